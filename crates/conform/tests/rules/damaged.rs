//! Slaves that accept damaged telegrams.

use super::faulty::Reaction;
use profivac_conform::probe::Received;
use profivac_wire::Telegram;

/// A slave that repairs one kind of damage, if nothing else is wrong with the telegram.
pub fn repaired(repair: fn(&mut Vec<u8>)) -> Box<Reaction> {
    Box::new(move |line, octets| {
        if octets.len() < 6 || Telegram::parse(octets).is_ok() {
            return line.send(octets);
        }
        let mut whole = octets.to_vec();
        repair(&mut whole);
        if Telegram::parse(&whole).is_ok() { line.send(&whole) } else { line.send(octets) }
    })
}

/// A slave that ignores the telegram after one that was cut off.
pub fn ignores_the_next() -> Box<Reaction> {
    let mut ignores = false;
    Box::new(move |line, octets| {
        let is_ignored = std::mem::replace(&mut ignores, is_cut_off(octets));
        if is_ignored { Received::Nothing } else { line.send(octets) }
    })
}

/// Whether the octets are the beginning of SD2.
fn is_cut_off(octets: &[u8]) -> bool {
    octets[0] == 0x68 && octets.get(1).is_none_or(|length| octets.len() < usize::from(*length) + 6)
}

/// Whether a damaged telegram is longer than those of the rules about each kind of damage.
pub fn is_long(octets: &[u8]) -> bool {
    octets.len() > 20 && Telegram::parse(octets).is_err()
}
