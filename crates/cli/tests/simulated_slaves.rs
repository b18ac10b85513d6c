//! `simulate` with slaves by their GSD files: lines on standard input, wrong files and modules, and a segment in memory.

#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic, reason = "tests")]

use crate::common::{Folder, Program, run};
use std::fs;
use std::path::Path;

fn gsd(name: &str) -> String {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../../tests/support/gsd").join(name).display().to_string()
}

#[test]
fn lines_set_inputs_diagnosis_and_records_of_a_slave_and_not_of_a_gauge() {
    let folder = Folder::new();
    let valves = gsd("valves.gsd@9:modules=3+7");
    let mut program = Program::start(&["simulate", "--pty", &folder.name("line"), "bcg450@5", &valves]);
    program.ready();
    for (line, answer) in [
        ("input 9 2 16#1F 00", "ok"),
        ("diagnosis 9 bit 24 on", "ok Supply of valves missing"),
        ("channel-error 9 1 0 Short circuit on", "ok Supply of valves missing; slot 1 channel 0: Short circuit"),
        ("diagnosis 9 none", "ok"),
        ("record 9 1 20 DE AD", "ok"),
        ("record 9 1 20", "ok DE AD"),
        ("record 9 1 21", "error: no record in slot 1 index 21"),
        ("input 9 4 00", "error: no module in slot 4; there are 1 (8 valves), 2 (16 limit switches)"),
        (
            "fault 9 eeprom",
            "error: Example Valve station at address 9 is a slave by its GSD file, without gauge; expected input, diagnosis, \
             channel-error, alarm, record, power or state; faults of its file: diagnosis 9 bit 24 on (Supply of valves missing), \
             diagnosis 9 area 32-39 5 (Pressure too low), channel-error 9 1 0 1 on (Short circuit), channel-error 9 1 0 6 on \
             (Line break)",
        ),
        (
            "input 5 1 00",
            "error: bcg450 at address 5 is a gauge, whose inputs and diagnosis follow from pressure and faults; expected fault, \
             clear, power, button, switch, pot or state",
        ),
        ("input 7 1 00", "error: no device at address 7; known: 5 (bcg450), 9 (Example Valve station)"),
        ("power 9 off", "ok"),
        ("pressure 1e-5 mbar", "ok"),
    ] {
        assert_eq!(program.tell(line), answer, "{line}");
    }
    let state = program.state(9);
    assert_eq!((&state["power"], &state["modules"][1]["inputs"]), (&false.into(), &"1F 00".into()));
    assert_eq!(program.state(5)["address"], 5);
    let known = program.tell("outputs 9");
    assert!(known.ends_with("input, diagnosis, channel-error, alarm, record, got \"outputs\""), "{known}");
}

/// A terminal would obey them.
#[test]
fn control_characters_of_a_gsd_file_are_shown_and_not_sent_to_the_terminal() {
    let folder = Folder::new();
    let bell =
        "#Profibus_DP\nVendor_Name = \"A\u{1b}[2JB\"\nModel_Name = \"C\u{7}D\"\nIdent_Number = 0x1234\n19.2_supp = 1
Max_Diag_Data_Len = 16\nUnit_Diag_Bit(0) = \"hot\u{1b}c\"\nModule = \"4DI\u{8}\" 0x10\n1\nEndModule\n";
    fs::write(folder.path("bell.gsd"), bell).unwrap();
    let slave = format!("{}@9:modules=1", folder.name("bell.gsd"));
    let mut program = Program::start(&["simulate", "--pty", &folder.name("line"), &slave]);
    program.ready();
    assert_eq!(program.tell("diagnosis 9 bit 0 on"), "ok hot\\u{1b}c");
    assert!(program.tell("input 9 2 00").ends_with("there are 1 (4DI\\u{8})"));
    assert!(program.tell("fault 9 eeprom").starts_with("error: A\\u{1b}[2JB C\\u{7}D at address 9 is a slave"));
    assert_eq!(program.state(9)["diagnosis_texts"][0], "hot\u{1b}c");
}

/// The beginning of such a line could be another command.
#[test]
fn a_line_that_is_too_long_is_an_error_and_does_nothing() {
    let folder = Folder::new();
    let mut program = Program::start(&["simulate", "--pty", &folder.name("line"), &gsd("pressure.gsd@9")]);
    program.ready();
    let line = format!("input 9 1{}", " 41".repeat(4000));
    assert_eq!(program.tell(&line), "error: expected a line of at most 4096 octets; nothing was done");
    let line = format!("power 9 off{}", " ".repeat(9000));
    assert!(program.tell(&line).starts_with("error: expected a line of at most"));
    assert_eq!(program.state(9)["power"], true);
}

#[test]
fn a_line_without_a_gauge_has_no_pressure() {
    let folder = Folder::new();
    let mut program = Program::start(&["simulate", "--pty", &folder.name("line"), &gsd("pressure.gsd@9")]);
    program.ready();
    let answer = "error: there is no gauge on the line; a slave by its GSD file takes input, diagnosis, channel-error, alarm, record, power \
                  or state";
    assert_eq!(program.tell("pressure 1e-5 mbar"), answer);
}

#[test]
fn a_wrong_slave_ends_with_exit_code_2_and_says_what_is_possible() {
    let folder = Folder::new();
    let other = folder.path("other.gsd");
    fs::write(&other, "no GSD file").unwrap();
    for (spec, sentence) in [
        (gsd("encoder.gsd@9"), "it has 1 (Class 1), 2 (Class 2); write FILE.gsd@ADDR:modules="),
        (gsd("valves.gsd@9:modules=4"), "the file has no module 4; it has 3 (8 valves), 7 (16 limit switches), 9 ("),
        (
            gsd("valves.gsd@9:module=3"),
            "expected FILE.gsd@ADDR, FILE.gsd@ADDR:modules=3+7 or FILE.gsd@ADDR:setup=FILE.toml, got",
        ),
        (gsd("valves.gsd@5:modules=3"), "two devices at address 5"),
        (gsd("nothing.gsd@9"), "nothing.gsd cannot be read: "),
        (format!("{}@9", other.display()), "other.gsd: "),
    ] {
        let output = run(&["simulate", "--pty", &folder.name("line"), "bcg450@5", &spec]);
        let complaint = String::from_utf8(output.stderr).unwrap();
        assert_eq!(output.status.code(), Some(2), "{spec}: {complaint}");
        assert!(complaint.contains(sentence), "{spec}: {complaint}");
    }
    let spec = gsd("valves.gsd@9:modules=3");
    let output = run(&["simulate", "--pty", &folder.name("line"), "--baud", "500000", &spec]);
    let complaint = String::from_utf8(output.stderr).unwrap();
    assert_eq!(output.status.code(), Some(2), "{complaint}");
    assert!(
        complaint.contains("the GSD file does not have 500 kbit/s; it has 9.6 kbit/s, 19.2 kbit/s, 93.75 kbit/s"),
        "{complaint}"
    );
}

#[test]
fn a_segment_in_memory_has_slaves_beside_its_gauges() {
    let folder = Folder::new();
    fs::copy(gsd("pressure.gsd"), folder.path("pressure.gsd")).unwrap();
    let file = folder.path("bus.toml");
    fs::write(&file, "devices = [\"bcg450@5\", \"pressure.gsd@9\"]\n").unwrap();
    let output = run(&["scan", "--port", &format!("sim:{}", file.display()), "--json"]);
    let found = String::from_utf8(output.stdout).unwrap();
    assert!(found.contains("F003") && found.contains("08E6"), "{found}");
    fs::write(&file, "devices = [\n  \"pressure.gsd@9:modules=5\",\n]\n").unwrap();
    let output = run(&["scan", "--port", &format!("sim:{}", file.display())]);
    let complaint = String::from_utf8(output.stderr).unwrap();
    assert_eq!(output.status.code(), Some(2), "{complaint}");
    assert!(
        complaint.contains("bus.toml:2:3: ") && complaint.contains("the file has no module 5; it has 1 ("),
        "{complaint}"
    );
}
