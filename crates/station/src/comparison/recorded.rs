//! The pump-downs of a series, with their samples.

use crate::identification::sprays::{Circumstances, SprayView, sprays};
use crate::pumpdown::compare::{Comparison, Excess, Pattern, Run, excess};
use crate::pumpdown::final_slope::pressure;
use crate::pumpdown::{PumpDown, TimeRange, Trace};
use crate::report::series::{pump_downs_in, series};
use profivac_recorder::{DatabaseError, Reader};

/// The most points of a curve, evenly on a logarithmic axis of time.
const POINTS: usize = 120;

/// The first point of a curve, in s.
const FIRST_S: f64 = 1.0;

/// The least number of usual curves of which a median is formed.
const LEAST_CURVES: usize = 5;

/// Days, and the length of the spans in s for a search of at most these days.
const WIDTHS: [(f64, i64); 3] = [(1.0, 1), (10.0, 10), (f64::INFINITY, 120)];

/// A pump-down with its samples.
#[derive(Clone, Debug, PartialEq)]
pub struct Recorded {
    /// Its times.
    pub run: Run,
    /// Its samples.
    pub trace: Trace,
}

impl Recorded {
    /// Reads the samples of a pump-down.
    ///
    /// # Errors
    /// [`DatabaseError`] when the database cannot be read.
    pub fn read(reader: &Reader, gauge: &str, one: &PumpDown) -> Result<Self, DatabaseError> {
        let trace = Trace::new(&series(reader, gauge, one.span)?.samples, one.span);
        Ok(Self { run: Run::new(one, &trace), trace })
    }

    /// The changes of the indication that look like helium at a leak.
    #[must_use]
    pub fn sprays(&self) -> Vec<SprayView> {
        let parts = self.trace.valid().map(|section| sprays(self.run.start, &section.points, Circumstances::default()));
        parts.flatten().collect()
    }

    /// Seconds and pressures in Pa, evenly on a logarithmic axis of time.
    #[must_use]
    pub fn curve(&self) -> Vec<(f64, f64)> {
        let last = self.run.seconds();
        let at = |step: usize| FIRST_S * (last / FIRST_S).powf(step as f64 / (POINTS - 1) as f64);
        (0..POINTS).map(at).filter_map(|s| Some((s, pressure(&self.trace, s)?))).collect()
    }
}

/// The pump-downs of a series in a time range, the earliest first.
///
/// # Errors
/// [`DatabaseError`] when the database cannot be read.
pub fn recorded(reader: &Reader, gauge: &str, range: TimeRange) -> Result<Vec<Recorded>, DatabaseError> {
    let days = range.seconds() / 86_400.0;
    let width = WIDTHS.into_iter().find(|(most, _)| days <= *most).map_or(120, |(_, width)| width);
    let found = pump_downs_in(reader, &[gauge.to_owned()], range, width)?;
    found.iter().map(|one| Recorded::read(reader, gauge, one)).collect()
}

/// The shape of the pressure above the median of the usual curves, where a pump-down is late at low pressure.
#[must_use]
pub fn excess_of(comparison: &Comparison, own: &Recorded, usual: &[&Recorded]) -> Option<Excess> {
    if comparison.pattern() != Some(Pattern::AtLowPressure) || usual.len() < LEAST_CURVES {
        return None;
    }
    let points = own.curve().into_iter().filter_map(|(s, pa)| {
        let mut others: Vec<f64> = usual.iter().filter_map(|one| pressure(&one.trace, s)).collect();
        others.sort_by(f64::total_cmp);
        (others.len() >= LEAST_CURVES).then(|| others.get(others.len() / 2).map(|middle| (s, pa, *middle)))?
    });
    excess(&points.collect::<Vec<_>>())
}
