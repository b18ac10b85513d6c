//! What went wrong, as JSON with one sentence.

use axum::Json;
use axum::http::StatusCode;
use axum::response::{IntoResponse, Response};
use serde::Serialize;
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

    /// It cannot be had at present.
    pub fn unavailable(problem: impl Into<String>) -> Self {
        Self { status: 503, problem: problem.into() }
    }
}

impl IntoResponse for Problem {
    fn into_response(self) -> Response {
        let status = StatusCode::from_u16(self.status).unwrap_or(StatusCode::INTERNAL_SERVER_ERROR);
        (status, Json(self)).into_response()
    }
}
