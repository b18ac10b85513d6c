//! The pump-downs of a series, with their samples.

use crate::identification::sprays::{Circumstances, SprayView, sprays};
use crate::pumpdown::compare::{Comparison, Pattern, Run, USUAL_RUNS};
use crate::pumpdown::excess::{Excess, excess};
use crate::pumpdown::final_slope::pressure;
use crate::pumpdown::{PumpDown, TimeRange, Trace};
use crate::report::series::{known, pump_downs_in, series};
use profivac_recorder::{DatabaseError, Reader};

/// The most points of a curve, evenly on a logarithmic axis of time.
const POINTS: usize = 120;

/// The first point of a curve, in s.
const FIRST_S: f64 = 1.0;

/// The least number of usual curves of which a median is formed.
const LEAST_CURVES: usize = 5;

/// Days, and the length of the spans in s for a search of at most these days. Only days with samples count: a pump-down of half a minute
/// is found in a short record, whatever time the question covers.
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
    let Some(known) = known(reader, &[gauge.to_owned()])? else { return Ok(Vec::new()) };
    let range = TimeRange { start: range.start.max(known.start), end: range.end.min(known.end) };
    if range.start >= range.end {
        return Ok(Vec::new());
    }
    let days = range.seconds() / 86_400.0;
    let width = WIDTHS.into_iter().find(|(most, _)| days <= *most).map_or(120, |(_, width)| width);
    let found = pump_downs_in(reader, &[gauge.to_owned()], range, width)?;
    found.iter().map(|one| Recorded::read(reader, gauge, one)).collect()
}

/// The last usual pump-downs before the one at `place`, the latest first.
#[must_use]
pub fn usual_before<'a>(runs: &'a [Recorded], compared: &[Comparison], index: usize) -> Vec<&'a Recorded> {
    let before = runs.iter().zip(compared).take(index).rev();
    let usual = before.filter(|(_, comparison)| comparison.first().is_none()).map(|(run, _)| run);
    usual.take(USUAL_RUNS).collect()
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

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, clippy::panic, reason = "a test")]

    use super::*;
    use crate::comparison::view::PumpDowns;
    use crate::pumpdown::compare::compare;
    use crate::pumpdown::find;
    use profivac_recorder::{Micros, Quality, Sample};

    /// An ion gauge: two hours of pumping from 100 mbar with 10 s, then helium in place of the air of a leak for a minute.
    fn samples() -> Vec<Sample> {
        let mut random = fastrand::Rng::with_seed(3);
        let filled = |s: f64| 1.0 - (-s.max(0.0) / 10.0).exp();
        let left = |t: f64| filled(t.min(6_060.0) - 6_000.0) * (-(t - 6_060.0).max(0.0) / 10.0).exp();
        let mut kept = Vec::new();
        for second in -20..7_200 {
            let t = f64::from(second).max(0.0);
            let noise: f64 = (0..12).map(|_| random.f64()).sum::<f64>() - 6.0;
            let pa = 1e4 * (-t / 10.0).exp() + 1e-3 * 3600.0 / (t + 10.0) + 1e-4 * (1.0 - 0.54 * left(t));
            let at = Micros((1_000_000 + i64::from(second)) * Micros::SECOND);
            let sample = Sample::new(at, Some(pa * (1.0 + 0.005 * noise)), Quality::Valid);
            kept.push(sample);
        }
        kept
    }

    #[test]
    fn helium_at_a_leak_is_a_sentence_of_its_pump_down() {
        let samples = samples();
        let one = find(&samples, 0).pop().unwrap();
        let trace = Trace::new(&samples, one.span);
        let own = Recorded { run: Run::new(&one, &trace), trace };
        let runs = [own];
        let compared = compare(std::slice::from_ref(&runs[0].run));
        let shown = PumpDowns::new("chamber".to_owned(), &runs, &compared, 10);
        let [spray] = &shown.runs[0].sprays[..] else { panic!("{:?}", shown.runs[0].sprays) };
        assert!(
            (spray.start_ms - 1_006_000_000).abs() < 3_000 && (spray.end_ms - 1_006_060_000).abs() < 3_000,
            "{spray:?}"
        );
        assert!(spray.text.contains("falls by") && spray.text.contains("helium sprayed on a leak"), "{}", spray.text);
        // The pressure is 7e-4 Pa, of which the leak is a seventh.
        assert!((spray.change_pa.mean / -5.4e-5 - 1.0).abs() < 0.1, "{spray:?}");
        assert_eq!(spray.leak_pa_m3_per_s, None, "the station does not know the kind of the gauge");
    }
}
