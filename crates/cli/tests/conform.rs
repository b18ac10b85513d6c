//! `conform` tests slaves against the rules and reports which they break.

#![allow(clippy::unwrap_used, clippy::panic, reason = "a test")]

use crate::common::{Program, run};
use profivac_conform::checks;
use std::net::TcpListener;

fn on_tcp(devices: &[&str]) -> (Program, String) {
    let program = Program::start(&[&["simulate", "--tcp", "127.0.0.1:0"], devices].concat());
    let address = format!("tcp://{}", program.ready());
    (program, address)
}

#[test]
fn a_gauge_keeps_all_rules() {
    let (_program, port) = on_tcp(&["bcg450@5"]);
    // A loaded computer may answer late.
    let output = run(&["conform", "--port", &port, "--address", "5", "--own", "--slot-time", "2000"]);
    let table = String::from_utf8(output.stdout).unwrap();
    assert_eq!(output.status.code(), Some(0), "{table}");
    let lines: Vec<_> = table.lines().collect();
    assert_eq!(
        lines.first(),
        Some(&"ok      layer2.fdl-status               FDL status is answered with status OK (1.11)")
    );
    let count = |word: &str| lines.iter().filter(|line| line.starts_with(word)).count();
    let (passed, untested) = (count("ok "), count("- "));
    // The gauge has neither Sync nor Freeze, and its parameters leave MS1 closed.
    assert_eq!((passed + untested, untested), (checks::all().count(), 11), "{table}");
    assert_eq!(count("        not tested: the slave has no "), untested, "{table}");
    let notices = String::from_utf8(output.stderr).unwrap();
    assert_eq!(notices.trim(), format!("{passed} rules passed, 0 broken, {untested} not tested"));
}

#[test]
fn a_configuration_that_the_slave_refuses_breaks_one_rule_and_the_others_name_it() {
    let (_program, port) = on_tcp(&["psg550@5"]);
    let output =
        run(&["conform", "--port", &port, "--address", "5", "--own", "--json", "--cfg", "11", "--slot-time", "4000"]);
    assert_eq!(output.status.code(), Some(1));
    let rows: Vec<serde_json::Value> = serde_json::from_slice(&output.stdout).unwrap();
    let row = |name: &str| rows.iter().find(|row| row["name"] == name).unwrap();
    let broken: Vec<_> = rows.iter().filter(|row| row["outcome"] == "broken").collect();
    assert_eq!(broken, [row("start-up.exchange")]);
    assert_eq!(broken[0]["expected"], "SC, DL or DH as the answer to Data_Exchange, within a second after Chk_Cfg");
    assert_eq!(broken[0]["came"], "10 00 05 03 08 16");
    let inputs = row("exchange.inputs");
    assert_eq!((&inputs["outcome"], &inputs["because"]), (&"not-tested".into(), &"start-up.exchange".into()));
    let complaint = String::from_utf8(output.stderr).unwrap();
    assert!(complaint.contains("the slave at address 5 breaks a rule"), "{complaint}");
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
        "profivac: conform takes ownership of the slave and sets its parameters; without a terminal add --own"
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

/// A serial server that has another client closes each connection. The command has caught the signals before it connects.
#[test]
fn ctrl_c_ends_the_wait_for_a_busy_server() {
    let server = TcpListener::bind("127.0.0.1:0").unwrap();
    let port = format!("tcp://{}", server.local_addr().unwrap());
    let mut program = Program::start(&["conform", "--port", &port, "--address", "5", "--own"]);
    drop(server.accept().unwrap());
    program.interrupt();
    std::thread::spawn(move || server.incoming().for_each(drop));
    let complaint = program.complaint();
    assert!(complaint.ends_with("interrupted while the server closed each connection at once"), "{complaint}");
    assert_eq!(program.exit_code(), 3);
}
