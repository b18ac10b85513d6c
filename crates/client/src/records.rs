//! Records of a slave, whichever way they are read and written.

use profivac_devices::model::AccessPath;
use profivac_host::session::SessionError;
use profivac_wire::acyclic::{ErrorCode, Negative};
use std::fmt;

/// A way to the records of one slave.
pub trait Records {
    /// Which way it is.
    fn via(&self) -> AccessPath;

    /// Reads a record.
    ///
    /// # Errors
    /// [`RecordError`] says whether the slave refused or nothing came.
    fn read(&mut self, slot: u8, index: u8) -> Result<Vec<u8>, RecordError>;

    /// Writes a record. `Ok` means that the slave has taken it.
    ///
    /// # Errors
    /// As [`read`](Self::read).
    fn write(&mut self, slot: u8, index: u8, octets: &[u8]) -> Result<(), RecordError>;
}

impl<R: Records + ?Sized> Records for Box<R> {
    fn via(&self) -> AccessPath {
        (**self).via()
    }

    fn read(&mut self, slot: u8, index: u8) -> Result<Vec<u8>, RecordError> {
        (**self).read(slot, index)
    }

    fn write(&mut self, slot: u8, index: u8, octets: &[u8]) -> Result<(), RecordError> {
        (**self).write(slot, index, octets)
    }
}

/// Why a record was not read or written.
#[derive(Debug, thiserror::Error)]
pub enum RecordError {
    /// The line.
    #[error(transparent)]
    Session(#[from] SessionError),
    /// The slave refused.
    #[error("{0}")]
    Refused(RefusalCodes),
    /// The slave does not have this way.
    #[error("{0}")]
    Unavailable(String),
    /// Nothing came, or nothing that can be used.
    #[error("{0}")]
    Interrupted(String),
}

/// The codes of a refusal.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct RefusalCodes {
    /// Error_Code_1 of DP-V1, where there is one.
    pub code_1: Option<ErrorCode>,
    /// The manual's own code: that of the parameter channel, and Error_Code_2 of DP-V1.
    pub code: u8,
}

/// The codes of the parameter channel as the manuals word them: tira41d1 2.2.1.1, tira56e1 4.3.3, i9973ber/a 3.2.2.1.
const CODES: [(u8, &str); 10] = [
    (0, "undefined slot"),
    (1, "parameter not changeable"),
    (2, "lower or upper value range limit overflow"),
    (3, "index error"),
    (5, "data type error"),
    (13, "a text cannot be read this way"),
    (17, "instruction not allowed in this state"),
    (18, "other errors"),
    (201, "object state conflict: already in the requested state"),
    (202, "object state conflict: not possible in the present state"),
];

impl RefusalCodes {
    /// Already in the requested state.
    pub const ALREADY: u8 = 201;
    /// Not possible in this state.
    pub const CONFLICT: u8 = 202;
    /// Not allowed in this operating mode.
    pub const MODE: u8 = 17;
    /// Outside the range.
    pub const RANGE: u8 = 2;

    /// The code in the words of the manual.
    #[must_use]
    pub fn text(&self) -> &'static str {
        CODES
            .into_iter()
            .find(|(code, _)| *code == self.code)
            .map_or("a code the manual does not have", |(_, words)| words)
    }
}

impl fmt::Display for RefusalCodes {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match (self.code_1, self.code) {
            // Error_Code_2 need not say anything.
            (Some(code_1), 0) if code_1 != ErrorCode::INVALID_SLOT => write!(f, "{code_1}"),
            (Some(code_1), code) => write!(f, "{code_1}, code {code}: {}", self.text()),
            (None, code) => write!(f, "code {code}: {}", self.text()),
        }
    }
}

impl From<Negative> for RefusalCodes {
    fn from(negative: Negative) -> Self {
        Self { code_1: Some(negative.code_1), code: negative.code_2 }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_refusal_is_told_in_the_manuals_words() {
        let refused = |code_1, code| RefusalCodes { code_1, code }.to_string();
        assert_eq!(
            refused(Some(ErrorCode::STATE_CONFLICT), 17),
            "state conflict (B5), code 17: instruction not allowed in this state"
        );
        assert_eq!(refused(None, 3), "code 3: index error");
        assert_eq!(refused(Some(ErrorCode::INVALID_SLOT), 0), "invalid slot (B2), code 0: undefined slot");
        assert_eq!(refused(Some(ErrorCode::READ_ERROR), 0), "read error (A0)");
        assert_eq!(refused(None, 99), "code 99: a code the manual does not have");
    }
}
