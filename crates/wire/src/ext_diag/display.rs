//! Extended diagnosis in English.

use super::{
    Block, Channel, Message, MessageKind, ModuleState, SpecifierChange, identifiers_with_diagnosis, module_states,
};
use core::fmt::{self, Display, Formatter};

impl Display for Block<'_> {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        match self {
            Self::Device(content) => {
                f.write_str("device:")?;
                octets(content, f)
            }
            Self::Identifier(content) => {
                f.write_str("disturbed modules:")?;
                list(identifiers_with_diagnosis(content), f)
            }
            Self::Channel(channel) => channel.fmt(f),
            Self::Revision(revision) => write!(f, "revision {revision}"),
        }
    }
}

impl Display for Channel {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        let direction = match (self.input, self.output) {
            (true, true) => "input and output ",
            (true, false) => "input ",
            (false, true) => "output ",
            (false, false) => "",
        };
        let Self { identifier, number, organisation, error, .. } = self;
        write!(f, "module {identifier}, {direction}channel {number} ({}): {error}", organisation.name())
    }
}

impl Display for Message<'_> {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        write!(f, "{} of slot {}", self.kind, self.slot)?;
        if matches!(self.kind, MessageKind::Alarm(_)) {
            write!(f, ", sequence number {}", self.specifier.seq_nr())?;
        }
        f.write_str(match self.specifier.change() {
            SpecifierChange::None => "",
            SpecifierChange::Appears => ", appears",
            SpecifierChange::Disappears => ", disappears",
            SpecifierChange::DisappearsOthersRemain => ", disappears, others remain",
        })?;
        match (self.kind, self.data) {
            (_, []) => Ok(()),
            (MessageKind::MODULE_STATUS, data) => {
                f.write_str(":")?;
                modules(data, f)
            }
            (_, data) => {
                f.write_str(":")?;
                octets(data, f)
            }
        }
    }
}

/// Lists the modules with an error.
fn modules(data: &[u8], f: &mut Formatter<'_>) -> fmt::Result {
    let mut first = true;
    for (number, state) in (0u16..).zip(module_states(data)) {
        let error = match state {
            ModuleState::Valid => continue,
            ModuleState::Invalid => "invalid data",
            ModuleState::Wrong => "wrong module",
            ModuleState::Missing => "no module",
        };
        write!(f, "{} {number} {error}", if first { "" } else { "," })?;
        first = false;
    }
    if first { f.write_str(" all valid") } else { Ok(()) }
}

fn octets(content: &[u8], f: &mut Formatter<'_>) -> fmt::Result {
    content.iter().try_for_each(|octet| write!(f, " {octet:02X}"))
}

fn list(numbers: impl Iterator<Item = u16>, f: &mut Formatter<'_>) -> fmt::Result {
    let mut first = true;
    for number in numbers {
        write!(f, "{} {number}", if first { "" } else { "," })?;
        first = false;
    }
    if first { f.write_str(" none") } else { Ok(()) }
}

#[cfg(test)]
mod tests {
    extern crate std;
    use super::super::Blocks;
    use super::*;
    use crate::testing::hex;
    use std::string::{String, ToString};
    use std::vec::Vec;

    fn describe(text: &str) -> Vec<String> {
        Blocks::new(&hex(text))
            .map(|block| block.map_or_else(|error| error.to_string(), |block| block.to_string()))
            .collect()
    }

    /// The example of the standard, profibus-wire 2.3.1, and further cases.
    #[test]
    fn blocks_are_described_in_english() {
        let described = describe("04 11 22 33 45 01 10 04 00 80 02 24 8C 06 A7 82 C3 50 BF 47 8F C5 42 00 00");
        let expected = [
            "device: 11 22 33",
            "disturbed modules: 0, 12, 18",
            "module 0, channel 2 (bit): overload",
            "module 12, channel 6 (word): upper limit exceeded",
            "module 2, input and output channel 3 (2 bit): manufacturer specific error 16",
        ];
        assert_eq!(described[..5], expected);
        assert_eq!(
            described[5..],
            [
                "module 63, input channel 7 (byte): reserved error 15",
                "revision 5",
                "disturbed modules: none",
                "the data unit ends too early"
            ][..]
        );
    }

    /// profibus-wire 2.3.2
    #[test]
    fn alarms_and_status_messages_are_described_in_english() {
        for (content, words) in [
            ("81 02 00 05 01 2C", "status message of slot 2: 05 01 2C"),
            ("02 03 09 50", "process alarm of slot 3, sequence number 1, appears: 50"),
            ("01 01 13", "diagnostic alarm of slot 1, sequence number 2, disappears, others remain"),
            ("82 00 00 E4", "module status of slot 0: 1 invalid data, 2 wrong module, 3 no module"),
            ("82 00 02 00", "module status of slot 0, disappears: all valid"),
            ("FE 00 01 04", "manufacturer specific status 126 of slot 0, appears: 04"),
        ] {
            assert_eq!(Message::parse(&hex(content)).unwrap().to_string(), words);
        }
    }
}
