//! The parameter channel in the cyclic data. tira36e1 2.2.1, (17) to (26).

use crate::support::{Tester, hex};
use crate::xpg400::{Gauge, KINDS, exchanging, switch};
use profivac_devices::Switch;
use profivac_devices::xpg400::Xpg400Model;

const CHANNEL: &str = "C6 87 8E 0A 0A 05 05 05 08";

/// One cycle; the answer in the channel.
fn cycle(tester: &mut Tester<Gauge>, request: &str) -> Vec<u8> {
    tester.exchange(&hex(request))[..8].to_vec()
}

/// One instruction, with AK 0 before it.
fn ask(tester: &mut Tester<Gauge>, request: &str) -> Vec<u8> {
    cycle(tester, "00 00 00 00 00 00 00 00");
    cycle(tester, request)
}

/// The sequence of 2.2.1.1: repeated until it is answered, then AK 0.
#[test]
fn the_channel_answers_one_task_until_the_master_ends_it() {
    for kind in KINDS {
        let mut tester = exchanging(kind, CHANNEL, 1e-3);
        for (request, answer) in [
            ("00 00 00 00 00 00 00 00", "00 00 00 00 00 00 00 00"),
            // Device State is EXECUTING.
            ("10 00 19 00 00 00 00 00", "B0 00 19 00 00 00 00 04"),
            ("10 00 19 00 00 00 00 00", "B0 00 19 00 00 00 00 04"),
            // Changed without AK 0: not started, the old answer stays (25).
            ("A0 01 2E 00 00 00 00 02", "B0 00 19 00 00 00 00 04"),
            ("00 01 2E 00 00 00 00 00", "00 01 2E 00 00 00 00 00"),
            // Select the ionisation part, and give it 1.5 mbar for a Safe Value.
            ("A0 01 2E 00 00 00 00 02", "B0 01 2E 00 00 00 00 02"),
            ("00 00 00 00 00 00 00 00", "00 00 00 00 00 00 00 00"),
            ("30 01 28 00 3F C0 00 00", "20 01 28 00 3F C0 00 00"),
            ("00 00 00 00 00 00 00 00", "00 00 00 00 00 00 00 00"),
            // Full scale adjustment, then set point B: relay open at 0 V.
            ("A0 01 0F 00 00 00 00 01", "B0 01 0F 00 00 00 00 01"),
            ("A0 01 0F 00 00 00 00 01", "B0 01 0F 00 00 00 00 01"),
            ("00 00 00 00 00 00 00 00", "00 00 00 00 00 00 00 00"),
            ("A0 01 2E 00 00 00 00 04", "B0 01 2E 00 00 00 00 04"),
            ("00 00 00 00 00 00 00 00", "00 00 00 00 00 00 00 00"),
            ("10 01 14 00 00 00 00 00", "B0 01 14 00 00 00 00 00"),
        ] {
            assert_eq!(cycle(&mut tester, request), hex(answer), "{request}");
        }
    }
}

/// 2.2.1.3, (23)
#[test]
fn every_error_code_has_its_access() {
    for (request, code) in [
        // 0: no such slot
        ("10 02 10 00 00 00 00 00", 0),
        // 3: no such index, or not for the selected instance
        ("10 00 0E 00 00 00 00 00", 3),
        ("10 01 69 00 00 00 00 00", 3),
        // 1: read only
        ("A0 00 19 00 00 00 00 04", 1),
        // 5: a text, a record, a word for a byte
        ("10 00 11 00 00 00 00 00", 5),
        ("10 00 1B 00 00 00 00 00", 5),
        ("20 01 2E 00 00 00 00 01", 5),
        // 2: out of range
        ("A0 01 2E 00 00 00 00 05", 2),
        // 17: not during the exchange
        ("A0 01 15 00 00 00 00 03", 17),
        ("20 01 16 00 00 00 05 15", 17),
        // 201: already in this state; 202: not in this state
        ("A0 00 0F 00 00 00 00 04", 201),
        ("A0 00 0F 00 00 00 00 03", 202),
        // 18: no such instruction, reading a command
        ("40 00 19 00 00 00 00 00", 18),
        ("10 01 0F 00 00 00 00 00", 18),
    ] {
        for kind in KINDS {
            let mut tester = exchanging(kind, CHANNEL, 1e-3);
            let octets = hex(request);
            assert_eq!(cycle(&mut tester, request), [0x70, octets[1], octets[2], 0, 0, 0, 0, code], "{request}");
        }
    }
}

/// (19), (20), (21)
#[test]
fn arrays_and_command_records_are_right_aligned() {
    let mut tester = exchanging(Xpg400Model::Bpg, CHANNEL, 1e-6);
    tester.fault("pirani-adjust", true);
    for (request, answer) in [
        ("10 00 CD 00 00 00 00 00", "20 00 CD 00 00 00 00 00"),
        ("10 00 D0 00 00 00 00 00", "20 00 D0 00 00 02 00 00"),
        ("10 00 CC 00 00 00 00 00", "B0 00 CC 00 00 00 00 00"),
        // The block type is allowed.
        ("10 00 10 00 00 00 00 00", "20 00 10 00 00 01 00 00"),
        ("A0 01 2E 00 00 00 00 02", "B0 01 2E 00 00 00 00 02"),
        // Degas on and off: command, value.
        ("20 01 0E 00 00 00 01 01", "10 01 0E 00 00 00 01 01"),
        ("10 01 6D 00 00 00 00 00", "B0 01 6D 00 00 00 00 03"),
        ("10 01 6A 00 00 00 00 00", "20 01 6A 00 41 A0 00 00"),
        ("20 01 0E 00 00 00 01 00", "10 01 0E 00 00 00 01 00"),
        ("10 01 6D 00 00 00 00 00", "B0 01 6D 00 00 00 00 00"),
    ] {
        assert_eq!(ask(&mut tester, request), hex(answer), "{request}");
    }
}

/// (38): the switchover is a float or a word, depending on the configuration.
#[test]
fn the_side_switches_are_read_through_the_channel() {
    let mut tester = exchanging(Xpg400Model::Hpg, CHANNEL, 1e-3);
    switch(&mut tester, Switch::LowHigh(3)).unwrap();
    switch(&mut tester, Switch::CalAdj(8)).unwrap();
    assert_eq!(ask(&mut tester, "10 00 CA 00 00 00 00 00"), hex("20 00 CA 00 3F 00 00 00"));
    assert_eq!(ask(&mut tester, "10 00 CB 00 00 00 00 00"), hex("B0 00 CB 00 00 00 00 08"));
    tester.bring_up(&hex("00 00 00 03 E9"), &hex("C6 87 8C 0A 0A 05 05 05 03"));
    assert_eq!(ask(&mut tester, "10 00 CA 00 00 00 00 00"), hex("10 00 CA 00 00 00 6D E4"));
}
