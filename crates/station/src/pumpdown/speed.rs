//! How fast the pressure falls: `-d(ln p)/dt`, which is the effective pumping speed divided by the volume while nothing else
//! than the volume is pumped.
//!
//! What is taken is the time in which the pressure halves, at every sample: long enough for noise, short enough for a valve
//! that opens.

use super::trace::{Section, Trace};

/// A fall by this factor is measured. free choice: noise of 5 % makes an error of a tenth.
const FACTOR: f64 = 2.0;

/// And at least over so many samples: of fewer, the rate of sampling would be seen.
const SAMPLES: usize = 4;

/// A point of the curve for so many decades.
const STEP: f64 = 0.1;

/// A fall of the pressure.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Fall {
    /// When it ended, in seconds since the beginning.
    pub s: f64,
    /// Around which pressure, in Pa.
    pub pa: f64,
    /// The rate, in 1/s.
    pub per_s: f64,
}

/// The falls to pressures that were not reached before, the quickest of every tenth of a decade.
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

/// The quickest of them.
#[must_use]
pub fn quickest(falls: &[Fall]) -> Option<Fall> {
    falls.iter().copied().max_by(|one, two| one.per_s.total_cmp(&two.per_s))
}

/// At every sample: since the last one at which the pressure was twice as high.
fn all(piece: &Section) -> Vec<Fall> {
    let points = &piece.smooth;
    let mut foot = 0;
    let mut falls = Vec::new();
    for (place, (t, pa)) in points.iter().enumerate() {
        let is_foot = |foot: usize| {
            foot + SAMPLES <= place + 1 && points.get(foot).is_some_and(|(_, above)| *above >= FACTOR * pa)
        };
        while is_foot(foot + 1) {
            foot += 1;
        }
        if let Some((t0, p0)) = points.get(foot).filter(|_| is_foot(foot)) {
            // A fall that bounces back at once is noise, as at the end of a range.
            let middle = (p0 * pa).sqrt();
            if points.iter().skip(place + 1).take(SAMPLES).all(|(_, later)| *later <= middle) {
                falls.push(Fall { s: *t, pa: middle, per_s: (p0 / pa).ln() / (t - t0) });
            }
        }
    }
    falls
}
