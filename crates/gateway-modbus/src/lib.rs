//! The points of a station as registers of Modbus TCP: functions 3, 4 and 43/14, nothing that writes.

pub mod image;
pub mod map;
pub mod pdu;
mod server;

pub use map::names;
pub use server::ModbusError;

use profivac_gateway::ReadModel;
use profivac_gateway::thread::GatewayThread;
use profivac_station::config::gateways::modbus::Settings;
use profivac_station::services::Services;
use std::sync::Arc;

/// Starts the gateway.
///
/// # Errors
/// When the system gives no thread.
pub fn start(settings: Settings, model: Arc<ReadModel>, services: Arc<Services>) -> std::io::Result<GatewayThread> {
    GatewayThread::start("modbus", model, services, move |context| server::serve(settings.clone(), context))
}
