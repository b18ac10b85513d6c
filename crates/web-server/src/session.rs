//! The session of a user: login with a password or at an OpenID provider, logout, change of password.

use crate::auth::openid::{OpenIdProvider, ReturnedLogin, is_openid};
use crate::auth::secret::RandomSecret;
use crate::auth::sessions::AuthenticatedUser;
use crate::auth::{Role, User};
use crate::body::Body;
use crate::middleware::RequestContext;
use crate::problem::Problem;
use axum::Json;
use axum::Router;
use axum::http::header::{ORIGIN, SET_COOKIE};
use axum::http::{Extensions, HeaderMap, StatusCode};
use axum::response::{AppendHeaders, IntoResponse, Response};
use axum::routing::{get, post};
use serde::{Deserialize, Serialize};
use utoipa::ToSchema;

/// Login with a password or at an OpenID provider, logout, and change of the password. They need the middleware
/// of [`crate::server::Server`] alone.
pub fn session_routes<S: Clone + Send + Sync + 'static>() -> Router<S> {
    Router::new()
        .route("/api/session", get(session))
        .route("/api/login", post(login))
        .route("/api/openid/begin", post(openid_begin))
        .route("/api/openid/login", post(openid_login))
        .route("/api/logout", post(logout))
        .route("/api/password", post(password))
}

/// Whether the user has to log in, and has.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, ToSchema)]
#[serde(rename_all = "kebab-case")]
pub enum LoginState {
    /// The station has no users and no login.
    NotRequired,
    /// The user has logged in.
    LoggedIn,
    /// The user has not logged in.
    LoggedOut,
}

/// The session of a request.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, ToSchema)]
pub struct Session {
    /// The name of the user.
    #[schema(example = "ada")]
    name: String,
    /// The role of the user.
    role: Role,
    /// The value of the header `x-csrf-token` that every request other than GET and HEAD needs; empty before login.
    token: String,
    /// Whether the user has to log in, and has.
    login: LoginState,
    /// Whether this station keeps the password of the user, who may change it here.
    has_password: bool,
    /// The name of the OpenID provider at which users may log in; `null` if there is none.
    #[schema(example = "Keycloak")]
    provider: Option<String>,
}

impl Session {
    fn new(authenticated: &AuthenticatedUser, login: LoginState, context: Option<&RequestContext>) -> Self {
        let AuthenticatedUser { user: User { name, role }, token, .. } = authenticated;
        let has_password = login == LoginState::LoggedIn && !is_openid(name);
        let (name, token) = (name.to_string(), token.reveal().to_owned());
        Self { name, role: *role, token, login, has_password, provider: provider(context) }
    }
}

/// The name of the OpenID provider.
fn provider(context: Option<&RequestContext>) -> Option<String> {
    let provider = context.and_then(|context| context.authenticator().provider());
    provider.map(OpenIdProvider::name).map(str::to_owned)
}

/// The beginning of a login at the OpenID provider.
#[derive(Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct OpenIdBegin {}

/// Where the browser continues.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, ToSchema)]
pub struct ProviderAddress {
    /// An address of the OpenID provider.
    #[schema(example = "https://login.example/realms/lab/protocol/openid-connect/auth?response_type=code")]
    url: String,
}

/// What the browser brings back from the OpenID provider: the parameters of the address of the page `/openid`.
#[derive(Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct OpenIdLogin {
    /// The state of the login.
    state: String,
    /// The code, if the login has succeeded.
    #[serde(default)]
    code: Option<String>,
    /// The code of an error, if it has not.
    #[serde(default)]
    error: Option<String>,
    /// The issuer, if the provider sends it.
    #[serde(default)]
    iss: Option<String>,
}

/// Name and password of a user.
#[derive(Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct Login {
    /// The name.
    #[schema(example = "ada")]
    name: String,
    /// The password.
    password: String,
}

/// A user's change of the password.
#[derive(Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct NewPassword {
    /// The current password.
    current: String,
    /// The new password, 8 characters at least.
    new: String,
}

/// The user of this session
#[utoipa::path(get, path = "/api/session", responses((status = 200, body = Session)))]
pub async fn session(user: User, extensions: Extensions) -> Json<Session> {
    let context = extensions.get::<RequestContext>();
    let requires_login = context.is_some_and(|context| context.authenticator().requires_login());
    Json(match context.and_then(RequestContext::authenticated) {
        Some(authenticated) => {
            let login = if requires_login { LoginState::LoggedIn } else { LoginState::NotRequired };
            Session::new(authenticated, login, context)
        }
        None => Session {
            name: user.name.to_string(),
            role: user.role,
            token: String::new(),
            login: if requires_login { LoginState::LoggedOut } else { LoginState::NotRequired },
            has_password: false,
            provider: provider(context),
        },
    })
}

/// Begin a session
///
/// A wrong password and an unknown name get the same answer after the same time.
#[utoipa::path(
    post,
    path = "/api/login",
    request_body = Login,
    responses(
        (status = 200, body = Session),
        (status = 400, body = Problem, description = "The body is malformed"),
        (status = 401, body = Problem, description = "The name or the password is wrong"),
        (status = 404, body = Problem, description = "The station has no users"),
        (status = 503, body = Problem, description = "Too many logins at the same time")
    )
)]
pub async fn login(
    extensions: Extensions,
    Body(Login { name, password }): Body<Login>,
) -> Result<impl IntoResponse, Problem> {
    let context = context(&extensions)?;
    let begun = context.authenticator().login(&name, password, context.session(), context.peer()).await?;
    Ok(session_response(context, &begun))
}

/// Begin a login at the OpenID provider
///
/// The answer sets a cookie that binds the login to the browser, which continues at the address.
#[utoipa::path(
    post,
    path = "/api/openid/begin",
    request_body = OpenIdBegin,
    responses(
        (status = 200, body = ProviderAddress),
        (status = 400, body = Problem, description = "The body is malformed"),
        (status = 403, body = Problem, description = "The page has another address than the provider sends browsers to"),
        (status = 404, body = Problem, description = "The station has no OpenID provider"),
        (status = 503, body = Problem, description = "The provider does not answer, or too many users log in at the same time")
    )
)]
pub async fn openid_begin(
    extensions: Extensions,
    headers: HeaderMap,
    Body(OpenIdBegin {}): Body<OpenIdBegin>,
) -> Result<impl IntoResponse, Problem> {
    let context = context(&extensions)?;
    let origin = headers.get(ORIGIN).and_then(|origin| origin.to_str().ok());
    let begun = context.authenticator().begin_openid(origin, context.peer()).await?;
    let cookie = AppendHeaders([(SET_COOKIE, context.openid_cookie(Some(&begun.browser)))]);
    Ok((cookie, Json(ProviderAddress { url: begun.url })))
}

/// Complete a login at the OpenID provider, and begin a session
#[utoipa::path(
    post,
    path = "/api/openid/login",
    request_body = OpenIdLogin,
    responses(
        (status = 200, body = Session),
        (status = 400, body = Problem, description = "The body is malformed"),
        (status = 403, body = Problem, description = "The login is refused: it began in another browser, the provider refuses it, or the user has no role here"),
        (status = 404, body = Problem, description = "The station has no OpenID provider"),
        (status = 503, body = Problem, description = "The provider does not answer, or too many users log in at the same time")
    )
)]
pub async fn openid_login(
    extensions: Extensions,
    Body(OpenIdLogin { state, code, error, iss }): Body<OpenIdLogin>,
) -> Result<impl IntoResponse, Problem> {
    let context = context(&extensions)?;
    let returned = ReturnedLogin { state, code, error, issuer: iss };
    let (browser, before) = (context.openid_browser(), context.session());
    let begun = context.authenticator().finish_openid(&returned, browser, before, context.peer()).await?;
    let cookies =
        [(SET_COOKIE, context.cookie(Some(&begun.0), begun.1.cookie_age)), (SET_COOKIE, context.openid_cookie(None))];
    Ok((AppendHeaders(cookies), Json(Session::new(&begun.1, LoginState::LoggedIn, Some(context)))))
}

/// End the session
///
/// A user of an OpenID provider may still have a session there: the browser ends it at the address of the answer.
#[utoipa::path(
    post,
    path = "/api/logout",
    responses(
        (status = 200, body = ProviderAddress, description = "The session has ended, and the browser may end that at the provider"),
        (status = 204, description = "The session has ended")
    )
)]
pub async fn logout(extensions: Extensions) -> Result<Response, Problem> {
    let context = context(&extensions)?;
    let cookie = AppendHeaders([(SET_COOKIE, context.cookie(None, None))]);
    let provider = context.authenticator().logout(context.session(), context.peer());
    context.store_sessions().await;
    Ok(match provider {
        Some(url) => (cookie, Json(ProviderAddress { url })).into_response(),
        None => (StatusCode::NO_CONTENT, cookie).into_response(),
    })
}

/// Change the password of the user
///
/// All sessions of the user end, and the answer begins a new one.
#[utoipa::path(
    post,
    path = "/api/password",
    request_body = NewPassword,
    responses(
        (status = 200, body = Session),
        (status = 400, body = Problem, description = "The new password is refused"),
        (status = 403, body = Problem, description = "The current password is wrong, or an OpenID provider keeps it"),
        (status = 404, body = Problem, description = "The station has no users"),
        (status = 503, body = Problem, description = "The password cannot be stored")
    )
)]
pub async fn password(
    user: User,
    extensions: Extensions,
    Body(NewPassword { current, new }): Body<NewPassword>,
) -> Result<impl IntoResponse, Problem> {
    let context = context(&extensions)?;
    let passwords = (current, new);
    let begun =
        context.authenticator().change_password(&user.name, passwords, context.session(), context.peer()).await?;
    Ok(session_response(context, &begun))
}

fn session_response(
    context: &RequestContext,
    (session, authenticated): &(RandomSecret, AuthenticatedUser),
) -> impl IntoResponse + use<> {
    let cookie = AppendHeaders([(SET_COOKIE, context.cookie(Some(session), authenticated.cookie_age))]);
    (cookie, Json(Session::new(authenticated, LoginState::LoggedIn, Some(context))))
}

/// The context that the middleware gives every request.
fn context(extensions: &Extensions) -> Result<&RequestContext, Problem> {
    extensions.get().ok_or_else(Problem::defect)
}
