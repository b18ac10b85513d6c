//! The clients that may read: programs of this computer without a login if the file permits it, otherwise users of the station's file.

use async_trait::async_trait;
use opcua_server::ServerEndpoint;
use opcua_server::authenticator::{AuthManager, Password, UserToken, user_pass_security_policy_id};
use opcua_types::{Error, StatusCode, UAString, UserTokenPolicy, UserTokenType};
use profivac_station::gateway_status::GatewayStatus;
use profivac_web_server::auth::users::Users;
use std::path::PathBuf;
use std::sync::Arc;
use std::time::Duration;
use tokio::sync::Semaphore;
use tokio::time::{sleep, timeout};

/// The pause after a wrong name or password. Wrong ones wait for each other, right ones do not wait for them. chosen: a guess a
/// second.
const REFUSAL_PAUSE: Duration = Duration::from_secs(1);

/// The longest wait for the check of a login to begin.
const LOGIN_TIMEOUT: Duration = Duration::from_secs(10);

/// The longest name and password that are looked at, in octets.
const MAX_LENGTH: usize = 1024;

/// Checks logins against the station's file of users, as it is at that moment.
pub struct Logins {
    file: PathBuf,
    status: Arc<GatewayStatus>,
    /// One login at a time: each takes a processor for some ten milliseconds.
    slot: Arc<Semaphore>,
    /// One refusal at a time.
    refusals: Arc<Semaphore>,
}

impl Logins {
    /// Logins of the users of this file.
    #[must_use]
    pub fn new(file: PathBuf, status: Arc<GatewayStatus>) -> Self {
        Self { file, status, slot: Arc::new(Semaphore::new(1)), refusals: Arc::new(Semaphore::new(1)) }
    }

    /// Whether name and password are those of a user.
    async fn is_right(&self, name: &str, password: &str) -> bool {
        if name.len() > MAX_LENGTH || password.len() > MAX_LENGTH {
            return false;
        }
        let (file, name, password) = (self.file.clone(), name.to_owned(), password.to_owned());
        let check = move || {
            let users = Users::read(&file).map_err(|error| error.to_string())?;
            Ok(users.get(&name).is_some_and(|account| account.password.matches(&password)))
        };
        match tokio::task::spawn_blocking(check).await {
            Ok(Ok(is_right)) => is_right,
            Ok(Err(error)) => {
                let error: String = error;
                self.status.error(&format!("no user can log in: {error}"));
                false
            }
            Err(_) => false,
        }
    }
}

/// Whether an endpoint has no encryption; the station offers it to programs of its own computer only.
fn is_open(endpoint: &ServerEndpoint) -> bool {
    endpoint.security_policy == "None"
}

fn rejected(sentence: &'static str) -> Error {
    Error::new(StatusCode::BadUserAccessDenied, sentence)
}

#[async_trait]
impl AuthManager for Logins {
    async fn authenticate_anonymous_token(&self, endpoint: &ServerEndpoint) -> Result<(), Error> {
        if is_open(endpoint) { Ok(()) } else { Err(rejected("a user has to log in")) }
    }

    async fn authenticate_username_identity_token(
        &self,
        _endpoint: &ServerEndpoint,
        name: &str,
        password: &Password,
    ) -> Result<UserToken, Error> {
        let Ok(Ok(slot)) = timeout(LOGIN_TIMEOUT, self.slot.acquire()).await else {
            return Err(Error::new(StatusCode::BadTooManyOperations, "too many logins at the same time"));
        };
        if self.is_right(name, password.get()).await {
            return Ok(UserToken(name.to_ascii_lowercase()));
        }
        drop(slot);
        // An unknown name may be a password in the wrong field: it is not repeated.
        self.status.refused("a login with a wrong name or password");
        let _refusal = self.refusals.acquire().await;
        sleep(REFUSAL_PAUSE).await;
        Err(rejected("wrong name or password"))
    }

    fn user_token_policies(&self, endpoint: &ServerEndpoint) -> Vec<UserTokenPolicy> {
        let policy = |id: UAString, token_type| UserTokenPolicy {
            policy_id: id,
            token_type,
            issued_token_type: UAString::null(),
            issuer_endpoint_url: UAString::null(),
            security_policy_uri: UAString::null(),
        };
        match is_open(endpoint) {
            true => vec![policy(UAString::from("anonymous"), UserTokenType::Anonymous)],
            false => vec![policy(user_pass_security_policy_id(endpoint), UserTokenType::UserName)],
        }
    }
}
