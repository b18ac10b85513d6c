//! Faults of cable and stations, at given times or by seed.

use crate::noise::Noise;
use crate::random::Random;
use crate::signal::TelegramFault;
use crate::station_id::StationId;
use profivac_dp::link::BitTime;

/// A fault, or its end.
///
/// Two further faults are stations: attach two with one address, or a [`Babbler`](crate::stations::Babbler).
#[derive(Clone, Debug)]
pub enum Fault {
    /// Switches the power of a station off (`false`) or on. Without power it neither receives nor sends; its state is kept; a
    /// test resets it if needed.
    Power(StationId, bool),
    /// Noise on the whole line, or `None` to end it.
    Noise(Option<Noise>),
    /// Noise at one station, or `None` to end it.
    NoiseAt(StationId, Option<Noise>),
    /// A fault of the next telegram of a station.
    Telegram(StationId, TelegramFault),
    /// Random loss and insertion of octets, or `None` to end it.
    OctetErrors(Option<OctetErrors>),
    /// A stub without terminator: every station, including the sender, receives each signal again after this delay in bit
    /// times. `None` removes the stub.
    Echo(Option<u64>),
    /// A cut of the cable in front of this position, or `None` to repair it.
    Cut(Option<u64>),
}

/// Octets that are lost and inserted at random.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct OctetErrors {
    /// The same seed gives the same errors.
    pub seed: u64,
    /// The probability of each octet to be lost.
    pub loss: f64,
    /// The probability of an additional octet in front of each octet.
    pub insertion: f64,
}

impl OctetErrors {
    /// Draws the faults of a telegram that begins at `now`.
    pub(crate) fn draw(&self, now: BitTime, octets: &[u8], faults: &mut Vec<TelegramFault>) {
        let mut random = Random::new(self.seed ^ now.0.wrapping_mul(0xA076_1D64_78BD_642F));
        for (index, present) in octets.iter().enumerate().rev() {
            if random.fraction() < self.loss {
                faults.push(TelegramFault::Lose(index));
            }
            if random.fraction() < self.insertion {
                // The inserted octet differs from the next one: otherwise a copy of the last octet would complete the telegram
                // one octet early, and the referee would report the answer as too early.
                let added = random.octet();
                faults.push(TelegramFault::Insert(index, if added == *present { !added } else { added }));
            }
        }
    }
}
