//! The transition command of the cyclic outputs.

use crate::model::{Field, command_code};

/// The transition command of the last cycle. It acts when it changes; no telegram reports a refusal (errata-bpg-bcg-tpg 101).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct TransitionCommand([u8; 2]);

impl TransitionCommand {
    /// No command: the state after power-up.
    pub const NONE: Self = Self([0; 2]);

    /// The code of the command in a field of the outputs, if it is another one than in the last cycle.
    pub fn changed(&mut self, field: Field, octets: &[u8]) -> Option<u16> {
        let (Field::TransitionCommand, &[command, value]) = (field, octets) else { return None };
        let is_other = self.0 != [command, value];
        self.0 = [command, value];
        is_other.then(|| command_code(command, value))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_command_acts_when_it_changes() {
        let mut command = TransitionCommand::NONE;
        let codes = [[0, 0], [1, 2], [1, 2], [0, 2], [0, 0], [1, 2]];
        let codes = codes.map(|octets| command.changed(Field::TransitionCommand, &octets));
        assert_eq!(codes, [None, Some(0x0102), None, Some(0), Some(0), Some(0x0102)]);
        assert_eq!(command.changed(Field::SensorOnOff, &[3, 3]), None);
        assert_eq!(command.changed(Field::TransitionCommand, &[3]), None);
        assert_eq!(command, TransitionCommand([1, 2]), "other fields are no command");
    }
}
