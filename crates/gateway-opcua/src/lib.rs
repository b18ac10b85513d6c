//! The points of a station as an OPC UA server.
//!
//! | Module | Holds |
//! |---|---|
//! | [`plan`] | the nodes of a station: identifiers, browse names, places |
//! | [`value`] | values of points as values of OPC UA |
//! | [`space`] | the nodes in the address space of the library |
//! | [`history`] | raw history from the record |
//! | [`users`] | logins |
//! | [`certificates`] | the folder of the certificates |
//! | [`relay`] | connections: their number, and clients that take no answers |
//! | [`manager`] | the station's part of the server |
//! | [`server`] | endpoints, limits, the loop that brings new values |

pub mod certificates;
pub mod history;
pub mod manager;
pub mod plan;
pub mod relay;
pub mod server;
pub mod space;
pub mod users;
pub mod value;

use plan::{DataType, NodeKind, Property, Source};
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
    /// The server of the library ended.
    #[error("the server ended: {0}")]
    Server(String),
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
        let NodeKind::Variable { source, data_type, properties, history } = &node.kind else { continue };
        let unit = properties.iter().find_map(|property| match property {
            Property::EngineeringUnits(unit) => Some(unit.symbol),
            _ => None,
        });
        let has_words = matches!(source, Source::Health(_)) || *data_type == DataType::UInt32;
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
