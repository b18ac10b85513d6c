//! The retention of samples: which days are dropped, in words before that happens.
//!
//! Each partition is dropped in a transaction of its own: a reader of one day holds back that day and no other. The lock of the whole table is
//! needed for each, so that a reader of all days holds back all.

use super::{DAY, Store, StoreError, day_number};
use profivac_recorder::Micros;
use std::collections::BTreeSet;
use tokio_postgres::error::SqlState;

/// The most days that are dropped at once without being told. chosen: an archive that was off for a week goes on by itself; a wrong number of
/// days or a wrong clock drops no history.
const MOST_UNTOLD: usize = 7;

/// The partitions of samples and of samples of points, the oldest first.
///
/// Materialised: otherwise PostgreSQL may read a day from the name of each table, also of those that are no days, and fail.
const OLD_DAYS: &str = "
    WITH all_days AS MATERIALIZED (
        SELECT inhparent::regclass::text AS parent, relname
        FROM pg_inherits JOIN pg_class ON pg_class.oid = inhrelid
        WHERE inhparent IN ('profivac_data.sample'::regclass, 'profivac_data.point_sample'::regclass)
    )
    SELECT parent, relname::text AS partition, to_char(day, 'YYYY-MM-DD') AS day
    FROM all_days, to_date(right(relname, 8), 'YYYYMMDD') AS day
    WHERE day < date '1970-01-01' + $1::int ORDER BY day, parent";

/// The lock with which an archive makes days; see `add_day` in the tables. It is taken before the time for locks begins.
const BEGIN: &str = "SELECT pg_advisory_xact_lock(1885763171); SET LOCAL lock_timeout = '1s'";

/// Who reads a table or its partition. An archive that stores holds the table for a moment.
const READERS: &str = "
    SELECT format('process %s (user %s%s)', pid, usename, CASE WHEN application_name <> '' THEN ', ' || application_name END)
    FROM pg_locks JOIN pg_stat_activity USING (pid)
    WHERE locktype = 'relation' AND granted AND pid <> pg_backend_pid() AND relation IN (to_regclass($1)::oid, to_regclass($2)::oid)
        AND database = (SELECT oid FROM pg_database WHERE datname = current_database())
    GROUP BY pid, usename, application_name ORDER BY pid LIMIT 3";

/// A partition that is older than the retention.
#[derive(Clone, Debug, PartialEq, Eq)]
struct Partition {
    /// The table, with its schema.
    parent: String,
    name: String,
    /// As `2026-11-29`.
    day: String,
}

/// The days of samples that are older than the retention.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct OldDays {
    /// The partitions, the oldest first.
    partitions: Vec<Partition>,
    samples_days: u32,
}

/// What became of old days.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Dropped {
    /// How many days are gone.
    days: usize,
    /// How many partitions are gone.
    pub partitions: usize,
    /// The days that stay because readers hold them, and who these are.
    held: Vec<(String, String)>,
    /// How many attempts ended without the lock.
    pub timeouts: usize,
}

impl Dropped {
    /// How many days stay because readers hold them.
    #[must_use]
    pub fn held(&self) -> usize {
        self.held.iter().map(|(day, _)| day).collect::<BTreeSet<_>>().len()
    }

    /// What is gone, in a sentence; `None` without such a day.
    #[must_use]
    pub fn gone(&self) -> Option<String> {
        match self.days {
            0 => None,
            1 => Some("the samples of one day are dropped".to_owned()),
            count => Some(format!("the samples of {count} days are dropped")),
        }
    }

    /// What stays and who holds it, in a sentence; `None` without such a day.
    #[must_use]
    pub fn stays(&self) -> Option<String> {
        let (first, readers) = self.held.first()?;
        let others = match self.held() {
            1 => String::new(),
            2 => " and another day".to_owned(),
            count => format!(" and {} other days", count - 1),
        };
        let readers = if readers.is_empty() { "a reader that has ended since" } else { readers };
        Some(format!(
            "the samples of {first}{others} stay, because {readers} held a lock: they are dropped when its transaction has ended; \
             `SELECT pg_terminate_backend(PROCESS)` ends it"
        ))
    }
}

impl OldDays {
    fn days(&self) -> BTreeSet<&str> {
        self.partitions.iter().map(|partition| partition.day.as_str()).collect()
    }

    /// Whether the days are few enough to be dropped without being told.
    #[must_use]
    pub fn are_few(&self) -> bool {
        self.count() <= MOST_UNTOLD
    }

    /// How many partitions these are.
    #[must_use]
    pub const fn partitions(&self) -> usize {
        self.partitions.len()
    }

    /// How many days these are.
    #[must_use]
    pub fn count(&self) -> usize {
        self.days().len()
    }

    /// The days in words; `None` without one.
    #[must_use]
    pub fn range(&self) -> Option<String> {
        let days = self.days();
        let (first, last) = (days.first()?, days.last()?);
        Some(match days.len() {
            1 => format!("the samples of {first}"),
            count => format!("the samples of {count} days, from {first} to {last},"),
        })
    }

    /// What happens to them, in a sentence; `None` without such a day.
    #[must_use]
    pub fn sentence(&self) -> Option<String> {
        let (range, kept) = (self.range()?, self.samples_days);
        Some(match self.are_few() {
            true => format!("{range} are dropped: samples-days is {kept}"),
            false => format!(
                "{range} are beyond samples-days = {kept} and are not dropped, because they are more than {MOST_UNTOLD}: correct samples-days \
                 or the clock of this computer, or drop them with `profivac archive FILE --drop-old-samples`"
            ),
        })
    }
}

impl Store {
    /// The days of samples that are older than the retention.
    ///
    /// # Errors
    /// [`StoreError`] when the database refuses.
    pub async fn old_days(&self, now: Micros) -> Result<OldDays, StoreError> {
        let before = now.0.div_euclid(DAY).saturating_sub(i64::from(self.samples_days));
        let rows = self.client.query(OLD_DAYS, &[&day_number(before)]).await?;
        let partition = |row: &tokio_postgres::Row| Partition { parent: row.get(0), name: row.get(1), day: row.get(2) };
        Ok(OldDays { partitions: rows.iter().map(partition).collect(), samples_days: self.samples_days })
    }

    /// Drops these days, each partition in a transaction of its own. Those that a reader holds stay.
    ///
    /// # Errors
    /// [`StoreError`] when the database refuses.
    pub async fn drop_days(&mut self, old: &OldDays) -> Result<Dropped, StoreError> {
        let (mut gone, mut dropped) = (BTreeSet::new(), Dropped::default());
        // The tables that a reader holds whole: a second wait for the same reader would only delay others.
        let mut held = BTreeSet::new();
        for partition in &old.partitions {
            let Partition { parent, name, day } = partition;
            if held.contains(parent) {
                dropped.held.push((day.clone(), self.readers(partition).await?));
                continue;
            }
            match self.drop_partition(parent, name).await? {
                Locked::Yes => {
                    dropped.partitions += 1;
                    gone.insert(day);
                }
                no => {
                    if no == Locked::NotTable {
                        held.insert(parent);
                    }
                    dropped.timeouts += 1;
                    dropped.held.push((day.clone(), self.readers(partition).await?));
                }
            }
        }
        dropped.days = gone.into_iter().filter(|day| !dropped.held.iter().any(|(held, _)| held == *day)).count();
        Ok(dropped)
    }

    async fn drop_partition(&mut self, parent: &str, name: &str) -> Result<Locked, StoreError> {
        let transaction = self.client.transaction().await?;
        transaction.batch_execute(BEGIN).await?;
        let lock = format!("LOCK TABLE ONLY {parent} IN ACCESS EXCLUSIVE MODE");
        if !is_locked(transaction.batch_execute(&lock).await)? {
            return Ok(Locked::NotTable);
        }
        // Another archive may have dropped it.
        if !is_locked(transaction.batch_execute(&format!("DROP TABLE IF EXISTS profivac_data.{name}")).await)? {
            return Ok(Locked::NotPartition);
        }
        transaction.commit().await?;
        Ok(Locked::Yes)
    }

    async fn readers(&self, partition: &Partition) -> Result<String, StoreError> {
        let table = format!("profivac_data.{}", partition.name);
        let rows = self.client.query(READERS, &[&partition.parent, &table]).await?;
        Ok(rows.iter().map(|row| row.get::<_, String>(0)).collect::<Vec<_>>().join(", "))
    }
}

/// Which locks were free within their time.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Locked {
    Yes,
    NotTable,
    NotPartition,
}

/// Whether a statement got its lock.
fn is_locked(result: Result<(), tokio_postgres::Error>) -> Result<bool, tokio_postgres::Error> {
    match result {
        Ok(()) => Ok(true),
        Err(error) if error.code().is_some_and(is_held) => Ok(false),
        Err(error) => Err(error),
    }
}

fn is_held(state: &SqlState) -> bool {
    [SqlState::LOCK_NOT_AVAILABLE, SqlState::T_R_DEADLOCK_DETECTED].contains(state)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn old(count: usize) -> OldDays {
        let partition = |parent: &str, day: usize| Partition {
            parent: parent.to_owned(),
            name: format!("{parent}_202601{day:02}"),
            day: format!("2026-01-{day:02}"),
        };
        let of_day = |day| [partition("point_sample", day), partition("sample", day)];
        OldDays { partitions: (1..=count).flat_map(of_day).collect(), samples_days: 3 }
    }

    #[test]
    fn a_week_of_samples_is_dropped_in_words_and_more_only_when_told() {
        assert_eq!(old(0).sentence(), None);
        assert_eq!(old(1).sentence().unwrap(), "the samples of 2026-01-01 are dropped: samples-days is 3");
        let week = old(7);
        let sentence = week.sentence().unwrap();
        assert_eq!(sentence, "the samples of 7 days, from 2026-01-01 to 2026-01-07, are dropped: samples-days is 3");
        assert!(week.are_few());
        let more = old(8);
        let sentence = more.sentence().unwrap();
        assert!(!more.are_few() && sentence.contains("are not dropped") && sentence.contains("--drop-old-samples"));
    }

    #[test]
    fn a_day_that_a_reader_holds_is_named_with_the_reader() {
        assert_eq!((Dropped::default().gone(), Dropped::default().stays()), (None, None));
        let held = |day: &str| (day.to_owned(), "process 7 (user ada, psql)".to_owned());
        let one = Dropped { days: 2, partitions: 4, held: vec![held("2026-01-02"), held("2026-01-02")], timeouts: 2 };
        assert_eq!(one.gone().unwrap(), "the samples of 2 days are dropped");
        let sentence = one.stays().unwrap();
        assert!(
            sentence.starts_with("the samples of 2026-01-02 stay, because process 7 (user ada, psql) held"),
            "{sentence}"
        );
        let two = Dropped { held: vec![held("2026-01-02"), held("2026-01-03")], ..one };
        let sentence = two.stays().unwrap();
        assert!(sentence.starts_with("the samples of 2026-01-02 and another day stay"), "{sentence}");
    }
}
