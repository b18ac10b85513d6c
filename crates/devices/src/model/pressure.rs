//! Units, number types, and the numbers that represent a pressure on the wire. Inside a device every pressure is in Pa.

use super::log;
use super::octets::Octets;

/// A pressure in mbar, converted to Pa.
#[must_use]
pub const fn mbar(mbar: f64) -> f64 {
    mbar * PA_PER_MBAR
}

const PA_PER_MBAR: f64 = 100.0;

/// A pressure unit of a device. Codes differ between device families: errata-bpg-bcg-tpg 5.
#[derive(Debug, PartialEq)]
pub struct Unit {
    /// The code of Data Units.
    pub code: u16,
    /// As printed.
    pub name: &'static str,
    /// Another common name.
    pub alias: &'static str,
    /// Its scale.
    pub scale: Scale,
}

/// The scale of a unit.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Scale {
    /// This number of units for one mbar.
    PerMbar(f64),
    /// It depends on the instance: [`Counts`].
    Counts,
}

impl Scale {
    /// mbar and hPa.
    pub const MBAR: Self = Self::PerMbar(1.0);
    /// Pa.
    pub const PASCAL: Self = Self::PerMbar(100.0);
    /// Torr: 101325/760 Pa.
    pub const TORR: Self = Self::PerMbar(0.750_061_68);
    /// mTorr.
    pub const MICRON: Self = Self::PerMbar(750.061_68);
}

/// The COUNTS of an instance.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Counts {
    /// counts = per_decade x log10(p / mbar) + at_1_mbar
    Log {
        /// Counts for a factor of ten.
        per_decade: f64,
        /// Counts at 1 mbar.
        at_1_mbar: f64,
    },
    /// counts = per_mbar x p / mbar
    Linear {
        /// Counts for one mbar.
        per_mbar: f64,
    },
    /// A difference of pressures, counted on the logarithmic scale from a point to the point plus or minus the
    /// difference. Both ends are converted, not the difference itself: errata-pxg55x-img400 32.
    Distance {
        /// Counts for a factor of ten.
        per_decade: f64,
        /// Counts at 1 mbar.
        at_1_mbar: f64,
        /// The point, in mbar.
        from_mbar: f64,
        /// The difference is added to the point (`true`) or subtracted from it.
        upwards: bool,
    },
}

impl Counts {
    fn number_of(self, mbar: f64) -> f64 {
        match self {
            // A pressure of 0 or less has no logarithm.
            Self::Log { .. } if mbar <= 0.0 => 0.0,
            Self::Log { per_decade, at_1_mbar } => per_decade * log::log10(mbar) + at_1_mbar,
            Self::Linear { per_mbar } => per_mbar * mbar,
            Self::Distance { per_decade, at_1_mbar, from_mbar, upwards } => {
                let scale = Self::Log { per_decade, at_1_mbar };
                let end_mbar = if upwards { from_mbar + mbar } else { from_mbar - mbar };
                (scale.number_of(end_mbar) - scale.number_of(from_mbar)).abs()
            }
        }
    }

    fn mbar_of(self, counts: f64) -> f64 {
        match self {
            Self::Log { per_decade, at_1_mbar } => log::exp10((counts - at_1_mbar) / per_decade),
            Self::Linear { per_mbar } => counts / per_mbar,
            Self::Distance { per_decade, at_1_mbar, from_mbar, upwards } => {
                let scale = Self::Log { per_decade, at_1_mbar };
                let from = scale.number_of(from_mbar);
                (scale.mbar_of(if upwards { from + counts } else { from - counts }) - from_mbar).abs()
            }
        }
    }
}

/// The number type of the pressures of a device: the parameter Data Type.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum NumberType {
    /// Integer16, whole units.
    Integer,
    /// IEEE 754.
    Float,
}

impl NumberType {
    /// The code of Data Type, which is also the type code in a configuration.
    #[must_use]
    pub const fn code(self) -> u8 {
        match self {
            Self::Integer => 3,
            Self::Float => 8,
        }
    }

    /// The number type with this code.
    #[must_use]
    pub const fn from_code(code: u8) -> Option<Self> {
        match code {
            3 => Some(Self::Integer),
            8 => Some(Self::Float),
            _ => None,
        }
    }

    /// The number of octets.
    #[must_use]
    pub const fn octets(self) -> usize {
        match self {
            Self::Integer => 2,
            Self::Float => 4,
        }
    }
}

/// The highest Integer16: errata-bpg-bcg-tpg 3.
pub const INTEGER16_MAX: u16 = 32767;

/// The highest pressure that fits into a float in every unit.
const HIGHEST_PA: f64 = 1e30;

/// Added before an integer is truncated, so that a 5 that is written and kept as 4.9999999999 is read as 5. Far below
/// the one count of errata-bpg-bcg-tpg 69.
const ROUNDING: f64 = 1e-6;

/// A measured pressure as far as its format holds it, in Pa. An integer is saturated and truncated to whole units
/// (errata-bpg-bcg-tpg 70, errata-pxg55x-img400 16), so its two ends stand for every pressure beyond them.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum HeldPressure {
    /// This pressure.
    Exact(f64),
    /// The highest integer: this pressure or a higher one.
    AtLeast(f64),
    /// The integer 0: a pressure below this one, which is one unit.
    Below(f64),
}

/// The format of the pressures of one instance on the wire.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PressureFormat {
    /// Data Units.
    pub unit: &'static Unit,
    /// Data Type.
    pub number: NumberType,
    /// The instance's COUNTS.
    pub counts: Counts,
    /// The highest integer: [`INTEGER16_MAX`], or 65535 where the manual means an unsigned word.
    pub max_integer: u16,
}

impl PressureFormat {
    /// The number that represents `pa`.
    #[must_use]
    pub fn number_from_pa(&self, pa: f64) -> f64 {
        let mbar = pa / PA_PER_MBAR;
        match self.unit.scale {
            // Zero has no logarithm: errata-bpg-bcg-tpg 74.
            _ if pa == 0.0 => 0.0,
            Scale::PerMbar(factor) => mbar * factor,
            Scale::Counts => self.counts.number_of(mbar),
        }
    }

    /// The pressure in Pa that `number` represents; `None` for a number that represents no pressure.
    #[must_use]
    pub fn pa_from_number(&self, number: f64) -> Option<f64> {
        let mbar = match self.unit.scale {
            _ if number == 0.0 => 0.0,
            Scale::PerMbar(factor) => number / factor,
            Scale::Counts => self.counts.mbar_of(number),
        };
        let pa = mbar * PA_PER_MBAR;
        let is_pressure = match (self.unit.scale, self.counts) {
            // The formula also holds below 0 counts, for very low pressures: errata-bpg-bcg-tpg 69.
            (Scale::Counts, Counts::Log { .. }) => number == 0.0 || pa > 0.0,
            _ => number >= 0.0,
        };
        // chosen: no manual limits a number that a master may write. A negative pressure has no COUNTS when the
        // unit changes (errata-bpg-bcg-tpg 74), and one beyond a float has no value in some unit; both are out of
        // range, and so are NaN and an infinite number, of which a distance downwards would make the whole point.
        (is_pressure && number.is_finite() && (0.0..=HIGHEST_PA).contains(&pa)).then_some(pa)
    }

    /// The octets of a pressure: a float, or an integer truncated to whole units and saturated (errata-bpg-bcg-tpg 69 and 70).
    #[must_use]
    pub fn encode(&self, pa: f64) -> Octets {
        let number = self.number_from_pa(pa);
        match self.number {
            #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "truncated and clamped")]
            NumberType::Integer => {
                let whole = libm::floor(number + ROUNDING).max(0.0).min(f64::from(self.max_integer));
                Octets::new(&(whole as u16).to_be_bytes())
            }
            #[expect(clippy::cast_possible_truncation, reason = "a float has no more digits")]
            NumberType::Float => Octets::new(&(number as f32).to_be_bytes()),
        }
    }

    /// The pressure in Pa; `None` for another length and for a number that represents no pressure.
    #[must_use]
    pub fn decode(&self, octets: &[u8]) -> Option<f64> {
        let number = match self.number {
            NumberType::Integer => {
                let word = octets.try_into().map(u16::from_be_bytes).ok()?;
                f64::from(Some(word).filter(|word| *word <= self.max_integer)?)
            }
            NumberType::Float => octets.try_into().map(f32::from_be_bytes).ok()?.into(),
        };
        self.pa_from_number(number)
    }

    /// The measured pressure; `None` as for [`decode`](Self::decode).
    ///
    /// ```
    /// use profivac_devices::bcg450::table::MODEL;
    /// use profivac_devices::model::{Counts, HeldPressure, NumberType, PressureFormat};
    ///
    /// let unit = MODEL.unit_named("Pascal").ok_or("no such unit")?;
    /// let (number, counts) = (NumberType::Integer, Counts::Linear { per_mbar: 1.0 });
    /// let format = PressureFormat { unit, number, counts, max_integer: MODEL.max_integer };
    /// let is_near = |pa: f64, expected: f64| (pa - expected).abs() < 1e-6;
    /// assert!(matches!(format.measured(&[0x7F, 0xFE]), Some(HeldPressure::Exact(pa)) if is_near(pa, 32766.0)));
    /// assert!(matches!(format.measured(&[0x7F, 0xFF]), Some(HeldPressure::AtLeast(pa)) if is_near(pa, 32767.0)));
    /// assert!(matches!(format.measured(&[0, 0]), Some(HeldPressure::Below(pa)) if is_near(pa, 1.0)));
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    #[must_use]
    pub fn measured(&self, octets: &[u8]) -> Option<HeldPressure> {
        let pa = self.decode(octets)?;
        if self.number == NumberType::Float {
            return Some(HeldPressure::Exact(pa));
        }
        Some(match octets {
            [0, 0] if self.truncates_to_zero() => HeldPressure::Below(self.pa_from_number(1.0)?),
            _ if octets == self.max_integer.to_be_bytes() => HeldPressure::AtLeast(pa),
            _ => HeldPressure::Exact(pa),
        })
    }

    /// Whether a pressure of a gauge can be below one unit. chosen: 0 on a logarithmic scale of COUNTS is no reading, because the ranges
    /// of all gauges end far above it, and a device sends 0 in place of a reading (Safe State Zero, errata-bpg-bcg-tpg 74).
    fn truncates_to_zero(&self) -> bool {
        !(self.unit.scale == Scale::Counts && matches!(self.counts, Counts::Log { .. }))
    }

    /// The pressure in Pa from which on an integer shows its highest number; `None` for a float.
    ///
    /// ```
    /// use profivac_devices::bcg450::table::MODEL;
    /// use profivac_devices::model::{Counts, NumberType, PressureFormat};
    ///
    /// let unit = MODEL.unit_named("Micron").ok_or("no such unit")?;
    /// let (number, counts) = (NumberType::Integer, Counts::Linear { per_mbar: 1.0 });
    /// let format = PressureFormat { unit, number, counts, max_integer: MODEL.max_integer };
    /// assert!(format.integer_end_pa().is_some_and(|pa| (pa / 100.0 - 43.686).abs() < 1e-3));
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    #[must_use]
    pub fn integer_end_pa(&self) -> Option<f64> {
        match self.number {
            NumberType::Integer => self.pa_from_number(self.max_integer.into()),
            NumberType::Float => None,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    static MBAR: Unit = Unit { code: 1308, name: "mbar", alias: "hPa", scale: Scale::PerMbar(1.0) };
    static COUNTS: Unit = Unit { code: 1001, name: "COUNTS", alias: "counts", scale: Scale::Counts };

    /// A difference from 100 mbar, with 1000 counts for a decade and 5000 at 1 mbar.
    const fn distance(upwards: bool) -> PressureFormat {
        let counts = Counts::Distance { per_decade: 1000.0, at_1_mbar: 5000.0, from_mbar: 100.0, upwards };
        PressureFormat { unit: &COUNTS, number: NumberType::Float, counts, max_integer: 32767 }
    }

    #[test]
    fn an_infinite_difference_is_refused() {
        for upwards in [true, false] {
            assert_eq!(distance(upwards).decode(&f32::INFINITY.to_be_bytes()), None, "upwards: {upwards}");
        }
    }

    #[test]
    fn a_difference_in_counts_is_a_distance_of_logarithms() {
        for (upwards, difference_mbar, counts) in [(true, 900.0, 1000.0), (false, 90.0, 1000.0), (false, 99.0, 2000.0)]
        {
            let format = distance(upwards);
            assert!((format.number_from_pa(mbar(difference_mbar)) - counts).abs() < 1e-9, "{difference_mbar} mbar");
            let pa = format.pa_from_number(counts).unwrap();
            assert!((pa / mbar(difference_mbar) - 1.0).abs() < 1e-9, "{counts} counts are {pa} Pa");
        }
        assert_eq!(distance(true).number_from_pa(0.0), 0.0);
    }

    #[test]
    fn a_difference_that_leads_below_zero_ends_at_zero_counts() {
        assert_eq!(distance(false).number_from_pa(mbar(200.0)), 7000.0);
    }

    const BCG: Counts = Counts::Log { per_decade: 2000.0, at_1_mbar: 25000.0 };

    const fn format(unit: &'static Unit, number: NumberType, counts: Counts, max_integer: u16) -> PressureFormat {
        PressureFormat { unit, number, counts, max_integer }
    }

    /// A pressure in mbar and its COUNTS, for the scales of all manuals.
    const SCALES: [(Counts, f64, f64); 9] = [
        // errata-bpg-bcg-tpg 59 and the limits beside it
        (BCG, 1500.0, 31352.1825),
        (BCG, 5.5e-3, 20480.7254),
        (BCG, 5e-10, 6397.94),
        // HPG400-SP: errata-bpg-bcg-tpg 64, errata-bpg-bcg-tpg 65 and errata-bpg-bcg-tpg 66
        (Counts::Log { per_decade: 4000.0 / 6.0, at_1_mbar: 170_000.0 / 6.0 }, 1000.0, 30333.3333),
        (Counts::Log { per_decade: 16000.0 / 6.0, at_1_mbar: 146_000.0 / 6.0 }, 1e-6, 8333.3333),
        (Counts::Log { per_decade: 2444.0, at_1_mbar: 22999.0 }, 1000.0, 30331.0),
        // errata-pxg55x-img400 81, 82 and 134
        (Counts::Log { per_decade: 3511.0, at_1_mbar: 21139.326 }, 1.0, 21139.326),
        (Counts::Linear { per_mbar: 16.0 }, 1500.0, 24000.0),
        (Counts::Log { per_decade: 4000.0, at_1_mbar: 50000.0 }, 1000.0, 62000.0),
    ];

    #[test]
    fn a_pressure_is_converted_to_the_counts_of_every_scale_and_back() {
        for (scale, pressure, counts) in SCALES {
            let format = format(&COUNTS, NumberType::Float, scale, 32767);
            let number = format.number_from_pa(mbar(pressure));
            assert!((number - counts).abs() < 1e-3, "{pressure} mbar are {number}, not {counts}");
            let back = format.pa_from_number(number).unwrap();
            assert!((back / mbar(pressure) - 1.0).abs() < 1e-12, "{counts} counts are {back} Pa");
        }
    }

    #[test]
    fn zero_is_zero_in_every_unit() {
        for unit in [&MBAR, &COUNTS] {
            let format = format(unit, NumberType::Integer, BCG, 32767);
            assert_eq!(format.encode(0.0).as_slice(), [0, 0]);
            assert_eq!(format.decode(&[0, 0]), Some(0.0));
        }
    }

    /// errata-bpg-bcg-tpg 69: "in Float send the exact value"; 74 for zero.
    #[test]
    fn floats_are_converted_below_zero_counts_too() {
        let format = format(&COUNTS, NumberType::Float, BCG, 32767);
        for (pressure, counts) in [(1e-12, 1000.0), (1e-13, -1000.0), (1e-20, -15000.0), (0.0, 0.0)] {
            assert!((format.number_from_pa(mbar(pressure)) - counts).abs() < 1e-6, "{pressure} mbar");
            let back = format.decode(&(counts as f32).to_be_bytes()).unwrap();
            assert!((back - mbar(pressure)).abs() <= 1e-9 * mbar(pressure), "{counts} counts are {back} Pa");
        }
    }

    #[test]
    fn integers_are_truncated_saturated_and_never_negative() {
        let words = |unit, max_integer, pressure: f64| {
            let octets = format(unit, NumberType::Integer, BCG, max_integer).encode(mbar(pressure));
            u16::from_be_bytes(octets.as_slice().try_into().unwrap())
        };
        assert_eq!(words(&MBAR, 32767, 0.99), 0);
        assert_eq!(words(&MBAR, 32767, 1.99), 1);
        assert_eq!(words(&MBAR, 32767, 1e9), 32767);
        assert_eq!(words(&MBAR, 65535, 1e9), 65535);
        assert_eq!(words(&COUNTS, 32767, 1e-13), 0, "below zero counts");
        assert_eq!(words(&COUNTS, 32767, 5.5e-3), 20480);
    }

    #[test]
    fn every_integer_that_a_master_writes_is_read_back() {
        for unit in [&MBAR, &COUNTS] {
            let format = format(unit, NumberType::Integer, BCG, 32767);
            for word in 0..=u16::MAX {
                let octets = word.to_be_bytes();
                let read = format.decode(&octets).map(|pa| format.encode(pa));
                assert_eq!(read.as_deref(), (word <= 32767).then_some(&octets[..]), "{word} {}", unit.name);
            }
        }
    }

    #[test]
    fn a_number_that_represents_no_pressure_is_rejected() {
        let format = format(&MBAR, NumberType::Float, BCG, 32767);
        for number in [-1e-30, f32::NAN, f32::INFINITY, f32::NEG_INFINITY, f32::MAX] {
            assert_eq!(format.decode(&number.to_be_bytes()), None, "{number}");
        }
        assert_eq!(format.decode(&[0; 2]), None, "too short");
        let counts =
            |counts, number: f32| PressureFormat { unit: &COUNTS, counts, ..format }.decode(&number.to_be_bytes());
        for number in [1e6, -1e6, f32::NAN, f32::INFINITY, f32::NEG_INFINITY] {
            assert_eq!(counts(BCG, number), None, "{number}");
        }
        assert_eq!(counts(Counts::Linear { per_mbar: 16.0 }, -16.0), None);
        let distance = Counts::Distance { per_decade: 1000.0, at_1_mbar: 5000.0, from_mbar: 100.0, upwards: true };
        assert_eq!(counts(distance, -100.0), None);
    }
}
