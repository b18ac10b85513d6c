//! The request whose answer is prepared: the next Data_Exchange of the owner.
//!
//! In the idle time after an answer the slave encodes the next one. If the request comes that is expected, the slave takes over the outputs
//! and returns the octets that are ready. Every other telegram takes the general way. Both ways give the same answers
//! and the same states, because whatever could make a difference drops the prepared answer:
//!
//! | What happens | Where it is dropped |
//! |---|---|
//! | another request, a repetition, a broadcast | [`Expected::is_touched_by`] |
//! | watchdog or connection expires | [`Expected::lasts_at`] |
//! | the device is changed | `Slave::device_mut` |
//! | power, rate, address, end of data exchange | the functions of `Slave` |
//! | outputs that change the inputs | `Device::keeps_inputs` |

use crate::link::BitTime;
use profivac_wire::{BROADCAST, DataTelegram, Telegram};

/// The expected request.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Expected {
    /// From this time on a timer has expired, and nothing is expected; 0 if nothing is expected at all.
    until: BitTime,
    fc: u8,
    da: u8,
    sa: u8,
    /// The length of the outputs.
    outputs: u8,
}

impl Expected {
    pub(super) const NOTHING: Self = Self { until: BitTime(0), fc: 0, da: 0, sa: 0, outputs: 0 };

    /// `request` with outputs of this length, before the next timer expires.
    pub(super) fn new(request: &DataTelegram<'_>, outputs: u8, until: Option<BitTime>) -> Self {
        Self { until: until.unwrap_or(BitTime(u64::MAX)), fc: request.fc, da: request.da, sa: request.sa, outputs }
    }

    /// Nothing is expected any more.
    #[inline]
    pub(super) const fn clear(&mut self) {
        self.until = BitTime(0);
    }

    pub(super) const fn is_nothing(&self) -> bool {
        self.until.0 == 0
    }

    /// Whether no timer has expired at `now`.
    #[inline]
    pub(super) fn lasts_at(&self, now: BitTime) -> bool {
        now < self.until
    }

    /// The outputs in `telegram`, if it is the expected request. Asked only while something is expected.
    #[inline]
    pub(super) fn outputs_in<'a>(&self, telegram: &Telegram<'a>) -> Option<&'a [u8]> {
        let Telegram::Data(DataTelegram { da, sa, dsap: None, ssap: None, fc, du }) = telegram else { return None };
        let is_expected = (*fc, *da, *sa) == (self.fc, self.da, self.sa) && du.len() == usize::from(self.outputs);
        is_expected.then_some(*du)
    }

    /// Whether a telegram that is not the expected one may change the answer to it: one to this station or to all.
    pub(super) fn is_touched_by(&self, telegram: &Telegram<'_>) -> bool {
        matches!(telegram, Telegram::Data(frame) if frame.da == self.da || frame.da == BROADCAST)
    }
}
