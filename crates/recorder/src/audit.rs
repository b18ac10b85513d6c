//! The audit trail: who did what to which gauge or alarm, when, and what came of it.
//!
//! Rows are only ever added. What came of something is a row of its own that refers to the first, and not a change of it:
//! so the file itself can refuse every change of a row, and what was true before anything was sent stays as it was written.

use super::sample::Micros;
use rusqlite::types::Type;
use rusqlite::{Connection, Row, params};

/// The table, as a step of the file.
pub const AUDIT_TABLE: &str = "
    -- Times in microseconds since 1970. what: fired, outcome, refused, disarmed, mastership.
    -- of: the row whose outcome this is. Empty where there is nothing to say.
    CREATE TABLE audit (
        id      INTEGER PRIMARY KEY AUTOINCREMENT,
        at      INTEGER NOT NULL,
        what    TEXT NOT NULL,
        of      INTEGER REFERENCES audit,
        who     TEXT NOT NULL,
        role    TEXT NOT NULL,
        peer    TEXT,
        gauge   TEXT,
        segment TEXT,
        address INTEGER,
        target  TEXT,
        before  TEXT,
        after   TEXT,
        outcome TEXT,
        order_id TEXT
    );
    CREATE INDEX audit_at ON audit (at);
    CREATE UNIQUE INDEX audit_of ON audit (of) WHERE of IS NOT NULL;
    CREATE TRIGGER audit_is_not_changed BEFORE UPDATE ON audit
        BEGIN SELECT RAISE(ABORT, 'the audit trail is not changed'); END;
    CREATE TRIGGER audit_is_not_deleted BEFORE DELETE ON audit
        BEGIN SELECT RAISE(ABORT, 'the audit trail is not deleted'); END;
";

/// What a row is about.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum AuditAction {
    /// Something is going to be sent: written before it is.
    Execute,
    /// What came of it.
    Outcome,
    /// Nothing was armed, because a condition did not hold.
    Refused,
    /// Somebody thought better of it.
    Disarmed,
    /// The mastership went from one to another.
    ControlAuthority,
    /// Somebody knows of an alarm.
    Acknowledged,
    /// An alarm is not told any more.
    TakenOutOfService,
    /// It is told again.
    ReturnedToService,
}

impl AuditAction {
    const ALL: [Self; 8] = [
        Self::Execute,
        Self::Outcome,
        Self::Refused,
        Self::Disarmed,
        Self::ControlAuthority,
        Self::Acknowledged,
        Self::TakenOutOfService,
        Self::ReturnedToService,
    ];

    /// As it stands in the file.
    #[must_use]
    pub const fn word(self) -> &'static str {
        match self {
            Self::Execute => "fired",
            Self::Outcome => "outcome",
            Self::Refused => "refused",
            Self::Disarmed => "disarmed",
            Self::ControlAuthority => "mastership",
            Self::Acknowledged => "acknowledged",
            Self::TakenOutOfService => "taken-out-of-service",
            Self::ReturnedToService => "returned-to-service",
        }
    }

    fn from_word(word: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|deed| deed.word() == word)
    }
}

/// A row that is to be written.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct AuditEntry {
    /// When.
    pub at: Micros,
    /// What it is about.
    pub action: AuditAction,
    /// The row whose outcome this is.
    pub refers_to: Option<i64>,
    /// The name of who did it.
    pub who: String,
    /// What they were.
    pub role: String,
    /// From which address, if it is known.
    pub peer: Option<String>,
    /// The gauge.
    pub gauge: Option<String>,
    /// Its segment.
    pub segment: Option<String>,
    /// Its address on the bus.
    pub address: Option<u8>,
    /// The parameter: the manual's name and its numbers. Or the alarm.
    pub target: Option<String>,
    /// What it was.
    pub before: Option<String>,
    /// What it was to be; of an outcome, what it is.
    pub after: Option<String>,
    /// What came of it, or what happened, in a sentence.
    pub outcome: Option<String>,
    /// The order.
    pub command_id: Option<String>,
}

/// A row that was written.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct AuditRow {
    /// Its number, rising.
    pub id: i64,
    /// What it says.
    pub entry: AuditEntry,
}

/// Which rows.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct AuditQuery {
    /// From this moment on.
    pub from: Micros,
    /// Before this moment.
    pub to: Micros,
    /// Of this gauge only.
    pub gauge: Option<String>,
    /// By this person only.
    pub who: Option<String>,
    /// At most so many.
    pub limit: u32,
}

/// Adds a row. Says which it is. A row that refers to one of a record that was deleted meanwhile refers to none.
///
/// # Errors
/// What SQLite says.
pub fn insert(connection: &Connection, entry: &AuditEntry) -> rusqlite::Result<i64> {
    let mut insert = connection.prepare_cached(
        "INSERT INTO audit (at, what, of, who, role, peer, gauge, segment, address, target, before, after, outcome, order_id)
         VALUES (?1, ?2, (SELECT id FROM audit WHERE id = ?3 AND order_id IS ?14), ?4, ?5, ?6, ?7, ?8, ?9, ?10, ?11, ?12, ?13, ?14)",
    )?;
    insert.execute(params![
        entry.at.0,
        entry.action.word(),
        entry.refers_to,
        entry.who,
        entry.role,
        entry.peer,
        entry.gauge,
        entry.segment,
        entry.address,
        entry.target,
        entry.before,
        entry.after,
        entry.outcome,
        entry.command_id,
    ])?;
    Ok(connection.last_insert_rowid())
}

/// What was going to be sent when the station ended has an outcome from now on: nobody knows.
///
/// # Errors
/// What SQLite says.
pub fn close_unfinished(connection: &Connection, now: Micros) -> rusqlite::Result<usize> {
    connection.execute(
        "INSERT INTO audit (at, what, of, who, role, peer, gauge, segment, address, target, before, outcome, order_id)
         SELECT ?1, 'outcome', id, who, role, peer, gauge, segment, address, target, before, ?2, order_id
         FROM audit AS open
         WHERE what = 'fired' AND NOT EXISTS (SELECT 1 FROM audit WHERE of = open.id)",
        params![now.0, OUTCOME_UNKNOWN],
    )
}

/// The outcome of what was going on when the station ended.
pub const OUTCOME_UNKNOWN: &str = "not known: the station ended meanwhile";

/// The rows that are wanted, the latest first.
///
/// # Errors
/// What SQLite says.
pub fn select(connection: &Connection, wanted: &AuditQuery) -> rusqlite::Result<Vec<AuditRow>> {
    let mut select = connection.prepare_cached(
        "SELECT id, at, what, of, who, role, peer, gauge, segment, address, target, before, after, outcome, order_id
         FROM audit
         WHERE at >= ?1 AND at < ?2 AND (?3 IS NULL OR gauge = ?3) AND (?4 IS NULL OR who = ?4)
         ORDER BY id DESC LIMIT ?5",
    )?;
    let AuditQuery { from, to, gauge, who, limit: most } = wanted;
    select.query_map(params![from.0, to.0, gauge, who, most], recorded)?.collect()
}

fn recorded(row: &Row<'_>) -> rusqlite::Result<AuditRow> {
    let word: String = row.get(2)?;
    let unknown = || rusqlite::Error::FromSqlConversionFailure(2, Type::Text, format!("{word:?} is no deed").into());
    let entry = AuditEntry {
        at: Micros(row.get(1)?),
        action: AuditAction::from_word(&word).ok_or_else(unknown)?,
        refers_to: row.get(3)?,
        who: row.get(4)?,
        role: row.get(5)?,
        peer: row.get(6)?,
        gauge: row.get(7)?,
        segment: row.get(8)?,
        address: row.get(9)?,
        target: row.get(10)?,
        before: row.get(11)?,
        after: row.get(12)?,
        outcome: row.get(13)?,
        command_id: row.get(14)?,
    };
    Ok(AuditRow { id: row.get(0)?, entry })
}
