//! The record of a fit: the valid samples of a time range, the times of the valve, and the volume.

use crate::pumpdown::{TimeRange, Trace, pressure_rises};
use profivac_identify::plant::{Dose, Phase, PlantRecord, Volume};
use profivac_recorder::{Micros, Quality, Sample};

/// The volume, or the dose from which it follows.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum KnownVolume {
    /// The volume in m³.
    Given(f64),
    /// A dose of gas let in while the valve was closed.
    Dose {
        /// The amount in Pa m³.
        amount: f64,
        /// When it was let in.
        at: Micros,
    },
}

/// What a user knows of a record.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Known {
    /// From the start of the pump-down to the end of the record.
    pub span: TimeRange,
    /// When the valve to the pump was closed; without it the beginning of the largest rise.
    pub closed: Option<Micros>,
    /// When it was opened again; without it the end of that rise.
    pub opened: Option<Micros>,
    /// The volume.
    pub volume: KnownVolume,
    /// The standard uncertainty of the gauge as a fraction.
    pub gauge_uncertainty: f64,
}

/// A record, and where its valve was closed.
#[derive(Clone, Debug, PartialEq)]
pub struct Chosen {
    /// The record.
    pub record: PlantRecord,
    /// All valid samples: the record of the fit ends with the rise unless the time of its end is known.
    pub indicated: Vec<(f64, f64)>,
    /// The seconds after the start at which the valve was closed and opened.
    pub rise: Option<[f64; 2]>,
}

/// The samples before and after the closing of the valve from which its time follows.
const BEFORE: usize = 20;
const AFTER: usize = 12;

/// The record between the known times.
#[must_use]
pub fn chosen(samples: &[Sample], known: &Known) -> Chosen {
    let TimeRange { start, end } = known.span;
    let seconds = |at: Micros| at.0.saturating_sub(start.0) as f64 / Micros::SECOND as f64;
    let trace = Trace::new(samples, TimeRange { start, end });
    let found = pressure_rises(&trace, &[0.0]).into_iter().filter(|rise| rise.fit.is_some());
    let found = found.max_by(|one, two| (one.to_pa / one.from_pa).total_cmp(&(two.to_pa / two.from_pa)));
    let found = found.map(|rise| [rise.from_s, rise.to_s]);
    let valid = |sample: &&Sample| sample.quality == Quality::Valid && sample.at >= start && sample.at <= end;
    let inside = samples.iter().filter(valid);
    let mut kept: Vec<(f64, f64)> = inside.filter_map(|sample| Some((seconds(sample.at), sample.pa?))).collect();
    kept.dedup_by_key(|(s, _)| s.to_bits());
    let closed = known.closed.map(seconds).or_else(|| found.map(|[from, _]| closing(&kept, from)));
    let opened = known.opened.map(seconds);
    let indicated = kept.clone();
    // Where the valve was opened between two samples is not known, so the record ends with the rise unless the time is given.
    if let Some([_, to]) = found.filter(|_| opened.is_none()) {
        kept.retain(|(s, _)| *s <= to);
    }
    let rise = closed.map(|closed| {
        let ends = found.filter(|[from, to]| *from <= closed && closed < *to).map(|[_, to]| to);
        [closed, opened.or(ends).unwrap_or_else(|| seconds(end))]
    });
    let volume = match known.volume {
        KnownVolume::Given(m3) => Volume::Given(m3),
        KnownVolume::Dose { amount, at } => Volume::FromDose(Dose { at_s: seconds(at), amount }),
    };
    let phases = phases(rise, seconds(end));
    let gauge_uncertainty = known.gauge_uncertainty;
    Chosen { record: PlantRecord { samples: kept, phases, volume, gauge_uncertainty }, indicated, rise }
}

fn phases(rise: Option<[f64; 2]>, end_s: f64) -> Vec<Phase> {
    let mut phases = vec![Phase { from_s: 0.0, pumped: true }];
    if let Some([closed, opened]) = rise {
        phases.push(Phase { from_s: closed, pumped: false });
        if opened < end_s {
            phases.push(Phase { from_s: opened, pumped: true });
        }
    }
    phases
}

/// When the valve was closed, near the last sample before the rise: where a straight line through the first samples of the rise
/// reaches the pressure before it.
fn closing(samples: &[(f64, f64)], foot_s: f64) -> f64 {
    let index = samples.partition_point(|(s, _)| *s < foot_s);
    let before = samples.get(index.saturating_sub(BEFORE)..index).unwrap_or_default();
    let base = before.iter().map(|(_, pa)| pa.ln()).sum::<f64>() / before.len().max(1) as f64;
    let base = base.exp();
    let rising = samples.iter().skip(index).skip_while(|(_, pa)| *pa < 1.3 * base).take(AFTER);
    let rising: Vec<(f64, f64)> = rising.copied().collect();
    let count = rising.len().max(1) as f64;
    let (s, pa) = rising.iter().fold((0.0, 0.0), |(s, pa), one| (s + one.0 / count, pa + one.1 / count));
    let squares: f64 = rising.iter().map(|one| (one.0 - s).powi(2)).sum();
    let slope = rising.iter().map(|one| (one.0 - s) * (one.1 - pa)).sum::<f64>() / squares;
    let closed = s - (pa - base) / slope;
    let longest = samples.get(index.saturating_sub(BEFORE)).map_or(0.0, |(first, _)| foot_s - first);
    let is_near = closed.is_finite() && !before.is_empty() && (closed - foot_s).abs() <= longest;
    if is_near { closed } else { foot_s }
}
