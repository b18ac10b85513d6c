//! Writing: the one path on which a client of a control system changes a gauge or acknowledges an alarm.
//!
//! ```text
//! request of a client ── user of the gateway's table ── role ── control authority ── conditions ── audit trail ── gauge
//! ```
//!
//! The steps are those of the HTTP API. A gateway that may write has a [`Commander`]; a refusal comes back as a sentence.

use crate::model::Snapshot;
use crate::point::{Point, PointValue, Value};
use crate::signal::Signal;
use profivac_station::alarm::{AlarmResult, AlarmServiceError, ReasonError, SHELVED, checked_reason};
use profivac_station::control::ControlError;
use profivac_station::control::operation::{GivenValue, OperationRequest};
use profivac_station::services::Services;
use profivac_web_server::auth::users::{Users, UsersError};
use profivac_web_server::auth::{Actor, Forbidden, Role};
use std::collections::HashSet;
use std::net::IpAddr;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::Duration;
use tokio::sync::Semaphore;

/// Requests of one gateway that wait or are being done. chosen: a gauge takes a tenth of a second, a client waits some seconds.
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
    /// The shelving of an alarm for a time.
    Shelve {
        /// The alarm.
        alarm: Arc<str>,
        /// Why.
        reason: String,
        /// For how long; the station allows [`SHELVED`].
        time: Duration,
    },
    /// The end of the shelving of an alarm.
    Unshelve {
        /// The alarm.
        alarm: Arc<str>,
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
    /// The user does not exist any more.
    #[error("{0} is no longer in the file of the users")]
    UnknownUser(String),
    /// The role of the user does not allow it.
    #[error(transparent)]
    Forbidden(#[from] Forbidden),
    /// The station, the audit trail or the gauge refuses.
    #[error(transparent)]
    Control(Box<ControlError>),
    /// The state of the alarm does not allow it.
    #[error(transparent)]
    Alarm(#[from] AlarmServiceError),
    /// The reason of a shelving is none.
    #[error(transparent)]
    Reason(#[from] ReasonError),
    /// An alarm is not shelved for this time.
    #[error("expected a time from {} to {} min, found {:.1} min", SHELVED.start().as_secs() / 60, SHELVED.end().as_secs() / 60, .0.as_secs_f64() / 60.0)]
    ShelvingTime(Duration),
    /// The request has failed unexpectedly.
    #[error("the request has failed unexpectedly")]
    Failed,
}

impl From<ControlError> for WriteError {
    fn from(error: ControlError) -> Self {
        Self::Control(Box::new(error))
    }
}

/// Does what clients of one gateway ask for, as a user of the station.
pub struct Commander {
    services: Arc<Services>,
    users: PathBuf,
    permits: Arc<Semaphore>,
}

impl Commander {
    /// A commander for the users of this file.
    #[must_use]
    pub fn new(services: Arc<Services>, users: PathBuf) -> Self {
        Self { services, users, permits: Arc::new(Semaphore::new(MAX_WAITING)) }
    }

    /// Does what a client at this address asks for, as the user of this name. Waits for the gauge and for the disk, up to minutes.
    ///
    /// # Errors
    /// [`WriteError`] says why it was not done.
    pub async fn execute(&self, user: &str, request: WriteRequest, peer: Option<IpAddr>) -> Result<(), WriteError> {
        let permit = Arc::clone(&self.permits).try_acquire_owned().map_err(|_| WriteError::Busy)?;
        let (services, users, user) = (Arc::clone(&self.services), self.users.clone(), user.to_owned());
        let work = move || {
            let _permit = permit;
            done(&services, &users, &user, request, peer)
        };
        tokio::task::spawn_blocking(work).await.unwrap_or(Err(WriteError::Failed))
    }
}

fn done(
    services: &Services,
    users: &Path,
    user: &str,
    request: WriteRequest,
    peer: Option<IpAddr>,
) -> Result<(), WriteError> {
    // The account may have another role than at the start or at the login.
    let users = Users::read(users)?;
    let account = users.get(user).ok_or_else(|| WriteError::UnknownUser(user.to_owned()))?;
    let actor = Actor { user: account.user(), peer };
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
        WriteRequest::Shelve { alarm, reason, time } => {
            actor.user.require(Role::Operator, "shelving an alarm")?;
            let reason = checked_reason(&reason)?;
            if !SHELVED.contains(&time) {
                return Err(WriteError::ShelvingTime(time));
            }
            first(services.alarms().shelve_all(vec![alarm.to_string()], &actor, &reason, time))?;
        }
        WriteRequest::Unshelve { alarm } => {
            actor.user.require(Role::Operator, "unshelving an alarm")?;
            first(services.alarms().unshelve_all(vec![alarm.to_string()], &actor))?;
        }
    }
    Ok(())
}

/// The result of a change of one alarm.
fn first(results: Vec<AlarmResult>) -> Result<(), WriteError> {
    results.into_iter().try_for_each(|(_, done)| Ok(done?))
}

/// The gauges that this station controls; those of other masters are left out.
#[must_use]
pub fn controlled_gauges(snapshot: &Snapshot) -> HashSet<&str> {
    let is_own = |(point, value): &(&Point, &PointValue)| {
        point.signal == Signal::ListenOnly && value.value == Value::Boolean(false)
    };
    snapshot.iter().filter(is_own).filter_map(|(point, _)| point.subject.gauge()).collect()
}

/// The value of a parameter as the station reads it: a pressure and a percentage have their unit, a code its word.
#[must_use]
pub fn given(signal: Signal, value: &Value) -> String {
    match (signal, value) {
        (Signal::ParameterPressure, Value::Float(pa)) => format!("{pa:e} Pa"),
        // A client may send a float of 32 bits: 5.1 is 5.099999905 then.
        (Signal::ParameterPercentage, Value::Float(percent)) => format!("{} %", (percent * 1e4).round() / 1e4),
        (Signal::ParameterPercentage, Value::Integer(percent)) => format!("{percent} %"),
        (_, Value::Float(number)) => number.to_string(),
        (_, other) => other.to_string(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_number_that_a_client_writes_has_the_unit_of_its_point() {
        assert_eq!(given(Signal::ParameterPressure, &Value::Float(0.5)), "5e-1 Pa");
        assert_eq!(given(Signal::ParameterPercentage, &Value::Float(5.0)), "5 %");
        assert_eq!(given(Signal::ParameterPercentage, &Value::Float(120.1_f32.into())), "120.1 %");
        assert_eq!(given(Signal::ParameterPercentage, &Value::Integer(5)), "5 %");
        assert_eq!(given(Signal::ParameterNumber, &Value::Float(3.0)), "3");
    }
}
