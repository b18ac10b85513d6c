//! The rate at which the pressure falls: `-d(ln p)/dt`. It is the effective pumping speed divided by the volume, as long as only the
//! volume is evacuated.
//!
//! The rate is measured over the time in which the pressure halves: long enough for noise, short enough for an opening valve.

use super::trace::{Section, Trace};

/// The measured fall, as a factor. chosen: with it, noise of 5 % causes an error of a tenth.
const FACTOR: f64 = 2.0;

/// The fewest samples of a fall. Fewer would show the sampling rate.
const SAMPLES: usize = 4;

/// The distance of two points of the curve, in decades.
const STEP: f64 = 0.1;

/// A fall of the pressure.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Fall {
    /// Its end, in seconds since the beginning.
    pub s: f64,
    /// The pressure in its middle, in Pa.
    pub pa: f64,
    /// Its rate, in 1/s.
    pub per_s: f64,
}

/// The falls to pressures that were not reached before; of every tenth of a decade the fastest one.
#[must_use]
pub fn falls(trace: &Trace) -> Vec<Fall> {
    let mut kept: Vec<Fall> = Vec::new();
    let mut lowest = f64::MAX;
    for fall in trace.valid().flat_map(all) {
        match kept.last_mut() {
            Some(last) if fall.pa > lowest / 10_f64.powf(STEP) => {
                if fall.pa <= lowest && fall.per_s > last.per_s {
                    *last = fall;
                }
            }
            _ => {
                lowest = fall.pa;
                kept.push(fall);
            }
        }
    }
    kept
}

/// The fastest fall.
#[must_use]
pub fn quickest(falls: &[Fall]) -> Option<Fall> {
    falls.iter().copied().max_by(|one, two| one.per_s.total_cmp(&two.per_s))
}

/// The falls that end at each sample, since the last sample with twice its pressure.
fn all(section: &Section) -> Vec<Fall> {
    let points = &section.smooth;
    let mut foot = 0;
    let mut falls = Vec::new();
    for (index, (t, pa)) in points.iter().enumerate() {
        let is_foot = |foot: usize| {
            foot + SAMPLES <= index + 1 && points.get(foot).is_some_and(|(_, above)| *above >= FACTOR * pa)
        };
        while is_foot(foot + 1) {
            foot += 1;
        }
        if let Some((t0, p0)) = points.get(foot).filter(|_| is_foot(foot)) {
            // A fall that reverses at once is noise, as at the end of a range.
            let middle = (p0 * pa).sqrt();
            if points.iter().skip(index + 1).take(SAMPLES).all(|(_, later)| *later <= middle) {
                falls.push(Fall { s: *t, pa: middle, per_s: (p0 / pa).ln() / (t - t0) });
            }
        }
    }
    falls
}
