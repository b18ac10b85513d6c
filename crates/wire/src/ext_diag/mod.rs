//! The blocks of Ext_Diag_Data, after the six fixed octets of a diagnosis. profibus-wire 2.3.1 and 2.3.2.
//!
//! The format of a device-related block depends on the device: it is defined in the manual, or, on a DP-V1 device, is an
//! alarm or a status. The caller knows the device, so [`Message`] is parsed from the block in a second step. Both implement
//! [`Display`](core::fmt::Display) in English.
//!
//! ```
//! use profivac_wire::ext_diag::{Block, Blocks, Channel, ChannelError, Organisation};
//! use profivac_wire::ext_diag::{Message, MessageKind, ModuleState, SpecifierChange, module_states};
//!
//! // Module_Status of two modules, then a short circuit at input 3 of the identifier 1.
//! let octets = [0x05, 0x82, 0x00, 0x00, 0x04, 0x81, 0x43, 0x21];
//! let mut blocks = Blocks::new(&octets);
//! let Some(Ok(Block::Device(content))) = blocks.next() else { panic!("expected a device-related block") };
//! let message = Message::parse(content)?;
//! assert_eq!((message.kind, message.kind.to_string().as_str()), (MessageKind::MODULE_STATUS, "module status"));
//! let states: Vec<_> = module_states(message.data).take(2).collect();
//! assert_eq!(states, [ModuleState::Valid, ModuleState::Invalid]);
//!
//! let Some(Ok(block @ Block::Channel(channel))) = blocks.next() else { panic!("expected a channel-related block") };
//! assert_eq!((channel.identifier, channel.number, channel.input), (1, 3, true));
//! assert_eq!((channel.organisation.name(), channel.error.to_string().as_str()), ("bit", "short circuit"));
//! assert_eq!(channel, Channel { organisation: Organisation::Bit, error: ChannelError(1), output: false, ..channel });
//! let mut out = [0; 3];
//! assert_eq!(block.emit(&mut out)?, 3);
//! assert_eq!(out, octets[5..]);
//!
//! // A process alarm of slot 3.
//! let alarm = Message::parse(&[0x02, 3, 0x0D])?;
//! assert_eq!((alarm.specifier.seq_nr(), alarm.specifier.add_ack()), (1, true));
//! assert_eq!(alarm.specifier.change(), SpecifierChange::Appears);
//! let mut out = [0; 3];
//! assert_eq!(alarm.emit(&mut out)?, 3);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

mod channel;
mod display;
mod message;

pub use channel::{Channel, ChannelError, Organisation};
pub use message::{Message, MessageKind, ModuleState, Specifier, SpecifierChange, module_states};

use crate::octets::{Reader, TooLong, TooShort, Writer};

/// A block of Ext_Diag_Data.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Block<'a> {
    /// Device-related: at most 62 octets after the header.
    Device(&'a [u8]),
    /// Identifier-related: one bit for each configuration identifier, see [`identifiers_with_diagnosis`]. At most 62 octets,
    /// 31 in practice.
    Identifier(&'a [u8]),
    /// Channel-related: the error of one channel of a module.
    Channel(Channel),
    /// Revision, 0 to 63.
    Revision(u8),
}

const LENGTH: u8 = 0x3F;
const IDENTIFIER: u8 = 0x40;
const CHANNEL: u8 = 0x80;
const REVISION: u8 = 0xC0;

impl<'a> Block<'a> {
    fn parse(reader: &mut Reader<'a>) -> Result<Self, TooShort> {
        let header = reader.octet()?;
        let low = header & LENGTH;
        match header & !LENGTH {
            CHANNEL => Channel::parse(low, reader).map(Self::Channel),
            REVISION => Ok(Self::Revision(low)),
            kind => {
                // The length includes the header, so 0 is invalid.
                let content = reader.take(usize::from(low).checked_sub(1).ok_or(TooShort)?)?;
                Ok(if kind == IDENTIFIER { Self::Identifier(content) } else { Self::Device(content) })
            }
        }
    }

    /// Writes the block to the front of `out` and returns its length.
    ///
    /// # Errors
    /// [`TooLong`] if `out` is too small or the content too long for a block.
    pub fn emit(&self, out: &mut [u8]) -> Result<usize, TooLong> {
        let mut writer = Writer::new(out);
        match self {
            Self::Device(content) => sized(0, content, &mut writer),
            Self::Identifier(content) => sized(IDENTIFIER, content, &mut writer),
            Self::Channel(channel) => channel.emit(&mut writer),
            Self::Revision(revision) => writer.octet(REVISION | (revision & LENGTH)),
        }?;
        Ok(writer.written())
    }
}

fn sized(kind: u8, content: &[u8], writer: &mut Writer<'_>) -> Result<(), TooLong> {
    let length = u8::try_from(content.len()).ok().and_then(|length| length.checked_add(1));
    writer.octet(kind | length.filter(|length| *length <= LENGTH).ok_or(TooLong)?)?;
    writer.octets(content)
}

/// Iterates over the blocks of Ext_Diag_Data. Ends after the first block that is truncated or has the length 0.
///
/// ```
/// use profivac_wire::ext_diag::{Block, Blocks, identifiers_with_diagnosis};
///
/// let mut blocks = Blocks::new(&[0x45, 0x01, 0x10, 0x04, 0x00, 0xC5]);
/// let Some(Ok(Block::Identifier(content))) = blocks.next() else { panic!("expected an identifier-related block") };
/// assert!(identifiers_with_diagnosis(content).eq([0, 12, 18]));
/// assert_eq!(blocks.next(), Some(Ok(Block::Revision(5))));
/// ```
#[derive(Clone, Debug)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Blocks<'a> {
    reader: Reader<'a>,
}

impl<'a> Blocks<'a> {
    /// An iterator over the blocks of `ext_diag`.
    #[must_use]
    pub const fn new(ext_diag: &'a [u8]) -> Self {
        Self { reader: Reader::new(ext_diag) }
    }
}

impl<'a> Iterator for Blocks<'a> {
    type Item = Result<Block<'a>, TooShort>;

    fn next(&mut self) -> Option<Self::Item> {
        if self.reader.is_empty() {
            return None;
        }
        let block = Block::parse(&mut self.reader);
        if block.is_err() {
            self.reader = Reader::new(&[]);
        }
        Some(block)
    }
}

/// The numbers of the identifiers with diagnosis in an identifier-related block; number 0 is bit 0 of the first octet.
pub fn identifiers_with_diagnosis(content: &[u8]) -> impl Iterator<Item = u16> {
    let bits = content.iter().flat_map(|octet| (0..8).map(move |bit| octet >> bit & 1 != 0));
    (0..).zip(bits).filter(|(_, set)| *set).map(|(number, _)| number)
}

#[cfg(test)]
mod tests {
    extern crate std;
    use super::*;
    use crate::diag::SlaveDiag;
    use crate::testing::{du, hex};
    use std::collections::BTreeSet;
    use std::string::{String, ToString};
    use std::vec::Vec;

    /// profibus-wire 2.3.1, the example of the standard.
    const STANDARD: &str =
        "68 1A 1A 68 82 88 08 3E 3C 08 0C 00 02 12 34 04 11 22 33 45 01 10 04 00 80 02 24 8C 06 A7 8B 16";
    /// profibus-wire 2.3.2
    const STATUS: &str = "68 12 12 68 82 88 08 3E 3C 00 0C 00 02 12 34 07 81 02 00 05 01 2C 9C 16";
    const ALARM: &str = "68 11 11 68 82 88 08 3E 3C 08 0C 00 02 12 34 06 01 01 09 DE AD 84 16";

    fn ext_diag(text: &str) -> Vec<u8> {
        SlaveDiag::parse(&du(text)).unwrap().ext_diag.to_vec()
    }

    fn standard() -> [Block<'static>; 4] {
        let channel = Channel {
            identifier: 0,
            input: false,
            output: false,
            number: 2,
            organisation: Organisation::Bit,
            error: ChannelError(4),
        };
        let other =
            Channel { identifier: 12, number: 6, organisation: Organisation::Word, error: ChannelError(7), ..channel };
        [
            Block::Device(&[0x11, 0x22, 0x33]),
            Block::Identifier(&[0x01, 0x10, 0x04, 0x00]),
            Block::Channel(channel),
            Block::Channel(other),
        ]
    }

    #[test]
    fn parses() {
        let octets = ext_diag(STANDARD);
        assert!(Blocks::new(&octets).eq(standard().map(Ok)));
        let octets = ext_diag(ALARM);
        let alarm = Message { kind: MessageKind::Alarm(1), slot: 1, specifier: Specifier(9), data: &[0xDE, 0xAD] };
        let Some(Ok(Block::Device(content))) = Blocks::new(&octets).next() else { panic!("a device-related block") };
        assert_eq!(Message::parse(content), Ok(alarm));
        assert_eq!((alarm.specifier.seq_nr(), alarm.specifier.add_ack()), (1, false));
        assert_eq!(
            (alarm.specifier.change(), alarm.kind.to_string().as_str()),
            (SpecifierChange::Appears, "diagnostic alarm")
        );
        let octets = ext_diag(STATUS);
        let status = Message { kind: MessageKind::Status(1), slot: 2, specifier: Specifier(0), data: &[5, 1, 0x2C] };
        assert_eq!(Message::parse(&octets[1..]), Ok(status));
    }

    #[test]
    fn emits() {
        let mut out = [0; 64];
        let mut chain = Vec::new();
        for block in standard() {
            let length = block.emit(&mut out).unwrap();
            chain.extend_from_slice(&out[..length]);
            assert_eq!(block.emit(&mut out[..length - 1]), Err(TooLong));
        }
        assert_eq!(chain, ext_diag(STANDARD));
        let octets = ext_diag(ALARM);
        let message = Message::parse(&octets[1..]).unwrap();
        assert_eq!(message.emit(&mut out), Ok(5));
        assert_eq!(out[..5], octets[1..]);
        assert_eq!(message.emit(&mut out[..4]), Err(TooLong));
        assert_eq!(Block::Device(&[0; 62]).emit(&mut out), Ok(63));
        assert_eq!(Block::Device(&[0; 63]).emit(&mut out), Err(TooLong));
        assert_eq!(Block::Identifier(&[0; 256]).emit(&mut out), Err(TooLong));
    }

    #[test]
    fn too_short() {
        for (text, blocks) in [("00", 0), ("40", 0), ("04 11 22", 0), ("C1 45 01 10 04", 1), ("04 11 22 33 80 02", 1)] {
            let octets = hex(text);
            let all: Vec<_> = Blocks::new(&octets).collect();
            assert_eq!(all.len(), blocks + 1, "{text}");
            assert_eq!(all[blocks], Err(TooShort), "{text}");
        }
        assert_eq!(Message::parse(&[1, 2]), Err(TooShort));
    }

    #[test]
    fn every_altered_octet_is_an_error_or_is_emitted_again() {
        let original = ext_diag(STANDARD);
        for position in 0..original.len() {
            for octet in 0..=0xFF {
                let mut altered = original.clone();
                altered[position] = octet;
                let mut chain = Vec::new();
                for block in Blocks::new(&altered).map_while(Result::ok) {
                    let mut out = [0; 64];
                    let length = block.emit(&mut out).unwrap();
                    chain.extend_from_slice(&out[..length]);
                }
                assert_eq!(chain, altered[..chain.len()]);
            }
        }
    }

    #[test]
    fn identifiers_are_counted_from_the_lowest_bit() {
        assert!(identifiers_with_diagnosis(&[0x01, 0x10, 0x04, 0x00]).eq([0, 12, 18]));
        assert!(identifiers_with_diagnosis(&[0; 31]).eq([]));
        assert!(identifiers_with_diagnosis(&[0, 0x80]).eq([15]));
    }

    /// The diagnosis of an ET 200S, profibus-wire 2.3.1: identifiers, then Module_Status of 64 modules.
    #[test]
    fn a_real_slave_puts_the_identifiers_first() {
        let octets = hex("49 00 00 00 00 00 00 00 00 14 82 00 00 E4 00 00 00 00 00 00 00 00 00 00 00 00 00 00 00");
        let blocks: Vec<_> = Blocks::new(&octets).map(Result::unwrap).collect();
        let [Block::Identifier(identifiers), Block::Device(content)] = blocks[..] else { panic!("two blocks") };
        assert_eq!(identifiers_with_diagnosis(identifiers).count(), 0);
        let message = Message::parse(content).unwrap();
        assert_eq!(message.kind, MessageKind::MODULE_STATUS);
        use ModuleState::{Invalid, Missing, Valid, Wrong};
        assert!(module_states(message.data).take(5).eq([Valid, Invalid, Wrong, Missing, Valid]));
        assert_eq!(module_states(message.data).count(), 64);
    }

    #[test]
    fn types_have_their_names_and_a_type_without_a_name_keeps_its_number() {
        for (octet, name) in [
            (0x00, "reserved alarm 0"),
            (0x02, "process alarm"),
            (0x07, "reserved alarm 7"),
            (0x1F, "reserved alarm 31"),
            (0x20, "manufacturer specific alarm 32"),
            (0x7E, "manufacturer specific alarm 126"),
            (0x7F, "reserved alarm 127"),
            (0x84, "reserved status 4"),
            (0x9E, "PrmCmdAck"),
            (0xA0, "manufacturer specific status 32"),
            (0xFE, "manufacturer specific status 126"),
            (0xFF, "reserved status 127"),
        ] {
            let kind = MessageKind::from_octet(octet);
            assert_eq!((kind.to_string().as_str(), kind.is_reserved()), (name, name.starts_with("reserved")));
        }
        for (error, name) in [
            (0, "reserved error 0"),
            (1, "short circuit"),
            (9, "error"),
            (10, "reserved error 10"),
            (15, "reserved error 15"),
            (16, "manufacturer specific error 16"),
            (31, "manufacturer specific error 31"),
        ] {
            assert_eq!(ChannelError(error).to_string(), name);
        }
    }

    /// Each of the 256 third octets of a channel-related block has a text of its own: no number is lost.
    #[test]
    fn every_width_and_error_of_a_channel_has_a_text_of_its_own() {
        let texts: BTreeSet<String> =
            (0..=0xFF).map(|kind| Blocks::new(&[0x82, 0xC3, kind]).next().unwrap().unwrap().to_string()).collect();
        assert_eq!(texts.len(), 256);
    }

    #[test]
    fn a_specifier_has_a_sequence_number_an_acknowledgement_and_a_change() {
        assert_eq!(Specifier(0x17).seq_nr(), 2);
        assert!(Specifier(0x17).add_ack());
        assert_eq!(Specifier(0x17).change(), SpecifierChange::DisappearsOthersRemain);
    }
}
