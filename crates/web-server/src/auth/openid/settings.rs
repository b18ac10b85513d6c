//! The settings of an OpenID provider, as `[openid]` has them.

use crate::auth::Role;
use crate::auth::secret::SecretDigest;
use std::fmt;
use std::time::Duration;
use tokio_rustls::rustls::pki_types::CertificateDer;

/// The longest time for all requests of one step of a login. chosen: a provider that takes longer is not usable.
pub const TIMEOUT: Duration = Duration::from_secs(10);

/// The secret of the station at the provider, which is never shown.
#[derive(Clone, PartialEq, Eq)]
pub struct ClientSecret(pub String);

impl fmt::Debug for ClientSecret {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter.write_str("(secret)")
    }
}

/// A provider, and what its claims mean at this station. The configuration has checked every value.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct OpenIdSettings {
    /// The name on the button.
    pub name: String,
    /// The issuer, exactly as the provider names itself.
    pub issuer: String,
    /// The station's identifier at the provider.
    pub client_id: String,
    /// The station's secret at the provider.
    pub client_secret: ClientSecret,
    /// The address of the dashboard without a final slash, as browsers use it; `None`: that of the server.
    pub url: Option<String>,
    /// The claim with the name of the user.
    pub user_claim: String,
    /// The claim with the roles, or the path to it: `realm_access.roles`.
    pub roles_claim: String,
    /// Values of the claim, each with its role here.
    pub roles: Vec<(String, Role)>,
    /// What the station asks for besides `openid`.
    pub scopes: Vec<String>,
    /// Certificates that are trusted in addition to those of the system.
    pub trusted: Vec<CertificateDer<'static>>,
    /// The longest time for all requests of one step of a login.
    pub timeout: Duration,
}

impl OpenIdSettings {
    /// The digest of what decides which users of the provider have which role. With another one no session continues after a restart.
    #[must_use]
    pub fn digest(&self) -> String {
        let Self { issuer, client_id, user_claim, roles_claim, roles, .. } = self;
        let text = format!("{:?}", (issuer, client_id, user_claim, roles_claim, roles));
        SecretDigest::of(&text).as_str().to_owned()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn settings() -> OpenIdSettings {
        OpenIdSettings {
            name: "Keycloak".to_owned(),
            issuer: "https://login.example".to_owned(),
            client_id: "profivac".to_owned(),
            client_secret: ClientSecret("secret".to_owned()),
            url: None,
            user_claim: "preferred_username".to_owned(),
            roles_claim: "groups".to_owned(),
            roles: vec![("guests".to_owned(), Role::Viewer)],
            scopes: Vec::new(),
            trusted: Vec::new(),
            timeout: TIMEOUT,
        }
    }

    #[test]
    fn another_provider_claim_or_role_has_another_digest_and_another_secret_has_not() {
        let changes: [fn(&mut OpenIdSettings); 7] = [
            |settings: &mut OpenIdSettings| settings.issuer = "https://other.example".to_owned(),
            |settings: &mut OpenIdSettings| settings.client_id = "other".to_owned(),
            |settings: &mut OpenIdSettings| settings.user_claim = "email".to_owned(),
            |settings: &mut OpenIdSettings| settings.roles_claim = "roles".to_owned(),
            |settings: &mut OpenIdSettings| settings.roles = Vec::new(),
            |settings: &mut OpenIdSettings| settings.roles = vec![("staff".to_owned(), Role::Viewer)],
            |settings: &mut OpenIdSettings| settings.roles = vec![("guests".to_owned(), Role::Operator)],
        ];
        let mut digests: Vec<_> = changes
            .iter()
            .map(|change| {
                let mut changed = settings();
                change(&mut changed);
                changed.digest()
            })
            .collect();
        digests.push(settings().digest());
        digests.sort();
        digests.dedup();
        assert_eq!(digests.len(), changes.len() + 1);
        let renewed = OpenIdSettings { client_secret: ClientSecret("new".to_owned()), ..settings() };
        assert_eq!(renewed.digest(), settings().digest());
    }
}
