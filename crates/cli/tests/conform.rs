//! `conform` holds slaves against the rules and tells which they break.

#![allow(clippy::unwrap_used, clippy::panic, reason = "a test")]

mod common;

use common::{Program, run};

fn on_tcp(devices: &[&str]) -> (Program, String) {
    let program = Program::start(&[&["simulate", "--tcp", "127.0.0.1:0"], devices].concat());
    let address = format!("tcp://{}", program.ready());
    (program, address)
}

#[test]
fn a_gauge_keeps_all_rules() {
    let (_program, port) = on_tcp(&["bcg450@5"]);
    let output = run(&["conform", "--port", &port, "--address", "5", "--own"]);
    let told = String::from_utf8(output.stdout).unwrap();
    assert_eq!(output.status.code(), Some(0), "{told}");
    let lines: Vec<_> = told.lines().collect();
    assert!(lines.iter().all(|line| line.starts_with("ok ")), "{told}");
    assert_eq!(
        lines.first(),
        Some(&"ok      layer2.fdl-status         FDL status is answered as a slave, without access points (1.11)")
    );
    let remarks = String::from_utf8(output.stderr).unwrap();
    assert_eq!(remarks.trim(), format!("{} rules hold, 0 are broken, 0 were not asked for", lines.len()));
}

#[test]
fn a_configuration_that_the_slave_does_not_take_is_told_rule_by_rule() {
    let (_program, port) = on_tcp(&["psg550@5"]);
    let output =
        run(&["conform", "--port", &port, "--address", "5", "--own", "--json", "--cfg", "11", "--slot-time", "4000"]);
    assert_eq!(output.status.code(), Some(1));
    let rows: Vec<serde_json::Value> = serde_json::from_slice(&output.stdout).unwrap();
    let row = rows.iter().find(|row| row["name"] == "exchange.inputs").unwrap();
    assert_eq!((row["outcome"].as_str(), row["section"].as_str()), (Some("broken"), Some("2.8")));
    assert_eq!(row["expected"].as_str(), Some("data exchange after Set_Prm and Chk_Cfg"));
    let complaint = String::from_utf8(output.stderr).unwrap();
    assert!(complaint.contains("the slave at address 5 breaks "), "{complaint}");
}

#[test]
fn nobody_is_no_slave() {
    let (_program, port) = on_tcp(&["bcg450@5"]);
    let output = run(&["conform", "--port", &port, "--address", "6", "--own"]);
    assert_eq!(output.status.code(), Some(3));
    assert_eq!(String::from_utf8(output.stderr).unwrap().trim(), "profivac: no slave answers at address 6");
}

#[test]
fn a_script_has_to_say_own() {
    let output = run(&["conform", "--port", "/dev/null", "--address", "6"]);
    assert_eq!(output.status.code(), Some(2));
    let complaint = String::from_utf8(output.stderr).unwrap();
    assert_eq!(complaint.trim(), "profivac: conform parameterises the slave and owns it: say --own in a script");
}

/// Ctrl-C ends it after the check that runs, and the slave belongs to nobody.
#[test]
fn who_stops_it_finds_the_slave_released() {
    for options in [&[][..], &["--json"]] {
        let (mut simulation, port) = on_tcp(&["bcg450@5"]);
        let mut program = Program::start(&[&["conform", "--port", &port, "--address", "5", "--own"], options].concat());
        // Under way: until it has parameterised the slave the first time.
        while simulation.state(5)["device_state"] != "EXECUTING" && !program.has_ended() {}
        program.interrupt();
        assert_eq!(program.complaint(), "profivac: interrupted by a signal; the slave is released");
        assert_eq!(program.exit_code(), 3);
        let scan = run(&["scan", "--port", &port, "--hsa", "5", "--json"]);
        let rows: serde_json::Value = serde_json::from_slice(&scan.stdout).unwrap();
        assert_eq!(rows[0]["owner"], serde_json::Value::Null);
    }
}
