//! `read`: by names and numbers, with units and codes, on every family, and its errors.

use crate::common::{End, Program, octets, run, sd2};
use crate::gauge_commands::Line;
use serde_json::{Value, json};
use std::time::Duration;

#[test]
fn parameters_are_read_by_name_and_by_number() {
    let line = Line::with(&["bcg450@5", "pcg550@6", "img400@7", "bpg400@8", "hpg400@9", "psg552@10"]);
    for (address, target, printed) in [
        (5, "device.device-state", "device.device-state = IDLE\n"),
        (5, "0/25", "device.device-state = IDLE\n"),
        (5, "pirani.full-scale", "pirani.full-scale = 1000 mbar\n"),
        (5, "1:2/24", "ba.full-scale = 0.02 mbar\n"),
        (5, "1/24", "pirani.full-scale = 1000 mbar\n"),
        (5, "Device Manufacturer Identifier", "device.device-manufacturer-identifier = INFICON AG\n"),
        (6, "trip-point.1/high-trip-enable", "trip-point.1/high-trip-enable = false\n"),
        (5, "ba.emission-current", "ba.emission-current = 0 mA\n"),
        (6, "atm.data-unit", "atm.data-unit = mbar\n"),
        (6, "device.run-hours", "device.run-hours = 0 h\n"),
        (6, "device.run-hours-4", "device.run-hours-4 = 0 h\n"),
        (7, "channel.1/emission-current", "channel.1/emission-current = 0-mA\n"),
        (8, "ba.underrange", "ba.underrange = 5e-10 mbar\n"),
        (9, "emission-on-switch", "device.emission-on-switch = 1 mbar\n"),
        (10, "pirani.pirani-off", "pirani.pirani-off = always-on\n"),
    ] {
        assert_eq!(line.output("read", address, &[target]), printed, "{address} {target}");
    }
}

#[test]
fn several_parameters_are_read_at_once_and_printed_as_json() {
    let mut line = Line::with(&["--pressure", "5e-6 mbar", "bcg450@5:unit=pascal"]);
    line.output("write", 5, &["execute"]);
    line.tell("pressure 2e-6 mbar");
    let printed = line.output("read", 5, &["--json", "ba.process-value", "ba.reading-valid"]);
    let values: Vec<Value> = serde_json::from_str(&printed).unwrap();
    let expected = json!({
        "name": "ba.process-value", "slot": 1, "instance": 2, "index": 19, "value": 0.0002, "text": "2e-4 Pascal",
        "unit": "Pascal", "octets": "39 51 B7 17", "valid": true
    });
    assert_eq!(values[0], expected);
    assert_eq!((&values[1]["value"], &values[1]["text"]), (&json!(1), &json!("true")));
}

/// In IDLE a gauge shows its safe value, which looks like a pressure.
#[test]
fn an_invalid_pressure_causes_a_notice_with_advice() {
    let line = Line::with(&["--pressure", "1e-2 mbar", "bcg450@5"]);
    let read = || line.run("read", 5, &["ba.process-value"]);
    let message = "profivac: ba.process-value is not a valid pressure";
    let advice = "; the gauge is in IDLE: `profivac write ... execute` starts it";
    let done = read();
    assert_eq!((done.code, done.out.as_str()), (0, "ba.process-value = 0 mbar  (not valid: the gauge is in IDLE)\n"));
    assert_eq!(done.err, format!("{message}{advice}\n"));
    let rows: Value = serde_json::from_str(&line.output("read", 5, &["--json", "1:2/19"])).unwrap();
    assert_eq!(rows[0]["valid"], json!(false));
    line.output("write", 5, &["execute"]);
    assert_eq!((read().out.as_str(), read().err.as_str()), ("ba.process-value = 0.01 mbar\n", ""));
    // The gauge measures, but the pressure is below its range.
    let done = line.run("read", 5, &["cdg.process-value"]);
    assert_eq!(
        (done.out.as_str(), done.err),
        ("cdg.process-value = 1 mbar  (not valid: under range)\n", message.replace("ba.", "cdg.") + "\n")
    );
}

/// The selector is restored, so that another master still reads the instance that it selected.
#[test]
fn the_selected_instance_is_restored() {
    let line = Line::with(&["bcg450@5"]);
    line.output("write", 5, &["one-of-n.channel-instance-selector", "3"]);
    assert_eq!(
        line.output("read", 5, &["pirani.full-scale", "1:2/24"]),
        "pirani.full-scale = 1000 mbar\nba.full-scale = 0.02 mbar\n"
    );
    assert_eq!(line.output("read", 5, &["1/46"]), "one-of-n.channel-instance-selector = 3\n");
    assert_eq!(line.output("read", 5, &["1/24"]), "cdg.full-scale = 1500 mbar\n");
}

#[test]
fn reading_sends_no_set_prm_and_keeps_the_state() {
    let mut line = Line::with(&["bcg450@5"]);
    line.output("read", 5, &["pirani.process-value"]);
    line.output("dump", 5, &[]);
    let mut end = End::pty(&line.folder.path("line"));
    end.insist(&sd2(5, 60, 0x6D, ""), "68 0B 0B 68 82 85 08 3E 3C 02 05 00 FF 08 E6 7D 16");
    assert_eq!(line.simulation.state(5)["device_state"], "IDLE");
}

#[test]
fn the_error_for_a_wrong_target_names_alternatives() {
    let line = Line::with(&["bcg450@5", "tpg300@6", "pcg554@7:atm=off"]);
    let fails = |address, target, code, sentence| line.fails("read", address, &[target], code, sentence);
    let alike = "bcg450 has no parameter or command \"piranni.process-value\"; did you mean pirani.process-value?";
    fails(5, "piranni.process-value", 2, alike);
    fails(5, "xyzzy", 2, "bcg450 has no parameter or command \"xyzzy\"; `profivac list` shows all");
    let ambiguous = "\"overrange\" is ambiguous: it may be pirani.overrange (1:1/44), ba.overrange (1:2/44), cdg.overrange (1:3/44)";
    fails(5, "overrange", 2, ambiguous);
    fails(5, "1/255", 2, "expected SLOT/INDEX or SLOT:INSTANCE/INDEX with numbers from 0 to 254, got \"1/255\"");
    let slot = "bcg450 at address 5, record (slot 9, index 19): reading was refused with invalid slot (B2), code 0: undefined \
                slot; this device does not have it now: a part that is not fitted, or another instance is shown";
    fails(5, "9/19", 1, slot);
    let write_only = "bcg450 at address 5, ba.hot-cathode-block-state-command (slot 1, index 14, instance 2): it cannot be read \
                      (access 1_W 2_W)";
    fails(5, "1:2/14", 1, write_only);
    let channel = "tpg300 or tpg500 at address 6, a1.pressure-unit (slot 1, index 22): the manual allows it only by the parameter channel (access ac_r, \
                   ac_w); say --via pkw";
    fails(6, "a1.pressure-unit", 1, channel);
    let cyclic = "tpg300 or tpg500 at address 6, a1.measured-value (slot 1, index 20): it is in the cyclic data only (access c_r); \
                  `profivac monitor` shows those";
    fails(6, "a1.measured-value", 1, cyclic);
    let fitted = "pcg554 has no parameter or command \"atm.process-value\"; did you mean cdg.process-value or pirani.process-value?";
    fails(7, "atm.process-value", 2, fitted);
}

#[test]
fn a_missing_slave_and_a_missing_port_are_no_answer() {
    let line = Line::with(&["bcg450@5"]);
    let missing = "no station answers at address 9; `profivac scan` shows the stations of the bus";
    line.fails("read", 9, &["--timeout", "10", "0/25"], 3, missing);
    let lost = run(&["read", "--port", "/nowhere", "--address", "5", "0/25"]);
    assert_eq!(lost.status.code(), Some(3));
    assert_eq!(
        String::from_utf8(lost.stderr).unwrap(),
        "profivac: there is no port /nowhere: plug in the adapter, or start the program that serves it\n"
    );
    let missing = run(&["read", "--port", "/nowhere", "0/25"]);
    assert_eq!(missing.status.code(), Some(2));
}

#[test]
fn a_device_without_power_is_no_answer() {
    let mut line = Line::with(&["bcg450@5"]);
    line.tell("power 5 off");
    let missing = "no station answers at address 5; `profivac scan` shows the stations of the bus";
    line.fails("read", 5, &["--timeout", "10", "0/25"], 3, missing);
}

/// The master that owns a gauge reads the selected instance, so a notice reports that the selector was moved.
#[test]
fn a_notice_names_the_owner_when_the_selector_was_moved() {
    let simulation = Program::start(&["simulate", "--tcp", "127.0.0.1:0", "bcg450@5"]);
    let address = simulation.ready();
    let port = format!("tcp://{address}");
    let mut master = End::tcp(&address);
    master.ask(&sd2(5, 61, 0x5D, "80 00 00 0B 08 E6 00 00 00 00 05 1C"), "E5");
    for (target, message) in [
        ("1:1/24", ""),
        ("1:2/24", "profivac: the Channel Instance Selector was changed and restored while master 2 owns the gauge\n"),
    ] {
        let read = run(&["read", "--port", &port, "--address", "5", target]);
        assert_eq!(
            (read.status.code(), String::from_utf8(read.stderr).unwrap().as_str()),
            (Some(0), message),
            "{target}"
        );
    }
}

/// An interrupted command leaves the gauge unchanged.
#[test]
fn an_interrupted_command_restores_the_selector() {
    let simulation = Program::start(&["simulate", "--tcp", "127.0.0.1:0", "bcg450@5"]);
    let address = simulation.ready();
    let port = format!("tcp://{address}");
    let mut listener = End::tcp(&address);
    // More targets than can be read before the signal.
    let targets = vec!["1:2/24"; 5000];
    let mut reader = Program::start(&[&["read", "--port", &port, "--address", "5"][..], &targets].concat());
    // Write to slot 1, index 46: instance 2.
    let moved = octets("5F 01 2E 01 02");
    let mut received = Vec::new();
    while !received.windows(moved.len()).any(|octets| octets == moved) {
        let more = listener.receive_within(Duration::from_secs(5));
        assert!(!more.is_empty(), "it is over: {}", reader.complaint());
        received.extend(more);
    }
    reader.terminate();
    assert_eq!(reader.exit_code(), 3);
    assert!(reader.complaint().ends_with("interrupted by a signal"));
    let read = run(&["read", "--port", &port, "--address", "5", "1/46"]);
    let shown = String::from_utf8(read.stdout).unwrap();
    assert_eq!(shown, "one-of-n.channel-instance-selector = 1\n");
}

/// The gauge falls silent while the command has moved the selector: its restoration fails after the timeout.
#[test]
fn a_signal_while_the_gauge_is_silent_ends_the_command_and_names_the_selector() {
    let simulation = Program::start(&["simulate", "--tcp", "127.0.0.1:0", "bcg450@5"]);
    let address = simulation.ready();
    let mut listener = End::tcp(&address);
    let port = format!("tcp://{address}");
    let mut reader = Program::start(&[&["read", "--port", &port, "--address", "5"][..], &["1:2/24"; 5000]].concat());
    let moved = octets("5F 01 2E 01 02");
    let mut received = Vec::new();
    while !received.windows(moved.len()).any(|octets| octets == moved) {
        received.extend(listener.receive_within(Duration::from_secs(5)));
        assert!(!reader.has_ended(), "it is over: {}", reader.complaint());
    }
    simulation.stop();
    reader.interrupt();
    reader.wait_for_complaint(
        "the Channel Instance Selector of the gauge at address 5 (slot 1, index 46) may still show instance 2: \
         `profivac write ... 1/46 1` restores it",
    );
    reader.wait_for_complaint("profivac: interrupted by a signal");
    assert_eq!(reader.exit_code(), 3);
}

/// A refused target does not hide the others; the JSON is complete.
#[test]
fn a_refused_target_does_not_hide_the_others() {
    let line = Line::with(&["bcg450@5", "tpg300@6"]);
    let targets = ["9/19", "0/25", "xyzzy"];
    let done = line.run("read", 5, &targets);
    assert_eq!((done.code, done.out.as_str()), (1, "device.device-state = IDLE\n"));
    assert!(done.err.contains("\"xyzzy\"") && done.err.contains("(slot 9, index 19)"), "{}", done.err);
    let done = line.run("read", 5, &[&["--json"], &targets[..]].concat());
    let rows: Value = serde_json::from_str(&done.out).unwrap();
    assert_eq!((done.code, rows.as_array().unwrap().len()), (1, 3));
    assert_eq!((&rows[0]["target"], &rows[1]["text"]), (&json!("9/19"), &json!("IDLE")));
    assert!(rows[2]["error"].as_str().unwrap().starts_with("bcg450 has no parameter"), "{rows}");
    line.fails("read", 6, &["1/99"], 1, "tpg300 or tpg500 at address 6: it has no DP-V1 services; say --via pkw");
    let own = "--address 5 is the address of this master; choose another with --master N";
    line.fails("read", 5, &["--master", "5", "0/25"], 2, own);
}
