//! The points of a station as an OPC UA server.

pub mod abandoned;
pub mod alarms;
pub mod certificates;
pub mod filters;
pub mod history;
pub mod manager;
pub mod plan;
pub mod relay;
pub mod server;
pub mod space;
pub mod standard;
pub mod types;
pub mod users;
pub mod value;

use plan::{DataType, NodeKind, Property};
use profivac_gateway::thread::GatewayThread;
use profivac_gateway::{NameTable, Point, ReadModel};
use profivac_station::config::gateways::opcua::Settings;
use profivac_station::services::Services;
use std::net::SocketAddr;
use std::path::PathBuf;
use std::sync::Arc;

/// The reason why the gateway does not serve.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum OpcuaError {
    /// The address cannot be used.
    #[error("cannot listen on {address}: {error}")]
    Listen {
        /// The address.
        address: SocketAddr,
        /// The error of the operating system.
        error: std::io::Error,
    },
    /// The folder of the certificates cannot be used.
    #[error("the folder of the certificates {} cannot be used: {error}", folder.display())]
    Certificates {
        /// The folder.
        folder: PathBuf,
        /// The error.
        error: String,
    },
    /// The library refuses the settings.
    #[error("the server cannot be made: {0}")]
    Build(String),
    /// The server of the library has ended with this error.
    #[error("the server has ended: {0}")]
    Server(String),
    /// A task has failed unexpectedly.
    #[error("{0} has failed unexpectedly")]
    Task(&'static str),
}

/// Starts the gateway.
///
/// # Errors
/// When the system gives no thread.
pub fn start(settings: Settings, model: Arc<ReadModel>, services: Arc<Services>) -> std::io::Result<GatewayThread> {
    GatewayThread::start("opcua", model, services, move |context| server::serve(settings.clone(), context))
}

/// The variables that the gateway publishes.
#[must_use]
pub fn names(points: &[Point]) -> NameTable {
    let mut table = NameTable::new(&["node", "type", "unit", "history", "description"]);
    for node in plan::nodes(points) {
        let NodeKind::Variable { data_type, properties, history, .. } = &node.kind else { continue };
        let unit = properties.iter().find_map(|property| match property {
            Property::EngineeringUnits(unit) => Some(unit.symbol),
            _ => None,
        });
        let has_words = *data_type == DataType::UInt32;
        table.push([
            format!("nsu={};s={}", plan::NAMESPACE, node.id),
            if has_words { "UInt32, EnumStrings".to_owned() } else { format!("{data_type:?}") },
            unit.unwrap_or_default().to_owned(),
            if history.is_some() { "yes" } else { "" }.to_owned(),
            node.description,
        ]);
    }
    table
}
