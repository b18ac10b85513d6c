//! The bus parameters of an active station. profibus-wire 1.12.

use crate::link::time::{Baud, CHARACTER_TBIT, T_SYN_TBIT};
use core::fmt;

/// The highest address of a station; slaves wait for an address at 126.
const MAX_ADDRESS: u8 = 125;

/// The bus parameters of an active station. All times are in bit times.
///
/// [`new`](Self::new) gives the defaults of a transmission rate; every field may be changed afterwards, and
/// [`check`](Self::check) checks the ranges. A port of an operating system delays every answer by milliseconds, which
/// `slot_tbit` must include.
///
/// ```
/// use profivac_dp::link::Baud;
/// use profivac_dp::link::active::BusParameters;
///
/// let bus = BusParameters { hsa: 40, ..BusParameters::new(2, Baud::B500000) };
/// let bus = bus.check()?;
/// assert_eq!(bus.get().id1_tbit(), 37);
/// # Ok::<(), profivac_dp::link::active::OutOfRange>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct BusParameters {
    /// TS, the address of this station: 0 to 125.
    pub address: u8,
    /// T_SL: the time in which the first character of an answer must come, from the end of the request. At least max T_SDR + 15.
    pub slot_tbit: u32,
    /// min T_SDR: no answer begins earlier. From 11, below max T_SDR.
    pub min_tsdr_tbit: u16,
    /// max T_SDR: no answer begins later. From T_SYN + T_SM to 1023.
    pub max_tsdr_tbit: u16,
    /// T_SET: from an event to the reaction to it.
    pub setup_tbit: u16,
    /// T_QUI: the time a transmitter or repeater cannot receive after sending.
    pub quiet_tbit: u16,
    /// max_retry_limit: how often the station repeats a request whose answer is missing or damaged, 0 to 15.
    pub retry_limit: u8,
    /// G: the pause between two scans of the GAP, in target rotation times, 1 to 100.
    pub gap_factor: u8,
    /// HSA: the highest address in the GAP, from the own address to 126.
    pub hsa: u8,
    /// T_TR, the target token rotation time: 256 to 16,777,960.
    pub rotation_tbit: u32,
    /// The idle time after a token to itself; `None` is T_ID1, because a station that passes the token to itself has received
    /// it. profibus-wire 8.2 and 1.13 count like that, 1.12 and 8.1 have T_ID2 as after other unconfirmed telegrams.
    pub token_idle_tbit: Option<u32>,
}

/// A bus parameter whose range [`BusParameters::check`] checks.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub enum BusParameter {
    /// TS.
    Address,
    /// HSA.
    HighestAddress,
    /// max T_SDR.
    MaxTsdr,
    /// min T_SDR.
    MinTsdr,
    /// T_SL.
    SlotTime,
    /// max_retry_limit, the number of repetitions.
    RetryLimit,
    /// G.
    GapFactor,
    /// T_TR.
    RotationTime,
}

impl fmt::Display for BusParameter {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Address => "the master's address",
            Self::HighestAddress => "the highest station address",
            Self::MaxTsdr => "max T_SDR",
            Self::MinTsdr => "min T_SDR",
            Self::SlotTime => "the slot time",
            Self::RetryLimit => "the retry limit",
            Self::GapFactor => "the GAP factor",
            Self::RotationTime => "the target rotation time",
        })
    }
}

/// A bus parameter is outside its range.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct OutOfRange {
    /// The parameter.
    pub parameter: BusParameter,
    /// The given value.
    pub given: u32,
    /// The least value possible.
    pub least: u32,
    /// The greatest value possible; `u32::MAX` if there is no limit.
    pub most: u32,
}

impl fmt::Display for OutOfRange {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { parameter, given, least, most } = self;
        match most {
            &u32::MAX => write!(f, "{parameter} must be at least {least}, not {given}"),
            most => write!(f, "{parameter} must be {least} to {most}, not {given}"),
        }
    }
}

impl core::error::Error for OutOfRange {}

impl BusParameters {
    /// The defaults for a station at `address`, profibus-wire 1.12.
    #[must_use]
    pub const fn new(address: u8, baud: Baud) -> Self {
        let (max_tsdr_tbit, setup_tbit, quiet_tbit, retry_limit, gap_factor, rotation_tbit) = match baud {
            Baud::B9600 | Baud::B19200 | Baud::B93750 | Baud::B187500 => (60, 1, 0, 1, 1, 50_000),
            // chosen: the set one maker uses, since it fits together and admits every slave seen
            // (profibus-wire 10, point 27)
            Baud::B45450 => (400, 95, 0, 1, 1, 50_000),
            Baud::B500000 => (100, 1, 0, 1, 1, 100_000),
            Baud::B1500000 => (150, 1, 0, 1, 10, 300_000),
            Baud::B3000000 => (250, 4, 3, 2, 10, 600_000),
            Baud::B6000000 => (450, 8, 6, 3, 10, 1_200_000),
            Baud::B12000000 => (800, 16, 9, 4, 10, 2_400_000),
        };
        Self {
            address,
            slot_tbit: baud.default_slot_tbit() as u32,
            min_tsdr_tbit: 11,
            max_tsdr_tbit,
            setup_tbit,
            quiet_tbit,
            retry_limit,
            gap_factor,
            hsa: 126,
            rotation_tbit,
            token_idle_tbit: None,
        }
    }

    /// T_SM, the safety margin.
    #[must_use]
    pub fn margin_tbit(&self) -> u64 {
        let setup = u64::from(self.setup_tbit);
        setup.saturating_add(setup).saturating_add(u64::from(self.quiet_tbit)).saturating_add(2)
    }

    /// T_ID1: the idle time before a request after an answer was received.
    #[must_use]
    pub fn id1_tbit(&self) -> u64 {
        self.margin_tbit().saturating_add(T_SYN_TBIT).max(u64::from(self.min_tsdr_tbit))
    }

    /// T_ID2: the idle time before a request after a telegram that has no answer.
    #[must_use]
    pub fn id2_tbit(&self) -> u64 {
        self.margin_tbit().saturating_add(T_SYN_TBIT).max(u64::from(self.max_tsdr_tbit))
    }

    /// T_TO: after this idle time the station takes the token, because no other station has it.
    #[must_use]
    pub fn timeout_tbit(&self) -> u64 {
        let slots = u64::from(self.address).saturating_add(3).saturating_mul(2);
        u64::from(self.slot_tbit).saturating_mul(slots)
    }

    /// T_GUD: the time from one scan of the GAP to the next.
    #[must_use]
    pub const fn gap_pause_tbit(&self) -> u64 {
        (self.gap_factor as u64).saturating_mul(self.rotation_tbit as u64)
    }

    /// The longest time until a ring of two masters with these parameters lets a newcomer in, if no visit has more than one
    /// message: three rotations to learn the ring, the pause of the GAP, and one of HSA + 1 addresses per rotation.
    /// profibus-wire 1.13.
    #[must_use]
    pub fn entry_tbit(&self) -> u64 {
        // A request without data has 6 characters or, with access points, 11; a token has 3.
        let slot = u64::from(self.slot_tbit);
        let message = slot.saturating_add(11 * CHARACTER_TBIT);
        let request = slot.saturating_add(6 * CHARACTER_TBIT);
        let token = self.id1_tbit().saturating_add(3 * CHARACTER_TBIT);
        let visit = message.saturating_add(request).saturating_add(token);
        let visits = u64::from(self.hsa).saturating_add(2 + 3);
        self.timeout_tbit().saturating_add(self.gap_pause_tbit()).saturating_add(visit.saturating_mul(visits))
    }

    /// Checks that all parameters are in their ranges.
    ///
    /// # Errors
    /// The first parameter that is [`OutOfRange`]. The slot time has no upper limit, because ports of operating systems
    /// need more than the 16383 bit times of profibus-wire 1.12 at higher rates (profibus-wire 9.4, point 38).
    pub fn check(self) -> Result<CheckedBus, OutOfRange> {
        let reaction = self.margin_tbit().saturating_add(T_SYN_TBIT);
        let reaction = u32::try_from(reaction).unwrap_or(u32::MAX);
        let (min_tsdr, max_tsdr) = (u32::from(self.min_tsdr_tbit), u32::from(self.max_tsdr_tbit));
        for (parameter, given, least, most) in [
            (BusParameter::Address, u32::from(self.address), 0, u32::from(MAX_ADDRESS)),
            (BusParameter::HighestAddress, u32::from(self.hsa), u32::from(self.address), 126),
            (BusParameter::MaxTsdr, max_tsdr, reaction, 1023),
            (BusParameter::MinTsdr, min_tsdr, 11, max_tsdr.saturating_sub(1)),
            (BusParameter::SlotTime, self.slot_tbit, max_tsdr.saturating_add(15), u32::MAX),
            (BusParameter::RetryLimit, u32::from(self.retry_limit), 0, 15),
            (BusParameter::GapFactor, u32::from(self.gap_factor), 1, 100),
            (BusParameter::RotationTime, self.rotation_tbit, 256, 16_777_960),
        ] {
            if !(least..=most).contains(&given) {
                return Err(OutOfRange { parameter, given, least, most });
            }
        }
        Ok(CheckedBus(self))
    }
}

/// Bus parameters that are all in their ranges: [`BusParameters::check`] makes them.
///
/// The state machine relies on the ranges. With a slot time below T_ID1, for instance, it would send into answers.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct CheckedBus(BusParameters);

impl CheckedBus {
    /// The parameters.
    #[must_use]
    pub const fn get(self) -> BusParameters {
        self.0
    }
}

#[cfg(test)]
mod tests {
    extern crate std;
    use super::*;
    use std::string::ToString;

    #[test]
    fn the_default_set_is_that_of_the_reference() {
        for (baud, [slot, max_tsdr, setup, quiet, repetitions, gap, rotation]) in [
            (Baud::B9600, [100, 60, 1, 0, 1, 1, 50_000]),
            (Baud::B19200, [100, 60, 1, 0, 1, 1, 50_000]),
            (Baud::B45450, [640, 400, 95, 0, 1, 1, 50_000]),
            (Baud::B93750, [100, 60, 1, 0, 1, 1, 50_000]),
            (Baud::B187500, [100, 60, 1, 0, 1, 1, 50_000]),
            (Baud::B500000, [200, 100, 1, 0, 1, 1, 100_000]),
            (Baud::B1500000, [300, 150, 1, 0, 1, 10, 300_000]),
            (Baud::B3000000, [400, 250, 4, 3, 2, 10, 600_000]),
            (Baud::B6000000, [600, 450, 8, 6, 3, 10, 1_200_000]),
            (Baud::B12000000, [1000, 800, 16, 9, 4, 10, 2_400_000]),
        ] {
            let bus = BusParameters::new(2, baud);
            let times = [bus.slot_tbit, bus.max_tsdr_tbit.into(), bus.setup_tbit.into(), bus.quiet_tbit.into()];
            assert_eq!(times, [slot, max_tsdr, setup, quiet], "{baud}");
            let counts = [bus.retry_limit.into(), bus.gap_factor.into(), bus.rotation_tbit];
            assert_eq!(counts, [repetitions, gap, rotation], "{baud}");
            assert_eq!((bus.min_tsdr_tbit, bus.hsa), (11, 126), "{baud}");
            assert_eq!(bus.gap_pause_tbit(), u64::from(gap.saturating_mul(rotation)), "{baud}");
        }
    }

    #[test]
    fn the_idle_times_are_those_of_the_reference() {
        for (baud, margin, id1, id2) in [
            (Baud::B9600, 4, 37, 60),
            (Baud::B45450, 192, 225, 400),
            (Baud::B187500, 4, 37, 60),
            (Baud::B500000, 4, 37, 100),
            (Baud::B1500000, 4, 37, 150),
            (Baud::B3000000, 13, 46, 250),
            (Baud::B6000000, 24, 57, 450),
            (Baud::B12000000, 43, 76, 800),
        ] {
            let bus = BusParameters::new(2, baud);
            assert_eq!((bus.margin_tbit(), bus.id1_tbit(), bus.id2_tbit()), (margin, id1, id2), "{baud}");
        }
    }

    #[test]
    fn the_timeout_grows_with_the_address() {
        let timeout = |address| BusParameters::new(address, Baud::B19200).timeout_tbit();
        assert_eq!([timeout(0), timeout(1), timeout(2)], [600, 800, 1000]);
    }

    #[test]
    fn the_defaults_of_every_rate_are_possible() {
        for baud in Baud::ALL {
            assert!(BusParameters::new(2, baud).check().is_ok(), "{baud}");
        }
    }

    #[test]
    fn an_impossible_parameter_is_named_with_its_range() {
        let good = BusParameters::new(2, Baud::B19200);
        for (bad, sentence) in [
            (BusParameters { address: 126, ..good }, "the master's address must be 0 to 125, not 126"),
            (BusParameters { hsa: 1, ..good }, "the highest station address must be 2 to 126, not 1"),
            (BusParameters { slot_tbit: 74, ..good }, "the slot time must be at least 75, not 74"),
            (BusParameters { max_tsdr_tbit: 36, ..good }, "max T_SDR must be 37 to 1023, not 36"),
            (BusParameters { min_tsdr_tbit: 60, ..good }, "min T_SDR must be 11 to 59, not 60"),
            (BusParameters { gap_factor: 0, ..good }, "the GAP factor must be 1 to 100, not 0"),
        ] {
            assert_eq!(bad.check().unwrap_err().to_string(), sentence);
        }
    }
}
