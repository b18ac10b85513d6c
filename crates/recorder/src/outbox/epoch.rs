//! The epochs of the outbox: a database and each copy of it number their batches under an epoch of their own.

use super::{Batch, Micros, encoded, station_event};
use rusqlite::{Connection, OptionalExtension, Row, Transaction, params};

/// The batches that are read and changed at once.
const PAGE: usize = 500;

/// The row of `outbox_state`.
pub(super) struct State {
    pub(super) epoch: i64,
    /// The ids of the last rows that are in a batch.
    pub(super) event: i64,
    pub(super) alarm: i64,
    pub(super) audit: i64,
    /// The number of the first batch of the epoch; 0 if it is not known.
    pub(super) first_number: i64,
}

impl State {
    /// The state; a new database, and a copy, begins its epoch now.
    pub(super) fn current(transaction: &Transaction<'_>, now: Micros) -> rusqlite::Result<Self> {
        let row = |row: &Row<'_>| {
            Ok(Self {
                epoch: row.get(0)?,
                event: row.get(1)?,
                alarm: row.get(2)?,
                audit: row.get(3)?,
                first_number: row.get(4)?,
            })
        };
        let sql = "SELECT epoch, event_id, alarm_id, audit_id, first_number FROM outbox_state";
        let found = transaction.prepare_cached(sql)?.query_row([], row).optional()?;
        if let Some(state) = found.as_ref().filter(|state| state.epoch != 0) {
            return Ok(Self { ..*state });
        }
        let last = "SELECT ifnull((SELECT seq FROM sqlite_sequence WHERE name = 'outbox'), 0)";
        let last: i64 = transaction.query_row(last, [], |row| row.get(0))?;
        let first_number = last.saturating_add(1);
        let alarm = match &found {
            Some(before) => before.alarm.min(before_standing_alarms(transaction)?),
            None => 0,
        };
        let begin = "INSERT INTO outbox_state (id, epoch, event_id, alarm_id, audit_id, first_number) VALUES (1, ?1, 0, 0, 0, ?2)
            ON CONFLICT DO UPDATE SET epoch = ?1, first_number = ?2";
        transaction.execute(begin, [now.0, first_number])?;
        let before = found.unwrap_or(Self { epoch: 0, event: 0, alarm: 0, audit: 0, first_number });
        Ok(Self { epoch: now.0, first_number, alarm, ..before })
    }
}

/// The id before the last changes of all alarms that are not normal. An archive shows the alarms of the present epoch, so that a new epoch begins
/// with them.
fn before_standing_alarms(transaction: &Transaction<'_>) -> rusqlite::Result<i64> {
    let sql = "SELECT min(id) - 1 FROM (SELECT max(id) AS id, state, change FROM alarm_history GROUP BY alarm)
        WHERE state <> 'normal' AND change <> 'removed'";
    let id: Option<i64> = transaction.query_row(sql, [], |row| row.get(0))?;
    Ok(id.unwrap_or(i64::MAX))
}

/// Makes a copy of a database another database: its batches go on under an epoch of their own. Those that are there keep theirs, so that
/// the archive has their rows once.
pub fn begin_epoch(connection: &Connection) -> rusqlite::Result<()> {
    let sql = "SELECT count(*) FROM pragma_table_info('outbox_state') WHERE name = 'first_number'";
    let has_numbers: i64 = connection.query_row(sql, [], |row| row.get(0))?;
    if has_numbers > 0 {
        connection.execute_batch(
            "UPDATE outbox SET epoch = (SELECT epoch FROM outbox_state) WHERE epoch IS NULL;
             UPDATE outbox_state SET epoch = 0, first_number = 0, stored = 0, lost = 0",
        )?;
        return Ok(());
    }
    let sql = "SELECT count(*) FROM sqlite_schema WHERE name = 'outbox_state'";
    let tables: i64 = connection.query_row(sql, [], |row| row.get(0))?;
    // A database of an older version has no outbox, or one without the epochs of its batches.
    if tables > 0 {
        connection.execute("UPDATE outbox_state SET epoch = 0", [])?;
    }
    Ok(())
}

/// Goes on as another database from batch `first` of this epoch on: the archive has other batches with these numbers, because an older copy
/// of the file was put back. The batches get the new epoch, and are sent again.
pub fn branch(transaction: &Transaction<'_>, epoch: i64, first: i64, now: Micros) -> rusqlite::Result<()> {
    let found = transaction.query_row("SELECT epoch FROM outbox_state", [], |row| row.get(0)).optional()?;
    if found != Some(epoch) {
        return Ok(());
    }
    transaction.execute("UPDATE outbox SET epoch = ?1 WHERE epoch IS NULL AND number < ?2", [epoch, first])?;
    let mut last = first.saturating_sub(1);
    while let Some(end) = send_again(transaction, epoch, first, last)? {
        last = end;
    }
    transaction.execute("DELETE FROM outbox_kept WHERE number >= ?1 AND epoch = ?2", [first, epoch])?;
    let text = "the archive has other batches of this database: an older copy of the file was put back, or a second computer runs with one; \
                the station goes on as another database, and sends again what the archive lacks";
    station_event(transaction, now, text)?;
    let begin = "UPDATE outbox_state SET epoch = ?1, first_number = ?2, stored = 0, alarm_id = min(alarm_id, ?3)";
    let standing = before_standing_alarms(transaction)?;
    transaction.execute(begin, [now.0.max(epoch.saturating_add(1)), first, standing]).map(drop)
}

/// Puts a page of the batches after `last` into the outbox, waiting ones and those that are kept, with the first number of their new epoch.
/// Returns the last number of the page.
fn send_again(transaction: &Transaction<'_>, epoch: i64, first: i64, last: i64) -> rusqlite::Result<Option<i64>> {
    let sql = "SELECT number, payload FROM outbox WHERE number > ?1
        UNION ALL SELECT number, payload FROM outbox_kept WHERE number > ?1 AND epoch = ?2 ORDER BY number";
    let mut select = transaction.prepare_cached(sql)?;
    let rows = select.query_map([last, epoch], |row| Ok((row.get(0)?, row.get(1)?)))?;
    let page: Vec<(i64, Vec<u8>)> = rows.take(PAGE).collect::<rusqlite::Result<_>>()?;
    let put = "INSERT OR REPLACE INTO outbox (number, payload, epoch) VALUES (?1, ?2, NULL)";
    let mut put = transaction.prepare_cached(put)?;
    for (number, payload) in &page {
        let Ok(batch) = Batch::decode_compressed(payload) else { continue };
        put.execute(params![number, encoded(&Batch { first_number: first, ..batch })?])?;
    }
    Ok(page.last().map(|(number, _)| *number))
}
