//! What went wrong, as JSON with one sentence.

use axum::Json;
use axum::http::StatusCode;
use axum::http::header::RETRY_AFTER;
use axum::response::{AppendHeaders, IntoResponse, Response};
use serde::Serialize;
use std::fmt;
use std::time::Duration;
use utoipa::ToSchema;

/// Why there is no answer.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, ToSchema)]
pub struct Problem {
    #[serde(skip)]
    status: u16,
    /// Seconds until it is worth asking again.
    #[serde(skip)]
    wait: Option<u64>,
    /// What was expected and what came.
    problem: String,
}

impl Problem {
    /// The request makes no sense.
    pub fn bad(problem: impl Into<String>) -> Self {
        Self { status: 400, problem: problem.into(), wait: None }
    }

    /// There is no such thing.
    pub fn unknown(problem: impl Into<String>) -> Self {
        Self { status: 404, problem: problem.into(), wait: None }
    }

    /// Whoever asks is not known.
    pub fn unauthorised(problem: impl Into<String>) -> Self {
        Self { status: 401, problem: problem.into(), wait: None }
    }

    /// Whether whoever asks is not known.
    #[must_use]
    pub const fn is_unauthorised(&self) -> bool {
        self.status == 401
    }

    /// Whoever asks may not.
    pub fn forbidden(problem: impl Into<String>) -> Self {
        Self { status: 403, problem: problem.into(), wait: None }
    }

    /// It would do something else than what whoever asks expects.
    pub fn conflict(problem: impl Into<String>) -> Self {
        Self { status: 409, problem: problem.into(), wait: None }
    }

    /// It is not done this way; the header `Allow` says how.
    pub fn method() -> Self {
        Self {
            status: 405,
            problem: "there is no such method here: the header Allow says which there are".to_owned(),
            wait: None,
        }
    }

    /// Whoever asked took us for somebody else.
    pub fn host(name: &str) -> Self {
        let name: String = name.chars().take(64).collect();
        let problem =
            format!("expected a name of this computer as the host, localhost or one of `hosts`, got {name:?}");
        Self { status: 421, problem, wait: None }
    }

    /// Too often; whoever asks again after this time is answered.
    pub fn too_often(wait: Duration) -> Self {
        let seconds = wait.as_secs().saturating_add(1);
        Self { status: 429, problem: format!("too often: ask again in {seconds} s"), wait: Some(seconds) }
    }

    /// The body takes too long.
    pub fn slow() -> Self {
        Self { status: 408, problem: "the body of the request took too long".to_owned(), wait: None }
    }

    /// The body is too large.
    pub fn large(most: usize) -> Self {
        Self { status: 413, problem: format!("expected a body of at most {most} octets"), wait: None }
    }

    /// The body is of another kind.
    pub fn kind() -> Self {
        Self { status: 415, problem: "expected a body with the content-type application/json".to_owned(), wait: None }
    }

    /// We have made a mistake.
    pub fn defect() -> Self {
        Self { status: 500, problem: "a defect of the program: the station itself goes on".to_owned(), wait: None }
    }

    /// It cannot be had at present.
    pub fn unavailable(problem: impl Into<String>) -> Self {
        Self { status: 503, problem: problem.into(), wait: None }
    }
}

impl fmt::Display for Problem {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.problem)
    }
}

impl IntoResponse for Problem {
    fn into_response(self) -> Response {
        let status = StatusCode::from_u16(self.status).unwrap_or(StatusCode::INTERNAL_SERVER_ERROR);
        let wait = self.wait.map(|seconds| (RETRY_AFTER, seconds.to_string()));
        (status, AppendHeaders(wait), Json(self)).into_response()
    }
}
