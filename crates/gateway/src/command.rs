//! Writing: the one path on which a client of a control system changes a gauge or acknowledges an alarm.
//!
//! ```text
//! request of a client ── user of the gateway's table ── role ── control authority ── conditions ── audit trail ── gauge
//! ```
//!
//! The steps are those of the HTTP API. A gateway that may write has a [`Commander`]; a refusal comes back as a sentence.

use crate::point::{Point, Subject, Value};
use crate::signal::Signal;
use profivac_client::names::{ParameterNames, Target};
use profivac_devices::catalog::model_named;
use profivac_devices::model::{AccessPath, Direction};
use profivac_station::alarm::AlarmServiceError;
use profivac_station::auth::users::{Users, UsersError};
use profivac_station::auth::{Actor, Forbidden, Role};
use profivac_station::config::gateways::write::Write;
use profivac_station::control::ControlError;
use profivac_station::control::operation::{GivenValue, OperationRequest};
use profivac_station::control::permissions;
use profivac_station::services::Services;
use std::net::IpAddr;
use std::sync::Arc;
use tokio::sync::Semaphore;

/// Requests of one gateway that wait or are being done. free choice: a gauge takes a tenth of a second, a client waits some seconds.
const MAX_WAITING: usize = 8;

/// What a client asks for.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum WriteRequest {
    /// A new value of a parameter.
    Parameter {
        /// The gauge.
        gauge: Arc<str>,
        /// The parameter: `trip-point.1/high-trip-point`.
        target: Arc<str>,
        /// The value with its unit: `1e-3 mbar`, `on`.
        value: String,
    },
    /// A command.
    Command {
        /// The gauge.
        gauge: Arc<str>,
        /// The command: `ba.degas-on`.
        command: String,
    },
    /// The acknowledgement of an alarm.
    Acknowledge {
        /// The alarm.
        alarm: Arc<str>,
        /// The occurrence that the client has seen: a later one stays unacknowledged.
        occurrence: i64,
    },
}

/// The reason why a request of a client was not done.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum WriteError {
    /// Too many requests wait.
    #[error("{MAX_WAITING} requests to write wait already: try again")]
    Busy,
    /// The file of the users cannot be read.
    #[error(transparent)]
    Users(#[from] UsersError),
    /// The user of the gateway does not exist any more.
    #[error("the user {0} of this gateway is no longer in the file of the users")]
    UnknownUser(String),
    /// The role of the user does not allow it.
    #[error(transparent)]
    Forbidden(#[from] Forbidden),
    /// The station, the audit trail or the gauge refuses.
    #[error(transparent)]
    Control(Box<ControlError>),
    /// The alarm cannot be acknowledged.
    #[error(transparent)]
    Alarm(#[from] AlarmServiceError),
    /// The request has failed unexpectedly.
    #[error("the request has failed unexpectedly")]
    Failed,
}

impl From<ControlError> for WriteError {
    fn from(error: ControlError) -> Self {
        Self::Control(Box::new(error))
    }
}

/// Does what clients of one gateway ask for, as the user of its table.
pub struct Commander {
    services: Arc<Services>,
    write: Write,
    places: Arc<Semaphore>,
}

impl Commander {
    /// A commander for these settings.
    #[must_use]
    pub fn new(services: Arc<Services>, write: Write) -> Self {
        Self { services, write, places: Arc::new(Semaphore::new(MAX_WAITING)) }
    }

    /// Whether a computer may write.
    #[must_use]
    pub fn permits(&self, peer: IpAddr) -> bool {
        self.write.permits(peer)
    }

    /// Does what a client asks for. Waits for the gauge and for the disk, up to minutes.
    ///
    /// # Errors
    /// [`WriteError`] says why it was not done.
    pub async fn execute(&self, request: WriteRequest, peer: IpAddr) -> Result<(), WriteError> {
        let place = Arc::clone(&self.places).try_acquire_owned().map_err(|_| WriteError::Busy)?;
        let (services, write) = (Arc::clone(&self.services), self.write.clone());
        let work = move || {
            let _place = place;
            done(&services, &write, request, peer)
        };
        tokio::task::spawn_blocking(work).await.unwrap_or(Err(WriteError::Failed))
    }
}

fn done(services: &Services, write: &Write, request: WriteRequest, peer: IpAddr) -> Result<(), WriteError> {
    // The account may have another role than at the start.
    let users = Users::read(&write.users)?;
    let account = users.get(&write.user).ok_or_else(|| WriteError::UnknownUser(write.user.clone()))?;
    let actor = Actor { user: account.user(), peer: Some(peer) };
    match request {
        WriteRequest::Parameter { gauge, target, value } => {
            let (target, value) = (Some(target.to_string()), Some(GivenValue::Text(value)));
            let operation = OperationRequest { target, value, ..OperationRequest::default() };
            services.control().execute_directly(&actor, &gauge, &operation)?;
        }
        WriteRequest::Command { gauge, command } => {
            let operation = OperationRequest { command: Some(command), ..OperationRequest::default() };
            services.control().execute_directly(&actor, &gauge, &operation)?;
        }
        WriteRequest::Acknowledge { alarm, occurrence } => {
            actor.user.require(Role::Operator, "acknowledging an alarm")?;
            services.alarms().acknowledge(&alarm, occurrence, &actor)?;
        }
    }
    Ok(())
}

/// Whether a point is a parameter that the station writes on this device.
#[must_use]
pub fn is_writable(point: &Point, device: &str) -> bool {
    let Subject::Parameter { target, .. } = &point.subject else { return false };
    let Some(model) = model_named(device) else { return false };
    let Some(names) = ParameterNames::of_catalog(model) else { return false };
    let path = if model.features.dpv1 { AccessPath::Class2 } else { AccessPath::ParameterChannel };
    match names.find(model.name, target) {
        Ok(Target::Parameter(named)) => {
            let row = named.parameter.row;
            row.access.allows(path, Direction::Write) && permissions::blocked_reason(row).is_none()
        }
        _ => false,
    }
}

/// The value of a parameter as the station reads it: a pressure has its unit, a code its word.
#[must_use]
pub fn given(signal: Signal, value: &Value) -> String {
    match (signal, value) {
        (Signal::ParameterPressure, Value::Float(pa)) => format!("{pa:e} Pa"),
        (_, Value::Float(number)) => number.to_string(),
        (_, other) => other.to_string(),
    }
}
