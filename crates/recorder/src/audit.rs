//! The audit trail: which user did what to which gauge or alarm, when, and with what outcome.
//!
//! Rows are only added. An outcome is a separate row that refers to the row of its command, so that the database can refuse every
//! change of a row, and the row that was written before the command was sent stays as it was.

use super::sample::Micros;
use rusqlite::types::Type;
use rusqlite::{Connection, Row, params};

/// The statement of a row.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum AuditAction {
    /// A command is about to be sent. Written before it is sent.
    Execute,
    /// The outcome of a command.
    Outcome,
    /// A command was not armed because a condition does not hold, or the role of the user does not permit an action.
    Refused,
    /// The user disarmed a command.
    Disarmed,
    /// Control authority was requested, granted, taken or released.
    ControlAuthority,
    /// The user acknowledged an alarm.
    Acknowledged,
    /// The user shelved an alarm.
    Shelved,
    /// The user unshelved an alarm.
    Unshelved,
    /// The user took an alarm out of service.
    TakenOutOfService,
    /// The user returned an alarm to service.
    ReturnedToService,
    /// The user changed the settings of an alarm.
    AlarmSettings,
    /// The user declared a plant state.
    PlantStateDeclared,
    /// The user gave a declared plant state a later end.
    PlantStateExtended,
    /// The user ended a declared plant state.
    PlantStateEnded,
    /// A copy of the database is about to be made. Written before it is made.
    Backup,
    /// A value of the station's file has changed.
    FileChanged,
}

impl AuditAction {
    const ALL: [Self; 16] = [
        Self::Execute,
        Self::Outcome,
        Self::Refused,
        Self::Disarmed,
        Self::ControlAuthority,
        Self::Acknowledged,
        Self::Shelved,
        Self::Unshelved,
        Self::TakenOutOfService,
        Self::ReturnedToService,
        Self::AlarmSettings,
        Self::PlantStateDeclared,
        Self::PlantStateExtended,
        Self::PlantStateEnded,
        Self::Backup,
        Self::FileChanged,
    ];

    /// The word in the database and in the API.
    #[must_use]
    pub const fn word(self) -> &'static str {
        match self {
            Self::Execute => "execute",
            Self::Outcome => "outcome",
            Self::Refused => "refused",
            Self::Disarmed => "disarmed",
            Self::ControlAuthority => "control-authority",
            Self::Acknowledged => "acknowledged",
            Self::Shelved => "shelved",
            Self::Unshelved => "unshelved",
            Self::TakenOutOfService => "taken-out-of-service",
            Self::ReturnedToService => "returned-to-service",
            Self::AlarmSettings => "alarm-settings",
            Self::PlantStateDeclared => "plant-state-declared",
            Self::PlantStateExtended => "plant-state-extended",
            Self::PlantStateEnded => "plant-state-ended",
            Self::Backup => "backup",
            Self::FileChanged => "file-changed",
        }
    }

    /// The action with this word.
    #[must_use]
    pub fn from_word(word: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|action| action.word() == word)
    }
}

/// A row that is to be written.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct AuditEntry {
    /// When it happened.
    pub at: Micros,
    /// The statement.
    pub action: AuditAction,
    /// The row whose outcome this row states.
    pub refers_to: Option<i64>,
    /// The name of the user.
    pub user: String,
    /// The role of the user at that time.
    pub role: String,
    /// The network address of the user, if it is known.
    pub peer: Option<String>,
    /// The gauge.
    pub gauge: Option<String>,
    /// Its segment.
    pub segment: Option<String>,
    /// Its address on the bus.
    pub address: Option<u8>,
    /// The parameter, by the manual's name and numbers, or the alarm.
    pub target: Option<String>,
    /// The value or state before.
    pub before: Option<String>,
    /// The value or state that was to be reached; in an outcome the one that was read back.
    pub after: Option<String>,
    /// A sentence about the outcome.
    pub outcome: Option<String>,
    /// The id of the armed command.
    pub command_id: Option<String>,
}

/// A row that was written.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct AuditRow {
    /// Its number, rising.
    pub id: i64,
    /// Its contents.
    pub entry: AuditEntry,
}

/// Selects rows.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct AuditQuery {
    /// From this time on.
    pub from: Micros,
    /// Before this time.
    pub to: Micros,
    /// Only rows about this gauge.
    pub gauge: Option<String>,
    /// Only rows by this user.
    pub user: Option<String>,
    /// The largest number of rows.
    pub limit: u32,
}

/// The outcome of a command that was being sent when the station ended: it is not known.
pub const OUTCOME_UNKNOWN: &str = "not known: the station ended meanwhile";

/// Adds a row and returns its number. A reference to a row of a database that was deleted meanwhile becomes empty.
///
/// # Errors
/// Any error of SQLite.
pub fn insert(connection: &Connection, entry: &AuditEntry) -> rusqlite::Result<i64> {
    let mut insert = connection.prepare_cached(
        "INSERT INTO audit (at_us, action, refers_to, user_name, role, peer, gauge, segment, address, target, before, after, outcome,
                            command_id)
         VALUES (?1, ?2, (SELECT id FROM audit WHERE id = ?3 AND command_id IS ?14), ?4, ?5, ?6, ?7, ?8, ?9, ?10, ?11, ?12, ?13, ?14)",
    )?;
    insert.execute(params![
        entry.at.0,
        entry.action.word(),
        entry.refers_to,
        entry.user,
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

/// Adds an unknown outcome for each command that has none: it was being sent when the station ended.
///
/// # Errors
/// Any error of SQLite.
pub fn close_unfinished(connection: &Connection, now: Micros) -> rusqlite::Result<usize> {
    connection.execute(
        "INSERT INTO audit (at_us, action, refers_to, user_name, role, peer, gauge, segment, address, target, before, outcome,
                            command_id)
         SELECT ?1, 'outcome', id, user_name, role, peer, gauge, segment, address, target, before, ?2, command_id
         FROM audit AS open
         WHERE action = 'execute' AND NOT EXISTS (SELECT 1 FROM audit WHERE refers_to = open.id)",
        params![now.0, OUTCOME_UNKNOWN],
    )
}

/// The selected rows, the latest first.
///
/// # Errors
/// Any error of SQLite.
pub fn select(connection: &Connection, query: &AuditQuery) -> rusqlite::Result<Vec<AuditRow>> {
    let mut select = connection.prepare_cached(
        "SELECT id, at_us, action, refers_to, user_name, role, peer, gauge, segment, address, target, before, after, outcome,
                command_id
         FROM audit
         WHERE at_us >= ?1 AND at_us < ?2 AND (?3 IS NULL OR gauge = ?3) AND (?4 IS NULL OR user_name = ?4)
         ORDER BY id DESC LIMIT ?5",
    )?;
    let AuditQuery { from, to, gauge, user, limit } = query;
    select.query_map(params![from.0, to.0, gauge, user, limit], audit_row)?.collect()
}

fn audit_row(row: &Row<'_>) -> rusqlite::Result<AuditRow> {
    let word: String = row.get(2)?;
    let unknown =
        || rusqlite::Error::FromSqlConversionFailure(2, Type::Text, format!("{word:?} is no audit action").into());
    let entry = AuditEntry {
        at: Micros(row.get(1)?),
        action: AuditAction::from_word(&word).ok_or_else(unknown)?,
        refers_to: row.get(3)?,
        user: row.get(4)?,
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
