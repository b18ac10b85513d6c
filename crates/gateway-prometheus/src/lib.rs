//! The points of a station as metrics for Prometheus: OpenMetrics text at `/metrics`.

pub mod family;
mod http;
pub mod metrics;

pub use family::names;
pub use http::{PrometheusError, router};

use profivac_gateway::ReadModel;
use profivac_gateway::thread::GatewayThread;
use profivac_station::config::gateways::prometheus::Settings;
use profivac_station::services::Services;
use std::sync::Arc;

/// Starts the gateway.
///
/// # Errors
/// When the system gives no thread.
pub fn start(settings: Settings, model: Arc<ReadModel>, services: Arc<Services>) -> std::io::Result<GatewayThread> {
    GatewayThread::start("prometheus", model, services, move |context| http::serve(settings.clone(), context))
}
