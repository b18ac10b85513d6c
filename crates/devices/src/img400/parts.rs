//! The measuring parts of the IMG 400: how many, their ranges, scales and thresholds. Numbers in brackets are those of
//! errata-pxg55x-img400.

use crate::model::{Clipping, Counts, Limits, Part, PartSpec, Principle, mbar};
use crate::profile::Thresholds;

/// The channels of the controller.
pub const CHANNELS: usize = 4;

/// The relays of the controller.
pub const RELAYS: usize = 7;

/// 4.4.2: COUNTS = 4000 x (log10(p / hPa) + 12.5), an unsigned word (15, 134).
pub const COUNTS: Counts = Counts::Log { per_decade: PER_DECADE, at_1_mbar: AT_1_MBAR };
const PER_DECADE: f64 = 4000.0;
const AT_1_MBAR: f64 = 50_000.0;

/// The highest COUNTS.
pub const HIGHEST_COUNT: u16 = u16::MAX;

/// COUNTS of a hysteresis above a trip point (32).
pub const fn hysteresis_counts(from_pa: f64) -> Counts {
    Counts::Distance { per_decade: PER_DECADE, at_1_mbar: AT_1_MBAR, from_mbar: from_pa / mbar(1.0), upwards: true }
}

// chosen: the ranges of the gauges are in another manual (133).
const BAG: Limits = Limits { under_pa: mbar(1e-10), over_pa: mbar(1e-2), full_scale_pa: mbar(1e-2) };
const EXT: Limits = Limits { under_pa: mbar(1e-12), over_pa: mbar(1e-4), full_scale_pa: mbar(1e-4) };
const TPR: Limits = Limits { under_pa: mbar(8e-4), over_pa: mbar(1000.0), full_scale_pa: mbar(1000.0) };
const CMR: Limits = Limits { under_pa: mbar(0.1), over_pa: mbar(1000.0), full_scale_pa: mbar(1000.0) };

const fn part(instance: u8, principle: Principle, limits: Limits) -> PartSpec {
    PartSpec { part: Part { instance, principle }, limits, clipping: Clipping::Never, counts: COUNTS }
}

/// The gauges of Appendix A on every channel where they may be.
pub static BAG_1: PartSpec = part(1, Principle::HotCathode, BAG);
pub static EXT_1: PartSpec = part(1, Principle::HotCathode, EXT);
pub static BAG_2: PartSpec = part(2, Principle::HotCathode, BAG);
pub static EXT_2: PartSpec = part(2, Principle::HotCathode, EXT);
pub static TPR_3: PartSpec = part(3, Principle::Pirani, TPR);
pub static CMR_3: PartSpec = part(3, Principle::Diaphragm, CMR);
pub static TPR_4: PartSpec = part(4, Principle::Pirani, TPR);
pub static CMR_4: PartSpec = part(4, Principle::Diaphragm, CMR);

/// 4.4.4: emission goes off above p_max, degas starts below 1e-4 hPa and 1e-5 hPa. It may be switched on at any
/// pressure.
// chosen: p_max is in another manual; it lies above the range, so that overrange can be reported.
pub static BAG_CATHODE: Thresholds = Thresholds { off_pa: mbar(2e-2), on_pa: f64::INFINITY, degas_pa: mbar(1e-4) };
pub static EXT_CATHODE: Thresholds = Thresholds { off_pa: mbar(2e-4), on_pa: f64::INFINITY, degas_pa: mbar(1e-5) };
