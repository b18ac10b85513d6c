//! Recognises a server that sends each FF twice, as telnet does, on a port for raw octets.
//!
//! Such a server need not send a command of telnet. Its telegrams with an FF are too long and look damaged, so a station whose answers
//! have none is found and another one never answers validly.

use profivac_wire::{MAX_TELEGRAM, Telegram};

const FF: u8 = 0xFF;
const SD2: u8 = 0x68;

/// Octets of an SD2 beside those that its length counts. profibus-wire 1.2.
const FRAME_OCTETS: usize = 6;

/// The longest telegram with each octet twice, and the octets that are kept for the next examination.
const LONGEST: usize = 2 * MAX_TELEGRAM;

/// What the octets have shown.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Verdict {
    /// No telegram with an FF was received yet.
    Open,
    /// A telegram is valid only if each pair of FF counts once.
    Doubled,
    /// A telegram with an FF is valid as it is.
    Raw,
}

/// Searches received octets for a telegram with an FF.
#[derive(Debug, Default)]
pub(super) struct DoubledFf {
    seen: Vec<u8>,
}

impl DoubledFf {
    /// Adds received octets.
    pub(super) fn examine(&mut self, octets: &[u8]) -> Verdict {
        self.seen.extend(octets);
        let verdict = if self.seen.contains(&FF) { self.verdict() } else { Verdict::Open };
        self.seen.drain(..self.seen.len().saturating_sub(LONGEST));
        verdict
    }

    fn verdict(&self) -> Verdict {
        let suffixes = (0..self.seen.len()).filter_map(|from| self.seen.get(from..));
        suffixes.map(verdict_of).find(|verdict| *verdict != Verdict::Open).unwrap_or(Verdict::Open)
    }
}

/// What the telegram shows that the octets begin with.
fn verdict_of(octets: &[u8]) -> Verdict {
    let [SD2, length, again, SD2, ..] = octets else { return Verdict::Open };
    if length != again {
        return Verdict::Open;
    }
    let length = usize::from(*length).saturating_add(FRAME_OCTETS);
    let is_valid = |octets: &[u8]| octets.contains(&FF) && Telegram::parse(octets).is_ok();
    if octets.get(..length).is_some_and(is_valid) {
        return Verdict::Raw;
    }
    if single_ffs(octets, length).is_some_and(|octets| is_valid(&octets)) { Verdict::Doubled } else { Verdict::Open }
}

/// The first `length` octets if each FF comes twice and counts once. `None` if there are fewer, or an FF is alone.
fn single_ffs(mut octets: &[u8], length: usize) -> Option<Vec<u8>> {
    let mut single = Vec::new();
    while single.len() < length {
        let (octet, rest) = match octets {
            [FF, FF, rest @ ..] => (FF, rest),
            [FF, ..] | [] => return None,
            [octet, rest @ ..] => (*octet, rest),
        };
        single.push(octet);
        octets = rest;
    }
    Some(single)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The diagnosis of a BCG450 without an owner: the address of its master is FF.
    const DIAGNOSIS: [u8; 17] =
        [0x68, 0x0B, 0x0B, 0x68, 0x82, 0x85, 0x08, 0x3E, 0x3C, 0x02, 0x05, 0x00, 0xFF, 0x08, 0xE6, 0x7D, 0x16];

    fn doubled(octets: &[u8]) -> Vec<u8> {
        octets.iter().flat_map(|octet| std::iter::repeat_n(*octet, if *octet == FF { 2 } else { 1 })).collect()
    }

    /// The verdict behind all octets, in portions of this size.
    fn verdict(octets: &[u8], portion: usize) -> Verdict {
        let mut examined = DoubledFf::default();
        let mut verdicts = octets.chunks(portion).map(|octets| examined.examine(octets));
        verdicts.find(|verdict| *verdict != Verdict::Open).unwrap_or(Verdict::Open)
    }

    #[test]
    fn a_telegram_with_an_ff_shows_whether_it_is_sent_twice() {
        let request = [0x10, 5, 2, 0x49, 0x50, 0x16];
        for portion in [1, 5, 1000] {
            let raw = [&request[..], &DIAGNOSIS].concat();
            assert_eq!(verdict(&raw, portion), Verdict::Raw);
            assert_eq!(verdict(&doubled(&raw), portion), Verdict::Doubled);
            assert_eq!(verdict(&request.repeat(200), portion), Verdict::Open);
        }
    }

    #[test]
    fn damaged_octets_show_nothing() {
        let mut damaged = doubled(&DIAGNOSIS);
        damaged[15] ^= 1;
        let alone = [&[0x68][..], &DIAGNOSIS[..12], &[0x16]].concat();
        for octets in [&damaged[..], &DIAGNOSIS[..16], &alone, &[FF; 2000], &[0x68; 2000]] {
            assert_eq!(verdict(octets, 7), Verdict::Open, "{octets:02X?}");
        }
    }

    /// The pair is in the telegram itself, as in a pressure beyond the range.
    #[test]
    fn a_pair_of_ff_in_a_valid_telegram_is_data() {
        let data = profivac_wire::DataTelegram { da: 2, sa: 5, dsap: None, ssap: None, fc: 8, du: &[FF, FF, 1] };
        let mut out = [0; MAX_TELEGRAM];
        let length = Telegram::Data(data).emit(&mut out).unwrap();
        assert_eq!(verdict(&out[..length], 1000), Verdict::Raw);
        assert_eq!(verdict(&doubled(&out[..length]), 1000), Verdict::Doubled);
    }
}
