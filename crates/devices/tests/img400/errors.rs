//! Exception Status, Channel Status and Reset Error Condition. BG 5530 4.4.1; errata-pxg55x-img400 35 to 38, 121 to
//! 128.

use crate::img400::{COMMANDS, Controller, FLOATS, exchanging};
use crate::support::Tester;
use profivac_devices::SimulatedDevice;

/// All gauges are on and in their ranges: no exception.
fn quiet() -> Tester<Controller> {
    let mut tester = exchanging(COMMANDS, 1.0);
    tester.device().sense(0, 5e-4);
    tester.device().sense(1, 5e-4);
    assert_eq!(tester.exchange(&[3, 1])[0], 0x80);
    tester
}

fn status(tester: &mut Tester<Controller>) -> u8 {
    let parameter = tester.get(0, 26)[0];
    // The cyclic octet is the parameter.
    assert_eq!(tester.exchange(&[0, 0])[0], parameter);
    parameter
}

#[test]
fn common_faults_set_alarm_and_warning_and_go_with_the_cause() {
    // (37): bits 0 and 4
    for name in ["eeprom", "ram", "eprom", "comm"] {
        let mut tester = quiet();
        tester.fault(name, true);
        assert_eq!(status(&mut tester), 0x91, "{name}");
        // Safe State on all channels (35), and Reading Valid does not change, by the wording of the manual (125).
        assert_eq!(tester.exchange(&[0, 0])[1..17], [0; 16], "{name}");
        tester.fault(name, false);
        assert_eq!(status(&mut tester), 0x80, "{name}");
    }
}

#[test]
fn a_supply_error_stays_until_alarm_and_warning_are_reset() {
    // (122): bits 2 and 6; bit 1 by the sensor alarms, bit 5 because every reading is invalid.
    for (name, alarm, warning) in [
        ("power", 0x01, 0x02),
        ("electronics3", 0x01, 0x02),
        ("electronics4", 0x01, 0x02),
        ("sensor1", 0x04, 0x08),
        ("electronics2", 0x04, 0x08),
    ] {
        let mut tester = quiet();
        tester.fault(name, true);
        assert_eq!(status(&mut tester), 0xE6, "{name}");
        // The cause persists, so the error comes back (128).
        tester.put(0, 205, &[0xFF]).unwrap();
        assert_eq!(status(&mut tester), 0xE6, "{name}");
        tester.fault(name, false);
        assert_eq!(status(&mut tester), 0xE6, "{name}");
        for other in [0x40, 0x20, if alarm == 1 { 0x0C } else { 0x03 }] {
            tester.put(0, 205, &[other]).unwrap();
            assert_eq!(status(&mut tester), 0xE6, "{name} after {other:02X}");
        }
        tester.put(0, 205, &[alarm]).unwrap();
        assert_eq!(status(&mut tester), 0xE0, "{name}: only the warning");
        tester.put(0, 205, &[warning]).unwrap();
        let off = status(&mut tester);
        // A gauge stays off: emission, or the supply of channels 3 and 4.
        assert_eq!(off, 0xA0, "{name}");
        tester.put(0, 205, &[0x10]).unwrap();
        tester.exchange(&[0, 0]);
        tester.exchange(&[3, 1]);
        assert_eq!(status(&mut tester), 0x80, "{name}");
    }
}

#[test]
fn channels_3_and_4_have_no_supply_until_a_reset_with_bit_4() {
    let mut tester = quiet();
    tester.fault("power", true);
    assert_eq!(tester.get(0, 204), [0x11, 0x11], "no reading is valid");
    tester.fault("power", false);
    tester.put(0, 205, &[0x03]).unwrap();
    assert_eq!(tester.get(0, 204), [0x00, 0x11], "3 and 4 are off");
    tester.put(0, 205, &[0x80]).unwrap();
    assert_eq!(tester.get(0, 204), [0x00, 0x11]);
    tester.put(0, 205, &[0x10]).unwrap();
    assert_eq!(tester.get(0, 204), [0x00, 0x00]);
}

#[test]
fn bit_7_resets_all_alarms_and_warnings_at_once() {
    let mut tester = quiet();
    for name in ["power", "sensor1", "electronics2"] {
        tester.fault(name, true);
        tester.fault(name, false);
    }
    assert_eq!(status(&mut tester), 0xE6);
    tester.put(0, 205, &[0x80]).unwrap();
    assert_eq!(status(&mut tester), 0xA0, "gauges are off, and nothing else");
    for slot in 1..=4 {
        assert_eq!([tester.get(slot, 103), tester.get(slot, 104)], [[0, 0], [0, 0]]);
    }
}

#[test]
fn sensor_alarm_and_warning_belong_to_the_channel() {
    // 4.4.4 tables 5 and 6, 4.4.5, 4.4.6; the slot of the detail (121)
    for (name, failed) in [
        ("sensor1", &[1u8][..]),
        ("electronics1", &[1]),
        ("sensor2", &[2]),
        ("electronics2", &[2]),
        ("power", &[3, 4]),
        ("electronics3", &[3, 4]),
    ] {
        let mut tester = quiet();
        tester.fault(name, true);
        for slot in 1..=4 {
            let bit = if failed.contains(&slot) { 0x02 } else { 0x00 };
            assert_eq!(tester.get(slot, 103), [0, bit], "{name}: alarm of {slot}");
            assert_eq!(tester.get(slot, 104), [0, bit], "{name}: warning of {slot}");
            // Any manufacturer alarm makes every reading invalid (4.4.2, ID 23).
            assert_eq!(tester.get(slot, 23), [0], "{name}: {slot}");
        }
    }
}

#[test]
fn a_gauge_that_does_not_answer_has_an_invalid_reading_and_no_alarm() {
    for (name, slot, status) in [
        ("unplugged1", 1, [0x01, 0x00]),
        ("unplugged2", 2, [0x10, 0x00]),
        ("unplugged3", 3, [0x00, 0x01]),
        ("sensor3", 3, [0x00, 0x01]),
        ("unplugged4", 4, [0x00, 0x10]),
        ("sensor4", 4, [0x00, 0x10]),
    ] {
        let mut tester = quiet();
        tester.fault(name, true);
        assert_eq!(tester.get(0, 204), status, "{name}");
        assert_eq!(tester.get(slot, 102), [1], "{name}");
        assert_eq!(tester.get(slot, 103), [0, 0], "{name}");
        assert_eq!(tester.get(0, 26), [0xA0], "{name}");
    }
}

#[test]
fn over_and_underrange_set_their_own_bits_only() {
    // (125)
    let mut tester = quiet();
    for (part, low, high) in [(0, 1e-9, 1.5), (1, 1e-11, 1.5e-2), (2, 1e-3, 2e5), (3, 1e-1, 2e5)] {
        let slot = part as u8 + 1;
        for (pa, extension) in [(low, 0x04), (high, 0x02)] {
            tester.device().sense(part, pa);
            assert_eq!(tester.get(slot, 102), [extension], "channel {slot} at {pa} Pa");
            assert_eq!(tester.get(slot, 23), [1], "reading valid");
            assert_eq!(status(&mut tester), 0xA0);
        }
        tester.device().sense(part, if part < 2 { 1e-3 } else { 1e2 });
        assert_eq!(status(&mut tester), 0x80);
    }
}

#[test]
fn channel_status_is_made_of_the_status_extensions() {
    // (127)
    let mut tester = exchanging(FLOATS, 1e-20);
    assert_eq!(tester.get(0, 204), [0x11, 0x44]);
    tester.put(2, 105, &[1]).unwrap();
    assert_eq!(tester.get(0, 204), [0x41, 0x44]);
    tester.pressure_mbar(1e5);
    assert_eq!(tester.get(0, 204), [0x11, 0x22]);
    for slot in 1..=4u8 {
        let status = tester.get(0, 204);
        let octet = status[usize::from(slot - 1) / 2];
        let nibble = if slot % 2 == 1 { octet & 0x0F } else { octet >> 4 };
        assert_eq!(tester.get(slot, 102), [nibble]);
    }
}
