//! The table of the audit trail.
//!
//! Rows are only added. An outcome is a separate row that refers to the row of its command, so that the database can refuse every
//! change of a row, and the row that was written before the command was sent stays as it was.

use profivac_model::{AuditEntry, Micros, Word};
use rusqlite::{Connection, Row, params};

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
        entry.action.as_str(),
        entry.refers_to,
        entry.user,
        entry.role.as_str(),
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
pub fn select(connection: &Connection, query: &AuditQuery) -> rusqlite::Result<Vec<AuditEntry>> {
    let mut select = connection.prepare_cached(
        "SELECT id, at_us, action, refers_to, user_name, role, peer, gauge, segment, address, target, before, after, outcome,
                command_id
         FROM audit
         WHERE at_us >= ?1 AND at_us < ?2 AND (?3 IS NULL OR gauge = ?3) AND (?4 IS NULL OR user_name = ?4)
         ORDER BY id DESC LIMIT ?5",
    )?;
    let AuditQuery { from, to, gauge, user, limit } = query;
    select.query_map(params![from.0, to.0, gauge, user, limit], audit_entry)?.collect()
}

fn audit_entry(row: &Row<'_>) -> rusqlite::Result<AuditEntry> {
    Ok(AuditEntry {
        id: row.get(0)?,
        at: Micros(row.get(1)?),
        action: Word::read(row.get(2)?),
        refers_to: row.get(3)?,
        user: row.get(4)?,
        role: Word::read(row.get(5)?),
        peer: row.get(6)?,
        gauge: row.get(7)?,
        segment: row.get(8)?,
        address: row.get(9)?,
        target: row.get(10)?,
        before: row.get(11)?,
        after: row.get(12)?,
        outcome: row.get(13)?,
        command_id: row.get(14)?,
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Reader, Recorder, Settings};
    use profivac_model::AuditAction;

    #[test]
    fn a_row_with_an_action_of_a_later_version_is_shown_with_its_word() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("plant.db");
        drop(Recorder::start(&path, Settings::default()).unwrap());
        let insert = "INSERT INTO audit (at_us, action, user_name, role)
                      VALUES (1, 'backup', 'Ada', 'engineer'), (2, 'calibrated', 'Ada', 'metrologist'), (3, 'shelved', 'Bo', 'operator')";
        Connection::open(&path).unwrap().execute_batch(insert).unwrap();
        let all = AuditQuery { from: Micros(0), to: Micros(i64::MAX), gauge: None, user: None, limit: 10 };
        let rows = Reader::open(&path).unwrap().audit(&all).unwrap();
        let words: Vec<_> = rows.iter().map(|row| (row.action.as_str(), row.role.as_str())).collect();
        assert_eq!(words, [("shelved", "operator"), ("calibrated", "metrologist"), ("backup", "engineer")]);
        assert_eq!(rows[0].action, AuditAction::Shelved);
    }
}
