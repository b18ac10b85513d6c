//! Traces as text and as capture files, written and read back.

#![allow(clippy::unwrap_used, clippy::panic, reason = "a test")]

use crate::common;
use crate::golden;

use common::{CFG, IDENT, OWN, Plain};
use golden::compare;
use profivac_dp::link::active::BusParameters;
use profivac_dp::link::{Baud, BitTime};
use profivac_dp::master::{Master, Mode, Settings, SlaveParameters};
use profivac_dp::slave::{Features, Slave};
use profivac_sim::dialogue::Dialogue;
use profivac_sim::stations::Tester;
use profivac_sim::trace::{Entry, pcapng};
use profivac_sim::{Fault, Noise, OctetErrors, Rule, Segment, TelegramFault, Trace};

/// The start-up of profibus-wire 2.13 with a slave of this project instead of the recorded one: the ident number and the
/// configuration differ, the other telegrams are equal.
const START_UP: &str = "
    +400    ->  10 08 02 49 53 16
    11..60  <-  10 02 08 00 0A 16
    +60     ->  68 05 05 68 88 82 6D 3C 3E F1 16
    11..60  <-  68 0B 0B 68 82 88 08 3E 3C 02 05 00 FF 12 34 D8 16
    +60     ->  68 0F 0F 68 88 82 5D 3D 3E B8 1E 01 00 12 34 01 00 00 00 00 16
    11..60  <-  E5
    +60     ->  68 07 07 68 88 82 7D 3E 3E 11 21 35 16
    11..60  <-  E5
    +60     ->  68 05 05 68 88 82 5D 3C 3E E1 16
    11..60  <-  68 0B 0B 68 82 88 08 3E 3C 00 0C 00 02 12 34 E0 16
    +60     ->  68 05 05 68 08 02 7D AA 55 86 16
    11..60  <-  68 05 05 68 02 08 08 01 00 13 16
    +60     ->  68 07 07 68 FF 82 46 3A 3E 02 00 41 16
    +150    ->  DC 02 02
";

fn started() -> Dialogue<Slave<Plain>> {
    let device = Plain { features: Features { sync: true, freeze: true, ..Features::default() }, ..Plain::new() };
    let mut talk = Dialogue::new(Baud::B500000, Slave::new(device, 8, Baud::B500000));
    talk.play(START_UP).unwrap();
    talk
}

#[test]
fn the_trace_of_a_start_up_matches_the_golden_file() {
    let mut talk = started();
    // The rest is damaged: an inverted bit, a lost octet, octets that are no telegram.
    let tester = talk.tester();
    talk.segment.inject(Fault::Telegram(tester, TelegramFault::Flip(vec![25])));
    talk.play("+60 -> 68 05 05 68 08 02 5D AA 55 66 16\n100 <- nothing").unwrap();
    talk.segment.inject(Fault::Telegram(tester, TelegramFault::Lose(7)));
    talk.play("+60 -> 68 05 05 68 08 02 5D AA 55 66 16\n100 <- nothing").unwrap();
    talk.play("+60 -> 00 FF").unwrap();
    compare("crates/sim/tests/trace-start-up.txt", &talk.segment.trace().to_string());
}

/// A second of data exchange with all kinds of damage.
fn disturbed() -> Trace {
    let baud = Baud::B12000000;
    let mut segment = Segment::new(baud);
    let mut master =
        Master::<1, 8>::on(BusParameters::new(OWN, baud).check().unwrap(), Settings::new(baud), BitTime(0));
    master.user.add(&SlaveParameters::new(8, IDENT, &CFG)).unwrap();
    master.user.set_mode(Mode::Operate);
    segment.attach(master);
    segment.attach(Slave::new(Plain::new(), 8, baud));
    segment.set_trace_length(usize::MAX);
    segment.inject(Fault::Noise(Some(Noise::new(11, 1e-4))));
    segment.inject(Fault::OctetErrors(Some(OctetErrors { seed: 12, loss: 0.001, insertion: 0.001 })));
    segment.run_until(BitTime(12_000_000)).unwrap();
    let trace = segment.trace().clone();
    assert!(trace.entries.len() > 10_000);
    assert!(trace.entries.iter().filter(|entry| !entry.errors.is_empty()).count() > 100);
    trace
}

/// A trace as text and capture files have it: without pauses inside the telegrams.
fn readable(mut trace: Trace) -> Trace {
    for entry in &mut trace.entries {
        *entry = Entry::new(entry.start, entry.octets.clone(), entry.errors.clone());
    }
    trace
}

#[test]
fn a_trace_is_read_back_from_text() {
    let trace = readable(disturbed());
    assert!(trace.to_string().parse() == Ok(trace));
}

#[test]
fn a_trace_is_read_back_from_a_capture_file() {
    let trace = readable(disturbed());
    for link_type in [pcapng::PROFIBUS_DL, pcapng::USER0] {
        assert!(pcapng::read(&pcapng::write(&trace, link_type), Baud::B9600).as_ref() == Ok(&trace));
    }
}

#[test]
fn a_trace_keeps_the_requested_number_of_telegrams() {
    let mut segment = Segment::new(Baud::B500000);
    let tester = segment.attach(Tester::new());
    for (kept, until) in [(100, 50), (5, 60), (1, 70)] {
        segment.set_trace_length(kept);
        (until - 10..until).for_each(|turn| segment.station_mut(tester).send(BitTime(turn * 1000), &[0xDC, 2, 2]));
        segment.run_until(BitTime(until * 1000)).unwrap();
        let starts: Vec<u64> = segment.trace().entries.iter().map(|entry| entry.start.0).collect();
        assert_eq!(starts.len(), kept.min(10));
        assert_eq!(starts.last(), Some(&((until - 1) * 1000)));
    }
}

/// A request of 66 bit times with a pause of 30, and one that lost an octet: both end when their sender ends.
#[test]
fn an_entry_ends_with_its_last_stop_bit_although_the_sender_paused() {
    for (fault, duration) in [(TelegramFault::Pause(2, 30), 96), (TelegramFault::Lose(2), 66)] {
        let mut segment = Segment::new(Baud::B500000);
        let tester = segment.attach(Tester::new());
        segment.allow(Rule::Gap);
        segment.inject(Fault::Telegram(tester.id(), fault.clone()));
        segment.station_mut(tester).send(BitTime(100), &[0x10, 8, 2, 0x49, 0x53, 0x16]);
        segment.run_until(BitTime(1000)).unwrap();
        assert_eq!(segment.trace().entries[0].end(), BitTime(100 + duration), "{fault:?}");
    }
}
