//! Records into a database with an outbox, and prints a line for each step that is on the disk.
//!
//! ```text
//! cargo run -p profivac-recorder --example acknowledged -- plant.db 20
//! ```
//!
//! Step N, which continues behind the steps in the database, has a sample and an event at N seconds after 2026-01-01, two rows of the
//! audit trail, a change of an alarm with a row of its history, and a notification; an archive has every fifth batch. `ci/power_cut`
//! cuts the power at each system call of this program.

use profivac_model::{AlarmChangeKind, AlarmHistoryEntry, AlarmState, AlarmStatus, Priority, Role};
use profivac_recorder::alarms::{AlarmBatch, Notification};
use profivac_recorder::outbox::Acknowledgement;
use profivac_recorder::{
    AuditAction, AuditEntry, Event, EventKind, Forward, Micros, Quality, Reader, Recorder, Sample, Settings,
};
use std::collections::BTreeMap;
use std::error::Error;
use std::path::{Path, PathBuf};
use std::sync::Arc;

const BEGIN: i64 = 1_767_225_600 * Micros::SECOND;

fn main() -> Result<(), Box<dyn Error>> {
    let mut arguments = std::env::args_os().skip(1);
    let path = PathBuf::from(arguments.next().ok_or("expected a database: acknowledged FILE STEPS")?);
    let steps: i64 =
        arguments.next().and_then(|text| text.to_str()?.parse().ok()).ok_or("expected a number of steps")?;
    let settings = Settings { outbox: Some(Forward::All), ..Settings::default() };
    let recorder = Recorder::start(&path, settings)?;
    let first = next_step(&path)?;
    for number in first..first.saturating_add(steps) {
        record(&recorder, &path, number)?;
        // The time of the acknowledgement: a reader may read this line much later.
        println!("acknowledged {number} at {}", Micros::now().0);
    }
    Ok(())
}

/// The number of the first step that is not in the database.
fn next_step(path: &Path) -> Result<i64, Box<dyn Error>> {
    let events = Reader::open(path)?.events(Micros(0), Micros(i64::MAX), u32::MAX)?;
    Ok(events.iter().filter_map(|event| event.text.parse::<i64>().ok()).max().map_or(0, |last| last.saturating_add(1)))
}

/// Records a step, and returns when all of it is on the disk.
fn record(recorder: &Recorder, path: &Path, number: i64) -> Result<(), Box<dyn Error>> {
    let at = Micros(BEGIN.saturating_add(number.saturating_mul(Micros::SECOND)));
    let gauge: Arc<str> = Arc::from("chamber");
    // Each pressure is outside the deadband of the one before.
    let pressure = if number % 2 == 0 { 1.0 } else { 10.0 };
    recorder.push(&gauge, Sample::new(at, Some(pressure), Quality::Valid));
    recorder.audit_before_sending(audit(at, AuditAction::Execute, number))?;
    let alarm =
        AlarmStatus { state: AlarmState::Unacknowledged, since: at, occurrence: number, ..AlarmStatus::default() };
    let batch = AlarmBatch {
        alarms: [("high".to_owned(), Some(alarm))].into(),
        plant_states: BTreeMap::new(),
        history: vec![history(at, number)],
        audit: vec![audit(at, AuditAction::Acknowledged, number)],
        notifications: vec![Notification { id: 0, webhook: "shift".to_owned(), at, body: number.to_string() }],
        finished_notifications: Vec::new(),
    };
    let event = Event { at, gauge: Some(gauge.to_string()), kind: EventKind::Note.into(), text: number.to_string() };
    if !recorder.record_alarms_with_receipt(batch, vec![event]).wait() {
        return Err("the disk has not answered for ten seconds".into());
    }
    if number % 5 == 4 {
        let page = Reader::open(path)?.outbox(0, 1, usize::MAX)?;
        if let Some(batch) = page.batches.first() {
            recorder.acknowledge_outbox(Acknowledgement {
                epoch: page.epoch,
                taken: batch.number,
                stored: batch.number,
            });
        }
    }
    Ok(())
}

fn audit(at: Micros, action: AuditAction, number: i64) -> AuditEntry {
    AuditEntry {
        id: 0,
        at,
        action: action.into(),
        refers_to: None,
        user: "ada".to_owned(),
        role: Role::Engineer.into(),
        peer: None,
        gauge: Some("chamber".to_owned()),
        segment: None,
        address: None,
        target: None,
        before: None,
        after: Some(number.to_string()),
        outcome: None,
        command_id: None,
    }
}

fn history(at: Micros, number: i64) -> AlarmHistoryEntry {
    AlarmHistoryEntry {
        at,
        alarm: "high".to_owned(),
        change: AlarmChangeKind::Raised.into(),
        state: AlarmState::Unacknowledged.into(),
        priority: Priority::High.into(),
        subject: None,
        occurrence: number,
        user: None,
        value: None,
        unit: None,
        text: "a step".to_owned(),
    }
}
