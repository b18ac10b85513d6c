//! The process is killed between "fired" and its outcome: the trail says so.

#![allow(clippy::unwrap_used, clippy::panic, clippy::indexing_slicing, reason = "a test")]

use profivac_devices::bcg450::table::MODEL;
use profivac_recorder::audit::AuditQuery;
use profivac_recorder::{AuditAction, Micros, Reader, Recorder, Settings};
use profivac_station::auth::{Role, User};
use profivac_station::control::operation::{Operation, OperationPreview, OperationRequest};
use profivac_station::control::permissions::{Risk, RiskClass};
use profivac_station::control::{self, Actor, AuthorityAction};
use profivac_station::services::{SegmentRequest, SegmentSnapshot, Services};
use profivac_station::view::{BusStationState, Gauge, Segment, SegmentState};
use std::io::{BufRead, BufReader, Write};
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::sync::Arc;
use std::time::Instant;

/// Set in the process that is killed: the file it records into.
const FILE: &str = "PROFIVAC_TEST_ACT_INTO";

/// What the killed process does: it fires, and the gauge never says what came of it.
#[test]
fn fire_for_ever_when_told_so() {
    let Some(path) = std::env::var_os(FILE).map(PathBuf::from) else { return };
    let recorder = Recorder::start(&path, Settings::default()).unwrap();
    let plant = Arc::new(Services::new("Target hall".to_owned(), path, recorder));
    plant.publish(scenery());
    let questions = plant.accept_requests("hall");
    std::thread::spawn(move || {
        let mut hung = Vec::new();
        while let Ok(question) = questions.recv() {
            match question {
                SegmentRequest::Preview(_, _, answer) => answer.send(Ok(draft())).unwrap(),
                SegmentRequest::Execute(..) => {
                    println!("sending");
                    std::io::stdout().flush().unwrap();
                    hung.push(question);
                }
                SegmentRequest::Blocks(..) => panic!("nobody asks for blocks"),
            }
        }
    });
    let person = User { name: Arc::from("Otto"), role: Role::Operator };
    let actor = Actor { user: person, peer: None };
    control::change_authority(&plant, &actor, AuthorityAction::Request, Instant::now()).unwrap();
    let wish = OperationRequest { command: Some("degas-on".to_owned()), ..OperationRequest::default() };
    let order = control::arm(&plant, &actor, "chamber", &wish).unwrap();
    control::execute(&plant, &actor, &order.id).map(drop).unwrap();
}

fn draft() -> OperationPreview {
    let wish = OperationRequest { command: Some("degas-on".to_owned()), ..OperationRequest::default() };
    let choice = Operation::of(&MODEL, &wish).unwrap();
    let risk = Risk { class: RiskClass::Dangerous, words: choice.command.unwrap().risk.to_owned() };
    OperationPreview {
        device: "bcg450",
        address: 5,
        octets: vec![1, 1],
        before: None,
        after: choice.text,
        risk,
        conditions: Vec::new(),
    }
}

fn scenery() -> SegmentSnapshot {
    let gauge = Gauge {
        name: "chamber".to_owned(),
        segment: "hall".to_owned(),
        address: 5,
        device: "bcg450".to_owned(),
        standing: BusStationState::Exchanging,
        trouble: None,
        exceptions: Vec::new(),
        gas: "n2".to_owned(),
        levels: Vec::new(),
        readings: Vec::new(),
        age_ms: None,
        poll_ms: 200,
    };
    let segment = Segment {
        name: "hall".to_owned(),
        port: "/dev/ttyUSB0".to_owned(),
        baud: 19200,
        master: 0,
        state: SegmentState::Running,
        trouble: None,
        cycle_ms: None,
        damaged: 0,
        stations: Vec::new(),
    };
    SegmentSnapshot { segment, gauges: vec![gauge] }
}

/// What, who and outcome of all rows, the earliest first.
fn trail(path: &Path) -> Vec<(AuditAction, String, Option<String>)> {
    let wanted = AuditQuery { from: Micros(0), to: Micros(i64::MAX), gauge: None, user: None, limit: 1000 };
    let rows = Reader::open(path).unwrap().audit(&wanted).unwrap();
    rows.into_iter().rev().map(|row| (row.entry.action, row.entry.user, row.entry.outcome)).collect()
}

#[test]
fn what_was_fired_when_the_process_was_killed_has_an_outcome() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("plant.db");
    for kills in 1..=3 {
        kill_while_sending(&path);
        let fired = trail(&path);
        assert_eq!(fired.last(), Some(&(AuditAction::Execute, "Otto".to_owned(), None)), "written before it is sent");
        drop(Recorder::start(&path, Settings::default()).unwrap());
        let closed = trail(&path);
        let unknown = "not known: the station ended meanwhile".to_owned();
        assert_eq!(closed.last(), Some(&(AuditAction::Outcome, "Otto".to_owned(), Some(unknown))));
        drop(Recorder::start(&path, Settings::default()).unwrap());
        assert_eq!(trail(&path), closed, "closed once");
        assert_eq!(closed.len(), 3 * kills);
    }
}

/// Lets the process fire, and kills it while the gauge does not answer.
fn kill_while_sending(path: &Path) {
    let mut child = Command::new(std::env::current_exe().unwrap())
        .args(["fire_for_ever_when_told_so", "--exact", "--nocapture"])
        .env(FILE, path)
        .stdout(Stdio::piped())
        .stderr(Stdio::inherit())
        .spawn()
        .unwrap();
    let mut output = BufReader::new(child.stdout.take().unwrap()).lines();
    assert!(output.by_ref().map_while(Result::ok).any(|line| line.ends_with("sending")), "it fires");
    child.kill().unwrap();
    child.wait().unwrap();
}
