//! Every command on standard input gets one line as its answer; `quit`, SIGTERM and end of file follow the contract.

#![allow(clippy::unwrap_used, clippy::panic, reason = "a test")]

use crate::common::{End, Folder, Program, become_an_ordinary_user};

fn simulation(folder: &Folder) -> Program {
    let program = Program::start(&["simulate", "--pty", &folder.name("line"), "bcg450@5", "bcg450@126"]);
    program.ready();
    program
}

#[test]
fn every_command_gets_its_answer() {
    let folder = Folder::new();
    let mut program = simulation(&folder);
    for line in [
        "pressure 5e-6 mbar",
        "atmosphere 1000 mbar",
        "gas n2",
        "fault 5 eeprom",
        "clear 5 eeprom",
        "power 126 off",
        "power 126 on",
        "advance 60",
    ] {
        assert_eq!(program.tell(line), "ok", "{line}");
    }
    for (line, answer) in [
        ("", "error: expected one of pressure, atmosphere, "),
        ("pressure", "error: expected pressure PRESSURE"),
        ("pressure 1 psi", "error: expected a unit, one of mbar, "),
        (
            "fault 5 tiredness",
            "error: bcg450 at address 5 has no fault \"tiredness\"; it has eeprom (EEPROM exception, alarm and warning), ram (",
        ),
        ("clear 126 eprom1", "error: bcg450 at address 126 has no fault \"eprom1\"; it has eeprom ("),
        ("state 7", "error: no device at address 7; known: 5 (bcg450), 126 (bcg450)"),
        ("button 5 200", "error: bcg450 at address 5 has no button"),
    ] {
        let answered = program.tell(line);
        assert!(answered.starts_with(answer), "{line}: {answered}");
    }
}

#[test]
fn buttons_switches_and_potentiometers_are_operated() {
    let folder = Folder::new();
    let mut program = Program::start(&["simulate", "--pty", &folder.name("line"), "bcg450@5", "pcg550@6"]);
    program.ready();
    for line in ["switch 5 degas off", "pot 5 a 7.5", "pot 5 b 0", "button 6 1", "button 6 2"] {
        assert_eq!(program.tell(line), "ok", "{line}");
    }
    for (line, answer) in [
        (
            "switch 5 colour red",
            "error: bcg450 at address 5 has no switch \"colour\"; it has address (0 ... 255), degas (on, off)",
        ),
        (
            "switch 5 degas maybe",
            "error: bcg450 at address 5 has no position \"maybe\" of the switch \"degas\"; it has on, off",
        ),
        ("button 6 3", "error: pcg550 at address 6 has no button 3; it has 1, 2"),
        ("pot 6 a 1", "error: pcg550 at address 6 has no potentiometer"),
    ] {
        assert_eq!(program.tell(line), answer);
    }
}

#[test]
fn device_time_advances_on_command_and_stops_without_power() {
    let folder = Folder::new();
    let mut program = simulation(&folder);
    let mut hours = |line: &str| {
        assert_eq!(program.tell(line), "ok", "{line}");
        program.state(5)["run_hours"].as_f64().unwrap()
    };
    let before = hours("advance 0");
    let after = hours("advance 7200");
    assert!((2.0..2.1).contains(&(after - before)), "{before} h, then {after} h");
    hours("power 5 off");
    hours("advance 7200");
    let later = hours("power 5 on");
    assert!((0.0..0.1).contains(&(later - after)), "{after} h, then {later} h");
}

#[test]
fn the_state_has_the_keys_of_the_contract() {
    let folder = Folder::new();
    let mut program = simulation(&folder);
    program.tell("pressure 5e-6 mbar");
    let state = program.tell("state 5");
    let keys = [
        "address",
        "device_state",
        "led",
        "relays",
        "true_mbar",
        "indicated",
        "active_instance",
        "exception_status",
        "outputs_safe",
        "emission",
        "degas",
        "run_hours",
    ];
    let places: Vec<_> = keys.iter().map(|key| state.find(&format!("\"{key}\":")).unwrap()).collect();
    assert!(places.is_sorted(), "{state}");
    let state = program.state(5);
    assert_eq!(state.as_object().unwrap().len(), keys.len());
    assert_eq!((&state["address"], &state["true_mbar"]), (&5.into(), &5e-6.into()));
    for shown in state["indicated"].as_array().unwrap() {
        let mut keys: Vec<_> = shown.as_object().unwrap().keys().collect();
        keys.sort();
        assert_eq!(keys, ["instance", "valid", "value_mbar"]);
    }
    assert_eq!(program.state(126)["address"], 126);
}

/// Channels without power or without a gauge keep their place in the lists.
#[test]
fn absent_channels_keep_their_place_in_the_state() {
    let folder = Folder::new();
    let line = folder.name("line");
    let mut program = Program::start(&["simulate", "--pty", &line, "bcg450@5", "img400@6:ch1=none", "tpg500@7"]);
    program.ready();
    assert_eq!(program.tell("power 5 off"), "ok");
    let state = program.state(5);
    let nothing = |instance: u8| serde_json::json!({"instance": instance, "value_mbar": null, "valid": false});
    assert_eq!(state["indicated"], serde_json::json!([nothing(1), nothing(2), nothing(3)]));
    let lists = ["relays", "emission", "degas"].map(|key| state[key].clone());
    assert_eq!(serde_json::Value::from(lists.to_vec()), serde_json::json!([[false, false], [false], [false]]));
    let outputs = ["device_state", "outputs_safe", "active_instance", "exception_status"].map(|key| state[key].clone());
    assert_eq!(serde_json::Value::from(outputs.to_vec()), serde_json::json!(["OFF", true, 0, 0]));
    let places = |device: u8, program: &mut Program| program.state(device)["emission"].as_array().unwrap().len();
    assert_eq!([6, 7].map(|device| places(device, &mut program)), [2, 2]);
}

#[test]
fn the_simulation_continues_after_end_of_file() {
    let folder = Folder::new();
    let mut program = simulation(&folder);
    program.end_of_file();
    let mut line = End::pty(&folder.path("line"));
    for _ in 0..3 {
        line.ask("10 05 02 49 50 16", "10 02 05 00 07 16");
    }
    program.terminate();
    assert_eq!(program.exit_code(), 0);
    assert!(!folder.path("line").is_symlink());
}

#[test]
fn quit_is_answered_and_removes_the_link() {
    let folder = Folder::new();
    let mut program = simulation(&folder);
    assert_eq!(program.tell("quit"), "ok");
    assert_eq!(program.exit_code(), 0);
    assert!(!folder.path("line").is_symlink());
}

#[test]
fn the_lock_of_a_killed_master_does_not_end_the_simulation() {
    become_an_ordinary_user();
    let folder = Folder::new();
    let mut program = simulation(&folder);
    for _ in 0..3 {
        let mut master = End::pty_of(&mut program, &folder.path("line"));
        master.lock();
        master.ask("10 05 02 49 50 16", "10 02 05 00 07 16");
    }
}
