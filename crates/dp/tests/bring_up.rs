//! From power-up to data exchange, and the faults in between. profibus-wire 2.13, 3.9 and 3.10.
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic, reason = "helpers of tests are tests")]

use crate::support;

use profivac_dp::link::active::{Active, Failure};
use profivac_dp::link::{Baud, BitTime};
use profivac_dp::master::{
    Event, EventKind, ExchangeError, HandlerState, Master, Mode, Settings, SlaveListError, SlaveParameters,
};
use profivac_wire::cfg::CfgError;
use profivac_wire::control::Status;
use support::line::{From, Line};
use support::plain::Plain;
use support::rig::MasterRig;
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
    let mut master = Master::on(bus().check().unwrap(), settings(), BitTime(0));
    for slave in slaves {
        master.user.add(slave).unwrap();
    }
    master.user.set_mode(Mode::Operate);
    master
}

fn rig(slave: &SlaveParameters<'_>) -> MasterRig<Master<32, 32>> {
    MasterRig::new(operating(&[*slave]))
}

/// A master that has found slave 8 and has just sent the first Slave_Diag to it.
fn rig_in_diag1() -> MasterRig<Master<32, 32>> {
    let mut rig = rig(&SlaveParameters::new(8, IDENT, &CFG));
    rig.dialogue(&format!("M 10 08 02 49 53 16\nS 10 02 08 00 0A 16\nM {DIAG_FIRST}"));
    rig
}

/// As [`rig_in_diag1`], a few messages later: Set_Prm and Chk_Cfg were acknowledged and the master has sent Slave_Diag for the result.
fn rig_in_diag2() -> MasterRig<Master<32, 32>> {
    let mut rig = rig_in_diag1();
    rig.dialogue(&format!(
        "S {POWER_UP}
         M 68 0C 0C 68 88 82 5D 3D 3E 88 0A 0A 0B 12 34 00 CF 16
         S E5
         M 68 07 07 68 88 82 7D 3E 3E 11 21 35 16
         S E5
         M {DIAG_0}"
    ));
    rig
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
    let mut rig = rig(&slave);
    rig.dialogue(
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
    assert_eq!(rig.station.user.state(8), Some(HandlerState::Data { diag: false }));
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
            assert_eq!((counters.lost, counters.repetitions, counters.starts), (0, 0, 1));
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
    let mut rig = rig_in_diag1();
    let locked = diag("00 0C 00 05 12 34");
    rig.receive(&locked);
    let mut asked = Vec::new();
    for _ in 0..10 {
        let sent = rig.next_request();
        assert_eq!(sent.octets[7], 0x3C, "nothing but Slave_Diag: {}", sent.text());
        asked.push(sent.start);
        rig.receive(&locked);
    }
    assert_eq!(rig.station.user.exchange_error(8), Some(ExchangeError::Owned { master: 5 }));
    let reported = events(&mut rig.station.user);
    assert_eq!(
        reported.iter().filter(|what| matches!(what, EventKind::Error(_))).count(),
        1,
        "reported once: {reported:?}"
    );
    // The pauses double from 10 ms to 250 ms.
    let pauses: Vec<_> = asked.windows(2).map(|pair| pair[1] - pair[0]).collect();
    let ms = |ms| Baud::B1500000.tbit_of_ms(ms);
    for (pause, least) in pauses.iter().zip([10, 20, 40, 80, 160, 250, 250, 250, 250].map(ms)) {
        assert!((least..least + 1000).contains(pause), "{pauses:?}");
    }
    // The other master releases it.
    rig.next_request();
    rig.receive(POWER_UP);
    assert_eq!(rig.next_request().octets[7], 0x3D);
}

#[test]
fn a_device_with_another_ident_number_is_never_parameterised() {
    let mut rig = rig_in_diag1();
    rig.receive(&diag("02 05 00 FF 43 21"));
    assert_eq!(rig.next_request().octets[7], 0x3C);
    let error = ExchangeError::Ident { expected: IDENT, received: 0x4321 };
    assert_eq!(rig.station.user.exchange_error(8), Some(error));
    assert_eq!(error.to_string(), "it is another device: ident number 4321 instead of 1234");
}

#[test]
fn the_second_diagnosis_decides() {
    for (du, error) in [
        ("42 05 00 FF 12 34", ExchangeError::PrmFault),
        ("06 05 00 FF 12 34", ExchangeError::CfgFault),
        ("02 05 00 FF 12 34", ExchangeError::PrmReq),
        ("00 0C 00 FF 12 34", ExchangeError::PrmReq),
        ("00 0C 00 03 12 34", ExchangeError::Owned { master: 3 }),
        ("00 0C 00 02 12", ExchangeError::Length { expected: 6, received: 5 }),
    ] {
        let mut rig = rig_in_diag2();
        rig.receive(&diag(du));
        assert_eq!(rig.station.user.exchange_error(8), Some(error), "{du}");
        assert_eq!(rig.station.user.state(8), Some(HandlerState::Diag1), "{du}");
        // The bring-up starts again, the first time without a pause.
        assert_eq!(rig.next_request().octets[7], 0x3C, "{du}");
        rig.receive(POWER_UP);
        assert_eq!(rig.next_request().octets[7], 0x3D, "{du}");
    }
}

/// profibus-wire 3.5
#[test]
fn a_slave_that_is_not_ready_is_asked_again_for_a_limited_time() {
    let mut rig = rig_in_diag2();
    let checking = diag("02 0C 00 02 12 34");
    let begin = rig.now;
    rig.receive(&checking);
    while rig.station.user.state(8) != Some(HandlerState::Diag1) {
        assert_eq!(rig.next_request().octets[7], 0x3C);
        rig.receive(&checking);
    }
    let took = rig.now - begin;
    assert!(took.abs_diff(settings().ready_tbit) < 1000, "{took}");
    assert_eq!(rig.station.user.exchange_error(8), Some(ExchangeError::NotReady));

    let mut rig = rig_in_diag2();
    rig.receive(&checking);
    rig.dialogue(&format!("M 68 05 05 68 88 82 7D 3C 3E 01 16\nS {READY}\nM 68 07 07 68 FF 82 46 3A 3E 00 00 3F 16"));
    assert_eq!(rig.next_request().octets[6], 0x5D, "Data_Exchange");
}

#[test]
fn single_lost_diagnoses_do_not_add_up() {
    let mut rig = rig_in_diag2();
    for _ in 0..5 {
        rig.receive(&diag("02 0C 00 02 12 34"));
        // The request, its repetition and the first contact after them fail: two failures in a row.
        (0..4).for_each(|_| drop(rig.next_request()));
    }
    assert!(matches!(rig.station.user.state(8), Some(HandlerState::Diag2 { .. })));
    assert_eq!(rig.station.user.counters(8).unwrap().lost, 10);
}

#[test]
fn a_slave_taken_up_again_does_not_wait_for_the_end_of_its_pause() {
    let mut rig = rig_in_diag1();
    for _ in 0..5 {
        rig.receive(&diag("00 0C 00 05 12 34"));
        rig.next_request();
    }
    rig.receive(&diag("00 0C 00 05 12 34"));
    rig.station.user.restart(8);
    let begin = rig.now;
    assert_eq!(rig.next_request().octets, hex("10 08 02 49 53 16"));
    assert!(rig.now - begin < 1_000);
    assert_eq!(rig.station.user.exchange_error(8), None);
}

#[test]
fn static_diagnosis_holds_back_the_exchange() {
    // profibus-wire 2.13: a hardware master reads 0E four times, then 0C, and only then continues.
    let mut rig = rig_in_diag2();
    for _ in 0..4 {
        rig.receive(&diag("00 0E 00 02 12 34"));
        assert_eq!(rig.next_request().octets[7], 0x3C);
    }
    assert_eq!(rig.station.user.exchange_error(8), Some(ExchangeError::StaticDiag));
    assert_eq!(rig.station.user.inputs(8), None);
    rig.receive(READY);
    assert_eq!(rig.next_request().octets[6], 0x46);
    assert_eq!(rig.next_request().octets[..7], [0x68, 5, 5, 0x68, 8, 2, 0x7D]);
}

#[test]
fn diag_update_delay_tolerates_a_slave_that_still_asks_for_parameters() {
    let slave = SlaveParameters { diag_update_delay: 2, ..SlaveParameters::new(8, IDENT, &CFG) };
    let mut rig = rig(&slave);
    rig.next_request();
    rig.receive("10 02 08 00 0A 16");
    rig.next_request();
    rig.receive(POWER_UP);
    for _ in 0..2 {
        rig.next_request();
        rig.receive("E5");
    }
    for _ in 0..2 {
        assert_eq!(rig.next_request().octets[7], 0x3C);
        rig.receive(POWER_UP);
        assert_eq!(rig.station.user.exchange_error(8), None);
    }
    assert_eq!(rig.next_request().octets[7], 0x3C);
    rig.receive(POWER_UP);
    assert_eq!(rig.station.user.exchange_error(8), Some(ExchangeError::PrmReq));
}

#[test]
fn set_prm_and_chk_cfg_accept_an_acknowledgement_only() {
    let mut rig = rig_in_diag1();
    rig.receive(POWER_UP);
    assert_eq!(rig.next_request().octets[7], 0x3D);
    rig.receive("10 02 08 03 0D 16");
    assert_eq!(rig.station.user.exchange_error(8), Some(ExchangeError::Refused(Status::ServiceNotActivated)));
    assert_eq!(rig.station.user.state(8), Some(HandlerState::Diag1));
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
fn the_diagnosis_reports_a_refused_parameter() {
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
fn absent_slaves_are_polled_one_per_cycle_in_turn() {
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
    assert_eq!(line.master.user.counters(3).unwrap().lost, 0, "an absent slave is not counted as lost");
}

#[test]
fn absent_slaves_are_polled_equally_often() {
    // The pause is over before the next cycle begins. The first absent slaves must not take the time of the others.
    let quick = Settings { pause_min_tbit: 1, pause_max_tbit: 1, ..settings() };
    let mut master = Master::<32, 32>::on(bus().check().unwrap(), quick, BitTime(0));
    for address in 3..33 {
        master.user.add(&SlaveParameters::new(address, IDENT, &CFG)).unwrap();
    }
    master.user.set_mode(Mode::Operate);
    let mut rig = MasterRig::new(master);
    let called: Vec<u8> = (0..90).map(|_| rig.next_request().octets[1]).collect();
    assert_eq!(called, (3..33).cycle().take(90).collect::<Vec<_>>());
}

#[test]
fn the_events_report_every_state_in_order() {
    let mut line = Line::new(operating(&[SlaveParameters::new(8, IDENT, &CFG)]));
    line.attach(Plain::new(IDENT, &CFG), 8);
    line.run_until(100_000, |line| line.master.user.inputs(8).is_some());
    let events: Vec<Event> = std::iter::from_fn(|| line.master.user.next_event()).collect();
    let reported: Vec<String> = events.iter().map(|event| event.kind.to_string()).collect();
    assert_eq!(reported, ["DIAG1", "new diagnosis", "PRM", "CFG", "DIAG2", "new diagnosis", "DATA"]);
    assert!(events.iter().all(|event| event.address == 8));
    assert!(events.is_sorted_by_key(|event| event.at));
}

#[test]
fn events_that_are_not_taken_overflow_and_the_overflow_is_reported() {
    let mut master = Master::<1, 32, 3>::on(bus().check().unwrap(), settings(), BitTime(0));
    master.user.add(&SlaveParameters::new(8, IDENT, &CFG)).unwrap();
    master.user.set_mode(Mode::Operate);
    let mut line = Line::new(master);
    line.attach(Plain::new(IDENT, &CFG), 8);
    line.run_until(100_000, |line| line.master.user.inputs(8).is_some());
    let reported: Vec<_> =
        std::iter::from_fn(|| line.master.user.next_event()).map(|event| event.kind.to_string()).collect();
    assert_eq!(reported, ["DIAG1", "new diagnosis", "PRM"], "the oldest are kept");
    assert!(line.master.user.take_overflow());
    assert!(!line.master.user.take_overflow(), "reported once");
    // Later events are queued again.
    line.master.user.release(8);
    line.run_for(5_000);
    assert_eq!(line.master.user.next_event().map(|event| event.kind), Some(EventKind::Entered(HandlerState::Release)));
    assert!(!line.master.user.take_overflow());
}

#[test]
fn a_released_slave_is_free_for_other_masters_and_may_be_restarted() {
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
fn impossible_parameters_are_refused() {
    let mut master = Master::<1, 4>::on(bus().check().unwrap(), settings(), BitTime(0)).user;
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
fn the_master_starts_again_with_a_slave_that_answers_only_fdl_status() {
    let mut rig = rig_in_diag1();
    rig.dialogue(&format!("M {DIAG_FIRST}\nM {DIAG_FIRST}\nM 10 08 02 49 53 16"));
    assert_eq!(rig.station.user.state(8), Some(HandlerState::Offline));
    assert_eq!(rig.station.user.exchange_error(8), Some(ExchangeError::NoAnswer(Failure::Silence)));
}

#[test]
fn a_stopped_master_sends_its_slaves_nothing() {
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
