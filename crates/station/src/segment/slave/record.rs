//! The DP-V1 records with points of a slave that the station does not own: when they are read, and what they give.

use super::SegmentSlave;
use super::points::{planned_point, valued_point};
use crate::config;
use crate::recording::RecorderHandle;
use crate::segment::moment::Moment;
use crate::view::WatchedParameter;
use profivac_client::ms2::Ms2Error;
use profivac_recorder::EventKind;
use std::time::{Duration, Instant};

/// The reads of a record without an answer after which its points are stale. chosen: one lost answer says nothing about the slave.
const MISSED_READS: u8 = 3;

/// A record that was not answered is read again after this time at the earliest. chosen.
const AFTER_MISS: Duration = Duration::from_secs(10);

/// A record with points, by slot and index.
pub struct Record {
    place: (u8, u8),
    every: Duration,
    due: Instant,
    /// The reads without an answer since the last one with an answer.
    missed: u8,
    /// The last event says that it is not read.
    is_told: bool,
}

impl Record {
    /// Whether the slave gives the record, as far as is known.
    pub const fn is_answered(&self) -> bool {
        self.missed < MISSED_READS
    }

    /// The slave gives no records any more: this one is read as soon as it does.
    pub const fn restart(&mut self, now: Instant) {
        (self.due, self.missed) = (now, 0);
    }
}

/// The records of the points. Several points may share one, which is read as often as one of them needs.
pub fn records(config: &config::Slave, now: Instant) -> Vec<Record> {
    let mut records: Vec<Record> = Vec::new();
    for config::WatchedRecord { slot, index, every } in config.points.iter().filter_map(|point| point.record) {
        match records.iter_mut().find(|record| record.place == (slot, index)) {
            Some(known) => known.every = known.every.min(every),
            None => records.push(Record { place: (slot, index), every, due: now, missed: 0, is_told: false }),
        }
    }
    records
}

impl SegmentSlave {
    /// When its first record is to be read; `None` while the slave gives none.
    fn first_due(&self) -> Option<Instant> {
        self.records.iter().map(|record| record.due).min().filter(|_| self.gives_records())
    }

    /// The record that is to be read now, if there is one. If so, sets the time of its next reading.
    fn record_due(&mut self, now: Instant) -> Option<(u8, u8)> {
        let is_given = self.gives_records();
        let due = self.records.iter_mut().filter(|record| is_given && record.due <= now);
        let record = due.min_by_key(|record| record.due)?;
        record.due = now + record.every;
        Some(record.place)
    }

    /// Takes the octets of a record, or why it was not read. After [`MISSED_READS`] misses this is the text of its points, and one event.
    pub fn take_record(
        &mut self,
        recorder: &RecorderHandle,
        place: (u8, u8),
        read: &Result<Vec<u8>, Ms2Error>,
        now: Moment,
    ) {
        // It may have been lost meanwhile.
        let is_given = self.gives_records();
        let Some(record) = self.records.iter_mut().find(|record| is_given && record.place == place) else { return };
        record.missed = if read.is_ok() { 0 } else { record.missed.saturating_add(1) };
        if read.is_err() {
            // The wait for an answer holds up the other requests of the line.
            record.due = now.at + record.every.max(AFTER_MISS);
            if record.is_answered() {
                return;
            }
        }
        let (slot, index) = place;
        let cause = read.as_ref().err().map(|error| format!("record {slot}/{index} was not read: {error}"));
        if std::mem::replace(&mut record.is_told, cause.is_some()) != cause.is_some() {
            let text = cause.clone().unwrap_or_else(|| format!("record {slot}/{index} is read again"));
            let text = format!("{}: {text}", self.config.name);
            recorder.event_at(now.wall, Some(&self.config.name), EventKind::Gauge, text);
        }
        let is_of_record = |point: &config::SlavePoint| point.record.is_some_and(|it| (it.slot, it.index) == place);
        let values = self.config.points.iter().zip(self.points.iter()).map(|(point, present)| match read {
            _ if !is_of_record(point) => present.clone(),
            Ok(octets) => valued_point(point, octets, now),
            Err(_) => WatchedParameter { text: cause.clone().unwrap_or_default(), ..planned_point(point) },
        });
        self.points = values.collect();
        self.record(recorder, now.wall, is_of_record);
        self.tell_changes(recorder, now);
    }
}

/// The address of the slave whose record is read next, and slot and index: of all slaves the record that has waited longest, as
/// [`super::next_request`] does. Sets the time of the next reading.
pub fn next_record(slaves: &mut [SegmentSlave], now: Moment) -> Option<(u8, (u8, u8))> {
    let due = slaves.iter_mut().filter_map(|slave| Some((slave.first_due()?, slave)));
    let (_, slave) = due.filter(|(due, _)| *due <= now.at).min_by_key(|(due, _)| *due)?;
    Some((slave.config.address, slave.record_due(now.at)?))
}
