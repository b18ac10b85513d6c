//! The active instance and its value. tira41d1 3.2.1.3, errata-bpg-bcg-tpg 77 to 80.

use super::parts::{BA, CDG, PIRANI};
use crate::model::{PartSpec, log, mbar};

/// The measurement of the gauge.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Measurement {
    /// The active instance: PV Selector.
    pub active: u8,
    /// Its value in Pa, not clipped.
    pub pa: f64,
}

/// A range in which two parts measure.
struct Overlap {
    low_pa: f64,
    high_pa: f64,
}

const BA_AND_PIRANI: Overlap = Overlap { low_pa: mbar(5.5e-3), high_pa: mbar(2e-2) };
const PIRANI_AND_CDG: Overlap = Overlap { low_pa: mbar(1.0), high_pa: mbar(10.0) };

impl Overlap {
    /// The weight of the upper part at `pa`: linear in the logarithm, 0 at the low and 1 at the high end.
    fn weight(&self, pa: f64) -> f64 {
        match pa {
            _ if pa <= self.low_pa => 0.0,
            _ if pa >= self.high_pa => 1.0,
            _ => log::ln(pa / self.low_pa) / log::ln(self.high_pa / self.low_pa),
        }
    }
}

/// The weighted geometric mean of the readings of two parts.
fn blend(low_pa: f64, high_pa: f64, weight: f64) -> f64 {
    log::exp(log::ln(low_pa) * (1.0 - weight) + log::ln(high_pa) * weight)
}

/// Joins the readings of the parts; the Bayard-Alpert part has none while its emission is off.
///
/// The Pirani measures in both overlaps, so its reading decides where the pressure lies. Without a diaphragm it measures up to the end.
pub fn measure(pirani_pa: f64, ba_pa: Option<f64>, cdg_pa: Option<f64>) -> Measurement {
    let pirani = Measurement { active: PIRANI.part.instance, pa: pirani_pa };
    let cdg = cdg_pa.map_or(pirani, |pa| Measurement { active: CDG.part.instance, pa });
    let upper = cdg_pa.map_or(0.0, |_| PIRANI_AND_CDG.weight(pirani_pa));
    let Some(ba_pa) = ba_pa.filter(|_| upper == 0.0) else { return join(pirani, cdg, &CDG, upper) };
    let ba = Measurement { active: BA.part.instance, pa: ba_pa };
    join(ba, pirani, &PIRANI, BA_AND_PIRANI.weight(pirani_pa))
}

/// The lower part, the upper one, or their mean; in the middle of the overlap the active instance changes (79).
///
/// chosen: the upper part becomes active only when the mean lies in its range; otherwise it could not show it. In
/// helium, where the readings of the two differ widely, this matters.
fn join(low: Measurement, high: Measurement, upper: &PartSpec, weight: f64) -> Measurement {
    if weight == 0.0 {
        return low;
    }
    if weight == 1.0 {
        return high;
    }
    let pa = blend(low.pa, high.pa, weight);
    let shows = weight >= 0.5 && pa >= upper.limits.under_pa;
    Measurement { active: if shows { high.active } else { low.active }, pa }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The measurement of parts that read the same.
    fn at(pa: f64) -> Measurement {
        measure(pa, Some(pa), Some(pa))
    }

    #[test]
    fn the_active_instance_changes_in_the_middle_of_each_overlap() {
        for (mbar_, active) in [
            (1e-11, 2),
            (5.4e-3, 2),
            (1.04e-2, 2),
            (1.06e-2, 1),
            (2.1e-2, 1),
            (0.99, 1),
            (3.1, 1),
            (3.2, 3),
            (10.0, 3),
            (2000.0, 3),
        ] {
            assert_eq!(at(mbar(mbar_)).active, active, "{mbar_} mbar");
        }
    }

    #[test]
    fn parts_that_agree_give_their_common_reading() {
        for mbar_ in [1e-9, 6e-3, 1e-2, 1.9e-2, 0.5, 1.5, 3.16, 9.9, 700.0] {
            let pa = mbar(mbar_);
            assert!((at(pa).pa / pa - 1.0).abs() < 1e-12, "{mbar_} mbar reads {} Pa", at(pa).pa);
        }
    }

    #[test]
    fn the_value_has_no_step_in_an_overlap() {
        // The CDG reads twice what the Pirani reads: the value rises steadily from one to the other.
        let read = |pa: f64| measure(pa, None, Some(2.0 * pa)).pa / pa;
        assert_eq!(read(mbar(1.0)), 1.0);
        assert!(read(mbar(1.001)) < 1.001);
        assert!((read(mbar(10.0f64.sqrt())) - 2.0f64.sqrt()).abs() < 1e-9);
        assert!(read(mbar(9.999)) > 1.999);
        assert_eq!(read(mbar(10.0)), 2.0);
    }

    #[test]
    fn the_upper_part_is_not_active_below_its_range() {
        // Helium: the Pirani reads 7 times what the ionisation part reads.
        for (pirani_mbar, active) in [(1.04e-2, 2), (1.06e-2, 2), (1.15e-2, 2), (1.3e-2, 1)] {
            let ba_pa = mbar(pirani_mbar) / 7.0;
            let measured = measure(mbar(pirani_mbar), Some(ba_pa), Some(ba_pa));
            assert_eq!(measured.active, active, "{pirani_mbar} mbar");
            assert_eq!(active == 1, measured.pa >= mbar(5.5e-3), "{measured:?}");
        }
    }

    #[test]
    fn the_pirani_measures_below_its_range_without_emission() {
        assert_eq!(measure(1e-6, None, Some(1e-6)), Measurement { active: 1, pa: 1e-6 });
    }
}
