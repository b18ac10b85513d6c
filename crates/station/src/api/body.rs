//! The body of a request: JSON, not long, and not slow.

use super::problem::Problem;
use axum::body::to_bytes;
use axum::extract::{FromRequest, Request};
use axum::http::header::CONTENT_TYPE;
use serde::de::DeserializeOwned;
use std::time::Duration;

/// The longest body, in octets. free choice: a wish has some hundred.
pub const LONGEST: usize = 16 << 10;

/// So long may it take to come.
const PATIENCE: Duration = Duration::from_secs(10);

/// What a body says.
pub struct Body<T>(pub T);

impl<S: Send + Sync, T: DeserializeOwned> FromRequest<S> for Body<T> {
    type Rejection = Problem;

    async fn from_request(request: Request, _: &S) -> Result<Self, Problem> {
        let kind = request.headers().get(CONTENT_TYPE).and_then(|kind| kind.to_str().ok()).unwrap_or_default();
        let kind = kind.split(';').next().unwrap_or_default().trim();
        if !kind.eq_ignore_ascii_case("application/json") {
            return Err(Problem::media());
        }
        let body = tokio::time::timeout(PATIENCE, to_bytes(request.into_body(), LONGEST)).await;
        let body = body.map_err(|_| Problem::slow())?.map_err(|_| Problem::too_large())?;
        serde_json::from_slice(&body).map(Self).map_err(|error| Problem::bad(format!("the body: {error}")))
    }
}
