//! A new address over the bus. profibus-wire 2.11.

use crate::rig;

use rig::{Answer, Gauge, MASTER, RR, RS, Rig, hex, low};

const SET_SLAVE_ADD: u8 = 55;
const TO_9: &str = "09 12 34 00";

/// A slave as delivered.
fn delivered() -> Rig {
    let mut rig = Rig::new(Gauge::default());
    rig.slave.power_up(126);
    rig
}

#[test]
fn the_printed_dialogue() {
    let mut rig = delivered();
    assert_eq!(rig.dialogue("68 09 09 68 FE 82 6D 37 3E 08 12 34 00 B0 16"), "E5");
    assert_eq!(rig.dialogue("10 08 02 49 53 16"), "10 02 08 00 0A 16");
    assert_eq!(rig.dialogue("10 7E 02 49 C9 16"), "silence", "no station has the old address");
}

#[test]
fn a_slave_at_126_can_be_diagnosed() {
    let mut rig = delivered();
    assert_eq!(rig.dialogue("10 7E 02 49 C9 16"), "10 02 7E 00 80 16");
    assert_eq!(rig.ms0(MASTER, 60, &[]), low("02 05 00 FF 12 34"));
    assert_eq!(rig.ms0(MASTER, 59, &[]), low("11 21"));
    // profibus-wire 10, point 32.
    assert_eq!(rig.ms0(MASTER, 61, &hex("80 01 01 00 12 34 00")), Answer::Ack);
    assert_eq!(rig.diag(MASTER), "02 04 00 02");
}

#[test]
fn set_slave_add_is_accepted_in_wait_prm_only() {
    let mut rig = Rig::new(Gauge::default());
    rig.ms0(MASTER, 61, &hex("80 01 01 00 12 34 00"));
    assert_eq!(rig.ms0(MASTER, SET_SLAVE_ADD, &hex(TO_9)), RS);
    rig.ms0(MASTER, 62, &hex("11 21"));
    assert_eq!(rig.ms0(MASTER, SET_SLAVE_ADD, &hex(TO_9)), RS);
    assert_eq!(rig.slave.address(), 8);
}

#[test]
fn a_device_with_an_address_switch_closes_set_slave_add() {
    let mut rig = Rig::new(Gauge { settable: false, ..Gauge::default() });
    assert_eq!(rig.ms0(MASTER, SET_SLAVE_ADD, &hex(TO_9)), RS);
}

/// profibus-wire 10, point 15.
#[test]
fn a_request_that_does_not_fit_is_acknowledged_and_changes_nothing() {
    for request in ["", "09 12 34", "09 12 35 00", "7E 12 34 00", "7F 12 34 00", "FF 12 34 00"] {
        let mut rig = Rig::new(Gauge::default());
        assert_eq!(rig.ms0(MASTER, SET_SLAVE_ADD, &hex(request)), Answer::Ack, "{request}");
        assert_eq!(rig.slave.address(), 8, "{request}");
    }
}

#[test]
fn no_add_chg_locks_the_address() {
    for (lock, second) in [("00", 10), ("01", 9), ("FF", 9)] {
        let mut rig = Rig::new(Gauge::default());
        assert_eq!(rig.ms0(MASTER, SET_SLAVE_ADD, &hex(&format!("09 12 34 {lock}"))), Answer::Ack);
        assert_eq!(rig.ms0(MASTER, SET_SLAVE_ADD, &hex("0A 12 34 00")), Answer::Ack);
        assert_eq!(rig.slave.address(), second, "{lock}");
    }
}

#[test]
fn the_lowest_and_the_highest_address_are_accepted() {
    for address in [0, 125] {
        let mut rig = Rig::new(Gauge::default());
        assert_eq!(rig.ms0(MASTER, SET_SLAVE_ADD, &[address, 0x12, 0x34, 0]), Answer::Ack);
        assert_eq!(rig.diag(MASTER), "02 05 00 FF");
    }
}

/// The new address has had no request yet, so no request to it is a repetition.
#[test]
fn the_frame_count_begins_anew_under_a_new_address() {
    let mut rig = Rig::new(Gauge::default());
    assert_eq!(rig.ms0(MASTER, 60, &[0]), RR);
    assert_eq!(rig.ms0(MASTER, SET_SLAVE_ADD, &hex(TO_9)), Answer::Ack);
    // The same frame count bit, from the same master, to the new address.
    assert_eq!(
        rig.raw(&hex("68 05 05 68 89 82 5D 3C 3E E2 16")),
        Some(hex("68 0B 0B 68 82 89 08 3E 3C 02 05 00 FF 12 34 D9 16"))
    );
}
