//! What the referee knows of the token: who has it, and who makes up the ring. profibus-wire 1.13.
//!
//! Only the station with the token begins anything. It has the token because it was given it, because the station it gave
//! the token to was silent for T_SL, or because the line was silent for its T_TO. After a disturbance nobody can know who
//! has the token; the next telegram tells.

use crate::referee::{Rule, Verdict};
use profivac_dp::link::BitTime;

/// A telegram that only a station with the token may send.
#[derive(Clone, Copy, Debug)]
pub(crate) struct TokenUse {
    pub(crate) sa: u8,
    /// To whom the token goes, if it is one.
    pub(crate) token_to: Option<u8>,
    pub(crate) at: BitTime,
    /// How long the line was idle before; nothing if nobody has spoken yet.
    pub(crate) idle_tbit: Option<u64>,
}

/// Follows the token.
#[derive(Clone, Debug, Default)]
pub(crate) struct Token {
    /// Who has it, as far as that can be known.
    holder: Option<u8>,
    /// Who has passed it on, until the holder speaks.
    passed_by: Option<u8>,
    /// The stations that the token has to go around, in the order of their addresses, and from when on.
    ring: Option<(Vec<u8>, BitTime)>,
}

impl Token {
    /// Nobody can know who has the token now.
    pub(crate) const fn forget(&mut self) {
        self.holder = None;
        self.passed_by = None;
    }

    /// From `from` on the token goes around these stations and no others.
    pub(crate) fn expect_ring(&mut self, addresses: &[u8], from: BitTime) {
        let mut addresses = addresses.to_vec();
        addresses.sort_unstable();
        self.ring = Some((addresses, from));
    }

    /// The token may go where it likes.
    pub(crate) fn expect_nothing(&mut self) {
        self.ring = None;
    }

    /// A station begins.
    pub(crate) fn check(&mut self, begun: TokenUse, slot_tbit: u64) -> Verdict {
        let entitled = self.is_entitled(begun, slot_tbit);
        (self.holder, self.passed_by) = match begun.token_to {
            Some(da) => (Some(da), (da != begun.sa).then_some(begun.sa)),
            None => (Some(begun.sa), None),
        };
        match begun.token_to {
            _ if entitled => self.check_ring(begun),
            Some(_) => Err((Rule::SecondToken, 0, 0)),
            None => Err((Rule::NoToken, 0, 0)),
        }
    }

    fn is_entitled(&self, begun: TokenUse, slot_tbit: u64) -> bool {
        let TokenUse { sa, token_to, idle_tbit: Some(idle), .. } = begun else { return true };
        let timeout_tbit = (6 + 2 * u64::from(sa)) * slot_tbit;
        self.holder.is_none_or(|holder| holder == sa)
            || (self.passed_by == Some(sa) && token_to.is_some() && idle >= slot_tbit)
            || idle >= timeout_tbit
    }

    fn check_ring(&self, begun: TokenUse) -> Verdict {
        let (Some((ring, from)), Some(da)) = (&self.ring, begun.token_to) else { return Ok(()) };
        let successor = ring.iter().find(|address| **address > begun.sa).or(ring.first());
        if begun.at < *from || ring.contains(&begun.sa) && successor == Some(&da) {
            return Ok(());
        }
        Err((Rule::Ring, 0, 0))
    }
}
