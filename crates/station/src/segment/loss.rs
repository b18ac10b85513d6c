//! Why a slave of the station's master gives no data.

use super::moment::Moment;
use profivac_dp::link::active::Failure;
use profivac_dp::master::ExchangeError;
use profivac_host::session::BusMaster;
use profivac_recorder::validity::MAX_SILENCE;

/// When the station looked for data of a slave last.
#[derive(Clone, Copy, Debug)]
pub struct Looked(Moment);

impl Looked {
    /// A slave that is looked for from now on.
    pub const fn begin(now: Moment) -> Self {
        Self(now)
    }

    /// The station looks `now`. Returns whether it has looked all the time: the silence of a slave while the station itself stood still says
    /// nothing about the slave.
    pub fn looks(&mut self, now: Moment) -> bool {
        now.since(std::mem::replace(&mut self.0, now)) < MAX_SILENCE
    }
}

/// The reason why a slave without valid inputs gives none; `None` while the master brings it into data exchange. A master needs several
/// rounds until it gives a silent slave up, which takes many seconds on a dead line, so a slave that has exchanged data and `is_silent` for
/// too long does not answer.
pub fn reason(master: &BusMaster, address: u8, is_silent: bool) -> Option<ExchangeError> {
    master.exchange_error(address).or_else(|| is_silent.then_some(ExchangeError::NoAnswer(Failure::Silence)))
}
