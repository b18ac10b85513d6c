//! The settings of an OpenID provider, as `[openid]` has them.

use crate::auth::Role;
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
