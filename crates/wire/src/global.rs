//! Global_Control (SAP 58): a command to all slaves of a group. profibus-wire 2.9.

use crate::octets::{Reader, TooLong, TooShort, Writer};

bitflags::bitflags! {
    /// Control_Command.
    #[derive(Clone, Copy, Debug, PartialEq, Eq)]
    pub struct ControlCommand: u8 {
        /// Set the outputs to their safe state.
        const CLEAR_DATA = 1 << 1;
        /// End Freeze mode.
        const UNFREEZE = 1 << 2;
        /// Sample the inputs now and return this image until the next command.
        const FREEZE = 1 << 3;
        /// End Sync mode.
        const UNSYNC = 1 << 4;
        /// Apply the received outputs now and hold later ones until the next command.
        const SYNC = 1 << 5;
        /// Bits 0, 6 and 7, reserved: 0.
        const RESERVED = 0xC1;
    }
}

/// The data unit of Global_Control.
///
/// ```
/// use profivac_wire::global::{ControlCommand, GlobalControl};
///
/// let control = GlobalControl::parse(&[0x20, 0x06])?;
/// assert_eq!(control.command, ControlCommand::SYNC);
/// assert!(control.selects(0x02) && !control.selects(0x08));
///
/// let mut out = [0; 2];
/// assert_eq!(control.emit(&mut out)?, 2);
/// assert_eq!(out, [0x20, 0x06]);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct GlobalControl {
    /// Control_Command.
    pub command: ControlCommand,
    /// Group_Select: 0 selects all slaves, otherwise the slaves whose Group_Ident shares a bit.
    pub group: u8,
}

impl GlobalControl {
    /// Reads the data unit. Further octets are ignored.
    ///
    /// # Errors
    /// [`TooShort`] if there are fewer than two octets.
    pub fn parse(du: &[u8]) -> Result<Self, TooShort> {
        let mut reader = Reader::new(du);
        Ok(Self { command: ControlCommand::from_bits_retain(reader.octet()?), group: reader.octet()? })
    }

    /// Writes the data unit to the front of `out` and returns its length.
    ///
    /// # Errors
    /// [`TooLong`] if `out` is too small.
    pub fn emit(&self, out: &mut [u8]) -> Result<usize, TooLong> {
        let mut writer = Writer::new(out);
        writer.octets(&[self.command.bits(), self.group])?;
        Ok(writer.written())
    }

    /// Whether the command selects a slave with `group_ident`.
    #[must_use]
    pub const fn selects(&self, group_ident: u8) -> bool {
        self.group == 0 || self.group & group_ident != 0
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn parses_and_emits_every_pair_of_octets() {
        for command in 0..=0xFF {
            for group in [0, 1, 0x80, 0xFF] {
                let control = GlobalControl::parse(&[command, group]).unwrap();
                let mut out = [0; 2];
                assert_eq!(control.emit(&mut out), Ok(2));
                assert_eq!(out, [command, group]);
            }
        }
        assert_eq!(GlobalControl::parse(&[0x20]), Err(TooShort));
        assert_eq!(GlobalControl { command: ControlCommand::SYNC, group: 1 }.emit(&mut [0]), Err(TooLong));
    }

    #[test]
    fn group_select_zero_selects_every_slave() {
        let select = |group| GlobalControl { command: ControlCommand::empty(), group };
        assert!(select(0).selects(0));
        assert!(select(0x06).selects(0x02));
        assert!(!select(0x06).selects(0x09));
    }
}
