//! Parameters by name, and their values in words: `ba.process-value = 1.2e-3 mbar`.

use profivac_devices::model::{Block, DataType, Model, Row, Unit};
use profivac_sim::describe::Hex;

/// What a telegram says about a device, in the device's own terms.
#[derive(Clone, Copy, Debug, Default)]
pub struct Tables {
    /// The device, the first of those that share an ident number.
    pub model: Option<&'static Model>,
    /// The unit it shows, once a telegram has told it.
    pub unit: Option<&'static Unit>,
    /// The instance that the selector of a slot with several shows, once a telegram has told it.
    pub instance: Option<u8>,
}

/// Parameters that choose which instance a slot shows.
const SELECTORS: [&str; 2] = ["Channel Instance Selector", "Analog Input Sensor Function Block Instance"];

impl Tables {
    /// The name of a parameter with its numbers. Instances that share a slot are all named: `pirani/ba.safe-value`.
    #[must_use]
    pub fn name(&self, slot: u8, index: u8) -> String {
        let mut names: Vec<(String, String)> = Vec::new();
        for (block, row) in self.rows(slot, index) {
            let (block, row) = (slug(block), slug(row.name));
            match names.iter_mut().find(|(_, known)| *known == row) {
                Some((blocks, _)) if blocks.split('/').any(|known| known == block) => {}
                Some((blocks, _)) => *blocks = format!("{blocks}/{block}"),
                None => names.push((block, row)),
            }
        }
        let numbers = format!("slot {slot} index {index}");
        if names.is_empty() {
            return numbers;
        }
        let names: Vec<String> = names.into_iter().map(|(blocks, row)| format!("{blocks}.{row}")).collect();
        format!("{} ({numbers})", names.join(" or "))
    }

    /// The value of a parameter, as far as the octets and the unit tell.
    #[must_use]
    pub fn value(&self, slot: u8, index: u8, octets: &[u8]) -> String {
        let Some((_, row)) = self.rows(slot, index).next() else { return Hex(octets).to_string() };
        self.special(row, octets)
            .or_else(|| self.plain(row.data_type, octets))
            .unwrap_or_else(|| Hex(octets).to_string())
    }

    /// The rows at a place, each with the name of its block.
    fn rows(&self, slot: u8, index: u8) -> impl Iterator<Item = (&'static str, &'static Row)> + '_ {
        let places = self.model.into_iter().flat_map(|model| model.places);
        places.flat_map(move |place| {
            let row = place.block.row(index);
            let shown = move |instance| instance == 0 || self.instance.is_none_or(|selected| selected == instance);
            let here = place.addresses.iter().filter(move |address| address.slot == slot && shown(address.instance));
            here.filter_map(move |address| Some((address.name, row?)))
        })
    }

    /// A parameter was read or written: unit and selector change what others mean.
    pub fn learn(&mut self, slot: u8, index: u8, octets: &[u8]) {
        let Some((_, row)) = self.rows(slot, index).next() else { return };
        if row.name == DATA_UNITS {
            self.unit = self.unit_of(octets).or(self.unit);
        }
        if let (true, [instance]) = (SELECTORS.contains(&row.name), octets) {
            self.instance = Some(*instance);
        }
    }

    /// The unit with the code in these octets.
    fn unit_of(&self, octets: &[u8]) -> Option<&'static Unit> {
        self.model?.unit(u16::from_be_bytes(octets.try_into().ok()?))
    }

    /// What says more than its number.
    fn special(&self, row: &Row, octets: &[u8]) -> Option<String> {
        match row.name {
            DATA_UNITS => self.unit_of(octets).map(|unit| format!("{} ({})", unit.name, unit.code)),
            "Block Type" => {
                let [high, low, ..] = octets else { return None };
                self.block(u16::from_be_bytes([*high, *low])).map(|block| format!("{} ({})", block.name, Hex(octets)))
            }
            _ => None,
        }
    }

    fn block(&self, number: u16) -> Option<&'static Block> {
        let blocks = self.model?.places.iter().map(|place| place.block);
        blocks.into_iter().find(|block| block.block_type == Some(number))
    }

    fn plain(&self, data_type: DataType, octets: &[u8]) -> Option<String> {
        Some(match data_type {
            DataType::Boolean => match octets {
                [0] => "false".to_owned(),
                [1] => "true".to_owned(),
                _ => return None,
            },
            DataType::Uint8 | DataType::Uint16 | DataType::Uint32 => unsigned(octets)?.to_string(),
            DataType::Int8 | DataType::Int16 | DataType::Int32 => signed(octets)?.to_string(),
            DataType::Float => short(float(octets)?),
            DataType::ByType => self.pressure(octets)?,
            DataType::Visible(_) => format!("{:?}", std::str::from_utf8(octets).ok()?.trim_end()),
            DataType::OctetString(_) | DataType::Array(_) | DataType::Record(_) => return None,
        })
    }

    /// A pressure as a number in the unit of the device: two octets are an integer, four a float.
    #[must_use]
    pub fn pressure(&self, octets: &[u8]) -> Option<String> {
        let number = match octets {
            [high, low] => u16::from_be_bytes([*high, *low]).to_string(),
            _ => short(float(octets)?),
        };
        let unit = self.unit.map_or("in a unit that was not told", |unit| unit.name);
        Some(format!("{number} {unit}"))
    }
}

const DATA_UNITS: &str = "Data Units";

/// A number with four digits, as short as possible.
#[must_use]
pub fn short(number: f32) -> String {
    let size = number.abs();
    if number == 0.0 || (0.01..10_000.0).contains(&size) {
        let digits = if size < 1.0 {
            4
        } else if size < 100.0 {
            2
        } else {
            1
        };
        let text = format!("{number:.digits$}");
        return text.trim_end_matches('0').trim_end_matches('.').to_owned();
    }
    format!("{number:.3e}")
}

fn float(octets: &[u8]) -> Option<f32> {
    octets.try_into().ok().map(f32::from_be_bytes)
}

fn unsigned(octets: &[u8]) -> Option<u64> {
    let joined = octets.iter().fold(0u64, |number, octet| number << 8 | u64::from(*octet));
    (1..=4).contains(&octets.len()).then_some(joined)
}

fn signed(octets: &[u8]) -> Option<i32> {
    let number = match *octets {
        [a] => i8::from_be_bytes([a]).into(),
        [a, b] => i16::from_be_bytes([a, b]).into(),
        [a, b, c, d] => i32::from_be_bytes([a, b, c, d]),
        _ => return None,
    };
    Some(number)
}

/// `Process Value (PV)` as `process-value`.
#[must_use]
pub fn slug(name: &str) -> String {
    let name = name.split('(').next().unwrap_or_default().trim().to_ascii_lowercase();
    let letters = |letter: char| if letter.is_ascii_alphanumeric() { letter } else { '-' };
    let mut slug: String = name.chars().map(letters).collect();
    while slug.contains("--") {
        slug = slug.replace("--", "-");
    }
    slug.trim_matches('-').to_owned()
}

#[cfg(test)]
mod tests {
    use super::*;
    use profivac_devices::bcg450::table::MODEL;

    fn tables() -> Tables {
        Tables { model: Some(&MODEL), unit: MODEL.unit_named("mbar"), instance: None }
    }

    #[test]
    fn parameters_have_the_names_of_the_manual() {
        assert_eq!(tables().name(0, 17), "device.device-type (slot 0 index 17)");
        assert_eq!(
            tables().name(1, 201),
            "setpoint-a/setpoint-b.setpoint-function or ba.emission-user-mode-state (slot 1 index 201)"
        );
        // The selector says whose row it is.
        let mut selected = tables();
        selected.learn(1, 46, &[6]);
        assert_eq!(selected.name(1, 201), "setpoint-b.setpoint-function (slot 1 index 201)");
        assert_eq!(tables().name(7, 7), "slot 7 index 7");
        assert_eq!(Tables::default().name(1, 19), "slot 1 index 19");
        assert_eq!(slug("One Of N PV Selector (test)"), "one-of-n-pv-selector");
    }

    #[test]
    fn values_have_type_and_unit() {
        let (tables, float) = (tables(), 1.5e-3_f32.to_be_bytes());
        assert_eq!(tables.value(1, 22, &[0x05, 0x1C]), "mbar (1308)");
        assert_eq!(tables.pressure(&float), Some("1.500e-3 mbar".to_owned()));
        assert_eq!(
            Tables { unit: None, ..tables }.pressure(&[0x03, 0xE8]),
            Some("1000 in a unit that was not told".to_owned())
        );
        assert_eq!(tables.value(1, 23, &[1]), "true");
        assert_eq!(tables.value(0, 17, b"BCG450  "), "\"BCG450\"");
        assert_eq!(tables.value(1, 23, &[9]), "09", "no Boolean");
        assert_eq!(tables.value(7, 7, &[1, 2]), "01 02");
    }

    #[test]
    fn numbers_are_short() {
        for (number, text) in [(0.0, "0"), (1.5, "1.5"), (1013.25, "1013.2"), (0.012, "0.012"), (5e-9, "5.000e-9")] {
            assert_eq!(short(number), text);
        }
    }
}
