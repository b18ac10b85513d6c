//! Effects of faults of cable and stations on a segment, and its recovery when they end.

#![allow(clippy::unwrap_used, clippy::panic, reason = "a test")]

use crate::common;

use common::{CFG, IDENT, OWN, Plain};
use profivac_dp::link::active::{Active, BusParameters};
use profivac_dp::link::{Baud, BitTime};
use profivac_dp::master::{Master, Mode, Settings, SlaveParameters};
use profivac_dp::slave::Slave;
use profivac_sim::stations::{Babbler, MockStation, Tester};
use profivac_sim::{Fault, Noise, OctetErrors, Rule, Segment, StationHandle, TelegramFault};
use profivac_wire::Telegram;

const BAUD: Baud = Baud::B1500000;
const SECOND: u64 = 1_500_000;

type Class1 = Active<Master<3, 8>>;
type Slaves = [StationHandle<Slave<Plain>>; 3];

/// A master at 2 and slaves at 10, 11 and 12 at different positions of the cable, all slaves in data exchange.
fn exchanging() -> (Segment, StationHandle<Class1>, Slaves) {
    let mut segment = Segment::new(BAUD);
    let mut master =
        Master::<3, 8>::on(BusParameters::new(OWN, BAUD).check().unwrap(), Settings::new(BAUD), BitTime(0));
    for address in 10..13 {
        let watchdog = Some([10, 5]);
        master.user.add(&SlaveParameters { watchdog, ..SlaveParameters::new(address, IDENT, &CFG) }).unwrap();
    }
    master.user.set_mode(Mode::Operate);
    let slaves =
        [10, 11, 12].map(|address| segment.attach_at(u64::from(address) - 10, Slave::new(Plain::new(), address, BAUD)));
    let master = segment.attach(master);
    segment.run_for(SECOND).unwrap();
    assert_eq!(states(&segment, &slaves), [DATA; 3]);
    (segment, master, slaves)
}

const DATA: &str = "DATA-EXCH";
const LOST: &str = "WAIT-PRM";

fn states(segment: &Segment, slaves: &Slaves) -> [String; 3] {
    slaves.map(|slave| segment.station(slave).state().to_string())
}

fn exchanges(segment: &Segment, master: StationHandle<Class1>) -> [u32; 3] {
    [10, 11, 12].map(|address| segment.station(master).user.counters(address).unwrap().exchanges)
}

fn repetitions(segment: &Segment, master: StationHandle<Class1>) -> [u32; 3] {
    [10, 11, 12].map(|address| segment.station(master).user.counters(address).unwrap().repetitions)
}

#[test]
fn a_slave_without_power_is_silent_and_the_others_continue() {
    let (mut segment, master, slaves) = exchanging();
    segment.inject(Fault::Power(slaves[1].id(), false));
    segment.run_for(SECOND).unwrap();
    let [first, lost, third] = exchanges(&segment, master);
    segment.run_for(SECOND).unwrap();
    let later = exchanges(&segment, master);
    assert!(later[0] > first + 1000 && later[2] > third + 1000);
    assert_eq!(later[1], lost);
    // Power returns; the slave has lost its state.
    segment.station_mut(slaves[1]).power_up(11);
    segment.inject(Fault::Power(slaves[1].id(), true));
    segment.run_for(SECOND).unwrap();
    assert_eq!(states(&segment, &slaves), [DATA; 3]);
    assert!(exchanges(&segment, master)[1] > lost + 1000);
}

#[test]
fn power_lost_inside_a_telegram_cuts_it_off() {
    let mut segment = Segment::new(BAUD);
    let (sender, listener) = (segment.attach(Tester::new()), segment.attach(Tester::new()));
    segment.station_mut(sender).send(BitTime(100), &[0x10, 8, 2, 0x49, 0x53, 0x16]);
    segment.schedule_fault(BitTime(100 + 3 * 11), Fault::Power(sender.id(), false));
    segment.run_until(BitTime(1000)).unwrap();
    assert_eq!((segment.station(listener).characters, segment.station(listener).received.len()), (3, 0));
}

#[test]
fn a_cut_cable_separates_the_stations_behind_it() {
    let (mut segment, master, slaves) = exchanging();
    segment.inject(Fault::Cut(Some(1)));
    segment.run_for(2 * SECOND).unwrap();
    assert_eq!(states(&segment, &slaves), [DATA, LOST, LOST], "the watchdogs behind the cut have expired");
    assert_eq!(segment.station(slaves[1]).device().outputs.last(), Some(&None));
    segment.inject(Fault::Cut(None));
    segment.run_for(SECOND).unwrap();
    assert_eq!(states(&segment, &slaves), [DATA; 3]);
    assert_eq!(segment.station(master).user.exchanging(), 3);
}

#[test]
fn a_cable_cut_inside_a_telegram_ends_it_for_the_stations_behind() {
    let mut segment = Segment::new(BAUD);
    let sender = segment.attach(Tester::new());
    let [near, far] = [0, 5].map(|position| segment.attach_at(position, Tester::new()));
    segment.station_mut(sender).send(BitTime(100), &[0x10, 8, 2, 0x49, 0x53, 0x16]);
    segment.schedule_fault(BitTime(100 + 5 + 2 * 11), Fault::Cut(Some(5)));
    segment.run_until(BitTime(1000)).unwrap();
    assert_eq!((segment.station(near).characters, segment.station(near).received.len()), (5, 1));
    assert_eq!((segment.station(far).characters, segment.station(far).received.len()), (2, 0));
}

#[test]
fn each_side_of_a_cut_has_its_own_referee() {
    // A master on each side: they do not receive each other, and neither violates a rule.
    let mut segment = Segment::new(BAUD);
    segment.inject(Fault::Cut(Some(10)));
    let masters = [(2, 0), (3, 20)].map(|(address, position)| {
        let master =
            Master::<1, 8>::on(BusParameters::new(address, BAUD).check().unwrap(), Settings::new(BAUD), BitTime(0));
        segment.attach_at(position, master)
    });
    segment.run_for(SECOND).unwrap();
    assert!(masters.iter().all(|master| segment.station(*master).has_token()));
}

#[test]
fn every_station_and_the_sender_receive_an_echo() {
    let mut segment = Segment::new(BAUD);
    let (sender, listener) = (segment.attach(Tester::new()), segment.attach(Tester::new()));
    segment.inject(Fault::Echo(Some(200)));
    segment.station_mut(sender).send(BitTime(100), &[0xDC, 2, 2]);
    segment.run_until(BitTime(1000)).unwrap();
    let ends = |station: &Tester| station.received.iter().map(|heard| heard.end.0).collect::<Vec<_>>();
    assert_eq!(ends(segment.station(sender)), [333]);
    assert_eq!(ends(segment.station(listener)), [133, 333]);
}

#[test]
fn a_stub_with_echo_damages_all_telegrams_until_it_is_removed() {
    let (mut segment, master, slaves) = exchanging();
    segment.inject(Fault::Echo(Some(2)));
    segment.run_for(2 * SECOND).unwrap();
    assert_eq!(states(&segment, &slaves), [LOST; 3]);
    let before = exchanges(&segment, master);
    segment.inject(Fault::Echo(None));
    segment.run_for(SECOND).unwrap();
    assert_eq!(states(&segment, &slaves), [DATA; 3]);
    assert!(exchanges(&segment, master).iter().zip(before).all(|(now, before)| *now > before + 1000));
}

#[test]
fn equal_answers_of_two_stations_at_one_address_are_received_as_one() {
    let (answers, characters) = two_answers([0x00, 0x00]);
    assert_eq!((answers, characters), (1, 5));
}

#[test]
fn different_answers_of_two_stations_at_one_address_are_received_damaged() {
    // FC 00 and 09: the check octets differ as well. A 0 wins over a 1, so the received parity may be right or wrong.
    let (answers, _) = two_answers([0x00, 0x09]);
    assert_eq!(answers, 0);
}

/// The number of telegrams and of other characters that a master receives when two slaves answer at once with these FC.
fn two_answers(fcs: [u8; 2]) -> (usize, usize) {
    let mut segment = Segment::new(BAUD);
    let master = segment.attach(Tester::new());
    segment.allow(Rule::Collision);
    for fc in fcs {
        segment.attach(MockStation::new(move |end, _: &Telegram<'_>| {
            Some((end + 11, vec![0x10, 2, 8, fc, 10_u8.wrapping_add(fc), 0x16]))
        }));
    }
    segment.station_mut(master).send(BitTime(100), &[0x10, 8, 2, 0x49, 0x53, 0x16]);
    segment.run_until(BitTime(250)).unwrap();
    let master = segment.station(master);
    (master.received.len(), master.characters)
}

#[test]
fn a_babbling_station_stops_data_exchange_until_it_is_silent() {
    let (mut segment, master, slaves) = exchanging();
    let babbler = segment.attach(Babbler::new(1, segment.now(), segment.now() + 2 * SECOND, 20));
    segment.exempt(babbler.id());
    [Rule::Collision, Rule::Syn, Rule::Id1, Rule::BeforeSlotTime].into_iter().for_each(|rule| segment.allow(rule));
    segment.run_for(2 * SECOND).unwrap();
    assert_eq!(states(&segment, &slaves), [LOST; 3]);
    let before = exchanges(&segment, master);
    segment.run_for(2 * SECOND).unwrap();
    assert_eq!(states(&segment, &slaves), [DATA; 3]);
    assert!(exchanges(&segment, master)[0] > before[0] + 1000);
}

#[test]
fn noise_at_one_station_affects_no_other() {
    let (mut segment, master, slaves) = exchanging();
    segment.inject(Fault::NoiseAt(slaves[1].id(), Some(Noise::new(5, 1e-3))));
    segment.run_for(SECOND).unwrap();
    let [first, second, third] = repetitions(&segment, master);
    assert_eq!((first, third), (0, 0));
    assert!(second > 100, "{second} repetitions");
    segment.inject(Fault::NoiseAt(slaves[1].id(), None));
    segment.run_for(SECOND / 100).unwrap();
    let quiet = repetitions(&segment, master)[1];
    segment.run_for(SECOND).unwrap();
    assert_eq!(repetitions(&segment, master)[1], quiet);
}

#[test]
fn a_separate_tap_receives_the_same_as_a_shared_one() {
    // The slaves share a tap in one run and have separate taps in the other: the traces are equal.
    let run = |alone: bool| {
        let (mut segment, _, slaves) = exchanging();
        segment.set_trace_length(usize::MAX);
        for slave in slaves.iter().filter(|_| alone) {
            segment.inject(Fault::NoiseAt(slave.id(), None));
        }
        segment.inject(Fault::Noise(Some(Noise::new(9, 3e-4))));
        segment.inject(Fault::OctetErrors(Some(OctetErrors { seed: 10, loss: 0.001, insertion: 0.001 })));
        segment.run_for(2 * SECOND).unwrap();
        segment.trace().to_string()
    };
    assert!(run(false) == run(true));
}

#[test]
fn a_slave_that_gets_power_inside_a_request_does_not_answer_it() {
    for (on, answers) in [(99 - 33, 1), (100, 0), (101, 0), (165, 0)] {
        let mut segment = Segment::new(BAUD);
        let tester = segment.attach(Tester::new());
        let slaves = [8, 9].map(|address| segment.attach(Slave::<_>::new(Plain::new(), address, BAUD)));
        segment.inject(Fault::Power(slaves[0].id(), false));
        segment.schedule_fault(BitTime(on), Fault::Power(slaves[0].id(), true));
        segment.station_mut(tester).send(BitTime(100), &[0x10, 8, 2, 0x49, 0x53, 0x16]);
        segment.run_until(BitTime(1000)).unwrap();
        assert_eq!(segment.station(tester).received.len(), answers, "power at {on}");
    }
}

#[test]
fn one_damaged_telegram_costs_one_repetition() {
    for fault in [
        TelegramFault::Flip(vec![3]),
        TelegramFault::Flip(vec![0, 47, 100]),
        TelegramFault::CharacterError(2),
        TelegramFault::Lose(0),
        TelegramFault::Lose(10),
        TelegramFault::Insert(3, 0x55),
    ] {
        let (mut segment, master, slaves) = exchanging();
        // The next telegram of a slave in data exchange is the answer to Data_Exchange.
        segment.inject(Fault::Telegram(slaves[2].id(), fault.clone()));
        segment.run_for(SECOND).unwrap();
        assert_eq!(repetitions(&segment, master), [0, 0, 1], "{fault:?}");
    }
}

#[test]
fn data_exchange_survives_lost_and_inserted_octets() {
    let (mut segment, master, slaves) = exchanging();
    let before = exchanges(&segment, master);
    segment.inject(Fault::OctetErrors(Some(OctetErrors { seed: 6, loss: 0.002, insertion: 0.002 })));
    segment.run_for(2 * SECOND).unwrap();
    assert!(
        repetitions(&segment, master).iter().all(|repetitions| *repetitions > 10),
        "{:?}",
        repetitions(&segment, master)
    );
    assert!(exchanges(&segment, master).iter().zip(before).all(|(now, before)| *now > before + 1000));
    segment.inject(Fault::OctetErrors(None));
    segment.run_for(SECOND).unwrap();
    assert_eq!(states(&segment, &slaves), [DATA; 3]);
}

#[test]
fn the_same_seed_gives_the_same_run() {
    let run = |seed| {
        let (mut segment, _, slaves) = exchanging();
        segment.set_trace_length(usize::MAX);
        segment.inject(Fault::Noise(Some(Noise::new(seed, 1e-4))));
        segment.inject(Fault::NoiseAt(slaves[0].id(), Some(Noise::new(seed + 1, 1e-4))));
        segment.inject(Fault::OctetErrors(Some(OctetErrors { seed, loss: 0.001, insertion: 0.001 })));
        segment.run_for(SECOND).unwrap();
        segment.trace().to_string()
    };
    assert!(run(7) == run(7));
    assert!(run(7) != run(8));
}

#[test]
fn scheduled_faults_begin_at_their_bit_time() {
    let (mut segment, _, slaves) = exchanging();
    let off = segment.now() + 10_000;
    segment.set_trace_length(usize::MAX);
    segment.schedule_fault(off, Fault::Power(slaves[0].id(), false));
    segment.run_for(SECOND).unwrap();
    let answers = segment.trace().entries.iter().filter(|entry| entry.octets.len() == 11 && entry.octets[5] == 10);
    let last = answers.map(|entry| entry.start).max().unwrap();
    assert!(last < off && off - last < 3000, "the last answer begins at {last}, the power is switched off at {off}");
}

#[test]
#[should_panic(expected = "station #1 does not belong to this segment")]
fn a_fault_of_a_station_of_another_segment_is_an_error_of_the_caller() {
    let mut other = Segment::new(Baud::B500000);
    other.attach(Tester::new());
    let station = other.attach(Tester::new()).id();
    Segment::new(Baud::B500000).inject(Fault::Power(station, false));
}
