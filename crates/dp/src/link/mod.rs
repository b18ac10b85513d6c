//! Layer 2: when a station may speak, to whom it listens and what counts as a repetition. profibus-wire 1.

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
pub struct Transmit<'a> {
    /// The first bit must not begin earlier.
    pub not_before: BitTime,
    /// The whole telegram.
    pub octets: &'a [u8],
}

/// Which telegrams a station has to be given.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Listening {
    /// All of them, and every character that completes none: an active station follows the token and its slot time.
    Everything,
    /// Frames to this address and to everybody. A passive station ignores the rest, profibus-wire 1.8, so whoever drives
    /// it may spare it the rest.
    Own(u8),
}

/// Anything that takes part in a bus: a slave or a master.
///
/// Whoever drives a station owns port and clock. It decodes what it hears with a [`Receiver`], hands telegrams over, sends
/// what comes back, and calls [`poll`](Station::poll) when [`wake_at`](Station::wake_at) has come.
pub trait Station {
    /// A valid telegram whose last bit ended at `end`. The answer, if there is one, is to be sent.
    fn telegram(&mut self, end: BitTime, telegram: &Telegram<'_>) -> Option<Transmit<'_>>;

    /// A character ended at `end` which did not complete a valid telegram. The line is busy, no more.
    fn activity(&mut self, _end: BitTime) {}

    /// The telegram this station gave out last has left the line at `end`.
    fn sent(&mut self, _end: BitTime) {}

    /// Time has come to `now`. A passive station only lets its timers expire here.
    fn poll(&mut self, now: BitTime) -> Option<Transmit<'_>>;

    /// When to poll next, if nothing is heard before.
    fn wake_at(&self) -> Option<BitTime>;

    /// What the station has to be given. The address may change with any telegram, the kind never does.
    fn listening(&self) -> Listening {
        Listening::Everything
    }
}
