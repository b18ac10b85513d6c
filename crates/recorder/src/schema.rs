//! The tables of a new database, and how a database of an older program gets them.
//!
//! Scripts and other programs read these tables, so their names are part of the interface: a change needs a new [`VERSION`] and a
//! migration. Times are microseconds since 1970 (UTC) and end in `_us`; pressures are in Pa and end in `_pa`.

use rusqlite::{Connection, TransactionBehavior};

/// The version of the tables, stored in the database's `user_version`.
pub const VERSION: i64 = 8;

/// The `application_id` of a database since version 5, by which the recorder tells its own files from others: "pfvc" in ASCII.
pub const APPLICATION_ID: i64 = 0x7066_7663;

/// All tables of the current version.
pub const TABLES: &str = "
    -- What is recorded under one name: a gauge, or one channel of a controller (`rack.2`). Events refer to it by the gauge's name.
    CREATE TABLE series (
        id   INTEGER PRIMARY KEY,
        name TEXT NOT NULL UNIQUE
    );
    -- quality: 0 valid, 1 overrange, 2 underrange, 3 fault, 4 stale, 5 off, 6 missing, 7 assumed. pressure_pa is NULL from 3 on.
    CREATE TABLE sample (
        series_id   INTEGER NOT NULL REFERENCES series,
        at_us       INTEGER NOT NULL,
        pressure_pa REAL,
        quality     INTEGER NOT NULL,
        PRIMARY KEY (series_id, at_us)
    ) WITHOUT ROWID;
    -- Summaries of 10 s (level 1), 2 min, 30 min and 6 h. qualities: bit 0 valid, bit 1 overrange, ... log10_sum / count is the
    -- logarithm of the geometric mean.
    CREATE TABLE span (
        level     INTEGER NOT NULL,
        series_id INTEGER NOT NULL REFERENCES series,
        start_us  INTEGER NOT NULL,
        min_pa    REAL,
        max_pa    REAL,
        log10_sum REAL NOT NULL,
        count     INTEGER NOT NULL,
        qualities INTEGER NOT NULL,
        PRIMARY KEY (level, series_id, start_us)
    ) WITHOUT ROWID;
    -- kind: station, bus, gauge, command, note, access, alarm, pump-down. The cursor of the outbox compares the ids of this table and of
    -- alarm_history and audit, so none is used twice, also after a retention has deleted all rows.
    CREATE TABLE event (
        id        INTEGER PRIMARY KEY AUTOINCREMENT,
        at_us     INTEGER NOT NULL,
        series_id INTEGER REFERENCES series,
        kind      TEXT NOT NULL,
        text      TEXT NOT NULL
    );
    CREATE INDEX event_at ON event (at_us);
    -- action: execute, outcome, refused, disarmed, control-authority, acknowledged, shelved, unshelved, taken-out-of-service,
    -- returned-to-service, alarm-settings, plant-state-declared, plant-state-extended, plant-state-ended, backup, file-changed.
    -- refers_to: the row whose outcome this row states.
    CREATE TABLE audit (
        id         INTEGER PRIMARY KEY AUTOINCREMENT,
        at_us      INTEGER NOT NULL,
        action     TEXT NOT NULL,
        refers_to  INTEGER REFERENCES audit,
        user_name  TEXT NOT NULL,
        role       TEXT NOT NULL,
        peer       TEXT,
        gauge      TEXT,
        segment    TEXT,
        address    INTEGER,
        target     TEXT,
        before     TEXT,
        after      TEXT,
        outcome    TEXT,
        command_id TEXT
    );
    CREATE INDEX audit_at ON audit (at_us);
    CREATE UNIQUE INDEX audit_of ON audit (refers_to) WHERE refers_to IS NOT NULL;
    CREATE TRIGGER audit_is_not_changed BEFORE UPDATE ON audit
        BEGIN SELECT RAISE(ABORT, 'the audit trail is not changed'); END;
    CREATE TRIGGER audit_is_not_deleted BEFORE DELETE ON audit
        BEGIN SELECT RAISE(ABORT, 'the audit trail is not deleted'); END;
    -- The state of each alarm that was ever raised, shelved, taken out of service or suppressed. The columns out_of_service_... are also
    -- those of a shelved or suppressed alarm: who, when, why, until when.
    CREATE TABLE alarm (
        name                    TEXT PRIMARY KEY,
        state                   TEXT NOT NULL,
        since_us                INTEGER NOT NULL,
        occurrence              INTEGER NOT NULL,
        raised_us               INTEGER,
        raised_value            REAL,
        raised_text             TEXT NOT NULL,
        acknowledged_by         TEXT,
        acknowledged_us         INTEGER,
        out_of_service_by       TEXT,
        out_of_service_us       INTEGER,
        out_of_service_reason   TEXT,
        out_of_service_until_us INTEGER
    ) WITHOUT ROWID;
    -- change: raised, returned, acknowledged, shelved, unshelved, taken-out-of-service, returned-to-service, suppressed, unsuppressed,
    -- removed, settings-changed.
    CREATE TABLE alarm_history (
        id         INTEGER PRIMARY KEY AUTOINCREMENT,
        at_us      INTEGER NOT NULL,
        alarm      TEXT NOT NULL,
        change     TEXT NOT NULL,
        state      TEXT NOT NULL,
        priority   TEXT NOT NULL,
        subject    TEXT,
        occurrence INTEGER NOT NULL,
        user_name  TEXT,
        value      REAL,
        unit       TEXT,
        text       TEXT NOT NULL
    );
    CREATE INDEX alarm_history_at ON alarm_history (at_us);
    -- The plant states that are declared: who declared them, when, why, and until when they suppress alarms.
    CREATE TABLE plant_state (
        name        TEXT PRIMARY KEY,
        declared_by TEXT NOT NULL,
        declared_us INTEGER NOT NULL,
        reason      TEXT NOT NULL,
        until_us    INTEGER NOT NULL
    ) WITHOUT ROWID;
    -- Notifications that wait for delivery to a webhook. An id is never used twice.
    CREATE TABLE notification (
        id      INTEGER PRIMARY KEY AUTOINCREMENT,
        webhook TEXT NOT NULL,
        at_us   INTEGER NOT NULL,
        body    TEXT NOT NULL
    );
    CREATE INDEX notification_webhook ON notification (webhook, id);
    -- When the station recorded, by the clock of the computer, in the order of recording. A retention counts this time.
    CREATE TABLE recording_period (
        id       INTEGER PRIMARY KEY,
        start_us INTEGER NOT NULL,
        end_us   INTEGER NOT NULL
    );
    -- Batches that wait for the archive, numbered without gaps; docs/archive-format.md describes the payload.
    CREATE TABLE outbox (
        number  INTEGER PRIMARY KEY AUTOINCREMENT,
        payload BLOB NOT NULL
    );
    -- Spans that have changed since they were in a batch.
    CREATE TABLE outbox_span (
        level     INTEGER NOT NULL,
        series_id INTEGER NOT NULL,
        start_us  INTEGER NOT NULL,
        PRIMARY KEY (level, series_id, start_us)
    ) WITHOUT ROWID;
    -- One row: the epoch of the batches (0: a copy, which begins its own), and the last rows that are in a batch.
    CREATE TABLE outbox_state (
        id       INTEGER PRIMARY KEY CHECK (id = 1),
        epoch    INTEGER NOT NULL,
        event_id INTEGER NOT NULL,
        alarm_id INTEGER NOT NULL,
        audit_id INTEGER NOT NULL
    );
";

/// The statements that lead from version N + 1 to the next, as older programs ran them. A published migration never changes.
const MIGRATIONS: [&[&str]; 7] = [FROM_1, FROM_2, FROM_3, FROM_4, FROM_5, FROM_6, FROM_7];

const FROM_1: &[&str] = &[
    "CREATE TABLE audit (
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
    )",
    "CREATE INDEX audit_at ON audit (at)",
    "CREATE UNIQUE INDEX audit_of ON audit (of) WHERE of IS NOT NULL",
    NOT_CHANGED,
    "CREATE TRIGGER audit_is_not_deleted BEFORE DELETE ON audit
        BEGIN SELECT RAISE(ABORT, 'the audit trail is not deleted'); END",
];

const FROM_2: &[&str] = &[
    "CREATE TABLE alarm (
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
    ) WITHOUT ROWID",
    "CREATE TABLE alarm_history (
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
    )",
    "CREATE INDEX alarm_history_at ON alarm_history (at)",
    "CREATE TABLE letter (
        id   INTEGER PRIMARY KEY AUTOINCREMENT,
        hook TEXT NOT NULL,
        at   INTEGER NOT NULL,
        body TEXT NOT NULL
    )",
    "CREATE INDEX letter_hook ON letter (hook, id)",
];

/// Renames tables and columns. Rows stay where they are, so the time does not depend on the number of samples.
///
/// Two action words of the audit trail change with the columns; its sentences stay as they were written.
const FROM_3: &[&str] = &[
    "ALTER TABLE gauge RENAME TO series",
    "ALTER TABLE sample RENAME COLUMN gauge TO series_id",
    "ALTER TABLE sample RENAME COLUMN at TO at_us",
    "ALTER TABLE sample RENAME COLUMN pa TO pressure_pa",
    "ALTER TABLE rollup RENAME TO span",
    "ALTER TABLE span RENAME COLUMN gauge TO series_id",
    "ALTER TABLE span RENAME COLUMN start TO start_us",
    "ALTER TABLE span RENAME COLUMN low TO min_pa",
    "ALTER TABLE span RENAME COLUMN high TO max_pa",
    "ALTER TABLE span RENAME COLUMN decades TO log10_sum",
    "ALTER TABLE event RENAME COLUMN at TO at_us",
    "ALTER TABLE event RENAME COLUMN gauge TO series_id",
    "ALTER TABLE audit RENAME COLUMN at TO at_us",
    "ALTER TABLE audit RENAME COLUMN what TO action",
    "ALTER TABLE audit RENAME COLUMN of TO refers_to",
    "ALTER TABLE audit RENAME COLUMN who TO user_name",
    "ALTER TABLE audit RENAME COLUMN order_id TO command_id",
    "DROP TRIGGER audit_is_not_changed",
    "UPDATE audit SET action = 'execute' WHERE action = 'fired'",
    "UPDATE audit SET action = 'control-authority' WHERE action = 'mastership'",
    NOT_CHANGED,
    "ALTER TABLE alarm RENAME COLUMN since TO since_us",
    "ALTER TABLE alarm RENAME COLUMN raised TO raised_us",
    "ALTER TABLE alarm RENAME COLUMN value TO raised_value",
    "ALTER TABLE alarm RENAME COLUMN text TO raised_text",
    "ALTER TABLE alarm RENAME COLUMN acknowledged_at TO acknowledged_us",
    "ALTER TABLE alarm RENAME COLUMN out_by TO out_of_service_by",
    "ALTER TABLE alarm RENAME COLUMN out_at TO out_of_service_us",
    "ALTER TABLE alarm RENAME COLUMN out_reason TO out_of_service_reason",
    "ALTER TABLE alarm RENAME COLUMN out_until TO out_of_service_until_us",
    "ALTER TABLE alarm_history RENAME COLUMN at TO at_us",
    "ALTER TABLE alarm_history RENAME COLUMN what TO change",
    "ALTER TABLE alarm_history RENAME COLUMN who TO user_name",
    "ALTER TABLE letter RENAME TO notification",
    "ALTER TABLE notification RENAME COLUMN hook TO webhook",
    "ALTER TABLE notification RENAME COLUMN at TO at_us",
    "DROP INDEX letter_hook",
    "CREATE INDEX notification_webhook ON notification (webhook, id)",
];

/// Adds the periods of recording. Those of the past are the spans of 6 h that have samples, up to the last sample.
const FROM_4: &[&str] = &[
    "CREATE TABLE recording_period (
        id       INTEGER PRIMARY KEY,
        start_us INTEGER NOT NULL,
        end_us   INTEGER NOT NULL
    )",
    "INSERT INTO recording_period (start_us, end_us)
     SELECT min(start_us), max(start_us) + 21600000000 FROM (
         SELECT start_us, start_us - 21600000000 * row_number() OVER (ORDER BY start_us) AS island
         FROM (SELECT DISTINCT start_us FROM span WHERE level = 4))
     GROUP BY island ORDER BY min(start_us)",
    "UPDATE recording_period SET end_us = ifnull(max(start_us, min(end_us,
         (SELECT max(last) FROM (SELECT (SELECT max(at_us) FROM sample WHERE series_id = series.id) AS last FROM series)))),
         end_us)",
    "PRAGMA application_id = 1885763171",
];

/// Adds the outbox, empty.
const FROM_5: &[&str] = &[
    "CREATE TABLE outbox (
        number  INTEGER PRIMARY KEY AUTOINCREMENT,
        payload BLOB NOT NULL
    )",
    "CREATE TABLE outbox_span (
        level     INTEGER NOT NULL,
        series_id INTEGER NOT NULL,
        start_us  INTEGER NOT NULL,
        PRIMARY KEY (level, series_id, start_us)
    ) WITHOUT ROWID",
    "CREATE TABLE outbox_state (
        id       INTEGER PRIMARY KEY CHECK (id = 1),
        epoch    INTEGER NOT NULL,
        event_id INTEGER NOT NULL,
        alarm_id INTEGER NOT NULL,
        audit_id INTEGER NOT NULL
    )",
];

/// Adds the declared plant states, none.
const FROM_6: &[&str] = &["CREATE TABLE plant_state (
        name        TEXT PRIMARY KEY,
        declared_by TEXT NOT NULL,
        declared_us INTEGER NOT NULL,
        reason      TEXT NOT NULL,
        until_us    INTEGER NOT NULL
    ) WITHOUT ROWID"];

/// No id of an event or of a row of the alarm history is used twice from now on.
///
/// SQLite began at id 1 again after a retention had deleted all rows, and the outbox sends only rows above its cursor. If the ids begin at
/// 1 and end below the cursor, the rows get the ids above the cursor, in their order, and are sent. In such a database the retention may
/// also have deleted the last rows alone, whose times were wrong; then the others are sent a second time. chosen: the archive may show a
/// row twice, but it misses no alarm. If the ids begin later, the first rows were deleted by their age: the others were sent and keep
/// their ids. If the ids have reached or passed the cursor again, nothing in the database tells the rows that were skipped from rows that
/// were sent, so the ids stay.
const FROM_7: &[&str] = &[
    "ALTER TABLE event RENAME TO event_7",
    "CREATE TABLE event (
        id        INTEGER PRIMARY KEY AUTOINCREMENT,
        at_us     INTEGER NOT NULL,
        series_id INTEGER REFERENCES series,
        kind      TEXT NOT NULL,
        text      TEXT NOT NULL
    )",
    "INSERT INTO event (id, at_us, series_id, kind, text)
     SELECT id + ifnull((SELECT event_id FROM outbox_state
             WHERE event_id > (SELECT max(id) FROM event_7) AND (SELECT min(id) FROM event_7) = 1), 0),
         at_us, series_id, kind, text
     FROM event_7 ORDER BY id",
    "DROP TABLE event_7",
    "CREATE INDEX event_at ON event (at_us)",
    "DELETE FROM sqlite_sequence WHERE name = 'event'",
    "INSERT INTO sqlite_sequence (name, seq)
     SELECT 'event', max(ifnull((SELECT max(id) FROM event), 0), ifnull((SELECT event_id FROM outbox_state), 0))",
    "ALTER TABLE alarm_history RENAME TO alarm_history_7",
    "CREATE TABLE alarm_history (
        id         INTEGER PRIMARY KEY AUTOINCREMENT,
        at_us      INTEGER NOT NULL,
        alarm      TEXT NOT NULL,
        change     TEXT NOT NULL,
        state      TEXT NOT NULL,
        priority   TEXT NOT NULL,
        subject    TEXT,
        occurrence INTEGER NOT NULL,
        user_name  TEXT,
        value      REAL,
        unit       TEXT,
        text       TEXT NOT NULL
    )",
    "INSERT INTO alarm_history (id, at_us, alarm, change, state, priority, subject, occurrence, user_name, value, unit, text)
     SELECT id + ifnull((SELECT alarm_id FROM outbox_state
             WHERE alarm_id > (SELECT max(id) FROM alarm_history_7) AND (SELECT min(id) FROM alarm_history_7) = 1), 0),
         at_us, alarm, change, state, priority, subject, occurrence, user_name, value, unit, text
     FROM alarm_history_7 ORDER BY id",
    "DROP TABLE alarm_history_7",
    "CREATE INDEX alarm_history_at ON alarm_history (at_us)",
    "DELETE FROM sqlite_sequence WHERE name = 'alarm_history'",
    "INSERT INTO sqlite_sequence (name, seq)
     SELECT 'alarm_history',
         max(ifnull((SELECT max(id) FROM alarm_history), 0), ifnull((SELECT alarm_id FROM outbox_state), 0))",
];

const NOT_CHANGED: &str = "CREATE TRIGGER audit_is_not_changed BEFORE UPDATE ON audit
        BEGIN SELECT RAISE(ABORT, 'the audit trail is not changed'); END";

/// The first version whose tables and columns have the current names.
const FINAL_NAMES: i64 = 4;

/// Gives the tables of an older database, opened for reading, their current names. Nothing is written to the database itself.
///
/// Reading a view fails if the older version does not have its table.
const READ_OLDER: &str = "
    CREATE TEMP VIEW series AS SELECT id, name FROM main.gauge;
    CREATE TEMP VIEW sample AS SELECT gauge AS series_id, at AS at_us, pa AS pressure_pa, quality FROM main.sample;
    CREATE TEMP VIEW span AS
        SELECT level, gauge AS series_id, start AS start_us, low AS min_pa, high AS max_pa, decades AS log10_sum, count, qualities
        FROM main.rollup;
    CREATE TEMP VIEW event AS SELECT id, at AS at_us, gauge AS series_id, kind, text FROM main.event;
    CREATE TEMP VIEW audit AS
        SELECT id, at AS at_us,
            CASE what WHEN 'fired' THEN 'execute' WHEN 'mastership' THEN 'control-authority' ELSE what END AS action,
            of AS refers_to, who AS user_name, role, peer, gauge, segment, address, target, before, after, outcome,
            order_id AS command_id
        FROM main.audit;
    CREATE TEMP VIEW alarm AS
        SELECT name, state, since AS since_us, occurrence, raised AS raised_us, value AS raised_value, text AS raised_text,
            acknowledged_by, acknowledged_at AS acknowledged_us, out_by AS out_of_service_by, out_at AS out_of_service_us,
            out_reason AS out_of_service_reason, out_until AS out_of_service_until_us
        FROM main.alarm;
    CREATE TEMP VIEW alarm_history AS
        SELECT id, at AS at_us, alarm, what AS change, state, priority, subject, occurrence, who AS user_name, value, unit, text
        FROM main.alarm_history;
    CREATE TEMP VIEW notification AS SELECT id, hook AS webhook, at AS at_us, body FROM main.letter;
";

/// The version of a database; 0 for an empty one.
pub fn version(connection: &Connection) -> rusqlite::Result<i64> {
    connection.query_row("PRAGMA user_version", [], |row| row.get(0))
}

/// Whether a database belongs to a recorder: by its `application_id` since version 5, before that by its tables. An empty database
/// may be used.
pub fn is_own(connection: &Connection, found: i64) -> rusqlite::Result<bool> {
    let id: i64 = connection.query_row("PRAGMA application_id", [], |row| row.get(0))?;
    let tables = |names: &str| -> rusqlite::Result<i64> {
        let sql = format!("SELECT count(*) FROM sqlite_master WHERE type = 'table' {names}");
        connection.query_row(&sql, [], |row| row.get(0))
    };
    match found {
        0 => Ok(id == 0 && tables("")? == 0),
        1..=3 => Ok(id == 0 && tables("AND name IN ('gauge', 'sample', 'rollup', 'event')")? == 4),
        4 => Ok(id == 0 && tables("AND name IN ('series', 'sample', 'span', 'event')")? == 4),
        _ => Ok(id == APPLICATION_ID),
    }
}

/// Makes the tables of an empty database, or migrates an older one, in one transaction: a kill leaves the database as it was.
pub fn upgrade(connection: &mut Connection, found: i64) -> rusqlite::Result<()> {
    upgrade_observed(connection, found, &mut |_| ())
}

/// Calls `observer` with the number of each statement before it runs.
fn upgrade_observed(connection: &mut Connection, found: i64, observer: &mut dyn FnMut(usize)) -> rusqlite::Result<()> {
    if found == VERSION {
        return Ok(());
    }
    let transaction = connection.transaction_with_behavior(TransactionBehavior::Immediate)?;
    match usize::try_from(found.saturating_sub(1)) {
        Ok(done) => {
            let statements = MIGRATIONS.iter().skip(done).flat_map(|migration| migration.iter());
            for (number, statement) in statements.enumerate() {
                observer(number);
                transaction.execute_batch(statement)?;
            }
        }
        Err(_) => {
            transaction.execute_batch(TABLES)?;
            transaction.pragma_update(None, "application_id", APPLICATION_ID)?;
        }
    }
    transaction.pragma_update(None, "user_version", VERSION)?;
    transaction.commit()
}

/// Prepares a connection that only reads: an older database is read under the current names.
pub fn read_as_current(connection: &Connection, found: i64) -> rusqlite::Result<()> {
    if found < FINAL_NAMES { connection.execute_batch(READ_OLDER) } else { Ok(()) }
}

#[cfg(test)]
mod tests {
    use super::super::alarms::AlarmBatch;
    use super::super::audit::AuditQuery;
    use super::super::batch::Batch;
    use super::super::connection::{open_to_read, open_to_write};
    use super::super::database::Database;
    use super::super::outbox::Forward;
    use super::super::quality::Quality;
    use super::super::reader::Reader;
    use super::super::sample::Micros;
    use super::super::spans::PendingSpans;
    use super::*;
    use profivac_model::{AlarmState, AlarmStatus, Attribution, AuditAction, EventKind, Suppression};
    use std::io::{BufRead, BufReader};
    use std::path::Path;
    use std::process::{Command, Stdio};

    /// A database of version 3, with rows in every table.
    const VERSION_3: &str = include_str!("../tests/data/schema_3.sql");

    /// The path of the database, for the process that is killed.
    const PATH: &str = "PROFIVAC_TEST_MIGRATE";

    /// The statement before which that process stops.
    const STOP_AT: &str = "PROFIVAC_TEST_STOP_AT";

    fn make_version_3(path: &Path) {
        Connection::open(path).unwrap().execute_batch(VERSION_3).unwrap();
    }

    /// Table, column, type, and whether it may be NULL, of all columns of a database.
    fn columns(connection: &Connection) -> Vec<(String, String, String, bool)> {
        let sql = "SELECT m.name, c.name, c.type, c.\"notnull\" FROM sqlite_master m, pragma_table_info(m.name) c
                   WHERE m.type = 'table' AND m.name NOT LIKE 'sqlite%' ORDER BY m.name, c.cid";
        let mut select = connection.prepare(sql).unwrap();
        let rows = select.query_map([], |row| Ok((row.get(0)?, row.get(1)?, row.get(2)?, row.get(3)?))).unwrap();
        rows.map(Result::unwrap).collect()
    }

    /// The tables whose ids are never used twice.
    fn counted(connection: &Connection) -> Vec<String> {
        let sql = "SELECT name FROM sqlite_master WHERE type = 'table' AND sql LIKE '%AUTOINCREMENT%' ORDER BY name";
        let mut select = connection.prepare(sql).unwrap();
        select.query_map([], |row| row.get(0)).unwrap().map(Result::unwrap).collect()
    }

    /// The names of all indexes and triggers of a database.
    fn helpers(connection: &Connection) -> Vec<(String, String)> {
        let sql =
            "SELECT type, name FROM sqlite_master WHERE type IN ('index', 'trigger') AND sql IS NOT NULL ORDER BY name";
        let mut select = connection.prepare(sql).unwrap();
        let rows = select.query_map([], |row| Ok((row.get(0)?, row.get(1)?))).unwrap();
        rows.map(Result::unwrap).collect()
    }

    /// Checks every row of the fixture through the reader.
    fn assert_all_rows(reader: &Reader) {
        let (from, to) = (Micros(0), Micros(i64::MAX));
        assert_eq!(reader.series_names().unwrap(), ["chamber", "tpg.2", "tpg"]);
        let samples = reader.samples("chamber", from, to).unwrap();
        let last: Vec<_> = samples[11..].iter().map(|sample| (sample.pa, sample.quality)).collect();
        let expected = [
            (Some(1e-4 * 12.0), Quality::Valid),
            (Some(1e5), Quality::Overrange),
            (Some(1e-8), Quality::Underrange),
            (None, Quality::Fault),
            (None, Quality::Stale),
        ];
        assert_eq!((samples.len(), last), (16, expected.to_vec()));
        assert_eq!(reader.samples("tpg.2", from, to).unwrap().len(), 4);
        let trend = reader.trend("chamber", Micros(samples[0].at.0), to, 1).unwrap();
        let summary = trend[0].summary;
        assert_eq!((summary.count, summary.low, summary.high, summary.qualities.0), (14, Some(1e-8), Some(1e5), 31));
        let events = reader.events(from, to, 100).unwrap();
        let kinds: Vec<_> = events.iter().rev().map(|event| event.kind.clone()).collect();
        // Version 3 has no event of a later kind.
        let of_version_3 = EventKind::ALL.into_iter().filter(|kind| *kind != EventKind::PumpDown);
        assert_eq!(kinds, of_version_3.collect::<Vec<_>>());
        assert_eq!((events[4].gauge.as_deref(), events[4].text.as_str()), (Some("tpg"), "tpg: sensor 2 fails"));
        assert_audit(reader);
        assert_alarms(reader);
    }

    fn assert_audit(reader: &Reader) {
        let query = AuditQuery { from: Micros(0), to: Micros(i64::MAX), gauge: None, user: None, limit: 100 };
        let mut rows = reader.audit(&query).unwrap();
        rows.reverse();
        let actions: Vec<_> = rows.iter().map(|row| (row.id, row.action, row.refers_to)).collect();
        let expected = [
            (1, AuditAction::ControlAuthority, None),
            (2, AuditAction::Execute, None),
            (3, AuditAction::Outcome, Some(2)),
            (4, AuditAction::Refused, None),
            (5, AuditAction::Disarmed, None),
            (6, AuditAction::Acknowledged, None),
            (7, AuditAction::TakenOutOfService, None),
            (8, AuditAction::ReturnedToService, None),
        ];
        assert_eq!(actions, expected);
        let first = &rows[0];
        assert_eq!(first.outcome.as_deref(), Some("has taken the mastership, which was free"), "sentences stay");
        let done = &rows[2];
        let cells = (done.user.as_str(), done.before.as_deref(), done.after.as_deref(), done.command_id.as_deref());
        assert_eq!(cells, ("Otto", Some("off"), Some("degas-on"), Some("646f-1")));
    }

    fn assert_alarms(reader: &Reader) {
        let alarms = reader.alarms().unwrap();
        let second = |second: i64| Micros((1_767_225_600 + second) * Micros::SECOND);
        let expected = AlarmStatus {
            state: AlarmState::Acknowledged,
            since: second(9),
            occurrence: 1_767_225_608_000,
            raised: Some(second(8)),
            value: Some(2.5),
            text: "chamber shows 2.50e-2 mbar, above the limit of 1.00e-2 mbar".to_owned(),
            acknowledged: Some(Attribution { user: "Otto".to_owned(), at: second(9) }),
            ..AlarmStatus::default()
        };
        assert_eq!(alarms[0], ("chamber too high".to_owned(), expected));
        let by = Attribution { user: "Erna".to_owned(), at: second(10) };
        let out = Suppression { by, reason: "calibration".to_owned(), until: Some(second(3600)) };
        assert_eq!(alarms[1].1.suppression, Some(out));
        let history = reader.alarm_history(Micros(0), Micros(i64::MAX), None, 10).unwrap();
        let changes: Vec<_> = history.iter().map(|entry| (entry.change.as_str(), entry.user.as_deref())).collect();
        assert_eq!(changes, [("acknowledged", Some("Otto")), ("raised", None)]);
        assert_eq!(reader.queued_notifications("log").unwrap(), [(2, second(9))]);
        assert_eq!(reader.queued_notifications("on call").unwrap(), []);
    }

    #[test]
    fn a_database_of_version_3_is_migrated_with_all_its_rows() {
        let folder = tempfile::tempdir().unwrap();
        let (old, new) = (folder.path().join("old.db"), folder.path().join("new.db"));
        make_version_3(&old);
        let (migrated, fresh) = (open_to_write(&old).unwrap(), open_to_write(&new).unwrap());
        assert_eq!((version(&migrated).unwrap(), version(&fresh).unwrap()), (VERSION, VERSION));
        assert_eq!(columns(&migrated), columns(&fresh));
        assert_eq!(helpers(&migrated), helpers(&fresh));
        assert_eq!(counted(&migrated), counted(&fresh));
        assert_all_rows(&Reader::open(&old).unwrap());
        let changed = migrated.execute_batch("UPDATE audit SET user_name = 'Eve'").unwrap_err().to_string();
        assert_eq!(changed, "the audit trail is not changed");
        migrated.execute_batch("INSERT INTO notification (webhook, at_us, body) VALUES ('log', 1, '{}')").unwrap();
        assert_eq!(migrated.last_insert_rowid(), 3, "the number of a delivered notification is not used again");
        let broken: i64 =
            migrated.query_row("SELECT count(*) FROM pragma_foreign_key_check", [], |row| row.get(0)).unwrap();
        assert_eq!(broken, 0);
        assert_eq!(Reader::open(&old).unwrap().plant_states().unwrap(), []);
    }

    #[test]
    fn a_database_of_version_3_is_read_without_a_change() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("old.db");
        make_version_3(&path);
        let before = std::fs::read(&path).unwrap();
        assert_all_rows(&Reader::open(&path).unwrap());
        assert_eq!(std::fs::read(&path).unwrap(), before);
    }

    #[test]
    fn a_database_of_version_1_gets_the_tables_it_lacks() {
        let folder = tempfile::tempdir().unwrap();
        let (old, new) = (folder.path().join("old.db"), folder.path().join("new.db"));
        make_version_3(&old);
        let without =
            "DROP TABLE audit; DROP TABLE alarm; DROP TABLE alarm_history; DROP TABLE letter; PRAGMA user_version = 1";
        Connection::open(&old).unwrap().execute_batch(without).unwrap();
        assert_eq!(Reader::open(&old).unwrap().series_names().unwrap(), ["chamber", "tpg.2", "tpg"]);
        let (migrated, fresh) = (open_to_write(&old).unwrap(), open_to_write(&new).unwrap());
        assert_eq!(columns(&migrated), columns(&fresh));
        assert_eq!(helpers(&migrated), helpers(&fresh));
        assert_eq!(Reader::open(&old).unwrap().samples("chamber", Micros(0), Micros(i64::MAX)).unwrap().len(), 16);
    }

    /// A database as the program with version 7 of the tables left it.
    fn make_version_7(path: &Path, rows: &str) {
        make_version_3(path);
        let connection = Connection::open(path).unwrap();
        MIGRATIONS[2..6].concat().iter().for_each(|statement| connection.execute_batch(statement).unwrap());
        connection.execute_batch("DELETE FROM event; DELETE FROM alarm_history; PRAGMA user_version = 7").unwrap();
        connection.execute_batch(rows).unwrap();
    }

    /// Writes nothing but what waits for the outbox. Returns the ids of the events and of the alarm changes in the batches.
    fn ids_sent(path: &Path) -> [Vec<i64>; 2] {
        let mut database = Database::open(path, Micros(1)).unwrap();
        database.set_outbox(Some(Forward::Off));
        database.write(&[], &PendingSpans::default(), &[], &AlarmBatch::default()).unwrap();
        let page = Reader::open(path).unwrap().outbox(0, 100, usize::MAX).unwrap();
        let batches: Vec<_> =
            page.batches.iter().map(|waiting| Batch::decode_compressed(&waiting.payload).unwrap()).collect();
        let events = batches.iter().flat_map(|batch| &batch.events).map(|event| event.id);
        let alarms = batches.iter().flat_map(|batch| &batch.alarms).map(|change| change.id);
        [events.collect(), alarms.collect()]
    }

    /// Three events and two alarm changes, from id 1 on, and one new row of each kind without an id.
    const ROWS: &str = "
        INSERT INTO event (id, at_us, kind, text) VALUES (1, 50, 'note', 'a'), (2, 51, 'note', 'b'), (3, 52, 'note', 'c');
        INSERT INTO alarm_history (id, at_us, alarm, change, state, priority, occurrence, text)
        VALUES (1, 50, 'x', 'raised', 'unacknowledged', 'high', 1, 'd'), (2, 51, 'x', 'returned', 'normal', 'high', 1, 'e');";
    const NEW_ROW: &str = "
        INSERT INTO event (at_us, kind, text) VALUES (53, 'note', 'new');
        INSERT INTO alarm_history (at_us, alarm, change, state, priority, occurrence, text)
        VALUES (53, 'y', 'raised', 'unacknowledged', 'high', 2, 'new');";

    #[test]
    fn rows_from_id_1_on_that_end_below_the_cursor_of_the_outbox_get_ids_above_it_and_are_sent() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("plant.db");
        let state = "INSERT INTO outbox_state VALUES (1, 5, 4, 9, 8);";
        make_version_7(&path, &format!("{state}{ROWS}"));
        assert_eq!(ids_sent(&path), [vec![5, 6, 7], vec![10, 11]]);
        let events = Reader::open(&path).unwrap().events(Micros(0), Micros(100), 10).unwrap();
        let texts: Vec<_> = events.iter().map(|event| event.text.as_str()).collect();
        assert_eq!(texts, ["c", "b", "a"]);
        open_to_write(&path).unwrap().execute_batch(NEW_ROW).unwrap();
        assert_eq!(ids_sent(&path), [vec![5, 6, 7, 8], vec![10, 11, 12]]);
    }

    #[test]
    fn empty_tables_go_on_above_the_cursor_of_the_outbox() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("plant.db");
        make_version_7(&path, "INSERT INTO outbox_state VALUES (1, 5, 4, 9, 8)");
        open_to_write(&path).unwrap().execute_batch(NEW_ROW).unwrap();
        assert_eq!(ids_sent(&path), [vec![5], vec![10]]);
    }

    #[test]
    fn rows_that_have_reached_the_cursor_keep_their_ids_and_are_not_sent_again() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("plant.db");
        make_version_7(&path, &format!("INSERT INTO outbox_state VALUES (1, 5, 3, 2, 8);{ROWS}"));
        assert_eq!(ids_sent(&path), [Vec::<i64>::new(), Vec::new()]);
        open_to_write(&path).unwrap().execute_batch(NEW_ROW).unwrap();
        assert_eq!(ids_sent(&path), [vec![4], vec![3]]);
    }

    /// The retention has deleted the first rows, and the last ones, whose times were wrong: the rows between were sent.
    #[test]
    fn rows_that_do_not_begin_at_id_1_keep_their_ids_and_are_not_sent_again() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("plant.db");
        let deleted = "DELETE FROM event WHERE id IN (1, 3); DELETE FROM alarm_history WHERE id = 1";
        make_version_7(&path, &format!("INSERT INTO outbox_state VALUES (1, 5, 3, 4, 8);{ROWS}{deleted}"));
        assert_eq!(ids_sent(&path), [Vec::<i64>::new(), Vec::new()]);
        open_to_write(&path).unwrap().execute_batch(NEW_ROW).unwrap();
        assert_eq!(ids_sent(&path), [vec![4], vec![5]]);
    }

    #[test]
    fn a_database_without_an_archive_keeps_its_ids_and_sends_all_rows_to_a_later_archive() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("plant.db");
        make_version_7(&path, ROWS);
        assert_eq!(ids_sent(&path), [vec![1, 2, 3], vec![1, 2]]);
    }

    /// `outbox_state` has one row, with a fixed key. That no retention deletes a series or a recording period is a test of the outbox.
    #[test]
    fn only_tables_whose_rows_are_never_deleted_may_use_an_id_twice() {
        let folder = tempfile::tempdir().unwrap();
        let connection = open_to_write(&folder.path().join("new.db")).unwrap();
        let sql = "SELECT m.name FROM sqlite_master m, pragma_table_info(m.name) c
                   WHERE m.type = 'table' AND m.name NOT LIKE 'sqlite%' AND c.pk = 1 AND c.type = 'INTEGER'
                       AND m.sql NOT LIKE '%WITHOUT ROWID%' AND m.sql NOT LIKE '%AUTOINCREMENT%' ORDER BY m.name";
        let mut select = connection.prepare(sql).unwrap();
        let tables: Vec<String> = select.query_map([], |row| row.get(0)).unwrap().map(Result::unwrap).collect();
        assert_eq!(tables, ["outbox_state", "recording_period", "series"]);
    }

    /// Not a separate test: the process that `a_kill_during_the_migration_leaves_version_3` starts and kills.
    #[test]
    fn migrate_and_stop_when_asked_to() {
        let (Ok(path), Ok(stop_at)) = (std::env::var(PATH), std::env::var(STOP_AT)) else { return };
        let stop_at: usize = stop_at.parse().unwrap();
        let mut connection = Connection::open(path).unwrap();
        connection
            .execute_batch("PRAGMA journal_mode = WAL; PRAGMA synchronous = FULL; PRAGMA cache_size = 1")
            .unwrap();
        let found = version(&connection).unwrap();
        upgrade_observed(&mut connection, found, &mut |number| {
            if number == stop_at {
                println!("\nstopped");
                loop {
                    std::thread::park();
                }
            }
        })
        .unwrap();
    }

    /// Starts a process that migrates the database, and kills it before one of the statements.
    fn kill_before(statement: usize, path: &Path) {
        let mut child = Command::new(std::env::current_exe().unwrap())
            .args(["--exact", "schema::tests::migrate_and_stop_when_asked_to", "--nocapture"])
            .env(PATH, path)
            .env(STOP_AT, statement.to_string())
            .stdout(Stdio::piped())
            .spawn()
            .unwrap();
        let mut lines = BufReader::new(child.stdout.take().unwrap()).lines().map(Result::unwrap);
        assert!(lines.any(|line| line == "stopped"), "statement {statement} was never reached");
        child.kill().unwrap();
        child.wait().unwrap();
    }

    #[test]
    fn a_kill_during_the_migration_leaves_version_3() {
        let folder = tempfile::tempdir().unwrap();
        for statement in 0..MIGRATIONS.iter().skip(2).map(|migration| migration.len()).sum::<usize>() {
            let path = folder.path().join(format!("{statement}.db"));
            make_version_3(&path);
            kill_before(statement, &path);
            let connection = open_to_read(&path).unwrap();
            assert_eq!(version(&connection).unwrap(), 3, "killed before statement {statement}");
            drop(connection);
            assert_all_rows(&Reader::open(&path).unwrap());
            let migrated = open_to_write(&path).unwrap();
            assert_eq!(version(&migrated).unwrap(), VERSION);
            assert_all_rows(&Reader::open(&path).unwrap());
        }
    }
}
