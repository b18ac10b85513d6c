//! Who asks, as they are seen from here, and how they come and go.

use super::body::Body;
use super::middleware::RequestContext;
use super::problem::Problem;
use crate::auth::secret::Secret;
use crate::auth::sessions::AuthenticatedUser;
use crate::auth::{Role, User};
use axum::Json;
use axum::http::header::SET_COOKIE;
use axum::http::{Extensions, StatusCode};
use axum::response::{AppendHeaders, IntoResponse};
use serde::{Deserialize, Serialize};
use utoipa::ToSchema;

/// How one comes in here.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, ToSchema)]
#[serde(rename_all = "lowercase")]
pub enum LoginState {
    /// Nobody logs in.
    Open,
    /// People log in, and whoever asks has.
    In,
    /// People log in, and whoever asks has not.
    Out,
}

/// Who asks.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, ToSchema)]
pub struct Session {
    /// Their name.
    name: String,
    /// What they may do.
    role: Role,
    /// What has to stand in `x-csrf-token` of everything that is not only looked at; empty before one has logged in.
    token: String,
    /// Whether one logs in here.
    door: LoginState,
}

impl Session {
    fn of(known: &AuthenticatedUser, door: LoginState) -> Self {
        let AuthenticatedUser { user: User { name, role }, token } = known;
        Self { name: name.to_string(), role: *role, token: token.reveal().to_owned(), door }
    }
}

/// What is asked of whoever logs in.
#[derive(Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct Login {
    /// Their name.
    name: String,
    /// Their password.
    password: String,
}

/// What is asked of whoever wants a new password.
#[derive(Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct NewPassword {
    /// The one they have.
    current: String,
    /// The one they want.
    new: String,
}

/// Who asks.
#[utoipa::path(get, path = "/api/session", responses((status = 200, body = Session)))]
pub async fn session(person: User, extensions: Extensions) -> Json<Session> {
    let visit = extensions.get::<RequestContext>();
    let locked = visit.is_some_and(|visit| visit.authenticator().requires_login());
    let door = if locked { LoginState::In } else { LoginState::Open };
    Json(match visit.and_then(RequestContext::user) {
        Some(known) => Session::of(known, door),
        None => Session {
            name: person.name.to_string(),
            role: person.role,
            token: String::new(),
            door: if locked { LoginState::Out } else { LoginState::Open },
        },
    })
}

/// Begins a session. The same answer at the same time to a wrong password and to a name that there is not.
#[utoipa::path(
    post,
    path = "/api/login",
    request_body = Login,
    responses(
        (status = 200, body = Session),
        (status = 400, body = Problem),
        (status = 401, body = Problem),
        (status = 404, body = Problem, description = "The station has no users"),
        (status = 429, body = Problem)
    )
)]
pub async fn login(
    extensions: Extensions,
    Body(Login { name, password }): Body<Login>,
) -> Result<impl IntoResponse, Problem> {
    let visit = visit(&extensions)?;
    let begun = visit.authenticator().login(&name, password, visit.session(), visit.peer()).await?;
    Ok(session_response(visit, &begun))
}

/// Ends the session.
#[utoipa::path(post, path = "/api/logout", responses((status = 204), (status = 401, body = Problem)))]
pub async fn logout(extensions: Extensions) -> Result<impl IntoResponse, Problem> {
    let visit = visit(&extensions)?;
    visit.authenticator().logout(visit.session(), visit.peer());
    Ok((StatusCode::NO_CONTENT, AppendHeaders([(SET_COOKIE, visit.cookie(None))])))
}

/// Changes the password of whoever asks; their other sessions end.
#[utoipa::path(
    post,
    path = "/api/password",
    request_body = NewPassword,
    responses(
        (status = 200, body = Session),
        (status = 400, body = Problem),
        (status = 403, body = Problem),
        (status = 404, body = Problem, description = "The station has no users")
    )
)]
pub async fn password(
    person: User,
    extensions: Extensions,
    Body(NewPassword { current, new }): Body<NewPassword>,
) -> Result<impl IntoResponse, Problem> {
    let visit = visit(&extensions)?;
    let door = visit.authenticator();
    let begun = door.change_password(&person.name, (current, new), visit.session(), visit.peer()).await?;
    Ok(session_response(visit, &begun))
}

fn session_response(
    visit: &RequestContext,
    (session, known): &(Secret, AuthenticatedUser),
) -> impl IntoResponse + use<> {
    (AppendHeaders([(SET_COOKIE, visit.cookie(Some(session)))]), Json(Session::of(known, LoginState::In)))
}

fn visit(extensions: &Extensions) -> Result<&RequestContext, Problem> {
    extensions.get().ok_or_else(|| Problem::unknown("nobody logs in here: the station has no users"))
}
