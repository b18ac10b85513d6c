//! The bus parameters of an active station. profibus-wire 1.12.

use crate::link::time::{Baud, CHARACTER_TBIT, T_SYN_TBIT};
use core::fmt;

/// The highest address a station can have; 126 is only where slaves wait for one.
const MAX_ADDRESS: u8 = 125;

/// What an active station must know about its bus. All times are in bit times.
///
/// [`new`](Self::new) gives the defaults of a transmission rate; every field may be changed afterwards. A port of an
/// operating system adds milliseconds to every answer: there `slot_tbit` must cover them.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct BusParameters {
    /// TS, the address of this station.
    pub address: u8,
    /// T_SL: how long to wait for the first character of an answer, from the end of the request.
    pub slot_tbit: u32,
    /// min T_SDR: no answer begins earlier.
    pub min_tsdr_tbit: u16,
    /// max T_SDR: no answer begins later.
    pub max_tsdr_tbit: u16,
    /// T_SET: from an event to the reaction to it.
    pub setup_tbit: u16,
    /// T_QUI: how long a transmitter or repeater is deaf after sending.
    pub quiet_tbit: u16,
    /// How often a request is repeated when its answer is missing or damaged.
    pub retry_limit: u8,
    /// G: from one scan of the GAP to the next so many target rotation times pass.
    pub gap_factor: u8,
    /// HSA: the highest address that is asked.
    pub hsa: u8,
    /// T_TR, the target token rotation time.
    pub rotation_tbit: u32,
    /// The idle line after a token to oneself, T_ID1 if nothing is said: who passes the token to himself has received it.
    /// profibus-wire 8.2 and 1.13 count like that, 1.12 and 8.1 have T_ID2 as after other unconfirmed telegrams.
    pub token_idle_tbit: Option<u32>,
}

/// A bus parameter that no bus can have.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct OutOfRange {
    /// What it is, in words.
    pub name: &'static str,
    /// What was given.
    pub given: u32,
    /// The least it can be.
    pub least: u32,
    /// The most it can be.
    pub most: u32,
}

impl fmt::Display for OutOfRange {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { name, given, least, most } = self;
        match most {
            &u32::MAX => write!(f, "{name} must be at least {least}, not {given}"),
            most => write!(f, "{name} must be {least} to {most}, not {given}"),
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
            // free choice: the set one maker uses, since it fits together and admits every slave seen
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

    /// T_ID1: the idle line before a request when an answer was received.
    #[must_use]
    pub fn id1_tbit(&self) -> u64 {
        self.margin_tbit().saturating_add(T_SYN_TBIT).max(u64::from(self.min_tsdr_tbit))
    }

    /// T_ID2: the idle line before a request when the telegram before it was not to be answered.
    #[must_use]
    pub fn id2_tbit(&self) -> u64 {
        self.margin_tbit().saturating_add(T_SYN_TBIT).max(u64::from(self.max_tsdr_tbit))
    }

    /// T_TO: how long the line must be silent before this station takes the token that nobody seems to have.
    #[must_use]
    pub fn timeout_tbit(&self) -> u64 {
        let slots = u64::from(self.address).saturating_add(3).saturating_mul(2);
        u64::from(self.slot_tbit).saturating_mul(slots)
    }

    /// T_GUD: from one scan of the GAP to the next.
    #[must_use]
    pub const fn gap_pause_tbit(&self) -> u64 {
        (self.gap_factor as u64).saturating_mul(self.rotation_tbit as u64)
    }

    /// How long a newcomer listens and then waits until a ring of two masters with these parameters has let it in, if no
    /// visit has more than one message: three rotations to learn the ring, the pause of the GAP, and one
    /// of HSA + 1 addresses per rotation. profibus-wire 1.13.
    #[must_use]
    pub fn entry_tbit(&self) -> u64 {
        // A request without data has 6 characters or, with access points, 11; a token has 3.
        let slot = u64::from(self.slot_tbit);
        let message = slot.saturating_add(11 * CHARACTER_TBIT);
        let question = slot.saturating_add(6 * CHARACTER_TBIT);
        let token = self.id1_tbit().saturating_add(3 * CHARACTER_TBIT);
        let visit = message.saturating_add(question).saturating_add(token);
        let visits = u64::from(self.hsa).saturating_add(2 + 3);
        self.timeout_tbit().saturating_add(self.gap_pause_tbit()).saturating_add(visit.saturating_mul(visits))
    }

    /// Whether a bus can have these parameters.
    ///
    /// # Errors
    /// The first parameter that is [`OutOfRange`]. The slot time has no upper limit, because ports of operating systems
    /// need more than the 16383 bit times of profibus-wire 1.12 at higher rates (profibus-wire 9.4, point 38).
    pub fn check(&self) -> Result<(), OutOfRange> {
        let reaction = self.margin_tbit().saturating_add(T_SYN_TBIT);
        let reaction = u32::try_from(reaction).unwrap_or(u32::MAX);
        let (min_tsdr, max_tsdr) = (u32::from(self.min_tsdr_tbit), u32::from(self.max_tsdr_tbit));
        for (name, given, least, most) in [
            ("the master's address", u32::from(self.address), 0, u32::from(MAX_ADDRESS)),
            ("the highest station address", u32::from(self.hsa), u32::from(self.address), 126),
            ("max T_SDR", max_tsdr, reaction, 1023),
            ("min T_SDR", min_tsdr, 11, max_tsdr.saturating_sub(1)),
            ("the slot time", self.slot_tbit, max_tsdr.saturating_add(15), u32::MAX),
            ("the retry limit", u32::from(self.retry_limit), 0, 15),
            ("the GAP factor", u32::from(self.gap_factor), 1, 100),
            ("the target rotation time", self.rotation_tbit, 256, 16_777_960),
        ] {
            if !(least..=most).contains(&given) {
                return Err(OutOfRange { name, given, least, most });
            }
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    extern crate std;
    use super::*;
    use std::string::ToString;

    #[test]
    fn the_default_set_is_that_of_the_reference() {
        for (baud, [slot, max_tsdr, setup, quiet, retries, gap, rotation]) in [
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
            assert_eq!(counts, [retries, gap, rotation], "{baud}");
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
            assert_eq!(BusParameters::new(2, baud).check(), Ok(()), "{baud}");
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
