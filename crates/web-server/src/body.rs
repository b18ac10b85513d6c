//! The body of a request as JSON. The middleware has already checked its length, its content type and its arrival time.

use crate::problem::Problem;
use axum::body::Bytes;
use axum::extract::{FromRequest, Request};
use serde::de::DeserializeOwned;

/// The detail of a malformed body. It does not repeat the body, which may hold a password.
const MALFORMED: &str = "expected a JSON body as /api/openapi.json describes it";

/// A deserialised body.
pub struct Body<T>(pub T);

impl<S: Send + Sync, T: DeserializeOwned> FromRequest<S> for Body<T> {
    type Rejection = Problem;

    async fn from_request(request: Request, state: &S) -> Result<Self, Problem> {
        let body =
            Bytes::from_request(request, state).await.map_err(|error| Problem::bad_request(error.body_text()))?;
        serde_json::from_slice(&body).map(Self).map_err(|_| Problem::bad_request(MALFORMED))
    }
}
