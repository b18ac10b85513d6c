//! The process is killed while a command is being sent: after the restart the audit trail says that the outcome is not known.

#![allow(clippy::unwrap_used, clippy::panic, clippy::indexing_slicing, reason = "a test")]

use crate::support;
use crate::support::database;
use crate::support::inputs::{gauge, segment};
use profivac_devices::bcg450::table::MODEL;
use profivac_model::Word;
use profivac_recorder::audit::AuditQuery;
use profivac_recorder::{AuditAction, Micros, Reader, Recorder, Settings};
use profivac_station::control::AuthorityAction;
use profivac_station::control::operation::{Operation, OperationPreview, OperationRequest};
use profivac_station::control::requests::SegmentRequest;
use profivac_station::snapshot::SegmentSnapshot;
use profivac_station::view::{Risk, RiskClass};
use profivac_web_server::auth::{Actor, Role, User};
use std::io::{BufRead, BufReader, Write};
use std::path::Path;
use std::process::{Command, Stdio};
use std::sync::Arc;
use std::time::Instant;

/// The environment variable that tells the child process the folder of its database.
const FOLDER: &str = "PROFIVAC_TEST_ACT_INTO";

/// The child process: it executes a command, and the gauge never answers.
#[test]
fn child_executes_until_it_is_killed() {
    let Some(folder) = std::env::var_os(FOLDER) else { return };
    let services = support::services(Path::new(&folder));
    services.snapshots().publish(SegmentSnapshot { segment: segment(), gauges: vec![gauge(Vec::new())] });
    let requests = services.control().requests().accept("hall");
    std::thread::spawn(move || {
        let mut unanswered = Vec::new();
        while let Ok(request) = requests.recv() {
            match request {
                SegmentRequest::Preview(_, _, answer) => answer.send(Ok(preview())).unwrap(),
                SegmentRequest::Execute(..) => {
                    println!("sending");
                    std::io::stdout().flush().unwrap();
                    unanswered.push(request);
                }
                SegmentRequest::Blocks(..) => panic!("expected no request for blocks"),
            }
        }
    });
    let user = User { name: Arc::from("Otto"), role: Role::Operator };
    let actor = Actor { user, peer: None };
    services.control().change_authority(&actor, AuthorityAction::Request, Instant::now()).unwrap();
    let request = OperationRequest { command: Some("degas-on".to_owned()), ..OperationRequest::default() };
    let command = services.control().arm(&actor, "chamber", &request).unwrap();
    services.control().execute(&actor, &command.id).map(drop).unwrap();
}

fn preview() -> OperationPreview {
    let request = OperationRequest { command: Some("degas-on".to_owned()), ..OperationRequest::default() };
    let operation = Operation::resolve(&MODEL, &request).unwrap();
    let risk = Risk { class: RiskClass::Dangerous, description: operation.command.unwrap().risk.to_owned() };
    OperationPreview {
        device: "bcg450",
        address: 5,
        octets: vec![1, 1],
        before: None,
        after: operation.text,
        forced: None,
        risk,
        conditions: Vec::new(),
    }
}

/// Action, user and outcome of all rows, the earliest first.
fn trail(path: &Path) -> Vec<(Word<AuditAction>, String, Option<String>)> {
    let wanted = AuditQuery { from: Micros(0), to: Micros(i64::MAX), gauge: None, user: None, limit: 1000 };
    let rows = Reader::open(path).unwrap().audit(&wanted).unwrap();
    rows.into_iter().rev().map(|row| (row.action, row.user, row.outcome)).collect()
}

#[test]
fn a_command_that_was_being_sent_when_the_process_was_killed_gets_an_outcome() {
    let folder = tempfile::tempdir().unwrap();
    let (folder, path) = (folder.path(), database(folder.path()));
    for kills in 1..=3 {
        kill_while_sending(folder);
        let fired = trail(&path);
        assert_eq!(
            fired.last(),
            Some(&(AuditAction::Execute.into(), "Otto".to_owned(), None)),
            "the row is written before the command is sent"
        );
        drop(Recorder::start(&path, Settings::default()).unwrap());
        let closed = trail(&path);
        let unknown = "not known: the station ended meanwhile".to_owned();
        assert_eq!(closed.last(), Some(&(AuditAction::Outcome.into(), "Otto".to_owned(), Some(unknown))));
        drop(Recorder::start(&path, Settings::default()).unwrap());
        assert_eq!(trail(&path), closed, "the outcome is added once");
        assert_eq!(closed.len(), 3 * kills);
    }
}

/// Lets the child execute a command, and kills it while the gauge does not answer.
fn kill_while_sending(folder: &Path) {
    let mut child = Command::new(std::env::current_exe().unwrap())
        .args(["audit_power_cut::child_executes_until_it_is_killed", "--exact", "--nocapture"])
        .env(FOLDER, folder)
        .stdout(Stdio::piped())
        .stderr(Stdio::inherit())
        .spawn()
        .unwrap();
    let mut output = BufReader::new(child.stdout.take().unwrap()).lines();
    assert!(
        output.by_ref().map_while(Result::ok).any(|line| line.ends_with("sending")),
        "the child executes a command"
    );
    child.kill().unwrap();
    child.wait().unwrap();
}
