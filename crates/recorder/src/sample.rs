//! A pressure with its quality.

use super::quality::{Qualities, Quality};
use super::recorded::Recorded;
use super::summary::Summary;
use profivac_devices::reading::is_pressure;

pub use profivac_model::Micros;

/// The pressure of a series at one time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sample {
    /// When it was measured.
    pub at: Micros,
    /// The pressure in Pa, positive and finite; `None` where the quality has no pressure.
    pub pa: Option<f64>,
    /// Its quality.
    pub quality: Quality,
}

impl Sample {
    /// A sample. A number that is no pressure is dropped, and makes a valid sample a fault.
    #[must_use]
    pub fn new(at: Micros, pa: Option<f64>, quality: Quality) -> Self {
        let kept = pa.filter(|pa| is_pressure(*pa) && quality.has_pressure());
        let quality = if quality == Quality::Valid && kept.is_none() { Quality::Fault } else { quality };
        Self { at, pa: kept, quality }
    }

    /// The beginning of a gap.
    #[must_use]
    pub const fn gap(at: Micros) -> Self {
        Self { at, pa: None, quality: Quality::Stale }
    }

    /// The decimal logarithm of the pressure.
    #[must_use]
    pub fn decades(&self) -> Option<f64> {
        self.pa.map(f64::log10)
    }
}

impl Recorded for Sample {
    type Summary = Summary;

    const SAMPLES: &'static str = "sample";
    const SPANS: &'static str = "span";
    const SERIES: &'static str = "series_id";
    const VALUE: &'static str = "pressure_pa";

    fn of(at: Micros, value: Option<f64>, quality: Quality) -> Self {
        Self::new(at, value, quality)
    }

    fn at(&self) -> Micros {
        self.at
    }

    fn value(&self) -> Option<f64> {
        self.pa
    }

    fn quality(&self) -> Quality {
        self.quality
    }

    fn on_scale(&self) -> Option<f64> {
        self.decades()
    }

    fn summary(&self) -> Summary {
        // The end of a range is no measured pressure.
        let measured = self.pa.filter(|_| self.quality == Quality::Valid);
        Summary {
            low: self.pa,
            high: self.pa,
            decades: measured.map_or(0.0, f64::log10),
            count: u32::from(measured.is_some()),
            last: measured,
            qualities: Qualities::of(self.quality),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_number_that_is_no_pressure_makes_a_valid_sample_a_fault() {
        for pa in [None, Some(f64::NAN), Some(0.0), Some(-1.0), Some(f64::INFINITY)] {
            let sample = Sample::new(Micros(1), pa, Quality::Valid);
            assert_eq!((sample.pa, sample.quality), (None, Quality::Fault), "{pa:?}");
        }
        assert_eq!(Sample::new(Micros(1), Some(9.9e9), Quality::Fault).pa, None);
        assert_eq!(Sample::new(Micros(1), Some(1e5), Quality::Overrange).pa, Some(1e5));
    }
}
