//! The points of a station for MQTT: plain topics, Home Assistant's discovery and Sparkplug B.
//!
//! ```text
//! snapshots ── tracker ──┬── plain topics ──────── connection ──▶ broker
//! record ──── backlog ───┴── Sparkplug edge node ── connection ──▶ broker
//! ```
//!
//! A will belongs to a connection, and plain topics and Sparkplug have different wills; so each has a connection of its own. The gateway
//! publishes and takes no writes: the only command that it executes is Sparkplug's rebirth.

pub mod connection;
pub mod message;
pub mod names;
pub mod plain;
mod retry;
pub mod sparkplug;
pub mod topic;
pub mod tracker;

use profivac_gateway::ReadModel;
use profivac_gateway::thread::GatewayThread;
use profivac_station::config::gateways::mqtt::Settings;
use profivac_station::services::Services;
use std::sync::Arc;

/// Starts the gateway: a thread for the plain topics, and one for Sparkplug.
///
/// # Errors
/// When the system gives no thread.
pub fn start(
    settings: &Settings,
    model: &Arc<ReadModel>,
    services: &Arc<Services>,
) -> std::io::Result<Vec<GatewayThread>> {
    let mut threads = Vec::new();
    if let Some(plain) = &settings.plain {
        let (broker, plain) = (settings.broker.clone(), plain.clone());
        let serve = move |context| plain::serve(broker.clone(), plain.clone(), context);
        threads.push(GatewayThread::start("mqtt", Arc::clone(model), Arc::clone(services), serve)?);
    }
    if let Some(sparkplug) = &settings.sparkplug {
        let (broker, sparkplug) = (settings.broker.clone(), sparkplug.clone());
        let serve = move |context| sparkplug::serve(broker.clone(), sparkplug.clone(), context);
        threads.push(GatewayThread::start("sparkplug", Arc::clone(model), Arc::clone(services), serve)?);
    }
    Ok(threads)
}
