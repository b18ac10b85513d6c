//! Requests to the API without a socket.

use axum::body::{Body, to_bytes};
use axum::http::Request;
use profivac_station::api::router;
use profivac_station::services::Services;
use profivac_web_server::auth::{Role, User};
use profivac_web_server::middleware::Peer;
use serde_json::Value;
use std::sync::Arc;
use tower::ServiceExt;

/// Sends a request of Ada at 10.0.0.7 with this role. Returns the status and the JSON body of the answer.
pub fn request(services: &Arc<Services>, method: &str, path: &str, body: String, role: Role) -> (u16, Value) {
    let runtime = tokio::runtime::Builder::new_multi_thread().worker_threads(1).enable_all().build().unwrap();
    runtime.block_on(async {
        let request = Request::builder().method(method).uri(path).header("content-type", "application/json");
        let mut request = request.body(Body::from(body)).unwrap();
        request.extensions_mut().insert(User { name: Arc::from("Ada"), role });
        request.extensions_mut().insert(Peer([10, 0, 0, 7].into()));
        let response = router(Arc::clone(services)).oneshot(request).await.unwrap();
        let status = response.status().as_u16();
        let octets = to_bytes(response.into_body(), usize::MAX).await.unwrap();
        (status, serde_json::from_slice(&octets).unwrap_or_else(|error| panic!("{path}: {error}")))
    })
}
