//! `monitor` shows the pressures of slaves, keeps their units, refuses those of other masters and unlocks its own.

#![allow(clippy::unwrap_used, clippy::panic, reason = "a test")]

use crate::common::{End, Folder, Program, run, sd2};
use serde_json::Value;

/// A simulation on its own pty.
fn simulation(folder: &Folder, arguments: &[&str]) -> (Program, String) {
    let path = folder.name("line");
    let program = Program::start(&[&["simulate", "--pty", &path], arguments].concat());
    program.ready();
    (program, path)
}

fn json(line: &str) -> Value {
    serde_json::from_str(line).unwrap()
}

/// Slave_Diag of a slave without an owner that waits for parameters.
const FREE: &str = "68 0B 0B 68 82 85 08 3E 3C 02 05 00 FF 08 E6 7D 16";

#[test]
fn pressures_are_shown_in_the_units_of_the_slaves() {
    let folder = Folder::new();
    let devices = ["bcg450@5:unit=torr", "bcg450@6", "--pressure", "5e-6 mbar"];
    let (mut simulation, path) = simulation(&folder, &devices);
    for _ in 0..2 {
        let mut monitor =
            Program::start(&["monitor", "--port", &path, "--slot-time=4000", "--own", "--json", "5", "6"]);
        for (address, pressure, unit) in [(5, 3.750_308_4e-6, "Torr"), (6, 5e-6, "mbar")] {
            let row = json(&monitor.line());
            assert_eq!((&row["address"], &row["unit"], &row["state"]), (&address.into(), &unit.into(), &"DATA".into()));
            assert!(
                (row["pressure"].as_f64().unwrap_or_else(|| panic!("{row}")) / pressure - 1.0).abs() < 1e-6,
                "{row}"
            );
            assert!((row["mbar"].as_f64().unwrap() / 5e-6 - 1.0).abs() < 1e-6, "{row}");
            assert!(row["exchanges"].as_u64().unwrap() > 0, "{row}");
            assert_eq!((&row["device"], &row["remarks"]), (&"bcg450".into(), &Value::Array(vec![])));
        }
        monitor.terminate();
        assert_eq!(monitor.exit_code(), 0);
        let mut line = End::pty(&folder.path("line"));
        line.insist(&sd2(5, 60, 0x6D, ""), FREE);
    }
    assert_eq!(simulation.tell("quit"), "ok");
}

/// A gauge gets zeros: outputs that are given would be ignored.
#[test]
fn outputs_for_a_known_gauge_are_refused_before_anything_is_sent() {
    let folder = Folder::new();
    let (mut simulation, path) = simulation(&folder, &["bcg450@5"]);
    let output = run(&["monitor", "--port", &path, "--own", "--json", "--for", "1", "--outputs", "5=00", "5"]);
    let said = String::from_utf8(output.stderr).unwrap();
    assert_eq!(output.status.code(), Some(2), "{said}");
    assert!(said.contains("the slave at address 5 is a bcg450") && said.contains("leave out --outputs"), "{said}");
    assert_eq!(simulation.state(5)["device_state"], "IDLE");
}

#[test]
fn changes_of_pressure_and_power_are_shown() {
    let folder = Folder::new();
    let (mut simulation, path) = simulation(&folder, &["bcg450@5"]);
    let monitor = Program::start(&["monitor", "--port", &path, "--own", "--csv", "5"]);
    let header =
        "unix_time,address,device,pressure,unit,mbar,instance,state,remarks,exchanges,lost,quality,limit_mbar,inputs";
    assert_eq!(monitor.line(), header);
    let shows = |text: &str| {
        for _ in 0..20 {
            if monitor.line().contains(text) {
                return;
            }
        }
        panic!("{text} is not shown");
    };
    shows(",5,bcg450,1e-3,mbar,1e-3,2,DATA,\"\",");
    simulation.tell("pressure 2000 mbar");
    shows(",5,bcg450,,mbar,,3,DATA,\"over range\",");
    shows(",overrange,1.5e3");
    simulation.tell("fault 5 eeprom");
    shows("common alarm");
    simulation.tell("power 5 off");
    shows(",OFFLINE,\"no answer\",");
    simulation.tell("clear 5 eeprom");
    simulation.tell("pressure 3e-7 mbar");
    simulation.tell("power 5 on");
    shows(",5,bcg450,3e-7,mbar,3e-7,2,DATA,\"\",");
}

#[test]
fn a_slave_of_another_master_is_refused() {
    let simulation = Program::start(&["simulate", "--tcp", "127.0.0.1:0", "bcg450@5"]);
    let address = simulation.ready();
    let mut master = End::tcp(&address);
    master.ask(&sd2(5, 61, 0x5D, "80 00 00 0B 08 E6 00 00 00 00 05 1C"), "E5");
    let failed = run(&["monitor", "--port", &format!("tcp://{address}"), "--own", "5"]);
    assert_eq!(failed.status.code(), Some(1));
    let message = String::from_utf8(failed.stderr).unwrap();
    assert_eq!(message, "profivac: the slave at address 5 belongs to master 2\n");
}

#[test]
fn a_script_must_give_own_for_slaves() {
    let folder = Folder::new();
    let (_simulation, path) = simulation(&folder, &["bcg450@5"]);
    let failed = run(&["monitor", "--port", &path, "5"]);
    assert_eq!(failed.status.code(), Some(2));
    assert!(String::from_utf8(failed.stderr).unwrap().contains("add --own"));
    let mut line = End::pty(&folder.path("line"));
    line.insist(&sd2(5, 60, 0x6D, ""), FREE);
}

#[test]
fn an_address_without_a_station_is_no_answer() {
    let folder = Folder::new();
    let (_simulation, path) = simulation(&folder, &["bcg450@5"]);
    let failed = run(&["monitor", "--port", &path, "--own", "--timeout", "0.5", "9"]);
    assert_eq!(failed.status.code(), Some(3));
    assert_eq!(String::from_utf8(failed.stderr).unwrap(), "profivac: no slave answers at address 9\n");
}

#[test]
fn monitor_ends_after_its_time() {
    let folder = Folder::new();
    let (_simulation, path) = simulation(&folder, &["bcg450@5"]);
    let done = run(&["monitor", "--port", &path, "--own", "--for", "1.5", "5"]);
    assert_eq!(done.status.code(), Some(0), "{}", String::from_utf8_lossy(&done.stderr));
    let table = String::from_utf8(done.stdout).unwrap();
    let mut lines = table.lines();
    assert!(lines.next().unwrap().starts_with("ADDR  DEVICE    PART  PRESSURE"), "{table}");
    assert!(lines.next().unwrap().starts_with("   5  bcg450       2  1.000e-3 mbar     DATA"), "{table}");
}

#[test]
fn impossible_addresses_are_refused() {
    for address in ["126", "five"] {
        let failed = run(&["monitor", "--port", "/nowhere", "--own", address]);
        assert_eq!(failed.status.code(), Some(2));
        let message = String::from_utf8(failed.stderr).unwrap();
        assert!(
            message.contains(&format!("expected the address of a slave from 0 to 125, got {address:?}")),
            "{message}"
        );
    }
}

#[test]
fn an_address_is_given_once_and_differs_from_the_master() {
    for (addresses, expected) in [
        (&["5", "6", "5"][..], "address 5 is given twice"),
        (&["5", "0"], "address 0 is the address of this master; choose another with --master N"),
    ] {
        let failed = run(&[&["monitor", "--port", "/nowhere", "--own"], addresses].concat());
        assert_eq!(failed.status.code(), Some(2));
        assert_eq!(String::from_utf8(failed.stderr).unwrap(), format!("profivac: {expected}\n"));
    }
}

/// The file contains port, rate, master and gauges.
#[test]
fn a_station_file_selects_the_gauges() {
    let folder = Folder::new();
    let (memory, plant) = (folder.name("memory.toml"), folder.name("plant.toml"));
    std::fs::write(&memory, "devices = [\"bcg450@5\", \"psg550@6\"]\nbaud = 187500\npressure = \"2e-3 mbar\"\n")
        .unwrap();
    let gauge = |device: &str, address: u8| {
        format!("[[segment.gauge]]\nname = \"{device}\"\naddress = {address}\ndevice = \"{device}\"\n")
    };
    let segment = format!("[[segment]]\nname = \"bus\"\nport = \"sim:{memory}\"\nbaud = 187500\nmaster = 1\n");
    let text = segment.clone() + &gauge("bcg450", 5) + &gauge("psg550", 6);
    std::fs::write(&plant, &text).unwrap();
    let output = run(&["monitor", "--own", "--csv", "--for", "1.5", &plant]);
    assert_eq!(output.status.code(), Some(0), "{}", String::from_utf8_lossy(&output.stderr));
    let printed = String::from_utf8(output.stdout).unwrap();
    assert!(printed.contains(",5,bcg450,2e-3,mbar,") && printed.contains(",6,"), "{printed}");
    let refused = |arguments: &[&str], sentence: &str| {
        let output = run(&[&["monitor", "--own"], arguments].concat());
        let message = String::from_utf8(output.stderr).unwrap();
        assert_eq!((output.status.code(), message.contains(sentence)), (Some(2), true), "{message}");
    };
    refused(&["--port", &memory, &plant], "the file names its ports");
    refused(&["5"], "expected --port PORT with addresses, or a station's FILE.toml alone");
    std::fs::write(&plant, segment).unwrap();
    refused(&[&plant], "the segment \"bus\" has no gauges");
    refused(&[&folder.name("missing.toml")], "the file cannot be read");
}

/// A station's file: segments with a name, a port and the address of a BCG450.
fn station_file(folder: &Folder, segments: &[(&str, &str, u8)]) -> String {
    let segment = |(name, port, address): &(&str, &str, u8)| {
        format!(
            "[[segment]]\nname = \"{name}\"\nport = \"{port}\"\nmaster = 1\n\
             [[segment.gauge]]\nname = \"{name}-gauge\"\naddress = {address}\ndevice = \"bcg450\"\n"
        )
    };
    let path = folder.name("plant.toml");
    std::fs::write(&path, segments.iter().map(segment).collect::<String>()).unwrap();
    path
}

#[test]
fn all_segments_of_a_station_are_monitored_and_every_row_names_its_segment() {
    let (hall, annex) = (Folder::new(), Folder::new());
    let (_hall, hall_line) = simulation(&hall, &["bcg450@5", "--pressure", "2e-3 mbar"]);
    let (_annex, annex_line) = simulation(&annex, &["bcg450@5", "--pressure", "4e-5 mbar"]);
    let plant = station_file(&hall, &[("hall", &hall_line, 5), ("annex, east", &annex_line, 5)]);
    for (form, rows) in [
        ("--csv", [",\"hall\",5,bcg450,2e-3,mbar,", ",\"annex, east\",5,bcg450,4e-5,mbar,"]),
        ("--json", ["\"segment\":\"hall\",\"address\":5", "\"segment\":\"annex, east\",\"address\":5"]),
    ] {
        let output = run(&["monitor", "--own", form, "--for", "1.7", &plant]);
        assert_eq!(output.status.code(), Some(0), "{}", String::from_utf8_lossy(&output.stderr));
        let printed = String::from_utf8(output.stdout).unwrap();
        assert!(rows.iter().all(|row| printed.contains(row)), "{form}: {printed}");
    }
    for folder in [&hall, &annex] {
        End::pty(&folder.path("line")).insist(&sd2(5, 60, 0x6D, ""), FREE);
    }
}

#[test]
fn a_segment_that_fails_does_not_stop_the_others() {
    let folder = Folder::new();
    let (_simulation, line) = simulation(&folder, &["bcg450@5"]);
    let plant = station_file(&folder, &[("gone", "/nowhere", 5), ("hall", &line, 5)]);
    let output = run(&["monitor", "--own", "--csv", "--for", "2", &plant]);
    let message = String::from_utf8(output.stderr).unwrap();
    let printed = String::from_utf8(output.stdout).unwrap();
    assert!(printed.contains(",\"hall\",5,bcg450,1e-3,"), "{printed}");
    assert_eq!(
        message,
        "profivac: gone: there is no port /nowhere: plug in the adapter, or start the program that serves it\n\
         profivac: the segment \"gone\" ended early\n"
    );
    assert_eq!(output.status.code(), Some(3));
}

#[test]
fn a_lost_port_does_not_stop_the_other_segments() {
    let (hall, annex) = (Folder::new(), Folder::new());
    let (_hall, hall_line) = simulation(&hall, &["bcg450@5"]);
    let (mut annex_simulation, annex_line) = simulation(&annex, &["bcg450@6"]);
    let plant = station_file(&hall, &[("hall", &hall_line, 5), ("annex", &annex_line, 6)]);
    let mut monitor = Program::start(&["monitor", "--own", "--json", &plant]);
    let exchanges = |monitor: &Program, segment: &str| loop {
        let row = json(&monitor.line());
        if row["segment"] == segment && row["state"] == "DATA" {
            return row["exchanges"].as_u64().unwrap();
        }
    };
    exchanges(&monitor, "annex");
    annex_simulation.tell("quit");
    annex_simulation.exit_code();
    let before = exchanges(&monitor, "hall");
    let after = (0..3).map(|_| exchanges(&monitor, "hall")).max().unwrap();
    assert!(after > before, "{before} {after}");
    let (_annex, _) = simulation(&annex, &["bcg450@6"]);
    let row = loop {
        let row = json(&monitor.line());
        if row["segment"] == "annex" && row["state"] == "DATA" && row["pressure"].is_number() {
            break row;
        }
    };
    assert_eq!(row["address"], 6);
    monitor.terminate();
    assert_eq!(monitor.exit_code(), 0);
}
