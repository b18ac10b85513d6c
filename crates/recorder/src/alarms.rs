//! Where alarms stand, their history, and letters to webhooks that wait: tables beside what was measured, written in the same transactions.

use super::audit::{self, AuditEntry};
use super::database::DatabaseError;
use super::reader::Reader;
use super::sample::Micros;
use rusqlite::{Connection, Row, Transaction, params};
use std::collections::BTreeMap;

/// The step that makes the tables.
pub const ALARM_TABLES: &str = "
    -- Where each alarm stands. Times in microseconds since 1970.
    CREATE TABLE alarm (
        name            TEXT PRIMARY KEY,
        state           TEXT NOT NULL,
        since           INTEGER NOT NULL,
        occurrence      INTEGER NOT NULL,
        raised          INTEGER,
        value           REAL,
        text            TEXT NOT NULL,
        acknowledged_by TEXT,
        acknowledged_at INTEGER,
        out_by          TEXT,
        out_at          INTEGER,
        out_reason      TEXT,
        out_until       INTEGER
    ) WITHOUT ROWID;
    CREATE TABLE alarm_history (
        id         INTEGER PRIMARY KEY,
        at         INTEGER NOT NULL,
        alarm      TEXT NOT NULL,
        what       TEXT NOT NULL,
        state      TEXT NOT NULL,
        priority   TEXT NOT NULL,
        subject    TEXT,
        occurrence INTEGER NOT NULL,
        who        TEXT,
        value      REAL,
        unit       TEXT,
        text       TEXT NOT NULL
    );
    CREATE INDEX alarm_history_at ON alarm_history (at);
    -- What webhooks have not taken yet. No number is ever used twice.
    CREATE TABLE letter (
        id   INTEGER PRIMARY KEY AUTOINCREMENT,
        hook TEXT NOT NULL,
        at   INTEGER NOT NULL,
        body TEXT NOT NULL
    );
    CREATE INDEX letter_hook ON letter (hook, id);
";

/// Where an alarm stands.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct StoredAlarm {
    /// The word of its state.
    pub state: String,
    /// Since when.
    pub since: Micros,
    /// Which time it was raised.
    pub occurrence: i64,
    /// When it was raised last.
    pub raised_at: Option<Micros>,
    /// The value then.
    pub value: Option<f64>,
    /// What was seen then.
    pub text: String,
    /// Who knows, and since when.
    pub acknowledged: Option<(String, Micros)>,
    /// Who took it out of service, when, and why.
    pub out_of_service: Option<(String, Micros, String)>,
    /// When it comes back.
    pub out_until: Option<Micros>,
}

/// A line of the history.
#[derive(Clone, Debug, PartialEq)]
pub struct AlarmHistoryEntry {
    /// When.
    pub at: Micros,
    /// The alarm.
    pub alarm: String,
    /// What happened.
    pub change: String,
    /// The state it led to.
    pub state: String,
    /// The priority it had.
    pub priority: String,
    /// The gauge or segment.
    pub subject: Option<String>,
    /// Which time it was raised.
    pub occurrence: i64,
    /// Who did it.
    pub who: Option<String>,
    /// The value then.
    pub value: Option<f64>,
    /// Its unit.
    pub unit: Option<String>,
    /// A sentence.
    pub text: String,
}

/// A letter that a webhook has not taken yet.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Notification {
    /// Its number; 0 before it is on the disk.
    pub id: i64,
    /// To which webhook.
    pub webhook: String,
    /// When it was written.
    pub at: Micros,
    /// What it says.
    pub body: String,
}

/// What is to be written together.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct AlarmBatch {
    /// Where alarms stand now; nothing for one that is not there any more.
    pub alarms: BTreeMap<String, Option<StoredAlarm>>,
    /// What happened.
    pub history: Vec<AlarmHistoryEntry>,
    /// What people did, for the audit trail.
    pub audit: Vec<AuditEntry>,
    /// What is to be told.
    pub notifications: Vec<Notification>,
    /// The numbers of letters that nobody waits for any more.
    pub finished_notifications: Vec<i64>,
}

impl AlarmBatch {
    /// What came later, too. Says how many lines, rows and letters found no room among so many.
    pub fn append(&mut self, mut later: Self, most: usize) -> u64 {
        self.alarms.append(&mut later.alarms);
        self.finished_notifications.append(&mut later.finished_notifications);
        let lost = extend_up_to(&mut self.history, later.history, most);
        let lost = lost.saturating_add(extend_up_to(&mut self.audit, later.audit, most));
        lost.saturating_add(extend_up_to(&mut self.notifications, later.notifications, most))
    }

    /// Whether there is nothing to be written.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.alarms.is_empty()
            && self.history.is_empty()
            && self.audit.is_empty()
            && self.notifications.is_empty()
            && self.finished_notifications.is_empty()
    }

    /// Writes all of it.
    pub(super) fn write(&self, transaction: &Transaction<'_>) -> rusqlite::Result<()> {
        for (name, kept) in &self.alarms {
            match kept {
                Some(kept) => upsert_alarm(transaction, name, kept)?,
                None => delete_alarm(transaction, name)?,
            }
        }
        self.history.iter().try_for_each(|line| insert_history(transaction, line))?;
        self.audit.iter().try_for_each(|entry| audit::insert(transaction, entry).map(drop))?;
        for Notification { webhook: hook, at, body, .. } in &self.notifications {
            transaction
                .prepare_cached("INSERT INTO letter (hook, at, body) VALUES (?1, ?2, ?3)")?
                .execute(params![hook, at.0, body])?;
        }
        for id in &self.finished_notifications {
            transaction.prepare_cached("DELETE FROM letter WHERE id = ?1")?.execute([id])?;
        }
        Ok(())
    }
}

fn extend_up_to<T>(all: &mut Vec<T>, more: Vec<T>, most: usize) -> u64 {
    let room = most.saturating_sub(all.len());
    let lost = more.len().saturating_sub(room);
    all.extend(more.into_iter().take(room));
    lost as u64
}

fn upsert_alarm(connection: &Connection, name: &str, kept: &StoredAlarm) -> rusqlite::Result<()> {
    let (acknowledged, out) = (kept.acknowledged.as_ref(), kept.out_of_service.as_ref());
    connection
        .prepare_cached("INSERT OR REPLACE INTO alarm VALUES (?1, ?2, ?3, ?4, ?5, ?6, ?7, ?8, ?9, ?10, ?11, ?12, ?13)")?
        .execute(params![
            name,
            kept.state,
            kept.since.0,
            kept.occurrence,
            kept.raised_at.map(|at| at.0),
            kept.value,
            kept.text,
            acknowledged.map(|(who, _)| who),
            acknowledged.map(|(_, at)| at.0),
            out.map(|(who, _, _)| who),
            out.map(|(_, at, _)| at.0),
            out.map(|(_, _, reason)| reason),
            kept.out_until.map(|at| at.0),
        ])
        .map(drop)
}

fn delete_alarm(connection: &Connection, name: &str) -> rusqlite::Result<()> {
    connection.prepare_cached("DELETE FROM alarm WHERE name = ?1")?.execute([name]).map(drop)
}

fn insert_history(connection: &Connection, line: &AlarmHistoryEntry) -> rusqlite::Result<()> {
    connection
        .prepare_cached(
            "INSERT INTO alarm_history (at, alarm, what, state, priority, subject, occurrence, who, value, unit, text)
             VALUES (?1, ?2, ?3, ?4, ?5, ?6, ?7, ?8, ?9, ?10, ?11)",
        )?
        .execute(params![
            line.at.0,
            line.alarm,
            line.change,
            line.state,
            line.priority,
            line.subject,
            line.occurrence,
            line.who,
            line.value,
            line.unit,
            line.text
        ])
        .map(drop)
}

fn stored_alarm(row: &Row<'_>) -> rusqlite::Result<(String, StoredAlarm)> {
    let time = |place: usize| Ok::<_, rusqlite::Error>(row.get::<_, Option<i64>>(place)?.map(Micros));
    let text = |place: usize| row.get::<_, Option<String>>(place);
    let out = text(9)?.zip(time(10)?).zip(text(11)?);
    let kept = StoredAlarm {
        state: row.get(1)?,
        since: Micros(row.get(2)?),
        occurrence: row.get(3)?,
        raised_at: time(4)?,
        value: row.get(5)?,
        text: row.get(6)?,
        acknowledged: text(7)?.zip(time(8)?),
        out_of_service: out.map(|((who, at), reason)| (who, at, reason)),
        out_until: time(12)?,
    };
    Ok((row.get(0)?, kept))
}

fn history_entry(row: &Row<'_>) -> rusqlite::Result<AlarmHistoryEntry> {
    Ok(AlarmHistoryEntry {
        at: Micros(row.get(0)?),
        alarm: row.get(1)?,
        change: row.get(2)?,
        state: row.get(3)?,
        priority: row.get(4)?,
        subject: row.get(5)?,
        occurrence: row.get(6)?,
        who: row.get(7)?,
        value: row.get(8)?,
        unit: row.get(9)?,
        text: row.get(10)?,
    })
}

fn notification_row(row: &Row<'_>) -> rusqlite::Result<Notification> {
    Ok(Notification { id: row.get(0)?, webhook: row.get(1)?, at: Micros(row.get(2)?), body: row.get(3)? })
}

impl Reader {
    /// Where all alarms stand, as far as something ever became of them.
    ///
    /// # Errors
    /// [`StoreError`] when the file cannot be read.
    pub fn alarms(&self) -> Result<Vec<(String, StoredAlarm)>, DatabaseError> {
        self.query_all("SELECT * FROM alarm", [], stored_alarm)
    }

    /// What happened to alarms in a time, the latest first, at most so much; to one of them, if it is named.
    ///
    /// # Errors
    /// [`StoreError`] when the file cannot be read.
    pub fn alarm_history(
        &self,
        from: Micros,
        to: Micros,
        alarm: Option<&str>,
        most: u32,
    ) -> Result<Vec<AlarmHistoryEntry>, DatabaseError> {
        self.query_all(
            "SELECT at, alarm, what, state, priority, subject, occurrence, who, value, unit, text FROM alarm_history
             WHERE at BETWEEN ?1 AND ?2 AND (?3 IS NULL OR alarm = ?3) ORDER BY at DESC, id DESC LIMIT ?4",
            params![from.0, to.0, alarm, most],
            history_entry,
        )
    }

    /// What a letter to a webhook says, if it is still there.
    ///
    /// # Errors
    /// [`StoreError`] when the file cannot be read.
    pub fn notification(&self, id: i64) -> Result<Option<Notification>, DatabaseError> {
        Ok(self.query_all("SELECT id, hook, at, body FROM letter WHERE id = ?1", [id], notification_row)?.pop())
    }

    /// The numbers and times of all letters to a webhook, in their order.
    ///
    /// # Errors
    /// [`StoreError`] when the file cannot be read.
    pub fn queued_notifications(&self, hook: &str) -> Result<Vec<(i64, Micros)>, DatabaseError> {
        let sql = "SELECT id, at FROM letter WHERE hook = ?1 ORDER BY id";
        self.query_all(sql, [hook], |row| Ok((row.get(0)?, Micros(row.get(1)?))))
    }

    /// The numbers of letters to webhooks other than these.
    ///
    /// # Errors
    /// [`StoreError`] when the file cannot be read.
    pub fn notifications_for_other_webhooks(&self, hooks: &[String]) -> Result<Vec<i64>, DatabaseError> {
        let all = self.query_all("SELECT id, hook, at, '' FROM letter", [], notification_row)?;
        Ok(all.into_iter().filter(|letter| !hooks.contains(&letter.webhook)).map(|letter| letter.id).collect())
    }
}
