//! Slaves that accept damaged telegrams.

use super::faulty::Reaction;
use profivac_conform::probe::Received;
use profivac_wire::Telegram;

/// A slave that repairs one kind of damage, if nothing else is wrong with the telegram.
pub fn repaired(repair: fn(&mut Vec<u8>)) -> Box<Reaction> {
    Box::new(move |line, octets| {
        if octets.len() < 6 || Telegram::parse(octets).is_ok() {
            return line.hear(octets);
        }
        let mut whole = octets.to_vec();
        repair(&mut whole);
        if Telegram::parse(&whole).is_ok() { line.hear(&whole) } else { line.hear(octets) }
    })
}

/// A slave that hears nothing for a telegram after one that was cut off.
pub fn deaf() -> Box<Reaction> {
    let mut deaf = false;
    Box::new(move |line, octets| {
        let was_deaf = std::mem::replace(&mut deaf, is_cut_off(octets));
        if was_deaf { Received::Nothing } else { line.hear(octets) }
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
