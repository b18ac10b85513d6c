//! A provider: a login begins, the browser goes there and returns, and the ID token says who it is.
//!
//! ```text
//! browser                       station                                      provider
//!   ├─ log in ───────────────────▶ ├─ description, if it is older than an hour ──▶ │
//!   │ ◀─────── address and cookie ─┤                                               │
//!   ├─ state, nonce, challenge ────────────────────────────────────────────────── ▶ │
//!   │ ◀────────────────────────────────────────────────────────── state and code ─┤
//!   ├─ state, code, cookie ──────▶ ├─ code, verifier, secret ────────────────────▶ │
//!   │                              │ ◀─────────────────────────────────── ID token ─┤
//!   │ ◀────────────────── session ─┤ (keys, if they are old or one is unknown)       │
//! ```
//!
//! Every step has one time limit, each answer a limit of octets, and few steps run at the same time: a provider that is silent, slow or
//! hostile delays logins at this provider alone.

use super::identity::{Identity, IdentityProblem};
use super::keys::{Keys, Verdict};
use super::metadata::{Metadata, MetadataProblem};
use super::pending::{PendingLogin, PendingLogins};
use super::settings::OpenIdSettings;
use super::token::{Expected, SignedToken, TokenProblem};
use crate::auth::rate_limit::{Quota, RateLimit};
use crate::auth::secret::RandomSecret;
use crate::client_tls::trusting;
use crate::http_client::{self, AnswerBody, RequestError, host_of, port_of};
use axum::body::{Body, Bytes};
use base64::Engine;
use base64::engine::general_purpose::{STANDARD, URL_SAFE_NO_PAD};
use hyper::header::{ACCEPT, AUTHORIZATION, CONTENT_TYPE};
use hyper::{Method, Request, Uri};
use serde::Deserialize;
use std::net::{IpAddr, SocketAddr};
use std::sync::{Arc, Mutex, PoisonError, RwLock};
use std::time::{Duration, Instant, SystemTime};
use tokio::net::{TcpStream, lookup_host};
use tokio::sync::Semaphore;
use tokio::time::timeout;
use tokio_rustls::TlsConnector;
use tokio_rustls::rustls;

/// The page of the dashboard to which the provider sends the browser back.
pub const RETURN_PATH: &str = "/openid";

/// The most octets of an answer. chosen: some times what providers send.
const MAX_ANSWER: usize = 256 << 10;

/// Description and keys are read again when they are older. chosen: a withdrawn key is refused after an hour.
const MAX_AGE: Duration = Duration::from_secs(3600);

/// The keys are read again for a token with an unknown key, this many times at once and then once in [`RELOAD_PERIOD`]. chosen.
const RELOADS: u32 = 3;

/// See [`RELOADS`].
const RELOAD_PERIOD: Duration = Duration::from_secs(60);

/// The most steps of logins at the same time. chosen.
const MAX_STEPS: usize = 8;

/// The most look-ups of a host name at the same time. Each holds a thread until the resolver gives up, also after a time-out.
const MAX_LOOKUPS: usize = 4;

/// The most characters of a code from the provider that an error repeats.
const MAX_SHOWN: usize = 64;

/// Why a login at the provider fails.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum OpenIdError {
    /// The provider gives no usable answer.
    #[error("{provider} cannot be asked: {reason}; try again, or log in with a name and a password of this station")]
    Provider {
        /// The name of the provider.
        provider: String,
        /// The reason.
        reason: ProviderProblem,
    },
    /// Too many logins at the same time.
    #[error("too many logins at the same time; try again")]
    Busy,
    /// The browser has another address of the station than the provider.
    #[error("open {0} to log in: the provider sends browsers there")]
    Address(String),
    /// The login has expired, was completed before, or began in another browser.
    #[error("this login began more than 10 minutes ago, in another window or in another browser; log in again")]
    NotPending,
    /// The provider has refused the login.
    #[error("{provider} has refused the login: {code}")]
    Refused {
        /// The name of the provider.
        provider: String,
        /// The code of the error (RFC 6749, 4.1.2.1).
        code: String,
    },
    /// The answer is that of another provider.
    #[error("the answer is not that of {0}")]
    OtherIssuer(String),
    /// The ID token is refused.
    #[error("the answer of {provider} is refused: {problem}")]
    Token {
        /// The name of the provider.
        provider: String,
        /// The reason.
        problem: TokenProblem,
    },
    /// The claims are not those of a user of this station.
    #[error("{0}")]
    Identity(#[from] IdentityProblem),
    /// Another user of the provider with this name has a session.
    #[error("another user of the provider is logged in as {0}: the claim with the name is not unique")]
    SameName(Arc<str>),
}

/// Why a provider gives no usable answer.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum ProviderProblem {
    /// It does not answer in time.
    #[error("it did not answer within {} s", .0.as_secs_f64())]
    Timeout(Duration),
    /// There is no answer.
    #[error(transparent)]
    Request(#[from] RequestError),
    /// The answer has another status.
    #[error("expected an answer with status 200 from {host}, found {status}")]
    Status {
        /// The host.
        host: String,
        /// The status.
        status: u16,
    },
    /// It does not take the code, or the secret of the station.
    #[error("it does not accept the request of the station: {0}")]
    Code(String),
    /// Its description cannot be used.
    #[error(transparent)]
    Metadata(#[from] MetadataProblem),
    /// Its keys cannot be used.
    #[error("expected its keys as a JSON Web Key Set")]
    Keys,
    /// Its answer has no ID token.
    #[error("expected an ID token in its answer")]
    NoToken,
    /// The operating system supplies no random numbers.
    #[error("no login can begin: {0}")]
    Random(std::io::Error),
}

/// A login that has begun.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct BegunLogin {
    /// The address of the provider where the browser logs in.
    pub url: String,
    /// The value of the cookie that binds the login to the browser.
    pub browser: RandomSecret,
}

/// What the browser brings back from the provider.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct ReturnedLogin {
    /// The state of the login.
    pub state: String,
    /// The code for the ID token.
    pub code: Option<String>,
    /// The code of an error.
    pub error: Option<String>,
    /// The issuer (RFC 9207).
    pub issuer: Option<String>,
}

/// A value with the time when it was read.
type Dated<T> = Option<(Arc<T>, Instant)>;

/// A provider.
pub struct OpenIdProvider {
    settings: OpenIdSettings,
    /// See [`OpenIdSettings::digest`].
    digest: String,
    /// The address of the dashboard without a final slash.
    url: String,
    connector: TlsConnector,
    lookups: Arc<Semaphore>,
    steps: Semaphore,
    pending: Mutex<PendingLogins>,
    metadata: RwLock<Dated<Metadata>>,
    keys: RwLock<Dated<Keys>>,
    /// One request for the description or for the keys at a time.
    reading: tokio::sync::Mutex<()>,
    reloads: Mutex<Quota>,
}

#[derive(Deserialize)]
struct TokenJson {
    id_token: Option<String>,
}

#[derive(Deserialize)]
struct ErrorJson {
    error: String,
}

impl OpenIdProvider {
    /// A provider that sends browsers back to `url` if its settings have no other address. Nothing is read before the first login.
    ///
    /// # Errors
    /// When the TLS library offers no protocol version.
    pub fn new(settings: OpenIdSettings, url: String) -> Result<Self, rustls::Error> {
        let config = trusting(settings.trusted.clone())?.with_no_client_auth();
        Ok(Self {
            url: settings.url.clone().unwrap_or(url),
            digest: settings.digest(),
            settings,
            connector: TlsConnector::from(Arc::new(config)),
            lookups: Arc::new(Semaphore::new(MAX_LOOKUPS)),
            steps: Semaphore::new(MAX_STEPS),
            pending: Mutex::default(),
            metadata: RwLock::default(),
            keys: RwLock::default(),
            reading: tokio::sync::Mutex::default(),
            reloads: Mutex::new(Quota::NEW),
        })
    }

    /// Whether the keys may be read again now, and counts it.
    fn may_reload(&self) -> bool {
        let mut quota = self.reloads.lock().unwrap_or_else(PoisonError::into_inner);
        quota.check(RateLimit::new(RELOADS, RELOAD_PERIOD), Instant::now()).is_ok()
    }

    /// The digest of what decides which users have which role.
    #[must_use]
    pub fn digest(&self) -> &str {
        &self.digest
    }

    /// The name on the button.
    #[must_use]
    pub fn name(&self) -> &str {
        &self.settings.name
    }

    /// Begins a login of a browser at `peer`, whose page has the origin `origin`.
    ///
    /// # Errors
    /// [`OpenIdError`].
    pub async fn begin(&self, peer: IpAddr, origin: Option<&str>) -> Result<BegunLogin, OpenIdError> {
        if origin.is_some_and(|origin| !origin.eq_ignore_ascii_case(&self.url)) {
            return Err(OpenIdError::Address(self.url.clone()));
        }
        let metadata = async { self.metadata().await.map_err(|reason| self.failed(reason)) };
        let metadata = self.in_time(metadata).await?;
        let random = |error| self.failed(ProviderProblem::Random(error));
        let login = PendingLogin::new(peer, Instant::now()).map_err(random)?;
        let state = RandomSecret::new().map_err(random)?;
        let url = self.authorization_url(&metadata, &state, &login);
        let browser = login.browser.clone();
        self.pending.lock().unwrap_or_else(PoisonError::into_inner).add(state, login);
        Ok(BegunLogin { url, browser })
    }

    /// Completes the login that `browser` has begun.
    ///
    /// # Errors
    /// [`OpenIdError`]. The login has ended in any case, if it was that of this browser.
    pub async fn finish(
        &self,
        returned: &ReturnedLogin,
        browser: Option<&RandomSecret>,
    ) -> Result<Identity, OpenIdError> {
        let provider = || self.settings.name.clone();
        let login = self.pending_login(returned, browser).ok_or(OpenIdError::NotPending)?;
        if returned.issuer.as_ref().is_some_and(|issuer| *issuer != self.settings.issuer) {
            return Err(OpenIdError::OtherIssuer(provider()));
        }
        let code = match (&returned.code, &returned.error) {
            (Some(code), None) => code,
            (_, error) => {
                let code = error_code(error.as_deref().unwrap_or("no code"));
                return Err(OpenIdError::Refused { provider: provider(), code });
            }
        };
        self.in_time(async {
            let metadata = self.metadata().await.map_err(|reason| self.failed(reason))?;
            if metadata.names_issuer && returned.issuer.is_none() {
                return Err(OpenIdError::OtherIssuer(provider()));
            }
            let token = self.exchange(&metadata, code, &login).await.map_err(|reason| self.failed(reason))?;
            self.identity(&metadata, &token, &login).await
        })
        .await
    }

    fn pending_login(&self, returned: &ReturnedLogin, browser: Option<&RandomSecret>) -> Option<PendingLogin> {
        let state = RandomSecret::parse(&returned.state)?;
        self.pending.lock().unwrap_or_else(PoisonError::into_inner).take(&state, browser?, Instant::now())
    }

    /// The address at which the browser ends the session at the provider, if the provider has one.
    #[must_use]
    pub fn end_session_url(&self) -> Option<String> {
        let metadata = self.metadata.read().unwrap_or_else(PoisonError::into_inner).clone();
        let url = metadata?.0.end_session.clone()?;
        let back = format!("{}/", self.url);
        Some(with_query(&url, &[("client_id", &self.settings.client_id), ("post_logout_redirect_uri", &back)]))
    }

    fn failed(&self, reason: ProviderProblem) -> OpenIdError {
        OpenIdError::Provider { provider: self.settings.name.clone(), reason }
    }

    /// Runs a step of a login within its time.
    async fn in_time<T>(&self, step: impl Future<Output = Result<T, OpenIdError>>) -> Result<T, OpenIdError> {
        let Ok(_slot) = self.steps.try_acquire() else { return Err(OpenIdError::Busy) };
        let limit = self.settings.timeout;
        timeout(limit, step).await.unwrap_or_else(|_| Err(self.failed(ProviderProblem::Timeout(limit))))
    }

    fn redirect_uri(&self) -> String {
        format!("{}{RETURN_PATH}", self.url)
    }

    fn authorization_url(&self, metadata: &Metadata, state: &RandomSecret, login: &PendingLogin) -> String {
        let verifier = ring::digest::digest(&ring::digest::SHA256, login.verifier.reveal().as_bytes());
        let scopes = self.settings.scopes.iter().map(String::as_str);
        let scope = std::iter::once("openid").chain(scopes).collect::<Vec<_>>().join(" ");
        with_query(
            &metadata.authorization,
            &[
                ("response_type", "code"),
                ("client_id", &self.settings.client_id),
                ("redirect_uri", &self.redirect_uri()),
                ("scope", &scope),
                ("state", state.reveal()),
                ("nonce", login.nonce.reveal()),
                ("code_challenge", &URL_SAFE_NO_PAD.encode(verifier)),
                ("code_challenge_method", "S256"),
            ],
        )
    }

    /// Exchanges the code for the ID token.
    async fn exchange(&self, metadata: &Metadata, code: &str, login: &PendingLogin) -> Result<String, ProviderProblem> {
        let request = self.token_request(metadata, code, login).map_err(RequestError::Request)?;
        let body = self.ask(&metadata.token, request).await?;
        let token: TokenJson = serde_json::from_slice(&body).map_err(|_| ProviderProblem::NoToken)?;
        token.id_token.ok_or(ProviderProblem::NoToken)
    }

    fn token_request(
        &self,
        metadata: &Metadata,
        code: &str,
        login: &PendingLogin,
    ) -> Result<Request<Body>, hyper::http::Error> {
        let OpenIdSettings { client_id, client_secret, .. } = &self.settings;
        let mut form = form_urlencoded::Serializer::new(String::new());
        form.append_pair("grant_type", "authorization_code")
            .append_pair("code", code)
            .append_pair("redirect_uri", &self.redirect_uri())
            .append_pair("code_verifier", login.verifier.reveal());
        let mut request = Request::builder()
            .method(Method::POST)
            .header(CONTENT_TYPE, "application/x-www-form-urlencoded")
            .header(ACCEPT, "application/json");
        if metadata.secret_in_body {
            form.append_pair("client_id", client_id).append_pair("client_secret", &client_secret.0);
        } else {
            // Both are encoded as in a form (RFC 6749, 2.3.1).
            let encoded = |text: &str| form_urlencoded::byte_serialize(text.as_bytes()).collect::<String>();
            let pair = STANDARD.encode(format!("{}:{}", encoded(client_id), encoded(&client_secret.0)));
            request = request.header(AUTHORIZATION, format!("Basic {pair}"));
        }
        request.body(Body::from(form.finish()))
    }

    /// The user of a token, after all checks.
    async fn identity(&self, metadata: &Metadata, token: &str, login: &PendingLogin) -> Result<Identity, OpenIdError> {
        let refused = |problem| OpenIdError::Token { provider: self.settings.name.clone(), problem };
        let token = SignedToken::parse(token).map_err(refused)?;
        match self.verdict(metadata, &token).await.map_err(|reason| self.failed(reason))? {
            Verdict::Right => {}
            Verdict::UnknownKey => return Err(refused(TokenProblem::UnknownKey)),
            Verdict::Wrong => return Err(refused(TokenProblem::Signature)),
        }
        let now = SystemTime::now().duration_since(SystemTime::UNIX_EPOCH).unwrap_or_default().as_secs_f64();
        let OpenIdSettings { issuer, client_id, .. } = &self.settings;
        let claims = token.into_claims(&Expected { issuer, client_id, nonce: &login.nonce, now }).map_err(refused)?;
        Ok(Identity::of(&claims, &self.settings)?)
    }

    /// Checks the signature with the keys that are known, and once more with the present ones if the provider may have changed them.
    async fn verdict(&self, metadata: &Metadata, token: &SignedToken<'_>) -> Result<Verdict, ProviderProblem> {
        let keys = self.keys(metadata, None).await?;
        let verdict = token.verify(&keys);
        let may_have_changed = verdict == Verdict::UnknownKey || (verdict == Verdict::Wrong && !token.names_key());
        if !may_have_changed {
            return Ok(verdict);
        }
        Ok(token.verify(&*self.keys(metadata, Some(&keys)).await?))
    }

    /// The description of the provider, read again when it is old.
    async fn metadata(&self) -> Result<Arc<Metadata>, ProviderProblem> {
        if let Some(metadata) = recent(&self.metadata) {
            return Ok(metadata);
        }
        let _reading = self.reading.lock().await;
        if let Some(metadata) = recent(&self.metadata) {
            return Ok(metadata);
        }
        let issuer = &self.settings.issuer;
        let url: Uri = Metadata::url(issuer).parse().map_err(|_| MetadataProblem::Malformed)?;
        let metadata = Metadata::parse(&self.get(&url).await?, issuer)?;
        Ok(store(&self.metadata, metadata))
    }

    /// The keys of the provider, read again when they are old, or when they are still the keys `outdated` and a reload is permitted.
    async fn keys(&self, metadata: &Metadata, outdated: Option<&Arc<Keys>>) -> Result<Arc<Keys>, ProviderProblem> {
        let is_good = |keys: &Arc<Keys>| outdated.is_none_or(|outdated| !Arc::ptr_eq(outdated, keys));
        if let Some(keys) = recent(&self.keys).filter(is_good) {
            return Ok(keys);
        }
        let _reading = self.reading.lock().await;
        let known = recent(&self.keys);
        match known {
            Some(keys) if is_good(&keys) || !self.may_reload() => Ok(keys),
            _ => {
                let keys = Keys::parse(&self.get(&metadata.keys).await?).ok_or(ProviderProblem::Keys)?;
                Ok(store(&self.keys, keys))
            }
        }
    }

    async fn get(&self, url: &Uri) -> Result<Bytes, ProviderProblem> {
        let request = Request::builder().header(ACCEPT, "application/json").body(Body::empty());
        self.ask(url, request.map_err(RequestError::Request)?).await
    }

    async fn ask(&self, url: &Uri, request: Request<Body>) -> Result<Bytes, ProviderProblem> {
        let stream = self.connect(url).await.map_err(RequestError::Connect)?;
        let body = AnswerBody::UpTo(MAX_ANSWER);
        let answer = http_client::send(&self.connector, stream, url, request, body).await?;
        if answer.status == 200 {
            return Ok(answer.body);
        }
        if let Ok(ErrorJson { error }) = serde_json::from_slice(&answer.body) {
            return Err(ProviderProblem::Code(error_code(&error)));
        }
        Err(ProviderProblem::Status { host: host_of(url).to_owned(), status: answer.status })
    }

    async fn connect(&self, url: &Uri) -> std::io::Result<TcpStream> {
        let slot = Arc::clone(&self.lookups).acquire_owned().await.map_err(std::io::Error::other)?;
        let (host, port) = (host_of(url).to_owned(), port_of(url));
        let lookup = tokio::spawn(async move {
            // The task goes on after a time-out, as its thread does.
            let _slot = slot;
            Ok(lookup_host((host, port)).await?.collect())
        });
        let addresses: std::io::Result<Vec<SocketAddr>> = lookup.await.map_err(std::io::Error::other)?;
        TcpStream::connect(addresses?.as_slice()).await
    }
}

/// A value that is not too old.
fn recent<T>(cell: &RwLock<Dated<T>>) -> Option<Arc<T>> {
    let dated = cell.read().unwrap_or_else(PoisonError::into_inner).clone();
    dated.filter(|(_, read)| read.elapsed() < MAX_AGE).map(|(value, _)| value)
}

fn store<T>(cell: &RwLock<Dated<T>>, value: T) -> Arc<T> {
    let value = Arc::new(value);
    *cell.write().unwrap_or_else(PoisonError::into_inner) = Some((Arc::clone(&value), Instant::now()));
    value
}

/// A code of an error. It comes from outside: other characters than those of codes (RFC 6749, 4.1.2.1) are left out.
fn error_code(text: &str) -> String {
    let is_usual = |letter: &char| letter.is_ascii_alphanumeric() || "_-. ".contains(*letter);
    text.chars().filter(is_usual).take(MAX_SHOWN).collect()
}

/// The URL with these parameters added.
fn with_query(url: &Uri, parameters: &[(&str, &str)]) -> String {
    let mut query = form_urlencoded::Serializer::new(String::new());
    query.extend_pairs(parameters);
    let separator = if url.query().is_some() { '&' } else { '?' };
    format!("{url}{separator}{}", query.finish())
}
