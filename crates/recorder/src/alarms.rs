//! Alarm states, their history, declared plant states, and the notifications that wait for delivery: tables beside the samples, written in
//! the same transactions as events and audit entries.

use super::audit;
use super::error::DatabaseError;
use super::reader::Reader;
use profivac_model::{
    AlarmHistoryEntry, AlarmState, AlarmStatus, Attribution, AuditEntry, Declaration, Micros, Priority, Suppression,
    Word,
};
use rusqlite::{Connection, Row, Transaction, params};
use std::collections::BTreeMap;

/// A message that waits for delivery to a webhook.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Notification {
    /// Its number; 0 before it is stored.
    pub id: i64,
    /// The name of the webhook.
    pub webhook: String,
    /// When it was written.
    pub at: Micros,
    /// Its body, a JSON object.
    pub body: String,
}

/// Changes that are written in one transaction.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct AlarmBatch {
    /// The new states of alarms by name; `None` removes an alarm.
    pub alarms: BTreeMap<String, Option<AlarmStatus>>,
    /// The declared plant states by name; `None` for one that has ended.
    pub plant_states: BTreeMap<String, Option<Declaration>>,
    /// Rows of the history.
    pub history: Vec<AlarmHistoryEntry>,
    /// Rows of the audit trail.
    pub audit: Vec<AuditEntry>,
    /// New notifications.
    pub notifications: Vec<Notification>,
    /// The numbers of notifications that were delivered or given up.
    pub finished_notifications: Vec<i64>,
}

impl AlarmBatch {
    /// Adds a later batch, up to `limit` rows of each kind. Returns how many rows were dropped.
    pub fn append(&mut self, mut later: Self, limit: usize) -> u64 {
        self.alarms.append(&mut later.alarms);
        self.plant_states.append(&mut later.plant_states);
        self.finished_notifications.append(&mut later.finished_notifications);
        let dropped = extend_up_to(&mut self.history, later.history, limit);
        let dropped = dropped.saturating_add(extend_up_to(&mut self.audit, later.audit, limit));
        dropped.saturating_add(extend_up_to(&mut self.notifications, later.notifications, limit))
    }

    /// The changes and rows in it.
    #[must_use]
    pub fn len(&self) -> usize {
        let states = self.alarms.len().saturating_add(self.plant_states.len());
        let rows = self.history.len().saturating_add(self.audit.len()).saturating_add(self.notifications.len());
        states.saturating_add(rows).saturating_add(self.finished_notifications.len())
    }

    /// Whether there is nothing to write.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.alarms.is_empty()
            && self.plant_states.is_empty()
            && self.history.is_empty()
            && self.audit.is_empty()
            && self.notifications.is_empty()
            && self.finished_notifications.is_empty()
    }

    /// Writes the batch.
    pub(super) fn write(&self, transaction: &Transaction<'_>) -> rusqlite::Result<()> {
        for (name, alarm) in &self.alarms {
            match alarm {
                Some(alarm) => upsert_alarm(transaction, name, alarm)?,
                None => delete_alarm(transaction, name)?,
            }
        }
        for (name, state) in &self.plant_states {
            match state {
                Some(state) => upsert_plant_state(transaction, name, state)?,
                None => delete_plant_state(transaction, name)?,
            }
        }
        self.history.iter().try_for_each(|entry| insert_history(transaction, entry))?;
        self.audit.iter().try_for_each(|entry| audit::insert(transaction, entry).map(drop))?;
        for Notification { webhook, at, body, .. } in &self.notifications {
            transaction
                .prepare_cached("INSERT INTO notification (webhook, at_us, body) VALUES (?1, ?2, ?3)")?
                .execute(params![webhook, at.0, body])?;
        }
        for id in &self.finished_notifications {
            transaction.prepare_cached("DELETE FROM notification WHERE id = ?1")?.execute([id])?;
        }
        Ok(())
    }
}

/// Appends `more` as far as `limit` allows. Returns how many items were dropped.
fn extend_up_to<T>(all: &mut Vec<T>, more: Vec<T>, limit: usize) -> u64 {
    let room = limit.saturating_sub(all.len());
    let dropped = more.len().saturating_sub(room);
    all.extend(more.into_iter().take(room));
    dropped as u64
}

fn upsert_alarm(connection: &Connection, name: &str, alarm: &AlarmStatus) -> rusqlite::Result<()> {
    let (acknowledged, out) = (alarm.acknowledged.as_ref(), alarm.suppression.as_ref());
    connection
        .prepare_cached(
            "INSERT OR REPLACE INTO alarm (name, state, since_us, occurrence, raised_us, raised_value, raised_text,
                 acknowledged_by, acknowledged_us, out_of_service_by, out_of_service_us, out_of_service_reason,
                 out_of_service_until_us)
             VALUES (?1, ?2, ?3, ?4, ?5, ?6, ?7, ?8, ?9, ?10, ?11, ?12, ?13)",
        )?
        .execute(params![
            name,
            alarm.state.word(),
            alarm.since.0,
            alarm.occurrence,
            alarm.raised.map(|at| at.0),
            alarm.value,
            alarm.text,
            acknowledged.map(|by| &by.user),
            acknowledged.map(|by| by.at.0),
            out.map(|it| &it.by.user),
            out.map(|it| it.by.at.0),
            out.map(|it| &it.reason),
            out.and_then(|it| it.until).map(|at| at.0),
        ])
        .map(drop)
}

fn delete_alarm(connection: &Connection, name: &str) -> rusqlite::Result<()> {
    connection.prepare_cached("DELETE FROM alarm WHERE name = ?1")?.execute([name]).map(drop)
}

fn upsert_plant_state(connection: &Connection, name: &str, state: &Declaration) -> rusqlite::Result<()> {
    let Declaration { by, reason, until } = state;
    connection
        .prepare_cached(
            "INSERT OR REPLACE INTO plant_state (name, declared_by, declared_us, reason, until_us) VALUES (?1, ?2, ?3, ?4, ?5)",
        )?
        .execute(params![name, by.user, by.at.0, reason, until.0])
        .map(drop)
}

fn delete_plant_state(connection: &Connection, name: &str) -> rusqlite::Result<()> {
    connection.prepare_cached("DELETE FROM plant_state WHERE name = ?1")?.execute([name]).map(drop)
}

fn insert_history(connection: &Connection, entry: &AlarmHistoryEntry) -> rusqlite::Result<()> {
    connection
        .prepare_cached(
            "INSERT INTO alarm_history (at_us, alarm, change, state, priority, subject, occurrence, user_name, value, unit, text)
             VALUES (?1, ?2, ?3, ?4, ?5, ?6, ?7, ?8, ?9, ?10, ?11)",
        )?
        .execute(params![
            entry.at.0,
            entry.alarm,
            entry.change.as_str(),
            entry.state.as_str(),
            entry.priority.as_str(),
            entry.subject,
            entry.occurrence,
            entry.user,
            entry.value,
            entry.unit,
            entry.text
        ])
        .map(drop)
}

/// The name and the status of an alarm. A state that this program does not know becomes one that an operator must acknowledge.
fn alarm_status(row: &Row<'_>) -> rusqlite::Result<(String, AlarmStatus)> {
    let time = |column: usize| Ok::<_, rusqlite::Error>(row.get::<_, Option<i64>>(column)?.map(Micros));
    let text = |column: usize| row.get::<_, Option<String>>(column);
    let attribution = |user: usize, at: usize| {
        Ok::<_, rusqlite::Error>(text(user)?.zip(time(at)?).map(|(user, at)| Attribution { user, at }))
    };
    let (suppressed, until) = (attribution(9, 10)?.zip(text(11)?), time(12)?);
    let state: String = row.get(1)?;
    let alarm = AlarmStatus {
        state: AlarmState::from_word(&state).unwrap_or(AlarmState::Returned),
        since: Micros(row.get(2)?),
        occurrence: row.get(3)?,
        raised: time(4)?,
        value: row.get(5)?,
        text: row.get(6)?,
        acknowledged: attribution(7, 8)?,
        suppression: suppressed.map(|(by, reason)| Suppression { by, reason, until }),
    };
    Ok((row.get(0)?, alarm))
}

fn history_entry(row: &Row<'_>) -> rusqlite::Result<AlarmHistoryEntry> {
    Ok(AlarmHistoryEntry {
        at: Micros(row.get(0)?),
        alarm: row.get(1)?,
        change: Word::read(row.get(2)?),
        state: Word::read(row.get(3)?),
        priority: Word::read(row.get(4)?),
        subject: row.get(5)?,
        occurrence: row.get(6)?,
        user: row.get(7)?,
        value: row.get(8)?,
        unit: row.get(9)?,
        text: row.get(10)?,
    })
}

fn notification_row(row: &Row<'_>) -> rusqlite::Result<Notification> {
    Ok(Notification { id: row.get(0)?, webhook: row.get(1)?, at: Micros(row.get(2)?), body: row.get(3)? })
}

impl Reader {
    /// The states of all alarms that were ever raised or taken out of service, by name.
    ///
    /// # Errors
    /// [`DatabaseError`] when the database cannot be read.
    pub fn alarms(&self) -> Result<Vec<(String, AlarmStatus)>, DatabaseError> {
        let sql = "SELECT name, state, since_us, occurrence, raised_us, raised_value, raised_text, acknowledged_by, acknowledged_us,
                       out_of_service_by, out_of_service_us, out_of_service_reason, out_of_service_until_us FROM alarm";
        self.query_all(sql, [], alarm_status)
    }

    /// The declared plant states, by name.
    ///
    /// # Errors
    /// [`DatabaseError`] when the database cannot be read.
    pub fn plant_states(&self) -> Result<Vec<(String, Declaration)>, DatabaseError> {
        let sql = "SELECT name, declared_by, declared_us, reason, until_us FROM plant_state ORDER BY name";
        self.query_all(sql, [], |row| {
            let by = Attribution { user: row.get(1)?, at: Micros(row.get(2)?) };
            Ok((row.get(0)?, Declaration { by, reason: row.get(3)?, until: Micros(row.get(4)?) }))
        })
    }

    /// How often an alarm was suppressed by a plant state from `from` to `to`.
    ///
    /// # Errors
    /// [`DatabaseError`] when the database cannot be read.
    pub fn suppressed_alarms(&self, from: Micros, to: Micros) -> Result<u64, DatabaseError> {
        let sql = "SELECT count(*) FROM alarm_history WHERE change = 'suppressed' AND at_us BETWEEN ?1 AND ?2";
        let counts = self.query_all(sql, params![from.0, to.0], |row| row.get::<_, i64>(0))?;
        Ok(counts.first().map_or(0, |count| count.unsigned_abs()))
    }

    /// The history of all alarms, or of one, from `from` to `to`: the `limit` rows that were recorded last, the last
    /// first.
    ///
    /// # Errors
    /// [`DatabaseError`] when the database cannot be read.
    pub fn alarm_history(
        &self,
        from: Micros,
        to: Micros,
        alarm: Option<&str>,
        limit: u32,
    ) -> Result<Vec<AlarmHistoryEntry>, DatabaseError> {
        let at = self.time_column("alarm_history", from, to)?;
        self.query_all(
            &format!(
                "SELECT at_us, alarm, change, state, priority, subject, occurrence, user_name, value, unit, text
                 FROM alarm_history
                 WHERE {at} BETWEEN ?1 AND ?2 AND (?3 IS NULL OR alarm = ?3) ORDER BY id DESC LIMIT ?4"
            ),
            params![from.0, to.0, alarm, limit],
            history_entry,
        )
    }

    /// Calls `take` with time, alarm and priority of every raised alarm from `from` to `to`, the earliest first. A priority of another
    /// version of the program is `None`.
    ///
    /// # Errors
    /// [`DatabaseError`] when the database cannot be read.
    pub fn each_raised_alarm(
        &self,
        from: Micros,
        to: Micros,
        mut take: impl FnMut(Micros, String, Option<Priority>),
    ) -> Result<(), DatabaseError> {
        let sql = "SELECT at_us, alarm, priority FROM alarm_history
                   WHERE change = 'raised' AND at_us BETWEEN ?1 AND ?2 ORDER BY at_us, id";
        self.query_each(sql, params![from.0, to.0], |row| {
            let priority: String = row.get(2)?;
            take(Micros(row.get(0)?), row.get(1)?, Priority::from_word(&priority));
            Ok(())
        })
    }

    /// A queued notification, if it still waits.
    ///
    /// # Errors
    /// [`DatabaseError`] when the database cannot be read.
    pub fn notification(&self, id: i64) -> Result<Option<Notification>, DatabaseError> {
        let sql = "SELECT id, webhook, at_us, body FROM notification WHERE id = ?1";
        Ok(self.query_all(sql, [id], notification_row)?.pop())
    }

    /// The numbers and times of all notifications queued for a webhook, the earliest first.
    ///
    /// # Errors
    /// [`DatabaseError`] when the database cannot be read.
    pub fn queued_notifications(&self, webhook: &str) -> Result<Vec<(i64, Micros)>, DatabaseError> {
        let sql = "SELECT id, at_us FROM notification WHERE webhook = ?1 ORDER BY id";
        self.query_all(sql, [webhook], |row| Ok((row.get(0)?, Micros(row.get(1)?))))
    }

    /// The numbers of notifications queued for webhooks other than these.
    ///
    /// # Errors
    /// [`DatabaseError`] when the database cannot be read.
    pub fn notifications_for_other_webhooks(&self, webhooks: &[String]) -> Result<Vec<i64>, DatabaseError> {
        let all = self.query_all("SELECT id, webhook, at_us, '' FROM notification", [], notification_row)?;
        let others = all.into_iter().filter(|notification| !webhooks.contains(&notification.webhook));
        Ok(others.map(|notification| notification.id).collect())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Recorder, Settings};

    #[test]
    fn a_status_is_the_same_after_a_restart_and_an_unknown_state_must_be_acknowledged() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("plant.db");
        let by = |user: &str, at| Attribution { user: user.to_owned(), at: Micros(at) };
        let status = AlarmStatus {
            state: AlarmState::Shelved,
            since: Micros(4),
            occurrence: 5,
            raised: Some(Micros(3)),
            value: Some(2.5),
            text: "too high".to_owned(),
            acknowledged: Some(by("Otto", 6)),
            suppression: Some(Suppression { by: by("Ada", 7), reason: "so".to_owned(), until: Some(Micros(9)) }),
        };
        let alarms = [("high".to_owned(), Some(status.clone()))].into();
        let recorder = Recorder::start(&path, Settings::default()).unwrap();
        assert!(recorder.record_alarms_with_receipt(AlarmBatch { alarms, ..AlarmBatch::default() }, Vec::new()).wait());
        drop(recorder);
        let stored = || Reader::open(&path).unwrap().alarms().unwrap();
        assert_eq!(stored(), [("high".to_owned(), status.clone())]);
        Connection::open(&path).unwrap().execute("UPDATE alarm SET state = 'latched'", []).unwrap();
        assert_eq!(stored(), [("high".to_owned(), AlarmStatus { state: AlarmState::Returned, ..status })]);
    }
}
