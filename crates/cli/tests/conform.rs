//! `conform` tests slaves against the rules and reports which they break.

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
    let stderr = String::from_utf8(output.stdout).unwrap();
    assert_eq!(output.status.code(), Some(0), "{stderr}");
    let lines: Vec<_> = stderr.lines().collect();
    assert!(lines.iter().all(|line| line.starts_with("ok ")), "{stderr}");
    assert_eq!(
        lines.first(),
        Some(&"ok      layer2.fdl-status         FDL status is answered as a slave, without access points (1.11)")
    );
    let notices = String::from_utf8(output.stderr).unwrap();
    assert_eq!(notices.trim(), format!("{} rules hold, 0 are broken, 0 were skipped", lines.len()));
}

#[test]
fn a_configuration_that_the_slave_refuses_breaks_rules_that_are_listed() {
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
fn an_address_without_a_slave_is_no_answer() {
    let (_program, port) = on_tcp(&["bcg450@5"]);
    let output = run(&["conform", "--port", &port, "--address", "6", "--own"]);
    assert_eq!(output.status.code(), Some(3));
    assert_eq!(String::from_utf8(output.stderr).unwrap().trim(), "profivac: no slave answers at address 6");
}

#[test]
fn a_script_must_give_own() {
    let output = run(&["conform", "--port", "/dev/null", "--address", "6"]);
    assert_eq!(output.status.code(), Some(2));
    let complaint = String::from_utf8(output.stderr).unwrap();
    assert_eq!(
        complaint.trim(),
        "profivac: conform parameterises the slave and takes ownership of it; without a terminal add --own"
    );
}

/// Ctrl-C ends it after the present check, and no master owns the slave afterwards.
#[test]
fn an_interrupted_run_releases_the_slave() {
    for options in [&[][..], &["--json"]] {
        let (mut simulation, port) = on_tcp(&["bcg450@5"]);
        let mut program = Program::start(&[&["conform", "--port", &port, "--address", "5", "--own"], options].concat());
        // Waits until it has parameterised the slave for the first time.
        while simulation.state(5)["device_state"] != "EXECUTING" && !program.has_ended() {}
        program.interrupt();
        assert_eq!(program.complaint(), "profivac: interrupted by a signal; the slave is released");
        assert_eq!(program.exit_code(), 3);
        let scan = run(&["scan", "--port", &port, "--hsa", "5", "--json"]);
        let rows: serde_json::Value = serde_json::from_slice(&scan.stdout).unwrap();
        assert_eq!(rows[0]["owner"], serde_json::Value::Null);
    }
}
