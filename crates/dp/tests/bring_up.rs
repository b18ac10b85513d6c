//! From nothing to data exchange, and everything that may come in between. profibus-wire 2.13, 3.9 and 3.10.
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic, reason = "helpers of tests are tests")]

mod support;

use profivac_dp::link::active::{Active, Failure};
use profivac_dp::link::{Baud, BitTime};
use profivac_dp::master::{
    Event, EventKind, ExchangeError, HandlerState, Master, Mode, Settings, SlaveListError, SlaveParameters,
};
use profivac_wire::cfg::CfgError;
use profivac_wire::control::Status;
use support::desk::Desk;
use support::line::{From, Line};
use support::plain::Plain;
use support::{bus, hex, is_housekeeping};

const IDENT: u16 = 0x1234;
/// Two octets in, two octets out.
const CFG: [u8; 2] = [0x11, 0x21];

const DIAG_FIRST: &str = "68 05 05 68 88 82 6D 3C 3E F1 16";
const DIAG_0: &str = "68 05 05 68 88 82 5D 3C 3E E1 16";
const POWER_UP: &str = "68 0B 0B 68 82 88 08 3E 3C 02 05 00 FF 12 34 D8 16";
const READY: &str = "68 0B 0B 68 82 88 08 3E 3C 00 0C 00 02 12 34 E0 16";

fn settings() -> Settings {
    Settings::new(Baud::B1500000)
}

fn operating(slaves: &[SlaveParameters<'_>]) -> Active<Master<32, 32>> {
    let mut master = Master::on(bus(), settings(), BitTime(0));
    for slave in slaves {
        master.user.add(slave).unwrap();
    }
    master.user.set_mode(Mode::Operate);
    master
}

fn desk(slave: &SlaveParameters<'_>) -> Desk<Master<32, 32>> {
    Desk::new(operating(&[*slave]))
}

/// A master with one slave 8 that it knows to be there and has just asked for its first diagnosis.
fn desk_in_diag1() -> Desk<Master<32, 32>> {
    let mut desk = desk(&SlaveParameters::new(8, IDENT, &CFG));
    desk.dialogue(&format!("M 10 08 02 49 53 16\nS 10 02 08 00 0A 16\nM {DIAG_FIRST}"));
    desk
}

/// As [`desk_in_diag1`], a few messages later: Set_Prm and Chk_Cfg were acknowledged and the result is asked for.
fn desk_in_diag2() -> Desk<Master<32, 32>> {
    let mut desk = desk_in_diag1();
    desk.dialogue(&format!(
        "S {POWER_UP}
         M 68 0C 0C 68 88 82 5D 3D 3E 88 0A 0A 0B 12 34 00 CF 16
         S E5
         M 68 07 07 68 88 82 7D 3E 3E 11 21 35 16
         S E5
         M {DIAG_0}"
    ));
    desk
}

/// An answer to Slave_Diag from slave 8 to master 2.
fn diag(du: &str) -> String {
    let du = hex(du);
    let le = du.len() as u8 + 5;
    let mut octets = vec![0x68, le, le, 0x68, 0x82, 0x88, 0x08, 0x3E, 0x3C];
    octets.extend(du);
    let fcs = octets[4..].iter().fold(0u8, |sum, octet| sum.wrapping_add(*octet));
    octets.extend([fcs, 0x16]);
    support::text(&octets)
}

fn events(master: &mut Master<32, 32>) -> Vec<EventKind> {
    std::iter::from_fn(|| master.next_event()).map(|event| event.kind).collect()
}

#[test]
fn the_start_up_is_the_one_of_the_real_trace() {
    // profibus-wire 2.13: telegram by telegram, on both sides.
    let slave = SlaveParameters {
        user_prm: &[0, 0, 0, 0x82, 0, 0, 0],
        watchdog: Some([0x1E, 1]),
        min_tsdr: 0,
        group: 1,
        sync: true,
        freeze: true,
        ..SlaveParameters::new(8, 0x0A35, &[0x21])
    };
    let mut desk = desk(&slave);
    desk.dialogue(
        "M 10 08 02 49 53 16                         | FDL status
         S 10 02 08 00 0A 16                         | passive, ok
         M 68 05 05 68 88 82 6D 3C 3E F1 16          | Slave_Diag, first
         S 68 0B 0B 68 82 88 08 3E 3C 02 05 00 FF 0A 35 D1 16
         M 68 13 13 68 88 82 5D 3D 3E B8 1E 01 00 0A 35 01 00 00 00 82 00 00 00 7B 16 | Set_Prm, FCB = 0
         S E5
         M 68 06 06 68 88 82 7D 3E 3E 21 24 16       | Chk_Cfg, FCB = 1
         S E5
         M 68 05 05 68 88 82 5D 3C 3E E1 16          | Slave_Diag, FCB = 0
         S 68 0B 0B 68 82 88 08 3E 3C 00 0C 00 02 0A 35 D9 16 | ready
         M 68 07 07 68 FF 82 46 3A 3E 00 00 3F 16    | the trace ends here: Operate
         M 68 05 05 68 08 02 7D 00 00 87 16          | and its outputs, FCB = 1
         S E5                                        | no inputs",
    );
    assert_eq!(desk.station.user.state(8), Some(HandlerState::Data { diag: false }));
}

#[test]
fn one_three_and_thirty_two_slaves_come_into_data_exchange() {
    for count in [1, 3, 32] {
        let slaves: Vec<_> = (3..3 + count).map(|address| SlaveParameters::new(address, IDENT, &CFG)).collect();
        let mut line = Line::new(operating(&slaves));
        for slave in &slaves {
            let mut device = Plain::new(IDENT, &CFG);
            device.inputs = vec![slave.address, !slave.address];
            line.attach(device, slave.address);
        }
        for slave in &slaves {
            line.master.user.outputs_mut(slave.address).unwrap().copy_from_slice(&[0x40, slave.address]);
        }
        // 32 slaves at 1.5 Mbit/s: far below 0.2 s.
        line.run_until(300_000, |line| {
            line.master.user.addresses().all(|address| line.master.user.inputs(address).is_some())
        });
        for (slave, remote) in slaves.iter().zip(&line.slaves) {
            let address = slave.address;
            assert_eq!(line.master.user.inputs(address), Some(&[address, !address][..]));
            assert_eq!(remote.device().outputs, Some(vec![0x40, address]));
            let counters = line.master.user.counters(address).unwrap();
            assert_eq!((counters.lost, counters.retries, counters.starts), (0, 0, 1));
        }
        assert_eq!(line.master.user.exchanging(), usize::from(count));
        assert!(!line.master.user.take_overflow() || count == 32, "64 events do for a few slaves");
    }
}

#[test]
fn slaves_are_served_in_the_order_in_which_they_were_added() {
    let order = [9, 3, 77, 8];
    let slaves = order.map(|address| SlaveParameters::new(address, IDENT, &CFG));
    let mut line = Line::new(operating(&slaves));
    order.into_iter().for_each(|address| line.attach(Plain::new(IDENT, &CFG), address));
    line.run_until(100_000, |line| line.master.user.exchanging() == 4);
    line.run_for(2_000);
    let first = line.trace.len();
    line.run_for(10_000);
    let of_master = line.trace[first..].iter().filter(|entry| entry.from == From::Master);
    let cycles: Vec<_> =
        of_master.map(|entry| (entry.octets[0], entry.octets[4.min(entry.octets.len() - 1)])).collect();
    let begin = cycles.iter().position(|(sd, _)| *sd == 0xDC).unwrap();
    assert_eq!(
        cycles[begin..begin + 10].iter().map(|(_, da)| *da).collect::<Vec<_>>(),
        [2, 9, 3, 77, 8, 2, 9, 3, 77, 8]
    );
}

#[test]
fn a_slave_of_another_master_is_left_alone_until_it_is_free() {
    let mut desk = desk_in_diag1();
    let locked = diag("00 0C 00 05 12 34");
    desk.hears(&locked);
    let mut asked = Vec::new();
    for _ in 0..10 {
        let said = desk.asks();
        assert_eq!(said.octets[7], 0x3C, "nothing but Slave_Diag: {}", said.text());
        asked.push(said.start);
        desk.hears(&locked);
    }
    assert_eq!(desk.station.user.exchange_error(8), Some(ExchangeError::Owned { master: 5 }));
    let told = events(&mut desk.station.user);
    assert_eq!(told.iter().filter(|what| matches!(what, EventKind::Trouble(_))).count(), 1, "told once: {told:?}");
    // Slowly: the pauses double from 10 ms to 250 ms.
    let pauses: Vec<_> = asked.windows(2).map(|pair| pair[1] - pair[0]).collect();
    let ms = |ms| Baud::B1500000.tbit_of_ms(ms);
    for (pause, least) in pauses.iter().zip([10, 20, 40, 80, 160, 250, 250, 250, 250].map(ms)) {
        assert!((least..least + 1000).contains(pause), "{pauses:?}");
    }
    // It becomes free.
    desk.asks();
    desk.hears(POWER_UP);
    assert_eq!(desk.asks().octets[7], 0x3D);
}

#[test]
fn another_device_is_never_sent_parameters() {
    let mut desk = desk_in_diag1();
    desk.hears(&diag("02 05 00 FF 43 21"));
    assert_eq!(desk.asks().octets[7], 0x3C);
    let trouble = ExchangeError::Ident { expected: IDENT, received: 0x4321 };
    assert_eq!(desk.station.user.exchange_error(8), Some(trouble));
    assert_eq!(trouble.to_string(), "it is another device: ident number 4321 instead of 1234");
}

#[test]
fn what_the_second_diagnosis_says_decides() {
    for (du, trouble) in [
        ("42 05 00 FF 12 34", ExchangeError::PrmFault),
        ("06 05 00 FF 12 34", ExchangeError::CfgFault),
        ("02 05 00 FF 12 34", ExchangeError::PrmReq),
        ("00 0C 00 FF 12 34", ExchangeError::PrmReq),
        ("00 0C 00 03 12 34", ExchangeError::Owned { master: 3 }),
        ("00 0C 00 02 12", ExchangeError::Length { expected: 6, received: 5 }),
    ] {
        let mut desk = desk_in_diag2();
        desk.hears(&diag(du));
        assert_eq!(desk.station.user.exchange_error(8), Some(trouble), "{du}");
        assert_eq!(desk.station.user.state(8), Some(HandlerState::Diag1), "{du}");
        // From the beginning, the first time at once.
        assert_eq!(desk.asks().octets[7], 0x3C, "{du}");
        desk.hears(POWER_UP);
        assert_eq!(desk.asks().octets[7], 0x3D, "{du}");
    }
}

#[test]
fn a_slave_that_is_not_ready_is_asked_again_but_not_for_ever() {
    let mut desk = desk_in_diag2();
    let checking = diag("02 0C 00 02 12 34");
    let begin = desk.now;
    desk.hears(&checking);
    while desk.station.user.state(8) != Some(HandlerState::Diag1) {
        assert_eq!(desk.asks().octets[7], 0x3C);
        desk.hears(&checking);
    }
    let took = desk.now - begin;
    assert!(took.abs_diff(settings().ready_tbit) < 1000, "{took}");
    assert_eq!(desk.station.user.exchange_error(8), Some(ExchangeError::NotReady));

    let mut desk = desk_in_diag2();
    desk.hears(&checking);
    desk.dialogue(&format!("M 68 05 05 68 88 82 7D 3C 3E 01 16\nS {READY}\nM 68 07 07 68 FF 82 46 3A 3E 00 00 3F 16"));
    assert_eq!(desk.asks().octets[6], 0x5D, "Data_Exchange");
}

#[test]
fn single_lost_diagnoses_do_not_add_up() {
    let mut desk = desk_in_diag2();
    for _ in 0..5 {
        desk.hears(&diag("02 0C 00 02 12 34"));
        // With its repetition and the first contact after it, two failures in a row.
        (0..4).for_each(|_| drop(desk.asks()));
    }
    assert!(matches!(desk.station.user.state(8), Some(HandlerState::Diag2 { .. })));
    assert_eq!(desk.station.user.counters(8).unwrap().lost, 10);
}

#[test]
fn a_slave_taken_up_again_does_not_wait_for_the_end_of_its_pause() {
    let mut desk = desk_in_diag1();
    for _ in 0..5 {
        desk.hears(&diag("00 0C 00 05 12 34"));
        desk.asks();
    }
    desk.hears(&diag("00 0C 00 05 12 34"));
    desk.station.user.restart(8);
    let begin = desk.now;
    assert_eq!(desk.asks().octets, hex("10 08 02 49 53 16"));
    assert!(desk.now - begin < 1_000);
    assert_eq!(desk.station.user.exchange_error(8), None);
}

#[test]
fn static_diagnosis_holds_back_the_exchange() {
    // profibus-wire 2.13: a hardware master reads 0E four times, then 0C, and only then goes on.
    let mut desk = desk_in_diag2();
    for _ in 0..4 {
        desk.hears(&diag("00 0E 00 02 12 34"));
        assert_eq!(desk.asks().octets[7], 0x3C);
    }
    assert_eq!(desk.station.user.exchange_error(8), Some(ExchangeError::StaticDiag));
    assert_eq!(desk.station.user.inputs(8), None);
    desk.hears(READY);
    assert_eq!(desk.asks().octets[6], 0x46);
    assert_eq!(desk.asks().octets[..7], [0x68, 5, 5, 0x68, 8, 2, 0x7D]);
}

#[test]
fn diag_update_delay_bears_with_a_slave_that_still_asks_for_parameters() {
    let slave = SlaveParameters { diag_update_delay: 2, ..SlaveParameters::new(8, IDENT, &CFG) };
    let mut desk = desk(&slave);
    desk.asks();
    desk.hears("10 02 08 00 0A 16");
    desk.asks();
    desk.hears(POWER_UP);
    for _ in 0..2 {
        desk.asks();
        desk.hears("E5");
    }
    for _ in 0..2 {
        assert_eq!(desk.asks().octets[7], 0x3C);
        desk.hears(POWER_UP);
        assert_eq!(desk.station.user.exchange_error(8), None);
    }
    assert_eq!(desk.asks().octets[7], 0x3C);
    desk.hears(POWER_UP);
    assert_eq!(desk.station.user.exchange_error(8), Some(ExchangeError::PrmReq));
}

#[test]
fn set_prm_and_chk_cfg_want_an_acknowledgement_and_nothing_else() {
    let mut desk = desk_in_diag1();
    desk.hears(POWER_UP);
    assert_eq!(desk.asks().octets[7], 0x3D);
    desk.hears("10 02 08 03 0D 16");
    assert_eq!(desk.station.user.exchange_error(8), Some(ExchangeError::Refused(Status::ServiceNotActivated)));
    assert_eq!(desk.station.user.state(8), Some(HandlerState::Diag1));
}

#[test]
fn a_refused_configuration_is_tried_again_slowly_while_the_others_exchange() {
    let slaves = [SlaveParameters::new(3, IDENT, &[0x10]), SlaveParameters::new(4, IDENT, &CFG)];
    let mut line = Line::new(operating(&slaves));
    line.attach(Plain::new(IDENT, &CFG), 3);
    line.attach(Plain::new(IDENT, &CFG), 4);
    line.run_for(3_000_000);
    assert_eq!(line.master.user.exchange_error(3), Some(ExchangeError::CfgFault));
    assert_eq!(line.master.user.exchanging(), 1);
    let sent_to_3 = line.trace.iter().filter(|entry| entry.octets.get(4) == Some(&0x83)).count();
    // Two seconds: 0, 10, 30, 70, 150, 310, 560 ... ms after the first failure, four messages each.
    assert!((30..70).contains(&sent_to_3), "{sent_to_3}");
    let counters = line.master.user.counters(4).unwrap();
    assert_eq!(counters.lost, 0);
    assert!(counters.exchanges > 6_000, "{counters:?}");
}

#[test]
fn a_refused_parameter_is_told_by_the_diagnosis() {
    let mut line = Line::new(operating(&[SlaveParameters::new(8, IDENT, &CFG)]));
    let mut device = Plain::new(IDENT, &CFG);
    device.accepts_prm = false;
    line.attach(device, 8);
    line.run_until(100_000, |line| line.master.user.exchange_error(8) == Some(ExchangeError::PrmFault));
    line.slaves[0].device_mut().accepts_prm = true;
    line.run_until(1_000_000, |line| line.master.user.inputs(8).is_some());
    assert_eq!(line.master.user.exchange_error(8), None);
}

#[test]
fn slaves_that_are_not_there_are_called_one_per_cycle_and_all_in_turn() {
    let slaves: Vec<_> = (3..33).map(|address| SlaveParameters::new(address, IDENT, &CFG)).collect();
    let mut line = Line::new(operating(&slaves));
    line.attach(Plain::new(IDENT, &CFG), 20);
    line.run_until(300_000, |line| line.master.user.exchanging() == 1);
    line.run_for(300_000);
    let first = line.trace.len();
    line.run_for(500_000);
    let trace = &line.trace[first..];
    let mut calls_in_cycle = 0;
    let mut called = std::collections::BTreeSet::new();
    for entry in trace.iter().filter(|entry| entry.from == From::Master) {
        match entry.octets[0] {
            0xDC => calls_in_cycle = 0,
            0x10 if !is_housekeeping(&entry.octets) => {
                calls_in_cycle += 1;
                called.insert(entry.octets[1]);
                assert!(calls_in_cycle <= 1);
            }
            _ => {}
        }
    }
    assert_eq!(called.len(), 29, "{called:?}");
    assert_eq!(line.master.user.counters(20).unwrap().lost, 0);
    assert_eq!(line.master.user.counters(3).unwrap().lost, 0, "nobody was lost who never was there");
}

#[test]
fn slaves_that_are_not_there_are_called_equally_often() {
    // The pause is over before the next cycle: the first ones must not take every turn.
    let quick = Settings { pause_min_tbit: 1, pause_max_tbit: 1, ..settings() };
    let mut master = Master::<32, 32>::on(bus(), quick, BitTime(0));
    for address in 3..33 {
        master.user.add(&SlaveParameters::new(address, IDENT, &CFG)).unwrap();
    }
    master.user.set_mode(Mode::Operate);
    let mut desk = Desk::new(master);
    let called: Vec<u8> = (0..90).map(|_| desk.asks().octets[1]).collect();
    assert_eq!(called, (3..33).cycle().take(90).collect::<Vec<_>>());
}

#[test]
fn the_events_tell_the_story() {
    let mut line = Line::new(operating(&[SlaveParameters::new(8, IDENT, &CFG)]));
    line.attach(Plain::new(IDENT, &CFG), 8);
    line.run_until(100_000, |line| line.master.user.inputs(8).is_some());
    let story: Vec<Event> = std::iter::from_fn(|| line.master.user.next_event()).collect();
    let told: Vec<String> = story.iter().map(|event| event.kind.to_string()).collect();
    assert_eq!(told, ["DIAG1", "new diagnosis", "PRM", "CFG", "DIAG2", "new diagnosis", "DATA"]);
    assert!(story.iter().all(|event| event.address == 8));
    assert!(story.is_sorted_by_key(|event| event.at));
}

#[test]
fn events_that_nobody_takes_are_lost_and_that_is_told() {
    let mut master = Master::<1, 32, 3>::on(bus(), settings(), BitTime(0));
    master.user.add(&SlaveParameters::new(8, IDENT, &CFG)).unwrap();
    master.user.set_mode(Mode::Operate);
    let mut line = Line::new(master);
    line.attach(Plain::new(IDENT, &CFG), 8);
    line.run_until(100_000, |line| line.master.user.inputs(8).is_some());
    let told: Vec<_> =
        std::iter::from_fn(|| line.master.user.next_event()).map(|event| event.kind.to_string()).collect();
    assert_eq!(told, ["DIAG1", "new diagnosis", "PRM"], "the oldest are kept");
    assert!(line.master.user.take_overflow());
    assert!(!line.master.user.take_overflow(), "told once");
    // What comes later is told again.
    line.master.user.release(8);
    line.run_for(5_000);
    assert_eq!(line.master.user.next_event().map(|event| event.kind), Some(EventKind::Entered(HandlerState::Release)));
    assert!(!line.master.user.take_overflow());
}

#[test]
fn a_released_slave_is_free_for_others_and_may_come_back() {
    let mut line = Line::new(operating(&[SlaveParameters::new(8, IDENT, &CFG)]));
    line.attach(Plain::new(IDENT, &CFG), 8);
    line.run_until(100_000, |line| line.master.user.inputs(8).is_some());
    line.master.user.release(8);
    line.run_until(10_000, |line| line.master.user.state(8) == Some(HandlerState::Inactive));
    assert_eq!(line.slaves[0].state().owner(), None);
    assert_eq!(line.master.user.inputs(8), None);
    let first = line.trace.len();
    line.run_for(10_000);
    assert_eq!(line.messages(first), Vec::<String>::new());
    line.master.user.restart(8);
    line.run_until(100_000, |line| line.master.user.inputs(8).is_some());
}

#[test]
fn parameters_that_cannot_work_are_refused() {
    let mut master = Master::<1, 4>::on(bus(), settings(), BitTime(0)).user;
    let good = SlaveParameters::new(8, IDENT, &CFG);
    for (bad, sentence) in [
        (SlaveParameters { address: 126, ..good }, "no slave of this master can have the address 126"),
        (SlaveParameters { address: 2, ..good }, "no slave of this master can have the address 2"),
        (SlaveParameters { cfg: &[], ..good }, "the configuration is wrong: no identifier"),
        (SlaveParameters { cfg: &[0x14], ..good }, "inputs: 5 octets, and there is room for 4"),
        (SlaveParameters { cfg: &[0x24], ..good }, "outputs: 5 octets, and there is room for 4"),
        (SlaveParameters { cfg: &[0; 5], ..good }, "configuration: 5 octets, and there is room for 4"),
        (SlaveParameters { user_prm: &[0; 5], ..good }, "user parameters: 5 octets, and there is room for 4"),
        (SlaveParameters { watchdog: Some([0, 1]), ..good }, "a watchdog factor must be 1 to 255, not 0"),
    ] {
        assert_eq!(master.add(&bad).unwrap_err().to_string(), sentence);
    }
    assert_eq!(master.add(&SlaveParameters { cfg: &[0xC6], ..good }), Err(SlaveListError::Cfg(CfgError::Truncated)));
    assert_eq!(master.add(&good), Ok(()));
    assert_eq!(master.add(&good), Err(SlaveListError::Taken(8)));
    assert_eq!(master.add(&SlaveParameters { address: 9, ..good }), Err(SlaveListError::Full { capacity: 1 }));
}

#[test]
fn a_slave_that_answers_nothing_but_fdl_status_goes_back_to_the_beginning() {
    let mut desk = desk_in_diag1();
    desk.dialogue(&format!("M {DIAG_FIRST}\nM {DIAG_FIRST}\nM 10 08 02 49 53 16"));
    assert_eq!(desk.station.user.state(8), Some(HandlerState::Offline));
    assert_eq!(desk.station.user.exchange_error(8), Some(ExchangeError::NoAnswer(Failure::Silence)));
}

#[test]
fn a_master_that_is_stopped_says_nothing_to_its_slaves() {
    let mut line = Line::new(operating(&[SlaveParameters::new(8, IDENT, &CFG)]));
    line.attach(Plain::new(IDENT, &CFG), 8);
    line.run_until(100_000, |line| line.master.user.inputs(8).is_some());
    line.master.user.set_mode(Mode::Stop);
    line.run_for(1_000);
    let first = line.trace.len();
    line.run_for(50_000);
    assert_eq!(line.messages(first), Vec::<String>::new());
    assert_eq!(line.master.user.inputs(8), None);
    assert!(line.trace.len() > first, "the token goes round");
}
