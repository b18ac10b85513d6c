//! Global_Control (SAP 58): one command to all slaves of a group. profibus-wire 2.9.

use crate::octets::{Reader, TooLong, TooShort, Writer};

bitflags::bitflags! {
    /// Control_Command.
    #[derive(Clone, Copy, Debug, PartialEq, Eq)]
    pub struct ControlCommand: u8 {
        /// Outputs to their safe state, now.
        const CLEAR_DATA = 1 << 1;
        /// End Freeze.
        const UNFREEZE = 1 << 2;
        /// Sample the inputs now and keep sending this image.
        const FREEZE = 1 << 3;
        /// End Sync.
        const UNSYNC = 1 << 4;
        /// Take over the outputs now and hold further ones back.
        const SYNC = 1 << 5;
        /// Bits 0, 6 and 7, reserved: 0.
        const RESERVED = 0xC1;
    }
}

/// The data unit of Global_Control.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct GlobalControl {
    /// What to do.
    pub command: ControlCommand,
    /// Group_Select: 0 means all slaves, else those that share a bit of their Group_Ident.
    pub group: u8,
}

impl GlobalControl {
    /// Reads the data unit. Octets after the two are ignored.
    ///
    /// # Errors
    /// [`TooShort`] when the two octets are not both there.
    pub fn parse(du: &[u8]) -> Result<Self, TooShort> {
        let mut reader = Reader::new(du);
        Ok(Self { command: ControlCommand::from_bits_retain(reader.octet()?), group: reader.octet()? })
    }

    /// Writes the data unit to the front of `out` and returns its length.
    ///
    /// # Errors
    /// [`Full`] when `out` is too small.
    pub fn emit(&self, out: &mut [u8]) -> Result<usize, TooLong> {
        let mut writer = Writer::new(out);
        writer.octets(&[self.command.bits(), self.group])?;
        Ok(writer.written())
    }

    /// Whether a slave of `group_ident` is meant.
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
    fn group_select_zero_concerns_everybody() {
        let select = |group| GlobalControl { command: ControlCommand::empty(), group };
        assert!(select(0).selects(0));
        assert!(select(0x06).selects(0x02));
        assert!(!select(0x06).selects(0x09));
    }
}
