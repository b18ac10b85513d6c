//! Orders to a virtual slave, as lines write them behind the address: `input 9 2 1F`, `diagnosis 9 bit 24 on`.

use super::alarms::{MANUFACTURER, TYPES};
use profivac_wire::ext_diag::SpecifierChange;
use std::ops::RangeInclusive;
use std::str::FromStr;

/// The first words of the orders, with the words behind the address.
pub const FORMS: [(&str, &str); 5] = [
    ("input", "ADDR SLOT [at OCTET] OCTET|TYPE:VALUE ..., or ADDR SLOT bit N on|off"),
    ("diagnosis", "ADDR bit N on|off, ADDR area FIRST-LAST VALUE|TEXT, or ADDR none"),
    ("channel-error", "ADDR SLOT CHANNEL ERROR|TEXT on|off"),
    (
        "alarm",
        "ADDR SLOT diagnostic|process|pull|plug|status|update|32...126 [appears|disappears|others-remain] [OCTET|TYPE:VALUE ...]",
    ),
    ("record", "ADDR SLOT INDEX [OCTET|TYPE:VALUE ...]"),
];

/// The highest bit of a device-related block that an order may name. The file may allow fewer.
const MAX_BIT: u16 = 495;

/// An order.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Order {
    /// Sets octets of the inputs of a slot, from octet `at` on.
    Input {
        /// The slot.
        slot: u32,
        /// The first octet, from 0.
        at: usize,
        /// The octets.
        octets: Vec<u8>,
    },
    /// Sets a bit of the inputs of a slot: bit 8 is the lowest one of the second octet.
    InputBit {
        /// The slot.
        slot: u32,
        /// The bit, from 0.
        bit: usize,
        /// Its value.
        on: bool,
    },
    /// Sets bits of the device-related diagnosis to a number, or to the number of a text.
    Diagnosis {
        /// The lowest bit. Bit 0 is the lowest one of the octet behind the header.
        first: u16,
        /// The highest bit.
        last: u16,
        /// A number, or the file's text.
        value: String,
    },
    /// Ends every diagnosis.
    NoDiagnosis,
    /// An error of a channel begins or ends.
    ChannelError {
        /// The slot.
        slot: u32,
        /// The channel, 0 to 63.
        channel: u8,
        /// The number of the error, or the file's text.
        error: String,
        /// It begins (`true`) or ends.
        present: bool,
    },
    /// Raises an alarm, which waits for the acknowledgement of the master.
    Alarm {
        /// The slot; 0 is the station.
        slot: u8,
        /// Alarm_Type, 1 to 6 or 32 to 126.
        alarm_type: u8,
        /// Whether its cause appears or disappears.
        change: SpecifierChange,
        /// Diagnosis_User_Data.
        octets: Vec<u8>,
    },
    /// Makes or changes a DP-V1 record.
    Record {
        /// The slot.
        slot: u8,
        /// The index, 0 to 254.
        index: u8,
        /// The new octets; none reads the record.
        octets: Option<Vec<u8>>,
    },
}

/// Why words are no order.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum OrderError {
    /// The words do not fit the order with this first word.
    #[error("expected {} {}", .0, FORMS.iter().find(|(word, _)| word == .0).map_or("", |(_, form)| form))]
    Form(&'static str),
    /// A word is no octet and no value.
    #[error(
        "expected a hexadecimal octet like 1F, an octet like 16#1F or 2#00011111, or a value like float:23.5, u16:500 or i32:-7, got {0:?}"
    )]
    Octet(String),
    /// A word is no number in its limits.
    #[error("expected for the {what} a number from {low} to {high}, got {found:?}")]
    Number {
        /// What the number is.
        what: &'static str,
        /// The lowest possible number.
        low: u32,
        /// The highest possible number.
        high: u32,
        /// The word.
        found: String,
    },
}

impl Order {
    /// Parses an order without its address. `None` if no order has this first word.
    ///
    /// ```
    /// use profivac_virtual::gsd_slave::Order;
    ///
    /// let order = Order::parse("input", &["2", "16#1F", "00"]);
    /// assert_eq!(order, Some(Ok(Order::Input { slot: 2, at: 0, octets: vec![0x1F, 0] })));
    /// assert_eq!(Order::parse("pressure", &["5e-6", "mbar"]), None);
    /// ```
    #[must_use]
    pub fn parse(word: &str, rest: &[&str]) -> Option<Result<Self, OrderError>> {
        let (word, _) = FORMS.into_iter().find(|(known, _)| *known == word)?;
        let parsed = match word {
            "input" => Self::input(rest),
            "diagnosis" => Self::diagnosis(rest),
            "channel-error" => Self::channel_error(rest),
            "alarm" => Self::alarm(rest),
            _ => Self::record(rest),
        };
        Some(parsed.and_then(|order| order.ok_or(OrderError::Form(word))))
    }

    fn input(rest: &[&str]) -> Result<Option<Self>, OrderError> {
        let [slot, rest @ ..] = rest else { return Ok(None) };
        let slot = slot_number(slot)?;
        Ok(match rest {
            ["bit", bit, value] => {
                let bit = number("bit", bit, 0..=1951)?;
                on(value).map(|on| Self::InputBit { slot, bit, on })
            }
            ["at", at, octets @ ..] if !octets.is_empty() => {
                Some(Self::Input { slot, at: number("octet", at, 0..=243)?, octets: read_octets(octets)? })
            }
            [] | ["at" | "bit", ..] => None,
            octets => Some(Self::Input { slot, at: 0, octets: read_octets(octets)? }),
        })
    }

    fn diagnosis(rest: &[&str]) -> Result<Option<Self>, OrderError> {
        let bit = |text| number("bit", text, 0..=MAX_BIT.into());
        Ok(match rest {
            ["none"] => Some(Self::NoDiagnosis),
            ["bit", number, value] => {
                let first = bit(number)?;
                on(value).map(|on| Self::Diagnosis { first, last: first, value: u8::from(on).to_string() })
            }
            ["area", bits, value @ ..] if !value.is_empty() => {
                let Some((first, last)) = bits.split_once('-') else { return Ok(None) };
                let (first, last) = (bit(first)?, bit(last)?);
                let is_area = first <= last && last.saturating_sub(first) < 64;
                is_area.then(|| Self::Diagnosis { first, last, value: value.join(" ") })
            }
            _ => None,
        })
    }

    fn channel_error(rest: &[&str]) -> Result<Option<Self>, OrderError> {
        let [slot, channel, error @ .., value] = rest else { return Ok(None) };
        let (slot, channel) = (slot_number(slot)?, number("channel", channel, 0..=63)?);
        let order = |present| Self::ChannelError { slot, channel, error: error.join(" "), present };
        Ok(on(value).filter(|_| !error.is_empty()).map(order))
    }

    fn alarm(rest: &[&str]) -> Result<Option<Self>, OrderError> {
        let [slot, kind, rest @ ..] = rest else { return Ok(None) };
        let slot = number("slot", slot, 0..=254)?;
        let named = TYPES.iter().find(|(word, _)| word == kind).map(|(_, alarm_type)| *alarm_type);
        let alarm_type = match named {
            Some(alarm_type) => alarm_type,
            None if kind.bytes().all(|digit| digit.is_ascii_digit()) => number("alarm type", kind, MANUFACTURER)?,
            None => return Ok(None),
        };
        let (change, octets) = match rest {
            ["appears", octets @ ..] => (SpecifierChange::Appears, octets),
            ["disappears", octets @ ..] => (SpecifierChange::Disappears, octets),
            ["others-remain", octets @ ..] => (SpecifierChange::DisappearsOthersRemain, octets),
            octets => (SpecifierChange::None, octets),
        };
        Ok(Some(Self::Alarm { slot, alarm_type, change, octets: read_octets(octets)? }))
    }

    fn record(rest: &[&str]) -> Result<Option<Self>, OrderError> {
        let [slot, index, octets @ ..] = rest else { return Ok(None) };
        let (slot, index) = (number("slot", slot, 0..=254)?, number("index", index, 0..=254)?);
        let octets = if octets.is_empty() { None } else { Some(read_octets(octets)?) };
        Ok(Some(Self::Record { slot, index, octets }))
    }
}

fn on(text: &str) -> Option<bool> {
    match text {
        "on" => Some(true),
        "off" => Some(false),
        _ => None,
    }
}

fn slot_number(text: &str) -> Result<u32, OrderError> {
    number("slot", text, 0..=u32::from(u16::MAX))
}

fn number<T: TryFrom<u32>>(what: &'static str, text: &str, within: RangeInclusive<u32>) -> Result<T, OrderError> {
    let number = text.parse().ok().filter(|number| within.contains(number));
    let wrong = || OrderError::Number { what, low: *within.start(), high: *within.end(), found: text.to_owned() };
    number.and_then(|number| T::try_from(number).ok()).ok_or_else(wrong)
}

fn read_octets(words: &[&str]) -> Result<Vec<u8>, OrderError> {
    let parts = words.iter().map(|word| octets_of(word).ok_or_else(|| OrderError::Octet((*word).to_owned())));
    Ok(parts.collect::<Result<Vec<_>, _>>()?.concat())
}

/// The octets of a word. Numbers are in network order, as PROFIBUS has them.
fn octets_of(word: &str) -> Option<Vec<u8>> {
    fn value<T: FromStr>(text: &str) -> Option<T> {
        text.parse().ok()
    }
    // from_str_radix would take a sign.
    let digits_only = |digits: &str| digits.bytes().all(|digit| digit.is_ascii_hexdigit());
    let one = |digits: &str, radix| {
        u8::from_str_radix(digits, radix).ok().filter(|_| digits_only(digits)).map(|octet| vec![octet])
    };
    if let Some((radix, digits)) = word.split_once('#') {
        let radix = value(radix).filter(|radix| [2, 8, 10, 16].contains(radix))?;
        return one(&digits.replace('_', ""), radix);
    }
    let Some((kind, text)) = word.split_once(':') else {
        let digits = word.strip_prefix("0x").unwrap_or(word);
        return one(digits, 16).filter(|_| digits.len() == 2);
    };
    match kind {
        "u8" => value::<u8>(text).map(|value| value.to_be_bytes().to_vec()),
        "u16" => value::<u16>(text).map(|value| value.to_be_bytes().to_vec()),
        "u32" => value::<u32>(text).map(|value| value.to_be_bytes().to_vec()),
        "i8" => value::<i8>(text).map(|value| value.to_be_bytes().to_vec()),
        "i16" => value::<i16>(text).map(|value| value.to_be_bytes().to_vec()),
        "i32" => value::<i32>(text).map(|value| value.to_be_bytes().to_vec()),
        "float" => value::<f32>(text).map(|value| value.to_be_bytes().to_vec()),
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn parse(line: &str) -> Result<Order, OrderError> {
        let words: Vec<_> = line.split_whitespace().collect();
        Order::parse(words[0], &words[1..]).unwrap()
    }

    #[test]
    fn octets_are_written_as_digits_or_as_values_in_network_order() {
        for (words, octets) in [
            ("1F 00", &[0x1F, 0][..]),
            ("0x1F 16#1f 2#0001_1111 10#31 8#37", &[31, 31, 31, 31, 31]),
            ("float:23.5 80", &[0x41, 0xBC, 0, 0, 0x80]),
            ("u16:500 i16:-2 u8:7 i8:-1", &[1, 0xF4, 0xFF, 0xFE, 7, 0xFF]),
            ("u32:1 i32:-7", &[0, 0, 0, 1, 0xFF, 0xFF, 0xFF, 0xF9]),
        ] {
            assert_eq!(
                parse(&format!("input 2 {words}")),
                Ok(Order::Input { slot: 2, at: 0, octets: octets.to_vec() })
            );
        }
        for word in ["1", "1FF", "0x1", "3#1", "16#100", "u8:256", "i8:128", "float:x", "word:1", "+1", "16#"] {
            assert_eq!(parse(&format!("input 2 {word}")), Err(OrderError::Octet(word.to_owned())));
        }
    }

    #[test]
    fn every_form_of_an_order_is_parsed() {
        let text = |text: &str| text.to_owned();
        for (line, order) in [
            ("input 1 at 4 1F", Order::Input { slot: 1, at: 4, octets: vec![0x1F] }),
            ("input 1 bit 9 on", Order::InputBit { slot: 1, bit: 9, on: true }),
            ("diagnosis bit 24 off", Order::Diagnosis { first: 24, last: 24, value: text("0") }),
            ("diagnosis area 8-11 Cable broken", Order::Diagnosis { first: 8, last: 11, value: text("Cable broken") }),
            ("diagnosis none", Order::NoDiagnosis),
            (
                "channel-error 3 0 Short circuit on",
                Order::ChannelError { slot: 3, channel: 0, error: text("Short circuit"), present: true },
            ),
            (
                "alarm 2 process 12 34",
                Order::Alarm { slot: 2, alarm_type: 2, change: SpecifierChange::None, octets: vec![0x12, 0x34] },
            ),
            (
                "alarm 0 diagnostic appears",
                Order::Alarm { slot: 0, alarm_type: 1, change: SpecifierChange::Appears, octets: Vec::new() },
            ),
            (
                "alarm 2 126 others-remain u8:7",
                Order::Alarm {
                    slot: 2,
                    alarm_type: 126,
                    change: SpecifierChange::DisappearsOthersRemain,
                    octets: vec![7],
                },
            ),
            ("record 1 20 01 02", Order::Record { slot: 1, index: 20, octets: Some(vec![1, 2]) }),
            ("record 1 20", Order::Record { slot: 1, index: 20, octets: None }),
        ] {
            assert_eq!(parse(line), Ok(order), "{line}");
        }
    }

    #[test]
    fn the_error_for_wrong_words_names_the_form_or_the_limits() {
        for line in ["input", "input 1", "input 1 at 4", "input 1 bit 9 up"] {
            assert_eq!(parse(line), Err(OrderError::Form("input")), "{line}");
        }
        for line in
            ["diagnosis", "diagnosis bit 1", "diagnosis area 9-8 1", "diagnosis area 0-64 1", "diagnosis area 8 1"]
        {
            assert_eq!(parse(line), Err(OrderError::Form("diagnosis")), "{line}");
        }
        for line in ["channel-error 1 2 on", "channel-error 1 2 3 maybe", "channel-error"] {
            assert_eq!(parse(line), Err(OrderError::Form("channel-error")), "{line}");
        }
        for line in ["alarm", "alarm 2", "alarm 2 process-alarm"] {
            assert_eq!(parse(line), Err(OrderError::Form("alarm")), "{line}");
        }
        for (line, sentence) in [
            ("alarm 255 process", "expected for the slot a number from 0 to 254, got \"255\""),
            ("alarm 2 7", "expected for the alarm type a number from 32 to 126, got \"7\""),
            ("record 1", "expected record ADDR SLOT INDEX [OCTET|TYPE:VALUE ...]"),
            ("record 255 1", "expected for the slot a number from 0 to 254, got \"255\""),
            ("record 1 255", "expected for the index a number from 0 to 254, got \"255\""),
            ("channel-error 1 64 2 on", "expected for the channel a number from 0 to 63, got \"64\""),
            ("diagnosis bit 496 on", "expected for the bit a number from 0 to 495, got \"496\""),
            ("input x 1F", "expected for the slot a number from 0 to 65535, got \"x\""),
        ] {
            assert_eq!(parse(line).unwrap_err().to_string(), sentence, "{line}");
        }
    }
}
