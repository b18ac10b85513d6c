//! `write`: values and commands, the checks before anything is sent, and refusals of the gauge.

use crate::common::{End, Program, interrupted_on_terminal, run_on_terminal};
use crate::gauge_commands::Line;
use serde_json::{Value, json};
use std::time::Duration;

/// No gauge answers, and the command would ask for ten minutes.
#[test]
fn a_write_that_a_signal_ends_before_it_was_sent_says_so() {
    let simulation = Program::start(&["simulate", "--tcp", "127.0.0.1:0", "bcg450@5"]);
    let address = simulation.ready();
    let port = format!("tcp://{address}");
    for target in [&["pirani.safe-value", "1 mbar"][..], &["--octets", "--yes", "1/24", "56 78"]] {
        let mut listener = End::tcp(&address);
        let options = ["write", "--port", &port, "--address", "9", "--timeout", "600", "--json"];
        let mut writer = Program::start(&[&options, target].concat());
        // The first octets of the master: from now on it catches signals.
        while listener.receive_within(Duration::from_secs(5)).is_empty() {
            assert!(!writer.has_ended(), "it is over: {}", writer.complaint());
        }
        writer.terminate();
        assert_eq!(writer.complaint(), "profivac: interrupted by a signal; nothing was written", "{target:?}");
        let printed: Value = serde_json::from_str(&writer.rest()).unwrap();
        let error = json!("interrupted by a signal; nothing was written");
        assert_eq!((&printed["effect"], &printed["error"]), (&json!("not-sent"), &error), "{target:?}");
        assert_eq!(writer.exit_code(), 3, "{target:?}");
    }
}

#[test]
fn a_value_is_written_and_the_old_value_shown() {
    let line = Line::with(&["bcg450@5", "pcg550@6", "img400@7", "bpg400@8"]);
    for (address, target, value, printed) in [
        (5, "pirani.safe-state", "use-safe-value", "pirani.safe-state: zero -> use-safe-value\n"),
        (5, "1:1/39", "0", "pirani.safe-state: use-safe-value -> zero\n"),
        (5, "ba.safe-value", "12.5 Pascal", "ba.safe-value: 0 mbar -> 0.125 mbar\n"),
        (
            5,
            "setpoint-a.setpoint-function",
            "atmosphere",
            "setpoint-a.setpoint-function: potentiometer -> atmosphere\n",
        ),
        (5, "pirani.data-units", "Torr", "pirani.data-units: mbar -> Torr\n"),
        (5, "ba.safe-value", "1 Torr", "ba.safe-value: 0.09375771 Torr -> 1 Torr\n"),
        (6, "trip-point.1/low-trip-point", "2e-3 mbar", "trip-point.1/low-trip-point: 5e-5 mbar -> 2e-3 mbar\n"),
        (6, "trip-point.1/low-trip-enable", "off", "trip-point.1/low-trip-enable: true -> false\n"),
        (6, "pirani.pirani-off", "automatic", "pirani.pirani-off: always-on -> automatic\n"),
        (7, "relay.7/low-trip-point", "1e-4 hPa", "relay.7/low-trip-point: 1e-3 hPa -> 1e-4 hPa\n"),
        (7, "key-lock", "full-lock", "device.key-lock: off -> full-lock\n"),
        (8, "ba.safe-state", "hold-last-value", "ba.safe-state: zero -> hold-last-value\n"),
    ] {
        assert_eq!(line.output("write", address, &[target, value]), printed, "{address} {target}");
    }
    let printed = line.output("write", 6, &["--json", "cdg.safe-value", "5 mbar"]);
    let change: Value = serde_json::from_str(&printed).unwrap();
    assert_eq!((&change["name"], &change["written"]), (&json!("cdg.safe-value"), &json!("5 mbar")));
    assert_eq!((&change["before"]["value"], &change["after"]["value"]), (&json!(0.0), &json!(5.0)));
}

#[test]
fn a_value_that_the_table_forbids_is_not_sent() {
    let line = Line::with(&["bcg450@5", "img400@7"]);
    let fails = |address, rest: &[&str], code, sentence: &str| line.fails("write", address, rest, code, sentence);
    let states = "bcg450 at address 5, pirani.safe-state (slot 1, index 39, instance 1): expected one of zero, full-scale, \
                  hold-last-value, use-safe-value, got";
    fails(5, &["pirani.safe-state", "never"], 2, &format!("{states} \"never\""));
    fails(5, &["pirani.safe-state", "4"], 2, &format!("{states} \"4\""));
    let range = "bcg450 at address 5, setpoint-a.percentage-of-atmosphere (slot 1, index 202, instance 5): expected a percentage \
                 from 1 % to 140 %, such as '50 %', got \"141 %\"";
    fails(5, &["setpoint-a.percentage-of-atmosphere", "141 %"], 2, range);
    let read_only = "bcg450 at address 5, device.serial-number (slot 0, index 23): it is read-only (access 1/2_R)";
    fails(5, &["serial-number", "4711"], 1, read_only);
    let prm = "img400 at address 7, channel.1/data-units (slot 1, index 22): only the user parameters of its master set it (access \
               2_R prm)";
    fails(7, &["channel.1/data-units", "Torr"], 1, prm);
    let value =
        "expected a VALUE for pirani.safe-state (1:1/39), got none; `profivac list` shows the values it accepts";
    fails(5, &["pirani.safe-state"], 2, value);
    let unknown = "bcg450 has no parameter or command \"explode\"; `profivac list` shows all";
    fails(5, &["explode"], 2, unknown);
    assert_eq!(line.output("read", 5, &["pirani.safe-state"]), "pirani.safe-state = zero\n");
}

/// A text that is no value is wrong usage, whatever is wrong with it; nothing is sent.
#[test]
fn a_pressure_needs_a_number_and_a_unit_of_the_gauge() {
    let line = Line::with(&["bcg450@5:unit=torr"]);
    let expected = "bcg450 at address 5, pirani.safe-value (slot 1, index 40, instance 1): expected a pressure of 0 or more with its \
                    unit, such as '1125.0925 Torr', got ";
    for (value, problem) in [
        ("0.5", "\"0.5\" without a unit; in the present unit of the gauge it is '0.5 Torr'"),
        ("0.2 bananas", "\"0.2 bananas\"; the units of the gauge are COUNTS, Torr, Micron, mbar, Pascal"),
        ("nan mbar", "\"nan mbar\""),
        ("-1 mbar", "\"-1 mbar\""),
        ("bogus", "\"bogus\""),
    ] {
        line.fails("write", 5, &["pirani.safe-value", value], 2, &format!("{expected}{problem}"));
    }
    assert_eq!(line.output("read", 5, &["pirani.safe-value"]), "pirani.safe-value = 0 Torr\n");
}

#[test]
fn a_pressure_outside_the_measuring_range_needs_force() {
    let line = Line::with(&["bcg450@5"]);
    let beyond = "bcg450 at address 5, pirani.safe-value (slot 1, index 40, instance 1): 1e9 mbar is outside the measuring range, \
                  which is 5e-10 mbar to 1500 mbar; to write it all the same add --force";
    line.fails("write", 5, &["pirani.safe-value", "1e9 mbar"], 2, beyond);
    assert_eq!(line.output("read", 5, &["pirani.safe-value"]), "pirani.safe-value = 0 mbar\n");
    let forced = line.output("write", 5, &["--force", "pirani.safe-value", "1e9 mbar"]);
    assert_eq!(forced, "pirani.safe-value: 0 mbar -> 1e9 mbar\n");
    // The end of the range is a legal value: tira41d1 3.2.5.1. --force does not make a text a value.
    let back = line.output("write", 5, &["pirani.safe-value", "1500 mbar"]);
    assert_eq!(back, "pirani.safe-value: 1e9 mbar -> 1500 mbar\n");
    let done = line.run("write", 5, &["--force", "pirani.safe-value", "1"]);
    assert_eq!(done.code, 2, "{}", done.err);
}

/// A script must know whether it has to read the parameter before it writes again.
#[test]
fn the_json_output_of_a_write_that_fails_says_whether_the_gauge_has_the_value() {
    let line = Line::with(&["bcg450@5"]);
    let effect = |target: &[&str]| {
        let done = line.run("write", 5, &[&["--json"], target].concat());
        let failed: Value = serde_json::from_str(&done.out).unwrap();
        assert_eq!(failed["target"], json!(target[0]), "{failed}");
        assert_eq!(done.err, format!("profivac: {}\n", failed["error"].as_str().unwrap()));
        (done.code, failed["effect"].as_str().unwrap().to_owned())
    };
    assert_eq!(effect(&["degas on", "--yes"]), (1, "not-sent".to_owned()), "the gauge is in IDLE");
    assert_eq!(effect(&["pirani.safe-state", "never"]), (2, "not-sent".to_owned()));
    line.output("write", 5, &["execute"]);
    assert_eq!(effect(&["pirani.data-units", "Torr"]), (1, "refused".to_owned()));
}

/// Unit and data type change only in IDLE: the gauge refuses, and the error advises the next step.
#[test]
fn the_error_explains_a_wrong_state() {
    let line = Line::with(&["bcg450@5"]);
    line.output("write", 5, &["execute"]);
    let mode = "bcg450 at address 5, pirani.data-units (slot 1, index 22, instance 1): writing was refused with state conflict \
                (B5), code 17: instruction not allowed in this state; unit and number type change only in IDLE and without \
                cyclic exchange: write stop first, or end the exchange in the owning master";
    line.fails("write", 5, &["pirani.data-units", "Torr"], 1, mode);
    line.output("write", 5, &["--yes", "stop"]);
    line.output("write", 5, &["pirani.data-units", "Torr"]);
}

#[test]
fn the_conditions_of_a_command_are_checked_before_it_is_sent() {
    let mut line = Line::with(&["--pressure", "1e-3 mbar", "bcg450@5"]);
    let degas = |reason: &str| {
        format!(
            "bcg450 at address 5, ba.hot-cathode-block-state-command (slot 1, index 14, instance 2): degas-on was not sent: {reason}"
        )
    };
    let on = ["--yes", "degas", "on"];
    line.fails("write", 5, &on, 1, &degas("the gauge is in IDLE and must be in EXECUTING; write execute first"));
    assert_eq!(line.output("write", 5, &["execute"]), "device.device-block-state-command: execute done\n");
    let again = "bcg450 at address 5, device.device-block-state-command (slot 0, index 15): execute was not sent: the gauge is in \
                 EXECUTING, and it is possible from IDLE only";
    line.fails("write", 5, &["execute"], 1, again);
    let high = "ba.process-value is 1e-3 mbar and must be below 7.2e-6 mbar; pump down first";
    line.fails("write", 5, &on, 1, &degas(high));
    line.tell("pressure 1e-6 mbar");
    assert_eq!(line.output("write", 5, &on), "ba.hot-cathode-block-state-command: degas-on done\n");
    assert_eq!(line.output("read", 5, &["ba.degas-status"]), "ba.degas-status = on\n");
    assert_eq!(line.output("write", 5, &["degas", "off"]), "ba.hot-cathode-block-state-command: degas-off done\n");
    assert_eq!(
        line.output("write", 5, &["--yes", "emission off"]),
        "ba.hot-cathode-block-state-command: emission-off done\n"
    );
    line.fails("write", 5, &on, 1, &degas("the emission is off; it must be on"));
}

/// The gauge holds tenths of a percent: 500 is 50 %.
#[test]
fn a_percentage_needs_its_sign_and_is_shown_with_it() {
    let line = Line::with(&["bcg450@5"]);
    let target = "setpoint-a.percentage-of-atmosphere";
    assert_eq!(line.output("read", 5, &[target]), format!("{target} = 5 %\n"));
    assert_eq!(line.output("write", 5, &[target, "50 %"]), format!("{target}: 5 % -> 50 %\n"));
    assert_eq!(line.output("write", 5, &[target, "12.5%"]), format!("{target}: 50 % -> 12.5 %\n"));
    assert_eq!(line.output("read", 5, &["1:5/202"]), format!("{target} = 12.5 %\n"));
    let bare = "bcg450 at address 5, setpoint-a.percentage-of-atmosphere (slot 1, index 202, instance 5): expected a percentage \
                from 1 % to 140 %, such as '50 %', got \"50\" without its sign; 50 percent is '50 %'";
    line.fails("write", 5, &[target, "50"], 2, bare);
    for wrong in ["0.9 %", "140.1 %", "12.55 %", "50 mbar", "%"] {
        let failed = line.run("write", 5, &[target, wrong]);
        assert_eq!(failed.code, 2, "{wrong}: {}", failed.err);
        assert!(failed.err.contains("expected a percentage from 1 % to 140 %"), "{wrong}: {}", failed.err);
    }
    let json: Value = serde_json::from_str(&line.output("read", 5, &["--json", target])).unwrap();
    assert_eq!((&json[0]["value"], &json[0]["text"], &json[0]["unit"]), (&json!(12.5), &json!("12.5 %"), &json!("%")));
}

/// The manuals print the pressure of an adjustment; a gauge that does not check it would be adjusted in a vacuum.
#[test]
fn an_adjustment_is_sent_only_at_the_pressure_of_the_manual() {
    let mut line = Line::with(&["--pressure", "5e-6 mbar", "bpg400@9", "pcg550@6", "bcg450@5", "img400@7"]);
    let refused = |line: &Line, address, target: &str, reason: &str| {
        let failed = line.run("write", address, &["--yes", target]);
        assert_eq!(failed.code, 1, "{address} {target}: {} {}", failed.out, failed.err);
        assert!(failed.err.contains(reason), "{address} {target}: {}", failed.err);
    };
    for address in [5, 6, 7, 9] {
        line.output("write", address, &["execute"]);
    }
    line.output("write", 7, &["--yes", "channel.1/emission-on"]);
    let vent = "must be above 100 mbar; vent first";
    refused(&line, 9, "full-scale-adjust", &format!("pirani.process-value is below 5.5e-3 mbar and {vent}"));
    refused(&line, 6, "pirani.gain-adjust", &format!("pirani.process-value is below 5e-5 mbar and {vent}"));
    refused(&line, 6, "atm.gain-adjust", "cdg.process-value is below 1 mbar and must be above 300 mbar; vent first");
    refused(&line, 5, "atmosphere-adjust", "cdg.process-value is below 1 mbar and must be above 300 mbar; vent first");
    for (address, target) in [(6, "cdg.zero-adjust"), (6, "pirani.zero-adjust"), (7, "channel.1/zero-adjust")] {
        let done = line.run("write", address, &["--yes", target]);
        assert_eq!(done.code, 0, "{address} {target}: {}", done.err);
    }
    line.tell("pressure 1000 mbar");
    for (address, target) in
        [(9, "full-scale-adjust"), (6, "pirani.gain-adjust"), (6, "atm.gain-adjust"), (5, "atmosphere-adjust")]
    {
        let done = line.run("write", address, &["--yes", target]);
        assert_eq!(done.code, 0, "{address} {target}: {}", done.err);
    }
    let pump = "and must be below 0.01 mbar; pump down first";
    refused(&line, 6, "cdg.zero-adjust", pump);
    refused(&line, 6, "pirani.zero-adjust", pump);
    refused(
        &line,
        7,
        "channel.4/zero-adjust",
        "channel.4/process-value is 1000 mbar and must be below 50 mbar; pump down first",
    );
}

#[test]
fn a_degas_that_runs_is_not_started_again() {
    let line = Line::with(&["--pressure", "1e-6 mbar", "bcg450@5", "bpg400@9"]);
    for (address, target) in [(5, "ba.hot-cathode-block-state-command"), (9, "ba.hot-cathode-block-state-command")] {
        line.output("write", address, &["execute"]);
        assert_eq!(line.output("write", address, &["--yes", "degas on"]), format!("{target}: degas-on done\n"));
        let again = line.run("write", address, &["--yes", "degas on"]);
        assert_eq!(again.code, 1, "{}", again.out);
        assert!(
            again.err.contains("degas-on was not sent: a degas runs; it ends by itself, or write degas off"),
            "{}",
            again.err
        );
        line.output("write", address, &["degas", "off"]);
        line.output("write", address, &["--yes", "degas on"]);
    }
}

#[test]
fn a_command_with_a_risk_needs_yes_in_a_script() {
    let mut line = Line::with(&["bcg450@5", "pcg550@6"]);
    line.output("write", 5, &["execute"]);
    let risk = "device.device-block-state-command stop stops the measurement; relays and outputs go to their safe state; nothing \
                was sent; without a terminal add --yes";
    line.fails("write", 5, &["stop"], 2, risk);
    assert_eq!(line.simulation.state(5)["device_state"], "EXECUTING");
    line.output("write", 6, &["execute"]);
    let zero = "cdg.ai-block-adjust-command zero-adjust moves the zero: the pressure must be two decades below the range of the \
                gauge; nothing was sent; without a terminal add --yes";
    line.fails("write", 6, &["cdg.zero-adjust"], 2, zero);
    let ambiguous = "\"zero-adjust\" is ambiguous: it may be cdg.zero-adjust, pirani.zero-adjust";
    line.fails("write", 6, &["zero-adjust"], 2, ambiguous);
}

/// A refusal that the tables do not contain: a trip point that the gauge calculates itself.
#[test]
fn a_refusal_of_the_gauge_is_shown_with_its_reason() {
    let line = Line::with(&["pcg550@6"]);
    line.output("write", 6, &["trip-point.1/setpoint-mode", "low-trip-point-by-atmosphere"]);
    let refused = "pcg550 at address 6, trip-point.1/low-trip-point (slot 2, index 19): writing was refused with state conflict \
                   (B5), code 17: instruction not allowed in this state; read device.device-state, and the parameter that says \
                   who sets this one";
    line.fails("write", 6, &["trip-point.1/low-trip-point", "1 mbar"], 1, refused);
}

/// On a terminal the user is asked for confirmation.
#[test]
fn a_command_with_a_risk_asks_on_a_terminal() {
    let mut line = Line::with(&["bcg450@5"]);
    line.output("write", 5, &["execute"]);
    let stop = ["write", "--port", &line.path, "--address", "5", "stop"];
    let (ended, out, said) = interrupted_on_terminal(&stop, "[y/N] ");
    assert_eq!((ended, out.as_str()), (3, ""), "Ctrl-C needs no Enter");
    assert_eq!(said, "\r\nprofivac: interrupted by a signal; nothing was written\r\n");
    for (typed, code, printed, state) in [
        ("n\n", 2, "", "EXECUTING"),
        ("\n", 2, "", "EXECUTING"),
        ("y\n", 0, "device.device-block-state-command: stop done\n", "IDLE"),
    ] {
        let (ended, out, shown) = run_on_terminal(&stop, "[y/N] ", typed);
        assert!(shown.contains("relays and outputs go to their safe state. Continue?"), "{shown}");
        assert_eq!((ended, out.as_str()), (code, printed), "{typed:?}");
        assert_eq!(line.simulation.state(5)["device_state"], state);
    }
}

/// In high vacuum the Pirani is below its range, which bounds the pressure from above.
#[test]
fn an_emission_that_was_switched_off_can_be_switched_on_again_in_high_vacuum() {
    let mut line = Line::with(&["--pressure", "5e-6 mbar", "bcg450@5"]);
    let sent = |code: &str| format!("ba.hot-cathode-block-state-command: {code} done\n");
    line.output("write", 5, &["execute"]);
    for pressure in ["5e-6 mbar", "1e-3 mbar", "1e-2 mbar"] {
        line.tell(&format!("pressure {pressure}"));
        for code in ["emission-off", "emission-on", "manual-mode"] {
            assert_eq!(line.output("write", 5, &["--yes", code]), sent(code), "{pressure}");
        }
    }
    let refused = |reason: &str| {
        format!(
            "bcg450 at address 5, ba.hot-cathode-block-state-command (slot 1, index 14, instance 2): emission-on was not sent: {reason}"
        )
    };
    line.output("write", 5, &["--yes", "emission-off"]);
    line.tell("pressure 5e-2 mbar");
    let high = line.run("write", 5, &["--yes", "emission-on"]);
    assert_eq!(high.code, 1);
    assert!(high.err.contains("and must be below 0.024 mbar; pump down first"), "{}", high.err);
    line.tell("pressure 5e-6 mbar");
    line.tell("fault 5 sensor1");
    let broken = "pirani.process-value is not valid now, and must be below 0.024 mbar";
    line.fails("write", 5, &["--yes", "emission-on"], 1, &refused(broken));
}
