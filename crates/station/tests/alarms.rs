//! All alarms of a station, with neither clock nor thread nor disk: limits, delays, people, reloads, and random plants.

#![allow(clippy::unwrap_used, clippy::panic, clippy::indexing_slicing, reason = "a test")]

mod desk;

use desk::sight;
use profivac_recorder::Micros;
use profivac_station::alarm::{
    AlarmChange, AlarmError, AlarmRegistry, AlarmState, AlarmStatus, AlarmTime, ChangeKind, Condition, Inputs,
    Priority, Rule, Subject,
};
use profivac_station::view::{BusStationState, SegmentState};
use std::time::Duration;

const NEW_YEAR_S: i64 = 1_767_225_600;

/// A book with a clock that nobody sets and one on the wall.
struct Desk {
    book: AlarmRegistry,
    steady_ms: i64,
    wall_ms: i64,
}

impl Desk {
    fn new(rules: Vec<Rule>) -> Self {
        let mut desk = Self { book: AlarmRegistry::default(), steady_ms: 0, wall_ms: NEW_YEAR_S * 1000 };
        desk.book.reconfigure(rules, Vec::new(), desk.now());
        desk
    }

    fn now(&self) -> AlarmTime {
        AlarmTime { monotonic: Micros(self.steady_ms * 1000), wall: Micros(self.wall_ms * 1000) }
    }

    fn pass(&mut self, ms: i64) {
        self.steady_ms += ms;
        self.wall_ms += ms;
    }

    fn look(&mut self, sight: &Inputs) -> Vec<ChangeKind> {
        let now = self.now();
        self.book.evaluate(sight, now).into_iter().map(|change| change.what).collect()
    }

    /// Looks, then lets time pass.
    fn look_for(&mut self, sight: &Inputs, ms: i64) -> Vec<ChangeKind> {
        let seen = self.look(sight);
        self.pass(ms);
        seen
    }

    fn life(&self) -> &AlarmStatus {
        self.book.entries()[0].status()
    }

    fn state(&self) -> AlarmState {
        self.life().state
    }

    fn acknowledge(&mut self) -> Result<AlarmChange, AlarmError> {
        let (occurrence, now) = (self.life().occurrence, self.now());
        self.book.acknowledge("it", occurrence, "Ada", now)
    }
}

fn series() -> Subject {
    Subject::Series { gauge: "chamber".to_owned(), series: "chamber".to_owned() }
}

fn rule(subject: Subject, condition: Condition, delay_s: u64, off_delay_s: u64) -> Rule {
    Rule {
        name: "it".to_owned(),
        subject,
        condition,
        priority: Priority::High,
        delay: Duration::from_secs(delay_s),
        off_delay: Duration::from_secs(off_delay_s),
        message: None,
    }
}

/// Above 1 Pa until below 0.5 Pa.
fn above(delay_s: u64, off_delay_s: u64) -> Rule {
    rule(series(), Condition::Above { limit: 1.0, reset: 0.5 }, delay_s, off_delay_s)
}

#[test]
fn an_alarm_goes_through_its_life() {
    let mut desk = Desk::new(vec![above(0, 0)]);
    assert_eq!(desk.look_for(&sight(0.9, "valid"), 250), []);
    assert_eq!(desk.look_for(&sight(1.1, "valid"), 250), [ChangeKind::Raised]);
    assert_eq!((desk.state(), desk.life().value), (AlarmState::Unacknowledged, Some(1.1)));
    assert_eq!(desk.life().text, "chamber shows 1.10e-2 mbar, above the limit of 1.00e-2 mbar");
    let change = desk.acknowledge().unwrap();
    assert_eq!((change.who.as_deref(), change.value, desk.state()), (Some("Ada"), Some(1.1), AlarmState::Acknowledged));
    assert_eq!(desk.look_for(&sight(0.4, "valid"), 250), [ChangeKind::Returned]);
    assert_eq!(desk.state(), AlarmState::Normal);
    desk.look_for(&sight(2.0, "valid"), 250);
    assert_eq!(desk.look_for(&sight(0.1, "valid"), 250), [ChangeKind::Returned]);
    assert_eq!(desk.state(), AlarmState::Returned, "nobody knows of it");
    desk.acknowledge().unwrap();
    assert_eq!(desk.state(), AlarmState::Normal);
}

#[test]
fn a_limit_has_a_hysteresis_with_two_edges() {
    let mut desk = Desk::new(vec![above(0, 0)]);
    assert_eq!(desk.look(&sight(1.0, "valid")), [], "at the limit is not above it");
    assert_eq!(desk.look(&sight(1.000_001, "valid")), [ChangeKind::Raised]);
    for pa in [0.99, 0.500_001, 1.5, 0.7] {
        assert_eq!(desk.look(&sight(pa, "valid")), [], "{pa}");
    }
    assert_eq!(desk.look(&sight(0.5, "valid")), [ChangeKind::Returned]);
    assert_eq!(desk.look(&sight(0.99, "valid")), [], "the limit counts again");
    let mut desk = Desk::new(vec![rule(series(), Condition::Below { limit: 1.0, reset: 2.0 }, 0, 0)]);
    assert_eq!(desk.look(&sight(1.0, "valid")), []);
    assert_eq!(desk.look(&sight(0.999, "valid")), [ChangeKind::Raised]);
    assert_eq!(desk.look(&sight(1.999, "valid")), []);
    assert_eq!(desk.look(&sight(2.0, "valid")), [ChangeKind::Returned]);
}

#[test]
fn delays_are_kept_to_the_millisecond() {
    let mut desk = Desk::new(vec![above(2, 3)]);
    desk.look_for(&sight(2.0, "valid"), 1999);
    assert_eq!(desk.look_for(&sight(2.0, "valid"), 1), []);
    assert_eq!(desk.look(&sight(2.0, "valid")), [ChangeKind::Raised]);
    desk.look_for(&sight(0.1, "valid"), 2999);
    assert_eq!(desk.look_for(&sight(0.1, "valid"), 1), []);
    assert_eq!(desk.look(&sight(0.1, "valid")), [ChangeKind::Returned]);
}

#[test]
fn a_signal_that_chatters_is_one_alarm() {
    let mut desk = Desk::new(vec![above(1, 5)]);
    let mut seen = Vec::new();
    for step in 0..4000 {
        // Nine of ten looks are above; the tenth is far below, for a quarter of a second.
        let pa = if step % 10 == 0 { 0.1 } else { 3.0 };
        seen.extend(desk.look_for(&sight(pa, "valid"), 250));
    }
    assert_eq!(seen, [ChangeKind::Raised]);
    let mut desk = Desk::new(vec![above(1, 5)]);
    let spikes: Vec<_> = (0..4000)
        .flat_map(|step| {
            let pa = if step % 10 == 0 { 3.0 } else { 0.1 };
            desk.look_for(&sight(pa, "valid"), 250)
        })
        .collect();
    assert_eq!(spikes, [], "spikes that are shorter than the delay are none");
}

#[test]
fn a_clock_that_is_set_moves_no_delay() {
    let mut desk = Desk::new(vec![above(10, 10)]);
    desk.look(&sight(2.0, "valid"));
    desk.wall_ms += 3_600_000;
    assert_eq!(desk.look_for(&sight(2.0, "valid"), 10_000), [], "an hour on the wall is no delay");
    desk.wall_ms -= 7_200_000;
    assert_eq!(desk.look(&sight(2.0, "valid")), [ChangeKind::Raised]);
    let first = desk.life().occurrence;
    desk.wall_ms -= 7_200_000;
    desk.look_for(&sight(0.1, "valid"), 10_000);
    desk.look_for(&sight(0.1, "valid"), 0);
    desk.look_for(&sight(2.0, "valid"), 10_000);
    assert_eq!(desk.look(&sight(2.0, "valid")), [ChangeKind::Raised]);
    assert_eq!(
        desk.life().occurrence,
        first + 1,
        "an occurrence is never used twice, even if the clock shows an earlier time"
    );
}

#[test]
fn what_is_not_known_raises_nothing_and_ends_nothing() {
    for nothing in [sight(0.1, "invalid"), sight(0.1, "gap"), desk::silent(), Inputs::default()] {
        let mut desk = Desk::new(vec![above(0, 0)]);
        assert_eq!(desk.look(&nothing), []);
        desk.look(&sight(2.0, "valid"));
        assert_eq!(desk.look(&nothing), [], "{nothing:?}");
        assert_eq!(desk.state(), AlarmState::Unacknowledged);
        assert_eq!(desk.look(&sight(0.1, "valid")), [ChangeKind::Returned]);
    }
}

#[test]
fn the_end_of_a_range_is_a_bound() {
    let table = [
        // range end, quality, raised with a limit of 1 Pa?
        (2.0, "overrange", Some(true)),
        (0.5, "overrange", None),
        (0.2, "underrange", Some(false)),
        (2.0, "underrange", None),
    ];
    for (pa, quality, known) in table {
        let mut desk = Desk::new(vec![above(0, 0)]);
        assert_eq!(desk.look(&sight(pa, quality)).is_empty(), known != Some(true), "{pa} {quality}");
        let mut desk = Desk::new(vec![above(0, 0)]);
        desk.look(&sight(9.0, "valid"));
        assert_eq!(desk.look(&sight(pa, quality)).is_empty(), known != Some(false), "{pa} {quality}");
        let blind = Condition::NotMeasurable { limits: vec![1.0] };
        let mut desk = Desk::new(vec![rule(series(), blind, 0, 0)]);
        assert_eq!(desk.look(&sight(pa, quality)).is_empty(), known.is_some(), "{pa} {quality} is blind");
    }
}

#[test]
fn a_part_without_a_valid_reading_is_blind_and_a_silent_gauge_is_not() {
    let blind = || Desk::new(vec![rule(series(), Condition::NotMeasurable { limits: vec![1.0] }, 0, 0)]);
    assert_eq!(blind().look(&sight(1.0, "invalid")), [ChangeKind::Raised]);
    assert_eq!(blind().look(&sight(1.0, "valid")), []);
    assert_eq!(blind().look(&desk::silent()), []);
    let other = Subject::Series { gauge: "chamber".to_owned(), series: "chamber.2".to_owned() };
    let mut desk = Desk::new(vec![rule(other, Condition::NotMeasurable { limits: vec![1.0] }, 0, 0)]);
    assert_eq!(desk.look(&sight(1.0, "valid")), [ChangeKind::Raised]);
    assert_eq!(desk.life().text, "chamber has no part chamber.2");
}

#[test]
fn a_rise_is_measured_over_its_window() {
    let rise = Condition::Rise { limit: 0.5, reset: 0.25, window: Duration::from_secs(20) };
    let walk = |decades_per_minute: f64, seconds: i64| {
        let mut desk = Desk::new(vec![rule(series(), rise.clone(), 0, 0)]);
        let seen: Vec<_> = (0..seconds * 4)
            .filter(|step| {
                let pa = 10_f64.powf(-6.0 + decades_per_minute * *step as f64 / 240.0);
                !desk.look_for(&sight(pa, "valid"), 250).is_empty()
            })
            .collect();
        (seen, desk)
    };
    assert_eq!(walk(0.49, 60).0, Vec::<i64>::new(), "slower than its limit");
    assert_eq!(walk(-5.0, 60).0, Vec::<i64>::new(), "a pump-down is no rise");
    let (seen, mut desk) = walk(0.51, 60);
    assert_eq!(seen, [40], "as soon as half of the window is known");
    assert!((desk.book.entries()[0].value().unwrap() - 0.51).abs() < 1e-6);
    let end = 10_f64.powf(-6.0 + 0.51);
    let still: Vec<_> = (0..80).flat_map(|_| desk.look_for(&sight(end, "valid"), 250)).collect();
    assert_eq!(still, [ChangeKind::Returned]);
    let (_, mut desk) = walk(0.51, 60);
    desk.look_for(&sight(1.0, "invalid"), 250);
    assert_eq!(desk.look(&sight(1e-6, "valid")), [], "what was before a hole is not compared with what is behind it");
    assert_eq!(desk.book.entries()[0].value(), None);
}

#[test]
fn a_gauge_that_reports_a_fault_is_an_alarm_until_it_exchanges_data_without() {
    let mut desk = Desk::new(vec![rule(Subject::Gauge("chamber".to_owned()), Condition::Fault, 0, 0)]);
    let with = |standing, exceptions: &[&str]| {
        let mut sight = sight(1.0, "valid");
        sight.gauges[0].standing = standing;
        sight.gauges[0].exceptions = exceptions.iter().map(|&words| words.to_owned()).collect();
        sight
    };
    assert_eq!(desk.look(&with(BusStationState::Exchanging, &[])), []);
    assert_eq!(desk.look(&with(BusStationState::Faulty, &["filament broken", "Pirani error"])), [ChangeKind::Raised]);
    assert_eq!(desk.life().text, "chamber reports filament broken, Pirani error");
    assert_eq!(desk.look(&with(BusStationState::Missing, &[])), [], "a gauge that is gone is not well");
    let now = desk.now();
    let changes = desk.book.evaluate(&with(BusStationState::Exchanging, &[]), now);
    assert_eq!(changes.iter().map(|change| change.what).collect::<Vec<_>>(), [ChangeKind::Returned]);
    assert_eq!(changes[0].text, "", "what is over is not told as if it were so");
}

#[test]
fn a_gauge_without_fresh_data_is_an_alarm_unless_its_segment_is_one() {
    let stale = |behind: Option<&str>| {
        let behind_segment = behind.map(str::to_owned);
        Desk::new(vec![rule(Subject::Gauge("chamber".to_owned()), Condition::Stale { behind_segment }, 0, 0)])
    };
    assert_eq!(stale(Some("hall")).look(&sight(1.0, "valid")), []);
    let mut desk = stale(Some("hall"));
    assert_eq!(desk.look(&desk::silent()), [ChangeKind::Raised]);
    assert_eq!(desk.life().text, "chamber gives no data, the last are 60 s old");
    let now = desk.now();
    assert_eq!(desk.book.evaluate(&sight(1.0, "valid"), now)[0].text, "");
    let mut lost = desk::silent();
    lost.segments[0].state = SegmentState::Waiting;
    assert_eq!(stale(Some("hall")).look(&lost), [], "the segment tells it");
    assert_eq!(stale(None).look(&lost), [ChangeKind::Raised]);
    let mut slow = desk::silent();
    slow.gauges[0].poll_ms = 30_000;
    assert_eq!(stale(None).look(&slow), [], "a minute is little for who is asked twice in it");
    let mut never = desk::silent();
    never.gauges[0].age_ms = None;
    assert_eq!(stale(None).look(&never), [ChangeKind::Raised]);
}

#[test]
fn a_segment_that_does_not_run_and_one_that_is_not_there_are_alarms() {
    let down = || Desk::new(vec![rule(Subject::Segment("hall".to_owned()), Condition::SegmentDown, 0, 0)]);
    assert_eq!(down().look(&sight(1.0, "valid")), []);
    let mut lost = sight(1.0, "valid");
    lost.segments[0].state = SegmentState::Waiting;
    lost.segments[0].trouble = Some("the port is lost".to_owned());
    let mut desk = down();
    assert_eq!(desk.look(&lost), [ChangeKind::Raised]);
    assert_eq!(desk.life().text, "segment hall does not run: the port is lost");
    let now = desk.now();
    assert_eq!(desk.book.evaluate(&sight(1.0, "valid"), now)[0].text, "");
    assert_eq!(down().look(&Inputs::default()), [ChangeKind::Raised]);
}

#[test]
fn damage_is_counted_over_a_minute() {
    let damage = rule(Subject::Segment("hall".to_owned()), Condition::DamagedTelegrams { limit: 30.0 }, 0, 0);
    let run = |per_second: f64| {
        let mut desk = Desk::new(vec![damage.clone()]);
        let seen: Vec<_> = (0..180)
            .flat_map(|second| {
                let mut sight = sight(1.0, "valid");
                sight.segments[0].damaged = 1000 + (per_second * f64::from(second)) as u32;
                desk.look_for(&sight, 1000)
            })
            .collect();
        (seen, desk)
    };
    assert_eq!(run(0.5).0, []);
    let (seen, mut desk) = run(0.6);
    assert_eq!(seen, [ChangeKind::Raised]);
    let mut anew = sight(1.0, "valid");
    anew.segments[0].damaged = 3;
    assert_eq!(desk.look(&anew), [ChangeKind::Returned], "a master that was made anew counts from nothing");
}

#[test]
fn a_record_that_is_not_written_is_an_alarm() {
    let mut desk = Desk::new(vec![rule(Subject::Station, Condition::NotRecording, 0, 0)]);
    let full = Inputs { recorder_error: Some("the disk is full".to_owned()), ..Inputs::default() };
    assert_eq!((desk.look(&Inputs::default()), desk.look(&full)), (vec![], vec![ChangeKind::Raised]));
    assert_eq!(desk.life().text, "nothing is recorded: the disk is full");
}

#[test]
fn nobody_acknowledges_what_they_have_not_seen() {
    let mut desk = Desk::new(vec![above(0, 0)]);
    desk.look_for(&sight(2.0, "valid"), 1000);
    let seen = desk.life().occurrence;
    desk.look_for(&sight(0.1, "valid"), 1000);
    desk.look_for(&sight(2.0, "valid"), 1000);
    let now = desk.now();
    let refused = desk.book.acknowledge("it", seen, "Ada", now).unwrap_err();
    assert_eq!(refused, AlarmError::OccurrenceChanged { name: "it".to_owned(), occurrence: seen + 2000, got: seen });
    assert_eq!(desk.state(), AlarmState::Unacknowledged);
    desk.acknowledge().unwrap();
    assert_eq!(desk.acknowledge().unwrap_err().to_string(), "it is acknowledged by Ada already");
    assert_eq!(desk.book.acknowledge("other", 1, "Ada", now).unwrap_err().to_string(), "there is no alarm \"other\"");
}

#[test]
fn what_is_out_of_service_is_silent_and_comes_back() {
    let mut desk = Desk::new(vec![above(0, 0)]);
    let now = desk.now();
    let hour = Some(Duration::from_secs(3600));
    desk.book.take_out_of_service("it", "Eve", "the gauge is being calibrated", hour, now).unwrap();
    assert_eq!(desk.look_for(&sight(2.0, "valid"), 3_599_999), []);
    let refused = desk.book.take_out_of_service("it", "Ada", "again", None, now).unwrap_err().to_string();
    assert_eq!(refused, "it is out-of-service by Eve already");
    // That the clock is set does not bring it back sooner or later.
    desk.wall_ms += 86_400_000;
    assert_eq!(desk.look_for(&sight(2.0, "valid"), 1), []);
    assert_eq!(
        desk.look(&sight(2.0, "valid")),
        [ChangeKind::ReturnedToService, ChangeKind::Raised],
        "it stands, so it is told"
    );
    let now = desk.now();
    desk.book.take_out_of_service("it", "Eve", "for ever", None, now).unwrap();
    desk.pass(100 * 86_400_000);
    assert_eq!(desk.look(&sight(2.0, "valid")), []);
    let now = desk.now();
    desk.book.return_to_service("it", "Eve", now).unwrap();
    assert_eq!(desk.book.return_to_service("it", "Eve", now).unwrap_err().to_string(), "it is normal");
    assert_eq!(desk.look(&sight(0.1, "valid")), [], "it does not stand any more");
}

#[test]
fn a_changed_file_leaves_alarms_where_they_stand() {
    let mut desk = Desk::new(vec![above(0, 0)]);
    desk.look(&sight(2.0, "valid"));
    desk.acknowledge().unwrap();
    let (before, now) = (desk.life().clone(), desk.now());
    let low = Rule { priority: Priority::Low, message: Some("call Eve".to_owned()), ..above(3, 3) };
    assert_eq!(desk.book.reconfigure(vec![low], Vec::new(), now), []);
    assert_eq!((desk.life(), desk.book.entries()[0].rule().priority), (&before, Priority::Low));
    // Another limit: what stood is over if it does not hold any more, and nothing is lost.
    let higher = rule(series(), Condition::Above { limit: 10.0, reset: 5.0 }, 0, 0);
    desk.book.reconfigure(vec![higher], Vec::new(), now);
    assert_eq!(desk.state(), AlarmState::Acknowledged);
    assert_eq!(desk.look(&sight(2.0, "valid")), [ChangeKind::Returned]);
    assert_eq!(desk.book.clone().reconfigure(Vec::new(), Vec::new(), now), [], "what is normal goes without a word");
    desk.look(&sight(20.0, "valid"));
    let gone = desk.book.reconfigure(Vec::new(), Vec::new(), now);
    assert_eq!(gone.iter().map(|change| change.what).collect::<Vec<_>>(), [ChangeKind::Removed]);
}

#[test]
fn a_restart_leaves_alarms_where_they_stood() {
    for state in AlarmState::ALL {
        let life = AlarmStatus { state, occurrence: 7, text: "it was so".to_owned(), ..AlarmStatus::default() };
        let mut desk = Desk::new(Vec::new());
        let now = desk.now();
        desk.book.reconfigure(vec![above(1, 1)], vec![("it".to_owned(), life.clone())], now);
        assert_eq!(desk.life(), &life);
        assert_eq!(desk.look_for(&Inputs::default(), 5000), [], "nothing is known yet");
        let seen = [desk.look_for(&sight(2.0, "valid"), 1000), desk.look(&sight(2.0, "valid"))].concat();
        let raised = matches!(state, AlarmState::Normal | AlarmState::Returned);
        assert_eq!(
            seen,
            [ChangeKind::Raised][..usize::from(raised)],
            "{state:?}: what stands still is not raised again"
        );
    }
}

/// A plant that does what it likes, people who do what they like, files that change, and programs that are killed.
#[test]
fn whatever_happens_nothing_that_was_raised_is_lost() {
    let mut random = fastrand::Rng::with_seed(11);
    let mut raised = 0;
    for _ in 0..300 {
        raised += random_walk(&mut random);
    }
    assert!(raised > 3000, "{raised} alarms were raised");
}

fn random_walk(random: &mut fastrand::Rng) -> usize {
    let (delay, off_delay) = (random.u64(0..4), random.u64(0..4));
    let mut desk = Desk::new(vec![above(delay, off_delay)]);
    // Since when it is known to hold without a break, and without a look that knows nothing.
    let mut holds: Option<i64> = None;
    let (mut raised, mut acknowledged) = (0, 0);
    for _ in 0..400 {
        let pa = if random.bool() { 2.0 } else { 0.1 };
        for _ in 0..random.usize(1..12) {
            let quality = ["valid", "valid", "valid", "invalid"][random.usize(0..4)];
            let before = desk.state();
            let now = desk.now();
            let changes = desk.book.evaluate(&sight(pa, quality), now);
            if quality == "valid" {
                holds = (pa > 1.0).then(|| holds.unwrap_or(desk.steady_ms));
            }
            for change in &changes {
                raised += usize::from(change.what == ChangeKind::Raised);
                assert!(change.what != ChangeKind::Returned || before.is_active(), "only what stands returns");
            }
            assert!(
                !before.needs_acknowledgement() || desk.state().needs_acknowledgement(),
                "looking never takes away what nobody knows of"
            );
            let long = holds.is_some_and(|since| desk.steady_ms - since >= delay as i64 * 1000);
            let told = desk.state().is_active() || desk.state() == AlarmState::OutOfService;
            assert!(
                !(long && quality == "valid") || told,
                "it holds for longer than its delay and is {:?}",
                desk.state()
            );
            desk.pass(250);
        }
        acknowledged += usize::from(act(random, &mut desk));
    }
    let open = usize::from(desk.state().needs_acknowledgement());
    assert!(acknowledged + open <= raised, "each was raised once and acknowledged at most once");
    raised
}

/// Says whether something was acknowledged.
fn act(random: &mut fastrand::Rng, desk: &mut Desk) -> bool {
    let now = desk.now();
    match random.usize(0..8) {
        0 | 1 => return desk.acknowledge().is_ok(),
        2 if random.usize(0..8) == 0 => {
            desk.book.take_out_of_service("it", "Eve", "so", Some(Duration::from_secs(random.u64(1..20))), now).ok();
        }
        3 => {
            desk.book.return_to_service("it", "Eve", now).ok();
        }
        4 => desk.wall_ms += random.i64(-10_000_000..10_000_000),
        5 => {
            let rule = desk.book.entries()[0].rule().clone();
            desk.book.reconfigure(vec![Rule { priority: Priority::Low, ..rule }], Vec::new(), now);
        }
        _ => {}
    }
    false
}
