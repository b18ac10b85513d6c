//! A segment on which the station only listens.

use super::fixture::{Fixture, PORT, gauge, polled};
use super::plant::VirtualEdge;
use crate::config;
use crate::segment::edge::{Edge, SegmentCommand};
use crate::segment::heard_line::{HeardLine, RATE_CHECK_INTERVAL};
use crate::segment::runner::PUBLISH_INTERVAL;
use crate::view::{Gauge, SegmentState};
use profivac_dp::link::Baud;
use profivac_recorder::Quality;
use profivac_recorder::validity::MAX_SILENCE;
use std::time::Duration;

/// A segment that hears the gauge of a foreign master.
fn fixture(baud: Baud, detects_baud: bool) -> Fixture<HeardLine> {
    let config = config::Segment { listen_only: true, detects_baud, ..polled(&["chamber bcg450 5"]) };
    Fixture::new(config, VirtualEdge::with_foreign(baud))
}

#[test]
fn the_rate_of_a_line_is_found_and_searched_again_when_it_becomes_another() {
    let mut fixture = fixture(Baud::B187500, true);
    fixture.exchanging("chamber");
    assert_eq!(fixture.segment().baud, 187_500);
    assert!(fixture.events("searched again").is_empty());

    fixture.change(|plant| plant.set_foreign(Baud::B93750));
    let at = fixture.edge.elapsed();
    fixture.until_problem("chamber", "its baud rate is searched again");
    let noticed = fixture.edge.elapsed() - at;
    assert!(noticed <= RATE_CHECK_INTERVAL * 2, "{noticed:?}");
    assert_eq!(fixture.segment().state, SegmentState::Waiting);
    fixture.exchanging("chamber");
    assert_eq!(fixture.segment().baud, 93_750);
    assert_eq!(fixture.events("at 187.5 kbit/s: its baud rate is searched again").len(), 1);
}

#[test]
fn a_line_without_telegrams_is_tried_again_until_it_has_some() {
    let mut fixture = fixture(Baud::B187500, true);
    fixture.change(|plant| plant.is_silent = true);
    fixture.until_problem("chamber", "no telegram");
    fixture.run_for(Duration::from_secs(300));
    assert_eq!(fixture.segment().state, SegmentState::Waiting);
    fixture.change(|plant| plant.is_silent = false);
    fixture.exchanging("chamber");
}

#[test]
fn a_lost_port_is_opened_again_and_what_was_heard_is_kept() {
    let mut fixture = fixture(Baud::B187500, false);
    let heard = fixture.exchanging("chamber");
    fixture.change(|plant| plant.is_gone = true);
    fixture.until_problem("chamber", &format!("lost {PORT}"));
    fixture.run_for(Duration::from_secs_f64(4.0));
    assert_eq!(fixture.pauses(), [0.5, 1.0, 1.0, 1.0], "a listener misses what happens meanwhile");
    fixture.change(|plant| plant.is_gone = false);
    let again = fixture.exchanging("chamber");
    assert_eq!(again.assumptions, heard.assumptions);
    assert_eq!(fixture.events("listening on").len(), 2);
}

/// The time of the line stands still while no port is open: the last data exchange looks as young as before the loss.
#[test]
fn a_data_exchange_from_before_a_lost_port_is_no_reading_of_the_port_that_was_opened_again() {
    for gone in [Duration::from_millis(100), Duration::from_secs(30)] {
        let mut fixture = fixture(Baud::B187500, false);
        fixture.exchanging("chamber");
        fixture.run_for(Duration::from_secs(1));
        let returns = |fixture: &Fixture<HeardLine>| fixture.events("chamber: in data exchange").len();
        let before = returns(&fixture);
        fixture.change(|plant| plant.is_gone = true);
        let lost = fixture.until_problem("chamber", &format!("lost {PORT}"));
        fixture.run_for(gone);
        fixture.change(|plant| (plant.is_gone, plant.is_silent) = (false, true));
        fixture.run_for(Duration::from_secs(10));
        let silent = fixture.gauge("chamber");
        assert_eq!((fixture.segment().state, silent.lost_at), (SegmentState::Listening, lost.lost_at), "{gone:?}");
        let gap = *fixture.samples("chamber").last().unwrap();
        assert_eq!((gap.quality, Some(gap.at)), (Quality::Stale, lost.lost_at), "{gone:?}");
        assert_eq!(returns(&fixture), before, "{gone:?}");

        let begin = fixture.edge.now().wall;
        fixture.change(|plant| plant.is_silent = false);
        fixture.exchanging("chamber");
        let samples = fixture.samples("chamber");
        let after: Vec<_> = samples.iter().filter(|sample| sample.at > gap.at).collect();
        assert!(!after.is_empty() && after.iter().all(|sample| sample.at > begin), "{gone:?}: {samples:?}");
        assert_eq!(returns(&fixture), before + 1, "{gone:?}");
    }
}

#[test]
fn the_loss_of_a_heard_gauge_has_the_time_of_the_decision_everywhere() {
    let mut fixture = fixture(Baud::B187500, false);
    fixture.exchanging("chamber");
    fixture.run_for(Duration::from_secs(2));
    fixture.change(|plant| plant.is_silent = true);
    let is_lost = |gauge: &Gauge| gauge.readings[0].quality == Quality::Stale;
    let lost = fixture.until("chamber", Duration::from_secs(5), is_lost);
    let (read_at, lost_at) = (lost.read_at.unwrap(), lost.lost_at.unwrap());
    assert!(lost_at >= read_at.after(MAX_SILENCE), "{read_at:?} {lost_at:?}");
    assert!(lost_at <= read_at.after(MAX_SILENCE + PUBLISH_INTERVAL * 2), "{read_at:?} {lost_at:?}");
    let samples = fixture.samples("chamber");
    let [.., last, gap] = samples[..] else { panic!("{samples:?}") };
    assert_eq!((gap.quality, gap.at, last.at), (Quality::Stale, lost_at, read_at));
    assert!(fixture.events("chamber: ").iter().any(|event| event.at == lost_at), "{:?}", fixture.events("chamber: "));
}

/// Its inputs cannot be decoded without the model in the file: the start-up of the slave was not heard.
#[test]
fn a_gauge_that_the_file_got_is_heard_also_at_another_rate() {
    let config = config::Segment { listen_only: true, detects_baud: true, ..polled(&["other bcg450 9"]) };
    let mut fixture = Fixture::<HeardLine>::new(config, VirtualEdge::with_foreign(Baud::B187500));
    fixture.commands.send(SegmentCommand::Gauges(vec![gauge("chamber bcg450 5")])).unwrap();
    fixture.run_for(Duration::from_secs(1));
    fixture.exchanging("chamber");
    fixture.change(|plant| plant.set_foreign(Baud::B93750));
    fixture.until_problem("chamber", "its baud rate is searched again");
    fixture.exchanging("chamber");
}

#[test]
fn a_heard_gauge_that_is_sampled_seldom_has_a_reading_soon_after_it_was_lost() {
    let slow = config::Gauge { poll: Duration::from_hours(1), ..gauge("chamber bcg450 5") };
    let config = config::Segment { listen_only: true, gauges: vec![slow], ..polled(&[]) };
    let mut fixture = Fixture::<HeardLine>::new(config, VirtualEdge::with_foreign(Baud::B187500));
    fixture.exchanging("chamber");
    fixture.change(|plant| plant.is_gone = true);
    fixture.until_problem("chamber", "lost");
    fixture.change(|plant| (plant.is_gone, plant.is_silent) = (false, true));
    fixture.until_problem("chamber", "not heard any more");
    fixture.change(|plant| plant.is_silent = false);
    fixture.exchanging("chamber");
}

#[test]
fn a_shorter_interval_of_a_heard_gauge_holds_at_once_and_not_after_the_former_one() {
    let slow = config::Gauge { poll: Duration::from_hours(1), ..gauge("chamber bcg450 5") };
    let config = config::Segment { listen_only: true, gauges: vec![slow], ..polled(&[]) };
    let mut fixture = Fixture::<HeardLine>::new(config, VirtualEdge::with_foreign(Baud::B187500));
    let first = fixture.exchanging("chamber");
    fixture.commands.send(SegmentCommand::Gauges(vec![gauge("chamber bcg450 5")])).unwrap();
    fixture.until("chamber", Duration::from_secs(1), |gauge| gauge.read_at > first.read_at);
}

#[test]
fn a_heard_gauge_with_another_name_ends_its_series_with_a_gap_and_begins_another_one_at_once() {
    let mut fixture = fixture(Baud::B187500, false);
    fixture.exchanging("chamber");
    let slow = config::Gauge { poll: Duration::from_mins(1), ..gauge("target bcg450 5") };
    fixture.commands.send(SegmentCommand::Gauges(vec![slow])).unwrap();
    fixture.run_for(PUBLISH_INTERVAL * 2);
    assert_eq!(fixture.samples("chamber").last().unwrap().quality, Quality::Stale);
    assert_eq!(fixture.gauge("target").readings[0].series, "target");
    let [first] = fixture.samples("target")[..] else { panic!("{:?}", fixture.samples("target")) };
    assert_eq!(first.quality, Quality::Valid);
}

#[test]
fn no_loss_ends_a_listening_segment() {
    let mut fixture = fixture(Baud::B187500, true);
    for _ in 0..2 {
        fixture.exchanging("chamber");
        fixture.change(|plant| plant.is_gone = true);
        fixture.run_for(Duration::from_secs(200));
        fixture.change(|plant| (plant.is_gone, plant.is_silent) = (false, true));
        fixture.run_for(Duration::from_secs(200));
        fixture.change(|plant| plant.is_silent = false);
    }
    fixture.exchanging("chamber");
    fixture.commands.send(SegmentCommand::Stop).unwrap();
    while fixture.step() {}
    assert_eq!(fixture.samples("chamber").last().unwrap().quality, Quality::Stale, "the end is a gap");
}
