//! Problem documents after RFC 9457: errors of the API as JSON.

use crate::auth::Forbidden;
use crate::auth::connections::StreamLimit;
use axum::Json;
use axum::http::StatusCode;
use axum::http::header::{CONTENT_TYPE, RETRY_AFTER};
use axum::response::{AppendHeaders, IntoResponse, Response};
use profivac_recorder::DatabaseError;
use serde::Serialize;
use std::fmt;
use std::time::Duration;
use tokio::task::JoinError;
use utoipa::ToSchema;

/// The content type of a problem document.
pub const PROBLEM_JSON: &str = "application/problem+json";

/// A problem document after RFC 9457: why a request was refused. Its `type` is `about:blank`, so it is left out.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, ToSchema)]
pub struct Problem {
    /// The phrase for the HTTP status.
    #[schema(example = "Not Found")]
    title: &'static str,
    /// The HTTP status.
    #[schema(example = 404)]
    status: u16,
    /// The value of the header `Retry-After`, in seconds.
    #[serde(skip)]
    retry_after_s: Option<u64>,
    /// The reason in a sentence: what was expected and what was found.
    #[schema(example = "there is no gauge \"chamber\"")]
    detail: String,
}

impl Problem {
    fn new(status: StatusCode, detail: impl Into<String>) -> Self {
        let title = status.canonical_reason().unwrap_or_default();
        Self { title, status: status.as_u16(), detail: detail.into(), retry_after_s: None }
    }

    /// 400: the request is malformed.
    pub fn bad_request(detail: impl Into<String>) -> Self {
        Self::new(StatusCode::BAD_REQUEST, detail)
    }

    /// 401: the user has not logged in.
    pub fn unauthorised(detail: impl Into<String>) -> Self {
        Self::new(StatusCode::UNAUTHORIZED, detail)
    }

    /// 403: the user or the page has no permission.
    pub fn forbidden(detail: impl Into<String>) -> Self {
        Self::new(StatusCode::FORBIDDEN, detail)
    }

    /// 404: the resource does not exist.
    pub fn not_found(detail: impl Into<String>) -> Self {
        Self::new(StatusCode::NOT_FOUND, detail)
    }

    /// 405: the resource does not have this method. The header `Allow` lists its methods.
    pub fn method_not_allowed() -> Self {
        Self::new(
            StatusCode::METHOD_NOT_ALLOWED,
            "this method is not available here; the header Allow lists those that are",
        )
    }

    /// 408: the body arrives too slowly.
    pub fn body_timeout() -> Self {
        Self::new(StatusCode::REQUEST_TIMEOUT, "the body of the request did not arrive in time")
    }

    /// 501: this program was built without it.
    pub fn not_implemented(detail: impl Into<String>) -> Self {
        Self::new(StatusCode::NOT_IMPLEMENTED, detail)
    }

    /// 409: the resource is in another state than the client assumes.
    pub fn conflict(detail: impl Into<String>) -> Self {
        Self::new(StatusCode::CONFLICT, detail)
    }

    /// 413: the body is longer than `max` octets.
    pub fn body_too_large(max: usize) -> Self {
        Self::new(StatusCode::PAYLOAD_TOO_LARGE, format!("expected a body of at most {max} octets"))
    }

    /// 415: the body is not JSON.
    pub fn not_json() -> Self {
        let detail = "expected a body with the content-type application/json";
        Self::new(StatusCode::UNSUPPORTED_MEDIA_TYPE, detail)
    }

    /// 421: the request is meant for another computer.
    pub fn wrong_host(host: &str) -> Self {
        let host: String = host.chars().take(64).collect();
        let detail = format!("expected localhost or one of `hosts` as the host of the request, found {host:?}");
        Self::new(StatusCode::MISDIRECTED_REQUEST, detail)
    }

    /// 429: the client is above a rate limit and may ask again after `wait`.
    pub fn too_many_requests(wait: Duration) -> Self {
        let seconds = wait.as_secs().saturating_add(1);
        let detail = format!("too many requests; try again in {seconds} s");
        Self { retry_after_s: Some(seconds), ..Self::new(StatusCode::TOO_MANY_REQUESTS, detail) }
    }

    /// 429: the client has too many live streams.
    pub fn too_many_streams(limit: &StreamLimit) -> Self {
        Self::new(StatusCode::TOO_MANY_REQUESTS, limit.to_string())
    }

    /// 431: the head is longer than `max` octets.
    pub fn head_too_large(max: usize) -> Self {
        let detail = format!("expected a request whose head has at most {max} octets");
        Self::new(StatusCode::REQUEST_HEADER_FIELDS_TOO_LARGE, detail)
    }

    /// 500: a handler panicked.
    pub fn defect() -> Self {
        Self::new(StatusCode::INTERNAL_SERVER_ERROR, "a defect of the program; the station continues to run")
    }

    /// 503: the station cannot do this at present.
    pub fn unavailable(detail: impl Into<String>) -> Self {
        Self::new(StatusCode::SERVICE_UNAVAILABLE, detail)
    }

    /// Whether the user has not logged in.
    #[must_use]
    pub const fn is_unauthorised(&self) -> bool {
        self.status == StatusCode::UNAUTHORIZED.as_u16()
    }
}

impl fmt::Display for Problem {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter.write_str(&self.detail)
    }
}

impl IntoResponse for Problem {
    fn into_response(self) -> Response {
        let status = StatusCode::from_u16(self.status).unwrap_or(StatusCode::INTERNAL_SERVER_ERROR);
        let retry_after = self.retry_after_s.map(|seconds| (RETRY_AFTER, seconds.to_string()));
        (status, [(CONTENT_TYPE, PROBLEM_JSON)], AppendHeaders(retry_after), Json(self)).into_response()
    }
}

/// The problem of a task on another thread that panicked or was cancelled.
pub fn task_failed(error: &JoinError) -> Problem {
    if error.is_panic() { Problem::defect() } else { Problem::unavailable("the station is stopping") }
}

impl From<DatabaseError> for Problem {
    fn from(error: DatabaseError) -> Self {
        Self::unavailable(error.to_string())
    }
}

impl From<Forbidden> for Problem {
    fn from(error: Forbidden) -> Self {
        Self::forbidden(error.to_string())
    }
}
