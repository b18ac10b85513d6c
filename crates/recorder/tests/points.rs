//! Values of points are recorded in their unit, and never among the pressures.

#![allow(clippy::unwrap_used, clippy::panic, clippy::indexing_slicing, reason = "a test")]

use crate::common::{Fixture, keep_everything};
use profivac_recorder::batch::Batch;
use profivac_recorder::{
    Chunks, CodeText, Deadband, DescribedPoint, Event, EventKind, Export, Forward, Micros, Point, PointKind,
    PointSample, PointTrend, Quality, Reader, Recorder, Retention, Sample, Settings,
};
use rusqlite::Connection;
use std::sync::Arc;
use std::time::Duration;

/// A start of a span of six hours.
const BEGIN: i64 = 1_767_225_600 * Micros::SECOND;

fn at(second: i64) -> Micros {
    Micros(BEGIN + second * Micros::SECOND)
}

fn valid(second: i64, number: f64) -> PointSample {
    PointSample::new(at(second), Some(number), Quality::Valid)
}

fn point(name: &str, unit: Option<&str>, kind: PointKind) -> Arc<Point> {
    Arc::new(Point { slave: "turbo".to_owned(), name: name.to_owned(), unit: unit.map(str::to_owned), kind })
}

fn speed() -> Arc<Point> {
    point("speed", Some("Hz"), PointKind::Number)
}

fn state() -> Arc<Point> {
    point("state", None, PointKind::Code)
}

/// Settings with the default deadband, whose longest interval is a minute.
fn thinned() -> Settings {
    Settings { deadband: Deadband::default(), ..keep_everything() }
}

fn seconds(samples: &[PointSample]) -> Vec<i64> {
    samples.iter().map(|sample| (sample.at.0 - BEGIN) / Micros::SECOND).collect()
}

fn stored(reader: &Reader, point: &Point) -> Vec<PointSample> {
    reader.point_page(point, at(-1000), at(100_000), u32::MAX).unwrap()
}

#[test]
fn values_are_read_back_in_their_unit_and_are_no_pressures() {
    let fixture = Fixture::new();
    let values = [
        valid(0, -12.5),
        valid(1, 0.0),
        PointSample::new(at(2), None, Quality::Fault),
        PointSample::gap(at(3)),
        valid(4, 4_294_967_295.0),
    ];
    let recorder = fixture.recorder(keep_everything());
    values.iter().for_each(|value| recorder.push_point(&speed(), 0.0, *value));
    recorder.push(&Arc::from("chamber"), Sample::new(at(0), Some(1.0), Quality::Valid));
    assert!(recorder.flush());
    let reader = fixture.reader();
    assert_eq!(reader.points().unwrap(), [Point::clone(&speed())]);
    assert_eq!(stored(&reader, &speed()), values);
    assert_eq!(reader.point_time_range(&speed()).unwrap(), Some((at(0), at(4))));
    assert_eq!(reader.series_names().unwrap(), ["chamber"]);
    for name in ["turbo", "speed", "turbo.speed"] {
        assert_eq!(reader.samples(name, at(0), at(10)).unwrap(), []);
        assert_eq!(reader.trend(name, at(0), at(10), 10).unwrap(), []);
    }
    let connection = Connection::open(&fixture.path).unwrap();
    let count = |sql: &str| -> i64 { connection.query_row(sql, [], |row| row.get(0)).unwrap() };
    assert_eq!(count("SELECT count(*) FROM sample"), 1, "the pressure");
    assert_eq!(count("SELECT count(*) FROM span"), 4);
}

#[test]
fn a_number_has_a_band_in_its_unit_and_a_code_is_kept_at_each_change() {
    let fixture = Fixture::new();
    let recorder = fixture.recorder(thinned());
    for (second, (number, code)) in (0..).zip([(0.0, 3.0), (1.0, 3.0), (-1.0, 4.0), (0.5, 4.0), (1.5, 3.0)]) {
        recorder.push_point(&speed(), 1.0, valid(second, number));
        recorder.push_point(&state(), 0.0, valid(second, code));
    }
    recorder.finish().unwrap();
    let reader = fixture.reader();
    assert_eq!(seconds(&stored(&reader, &speed())), [0, 3, 4]);
    assert_eq!(seconds(&stored(&reader, &state())), [0, 1, 2, 3, 4]);
}

/// The mean is that of all values, also of those that the deadband leaves out.
#[test]
fn a_trend_has_the_mean_of_a_number_and_the_last_value_of_a_code() {
    let fixture = Fixture::new();
    let recorder = fixture.recorder(thinned());
    for second in 0..20 {
        recorder.push_point(&speed(), 1000.0, valid(second, f64::from(u32::try_from(second).unwrap()) - 9.5));
        recorder.push_point(&state(), 0.0, valid(second, if second < 15 { 3.0 } else { 1.0 }));
        // Each second is a transaction, which adds to the spans of the one before.
        assert!(recorder.flush());
    }
    recorder.finish().unwrap();
    drop(recorder);
    // Five seconds are shorter than the shortest span, so these are the kept values.
    let codes = fixture.reader().point_trend(&state(), at(0), at(20), 4).unwrap();
    let codes = PointTrend::of(described(vec![Point::clone(&state())]).remove(0), &codes);
    let each = vec![Some(3.0), Some(3.0), Some(1.0)];
    assert_eq!((codes.low, codes.high, codes.last, codes.mean), (each.clone(), each.clone(), each, vec![None; 3]));

    Connection::open(&fixture.path).unwrap().execute("DELETE FROM point_sample", []).unwrap();
    let reader = fixture.reader();
    let trend = |point: &Arc<Point>| {
        let spans = reader.point_trend(point, at(0), at(19), 19).unwrap();
        PointTrend::of(described(vec![Point::clone(point)]).remove(0), &spans)
    };
    let numbers = trend(&speed());
    assert_eq!(numbers.mean, [Some(-5.0), Some(5.0)]);
    assert_eq!((numbers.low, numbers.high), (vec![Some(-9.5), Some(0.5)], vec![Some(-0.5), Some(9.5)]));
    let codes = trend(&state());
    assert_eq!((codes.mean, codes.last), (vec![None; 2], vec![Some(3.0), Some(1.0)]));
}

#[test]
fn another_unit_is_another_point_and_the_present_one_is_that_of_the_last_value() {
    let fixture = Fixture::new();
    let recorder = fixture.recorder(keep_everything());
    let in_rpm = point("speed", Some("rpm"), PointKind::Number);
    recorder.push_point(&speed(), 0.0, valid(0, 1000.0));
    recorder.push_point(&in_rpm, 0.0, valid(1, 60_000.0));
    assert!(recorder.flush());
    let reader = fixture.reader();
    let found = |unit: Option<&str>| reader.point("turbo", "speed", unit).unwrap();
    assert_eq!(found(None), Some(Point::clone(&in_rpm)));
    assert_eq!(found(Some("Hz")), Some(Point::clone(&speed())));
    assert_eq!((found(Some("kHz")), found(Some(""))), (None, None));
    assert_eq!(stored(&reader, &speed()), [valid(0, 1000.0)]);
    // The file of the station has the former unit again.
    recorder.push_point(&speed(), 0.0, valid(2, 1001.0));
    assert!(recorder.flush());
    assert_eq!(found(None), Some(Point::clone(&speed())));
    assert_eq!(reader.points().unwrap().len(), 2);
}

#[test]
fn an_event_of_the_slave_keeps_every_value_around_it() {
    let kept = |gauge: Option<&str>| {
        let fixture = Fixture::new();
        let recorder = fixture.recorder(thinned());
        (0..20).for_each(|second| recorder.push_point(&speed(), 1.0, valid(second, 7.0)));
        let kind = EventKind::Gauge.into();
        recorder.record_event(Event { at: at(19), gauge: gauge.map(str::to_owned), kind, text: "x".to_owned() });
        assert!(recorder.flush());
        seconds(&stored(&fixture.reader(), &speed()))
    };
    let around = [0, 14, 15, 16, 17, 18, 19];
    assert_eq!((kept(Some("turbo")), kept(None)), (around.to_vec(), around.to_vec()));
    assert_eq!(kept(Some("chamber")), [0]);
}

#[test]
fn a_retention_deletes_values_and_their_spans_and_keeps_the_point() {
    let fixture = Fixture::new();
    let day = 86_400;
    let recorder = fixture.recorder(keep_everything());
    [0, day, 3 * day].into_iter().for_each(|second| recorder.push_point(&speed(), 0.0, valid(second, 7.0)));
    recorder.finish().unwrap();
    drop(recorder);
    let mut database = profivac_recorder::database::Database::open(&fixture.path, at(0)).unwrap();
    database.begin_period(at(0)).unwrap();
    database.extend_period(at(3 * day)).unwrap();
    let kept = Some(Duration::from_secs(2 * 86_400));
    let retention = Retention { samples: kept, spans: [kept; 4], ..Retention::default() };
    database.prune(&retention).unwrap();
    drop(database);
    let reader = fixture.reader();
    let left = reader.point_page(&speed(), at(0), at(4 * day), u32::MAX).unwrap();
    assert_eq!(seconds(&left), [day, 3 * day]);
    let connection = Connection::open(&fixture.path).unwrap();
    let starts: i64 =
        connection.query_row("SELECT count(*) FROM point_span WHERE level = 4", [], |row| row.get(0)).unwrap();
    assert_eq!((starts, reader.points().unwrap().len()), (2, 1));
}

/// The points with the texts of a file that has one for the code 3 of the state.
fn described(points: Vec<Point>) -> Vec<DescribedPoint> {
    let texts = |point: &Point| match point.kind {
        PointKind::Code => vec![CodeText { number: 3.0, text: "at speed, warm".to_owned() }],
        PointKind::Number => Vec::new(),
    };
    points.into_iter().map(|point| DescribedPoint { texts: texts(&point), point }).collect()
}

#[test]
fn a_batch_for_an_archive_has_the_texts_of_its_codes() {
    let fixture = Fixture::new();
    let recorder = fixture.recorder(Settings { outbox: Some(Forward::All), ..keep_everything() });
    recorder.set_point_texts(described(vec![Point::clone(&state()), Point::clone(&speed())]));
    recorder.push_point(&state(), 0.0, valid(0, 3.0));
    recorder.push_point(&speed(), 0.0, valid(0, 1000.0));
    assert!(recorder.flush());
    let page = fixture.reader().outbox(0, 100, usize::MAX).unwrap();
    let batches = page.batches.iter().map(|waiting| Batch::decode_compressed(&waiting.payload).unwrap());
    let texts: Vec<_> = batches.flat_map(|batch| batch.point_texts).collect();
    let texts: Vec<_> = texts.iter().map(|row| (row.point.name.as_str(), row.value, row.text.as_str())).collect();
    assert_eq!(texts, [("state", 3.0, "at speed, warm")]);
}

#[test]
fn an_export_says_the_unit_of_each_value_and_the_text_of_each_code() {
    let fixture = Fixture::new();
    let recorder = fixture.recorder(keep_everything());
    recorder.push_point(&speed(), 0.0, valid(0, 1000.5));
    recorder.push_point(&speed(), 0.0, PointSample::gap(at(1)));
    recorder.push_point(&state(), 0.0, valid(1, 3.0));
    recorder.push_point(&state(), 0.0, valid(2, 4.0));
    assert!(recorder.flush());
    let points = described(fixture.reader().points().unwrap());
    let rows: String = Export::new(fixture.reader(), points, at(0), at(10)).map(Result::unwrap).collect();
    let expected = "\
time,slave,point,unit,value,quality,text
2026-01-01T00:00:00.000000Z,turbo,speed,Hz,1000.5,valid,
2026-01-01T00:00:01.000000Z,turbo,speed,Hz,,stale,
2026-01-01T00:00:01.000000Z,turbo,state,,3,valid,\"at speed, warm\"
2026-01-01T00:00:02.000000Z,turbo,state,,4,valid,
";
    assert_eq!(rows, expected);
    let names = fixture.reader().series_names().unwrap();
    let pressures: String = Export::new(fixture.reader(), names, at(0), at(10)).map(Result::unwrap).collect();
    assert_eq!(pressures, "time,gauge,pressure_pa,quality\n");
}

#[test]
fn an_export_has_each_value_once_across_its_chunks() {
    let fixture = Fixture::new();
    let recorder = fixture.recorder(keep_everything());
    for second in 0..4_500 {
        recorder.push_point(&speed(), 0.0, valid(second, 7.0));
    }
    recorder.push_point(&state(), 0.0, valid(0, 1.0));
    assert!(recorder.flush());
    let points = described(fixture.reader().points().unwrap());
    let chunks = Chunks::new(fixture.reader(), points, at(0), at(4_000));
    let counts: Vec<_> = chunks.map(|chunk| chunk.unwrap().samples.len()).collect();
    assert_eq!(counts, [2_000, 2_000, 1, 1]);
}

#[cfg(feature = "parquet")]
#[test]
fn a_parquet_file_of_points_has_the_unit_and_the_text_beside_each_value() {
    use parquet::file::reader::{FileReader, SerializedFileReader};
    use parquet::record::Field;
    let fixture = Fixture::new();
    let recorder = fixture.recorder(keep_everything());
    recorder.push_point(&speed(), 0.0, valid(0, -1.5));
    recorder.push_point(&state(), 0.0, PointSample::gap(at(1)));
    recorder.push_point(&state(), 0.0, valid(2, 3.0));
    assert!(recorder.flush());
    let chunks = Chunks::new(fixture.reader(), described(fixture.reader().points().unwrap()), at(0), at(10));
    let to = fixture.path.with_extension("parquet");
    assert_eq!(profivac_recorder::parquet::write(chunks, std::fs::File::create(&to).unwrap()).unwrap(), 3);
    let file = SerializedFileReader::new(std::fs::File::open(&to).unwrap()).unwrap();
    let rows: Vec<Vec<(String, Field)>> =
        file.get_row_iter(None).unwrap().map(|row| row.unwrap().into_columns()).collect();
    let text = |text: &str| Field::Str(text.to_owned());
    let row = |at: Micros, point: &str, unit: &str, value: Field, quality: &str, of_code: Field| {
        let series = [Field::TimestampMicros(at.0), text("turbo"), text(point), text(unit)];
        let fields = series.into_iter().chain([value, text(quality), of_code]);
        let names = ["time", "slave", "point", "unit", "value", "quality", "text"].map(str::to_owned);
        names.into_iter().zip(fields).collect::<Vec<_>>()
    };
    assert_eq!(rows[0], row(at(0), "speed", "Hz", Field::Double(-1.5), "valid", Field::Null));
    assert_eq!(rows[1], row(at(1), "state", "", Field::Null, "stale", Field::Null));
    assert_eq!(rows[2], row(at(2), "state", "", Field::Double(3.0), "valid", text("at speed, warm")));
}

#[test]
fn values_go_on_in_a_database_that_was_created_again() {
    let fixture = Fixture::new();
    let recorder = Recorder::start(&fixture.path, keep_everything()).unwrap();
    recorder.push_point(&state(), 0.0, valid(0, 5.0));
    recorder.push_point(&speed(), 0.0, valid(0, 1.0));
    assert!(recorder.flush());
    std::fs::remove_file(&fixture.path).unwrap();
    recorder.push_point(&speed(), 0.0, valid(1, 2.0));
    assert!(recorder.flush());
    // The event of the new file brings the values before it, each under its own point.
    let reader = fixture.reader();
    let numbers = |point: &Point| stored(&reader, point).iter().map(|sample| sample.number).collect::<Vec<_>>();
    assert_eq!(numbers(&speed()).last(), Some(&Some(2.0)));
    assert!(!numbers(&speed()).contains(&Some(5.0)) && !numbers(&state()).contains(&Some(2.0)));
}
