//! What the station accepts of users who change alarms, whether they use the API or a gateway.

use profivac_web_server::visible_text::{TextProblem, check_line};
use std::ops::RangeInclusive;
use std::time::Duration;

/// The longest reason, in characters.
const MAX_REASON: usize = 500;

/// The longest time on the shelf, in minutes: a shift of twelve hours. chosen; ISA-18.2 demands a limit.
pub const MAX_SHELVED_MINUTES: u32 = 720;

/// The times for which an alarm is shelved.
pub const SHELVED: RangeInclusive<Duration> =
    Duration::from_secs(60)..=Duration::from_secs(MAX_SHELVED_MINUTES as u64 * 60);

/// The fault of a reason.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum ReasonError {
    /// It is empty or too long.
    #[error("expected a reason in one line of 1 to {MAX_REASON} characters")]
    Length,
    /// It is no line of text.
    #[error("reason: {0}")]
    Text(#[from] TextProblem),
}

/// The reason of a user without blanks around it.
///
/// # Errors
/// [`ReasonError`] if it is no line of 1 to 500 characters.
pub fn checked_reason(reason: &str) -> Result<String, ReasonError> {
    let reason = reason.trim();
    if !(1..=MAX_REASON).contains(&reason.chars().count()) {
        return Err(ReasonError::Length);
    }
    check_line(reason)?;
    Ok(reason.to_owned())
}
