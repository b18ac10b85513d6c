//! What can go wrong on a cable, by script or by seed.

use crate::noise::Noise;
use crate::random::Random;
use crate::segment::StationId;
use crate::signal::TelegramFault;
use profivac_dp::link::BitTime;

/// A fault, or its end. Two stations at one address need none: attach them. Nor does a station that babbles:
/// [`Babbler`](crate::stations::Babbler).
#[derive(Clone, Debug)]
pub enum Fault {
    /// A station loses (`false`) or gets power. It hears and sends nothing without; what it forgets is its own business.
    Power(StationId, bool),
    /// The whole line is noisy, or quiet again.
    Noise(Option<Noise>),
    /// One station hears noise that others do not.
    NoiseAt(StationId, Option<Noise>),
    /// Something happens to the next telegram of a station.
    Telegram(StationId, TelegramFault),
    /// Octets are lost and added now and then, or not any more.
    OctetErrors(Option<OctetErrors>),
    /// A stub without terminator: everybody, the sender included, hears everything once more so many bit times later.
    Echo(Option<u64>),
    /// The cable is cut in front of everything from this position on, or mended.
    Cut(Option<u64>),
}

/// Octets that are lost and added at random.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct OctetErrors {
    /// The same seed loses and adds the same octets.
    pub seed: u64,
    /// The probability for each octet to be lost.
    pub loss: f64,
    /// The probability for another octet to appear in front of it.
    pub insertion: f64,
}

impl OctetErrors {
    /// What happens to a telegram that begins at `now`.
    pub(crate) fn draw(&self, now: BitTime, octets: &[u8], tampers: &mut Vec<TelegramFault>) {
        let mut random = Random::new(self.seed ^ now.0.wrapping_mul(0xA076_1D64_78BD_642F));
        for (place, present) in octets.iter().enumerate().rev() {
            if random.fraction() < self.loss {
                tampers.push(TelegramFault::Lose(place));
            }
            if random.fraction() < self.insertion {
                // Not the octet that follows anyway: before the last one it would complete the telegram an octet early, and
                // the answer to it would be called too early.
                let added = random.octet();
                tampers.push(TelegramFault::Insert(place, if added == *present { !added } else { added }));
            }
        }
    }
}
