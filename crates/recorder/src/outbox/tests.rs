use super::*;
use crate::alarms::AlarmBatch;
use crate::backup::Existing;
use crate::database::{Database, NewPoints, Retention};
use crate::point::DescribedPoint;
use crate::quality::Quality;
use profivac_model::{AlarmChangeKind, AlarmHistoryEntry, AlarmState, Event as RecordEvent, Priority};
use std::path::Path;

const DAY: i64 = 86_400 * Micros::SECOND;

fn valid(at: i64, pa: f64) -> Sample {
    Sample::new(Micros(at), Some(pa), Quality::Valid)
}

fn open(path: &Path, forward: Forward) -> Database {
    let mut database = Database::open(path, Micros(DAY)).unwrap();
    database.set_outbox(Some(forward));
    database
}

fn write(database: &mut Database, now: i64, samples: &[Sample]) {
    let index = database.series_index("chamber");
    let mut spans = PendingSpans::default();
    samples.iter().for_each(|sample| spans.add(index, sample));
    let samples: Vec<_> = samples.iter().map(|sample| (index, *sample)).collect();
    database.set_time(Micros(now));
    database.write(&samples, &spans, &[], &AlarmBatch::default()).unwrap();
}

/// Writes an event and a row of the alarm history.
fn write_event_and_alarm(database: &mut Database, at: i64, text: &str) {
    let event = RecordEvent { at: Micros(at), gauge: None, kind: EventKind::Note.into(), text: text.to_owned() };
    let change = AlarmHistoryEntry {
        at: Micros(at),
        alarm: "chamber too high".to_owned(),
        change: AlarmChangeKind::Raised.into(),
        state: AlarmState::Unacknowledged.into(),
        priority: Priority::High.into(),
        subject: None,
        occurrence: at,
        user: None,
        value: None,
        unit: None,
        text: text.to_owned(),
    };
    let alarms = AlarmBatch { history: vec![change], ..AlarmBatch::default() };
    database.write(&[], &PendingSpans::default(), &[event], &alarms).unwrap();
}

/// The ids and texts of all events in the batches, then those of all alarm changes.
fn sent(path: &Path) -> [Vec<(i64, String)>; 2] {
    let batches = batches(path);
    let events = batches.iter().flat_map(|batch| &batch.events).map(|event| (event.id, event.text.clone()));
    let alarms = batches.iter().flat_map(|batch| &batch.alarms).map(|change| (change.id, change.text.clone()));
    [events.collect(), alarms.collect()]
}

fn row_counts(path: &Path) -> (i64, i64) {
    let sql = "SELECT (SELECT count(*) FROM event), (SELECT count(*) FROM alarm_history)";
    let reader = Reader::open(path).unwrap();
    reader.connection().query_row(sql, [], |row| Ok((row.get(0)?, row.get(1)?))).unwrap()
}

fn taken(epoch: i64, number: i64) -> Acknowledgement {
    Acknowledgement { epoch, taken: number, stored: 0 }
}

/// The numbers of the batches that are kept after their acknowledgement.
fn kept(path: &Path, epoch: i64) -> Vec<i64> {
    let reader = Reader::open(path).unwrap();
    let batches = reader.kept_batches(epoch, 1..=i64::MAX, 100, usize::MAX).unwrap();
    batches.iter().map(|batch| batch.number).collect()
}

fn page(path: &Path) -> Page {
    Reader::open(path).unwrap().outbox(0, 100, usize::MAX).unwrap()
}

fn batches(path: &Path) -> Vec<Batch> {
    page(path).batches.iter().map(|waiting| Batch::decode_compressed(&waiting.payload).unwrap()).collect()
}

#[test]
fn a_batch_has_the_samples_of_the_record_at_the_times_of_the_record() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("plant.db");
    let mut database = open(&path, Forward::All);
    write(&mut database, DAY, &[valid(DAY, 1.0), valid(DAY, 1.0), valid(DAY, 2.0)]);
    // A repeated sample is one row; another one at a taken time moves by a microsecond.
    write(&mut database, DAY, &[valid(DAY, 1.0), valid(DAY - 5, 3.0)]);
    let sent: Vec<_> =
        batches(&path).iter().flat_map(|batch| batch.samples.clone()).map(|it| it.unpack().unwrap()).collect();
    assert_eq!(sent, [vec![valid(DAY, 1.0), valid(DAY + 1, 2.0)], vec![valid(DAY - 5, 3.0)]]);
    let mut sent = sent.concat();
    sent.sort_by_key(|sample| sample.at);
    assert_eq!(Reader::open(&path).unwrap().samples("chamber", Micros(0), Micros(i64::MAX)).unwrap(), sent);
}

#[test]
fn numbers_have_no_gaps_and_are_not_used_again_after_an_acknowledgement() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("plant.db");
    let mut database = open(&path, Forward::All);
    let numbers = || page(&path).batches.iter().map(|waiting| waiting.number).collect::<Vec<_>>();
    (0..3).for_each(|second| write(&mut database, DAY, &[valid(DAY + second, 1.0)]));
    assert_eq!(numbers(), [1, 2, 3]);
    let epoch = page(&path).epoch;
    database.acknowledge_outbox(taken(epoch + 1, 3)).unwrap();
    assert_eq!(numbers(), [1, 2, 3], "of another database");
    database.acknowledge_outbox(taken(epoch, 3)).unwrap();
    drop(database);
    write(&mut open(&path, Forward::All), DAY, &[valid(DAY + 9, 1.0)]);
    assert_eq!(numbers(), [4]);
    assert_eq!(page(&path).epoch, epoch);
    let expected = Summary { waiting: 1, oldest: Some(Micros(DAY)), lost: 0 };
    assert_eq!(Reader::open(&path).unwrap().outbox_summary().unwrap(), expected);
}

#[test]
fn a_span_is_sent_when_it_has_ended_and_again_after_a_late_sample() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("plant.db");
    let mut database = open(&path, Forward::Off);
    write(&mut database, DAY, &[valid(DAY, 1.0)]);
    assert!(page(&path).batches.is_empty());
    let after = DAY + 126 * Micros::SECOND;
    write(&mut database, after, &[]);
    write(&mut database, after, &[]);
    write(&mut database, after, &[valid(DAY + 1, 3.0)]);
    let spans: Vec<_> = batches(&path).into_iter().flat_map(|batch| batch.spans).collect();
    let short: Vec<_> = spans.iter().map(|span| (span.level, span.start_us, span.count, span.max_pa)).collect();
    assert_eq!(short, [(2, DAY, 1, Some(1.0)), (2, DAY, 2, Some(3.0))]);
}

#[test]
fn events_are_sent_once_also_those_before_the_outbox() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("plant.db");
    let event =
        |text: &str| RecordEvent { at: Micros(1), gauge: None, kind: EventKind::Note.into(), text: text.to_owned() };
    let mut database = Database::open(&path, Micros(DAY)).unwrap();
    database.write(&[], &PendingSpans::default(), &[event("before")], &AlarmBatch::default()).unwrap();
    database.set_outbox(Some(Forward::Off));
    database.write(&[], &PendingSpans::default(), &[event("after")], &AlarmBatch::default()).unwrap();
    database.write(&[], &PendingSpans::default(), &[], &AlarmBatch::default()).unwrap();
    let texts: Vec<_> = batches(&path).into_iter().flat_map(|batch| batch.events).map(|it| it.text).collect();
    assert_eq!(texts, ["before", "after"]);
}

#[test]
fn rows_after_a_retention_that_deleted_all_events_and_the_alarm_history_are_sent() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("plant.db");
    let mut database = open(&path, Forward::Off);
    database.begin_period(Micros(DAY)).unwrap();
    write_event_and_alarm(&mut database, DAY, "before");
    write_event_and_alarm(&mut database, DAY + 1, "before, too");
    let day = Some(Duration::from_secs(86_400));
    let retention = Retention { events: day, alarm_history: day, ..Retention::default() };
    database.extend_period(Micros(2 * DAY)).unwrap();
    database.prune(&retention).unwrap();
    assert_eq!(row_counts(&path), (2, 2), "the time is not over yet");
    database.extend_period(Micros(2 * DAY + 2)).unwrap();
    database.prune(&retention).unwrap();
    assert_eq!(row_counts(&path), (0, 0));
    drop(database);
    write_event_and_alarm(&mut open(&path, Forward::Off), 2 * DAY + 3, "after");
    let expected = [(1, "before"), (2, "before, too"), (3, "after")].map(|(id, text)| (id, text.to_owned()));
    assert_eq!(sent(&path), [expected.to_vec(), expected.to_vec()]);
}

/// Samples and events refer to a series by its id, and the retention counts the recording periods.
#[test]
fn a_retention_that_deletes_everything_leaves_the_series_and_the_recording_periods() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("plant.db");
    let mut database = open(&path, Forward::Off);
    database.begin_period(Micros(DAY)).unwrap();
    write(&mut database, DAY, &[valid(DAY, 1.0)]);
    write_event_and_alarm(&mut database, DAY, "deleted");
    database.extend_period(Micros(2 * DAY)).unwrap();
    database.begin_period(Micros(900 * DAY)).unwrap();
    database.extend_period(Micros(902 * DAY)).unwrap();
    let day = Some(Duration::from_secs(86_400));
    let retention =
        Retention { samples: day, spans: [day; 4], events: day, alarm_history: day, batches: Some(Duration::ZERO) };
    database.prune(&retention).unwrap();
    drop(database);
    let reader = Reader::open(&path).unwrap();
    let count = |table: &str| -> i64 {
        reader.connection().query_row(&format!("SELECT count(*) FROM {table}"), [], |row| row.get(0)).unwrap()
    };
    let deleted = ["sample", "span", "event", "alarm_history"].map(count);
    assert_eq!((deleted, count("series"), count("recording_period")), ([0; 4], 1, 2));
}

/// The last rows are the first to be deleted if the clock was behind when they were written.
#[test]
fn rows_after_a_retention_that_deleted_the_last_rows_alone_are_sent() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("plant.db");
    let mut database = open(&path, Forward::Off);
    database.begin_period(Micros(9 * DAY)).unwrap();
    database.extend_period(Micros(11 * DAY)).unwrap();
    write_event_and_alarm(&mut database, 11 * DAY, "kept");
    write_event_and_alarm(&mut database, DAY, "deleted");
    let day = Some(Duration::from_secs(86_400));
    database.prune(&Retention { events: day, alarm_history: day, ..Retention::default() }).unwrap();
    assert_eq!(row_counts(&path), (1, 1));
    write_event_and_alarm(&mut database, 11 * DAY, "after");
    let expected = [(1, "kept"), (2, "deleted"), (3, "after")].map(|(id, text)| (id, text.to_owned()));
    assert_eq!(sent(&path), [expected.to_vec(), expected.to_vec()]);
}

#[test]
fn the_deadband_passes_changes_of_five_percent_of_quality_and_one_sample_in_ten_minutes() {
    let mut last = HashMap::new();
    let five_percent = Forward::Deadband(1.05_f64.log10());
    let samples = [
        (valid(0, 1.0), true),
        (valid(1, 1.04), false),
        (valid(2, 1.051), true),
        (Sample::gap(Micros(3)), true),
        (Sample::gap(Micros(4)), false),
        (valid(5, 1.0), true),
        (valid(600 * Micros::SECOND + 5, 1.0), true),
    ];
    for (sample, passed) in samples {
        assert_eq!(passes(five_percent, &mut last, 1, &sample), passed, "{sample:?}");
    }
}

fn number(at: i64, number: f64) -> PointSample {
    PointSample::new(Micros(at), Some(number), Quality::Valid)
}

fn point(name: &str, unit: Option<&str>, kind: PointKind) -> Point {
    Point { slave: "turbo".to_owned(), name: name.to_owned(), unit: unit.map(str::to_owned), kind }
}

fn write_points(database: &mut Database, now: i64, point: &Point, samples: &[PointSample]) {
    let index = database.point_index(point);
    let mut points = NewPoints::default();
    samples.iter().for_each(|sample| points.add(index, *sample));
    database.set_time(Micros(now));
    let alarms = AlarmBatch::default();
    database.write_with_points(&[], &PendingSpans::default(), &points, &[], &alarms).unwrap();
}

#[test]
fn the_values_of_points_are_in_the_batches_with_their_unit_and_their_spans() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("plant.db");
    let mut database = open(&path, Forward::All);
    let (hertz, rpm) = (point("speed", Some("Hz"), PointKind::Number), point("speed", Some("rpm"), PointKind::Number));
    let state = point("state", None, PointKind::Code);
    write_points(&mut database, DAY, &hertz, &[number(DAY, -1.0), number(DAY + 1, 3.0)]);
    write_points(&mut database, DAY, &rpm, &[number(DAY + 2, 60.0)]);
    write_points(&mut database, DAY, &state, &[number(DAY + 3, 3.0)]);
    let sent = |path: &Path| batches(path).into_iter().flat_map(|batch| batch.point_samples).collect::<Vec<_>>();
    let values: Vec<_> = sent(&path).iter().map(|it| (it.point.clone(), it.unpack().unwrap())).collect();
    let expected = [
        (BatchPoint::of(&hertz), vec![number(DAY, -1.0), number(DAY + 1, 3.0)]),
        (BatchPoint::of(&rpm), vec![number(DAY + 2, 60.0)]),
        (BatchPoint::of(&state), vec![number(DAY + 3, 3.0)]),
    ];
    assert_eq!(values, expected);
    write(&mut database, DAY + 126 * Micros::SECOND, &[]);
    write(&mut database, DAY + 126 * Micros::SECOND, &[]);
    let spans: Vec<_> = batches(&path).into_iter().flat_map(|batch| batch.point_spans).collect();
    let of = |span: &PointSpan| (span.point.unit.clone(), span.level, span.sum, span.last_value, span.count);
    let spans: Vec<_> = spans.iter().map(of).collect();
    let expected = [("Hz", 2.0, 3.0, 2), ("rpm", 60.0, 60.0, 1), ("", 3.0, 3.0, 1)];
    let expected = expected.map(|(unit, sum, last, count)| (unit.to_owned(), 2, sum, Some(last), count));
    assert_eq!(spans, expected);
    assert!(batches(&path).iter().all(|batch| batch.samples.is_empty()), "no point is a series of pressures");
}

fn described(point: &Point, texts: &[(f64, &str)]) -> DescribedPoint {
    let texts = texts.iter().map(|(number, text)| CodeText { number: *number, text: (*text).to_owned() }).collect();
    DescribedPoint { point: point.clone(), texts }
}

#[test]
fn the_texts_of_a_code_are_sent_with_its_values_at_first_after_six_hours_and_after_a_change() {
    const SIX_HOURS: i64 = 6 * 3_600;
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("plant.db");
    let mut database = open(&path, Forward::All);
    let (state, speed) = (point("state", None, PointKind::Code), point("speed", Some("Hz"), PointKind::Number));
    let of_state = described(&state, &[(0.0, "stopped"), (3.0, "at speed")]);
    database.set_point_texts(vec![of_state, described(&speed, &[])]);
    let write_state = |database: &mut Database, second: i64| {
        let at = DAY + second * Micros::SECOND;
        write_points(database, at, &state, &[number(at, 3.0)]);
    };
    write_points(&mut database, DAY, &speed, &[number(DAY, 1.0)]);
    [0, 1, SIX_HOURS - 1, SIX_HOURS].into_iter().for_each(|second| write_state(&mut database, second));
    database.set_point_texts(vec![described(&state, &[(0.0, "stands")])]);
    write_state(&mut database, SIX_HOURS + 1);
    let texts = |batch: &Batch| {
        let of_state = batch.point_texts.iter().filter(|row| row.point == BatchPoint::of(&state));
        of_state.map(|row| format!("{} {}", row.value, row.text)).collect::<Vec<_>>().join(", ")
    };
    let sent: Vec<_> = batches(&path).iter().map(texts).collect();
    let all = "0 stopped, 3 at speed";
    assert_eq!(sent, ["", all, "", "", all, "0 stands"]);
}

#[test]
fn a_batch_has_at_most_a_thousand_texts_and_the_others_are_in_the_next_one() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("plant.db");
    let mut database = open(&path, Forward::All);
    let states = ["a", "b"].map(|name| point(name, None, PointKind::Code));
    let many: Vec<_> = (0..600_u32).map(|code| (f64::from(code), "text")).collect();
    database.set_point_texts(states.iter().map(|state| described(state, &many)).collect());
    for second in 0..2 {
        let mut points = NewPoints::default();
        for state in &states {
            points.add(database.point_index(state), number(DAY + second, 3.0));
        }
        let alarms = AlarmBatch::default();
        database.write_with_points(&[], &PendingSpans::default(), &points, &[], &alarms).unwrap();
    }
    let sent: Vec<_> = batches(&path).iter().map(|batch| batch.point_texts.len()).collect();
    assert_eq!(sent, [600, 600]);
}

/// An archive puts a batch with such a value aside, with all that is in it.
#[test]
fn a_text_of_a_value_that_no_sample_has_is_not_sent() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("plant.db");
    let mut database = open(&path, Forward::All);
    let state = point("state", None, PointKind::Code);
    database.set_point_texts(vec![described(&state, &[(-1e300, "far"), (3.0, "at speed"), (1e300, "farther")])]);
    write_points(&mut database, DAY, &state, &[number(DAY, 3.0)]);
    let texts: Vec<_> = batches(&path).iter().flat_map(|batch| &batch.point_texts).map(|row| row.value).collect();
    assert_eq!(texts, [3.0]);
}

#[test]
fn the_deadband_passes_changes_of_five_percent_of_a_number_and_each_change_of_a_code() {
    let five_percent = Forward::Deadband(1.05_f64.log10());
    let table = [
        (100.0, true, true),
        (104.0, false, true),
        (106.0, true, true),
        (106.0, false, false),
        (0.0, true, true),
        (0.0, false, false),
        (0.1, true, true),
        (-0.1, true, true),
    ];
    for is_code in [false, true] {
        let mut last = HashMap::new();
        for (at, (value, of_number, of_code)) in (0..).zip(table) {
            let passed = passes_point(five_percent, &mut last, 1, is_code, &number(at, value));
            assert_eq!(passed, if is_code { of_code } else { of_number }, "{value} {is_code}");
        }
        let gap = PointSample::gap(Micros(100));
        let passed = [gap, gap].map(|gap| passes_point(five_percent, &mut last, 1, is_code, &gap));
        assert_eq!(passed, [true, false], "{is_code}");
    }
    let mut last = HashMap::new();
    assert!(!passes_point(Forward::Off, &mut last, 1, true, &number(0, 1.0)));
}

#[test]
fn many_values_of_points_are_batches_of_their_own_and_each_is_in_one() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("plant.db");
    let mut database = open(&path, Forward::All);
    let speed = point("speed", Some("Hz"), PointKind::Number);
    database.set_point_texts(vec![described(&speed, &[(1.0, "slow")])]);
    let (series, index) = (database.series_index("chamber"), database.point_index(&speed));
    let count = MAX_SAMPLES as i64 + 1;
    let samples = (0..count).map(|at| (index, number(DAY + at, 1.0))).collect();
    let points = NewPoints { samples, spans: PendingSpans::default() };
    let pressures = [(series, valid(DAY, 1.0))];
    database.set_time(Micros(DAY));
    let alarms = AlarmBatch::default();
    database.write_with_points(&pressures, &PendingSpans::default(), &points, &[], &alarms).unwrap();
    let of = |batch: &Batch| (batch.sample_count(), batch.point_texts.len(), batch.first_number);
    let counts: Vec<_> = batches(&path).iter().map(of).collect();
    assert_eq!(counts, [(1, 0, 1), (MAX_SAMPLES, 1, 1), (1, 0, 1)], "samples, texts, number of the first batch");
}

#[test]
fn many_samples_of_one_transaction_are_several_batches() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("plant.db");
    let count = MAX_SAMPLES as i64 + 1;
    let samples: Vec<_> = (0..count).map(|at| valid(DAY + at, 1.0)).collect();
    write(&mut open(&path, Forward::All), DAY, &samples);
    let counts: Vec<_> = batches(&path).iter().map(Batch::sample_count).collect();
    assert_eq!(counts, [MAX_SAMPLES, 1]);
}

#[test]
fn an_acknowledged_batch_is_kept_as_it_was_for_a_day_after_the_database_of_the_archive_has_it() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("plant.db");
    let mut database = open(&path, Forward::All);
    database.begin_period(Micros(DAY)).unwrap();
    (0..3).for_each(|second| write(&mut database, DAY, &[valid(DAY + second, 1.0)]));
    let Page { epoch, batches: sent } = page(&path);
    database.set_time(Micros(DAY + 5));
    database.acknowledge_outbox(taken(epoch, 2)).unwrap();
    let reader = Reader::open(&path).unwrap();
    assert_eq!(reader.kept_batches(epoch, 1..=9, 100, usize::MAX).unwrap(), sent[..2]);
    assert_eq!(reader.kept_batches(epoch, 2..=9, 100, usize::MAX).unwrap(), sent[1..2]);
    assert_eq!(reader.kept_batches(epoch + 1, 1..=9, 100, usize::MAX).unwrap(), [], "of another database");
    let retention = Retention { batches: Some(Duration::from_secs(86_400)), ..Retention::default() };
    let prune_at = |database: &mut Database, at: i64| {
        database.extend_period(Micros(at)).unwrap();
        database.prune(&retention).unwrap();
    };
    prune_at(&mut database, 9 * DAY);
    assert_eq!(kept(&path, epoch), [1, 2], "the database of the archive may lack them");
    database.acknowledge_outbox(Acknowledgement { epoch, taken: 0, stored: 1 }).unwrap();
    prune_at(&mut database, 9 * DAY);
    assert_eq!(kept(&path, epoch), [2]);
    database.set_time(Micros(9 * DAY));
    database.acknowledge_outbox(Acknowledgement { epoch, taken: 3, stored: 3 }).unwrap();
    prune_at(&mut database, 10 * DAY);
    assert_eq!(kept(&path, epoch), [3], "a day after its acknowledgement");
    prune_at(&mut database, 10 * DAY + 1);
    assert_eq!(kept(&path, epoch), [] as [i64; 0]);
}

#[test]
fn a_full_disk_keeps_no_batches_that_were_taken() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("plant.db");
    let mut database = open(&path, Forward::All);
    let samples: Vec<_> = (0..20_000).map(|at| valid(DAY + at, 1.0 + at as f64)).collect();
    write(&mut database, DAY, &samples);
    let epoch = page(&path).epoch;
    database.limit_pages(1);
    database.acknowledge_outbox(taken(epoch, 1)).unwrap();
    assert_eq!((page(&path).batches.len(), kept(&path, epoch)), (0, Vec::new()));
}

#[test]
fn a_full_outbox_is_an_event_when_it_begins_and_one_when_batches_are_taken_again() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("plant.db");
    let mut database = open(&path, Forward::All);
    let mut second = 0;
    let mut write_next = |database: &mut Database| {
        second += 1;
        write(database, DAY + second, &[valid(DAY + second, 1.0)]);
    };
    (0..2).for_each(|_| write_next(&mut database));
    // As if the batches between had been written.
    let last = "UPDATE sqlite_sequence SET seq = ?1 WHERE name = 'outbox'";
    rusqlite::Connection::open(&path).unwrap().execute(last, [MAX_BATCHES]).unwrap();
    let events = || -> Vec<String> {
        let events = Reader::open(&path).unwrap().events(Micros(0), Micros(i64::MAX), 100).unwrap();
        events.into_iter().rev().map(|event| event.text).collect()
    };
    let lost = || Reader::open(&path).unwrap().outbox_summary().unwrap().lost;
    write_next(&mut database);
    assert_eq!((lost(), events().len()), (1, 1));
    assert!(events()[0].starts_with("2592000 batches wait for the archive, and none is taken"), "{:?}", events());
    write_next(&mut database);
    assert_eq!((lost(), events().len()), (2, 1), "it is reported once");
    database.acknowledge_outbox(taken(page(&path).epoch, MAX_BATCHES + 1)).unwrap();
    assert_eq!((lost(), events().len()), (0, 2));
    assert!(events()[1].starts_with("batches are taken again; 2 that waited"), "{:?}", events());
}

#[test]
fn a_copy_that_was_put_back_goes_on_as_another_database_from_the_first_number_that_was_given_twice() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("plant.db");
    let mut database = open(&path, Forward::All);
    (0..5).for_each(|second| write(&mut database, DAY, &[valid(DAY + second, 1.0)]));
    let Page { epoch, batches: before } = page(&path);
    database.acknowledge_outbox(taken(epoch, 3)).unwrap();
    database.set_time(Micros(DAY + 9));
    database.branch_outbox(epoch + 1, 3).unwrap();
    assert_eq!(page(&path).epoch, epoch, "of another database");
    database.branch_outbox(epoch, 3).unwrap();
    let waiting: Vec<_> = page(&path).batches.iter().map(|batch| (batch.epoch, batch.number)).collect();
    assert_eq!(waiting, [(DAY + 9, 3), (DAY + 9, 4), (DAY + 9, 5)]);
    assert_eq!(kept(&path, epoch), [1, 2]);
    let first = Batch::decode_compressed(&before[2].payload).unwrap();
    assert_eq!(batches(&path)[0], Batch { first_number: 3, ..first });
    database.branch_outbox(epoch, 3).unwrap();
    assert_eq!(page(&path).epoch, DAY + 9, "told once more");
    write(&mut database, DAY + 9, &[valid(DAY + 9, 1.0)]);
    let last = batches(&path).pop().unwrap();
    assert_eq!((last.first_number, last.events.len()), (3, 1), "the event about it");
}

#[test]
fn more_batches_than_a_page_are_sent_again() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("plant.db");
    let mut database = open(&path, Forward::All);
    let count = 1_203;
    (0..count).for_each(|second| write(&mut database, DAY, &[valid(DAY + second, 1.0)]));
    let epoch = page(&path).epoch;
    database.acknowledge_outbox(taken(epoch, 700)).unwrap();
    database.set_time(Micros(DAY + 9));
    database.branch_outbox(epoch, 101).unwrap();
    let connection = rusqlite::Connection::open(&path).unwrap();
    let sql = "SELECT min(number), max(number), count(*), count(epoch) FROM outbox";
    let row = |row: &Row<'_>| Ok((row.get(0)?, row.get(1)?, row.get(2)?, row.get(3)?));
    let found: (i64, i64, i64, i64) = connection.query_row(sql, [], row).unwrap();
    assert_eq!(found, (101, count, count - 100, 0));
    assert_eq!(kept(&path, epoch), (1..=100).collect::<Vec<_>>());
}

/// An archive shows the alarms of the present epoch only.
#[test]
fn a_new_epoch_begins_with_the_standing_alarms() {
    let folder = tempfile::tempdir().unwrap();
    let (path, copy) = (folder.path().join("plant.db"), folder.path().join("copy.db"));
    let mut database = open(&path, Forward::All);
    write_event_and_alarm(&mut database, DAY, "raised");
    write(&mut database, DAY, &[valid(DAY, 1.0)]);
    Reader::open(&path).unwrap().backup(&copy, Existing::Keep, |_, _| ()).unwrap();
    let alarms = |path: &Path| batches(path).iter().map(|batch| batch.alarms.len()).collect::<Vec<_>>();
    assert_eq!(alarms(&path), [1, 0]);
    let epoch = page(&path).epoch;
    database.set_time(Micros(DAY + 9));
    database.branch_outbox(epoch, 2).unwrap();
    write(&mut database, DAY + 9, &[valid(DAY + 9, 1.0)]);
    assert_eq!(alarms(&path), [1, 0, 1], "of a copy that was put back");
    write(&mut open(&copy, Forward::All), DAY + 7, &[valid(DAY + 9, 1.0)]);
    assert_eq!(alarms(&copy), [1, 0, 1], "of a copy that was made for it");
}

#[test]
fn a_batch_has_the_number_of_the_first_one_of_its_epoch() {
    let folder = tempfile::tempdir().unwrap();
    let (path, copy) = (folder.path().join("plant.db"), folder.path().join("copy.db"));
    let mut database = open(&path, Forward::All);
    (0..2).for_each(|second| write(&mut database, DAY, &[valid(DAY + second, 1.0)]));
    let firsts = |path: &Path| batches(path).iter().map(|batch| batch.first_number).collect::<Vec<_>>();
    assert_eq!(firsts(&path), [1, 1]);
    Reader::open(&path).unwrap().backup(&copy, Existing::Keep, |_, _| ()).unwrap();
    write(&mut open(&copy, Forward::All), DAY + 7, &[valid(DAY + 9, 1.0)]);
    assert_eq!(firsts(&copy), [1, 1, 3]);
}

#[test]
fn a_restored_copy_begins_another_epoch_and_its_waiting_batches_keep_theirs() {
    let folder = tempfile::tempdir().unwrap();
    let (path, copy) = (folder.path().join("plant.db"), folder.path().join("copy.db"));
    write(&mut open(&path, Forward::All), DAY, &[valid(DAY, 1.0)]);
    Reader::open(&path).unwrap().backup(&copy, Existing::Keep, |_, _| ()).unwrap();
    write(&mut open(&copy, Forward::All), DAY + 7, &[valid(DAY + 1, 1.0)]);
    assert_eq!((page(&path).epoch, page(&copy).epoch), (DAY, DAY + 7));
    let of_copy: Vec<_> = page(&copy).batches.iter().map(|batch| (batch.epoch, batch.number)).collect();
    assert_eq!(of_copy, [(DAY, 1), (DAY + 7, 2)]);
    assert_eq!(page(&copy).batches[0], page(&path).batches[0]);
    let mut copied = open(&copy, Forward::All);
    copied.acknowledge_outbox(taken(DAY + 7, 2)).unwrap();
    assert_eq!((kept(&copy, DAY), kept(&copy, DAY + 7)), (vec![1], vec![2]));
}

/// Opens the database of a station without `[archive]`.
fn open_without(path: &Path) -> Database {
    Database::open(path, Micros(DAY)).unwrap()
}

/// The samples of pressures in the batches, in the order of their times.
fn sent_samples(path: &Path) -> Vec<Sample> {
    let all = Reader::open(path).unwrap().outbox(0, 10_000, usize::MAX).unwrap().batches;
    let batches = all.iter().map(|waiting| Batch::decode_compressed(&waiting.payload).unwrap());
    let mut samples: Vec<_> = batches.flat_map(|batch| batch.samples).flat_map(|it| it.unpack().unwrap()).collect();
    samples.sort_by_key(|sample| sample.at);
    samples
}

#[test]
fn what_was_recorded_without_an_outbox_is_sent_when_there_is_one_again() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("plant.db");
    let second = |number: i64| DAY + number * Micros::SECOND;
    let speed = point("speed", Some("Hz"), PointKind::Number);
    write(&mut open(&path, Forward::All), second(0), &[valid(second(0), 1.0)]);
    let mut without = open_without(&path);
    write(&mut without, second(200), &[valid(second(130), 2.0), valid(second(200), 3.0)]);
    write_points(&mut without, second(201), &speed, &[number(second(201), 7.0)]);
    write_event_and_alarm(&mut without, second(202), "meanwhile");
    drop(without);
    let mut again = open(&path, Forward::All);
    write(&mut again, second(500), &[valid(second(500), 4.0)]);
    write(&mut again, second(1_000), &[]);
    let all = Reader::open(&path).unwrap().samples("chamber", Micros(0), Micros(i64::MAX)).unwrap();
    assert_eq!(all.len(), 4);
    assert_eq!(
        sent_samples(&path).iter().filter(|sample| sample.at.0 < second(500)).copied().collect::<Vec<_>>(),
        all[..3]
    );
    let batches = batches(&path);
    let points: Vec<_> = batches.iter().flat_map(|batch| &batch.point_samples).map(|it| it.unpack().unwrap()).collect();
    assert_eq!(points, [[number(second(201), 7.0)]]);
    let spans: Vec<_> = batches.iter().flat_map(|batch| &batch.spans).map(|span| (span.level, span.start_us)).collect();
    assert_eq!(spans, [(2, second(0)), (2, second(120)), (2, second(480))]);
    let point_spans = batches.iter().flat_map(|batch| &batch.point_spans).filter(|span| span.level == 2);
    assert_eq!(point_spans.map(|span| span.start_us).collect::<Vec<_>>(), [second(120)]);
    let [events, alarms] = sent(&path);
    let texts: Vec<_> = events.iter().map(|(_, text)| text.as_str()).collect();
    assert!(texts.contains(&"meanwhile") && alarms.len() == 1, "{texts:?}");
    let said = "the station sends to an archive again, also what it has recorded since 1970-01-02T00:02:";
    assert_eq!(texts.iter().filter(|text| text.starts_with(said)).count(), 1, "{texts:?}");
    // It is over.
    let count = page(&path).batches.len();
    write(&mut again, second(1_001), &[]);
    assert_eq!(page(&path).batches.len(), count);
}

#[test]
fn a_long_time_without_an_outbox_comes_in_pages_also_after_a_second_absence() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("plant.db");
    write(&mut open(&path, Forward::All), DAY, &[valid(DAY, 1.0)]);
    let many: Vec<_> = (1..=12_000).map(|number| valid(DAY + number * 1_000, number as f64)).collect();
    write(&mut open_without(&path), DAY + 20 * Micros::SECOND, &many);
    let mut again = open(&path, Forward::All);
    write(&mut again, DAY + 21 * Micros::SECOND, &[]);
    let first = sent_samples(&path).len();
    assert!((2..12_000).contains(&first), "{first} samples in the first transaction");
    drop(again);
    write(&mut open_without(&path), DAY + 30 * Micros::SECOND, &[valid(DAY + 30 * Micros::SECOND, 5.0)]);
    let mut again = open(&path, Forward::All);
    (40..50).for_each(|second| write(&mut again, DAY + second * Micros::SECOND, &[]));
    let mut sent: Vec<_> = sent_samples(&path);
    sent.dedup();
    assert_eq!(Reader::open(&path).unwrap().samples("chamber", Micros(0), Micros(i64::MAX)).unwrap(), sent);
}

#[test]
fn the_deadband_holds_for_what_was_recorded_without_an_outbox() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("plant.db");
    let forward = Forward::Deadband(1.05_f64.log10());
    write(&mut open(&path, forward), DAY, &[valid(DAY, 1.0)]);
    let later = DAY + 20 * Micros::SECOND;
    let samples = [valid(later + 1, 1.0), valid(later + 2, 1.01), valid(later + 3, 2.0), valid(later + 4, 2.01)];
    write(&mut open_without(&path), later + 5, &samples);
    write(&mut open(&path, forward), later + 6, &[]);
    assert_eq!(sent_samples(&path), [valid(DAY, 1.0), valid(later + 1, 1.0), valid(later + 3, 2.0)]);
}

#[test]
fn a_station_that_never_had_an_outbox_begins_with_it() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("plant.db");
    write(&mut open_without(&path), DAY, &[valid(DAY, 1.0)]);
    let mut database = open(&path, Forward::All);
    write(&mut database, DAY + 1, &[valid(DAY + 1, 2.0)]);
    write(&mut database, DAY + 2, &[]);
    assert_eq!(sent_samples(&path), [valid(DAY + 1, 2.0)]);
}
