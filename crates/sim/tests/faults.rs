//! What faults of cable and stations do to a segment, and that it recovers when they end.

#![allow(clippy::unwrap_used, clippy::panic, reason = "a test")]

mod common;

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

/// A master at 2 and slaves at 10, 11 and 12, all of them in data exchange. One after the other along the cable.
fn exchanging() -> (Segment, StationHandle<Class1>, Slaves) {
    let mut bus = Segment::new(BAUD);
    let mut master = Master::<3, 8>::on(BusParameters::new(OWN, BAUD), Settings::new(BAUD), BitTime(0));
    for address in 10..13 {
        let watchdog = Some([10, 5]);
        master.user.add(&SlaveParameters { watchdog, ..SlaveParameters::new(address, IDENT, &CFG) }).unwrap();
    }
    master.user.set_mode(Mode::Operate);
    let slaves =
        [10, 11, 12].map(|address| bus.attach_at(u64::from(address) - 10, Slave::new(Plain::new(), address, BAUD)));
    let master = bus.attach(master);
    bus.run_for(SECOND).unwrap();
    assert_eq!(states(&bus, &slaves), [DATA; 3]);
    (bus, master, slaves)
}

const DATA: &str = "DATA-EXCH";
const LOST: &str = "WAIT-PRM";

fn states(bus: &Segment, slaves: &Slaves) -> [String; 3] {
    slaves.map(|slave| bus.station(slave).state().to_string())
}

fn exchanges(bus: &Segment, master: StationHandle<Class1>) -> [u32; 3] {
    [10, 11, 12].map(|address| bus.station(master).user.counters(address).unwrap().exchanges)
}

fn retries(bus: &Segment, master: StationHandle<Class1>) -> [u32; 3] {
    [10, 11, 12].map(|address| bus.station(master).user.counters(address).unwrap().retries)
}

#[test]
fn a_slave_without_power_is_silent_and_the_others_go_on() {
    let (mut bus, master, slaves) = exchanging();
    bus.inject(Fault::Power(slaves[1].id(), false));
    bus.run_for(SECOND).unwrap();
    let [first, lost, third] = exchanges(&bus, master);
    bus.run_for(SECOND).unwrap();
    let later = exchanges(&bus, master);
    assert!(later[0] > first + 1000 && later[2] > third + 1000);
    assert_eq!(later[1], lost);
    // Power returns, and the slave has forgotten everything.
    bus.station_mut(slaves[1]).power_up(11);
    bus.inject(Fault::Power(slaves[1].id(), true));
    bus.run_for(SECOND).unwrap();
    assert_eq!(states(&bus, &slaves), [DATA; 3]);
    assert!(exchanges(&bus, master)[1] > lost + 1000);
}

#[test]
fn power_lost_inside_a_telegram_cuts_it_off() {
    let mut bus = Segment::new(BAUD);
    let (sender, listener) = (bus.attach(Tester::new()), bus.attach(Tester::new()));
    bus.station_mut(sender).send(BitTime(100), &[0x10, 8, 2, 0x49, 0x53, 0x16]);
    bus.schedule_fault(BitTime(100 + 3 * 11), Fault::Power(sender.id(), false));
    bus.run_until(BitTime(1000)).unwrap();
    assert_eq!((bus.station(listener).characters, bus.station(listener).received.len()), (3, 0));
}

#[test]
fn a_cut_cable_separates_what_is_behind_it() {
    let (mut bus, master, slaves) = exchanging();
    bus.inject(Fault::Cut(Some(1)));
    bus.run_for(2 * SECOND).unwrap();
    assert_eq!(states(&bus, &slaves), [DATA, LOST, LOST], "the watchdogs behind the cut have expired");
    assert_eq!(bus.station(slaves[1]).device().outputs.last(), Some(&None));
    bus.inject(Fault::Cut(None));
    bus.run_for(SECOND).unwrap();
    assert_eq!(states(&bus, &slaves), [DATA; 3]);
    assert_eq!(bus.station(master).user.exchanging(), 3);
}

#[test]
fn a_cable_cut_inside_a_telegram_ends_it_for_those_behind() {
    let mut bus = Segment::new(BAUD);
    let sender = bus.attach(Tester::new());
    let [near, far] = [0, 5].map(|position| bus.attach_at(position, Tester::new()));
    bus.station_mut(sender).send(BitTime(100), &[0x10, 8, 2, 0x49, 0x53, 0x16]);
    bus.schedule_fault(BitTime(100 + 5 + 2 * 11), Fault::Cut(Some(5)));
    bus.run_until(BitTime(1000)).unwrap();
    assert_eq!((bus.station(near).characters, bus.station(near).received.len()), (5, 1));
    assert_eq!((bus.station(far).characters, bus.station(far).received.len()), (2, 0));
}

#[test]
fn both_sides_of_a_cut_are_refereed_by_themselves() {
    // A master on each side; none hears the other, and neither breaks a rule.
    let mut bus = Segment::new(BAUD);
    bus.inject(Fault::Cut(Some(10)));
    let masters = [(2, 0), (3, 20)].map(|(address, position)| {
        let master = Master::<1, 8>::on(BusParameters::new(address, BAUD), Settings::new(BAUD), BitTime(0));
        bus.attach_at(position, master)
    });
    bus.run_for(SECOND).unwrap();
    assert!(masters.iter().all(|master| bus.station(*master).has_token()));
}

#[test]
fn an_echo_is_heard_by_everybody_and_by_the_sender() {
    let mut bus = Segment::new(BAUD);
    let (sender, listener) = (bus.attach(Tester::new()), bus.attach(Tester::new()));
    bus.inject(Fault::Echo(Some(200)));
    bus.station_mut(sender).send(BitTime(100), &[0xDC, 2, 2]);
    bus.run_until(BitTime(1000)).unwrap();
    let ends = |station: &Tester| station.received.iter().map(|heard| heard.end.0).collect::<Vec<_>>();
    assert_eq!(ends(bus.station(sender)), [333]);
    assert_eq!(ends(bus.station(listener)), [133, 333]);
}

#[test]
fn a_stub_that_echoes_damages_everything_until_it_is_gone() {
    let (mut bus, master, slaves) = exchanging();
    bus.inject(Fault::Echo(Some(2)));
    bus.run_for(2 * SECOND).unwrap();
    assert_eq!(states(&bus, &slaves), [LOST; 3]);
    let before = exchanges(&bus, master);
    bus.inject(Fault::Echo(None));
    bus.run_for(SECOND).unwrap();
    assert_eq!(states(&bus, &slaves), [DATA; 3]);
    assert!(exchanges(&bus, master).iter().zip(before).all(|(now, before)| *now > before + 1000));
}

#[test]
fn two_stations_at_one_address_that_say_the_same_are_heard_as_one() {
    let (answers, characters) = two_answers([0x00, 0x00]);
    assert_eq!((answers, characters), (1, 5));
}

#[test]
fn two_stations_at_one_address_that_differ_are_heard_damaged() {
    // FC 00 and 09: the check octets differ too. A 0 wins over a 1, so what is heard has a parity that fits or not.
    let (answers, _) = two_answers([0x00, 0x09]);
    assert_eq!(answers, 0);
}

/// How many telegrams and other characters a master hears when two slaves answer at once with these FC.
fn two_answers(fcs: [u8; 2]) -> (usize, usize) {
    let mut bus = Segment::new(BAUD);
    let master = bus.attach(Tester::new());
    bus.allow(Rule::Collision);
    for fc in fcs {
        bus.attach(MockStation::new(move |end, _: &Telegram<'_>| {
            Some((end + 11, vec![0x10, 2, 8, fc, 10_u8.wrapping_add(fc), 0x16]))
        }));
    }
    bus.station_mut(master).send(BitTime(100), &[0x10, 8, 2, 0x49, 0x53, 0x16]);
    bus.run_until(BitTime(250)).unwrap();
    let master = bus.station(master);
    (master.received.len(), master.characters)
}

#[test]
fn a_babbling_station_stops_the_exchange_until_it_falls_silent() {
    let (mut bus, master, slaves) = exchanging();
    let babbler = bus.attach(Babbler::new(1, bus.now(), bus.now() + 2 * SECOND, 20));
    bus.exempt(babbler.id());
    [Rule::Collision, Rule::Syn, Rule::Id1, Rule::BeforeSlotTime].into_iter().for_each(|rule| bus.allow(rule));
    bus.run_for(2 * SECOND).unwrap();
    assert_eq!(states(&bus, &slaves), [LOST; 3]);
    let before = exchanges(&bus, master);
    bus.run_for(2 * SECOND).unwrap();
    assert_eq!(states(&bus, &slaves), [DATA; 3]);
    assert!(exchanges(&bus, master)[0] > before[0] + 1000);
}

#[test]
fn noise_at_one_station_is_heard_by_no_other() {
    let (mut bus, master, slaves) = exchanging();
    bus.inject(Fault::NoiseAt(slaves[1].id(), Some(Noise::new(5, 1e-3))));
    bus.run_for(SECOND).unwrap();
    let [first, second, third] = retries(&bus, master);
    assert_eq!((first, third), (0, 0));
    assert!(second > 100, "{second} retries");
    bus.inject(Fault::NoiseAt(slaves[1].id(), None));
    bus.run_for(SECOND / 100).unwrap();
    let quiet = retries(&bus, master)[1];
    bus.run_for(SECOND).unwrap();
    assert_eq!(retries(&bus, master)[1], quiet);
}

#[test]
fn who_decodes_for_itself_hears_what_others_hear() {
    // Once the slaves share what they hear, once each of them decodes alone: the line sees no difference.
    let run = |alone: bool| {
        let (mut bus, _, slaves) = exchanging();
        bus.set_trace_length(usize::MAX);
        for slave in slaves.iter().filter(|_| alone) {
            bus.inject(Fault::NoiseAt(slave.id(), None));
        }
        bus.inject(Fault::Noise(Some(Noise::new(9, 3e-4))));
        bus.inject(Fault::OctetErrors(Some(OctetErrors { seed: 10, loss: 0.001, insertion: 0.001 })));
        bus.run_for(2 * SECOND).unwrap();
        bus.trace().to_string()
    };
    assert!(run(false) == run(true));
}

#[test]
fn who_gets_power_inside_a_request_does_not_answer_it() {
    for (on, answers) in [(99 - 33, 1), (100, 0), (101, 0), (165, 0)] {
        let mut bus = Segment::new(BAUD);
        let tester = bus.attach(Tester::new());
        let slaves = [8, 9].map(|address| bus.attach(Slave::<_>::new(Plain::new(), address, BAUD)));
        bus.inject(Fault::Power(slaves[0].id(), false));
        bus.schedule_fault(BitTime(on), Fault::Power(slaves[0].id(), true));
        bus.station_mut(tester).send(BitTime(100), &[0x10, 8, 2, 0x49, 0x53, 0x16]);
        bus.run_until(BitTime(1000)).unwrap();
        assert_eq!(bus.station(tester).received.len(), answers, "power at {on}");
    }
}

#[test]
fn one_damaged_telegram_costs_one_repetition() {
    for tamper in [
        TelegramFault::Flip(vec![3]),
        TelegramFault::Flip(vec![0, 47, 100]),
        TelegramFault::CharacterError(2),
        TelegramFault::Lose(0),
        TelegramFault::Lose(10),
        TelegramFault::Insert(3, 0x55),
    ] {
        let (mut bus, master, slaves) = exchanging();
        // The next telegram of a slave in data exchange is an answer to Data_Exchange.
        bus.inject(Fault::Telegram(slaves[2].id(), tamper.clone()));
        bus.run_for(SECOND).unwrap();
        assert_eq!(retries(&bus, master), [0, 0, 1], "{tamper:?}");
    }
}

#[test]
fn lost_and_added_octets_are_survived() {
    let (mut bus, master, slaves) = exchanging();
    let before = exchanges(&bus, master);
    bus.inject(Fault::OctetErrors(Some(OctetErrors { seed: 6, loss: 0.002, insertion: 0.002 })));
    bus.run_for(2 * SECOND).unwrap();
    assert!(retries(&bus, master).iter().all(|retries| *retries > 10), "{:?}", retries(&bus, master));
    assert!(exchanges(&bus, master).iter().zip(before).all(|(now, before)| *now > before + 1000));
    bus.inject(Fault::OctetErrors(None));
    bus.run_for(SECOND).unwrap();
    assert_eq!(states(&bus, &slaves), [DATA; 3]);
}

#[test]
fn the_same_seed_is_the_same_run() {
    let run = |seed| {
        let (mut bus, _, slaves) = exchanging();
        bus.set_trace_length(usize::MAX);
        bus.inject(Fault::Noise(Some(Noise::new(seed, 1e-4))));
        bus.inject(Fault::NoiseAt(slaves[0].id(), Some(Noise::new(seed + 1, 1e-4))));
        bus.inject(Fault::OctetErrors(Some(OctetErrors { seed, loss: 0.001, insertion: 0.001 })));
        bus.run_for(SECOND).unwrap();
        bus.trace().to_string()
    };
    assert!(run(7) == run(7));
    assert!(run(7) != run(8));
}

#[test]
fn faults_of_the_script_come_at_their_bit_time() {
    let (mut bus, _, slaves) = exchanging();
    let off = bus.now() + 10_000;
    bus.set_trace_length(usize::MAX);
    bus.schedule_fault(off, Fault::Power(slaves[0].id(), false));
    bus.run_for(SECOND).unwrap();
    let answers = bus.trace().entries.iter().filter(|entry| entry.octets.len() == 11 && entry.octets[5] == 10);
    let last = answers.map(|entry| entry.start).max().unwrap();
    assert!(last < off && off - last < 3000, "the last answer begins at {last}, power goes at {off}");
}
