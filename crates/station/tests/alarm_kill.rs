//! The process is killed forty times, at any moment: no acknowledgement that was answered is lost, and alarms stand where they stood.

#![allow(clippy::unwrap_used, clippy::panic, reason = "a test")]

mod desk;

use desk::{actor, sight};
use profivac_recorder::audit::AuditQuery;
use profivac_recorder::{Micros, Reader, Recorder, Settings};
use profivac_station::alarm::{AlarmState, Condition, NotificationTarget, Priority, Rule, Subject};
use profivac_station::services::Services;
use std::io::{BufRead, BufReader, Write};
use std::path::Path;
use std::process::{Command, Stdio};
use std::time::Duration;

/// Set in the process that is killed: the file it records into.
const FILE: &str = "PROFIVAC_TEST_ALARMS_INTO";

fn rule(name: &str, limit: f64) -> Rule {
    Rule {
        name: name.to_owned(),
        subject: Subject::Series { gauge: "chamber".to_owned(), series: "chamber".to_owned() },
        condition: Condition::Above { limit, reset: limit },
        priority: Priority::High,
        delay: Duration::ZERO,
        off_delay: Duration::ZERO,
        message: None,
    }
}

/// The plant over the file, with its alarms where they stood.
fn open(path: &Path) -> Services {
    let recorder = Recorder::start(path, Settings::default()).unwrap();
    let plant = Services::new("hall".to_owned(), path.to_owned(), recorder);
    let rules = vec![rule("chatters", 1.0), rule("stands", 0.5), rule("was", 10.0), rule("away", 1.0)];
    let everything = NotificationTarget { webhook: "ops".to_owned(), min_priority: Priority::Low };
    plant.alarms().begin(&plant, rules, vec![everything]).unwrap();
    plant
}

fn occurrence(plant: &Services, name: &str) -> (AlarmState, i64) {
    let alarm = plant.alarms().all().into_iter().find(|alarm| alarm.name == name).unwrap();
    (alarm.state, alarm.occurrence)
}

/// What the killed process does: an alarm chatters; it is acknowledged each time, and a line is printed as soon as that is answered.
#[test]
fn raise_and_acknowledge_for_ever_when_told_so() {
    let Some(path) = std::env::var_os(FILE) else { return };
    let plant = open(Path::new(&path));
    loop {
        plant.alarms().evaluate(plant.recorder(), &sight(2.0, "valid"));
        let (_, raised) = occurrence(&plant, "chatters");
        // The process before may have died between this and what follows.
        if plant.alarms().acknowledge(plant.recorder(), "chatters", raised, &actor("Ada")).is_ok() {
            println!("acknowledged {raised}");
            std::io::stdout().flush().unwrap();
        }
        plant.alarms().evaluate(plant.recorder(), &sight(0.6, "valid"));
    }
}

#[test]
fn forty_kills_lose_no_acknowledgement_and_leave_alarms_where_they_stood() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("plant.db");
    // One that stands acknowledged, one that is over and nobody knows, one that is out of service.
    let plant = open(&path);
    plant.alarms().evaluate(plant.recorder(), &sight(20.0, "valid"));
    plant.alarms().evaluate(plant.recorder(), &sight(0.6, "valid"));
    let (_, stands) = occurrence(&plant, "stands");
    plant.alarms().acknowledge(plant.recorder(), "stands", stands, &actor("Ada")).unwrap();
    plant.alarms().take_out_of_service(plant.recorder(), "away", &actor("Eve"), "calibration", None).unwrap();
    drop(plant);
    let mut random = fastrand::Rng::with_seed(12);
    for _ in 0..40 {
        let acknowledged = kill_after(random.usize(1..8), random.usize(0..20_000), &path);
        let reader = Reader::open(&path).unwrap();
        let lines = reader.alarm_history(Micros(0), Micros(i64::MAX), Some("chatters"), u32::MAX).unwrap();
        let known: Vec<_> =
            lines.iter().filter(|line| line.change == "acknowledged").map(|line| line.occurrence).collect();
        for raised in &acknowledged {
            assert!(known.contains(raised), "{raised} was answered and is lost");
        }
        let everything = AuditQuery {
            from: Micros(0),
            to: Micros(i64::MAX),
            gauge: None,
            user: Some("Ada".to_owned()),
            limit: u32::MAX,
        };
        let rows = reader.audit(&everything).unwrap();
        assert_eq!(rows.len(), known.len() + 1, "each acknowledgement has its row, and the first has one");
        let told = reader.queued_notifications("ops").unwrap().len();
        let all = reader.alarm_history(Micros(0), Micros(i64::MAX), None, u32::MAX).unwrap().len();
        assert_eq!(told, all, "each line has its letter");
        drop(reader);
        let plant = open(&path);
        assert_eq!(occurrence(&plant, "stands"), (AlarmState::Acknowledged, stands));
        assert_eq!(occurrence(&plant, "was").0, AlarmState::Returned, "nobody knows of it yet");
        assert_eq!(occurrence(&plant, "away").0, AlarmState::OutOfService);
        assert_ne!(occurrence(&plant, "chatters").0, AlarmState::OutOfService);
    }
}

/// Lets the process acknowledge so often, spins a little, kills it. Returns what it said was acknowledged.
fn kill_after(lines: usize, spins: usize, path: &Path) -> Vec<i64> {
    let mut child = Command::new(std::env::current_exe().unwrap())
        .args(["raise_and_acknowledge_for_ever_when_told_so", "--exact", "--nocapture"])
        .env(FILE, path)
        .stdout(Stdio::piped())
        .stderr(Stdio::null())
        .spawn()
        .unwrap();
    let mut output = BufReader::new(child.stdout.take().unwrap()).lines();
    let told = |line: String| line.strip_prefix("acknowledged ").and_then(|number| number.parse::<i64>().ok());
    let mut all: Vec<_> = output.by_ref().map_while(Result::ok).filter_map(told).take(lines).collect();
    assert_eq!(all.len(), lines, "it ended by itself");
    (0..spins).for_each(|_| std::hint::spin_loop());
    child.kill().unwrap();
    child.wait().unwrap();
    // What it said before it died counts too.
    all.extend(output.map_while(Result::ok).filter_map(told));
    all
}
