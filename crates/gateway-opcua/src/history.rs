//! Reading of raw history (OPC 10000-11) from the record.

use crate::plan::History;
use crate::value::{micros, of_point_sample, of_sample, time};
use opcua_types::{DataValue, ReadRawModifiedDetails, StatusCode};
use profivac_recorder::{DatabaseError, Micros, Reader};

/// The most samples of an answer; the rest follows with a continuation point.
pub const MAX_SAMPLES: u32 = 5_000;

/// The width of the first step into the past, in microseconds. chosen: 2,000 samples at the shortest interval of 50 ms.
const FIRST_STEP: i64 = 100 * Micros::SECOND;

/// What a client asks for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Query {
    /// From the first time to the second, the oldest first.
    Forward(Micros, Micros),
    /// From the first time back to the second, the newest first.
    Backward(Micros, Micros),
}

impl Query {
    /// The rest of the query behind a value of this time.
    const fn after(self, at: Micros) -> Self {
        match self {
            Self::Forward(_, to) => Self::Forward(Micros(at.0.saturating_add(1)), to),
            Self::Backward(_, to) => Self::Backward(Micros(at.0.saturating_sub(1)), to),
        }
    }
}

/// An answer.
#[derive(Debug, Default)]
pub struct Answer {
    /// The samples.
    pub values: Vec<DataValue>,
    /// The rest, for the next request.
    pub rest: Option<Query>,
}

/// The query of these details, and the most samples of an answer. OPC 10000-11, 6.5.3: without one of the times, or with the later time
/// first, the order follows from what is given.
///
/// # Errors
/// The status for the client.
pub fn query(details: &ReadRawModifiedDetails) -> Result<(Query, u32), StatusCode> {
    if details.is_read_modified {
        return Err(StatusCode::BadHistoryOperationUnsupported);
    }
    let count = details.num_values_per_node;
    let limit = if count == 0 { MAX_SAMPLES } else { count.min(MAX_SAMPLES) };
    let query = match (micros(&details.start_time), micros(&details.end_time)) {
        (Some(start), Some(end)) if start <= end => Query::Forward(start, end),
        (Some(start), Some(end)) => Query::Backward(start, end),
        (Some(start), None) if count > 0 => Query::Forward(start, Micros(i64::MAX)),
        (None, Some(end)) if count > 0 => Query::Backward(end, Micros(0)),
        _ => return Err(StatusCode::BadHistoryOperationInvalid),
    };
    Ok((query, limit))
}

/// Reads the answer to a query, at most `limit` samples.
///
/// # Errors
/// When the database cannot be read.
pub fn read(reader: &Reader, history: &History, query: Query, limit: u32) -> Result<Answer, DatabaseError> {
    let known = match history {
        History::Series(series) => reader.time_range(series)?,
        History::Point { point, .. } => reader.point_time_range(point)?,
    };
    let Some((first, last)) = known else { return Ok(Answer::default()) };
    let (samples, is_complete) = match query {
        Query::Forward(from, to) => page(reader, history, (from, to), limit)?,
        Query::Backward(from, to) => backward(reader, history, (from.min(last), to.max(first)), limit)?,
    };
    let rest = samples.last().filter(|_| !is_complete).map(|(at, _)| query.after(*at));
    Ok(Answer { values: samples.into_iter().map(|(_, value)| value).collect(), rest })
}

/// The first values of a time, each with its time, and whether these are all.
fn page(
    reader: &Reader,
    history: &History,
    (from, to): (Micros, Micros),
    limit: u32,
) -> Result<(Vec<(Micros, DataValue)>, bool), DatabaseError> {
    let one_more = limit.saturating_add(1);
    let mut values: Vec<(Micros, DataValue)> = match history {
        History::Series(series) => {
            let samples = reader.page(series, from, to, one_more)?;
            samples.iter().map(|sample| (sample.at, of_sample(sample))).collect()
        }
        History::Point { point, data_type } => {
            let samples = reader.point_page(point, from, to, one_more)?;
            samples.iter().map(|sample| (sample.at, of_point_sample(sample, *data_type))).collect()
        }
    };
    let is_complete = values.len() <= limit as usize;
    values.truncate(limit as usize);
    Ok((values, is_complete))
}

/// The last values of a time, the newest first, and whether these are all. The record is read in steps into the past, shorter ones
/// where it has more samples.
fn backward(
    reader: &Reader,
    history: &History,
    (from, to): (Micros, Micros),
    limit: u32,
) -> Result<(Vec<(Micros, DataValue)>, bool), DatabaseError> {
    let (mut values, mut end, mut step) = (Vec::new(), from, FIRST_STEP);
    while end >= to && values.len() <= limit as usize {
        let start = Micros(end.0.saturating_sub(step)).max(to);
        let (mut found, is_complete) = page(reader, history, (start, end), MAX_SAMPLES)?;
        if !is_complete && step > 1 {
            step /= 2;
            continue;
        }
        step = step.saturating_mul(2);
        end = Micros(start.0.saturating_sub(1));
        found.reverse();
        values.append(&mut found);
    }
    let is_complete = values.len() <= limit as usize;
    values.truncate(limit as usize);
    Ok((values, is_complete))
}

/// The answer with the bounds that a client may ask for: the record has no value between its samples, and says so. Bounds count as values:
/// the answer has at most `limit` (OPC 10000-11, 6.5.3), and what does not fit follows.
#[must_use]
pub fn with_bounds(answer: Answer, query: Query, is_first: bool, limit: u32) -> Answer {
    let Answer { mut values, mut rest } = answer;
    let (Query::Forward(start, end) | Query::Backward(start, end)) = query;
    let bound = |at: Micros| DataValue {
        value: None,
        status: Some(StatusCode::BadBoundNotSupported),
        source_timestamp: Some(time(at)),
        source_picoseconds: None,
        server_timestamp: None,
        server_picoseconds: None,
    };
    let is_at = |value: Option<&DataValue>, at: Micros| value.and_then(|it| it.source_timestamp) == Some(time(at));
    if is_first && !is_at(values.first(), start) {
        values.insert(0, bound(start));
    }
    // A client that gives one time only asks for no end.
    let has_end = end > Micros(0) && end < Micros::now();
    if rest.is_none() && has_end && !is_at(values.last(), end) {
        values.push(bound(end));
    }
    if values.len() > limit as usize {
        values.truncate(limit as usize);
        let last = values.last().and_then(|value| micros(value.source_timestamp.as_ref()?));
        rest = last.map(|at| query.after(at));
    }
    Answer { values, rest }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::plan::DataType;
    use opcua_types::{DateTime, Variant};
    use profivac_recorder::{Deadband, Point, PointKind, PointSample, Quality, Recorder, Sample, Settings};
    use std::sync::Arc;
    use std::time::Duration;

    fn details(start: DateTime, end: DateTime, count: u32) -> ReadRawModifiedDetails {
        ReadRawModifiedDetails {
            is_read_modified: false,
            start_time: start,
            end_time: end,
            num_values_per_node: count,
            return_bounds: false,
        }
    }

    #[test]
    fn the_order_follows_from_the_times() {
        let (early, late) = (Micros(1_000_000), Micros(2_000_000));
        let asked = |start, end, count| query(&details(start, end, count));
        assert_eq!(asked(time(early), time(late), 0).unwrap(), (Query::Forward(early, late), MAX_SAMPLES));
        assert_eq!(asked(time(late), time(early), 7).unwrap(), (Query::Backward(late, early), 7));
        assert_eq!(asked(DateTime::null(), time(late), 1).unwrap(), (Query::Backward(late, Micros(0)), 1));
        assert_eq!(asked(time(early), DateTime::null(), 1).unwrap().0, Query::Forward(early, Micros(i64::MAX)));
        let invalid = Err(StatusCode::BadHistoryOperationInvalid);
        assert_eq!(asked(DateTime::null(), time(late), 0), invalid);
        assert_eq!(asked(DateTime::null(), DateTime::null(), 5), invalid);
    }

    /// All answers to a query, one after the other, as times in seconds.
    fn pages(reader: &Reader, query: Query, limit: u32) -> Vec<Vec<i64>> {
        pages_of(reader, &History::Series("chamber".to_owned()), query, limit)
    }

    fn pages_of(reader: &Reader, history: &History, query: Query, limit: u32) -> Vec<Vec<i64>> {
        let second = |value: &DataValue| micros(&value.source_timestamp.unwrap()).unwrap().0 / Micros::SECOND;
        let (mut pages, mut rest) = (Vec::new(), Some(query));
        while let Some(query) = rest {
            let answer = read(reader, history, query, limit).unwrap();
            pages.push(answer.values.iter().map(second).collect());
            rest = answer.rest;
        }
        pages
    }

    #[test]
    fn a_long_history_comes_in_pages_in_both_directions_and_complete() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("plant.db");
        let settings =
            Settings { deadband: Deadband { decades: 0.0, max_interval: Duration::ZERO }, ..Settings::default() };
        let recorder = Recorder::start(&path, settings).unwrap();
        // Samples in two groups, an hour apart: the steps into the past cross a time without samples.
        let begin = Micros::now().0 / Micros::SECOND - 4_000;
        let times: Vec<i64> = (0..5).chain(3_600..3_605).map(|second| begin + second).collect();
        let gauge: Arc<str> = Arc::from("chamber");
        for second in &times {
            recorder.push(&gauge, Sample::new(Micros(second * Micros::SECOND), Some(1.0), Quality::Valid));
        }
        assert!(recorder.flush());
        let reader = Reader::open(&path).unwrap();
        let (from, to) = (Micros(begin * Micros::SECOND), Micros((begin + 4_000) * Micros::SECOND));
        let forward = pages(&reader, Query::Forward(from, to), 4);
        assert_eq!((forward.len(), forward.concat()), (3, times.clone()));
        let backward = pages(&reader, Query::Backward(to, from), 4);
        assert_eq!((backward.len(), backward.concat()), (3, times.into_iter().rev().collect()));
    }

    #[test]
    fn a_series_without_samples_has_an_empty_history() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("plant.db");
        drop(Recorder::start(&path, Settings::default()).unwrap());
        let query = Query::Backward(Micros::now(), Micros(0));
        assert_eq!(pages(&Reader::open(&path).unwrap(), query, 4), [Vec::<i64>::new()]);
    }

    /// The history of the speed of a pump in this unit.
    fn speed(unit: &str) -> (Arc<Point>, History) {
        let (slave, name, unit) = ("turbo".to_owned(), "speed".to_owned(), Some(unit.to_owned()));
        let point = Arc::new(Point { slave, name, unit, kind: PointKind::Number });
        (Arc::clone(&point), History::Point { point, data_type: DataType::Double })
    }

    #[test]
    fn the_history_of_a_point_has_the_values_of_its_present_unit_in_pages_in_both_directions() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("plant.db");
        let recorder = Recorder::start(&path, Settings::default()).unwrap();
        let begin = Micros::now().0 / Micros::SECOND - 100;
        let (rpm, in_rpm) = speed("rpm");
        let (hertz, in_hertz) = speed("Hz");
        let value =
            |second: i64, number| PointSample::new(Micros((begin + second) * Micros::SECOND), number, Quality::Valid);
        recorder.push_point(&rpm, 0.0, value(0, Some(60_000.0)));
        for (at, number) in [(1, Some(-0.5)), (2, Some(0.0)), (3, Some(1000.0)), (4, None), (5, Some(990.0))] {
            recorder.push_point(&hertz, 0.0, value(at, number));
        }
        recorder.push_point(&hertz, 0.0, PointSample::gap(Micros((begin + 6) * Micros::SECOND)));
        assert!(recorder.flush());
        let reader = Reader::open(&path).unwrap();
        let (from, to) = (Micros(begin * Micros::SECOND), Micros((begin + 90) * Micros::SECOND));
        let shown = read(&reader, &in_hertz, Query::Forward(from, to), 10).unwrap().values;
        let shown: Vec<_> = shown.into_iter().map(|value| (value.value.unwrap(), value.status.unwrap())).collect();
        let good = |number| (Variant::Double(number), StatusCode::Good);
        let expected = [
            good(-0.5),
            good(0.0),
            good(1000.0),
            (Variant::Empty, StatusCode::BadSensorFailure),
            good(990.0),
            (Variant::Empty, StatusCode::BadNoCommunication),
        ];
        assert_eq!(shown, expected);
        let times: Vec<i64> = (1..=6).map(|second| begin + second).collect();
        let forward = pages_of(&reader, &in_hertz, Query::Forward(from, to), 4);
        assert_eq!((forward.len(), forward.concat()), (2, times.clone()));
        let backward = pages_of(&reader, &in_hertz, Query::Backward(to, from), 4);
        assert_eq!((backward.len(), backward.concat()), (2, times.into_iter().rev().collect()));
        assert_eq!(pages_of(&reader, &in_rpm, Query::Forward(from, to), 4).concat(), [begin]);
        let (_, in_percent) = speed("%");
        assert_eq!(pages_of(&reader, &in_percent, Query::Backward(to, from), 4).concat(), [0; 0]);
    }

    #[test]
    fn modified_values_do_not_exist() {
        let details =
            ReadRawModifiedDetails { is_read_modified: true, ..details(DateTime::null(), DateTime::null(), 1) };
        assert_eq!(query(&details), Err(StatusCode::BadHistoryOperationUnsupported));
    }

    /// The times of an answer in seconds, and whether each value is a bound.
    fn shown(values: &[DataValue]) -> Vec<(i64, bool)> {
        let at = |value: &DataValue| micros(&value.source_timestamp.unwrap()).unwrap().0 / Micros::SECOND;
        values.iter().map(|value| (at(value), value.value.is_none())).collect()
    }

    fn second(number: i64) -> Micros {
        Micros(number * Micros::SECOND)
    }

    #[test]
    fn a_bound_without_a_sample_has_no_value() {
        let answer = with_bounds(Answer::default(), Query::Forward(second(1), second(3)), true, 5);
        assert_eq!((shown(&answer.values), answer.rest), (vec![(1, true), (3, true)], None));
    }

    /// All answers to a client that asks for bounds, from samples at these seconds.
    fn bounded(samples: &[i64], query: Query, limit: usize) -> Vec<Vec<(i64, bool)>> {
        let (mut pages, mut rest) = (Vec::new(), Some(query));
        while let Some(query) = rest {
            let (Query::Forward(a, b) | Query::Backward(a, b)) = query;
            let mut found: Vec<i64> =
                samples.iter().copied().filter(|it| (a.min(b)..=a.max(b)).contains(&second(*it))).collect();
            if matches!(query, Query::Backward(..)) {
                found.reverse();
            }
            let value = |it: &i64| of_sample(&Sample::new(second(*it), Some(1.0), Quality::Valid));
            let is_complete = found.len() <= limit;
            found.truncate(limit);
            let rest_of = found.last().filter(|_| !is_complete).map(|last| query.after(second(*last)));
            let answer = Answer { values: found.iter().map(value).collect(), rest: rest_of };
            let answer = with_bounds(answer, query, pages.is_empty(), u32::try_from(limit).unwrap());
            assert!(answer.values.len() <= limit, "{:?}", answer.values);
            pages.push(shown(&answer.values));
            rest = answer.rest;
            assert!(pages.len() < 20, "it ends: {pages:?}");
        }
        pages
    }

    #[test]
    fn bounds_count_as_values_and_what_does_not_fit_follows() {
        let samples = [2, 3, 4];
        let expected = vec![(1, true), (2, false), (3, false), (4, false), (9, true)];
        for limit in 1..=6 {
            let pages = bounded(&samples, Query::Forward(second(1), second(9)), limit);
            assert_eq!(pages.concat(), expected, "limit {limit}");
            let backward: Vec<_> = expected.iter().rev().copied().collect();
            assert_eq!(bounded(&samples, Query::Backward(second(9), second(1)), limit).concat(), backward);
        }
        // Samples at the bounds are the bounds.
        let pages = bounded(&samples, Query::Forward(second(2), second(4)), 3);
        assert_eq!(pages, [vec![(2, false), (3, false), (4, false)]]);
    }

    #[test]
    fn a_time_that_a_client_does_not_give_has_no_bound() {
        let (query, limit) = query(&details(DateTime::null(), time(second(3)), 5)).unwrap();
        let answer = with_bounds(Answer::default(), query, true, limit);
        assert_eq!((shown(&answer.values), answer.rest), (vec![(3, true)], None));
    }
}
