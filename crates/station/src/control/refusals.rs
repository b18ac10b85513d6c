//! Refusals for a missing role, as rows of the audit trail: at most one a minute for a user and an action, with a count, so that a
//! client that repeats its requests does not fill the database.

use crate::recording::RecorderHandle;
use profivac_recorder::{AuditAction, AuditEntry};
use profivac_web_server::auth::{Actor, Forbidden, Role};
use std::collections::HashMap;
use std::sync::{Arc, Mutex, PoisonError};
use std::time::{Duration, Instant};

/// The shortest time between two rows about a user and an action.
const PERIOD: Duration = Duration::from_secs(60);

/// The most pairs of user and action that are counted. chosen: more than the parameters of a gauge; a row for each pair beyond.
const MAX_PAIRS: usize = 1_000;

/// What was refused since the last row.
struct Counted {
    since: Instant,
    /// The refusals without a row.
    count: u64,
    /// The last of them.
    last: AuditEntry,
}

/// The refusals of a station.
pub struct Refusals {
    recorder: Arc<RecorderHandle>,
    counted: Mutex<HashMap<(Arc<str>, String), Counted>>,
}

impl Refusals {
    /// No refusals yet.
    #[must_use]
    pub fn new(recorder: Arc<RecorderHandle>) -> Self {
        Self { recorder, counted: Mutex::default() }
    }

    /// Checks the role of a user, and records a refusal.
    ///
    /// # Errors
    /// [`Forbidden`] names `action` and the role that it needs.
    pub fn require(&self, actor: &Actor, needed: Role, action: &str) -> Result<(), Forbidden> {
        actor.user.require(needed, action).inspect_err(|error| self.refused(actor, action, error, Instant::now()))
    }

    fn refused(&self, actor: &Actor, action: &str, error: &Forbidden, now: Instant) {
        let entry = AuditEntry {
            target: Some(action.to_owned()),
            outcome: Some(error.to_string()),
            ..actor.audit_entry(AuditAction::Refused)
        };
        let mut counted = self.counted.lock().unwrap_or_else(PoisonError::into_inner);
        let pair = (Arc::clone(&actor.user.name), action.to_owned());
        match counted.get_mut(&pair) {
            Some(known) => {
                known.count = known.count.saturating_add(1);
                known.last = entry;
            }
            None => {
                if counted.len() < MAX_PAIRS {
                    counted.insert(pair, Counted { since: now, count: 0, last: entry.clone() });
                }
                drop(self.recorder.audit(entry));
            }
        }
        drop(counted);
        self.flush(now);
    }

    /// Writes the row of each pair whose minute is over, with the count of its refusals. To be called every few seconds.
    pub fn flush(&self, now: Instant) {
        let mut counted = self.counted.lock().unwrap_or_else(PoisonError::into_inner);
        counted.retain(|_, Counted { since, count, last }| {
            if now.saturating_duration_since(*since) < PERIOD {
                return true;
            }
            if *count == 0 {
                return false;
            }
            let sentence = last.outcome.clone().unwrap_or_default();
            let outcome = Some(format!("{sentence}; {count} times since the row before"));
            drop(self.recorder.audit(AuditEntry { outcome, ..last.clone() }));
            (*since, *count) = (now, 0);
            true
        });
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use profivac_model::AuditEntry;
    use profivac_recorder::audit::AuditQuery;
    use profivac_recorder::{Micros, Recorder, Settings};
    use profivac_web_server::auth::User;

    #[test]
    fn a_user_who_repeats_a_refused_action_has_one_row_a_minute_with_a_count() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("plant.db");
        let recorder = Recorder::start(&path, Settings::default()).unwrap();
        let refusals = Refusals::new(Arc::new(RecorderHandle::new(recorder, path)));
        let user = |name: &str| Actor { user: User { name: Arc::from(name), role: Role::Viewer }, peer: None };
        let begin = Instant::now();
        let refuse = |name: &str, action: &str, after_s: u64| {
            let actor = user(name);
            let error = actor.user.require(Role::Operator, action).unwrap_err();
            refusals.refused(&actor, action, &error, begin + Duration::from_secs(after_s));
        };
        (0..40).for_each(|second| refuse("eve", "control", second));
        refuse("eve", "device.store", 41);
        refuse("mallory", "control", 42);
        let rows = || -> Vec<AuditEntry> {
            assert!(refusals.recorder.flush());
            let all = AuditQuery { from: Micros(0), to: Micros(i64::MAX), gauge: None, user: None, limit: 100 };
            refusals.recorder.open_reader().unwrap().audit(&all).unwrap()
        };
        assert_eq!(rows().len(), 3, "one for each pair");
        refusals.flush(begin + Duration::from_secs(59));
        assert_eq!(rows().len(), 3, "the minute is not over");
        refusals.flush(begin + PERIOD);
        let latest = rows().remove(0);
        assert_eq!((rows().len(), latest.user.as_str(), latest.target.as_deref()), (4, "eve", Some("control")));
        assert!(latest.outcome.unwrap().ends_with("; 39 times since the row before"));
        refusals.flush(begin + 4 * PERIOD);
        assert_eq!(rows().len(), 4, "nothing was refused meanwhile");
        assert!(refusals.counted.lock().unwrap().is_empty(), "and nothing is kept");
    }
}
