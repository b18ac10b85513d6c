//! Telegrams octet by octet.

use crate::telegram;
use profivac_dp::link::{BitTime, CHARACTER_TBIT, Received, Receiver, T_SYN_TBIT};
use std::hint::black_box;

/// One telegram after the other, each after T_SYN, without gaps inside.
pub fn receive_each(times: u32) {
    let octets = telegram::octets();
    let mut receiver = Receiver::new(BitTime(0));
    let mut now = BitTime(0);
    for _ in 0..times {
        now = now + T_SYN_TBIT;
        for octet in &octets {
            now = now + CHARACTER_TBIT;
            if let Received::Telegram(telegram) = receiver.octet(now, *octet) {
                black_box(telegram);
            }
        }
    }
}

/// The same, but a telegram comes in one piece, as a port or a DMA buffer has it.
pub fn receive_piece(times: u32) {
    let octets = telegram::octets();
    let mut receiver = Receiver::new(BitTime(0));
    let mut now = BitTime(0);
    for _ in 0..times {
        now = now + T_SYN_TBIT + CHARACTER_TBIT;
        let _ = black_box(receiver.octets(now, black_box(&octets)));
        now = now + CHARACTER_TBIT * 40;
    }
}

/// The same, but a telegram comes in pieces of eight, as a small FIFO has it.
pub fn receive_pieces(times: u32) {
    let octets = telegram::octets();
    let mut receiver = Receiver::new(BitTime(0));
    let mut now = BitTime(0);
    for _ in 0..times {
        now = now + T_SYN_TBIT;
        for piece in octets.chunks(8) {
            let _ = black_box(receiver.octets(now + CHARACTER_TBIT, black_box(piece)));
            now = now + CHARACTER_TBIT * piece.len() as u64;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_last_octet_completes_the_telegram() {
        let octets = telegram::octets();
        let mut receiver = Receiver::new(BitTime(0));
        let mut telegrams = 0;
        for (position, octet) in (1..).zip(&octets) {
            let end = BitTime(T_SYN_TBIT + position * CHARACTER_TBIT);
            telegrams += u32::from(matches!(receiver.octet(end, *octet), Received::Telegram(_)));
        }
        assert_eq!(telegrams, 1);
    }

    #[test]
    fn the_last_piece_completes_the_telegram() {
        let mut receiver = Receiver::new(BitTime(0));
        let mut first = BitTime(T_SYN_TBIT + CHARACTER_TBIT);
        let mut heard = Vec::new();
        for piece in telegram::octets().chunks(8) {
            let (taken, said) = receiver.octets(first, piece);
            assert_eq!(taken, piece.len());
            heard.push(matches!(said, Received::Telegram(_)));
            first = first + CHARACTER_TBIT * piece.len() as u64;
        }
        assert_eq!(heard, [false, false, false, false, false, true]);
    }
}
