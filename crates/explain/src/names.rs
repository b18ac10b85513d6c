//! Names and values of parameters from the tables of a device: `ba.process-value = 1.2e-3 mbar`.

use profivac_client::names::{NamedParameter, ParameterNames};
use profivac_client::values::{Value, ValueFormat};
use profivac_devices::model::{Codes, DataType, Model, Role, Unit};
use profivac_sim::describe::Hex;
use std::cmp::Ordering;

/// The tables of a device, with the parameters that change the meaning of others.
#[derive(Clone, Copy, Debug, Default)]
pub struct DeviceTables {
    /// The device; the first one if several have the same Ident_Number.
    pub model: Option<&'static Model>,
    /// The unit of its pressures, if a telegram has shown it.
    pub unit: Option<&'static Unit>,
    /// The instance that the selector of a slot with several instances has selected, if a telegram has shown it.
    pub instance: Option<u8>,
}

impl DeviceTables {
    /// The name of a parameter as in [`ParameterNames`], with its numbers. The name lists all instances that share the slot:
    /// `pirani/ba.safe-value`.
    #[must_use]
    pub fn name(&self, slot: u8, index: u8) -> String {
        let mut names: Vec<(String, &str)> = Vec::new();
        for named in self.named(slot, index) {
            let at = named.name.rfind(['.', '/']).unwrap_or_default();
            let (location, row) = named.name.split_at(at);
            match names.iter_mut().find(|(_, known)| *known == row) {
                Some((locations, _)) => *locations = format!("{locations}/{location}"),
                None => names.push((location.to_owned(), row)),
            }
        }
        let numbers = format!("slot {slot} index {index}");
        if names.is_empty() {
            return numbers;
        }
        let names: Vec<String> = names.into_iter().map(|(locations, row)| locations + row).collect();
        format!("{} ({numbers})", names.join(" or "))
    }

    /// The value of a parameter as [`ValueFormat`] writes it, or its octets if the value is not known. A code keeps its number.
    #[must_use]
    pub fn value(&self, slot: u8, index: u8, octets: &[u8]) -> String {
        self.known_value(slot, index, octets).unwrap_or_else(|| Hex(octets).to_string())
    }

    /// The value of a parameter; `None` if its type is not known or the octets do not fit it.
    fn known_value(&self, slot: u8, index: u8, octets: &[u8]) -> Option<String> {
        let mut all = self.named(slot, index);
        let named = all.next()?;
        let row = named.parameter.row;
        // No telegram has shown the instance, and its instances differ in code or type.
        if all.any(|other| other.parameter.row.codes != row.codes || other.parameter.row.data_type != row.data_type) {
            return None;
        }
        match row.data_type {
            DataType::ByType => return self.pressure(octets),
            DataType::Visible(_) => return Some(format!("{:?}", std::str::from_utf8(octets).ok()?.trim_end())),
            _ if row.role == Some(Role::BlockType) => return self.block(octets),
            DataType::Boolean if !matches!(octets, [0 | 1]) => return None,
            _ => {}
        }
        let format = ValueFormat { named, model: self.model?, unit: self.unit };
        let value = Value::of_row(row, octets).ok()?;
        let text = format.text(octets, &value);
        Some(match value {
            Value::Integer(number) if row.codes != Codes::Plain && text != number.to_string() => {
                format!("{text} ({number})")
            }
            _ => text,
        })
    }

    /// The parameters with this slot and index, of the selected instance only if that is known.
    fn named(&self, slot: u8, index: u8) -> impl Iterator<Item = &'static NamedParameter> + '_ {
        let names = self.model.map(ParameterNames::shared);
        let parameters = names.into_iter().flat_map(move |names| names.at_index(slot, index));
        parameters.filter(|named| {
            let instance = named.parameter.location.instance;
            instance == 0 || self.instance.is_none_or(|selected| selected == instance)
        })
    }

    /// Records a value that was read or written: the unit and the selector change the meaning of other parameters.
    pub fn learn(&mut self, slot: u8, index: u8, octets: &[u8]) {
        let Some(row) = self.named(slot, index).next().map(|named| named.parameter.row) else { return };
        if row.role == Some(Role::Unit) {
            self.unit = self.unit_of(octets).or(self.unit);
        }
        if let (Some(Role::InstanceSelector), [instance]) = (row.role, octets) {
            self.instance = Some(*instance);
        }
    }

    /// The unit with this code of one or two octets.
    fn unit_of(&self, octets: &[u8]) -> Option<&'static Unit> {
        let code = match octets {
            [code] => u16::from(*code),
            _ => u16::from_be_bytes(octets.try_into().ok()?),
        };
        self.model?.unit(code)
    }

    /// The name of a block by its number.
    fn block(&self, octets: &[u8]) -> Option<String> {
        let [high, low, ..] = octets else { return None };
        let number = u16::from_be_bytes([*high, *low]);
        let mut blocks = self.model?.blocks.iter().map(|placed| placed.block);
        let block = blocks.find(|block| block.block_type == Some(number))?;
        Some(format!("{} ({})", block.name, Hex(octets)))
    }

    /// A pressure in the unit of the device: two octets are an integer, four octets a float. The highest integer stands for every higher
    /// pressure (errata-bpg-bcg-tpg 70, errata-pxg55x-img400 16), and above it an integer is no pressure.
    #[must_use]
    pub fn pressure(&self, octets: &[u8]) -> Option<String> {
        let unit = self.unit.map_or("(unit unknown)", |unit| unit.name);
        let [high, low] = *octets else { return Some(format!("{} {unit}", short(float(octets)?))) };
        let word = u16::from_be_bytes([high, low]);
        Some(match self.model.map(|model| word.cmp(&model.max_integer)) {
            Some(Ordering::Greater) => format!("{word}, no pressure"),
            Some(Ordering::Equal) => format!("{word} {unit} or more"),
            Some(Ordering::Less) | None => format!("{word} {unit}"),
        })
    }
}

/// A number with at most four decimals and no trailing zeros; with an exponent below 0.01 and from 10000.
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

#[cfg(test)]
mod tests {
    use super::*;
    use profivac_client::names::Parameter;
    use profivac_devices::bcg450::table::MODEL;
    use profivac_devices::catalog::{MODELS, model_named};

    fn tables() -> DeviceTables {
        DeviceTables { model: Some(&MODEL), unit: MODEL.unit_named("mbar"), instance: None }
    }

    #[test]
    fn a_parameter_has_the_name_of_the_manual() {
        assert_eq!(tables().name(0, 17), "device.device-type (slot 0 index 17)");
        assert_eq!(
            tables().name(1, 201),
            "ba.emission-user-mode-state or setpoint-a/setpoint-b.setpoint-function (slot 1 index 201)"
        );
        // The selector shows to which instance the row belongs.
        let mut selected = tables();
        selected.learn(1, 46, &[6]);
        assert_eq!(selected.name(1, 201), "setpoint-b.setpoint-function (slot 1 index 201)");
        assert_eq!(tables().name(7, 7), "slot 7 index 7");
        assert_eq!(DeviceTables::default().name(1, 19), "slot 1 index 19");
    }

    /// Each manual has its own word for the unit parameter: `Data Units`, `Data Unit`, `Pressure unit`.
    #[test]
    fn the_unit_parameter_of_every_model_sets_the_unit() {
        for model in MODELS {
            let names = ParameterNames::of(model);
            let rows = names.all().iter().map(|named| named.parameter);
            for Parameter { location, row, .. } in rows.filter(|parameter| parameter.row.codes == Codes::Units) {
                let unit = &model.units[0];
                let octets = match row.data_type {
                    DataType::Uint8 => unit.code.to_be_bytes()[1..].to_vec(),
                    _ => unit.code.to_be_bytes().to_vec(),
                };
                let mut tables = DeviceTables { model: Some(model), unit: None, instance: Some(location.instance) };
                tables.learn(location.slot, row.index, &octets);
                assert_eq!(tables.unit, Some(unit), "{} {}", model.name, row.name);
            }
        }
    }

    /// The block type has several names in the manuals: `Block Type`, `Block Type ID`, `Block-Type`.
    #[test]
    fn the_block_type_of_every_model_has_the_name_of_its_block() {
        for model in MODELS {
            let mut numbers = model.blocks.iter().filter_map(|placed| placed.block.block_type);
            let Some(number) = numbers.next() else { continue };
            let octets = [number.to_be_bytes(), [0, 0]].concat();
            let names = ParameterNames::of(model);
            let rows = names.all().iter().map(|named| named.parameter);
            for Parameter { location, row, .. } in rows.filter(|found| found.row.role == Some(Role::BlockType)) {
                let tables = DeviceTables { model: Some(model), unit: None, instance: Some(location.instance) };
                let text = tables.value(location.slot, row.index, &octets);
                assert!(text.ends_with(&format!("({})", Hex(&octets))), "{} {}: {text}", model.name, row.name);
            }
        }
    }

    #[test]
    fn a_value_has_its_type_and_unit() {
        let (tables, float) = (tables(), 1.5e-3_f32.to_be_bytes());
        assert_eq!(tables.value(1, 22, &[0x05, 0x1C]), "mbar (1308)");
        assert_eq!(tables.pressure(&float), Some("1.500e-3 mbar".to_owned()));
        let pascal = DeviceTables { unit: MODEL.unit_named("Pascal"), ..tables };
        assert_eq!(pascal.pressure(&[0x7F, 0xFF]), Some("32767 Pascal or more".to_owned()));
        assert_eq!(pascal.pressure(&[0x7F, 0xFE]), Some("32766 Pascal".to_owned()));
        for word in [0x8000_u16, 0xA000, 0xFFFF] {
            assert_eq!(pascal.pressure(&word.to_be_bytes()), Some(format!("{word}, no pressure")));
        }
        let controller = DeviceTables { model: model_named("img400"), ..pascal };
        assert_eq!(controller.pressure(&[0x80, 0]), Some("32768 Pascal".to_owned()));
        assert_eq!(controller.pressure(&[0xFF, 0xFF]), Some("65535 Pascal or more".to_owned()));
        assert_eq!(DeviceTables { model: None, ..pascal }.pressure(&[0xFF, 0xFF]), Some("65535 Pascal".to_owned()));
        // A record has no status: 0 may be the Safe Value of a gauge in IDLE.
        assert_eq!(tables.value(1, 19, &[0, 0]), "0 mbar");
        assert_eq!(tables.value(1, 40, &[0, 0]), "0 mbar");
        assert_eq!(
            DeviceTables { unit: None, ..tables }.pressure(&[0x03, 0xE8]),
            Some("1000 (unit unknown)".to_owned())
        );
        assert_eq!(tables.value(1, 23, &[1]), "true");
        assert_eq!(tables.value(0, 17, b"BCG450  "), "\"BCG450\"");
        assert_eq!(tables.value(1, 23, &[9]), "09", "09 is not a Boolean");
        assert_eq!(tables.value(7, 7, &[1, 2]), "01 02");
    }

    /// Names and texts of codes have one implementation: `read` and `decode` print the same.
    #[test]
    fn names_and_codes_are_those_of_the_client() {
        let tables = tables();
        assert_eq!(tables.value(0, 25, &[4]), "EXECUTING (4)");
        assert_eq!(tables.value(1, 39, &[3]), "use-safe-value (3)");
        // Index 201 is the set point function of one instance and the emission user mode of another.
        assert_eq!(tables.value(1, 201, &[1]), "01");
        let second = DeviceTables { instance: Some(2), ..tables };
        assert_eq!(
            (second.value(1, 201, &[1]), second.value(1, 14, &[1, 1])),
            ("true".to_owned(), "degas-on".to_owned())
        );
        for model in MODELS {
            for named in ParameterNames::of(model).all() {
                let Parameter { location, row, .. } = named.parameter;
                let mut tables = DeviceTables { model: Some(model), ..DeviceTables::default() };
                tables.instance = Some(location.instance);
                let name = tables.name(location.slot, row.index);
                assert_eq!(name, format!("{} (slot {} index {})", named.name, location.slot, row.index));
            }
        }
    }

    #[test]
    fn a_number_has_few_decimals_and_no_trailing_zeros() {
        for (number, text) in [(0.0, "0"), (1.5, "1.5"), (1013.25, "1013.2"), (0.012, "0.012"), (5e-9, "5.000e-9")] {
            assert_eq!(short(number), text);
        }
    }
}
