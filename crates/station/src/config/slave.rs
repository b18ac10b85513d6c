//! A slave by its GSD file, and the points in its inputs.

use crate::view::UNCERTAIN;
use profivac_gsd_slave::GsdSlave;
use profivac_recorder::{CodeText, DescribedPoint, Point, PointKind, Quality};
use std::collections::BTreeSet;
use std::ops::RangeInclusive;
use std::sync::{Arc, Mutex, PoisonError};
use std::time::Duration;

/// A slave that the station knows by its GSD file: a pump controller, a valve, a flow controller.
#[derive(Clone, Debug)]
pub struct Slave {
    /// Its name, unique in the station.
    pub name: String,
    /// Its bus address.
    pub address: u8,
    /// Its GSD file with modules and parameters.
    pub gsd: Arc<GsdSlave>,
    /// The station takes the slave into data exchange.
    pub is_owned: bool,
    /// The outputs that a slave of the station gets; empty without outputs and for a slave that the station does not own.
    pub outputs: Vec<u8>,
    /// The sampling interval.
    pub poll: Duration,
    /// The points, in the order of the file.
    pub points: Vec<SlavePoint>,
}

/// Equal slaves are parameterised, configured and shown in the same way.
impl PartialEq for Slave {
    fn eq(&self, other: &Self) -> bool {
        let Self { name, address, gsd, is_owned, outputs, poll, points } = self;
        let octets = |gsd: &GsdSlave| (gsd.chk_cfg().to_vec(), gsd.user_prm().to_vec());
        (name, address, is_owned, outputs, poll, points)
            == (&other.name, &other.address, &other.is_owned, &other.outputs, &other.poll, &other.points)
            && octets(gsd) == octets(&other.gsd)
            && gsd.file().text() == other.gsd.file().text()
    }
}

impl Slave {
    /// Vendor and model of the GSD file.
    #[must_use]
    pub fn model(&self) -> String {
        let general = &self.gsd.device().general;
        let words = [&general.vendor_name, &general.model_name].map(|it| it.as_deref().unwrap_or_default().trim());
        words.join(" ").trim().to_owned()
    }

    /// The vendor of the GSD file.
    #[must_use]
    pub fn vendor(&self) -> Option<&str> {
        let vendor = self.gsd.device().general.vendor_name.as_deref().map(str::trim);
        vendor.filter(|vendor| !vendor.is_empty())
    }

    /// The length of its inputs in octets.
    #[must_use]
    pub fn inputs(&self) -> usize {
        self.gsd.lengths().inputs.into()
    }
}

/// The status octet of a good value, PROFIBUS PA profile 3.02.
const GOOD: u8 = 0x80;

/// The type of a point.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PointType {
    /// One bit.
    Bool,
    /// An unsigned number of one octet.
    U8,
    /// A signed number of one octet.
    I8,
    /// An unsigned number of two octets.
    U16,
    /// A signed number of two octets.
    I16,
    /// An unsigned number of four octets.
    U32,
    /// A signed number of four octets.
    I32,
    /// A floating-point number of four octets (IEEE 754).
    F32,
    /// A floating-point number of four octets, and a status octet behind it (PROFIBUS PA, DS-33).
    Pa,
}

impl PointType {
    /// All types by their words in the station's file.
    pub const ALL: [(&'static str, Self); 9] = [
        ("bool", Self::Bool),
        ("u8", Self::U8),
        ("i8", Self::I8),
        ("u16", Self::U16),
        ("i16", Self::I16),
        ("u32", Self::U32),
        ("i32", Self::I32),
        ("f32", Self::F32),
        ("pa", Self::Pa),
    ];

    /// The number of octets of the inputs that a point of this type takes.
    #[must_use]
    pub const fn octets(self) -> usize {
        match self {
            Self::Bool | Self::U8 | Self::I8 => 1,
            Self::U16 | Self::I16 => 2,
            Self::U32 | Self::I32 | Self::F32 => 4,
            Self::Pa => 5,
        }
    }

    /// The codes that a number of this type may be; `None` for a float, which is no code.
    #[must_use]
    pub fn codes(self) -> Option<RangeInclusive<i64>> {
        Some(match self {
            Self::Bool => 0..=1,
            Self::U8 => 0..=u8::MAX.into(),
            Self::I8 => i8::MIN.into()..=i8::MAX.into(),
            Self::U16 => 0..=u16::MAX.into(),
            Self::I16 => i16::MIN.into()..=i16::MAX.into(),
            Self::U32 => 0..=u32::MAX.into(),
            Self::I32 => i32::MIN.into()..=i32::MAX.into(),
            Self::F32 | Self::Pa => return None,
        })
    }

    /// The octets of a number, the most significant one first, without a status octet; a bit is the lowest one. `None` if the type does not
    /// have the number: a whole number may differ by the rounding of `scale`.
    fn octets_of(self, raw: f64) -> Option<Vec<u8>> {
        let Some(codes) = self.codes() else {
            #[expect(clippy::cast_possible_truncation, reason = "the type has 32 bits")]
            let number = raw as f32;
            return number.is_finite().then(|| number.to_be_bytes().to_vec());
        };
        let whole = raw.round();
        let is_whole = (raw - whole).abs() <= 1e-6 * whole.abs().max(1.0);
        #[expect(clippy::cast_possible_truncation, reason = "a number beyond the type is beyond its codes too")]
        let code = Some(whole as i64).filter(|code| is_whole && codes.contains(code))?;
        let octets = code.to_be_bytes();
        octets.get(octets.len().saturating_sub(self.octets())..).map(<[u8]>::to_vec)
    }

    /// The number in these octets, the most significant octet first. A bit is bit `bit` of the first octet.
    fn number(self, octets: &[u8], bit: u8) -> Option<f64> {
        let first = *octets.first()?;
        Some(match self {
            Self::Bool => f64::from(first.checked_shr(bit.into())? & 1),
            Self::U8 => first.into(),
            Self::I8 => i8::from_be_bytes([first]).into(),
            Self::U16 => u16::from_be_bytes(octets.try_into().ok()?).into(),
            Self::I16 => i16::from_be_bytes(octets.try_into().ok()?).into(),
            Self::U32 => u32::from_be_bytes(octets.try_into().ok()?).into(),
            Self::I32 => i32::from_be_bytes(octets.try_into().ok()?).into(),
            // Its shortest decimal number: 0.1 as a float of 32 bits is 0.10000000149 as one of 64.
            Self::F32 | Self::Pa => f32::from_be_bytes(octets.try_into().ok()?).to_string().parse().ok()?,
        })
    }
}

/// A DP-V1 record that the station reads over MS2, without ownership.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct WatchedRecord {
    /// The slot.
    pub slot: u8,
    /// The index.
    pub index: u8,
    /// The time between two readings.
    pub every: Duration,
}

/// A point: a number, a code or a bit in the inputs or in a record of a slave.
#[derive(Clone, Debug, PartialEq)]
pub struct SlavePoint {
    /// Its name, unique for its slave.
    pub name: String,
    /// Where it is, for people: `slot 3 4DI octet 0 bit 2`.
    pub place: String,
    /// The record that has it; `None` for the inputs.
    pub record: Option<WatchedRecord>,
    /// Its type.
    pub kind: PointType,
    /// Its first octet in the inputs of the slave, or in the record.
    pub octet: usize,
    /// The number of its bit, 0 for the lowest; 0 for other types.
    pub bit: u8,
    /// The least significant octet comes first.
    pub is_little_endian: bool,
    /// The value is the number times `scale` plus `offset`.
    pub scale: f64,
    /// See `scale`.
    pub offset: f64,
    /// The unit of the value.
    pub unit: Option<&'static str>,
    /// Texts for codes, which are numbers before `scale` and `offset`.
    pub texts: Vec<(i64, String)>,
    /// The status octet of PROFIBUS PA in the inputs of the slave, or in the record.
    pub status: Option<usize>,
    /// The recorder keeps a number that differs by more than this from the one that it kept last, in the unit of the point.
    pub deadband: f64,
}

/// The value of a point.
#[derive(Clone, Debug, PartialEq)]
pub struct PointValue {
    /// The number in the unit of the point; of a code or a bit the number itself. `None` if the status octet or the number is bad.
    pub number: Option<f64>,
    /// The value in words, with the unit.
    pub text: String,
    /// `Valid` or `Fault`; a number that the status octet calls uncertain is valid, and its text says so.
    pub quality: Quality,
}

impl SlavePoint {
    /// The value in the inputs of the slave, or in the record. Inputs that end before the point are a fault.
    #[must_use]
    pub fn value(&self, inputs: &[u8]) -> PointValue {
        let fault = |text: &str| PointValue { number: None, text: text.to_owned(), quality: Quality::Fault };
        let length = if self.kind == PointType::Pa { 4 } else { self.kind.octets() };
        let end = self.octet.saturating_add(length);
        let Some(octets) = inputs.get(self.octet..end) else {
            return fault(if self.record.is_some() { "not in the record" } else { "not in the inputs" });
        };
        let mut octets = octets.to_vec();
        if self.is_little_endian {
            octets.reverse();
        }
        let raw = self.kind.number(&octets, self.bit);
        let numbers = raw.and_then(|raw| Some((raw, self.scaled(raw)?)));
        let status = self.status.map(|at| inputs.get(at).copied().unwrap_or_default());
        // The two highest bits are the quality: bad, uncertain, good, good in a cascade (PROFIBUS PA profile 3.02, status octet).
        let (is_bad, remark) = match status.map(|status| status >> 6) {
            Some(0) => (true, ""),
            Some(1) => (false, UNCERTAIN),
            _ => (false, ""),
        };
        match numbers {
            _ if is_bad => fault(&format!("bad, status {:02X}h", status.unwrap_or_default())),
            None => fault("not a number"),
            Some((raw, number)) => {
                let text = self.text(raw, number) + remark;
                PointValue { number: Some(number), text, quality: Quality::Valid }
            }
        }
    }

    /// The octets of the image that it takes, each with its bits.
    #[must_use]
    pub fn bits(&self) -> Vec<(usize, u8)> {
        let mask = if self.kind == PointType::Bool { 1_u8.checked_shl(self.bit.into()).unwrap_or(0) } else { u8::MAX };
        (self.octet..self.octet.saturating_add(self.kind.octets())).map(|octet| (octet, mask)).collect()
    }

    /// The number before `scale` and `offset` that belongs to a value.
    #[must_use]
    pub fn raw(&self, value: f64) -> f64 {
        (value - self.offset) / self.scale
    }

    /// Puts a number before `scale` and `offset` into outputs; a number of type `pa` has the status 80 hex behind it, good. Returns whether
    /// the type has the number; nothing changes otherwise.
    pub fn put_raw(&self, raw: f64, outputs: &mut [u8]) -> bool {
        let Some(mut octets) = self.kind.octets_of(raw) else { return false };
        if self.is_little_endian {
            octets.reverse();
        }
        if self.kind == PointType::Pa {
            octets.push(GOOD);
        }
        for ((octet, mask), new) in self.bits().into_iter().zip(octets) {
            let new = if self.kind == PointType::Bool { new.checked_shl(self.bit.into()).unwrap_or(0) } else { new };
            if let Some(octet) = outputs.get_mut(octet) {
                *octet = (*octet & !mask) | (new & mask);
            }
        }
        true
    }

    /// Whether its values are words and no quantity.
    #[must_use]
    pub const fn has_texts(&self) -> bool {
        matches!(self.kind, PointType::Bool) || !self.texts.is_empty()
    }

    /// The point of `slave` as the recorder knows it.
    #[must_use]
    pub fn recorded(&self, slave: &str) -> Point {
        Point {
            slave: slave.to_owned(),
            name: self.name.clone(),
            unit: self.unit.map(str::to_owned),
            kind: if self.has_texts() { PointKind::Code } else { PointKind::Number },
        }
    }

    /// The same with the text of each number that its codes give.
    #[must_use]
    pub fn described(&self, slave: &str) -> DescribedPoint {
        let given =
            self.texts.iter().filter(|_| self.kind.codes().is_some()).map(|(code, text)| (*code, text.as_str()));
        let bits = [(0, "off"), (1, "on")].into_iter().filter(|_| self.kind == PointType::Bool);
        let usual = bits.filter(|(bit, _)| self.texts.iter().all(|(code, _)| code != bit));
        #[expect(clippy::cast_precision_loss, reason = "codes have 32 bits")]
        let code =
            |(code, text): (i64, &str)| Some(CodeText { number: self.scaled(code as f64)?, text: text.to_owned() });
        let mut texts: Vec<_> = given.chain(usual).filter_map(code).collect();
        texts.sort_by(|one, two| one.number.total_cmp(&two.number));
        DescribedPoint { point: self.recorded(slave), texts }
    }

    /// The number in the unit of the point; `None` if it is no number, or too large for one.
    fn scaled(&self, raw: f64) -> Option<f64> {
        Some(raw.mul_add(self.scale, self.offset)).filter(|number| number.is_finite()).map(rounded)
    }

    /// The text of a code, `on` or `off` of a bit, or the number with its unit.
    fn text(&self, raw: f64, number: f64) -> String {
        #[expect(clippy::cast_precision_loss, reason = "codes have 32 bits")]
        let code = self.texts.iter().find(|(code, _)| self.kind.codes().is_some() && *code as f64 == raw);
        match (code, self.kind, self.unit) {
            (Some((_, text)), ..) => text.clone(),
            (None, PointType::Bool, _) => if raw == 0.0 { "off" } else { "on" }.to_owned(),
            (None, _, Some(unit)) => format!("{} {unit}", shown(number)),
            (None, _, None) => shown(number),
        }
    }
}

/// The number with twelve significant digits: a whole number of 32 bits has ten, and `scale` adds digits that mean nothing.
fn rounded(number: f64) -> f64 {
    format!("{number:.11e}").parse().unwrap_or(number)
}

/// A number in words; a very large or small one with an exponent.
fn shown(number: f64) -> String {
    let is_usual = number == 0.0 || (1e-6..1e12).contains(&number.abs());
    if is_usual { number.to_string() } else { format!("{number:e}") }
}

/// The units that the files of this program have named so far.
static UNITS: Mutex<BTreeSet<&'static str>> = Mutex::new(BTreeSet::new());

/// The same unit, for the life of the program: every view and every gateway names it often, and a plant has few.
#[must_use]
pub fn unit(text: &str) -> &'static str {
    let mut units = UNITS.lock().unwrap_or_else(PoisonError::into_inner);
    if let Some(known) = units.get(text) {
        return known;
    }
    let unit: &'static str = Box::leak(text.into());
    units.insert(unit);
    unit
}

#[cfg(test)]
mod tests {
    use super::*;

    fn point(kind: PointType) -> SlavePoint {
        SlavePoint {
            name: "speed".to_owned(),
            place: "slot 1".to_owned(),
            record: None,
            kind,
            octet: 1,
            bit: 0,
            is_little_endian: false,
            scale: 1.0,
            offset: 0.0,
            unit: Some("Hz"),
            texts: Vec::new(),
            status: None,
            deadband: 0.0,
        }
    }

    fn valid(point: &SlavePoint, inputs: &[u8]) -> (f64, String) {
        let PointValue { number, text, quality } = point.value(inputs);
        assert_eq!(quality, Quality::Valid, "{text}");
        (number.unwrap(), text)
    }

    #[test]
    fn each_type_reads_its_octets_in_both_orders() {
        for (kind, octets, number) in [
            (PointType::U8, &[0xFE][..], 254.0),
            (PointType::I8, &[0xFE], -2.0),
            (PointType::U16, &[0xFF, 0xFE], 65_534.0),
            (PointType::I16, &[0xFF, 0xFE], -2.0),
            (PointType::U32, &[0xFF, 0xFF, 0xFF, 0xFE], 4_294_967_294.0),
            (PointType::I32, &[0xFF, 0xFF, 0xFF, 0xFE], -2.0),
            (PointType::F32, &[0x41, 0x20, 0, 0], 10.0),
        ] {
            let big = [&[0x55][..], octets, &[0x55]].concat();
            assert_eq!(valid(&point(kind), &big).0, number, "{kind:?}");
            let reversed: Vec<u8> = octets.iter().rev().copied().collect();
            let little = [&[0x55][..], &reversed, &[0x55]].concat();
            let point = SlavePoint { is_little_endian: true, ..point(kind) };
            assert_eq!(valid(&point, &little).0, number, "{kind:?}");
        }
    }

    #[test]
    fn a_bit_is_counted_from_the_lowest_and_has_texts() {
        let bit = SlavePoint { bit: 2, unit: None, ..point(PointType::Bool) };
        assert_eq!(valid(&bit, &[0, 0b100]), (1.0, "on".to_owned()));
        assert_eq!(valid(&bit, &[0, 0b1011]), (0.0, "off".to_owned()));
        let texts = vec![(0, "closed".to_owned()), (1, "open".to_owned())];
        let bit = SlavePoint { texts, ..bit };
        assert_eq!(valid(&bit, &[0, 0b100]), (1.0, "open".to_owned()));
        assert_eq!(valid(&bit, &[0, 0]), (0.0, "closed".to_owned()));
    }

    #[test]
    fn a_number_is_scaled_and_a_code_is_the_number_before() {
        let scaled = SlavePoint { scale: 0.1, offset: -40.0, ..point(PointType::U16) };
        assert_eq!(valid(&scaled, &[0, 0x01, 0xF5]), (10.1, "10.1 Hz".to_owned()));
        let code = SlavePoint { texts: vec![(501, "at speed".to_owned())], ..scaled };
        assert_eq!(valid(&code, &[0, 0x01, 0xF5]).1, "at speed");
    }

    #[test]
    fn each_text_has_the_number_that_is_recorded_for_its_code() {
        let texts = |point: &SlavePoint| {
            let described = point.described("turbo");
            described.texts.into_iter().map(|code| (code.number, code.text)).collect::<Vec<_>>()
        };
        let code = SlavePoint {
            scale: 0.1,
            offset: -40.0,
            texts: vec![(501, "at speed".to_owned()), (7, "off".to_owned())],
            ..point(PointType::U16)
        };
        assert_eq!(texts(&code), [(-39.3, "off".to_owned()), (10.1, "at speed".to_owned())]);
        for (number, text) in [(10.1, Some("at speed")), (10.0, None)] {
            assert_eq!(code.described("turbo").text_of(number), text);
        }
        assert_eq!(code.described("turbo").text_of(valid(&code, &[0, 0x01, 0xF5]).0), Some("at speed"));
        let bit = SlavePoint { unit: None, texts: vec![(1, "closed".to_owned())], ..point(PointType::Bool) };
        assert_eq!(texts(&bit), [(0.0, "off".to_owned()), (1.0, "closed".to_owned())]);
        assert_eq!(texts(&point(PointType::U16)), []);
    }

    #[test]
    fn a_whole_number_and_a_float_have_all_their_digits() {
        let counter = SlavePoint { unit: None, ..point(PointType::U32) };
        assert_eq!(valid(&counter, &[0, 0xFF, 0xFF, 0xFF, 0xFE]), (4_294_967_294.0, "4294967294".to_owned()));
        let energy = SlavePoint { scale: 0.1, unit: Some("kWh"), ..counter };
        assert_eq!(valid(&energy, &[0, 0xFF, 0xFF, 0xFF, 0xFE]), (429_496_729.4, "429496729.4 kWh".to_owned()));
        let float = |number: f32| {
            let octets = [&[0][..], &number.to_be_bytes()].concat();
            valid(&SlavePoint { unit: None, ..point(PointType::F32) }, &octets)
        };
        assert_eq!(float(0.1), (0.1, "0.1".to_owned()));
        assert_eq!(float(16_777_215.0), (16_777_215.0, "16777215".to_owned()));
        assert_eq!(float(f32::MAX), (3.402_823_5e38, "3.4028235e38".to_owned()));
    }

    #[test]
    fn a_number_beyond_all_numbers_is_a_fault() {
        let huge = SlavePoint { scale: 1e308, ..point(PointType::U16) };
        let PointValue { number, text, quality } = huge.value(&[0, 0xFF, 0xFF]);
        assert_eq!((number, text.as_str(), quality), (None, "not a number", Quality::Fault));
    }

    #[test]
    fn the_status_octet_decides_whether_a_number_is_good() {
        let pa = SlavePoint { status: Some(5), unit: Some("l/min"), ..point(PointType::Pa) };
        let inputs = |status: u8| [0, 0x3F, 0x80, 0, 0, status];
        for (status, text) in
            [(0x80, "1 l/min"), (0xC0, "1 l/min"), (0x40, "1 l/min (uncertain)"), (0x7F, "1 l/min (uncertain)")]
        {
            assert_eq!(valid(&pa, &inputs(status)), (1.0, text.to_owned()), "{status:02X}");
        }
        for status in [0x00, 0x3F] {
            let PointValue { number, text, quality } = pa.value(&inputs(status));
            assert_eq!((number, quality), (None, Quality::Fault), "{status:02X}");
            assert_eq!(text, format!("bad, status {status:02X}h"));
        }
    }

    #[test]
    fn inputs_that_are_too_short_and_numbers_that_are_none_are_faults() {
        let short = point(PointType::U16).value(&[0, 1]);
        assert_eq!((short.number, short.quality), (None, Quality::Fault));
        let nan = point(PointType::F32).value(&[0, 0x7F, 0xC0, 0, 0]);
        assert_eq!((nan.number, nan.quality, nan.text.as_str()), (None, Quality::Fault, "not a number"));
    }

    #[test]
    fn a_unit_is_kept_once() {
        assert!(std::ptr::eq(unit("l/min"), unit(&["l", "min"].join("/"))));
    }
}
