//! The measuring parts of the series: ranges and scales of tira56e1. Numbers in brackets are those of
//! errata-pxg55x-img400.

use crate::model::{Clipping, Counts, Limits, Part, PartSpec, Principle, mbar};

/// Counts for a factor of ten, and at 1 mbar: 3511 x log10(2^20) + 1.
const PER_DECADE: f64 = 3511.0;
const AT_1_MBAR: f64 = PER_DECADE * 20.0 * core::f64::consts::LOG10_2 + 1.0;

/// 3511 x log10(p x 2^20) + 1, with the braces corrected (81).
pub const COUNTS: Counts = Counts::Log { per_decade: PER_DECADE, at_1_mbar: AT_1_MBAR };

/// 8.3.3: the atmosphere sensor has p x 2^4 (82).
const ATM_COUNTS: Counts = Counts::Linear { per_mbar: 16.0 };

/// A hysteresis above or below a point in Pa (32).
pub const fn hysteresis_counts(from_pa: f64, upwards: bool) -> Counts {
    Counts::Distance { per_decade: PER_DECADE, at_1_mbar: AT_1_MBAR, from_mbar: from_pa / mbar(1.0), upwards }
}

/// The diaphragm. 8.1.8, 8.1.12, 8.1.13: the manual has no numbers (86).
pub static CDG: PartSpec = PartSpec {
    part: Part { instance: 1, principle: Principle::Diaphragm },
    limits: Limits { under_pa: mbar(1.0), over_pa: mbar(1500.0), full_scale_pa: mbar(1500.0) },
    clipping: Clipping::Never,
    counts: COUNTS,
};

/// 8.2.8, 8.2.11, 8.2.12 (86)
const PIRANI_LIMITS: Limits = Limits { under_pa: mbar(5e-5), over_pa: mbar(1200.0), full_scale_pa: mbar(1000.0) };

/// The Pirani with this instance.
const fn pirani(instance: u8) -> PartSpec {
    PartSpec {
        part: Part { instance, principle: Principle::Pirani },
        limits: PIRANI_LIMITS,
        clipping: Clipping::Never,
        counts: COUNTS,
    }
}

/// The Pirani of a PCG55x.
pub static PCG_PIRANI: PartSpec = pirani(2);

/// The Pirani of a PSG55x (8).
pub static PSG_PIRANI: PartSpec = pirani(1);

/// The atmosphere sensor.
// chosen: the manual does not say what the atmosphere sensor measures (86); this covers every inhabited altitude.
pub static ATM: PartSpec = PartSpec {
    part: Part { instance: 3, principle: Principle::Atmosphere },
    limits: Limits { under_pa: mbar(300.0), over_pa: mbar(1200.0), full_scale_pa: mbar(1200.0) },
    clipping: Clipping::Never,
    counts: ATM_COUNTS,
};

/// "2 decades below the minimum pressure range of the gauge" (8.1.1): the diaphragm reads zero there.
pub const CDG_ZERO_PA: f64 = CDG.limits.under_pa / 100.0;

/// "Vent to atmosphere" comes before a gain adjust of the Pirani (8.2.1); a chamber below this pressure in Pa is not
/// vented (164).
pub const LOWEST_AIR_PA: f64 = mbar(100.0);

/// chosen: two decades below its range (8.2.1) a Pirani shows only its zero error; a zero error is no greater than this.
pub const LARGEST_PIRANI_ZERO_PA: f64 = mbar(1e-2);

/// The lowest pressure that a gauge of the series measures, in Pa.
pub const LOWEST_PA: f64 = PIRANI_LIMITS.under_pa;
