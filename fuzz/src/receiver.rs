//! The receiver: octets with pauses and character errors.
//!
//! The same octets one by one and in pieces give the same telegrams; each telegram is one that `Telegram::parse` accepts and
//! that `emit` writes with the same octets.

use crate::script::Script;
use profivac_dp::link::{BitTime, CHARACTER_TBIT, Received, Receiver};
use profivac_wire::{MAX_TELEGRAM, Telegram};

/// What a receiver says: the octets of a telegram, or none for damage.
type Said = (usize, Option<Vec<u8>>);

/// Passes a piece to the receiver one by one and returns what it says, by the position of the octet.
fn each(receiver: &mut Receiver, first: BitTime, piece: &[u8], at: usize, said: &mut Vec<Said>) {
    let mut end = first;
    for (position, octet) in piece.iter().enumerate() {
        note(receiver.octet(end, *octet), at + position, said);
        end = end + CHARACTER_TBIT;
    }
}

/// The same in one call, as far as the receiver takes the octets at once.
fn whole(receiver: &mut Receiver, first: BitTime, piece: &[u8], at: usize, said: &mut Vec<Said>) {
    let (mut end, mut rest, mut at) = (first, piece, at);
    while !rest.is_empty() {
        let (taken, received) = receiver.octets(end, rest);
        assert!((1..=rest.len()).contains(&taken), "the receiver takes {taken} of {} octets", rest.len());
        note(received, at + taken - 1, said);
        rest = &rest[taken..];
        at += taken;
        end = end + CHARACTER_TBIT * taken as u64;
    }
}

fn note(received: Received<'_>, at: usize, said: &mut Vec<Said>) {
    match received {
        Received::Nothing => {}
        Received::Damaged(_) => said.push((at, None)),
        Received::Telegram(telegram) => {
            let mut octets = [0; MAX_TELEGRAM];
            let length = telegram.emit(&mut octets).expect("a received telegram can be sent");
            assert_eq!(Telegram::parse(&octets[..length]), Ok(telegram));
            said.push((at, Some(octets[..length].to_vec())));
        }
    }
}

/// Runs the target.
pub fn run(octets: &[u8]) {
    let mut script = Script::new(octets);
    let idle_tbit = script.one_of(&[33, 33, 11, 500, 10_000, u64::MAX]);
    let [mut one, mut other] = [0, 1].map(|_| Receiver::with_idle(BitTime(0), idle_tbit));
    let (mut now, mut at) = (BitTime(0), 0);
    let (mut by_octet, mut by_piece) = (Vec::new(), Vec::new());
    while let Some(kind) = script.octet() {
        match kind >> 6 {
            0 => now = now + script.pause_tbit(),
            1 if kind & 1 == 0 => [&mut one, &mut other].into_iter().for_each(|receiver| receiver.character_error(now)),
            1 => [&mut one, &mut other].into_iter().for_each(|receiver| receiver.own_telegram(now)),
            _ => {
                let piece = script.take(usize::from(kind & 0x7F) + 1);
                each(&mut one, now + CHARACTER_TBIT, piece, at, &mut by_octet);
                whole(&mut other, now + CHARACTER_TBIT, piece, at, &mut by_piece);
                now = now + CHARACTER_TBIT * piece.len() as u64;
                at += piece.len();
            }
        }
    }
    assert_eq!(by_octet, by_piece, "one by one, and in pieces");
    assert_eq!(one.damaged(), other.damaged());
}
