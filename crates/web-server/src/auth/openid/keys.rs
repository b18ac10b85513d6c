//! The keys with which a provider signs (RFC 7517), and the check of a signature (RFC 7515, 7518, 8037).
//!
//! | Algorithm | Key |
//! |---|---|
//! | RS256, RS384, RS512, PS256, PS384, PS512 | RSA with 2048 to 8192 bits |
//! | ES256, ES384 | ECDSA on P-256, P-384 |
//! | EdDSA | Ed25519 |
//!
//! All others are refused: `none`, and those with a shared secret (HS256), where a public key of the provider would be the secret.

use base64::Engine;
use base64::engine::general_purpose::URL_SAFE_NO_PAD;
use ring::signature::{
    ECDSA_P256_SHA256_FIXED, ECDSA_P384_SHA384_FIXED, ED25519, RSA_PKCS1_2048_8192_SHA256, RSA_PKCS1_2048_8192_SHA384,
    RSA_PKCS1_2048_8192_SHA512, RSA_PSS_2048_8192_SHA256, RSA_PSS_2048_8192_SHA384, RSA_PSS_2048_8192_SHA512,
    RsaParameters, RsaPublicKeyComponents, UnparsedPublicKey,
};
use serde::Deserialize;
use serde_json::Value;

/// The most keys of a provider that are considered. chosen: providers have two or three.
const MAX_KEYS: usize = 32;

/// A signature algorithm that the station knows.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Algorithm {
    /// RSASSA-PKCS1-v1_5 with SHA-256.
    Rs256,
    /// RSASSA-PKCS1-v1_5 with SHA-384.
    Rs384,
    /// RSASSA-PKCS1-v1_5 with SHA-512.
    Rs512,
    /// RSASSA-PSS with SHA-256.
    Ps256,
    /// RSASSA-PSS with SHA-384.
    Ps384,
    /// RSASSA-PSS with SHA-512.
    Ps512,
    /// ECDSA on P-256 with SHA-256.
    Es256,
    /// ECDSA on P-384 with SHA-384.
    Es384,
    /// Ed25519.
    EdDsa,
}

impl Algorithm {
    /// The algorithm of this name; `None` for any other, `none` and those with a shared secret included.
    #[must_use]
    pub fn parse(name: &str) -> Option<Self> {
        match name {
            "RS256" => Some(Self::Rs256),
            "RS384" => Some(Self::Rs384),
            "RS512" => Some(Self::Rs512),
            "PS256" => Some(Self::Ps256),
            "PS384" => Some(Self::Ps384),
            "PS512" => Some(Self::Ps512),
            "ES256" => Some(Self::Es256),
            "ES384" => Some(Self::Es384),
            "EdDSA" => Some(Self::EdDsa),
            _ => None,
        }
    }

    /// The padding and the hash of an algorithm with an RSA key.
    fn rsa(self) -> Option<&'static RsaParameters> {
        match self {
            Self::Rs256 => Some(&RSA_PKCS1_2048_8192_SHA256),
            Self::Rs384 => Some(&RSA_PKCS1_2048_8192_SHA384),
            Self::Rs512 => Some(&RSA_PKCS1_2048_8192_SHA512),
            Self::Ps256 => Some(&RSA_PSS_2048_8192_SHA256),
            Self::Ps384 => Some(&RSA_PSS_2048_8192_SHA384),
            Self::Ps512 => Some(&RSA_PSS_2048_8192_SHA512),
            Self::Es256 | Self::Es384 | Self::EdDsa => None,
        }
    }
}

/// The numbers of a public key.
#[derive(Clone, Debug, PartialEq, Eq)]
enum PublicKey {
    Rsa {
        n: Vec<u8>,
        e: Vec<u8>,
    },
    /// A point without compression.
    P256(Vec<u8>),
    P384(Vec<u8>),
    Ed25519(Vec<u8>),
}

/// A key.
#[derive(Clone, Debug, PartialEq, Eq)]
struct Key {
    id: Option<String>,
    /// The only algorithm that it is for, if it names one.
    algorithm: Option<String>,
    public: PublicKey,
}

#[derive(Deserialize)]
struct KeysJson {
    keys: Vec<Value>,
}

#[derive(Deserialize)]
struct KeyJson {
    kty: String,
    kid: Option<String>,
    #[serde(rename = "use")]
    purpose: Option<String>,
    alg: Option<String>,
    crv: Option<String>,
    n: Option<String>,
    e: Option<String>,
    x: Option<String>,
    y: Option<String>,
}

/// The keys of a provider.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Keys(Vec<Key>);

/// What a check of a signature found.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Verdict {
    /// The provider signed it.
    Right,
    /// No key has this identifier and is for this algorithm.
    UnknownKey,
    /// The signature is not that of the key.
    Wrong,
}

impl Keys {
    /// Parses a set of keys; `None` if it is none. Keys that the station cannot use are left out.
    #[must_use]
    pub fn parse(json: &[u8]) -> Option<Self> {
        let KeysJson { keys } = serde_json::from_slice(json).ok()?;
        Some(Self(keys.into_iter().take(MAX_KEYS).filter_map(key).collect()))
    }

    /// Checks the signature of `message` by the key `id`; without an identifier, by any key for the algorithm.
    #[must_use]
    pub fn verify(&self, algorithm: Algorithm, id: Option<&str>, message: &[u8], signature: &[u8]) -> Verdict {
        let is_candidate = |key: &&Key| {
            let has_id = id.is_none() || key.id.as_deref() == id;
            let is_for = key.algorithm.as_deref().is_none_or(|name| Algorithm::parse(name) == Some(algorithm));
            has_id && is_for && key.fits(algorithm)
        };
        let mut candidates = self.0.iter().filter(is_candidate).peekable();
        if candidates.peek().is_none() {
            return Verdict::UnknownKey;
        }
        let is_right = candidates.any(|key| key.has_signed(algorithm, message, signature));
        if is_right { Verdict::Right } else { Verdict::Wrong }
    }
}

impl Key {
    fn fits(&self, algorithm: Algorithm) -> bool {
        match self.public {
            PublicKey::Rsa { .. } => algorithm.rsa().is_some(),
            PublicKey::P256(_) => algorithm == Algorithm::Es256,
            PublicKey::P384(_) => algorithm == Algorithm::Es384,
            PublicKey::Ed25519(_) => algorithm == Algorithm::EdDsa,
        }
    }

    fn has_signed(&self, algorithm: Algorithm, message: &[u8], signature: &[u8]) -> bool {
        match (algorithm, &self.public) {
            (rsa, PublicKey::Rsa { n, e }) => rsa.rsa().is_some_and(|parameters| {
                RsaPublicKeyComponents { n, e }.verify(parameters, message, signature).is_ok()
            }),
            (Algorithm::Es256, PublicKey::P256(point)) => {
                UnparsedPublicKey::new(&ECDSA_P256_SHA256_FIXED, point).verify(message, signature).is_ok()
            }
            (Algorithm::Es384, PublicKey::P384(point)) => {
                UnparsedPublicKey::new(&ECDSA_P384_SHA384_FIXED, point).verify(message, signature).is_ok()
            }
            (Algorithm::EdDsa, PublicKey::Ed25519(point)) => {
                UnparsedPublicKey::new(&ED25519, point).verify(message, signature).is_ok()
            }
            _ => false,
        }
    }
}

/// A key that the station can use.
fn key(json: Value) -> Option<Key> {
    let json: KeyJson = serde_json::from_value(json).ok()?;
    if json.purpose.as_deref().is_some_and(|purpose| purpose != "sig") {
        return None;
    }
    let octets = |text: &Option<String>| URL_SAFE_NO_PAD.decode(text.as_deref()?).ok();
    let public = match (json.kty.as_str(), json.crv.as_deref()) {
        ("RSA", _) => PublicKey::Rsa { n: without_zeros(octets(&json.n)?), e: without_zeros(octets(&json.e)?) },
        ("EC", Some("P-256")) => PublicKey::P256(point(octets(&json.x)?, octets(&json.y)?, 32)?),
        ("EC", Some("P-384")) => PublicKey::P384(point(octets(&json.x)?, octets(&json.y)?, 48)?),
        ("OKP", Some("Ed25519")) => PublicKey::Ed25519(octets(&json.x)?),
        _ => return None,
    };
    Some(Key { id: json.kid, algorithm: json.alg, public })
}

/// A number without the zeros before it, which some providers write and `ring` refuses.
fn without_zeros(octets: Vec<u8>) -> Vec<u8> {
    octets.into_iter().skip_while(|octet| *octet == 0).collect()
}

/// A point without compression: 4, x, y (SEC 1, 2.3.3).
fn point(x: Vec<u8>, y: Vec<u8>, length: usize) -> Option<Vec<u8>> {
    (x.len() == length && y.len() == length).then(|| [vec![4], x, y].concat())
}

#[cfg(test)]
mod tests {
    use super::*;
    use ring::rand::SystemRandom;
    use ring::signature::{ECDSA_P384_SHA384_FIXED_SIGNING, EcdsaKeyPair, Ed25519KeyPair, KeyPair};
    use serde_json::json;

    const MESSAGE: &[u8] = b"header.claims";

    fn keys(keys: Value) -> Keys {
        Keys::parse(json!({ "keys": keys }).to_string().as_bytes()).unwrap()
    }

    /// The key and the signature of RFC 7515, appendix A.2.
    #[test]
    fn the_example_of_rfc_7515_is_right() {
        let n = "ofgWCuLjybRlzo0tZWJjNiuSfb4p4fAkd_wWJcyQoTbji9k0l8W26mPddxHmfHQp-Vaw-4qPCJrcS2mJPMEzP1Pt0Bm4d4QlL-yRT-SFd2lZS-pC\
                 gNMsD1W_YpRPEwOWvG6b32690r2jZ47soMZo9wGzjb_7OMg0LOL-bSf63kpaSHSXndS5z5rexMdbBYUsLA9e-KXBdQOS-UTo7WTBEMa2R2CapHg66\
                 5xsmtdVMTBQY4uDZlxvb3qCo5ZwKh9kG4LT6_I5IhlJH7aGhyxXFvUK-DWNmoudF8NAco9_h9iaGNj8q2ethFkMLs91kzk2PAcDTW9gb54h4FRWyu\
                 XpoQ";
        let message = "eyJhbGciOiJSUzI1NiJ9.eyJpc3MiOiJqb2UiLA0KICJleHAiOjEzMDA4MTkzODAsDQogImh0dHA6Ly9leGFtcGxlLmNvbS9pc19yb290I\
                       jp0cnVlfQ";
        let signature = "cC4hiUPoj9Eetdgtv3hF80EGrhuB__dzERat0XF9g2VtQgr9PJbu3XOiZj5RZmh7AAuHIm4Bh-0Qc_lF5YKt_O8W2Fp5jujGbds9uJdbF9\
                         CUAr7t1dnZcAcQjbKBYNX4BAynRFdiuB--f_nZLgrnbyTyWzO75vRK5h6xBArLIARNPvkSjtQBMHlb1L07Qe7K0GarZRmB_eSN9383LcO\
                         Ln6_dO--xi12jzDwusC-eOkHWEsqtFZESc6BfI7noOPqvhJ1phCnvWh6IeYI2w9QOYEUipUTI8np6LbgGY9Fs98rqVt5AXLIhWkWywlVm\
                         tVrBp0igcN_IoypGlUPQGe77Rw";
        let signature = URL_SAFE_NO_PAD.decode(signature).unwrap();
        let keys = keys(json!([{ "kty": "RSA", "n": n, "e": "AQAB" }]));
        let verdict = |algorithm, message: &str| keys.verify(algorithm, None, message.as_bytes(), &signature);
        assert_eq!(verdict(Algorithm::Rs256, message), Verdict::Right);
        assert_eq!(verdict(Algorithm::Rs256, &message.replace("joe", "eve").replace('J', "j")), Verdict::Wrong);
        assert_eq!(verdict(Algorithm::Ps256, message), Verdict::Wrong);
        assert_eq!(verdict(Algorithm::Es256, message), Verdict::UnknownKey);
    }

    /// The file has one key and a signature of [`MESSAGE`] for each algorithm, made with OpenSSL.
    #[test]
    fn an_rsa_key_verifies_each_padding_and_hash_and_no_other() {
        let file: Value = serde_json::from_str(include_str!("rsa_signatures.json")).unwrap();
        let keys = keys(json!([file["key"]]));
        for name in ["RS256", "RS384", "RS512", "PS256", "PS384", "PS512"] {
            let algorithm = Algorithm::parse(name).unwrap();
            for (other, signature) in file["signatures"].as_object().unwrap() {
                let signature = URL_SAFE_NO_PAD.decode(signature.as_str().unwrap()).unwrap();
                let expected = if other == name { Verdict::Right } else { Verdict::Wrong };
                assert_eq!(keys.verify(algorithm, None, MESSAGE, &signature), expected, "{name} of {other}");
            }
        }
    }

    #[test]
    fn keys_of_other_curves_verify_too() {
        let random = SystemRandom::new();
        let algorithm = &ECDSA_P384_SHA384_FIXED_SIGNING;
        let document = EcdsaKeyPair::generate_pkcs8(algorithm, &random).unwrap();
        let p384 = EcdsaKeyPair::from_pkcs8(algorithm, document.as_ref(), &random).unwrap();
        let ed25519 = Ed25519KeyPair::from_pkcs8(Ed25519KeyPair::generate_pkcs8(&random).unwrap().as_ref()).unwrap();
        let encode = |octets: &[u8]| URL_SAFE_NO_PAD.encode(octets);
        let point = p384.public_key().as_ref();
        let keys = keys(json!([
            { "kty": "EC", "crv": "P-384", "kid": "a", "x": encode(&point[1..49]), "y": encode(&point[49..]) },
            { "kty": "OKP", "crv": "Ed25519", "kid": "b", "x": encode(ed25519.public_key().as_ref()) },
        ]));
        let signature = p384.sign(&random, MESSAGE).unwrap();
        assert_eq!(keys.verify(Algorithm::Es384, Some("a"), MESSAGE, signature.as_ref()), Verdict::Right);
        assert_eq!(keys.verify(Algorithm::Es384, Some("b"), MESSAGE, signature.as_ref()), Verdict::UnknownKey);
        assert_eq!(keys.verify(Algorithm::Es256, Some("a"), MESSAGE, signature.as_ref()), Verdict::UnknownKey);
        let signature = ed25519.sign(MESSAGE);
        assert_eq!(keys.verify(Algorithm::EdDsa, Some("b"), MESSAGE, signature.as_ref()), Verdict::Right);
        assert_eq!(keys.verify(Algorithm::EdDsa, Some("b"), b"other", signature.as_ref()), Verdict::Wrong);
    }

    #[test]
    fn keys_that_are_short_damaged_or_for_something_else_are_left_out() {
        let x = URL_SAFE_NO_PAD.encode([1; 32]);
        for key in [
            json!({ "kty": "oct", "k": x }),
            json!({ "kty": "EC", "crv": "P-256", "x": x }),
            json!({ "kty": "EC", "crv": "P-256", "x": x, "y": "AA" }),
            json!({ "kty": "EC", "crv": "P-256", "use": "enc", "x": x, "y": x }),
            json!({ "kty": "EC", "crv": "secp256k1", "x": x, "y": x }),
            json!({ "kty": "RSA", "n": "not base64!", "e": "AQAB" }),
            json!(5),
        ] {
            assert_eq!(keys(json!([key])), Keys::default(), "{key}");
        }
        let short = keys(json!([{ "kty": "RSA", "n": URL_SAFE_NO_PAD.encode([0xFF; 128]), "e": "AQAB" }]));
        assert_eq!(short.verify(Algorithm::Rs256, None, MESSAGE, &[1; 128]), Verdict::Wrong, "1024 bits");
        let of_another = keys(json!([{ "kty": "RSA", "alg": "RS512", "n": x, "e": "AQAB" }]));
        assert_eq!(of_another.verify(Algorithm::Rs256, None, MESSAGE, &[]), Verdict::UnknownKey);
        for text in ["", "[]", "{}", "{\"keys\": 5}", "{\"keys\": {}}"] {
            assert_eq!(Keys::parse(text.as_bytes()), None, "{text}");
        }
    }

    #[test]
    fn algorithms_without_a_public_key_are_none() {
        for name in ["none", "HS256", "HS384", "HS512", "RSA-OAEP", "rs256", "RS256 ", ""] {
            assert_eq!(Algorithm::parse(name), None, "{name}");
        }
    }
}
