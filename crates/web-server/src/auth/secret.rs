//! Random numbers of the operating system, for session identifiers and tokens.

use std::fmt;
use subtle::ConstantTimeEq;

/// 256 bits.
const OCTETS: usize = 32;

/// A random number of 256 bits as 64 hexadecimal digits: a session identifier, or the token of a session.
#[derive(Clone, PartialEq, Eq, Hash)]
pub struct RandomSecret(String);

impl RandomSecret {
    /// A new random number.
    ///
    /// # Errors
    /// When the operating system supplies no random numbers.
    pub fn new() -> std::io::Result<Self> {
        let mut octets = [0; OCTETS];
        getrandom::fill(&mut octets).map_err(|error| std::io::Error::other(format!("no random numbers: {error}")))?;
        Ok(Self(octets.iter().map(|octet| format!("{octet:02x}")).collect()))
    }

    /// Parses 64 lower-case hexadecimal digits; `None` for any other text.
    #[must_use]
    pub fn parse(text: &str) -> Option<Self> {
        let digits = text.bytes().all(|octet| octet.is_ascii_digit() || (b'a'..=b'f').contains(&octet));
        (digits && text.len() == 2 * OCTETS).then(|| Self(text.to_owned()))
    }

    /// The digits, for the owner of the session only.
    #[must_use]
    pub fn reveal(&self) -> &str {
        &self.0
    }

    /// Compares in constant time.
    #[must_use]
    pub fn matches(&self, given: &[u8]) -> bool {
        self.0.as_bytes().ct_eq(given).into()
    }
}

/// Hides the digits, so that no log contains them.
impl fmt::Debug for RandomSecret {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter.write_str("RandomSecret")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn two_secrets_differ_and_debug_output_hides_them() {
        let (one, other) = (RandomSecret::new().unwrap(), RandomSecret::new().unwrap());
        assert_ne!(one.reveal(), other.reveal());
        assert!(one.matches(one.reveal().as_bytes()) && !one.matches(other.reveal().as_bytes()) && !one.matches(b""));
        assert_eq!(format!("{one:?}"), "RandomSecret");
    }

    #[test]
    fn only_64_lower_case_hexadecimal_digits_are_a_secret() {
        let secret = RandomSecret::new().unwrap();
        assert_eq!(RandomSecret::parse(secret.reveal()), Some(secret.clone()));
        for wrong in ["", "ab", &"g".repeat(64), &"A".repeat(64), &"a".repeat(65), &"ä".repeat(32)] {
            assert_eq!(RandomSecret::parse(wrong), None, "{wrong}");
        }
    }
}
