//! A telegram on its way along the cable, as bits.

use crate::character::{self, Character, Uart};
use profivac_dp::link::CHARACTER_TBIT;
use std::sync::Arc;

/// Something that happens to one telegram between its sender and all who listen. Octets and bits count from 0.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum TelegramFault {
    /// These bits are inverted, eleven for each character: start, data, parity, stop.
    Flip(Vec<usize>),
    /// The parity bit of an octet is inverted.
    CharacterError(usize),
    /// An octet is missing; the line is idle in its place.
    Lose(usize),
    /// An octet more, in front of the octet that had this number.
    Insert(usize, u8),
    /// The sender itself pauses for so many bit times in front of an octet. The referee objects.
    Pause(usize, u64),
}

/// What is sent, bit by bit.
#[derive(Clone, Debug)]
pub(crate) struct Signal {
    octets: Arc<[u8]>,
    /// The octets are one telegram.
    telegram: bool,
    damage: Option<Arc<Damage>>,
}

/// Where the bits differ from octets that follow each other without a gap.
#[derive(Clone, Debug, Default)]
struct Damage {
    /// Idle bit times in front of the octet with this number.
    pauses: Vec<(usize, u64)>,
    /// Inverted bits, counted from the first start bit.
    flips: Vec<u64>,
}

impl Signal {
    /// `octets` as they are; `telegram` if they are one.
    pub(crate) const fn plain(octets: Arc<[u8]>, telegram: bool) -> Self {
        Self { octets, telegram, damage: None }
    }

    /// `octets` after all of `tampers`, one after the other.
    pub(crate) fn faulty(octets: &[u8], tampers: &[TelegramFault]) -> Self {
        let (mut octets, mut damage) = (octets.to_vec(), Damage::default());
        for tamper in tampers {
            match tamper {
                TelegramFault::Flip(bits) => damage.flips.extend(bits.iter().map(|bit| *bit as u64)),
                TelegramFault::CharacterError(place) => damage.flips.push(*place as u64 * CHARACTER_TBIT + 9),
                TelegramFault::Lose(place) if *place < octets.len() => {
                    octets.remove(*place);
                    damage.pauses.push((*place, CHARACTER_TBIT));
                }
                TelegramFault::Lose(_) => {}
                TelegramFault::Insert(place, octet) => octets.insert((*place).min(octets.len()), *octet),
                TelegramFault::Pause(place, tbit) => damage.pauses.push((*place, *tbit)),
            }
        }
        Self { octets: octets.into(), telegram: false, damage: Some(Arc::new(damage)) }
    }

    /// Whether an undisturbed receiver hears one telegram, with its last octet.
    pub(crate) const fn is_telegram(&self) -> bool {
        self.telegram
    }

    /// The octets if they follow each other without gap or damage.
    pub(crate) fn clean(&self) -> Option<&Arc<[u8]>> {
        self.damage.is_none().then_some(&self.octets)
    }

    /// From the first start bit to the last stop bit.
    pub(crate) fn duration_tbit(&self) -> u64 {
        let pauses: u64 = self.damage.iter().flat_map(|damage| &damage.pauses).map(|(_, tbit)| tbit).sum();
        self.octets.len() as u64 * CHARACTER_TBIT + pauses
    }

    /// The level `offset` bit times after the beginning of the first start bit.
    pub(crate) fn level(&self, offset: u64) -> bool {
        let Some(damage) = &self.damage else { return self.sent(offset) };
        let flipped = damage.flips.iter().filter(|flip| **flip == offset).count() % 2 == 1;
        let mut without_pauses = offset;
        for (place, tbit) in &damage.pauses {
            let begin = *place as u64 * CHARACTER_TBIT;
            if without_pauses >= begin + tbit {
                without_pauses -= tbit;
            } else if without_pauses >= begin {
                return !flipped;
            }
        }
        self.sent(without_pauses) != flipped
    }

    /// The level as if there were no damage.
    fn sent(&self, offset: u64) -> bool {
        let octet = self.octets.get((offset / CHARACTER_TBIT) as usize);
        octet.is_none_or(|octet| character::bits(*octet) >> (offset % CHARACTER_TBIT) & 1 == 1)
    }

    /// What an undisturbed receiver reads, with `flips` more bits inverted.
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

    fn read(tampers: &[TelegramFault]) -> Vec<(u8, bool)> {
        let signal = Signal::faulty(&TOKEN, tampers);
        signal.read(&[]).into_iter().map(|character| (character.octet, character.error)).collect()
    }

    #[test]
    fn what_is_sent_is_read() {
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
    fn octets_are_lost_and_added() {
        assert_eq!(read(&[TelegramFault::Lose(1)]), [(0xDC, false), (2, false)]);
        assert_eq!(Signal::faulty(&TOKEN, &[TelegramFault::Lose(1)]).duration_tbit(), 33);
        assert_eq!(read(&[TelegramFault::Insert(1, 0x55)]), [(0xDC, false), (0x55, false), (2, false), (2, false)]);
        assert_eq!(
            read(&[TelegramFault::Lose(9), TelegramFault::Insert(9, 1)]),
            [(0xDC, false), (2, false), (2, false), (1, false)]
        );
    }

    #[test]
    fn a_pause_moves_what_follows() {
        let signal = Signal::faulty(&TOKEN, &[TelegramFault::Pause(1, 5)]);
        assert_eq!(signal.duration_tbit(), 38);
        assert!((11..16).all(|at| signal.level(at)) && !signal.level(16));
        assert_eq!(read(&[TelegramFault::Pause(1, 5)]), [(0xDC, false), (2, false), (2, false)]);
    }
}
