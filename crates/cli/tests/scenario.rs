//! `simulate --scenario`: the plant of a file instead of constant conditions.

#![allow(clippy::unwrap_used, clippy::panic, reason = "a test")]

use crate::common::{Folder, Program, run};
use crate::until::until;
use serde_json::Value;

const TEXT: &str = "\
title = \"a chamber that is vented\"
until = \"1 h\"
sensors = \"ideal\"
[volumes]
chamber = { volume = \"1 l\", pressure = \"1e-3 mbar\" }
[vents]
vent = { at = \"chamber\", diameter = \"10 mm\", length = \"10 mm\" }
[gauges]
\"bcg450@5\" = \"chamber\"
[[timeline]]
at = \"0.1 s\"
open = [\"vent\"]
";

fn scenario(folder: &Folder, text: &str) -> String {
    let path = folder.name("x.toml");
    std::fs::write(&path, text).unwrap();
    path
}

fn true_mbar(program: &mut Program) -> f64 {
    let answer = program.tell("state 5");
    let state: Value = serde_json::from_str(answer.strip_prefix("ok ").unwrap()).unwrap();
    state["true_mbar"].as_f64().unwrap()
}

#[test]
fn a_scenario_is_shown_and_takes_more_devices() {
    let folder = Folder::new();
    let shown = run(&["simulate", "--scenario", "pump-down", "--show"]);
    assert_eq!(shown.status.code(), Some(0));
    let text = String::from_utf8(shown.stdout).unwrap();
    assert_eq!(text.trim_end(), include_str!("../../../scenarios/pump-down.toml").trim_end());
    let file = scenario(&folder, TEXT);
    let shown = run(&["simulate", "--scenario", &file, "--show"]);
    assert_eq!(String::from_utf8(shown.stdout).unwrap().trim_end(), TEXT.trim_end());
    let line = folder.name("line");
    let mut program = Program::start(&["simulate", "--pty", &line, "--scenario", &file, "psg550@9"]);
    program.ready();
    for address in [5, 9] {
        assert!(program.tell(&format!("state {address}")).starts_with("ok {"), "{address}");
    }
    let twice = run(&["simulate", "--pty", &folder.name("other"), "--scenario", &file, "psg550@5"]);
    assert_eq!(twice.status.code(), Some(2));
    assert!(String::from_utf8(twice.stderr).unwrap().contains("two devices at address 5"));
}

#[test]
fn the_scenario_controls_the_chamber() {
    let folder = Folder::new();
    let file = scenario(&folder, TEXT);
    let mut program = Program::start(&["simulate", "--pty", &folder.name("line"), "--scenario", &file]);
    program.ready();
    for line in ["pressure 1 mbar", "gas ar", "atmosphere 1 bar", "advance 1"] {
        assert_eq!(
            program.tell(line),
            "error: the scenario controls the chamber; start `simulate` without --scenario to use this command",
            "{line}"
        );
    }
    assert_eq!(program.tell("fault 5 sensor2"), "ok");
    // Only the file vents the chamber.
    until("the vented chamber", || (true_mbar(&mut program) >= 1000.0).then_some(()));
    program.terminate();
    assert_eq!(program.exit_code(), 0);
}

#[test]
fn a_wrong_scenario_and_conflicting_options_are_refused() {
    let folder = Folder::new();
    let (line, good) = (folder.name("line"), scenario(&folder, TEXT));
    for more in [["--gas", "ar"], ["--pressure", "1 mbar"]] {
        let refused = run(&[&["simulate", "--pty", &line, "--scenario", &good], &more[..]].concat());
        assert_eq!(refused.status.code(), Some(2), "{more:?}");
    }
    let bad = scenario(&folder, &TEXT.replace("0.1 s", "soon"));
    let refused = run(&["simulate", "--pty", &line, "--scenario", &bad]);
    let message = String::from_utf8(refused.stderr).unwrap();
    assert_eq!(refused.status.code(), Some(2), "{message}");
    assert!(
        message.ends_with("x.toml:11:6: at: expected a time like \"90 s\" in ms, s, min, h, d, got \"soon\"\n"),
        "{message}"
    );
}
