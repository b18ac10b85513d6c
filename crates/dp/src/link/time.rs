//! Bit times and the ten transmission rates. profibus-wire 1.1 and 1.12.

use core::fmt;
use core::ops::{Add, Sub};

/// One character: start bit, eight data bits, even parity, stop bit.
pub const CHARACTER_TBIT: u64 = 11;

/// T_SYN: the idle time before every request.
pub const T_SYN_TBIT: u64 = 33;

/// A point in time, in bit times since an origin that the caller chooses. A duration is a plain number of bit times (`_tbit`).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct BitTime(pub u64);

impl Add<u64> for BitTime {
    type Output = Self;

    /// Later by `tbit`. Saturates at the greatest time instead of wrapping.
    fn add(self, tbit: u64) -> Self {
        Self(self.0.saturating_add(tbit))
    }
}

impl Sub for BitTime {
    type Output = u64;

    /// The bit times since `earlier`, 0 if it is later.
    fn sub(self, earlier: Self) -> u64 {
        self.0.saturating_sub(earlier.0)
    }
}

impl fmt::Display for BitTime {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.0.fmt(f)
    }
}

/// A transmission rate of RS-485.
///
/// ```
/// use profivac_dp::link::{Baud, BitTime};
///
/// let baud = Baud::B19200;
/// assert_eq!((baud.bits_per_second(), Baud::from_bits_per_second(19_200)), (19_200, Some(baud)));
/// assert_eq!((baud.tbit_of_ms(10), baud.tbit_of_us(10_000)), (192, 192));
/// assert_eq!((baud.max_tsdr_tbit(), baud.default_slot_tbit()), (60, 100));
/// assert_eq!(BitTime(1000) + baud.tbit_of_ms(10), BitTime(1192));
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Baud {
    /// 9.6 kbit/s
    B9600,
    /// 19.2 kbit/s
    B19200,
    /// 45.45 kbit/s
    B45450,
    /// 93.75 kbit/s
    B93750,
    /// 187.5 kbit/s
    B187500,
    /// 500 kbit/s
    B500000,
    /// 1.5 Mbit/s
    B1500000,
    /// 3 Mbit/s
    B3000000,
    /// 6 Mbit/s
    B6000000,
    /// 12 Mbit/s
    B12000000,
}

impl Baud {
    /// All rates, slowest first.
    pub const ALL: [Self; 10] = [
        Self::B9600,
        Self::B19200,
        Self::B45450,
        Self::B93750,
        Self::B187500,
        Self::B500000,
        Self::B1500000,
        Self::B3000000,
        Self::B6000000,
        Self::B12000000,
    ];

    /// Bits per second.
    #[must_use]
    pub const fn bits_per_second(self) -> u32 {
        match self {
            Self::B9600 => 9_600,
            Self::B19200 => 19_200,
            Self::B45450 => 45_450,
            Self::B93750 => 93_750,
            Self::B187500 => 187_500,
            Self::B500000 => 500_000,
            Self::B1500000 => 1_500_000,
            Self::B3000000 => 3_000_000,
            Self::B6000000 => 6_000_000,
            Self::B12000000 => 12_000_000,
        }
    }

    /// The rate with this number of bits per second, if PROFIBUS has it.
    #[must_use]
    pub fn from_bits_per_second(rate: u32) -> Option<Self> {
        Self::ALL.into_iter().find(|baud| baud.bits_per_second() == rate)
    }

    /// The number of bit times in `ms` milliseconds, rounded down.
    #[must_use]
    pub const fn tbit_of_ms(self, ms: u64) -> u64 {
        thousandth(ms.saturating_mul(self.bits_per_second() as u64))
    }

    /// The number of bit times in `us` microseconds, rounded down.
    #[must_use]
    pub const fn tbit_of_us(self, us: u64) -> u64 {
        thousandth(thousandth(us.saturating_mul(self.bits_per_second() as u64)))
    }

    /// max T_SDR, the latest start of an answer that a slave of this project declares, in bit times. profibus-wire 1.12; for
    /// 45.45 kbit/s one of the values of profibus-wire 10, point 27.
    #[must_use]
    pub const fn max_tsdr_tbit(self) -> u16 {
        match self {
            Self::B9600 | Self::B19200 | Self::B45450 | Self::B93750 | Self::B187500 => 60,
            Self::B500000 => 100,
            Self::B1500000 => 150,
            Self::B3000000 => 250,
            Self::B6000000 => 450,
            Self::B12000000 => 800,
        }
    }

    /// T_SL, the time in which the first character of an answer must come, in bit times. profibus-wire 1.12.
    #[must_use]
    pub const fn default_slot_tbit(self) -> u16 {
        match self {
            Self::B9600 | Self::B19200 | Self::B93750 | Self::B187500 => 100,
            Self::B45450 => 640,
            Self::B500000 => 200,
            Self::B1500000 => 300,
            Self::B3000000 => 400,
            Self::B6000000 => 600,
            Self::B12000000 => 1000,
        }
    }
}

/// A thousandth, rounded down.
const fn thousandth(value: u64) -> u64 {
    if cfg!(target_pointer_width = "64") { value.div_euclid(1000) } else { thousandth_by_digits(value) }
}

/// A thousandth, rounded down, with divisions of 32 bits: a division of 64 bits takes 900 octets of a program for a microcontroller.
#[cfg_attr(target_pointer_width = "64", allow(dead_code))]
#[inline(never)]
const fn thousandth_by_digits(value: u64) -> u64 {
    let (mut rest, mut quotient, mut remainder) = (value, 0_u64, 0_u32);
    let mut digits = 4_u8;
    while digits > 0 {
        rest = rest.rotate_left(16);
        let part = remainder << 16 | rest as u32 & 0xFFFF;
        quotient = quotient << 16 | part.div_euclid(1000) as u64;
        remainder = part.rem_euclid(1000);
        digits = digits.saturating_sub(1);
    }
    quotient
}

impl fmt::Display for Baud {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::B9600 => "9.6 kbit/s",
            Self::B19200 => "19.2 kbit/s",
            Self::B45450 => "45.45 kbit/s",
            Self::B93750 => "93.75 kbit/s",
            Self::B187500 => "187.5 kbit/s",
            Self::B500000 => "500 kbit/s",
            Self::B1500000 => "1.5 Mbit/s",
            Self::B3000000 => "3 Mbit/s",
            Self::B6000000 => "6 Mbit/s",
            Self::B12000000 => "12 Mbit/s",
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn time_neither_wraps_nor_panics() {
        assert_eq!(BitTime(u64::MAX) + 1, BitTime(u64::MAX));
        assert_eq!(BitTime(3) - BitTime(5), 0);
        assert_eq!(BitTime(5) - BitTime(3), 2);
    }

    #[test]
    fn a_division_by_digits_agrees_with_that_of_the_processor() {
        let mut value = u64::MAX;
        while value > 0 {
            for value in [value, value - 1, value / 1000 * 1000] {
                assert_eq!(thousandth_by_digits(value), value / 1000, "{value}");
            }
            value = value / 3 * 2;
        }
    }

    #[test]
    fn rates_convert_both_ways() {
        for baud in Baud::ALL {
            assert_eq!(Baud::from_bits_per_second(baud.bits_per_second()), Some(baud));
        }
        assert_eq!(Baud::from_bits_per_second(115_200), None);
        assert_eq!(Baud::B19200.tbit_of_ms(10), 192);
        assert_eq!(Baud::B12000000.tbit_of_us(100), 1200);
    }

    #[test]
    fn the_slot_time_leaves_room_for_the_latest_answer() {
        for baud in Baud::ALL {
            assert!(baud.max_tsdr_tbit() + 15 <= baud.default_slot_tbit(), "{baud}");
        }
    }
}
