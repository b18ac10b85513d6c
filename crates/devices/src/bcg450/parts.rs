//! The measuring parts of the BCG450-SP: ranges, scales and thresholds of tira41d1. Numbers in brackets are those of
//! errata-bpg-bcg-tpg.

use crate::model::{Clipping, Counts, Limits, MeasuringRange, Part, PartSpec, Principle, mbar};
use crate::profile::{PotentiometerScale, Thresholds};

/// The first and the last instance of slot 1 that the selector can name.
pub const INSTANCES: (u8, u8) = (1, 6);

/// COUNTS of every instance: a pressure is 10^(COUNTS/2000 - 12.5) mbar (59).
pub const COUNTS: Counts = Counts::Log { per_decade: 2000.0, at_1_mbar: 25000.0 };

/// The Pirani. 3.2.2.6, 3.2.2.9, 3.2.2.10.
pub static PIRANI: PartSpec = PartSpec {
    part: Part { instance: 1, principle: Principle::Pirani },
    limits: Limits { under_pa: mbar(5.5e-3), over_pa: mbar(1000.0), full_scale_pa: mbar(1000.0) },
    clipping: Clipping::Both,
    counts: COUNTS,
};

/// The Bayard-Alpert part. 3.2.3.6, 3.2.3.9, 3.2.3.10.
pub static BA: PartSpec = PartSpec {
    part: Part { instance: 2, principle: Principle::HotCathode },
    limits: Limits { under_pa: mbar(5e-10), over_pa: mbar(2e-2), full_scale_pa: mbar(2e-2) },
    clipping: Clipping::Above,
    counts: COUNTS,
};

/// The capacitance diaphragm. 3.2.4.6, 3.2.4.9, 3.2.4.10.
pub static CDG: PartSpec = PartSpec {
    part: Part { instance: 3, principle: Principle::Diaphragm },
    limits: Limits { under_pa: mbar(1.0), over_pa: mbar(1500.0), full_scale_pa: mbar(1500.0) },
    clipping: Clipping::Below,
    counts: COUNTS,
};

/// The measuring parts. The last one measures the ambient air, not the chamber, and has no range in the tables (3.3.5).
pub static PARTS: [Part; 4] = [PIRANI.part, BA.part, CDG.part, Part { instance: 4, principle: Principle::Atmosphere }];

/// Those of a gauge without a diaphragm, in a device file.
pub static PARTS_WITHOUT_DIAPHRAGM: [Part; 3] =
    [PIRANI.part, BA.part, Part { instance: 4, principle: Principle::Atmosphere }];

/// The range of the ambient pressure sensor.
///
/// chosen: the manual gives none (3.3.5); as in the gauges of tira56e1.
pub const ATMOSPHERE: MeasuringRange = MeasuringRange { lowest_pa: mbar(300.0), highest_pa: mbar(1200.0) };

/// The range of the whole gauge. 3.3.1.1 (58).
pub const GAUGE: Limits = Limits { under_pa: mbar(5e-10), over_pa: mbar(1500.0), full_scale_pa: mbar(1500.0) };

/// The pressures at which the hot cathode is switched. 3.3.3.9.
///
/// chosen: the operating current changes at the Degas On Limit, as on the BPG400-SP.
pub static CATHODE: Thresholds = Thresholds { off_pa: mbar(3.2e-2), on_pa: mbar(2.4e-2), degas_pa: mbar(7.2e-6) };

/// The potentiometers of the set points. 3.2.5.1; the manual has no limit above which the relays do not work (107).
pub static POTENTIOMETER: PotentiometerScale =
    PotentiometerScale { per_volt: 1.23011, at_0_v: -9.301_029_99, highest_pa: f64::INFINITY };

/// The range of Percentage of atmosphere, in tenths of a percent. 3.2.5.7.
pub const PERCENTAGE: (u16, u16) = (10, 1400);
