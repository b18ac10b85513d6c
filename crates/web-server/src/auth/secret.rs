//! Random numbers of the operating system, for session identifiers and tokens.

use ring::digest::{SHA256, digest};
use serde::{Deserialize, Serialize};
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
        Ok(Self(hexadecimal(&octets)))
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

    /// What the station keeps of a session identifier.
    #[must_use]
    pub fn digest(&self) -> SecretDigest {
        SecretDigest::of(&self.0)
    }

    /// The token of the session with this identifier, which need not be kept. Neither the identifier follows from it, nor the token from
    /// the [digest](Self::digest).
    #[must_use]
    pub fn session_token(&self) -> Self {
        Self(SecretDigest::of(&format!("x-csrf-token {}", self.0)).0)
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

/// The SHA-256 of a secret as 64 hexadecimal digits. A file with it is of no use to a thief: the secret has 256 random bits or is an argon2id
/// hash.
#[derive(Clone, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
pub struct SecretDigest(String);

impl SecretDigest {
    /// The digest of a text.
    #[must_use]
    pub fn of(secret: &str) -> Self {
        Self(hexadecimal(digest(&SHA256, secret.as_bytes()).as_ref()))
    }

    /// The digits.
    #[must_use]
    pub fn as_str(&self) -> &str {
        &self.0
    }
}

fn hexadecimal(octets: &[u8]) -> String {
    octets.iter().map(|octet| format!("{octet:02x}")).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_digest_and_the_token_of_a_session_identifier_differ_from_it_and_from_each_other() {
        let id = RandomSecret::parse(&"ab".repeat(32)).unwrap();
        let (digest, token) = (id.digest(), id.session_token());
        assert_eq!((&digest, &token), (&id.digest(), &id.session_token()), "they need not be kept");
        assert_eq!(RandomSecret::parse(token.reveal()), Some(token.clone()));
        assert!(digest.0 != id.0 && token.0 != id.0 && digest.0 != token.0);
        // The example of FIPS 180-4.
        assert_eq!(SecretDigest::of("abc").0, "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad");
    }

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
