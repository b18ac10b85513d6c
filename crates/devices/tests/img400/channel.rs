//! The parameter channel: the walk-throughs of BG 5530 appendices D and E, with errata-pxg55x-img400 158 and 159
//! applied.

use crate::img400::{CHANNEL, Controller, exchanging};
use crate::support::{Tester, hex};

/// The request of the master and the answer in the channel.
fn line(tester: &mut Tester<Controller>, request: &str, answer: &str) {
    let inputs = tester.exchange(&hex(request));
    assert_eq!(inputs[..8], hex(answer), "{request}");
}

/// Emission of channel 1 and 2.
fn emission(tester: &mut Tester<Controller>) -> [u8; 2] {
    [tester.get(1, 105)[0], tester.get(2, 105)[0]]
}

#[test]
fn appendix_d_reads_the_unit_of_channel_4() {
    let mut tester = exchanging(CHANNEL, 1e-5);
    line(&mut tester, "10 04 16 00 00 00 00 00 00 00", "10 04 16 00 00 00 13 08");
}

#[test]
fn appendix_e_switches_the_emission_by_transition_command() {
    // Configuration 8: TC and TV follow the parameter channel.
    let mut tester = exchanging(CHANNEL, 1e-5);
    let nothing = "00 00 00 00 00 00 00 00";
    line(&mut tester, "00 00 00 00 00 00 00 00 03 01", nothing);
    assert_eq!(emission(&mut tester), [1, 1]);
    line(&mut tester, "00 00 00 00 00 00 00 00 03 00", nothing);
    assert_eq!(emission(&mut tester), [0, 0]);
    line(&mut tester, "00 00 00 00 00 00 00 00 00 00", nothing);
    assert_eq!(emission(&mut tester), [0, 0]);
}

#[test]
fn appendix_e_switches_the_emission_by_the_parameter_channel() {
    let mut tester = exchanging(CHANNEL, 1e-5);
    line(&mut tester, "10 02 69 00 00 00 00 00 00 00", "B0 02 69 00 00 00 00 00");
    line(&mut tester, "00 02 69 00 00 00 00 00 00 00", "00 02 69 00 00 00 00 00");
    line(&mut tester, "A0 02 69 00 00 00 00 01 00 00", "B0 02 69 00 00 00 00 01");
    assert_eq!(emission(&mut tester), [0, 1]);
    line(&mut tester, "00 02 69 00 00 00 00 01 00 00", "00 02 69 00 00 00 00 00");
    line(&mut tester, "10 02 69 00 00 00 00 00 00 00", "B0 02 69 00 00 00 00 01");
    // Exception Status and the four values follow the channel.
    let inputs = tester.exchange(&hex("00 00 00 00 00 00 00 00 00 00"));
    assert_eq!(inputs.len(), 25);
    assert_eq!(inputs[8], 0xA0);
}

#[test]
fn a_task_starts_only_after_ak_0() {
    // (10)
    let mut tester = exchanging(CHANNEL, 1e-5);
    line(&mut tester, "10 00 19 00 00 00 00 00 00 00", "B0 00 19 00 00 00 00 04");
    line(&mut tester, "A0 00 CB 00 00 00 00 02 00 00", "B0 00 19 00 00 00 00 04");
    assert_eq!(tester.get(0, 203), [0]);
    line(&mut tester, "00 00 00 00 00 00 00 00 00 00", "00 00 00 00 00 00 00 00");
    line(&mut tester, "A0 00 CB 00 00 00 00 02 00 00", "B0 00 CB 00 00 00 00 02");
    assert_eq!(tester.get(0, 203), [2]);
}

#[test]
fn every_refusal_has_its_code() {
    let mut tester = exchanging(CHANNEL, 1e-5);
    for (request, answer) in [
        // No such slot, no such index: no identity, no high trip point, no channel 106 and 109, no I&M (120, 146, 148,
        // 160).
        ("10 0C 13 00 00 00 00 00 00 00", "70 0C 13 00 00 00 00 00"),
        ("10 00 11 00 00 00 00 00 00 00", "70 00 11 00 00 00 00 03"),
        ("10 00 1B 00 00 00 00 00 00 00", "70 00 1B 00 00 00 00 03"),
        ("10 05 11 00 00 00 00 00 00 00", "70 05 11 00 00 00 00 03"),
        ("10 05 12 00 00 00 00 00 00 00", "70 05 12 00 00 00 00 03"),
        ("10 01 6A 00 00 00 00 00 00 00", "70 01 6A 00 00 00 00 03"),
        ("10 01 6D 00 00 00 00 00 00 00", "70 01 6D 00 00 00 00 03"),
        ("10 03 69 00 00 00 00 00 00 00", "70 03 69 00 00 00 00 03"),
        ("10 00 FF 00 00 00 00 00 00 00", "70 00 FF 00 00 00 00 03"),
        // Not changeable, not readable.
        ("20 04 16 00 00 00 13 01 00 00", "70 04 16 00 00 00 00 01"),
        ("10 00 CD 00 00 00 00 00 00 00", "70 00 CD 00 00 00 00 12"),
        // Another width (8), no such instruction (12).
        ("20 00 CB 00 00 00 00 01 00 00", "70 00 CB 00 00 00 00 05"),
        ("A0 01 28 00 00 00 00 01 00 00", "70 01 28 00 00 00 00 05"),
        ("40 00 CB 00 00 00 00 01 00 00", "70 00 CB 00 00 00 00 12"),
        // Range, mode, already in this state, conflict (25).
        ("A0 00 CB 00 00 00 00 04 00 00", "70 00 CB 00 00 00 00 02"),
        ("A0 01 15 00 00 00 00 03 00 00", "70 01 15 00 00 00 00 11"),
        ("A0 00 0F 00 00 00 00 04 00 00", "70 00 0F 00 00 00 00 C9"),
        ("A0 00 0F 00 00 00 00 03 00 00", "70 00 0F 00 00 00 00 CA"),
        ("A0 00 0F 00 00 00 00 07 00 00", "70 00 0F 00 00 00 00 02"),
        ("20 01 0E 00 00 00 01 01 00 00", "70 01 0E 00 00 00 00 CA"),
    ] {
        line(&mut tester, request, answer);
        line(&mut tester, "00 00 00 00 00 00 00 00 00 00", "00 00 00 00 00 00 00 00");
    }
}

#[test]
fn the_channel_transfers_strings_and_records_of_one_to_four_octets() {
    // (4)
    let mut tester = exchanging(CHANNEL, 1e-5);
    for (request, answer) in [
        ("10 00 10 00 00 00 00 00 00 00", "20 00 10 00 00 01 00 00"),
        ("10 07 10 00 00 00 00 00 00 00", "20 07 10 00 00 11 00 00"),
        // Channels 1 and 2 are off, 3 and 4 below their range.
        ("10 00 CC 00 00 00 00 00 00 00", "10 00 CC 00 00 00 11 44"),
        ("20 01 0E 00 00 00 03 01 00 00", "10 01 0E 00 00 00 03 01"),
        ("10 00 CC 00 00 00 00 00 00 00", "10 00 CC 00 00 00 10 44"),
        ("10 01 67 00 00 00 00 00 00 00", "10 01 67 00 00 00 00 00"),
        ("10 01 0E 00 00 00 00 00 00 00", "10 01 0E 00 00 00 00 00"),
    ] {
        line(&mut tester, request, answer);
        line(&mut tester, "00 00 00 00 00 00 00 00 00 00", "00 00 00 00 00 00 00 00");
    }
}
