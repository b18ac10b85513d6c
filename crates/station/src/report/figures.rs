//! The numbers of a report, as a program reads them: pressures in Pa, times in seconds since the beginning and as moments.

use super::format::{Unit, target_pressure, timestamp};
use super::series::{Series, series};
use crate::config::Config;
use crate::pumpdown::trace::seconds;
use crate::pumpdown::{
    Crossing, Fall, FinalSlope, PressureRise, TimeRange, Trace, crossing, falls, final_slope, pressure_rises, quickest,
};
use jiff::Timestamp;
use jiff::tz::TimeZone;
use profivac_recorder::{DatabaseError, Deadband, Event, Micros, Quality, Reader};
use profivac_vacuum::Gas;
use profivac_virtual::device_spec::entry;
use serde::Serialize;
use std::time::Duration;

/// So many events are listed.
const EVENTS: u32 = 500;

/// Slower than this, in 1/s, is rounding and no fall: an e-th part in four months.
const LOWEST_RATE: f64 = 1e-7;

/// What a station's file says about a gauge.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct GaugeInfo {
    /// The device.
    pub device: Option<String>,
    /// Its address.
    pub address: Option<u8>,
    /// Its segment.
    pub segment: Option<String>,
    /// What its chamber is filled with, where it is not air or nitrogen.
    pub gas: Option<String>,
    /// Lines: names and pressures in Pa.
    #[serde(skip)]
    pub levels: Vec<(String, f64)>,
}

impl GaugeInfo {
    /// What `config` says about a series: a gauge's, or that of a channel of it (`name.2`).
    #[must_use]
    pub fn of(config: &Config, series: &str) -> Self {
        let gauges =
            || config.segments.iter().flat_map(|segment| segment.gauges.iter().map(move |gauge| (segment, gauge)));
        let channel = series.rsplit_once('.').map_or(series, |(name, _)| name);
        let found = gauges().find(|(_, gauge)| gauge.name == series);
        let found = found.or_else(|| gauges().find(|(_, gauge)| gauge.name == channel));
        found.map_or_else(Self::default, |(segment, gauge)| Self {
            device: Some(entry(&gauge.device).map_or(gauge.device.clone(), |entry| entry.model.title.to_owned())),
            address: Some(gauge.address),
            segment: Some(segment.name.clone()),
            gas: (gauge.gas != Gas::N2).then(|| gauge.gas.to_string()),
            levels: gauge.levels.iter().map(|(name, level)| (name.clone(), level.pa())).collect(),
        })
    }
}

/// What a report is to be about.
#[derive(Clone, Debug)]
pub struct ReportRequest {
    /// Its heading.
    pub title: String,
    /// The name of the station, if known.
    pub station: Option<String>,
    /// The file.
    pub record: String,
    /// From when to when.
    pub span: TimeRange,
    /// Why from then to then.
    pub why: String,
    /// Whose series.
    pub gauges: Vec<(String, GaugeInfo)>,
    /// The volume, in m³.
    pub volume_m3: Option<f64>,
    /// Pressures whose times are wanted, in Pa.
    pub pressures: Vec<f64>,
    /// The unit of the page.
    pub unit: Unit,
    /// The zone of the page, beside UTC.
    pub zone: TimeZone,
    /// When it is made.
    pub made: Micros,
}

/// A pressure whose time is wanted.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct TargetPressure {
    /// In Pa.
    pub pa: f64,
    /// The name of a level, if it is one.
    pub name: Option<String>,
}

/// When it was reached, in words of a program.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Reached {
    /// In Pa.
    pub pa: f64,
    /// `reached`, `between`, `before`, `already` or `not`.
    pub outcome: &'static str,
    /// When: the latest possible.
    pub s: Option<f64>,
    /// The same as a moment.
    pub at: Option<Timestamp>,
    /// Not before this, where it is between two.
    pub from_s: Option<f64>,
}

/// A pressure at a time.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct PressurePoint {
    /// In Pa.
    pub pa: f64,
    /// In seconds since the beginning.
    pub s: f64,
    /// The moment.
    pub at: Timestamp,
}

/// A fall of the pressure.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Falling {
    /// In seconds since the beginning.
    pub s: f64,
    /// Around which pressure, in Pa.
    pub pa: f64,
    /// In which the pressure falls to the e-th part, in seconds.
    pub time_constant_s: f64,
    /// With the volume: the effective pumping speed in m³/s.
    pub speed_m3_per_s: Option<f64>,
}

/// The slope at the end.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Slope {
    /// n in `p ~ t^-n`.
    pub exponent: f64,
    /// Its standard error.
    pub error: f64,
    /// From when, in seconds since the beginning.
    pub from_s: f64,
    /// Until when.
    pub to_s: f64,
}

/// A rise.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Rising {
    /// Where it began.
    pub from: PressurePoint,
    /// Where it ended.
    pub to: PressurePoint,
    /// The part that does not slow down, in Pa/s; nothing if it is no rise in a closed volume.
    pub steady_pa_per_s: Option<f64>,
    /// The part that does, at its beginning, in Pa/s.
    pub slowing_pa_per_s: Option<f64>,
    /// The steady flow, in Pa m³/s.
    pub steady_pa_m3_per_s: Option<f64>,
}

/// What the numbers stand on.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct DataCoverage {
    /// Samples that were kept.
    pub samples: usize,
    /// The time between two of them, the middle one of all.
    pub spacing_s: Option<f64>,
    /// The longest span that stands for several, in seconds; nothing if all are as they were kept.
    pub coarsest_s: Option<f64>,
    /// How long it measured, in seconds.
    pub valid_s: f64,
    /// How long it was above its range.
    pub over_s: f64,
    /// How long it was below its range.
    pub under_s: f64,
    /// How long its reading was not valid.
    pub invalid_s: f64,
    /// How long nothing was heard of it.
    pub gap_s: f64,
}

/// A gauge.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Gauge {
    /// Its name.
    pub name: String,
    /// What it is.
    #[serde(flatten)]
    pub identity: GaugeInfo,
    /// The first pressure it measured.
    pub first: Option<PressurePoint>,
    /// The lowest.
    pub lowest: Option<PressurePoint>,
    /// The last.
    pub last: Option<PressurePoint>,
    /// When it reached what is asked for, in the order of [`Report::asked`].
    pub times: Vec<Reached>,
    /// The quickest fall.
    pub quickest: Option<Falling>,
    /// The falls, from high to low pressure.
    pub falls: Vec<Falling>,
    /// The slope at the end.
    pub slope: Option<Slope>,
    /// Rises.
    pub rises: Vec<Rising>,
    /// What all this stands on.
    pub standing: DataCoverage,
    /// Its curve.
    #[serde(skip)]
    pub trace: Trace,
}

/// Something that happened.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct ReportEvent {
    /// Its number in the pictures.
    pub number: usize,
    /// When.
    pub at: Timestamp,
    /// To which gauge.
    pub gauge: Option<String>,
    /// What kind of thing.
    pub kind: &'static str,
    /// One sentence.
    pub text: String,
    /// When, to the microsecond.
    #[serde(skip)]
    pub moment: Micros,
}

/// All of it.
#[derive(Clone, Debug, Serialize)]
pub struct Report {
    /// Which program made it.
    pub generator: &'static str,
    /// When.
    pub made: Timestamp,
    /// Its heading.
    pub title: String,
    /// The name of the station, if known.
    pub station: Option<String>,
    /// The file.
    pub record: String,
    /// The beginning.
    pub begin: Timestamp,
    /// The end.
    pub end: Timestamp,
    /// How long it took.
    pub seconds: f64,
    /// Why from then to then.
    pub why: String,
    /// The unit of the page; here everything is in Pa.
    pub unit: Unit,
    /// The volume, in m³.
    pub volume_m3: Option<f64>,
    /// The pressures whose times are told, from high to low.
    pub asked: Vec<TargetPressure>,
    /// The gauges.
    pub gauges: Vec<Gauge>,
    /// What happened, the earliest first.
    pub events: Vec<ReportEvent>,
    /// Whether there were more events than are listed.
    pub has_more_events: bool,
    /// The dead band of a recorder as it is by default, in decades.
    pub dead_band_decades: f64,
    /// The span in microseconds.
    #[serde(skip)]
    pub span: TimeRange,
    /// The zone of the page.
    #[serde(skip)]
    pub zone: TimeZone,
}

impl Report {
    /// Reads what is wanted and calculates the rest.
    ///
    /// # Errors
    /// [`StoreError`] when the record cannot be read.
    pub fn make(reader: &Reader, wish: ReportRequest) -> Result<Self, DatabaseError> {
        let span = wish.span;
        let read = |(name, identity): &(String, GaugeInfo)| {
            let series = series(reader, name, span)?;
            Ok((name.clone(), identity.clone(), Trace::new(&series.samples, span), series))
        };
        let read: Vec<_> = wish.gauges.iter().map(read).collect::<Result<_, DatabaseError>>()?;
        let asked = wanted(&wish, read.iter().map(|(_, _, trace, _)| trace));
        let gauges = read
            .into_iter()
            .map(|(name, identity, trace, series)| gauge(name, identity, trace, &series, &asked, &wish));
        let gauges: Vec<Gauge> = gauges.collect();
        let (events, has_more_events) = events(reader, span, &gauges)?;
        Ok(Self {
            generator: concat!("profivac ", env!("CARGO_PKG_VERSION")),
            made: timestamp(wish.made),
            begin: timestamp(span.start),
            end: timestamp(span.end),
            seconds: span.seconds(),
            title: wish.title,
            station: wish.station,
            record: wish.record,
            why: wish.why,
            unit: wish.unit,
            volume_m3: wish.volume_m3,
            asked,
            gauges,
            events,
            has_more_events,
            dead_band_decades: Deadband::default().decades,
            span,
            zone: wish.zone,
        })
    }
}

/// The last events of these gauges and of the station, the earliest first, and whether there were more.
fn events(reader: &Reader, span: TimeRange, gauges: &[Gauge]) -> Result<(Vec<ReportEvent>, bool), DatabaseError> {
    let mut events = reader.events(span.start, span.end, EVENTS + 1)?;
    let has_more = events.len() > EVENTS as usize;
    events.truncate(EVENTS as usize);
    let is_ours =
        |event: &Event| event.gauge.as_ref().is_none_or(|of| gauges.iter().any(|gauge| belongs(&gauge.name, of)));
    Ok((events.into_iter().rev().filter(is_ours).enumerate().map(happening).collect(), has_more))
}

/// Whether an event of `of` is one of the series `name`: a controller has a series for each channel.
fn belongs(name: &str, of: &str) -> bool {
    name == of || name.strip_prefix(of).is_some_and(|rest| rest.starts_with('.'))
}

fn happening((place, event): (usize, Event)) -> ReportEvent {
    ReportEvent {
        number: place + 1,
        at: timestamp(event.at),
        gauge: event.gauge,
        kind: event.kind.word(),
        text: event.text,
        moment: event.at,
    }
}

/// Every power of ten that was passed, and the next one, the levels, and what was asked for; from high to low.
fn wanted<'a>(wish: &ReportRequest, traces: impl Iterator<Item = &'a Trace>) -> Vec<TargetPressure> {
    let one = wish.unit.pa();
    let ends = traces.filter_map(Trace::ends);
    let (top, bottom) = ends.fold((f64::MIN, f64::MAX), |(top, bottom), [first, low, _]| {
        (top.max((first.1 / one).log10()), bottom.min((low.1 / one).log10()))
    });
    let decades = (top >= bottom).then(|| bottom.floor() as i32..=top.ceil() as i32 - 1).into_iter().flatten();
    let named = wish.gauges.iter().flat_map(|(_, identity)| &identity.levels);
    let named = named.map(|(name, pa)| TargetPressure { pa: *pa, name: Some(name.clone()) });
    // A power of ten above one is exact, its inverse is not.
    let power = |decade: i32| if decade < 0 { one / 10_f64.powi(-decade) } else { one * 10_f64.powi(decade) };
    let plain = wish.pressures.iter().copied().chain(decades.map(power));
    let mut all: Vec<TargetPressure> = named.chain(plain.map(|pa| TargetPressure { pa, name: None })).collect();
    // Sorting keeps the order of equals, so a named one stays before a decade at the same pressure.
    all.sort_by(|one, two| two.pa.total_cmp(&one.pa));
    all.dedup_by(|later, kept| {
        (later.pa / kept.pa - 1.0).abs() < 1e-9 && (later.name.is_none() || later.name == kept.name)
    });
    all
}

fn gauge(
    name: String,
    identity: GaugeInfo,
    trace: Trace,
    series: &Series,
    asked: &[TargetPressure],
    wish: &ReportRequest,
) -> Gauge {
    let start = wish.span.start;
    let ends = trace.ends().map(|ends| ends.map(|point| seen(start, point)));
    let falls = falls(&trace);
    let falling = |fall: &Fall| falling(fall, wish.volume_m3);
    Gauge {
        name,
        identity,
        first: ends.map(|[first, _, _]| first),
        lowest: ends.map(|[_, lowest, _]| lowest),
        last: ends.map(|[_, _, last]| last),
        times: asked.iter().map(|asked| reached(start, asked.pa, crossing(&trace, asked.pa))).collect(),
        quickest: quickest(&falls).as_ref().map(falling),
        falls: falls.iter().filter(|fall| fall.per_s > LOWEST_RATE).map(falling).collect(),
        slope: final_slope(&trace).map(slope),
        rises: pressure_rises(&trace).iter().map(|climb| rising(start, climb, wish.volume_m3)).collect(),
        standing: standing(&trace, series),
        trace,
    }
}

fn after(start: Micros, s: f64) -> Micros {
    start.after(Duration::try_from_secs_f64(s).unwrap_or_default())
}

fn seen(start: Micros, (s, pa): (f64, f64)) -> PressurePoint {
    PressurePoint { pa, s, at: timestamp(after(start, s)) }
}

fn reached(start: Micros, pa: f64, passage: Crossing) -> Reached {
    let (outcome, s, from_s) = match passage {
        Crossing::Reached { s } => ("reached", Some(s), None),
        Crossing::Between { from_s, to_s } => ("between", Some(to_s), Some(from_s)),
        Crossing::Before { s } => ("before", Some(s), None),
        Crossing::Already => ("already", Some(0.0), None),
        Crossing::Not => ("not", None, None),
    };
    Reached { pa, outcome, s, at: s.map(|s| timestamp(after(start, s))), from_s }
}

fn falling(fall: &Fall, volume_m3: Option<f64>) -> Falling {
    let speed_m3_per_s = volume_m3.map(|volume| volume * fall.per_s);
    Falling { s: fall.s, pa: fall.pa, time_constant_s: 1.0 / fall.per_s, speed_m3_per_s }
}

fn slope(tail: FinalSlope) -> Slope {
    Slope { exponent: tail.exponent, error: tail.error, from_s: tail.from_s, to_s: tail.to_s }
}

fn rising(start: Micros, climb: &PressureRise, volume_m3: Option<f64>) -> Rising {
    let steady_pa_per_s = climb.fit.map(|fit| fit.steady_pa_per_s);
    Rising {
        from: seen(start, (climb.from_s, climb.from_pa)),
        to: seen(start, (climb.to_s, climb.to_pa)),
        steady_pa_per_s,
        slowing_pa_per_s: climb.fit.and_then(|fit| fit.bend).map(|bend| bend.initial_pa_per_s()),
        steady_pa_m3_per_s: steady_pa_per_s.zip(volume_m3).map(|(rate, volume)| rate * volume),
    }
}

fn standing(trace: &Trace, series: &Series) -> DataCoverage {
    DataCoverage {
        samples: trace.samples,
        spacing_s: trace.spacing_s,
        coarsest_s: series.coarsest_s,
        valid_s: trace.seconds_of(Quality::Valid),
        over_s: trace.seconds_of(Quality::Overrange),
        under_s: trace.seconds_of(Quality::Underrange),
        invalid_s: trace.seconds_of(Quality::Invalid),
        gap_s: trace.seconds_of(Quality::Gap),
    }
}

impl TargetPressure {
    /// The pressure with its unit, and the name if it has one.
    #[must_use]
    pub fn words(&self, unit: Unit) -> String {
        let pressure = format!("{}\u{a0}{}", target_pressure(self.pa, unit), unit.name());
        self.name.as_ref().map_or(pressure.clone(), |name| format!("{name}: {pressure}"))
    }
}

/// How long ago the beginning was at a moment.
#[must_use]
pub fn since(report: &Report, at: Micros) -> f64 {
    seconds(report.span.start, at)
}
