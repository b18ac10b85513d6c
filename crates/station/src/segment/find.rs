//! The search for a gauge at its address.

use crate::config;
use profivac_client::ClientError;
use profivac_client::cyclic::CyclicSlave;
use profivac_client::discover::CyclicError;
use profivac_client::identify;
use profivac_client::ms2::Ms2;
use profivac_client::records::{RecordError, Unavailable};
use profivac_devices::catalog::KnownDevices;
use profivac_devices::model::Model;
use profivac_dp::master::SlaveListError;
use profivac_host::port::PortError;
use profivac_host::scan;
use profivac_host::session::{BusSession, SessionError};

/// The reason why a gauge cannot be brought into data exchange.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum FindError {
    /// The port was lost.
    #[error(transparent)]
    Port(PortError),
    /// No slave answers at its address.
    #[error("no slave answers")]
    NoAnswer,
    /// The bus does not allow requests.
    #[error(transparent)]
    Session(SessionError),
    /// The slave cannot exchange data with this station.
    #[error(transparent)]
    Slave(CyclicError),
    /// All MS2 connections of the slave are in use, so its unit cannot be read.
    #[error(
        "waiting for an MS2 connection left by an earlier connection, for example of a station that was killed: its unit is read over \
         MS2, and the gauge closes an abandoned connection within 15 s"
    )]
    NoConnection,
    /// Another device has the address.
    #[error("it is a {found}, the station's file says {configured}")]
    OtherDevice {
        /// The device on the bus.
        found: &'static str,
        /// The device in the file.
        configured: String,
    },
    /// The master does not take it.
    #[error(transparent)]
    Rejected(#[from] SlaveListError),
}

impl From<SessionError> for FindError {
    fn from(error: SessionError) -> Self {
        match error {
            SessionError::Port(error) => Self::Port(error),
            error => Self::Session(error),
        }
    }
}

impl From<CyclicError> for FindError {
    fn from(error: CyclicError) -> Self {
        match error {
            CyclicError::Session(error) => error.into(),
            CyclicError::Client(ClientError::Unavailable { reason: Unavailable::NoConnection, .. })
            | CyclicError::UnreadableUnit { error: RecordError::Unavailable(Unavailable::NoConnection), .. } => {
                Self::NoConnection
            }
            error => Self::Slave(error),
        }
    }
}

/// Searches for a gauge at its address: a slave that answers, that no other master owns, and that is the configured device.
pub fn find_gauge(
    devices: KnownDevices,
    session: &mut BusSession,
    gauge: &config::Gauge,
    master: u8,
) -> Result<CyclicSlave, FindError> {
    // A probe takes less time than waiting for a slave that is absent.
    let status = scan::probe(session, gauge.address)?.and_then(|station| station.slave).ok_or(FindError::NoAnswer)?;
    // The file names the device: another one with its Ident_Number is not meant.
    let devices = if status.ident == gauge.device.ident { devices.narrowed_to(gauge.device) } else { devices };
    let found = CyclicSlave::find_among(devices, session, gauge.address, master)?;
    let configured = gauge.device;
    // A model that the search only assumes is no reason to doubt the file: the model is read again.
    let reported = if configured.ident == found.model.ident && configured.name != found.model.name {
        identify::reported_model(devices, found.model.ident, &mut Ms2::new(session, gauge.address))
    } else {
        None
    };
    as_configured(found, reported, configured)
}

/// The found slave as the configured device. Devices that share an ident number differ in the model that they report; TPG300
/// and TPG500 report none.
fn as_configured(
    found: CyclicSlave,
    reported: Option<&'static Model>,
    model: &'static Model,
) -> Result<CyclicSlave, FindError> {
    let is_other = |other: &Model| other.name != model.name;
    let other =
        if model.ident == found.model.ident { reported.filter(|other| is_other(other)) } else { Some(found.model) };
    if let Some(other) = other {
        return Err(FindError::OtherDevice { found: other.name, configured: model.name.to_owned() });
    }
    let configuration = model.configuration(found.configuration.octets).unwrap_or(found.configuration);
    Ok(CyclicSlave { model, configuration, unit: model.unit(found.unit.code).unwrap_or(found.unit), ..found })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_gauge_whose_connections_are_in_use_is_told_as_waiting_for_them() {
        let unreadable = |error: RecordError| FindError::from(CyclicError::UnreadableUnit { address: 5, error });
        let waiting = unreadable(Unavailable::NoConnection.into()).to_string();
        assert!(waiting.starts_with("waiting for an MS2 connection left by an earlier connection"), "{waiting}");
        let other = unreadable(Unavailable::NoMs1.into()).to_string();
        assert!(other.starts_with("the unit of the slave at address 5 cannot be read: "), "{other}");
    }
}
