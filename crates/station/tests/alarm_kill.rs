//! A process that acknowledges alarms is killed forty times at random: no confirmed acknowledgement is lost, and alarms keep their state.

#![allow(clippy::unwrap_used, clippy::panic, reason = "a test")]

use crate::support;
use crate::support::database;
use crate::support::inputs::{actor, inputs};
use profivac_recorder::audit::AuditQuery;
use profivac_recorder::{Micros, Quality, Reader};
use profivac_station::alarm::{AlarmChangeKind, AlarmState, Condition, NotificationTarget, Priority, Rule, Series};
use profivac_station::services::Services;
use std::io::{BufRead, BufReader, Write};
use std::path::Path;
use std::process::{Command, Stdio};
use std::sync::Arc;
use std::time::Duration;

/// The environment variable that tells the child process the folder of its database.
const FOLDER: &str = "PROFIVAC_TEST_ALARMS_INTO";

fn rule(name: &str, limit: f64) -> Rule {
    Rule {
        name: name.to_owned(),
        condition: Condition::Above {
            series: Series { gauge: "chamber".to_owned(), name: "chamber".to_owned() },
            limit,
            reset: limit,
        },
        priority: Priority::High,
        delay: Duration::ZERO,
        off_delay: Duration::ZERO,
        message: None,
    }
}

/// The services over the database in `folder`, with the stored alarms.
fn open(folder: &Path) -> Arc<Services> {
    let services = support::services(folder);
    let rules = vec![rule("chatters", 1.0), rule("stands", 0.5), rule("was", 10.0), rule("away", 1.0)];
    let all = NotificationTarget::of_every_change("ops".to_owned(), Priority::Low);
    services.alarms().start(rules, vec![all]).unwrap();
    services
}

fn occurrence(services: &Services, name: &str) -> (AlarmState, i64) {
    let alarm = services.alarms().all().into_iter().find(|alarm| alarm.name == name).unwrap();
    (alarm.state, alarm.occurrence)
}

/// The child process: an alarm chatters and is acknowledged each time; a line is printed when the acknowledgement is confirmed.
#[test]
fn child_acknowledges_until_it_is_killed() {
    let Some(folder) = std::env::var_os(FOLDER) else { return };
    let services = open(Path::new(&folder));
    loop {
        services.alarms().evaluate(&inputs(2.0, Quality::Valid));
        let (_, raised) = occurrence(&services, "chatters");
        // The process before may have been killed after it had raised the alarm.
        if services.alarms().acknowledge("chatters", raised, &actor("Ada")).is_ok() {
            println!("acknowledged {raised}");
            std::io::stdout().flush().unwrap();
        }
        services.alarms().evaluate(&inputs(0.6, Quality::Valid));
    }
}

#[test]
fn forty_kills_lose_no_acknowledgement_and_no_alarm_state() {
    let folder = tempfile::tempdir().unwrap();
    let (folder, path) = (folder.path(), database(folder.path()));
    // One alarm is acknowledged, one has returned unacknowledged, one is out of service.
    let services = open(folder);
    services.alarms().evaluate(&inputs(20.0, Quality::Valid));
    services.alarms().evaluate(&inputs(0.6, Quality::Valid));
    let (_, stands) = occurrence(&services, "stands");
    services.alarms().acknowledge("stands", stands, &actor("Ada")).unwrap();
    services.alarms().take_out_of_service("away", &actor("Eve"), "calibration", None).unwrap();
    drop(services);
    let mut random = fastrand::Rng::with_seed(12);
    for _ in 0..40 {
        let acknowledged = kill_after(random.usize(1..8), random.usize(0..20_000), folder);
        let reader = Reader::open(&path).unwrap();
        let lines = reader.alarm_history(Micros(0), Micros(i64::MAX), Some("chatters"), u32::MAX).unwrap();
        let known: Vec<_> = lines
            .iter()
            .filter(|line| line.change == AlarmChangeKind::Acknowledged)
            .map(|line| line.occurrence)
            .collect();
        for raised in &acknowledged {
            assert!(known.contains(raised), "{raised} was confirmed and is lost");
        }
        let everything = AuditQuery {
            from: Micros(0),
            to: Micros(i64::MAX),
            gauge: None,
            user: Some("Ada".to_owned()),
            limit: u32::MAX,
        };
        let rows = reader.audit(&everything).unwrap();
        assert_eq!(rows.len(), known.len() + 1, "each acknowledgement has a row of the audit trail");
        let notifications = reader.queued_notifications("ops").unwrap().len();
        let all = reader.alarm_history(Micros(0), Micros(i64::MAX), None, u32::MAX).unwrap().len();
        assert_eq!(notifications, all, "each change has a notification");
        drop(reader);
        let services = open(folder);
        assert_eq!(occurrence(&services, "stands"), (AlarmState::Acknowledged, stands));
        assert_eq!(occurrence(&services, "was").0, AlarmState::Returned, "it is not acknowledged yet");
        assert_eq!(occurrence(&services, "away").0, AlarmState::OutOfService);
        assert_ne!(occurrence(&services, "chatters").0, AlarmState::OutOfService);
    }
}

/// Lets the child acknowledge `lines` times, spins `spins` times and kills it. Returns the acknowledged occurrences.
fn kill_after(lines: usize, spins: usize, folder: &Path) -> Vec<i64> {
    let mut child = Command::new(std::env::current_exe().unwrap())
        .args(["alarm_kill::child_acknowledges_until_it_is_killed", "--exact", "--nocapture"])
        .env(FOLDER, folder)
        .stdout(Stdio::piped())
        .stderr(Stdio::null())
        .spawn()
        .unwrap();
    let mut output = BufReader::new(child.stdout.take().unwrap()).lines();
    let number_in = |line: String| line.strip_prefix("acknowledged ").and_then(|number| number.parse::<i64>().ok());
    let mut all: Vec<_> = output.by_ref().map_while(Result::ok).filter_map(number_in).take(lines).collect();
    assert_eq!(all.len(), lines, "the child ended by itself");
    (0..spins).for_each(|_| std::hint::spin_loop());
    child.kill().unwrap();
    child.wait().unwrap();
    // Lines printed before the kill count too.
    all.extend(output.map_while(Result::ok).filter_map(number_in));
    all
}
