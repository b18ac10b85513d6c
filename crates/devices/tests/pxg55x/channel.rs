//! The parameter channel, as far as it differs from the BCG450: 4.3, (1) to (12), (53), (54). The tests of the BCG450 cover
//! the common rules.

use crate::pxg55x::{CHANNEL, Gauge, exchanging, float, of_instance, pcg};
use crate::support::{Tester, hex};

/// An instruction after AK 0, and its answer.
fn instruct(tester: &mut Tester<Gauge>, request: &str) -> Vec<u8> {
    tester.channel(hex(request).try_into().unwrap()).to_vec()
}

/// 4.3.1: every instruction signature, with the response signature beside it in the table.
#[test]
fn every_length_has_its_ak() {
    let mut tester = exchanging(pcg(), CHANNEL, 100.0);
    for (request, answer) in [
        // Read: a byte, a word, a double word. Device State, Data Unit (class 2 only: 3), Process Value.
        ("10 00 19 00 00 00 00 00", "B0 00 19 00 00 00 00 04"),
        ("10 01 16 00 00 00 00 00", "10 01 16 00 00 00 13 08"),
        ("10 01 13 00 00 00 00 00", "20 01 13 00 42 C8 00 00"),
        // Arrays and the block type have a length that fits (4).
        ("10 00 CD 00 00 00 00 00", "20 00 CD 00 00 00 00 00"),
        ("10 02 10 00 00 00 00 00", "20 02 10 00 00 11 00 00"),
        // Write: a double word (53), a byte, a word.
        ("30 02 13 00 43 48 00 00", "20 02 13 00 43 48 00 00"),
        ("10 02 15 00 00 00 00 00", "B0 02 15 00 00 00 00 01"),
        ("A0 02 14 00 00 00 00 00", "B0 02 14 00 00 00 00 00"),
        ("20 01 0F 00 00 00 FF 00", "10 01 0F 00 00 00 FF 00"),
    ] {
        assert_eq!(instruct(&mut tester, request), hex(answer), "{request}");
    }
}

/// 4.3.3: the error codes in octets 7 and 8, counted from 1 (1).
#[test]
fn every_refusal_has_its_error_code() {
    let mut tester = exchanging(pcg(), CHANNEL, 100.0);
    for (request, code) in [
        // Undefined slot, and an index that does not exist (7).
        ("10 06 10 00 00 00 00 00", 0),
        ("10 01 0E 00 00 00 00 00", 3),
        // Read-only; width; range.
        ("A0 00 1A 00 00 00 00 00", 1),
        ("20 02 14 00 00 00 00 01", 5),
        ("A0 02 14 00 00 00 00 02", 2),
        ("A0 02 CA 00 00 00 00 03", 2),
        // Texts have a separate code (6); records are too long.
        ("10 00 11 00 00 00 00 00", 13),
        ("10 00 17 00 00 00 00 00", 13),
        ("10 00 1B 00 00 00 00 00", 5),
        // Unit and data type during the exchange.
        ("20 01 16 00 00 00 13 01", 17),
        ("A0 03 1D 00 00 00 00 03", 17),
        // Execute in EXECUTING, Recover there.
        ("A0 00 0F 00 00 00 00 04", 201),
        ("A0 00 0F 00 00 00 00 03", 202),
        // No instruction (12).
        ("40 00 19 00 00 00 00 00", 18),
        ("F0 00 19 00 00 00 00 00", 18),
    ] {
        let answer = instruct(&mut tester, request);
        assert_eq!((answer[0], &answer[4..]), (0x70, &[0, 0, 0, code][..]), "{request}");
        assert_eq!(answer[1..3], hex(request)[1..3], "slot and index are repeated (9)");
    }
}

/// (10): a repeated instruction is executed once; otherwise the device would adjust in every cycle.
#[test]
fn a_repeated_task_adjusts_once() {
    let mut tester = exchanging(pcg(), CHANNEL, 100.0);
    let zero = hex("20 01 0F 00 00 00 00 00");
    assert_eq!(tester.exchange(&zero)[..8], hex("10 01 0F 00 00 00 00 00"));
    assert_eq!(float(&mut tester, 1, 19), 0.0);
    tester.pressure_mbar(150.0);
    assert_eq!(tester.exchange(&zero)[..8], hex("10 01 0F 00 00 00 00 00"));
    assert_eq!(float(&mut tester, 1, 19), 50.0);
    tester.exchange(&[0; 8]);
    tester.exchange(&zero);
    assert_eq!(float(&mut tester, 1, 19), 0.0);
}

/// "The slave keeps transmitting the response": for a read, with the present value (10).
#[test]
fn a_read_task_shows_the_present_value_in_every_cycle() {
    let mut tester = exchanging(pcg(), CHANNEL, 100.0);
    let read = hex("10 01 13 00 00 00 00 00");
    assert_eq!(tester.exchange(&read)[4..8], 100f32.to_be_bytes());
    tester.pressure_mbar(200.0);
    assert_eq!(tester.exchange(&read)[4..8], 200f32.to_be_bytes());
    // Another instance in the meantime.
    tester.put(1, 46, &[3]).unwrap();
    assert_eq!(tester.exchange(&read)[4..8], 1013.25f32.to_be_bytes());
    assert_eq!(of_instance(&mut tester, 3, 22), hex("13 08"));
}
