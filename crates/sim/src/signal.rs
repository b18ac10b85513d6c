//! A telegram on the cable, as bits.

use crate::character::{self, Character, Uart};
use profivac_dp::link::CHARACTER_TBIT;
use std::sync::Arc;

/// A fault of one telegram between its sender and all receivers. Octets and bits count from 0.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum TelegramFault {
    /// Inverts these bits; each character has eleven: start, data, parity, stop.
    Flip(Vec<usize>),
    /// Inverts the parity bit of an octet.
    CharacterError(usize),
    /// Removes an octet; the line is idle in its place.
    Lose(usize),
    /// Inserts an octet in front of the octet with this number.
    Insert(usize, u8),
    /// The sender pauses in front of an octet, for this number of bit times. The referee reports it.
    Pause(usize, u64),
}

/// A transmission, bit by bit.
#[derive(Clone, Debug)]
pub(crate) struct Signal {
    octets: Arc<[u8]>,
    /// Whether the octets are one telegram.
    is_telegram: bool,
    damage: Option<Arc<Damage>>,
}

/// The differences from octets without gaps and errors.
#[derive(Clone, Debug, Default)]
struct Damage {
    /// Idle bit times in front of the octet with this number.
    pauses: Vec<(usize, u64)>,
    /// Inverted bits, counted from the first start bit.
    flips: Vec<u64>,
}

impl Signal {
    /// An undamaged signal; `is_telegram` if the octets are one telegram.
    pub(crate) const fn plain(octets: Arc<[u8]>, is_telegram: bool) -> Self {
        Self { octets, is_telegram, damage: None }
    }

    /// `octets` with faults, applied in order.
    pub(crate) fn faulty(octets: &[u8], faults: &[TelegramFault]) -> Self {
        let (mut octets, mut damage) = (octets.to_vec(), Damage::default());
        for fault in faults {
            match fault {
                TelegramFault::Flip(bits) => damage.flips.extend(bits.iter().map(|bit| *bit as u64)),
                TelegramFault::CharacterError(index) => damage.flips.push(*index as u64 * CHARACTER_TBIT + 9),
                TelegramFault::Lose(index) if *index < octets.len() => {
                    octets.remove(*index);
                    damage.pauses.push((*index, CHARACTER_TBIT));
                }
                TelegramFault::Lose(_) => {}
                TelegramFault::Insert(index, octet) => octets.insert((*index).min(octets.len()), *octet),
                TelegramFault::Pause(index, tbit) => damage.pauses.push((*index, *tbit)),
            }
        }
        Self { octets: octets.into(), is_telegram: false, damage: Some(Arc::new(damage)) }
    }

    /// Whether an undisturbed receiver gets one telegram, complete with the last octet.
    pub(crate) const fn is_telegram(&self) -> bool {
        self.is_telegram
    }

    /// The octets, if the signal has neither gaps nor errors.
    pub(crate) fn clean(&self) -> Option<&Arc<[u8]>> {
        self.damage.is_none().then_some(&self.octets)
    }

    /// From the first start bit to the last stop bit.
    pub(crate) fn duration_tbit(&self) -> u64 {
        let pauses: u64 = self.damage.iter().flat_map(|damage| &damage.pauses).map(|(_, tbit)| tbit).sum();
        self.octets.len() as u64 * CHARACTER_TBIT + pauses
    }

    /// The level `offset` bit times after the start of the first start bit.
    pub(crate) fn level(&self, offset: u64) -> bool {
        let Some(damage) = &self.damage else { return self.sent(offset) };
        let flipped = damage.flips.iter().filter(|flip| **flip == offset).count() % 2 == 1;
        let mut without_pauses = offset;
        for (index, tbit) in &damage.pauses {
            let begin = *index as u64 * CHARACTER_TBIT;
            if without_pauses >= begin + tbit {
                without_pauses -= tbit;
            } else if without_pauses >= begin {
                return !flipped;
            }
        }
        self.sent(without_pauses) != flipped
    }

    /// The level without damage.
    fn sent(&self, offset: u64) -> bool {
        let octet = self.octets.get((offset / CHARACTER_TBIT) as usize);
        octet.is_none_or(|octet| character::bits(*octet) >> (offset % CHARACTER_TBIT) & 1 == 1)
    }

    /// The characters that a receiver reads if the bits `flips` are inverted as well.
    pub(crate) fn read(&self, flips: &[u64]) -> Vec<Character> {
        let mut uart = Uart::default();
        let levels = (0..self.duration_tbit() + CHARACTER_TBIT).map(|at| self.level(at) != flips.contains(&at));
        levels.filter_map(|level| uart.level(level)).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const TOKEN: [u8; 3] = [0xDC, 2, 2];

    fn read(faults: &[TelegramFault]) -> Vec<(u8, bool)> {
        let signal = Signal::faulty(&TOKEN, faults);
        signal.read(&[]).into_iter().map(|character| (character.octet, character.error)).collect()
    }

    #[test]
    fn an_undamaged_signal_is_read_unchanged() {
        assert_eq!(read(&[]), [(0xDC, false), (2, false), (2, false)]);
        assert_eq!(Signal::plain(TOKEN.into(), true).duration_tbit(), 33);
    }

    #[test]
    fn a_flipped_bit_is_an_error_and_two_are_another_octet() {
        assert_eq!(read(&[TelegramFault::Flip(vec![12])]), [(0xDC, false), (3, true), (2, false)]);
        assert_eq!(read(&[TelegramFault::Flip(vec![12, 14])]), [(0xDC, false), (7, false), (2, false)]);
        assert_eq!(read(&[TelegramFault::CharacterError(2)]), [(0xDC, false), (2, false), (2, true)]);
    }

    #[test]
    fn octets_are_lost_and_inserted() {
        assert_eq!(read(&[TelegramFault::Lose(1)]), [(0xDC, false), (2, false)]);
        assert_eq!(Signal::faulty(&TOKEN, &[TelegramFault::Lose(1)]).duration_tbit(), 33);
        assert_eq!(read(&[TelegramFault::Insert(1, 0x55)]), [(0xDC, false), (0x55, false), (2, false), (2, false)]);
        assert_eq!(
            read(&[TelegramFault::Lose(9), TelegramFault::Insert(9, 1)]),
            [(0xDC, false), (2, false), (2, false), (1, false)]
        );
    }

    #[test]
    fn a_pause_delays_the_octets_after_it() {
        let signal = Signal::faulty(&TOKEN, &[TelegramFault::Pause(1, 5)]);
        assert_eq!(signal.duration_tbit(), 38);
        assert!((11..16).all(|at| signal.level(at)) && !signal.level(16));
        assert_eq!(read(&[TelegramFault::Pause(1, 5)]), [(0xDC, false), (2, false), (2, false)]);
    }
}
