//! The points of a station as metrics for Prometheus.

pub mod family;

use axum::Router;
use axum::routing::get;
pub use family::names;
use profivac_gateway::thread::{Context, GatewayThread};
use profivac_gateway::{ReadModel, Signal, Snapshot, Value};
use profivac_station::config::gateways::prometheus::Settings;
use profivac_station::services::Services;
use std::fmt::Write;
use std::net::SocketAddr;
use std::sync::Arc;
use tokio::net::TcpListener;

/// The reason why the gateway does not serve.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum PrometheusError {
    /// The address cannot be used.
    #[error("cannot listen on {address}: {error}")]
    Listen {
        /// The address.
        address: SocketAddr,
        /// The error of the operating system.
        error: std::io::Error,
    },
    /// The server ended.
    #[error("the server ended: {0}")]
    Serve(std::io::Error),
}

/// Starts the gateway.
///
/// # Errors
/// When the system gives no thread.
pub fn start(settings: Settings, model: Arc<ReadModel>, services: Arc<Services>) -> std::io::Result<GatewayThread> {
    GatewayThread::start("prometheus", model, services, move |context| serve(settings.clone(), context))
}

async fn serve(settings: Settings, context: Context) -> Result<(), PrometheusError> {
    let address = settings.listen;
    let listener = TcpListener::bind(address).await.map_err(|error| PrometheusError::Listen { address, error })?;
    context.status.runs(listener.local_addr().unwrap_or(address).to_string());
    let model = Arc::clone(&context.model);
    let router = Router::new().route("/metrics", get(move || async move { text(&model.snapshot()) }));
    let mut stop = context.stop;
    let served = axum::serve(listener, router).with_graceful_shutdown(async move { stop.stopped().await });
    served.await.map_err(PrometheusError::Serve)
}

/// The metrics of a snapshot.
fn text(snapshot: &Snapshot) -> String {
    let mut text = String::new();
    for (point, value) in snapshot.iter().filter(|(point, _)| point.signal == Signal::Pressure) {
        if let Value::Float(pa) = value.value
            && value.state.codes().is_measured
        {
            // Writing to a String cannot fail.
            let _written =
                writeln!(text, "profivac_gauge_pressure_pascals{{gauge=\"{}\"}} {pa:e}", point.subject.name());
        }
    }
    text
}
