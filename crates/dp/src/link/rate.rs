//! The transmission rate of a passive station: searched, supervised, or fixed. profibus-wire 3.6 and 3.7.
//!
//! The caller sets the port to [`RateControl::rate`], reports every valid telegram and the time, and keeps the transmitter off
//! while the rate is [`Rate::Searching`]. Time is in bit times of that rate. It begins anew, with a new
//! [`Receiver`](super::Receiver), whenever a call reports that the rate changed.

use super::time::{Baud, BitTime, CHARACTER_TBIT};
use profivac_wire::{MAX_TELEGRAM, Telegram};

/// The setting of the port.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Rate {
    /// The station searches at this rate and must not send.
    Searching(Baud),
    /// The bus runs at this rate.
    Found(Baud),
}

impl Rate {
    /// The rate of the port.
    #[must_use]
    pub const fn baud(self) -> Baud {
        match self {
            Self::Searching(baud) | Self::Found(baud) => baud,
        }
    }
}

/// BAUD_SEARCH and BAUD_CONTROL. DP_CONTROL is the watchdog of the slave, which replaces BAUD_CONTROL while it runs.
///
/// ```
/// use profivac_dp::link::{Baud, BitTime, Rate, RateControl};
///
/// let mut control = RateControl::automatic(BitTime(0));
/// assert_eq!(control.rate(), Rate::Searching(Baud::B12000000));
/// // No telegram came: the next slower rate.
/// let deadline = control.wake_at().expect("a search has a deadline");
/// assert!(control.elapse(deadline, false));
/// assert_eq!(control.rate(), Rate::Searching(Baud::B6000000));
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct RateControl {
    rate: Rate,
    /// When the station gives the rate up; `None` if the rate is fixed.
    until: Option<BitTime>,
}

/// How long to listen at one rate, in ms: longer than any pause between two telegrams of a bus (token and GAP pauses).
/// chosen within the usual 100 to 300 ms.
const DWELL_MS: u64 = 300;

/// How long a found rate is valid without a telegram to the station, in ms: 2 x WD_Baud_Control_Val x 10 ms with the greatest
/// value, 255. chosen: the station must not search while a class 2 master reads only now and then.
const CONTROL_MS: u64 = 5_100;

impl RateControl {
    /// A station with a fixed rate.
    #[must_use]
    pub const fn fixed(baud: Baud) -> Self {
        Self { rate: Rate::Found(baud), until: None }
    }

    /// Begins to search at `now`, with the highest rate.
    #[must_use]
    pub fn automatic(now: BitTime) -> Self {
        Self::searching(Baud::B12000000, now)
    }

    fn searching(baud: Baud, now: BitTime) -> Self {
        // The station may begin to listen inside the longest telegram and must receive the next one to its end.
        let telegrams = CHARACTER_TBIT.saturating_mul(2).saturating_mul(MAX_TELEGRAM as u64);
        Self { rate: Rate::Searching(baud), until: Some(now + baud.tbit_of_ms(DWELL_MS) + telegrams) }
    }

    fn found(baud: Baud, now: BitTime) -> Self {
        Self { rate: Rate::Found(baud), until: Some(now + baud.tbit_of_ms(CONTROL_MS)) }
    }

    /// The present setting of the port.
    #[must_use]
    pub const fn rate(&self) -> Rate {
        self.rate
    }

    /// When [`elapse`](Self::elapse) has something to do.
    #[must_use]
    pub const fn wake_at(&self) -> Option<BitTime> {
        self.until
    }

    /// A valid telegram ended at `end` at a station with `address`. Any data telegram confirms a rate that is tried, one to
    /// this station confirms the rate found. Tokens and short acknowledgements prove nothing, because noise may look like
    /// them.
    ///
    /// Returns whether this found the rate.
    pub fn telegram_received(&mut self, end: BitTime, telegram: &Telegram<'_>, address: u8) -> bool {
        let Telegram::Data(data) = telegram else { return false };
        match (self.rate, self.until) {
            (Rate::Searching(baud), _) => {
                *self = Self::found(baud, end);
                true
            }
            (Rate::Found(baud), Some(_)) if data.da == address => {
                *self = Self::found(baud, end);
                false
            }
            (Rate::Found(_), _) => false,
        }
    }

    /// Advances the time to `now`. `watched` means that the watchdog of the slave runs, which then supervises the rate.
    ///
    /// Returns whether the rate changed: the search tries the next rate, or begins because the rate was lost.
    pub fn elapse(&mut self, now: BitTime, watched: bool) -> bool {
        let Some(until) = self.until else { return false };
        match self.rate {
            Rate::Found(baud) if watched => {
                *self = Self::found(baud, now);
                false
            }
            _ if now < until => false,
            Rate::Searching(baud) => {
                *self = Self::searching(slower(baud), BitTime(0));
                true
            }
            // chosen: the search begins at the last rate, so that a station without requests for a while misses one
            // telegram and not all telegrams during a round of all rates.
            Rate::Found(baud) => {
                *self = Self::searching(baud, BitTime(0));
                true
            }
        }
    }
}

/// The next rate to try; after the lowest the highest again.
fn slower(baud: Baud) -> Baud {
    Baud::ALL.into_iter().rev().find(|other| *other < baud).unwrap_or(Baud::B12000000)
}

#[cfg(test)]
mod tests {
    use super::*;
    use profivac_wire::DataTelegram;

    const OTHERS: Telegram<'static> =
        Telegram::Data(DataTelegram { da: 9, sa: 2, dsap: None, ssap: None, fc: 0x49, du: &[] });
    const OURS: Telegram<'static> =
        Telegram::Data(DataTelegram { da: 8, sa: 2, dsap: None, ssap: None, fc: 0x49, du: &[] });

    fn found(baud: Baud) -> RateControl {
        let mut control = RateControl::automatic(BitTime(0));
        while control.rate() != Rate::Searching(baud) {
            let until = control.wake_at().unwrap();
            assert!(!control.elapse(BitTime(until.0.saturating_sub(1)), false));
            assert!(control.elapse(until, false));
        }
        assert!(control.telegram_received(BitTime(100), &OTHERS, 8));
        control
    }

    #[test]
    fn every_rate_is_tried_from_the_highest_down_and_around() {
        let mut control = RateControl::automatic(BitTime(0));
        for baud in Baud::ALL.into_iter().rev().chain([Baud::B12000000]) {
            assert_eq!(control.rate(), Rate::Searching(baud));
            assert!(control.elapse(control.wake_at().unwrap(), false));
        }
    }

    #[test]
    fn at_each_rate_it_listens_300_ms_and_the_longest_telegram_twice() {
        let mut control = RateControl::automatic(BitTime(0));
        assert_eq!(control.wake_at(), Some(BitTime(3_600_000 + 5610)));
        control.elapse(BitTime(3_605_610), false);
        assert_eq!(control.wake_at(), Some(BitTime(1_800_000 + 5610)));
    }

    #[test]
    fn a_telegram_of_any_station_finds_the_rate() {
        for baud in Baud::ALL {
            assert_eq!(found(baud).rate(), Rate::Found(baud));
        }
    }

    #[test]
    fn tokens_and_short_acknowledgements_prove_nothing() {
        let mut control = RateControl::automatic(BitTime(0));
        assert!(!control.telegram_received(BitTime(100), &Telegram::ShortAck, 8));
        assert!(!control.telegram_received(BitTime(200), &Telegram::Token { da: 8, sa: 2 }, 8));
        assert_eq!(control.rate(), Rate::Searching(Baud::B12000000));
    }

    #[test]
    fn telegrams_to_the_station_keep_the_rate_and_others_do_not() {
        let mut control = found(Baud::B19200);
        let lost = |from: u64| BitTime(from + 19_200 * 51 / 10);
        assert_eq!(control.wake_at(), Some(lost(100)));
        assert!(!control.telegram_received(BitTime(5000), &OTHERS, 8));
        assert_eq!(control.wake_at(), Some(lost(100)));
        assert!(!control.telegram_received(BitTime(5000), &OURS, 8));
        assert_eq!(control.wake_at(), Some(lost(5000)));
        assert!(!control.elapse(BitTime(lost(5000).0 - 1), false));
        assert!(control.elapse(lost(5000), false));
        assert_eq!(control.rate(), Rate::Searching(Baud::B19200));
    }

    #[test]
    fn while_the_watchdog_runs_the_rate_is_kept() {
        let mut control = found(Baud::B19200);
        assert!(!control.elapse(BitTime(1_000_000), true));
        assert_eq!(control.rate(), Rate::Found(Baud::B19200));
        assert!(!control.elapse(BitTime(1_000_001), false), "when it ends, the time begins");
        assert!(control.elapse(BitTime(1_000_000 + 97_920), false));
    }

    #[test]
    fn a_fixed_rate_is_never_given_up() {
        let mut control = RateControl::fixed(Baud::B500000);
        assert!(!control.elapse(BitTime(u64::MAX), false));
        assert!(!control.telegram_received(BitTime(u64::MAX), &OURS, 8));
        assert_eq!((control.rate(), control.wake_at()), (Rate::Found(Baud::B500000), None));
    }
}
