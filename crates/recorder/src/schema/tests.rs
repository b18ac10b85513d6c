use super::super::alarms::AlarmBatch;
use super::super::audit::AuditQuery;
use super::super::batch::Batch;
use super::super::connection::{open_to_read, open_to_write};
use super::super::database::{Database, NewPoints};
use super::super::outbox::Forward;
use super::super::point::{Point, PointKind, PointSample};
use super::super::quality::Quality;
use super::super::reader::Reader;
use super::super::sample::Micros;
use super::super::spans::PendingSpans;
use super::*;
use profivac_model::{AlarmState, AlarmStatus, Attribution, AuditAction, EventKind, Suppression, Word};
use std::io::{BufRead, BufReader};
use std::path::Path;
use std::process::{Command, Stdio};

/// A database of version 3, with rows in every table.
const VERSION_3: &str = include_str!("../../tests/data/schema_3.sql");

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
    assert_all_rows_but_points(reader);
    assert_eq!(reader.points().unwrap(), []);
}

fn assert_all_rows_but_points(reader: &Reader) {
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
    let actions: Vec<_> = rows.iter().map(|row| (row.id, row.action.clone(), row.refers_to)).collect();
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
    assert_eq!(actions, expected.map(|(id, action, of)| (id, Word::from(action), of)));
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

/// A database as the program with version 8 of the tables left it.
fn make_version_8(path: &Path) {
    make_version_3(path);
    let connection = Connection::open(path).unwrap();
    MIGRATIONS[2..7].concat().iter().for_each(|statement| connection.execute_batch(statement).unwrap());
    connection.execute_batch("PRAGMA user_version = 8").unwrap();
}

/// The rows of a table as text.
fn rows_of(connection: &Connection, table: &str) -> Vec<String> {
    let mut select = connection.prepare(&format!("SELECT * FROM {table}")).unwrap();
    let columns = select.column_count();
    let row = |row: &rusqlite::Row<'_>| {
        (0..columns).map(|column| row.get_ref(column).map(|value| format!("{value:?}"))).collect::<Result<Vec<_>, _>>()
    };
    select.query_map([], row).unwrap().map(|row| row.unwrap().join(" ")).collect()
}

#[test]
fn a_database_of_version_8_keeps_every_row_and_records_points() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("old.db");
    make_version_8(&path);
    assert_all_rows(&Reader::open(&path).unwrap());
    let before = Connection::open(&path).unwrap();
    let mut tables: Vec<_> = columns(&before).into_iter().map(|(table, ..)| table).collect();
    tables.dedup();
    let of_tables = |connection: &Connection| tables.iter().map(|table| rows_of(connection, table)).collect::<Vec<_>>();
    let rows = of_tables(&before);
    assert!(rows.iter().filter(|rows| !rows.is_empty()).count() > 6, "{tables:?}");
    drop(before);
    let mut database = Database::open(&path, Micros(1)).unwrap();
    let speed = Point {
        slave: "turbo".to_owned(),
        name: "speed".to_owned(),
        unit: Some("Hz".to_owned()),
        kind: PointKind::Number,
    };
    let index = database.point_index(&speed);
    let mut points = NewPoints::default();
    let value = PointSample::new(Micros(5), Some(-1.5), Quality::Valid);
    points.add(index, value);
    database.write_with_points(&[], &PendingSpans::default(), &points, &[], &AlarmBatch::default()).unwrap();
    drop(database);
    let reader = Reader::open(&path).unwrap();
    assert_all_rows_but_points(&reader);
    assert_eq!(reader.points().unwrap(), std::slice::from_ref(&speed));
    assert_eq!(reader.point_page(&speed, Micros(0), Micros(10), 10).unwrap(), [value]);
    assert_eq!(of_tables(reader.connection()), rows);
}

/// `outbox_state` has one row, with a fixed key; the numbers of `outbox_kept` come from `outbox`. That no retention deletes a series or a
/// recording period is a test of the outbox.
#[test]
fn only_tables_whose_rows_are_never_deleted_may_use_an_id_twice() {
    let folder = tempfile::tempdir().unwrap();
    let connection = open_to_write(&folder.path().join("new.db")).unwrap();
    let sql = "SELECT m.name FROM sqlite_master m, pragma_table_info(m.name) c
               WHERE m.type = 'table' AND m.name NOT LIKE 'sqlite%' AND c.pk = 1 AND c.type = 'INTEGER'
                   AND m.sql NOT LIKE '%WITHOUT ROWID%' AND m.sql NOT LIKE '%AUTOINCREMENT%' ORDER BY m.name";
    let mut select = connection.prepare(sql).unwrap();
    let tables: Vec<String> = select.query_map([], |row| row.get(0)).unwrap().map(Result::unwrap).collect();
    assert_eq!(tables, ["outbox_kept", "outbox_state", "point", "recording_period", "series"]);
}

/// Not a separate test: the process that `a_kill_during_the_migration_leaves_version_3` starts and kills.
#[test]
fn migrate_and_stop_when_asked_to() {
    let (Ok(path), Ok(stop_at)) = (std::env::var(PATH), std::env::var(STOP_AT)) else { return };
    let stop_at: usize = stop_at.parse().unwrap();
    let mut connection = Connection::open(path).unwrap();
    connection.execute_batch("PRAGMA journal_mode = WAL; PRAGMA synchronous = FULL; PRAGMA cache_size = 1").unwrap();
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
