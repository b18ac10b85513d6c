//! A message becomes a batch, or is refused with the reason.

use profivac_archive_protocol::nats::{BATCH_HEADER, of_message_id, of_subject};
use profivac_recorder::batch::{
    AlarmChange, Audit, Batch, BatchError, BatchPoint, Event, PointSamples, PointSpan, PointText, Samples, Span,
};
use profivac_recorder::{Micros, PointSample, Sample};
use thiserror::Error;

/// Rows with times before this one are of a clock that was not set: 2000-01-01.
const EARLIEST: i64 = 946_684_800 * Micros::SECOND;

/// How far the clock of a station may be ahead of that of the archive. chosen.
const MAX_AHEAD: i64 = 3_600 * Micros::SECOND;

/// The most octets of a name that an index of the database holds: PostgreSQL refuses a longer one than 2,704, and then the whole
/// transaction. Names in the file of a station have at most 120 characters.
const MAX_NAME: usize = 1_000;

/// The most octets of another text: of a sentence, or of a value in the audit trail. chosen: a note has at most 500 characters, and
/// an answer of the view has up to 10,000 events.
const MAX_TEXT: usize = 32 << 10;

/// The octets of a batch that a transaction counts as one row, so that long texts do not fill the memory. chosen.
const OCTETS_OF_ROW: usize = 64;

/// The most decades from 1 Pa of a mean: beyond, PostgreSQL has no number for it, and no query that reads such a row has an answer.
const MAX_DECADES: f64 = 300.0;

/// A value of a point beyond this is none, and PostgreSQL has no sum of such values; as in the recorder of a station.
const LARGEST: f64 = 1e290;

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
    pub points: Vec<(BatchPoint, Vec<PointSample>)>,
}

impl Accepted<'_> {
    /// The number of rows and samples; long texts count as several rows.
    pub fn weight(&self) -> usize {
        let rows = self.batch.sample_count().saturating_add(self.batch.row_count());
        rows.saturating_add(self.batch.octets() / OCTETS_OF_ROW)
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
    /// A name is too long for an index, or a text for a page.
    #[error("a {what} of {found} octets, and at most {most} are stored: {beginning:?}")]
    Long {
        /// `name` or `text`.
        what: &'static str,
        /// The most octets.
        most: usize,
        /// The number of octets.
        found: usize,
        /// Its first characters.
        beginning: String,
    },
    /// The level of a span has no number in the database.
    #[error(
        "the span of series {series} that begins {start_us} µs since 1970 has the level {level}, expected 2, 3 or 4"
    )]
    Level {
        /// The series.
        series: String,
        /// The start of the span.
        start_us: i64,
        /// The level.
        level: u32,
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
    /// A value of a span of a point is no number.
    #[error(
        "the span of point {point} that begins {start_us} µs since 1970 has values beyond ±1e290 or a sum that does not fit to them"
    )]
    NoValue {
        /// The point.
        point: String,
        /// The start of the span.
        start_us: i64,
    },
    /// A text is of a value that no point has.
    #[error("point {point} has a text for a value beyond ±1e290")]
    NoCode {
        /// The point.
        point: String,
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
    /// The database of the station began in the future.
    #[error(
        "the database of the station began {seconds} s ahead of the clock of the archive: set the clock of the station, and restore a \
         backup of its database, which begins another epoch"
    )]
    EpochAhead {
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
    /// An operator has chosen an earlier database as the one of the station.
    #[error(
        "an operator has chosen an earlier database as the one of station {station}: give the station with this database another name"
    )]
    NotChosen {
        /// The station.
        station: String,
    },
    /// Two batches of one database have one number.
    #[error(
        "batch {number} of this database came before, made at another time: an older copy of the database was put back, or a second computer runs \
         with a copy; the station is told to go on as another database"
    )]
    Copied {
        /// The number.
        number: i64,
    },
    /// Two stations have one name.
    #[error(
        "two databases send as station {station}: one that began at {known}, and this one of {found}, both in microseconds since 1970; \
         give each station a name of its own; if this one is the right one, `profivac archive FILE --accept {station}` chooses it; if this one was begun with a clock that was behind, restore a backup of it, which begins \
         another epoch"
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

impl Refusal {
    /// The reason in a word.
    pub const fn word(&self) -> &'static str {
        match self {
            Self::Subject => "subject",
            Self::Id { .. } => "id",
            Self::Batch(_) => "damaged",
            Self::Long { .. } => "too_long",
            Self::Level { .. } | Self::NoMean { .. } | Self::NoValue { .. } | Self::NoCode { .. } => "no_value",
            Self::ClockNotSet { .. } => "clock_not_set",
            Self::ClockAhead { .. } | Self::EpochAhead { .. } => "clock_ahead",
            Self::OtherPlant { .. } => "other_plant",
            Self::NotChosen { .. } => "not_chosen",
            Self::Copied { .. } => "copied",
            Self::TwoDatabases { .. } => "two_databases",
        }
    }

    /// Whether the batch is of another database under the name of its station, which an operator can choose.
    pub const fn competes(&self) -> bool {
        matches!(self, Self::TwoDatabases { .. } | Self::NotChosen { .. })
    }
}

/// Decodes and checks a message, or says why it cannot be stored.
pub fn accept(message: &Incoming, now: Micros) -> Result<Accepted<'_>, Refusal> {
    let (plant, station) = of_subject(&message.subject).ok_or(Refusal::Subject)?;
    let id = of_message_id(&message.id, station);
    let (epoch, number) = id.ok_or_else(|| Refusal::Id { station: station.to_owned() })?;
    let latest = now.0.saturating_add(MAX_AHEAD);
    if epoch > latest {
        return Err(Refusal::EpochAhead { seconds: epoch.saturating_sub(now.0) / Micros::SECOND });
    }
    let batch = Batch::decode_compressed(&message.payload)?;
    let unpack = |series: &Samples| Ok((text(&series.series), series.unpack()?));
    let samples = batch.samples.iter().map(unpack).collect::<Result<Vec<_>, BatchError>>()?;
    let unpack = |point: &PointSamples| Ok((point.point.clone(), point.unpack()?));
    let points = batch.point_samples.iter().map(unpack).collect::<Result<Vec<_>, BatchError>>()?;
    check_texts(&batch)?;
    batch.spans.iter().try_for_each(check_span)?;
    batch.point_spans.iter().try_for_each(check_point_span)?;
    batch.point_texts.iter().try_for_each(check_point_text)?;
    let accepted = Accepted { plant, station, epoch, number, batch, samples, points };
    check_times(&accepted, now, latest)?;
    Ok(accepted)
}

/// Names are keys of tables, and pages show texts.
fn check_texts(batch: &Batch) -> Result<(), Refusal> {
    let of_samples = batch.samples.iter().map(|series| series.series.as_str());
    let of_spans = batch.spans.iter().map(|span| span.series.as_str());
    let of_events = batch.events.iter().flat_map(names_of_event);
    let names = of_samples.chain(of_spans).chain(of_events).chain(batch.alarms.iter().flat_map(names_of_alarm));
    check_lengths("name", MAX_NAME, names)?;
    let of_spans = batch.point_spans.iter().map(|span| &span.point);
    let of_texts = batch.point_texts.iter().map(|row| &row.point);
    let points = batch.point_samples.iter().map(|samples| &samples.point).chain(of_spans).chain(of_texts);
    // One index has all words of a point.
    let mut words =
        points.map(|BatchPoint { slave, name, unit, kind }| [slave, name, unit, kind].map(String::as_str).concat());
    words.try_for_each(|words| check_lengths("name", MAX_NAME, [words.as_str()].into_iter()))?;
    check_lengths("text", MAX_NAME, batch.point_texts.iter().map(|row| row.text.as_str()))?;
    let of_events = batch.events.iter().map(|row| row.text.as_str());
    let texts = of_events.chain(batch.alarms.iter().map(|row| row.text.as_str()));
    check_lengths("text", MAX_TEXT, texts.chain(batch.audit.iter().flat_map(texts_of_audit)))
}

fn names_of_event(row: &Event) -> impl Iterator<Item = &str> {
    [row.series.as_deref(), Some(&row.kind)].into_iter().flatten()
}

fn names_of_alarm(row: &AlarmChange) -> impl Iterator<Item = &str> {
    let always = [&row.alarm, &row.change, &row.state, &row.priority].map(|name| Some(name.as_str()));
    always.into_iter().chain([row.subject.as_deref(), row.user.as_deref(), row.unit.as_deref()]).flatten()
}

fn texts_of_audit(row: &Audit) -> impl Iterator<Item = &str> {
    let always = [&row.action, &row.user, &row.role].map(|text| Some(text.as_str()));
    let others = [&row.peer, &row.gauge, &row.target, &row.before, &row.after, &row.outcome];
    always.into_iter().chain(others.map(|text| text.as_deref())).flatten()
}

fn check_lengths<'a>(what: &'static str, most: usize, mut texts: impl Iterator<Item = &'a str>) -> Result<(), Refusal> {
    let long = texts.find(|text| text.len() > most);
    long.map_or(Ok(()), |text| {
        Err(Refusal::Long { what, most, found: text.len(), beginning: text.chars().take(64).collect() })
    })
}

/// The level of a span is one that the database holds, and its mean is a number.
fn check_span(span: &Span) -> Result<(), Refusal> {
    let Span { start_us, level, .. } = *span;
    let series = || span.series.chars().take(64).collect();
    if i16::try_from(level).is_err() {
        return Err(Refusal::Level { series: series(), start_us, level });
    }
    if span.log10_sum.abs() <= MAX_DECADES * f64::from(span.count) {
        return Ok(());
    }
    Err(Refusal::NoMean { series: series(), start_us })
}

/// The level of a span of a point is one that the database holds, and its values are numbers.
fn check_point_span(span: &PointSpan) -> Result<(), Refusal> {
    let PointSpan { start_us, level, min_value, max_value, last_value, sum, count, .. } = *span;
    let point = || format!("{}.{}", span.point.slave, span.point.name).chars().take(64).collect();
    if i16::try_from(level).is_err() {
        return Err(Refusal::Level { series: point(), start_us, level });
    }
    let is_value = |value: f64| value.abs() <= LARGEST;
    let values = [min_value, max_value, last_value];
    if values.into_iter().flatten().all(is_value) && sum.abs() <= LARGEST * f64::from(count) {
        return Ok(());
    }
    Err(Refusal::NoValue { point: point(), start_us })
}

/// The value of a text is a number that a sample may have.
fn check_point_text(row: &PointText) -> Result<(), Refusal> {
    let point = || format!("{}.{}", row.point.slave, row.point.name).chars().take(64).collect();
    if row.value.abs() <= LARGEST { Ok(()) } else { Err(Refusal::NoCode { point: point() }) }
}

/// A batch with times of a wrong clock is put aside whole: its rows would be found nowhere, and its partitions be dropped or wait for
/// years.
fn check_times(accepted: &Accepted<'_>, now: Micros, latest: i64) -> Result<(), Refusal> {
    let Accepted { batch, samples, points, .. } = accepted;
    let of_samples = samples.iter().flat_map(|(_, samples)| samples.iter().map(|sample| sample.at.0));
    let of_points = points.iter().flat_map(|(_, samples)| samples.iter().map(|sample| sample.at.0));
    let of_samples = of_samples.chain(of_points).chain(batch.point_spans.iter().map(|span| span.start_us));
    let of_lists = batch.events.iter().map(|row| row.at_us).chain(batch.alarms.iter().map(|row| row.at_us));
    let all = of_samples.chain(of_lists).chain(batch.audit.iter().map(|row| row.at_us));
    let all = all.chain(batch.spans.iter().map(|span| span.start_us)).chain([batch.made_us]);
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
    use profivac_recorder::batch::FORMAT;

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
    fn a_database_that_began_in_the_future_is_refused() {
        let with_epoch = |seconds: i64| {
            let id = format!("hall-1/{}/7", NOW.0 + seconds * Micros::SECOND);
            accept(&Incoming { id, ..message(NOW.0) }, NOW).err().map(|refusal| refusal.to_string())
        };
        assert_eq!(with_epoch(3_600), None);
        assert!(with_epoch(3_601).unwrap().contains("began 3601 s ahead"));
        let last = Incoming { id: format!("hall-1/{}/7", i64::MAX), ..message(NOW.0) };
        assert!(matches!(accept(&last, NOW), Err(Refusal::EpochAhead { .. })));
    }

    #[test]
    fn long_texts_count_as_rows_and_texts_that_no_page_shows_are_refused() {
        let event = |text: String| Batch {
            format: FORMAT,
            made_us: NOW.0,
            events: vec![Event { id: 1, at_us: NOW.0, text, ..Event::default() }],
            ..Batch::default()
        };
        let of = |batch: Batch| Incoming { payload: batch.encode_compressed().unwrap(), ..message(NOW.0) };
        let long = of(event("x".repeat(MAX_TEXT)));
        assert!(accept(&long, NOW).unwrap().weight() >= MAX_TEXT / OCTETS_OF_ROW);
        let refused = accept(&of(event("x".repeat(MAX_TEXT + 1))), NOW).err().unwrap().to_string();
        assert!(refused.starts_with("a text of 32769 octets, and at most 32768 are stored"), "{refused}");
        let outcome = Some("x".repeat(MAX_TEXT + 1));
        let audit = vec![Audit { at_us: NOW.0, outcome, ..Audit::default() }];
        assert!(accept(&of(Batch { audit, ..event(String::new()) }), NOW).is_err());
        let alarms = vec![AlarmChange { at_us: NOW.0, unit: Some("x".repeat(MAX_NAME + 1)), ..AlarmChange::default() }];
        assert!(accept(&of(Batch { alarms, ..event(String::new()) }), NOW).is_err());
    }

    #[test]
    fn levels_that_the_database_would_store_as_one_are_refused() {
        let span = |level| Span { series: "chamber".to_owned(), level, start_us: NOW.0, ..Span::default() };
        let batch = |spans| Batch { format: FORMAT, made_us: NOW.0, spans, ..Batch::default() }.encode_compressed();
        let of = |spans| Incoming { payload: batch(spans).unwrap(), ..message(NOW.0) };
        assert!(accept(&of(vec![span(2), span(32_767)]), NOW).is_ok());
        let refused = accept(&of(vec![span(40_000), span(50_000)]), NOW).err().unwrap().to_string();
        assert!(refused.ends_with("has the level 40000, expected 2, 3 or 4"), "{refused}");
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
    fn points_are_taken_with_their_units_and_refused_with_the_limits_of_pressures() {
        let words = |name: &str| {
            let [slave, name, unit, kind] = ["turbo", name, "Hz", "number"].map(str::to_owned);
            BatchPoint { slave, name, unit, kind }
        };
        let checked = |batch: Batch| {
            let payload = Batch { format: FORMAT, made_us: NOW.0, ..batch }.encode_compressed().unwrap();
            let message = Incoming { payload, ..message(NOW.0) };
            accept(&message, NOW).map(|accepted| accepted.points).map_err(|refusal| refusal.to_string())
        };
        let of_samples = |name: &str, at| {
            let samples = [PointSample::new(Micros(at), Some(-1.5), Quality::Valid)];
            checked(Batch { point_samples: vec![PointSamples::new(words(name), &samples)], ..Batch::default() })
        };
        let expected = (words("speed"), vec![PointSample::new(NOW, Some(-1.5), Quality::Valid)]);
        assert_eq!(of_samples("speed", NOW.0).unwrap(), [expected]);
        assert!(of_samples("speed", 0).unwrap_err().contains("was not set"));
        // The words of a point have one index together.
        assert!(of_samples(&"x".repeat(MAX_NAME - 13), NOW.0).is_ok());
        assert!(of_samples(&"x".repeat(MAX_NAME - 12), NOW.0).unwrap_err().contains("1001 octets"));
        let of_span = |span: PointSpan| {
            let span = PointSpan { point: words("speed"), start_us: NOW.0, ..span };
            checked(Batch { point_spans: vec![span], ..Batch::default() }).map(drop)
        };
        let span = PointSpan { level: 2, count: 2, sum: -3.0, last_value: Some(-1.5), ..PointSpan::default() };
        assert_eq!(of_span(span.clone()), Ok(()));
        assert!(of_span(PointSpan { level: 40_000, ..span.clone() }).unwrap_err().contains("has the level 40000"));
        for wrong in [
            PointSpan { sum: f64::NAN, ..span.clone() },
            PointSpan { sum: f64::INFINITY, ..span.clone() },
            PointSpan { count: 0, ..span.clone() },
            PointSpan { max_value: Some(1e291), ..span.clone() },
            PointSpan { last_value: Some(f64::NAN), ..span },
        ] {
            assert!(of_span(wrong.clone()).unwrap_err().contains("beyond ±1e290"), "{wrong:?}");
        }
    }

    #[test]
    fn texts_of_codes_are_taken_and_refused_with_the_limits_of_points() {
        let refused = |slave: &str, value: f64, text: &str| {
            let [slave, name, unit, kind] = [slave, "state", "", "code"].map(str::to_owned);
            let point = BatchPoint { slave, name, unit, kind };
            let point_texts = vec![PointText { point, value, text: text.to_owned() }];
            let batch = Batch { format: FORMAT, made_us: NOW.0, point_texts, ..Batch::default() };
            let message = Incoming { payload: batch.encode_compressed().unwrap(), ..message(NOW.0) };
            accept(&message, NOW).err().map(|refusal| refusal.to_string())
        };
        assert_eq!(refused("valve", 3.0, "closed"), None);
        for value in [f64::NAN, f64::INFINITY, -1e291] {
            assert_eq!(
                refused("valve", value, "closed").unwrap(),
                "point valve.state has a text for a value beyond ±1e290"
            );
        }
        let long = "x".repeat(MAX_NAME + 1);
        assert!(refused("valve", 3.0, &long).unwrap().starts_with("a text of 1001 octets, and at most 1000"));
        assert!(refused(&long, 3.0, "closed").unwrap().starts_with("a name of 1010 octets"));
    }

    #[test]
    fn a_text_has_no_nul() {
        assert_eq!(text("a\0b"), "a\u{fffd}b");
    }
}
