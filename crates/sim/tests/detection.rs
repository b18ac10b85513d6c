//! A receiver rejects every telegram with up to three inverted bits. profibus-wire 1.1 and 1.7.
//!
//! The tests invert every pattern of bits of the characters, including start, parity and stop bits, so a lost start bit
//! shifts the bits that are read, as on a line. SD4 has no check octet: the golden file lists the patterns that are accepted.

#![allow(clippy::unwrap_used, clippy::panic, reason = "a test")]

use crate::golden;

use golden::compare;
use profivac_dp::link::{BitTime, CHARACTER_TBIT, Received, Receiver};
use profivac_sim::Random;
use profivac_sim::character::{self, Uart};
use profivac_sim::describe::Hex;
use profivac_sim::dialogue::hex;
use profivac_wire::{MAX_TELEGRAM, Telegram};
use std::fmt::Write as _;

/// Idle before and after the telegram, enough for the last shifted character to end.
const IDLE: usize = 40;

/// A telegram as levels, with idle line around it.
fn levels(octets: &[u8]) -> Vec<bool> {
    let bits = octets.iter().flat_map(|octet| (0..CHARACTER_TBIT).map(|bit| character::bits(*octet) >> bit & 1 == 1));
    std::iter::repeat_n(true, IDLE).chain(bits).chain(std::iter::repeat_n(true, IDLE)).collect()
}

/// Feeds levels to a receiver; `accepted` gets every telegram that it accepts.
fn play(levels: &[bool], mut accepted: impl FnMut(&Telegram<'_>)) {
    let mut uart = Uart::default();
    let mut receiver = Receiver::new(BitTime(0));
    for (level, end) in levels.iter().zip(1..) {
        match uart.level(*level) {
            Some(character) if character.error => receiver.character_error(BitTime(end)),
            Some(character) => {
                if let Received::Telegram(telegram) = receiver.octet(BitTime(end), character.octet) {
                    accepted(&telegram);
                }
            }
            None => {}
        }
    }
}

fn emitted(telegram: &Telegram<'_>) -> Vec<u8> {
    let mut octets = [0; MAX_TELEGRAM];
    let length = telegram.emit(&mut octets).unwrap();
    octets[..length].to_vec()
}

/// The accepted telegrams with these bits inverted.
fn accepted(levels: &mut [bool], flips: &[usize]) -> Vec<Vec<u8>> {
    let mut all = Vec::new();
    flip(levels, flips);
    play(levels, |telegram| all.push(emitted(telegram)));
    flip(levels, flips);
    all
}

fn flip(levels: &mut [bool], flips: &[usize]) {
    flips.iter().for_each(|bit| levels[IDLE + bit] ^= true);
}

/// Calls `each` with every choice of one, two and three of `bits`.
fn up_to_three(bits: usize, mut each: impl FnMut(&[usize])) {
    for first in 0..bits {
        each(&[first]);
        for second in first + 1..bits {
            each(&[first, second]);
            for third in second + 1..bits {
                each(&[first, second, third]);
            }
        }
    }
}

/// Every pattern of up to three bits is rejected. Returns how many there are.
fn exhaustive(text: &str) -> u64 {
    let octets = hex(text);
    let mut levels = levels(&octets);
    assert_eq!(accepted(&mut levels, &[]), [emitted(&Telegram::parse(&octets).unwrap())], "{text} without damage");
    let mut patterns = 0;
    up_to_three(octets.len() * 11, |flips| {
        patterns += 1;
        let accepted = accepted(&mut levels, flips);
        assert!(accepted.is_empty(), "{text} with bits {flips:?} flipped is {}", Hex(&accepted.concat()));
    });
    patterns
}

#[test]
fn every_pattern_of_sc_is_rejected() {
    assert_eq!(exhaustive("E5"), 11 + 55 + 165);
}

#[test]
fn every_pattern_of_sd1_is_rejected() {
    for text in [
        "10 08 02 49 53 16", // FDL status
        "10 02 08 00 0A 16", // its answer
        "10 08 02 5D 67 16", // Data_Exchange without outputs
        "10 02 08 03 0D 16", // RS
        "10 02 08 0A 14 16", // DH without inputs
        "10 00 01 00 01 16", // the most zeros that a telegram can have
        "10 7E 7F 6F 6C 16", // the most ones
    ] {
        assert_eq!(exhaustive(text), 66 + 2145 + 45_760);
    }
}

#[test]
fn every_pattern_of_sd2_is_rejected() {
    for text in [
        "68 05 05 68 88 82 6D 3C 3E F1 16",                      // Slave_Diag
        "68 05 05 68 08 02 7D AA 55 86 16",                      // Data_Exchange
        "68 05 05 68 02 08 08 01 02 15 16",                      // its answer
        "68 05 05 68 02 08 08 FF FF 10 16",                      // the same with all bits set
        "68 05 05 68 02 08 08 00 00 12 16",                      // and with none
        "68 07 07 68 FF 82 46 3A 3E 00 00 3F 16",                // Global_Control
        "68 07 07 68 88 82 7D 3E 3E 11 21 35 16",                // Chk_Cfg
        "68 0C 0C 68 88 82 5D 3D 3E 88 0A 0A 0B 12 34 01 D0 16", // Set_Prm
    ] {
        exhaustive(text);
    }
}

#[test]
fn every_pattern_of_sd3_is_rejected() {
    assert_eq!(exhaustive("A2 08 02 7D 01 02 03 04 05 06 07 08 AB 16"), 154 + 11_781 + 596_904);
}

#[test]
fn a_telegram_inside_the_data_of_another_is_never_accepted() {
    for text in [
        // Data_Exchange whose outputs are an FDL status to the same slave, alone and with SC on both sides.
        "68 09 09 68 08 02 7D 10 08 02 49 53 16 53 16",
        "68 0B 0B 68 08 02 7D E5 10 08 02 49 53 16 E5 1D 16",
        // Data_Exchange whose outputs are another Data_Exchange.
        "68 0E 0E 68 08 02 7D 68 05 05 68 08 02 7D AA 55 86 16 83 16",
    ] {
        exhaustive(text);
    }
}

#[test]
fn sampled_patterns_of_long_telegrams_are_rejected() {
    const SEED: u64 = 20_260_801;
    println!("seed {SEED}");
    let mut random = Random::new(SEED);
    for _ in 0..400 {
        let du: Vec<u8> = (0..1 + random.below(244)).map(|_| random.octet()).collect();
        let telegram = profivac_wire::DataTelegram { da: 8, sa: 2, dsap: Some(51), ssap: Some(51), fc: 0x5C, du: &du };
        let octets = emitted(&Telegram::Data(telegram));
        let mut levels = levels(&octets);
        for _ in 0..100 {
            let flips: Vec<usize> = (0..3).map(|_| random.below(octets.len() as u64 * 11) as usize).collect();
            let accepted = accepted(&mut levels, &flips);
            // Two of the three may be the same bit: then only one is inverted.
            assert!(accepted.is_empty(), "{} with bits {flips:?} flipped", Hex(&octets));
        }
    }
}

/// A token has no check octet. The golden file lists the accepted patterns: two bits of one character suffice for another
/// address. The token rules handle them (profibus-wire 1.13: addresses from 127 on are rejected, a foreign token is ignored).
#[test]
fn accepted_damaged_tokens_match_the_golden_list() {
    let octets = hex("DC 02 02");
    let mut levels = levels(&octets);
    let mut list = String::from(
        "# DC 02 02 with up to three flipped bits: the bits, counted from the first start bit, and what is heard.\n",
    );
    up_to_three(33, |flips| {
        for telegram in accepted(&mut levels, flips) {
            let bits = flips.iter().map(|bit| format!("{bit:2}")).collect::<Vec<_>>().join(" ");
            writeln!(list, "{bits:8}  {}", Hex(&telegram)).unwrap();
        }
    });
    compare("crates/sim/tests/detection-token.txt", &list);
}
