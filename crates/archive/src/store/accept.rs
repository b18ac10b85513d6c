//! A message becomes a batch, or is refused with the reason.

use crate::nats::{BATCH_HEADER, of_message_id, of_subject};
use profivac_recorder::batch::{Batch, BatchError, Samples, Span};
use profivac_recorder::{Micros, Sample};
use thiserror::Error;

/// Rows with times before this one are of a clock that was not set: 2000-01-01.
const EARLIEST: i64 = 946_684_800 * Micros::SECOND;

/// How far the clock of a station may be ahead of that of the archive. free choice.
const MAX_AHEAD: i64 = 3_600 * Micros::SECOND;

/// The most octets of a name that an index of the database holds: PostgreSQL refuses a longer one than 2,704, and then the whole
/// transaction. Names in the file of a station have at most 120 characters.
const MAX_NAME: usize = 1_000;

/// The most decades from 1 Pa of a mean: beyond, PostgreSQL has no number for it, and no query that reads such a row has an answer.
const MAX_DECADES: f64 = 300.0;

/// A message of a station.
#[derive(Clone, Debug)]
pub struct Incoming {
    /// Its subject.
    pub subject: String,
    /// Its id.
    pub id: String,
    /// Its octets.
    pub payload: Vec<u8>,
}

impl Incoming {
    /// What a message of NATS has for an archive.
    #[must_use]
    pub fn of(message: &async_nats::Message) -> Self {
        let id = message.headers.as_ref().and_then(|headers| headers.get(BATCH_HEADER));
        Self {
            subject: message.subject.to_string(),
            id: id.map(|id| id.as_str().to_owned()).unwrap_or_default(),
            payload: message.payload.to_vec(),
        }
    }
}

/// A batch that can be stored.
pub struct Accepted<'a> {
    pub plant: &'a str,
    pub station: &'a str,
    pub epoch: i64,
    pub number: i64,
    pub batch: Batch,
    pub samples: Vec<(String, Vec<Sample>)>,
}

impl Accepted<'_> {
    /// The number of rows and samples.
    pub fn weight(&self) -> usize {
        self.batch.sample_count().saturating_add(self.batch.row_count())
    }
}

/// The reason why a message is put aside. An archive stores it as a sentence.
#[derive(Debug, Error)]
pub enum Refusal {
    /// The subject is not that of a batch.
    #[error("the subject is not profivac.v1.PLANT.STATION.batch")]
    Subject,
    /// The id is not that of a batch of this station.
    #[error("the id is not {station}/EPOCH/NUMBER")]
    Id {
        /// The station of the subject.
        station: String,
    },
    /// The batch cannot be decoded.
    #[error(transparent)]
    Batch(#[from] BatchError),
    /// A name is too long for an index.
    #[error("a name of {found} octets, and at most {MAX_NAME} are stored: {beginning:?}")]
    LongName {
        /// The number of octets.
        found: usize,
        /// Its first characters.
        beginning: String,
    },
    /// The mean of a span is no number.
    #[error(
        "the span of series {series} that begins {start_us} µs since 1970 has a sum of logarithms that is no sum of pressures"
    )]
    NoMean {
        /// The series.
        series: String,
        /// The start of the span.
        start_us: i64,
    },
    /// A time is before the year 2000.
    #[error("a time before 2000 ({at_us} µs since 1970): the clock of the station was not set")]
    ClockNotSet {
        /// The time.
        at_us: i64,
    },
    /// A time is in the future.
    #[error("a time {seconds} s ahead of the clock of the archive: set the clock of the station")]
    ClockAhead {
        /// How far.
        seconds: i64,
    },
    /// The station belongs to another plant.
    #[error("the station {station} belongs to plant {plant}, and this batch names {found}")]
    OtherPlant {
        /// The station.
        station: String,
        /// Its plant.
        plant: String,
        /// The plant of the subject.
        found: String,
    },
    /// Two stations have one name.
    #[error(
        "two databases send as station {station}: one that began at {known}, and this one of {found}, both in microseconds since 1970; \
         give each station a name of its own"
    )]
    TwoDatabases {
        /// The station.
        station: String,
        /// The epoch of the later database.
        known: i64,
        /// The epoch of this batch.
        found: i64,
    },
}

/// Decodes and checks a message, or says why it cannot be stored.
pub fn accept(message: &Incoming, now: Micros) -> Result<Accepted<'_>, Refusal> {
    let (plant, station) = of_subject(&message.subject).ok_or(Refusal::Subject)?;
    let id = of_message_id(&message.id, station);
    let (epoch, number) = id.ok_or_else(|| Refusal::Id { station: station.to_owned() })?;
    let batch = Batch::decode_compressed(&message.payload)?;
    let unpack = |series: &Samples| Ok((text(&series.series), series.unpack()?));
    let samples = batch.samples.iter().map(unpack).collect::<Result<Vec<_>, BatchError>>()?;
    check_names(&batch, station)?;
    batch.spans.iter().try_for_each(check_span)?;
    check_times(&batch, &samples, now)?;
    Ok(Accepted { plant, station, epoch, number, batch, samples })
}

/// Names are keys of tables.
fn check_names(batch: &Batch, station: &str) -> Result<(), Refusal> {
    let of_samples = batch.samples.iter().map(|series| series.series.as_str());
    let of_spans = batch.spans.iter().map(|span| span.series.as_str());
    let of_alarms = batch.alarms.iter().map(|row| row.alarm.as_str());
    let long = of_samples.chain(of_spans).chain(of_alarms).chain([station]).find(|name| name.len() > MAX_NAME);
    long.map_or(Ok(()), |name| Err(Refusal::LongName { found: name.len(), beginning: name.chars().take(64).collect() }))
}

/// The mean of a span is a number.
fn check_span(span: &Span) -> Result<(), Refusal> {
    if span.log10_sum.abs() <= MAX_DECADES * f64::from(span.count) {
        return Ok(());
    }
    Err(Refusal::NoMean { series: span.series.chars().take(64).collect(), start_us: span.start_us })
}

/// A batch with times of a wrong clock is put aside whole: its rows would be found nowhere, and its partitions be dropped or wait for
/// years.
fn check_times(batch: &Batch, samples: &[(String, Vec<Sample>)], now: Micros) -> Result<(), Refusal> {
    let of_samples = samples.iter().flat_map(|(_, samples)| samples.iter().map(|sample| sample.at.0));
    let of_lists = batch.events.iter().map(|row| row.at_us).chain(batch.alarms.iter().map(|row| row.at_us));
    let all = of_samples.chain(of_lists).chain(batch.audit.iter().map(|row| row.at_us));
    let all = all.chain(batch.spans.iter().map(|span| span.start_us)).chain([batch.made_us]);
    let latest = now.0.saturating_add(MAX_AHEAD);
    let wrong = all.into_iter().find(|at| !(EARLIEST..=latest).contains(at));
    wrong.map_or(Ok(()), |at| match at < EARLIEST {
        true => Err(Refusal::ClockNotSet { at_us: at }),
        false => Err(Refusal::ClockAhead { seconds: at.saturating_sub(now.0) / Micros::SECOND }),
    })
}

/// A text that PostgreSQL accepts: it has no NUL.
pub fn text(text: &str) -> String {
    text.replace('\0', "\u{fffd}")
}

#[cfg(test)]
mod tests {
    use super::*;
    use profivac_recorder::Quality;
    use profivac_recorder::batch::{AlarmChange, FORMAT};

    const NOW: Micros = Micros(1_700_000_000 * Micros::SECOND);

    fn message(at: i64) -> Incoming {
        let samples = [Sample::new(Micros(at), Some(1.0), Quality::Valid)];
        let samples = vec![Samples::new("chamber".to_owned(), &samples)];
        let batch = Batch { format: FORMAT, made_us: NOW.0, samples, ..Batch::default() };
        let payload = batch.encode_compressed().unwrap();
        Incoming { subject: "profivac.v1.hall.hall-1.batch".to_owned(), id: "hall-1/5/7".to_owned(), payload }
    }

    #[test]
    fn a_message_has_plant_station_epoch_number_and_samples() {
        let message = message(NOW.0);
        let accepted = accept(&message, NOW).unwrap();
        assert_eq!((accepted.plant, accepted.station, accepted.epoch, accepted.number), ("hall", "hall-1", 5, 7));
        assert_eq!(accepted.samples[0].1[0].at, NOW);
    }

    #[test]
    fn a_wrong_clock_another_station_and_damage_are_refused_with_a_reason() {
        let reason = |message: Incoming| accept(&message, NOW).err().unwrap().to_string();
        assert!(reason(message(0)).contains("was not set"));
        assert!(reason(message(NOW.0 + 3_601 * Micros::SECOND)).contains("3601 s ahead"));
        assert!(accept(&message(NOW.0 + 3_600 * Micros::SECOND), NOW).is_ok());
        assert!(reason(Incoming { id: "hall-2/5/7".to_owned(), ..message(NOW.0) }).contains("hall-1/EPOCH/NUMBER"));
        assert!(reason(Incoming { subject: "x".to_owned(), ..message(NOW.0) }).contains("the subject is not"));
        assert!(reason(Incoming { payload: vec![255; 9], ..message(NOW.0) }).contains("the batch is damaged"));
    }

    #[test]
    fn a_name_that_no_index_holds_and_a_mean_that_is_no_number_are_refused() {
        let reason = |batch: Batch| {
            let payload = Batch { format: FORMAT, made_us: NOW.0, ..batch }.encode_compressed().unwrap();
            accept(&Incoming { payload, ..message(NOW.0) }, NOW).err().map(|refusal| refusal.to_string())
        };
        let long = "x".repeat(MAX_NAME + 1);
        let sample = [Sample::gap(NOW)];
        let alarm = AlarmChange { at_us: NOW.0, alarm: long.clone(), ..AlarmChange::default() };
        for batch in [
            Batch { samples: vec![Samples::new(long.clone(), &sample)], ..Batch::default() },
            Batch { spans: vec![Span { series: long, start_us: NOW.0, ..Span::default() }], ..Batch::default() },
            Batch { alarms: vec![alarm], ..Batch::default() },
        ] {
            assert!(reason(batch).unwrap().starts_with("a name of 1001 octets, and at most 1000 are stored: \"xxx"));
        }
        let of_sum = |log10_sum, count| {
            let span =
                Span { series: "chamber".to_owned(), level: 2, start_us: NOW.0, log10_sum, count, ..Span::default() };
            reason(Batch { spans: vec![span], ..Batch::default() })
        };
        for (sum, count) in [(1.0, 0), (f64::NAN, 1), (f64::INFINITY, 1), (-301.0, 1), (1e300, u32::MAX)] {
            assert!(of_sum(sum, count).unwrap().contains("no sum of pressures"), "{sum} of {count}");
        }
        for (sum, count) in [(0.0, 0), (-1.2e6, 100_000), (5.0, 1)] {
            assert_eq!(of_sum(sum, count), None, "{sum} of {count}");
        }
    }

    #[test]
    fn a_text_has_no_nul() {
        assert_eq!(text("a\0b"), "a\u{fffd}b");
    }
}
