//! The calculation of the numbers of a report.

use super::figures::{
    DataCoverage, Falling, Gauge, GaugeInfo, Outcome, PressurePoint, Reached, Report, ReportEvent, ReportRequest,
    Rising, Slope, TargetPressure,
};
use super::format::timestamp;
use super::series::{Series, series};
use crate::pumpdown::time_range::seconds;
use crate::pumpdown::{
    Crossing, Fall, FinalSlope, PressureRise, TimeRange, Trace, crossing, falls, final_slope, find, pressure_rises,
    quickest,
};
use profivac_identify::Interval;
use profivac_recorder::{DatabaseError, Deadband, Event, Micros, Quality, Reader};
use std::time::Duration;

/// The most events in a report.
const MAX_EVENTS: u32 = 500;

/// Why a rise is not separated into leak and outgassing.
const NO_CLOSED_VOLUME: &str = "not the rise of a closed volume: pumped at the same time, or in steps";

/// Slower falls, in 1/s, are rounding errors: a time constant of four months.
const MIN_RATE: f64 = 1e-7;

impl Report {
    /// Reads the samples and calculates the numbers.
    ///
    /// # Errors
    /// [`DatabaseError`] when the database cannot be read.
    pub fn make(reader: &Reader, request: ReportRequest) -> Result<Self, DatabaseError> {
        let span = request.span;
        let read = |(name, info): &(String, GaugeInfo)| {
            let series = series(reader, name, span)?;
            Ok((name.clone(), info.clone(), Trace::new(&series.samples, span), series))
        };
        let read: Vec<_> = request.gauges.iter().map(read).collect::<Result<_, DatabaseError>>()?;
        let targets = target_pressures(&request, read.iter().map(|(_, _, trace, _)| trace));
        let gauges =
            read.into_iter().map(|(name, info, trace, series)| gauge(name, info, trace, &series, &targets, &request));
        let gauges: Vec<Gauge> = gauges.collect();
        let (events, has_more_events) = events(reader, span, &gauges)?;
        Ok(Self {
            generator: concat!("profivac ", env!("CARGO_PKG_VERSION")),
            made: timestamp(request.made),
            begin: timestamp(span.start),
            end: timestamp(span.end),
            seconds: span.seconds(),
            title: request.title,
            station: request.station,
            record: request.record,
            why: request.why,
            unit: request.unit,
            volume_m3: request.volume_m3,
            targets,
            gauges,
            plant: None,
            plant_note: None,
            usual: None,
            events,
            has_more_events,
            dead_band_decades: Deadband::default().decades,
            span,
            zone: request.zone,
        })
    }
}

/// The last events of these gauges and of the station, the earliest first, and whether there were more.
fn events(reader: &Reader, span: TimeRange, gauges: &[Gauge]) -> Result<(Vec<ReportEvent>, bool), DatabaseError> {
    let mut events = reader.events(span.start, span.end, MAX_EVENTS + 1)?;
    let has_more = events.len() > MAX_EVENTS as usize;
    events.truncate(MAX_EVENTS as usize);
    let is_relevant =
        |event: &Event| event.gauge.as_ref().is_none_or(|of| gauges.iter().any(|gauge| belongs(&gauge.name, of)));
    Ok((events.into_iter().rev().filter(is_relevant).enumerate().map(report_event).collect(), has_more))
}

/// Whether an event of the gauge `of` belongs to the series `name`. A controller has a series for each channel.
fn belongs(name: &str, of: &str) -> bool {
    name == of || name.strip_prefix(of).is_some_and(|rest| rest.starts_with('.'))
}

fn report_event((index, event): (usize, Event)) -> ReportEvent {
    ReportEvent {
        number: index + 1,
        at: timestamp(event.at),
        gauge: event.gauge,
        kind: event.kind.clone(),
        text: event.text,
        moment: event.at,
    }
}

/// The pressures of the table of times, from high to low: requested ones, levels, every decade that a gauge crossed, and the next
/// decade below.
fn target_pressures<'a>(request: &ReportRequest, traces: impl Iterator<Item = &'a Trace>) -> Vec<TargetPressure> {
    let one = request.unit.pa();
    let ends = traces.filter_map(Trace::ends);
    let (top, bottom) = ends.fold((f64::MIN, f64::MAX), |(top, bottom), [first, low, _]| {
        (top.max((first.1 / one).log10()), bottom.min((low.1 / one).log10()))
    });
    let decades = (top >= bottom).then(|| bottom.floor() as i32..=top.ceil() as i32 - 1).into_iter().flatten();
    let named = request.gauges.iter().flat_map(|(_, info)| &info.levels);
    let named = named.map(|(name, pa)| TargetPressure { pa: *pa, name: Some(name.clone()) });
    // A positive power of ten is exact, its inverse is not.
    let power = |decade: i32| if decade < 0 { one / 10_f64.powi(-decade) } else { one * 10_f64.powi(decade) };
    let plain = request.pressures.iter().copied().chain(decades.map(power));
    let mut all: Vec<TargetPressure> = named.chain(plain.map(|pa| TargetPressure { pa, name: None })).collect();
    // The sort is stable, so a named pressure stays before a decade at the same pressure.
    all.sort_by(|one, two| two.pa.total_cmp(&one.pa));
    all.dedup_by(|later, kept| {
        (later.pa / kept.pa - 1.0).abs() < 1e-9 && (later.name.is_none() || later.name == kept.name)
    });
    all
}

fn gauge(
    name: String,
    info: GaugeInfo,
    trace: Trace,
    series: &Series,
    targets: &[TargetPressure],
    request: &ReportRequest,
) -> Gauge {
    let start = request.span.start;
    let ends = trace.ends().map(|ends| ends.map(|end| point(start, end)));
    let falls = falls(&trace);
    let falling = |fall: &Fall| falling(fall, request.volume_m3);
    let begun: Vec<f64> = find(&series.samples, 0).iter().map(|one| seconds(start, one.span.start)).collect();
    Gauge {
        name,
        identity: info,
        first: ends.map(|[first, _, _]| first),
        lowest: ends.map(|[_, lowest, _]| lowest),
        last: ends.map(|[_, _, last]| last),
        times: targets.iter().map(|target| reached(start, target.pa, crossing(&trace, target.pa))).collect(),
        quickest: quickest(&falls).as_ref().map(falling),
        falls: falls.iter().filter(|fall| fall.per_s > MIN_RATE).map(falling).collect(),
        slope: final_slope(&trace).map(slope),
        rises: pressure_rises(&trace, &begun).iter().map(|rise| rising(start, rise, request.volume_m3)).collect(),
        coverage: coverage(&trace, series),
        trace,
    }
}

fn after(start: Micros, s: f64) -> Micros {
    start.after(Duration::try_from_secs_f64(s).unwrap_or_default())
}

fn point(start: Micros, (s, pa): (f64, f64)) -> PressurePoint {
    PressurePoint { pa, s, at: timestamp(after(start, s)) }
}

fn reached(start: Micros, pa: f64, crossing: Crossing) -> Reached {
    let (outcome, s, from_s) = match crossing {
        Crossing::Reached { s } => (Outcome::Reached, Some(s), None),
        Crossing::Between { from_s, to_s } => (Outcome::Between, Some(to_s), Some(from_s)),
        Crossing::Before { s } => (Outcome::Before, Some(s), None),
        Crossing::Already => (Outcome::Already, Some(0.0), None),
        Crossing::Unknown { since_s, .. } => (Outcome::Unknown, None, Some(since_s)),
        Crossing::Not => (Outcome::Not, None, None),
    };
    let limit_pa = if let Crossing::Unknown { end_pa, .. } = crossing { Some(end_pa) } else { None };
    Reached { pa, outcome, limit_pa, s, at: s.map(|s| timestamp(after(start, s))), from_s }
}

fn falling(fall: &Fall, volume_m3: Option<f64>) -> Falling {
    let speed_m3_per_s = volume_m3.map(|volume| volume * fall.per_s);
    Falling { s: fall.s, pa: fall.pa, time_constant_s: 1.0 / fall.per_s, speed_m3_per_s }
}

fn slope(slope: FinalSlope) -> Slope {
    Slope { exponent: slope.exponent, error: slope.error, from_s: slope.from_s, to_s: slope.to_s }
}

fn rising(start: Micros, rise: &PressureRise, volume_m3: Option<f64>) -> Rising {
    let leak = rise.fit.map(|fit| fit.leak_pa_per_s);
    let outgassing = rise.fit.map(|fit| fit.outgassing_pa_per_s);
    let flow = |rate: Option<Interval>| rate.zip(volume_m3).map(|(rate, volume)| rate.scaled(volume).into());
    Rising {
        from: point(start, (rise.from_s, rise.from_pa)),
        to: point(start, (rise.to_s, rise.to_pa)),
        pumped_s: rise.pumped_s,
        cause: rise.fit.map(|fit| fit.cause.into()),
        note: rise.fit.is_none().then_some(NO_CLOSED_VOLUME),
        leak_pa_per_s: leak.map(Into::into),
        outgassing_pa_per_s: outgassing.map(Into::into),
        leak_pa_m3_per_s: flow(leak),
        outgassing_pa_m3_per_s: flow(outgassing),
        speed_m3_per_s: rise.fit.and_then(|fit| fit.pumped_per_s).zip(volume_m3).map(|(per_s, volume)| per_s * volume),
    }
}

fn coverage(trace: &Trace, series: &Series) -> DataCoverage {
    DataCoverage {
        samples: trace.samples,
        spacing_s: trace.spacing_s,
        coarsest_s: series.coarsest_s,
        valid_s: trace.seconds_of(Quality::Valid),
        overrange_s: trace.seconds_of(Quality::Overrange),
        underrange_s: trace.seconds_of(Quality::Underrange),
        off_s: trace.seconds_of(Quality::Off),
        missing_s: trace.seconds_of(Quality::Missing),
        fault_s: trace.seconds_of(Quality::Fault),
        stale_s: trace.seconds_of(Quality::Stale),
        assumed_s: trace.seconds_of(Quality::Assumed),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_rise_without_a_leak_says_why() {
        let rise = PressureRise { from_s: 0.0, to_s: 60.0, from_pa: 1e-4, to_pa: 1e-2, pumped_s: None, fit: None };
        let shown = rising(Micros(0), &rise, Some(0.1));
        assert_eq!((shown.leak_pa_m3_per_s, shown.note), (None, Some(NO_CLOSED_VOLUME)));
    }
}
