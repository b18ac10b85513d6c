//! The body of a request as JSON. How long it may be, how slow and of which kind, the gate has checked.

use super::problem::Problem;
use axum::body::Bytes;
use axum::extract::{FromRequest, Request};
use serde::de::DeserializeOwned;

/// What came is not repeated: it may be a password.
const WRONG: &str = "expected JSON as /api/openapi.json describes it";

/// What a body says.
pub struct Body<T>(pub T);

impl<S: Send + Sync, T: DeserializeOwned> FromRequest<S> for Body<T> {
    type Rejection = Problem;

    async fn from_request(request: Request, state: &S) -> Result<Self, Problem> {
        let body = Bytes::from_request(request, state).await.map_err(|error| Problem::bad(error.body_text()))?;
        serde_json::from_slice(&body).map(Self).map_err(|_| Problem::bad(WRONG))
    }
}
