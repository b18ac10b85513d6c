//! What a station knows of before it was started: rows that replace one another, by their names.

use super::error::DatabaseError;
use super::reader::Reader;
use super::sample::Micros;
use rusqlite::{Connection, OptionalExtension, params};

/// A state of the station, as it is stored.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct StationState {
    /// Its name.
    pub name: &'static str,
    /// When it was found.
    pub at: Micros,
    /// Its value, whose form its name decides.
    pub value: String,
}

/// The name of the state for a check of the database.
const CHECK: &str = "database-check";

/// A check of the whole database.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct LastCheck {
    /// When it ended.
    pub at: Micros,
    /// The damage, one sentence each; empty if there was none.
    pub found: Vec<String>,
}

impl From<&LastCheck> for StationState {
    fn from(check: &LastCheck) -> Self {
        Self { name: CHECK, at: check.at, value: check.found.join("\n") }
    }
}

/// Stores a state in place of the one with its name.
pub fn store(connection: &Connection, state: &StationState) -> rusqlite::Result<()> {
    let StationState { name, at, value } = state;
    let sql = "INSERT OR REPLACE INTO station_state (name, at_us, value) VALUES (?1, ?2, ?3)";
    connection.prepare_cached(sql)?.execute(params![name, at.0, value]).map(drop)
}

impl Reader {
    /// The state with this name; `None` if it was never stored, also in a database of an older version.
    ///
    /// # Errors
    /// [`DatabaseError`] when the database cannot be read.
    pub fn state(&self, name: &'static str) -> Result<Option<StationState>, DatabaseError> {
        let read = || {
            let sql = "SELECT 1 FROM sqlite_schema WHERE name = 'station_state'";
            if self.connection().query_row(sql, [], |_| Ok(())).optional()?.is_none() {
                return Ok(None);
            }
            let sql = "SELECT at_us, value FROM station_state WHERE name = ?1";
            let state = self
                .connection()
                .query_row(sql, [name], |row| Ok(StationState { name, at: Micros(row.get(0)?), value: row.get(1)? }));
            state.optional()
        };
        read().map_err(|error| self.failed(error))
    }

    /// The last check of the database; `None` if none has ended.
    ///
    /// # Errors
    /// [`DatabaseError`] when the database cannot be read.
    pub fn last_check(&self) -> Result<Option<LastCheck>, DatabaseError> {
        let state = self.state(CHECK)?;
        Ok(state.map(|state| LastCheck { at: state.at, found: state.value.lines().map(str::to_owned).collect() }))
    }

    /// When the station began to record into this database; `None` if it never did.
    ///
    /// # Errors
    /// [`DatabaseError`] when the database cannot be read.
    pub fn recording_since(&self) -> Result<Option<Micros>, DatabaseError> {
        let sql = "SELECT min(start_us) FROM recording_period";
        let first = self.connection().query_row(sql, [], |row| row.get::<_, Option<i64>>(0));
        first.map(|first| first.map(Micros)).map_err(|error| self.failed(error))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Recorder, Settings};

    #[test]
    fn the_last_check_is_there_after_a_restart_and_replaces_the_one_before() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("plant.db");
        let checked = |at: i64, found: &[&str]| LastCheck {
            at: Micros(at),
            found: found.iter().map(|text| (*text).to_owned()).collect(),
        };
        let last = || Reader::open(&path).unwrap().last_check().unwrap();
        for check in [checked(5, &["page 7 is damaged", "page 9 too"]), checked(6, &[])] {
            let recorder = Recorder::start(&path, Settings::default()).unwrap();
            assert!(recorder.store_state(StationState::from(&check)));
            drop(recorder);
            assert_eq!(last(), Some(check));
        }
        let states: i64 = Connection::open(&path)
            .unwrap()
            .query_row("SELECT count(*) FROM station_state", [], |row| row.get(0))
            .unwrap();
        assert_eq!(states, 1);
    }

    #[test]
    fn a_database_of_an_older_version_has_no_last_check() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("plant.db");
        drop(Recorder::start(&path, Settings::default()).unwrap());
        let older = "DROP TABLE station_state; PRAGMA user_version = 8";
        Connection::open(&path).unwrap().execute_batch(older).unwrap();
        assert_eq!(Reader::open(&path).unwrap().last_check().unwrap(), None);
    }
}
