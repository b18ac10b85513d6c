//! Notes of users in the list of events.

use super::names::not_found;
use crate::services::Services;
use axum::Json;
use axum::extract::State;
use profivac_model::{Event, EventKind, Micros};
use profivac_recorder::AuditError;
use profivac_web_server::auth::{Actor, Role};
use profivac_web_server::body::Body;
use profivac_web_server::problem::{Problem, task_failed};
use profivac_web_server::visible_text::check_line;
use serde::Deserialize;
use std::sync::Arc;
use utoipa::ToSchema;

/// The longest note, in characters.
const MAX_NOTE: usize = 500;

/// What a user notes.
#[derive(Debug, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct NewNote {
    /// One line of 1 to 500 characters.
    #[schema(min_length = 1, max_length = 500, example = "the cold trap is filled")]
    text: String,
    /// The time that the note is about, in milliseconds since 1970, not after the present; without it the present.
    #[schema(minimum = 0, example = 1_767_225_600_000_i64)]
    at_ms: Option<i64>,
    /// The name of the gauge that the note is about.
    #[schema(example = "chamber")]
    gauge: Option<String>,
}

/// Make a note
///
/// The note is an event of the kind `note` with the name of the user. The database has it before the answer.
#[utoipa::path(
    post,
    path = "/api/notes",
    request_body = NewNote,
    responses(
        (status = 200, body = Event),
        (status = 400, body = Problem, description = "The body is malformed, or something in it is out of range"),
        (status = 403, body = Problem, description = "The role operator is needed"),
        (status = 404, body = Problem, description = "There is no gauge of this name"),
        (status = 503, body = Problem, description = "The database cannot be written: the note is not stored, unless the answer says that the disk did not answer in time")
    )
)]
pub async fn make(
    State(services): State<Arc<Services>>,
    actor: Actor,
    Body(note): Body<NewNote>,
) -> Result<Json<Event>, Problem> {
    services.control().refusals().require(&actor, Role::Operator, "making a note")?;
    let text = checked_text(&note.text)?;
    let at = checked_time(note.at_ms, Micros::now())?;
    if let Some(gauge) = &note.gauge {
        services.snapshots().gauge_named(gauge).map_err(not_found)?;
    }
    let event = Event {
        at,
        gauge: note.gauge,
        kind: EventKind::Note.into(),
        text: format!("{} noted: {text}", actor.user.name),
    };
    let noted = event.clone();
    let stored = tokio::task::spawn_blocking(move || services.recorder().record_event_or_nothing(event))
        .await
        .map_err(|error| task_failed(&error))?;
    match stored {
        Ok(()) => Ok(Json(noted)),
        Err(AuditError::Timeout) => Err(Problem::unavailable(
            "the disk did not answer in time; look whether the events have the note before you make it again",
        )),
        Err(error) => Err(Problem::unavailable(format!("the note is not stored, and will not be: {error}"))),
    }
}

/// The text without blanks around it.
fn checked_text(text: &str) -> Result<&str, Problem> {
    let text = text.trim();
    if !(1..=MAX_NOTE).contains(&text.chars().count()) {
        return Err(Problem::bad_request(format!("expected a note in one line of 1 to {MAX_NOTE} characters")));
    }
    check_line(text).map_err(|error| Problem::bad_request(format!("text: {error}")))?;
    Ok(text)
}

/// The time of a note, `now` without one.
fn checked_time(at_ms: Option<i64>, now: Micros) -> Result<Micros, Problem> {
    let Some(at_ms) = at_ms else { return Ok(now) };
    let at = at_ms.checked_mul(1000).map(Micros).filter(|at| (Micros(0)..=now).contains(at));
    at.ok_or_else(|| Problem::bad_request(format!("at_ms: expected a time since 1970 that has passed, found {at_ms}")))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_note_is_one_line_without_blanks_around_it() {
        assert_eq!(checked_text("  the trap is filled ").ok(), Some("the trap is filled"));
        assert_eq!(checked_text(&"ü".repeat(MAX_NOTE)).map(|text| text.chars().count()).ok(), Some(MAX_NOTE));
        for wrong in ["", "  ", &"x".repeat(MAX_NOTE + 1), "two\nlines", "a\u{202e}b"] {
            assert!(checked_text(wrong).is_err(), "{wrong:?}");
        }
    }

    #[test]
    fn a_note_is_about_a_time_that_has_passed() {
        let now = Micros(5_000_000);
        assert_eq!(checked_time(None, now).ok(), Some(now));
        assert_eq!(checked_time(Some(0), now).ok(), Some(Micros(0)));
        assert_eq!(checked_time(Some(5_000), now).ok(), Some(now));
        for wrong in [-1, 5_001, i64::MAX, i64::MIN] {
            assert!(checked_time(Some(wrong), now).is_err(), "{wrong}");
        }
    }
}
