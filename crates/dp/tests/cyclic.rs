//! Data exchange and its failures. profibus-wire 2.8, 2.9 and 3.10.
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic, reason = "helpers of tests are tests")]

use crate::support;

use profivac_dp::link::active::{Active, Failure, Mismatch};
use profivac_dp::link::{Baud, BitTime, Station as _};
use profivac_dp::master::{EventKind, ExchangeError, HandlerState, Master, Mode, Settings, SlaveParameters};
use profivac_wire::control::Status;
use profivac_wire::diag::StationStatus;
use support::line::{From, Line};
use support::plain::Plain;
use support::rig::MasterRig;
use support::{Random, bus, hex, text};

const IDENT: u16 = 0x1234;
/// Two octets in, two octets out.
const CFG: [u8; 2] = [0x11, 0x21];

const READY: &str = "68 0B 0B 68 82 88 08 3E 3C 00 0C 00 02 12 34 E0 16";
const INPUTS: &str = "68 05 05 68 02 08 08 01 02 15 16";
const INPUTS_HIGH: &str = "68 05 05 68 02 08 0A 01 02 17 16";
const OPERATE: &str = "68 07 07 68 FF 82 46 3A 3E 00 00 3F 16";
const CLEAR: &str = "68 07 07 68 FF 82 46 3A 3E 02 00 41 16";

type Station = Active<Master<8, 32>>;

fn settings() -> Settings {
    // Global_Control only when something changes.
    Settings { control_cycles: 0, ..Settings::new(Baud::B1500000) }
}

fn station(slaves: &[SlaveParameters<'_>], settings: Settings) -> Station {
    let mut master = Master::on(bus().check().unwrap(), settings, BitTime(0));
    for slave in slaves {
        master.user.add(slave).expect("room for it");
    }
    master.user.set_mode(Mode::Operate);
    master
}

/// A master that has just sent a Data_Exchange request to slave 8 with FCB = 1; the request before it had 0.
fn rig_with(slave: &SlaveParameters<'_>) -> MasterRig<Master<8, 32>> {
    let mut rig = MasterRig::new(station(&[*slave], settings()));
    rig.next_request();
    for answer in ["10 02 08 00 0A 16", "68 0B 0B 68 82 88 08 3E 3C 02 05 00 FF 12 34 D8 16", "E5", "E5", READY] {
        rig.receive(answer);
        rig.next_request();
    }
    // Global_Control (Operate) was sent; the exchange follows.
    let exchange = rig.next_request();
    assert_eq!(if exchange.octets[0] == 0x10 { exchange.octets[3] } else { exchange.octets[6] }, 0x7D);
    rig
}

fn rig() -> MasterRig<Master<8, 32>> {
    rig_with(&SlaveParameters::new(8, IDENT, &CFG))
}

/// As [`rig`], with inputs 01 02 in the image.
fn exchanging() -> MasterRig<Master<8, 32>> {
    let mut rig = rig();
    rig.receive(INPUTS);
    rig
}

/// Master and slave on a line; the slave returns 01 02 for the outputs of the test.
fn line(settings: Settings, addresses: &[u8]) -> Line<Master<8, 32>> {
    let slaves: Vec<_> = addresses.iter().map(|address| SlaveParameters::new(*address, IDENT, &CFG)).collect();
    line_of(settings, &slaves)
}

fn line_of(settings: Settings, slaves: &[SlaveParameters<'_>]) -> Line<Master<8, 32>> {
    let mut line = Line::new(station(slaves, settings));
    for slave in slaves {
        let mut device = Plain::new(IDENT, &CFG);
        device.inputs = vec![1, slave.address];
        line.attach(device, slave.address);
    }
    line.run_until(300_000, |line| {
        line.master.user.addresses().all(|address| line.master.user.inputs(address).is_some())
    });
    while line.master.user.next_event().is_some() {}
    line
}

#[test]
fn inputs_are_those_of_the_last_valid_answer() {
    let mut rig = rig();
    assert_eq!(rig.station.user.inputs(8), None, "nothing was received yet");
    rig.receive(INPUTS);
    assert_eq!(rig.station.user.inputs(8), Some(&[1, 2][..]));
    assert_eq!(rig.station.user.exchanged_at(8), Some(rig.now));
    rig.next_request();
    rig.receive("68 05 05 68 02 08 08 03 04 19 16");
    assert_eq!(rig.station.user.inputs(8), Some(&[3, 4][..]));
    assert_eq!(rig.station.user.counters(8).unwrap().exchanges, 2);
}

#[test]
fn dh_is_followed_by_slave_diag_and_then_by_exchange() {
    let mut rig = rig();
    rig.receive(INPUTS_HIGH);
    assert_eq!(rig.station.user.inputs(8), Some(&[1, 2][..]), "DH carries data as well");
    rig.dialogue(&format!(
        "M 68 05 05 68 88 82 5D 3C 3E E1 16                         | Slave_Diag, FCB = 0
         S 68 0D 0D 68 82 88 08 3E 3C 08 0C 00 02 12 34 02 7F 69 16 | Ext_Diag: 02 7F
         M 68 05 05 68 08 02 7D 00 00 87 16                         | Data_Exchange, FCB = 1
         S {INPUTS}
         M 68 05 05 68 08 02 5D 00 00 67 16"
    ));
    let diag = rig.station.user.diagnosis(8).unwrap();
    assert!(diag.status.contains(StationStatus::EXT_DIAG));
    assert_eq!(diag.ext_diag, [0x02, 0x7F]);
    assert_eq!(
        std::iter::from_fn(|| rig.station.user.next_event()).last().map(|event| event.kind),
        Some(EventKind::Diagnosis)
    );
}

#[test]
fn a_slave_with_a_new_diagnosis_is_diagnosed_once() {
    let mut line = line(settings(), &[8]);
    let first = line.trace.len();
    line.slaves[0].device_mut().diagnose(&[0x03, 0xAA, 0xBB]);
    line.run_for(20_000);
    let diags = line.messages(first).iter().filter(|text| text.contains("3C 3E") && text.contains("88 82")).count();
    assert_eq!(diags, 1);
    let news = |line: &mut Line<Master<8, 32>>| std::iter::from_fn(|| line.master.user.next_event()).count();
    assert_eq!(news(&mut line), 1);
    // The same diagnosis again: no event.
    line.slaves[0].device_mut().changed = true;
    line.run_for(20_000);
    assert_eq!(line.master.user.counters(8).unwrap().diagnoses, 4);
    assert_eq!(news(&mut line), 0);
    assert_eq!(line.master.user.diagnosis(8).unwrap().ext_diag, [0x03, 0xAA, 0xBB]);
    assert_eq!(line.master.user.state(8), Some(HandlerState::Data { diag: false }));
}

#[test]
fn a_diagnosis_longer_than_its_buffer_is_cut_and_marked() {
    let mut line = line(settings(), &[8]);
    line.slaves[0].device_mut().diagnose(&[7; 33]);
    line.run_for(20_000);
    let diag = line.master.user.diagnosis(8).unwrap();
    assert!(diag.status.contains(StationStatus::EXT_DIAG_OVERFLOW));
    assert_eq!(diag.ext_diag, [7; 32]);
}

#[test]
fn an_answer_that_does_not_fit_never_becomes_a_value() {
    for (answer, mismatch) in [
        ("68 05 05 68 02 09 08 07 07 21 16", Some(Mismatch::Source(9))),
        ("68 05 05 68 03 08 08 07 07 21 16", Some(Mismatch::Destination(3))),
        ("68 07 07 68 82 88 08 3E 38 07 07 96 16", Some(Mismatch::AccessPoint)),
        ("68 05 05 68 02 08 00 07 07 18 16", Some(Mismatch::Function(0))),
        ("68 05 05 68 02 08 03 07 07 1B 16", Some(Mismatch::Form)),
        ("68 05 05 68 02 08 08 07 07 21 16", None),
    ] {
        let mut rig = exchanging();
        for _ in 0..2 {
            rig.next_request();
            rig.receive(answer);
        }
        rig.next_request();
        assert_eq!(rig.station.user.inputs(8), Some(&[1, 2][..]), "{answer}");
        // A wrong FCS is a damaged answer: the master reports it when the slave is lost, not before.
        let error = mismatch.map(|mismatch| ExchangeError::NoAnswer(Failure::Mismatch(mismatch)));
        assert_eq!(rig.station.user.exchange_error(8), error, "{answer}");
        assert_eq!(rig.station.user.counters(8).unwrap().lost, 1, "{answer}");
    }
}

#[test]
fn an_answer_of_the_wrong_length_restarts_the_slave() {
    for (answer, received) in
        [("68 04 04 68 02 08 08 07 19 16", 1), ("68 06 06 68 02 08 08 07 07 07 27 16", 3), ("E5", 0)]
    {
        let mut rig = exchanging();
        rig.next_request();
        rig.receive(answer);
        assert_eq!(
            rig.station.user.exchange_error(8),
            Some(ExchangeError::Length { expected: 2, received }),
            "{answer}"
        );
        assert_eq!(rig.station.user.inputs(8), None, "{answer}");
        assert_eq!(rig.next_request().octets[7], 0x3C, "Slave_Diag: {answer}");
    }
}

#[test]
fn an_answer_longer_than_any_image_restarts_the_slave() {
    let mut rig = exchanging();
    rig.next_request();
    let mut octets = vec![0x68, 0xF7, 0xF7, 0x68, 2, 8, 8];
    octets.extend([7; 244]);
    let fcs = octets[4..].iter().fold(0u8, |sum, octet| sum.wrapping_add(*octet));
    octets.extend([fcs, 0x16]);
    rig.receive_octets(11, &octets);
    assert_eq!(rig.station.user.exchange_error(8), Some(ExchangeError::Length { expected: 2, received: 244 }));
}

#[test]
fn rs_in_exchange_restarts_the_slave_at_once() {
    let mut line = line(settings(), &[8]);
    line.slaves[0].power_up(8);
    let first = line.trace.len();
    line.run_until(10_000, |line| line.master.user.counters(8).unwrap().starts == 2);
    let reported: Vec<_> = std::iter::from_fn(|| line.master.user.next_event()).map(|event| event.kind).collect();
    assert_eq!(reported[0], EventKind::Error(ExchangeError::Refused(Status::ServiceNotActivated)));
    assert_eq!(reported[1], EventKind::Entered(HandlerState::Diag1));
    // RS, then diagnosis, parameters, configuration and diagnosis.
    let messages = line.messages(first);
    let begin = messages.iter().position(|text| text == "10 02 08 03 0D 16").unwrap();
    assert_eq!(messages.len() - begin, 9, "{messages:?}");

    // The slave exchanged data for longer than the longest pause, so the next restart has no pause.
    line.run_for(settings().pause_max_tbit);
    line.slaves[0].power_up(8);
    line.run_until(5_000, |line| line.master.user.counters(8).unwrap().starts == 3);
}

#[test]
fn a_slave_that_leaves_exchange_every_time_is_started_more_and_more_slowly() {
    let mut line = line(settings(), &[8]);
    let mut starts = Vec::new();
    for _ in 0..8 {
        line.run_for(3_000);
        line.slaves[0].power_up(8);
        let fell = line.now;
        let known = line.master.user.counters(8).unwrap().starts;
        line.run_until(400_000, |line| line.master.user.counters(8).unwrap().starts > known);
        starts.push(line.now - fell);
    }
    let ms = |ms| Baud::B1500000.tbit_of_ms(ms);
    for (start, least) in starts.iter().zip([0, 10, 20, 40, 80, 160, 250, 250].map(ms)) {
        assert!((least..least + 4_000).contains(start), "{starts:?}");
    }
}

#[test]
fn a_slave_that_fails_before_its_first_exchange_is_started_more_and_more_slowly() {
    let mut rig = rig();
    let mut starts = Vec::new();
    for _ in 0..5 {
        rig.receive("10 02 08 03 0D 16");
        starts.push(rig.next_request().start);
        for answer in ["68 0B 0B 68 82 88 08 3E 3C 02 05 00 FF 12 34 D8 16", "E5", "E5", READY] {
            rig.receive(answer);
            rig.next_request();
        }
        // After Operate the slave refuses the exchange.
        rig.next_request();
    }
    let ms = |ms| Baud::B1500000.tbit_of_ms(ms);
    let pauses: Vec<_> = starts.windows(2).map(|pair| pair[1] - pair[0]).collect();
    for (pause, least) in pauses.iter().zip([10, 20, 40, 80].map(ms)) {
        assert!((least..least + 5_000).contains(pause), "{pauses:?}");
    }
}

#[test]
fn an_answer_that_arrives_after_the_release_is_ignored() {
    let mut rig = exchanging();
    rig.next_request();
    rig.station.user.release(8);
    rig.receive("68 05 05 68 02 08 08 03 04 19 16");
    assert_eq!(rig.station.user.inputs(8), None);
    assert_eq!(rig.next_request().text(), "68 0C 0C 68 88 82 7D 3D 3E 40 00 00 00 12 34 00 88 16");
    rig.receive("E5");
    assert_eq!(rig.station.user.state(8), Some(HandlerState::Inactive));
}

#[test]
fn rr_and_ue_are_tolerated_up_to_the_miss_limit() {
    for (answer, status) in [("10 02 08 02 0C 16", Status::NoResource), ("10 02 08 01 0B 16", Status::UserError)] {
        let mut rig = exchanging();
        for round in 1..=3 {
            assert_eq!(rig.next_request().octets[4], 8, "{answer}");
            rig.receive(answer);
            assert_eq!(rig.station.user.exchange_error(8).is_some(), round == 3, "{answer}");
        }
        assert_eq!(rig.station.user.exchange_error(8), Some(ExchangeError::Refused(status)));
        assert_eq!(rig.station.user.state(8), Some(HandlerState::Diag1));
    }
}

#[test]
fn a_silent_slave_is_lost_after_the_miss_limit() {
    let mut rig = exchanging();
    let first_contact = "68 05 05 68 08 02 6D 00 00 77 16";
    rig.dialogue(&format!(
        "M 68 05 05 68 08 02 5D 00 00 67 16 | counted
         M 68 05 05 68 08 02 5D 00 00 67 16 | once more
         M {first_contact}                  | then first contacts, one try each
         M {first_contact}
         M 10 08 02 49 53 16                | lost: FDL status"
    ));
    assert_eq!(rig.station.user.state(8), Some(HandlerState::Offline));
    assert_eq!(rig.station.user.exchange_error(8), Some(ExchangeError::NoAnswer(Failure::Silence)));
    assert_eq!(rig.station.user.inputs(8), None);
    assert_eq!(rig.station.user.counters(8).unwrap().lost, 3);
}

/// A telegram of another master in place of the answer is no failure of the slave, even if it is repeated.
#[test]
fn a_slave_is_not_lost_when_another_master_interrupts() {
    let mut rig = exchanging();
    for _ in 0..10 {
        assert_eq!(rig.next_request().octets[4], 8);
        rig.receive_after(100, "10 05 03 49 51 16");
    }
    assert_eq!((rig.station.user.exchanging(), rig.station.user.exchange_error(8)), (1, None));
    assert_eq!(rig.station.user.counters(8).unwrap().lost, 0);
    assert_eq!(rig.station.user.inputs(8), Some(&[1, 2][..]));
}

#[test]
fn a_slave_that_answers_again_in_time_stays_in_data_exchange() {
    let mut rig = exchanging();
    rig.next_request();
    rig.next_request();
    rig.next_request();
    rig.receive(INPUTS);
    assert_eq!(rig.station.user.state(8), Some(HandlerState::Data { diag: false }));
    assert_eq!(rig.station.user.exchange_error(8), None);
    assert_eq!(rig.next_request().octets[6], 0x5D, "first contact, then FCB = 0");
}

#[test]
fn a_request_whose_answer_is_lost_is_repeated_and_counted_once() {
    let mut line = line(settings(), &[8]);
    // From the end of a cycle.
    line.run_until(10_000, |line| line.trace.last().is_some_and(|entry| entry.octets[0] == 0xDC));
    let before = *line.master.user.counters(8).unwrap();
    let mut drop_next = true;
    line.telegram_fault = Some(Box::new(move |from, octets| {
        if from == From::Slave(0) && std::mem::take(&mut drop_next) { Vec::new() } else { octets.to_vec() }
    }));
    let first = line.trace.len();
    line.run_for(5_000);
    let messages = line.messages(first);
    assert_eq!(messages[0], messages[2], "the same request: {messages:?}");
    assert_eq!(messages[1], messages[3], "the same answer: {messages:?}");
    let after = line.master.user.counters(8).unwrap();
    assert_eq!((after.repetitions - before.repetitions, after.lost - before.lost), (1, 0));
}

#[test]
fn a_master_recovers_from_a_bus_without_answers() {
    let mut line = line(settings(), &[8, 9]);
    line.telegram_fault =
        Some(Box::new(|from, octets| if from == From::Master { octets.to_vec() } else { Vec::new() }));
    // 0.7 s
    line.run_for(1_050_000);
    assert_eq!(line.master.user.exchanging(), 0);
    assert_eq!(line.master.user.state(8), Some(HandlerState::Offline));
    line.telegram_fault = None;
    let back = line.now;
    line.run_until(400_000, |line| line.master.user.exchanging() == 2);
    println!("back after {} bit times", line.now - back);
}

#[test]
fn the_master_restarts_a_slave_whose_watchdog_expired() {
    let mut line = line(settings(), &[8]);
    // The slave receives nothing for 1.2 s; its watchdog time is one second.
    line.telegram_fault = Some(Box::new(|_, _| Vec::new()));
    line.run_for(1_800_000);
    assert_eq!(line.slaves[0].state().owner(), None);
    line.telegram_fault = None;
    line.run_until(400_000, |line| line.master.user.inputs(8).is_some());
}

#[test]
fn flipped_bits_cause_repetitions_and_never_a_wrong_value() {
    let addresses = [3, 8, 77];
    let mut line = line(settings(), &addresses);
    let mut random = Random::new(0x5EED_0001);
    // One octet in 500 with one bit flipped, at most one octet per telegram.
    line.telegram_fault = Some(Box::new(move |_, octets| {
        let mut octets = octets.to_vec();
        let index = random.below(500);
        if let Some(octet) = octets.get_mut(index) {
            *octet ^= 1 << random.below(8);
        }
        octets
    }));
    for round in 0..3_000u32 {
        let outputs = (round as u16).to_be_bytes();
        for address in addresses {
            line.master.user.outputs_mut(address).unwrap().copy_from_slice(&outputs);
        }
        line.run_for(2_000);
        for (address, slave) in addresses.iter().zip(&line.slaves) {
            assert!(line.master.user.inputs(*address).is_none_or(|inputs| inputs == [1, *address]));
            // Repetitions may delay the outputs by a few rounds.
            let recent = (round.saturating_sub(8) as u16)..=(round as u16);
            let outputs = slave.device().outputs.as_ref();
            let is_recent = outputs.is_none_or(|octets| recent.contains(&u16::from_be_bytes([octets[0], octets[1]])));
            assert!(is_recent, "{outputs:?} in round {round}");
        }
    }
    line.telegram_fault = None;
    for address in addresses {
        let counters = line.master.user.counters(address).unwrap();
        assert!(counters.exchanges > 3_000 && counters.repetitions > 20, "{counters:?}");
        assert_eq!(counters.starts, 1, "no slave was restarted");
    }
}

#[test]
fn clear_and_operate_are_sent_at_once_and_outputs_follow() {
    let mut rig = exchanging();
    rig.station.user.outputs_mut(8).unwrap().copy_from_slice(&[0xAA, 0x55]);
    rig.dialogue(&format!("M 68 05 05 68 08 02 5D AA 55 66 16\nS {INPUTS}"));
    rig.station.user.set_mode(Mode::Clear);
    rig.dialogue(&format!("M {CLEAR}\nM 68 05 05 68 08 02 7D 00 00 87 16\nS {INPUTS}"));
    assert_eq!(rig.station.user.inputs(8), Some(&[1, 2][..]), "inputs are valid in Clear");
    rig.station.user.set_mode(Mode::Operate);
    rig.dialogue(&format!("M {OPERATE}\nM 68 05 05 68 08 02 5D AA 55 66 16\nS {INPUTS}"));
}

#[test]
fn a_fail_safe_slave_is_cleared_by_outputs_of_length_zero() {
    let slave = SlaveParameters { fail_safe: true, ..SlaveParameters::new(8, IDENT, &CFG) };
    let mut rig = rig_with(&slave);
    rig.station.user.set_mode(Mode::Clear);
    rig.receive(INPUTS);
    rig.dialogue(&format!("M {CLEAR}\nM 10 08 02 5D 67 16\nS {INPUTS}"));
}

#[test]
fn the_outputs_of_a_real_slave_follow_the_mode() {
    let mut line = line(settings(), &[8]);
    line.master.user.outputs_mut(8).unwrap().copy_from_slice(&[7, 7]);
    line.run_for(2_000);
    assert_eq!(line.slaves[0].device().outputs, Some(vec![7, 7]));
    line.master.user.set_mode(Mode::Clear);
    line.run_for(2_000);
    assert_eq!(line.slaves[0].device().outputs, Some(vec![0, 0]));
    line.master.user.set_mode(Mode::Operate);
    line.run_for(2_000);
    assert_eq!(line.slaves[0].device().outputs, Some(vec![7, 7]));
}

#[test]
fn global_control_is_repeated() {
    let mut line = line(Settings { control_cycles: 10, ..settings() }, &[8, 9]);
    line.run_for(10_000);
    let first = line.trace.len();
    let cycles = line.master.user.cycles();
    line.run_for(100_000);
    let reported = line.messages(first).iter().filter(|text| *text == OPERATE).count();
    let expected = ((line.master.user.cycles() - cycles) / 10) as usize;
    assert!(expected > 5 && reported.abs_diff(expected) <= 1, "{reported} times, {expected} expected");
}

#[test]
fn a_slave_that_enters_data_exchange_is_sent_the_mode() {
    let mut line = line(settings(), &[8]);
    line.run_for(10_000);
    let first = line.trace.len();
    line.master.user.restart(8);
    line.run_for(10_000);
    assert_eq!(line.messages(first).iter().filter(|text| *text == OPERATE).count(), 1);
}

#[test]
fn global_control_that_another_master_interrupted_is_sent_later() {
    let mut rig = exchanging();
    rig.station.user.set_mode(Mode::Clear);
    let due = rig.station.wake_at().unwrap();
    assert_eq!(text(rig.station.poll(due).unwrap().octets), CLEAR);
    rig.now = due;
    rig.receive_after(11, "DC 05 05");
    rig.station.sent(rig.now);
    rig.dialogue(&format!("M {CLEAR}"));
}

#[test]
fn a_slave_without_inputs_answers_sc_or_dh_without_data() {
    let slave = SlaveParameters::new(8, IDENT, &[0x21]);
    let mut rig = rig_with(&slave);
    rig.receive("E5");
    assert_eq!(rig.station.user.inputs(8), Some(&[][..]));
    rig.next_request();
    rig.receive("10 02 08 0A 14 16");
    assert_eq!(rig.next_request().octets[7], 0x3C, "a diagnosis is pending");
    rig.receive(READY);
    rig.next_request();
    rig.receive("10 02 08 09 13 16");
    assert_eq!(rig.station.user.counters(8).unwrap().exchanges, 3);
}

#[test]
fn a_slave_without_outputs_is_sent_an_sd1() {
    let slave = SlaveParameters::new(8, IDENT, &[0x11]);
    let mut rig = rig_with(&slave);
    rig.receive(INPUTS);
    assert_eq!(rig.next_request().text(), "10 08 02 5D 67 16");
}

/// profibus-wire 2.3.1 and 2.3.2: the example of the standard, an alarm, a revision, and a truncated list of blocks.
#[test]
fn the_extended_diagnosis_is_returned_entry_by_entry() {
    let octets = hex("04 11 22 33 45 01 10 04 00 80 02 24 8C 06 A7 09 02 03 01 50 01 02 03 04 C5 07 81");
    for (dpv1, device) in [
        (false, ["device: 11 22 33", "device: 02 03 01 50 01 02 03 04"]),
        (
            true,
            [
                "reserved alarm 17 of slot 34, sequence number 6, disappears, others remain",
                "process alarm of slot 3, \
              sequence number 0, appears: 50 01 02 03 04",
            ],
        ),
    ] {
        let slave = SlaveParameters { dpv1, ..SlaveParameters::new(8, IDENT, &CFG) };
        let mut line = line_of(settings(), &[slave]);
        line.slaves[0].device_mut().diagnose(&octets);
        line.run_for(20_000);
        let reported: Vec<_> = line.master.user.ext_diag(8).map(|entry| entry.to_string()).collect();
        let others = [
            "disturbed modules: 0, 12, 18",
            "module 0, channel 2 (bit): overload",
            "module 12, channel 6 (word): upper limit exceeded",
        ];
        assert_eq!((reported[0].as_str(), reported[4].as_str()), (device[0], device[1]));
        assert_eq!(reported[1..4], others);
        assert_eq!(reported[5..], ["revision 5", "the rest is no block"]);
    }
    assert_eq!(line(settings(), &[8]).master.user.ext_diag(99).count(), 0);
}

#[test]
fn a_diagnosis_may_end_data_exchange() {
    for (diag, error, next) in [
        // Another master owns the slave.
        ("68 0B 0B 68 82 88 08 3E 3C 00 0C 00 05 12 34 E3 16", ExchangeError::Owned { master: 5 }, HandlerState::Diag1),
        ("68 0B 0B 68 82 88 08 3E 3C 02 05 00 FF 12 34 D8 16", ExchangeError::PrmReq, HandlerState::Diag1),
    ] {
        let mut rig = rig();
        rig.receive(INPUTS_HIGH);
        rig.next_request();
        rig.receive(diag);
        assert_eq!(rig.station.user.exchange_error(8), Some(error));
        assert_eq!(rig.station.user.state(8), Some(next));
        assert_eq!(rig.station.user.inputs(8), None);
    }
    // Static diagnosis suspends data exchange and does not end it.
    let mut rig = rig();
    rig.receive(INPUTS_HIGH);
    rig.next_request();
    rig.receive("68 0B 0B 68 82 88 08 3E 3C 00 0E 00 02 12 34 E2 16");
    assert!(matches!(rig.station.user.state(8), Some(HandlerState::Diag2 { .. })));
    assert_eq!(rig.station.user.inputs(8), None);
    assert_eq!(rig.next_request().octets[7], 0x3C);
    rig.receive(READY);
    assert_eq!(rig.station.user.state(8), Some(HandlerState::Data { diag: false }));
}

#[test]
fn cycles_keep_the_minimum_cycle_time() {
    let mut line = line(Settings { min_cycle_tbit: 15_000, ..settings() }, &[8, 9]);
    line.run_for(20_000);
    let first = line.trace.len();
    line.run_for(150_000);
    let starts: Vec<_> = line.trace[first..]
        .iter()
        .filter(|entry| entry.from == From::Master && entry.octets.get(4) == Some(&8))
        .map(|entry| entry.start)
        .collect();
    assert!((9..=10).contains(&starts.len()), "{starts:?}");
    for pair in starts.windows(2) {
        assert!((15_000..15_300).contains(&(pair[1] - pair[0])), "{starts:?}");
    }
    assert!((15_000..15_300).contains(&line.master.user.cycle_tbit()));
}
