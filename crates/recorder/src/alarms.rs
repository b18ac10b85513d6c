//! Where alarms stand, their history, and letters to webhooks that wait: tables beside what was measured, written in the same transactions.

use super::audit::{self, Entry};
use super::reader::Reader;
use super::sample::Micros;
use super::store::StoreError;
use rusqlite::{Connection, Row, Transaction, params};
use std::collections::BTreeMap;

/// The step that makes the tables.
pub const TABLES: &str = "
    -- Where each alarm stands. Times in microseconds since 1970.
    CREATE TABLE alarm (
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
    ) WITHOUT ROWID;
    CREATE TABLE alarm_history (
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
    );
    CREATE INDEX alarm_history_at ON alarm_history (at);
    -- What webhooks have not taken yet. No number is ever used twice.
    CREATE TABLE letter (
        id   INTEGER PRIMARY KEY AUTOINCREMENT,
        hook TEXT NOT NULL,
        at   INTEGER NOT NULL,
        body TEXT NOT NULL
    );
    CREATE INDEX letter_hook ON letter (hook, id);
";

/// Where an alarm stands.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Kept {
    /// The word of its state.
    pub state: String,
    /// Since when.
    pub since: Micros,
    /// Which time it was raised.
    pub occurrence: i64,
    /// When it was raised last.
    pub raised: Option<Micros>,
    /// The value then.
    pub value: Option<f64>,
    /// What was seen then.
    pub text: String,
    /// Who knows, and since when.
    pub acknowledged: Option<(String, Micros)>,
    /// Who took it out of service, when, and why.
    pub out: Option<(String, Micros, String)>,
    /// When it comes back.
    pub out_until: Option<Micros>,
}

/// A line of the history.
#[derive(Clone, Debug, PartialEq)]
pub struct Line {
    /// When.
    pub at: Micros,
    /// The alarm.
    pub alarm: String,
    /// What happened.
    pub what: String,
    /// The state it led to.
    pub state: String,
    /// The priority it had.
    pub priority: String,
    /// The gauge or segment.
    pub subject: Option<String>,
    /// Which time it was raised.
    pub occurrence: i64,
    /// Who did it.
    pub who: Option<String>,
    /// The value then.
    pub value: Option<f64>,
    /// Its unit.
    pub unit: Option<String>,
    /// A sentence.
    pub text: String,
}

/// A letter that a webhook has not taken yet.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Letter {
    /// Its number; 0 before it is on the disk.
    pub id: i64,
    /// To which webhook.
    pub hook: String,
    /// When it was written.
    pub at: Micros,
    /// What it says.
    pub body: String,
}

/// What is to be written together.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Batch {
    /// Where alarms stand now; nothing for one that is not there any more.
    pub kept: BTreeMap<String, Option<Kept>>,
    /// What happened.
    pub lines: Vec<Line>,
    /// What people did, for the audit trail.
    pub audit: Vec<Entry>,
    /// What is to be told.
    pub letters: Vec<Letter>,
    /// The numbers of letters that nobody waits for any more.
    pub gone: Vec<i64>,
}

impl Batch {
    /// What came later, too. Says how many lines, rows and letters found no room among so many.
    pub fn append(&mut self, mut later: Self, most: usize) -> u64 {
        self.kept.append(&mut later.kept);
        self.gone.append(&mut later.gone);
        let lost = fill(&mut self.lines, later.lines, most);
        let lost = lost.saturating_add(fill(&mut self.audit, later.audit, most));
        lost.saturating_add(fill(&mut self.letters, later.letters, most))
    }

    /// Whether there is nothing to be written.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.kept.is_empty()
            && self.lines.is_empty()
            && self.audit.is_empty()
            && self.letters.is_empty()
            && self.gone.is_empty()
    }

    /// Writes all of it.
    pub(super) fn write(&self, transaction: &Transaction<'_>) -> rusqlite::Result<()> {
        for (name, kept) in &self.kept {
            match kept {
                Some(kept) => keep(transaction, name, kept)?,
                None => forget(transaction, name)?,
            }
        }
        self.lines.iter().try_for_each(|line| insert_line(transaction, line))?;
        self.audit.iter().try_for_each(|entry| audit::insert(transaction, entry).map(drop))?;
        for Letter { hook, at, body, .. } in &self.letters {
            transaction
                .prepare_cached("INSERT INTO letter (hook, at, body) VALUES (?1, ?2, ?3)")?
                .execute(params![hook, at.0, body])?;
        }
        for id in &self.gone {
            transaction.prepare_cached("DELETE FROM letter WHERE id = ?1")?.execute([id])?;
        }
        Ok(())
    }
}

fn fill<T>(all: &mut Vec<T>, more: Vec<T>, most: usize) -> u64 {
    let room = most.saturating_sub(all.len());
    let lost = more.len().saturating_sub(room);
    all.extend(more.into_iter().take(room));
    lost as u64
}

fn keep(connection: &Connection, name: &str, kept: &Kept) -> rusqlite::Result<()> {
    let (acknowledged, out) = (kept.acknowledged.as_ref(), kept.out.as_ref());
    connection
        .prepare_cached("INSERT OR REPLACE INTO alarm VALUES (?1, ?2, ?3, ?4, ?5, ?6, ?7, ?8, ?9, ?10, ?11, ?12, ?13)")?
        .execute(params![
            name,
            kept.state,
            kept.since.0,
            kept.occurrence,
            kept.raised.map(|at| at.0),
            kept.value,
            kept.text,
            acknowledged.map(|(who, _)| who),
            acknowledged.map(|(_, at)| at.0),
            out.map(|(who, _, _)| who),
            out.map(|(_, at, _)| at.0),
            out.map(|(_, _, reason)| reason),
            kept.out_until.map(|at| at.0),
        ])
        .map(drop)
}

fn forget(connection: &Connection, name: &str) -> rusqlite::Result<()> {
    connection.prepare_cached("DELETE FROM alarm WHERE name = ?1")?.execute([name]).map(drop)
}

fn insert_line(connection: &Connection, line: &Line) -> rusqlite::Result<()> {
    connection
        .prepare_cached(
            "INSERT INTO alarm_history (at, alarm, what, state, priority, subject, occurrence, who, value, unit, text)
             VALUES (?1, ?2, ?3, ?4, ?5, ?6, ?7, ?8, ?9, ?10, ?11)",
        )?
        .execute(params![
            line.at.0,
            line.alarm,
            line.what,
            line.state,
            line.priority,
            line.subject,
            line.occurrence,
            line.who,
            line.value,
            line.unit,
            line.text
        ])
        .map(drop)
}

fn kept(row: &Row<'_>) -> rusqlite::Result<(String, Kept)> {
    let time = |place: usize| Ok::<_, rusqlite::Error>(row.get::<_, Option<i64>>(place)?.map(Micros));
    let text = |place: usize| row.get::<_, Option<String>>(place);
    let out = text(9)?.zip(time(10)?).zip(text(11)?);
    let kept = Kept {
        state: row.get(1)?,
        since: Micros(row.get(2)?),
        occurrence: row.get(3)?,
        raised: time(4)?,
        value: row.get(5)?,
        text: row.get(6)?,
        acknowledged: text(7)?.zip(time(8)?),
        out: out.map(|((who, at), reason)| (who, at, reason)),
        out_until: time(12)?,
    };
    Ok((row.get(0)?, kept))
}

fn line(row: &Row<'_>) -> rusqlite::Result<Line> {
    Ok(Line {
        at: Micros(row.get(0)?),
        alarm: row.get(1)?,
        what: row.get(2)?,
        state: row.get(3)?,
        priority: row.get(4)?,
        subject: row.get(5)?,
        occurrence: row.get(6)?,
        who: row.get(7)?,
        value: row.get(8)?,
        unit: row.get(9)?,
        text: row.get(10)?,
    })
}

fn letter(row: &Row<'_>) -> rusqlite::Result<Letter> {
    Ok(Letter { id: row.get(0)?, hook: row.get(1)?, at: Micros(row.get(2)?), body: row.get(3)? })
}

impl Reader {
    /// Where all alarms stand, as far as something ever became of them.
    ///
    /// # Errors
    /// [`StoreError`] when the file cannot be read.
    pub fn alarms(&self) -> Result<Vec<(String, Kept)>, StoreError> {
        self.all("SELECT * FROM alarm", [], kept)
    }

    /// What happened to alarms in a time, the latest first, at most so much; to one of them, if it is named.
    ///
    /// # Errors
    /// [`StoreError`] when the file cannot be read.
    pub fn alarm_history(
        &self,
        from: Micros,
        to: Micros,
        alarm: Option<&str>,
        most: u32,
    ) -> Result<Vec<Line>, StoreError> {
        self.all(
            "SELECT at, alarm, what, state, priority, subject, occurrence, who, value, unit, text FROM alarm_history
             WHERE at BETWEEN ?1 AND ?2 AND (?3 IS NULL OR alarm = ?3) ORDER BY at DESC, id DESC LIMIT ?4",
            params![from.0, to.0, alarm, most],
            line,
        )
    }

    /// What a letter to a webhook says, if it is still there.
    ///
    /// # Errors
    /// [`StoreError`] when the file cannot be read.
    pub fn letter(&self, id: i64) -> Result<Option<Letter>, StoreError> {
        Ok(self.all("SELECT id, hook, at, body FROM letter WHERE id = ?1", [id], letter)?.pop())
    }

    /// The numbers and times of all letters to a webhook, in their order.
    ///
    /// # Errors
    /// [`StoreError`] when the file cannot be read.
    pub fn letters(&self, hook: &str) -> Result<Vec<(i64, Micros)>, StoreError> {
        let sql = "SELECT id, at FROM letter WHERE hook = ?1 ORDER BY id";
        self.all(sql, [hook], |row| Ok((row.get(0)?, Micros(row.get(1)?))))
    }

    /// The numbers of letters to webhooks other than these.
    ///
    /// # Errors
    /// [`StoreError`] when the file cannot be read.
    pub fn letters_to_others(&self, hooks: &[String]) -> Result<Vec<i64>, StoreError> {
        let all = self.all("SELECT id, hook, at, '' FROM letter", [], letter)?;
        Ok(all.into_iter().filter(|letter| !hooks.contains(&letter.hook)).map(|letter| letter.id).collect())
    }
}
