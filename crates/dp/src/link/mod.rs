//! Layer 2 (FDL): when a station may send, which telegrams it accepts and which of them are repetitions. profibus-wire 1.

pub mod active;
mod rate;
mod receiver;
mod responder;
mod time;

pub use rate::{Rate, RateControl};
pub use receiver::{Received, Receiver};
pub use responder::{Accepted, Indication, Reply, Responder};
pub use time::{Baud, BitTime, CHARACTER_TBIT, T_SYN_TBIT};

use profivac_wire::Telegram;

/// A telegram to be sent.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Transmit<'a> {
    /// The first bit must not begin earlier.
    pub not_before: BitTime,
    /// The whole telegram.
    pub octets: &'a [u8],
}

/// The telegrams that a station needs.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Listening {
    /// All telegrams, and every character that completes none: an active station follows the token and its slot time.
    Everything,
    /// Telegrams to this address and to all stations. A passive station ignores the rest, profibus-wire 1.8, so the caller
    /// may drop them.
    Own(u8),
}

/// A station of a bus: a slave or a master.
///
/// The caller owns port and clock. It decodes the received octets with a [`Receiver`], passes the telegrams to the station,
/// sends the returned [`Transmit`], and calls [`poll`](Station::poll) when [`wake_at`](Station::wake_at) has come.
pub trait Station {
    /// Processes a valid telegram whose last bit ended at `end`, and returns the answer, if any.
    fn telegram(&mut self, end: BitTime, telegram: &Telegram<'_>) -> Option<Transmit<'_>>;

    /// A character ended at `end` that did not complete a valid telegram: the line is busy.
    fn activity(&mut self, _end: BitTime) {}

    /// The last bit of the telegram that this station returned last has left at `end`.
    fn sent(&mut self, _end: BitTime) {}

    /// Advances the time to `now`. In a passive station only timers expire here.
    fn poll(&mut self, now: BitTime) -> Option<Transmit<'_>>;

    /// When to poll next, if no telegram comes before.
    fn wake_at(&self) -> Option<BitTime>;

    /// The telegrams that the station needs. The address may change with any telegram, the variant never does.
    fn listening(&self) -> Listening {
        Listening::Everything
    }
}
