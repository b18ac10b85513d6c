//! Values as the types `DBR_*` (db_access.h of EPICS base): big-endian, each with the padding of its C structure.

use crate::record::{Answer, DECIMALS, Data, MAX_TEXT, Meta, Sample, cut, exponential};
use profivac_recorder::Micros;

/// The types of values, without meta data.
pub mod plain {
    /// A text of 40 octets.
    pub const STRING: u16 = 0;
    /// A whole number of 16 bits.
    pub const SHORT: u16 = 1;
    /// A floating-point number of 32 bits.
    pub const FLOAT: u16 = 2;
    /// The position of a word.
    pub const ENUM: u16 = 3;
    /// A whole number of 8 bits.
    pub const CHAR: u16 = 4;
    /// A whole number of 32 bits.
    pub const LONG: u16 = 5;
    /// A floating-point number of 64 bits.
    pub const DOUBLE: u16 = 6;
}

/// `DBR_STSACK_STRING`: alarm, acknowledgement and text.
const STSACK_STRING: u16 = 37;

/// `DBR_CLASS_NAME`: the type of the record.
pub const CLASS_NAME: u16 = 38;

/// The types with meta data, each beginning seven above the one before.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Family {
    Plain,
    Status,
    Time,
    Graphic,
    Control,
}

/// Seconds from 1970 to 1990, where the time of EPICS begins.
const EPICS_EPOCH_S: i64 = 631_152_000;

/// Octets of a unit, of a word, and words of an enumeration.
const UNIT: usize = 8;
const WORD: usize = 26;
const WORDS: usize = 16;

/// The octets of a long text (`NAME$`), with its end mark. chosen: longer than every sentence of the station.
pub const MAX_LONG_TEXT: usize = 1024;

/// The reason why there is no encoding.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum NoEncoding {
    /// The type does not exist.
    Type,
    /// The value cannot be converted: a text is no number.
    Conversion,
}

/// The type of a value where the client asks for none other.
#[must_use]
pub const fn native(data: &Data, is_large: bool) -> u16 {
    match data {
        Data::Double(_) => plain::DOUBLE,
        // A number of 64 bits is a floating-point number in Channel Access.
        Data::Long(_) if is_large => plain::DOUBLE,
        Data::Long(_) => plain::LONG,
        Data::Enum(_) => plain::ENUM,
        Data::Text(_) => plain::STRING,
    }
}

/// One value as a type `DBR_*`.
///
/// # Errors
/// [`NoEncoding`].
pub fn encode(kind: u16, answer: &Answer) -> Result<Vec<u8>, NoEncoding> {
    encode_with(kind, answer, |out, plain| value(out, plain, &answer.sample.data, &answer.meta))
}

/// A long text as an array of one of the types `DBR_*_CHAR`: `count` octets, the last one 0. With a count of 0 as many as the text has.
/// Returns the octets and the number of elements.
///
/// # Errors
/// [`NoEncoding`].
pub fn encode_long_text(kind: u16, answer: &Answer, count: u32) -> Result<(Vec<u8>, u32), NoEncoding> {
    if kind % 7 != plain::CHAR {
        return encode(kind, answer).map(|octets| (octets, 1));
    }
    let content = as_text(&answer.sample.data, &answer.meta);
    let content = cut(&content, MAX_LONG_TEXT.saturating_sub(1));
    let size = match usize::try_from(count).unwrap_or(usize::MAX) {
        0 => content.len().saturating_add(1),
        given => given.min(MAX_LONG_TEXT),
    };
    let octets = encode_with(kind, answer, |out, _| {
        field(out, content, size);
        Ok(())
    })?;
    Ok((octets, u32::try_from(size).unwrap_or(u32::MAX)))
}

fn encode_with(
    kind: u16,
    answer: &Answer,
    value: impl FnOnce(&mut Vec<u8>, u16) -> Result<(), NoEncoding>,
) -> Result<Vec<u8>, NoEncoding> {
    let (sample, meta) = (&answer.sample, &*answer.meta);
    let mut out = Vec::with_capacity(64);
    let family = match kind {
        0..=6 => Family::Plain,
        7..=13 => Family::Status,
        14..=20 => Family::Time,
        21..=27 => Family::Graphic,
        28..=34 => Family::Control,
        STSACK_STRING => {
            alarm(&mut out, sample);
            // No acknowledgement over Channel Access: neither required nor pending.
            out.extend([0; 4]);
            text(&mut out, &as_text(&sample.data, meta));
            return Ok(out);
        }
        _ => return Err(NoEncoding::Type),
    };
    let plain = kind % 7;
    if family != Family::Plain {
        alarm(&mut out, sample);
    }
    match family {
        Family::Plain | Family::Status => {}
        Family::Time => time(&mut out, sample.at),
        Family::Graphic | Family::Control => metadata(&mut out, plain, meta, family == Family::Control),
    }
    out.resize(out.len().saturating_add(padding(family, plain)), 0);
    value(&mut out, plain)?;
    Ok(out)
}

/// The octets between the meta data and the value, so that the value is aligned.
const fn padding(family: Family, plain: u16) -> usize {
    match (family, plain) {
        (Family::Plain, _) => 0,
        (Family::Status, plain::CHAR) => 1,
        (Family::Status, plain::DOUBLE) => 4,
        (Family::Time, plain::SHORT | plain::ENUM) => 2,
        (Family::Time, plain::CHAR) => 3,
        (Family::Time, plain::DOUBLE) => 4,
        (Family::Graphic | Family::Control, plain::CHAR) => 1,
        _ => 0,
    }
}

fn alarm(out: &mut Vec<u8>, sample: &Sample) {
    out.extend((sample.status as u16).to_be_bytes());
    out.extend((sample.severity as u16).to_be_bytes());
}

fn time(out: &mut Vec<u8>, Micros(micros): Micros) {
    let seconds = micros.div_euclid(Micros::SECOND).saturating_sub(EPICS_EPOCH_S);
    let nanoseconds = micros.rem_euclid(Micros::SECOND).saturating_mul(1000);
    out.extend(u32::try_from(seconds.max(0)).unwrap_or(u32::MAX).to_be_bytes());
    out.extend(u32::try_from(nanoseconds).unwrap_or_default().to_be_bytes());
}

fn metadata(out: &mut Vec<u8>, plain: u16, meta: &Meta, is_control: bool) {
    match plain {
        plain::STRING => {}
        plain::ENUM => words(out, meta),
        _ => {
            if matches!(plain, plain::FLOAT | plain::DOUBLE) {
                out.extend(meta.precision.to_be_bytes());
                out.extend([0; 2]);
            }
            field(out, &meta.unit, UNIT);
            let (low, high) = meta.display;
            let limits = meta.limits;
            let numbers = [high, low, limits.high_high, limits.high, limits.low, limits.low_low];
            numbers.into_iter().for_each(|limit| number(out, plain, limit));
            if is_control {
                number(out, plain, high);
                number(out, plain, low);
            }
        }
    }
}

fn words(out: &mut Vec<u8>, meta: &Meta) {
    let count = meta.states.len().min(WORDS);
    out.extend(u16::try_from(count).unwrap_or_default().to_be_bytes());
    for index in 0..WORDS {
        field(out, meta.states.get(index).copied().unwrap_or_default(), WORD);
    }
}

/// A text in a field of `size` octets with an end mark.
fn field(out: &mut Vec<u8>, content: &str, size: usize) {
    let content = cut(content, size.saturating_sub(1)).as_bytes();
    out.extend(content);
    out.resize(out.len().saturating_add(size.saturating_sub(content.len())), 0);
}

fn text(out: &mut Vec<u8>, content: &str) {
    field(out, content, MAX_TEXT.saturating_add(1));
}

/// A number in one of the types of numbers. A number that is none, or too large, becomes the nearest that exists.
#[expect(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "a cast from a floating-point number saturates"
)]
fn number(out: &mut Vec<u8>, plain: u16, number: f64) {
    match plain {
        plain::SHORT => out.extend((number as i16).to_be_bytes()),
        plain::FLOAT => out.extend((number as f32).to_be_bytes()),
        plain::ENUM => out.extend((number as u16).to_be_bytes()),
        plain::CHAR => out.push(number as u8),
        plain::LONG => out.extend((number as i32).to_be_bytes()),
        _ => out.extend(number.to_be_bytes()),
    }
}

#[expect(clippy::cast_precision_loss, reason = "a counter beyond 53 bits is not exact in Channel Access")]
fn value(out: &mut Vec<u8>, plain: u16, data: &Data, meta: &Meta) -> Result<(), NoEncoding> {
    if plain == plain::STRING {
        text(out, &as_text(data, meta));
        return Ok(());
    }
    let of_text = |text: &str| text.trim().parse().map_err(|_| NoEncoding::Conversion);
    number(
        out,
        plain,
        match data {
            Data::Double(number) => *number,
            Data::Long(number) => *number as f64,
            Data::Enum(number) => f64::from(*number),
            Data::Text(text) => of_text(text)?,
        },
    );
    Ok(())
}

/// A value as a text. A pressure is in exponential form, so that a small one is not 0.
fn as_text(data: &Data, meta: &Meta) -> String {
    let decimals = usize::try_from(meta.precision).unwrap_or_default();
    match data {
        Data::Double(number) if !meta.is_exponential && number.is_finite() => format!("{number:.decimals$}"),
        Data::Double(number) => exponential(*number, DECIMALS.into()),
        Data::Long(number) => number.to_string(),
        Data::Enum(number) => {
            let word = meta.states.get(usize::from(*number));
            word.map_or_else(|| number.to_string(), |word| (*word).to_owned())
        }
        Data::Text(text) => text.to_string(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::record::AlarmLimits;
    use profivac_gateway::{EpicsSeverity, EpicsStatus};
    use std::borrow::Cow;

    const META: Meta = Meta {
        description: String::new(),
        unit: String::new(),
        precision: 2,
        is_exponential: false,
        display: (1.0, 3.0),
        limits: AlarmLimits { high_high: 2.5, ..AlarmLimits::NONE },
        states: &["No", "Yes"],
    };

    fn answer(data: Data) -> Answer<'static> {
        let at = Micros(EPICS_EPOCH_S * Micros::SECOND + 2_000_003);
        let meta = Meta { unit: "mbar".to_owned(), ..META };
        Answer {
            sample: Sample { data, severity: EpicsSeverity::Minor, status: EpicsStatus::HwLimit, message: "", at },
            meta: Cow::Owned(meta),
        }
    }

    /// The sizes of the C structures, `dbr_size` of EPICS base.
    #[test]
    fn every_type_has_the_size_of_its_structure() {
        let sizes = [
            40, 2, 4, 2, 1, 4, 8, 44, 6, 8, 6, 6, 8, 16, 52, 16, 16, 16, 16, 16, 24, 44, 26, 44, 424, 20, 40, 72, 44,
            30, 52, 424, 22, 48, 88,
        ];
        for (kind, size) in (0..).zip(sizes) {
            assert_eq!(encode(kind, &answer(Data::Double(1.0))).unwrap().len(), size, "type {kind}");
        }
        assert_eq!(encode(STSACK_STRING, &answer(Data::Double(1.0))).unwrap().len(), 48);
        assert_eq!(encode(39, &answer(Data::Double(1.0))), Err(NoEncoding::Type));
    }

    #[test]
    fn a_number_has_alarm_time_unit_and_limits_at_their_places() {
        let octets = encode(20, &answer(Data::Double(1.5))).unwrap();
        assert_eq!(octets[..4], [0, 11, 0, 1]);
        assert_eq!(octets[4..12], [0, 0, 0, 2, 0, 0, 0x0B, 0xB8]);
        assert_eq!(octets[16..], 1.5_f64.to_be_bytes());
        let octets = encode(34, &answer(Data::Double(1.5))).unwrap();
        assert_eq!((&octets[4..6], &octets[8..13]), (&[0, 2][..], &b"mbar\0"[..]));
        let numbers: Vec<_> =
            octets[16..].chunks(8).map(|chunk| f64::from_be_bytes(chunk.try_into().unwrap())).collect();
        assert_eq!((&numbers[..3], &numbers[6..]), (&[3.0, 1.0, 2.5][..], &[3.0, 1.0, 1.5][..]));
        assert!(numbers[3..6].iter().all(|limit| limit.is_nan()));
    }

    #[test]
    fn a_long_text_is_an_array_of_octets_with_an_end_mark() {
        let long = "x".repeat(50);
        let (octets, count) = encode_long_text(4, &answer(Data::Text(long.as_str().into())), 0).unwrap();
        assert_eq!((octets, count), ([long.as_bytes(), &[0]].concat(), 51));
        let (octets, count) = encode_long_text(18, &answer(Data::Text(long.as_str().into())), 60).unwrap();
        assert_eq!((octets.len(), count, &octets[12..15]), (15 + 60, 60, &[0, 0, 0][..]), "alarm, time and padding");
        assert_eq!((&octets[15..65], octets[65]), (long.as_bytes(), 0));
        let (octets, count) = encode_long_text(4, &answer(Data::Text("abc".into())), 2).unwrap();
        assert_eq!((octets, count), (vec![b'a', 0], 2));
        assert_eq!(encode_long_text(4, &answer(Data::Text("é".repeat(4000).into())), u32::MAX).unwrap().1, 1024);
        assert_eq!(encode_long_text(0, &answer(Data::Text("abc".into())), 0).unwrap().1, 1, "as a text it is one");
    }

    #[test]
    fn a_value_becomes_what_the_client_asks_for() {
        let text =
            |data| String::from_utf8(encode(0, &answer(data)).unwrap()).unwrap().trim_end_matches('\0').to_owned();
        assert_eq!(text(Data::Double(5.2)), "5.20");
        let Answer { sample, meta } = answer(Data::Double(5.2e-6));
        let meta = Meta { is_exponential: true, precision: 11, ..meta.into_owned() };
        let pressure = encode(0, &Answer { sample, meta: Cow::Owned(meta) }).unwrap();
        assert!(pressure.starts_with(b"5.20e-06\0"), "{pressure:?}");
        assert_eq!(text(Data::Enum(1)), "Yes");
        assert_eq!(text(Data::Text("x".repeat(50).into())), "x".repeat(39));
        assert_eq!(encode(5, &answer(Data::Text("abc".into()))), Err(NoEncoding::Conversion));
        assert_eq!(encode(5, &answer(Data::Double(1e12))).unwrap(), i32::MAX.to_be_bytes());
        assert_eq!(encode(1, &answer(Data::Double(f64::NAN))).unwrap(), [0, 0]);
    }
}
