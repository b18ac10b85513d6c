//! The parameter channel in the cyclic data. tira41d1 2.2.1, (17) to (26).

use crate::bcg450::{Gauge, exchanging};
use crate::support::{Tester, hex};

const CHANNEL: &str = "C6 87 8E 0A 0A 05 05 05 08";

/// One cycle; the answer in the channel.
fn cycle(tester: &mut Tester<Gauge>, request: &str) -> Vec<u8> {
    tester.exchange(&hex(request))[..8].to_vec()
}

#[test]
fn the_channel_answers_one_task_until_the_master_ends_it() {
    let mut tester = exchanging(CHANNEL, 1e-3);
    for (request, answer) in [
        // No task.
        ("00 00 00 00 00 00 00 00", "00 00 00 00 00 00 00 00"),
        // Device State is EXECUTING.
        ("10 00 19 00 00 00 00 00", "B0 00 19 00 00 00 00 04"),
        ("10 00 19 00 00 00 00 00", "B0 00 19 00 00 00 00 04"),
        // Changed without AK 0: not started, the old answer stays (25).
        ("A0 01 2E 00 00 00 00 03", "B0 00 19 00 00 00 00 04"),
        ("00 01 2E 00 00 00 00 00", "00 01 2E 00 00 00 00 00"),
        // Select the diaphragm, and read the selector.
        ("A0 01 2E 00 00 00 00 03", "B0 01 2E 00 00 00 00 03"),
        ("00 00 00 00 00 00 00 00", "00 00 00 00 00 00 00 00"),
        ("10 01 2E 00 00 00 00 00", "B0 01 2E 00 00 00 00 03"),
        ("00 00 00 00 00 00 00 00", "00 00 00 00 00 00 00 00"),
        // Safe Value 1.5 mbar as a double word, Percentage as a word of set point B.
        ("30 01 28 00 3F C0 00 00", "20 01 28 00 3F C0 00 00"),
        ("00 00 00 00 00 00 00 00", "00 00 00 00 00 00 00 00"),
        ("A0 01 2E 00 00 00 00 06", "B0 01 2E 00 00 00 00 06"),
        ("00 00 00 00 00 00 00 00", "00 00 00 00 00 00 00 00"),
        ("20 01 CA 00 00 00 01 F4", "10 01 CA 00 00 00 01 F4"),
        ("00 00 00 00 00 00 00 00", "00 00 00 00 00 00 00 00"),
        ("10 01 CA 00 00 00 00 00", "10 01 CA 00 00 00 01 F4"),
    ] {
        assert_eq!(cycle(&mut tester, request), hex(answer), "{request}");
    }
}

/// (24): the device ignores bits 11 to 8, the reserved octet and unused octets of the value.
#[test]
fn reserved_octets_and_bits_have_no_effect() {
    let mut tester = exchanging(CHANNEL, 1e-3);
    assert_eq!(cycle(&mut tester, "AF 01 2E FF 11 22 33 02"), hex("B0 01 2E 00 00 00 00 02"));
    tester.put(1, 46, &[5]).unwrap();
    assert_eq!(cycle(&mut tester, "A0 01 2E 00 44 55 66 02"), hex("B0 01 2E 00 00 00 00 02"));
    assert_eq!(tester.get(1, 46), [5], "the same instruction, done once");
}

/// (25): a write is executed once; a read is answered with the present value.
#[test]
fn a_repeated_write_is_executed_once_and_a_repeated_read_each_time() {
    let mut tester = exchanging(CHANNEL, 1e-3);
    let stop = "A0 00 0F 00 00 00 00 05";
    assert_eq!(cycle(&mut tester, stop), hex("B0 00 0F 00 00 00 00 05"));
    tester.command(4).unwrap();
    assert_eq!(cycle(&mut tester, stop), hex("B0 00 0F 00 00 00 00 05"));
    assert_eq!(tester.state(), 4, "the repetition does nothing");
    cycle(&mut tester, "00 00 00 00 00 00 00 00");
    assert_eq!(cycle(&mut tester, "10 00 19 00 00 00 00 00"), hex("B0 00 19 00 00 00 00 04"));
    tester.command(5).unwrap();
    assert_eq!(cycle(&mut tester, "10 00 19 00 00 00 00 00"), hex("B0 00 19 00 00 00 00 02"));
}

/// (25): in data exchange the same configuration once more begins no task again.
#[test]
fn a_repeated_chk_cfg_executes_no_write_again() {
    let mut tester = exchanging(CHANNEL, 1e-3);
    let stop = "A0 00 0F 00 00 00 00 05";
    assert_eq!(cycle(&mut tester, stop), hex("B0 00 0F 00 00 00 00 05"));
    tester.command(4).unwrap();
    tester.chk_cfg(&hex(CHANNEL));
    assert_eq!(cycle(&mut tester, stop), hex("B0 00 0F 00 00 00 00 05"), "the answer stays");
    assert_eq!(tester.state(), 4, "the repetition does nothing");
}

/// 2.2.1.3, (23)
#[test]
fn every_error_code_has_its_access() {
    for (request, code) in [
        // 0: no such slot
        ("10 02 10 00 00 00 00 00", 0),
        // 3: no such index, or not for the selected instance
        ("10 00 0E 00 00 00 00 00", 3),
        ("10 01 0E 00 00 00 00 00", 3),
        // 1: read only
        ("A0 00 19 00 00 00 00 04", 1),
        // 5: a text, a record, a word for a byte
        ("10 00 11 00 00 00 00 00", 5),
        ("10 00 1B 00 00 00 00 00", 5),
        ("20 01 2E 00 00 00 00 01", 5),
        // 2: out of range
        ("A0 01 2E 00 00 00 00 07", 2),
        // 17: not during the exchange
        ("A0 01 15 00 00 00 00 03", 17),
        ("20 01 16 00 00 00 05 15", 17),
        // 201: already in this state; 202: not in this state
        ("A0 00 0F 00 00 00 00 04", 201),
        ("A0 00 0F 00 00 00 00 03", 202),
        // 18: no such instruction
        ("40 00 19 00 00 00 00 00", 18),
        ("F0 00 19 00 00 00 00 00", 18),
    ] {
        let mut tester = exchanging(CHANNEL, 1e-3);
        let octets = hex(request);
        assert_eq!(cycle(&mut tester, request), [0x70, octets[1], octets[2], 0, 0, 0, 0, code], "{request}");
    }
    // 18: reading a command
    let mut tester = exchanging(CHANNEL, 1e-3);
    tester.put(1, 46, &[2]).unwrap();
    assert_eq!(cycle(&mut tester, "10 01 0E 00 00 00 00 00"), hex("70 01 0E 00 00 00 00 12"));
}

/// (20), (21)
#[test]
fn arrays_and_command_records_are_right_aligned() {
    let mut tester = exchanging(CHANNEL, 1e-3);
    tester.fault("pirani-adjust", true);
    tester.fault("sensor2", true);
    for (request, answer) in [
        ("10 00 CD 00 00 00 00 00", "20 00 CD 00 00 00 00 00"),
        ("10 00 CE 00 00 00 00 00", "10 00 CE 00 00 00 00 02"),
        ("10 00 D1 00 00 00 00 00", "20 00 D1 00 01 00 00 00"),
        ("10 00 D2 00 00 00 00 00", "20 00 D2 00 00 02 00 00"),
        // The block type is allowed (19).
        ("10 00 10 00 00 00 00 00", "20 00 10 00 00 01 00 00"),
        ("A0 01 2E 00 00 00 00 02", "B0 01 2E 00 00 00 00 02"),
        ("20 01 0E 00 00 00 80 00", "10 01 0E 00 00 00 80 00"),
        ("10 01 C9 00 00 00 00 00", "B0 01 C9 00 00 00 00 00"),
    ] {
        cycle(&mut tester, "00 00 00 00 00 00 00 00");
        assert_eq!(cycle(&mut tester, request), hex(answer), "{request}");
    }
}

/// (101): a master in Clear sends no task.
#[test]
fn clear_counts_as_ak_0() {
    let mut tester = exchanging(CHANNEL, 1e-3);
    let select = "A0 01 2E 00 00 00 00 03";
    cycle(&mut tester, select);
    tester.put(1, 46, &[5]).unwrap();
    tester.request_sdn(&[0x02, 0x00]);
    assert_eq!(cycle(&mut tester, select), hex("B0 01 2E 00 00 00 00 03"));
    assert_eq!(tester.get(1, 46), [3], "a new instruction after AK 0");
}
