//! The settings of the gateways to control systems.

pub mod archive;
pub mod epics;
pub mod modbus;
pub mod mqtt;
pub mod opcua;
pub mod prometheus;
pub mod write;

use std::net::SocketAddr;
use write::Write;

/// The settings of a gateway.
#[derive(Clone, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum GatewaySettings {
    /// `[archive]`.
    Archive(Box<archive::Settings>),
    /// `[epics]`.
    Epics(epics::Settings),
    /// `[mqtt]`.
    Mqtt(Box<mqtt::Settings>),
    /// `[modbus]`.
    Modbus(modbus::Settings),
    /// `[opcua]`.
    Opcua(opcua::Settings),
    /// `[prometheus]`.
    Prometheus(prometheus::Settings),
}

impl GatewaySettings {
    /// The name of its table, which is also that of the gateway.
    #[must_use]
    pub const fn name(&self) -> &'static str {
        match self {
            Self::Archive(_) => "archive",
            Self::Epics(_) => "epics",
            Self::Mqtt(_) => "mqtt",
            Self::Modbus(_) => "modbus",
            Self::Opcua(_) => "opcua",
            Self::Prometheus(_) => "prometheus",
        }
    }

    /// The broker or server on another computer to which it connects without encryption.
    #[must_use]
    pub fn unencrypted_broker(&self) -> Option<&str> {
        match self {
            Self::Archive(it) => it.transport.exposed(),
            Self::Mqtt(it) => it.broker.exposed(),
            Self::Epics(_) | Self::Modbus(_) | Self::Opcua(_) | Self::Prometheus(_) => None,
        }
    }

    /// Where it listens for other computers without encryption and login, because its protocol has none.
    #[must_use]
    pub fn unprotected(&self) -> Option<String> {
        match self {
            Self::Epics(settings) => settings.is_open_to_network().then(|| settings.addresses()),
            Self::Modbus(settings) => (!settings.listen.ip().is_loopback()).then(|| settings.listen.to_string()),
            Self::Archive(_) | Self::Mqtt(_) | Self::Opcua(_) | Self::Prometheus(_) => None,
        }
    }

    /// The addresses on which it listens. The ports of EPICS are shared with other servers, so only its addresses count, with port 0.
    #[must_use]
    pub fn listens_on(&self) -> Vec<SocketAddr> {
        match self {
            Self::Epics(it) => it.interfaces.iter().map(|interface| (interface.address, 0).into()).collect(),
            Self::Modbus(it) => vec![it.listen],
            Self::Opcua(it) => vec![it.listen],
            Self::Prometheus(it) => vec![it.listen],
            Self::Archive(_) | Self::Mqtt(_) => Vec::new(),
        }
    }

    /// As which user its clients write, where they may.
    #[must_use]
    pub fn writer(&self) -> Option<&Write> {
        match self {
            Self::Epics(settings) => settings.write.as_ref(),
            Self::Archive(_) | Self::Modbus(_) | Self::Mqtt(_) | Self::Opcua(_) | Self::Prometheus(_) => None,
        }
    }

    /// Whether its table holds secrets or names the files that hold them.
    #[must_use]
    pub fn is_private(&self) -> bool {
        match self {
            Self::Archive(it) => it.transport.is_private(),
            Self::Epics(_) | Self::Modbus(_) | Self::Opcua(_) => false,
            Self::Mqtt(it) => {
                it.broker.credentials.is_some() || it.broker.tls.as_ref().is_some_and(|tls| tls.client.is_some())
            }
            Self::Prometheus(settings) => settings.token.is_some(),
        }
    }
}
