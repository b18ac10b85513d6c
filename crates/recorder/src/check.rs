//! A check of a database for damage while a recorder writes to it, in pieces.
//!
//! SQLite's own check of the whole file is one read transaction. Until it ends the recorder cannot begin its log again, so the log grows.
//! A piece that takes too long is therefore given up and divided:
//!
//! ```text
//! the whole file ── each table with its indexes ── the rows of the table, the entries of each index: 10 000 at a time
//! ```
//!
//! The last step reads every page of the table and of its indexes, and checks that the keys ascend. It does not check free pages and the
//! room between rows, which only a small database gets checked.

use super::connection::{MAX_WAL_OCTETS, open_to_read};
use super::error::{DatabaseError, is_damage};
use super::lock::sibling_path;
use rusqlite::types::{FromSql, Value, ValueRef};
use rusqlite::{Connection, ErrorCode, Params, Row, params_from_iter};
use std::cmp::Ordering;
use std::fs;
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// The rows that a piece reads. chosen: some ten milliseconds of work.
const ROWS_PER_PIECE: usize = 10_000;

/// The pages or instructions of SQLite between two questions whether the piece is given up. chosen: a millisecond of work.
const STEPS_PER_QUESTION: i32 = 500;

/// The most damages that are listed. chosen: a database with one is restored.
const MAX_FOUND: usize = 10;

/// A piece is given up when the log has become longer than this, in octets. chosen: twice the length at which the recorder truncates it.
const MAX_LOG: u64 = 2 * MAX_WAL_OCTETS.unsigned_abs();

/// Whether a piece is given up because others need the disk. Asked during the piece.
pub type GiveUp = Arc<dyn Fn() -> bool + Send + Sync>;

/// A check that goes on piece by piece. Between two pieces no read transaction is open.
pub struct Check {
    path: PathBuf,
    connection: Connection,
    give_up: GiveUp,
    max_log: u64,
    /// The next piece is the last one.
    pieces: Vec<Piece>,
    found: Vec<String>,
}

/// A part of the check.
enum Piece {
    /// The whole file, also its free pages.
    File,
    /// A table with its indexes.
    Table(String),
    /// Rows of a table, or entries of an index.
    Rows(Walk),
}

/// The rows of a table or the entries of an index, in the order of their keys, from a key on.
struct Walk {
    /// The words for it in a sentence.
    name: String,
    /// Selects the keys, then the other columns.
    select: String,
    /// The condition that every row fulfils.
    condition: String,
    keys: Vec<String>,
    after: Option<Vec<Value>>,
}

impl Check {
    /// Begins a check of the database at `path`, on a connection of its own that only reads. A piece is given up when `give_up` says so.
    ///
    /// # Errors
    /// [`DatabaseError`] when the database cannot be opened; [`DatabaseError::is_damage`] if because of damage.
    pub fn begin(path: &Path, give_up: GiveUp) -> Result<Self, DatabaseError> {
        let connection = open_to_read(path)?;
        // SQLite then looks at every row of a page that it reads.
        let prepared = connection.pragma_update(None, "cell_size_check", true);
        prepared.map_err(|error| DatabaseError::Sql { path: path.to_owned(), error })?;
        let (pieces, found) = (vec![Piece::File], Vec::new());
        Ok(Self { path: path.to_owned(), connection, give_up, max_log: MAX_LOG, pieces, found })
    }

    /// Checks the next piece. Returns whether there are more.
    ///
    /// # Errors
    /// [`DatabaseError`] when the database cannot be read for another reason than damage.
    pub fn step(&mut self) -> Result<bool, DatabaseError> {
        let Some(piece) = self.pieces.pop() else { return Ok(false) };
        match self.check(&piece) {
            Ok(rest) => self.pieces.extend(rest),
            Err(error) if is_damage(&error) => self.add(format!("{}: {error}", piece.name())),
            Err(error) => return Err(DatabaseError::Sql { path: self.path.clone(), error }),
        }
        Ok(!self.pieces.is_empty())
    }

    /// The damage that was found, one sentence each.
    #[must_use]
    pub fn found(&self) -> &[String] {
        &self.found
    }

    fn add(&mut self, damage: String) {
        if self.found.len() < MAX_FOUND {
            self.found.push(damage);
        }
    }

    /// Checks a piece. Returns the pieces that are left of it.
    fn check(&mut self, piece: &Piece) -> rusqlite::Result<Vec<Piece>> {
        match piece {
            Piece::File => match self.quick_check(None) {
                Ok(()) => Ok(Vec::new()),
                Err(error) if is_given_up(&error) || is_damage(&error) => {
                    if is_damage(&error) {
                        // The check of each table says which one it is.
                        self.add(format!("{}: {error}", piece.name()));
                    }
                    Ok(tables(&self.connection)?.into_iter().map(Piece::Table).collect())
                }
                Err(error) => Err(error),
            },
            Piece::Table(table) => match self.quick_check(Some(table)) {
                Ok(()) => Ok(Vec::new()),
                Err(error) if is_given_up(&error) => {
                    Ok(walks(&self.connection, table)?.into_iter().map(Piece::Rows).collect())
                }
                Err(error) => Err(error),
            },
            Piece::Rows(walk) => Ok(self.read_rows(walk)?.map(Piece::Rows).into_iter().collect()),
        }
    }

    /// SQLite's check of the whole file, or of one table with its indexes.
    fn quick_check(&mut self, table: Option<&str>) -> rusqlite::Result<()> {
        let (give_up, max_log, log) = (Arc::clone(&self.give_up), self.max_log, sibling_path(&self.path, "-wal"));
        let is_log_long = move || fs::metadata(&log).is_ok_and(|log| log.len() > max_log);
        self.connection.progress_handler(STEPS_PER_QUESTION, Some(move || give_up() || is_log_long()))?;
        let subject = table.map_or_else(|| MAX_FOUND.to_string(), quoted);
        let checked = all(&self.connection, &format!("PRAGMA quick_check({subject})"), []);
        self.connection.progress_handler(0, None::<fn() -> bool>)?;
        checked?.into_iter().filter(|row: &String| row != "ok").for_each(|row| self.add(row));
        Ok(())
    }

    /// Reads some rows. Returns what is left.
    fn read_rows(&mut self, walk: &Walk) -> rusqlite::Result<Option<Walk>> {
        let mut select = self.connection.prepare_cached(&walk.sql())?;
        let mut rows = select.query(params_from_iter(walk.after.iter().flatten()))?;
        let (mut last, mut count) = (walk.after.clone(), 0_usize);
        while let Some(row) = rows.next()? {
            let key = key(row, walk.keys.len())?;
            if !key.as_ref().is_some_and(|key| last.as_ref().is_none_or(|last| follows(last, key))) {
                drop(rows);
                drop(select);
                self.add(format!("{}: a key is not one, or does not follow the one before", walk.name));
                return Ok(None);
            }
            (last, count) = (key, count.saturating_add(1));
        }
        Ok((count == ROWS_PER_PIECE).then(|| walk.from(last)))
    }
}

impl Piece {
    /// The words for it in a sentence.
    fn name(&self) -> String {
        match self {
            Self::File => "the file".to_owned(),
            Self::Table(table) => format!("table {table}"),
            Self::Rows(walk) => walk.name.clone(),
        }
    }
}

impl Walk {
    fn sql(&self) -> String {
        let Self { select, condition, keys, after, .. } = self;
        let key = keys.join(", ");
        let after = after.as_ref().map(|_| format!("AND ({key}) > ({})", vec!["?"; keys.len()].join(", ")));
        format!("{select} WHERE {condition} {} ORDER BY {key} LIMIT {ROWS_PER_PIECE}", after.unwrap_or_default())
    }

    /// The same from this key on.
    fn from(&self, after: Option<Vec<Value>>) -> Self {
        let Self { name, select, condition, keys, .. } = self;
        let (name, select, condition, keys) = (name.clone(), select.clone(), condition.clone(), keys.clone());
        Self { name, select, condition, keys, after }
    }
}

/// A name in a statement.
fn quoted(name: &str) -> String {
    format!("\"{}\"", name.replace('"', "\"\""))
}

/// All tables, also those of SQLite.
fn tables(connection: &Connection) -> rusqlite::Result<Vec<String>> {
    all(connection, "SELECT name FROM pragma_table_list WHERE schema = 'main' AND type = 'table'", [])
}

/// The first column of all rows.
fn all<T: FromSql>(connection: &Connection, sql: &str, parameters: impl Params) -> rusqlite::Result<Vec<T>> {
    let mut select = connection.prepare(sql)?;
    let rows = select.query_map(parameters, |row| row.get(0))?;
    rows.collect()
}

/// The rows of a table, and the entries of its indexes.
fn walks(connection: &Connection, table: &str) -> rusqlite::Result<Vec<Walk>> {
    let sql = "SELECT wr FROM pragma_table_list WHERE schema = 'main' AND name = ?1";
    let has_rowid = !connection.query_row(sql, [table], |row| row.get::<_, bool>(0))?;
    let columns = |sql: &str, of: &str| -> rusqlite::Result<Vec<String>> {
        // A column without a name in an index is the row's number.
        let column = |name: Option<String>| name.map_or_else(|| "rowid".to_owned(), |name| quoted(&name));
        Ok(all(connection, sql, [of])?.into_iter().map(column).collect())
    };
    let own = "SELECT name FROM pragma_table_info(?1) WHERE pk > 0 ORDER BY pk";
    let keys = if has_rowid { vec!["rowid".to_owned()] } else { columns(own, table)? };
    let from = quoted(table);
    let select = format!("SELECT {}, * FROM {from}", keys.join(", "));
    let mut walks =
        vec![Walk { name: format!("table {table}"), select, condition: "true".to_owned(), keys, after: None }];
    // The key of a table without row numbers is the table itself.
    let of_table = "SELECT name FROM pragma_index_list(?1) WHERE origin <> 'pk'";
    for index in all::<String>(connection, of_table, [table])? {
        let keys = columns("SELECT name FROM pragma_index_xinfo(?1) ORDER BY seqno", &index)?;
        let select = format!("SELECT {} FROM {from} INDEXED BY {}", keys.join(", "), quoted(&index));
        // An index for a part of the rows is used only with its condition; ours leave out rows without a value.
        let condition = keys.iter().map(|key| format!("{key} IS NOT NULL")).collect::<Vec<_>>().join(" AND ");
        walks.push(Walk { name: format!("index {index}"), select, condition, keys, after: None });
    }
    Ok(walks)
}

/// Whether a statement was interrupted.
fn is_given_up(error: &rusqlite::Error) -> bool {
    error.sqlite_error_code() == Some(ErrorCode::OperationInterrupted)
}

/// The first columns of a row; `None` if they are no key.
fn key(row: &Row<'_>, columns: usize) -> rusqlite::Result<Option<Vec<Value>>> {
    let value = |column| {
        Ok(match row.get_ref(column)? {
            ValueRef::Integer(number) => Some(Value::Integer(number)),
            ValueRef::Text(text) => String::from_utf8(text.to_vec()).ok().map(Value::Text),
            ValueRef::Null | ValueRef::Real(_) | ValueRef::Blob(_) => None,
        })
    };
    (0..columns).map(value).collect()
}

/// Whether a key comes after another one.
fn follows(before: &[Value], key: &[Value]) -> bool {
    let order = |pair: (&Value, &Value)| match pair {
        (Value::Integer(one), Value::Integer(other)) => one.cmp(other),
        (Value::Text(one), Value::Text(other)) => one.cmp(other),
        // Keys of another type than that of their column.
        _ => Ordering::Greater,
    };
    before.iter().zip(key).map(order).find(|order| order.is_ne()) == Some(Ordering::Less)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::connection::open_to_write;
    use std::fs::{File, OpenOptions};
    use std::os::unix::fs::FileExt;

    const PAGE: u64 = 4096;

    /// A database with 25 000 samples of two series and 25 000 events: several levels of pages.
    struct Fixture {
        folder: tempfile::TempDir,
    }

    impl Fixture {
        fn new() -> Self {
            let fixture = Self { folder: tempfile::tempdir().unwrap() };
            let connection = open_to_write(&fixture.path()).unwrap();
            connection
                .execute_batch(
                    "INSERT INTO series (name) VALUES ('chamber'), ('lock');
                     WITH RECURSIVE n (i) AS (SELECT 1 UNION ALL SELECT i + 1 FROM n WHERE i < 25000)
                     INSERT INTO sample (series_id, at_us, pressure_pa, quality) SELECT 1 + i % 2, i, 1e-3 * i, 0 FROM n;
                     WITH RECURSIVE n (i) AS (SELECT 1 UNION ALL SELECT i + 1 FROM n WHERE i < 25000)
                     INSERT INTO event (at_us, kind, text) SELECT i / 3, 'note', 'note ' || i FROM n;
                     INSERT INTO audit (at_us, action, user_name, role) VALUES (1, 'execute', 'Ada', 'engineer');
                     INSERT INTO audit (at_us, action, refers_to, user_name, role) VALUES (2, 'outcome', 1, 'Ada', 'engineer');
                     INSERT INTO alarm_history (at_us, alarm, change, state, priority, occurrence, text)
                     VALUES (1, 'high', 'raised', 'unacknowledged', 'high', 1, 'too high');
                     INSERT INTO notification (webhook, at_us, body) VALUES ('log', 1, '{}'), ('log', 2, '{}');
                     PRAGMA wal_checkpoint(TRUNCATE)",
                )
                .unwrap();
            fixture
        }

        fn path(&self) -> PathBuf {
            self.folder.path().join("plant.db")
        }

        /// The numbers of the leaf pages of a table or index, from 1.
        fn leaves(&self, name: &str) -> Vec<u64> {
            let connection = open_to_read(&self.path()).unwrap();
            let sql = "SELECT pageno FROM dbstat WHERE name = ?1 AND pagetype = 'leaf' ORDER BY path";
            let mut select = connection.prepare(sql).unwrap();
            select.query_map([name], |row| row.get::<_, u32>(0)).unwrap().map(|page| page.unwrap().into()).collect()
        }

        /// Writes garbage into the page in the middle of a table or index.
        fn damage(&self, name: &str) {
            let leaves = self.leaves(name);
            assert!(leaves.len() > 4, "{name}: {leaves:?}");
            let garbage: Vec<u8> = (0..PAGE).map(|octet| (octet * 7 + 3) as u8).collect();
            let file = OpenOptions::new().write(true).open(self.path()).unwrap();
            file.write_all_at(&garbage, (leaves[leaves.len() / 2] - 1) * PAGE).unwrap();
        }

        fn check(&self) -> Check {
            Check::begin(&self.path(), Arc::new(|| false)).unwrap()
        }

        /// A check that is divided as far as it can be.
        fn divided(&self) -> Check {
            let mut check = self.check();
            let tables = tables(&check.connection).unwrap();
            let walks = tables.iter().flat_map(|table| walks(&check.connection, table).unwrap());
            check.pieces = walks.map(Piece::Rows).collect();
            check
        }
    }

    /// Checks all pieces. Returns their number and the damage.
    fn finished(mut check: Check) -> (usize, Vec<String>) {
        let mut pieces = 1;
        while check.step().unwrap() {
            pieces += 1;
        }
        (pieces, check.found().to_vec())
    }

    #[test]
    fn a_sound_database_has_no_damage_whole_and_divided() {
        let fixture = Fixture::new();
        assert_eq!(finished(fixture.check()), (1, Vec::new()));
        let names: Vec<_> = fixture.divided().pieces.iter().map(Piece::name).collect();
        for name in [
            "table sample",
            "table sqlite_schema",
            "index event_at",
            "index audit_of",
            "index sqlite_autoindex_series_1",
        ] {
            assert!(names.iter().any(|own| own == name), "{name}: {names:?}");
        }
        let (pieces, found) = finished(fixture.divided());
        assert_eq!(found, Vec::<String>::new());
        // Two more pieces for the samples, for the events and for the index of the events.
        assert_eq!(pieces, names.len() + 6);
    }

    #[test]
    fn garbage_in_a_page_in_the_middle_of_a_table_or_an_index_is_found_whole_and_divided() {
        for (name, words) in [("sample", "table sample"), ("event", "table event"), ("event_at", "index event_at")] {
            let fixture = Fixture::new();
            fixture.damage(name);
            let (_, whole) = finished(fixture.check());
            assert!(!whole.is_empty(), "{name}");
            let (_, divided) = finished(fixture.divided());
            assert_eq!(divided.len(), 1, "{name}: {divided:?}");
            assert!(divided[0].starts_with(words), "{divided:?}");
        }
    }

    #[test]
    fn rows_in_a_wrong_order_are_found_in_a_divided_check() {
        let fixture = Fixture::new();
        let leaves = fixture.leaves("sample");
        let file = File::options().read(true).write(true).open(fixture.path()).unwrap();
        // Each page is right by itself.
        let mut pages = [3, 5].map(|leaf| (leaves[leaf] - 1, vec![0; PAGE as usize]));
        pages.iter_mut().for_each(|(page, octets)| file.read_exact_at(octets, *page * PAGE).unwrap());
        let [(one, of_one), (other, of_other)] = &pages;
        file.write_all_at(of_one, other * PAGE).unwrap();
        file.write_all_at(of_other, one * PAGE).unwrap();
        let (_, found) = finished(fixture.divided());
        assert_eq!(found, ["table sample: a key is not one, or does not follow the one before"]);
    }

    #[test]
    fn a_piece_that_is_given_up_is_divided_and_the_damage_is_found() {
        let fixture = Fixture::new();
        fixture.damage("sample");
        let check = Check::begin(&fixture.path(), Arc::new(|| true)).unwrap();
        let (pieces, found) = finished(check);
        assert!(pieces > 10, "{pieces}");
        assert!(found.iter().any(|damage| damage.starts_with("table sample: ")), "{found:?}");
    }

    #[test]
    fn a_long_log_divides_the_check_and_the_log_begins_again_between_two_pieces() {
        let fixture = Fixture::new();
        let writer = open_to_write(&fixture.path()).unwrap();
        let write = || writer.execute_batch("INSERT INTO event (at_us, kind, text) VALUES (1, 'note', 'x')").unwrap();
        write();
        let mut check = fixture.check();
        check.max_log = 0;
        assert!(check.step().unwrap(), "the piece is given up because of the log");
        let mut is_more = true;
        while is_more {
            is_more = check.step().unwrap();
            write();
            let busy: i64 = writer.query_row("PRAGMA wal_checkpoint(TRUNCATE)", [], |row| row.get(0)).unwrap();
            assert_eq!(busy, 0, "no read transaction is open");
            assert_eq!(fs::metadata(sibling_path(&fixture.path(), "-wal")).unwrap().len(), 0);
        }
        assert_eq!(check.found(), Vec::<String>::new());
    }

    #[test]
    fn a_file_without_the_head_of_a_database_is_damaged() {
        let fixture = Fixture::new();
        let file = OpenOptions::new().write(true).open(fixture.path()).unwrap();
        file.write_all_at(&[0; 100], 0).unwrap();
        let error = Check::begin(&fixture.path(), Arc::new(|| false)).map(drop).unwrap_err();
        assert!(error.is_damage(), "{error}");
        let missing = fixture.folder.path().join("missing.db");
        assert!(!Check::begin(&missing, Arc::new(|| false)).map(drop).unwrap_err().is_damage());
    }
}
