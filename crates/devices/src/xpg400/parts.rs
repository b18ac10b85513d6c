//! The measuring parts of BPG400-SP and HPG400-SP: ranges, scales and thresholds of tira36e1. Numbers in brackets are
//! those of errata-bpg-bcg-tpg.

use crate::model::{Clipping, Counts, Limits, Part, PartSpec, Principle, mbar};
use crate::profile::{PotentiometerScale, Thresholds};

/// The first and the last instance of slot 1 that the selector can name.
pub const INSTANCES: (u8, u8) = (1, 4);

/// COUNTS of every instance of the BPG400-SP: a pressure is 10^(COUNTS/2000 - 12.5) mbar (59).
pub const BPG_COUNTS: Counts = Counts::Log { per_decade: 2000.0, at_1_mbar: 25000.0 };

// The HPG400-SP has three scales (64).
/// 10^(6 x COUNTS/4000 - 42.5) mbar: Pirani and Emission On Switch (66).
const HPG_PIRANI_COUNTS: Counts = Counts::Log { per_decade: 4000.0 / 6.0, at_1_mbar: 42.5 * 4000.0 / 6.0 };
/// 10^(6 x COUNTS/16000 - 9.125) mbar.
const HP_COUNTS: Counts = Counts::Log { per_decade: 16000.0 / 6.0, at_1_mbar: 9.125 * 16000.0 / 6.0 };
/// COUNTS of the set points: a pressure is 10^((COUNTS - 22999)/2444) mbar, with the printed constants (65).
pub const HPG_SET_POINT_COUNTS: Counts = Counts::Log { per_decade: 2444.0, at_1_mbar: 22999.0 };

/// The Pirani of both gauges.
pub const PIRANI: Part = Part { instance: 1, principle: Principle::Pirani };
const ION: Part = Part { instance: 2, principle: Principle::HotCathode };

/// Below this pressure in Pa the Pirani is not in air (chosen).
pub const LOWEST_AIR_PA: f64 = mbar(100.0);

/// The measuring parts.
pub static PARTS: [Part; 2] = [PIRANI, ION];

/// The Pirani of the BPG400-SP. Above overrange the gauge shows the value as measured (53). 3.2.2.6, 3.2.2.9, 3.2.2.10.
pub static BPG_PIRANI: PartSpec = PartSpec {
    part: PIRANI,
    limits: Limits { under_pa: mbar(5.5e-3), over_pa: mbar(1000.0), full_scale_pa: mbar(1000.0) },
    clipping: Clipping::Below,
    counts: BPG_COUNTS,
};

/// The Pirani of the HPG400-SP, from the same sections.
pub static HPG_PIRANI: PartSpec = PartSpec {
    part: PIRANI,
    limits: Limits { under_pa: mbar(1e-2), over_pa: mbar(1000.0), full_scale_pa: mbar(1000.0) },
    clipping: Clipping::Below,
    counts: HPG_PIRANI_COUNTS,
};

/// The Bayard-Alpert part of the BPG400-SP. 3.2.3.6, 3.2.3.9, 3.2.3.10 (61).
pub static BA: PartSpec = PartSpec {
    part: ION,
    limits: Limits { under_pa: mbar(5e-10), over_pa: mbar(2e-2), full_scale_pa: mbar(2e-2) },
    clipping: Clipping::Above,
    counts: BPG_COUNTS,
};

/// The High Pressure ionisation part of the HPG400-SP, from the same sections.
pub static HP: PartSpec = PartSpec {
    part: ION,
    limits: Limits { under_pa: mbar(1e-6), over_pa: mbar(1.0), full_scale_pa: mbar(1.0) },
    clipping: Clipping::Above,
    counts: HP_COUNTS,
};

/// The range of the whole BPG400-SP (58).
pub const BPG_GAUGE: Limits = Limits { under_pa: mbar(5e-10), over_pa: mbar(1000.0), full_scale_pa: mbar(1000.0) };

/// The range of the whole HPG400-SP (58).
pub const HPG_GAUGE: Limits = Limits { under_pa: mbar(1e-6), over_pa: mbar(1000.0), full_scale_pa: mbar(1000.0) };

/// The pressure at which the ionisation part takes over from the Pirani (3.2.1.4).
#[derive(Debug)]
pub struct Switchover {
    /// Below this pressure of the Pirani the ionisation part measures, in Pa; no hysteresis (77).
    pub pa: f64,
    /// The pressures at which its emission is switched.
    pub emission: Thresholds,
}

/// The switchover of the BPG400-SP. The operating current changes at the limit of degas.
///
/// chosen: the manual has no thresholds of the emission, these are those of the BCG450-SP.
pub static BPG_SWITCHOVER: Switchover = Switchover {
    pa: mbar(5.5e-3),
    emission: Thresholds { off_pa: mbar(3.2e-2), on_pa: mbar(2.4e-2), degas_pa: mbar(7.2e-6) },
};

/// The emission of the HPG400-SP switches on at the switchover (82).
///
/// chosen: it goes off a third above it, as far as on the BCG450-SP. There is one current and no degas.
const fn switchover(at_mbar: f64) -> Switchover {
    let pa = mbar(at_mbar);
    Switchover { pa, emission: Thresholds { off_pa: pa * 4.0 / 3.0, on_pa: pa, degas_pa: 0.0 } }
}

/// 3.1.1.13: for each two positions of LOW-HIGH, from 0 on (66).
static HPG_SWITCHOVER: [Switchover; 5] =
    [switchover(1.0), switchover(0.5), switchover(0.2), switchover(0.1), switchover(0.05)];

/// The switchover of the HPG400-SP at this position of LOW-HIGH, 0 to 9.
pub const fn hpg_switchover(position: u8) -> &'static Switchover {
    let [high, second, third, fourth, low] = &HPG_SWITCHOVER;
    match position {
        0 | 1 => high,
        2 | 3 => second,
        4 | 5 => third,
        6 | 7 => fourth,
        _ => low,
    }
}

/// 3.2.4.1: above 100 mbar the switching functions do not work (107).
const HIGHEST_SET_POINT_PA: f64 = mbar(100.0);

/// The potentiometers of the BPG400-SP (109).
pub static BPG_POTENTIOMETER: PotentiometerScale =
    PotentiometerScale { per_volt: 1.23011, at_0_v: -9.301_029_99, highest_pa: HIGHEST_SET_POINT_PA };

/// The potentiometers of the HPG400-SP (109).
pub static HPG_POTENTIOMETER: PotentiometerScale =
    PotentiometerScale { per_volt: 0.9, at_0_v: -6.0, highest_pa: HIGHEST_SET_POINT_PA };
