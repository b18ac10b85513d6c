//! Writing through a gateway: role, control authority, conditions and audit trail are those of the API.

#![allow(clippy::unwrap_used, clippy::panic, clippy::indexing_slicing, reason = "a test")]

use crate::until::until;
use profivac_gateway::command::controlled_gauges;
use profivac_gateway::model::Modeller;
use profivac_gateway::{Commander, Inputs, ReadModel, Signal, Value, WriteError, WriteRequest};
use profivac_recorder::Micros;
use profivac_recorder::audit::AuditQuery;
use profivac_station::alarm::{AlarmError, AlarmServiceError};
use profivac_station::control::AuthorityAction;
use profivac_station::control::operation::{Operation, OperationRequest};
use profivac_station::station::Station;
use profivac_station::view::BusStationState;
use profivac_web_server::auth::password::Hash;
use profivac_web_server::auth::users::Users;
use profivac_web_server::auth::{Actor, Role, User};
use std::net::{IpAddr, Ipv4Addr};
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::{Duration, Instant};
use tempfile::TempDir;

const SEGMENT: &str = "baud = 1500000\ndevices = [\"bcg450@5\", \"psg550@6\"]\n";

const PLANT: &str = r#"
[[segment]]
name = "hall"
port = "sim:SEGMENT"
baud = 1500000

[[segment.gauge]]
name = "chamber"
address = 5
device = "bcg450"

[[segment.gauge]]
name = "fore line"
address = 6
device = "psg550"

[[alarm]]
name = "Chamber high"
gauge = "chamber"
above = "1e-6 mbar"
delay = "0 s"
"#;

const PEER: IpAddr = IpAddr::V4(Ipv4Addr::LOCALHOST);
const TRIP_POINT: &str = "trip-point.1/high-trip-point";

struct Plant {
    station: Station,
    commander: Commander,
    users: PathBuf,
    runtime: tokio::runtime::Runtime,
    _folder: TempDir,
}

impl Plant {
    /// A station whose gauges answer, and a gateway that writes as a user with this role.
    fn new(role: Role) -> Self {
        let folder = tempfile::tempdir().unwrap();
        let segment = folder.path().join("hall.toml");
        std::fs::write(&segment, SEGMENT).unwrap();
        let text = PLANT.replace("SEGMENT", &segment.display().to_string());
        let station =
            Station::start(profivac_config::parse(&text, Path::new(&folder.path().join("plant.toml"))).unwrap())
                .unwrap();
        let users = folder.path().join("plant.users.toml");
        let hash = Hash::of("a password of some length").unwrap();
        Users::change(&users, |users| users.add("epics", role, hash)).unwrap();
        let commander = Commander::new(station.services(), users.clone());
        let runtime = tokio::runtime::Builder::new_multi_thread().worker_threads(1).enable_all().build().unwrap();
        let plant = Self { station, commander, users, runtime, _folder: folder };
        until("the gauges", || {
            let gauges = plant.station.services().snapshots().gauges();
            (gauges.len() == 2 && gauges.iter().all(|gauge| gauge.state == BusStationState::DataExchange)).then_some(())
        });
        plant
    }

    fn execute(&self, request: WriteRequest) -> Result<(), WriteError> {
        self.runtime.block_on(self.commander.execute("epics", request, Some(PEER)))
    }

    fn write(&self, value: &str) -> Result<(), String> {
        let request = WriteRequest::Parameter {
            gauge: Arc::from("fore line"),
            target: Arc::from(TRIP_POINT),
            value: value.to_owned(),
        };
        self.execute(request).map_err(|error| error.to_string())
    }

    fn command(&self, command: &str) -> Result<(), String> {
        let request = WriteRequest::Command { gauge: Arc::from("chamber"), command: command.to_owned() };
        self.execute(request).map_err(|error| error.to_string())
    }

    /// The rows of the audit trail, the earliest first: action, user, peer, outcome.
    fn trail(&self) -> Vec<String> {
        let services = self.station.services();
        let query = AuditQuery { from: Micros(0), to: Micros(i64::MAX), gauge: None, user: None, limit: 100 };
        let mut rows = services.recorder().open_reader().unwrap().audit(&query).unwrap();
        rows.sort_by_key(|row| row.id);
        let text = |text: &Option<String>| text.clone().unwrap_or_default();
        let line = |entry: &profivac_recorder::AuditEntry| {
            format!("{} {} {}: {}", entry.action.as_str(), entry.user, text(&entry.peer), text(&entry.outcome))
        };
        rows.iter().map(line).collect()
    }
}

#[test]
fn a_write_reaches_the_gauge_and_the_audit_trail_and_leaves_control_free() {
    let plant = Plant::new(Role::Engineer);
    assert_eq!(plant.write("5e-3 mbar"), Ok(()));
    let trail = plant.trail();
    let end = trail.len() - 4;
    assert_eq!(
        trail[end..],
        [
            "control-authority epics 127.0.0.1: took control, which was free",
            "execute epics 127.0.0.1: ",
            "outcome epics 127.0.0.1: done",
            "control-authority epics 127.0.0.1: released control",
        ]
    );
    let services = plant.station.services();
    assert_eq!(services.control().authority(Instant::now()).holder, None);
    let model = ReadModel::start(Arc::clone(&services)).unwrap();
    until("the new value", || {
        let snapshot = model.snapshot();
        let is_it = |signal| signal == Signal::ParameterPressure;
        let found = snapshot.iter().find(|(point, _)| point.subject.name() == TRIP_POINT && is_it(point.signal))?;
        assert!(found.0.is_writable);
        matches!(found.1.value, Value::Float(pa) if (pa / 0.5 - 1.0).abs() < 1e-3).then_some(())
    });
    let snapshot = model.snapshot();
    let status = snapshot.points.iter().find(|point| point.subject.name() == "ba.degas-status").unwrap();
    assert!(!status.is_writable, "a status is not written");
    plant.station.stop().unwrap();
}

/// What a gauge of a device file accepts is in its own tables, not in those of a built-in device with another name.
#[test]
fn parameters_of_a_gauge_that_a_file_describes_are_written_as_its_tables_say() {
    let folder = tempfile::tempdir().unwrap();
    let device = r#"format = 1
name = "mine"
title = "Mine"
vendor = "A maker"
like = "psg550"
ident = 0x1234
[[block]]
name = "Trip Point Function Block"
parameters = [{ index = 17, name = "High Trip Point", type = "BY_TYPE", access = "1/2_R", store = "N", section = "9" }]
"#;
    std::fs::write(folder.path().join("mine.toml"), device).unwrap();
    let gauge = |name: &str, address: u8, device: &str| {
        format!("[[segment.gauge]]\nname = {name:?}\naddress = {address}\ndevice = {device:?}\n")
    };
    let text = format!(
        "[[segment]]\nname = \"hall\"\nport = \"/dev/ttyUSB0\"\n{}{}",
        gauge("described", 5, "mine.toml"),
        gauge("built in", 6, "psg550")
    );
    let config = profivac_config::parse(&text, &folder.path().join("plant.toml")).unwrap();
    let snapshot = Modeller::default().next(Inputs::planned(&config), Micros(1));
    let is_writable = |gauge: &str, target: &str| {
        let is_it =
            |point: &&profivac_gateway::Point| point.subject.gauge() == Some(gauge) && point.subject.name() == target;
        snapshot.points.iter().find(is_it).map(|point| point.is_writable)
    };
    assert_eq!(is_writable("built in", TRIP_POINT), Some(true));
    assert_eq!(is_writable("described", TRIP_POINT), Some(false), "its file says read only");
    assert_eq!(is_writable("described", "trip-point.1/low-trip-point"), Some(true));
    let vendor =
        snapshot.points.iter().find(|it| it.signal == Signal::Device && it.subject.gauge() == Some("described"));
    assert_eq!(vendor.and_then(|point| point.vendor.as_deref()), Some("A maker"));
    assert_eq!(controlled_gauges(&snapshot).len(), 2);
}

/// The Ident_Number alone does not say which one is on the line: the file of the station does.
#[test]
fn two_gauges_of_two_files_with_one_ident_number_are_on_one_line() {
    let folder = tempfile::tempdir().unwrap();
    for (name, index) in [("one", 210), ("two", 211)] {
        let device = format!(
            "format = 1\nname = {name:?}\ntitle = {name:?}\nlike = \"bcg450\"\nident = 0x1234\n[[block]]\nname = \"Device Block\"\n\
             parameters = [{{ index = {index}, name = \"Own\", type = \"UINT8\", access = \"1/2_R/W\" }}]\n"
        );
        std::fs::write(folder.path().join(format!("{name}.toml")), device).unwrap();
    }
    let segment = folder.path().join("hall.toml");
    std::fs::write(&segment, "baud = 1500000\ndevices = [\"one.toml@5\", \"two.toml@6\"]\n").unwrap();
    let gauge = |name: &str, address: u8| {
        format!("[[segment.gauge]]\nname = {name:?}\naddress = {address}\ndevice = \"{name}.toml\"\n")
    };
    let port = format!("sim:{}", segment.display());
    let head = format!("[[segment]]\nname = \"hall\"\nport = {port:?}\nbaud = 1500000\n");
    let text = head + &gauge("one", 5) + &gauge("two", 6);
    let config = profivac_config::parse(&text, &folder.path().join("plant.toml")).unwrap();
    let station = Station::start(config).unwrap();
    until("both gauges with their own tables", || {
        let gauges = station.services().snapshots().gauges();
        let is_own = |gauge: &profivac_station::view::Gauge| {
            gauge.state == BusStationState::DataExchange && gauge.device == gauge.name
        };
        (gauges.len() == 2 && gauges.iter().all(is_own)).then_some(())
    });
    let execute = OperationRequest { command: Some("execute".to_owned()), ..OperationRequest::default() };
    for gauge in station.services().snapshots().gauges() {
        let operation = Operation::resolve(gauge.model.unwrap(), &execute).unwrap();
        assert!(operation.from_device_file, "the station says where its conditions come from");
    }
    station.stop().unwrap();
}

#[test]
fn a_refusal_says_why_and_is_in_the_audit_trail() {
    let plant = Plant::new(Role::Operator);
    let forbidden = plant.write("5e-3 mbar").unwrap_err();
    assert!(forbidden.contains("engineer"), "{forbidden}");
    let unmet = plant.command("ba.degas-on").unwrap_err();
    assert!(unmet.contains("7.2e-6 mbar"), "the pressure is too high: {unmet}");
    let unknown = plant.command("ba.explode").unwrap_err();
    assert_eq!(unknown, "bcg450 has no command \"ba.explode\"");
    let ada = Actor { user: User { name: Arc::from("Ada"), role: Role::Operator }, peer: None };
    let services = plant.station.services();
    services.control().change_authority(&ada, AuthorityAction::Request, Instant::now()).unwrap();
    assert_eq!(plant.command("ba.degas-on").unwrap_err(), "Ada has control");
    assert_eq!(
        services.control().authority(Instant::now()).holder.as_deref(),
        Some("Ada"),
        "control stays where it is"
    );
    let refused: Vec<_> = plant.trail().into_iter().filter(|row| row.starts_with("refused epics 127.0.0.1")).collect();
    assert_eq!(refused.len(), 4, "{refused:#?}");
    assert!(refused[3].ends_with(": Ada has control"), "{refused:#?}");
    Users::change(&plant.users, |users| users.remove("epics")).unwrap();
    let gone = plant.command("ba.degas-on").unwrap_err();
    assert!(gone.contains("epics") && gone.contains("no longer in the file of the users"), "{gone}");
    plant.station.stop().unwrap();
}

#[test]
fn the_occurrence_that_a_client_has_seen_is_acknowledged_and_no_other() {
    let plant = Plant::new(Role::Operator);
    let services = plant.station.services();
    let alarm = || services.alarms().all().into_iter().find(|alarm| alarm.name == "Chamber high").unwrap();
    let occurrence = until("the alarm", || Some(alarm()).filter(|it| it.state.needs_acknowledgement())).occurrence;
    let acknowledge = |occurrence| {
        plant
            .execute(WriteRequest::Acknowledge { alarm: Arc::from("Chamber high"), occurrence })
            .map_err(|error| error.to_string())
    };
    assert!(acknowledge(occurrence + 1).is_err());
    assert_eq!(acknowledge(occurrence), Ok(()));
    assert_eq!(alarm().acknowledged_by.as_deref(), Some("epics"));
    plant.station.stop().unwrap();
}

#[test]
fn an_operator_shelves_an_alarm_for_a_time_with_a_reason() {
    let plant = Plant::new(Role::Operator);
    let services = plant.station.services();
    let alarm = || services.alarms().all().into_iter().find(|alarm| alarm.name == "chamber: fault").unwrap();
    let shelve = |reason: &str, seconds: u64| {
        let (alarm, reason) = (Arc::from("chamber: fault"), reason.to_owned());
        plant.execute(WriteRequest::Shelve { alarm, reason, time: Duration::from_secs(seconds) })
    };
    let unshelve = || plant.execute(WriteRequest::Unshelve { alarm: Arc::from("chamber: fault") });
    let not_applicable = |done: Result<(), WriteError>| {
        matches!(done, Err(WriteError::Alarm(AlarmServiceError::Refused(AlarmError::NotApplicable { .. }))))
    };
    for seconds in [0, 59, 12 * 3600 + 1] {
        assert!(matches!(shelve("vented", seconds), Err(WriteError::ShelvingTime(_))), "{seconds}");
    }
    for reason in ["", " ", "two\nlines", &"x".repeat(501)] {
        assert!(matches!(shelve(reason, 60), Err(WriteError::Reason(_))), "{reason:?}");
    }
    assert!(not_applicable(unshelve()));
    shelve(" the lock is vented ", 60).unwrap();
    let shelved = alarm().shelved.unwrap();
    assert_eq!((shelved.user.as_str(), shelved.reason.as_str()), ("epics", "the lock is vented"));
    assert_eq!(shelved.until_ms, Some(shelved.at_ms + 60_000));
    assert!(not_applicable(shelve("again", 60)));
    unshelve().unwrap();
    assert_eq!(alarm().shelved, None);
    Users::change(&plant.users, |users| users.get_mut("epics").map(|user| user.role = Role::Viewer)).unwrap();
    assert!(matches!(shelve("vented", 60), Err(WriteError::Forbidden(_))));
    assert!(matches!(unshelve(), Err(WriteError::Forbidden(_))));
    plant.station.stop().unwrap();
}
