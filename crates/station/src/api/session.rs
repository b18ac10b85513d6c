//! The session of a user: login, logout, change of password.

use super::body::Body;
use super::middleware::RequestContext;
use super::problem::Problem;
use crate::auth::secret::RandomSecret;
use crate::auth::sessions::AuthenticatedUser;
use crate::auth::{Role, User};
use axum::Json;
use axum::http::header::SET_COOKIE;
use axum::http::{Extensions, StatusCode};
use axum::response::{AppendHeaders, IntoResponse};
use serde::{Deserialize, Serialize};
use utoipa::ToSchema;

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
}

impl Session {
    fn new(authenticated: &AuthenticatedUser, login: LoginState) -> Self {
        let AuthenticatedUser { user: User { name, role }, token } = authenticated;
        Self { name: name.to_string(), role: *role, token: token.reveal().to_owned(), login }
    }
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
            Session::new(authenticated, if requires_login { LoginState::LoggedIn } else { LoginState::NotRequired })
        }
        None => Session {
            name: user.name.to_string(),
            role: user.role,
            token: String::new(),
            login: if requires_login { LoginState::LoggedOut } else { LoginState::NotRequired },
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

/// End the session
#[utoipa::path(post, path = "/api/logout", responses((status = 204, description = "The session has ended")))]
pub async fn logout(extensions: Extensions) -> Result<impl IntoResponse, Problem> {
    let context = context(&extensions)?;
    context.authenticator().logout(context.session(), context.peer());
    Ok((StatusCode::NO_CONTENT, AppendHeaders([(SET_COOKIE, context.cookie(None))])))
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
        (status = 403, body = Problem, description = "The current password is wrong"),
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
    let cookie = AppendHeaders([(SET_COOKIE, context.cookie(Some(session)))]);
    (cookie, Json(Session::new(authenticated, LoginState::LoggedIn)))
}

/// The context that the middleware gives every request.
fn context(extensions: &Extensions) -> Result<&RequestContext, Problem> {
    extensions.get().ok_or_else(Problem::defect)
}
