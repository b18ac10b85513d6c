//! Characters of eleven bits, and the receiver that reads them from line levels. profibus-wire 1.1.
//!
//! A character is a start bit (0), eight data bits with the lowest first, even parity and a stop bit (1). The idle line is 1.
//! The levels alone determine where a character begins, so a receiver with an inverted start bit reads the following bits
//! shifted, as a real UART does.

use profivac_dp::link::CHARACTER_TBIT;

/// A character as received.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Character {
    /// The data bits.
    pub octet: u8,
    /// Whether parity or stop bit are wrong.
    pub error: bool,
}

/// The eleven bits of `octet`; bit 0 is sent first.
#[must_use]
pub const fn bits(octet: u8) -> u16 {
    let parity = (octet.count_ones() & 1) as u16;
    1 << 10 | parity << 9 | (octet as u16) << 1
}

/// Reads characters from line levels, one bit time per step.
#[derive(Clone, Copy, Debug, Default)]
pub struct Uart {
    /// The bits of the present character so far, the first in bit 0.
    bits: u16,
    count: u8,
    /// A stop bit is missing: the next character begins after the line was 1.
    broken: bool,
}

impl Uart {
    /// Whether the receiver is between two characters: the next 0 is a start bit.
    #[must_use]
    pub const fn is_idle(&self) -> bool {
        self.count == 0 && !self.broken
    }

    /// Takes the level of one bit time. Returns the character that ends with it.
    pub const fn level(&mut self, level: bool) -> Option<Character> {
        if self.broken || self.count == 0 && level {
            self.broken = self.broken && !level;
            return None;
        }
        self.bits |= (level as u16) << self.count;
        self.count += 1;
        if (self.count as u64) < CHARACTER_TBIT {
            return None;
        }
        let octet = (self.bits >> 1) as u8;
        let error = self.bits != bits(octet);
        // chosen: some receivers treat a missing stop bit as the next start bit; this one waits for a 1.
        *self = Self { bits: 0, count: 0, broken: !level };
        Some(Character { octet, error })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn read(levels: impl IntoIterator<Item = bool>) -> Vec<Character> {
        let mut uart = Uart::default();
        levels.into_iter().filter_map(|level| uart.level(level)).collect()
    }

    fn levels(bits: u16) -> impl Iterator<Item = bool> {
        (0..11).map(move |bit| bits >> bit & 1 == 1)
    }

    #[test]
    fn a_character_has_even_parity() {
        // Stop, parity, data, start.
        for (octet, text) in [
            (0x16, "1 1 00010110 0"),
            (0xE5, "1 1 11100101 0"),
            (0x10, "1 1 00010000 0"),
            (0x68, "1 1 01101000 0"),
            (0xFF, "1 0 11111111 0"),
        ] {
            assert_eq!(bits(octet), u16::from_str_radix(&text.replace(' ', ""), 2).unwrap(), "{octet:02X}");
        }
    }

    #[test]
    fn every_octet_is_read_back_without_idle_bits_between() {
        let sent: Vec<u8> = (0..=0xFF).collect();
        let read = read(sent.iter().flat_map(|octet| levels(bits(*octet))));
        assert_eq!(read, sent.into_iter().map(|octet| Character { octet, error: false }).collect::<Vec<_>>());
    }

    #[test]
    fn every_flipped_data_or_parity_or_stop_bit_is_an_error() {
        for octet in 0..=0xFF {
            for bit in 1..11 {
                let read = read(levels(bits(octet) ^ 1 << bit));
                assert!(read.len() == 1 && read[0].error, "{octet:02X} bit {bit}");
            }
        }
    }

    #[test]
    fn a_lost_start_bit_shifts_the_bits_that_are_read() {
        // E5 without its start bit begins at the first 0 of the data; idle bits complete the character.
        let line = levels(bits(0xE5) | 1).chain([true; 11]);
        assert_eq!(read(line), [Character { octet: 0xF9, error: true }]);
    }

    #[test]
    fn a_short_pulse_on_the_idle_line_is_a_character_error() {
        let line = [true, false].into_iter().chain([true; 12]);
        assert_eq!(read(line), [Character { octet: 0xFF, error: true }]);
    }

    #[test]
    fn a_line_at_0_is_one_character_error_until_it_returns_to_1() {
        let line = [false; 40].into_iter().chain([true]).chain(levels(bits(0x55)));
        let read = read(line);
        assert_eq!(read, [Character { octet: 0, error: true }, Character { octet: 0x55, error: false }]);
    }
}
