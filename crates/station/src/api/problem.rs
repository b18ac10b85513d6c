//! What went wrong, as JSON with one sentence.

use axum::Json;
use axum::http::StatusCode;
use axum::response::{IntoResponse, Response};
use serde::Serialize;
use std::fmt;
use utoipa::ToSchema;

/// Why there is no answer.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, ToSchema)]
pub struct Problem {
    #[serde(skip)]
    status: u16,
    /// What was expected and what came.
    problem: String,
}

impl Problem {
    /// The request makes no sense.
    pub fn bad(problem: impl Into<String>) -> Self {
        Self { status: 400, problem: problem.into() }
    }

    /// There is no such thing.
    pub fn unknown(problem: impl Into<String>) -> Self {
        Self { status: 404, problem: problem.into() }
    }

    /// Whoever asks is not known.
    pub fn unauthorised(problem: impl Into<String>) -> Self {
        Self { status: 401, problem: problem.into() }
    }

    /// Whoever asks may not.
    pub fn forbidden(problem: impl Into<String>) -> Self {
        Self { status: 403, problem: problem.into() }
    }

    /// It would do something else than what whoever asks expects.
    pub fn conflict(problem: impl Into<String>) -> Self {
        Self { status: 409, problem: problem.into() }
    }

    /// It is not done this way; the header `Allow` says how.
    pub fn method() -> Self {
        Self { status: 405, problem: "there is no such method here: the header Allow says which there are".to_owned() }
    }

    /// Whoever asked took us for somebody else.
    pub fn host(name: &str) -> Self {
        let problem = format!("expected this computer as the host, localhost or a loopback address, got {name:?}");
        Self { status: 421, problem }
    }

    /// More was sent than anybody needs to say.
    pub fn too_large() -> Self {
        Self { status: 413, problem: format!("expected a body of at most {} octets", super::body::LONGEST) }
    }

    /// What was sent is no JSON.
    pub fn media() -> Self {
        Self { status: 415, problem: "expected a body with content-type application/json".to_owned() }
    }

    /// The body did not come.
    pub fn slow() -> Self {
        Self { status: 408, problem: "the body of the request did not come in time".to_owned() }
    }

    /// We have made a mistake.
    pub fn defect() -> Self {
        Self { status: 500, problem: "a defect of the program: the station itself goes on".to_owned() }
    }

    /// It cannot be had at present.
    pub fn unavailable(problem: impl Into<String>) -> Self {
        Self { status: 503, problem: problem.into() }
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
        (status, Json(self)).into_response()
    }
}
