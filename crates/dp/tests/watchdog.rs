//! The response watchdog. profibus-wire 2.4 and 3.6.

use crate::rig;

use profivac_dp::link::{Baud, BitTime, CHARACTER_TBIT, Station, T_SYN_TBIT};
use profivac_wire::{DataTelegram, Telegram};
use rig::{Answer, Gauge, INITIATE, MASTER, RS, Rig, Seen, emit, hex, low};

/// 10 ms at 1.5 Mbit/s.
const T: u64 = 15_000;

/// Data exchange, watched with 10 ms.
fn ten_ms() -> Rig {
    let mut rig = Rig::new(Gauge::default());
    rig.ms0(MASTER, 61, &hex("88 01 01 00 12 34 00 80 00 00"));
    rig.ms0(MASTER, 62, &hex("11 21"));
    rig
}

/// Passes time until `tbit` after the last request ended.
fn pass_until(rig: &mut Rig, tbit: u64) {
    rig.pass(rig.request_end + tbit - rig.now);
}

fn owner(rig: &Rig) -> Option<u8> {
    rig.slave.state().owner().map(|owner| owner.master)
}

#[test]
fn the_watchdog_expires_in_the_right_bit_time() {
    let mut rig = ten_ms();
    assert_eq!(rig.slave.wake_at(), Some(rig.request_end + T));
    pass_until(&mut rig, T - 1);
    assert_eq!(owner(&rig), Some(MASTER));
    rig.pass(1);
    assert_eq!(owner(&rig), None);
    assert_eq!(rig.slave.wake_at(), None);
}

#[test]
fn the_watchdog_time_is_the_base_times_both_factors() {
    for (baud, factors, user, tbit) in [
        (Baud::B9600, "01 01", "80 00 00", 96),
        (Baud::B19200, "0A 0A", "80 00 00", 19_200),
        (Baud::B1500000, "FF FF", "80 00 00", 975_375_000),
        (Baud::B1500000, "02 03", "84 00 00", 9_000),
        (Baud::B12000000, "01 01", "04 00 00", 12_000),
        (Baud::B1500000, "02 03", "", 90_000),
    ] {
        let mut rig: Rig = Rig::at(Gauge::default(), baud);
        rig.ms0(MASTER, 61, &hex(&format!("88 {factors} 00 12 34 00 {user}")));
        assert_eq!(rig.slave.wake_at(), Some(rig.request_end + tbit), "{baud} {factors}");
    }
}

/// profibus-wire 3.2, transition 14.
#[test]
fn an_expired_watchdog_returns_the_slave_to_wait_prm() {
    let mut rig = ten_ms();
    rig.dx(MASTER, &[5, 6]);
    assert_eq!(rig.ms1("5E 01 10 04"), Answer::Ack);
    pass_until(&mut rig, T);
    let [.., Seen::Safe, Seen::Exchanging(false)] = rig.device().seen[..] else { panic!("outputs are safe") };
    assert_eq!(rig.dx(MASTER, &[5, 6]), RS);
    assert_eq!(rig.ms1(""), RS);
    assert_eq!(rig.diag(MASTER), "02 05 00 FF");
}

#[test]
fn the_watchdog_runs_in_wait_cfg_too() {
    let mut rig = Rig::new(Gauge::default());
    rig.ms0(MASTER, 61, &hex("88 01 01 00 12 34 00"));
    assert_eq!(rig.diag(MASTER), "02 0C 00 02");
    pass_until(&mut rig, T);
    assert_eq!(rig.diag(MASTER), "02 05 00 FF");
}

/// Also without a poll in between: a late request finds it expired.
#[test]
fn a_late_request_does_not_restart_an_expired_watchdog() {
    let mut rig = ten_ms();
    let octets = hex("68 05 05 68 08 02 7D AA 55 86 16");
    let late = rig.request_end + T;
    let telegram = Telegram::parse(&octets).unwrap();
    let answer = rig.slave.telegram(late, &telegram).unwrap();
    assert_eq!(answer.octets, hex("10 02 08 03 0D 16"));
}

/// profibus-wire 10, point 16: every request of the owner to the slave, and an accepted Global_Control.
#[test]
fn every_request_of_the_owner_restarts_the_watchdog() {
    let request = |da, dsap, fc, du| DataTelegram { da, sa: MASTER, dsap, ssap: dsap.map(|_| 62), fc, du };
    let initiate = hex(INITIATE);
    for data in [
        request(8, None, 0x6D, &[1, 2][..]),
        request(8, Some(60), 0x6D, &[]),
        request(8, Some(59), 0x6D, &[]),
        request(8, Some(56), 0x6D, &[]),
        request(8, Some(51), 0x6C, &[]),
        request(8, Some(49), 0x6C, &initiate),
        request(8, Some(20), 0x6C, &[]),
        request(8, None, 0x49, &[]),
        request(127, Some(58), 0x46, &[0, 0]),
    ] {
        let mut rig = ten_ms();
        pass_until(&mut rig, T / 2);
        rig.raw(&emit(&Telegram::Data(data)));
        let restarted = rig.request_end + T;
        let watchdog = rig.slave.state().owner().and_then(|owner| owner.watchdog);
        assert_eq!(watchdog.map(|watchdog| watchdog.deadline), Some(restarted), "{data:?}");
    }
    let mut rig = ten_ms();
    rig.dx(MASTER, &[1, 2]);
    pass_until(&mut rig, T / 2);
    rig.again();
    assert_eq!(rig.slave.wake_at(), Some(rig.request_end + T), "a repetition");
}

#[test]
fn no_other_request_restarts_the_watchdog() {
    let mut rig = ten_ms();
    let deadline = rig.slave.wake_at();
    for octets in [
        "10 08 03 49 54 16",
        "68 05 05 68 88 83 6D 3C 3E F2 16",
        "10 09 02 49 54 16",
        // Global_Control of another master, and of the owner to a group that is not ours
        "68 07 07 68 FF 83 46 3A 3E 00 00 40 16",
        "68 07 07 68 FF 82 46 3A 3E 00 01 40 16",
        "E5",
        "DC 08 02",
    ] {
        rig.raw(&hex(octets));
    }
    assert_eq!(rig.slave.wake_at(), deadline);
}

#[test]
fn a_slave_without_a_watchdog_stays_in_data_exchange() {
    let mut rig = Rig::exchanging(Gauge::default());
    rig.dx(MASTER, &[5, 6]);
    assert_eq!(rig.slave.wake_at(), None);
    rig.pass(u64::from(u32::MAX));
    assert_eq!(rig.ms0(3, 57, &[]), low("05 06"));
}

#[test]
fn a_slave_works_at_the_greatest_bit_time() {
    let mut rig = ten_ms();
    assert_eq!(rig.slave.poll(BitTime(u64::MAX)), None);
    assert_eq!(owner(&rig), None);
    let poll = T_SYN_TBIT + 11 * CHARACTER_TBIT;
    rig.now = BitTime(u64::MAX - poll);
    assert_eq!(rig.ms0(MASTER, 61, &hex("88 01 01 00 12 34 00")), Answer::Ack);
    assert_eq!(rig.slave.poll(BitTime(u64::MAX)), None);
}
