//! What a provider says about itself: OpenID Connect Discovery 1.0.

use crate::host_name::is_loopback;
use hyper::Uri;
use serde::Deserialize;

/// The longest URL of an endpoint, in octets.
const MAX_URL: usize = 2048;

/// The endpoints of a provider.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Metadata {
    /// Where the browser logs in.
    pub authorization: Uri,
    /// Where the station exchanges the code for the ID token.
    pub token: Uri,
    /// Where the keys are.
    pub keys: Uri,
    /// Where the browser logs out, if the provider has it.
    pub end_session: Option<Uri>,
    /// Whether the secret goes into the body of the request: the provider does not take it in a header.
    pub secret_in_body: bool,
    /// Whether every answer names its issuer (RFC 9207).
    pub names_issuer: bool,
}

/// Why the document is not that of the provider.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum MetadataProblem {
    /// It is not JSON, or a property is missing.
    #[error("expected its description as JSON with issuer, authorization_endpoint, token_endpoint and jwks_uri")]
    Malformed,
    /// It is that of another issuer.
    #[error("expected the issuer {expected:?}, found {found:?}; write the issuer as the provider does")]
    Issuer {
        /// The issuer of the station's file.
        expected: String,
        /// That of the document.
        found: String,
    },
    /// An endpoint is no URL with encryption.
    #[error("expected a URL with https as its {0}")]
    Endpoint(&'static str),
    /// The provider does not know the way that the station uses to prove who it is.
    #[error("expected client_secret_basic or client_secret_post among its token_endpoint_auth_methods_supported")]
    Authentication,
}

#[derive(Deserialize)]
struct MetadataJson {
    issuer: String,
    authorization_endpoint: String,
    token_endpoint: String,
    jwks_uri: String,
    end_session_endpoint: Option<String>,
    token_endpoint_auth_methods_supported: Option<Vec<String>>,
    #[serde(default)]
    authorization_response_iss_parameter_supported: bool,
}

impl Metadata {
    /// The URL of the document of an issuer.
    #[must_use]
    pub fn url(issuer: &str) -> String {
        format!("{}/.well-known/openid-configuration", issuer.trim_end_matches('/'))
    }

    /// Parses the document of the provider `issuer`.
    ///
    /// # Errors
    /// [`MetadataProblem`].
    pub fn parse(json: &[u8], issuer: &str) -> Result<Self, MetadataProblem> {
        let json: MetadataJson = serde_json::from_slice(json).map_err(|_| MetadataProblem::Malformed)?;
        if json.issuer != issuer {
            let found = json.issuer.chars().take(200).collect();
            return Err(MetadataProblem::Issuer { expected: issuer.to_owned(), found });
        }
        // Only a provider on this computer may send the station to this computer without encryption.
        let is_near = issuer.parse::<Uri>().is_ok_and(|issuer| issuer.scheme_str() == Some("http"));
        let url = |name, text: &str| endpoint(text, is_near).ok_or(MetadataProblem::Endpoint(name));
        let methods = json.token_endpoint_auth_methods_supported;
        let knows = |method: &str| methods.as_ref().is_none_or(|all| all.iter().any(|other| other == method));
        let secret_in_body = match (knows("client_secret_basic"), knows("client_secret_post")) {
            (true, _) => false,
            (false, true) => true,
            (false, false) => return Err(MetadataProblem::Authentication),
        };
        Ok(Self {
            authorization: url("authorization_endpoint", &json.authorization_endpoint)?,
            token: url("token_endpoint", &json.token_endpoint)?,
            keys: url("jwks_uri", &json.jwks_uri)?,
            end_session: json.end_session_endpoint.map(|text| url("end_session_endpoint", &text)).transpose()?,
            secret_in_body,
            names_issuer: json.authorization_response_iss_parameter_supported,
        })
    }
}

/// The URL of an endpoint: https, or http on this computer if the provider is there.
fn endpoint(text: &str, is_near: bool) -> Option<Uri> {
    let url: Uri = text.parse().ok().filter(|_| text.len() <= MAX_URL && text.is_ascii())?;
    let authority = url.authority()?.as_str();
    let is_protected = match url.scheme_str() {
        Some("https") => true,
        Some("http") => is_near && is_loopback(authority),
        _ => false,
    };
    (is_protected && !authority.contains('@')).then_some(url)
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::{Value, json};

    const ISSUER: &str = "https://login.example/realms/lab";

    fn document() -> Value {
        json!({
            "issuer": ISSUER,
            "authorization_endpoint": "https://login.example/auth",
            "token_endpoint": "https://login.example/token",
            "jwks_uri": "https://keys.example/jwks",
        })
    }

    fn parse(change: impl FnOnce(&mut Value)) -> Result<Metadata, MetadataProblem> {
        let mut document = document();
        change(&mut document);
        Metadata::parse(document.to_string().as_bytes(), ISSUER)
    }

    #[test]
    fn a_description_names_its_issuer_exactly() {
        assert!(parse(|_| {}).is_ok());
        for other in ["https://login.example/realms/lab/", "https://LOGIN.example/realms/lab", "https://evil.example"] {
            let found = parse(|document| document["issuer"] = other.into());
            assert!(matches!(found, Err(MetadataProblem::Issuer { .. })), "{other}: {found:?}");
        }
    }

    #[test]
    fn every_endpoint_has_encryption() {
        for name in ["authorization_endpoint", "token_endpoint", "jwks_uri", "end_session_endpoint"] {
            for url in [
                "http://login.example/a",
                "http://127.0.0.1:80/a",
                "javascript:alert(1)",
                "https://a@login.example/",
                "/a",
                "",
            ] {
                let found = parse(|document| document[name] = url.into());
                assert_eq!(found, Err(MetadataProblem::Endpoint(name)), "{url}");
            }
        }
        let near = json!({
            "issuer": "http://127.0.0.1:9000",
            "authorization_endpoint": "http://127.0.0.1:9000/auth",
            "token_endpoint": "http://10.0.0.1/token",
            "jwks_uri": "http://127.0.0.1:9000/jwks",
        });
        let found = Metadata::parse(near.to_string().as_bytes(), "http://127.0.0.1:9000");
        assert_eq!(found, Err(MetadataProblem::Endpoint("token_endpoint")));
    }

    #[test]
    fn the_secret_goes_where_the_provider_takes_it() {
        let methods = |methods: Value| parse(|document| document["token_endpoint_auth_methods_supported"] = methods);
        assert!(!methods(json!(["client_secret_post", "client_secret_basic"])).unwrap().secret_in_body);
        assert!(methods(json!(["private_key_jwt", "client_secret_post"])).unwrap().secret_in_body);
        assert_eq!(methods(json!(["private_key_jwt"])), Err(MetadataProblem::Authentication));
    }

    #[test]
    fn any_octets_are_no_description() {
        for text in
            ["", "{}", "[]", "null", "{\"issuer\": 5}", "\u{0}", "{\"issuer\": \"https://login.example/realms/lab\"}"]
        {
            assert_eq!(Metadata::parse(text.as_bytes(), ISSUER), Err(MetadataProblem::Malformed), "{text}");
        }
    }
}
