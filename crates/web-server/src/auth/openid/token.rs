//! The ID token: who logged in, for which client, signed by the provider (OpenID Connect Core 1.0, 2 and 3.1.3.7).

use super::keys::{Algorithm, Keys, Verdict};
use super::pending;
use crate::auth::secret::RandomSecret;
use base64::Engine;
use base64::engine::general_purpose::URL_SAFE_NO_PAD;
use serde::Deserialize;
use serde_json::{Map, Value};

/// The clocks of provider and station may differ by this, in seconds. chosen: computers without NTP are off by less.
const CLOCK_SKEW_S: f64 = 60.0;

/// The longest ID token, in octets. chosen: Entra ID lists up to 200 groups, each with 36 characters.
const MAX_TOKEN: usize = 32 << 10;

/// The most characters of a value that an error repeats.
const MAX_SHOWN: usize = 120;

/// The claims of a token.
pub type Claims = Map<String, Value>;

/// Why an ID token is refused.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum TokenProblem {
    /// It is no signed token.
    #[error("expected a signed ID token of at most {MAX_TOKEN} octets")]
    Malformed,
    /// It is not signed, signed with a shared secret, or with an algorithm that the station does not know.
    #[error(
        "expected an ID token signed with RS256, RS384, RS512, PS256, PS384, PS512, ES256, ES384 or EdDSA, found {0:?}"
    )]
    Algorithm(String),
    /// The provider does not publish the key.
    #[error("expected an ID token signed with a key that the provider publishes")]
    UnknownKey,
    /// The signature is wrong.
    #[error("the signature of the ID token is wrong")]
    Signature,
    /// A claim is missing, or has another type.
    #[error("expected the claim {0} in the ID token")]
    Missing(&'static str),
    /// Another issuer.
    #[error("expected an ID token of {expected:?}, found one of {found:?}")]
    Issuer {
        /// The issuer of the station's file.
        expected: String,
        /// That of the token.
        found: String,
    },
    /// The provider names no client.
    #[error(
        "the audience (aud) of the ID token is empty: expected {0:?}; add the station as an audience of its client at the provider"
    )]
    NoAudience(String),
    /// Another client.
    #[error("the ID token is for another client than {0:?}")]
    Audience(String),
    /// The token has expired, or was issued in the future or too long ago.
    #[error(
        "the ID token is not valid now: {claim} is {difference:.0} s from the clock of the station; check the clocks of both computers"
    )]
    Time {
        /// The claim.
        claim: &'static str,
        /// Its time minus that of the station, in seconds.
        difference: f64,
    },
    /// The token belongs to another login.
    #[error("the ID token belongs to another login")]
    Nonce,
}

/// A token in its three parts.
pub struct SignedToken<'a> {
    message: &'a str,
    algorithm: Algorithm,
    key: Option<String>,
    claims: Claims,
    signature: Vec<u8>,
}

#[derive(Deserialize)]
struct HeaderJson {
    alg: String,
    kid: Option<String>,
    crit: Option<Value>,
}

impl<'a> SignedToken<'a> {
    /// Parses the compact form: header, claims and signature. Nothing of it is trusted before [`Self::verify`].
    ///
    /// # Errors
    /// [`TokenProblem`].
    pub fn parse(text: &'a str) -> Result<Self, TokenProblem> {
        let malformed = || TokenProblem::Malformed;
        if text.len() > MAX_TOKEN {
            return Err(malformed());
        }
        let (message, signature) = text.rsplit_once('.').ok_or_else(malformed)?;
        let (header, claims) = message.split_once('.').ok_or_else(malformed)?;
        let decode = |part: &str| URL_SAFE_NO_PAD.decode(part).map_err(|_| malformed());
        let HeaderJson { alg, kid, crit } =
            serde_json::from_slice(&decode(header)?).map_err(|_| TokenProblem::Malformed)?;
        let shown = || alg.chars().take(MAX_SHOWN).collect();
        let algorithm = Algorithm::parse(&alg).ok_or_else(|| TokenProblem::Algorithm(shown()))?;
        if crit.is_some() {
            // It demands an extension (RFC 7515, 4.1.11), and the station has none.
            return Err(malformed());
        }
        let claims = serde_json::from_slice(&decode(claims)?).map_err(|_| TokenProblem::Malformed)?;
        Ok(Self { message, algorithm, key: kid, claims, signature: decode(signature)? })
    }

    /// Checks the signature.
    #[must_use]
    pub fn verify(&self, keys: &Keys) -> Verdict {
        keys.verify(self.algorithm, self.key.as_deref(), self.message.as_bytes(), &self.signature)
    }

    /// Whether it names its key.
    #[must_use]
    pub const fn names_key(&self) -> bool {
        self.key.is_some()
    }

    /// The claims of a token whose signature is right, if it is for this login.
    ///
    /// # Errors
    /// [`TokenProblem`].
    pub fn into_claims(self, expected: &Expected<'_>) -> Result<Claims, TokenProblem> {
        expected.check(&self.claims)?;
        Ok(self.claims)
    }
}

/// What a token must say.
pub struct Expected<'a> {
    /// The provider.
    pub issuer: &'a str,
    /// The station's identifier at the provider.
    pub client_id: &'a str,
    /// The number of this login.
    pub nonce: &'a RandomSecret,
    /// The clock of the station, in seconds since 1970.
    pub now: f64,
}

impl Expected<'_> {
    fn check(&self, claims: &Claims) -> Result<(), TokenProblem> {
        let text = |name| claims.get(name).and_then(Value::as_str).ok_or(TokenProblem::Missing(name));
        let time = |name| claims.get(name).and_then(Value::as_f64).ok_or(TokenProblem::Missing(name));
        let issuer = text("iss")?;
        if issuer != self.issuer {
            let found = issuer.chars().take(MAX_SHOWN).collect();
            return Err(TokenProblem::Issuer { expected: self.issuer.to_owned(), found });
        }
        self.check_audience(claims)?;
        let issued_at = time("iat")?;
        self.check_time("exp", time("exp")?, 0.0..=f64::MAX)?;
        self.check_time("iat", issued_at, -pending::LIFETIME.as_secs_f64()..=0.0)?;
        if claims.contains_key("nbf") {
            self.check_time("nbf", time("nbf")?, f64::MIN..=0.0)?;
        }
        if !self.nonce.matches(text("nonce")?.as_bytes()) {
            return Err(TokenProblem::Nonce);
        }
        Ok(())
    }

    /// A token for several clients names the one that asked for it.
    fn check_audience(&self, claims: &Claims) -> Result<(), TokenProblem> {
        let is_own = |value: &Value| value.as_str() == Some(self.client_id);
        let azp = claims.get("azp");
        let names_no_client = |value: &Value| match value {
            Value::Array(all) => all.is_empty(),
            Value::String(one) => one.is_empty(),
            other => other.is_null(),
        };
        if claims.get("aud").is_some_and(names_no_client) {
            return Err(TokenProblem::NoAudience(self.client_id.to_owned()));
        }
        let is_for_this_client = match claims.get("aud").ok_or(TokenProblem::Missing("aud"))? {
            Value::Array(all) if all.len() > 1 => all.iter().any(is_own) && azp.is_some(),
            Value::Array(all) => all.iter().any(is_own),
            one => is_own(one),
        };
        if is_for_this_client && azp.is_none_or(is_own) {
            return Ok(());
        }
        Err(TokenProblem::Audience(self.client_id.to_owned()))
    }

    /// Checks that `time` minus the present is within `permitted`, apart from the difference of the clocks.
    fn check_time(
        &self,
        claim: &'static str,
        time: f64,
        permitted: std::ops::RangeInclusive<f64>,
    ) -> Result<(), TokenProblem> {
        let difference = time - self.now;
        if difference + CLOCK_SKEW_S >= *permitted.start() && difference - CLOCK_SKEW_S <= *permitted.end() {
            return Ok(());
        }
        Err(TokenProblem::Time { claim, difference })
    }
}
