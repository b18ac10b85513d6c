//! Days that are over get smaller: the key of a day gives way to an index of its series and a summary of its times.
//!
//! The rows stay where they are, so that a dump, a replica and an open transaction see the whole day at any moment. Each step is harmless if the
//! archive is killed after it, and the next look goes on. Of several archives one packs.

use crate::config::Config;
use crate::database::{ConnectError, described};
use crate::schema::{SchemaError, upgrade};
use crate::session::Report;
use crate::store::KEYS;
use profivac_recorder::Micros;
use std::time::Duration;
use thiserror::Error;
use tokio::sync::watch;
use tokio::time::sleep;
use tokio_postgres::error::SqlState;
use tokio_postgres::{Client, Row};

/// The time between two looks, and after one that could not begin.
const INTERVAL: Duration = Duration::from_secs(3_600);
const RETRY_INTERVAL: Duration = Duration::from_secs(60);

/// A day is packed this number of days after its end (UTC). chosen: the batches of a station that had no network for a day still find the key,
/// with which they are stored faster.
const DAYS_AFTER: i64 = 1;

const DAY: i64 = 86_400 * Micros::SECOND;

/// The lock of the archive that packs, until its session ends.
const CLAIM: &str = "SELECT pg_try_advisory_lock(1885763175)";

/// A concurrent index waits for the transactions of readers, however long these take. A statement after a lock sees what was committed before.
const SETTINGS: &str =
    "SET statement_timeout = 0; SET default_transaction_isolation = 'read committed'; SET timezone = 'UTC'";

/// After this number of days that somebody holds the look ends: each wait for a lock stops those who store for a second. chosen
const MOST_HELD: usize = 3;

/// The tables of days from one on and before another, the oldest first, with the name of the key of those that have one.
///
/// Materialised: otherwise PostgreSQL may take a date from the name of each table.
const DAYS: &str = "
    WITH days AS MATERIALIZED (
        SELECT inhrelid, inhparent::regclass::text AS parent, relname::text AS name, right(relname, 8) COLLATE \"C\" AS day
        FROM pg_inherits JOIN pg_class ON pg_class.oid = inhrelid
        WHERE inhparent IN ('profivac_data.sample'::regclass, 'profivac_data.point_sample'::regclass)
            AND relname ~ '^(point_)?sample_[0-9]{8}$'
    )
    SELECT parent, name, day, conname::text AS key FROM days LEFT JOIN pg_constraint ON conrelid = inhrelid AND contype = 'p'
    WHERE day >= to_char(date '1970-01-01' + $1::integer, 'YYYYMMDD') COLLATE \"C\"
        AND day < to_char(date '1970-01-01' + $2::integer, 'YYYYMMDD') COLLATE \"C\" ORDER BY day, name";

/// The indexes of a table by name, and whether each is complete.
const INDEXES: &str = "
    SELECT relname::text AS name, indisvalid FROM pg_index JOIN pg_class ON pg_class.oid = indexrelid
    WHERE indrelid = to_regclass('profivac_data.' || $1::text)";

/// What the archive waits for in the last step: no transaction stores samples, and nobody reads the day. While it waits, others wait behind it.
const BEGIN: &str = "SET LOCAL lock_timeout = '1s'";

/// Why a day was not packed.
#[derive(Debug, Error)]
enum PackError {
    #[error("the database: {0}")]
    Connect(#[from] ConnectError),
    #[error("the database: {}", described(.0))]
    Database(#[from] tokio_postgres::Error),
    #[error(transparent)]
    Schema(#[from] SchemaError),
}

impl PackError {
    /// Whether somebody held a lock: the next look tries again.
    fn is_held(&self) -> bool {
        let held = [SqlState::LOCK_NOT_AVAILABLE, SqlState::T_R_DEADLOCK_DETECTED];
        matches!(self, Self::Database(error) if error.code().is_some_and(|code| held.contains(code)))
    }
}

/// The table of a day.
struct Day {
    name: String,
    /// As 20261129.
    day: String,
    /// The column that names the series or the point.
    of: &'static str,
    /// The name of its key, until it is packed.
    key: Option<String>,
}

impl Day {
    fn from_row(row: &Row) -> Self {
        let of = if row.get::<_, &str>("parent").ends_with("point_sample") { "point" } else { "series" };
        Self { name: row.get("name"), day: row.get("day"), of, key: row.get("key") }
    }

    /// The indexes in place of the key: name and definition. A table has long runs of one series in the first, which takes 7 octets a sample,
    /// and the times of 16 pages in each entry of the second.
    fn indexes(&self) -> [(String, String); 2] {
        let Self { name, of, .. } = self;
        [
            (format!("{name}_{of}"), format!("({of}) WITH (fillfactor = 100)")),
            (format!("{name}_at"), "USING brin (at) WITH (pages_per_range = 16)".to_owned()),
        ]
    }
}

/// Packs the days that are over, at once and then each hour, until it is told to stop. A failure is reported once; that the database cannot be
/// reached is reported by those who store.
pub async fn run(config: &Config, mut stop: watch::Receiver<bool>, report: &mut impl FnMut(Report<'_>)) {
    let mut said = Vec::new();
    while !*stop.borrow() {
        let packed = tokio::select! {
            packed = pack(config, Micros::now()) => packed,
            () = stopped(&mut stop) => return,
        };
        let pause = if packed.is_ok() { INTERVAL } else { RETRY_INTERVAL };
        let sentences = match packed {
            Ok(sentences) => sentences,
            Err(PackError::Connect(_)) => Vec::new(),
            Err(error) => vec![format!("days that are over are not packed: {error}; the archive tries again")],
        };
        sentences.iter().filter(|it| !said.contains(*it)).for_each(|it| report(Report::Packing(it.clone())));
        said = sentences;
        tokio::select! {
            () = sleep(pause) => {}
            () = stopped(&mut stop) => {}
        }
    }
}

async fn stopped(stop: &mut watch::Receiver<bool>) {
    drop(stop.wait_for(|is_stopped| *is_stopped).await);
}

/// Packs the days that are over. Returns what failed, in sentences: after a failure the next day follows.
async fn pack(config: &Config, now: Micros) -> Result<Vec<String>, PackError> {
    let (mut client, _connection) = config.database.connect().await?;
    upgrade(&mut client).await?;
    client.batch_execute(SETTINGS).await?;
    if !client.query_one(CLAIM, &[]).await?.get::<_, bool>(0) {
        return Ok(Vec::new());
    }
    let (first, end) = days_to_pack(now, config.samples_days);
    let rows = client.query(DAYS, &[&first, &end]).await?;
    let (mut failed, mut held) = (Vec::new(), 0);
    for day in rows.iter().map(Day::from_row) {
        match pack_day(&mut client, &day).await {
            Ok(()) => {}
            Err(error) if client.is_closed() => return Err(error),
            Err(error) if error.is_held() => held += 1,
            Err(error) => failed.push(format!("the samples of {} are not packed: {error}", day.day)),
        }
        if held == MOST_HELD {
            break;
        }
    }
    Ok(failed)
}

/// The first day to pack and the one after the last, since 1970. Days beyond the retention are dropped, or wait for the operator.
fn days_to_pack(now: Micros, samples_days: u32) -> (i32, i32) {
    let today = now.0.div_euclid(DAY);
    let number = |day: i64| i32::try_from(day).unwrap_or(0);
    (number(today.saturating_sub(i64::from(samples_days))), number(today.saturating_sub(DAYS_AFTER)))
}

async fn pack_day(client: &mut Client, day: &Day) -> Result<(), PackError> {
    let Day { name, key, .. } = day;
    let Some(key) = key else {
        // Samples that came late have no entry in the summary yet, and are looked through by each query.
        let sql = "SELECT brin_summarize_new_values(indexrelid) FROM pg_index JOIN pg_class ON pg_class.oid = indexrelid
            JOIN pg_am ON pg_am.oid = relam WHERE amname = 'brin' AND indisvalid AND indrelid = to_regclass('profivac_data.' || $1::text)";
        client.execute(sql, &[name]).await?;
        return Ok(());
    };
    let found = client.query(INDEXES, &[name]).await?;
    for (index, definition) in day.indexes() {
        let is_complete = found.iter().find(|row| row.get::<_, &str>("name") == index).map(|row| row.get("indisvalid"));
        if is_complete == Some(false) {
            client.batch_execute(&format!("DROP INDEX CONCURRENTLY IF EXISTS profivac_data.{index}")).await?;
        }
        if is_complete != Some(true) {
            client
                .batch_execute(&format!("CREATE INDEX CONCURRENTLY {index} ON profivac_data.{name} {definition}"))
                .await?;
        }
    }
    client.batch_execute(&format!("ANALYZE profivac_data.{name}")).await?;
    let transaction = client.transaction().await?;
    transaction.batch_execute(BEGIN).await?;
    // No transaction that relies on the key is under way, and the next one sees that there is none.
    transaction.execute("SELECT pg_advisory_xact_lock($1)", &[&KEYS]).await?;
    let complete = transaction.query(INDEXES, &[name]).await?;
    let is_complete =
        |index: &str| complete.iter().any(|row| row.get::<_, &str>("name") == index && row.get("indisvalid"));
    if day.indexes().iter().all(|(index, _)| is_complete(index)) {
        let sql = "SELECT format('ALTER TABLE profivac_data.%I DROP CONSTRAINT %I', $1::text, $2::text)";
        let drop_key: String = transaction.query_one(sql, &[name, key]).await?.get(0);
        transaction.batch_execute(&drop_key).await?;
    }
    Ok(transaction.commit().await?)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn today_the_day_before_and_days_beyond_the_retention_are_not_packed() {
        assert_eq!(days_to_pack(Micros(20_000 * DAY + 5), 30), (19_970, 19_999));
    }

    #[test]
    fn a_packed_day_has_an_index_of_its_series_and_a_summary_of_its_times() {
        let day = Day { name: "point_sample_20261129".to_owned(), day: "20261129".to_owned(), of: "point", key: None };
        let [(first, of), (second, at)] = day.indexes();
        assert_eq!((first.as_str(), of.as_str()), ("point_sample_20261129_point", "(point) WITH (fillfactor = 100)"));
        assert_eq!((second.as_str(), at.starts_with("USING brin (at)")), ("point_sample_20261129_at", true));
    }
}
