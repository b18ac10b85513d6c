//! The token rules of the referee: the holder of the token, and the expected ring. profibus-wire 1.13.
//!
//! Only the holder of the token begins a request or passes the token. A station holds the token if it received it, if the
//! station to which it passed the token was silent for T_SL, or if the line was silent for its T_TO. After a disturbance the
//! holder is unknown until the next telegram.

use crate::rule::{Rule, Verdict, violates};
use profivac_dp::link::BitTime;

/// A telegram that only the holder of the token may send.
#[derive(Clone, Copy, Debug)]
pub(crate) struct TokenUse {
    pub(crate) sa: u8,
    /// The receiver of the token, if the telegram is a token.
    pub(crate) token_to: Option<u8>,
    pub(crate) at: BitTime,
    /// The idle time before; `None` for the first telegram.
    pub(crate) idle_tbit: Option<u64>,
}

/// Tracks the token.
#[derive(Clone, Debug, Default)]
pub(crate) struct Token {
    /// The holder; `None` if unknown.
    holder: Option<u8>,
    /// The station that passed the token, until the holder sends.
    passed_by: Option<u8>,
    /// The expected ring in the order of addresses, and the time from which it is expected.
    ring: Option<(Vec<u8>, BitTime)>,
}

impl Token {
    /// Marks the holder as unknown.
    pub(crate) const fn forget(&mut self) {
        self.holder = None;
        self.passed_by = None;
    }

    /// Expects the token to go around exactly these stations from `from` on.
    pub(crate) fn expect_ring(&mut self, addresses: &[u8], from: BitTime) {
        let mut addresses = addresses.to_vec();
        addresses.sort_unstable();
        self.ring = Some((addresses, from));
    }

    /// Accepts any receiver of the token.
    pub(crate) fn expect_nothing(&mut self) {
        self.ring = None;
    }

    /// Checks a telegram of the token holder.
    pub(crate) fn check(&mut self, token_use: TokenUse, slot_tbit: u64) -> Verdict {
        let entitled = self.is_entitled(token_use, slot_tbit);
        (self.holder, self.passed_by) = match token_use.token_to {
            Some(da) => (Some(da), (da != token_use.sa).then_some(token_use.sa)),
            None => (Some(token_use.sa), None),
        };
        match token_use.token_to {
            _ if entitled => self.check_ring(token_use),
            Some(_) => violates(Rule::SecondToken),
            None => violates(Rule::NoToken),
        }
    }

    fn is_entitled(&self, token_use: TokenUse, slot_tbit: u64) -> bool {
        let TokenUse { sa, token_to, idle_tbit: Some(idle), .. } = token_use else { return true };
        let timeout_tbit = (6 + 2 * u64::from(sa)) * slot_tbit;
        self.holder.is_none_or(|holder| holder == sa)
            || (self.passed_by == Some(sa) && token_to.is_some() && idle >= slot_tbit)
            || idle >= timeout_tbit
    }

    fn check_ring(&self, token_use: TokenUse) -> Verdict {
        let (Some((ring, from)), Some(da)) = (&self.ring, token_use.token_to) else { return Ok(()) };
        let successor = ring.iter().find(|address| **address > token_use.sa).or(ring.first());
        if token_use.at < *from || ring.contains(&token_use.sa) && successor == Some(&da) {
            return Ok(());
        }
        violates(Rule::Ring)
    }
}
