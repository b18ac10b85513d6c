//! Decodes parity and framing errors as a terminal driver marks them in the octets it delivers (PARMRK).
//!
//! `FF 00 x` is a character `x` with an error, `FF FF` is an octet FF. A break is `FF 00 00`, also an error.

use super::Character;

/// Removes the marks.
#[derive(Clone, Debug, Default)]
pub struct Marks {
    state: State,
}

#[derive(Clone, Copy, Debug, Default)]
enum State {
    #[default]
    Plain,
    /// FF arrived.
    Mark,
    /// FF 00 arrived.
    Error,
}

impl Marks {
    /// The character that the next octet from the driver completes.
    pub fn take(&mut self, octet: u8) -> Option<Character> {
        let (state, completed) = match (self.state, octet) {
            (State::Plain, 0xFF) => (State::Mark, None),
            (State::Mark, 0x00) => (State::Error, None),
            (State::Plain | State::Mark, _) => (State::Plain, Some(Character::Octet(octet))),
            (State::Error, _) => (State::Plain, Some(Character::Error)),
        };
        self.state = state;
        completed
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn taken(octets: &[u8]) -> Vec<Character> {
        let mut marks = Marks::default();
        octets.iter().filter_map(|octet| marks.take(*octet)).collect()
    }

    #[test]
    fn octets_pass_and_a_doubled_ff_is_one() {
        use Character::Octet;
        assert_eq!(taken(&[0x68, 0x00, 0xFF, 0xFF, 0x16]), [Octet(0x68), Octet(0), Octet(0xFF), Octet(0x16)]);
    }

    #[test]
    fn a_marked_character_is_an_error_whatever_its_value() {
        for octet in [0x00, 0x55, 0xFF] {
            assert_eq!(taken(&[0xFF, 0x00, octet, 0x10]), [Character::Error, Character::Octet(0x10)]);
        }
    }
}
