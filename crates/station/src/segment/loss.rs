//! Why a slave of the station's master gives no data.

use profivac_dp::link::active::Failure;
use profivac_dp::master::ExchangeError;
use profivac_host::session::BusMaster;

/// The reason why a slave without valid inputs gives none; `None` while the master brings it into data exchange. With the slot time of a
/// network or of a slow adapter the master needs many seconds until it gives a silent slave up, so a slave that has exchanged data, and whose
/// inputs are too old, does not answer.
pub fn reason(master: &BusMaster, address: u8) -> Option<ExchangeError> {
    let silence = || master.exchanged_at(address).map(|_| ExchangeError::NoAnswer(Failure::Silence));
    master.exchange_error(address).or_else(silence)
}
