//! The tables of a new database, and how a database of an older program gets them.
//!
//! Scripts and other programs read these tables, so their names are part of the interface: a change needs a new [`VERSION`] and a
//! migration. Times are microseconds since 1970 (UTC) and end in `_us`; pressures are in Pa and end in `_pa`. Values of points are in
//! the unit of their point.

use rusqlite::{Connection, TransactionBehavior};

/// The version of the tables, stored in the database's `user_version`.
pub const VERSION: i64 = 9;

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
    -- logarithm of the geometric mean of the valid pressures; min_pa and max_pa may be the end of the range. Version 0.1 counted the ends.
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
    -- A point of a slave whose values are recorded. unit: that of the values, empty without one. kind: number; code, also of a bit. With
    -- another unit or kind it is another row.
    CREATE TABLE point (
        id    INTEGER PRIMARY KEY,
        slave TEXT NOT NULL,
        name  TEXT NOT NULL,
        unit  TEXT NOT NULL,
        kind  TEXT NOT NULL,
        UNIQUE (slave, name, unit, kind)
    );
    -- quality: 0 valid, 3 fault, 4 stale. value is NULL unless it is valid.
    CREATE TABLE point_sample (
        point_id INTEGER NOT NULL REFERENCES point,
        at_us    INTEGER NOT NULL,
        value    REAL,
        quality  INTEGER NOT NULL,
        PRIMARY KEY (point_id, at_us)
    ) WITHOUT ROWID;
    -- Summaries, as in span. sum / count is the mean of a number; a code has no mean. last_value: the one that was recorded last.
    CREATE TABLE point_span (
        level      INTEGER NOT NULL,
        point_id   INTEGER NOT NULL REFERENCES point,
        start_us   INTEGER NOT NULL,
        min_value  REAL,
        max_value  REAL,
        last_value REAL,
        sum        REAL NOT NULL,
        count      INTEGER NOT NULL,
        qualities  INTEGER NOT NULL,
        PRIMARY KEY (level, point_id, start_us)
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
    -- Batches that wait for the archive, numbered without gaps; docs/archive-format.md describes the payload. epoch: NULL is the one of
    -- outbox_state; a copy keeps the epoch of the database in which the batch was made.
    CREATE TABLE outbox (
        number  INTEGER PRIMARY KEY AUTOINCREMENT,
        payload BLOB NOT NULL,
        epoch   INTEGER
    );
    -- Batches that were acknowledged, for some time: the archive asks for those that it lacks. Their numbers are those of outbox.
    CREATE TABLE outbox_kept (
        number          INTEGER PRIMARY KEY,
        epoch           INTEGER NOT NULL,
        acknowledged_us INTEGER NOT NULL,
        payload         BLOB NOT NULL
    );
    CREATE INDEX outbox_kept_acknowledged ON outbox_kept (acknowledged_us);
    -- Spans that have changed since they were in a batch.
    CREATE TABLE outbox_span (
        level     INTEGER NOT NULL,
        series_id INTEGER NOT NULL,
        start_us  INTEGER NOT NULL,
        PRIMARY KEY (level, series_id, start_us)
    ) WITHOUT ROWID;
    -- The same with spans of points.
    CREATE TABLE outbox_point_span (
        level    INTEGER NOT NULL,
        point_id INTEGER NOT NULL,
        start_us INTEGER NOT NULL,
        PRIMARY KEY (level, point_id, start_us)
    ) WITHOUT ROWID;
    -- One row: the epoch of the batches (0: a copy, which begins its own), the last rows that are in a batch, the number of the first
    -- batch of the epoch (0: an older program has begun it), the number up to which the database of the archive has every batch, and how
    -- many batches were deleted since the last acknowledgement because too many wait.
    CREATE TABLE outbox_state (
        id           INTEGER PRIMARY KEY CHECK (id = 1),
        epoch        INTEGER NOT NULL,
        event_id     INTEGER NOT NULL,
        alarm_id     INTEGER NOT NULL,
        audit_id     INTEGER NOT NULL,
        first_number INTEGER NOT NULL DEFAULT 0,
        stored       INTEGER NOT NULL DEFAULT 0,
        lost         INTEGER NOT NULL DEFAULT 0
    );
    -- What the station knows of before it was started, by name: database-check (the last check of the database; the value is the damage,
    -- empty without damage), file (the keys and values of the station's file, JSON; secrets as password hashes), archive-absence (the
    -- first sample since the station sends to no archive; the value is how far it has sent what it recorded meanwhile).
    CREATE TABLE station_state (
        name  TEXT PRIMARY KEY,
        at_us INTEGER NOT NULL,
        value TEXT NOT NULL
    ) WITHOUT ROWID;
";

/// The statements that lead from version N + 1 to the next, as older programs ran them. A published migration never changes.
const MIGRATIONS: [&[&str]; 8] = [FROM_1, FROM_2, FROM_3, FROM_4, FROM_5, FROM_6, FROM_7, FROM_8];

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

/// Adds the points of slaves and the states of the station, none; keeps acknowledged batches, and the numbers that an archive needs to see what
/// it lacks. The rows of the other tables stay as they are.
const FROM_8: &[&str] = &[
    "CREATE TABLE point (
        id    INTEGER PRIMARY KEY,
        slave TEXT NOT NULL,
        name  TEXT NOT NULL,
        unit  TEXT NOT NULL,
        kind  TEXT NOT NULL,
        UNIQUE (slave, name, unit, kind)
    )",
    "CREATE TABLE point_sample (
        point_id INTEGER NOT NULL REFERENCES point,
        at_us    INTEGER NOT NULL,
        value    REAL,
        quality  INTEGER NOT NULL,
        PRIMARY KEY (point_id, at_us)
    ) WITHOUT ROWID",
    "CREATE TABLE point_span (
        level      INTEGER NOT NULL,
        point_id   INTEGER NOT NULL REFERENCES point,
        start_us   INTEGER NOT NULL,
        min_value  REAL,
        max_value  REAL,
        last_value REAL,
        sum        REAL NOT NULL,
        count      INTEGER NOT NULL,
        qualities  INTEGER NOT NULL,
        PRIMARY KEY (level, point_id, start_us)
    ) WITHOUT ROWID",
    "CREATE TABLE outbox_point_span (
        level    INTEGER NOT NULL,
        point_id INTEGER NOT NULL,
        start_us INTEGER NOT NULL,
        PRIMARY KEY (level, point_id, start_us)
    ) WITHOUT ROWID",
    "CREATE TABLE station_state (
        name  TEXT PRIMARY KEY,
        at_us INTEGER NOT NULL,
        value TEXT NOT NULL
    ) WITHOUT ROWID",
    "ALTER TABLE outbox ADD COLUMN epoch INTEGER",
    "CREATE TABLE outbox_kept (
        number          INTEGER PRIMARY KEY,
        epoch           INTEGER NOT NULL,
        acknowledged_us INTEGER NOT NULL,
        payload         BLOB NOT NULL
    )",
    "CREATE INDEX outbox_kept_acknowledged ON outbox_kept (acknowledged_us)",
    "ALTER TABLE outbox_state ADD COLUMN first_number INTEGER NOT NULL DEFAULT 0",
    "ALTER TABLE outbox_state ADD COLUMN stored INTEGER NOT NULL DEFAULT 0",
    "ALTER TABLE outbox_state ADD COLUMN lost INTEGER NOT NULL DEFAULT 0",
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

/// The first version with points.
const WITH_POINTS: i64 = 9;

/// Gives an older database, opened for reading, empty tables of points. Nothing is written to the database itself.
const WITHOUT_POINTS: &str = "
    CREATE TEMP VIEW point AS SELECT 0 AS id, '' AS slave, '' AS name, '' AS unit, '' AS kind WHERE false;
    CREATE TEMP VIEW point_sample AS SELECT 0 AS point_id, 0 AS at_us, NULL AS value, 0 AS quality WHERE false;
    CREATE TEMP VIEW point_span AS
        SELECT 0 AS level, 0 AS point_id, 0 AS start_us, NULL AS min_value, NULL AS max_value, NULL AS last_value, 0.0 AS sum, 0 AS count,
            0 AS qualities
        WHERE false;
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
    if found < FINAL_NAMES {
        connection.execute_batch(READ_OLDER)?;
    }
    if found < WITH_POINTS { connection.execute_batch(WITHOUT_POINTS) } else { Ok(()) }
}

#[cfg(test)]
mod tests;
