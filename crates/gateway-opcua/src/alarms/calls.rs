//! What a call of a method does: acknowledging and shelving for users who log in, and the refresh.

use super::ANONYMOUS;
use super::condition::Condition;
use super::conditions::Conditions;
use super::method::Method;
use opcua_server::node_manager::RequestContext;
use opcua_types::{ByteString, LocalizedText, NodeId, StatusCode, Variant};
use profivac_gateway::{WriteError, WriteRequest};
use profivac_station::alarm::registry::AlarmError;
use profivac_station::alarm::{AlarmServiceError, AlarmState};
use std::cmp::Ordering;
use std::sync::Arc;
use std::time::Duration;

/// The reason of a shelving for which the client gives none.
const NO_REASON: &str = "shelved over OPC UA";

/// A call that is refused: the status for the client, and why in words.
type Refusal = (StatusCode, String);

impl Conditions {
    /// Calls a method of a condition.
    ///
    /// # Errors
    /// The status for the client.
    pub async fn call(
        &self,
        context: &RequestContext,
        object: &NodeId,
        method: &NodeId,
        arguments: &[Variant],
    ) -> Result<(), StatusCode> {
        match (method_of(method)?, arguments) {
            (Method::Refresh, [Variant::UInt32(subscription)]) => self.refresh(context, *subscription, None),
            (Method::Refresh2, [Variant::UInt32(subscription), Variant::UInt32(item)]) => {
                self.refresh(context, *subscription, Some(*item))
            }
            _ => self.call_as(&context.token.0, object, method, arguments).await,
        }
    }

    /// Calls a method other than a refresh, for this user.
    ///
    /// # Errors
    /// The status for the client.
    pub async fn call_as(
        &self,
        user: &str,
        object: &NodeId,
        method: &NodeId,
        arguments: &[Variant],
    ) -> Result<(), StatusCode> {
        let method = method_of(method)?;
        if method == Method::Enable && arguments.is_empty() {
            return Err(StatusCode::BadConditionAlreadyEnabled);
        }
        let done = match change_of(method, arguments)? {
            Change::Refused(status, reason) => Err((status, reason.to_owned())),
            change => {
                let condition = self.find(object).ok_or(StatusCode::BadNodeIdUnknown)?;
                self.change(user, &condition, change).await
            }
        };
        done.map_err(|(status, reason)| {
            self.status.refused(&format!("a call of {user}: {reason}"));
            status
        })
    }

    async fn change(&self, user: &str, condition: &Condition, change: Change) -> Result<(), Refusal> {
        let denied = |reason: &str| (StatusCode::BadUserAccessDenied, reason.to_owned());
        let commander = self.commander.as_ref().ok_or_else(|| denied("the gateway is read-only"))?;
        if user == ANONYMOUS {
            return Err(denied("only users who log in change alarms"));
        }
        let alarm = Arc::clone(&condition.alarm);
        let request = match change {
            Change::Acknowledge(event) => {
                let unknown = || (StatusCode::BadEventIdUnknown, "the event is not of this alarm".to_owned());
                let occurrence = condition.occurrence_of(&event).ok_or_else(unknown)?;
                WriteRequest::Acknowledge { alarm, occurrence }
            }
            Change::Shelve(time, reason) => WriteRequest::Shelve { alarm, reason, time },
            Change::Unshelve => WriteRequest::Unshelve { alarm },
            Change::Refused(status, reason) => return Err((status, reason.to_owned())),
        };
        let inapplicable = inapplicable(&request);
        let done = commander.execute(user, request, None).await;
        done.map_err(|error| (status_of(&error, inapplicable), error.to_string()))
    }
}

fn method_of(node: &NodeId) -> Result<Method, StatusCode> {
    Method::of_type(node).or_else(|| Method::of_instance(node)).ok_or(StatusCode::BadMethodInvalid)
}

/// What a call asks for.
#[derive(Clone, Debug, PartialEq)]
enum Change {
    /// The acknowledgement of the occurrence that this event tells of.
    Acknowledge(ByteString),
    /// Shelving for a time, with the reason.
    Shelve(Duration, String),
    /// The end of shelving.
    Unshelve,
    /// What the gateway refuses every user.
    Refused(StatusCode, &'static str),
}

/// The change that a method makes with these arguments.
fn change_of(method: Method, arguments: &[Variant]) -> Result<Change, StatusCode> {
    let denied = |reason| Change::Refused(StatusCode::BadUserAccessDenied, reason);
    Ok(match (method, arguments) {
        (Method::Acknowledge, [Variant::ByteString(event), _comment]) => Change::Acknowledge(event.clone()),
        (Method::TimedShelve, [Variant::Double(time)]) => shelve(*time, ""),
        (Method::TimedShelve2, [Variant::Double(time), Variant::LocalizedText(reason)]) => {
            shelve(*time, text_of(reason))
        }
        (Method::Unshelve, []) => Change::Unshelve,
        (Method::OneShotShelve, []) => {
            Change::Refused(StatusCode::BadNotExecutable, "the station shelves alarms for a time only")
        }
        (Method::Disable, []) => denied("an alarm is not disabled"),
        (Method::AddComment, [_, _]) => denied("comments are not kept"),
        (method, arguments) => return Err(mismatch(method, arguments.len())),
    })
}

/// The status of a call whose arguments are not those of the method.
fn mismatch(method: Method, given: usize) -> StatusCode {
    match given.cmp(&method.arguments().len()) {
        Ordering::Less => StatusCode::BadArgumentsMissing,
        Ordering::Equal => StatusCode::BadInvalidArgument,
        Ordering::Greater => StatusCode::BadTooManyArguments,
    }
}

/// Shelving for this time in milliseconds.
fn shelve(milliseconds: f64, reason: &str) -> Change {
    let reason = if reason.trim().is_empty() { NO_REASON } else { reason };
    match Duration::try_from_secs_f64(milliseconds / 1e3) {
        Ok(time) => Change::Shelve(time, reason.to_owned()),
        Err(_) => Change::Refused(StatusCode::BadShelvingTimeOutOfRange, "the time is no time"),
    }
}

fn text_of(text: &LocalizedText) -> &str {
    text.text.value().as_deref().unwrap_or_default()
}

/// The status for a state of the alarm that does not allow a request.
fn inapplicable(request: &WriteRequest) -> fn(AlarmState) -> StatusCode {
    match request {
        WriteRequest::Shelve { .. } => |state| match state {
            AlarmState::Shelved => StatusCode::BadConditionAlreadyShelved,
            _ => StatusCode::BadInvalidState,
        },
        WriteRequest::Unshelve { .. } => |_| StatusCode::BadConditionNotShelved,
        _ => |_| StatusCode::BadConditionBranchAlreadyAcked,
    }
}

/// The status of a change that was not made.
fn status_of(error: &WriteError, inapplicable: fn(AlarmState) -> StatusCode) -> StatusCode {
    match error {
        WriteError::Busy => StatusCode::BadTooManyOperations,
        WriteError::Users(_) | WriteError::UnknownUser(_) | WriteError::Forbidden(_) => StatusCode::BadUserAccessDenied,
        WriteError::ShelvingTime(_) => StatusCode::BadShelvingTimeOutOfRange,
        WriteError::Reason(_) => StatusCode::BadInvalidArgument,
        WriteError::Alarm(AlarmServiceError::Refused(
            AlarmError::OccurrenceChanged { .. } | AlarmError::Unknown(_),
        )) => StatusCode::BadEventIdUnknown,
        WriteError::Alarm(AlarmServiceError::Refused(AlarmError::NotApplicable { state, .. })) => inapplicable(*state),
        WriteError::Alarm(AlarmServiceError::NotStored) => StatusCode::BadResourceUnavailable,
        _ => StatusCode::BadInternalError,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_call_has_the_arguments_of_its_method() {
        let (minute, reason) = (Variant::Double(60_000.0), Variant::from(LocalizedText::new("", "the lock is vented")));
        let shelve = |reason: &str| Change::Shelve(Duration::from_secs(60), reason.to_owned());
        assert_eq!(change_of(Method::TimedShelve, std::slice::from_ref(&minute)), Ok(shelve(NO_REASON)));
        assert_eq!(change_of(Method::TimedShelve2, &[minute.clone(), reason]), Ok(shelve("the lock is vented")));
        let none = Variant::from(LocalizedText::null());
        assert_eq!(change_of(Method::TimedShelve2, &[minute.clone(), none]), Ok(shelve(NO_REASON)));
        assert_eq!(change_of(Method::Unshelve, &[]), Ok(Change::Unshelve));
        for (method, arguments, status) in [
            (Method::TimedShelve, vec![], StatusCode::BadArgumentsMissing),
            (Method::TimedShelve, vec![Variant::Float(60_000.0)], StatusCode::BadInvalidArgument),
            (Method::TimedShelve2, vec![minute.clone(), minute.clone()], StatusCode::BadInvalidArgument),
            (Method::Acknowledge, vec![minute.clone(), minute.clone()], StatusCode::BadInvalidArgument),
            (Method::Unshelve, vec![minute.clone()], StatusCode::BadTooManyArguments),
            (Method::Refresh2, vec![Variant::UInt32(1)], StatusCode::BadArgumentsMissing),
            (Method::Refresh, vec![Variant::Int32(1)], StatusCode::BadInvalidArgument),
        ] {
            assert_eq!(change_of(method, &arguments), Err(status), "{method:?}");
        }
    }

    #[test]
    fn a_time_that_is_none_is_refused() {
        for time in [-1.0, f64::NAN, f64::INFINITY, 1e300] {
            let found = change_of(Method::TimedShelve, &[Variant::Double(time)]);
            assert!(matches!(found, Ok(Change::Refused(StatusCode::BadShelvingTimeOutOfRange, _))), "{time}");
        }
        let found = change_of(Method::OneShotShelve, &[]);
        assert!(matches!(found, Ok(Change::Refused(StatusCode::BadNotExecutable, _))));
    }
}
