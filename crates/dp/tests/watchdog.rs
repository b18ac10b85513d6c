//! The response watchdog. profibus-wire 2.4 and 3.6.

mod bench;

use bench::{Answer, Bench, Gauge, INITIATE, MASTER, RS, Seen, emit, hex, low};
use profivac_dp::link::{Baud, BitTime, CHARACTER_TBIT, Station, T_SYN_TBIT};
use profivac_wire::{DataTelegram, Telegram};

/// 10 ms at 1.5 Mbit/s.
const T: u64 = 15_000;

/// Data exchange, watched with 10 ms.
fn ten_ms() -> Bench {
    let mut bench = Bench::new(Gauge::default());
    bench.ms0(MASTER, 61, &hex("88 01 01 00 12 34 00 80 00 00"));
    bench.ms0(MASTER, 62, &hex("11 21"));
    bench
}

/// Passes time until `tbit` after the last request ended.
fn pass_until(bench: &mut Bench, tbit: u64) {
    bench.pass(bench.asked + tbit - bench.now);
}

fn owner(bench: &Bench) -> Option<u8> {
    bench.slave.state().owner().map(|owner| owner.master)
}

#[test]
fn it_expires_to_the_bit() {
    let mut bench = ten_ms();
    assert_eq!(bench.slave.wake_at(), Some(bench.asked + T));
    pass_until(&mut bench, T - 1);
    assert_eq!(owner(&bench), Some(MASTER));
    bench.pass(1);
    assert_eq!(owner(&bench), None);
    assert_eq!(bench.slave.wake_at(), None);
}

#[test]
fn its_time_is_base_times_both_factors() {
    for (baud, factors, user, tbit) in [
        (Baud::B9600, "01 01", "80 00 00", 96),
        (Baud::B19200, "0A 0A", "80 00 00", 19_200),
        (Baud::B1500000, "FF FF", "80 00 00", 975_375_000),
        (Baud::B1500000, "02 03", "84 00 00", 9_000),
        (Baud::B12000000, "01 01", "04 00 00", 12_000),
        (Baud::B1500000, "02 03", "", 90_000),
    ] {
        let mut bench: Bench = Bench::at(Gauge::default(), baud);
        bench.ms0(MASTER, 61, &hex(&format!("88 {factors} 00 12 34 00 {user}")));
        assert_eq!(bench.slave.wake_at(), Some(bench.asked + tbit), "{baud} {factors}");
    }
}

/// Transition 14.
#[test]
fn when_it_expires_the_slave_leaves_its_master() {
    let mut bench = ten_ms();
    bench.dx(MASTER, &[5, 6]);
    assert_eq!(bench.ms1("5E 01 10 04"), Answer::Ack);
    pass_until(&mut bench, T);
    let [.., Seen::Safe, Seen::Exchanging(false)] = bench.device().seen[..] else { panic!("outputs are safe") };
    assert_eq!(bench.dx(MASTER, &[5, 6]), RS);
    assert_eq!(bench.ms1(""), RS);
    assert_eq!(bench.diag(MASTER), "02 05 00 FF");
}

#[test]
fn it_runs_in_wait_cfg_too() {
    let mut bench = Bench::new(Gauge::default());
    bench.ms0(MASTER, 61, &hex("88 01 01 00 12 34 00"));
    assert_eq!(bench.diag(MASTER), "02 0C 00 02");
    pass_until(&mut bench, T);
    assert_eq!(bench.diag(MASTER), "02 05 00 FF");
}

/// Also without a poll in between: a late request finds it expired.
#[test]
fn a_request_that_comes_too_late_does_not_save_it() {
    let mut bench = ten_ms();
    let octets = hex("68 05 05 68 08 02 7D AA 55 86 16");
    let late = bench.asked + T;
    let telegram = Telegram::parse(&octets).unwrap();
    let answer = bench.slave.telegram(late, &telegram).unwrap();
    assert_eq!(answer.octets, hex("10 02 08 03 0D 16"));
}

/// Point 16 of section 10: every request of the owner to the slave, and an accepted Global_Control.
#[test]
fn every_request_of_the_owner_restarts_it() {
    let frame = |da, dsap, fc, du| DataTelegram { da, sa: MASTER, dsap, ssap: dsap.map(|_| 62), fc, du };
    let initiate = hex(INITIATE);
    for frame in [
        frame(8, None, 0x6D, &[1, 2][..]),
        frame(8, Some(60), 0x6D, &[]),
        frame(8, Some(59), 0x6D, &[]),
        frame(8, Some(56), 0x6D, &[]),
        frame(8, Some(51), 0x6C, &[]),
        frame(8, Some(49), 0x6C, &initiate),
        frame(8, Some(20), 0x6C, &[]),
        frame(8, None, 0x49, &[]),
        frame(127, Some(58), 0x46, &[0, 0]),
    ] {
        let mut bench = ten_ms();
        pass_until(&mut bench, T / 2);
        bench.raw(&emit(&Telegram::Data(frame)));
        let restarted = bench.asked + T;
        let watchdog = bench.slave.state().owner().and_then(|owner| owner.watchdog);
        assert_eq!(watchdog.map(|watchdog| watchdog.deadline), Some(restarted), "{frame:?}");
    }
    let mut bench = ten_ms();
    bench.dx(MASTER, &[1, 2]);
    pass_until(&mut bench, T / 2);
    bench.again();
    assert_eq!(bench.slave.wake_at(), Some(bench.asked + T), "a repetition");
}

#[test]
fn nothing_else_restarts_it() {
    let mut bench = ten_ms();
    let deadline = bench.slave.wake_at();
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
        bench.raw(&hex(octets));
    }
    assert_eq!(bench.slave.wake_at(), deadline);
}

#[test]
fn a_slave_that_is_not_watched_stays() {
    let mut bench = Bench::exchanging(Gauge::default());
    bench.dx(MASTER, &[5, 6]);
    assert_eq!(bench.slave.wake_at(), None);
    bench.pass(u64::from(u32::MAX));
    assert_eq!(bench.ms0(3, 57, &[]), low("05 06"));
}

#[test]
fn the_end_of_time_is_not_the_end_of_the_slave() {
    let mut bench = ten_ms();
    assert_eq!(bench.slave.poll(BitTime(u64::MAX)), None);
    assert_eq!(owner(&bench), None);
    let poll = T_SYN_TBIT + 11 * CHARACTER_TBIT;
    bench.now = BitTime(u64::MAX - poll);
    assert_eq!(bench.ms0(MASTER, 61, &hex("88 01 01 00 12 34 00")), Answer::Ack);
    assert_eq!(bench.slave.poll(BitTime(u64::MAX)), None);
}
