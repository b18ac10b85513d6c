//! Units, number types, and the numbers that stand for a pressure. Inside a device every pressure is in Pa.

use super::Octets;

/// Pa of so many mbar.
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
    /// What people call it besides.
    pub alias: &'static str,
    /// What one mbar is.
    pub scale: Scale,
}

/// What one mbar is in a unit.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Scale {
    /// So many of it.
    PerMbar(f64),
    /// It depends on the instance: [`Counts`].
    Counts,
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
    /// A difference of pressures, counted on the logarithmic scale from a point to where the difference ends. Both ends
    /// are converted, not the difference itself: errata-pxg55x-img400 32.
    Distance {
        /// Counts for a factor of ten.
        per_decade: f64,
        /// Counts at 1 mbar.
        at_1_mbar: f64,
        /// The point, in mbar.
        from_mbar: f64,
        /// The difference is added to the point, or taken from it.
        upwards: bool,
    },
}

impl Counts {
    fn of(self, mbar: f64) -> f64 {
        match self {
            // Neither 0 nor what is less has a logarithm.
            Self::Log { .. } if mbar <= 0.0 => 0.0,
            Self::Log { per_decade, at_1_mbar } => per_decade * libm::log10(mbar) + at_1_mbar,
            Self::Linear { per_mbar } => per_mbar * mbar,
            Self::Distance { per_decade, at_1_mbar, from_mbar, upwards } => {
                let scale = Self::Log { per_decade, at_1_mbar };
                let end_mbar = if upwards { from_mbar + mbar } else { from_mbar - mbar };
                (scale.of(end_mbar) - scale.of(from_mbar)).abs()
            }
        }
    }

    fn mbar(self, counts: f64) -> f64 {
        match self {
            Self::Log { per_decade, at_1_mbar } => libm::exp10((counts - at_1_mbar) / per_decade),
            Self::Linear { per_mbar } => counts / per_mbar,
            Self::Distance { per_decade, at_1_mbar, from_mbar, upwards } => {
                let scale = Self::Log { per_decade, at_1_mbar };
                let from = scale.of(from_mbar);
                (scale.mbar(if upwards { from + counts } else { from - counts }) - from_mbar).abs()
            }
        }
    }
}

/// How a device writes its pressures: the parameter Data Type.
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
    pub const fn of(code: u8) -> Option<Self> {
        match code {
            3 => Some(Self::Integer),
            8 => Some(Self::Float),
            _ => None,
        }
    }

    /// How many octets a number has.
    #[must_use]
    pub const fn octets(self) -> usize {
        match self {
            Self::Integer => 2,
            Self::Float => 4,
        }
    }
}

/// The highest pressure that is written in every unit without leaving the range of a float.
const HIGHEST_PA: f64 = 1e30;

/// Added before an integer is cut, so that 4.9999999999 written as 5 is read as 5. Far below the one count of
/// errata-bpg-bcg-tpg 69.
const ROUNDING: f64 = 1e-6;

/// How the pressures of one instance look on the wire.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Format {
    /// Data Units.
    pub unit: &'static Unit,
    /// Data Type.
    pub number: NumberType,
    /// The instance's COUNTS.
    pub counts: Counts,
    /// The highest integer: 32767, or 65535 where the manual means an unsigned word.
    pub highest: u16,
}

impl Format {
    /// The number that stands for `pa`.
    #[must_use]
    pub fn number_of(&self, pa: f64) -> f64 {
        let mbar = pa / PA_PER_MBAR;
        match self.unit.scale {
            // No pressure has no logarithm: errata-bpg-bcg-tpg 74.
            _ if pa == 0.0 => 0.0,
            Scale::PerMbar(factor) => mbar * factor,
            Scale::Counts => self.counts.of(mbar),
        }
    }

    /// The pressure in Pa that `number` stands for; `None` for what no pressure can be.
    #[must_use]
    pub fn pa_of(&self, number: f64) -> Option<f64> {
        let mbar = match self.unit.scale {
            _ if number == 0.0 => 0.0,
            Scale::PerMbar(factor) => number / factor,
            Scale::Counts => self.counts.mbar(number),
        };
        let pa = mbar * PA_PER_MBAR;
        // free choice: no manual limits a number that a master may write; below zero and beyond a float in one of the
        // units it is out of range. The same for a number that is none.
        (number >= 0.0 && (0.0..=HIGHEST_PA).contains(&pa)).then_some(pa)
    }

    /// The octets of a pressure: cut to whole units and saturated as an integer (errata-bpg-bcg-tpg 69 and 70).
    #[must_use]
    pub fn encode(&self, pa: f64) -> Octets {
        let number = self.number_of(pa);
        match self.number {
            #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "cut and clamped")]
            NumberType::Integer => {
                let whole = libm::floor(number + ROUNDING).clamp(0.0, f64::from(self.highest));
                Octets::new(&(whole as u16).to_be_bytes())
            }
            #[expect(clippy::cast_possible_truncation, reason = "a float has no more digits")]
            NumberType::Float => Octets::new(&(number as f32).to_be_bytes()),
        }
    }

    /// The pressure in Pa; `None` for another length and for what no pressure can be.
    #[must_use]
    pub fn decode(&self, octets: &[u8]) -> Option<f64> {
        let number = match self.number {
            NumberType::Integer => {
                let word = octets.try_into().map(u16::from_be_bytes).ok()?;
                f64::from(Some(word).filter(|word| *word <= self.highest)?)
            }
            NumberType::Float => octets.try_into().map(f32::from_be_bytes).ok()?.into(),
        };
        self.pa_of(number)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const COUNTS: Unit = Unit { code: 0, name: "COUNTS", alias: "counts", scale: Scale::Counts };

    /// 1000 counts for a decade, 5000 at 1 mbar, seen from 100 mbar.
    const fn distance(upwards: bool) -> Format {
        let counts = Counts::Distance { per_decade: 1000.0, at_1_mbar: 5000.0, from_mbar: 100.0, upwards };
        Format { unit: &COUNTS, number: NumberType::Float, counts, highest: 32767 }
    }

    #[test]
    fn a_difference_in_counts_is_a_distance_of_logarithms() {
        for (upwards, difference_mbar, counts) in [(true, 900.0, 1000.0), (false, 90.0, 1000.0), (false, 99.0, 2000.0)]
        {
            let format = distance(upwards);
            assert!((format.number_of(mbar(difference_mbar)) - counts).abs() < 1e-9, "{difference_mbar} mbar");
            let pa = format.pa_of(counts).unwrap();
            assert!((pa / mbar(difference_mbar) - 1.0).abs() < 1e-9, "{counts} counts are {pa} Pa");
        }
        assert_eq!(distance(true).number_of(0.0), 0.0);
    }

    #[test]
    fn a_difference_that_leads_below_zero_ends_where_the_scale_does() {
        assert_eq!(distance(false).number_of(mbar(200.0)), 7000.0);
    }
}
