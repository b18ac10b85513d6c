//! A segment whose gauges the station polls.

use super::fixture::{Fixture, POLL, PORT, gauge, polled};
use super::plant::VirtualEdge;
use crate::config;
use crate::segment::edge::{Edge, SegmentCommand};
use crate::segment::planned_segments;
use crate::segment::polled_line::PolledLine;
use crate::segment::runner::PUBLISH_INTERVAL;
use crate::view::{BusStationState, Gauge};
use profivac_recorder::validity::MAX_SILENCE;
use profivac_recorder::{Micros, Quality};
use std::time::Duration;

/// A time in which each missing gauge is searched several times.
const LONG: Duration = Duration::from_secs(15);

fn fixture(devices: &[&str], gauges: &[&str]) -> Fixture<PolledLine> {
    Fixture::new(polled(gauges), VirtualEdge::with_slaves(devices))
}

/// The number of samples of `chamber` in [`LONG`].
fn samples_of_chamber(fixture: &mut Fixture<PolledLine>) -> u32 {
    let before = fixture.count("chamber");
    fixture.run_for(LONG);
    fixture.count("chamber") - before
}

#[test]
fn gauges_that_are_absent_or_answer_no_class_2_master_do_not_slow_the_others() {
    let mut alone = fixture(&["bcg450@5"], &["chamber bcg450 5"]);
    alone.exchanging("chamber");
    let possible = samples_of_chamber(&mut alone);
    assert!(u128::from(possible) * 10 >= LONG.as_millis() / POLL.as_millis() * 9, "alone: {possible}");

    let gauges = ["chamber bcg450 5", "silent bcg450 6", "absent bcg450 7", "away psg550 8", "gone bcg450 9"];
    let mut fixture = fixture(&["bcg450@5", "bcg450@6"], &gauges);
    fixture.change(|plant| plant.set_ms2(6, false));
    fixture.exchanging("chamber");
    fixture.until_problem("silent", "unit of the slave at address 6 cannot be read");
    for name in ["absent", "away", "gone"] {
        fixture.until_problem(name, "no slave answers");
    }
    let samples = samples_of_chamber(&mut fixture);
    assert!(samples * 10 >= possible * 9, "{samples} of {possible} samples");
    fixture.change(|plant| plant.set_ms2(6, true));
    fixture.exchanging("silent");
}

#[test]
fn a_gauge_is_awaited_until_it_answers_or_its_search_ends() {
    let gauges = ["chamber bcg450 5", "absent bcg450 6", "away bcg450 7"];
    let mut fixture = fixture(&["bcg450@5"], &gauges);
    assert!(["chamber", "absent", "away"].iter().all(|name| fixture.gauge(name).is_awaited), "no port is open yet");
    assert!(!fixture.exchanging("chamber").is_awaited);
    for name in ["absent", "away"] {
        assert!(!fixture.until_problem(name, "no slave answers").is_awaited, "{name}");
    }
    fixture.change(|plant| plant.is_gone = true);
    fixture.until_problem("away", "lost");
    fixture.change(|plant| plant.is_gone = false);
    fixture.until_problem("away", "no slave answers");
}

/// An adapter with a loose contact: each opening used to begin the wait again.
#[test]
fn a_gauge_is_missed_on_a_port_that_is_lost_every_few_seconds() {
    let mut fixture = fixture(&[], &["absent bcg450 6", "away bcg450 7"]);
    for _ in 0..12 {
        fixture.change(|plant| plant.is_gone = false);
        fixture.run_for(Duration::from_secs(5));
        fixture.change(|plant| plant.is_gone = true);
        fixture.run_for(Duration::from_millis(100));
    }
    assert!(["absent", "away"].iter().all(|name| !fixture.gauge(name).is_awaited));
}

#[test]
fn a_port_that_is_lost_is_opened_again_after_growing_pauses() {
    let mut fixture = fixture(&["bcg450@5"], &["chamber bcg450 5"]);
    fixture.exchanging("chamber");
    let lost = format!("lost {PORT}");
    for _ in 0..2 {
        fixture.change(|plant| plant.is_gone = true);
        let gauge = fixture.until_problem("chamber", &lost);
        assert_eq!((gauge.state, gauge.readings[0].quality), (BusStationState::Missing, Quality::Stale));
        assert!(fixture.segment().problem.is_some_and(|problem| problem.contains(&lost)));
        fixture.run_for(Duration::from_secs(95));
        assert_eq!(fixture.pauses(), [0.5, 1.0, 2.0, 4.0, 8.0, 16.0, 30.0, 30.0]);
        fixture.change(|plant| plant.is_gone = false);
        fixture.exchanging("chamber");
    }
    let (opened, lost) = (fixture.events("is open"), fixture.events(&format!("segment hall: {lost}")));
    assert_eq!((opened.len(), lost.len()), (3, 2), "one event for each loss, however often the port is tried");
}

#[test]
fn a_loss_has_the_time_at_which_the_station_decides_it() {
    let mut fixture = fixture(&["bcg450@5"], &["chamber bcg450 5"]);
    let measured = fixture.exchanging("chamber");
    assert_eq!(measured.lost_at, None);
    fixture.run_for(Duration::from_secs(2));
    fixture.change(|plant| plant.is_silent = true);

    // The master gives a slave up that answers no poll, and no reading outlasts a silence of a second.
    let is_lost = |gauge: &Gauge| gauge.readings[0].quality == Quality::Stale;
    let lost = fixture.until("chamber", Duration::from_secs(5), is_lost);
    let (read_at, lost_at) = (lost.read_at.unwrap(), lost.lost_at.unwrap());
    assert!(lost_at > read_at, "{read_at:?} {lost_at:?}");
    assert!(lost_at <= read_at.after(MAX_SILENCE + PUBLISH_INTERVAL), "{read_at:?} {lost_at:?}");
    let samples = fixture.samples("chamber");
    let [.., last, gap] = samples[..] else { panic!("{samples:?}") };
    assert_eq!((gap.quality, gap.at), (Quality::Stale, lost_at), "the database");
    assert_eq!((last.quality, last.at), (Quality::Valid, read_at), "the last reading");

    // The same loss keeps its time while the gauge is searched.
    fixture.run_for(Duration::from_secs(1));
    assert_eq!(fixture.gauge("chamber").lost_at, Some(lost_at));
    let searched = fixture.until_problem("chamber", "no slave answers");
    assert_eq!((searched.state, searched.read_at), (BusStationState::Missing, Some(read_at)));
    assert_eq!(searched.lost_at, Some(lost_at));

    fixture.change(|plant| plant.is_silent = false);
    let back = fixture.exchanging("chamber");
    assert_eq!(back.lost_at, None);
    assert!(back.read_at > Some(lost_at));
}

/// The master has tried each gauge of a dead line only once or twice after a second.
#[test]
fn a_gauge_that_is_silent_for_a_second_gives_no_answer_in_every_view() {
    let devices: Vec<_> = (5..17).map(|address| format!("bcg450@{address}")).collect();
    let gauges: Vec<_> = (5..17).map(|address| format!("gauge{address} bcg450 {address}")).collect();
    let names: Vec<_> = (5..17).map(|address| format!("gauge{address}")).collect();
    let [devices, gauges] = [&devices, &gauges].map(|all| all.iter().map(String::as_str).collect::<Vec<_>>());
    let mut fixture = fixture(&devices, &gauges);
    names.iter().for_each(|name| {
        fixture.exchanging(name);
    });
    fixture.run_for(Duration::from_secs(1));
    fixture.change(|plant| plant.is_silent = true);
    fixture.run_for(MAX_SILENCE + PUBLISH_INTERVAL * 3);
    let stations = fixture.segment().stations;
    for name in &names {
        let lost = fixture.gauge(name);
        assert_eq!((lost.state, lost.problem.as_deref()), (BusStationState::Missing, Some("no answer")), "{name}");
        assert!(!lost.is_awaited);
        let station = stations.iter().find(|station| station.address == lost.address).unwrap();
        assert_eq!((station.state, station.description.as_str()), (BusStationState::Missing, "no answer"), "{name}");
        let gap = *fixture.samples(name).last().unwrap();
        let events: Vec<_> = fixture.events(&format!("{name}: no answer")).iter().map(|event| Some(event.at)).collect();
        assert_eq!((gap.quality, Some(gap.at), events), (Quality::Stale, lost.lost_at, vec![lost.lost_at]), "{name}");
    }

    // Then the master gives the gauge up: the same loss.
    let lost_at = fixture.gauge(&names[0]).lost_at;
    fixture.run_for(Duration::from_secs(2));
    assert_eq!(fixture.gauge(&names[0]).lost_at, lost_at);
    assert_eq!(fixture.events(&format!("{}: no answer", names[0])).len(), 1);
    fixture.change(|plant| plant.is_silent = false);
    fixture.exchanging(&names[0]);
    assert_eq!(fixture.events(&format!("{}: in data exchange", names[0])).len(), 1);
}

/// The computer was suspended, or so busy that the station did nothing for two seconds.
#[test]
fn a_silence_while_the_station_stood_still_is_no_missing_answer() {
    let mut fixture = fixture(&["bcg450@5"], &["chamber bcg450 5"]);
    fixture.exchanging("chamber");
    fixture.run_for(Duration::from_secs(1));
    fixture.change(|plant| plant.stall(Duration::from_secs(2)));
    assert!(fixture.step());
    fixture.exchanging("chamber");
    fixture.run_for(Duration::from_secs(1));
    assert!(fixture.events("no answer").is_empty(), "{:?}", fixture.events("chamber"));
}

#[test]
fn the_loss_of_a_port_is_one_event_with_the_time_of_the_gap() {
    let mut fixture = fixture(&["bcg450@5"], &["chamber bcg450 5"]);
    fixture.exchanging("chamber");
    fixture.run_for(Duration::from_secs(1));
    fixture.change(|plant| plant.is_gone = true);
    let lost = fixture.until_problem("chamber", "lost");
    let events = fixture.events("segment hall: lost");
    let gap = *fixture.samples("chamber").last().unwrap();
    assert_eq!(gap.quality, Quality::Stale);
    assert_eq!((Some(gap.at), vec![gap.at]), (lost.lost_at, events.iter().map(|event| event.at).collect()));
}

/// Another slave in the station's file restarts the segment: the gauges of the new segment have lost nothing a second time.
#[test]
fn a_segment_that_begins_anew_has_the_losses_of_the_database() {
    let config = || polled(&["chamber bcg450 5", "absent bcg450 6"]);
    let mut fixture = Fixture::<PolledLine>::new(config(), VirtualEdge::with_slaves(&["bcg450@5"]));
    fixture.services.snapshots().set_plan(planned_segments(&[config()]));
    let made = fixture.gauge("absent").lost_at;
    assert_eq!(
        made,
        Some(fixture.edge.now().wall),
        "a gauge of which nothing was heard yet has the time of the station"
    );
    fixture.exchanging("chamber");
    fixture.run_for(Duration::from_secs(1));
    fixture.stop();
    let gap = *fixture.samples("chamber").last().unwrap();
    assert_eq!(gap.quality, Quality::Stale);
    let planned = fixture.services.snapshots().in_order_of_file().remove(0).gauges;
    assert_eq!(planned.iter().map(|gauge| gauge.lost_at).collect::<Vec<_>>(), [Some(gap.at), made]);
    fixture.change(|plant| plant.stall(Duration::from_millis(500)));
    fixture.start(config());
    assert_eq!(fixture.gauge("chamber").lost_at, Some(gap.at));
    assert_eq!(fixture.gauge("absent").lost_at, made);

    // A loss that ended is forgotten.
    assert_eq!(fixture.exchanging("chamber").lost_at, None);
    fixture.run_for(Duration::from_secs(1));
    fixture.stop();
    fixture.start(config());
    let lost_at = fixture.gauge("chamber").lost_at;
    assert!(lost_at > Some(gap.at));
    assert_eq!(lost_at, Some(fixture.samples("chamber").last().unwrap().at));
}

/// A gauge shows the time that the database has.
#[test]
fn a_sample_has_the_time_of_its_exchange_in_the_api_and_in_the_database() {
    let mut fixture = fixture(&["bcg450@5"], &["chamber bcg450 5"]);
    fixture.exchanging("chamber");
    let mut shown = Vec::new();
    for _ in 0..20 {
        fixture.run_for(PUBLISH_INTERVAL);
        shown.push(fixture.gauge("chamber").read_at.unwrap());
    }
    // The recorder keeps all samples around an event.
    fixture.services.recorder().event_now(None, profivac_recorder::EventKind::Note, "all");
    let recorded: Vec<_> = fixture.samples("chamber").iter().map(|sample| sample.at).collect();
    assert!(shown.iter().all(|at| recorded.contains(at)), "{shown:?} {recorded:?}");
}

/// The line stands still before the sample, as while another master keeps the token: the inputs stay as they were in the last exchange.
#[test]
fn the_reading_of_a_gauge_that_is_sampled_seldom_has_the_time_of_its_exchange_and_ends_with_a_silence() {
    let slow = config::Gauge { poll: Duration::from_secs(5), ..gauge("chamber bcg450 5") };
    let segment = config::Segment { gauges: vec![slow.clone()], ..polled(&[]) };
    let mut fixture = Fixture::<PolledLine>::new(segment, VirtualEdge::with_slaves(&["bcg450@5"]));
    fixture.exchanging("chamber");
    for (stall, is_lost) in [(Duration::from_millis(600), false), (Duration::from_secs(2), true)] {
        fixture.run_for(slow.poll - Duration::from_millis(500));
        let before = fixture.edge.now().wall;
        fixture.change(|plant| plant.stall(stall));
        assert!(fixture.step());
        let gauge = fixture.gauge("chamber");
        let read_at = gauge.read_at.unwrap();
        assert!(read_at <= before, "{stall:?}: {read_at:?} {before:?}");
        assert_eq!(gauge.readings[0].quality == Quality::Stale, is_lost, "{stall:?}");
        // The recorder keeps all samples around an event.
        fixture.services.recorder().event_now(None, profivac_recorder::EventKind::Note, "all");
        let last = *fixture.samples("chamber").last().unwrap();
        if is_lost {
            assert_eq!((last.quality, Some(last.at)), (Quality::Stale, gauge.lost_at));
        } else {
            assert!(read_at > before.before(PUBLISH_INTERVAL), "{read_at:?} {before:?}");
            assert_eq!((last.quality, last.at), (Quality::Valid, read_at));
        }
    }
}

#[test]
fn a_clock_that_is_set_makes_no_gap_and_ages_no_reading() {
    let hour = 3600 * Micros::SECOND;
    for set in [hour, -hour] {
        let mut fixture = fixture(&["bcg450@5"], &["chamber bcg450 5"]);
        fixture.exchanging("chamber");
        fixture.run_for(Duration::from_secs(1));
        let before = fixture.gauge("chamber").read_at.unwrap();
        // While the gauge is silent, but not for long: its silence is not measured with this clock.
        fixture.change(|plant| plant.is_silent = true);
        fixture.run_for(POLL);
        fixture.change(|plant| plant.clock_set = set);
        fixture.run_for(POLL * 2);
        fixture.change(|plant| plant.is_silent = false);
        for _ in 0..20 {
            fixture.run_for(PUBLISH_INTERVAL);
            let gauge = fixture.gauge("chamber");
            assert_eq!((gauge.state, gauge.lost_at), (BusStationState::DataExchange, None), "{set}");
            assert_eq!(gauge.readings[0].quality, Quality::Valid, "{set}");
        }
        let moved = fixture.gauge("chamber").read_at.unwrap().0 - before.0;
        assert!((moved - set - 2 * Micros::SECOND).abs() < Micros::SECOND / 2, "{set}: {moved}");
        let samples = fixture.samples("chamber");
        assert!(samples.iter().all(|sample| sample.quality == Quality::Valid), "{samples:?}");
    }
}

#[test]
fn a_removed_gauge_ends_with_a_gap_and_the_others_are_not_disturbed() {
    let mut fixture = fixture(&["bcg450@5", "psg550@6"], &["chamber bcg450 5", "fore psg550 6"]);
    fixture.exchanging("chamber");
    fixture.exchanging("fore");
    fixture.commands.send(SegmentCommand::Gauges(vec![gauge("fore psg550 6")])).unwrap();
    fixture.run_for(Duration::from_secs(1));
    assert!(fixture.services.snapshots().gauge("chamber").is_none());
    assert_eq!(fixture.samples("chamber").last().unwrap().quality, Quality::Stale);
    assert!(fixture.samples("fore").iter().all(|sample| sample.quality == Quality::Valid));
}

#[test]
fn a_gauge_that_is_sampled_seldom_has_its_first_reading_soon_after_it_was_found_or_lost() {
    let slow = config::Gauge { poll: Duration::from_hours(1), ..gauge("chamber bcg450 5") };
    let segment = config::Segment { gauges: vec![slow], ..polled(&[]) };
    let mut fixture = Fixture::<PolledLine>::new(segment, VirtualEdge::with_slaves(&["bcg450@5"]));
    fixture.exchanging("chamber");
    fixture.change(|plant| plant.is_gone = true);
    fixture.until_problem("chamber", "lost");
    fixture.change(|plant| plant.is_gone = false);
    fixture.exchanging("chamber");
}

#[test]
fn a_shorter_interval_holds_at_once_and_not_after_the_former_one() {
    let slow = config::Gauge { poll: Duration::from_hours(1), ..gauge("chamber bcg450 5") };
    let segment = config::Segment { gauges: vec![slow], ..polled(&[]) };
    let mut fixture = Fixture::<PolledLine>::new(segment, VirtualEdge::with_slaves(&["bcg450@5"]));
    let first = fixture.exchanging("chamber");
    fixture.commands.send(SegmentCommand::Gauges(vec![gauge("chamber bcg450 5")])).unwrap();
    let second = Duration::from_secs(1);
    fixture.until("chamber", second, |gauge| gauge.read_at > first.read_at);
    let before = fixture.count("chamber");
    fixture.run_for(second);
    assert!(u128::from(fixture.count("chamber") - before) * 10 >= second.as_millis() / POLL.as_millis() * 9);
}

#[test]
fn a_gauge_with_another_name_ends_its_series_with_a_gap_and_begins_another_one_at_once() {
    let slow = |text| config::Gauge { poll: Duration::from_mins(1), ..gauge(text) };
    let mut fixture = fixture(&["bcg450@5"], &["chamber bcg450 5"]);
    fixture.exchanging("chamber");
    fixture.run_for(Duration::from_secs(1));
    let renamed = fixture.edge.now().wall;
    fixture.commands.send(SegmentCommand::Gauges(vec![slow("target bcg450 5")])).unwrap();
    fixture.run_for(PUBLISH_INTERVAL * 2);
    let former = fixture.samples("chamber");
    let [.., last, gap] = former[..] else { panic!("{former:?}") };
    assert_eq!((last.quality, gap.quality), (Quality::Valid, Quality::Stale));
    assert!(last.at <= gap.at && gap.at >= renamed, "{former:?}");
    assert!(fixture.services.snapshots().gauge("chamber").is_none());
    assert_eq!(fixture.gauge("target").readings[0].series, "target");
    let [first] = fixture.samples("target")[..] else { panic!("{:?}", fixture.samples("target")) };
    assert_eq!(first.quality, Quality::Valid);
}

/// The emission status needs a move of the selector: the station reads it a few times a day.
#[test]
fn a_state_that_is_read_seldom_is_valid_for_a_minute_and_a_setting_for_good() {
    let mut fixture = fixture(&["bcg450@5"], &["chamber bcg450 5"]);
    fixture.services.snapshots().add_parameter_reader();
    let of = |gauge: &Gauge, target: &str| gauge.parameters.iter().find(|it| it.target == target).unwrap().clone();
    let (state, setting) = ("ba.emission-status", "setpoint-a.percentage-of-atmosphere");
    let is_read = |gauge: &Gauge| {
        let valid = gauge.parameters.iter().filter(|it| it.quality == Quality::Valid);
        valid.filter(|it| [state, setting].contains(&it.target.as_str())).count() == 2
    };
    let read = fixture.until("chamber", Duration::from_secs(60), is_read);
    fixture.run_for(Duration::from_secs(50));
    let young = fixture.gauge("chamber");
    assert_eq!(of(&young, state), of(&read, state));
    fixture.run_for(Duration::from_secs(12));
    let old = fixture.gauge("chamber");
    let shown = of(&old, state);
    assert_eq!((shown.quality, shown.number, shown.text.as_str()), (Quality::Stale, None, ""));
    assert_eq!(shown.read_at, of(&read, state).read_at, "the time of the last reading");
    assert_eq!(of(&old, setting), of(&read, setting));
}

#[test]
fn only_the_station_ends_a_segment() {
    let mut fixture = fixture(&["bcg450@5"], &["chamber bcg450 5"]);
    fixture.change(|plant| plant.is_gone = true);
    fixture.run_for(Duration::from_secs(200));
    fixture.change(|plant| plant.is_gone = false);
    fixture.exchanging("chamber");
    fixture.commands.send(SegmentCommand::Stop).unwrap();
    while fixture.step() {}
    assert_eq!(fixture.samples("chamber").last().unwrap().quality, Quality::Stale, "the end is a gap");
}
