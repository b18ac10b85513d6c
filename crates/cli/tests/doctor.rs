//! `profivac doctor`: each finding names the next step, and the exit code says whether something is wrong.

#![allow(clippy::unwrap_used, clippy::panic, reason = "a test")]

use crate::common::{Folder, Program, run};
use profivac_recorder::{Deadband, LastCheck, Micros, Quality, Recorder, Retention, Sample, Settings, StationState};
use serde_json::Value;
use std::fs;
use std::io::{Read, Write};
use std::net::TcpListener;
use std::path::Path;
use std::process::Output;
use std::sync::Arc;
use std::time::Duration;

/// The findings as (verdict, text), and the exit code.
fn findings(output: &Output) -> (Vec<(String, String)>, i32) {
    let examinations: Value = serde_json::from_slice(&output.stdout).unwrap();
    let all = examinations.as_array().unwrap().iter().flat_map(|it| it["findings"].as_array().unwrap());
    let finding = |finding: &Value| {
        let verdict = finding["verdict"].as_str().unwrap().to_owned();
        let next = finding["next"].as_str();
        assert_eq!(verdict == "good", next.is_none(), "{finding}: only what is good has no next step");
        (verdict, format!("{} -> {}", finding["found"].as_str().unwrap(), next.unwrap_or_default()))
    };
    (all.map(finding).collect(), output.status.code().unwrap())
}

fn doctor(subjects: &[&str]) -> (Vec<(String, String)>, i32) {
    doctor_for("1", subjects)
}

fn doctor_for(seconds: &str, subjects: &[&str]) -> (Vec<(String, String)>, i32) {
    findings(&run(&[&["doctor", "--json", "--for", seconds], subjects].concat()))
}

/// Asserts that one finding has this verdict and contains this text.
#[track_caller]
fn assert_finds(found: &[(String, String)], verdict: &str, text: &str) {
    assert!(
        found.iter().any(|(own, sentence)| own == verdict && sentence.contains(text)),
        "{verdict} {text}: {found:#?}"
    );
}

#[test]
fn the_computer_is_checked_without_a_name() {
    let (found, code) = doctor(&[]);
    assert_finds(&found, "good", "the clock is set");
    assert!(found.iter().any(|(_, text)| text.contains("runs this program at most")), "{found:?}");
    // A serial device of this computer may be one that the user may not open.
    assert!(code == 0 || found.iter().any(|(verdict, _)| verdict == "bad-port"), "{found:?}");
}

#[test]
fn a_missing_port_is_a_problem_and_its_next_step_names_those_that_are_there() {
    let (found, code) = doctor(&["/dev/no-such-device"]);
    assert_eq!(code, 3);
    assert_finds(&found, "bad-port", "there is no port /dev/no-such-device -> plug in the adapter");
    assert!(found[0].1.contains("this computer has"), "{found:?}");
}

#[test]
fn a_silent_line_is_noted_and_a_scan_is_the_next_step() {
    let folder = Folder::new();
    let line = folder.name("line");
    let simulation = Program::start(&["simulate", "--pty", &line, "bcg450@5"]);
    simulation.ready();
    let (found, code) = doctor(&[&fs::canonicalize(&line).unwrap().to_string_lossy()]);
    assert_eq!(code, 0);
    assert_finds(
        &found,
        "note",
        "the line is silent: no master sends -> ask the gauges with `profivac scan --port /dev/pts/",
    );
}

/// A master and slaves that a test writes octet by octet.
fn line_with(octets: &'static [u8]) -> (Vec<(String, String)>, i32, Vec<u8>) {
    let server = TcpListener::bind("127.0.0.1:0").unwrap();
    let port = format!("tcp://{}", server.local_addr().unwrap());
    let writer = std::thread::spawn(move || {
        let (mut line, _) = server.accept().unwrap();
        line.write_all(octets).unwrap();
        let mut sent = Vec::new();
        line.read_to_end(&mut sent).unwrap();
        sent
    });
    // Long enough for a writer that a loaded computer delays.
    let (found, code) = doctor_for("5", &[&port]);
    (found, code, writer.join().unwrap())
}

#[test]
fn telegrams_name_the_masters_and_a_slave_that_does_not_answer_and_nothing_is_sent() {
    // Two Slave_Diag requests of master 2 to slave 5, repeated, and its token.
    const REQUESTS: [u8; 11] = [0x68, 5, 5, 0x68, 0x85, 0x82, 0x6D, 0x3C, 0x3E, 0xEE, 0x16];
    let mut line = Vec::new();
    for _ in 0..4 {
        line.extend(REQUESTS);
        line.extend([0xDC, 2, 2]);
    }
    let (found, code, sent) = line_with(line.leak());
    assert_eq!((code, sent), (3, Vec::new()));
    assert_finds(&found, "good", "8 telegrams");
    assert_finds(&found, "bad-port", "station 5 is asked and does not answer -> check its power");
}

#[test]
fn octets_without_a_telegram_name_the_wires() {
    let (found, code, _) = line_with(&[0x55; 60]);
    assert_eq!(code, 3);
    assert_finds(&found, "bad-port", "60 octets and no telegram among them -> exchange the wires A and B");
}

/// A telnet server that negotiates nothing, on a port for raw octets.
#[test]
fn a_server_that_doubles_ff_is_named_in_place_of_the_wires() {
    // Slave_Diag, and the answer of a gauge without an owner: the address of its master is FF, and comes twice.
    const REQUEST: [u8; 11] = [0x68, 5, 5, 0x68, 0x85, 0x82, 0x6D, 0x3C, 0x3E, 0xEE, 0x16];
    const ANSWER: [u8; 18] = [0x68, 11, 11, 0x68, 0x82, 0x85, 8, 0x3E, 0x3C, 2, 5, 0, 0xFF, 0xFF, 8, 0xE6, 0x7D, 0x16];
    let (found, code, _) = line_with([&REQUEST[..], &ANSWER].concat().repeat(6).leak());
    assert_eq!(code, 3, "{found:?}");
    assert_finds(
        &found,
        "bad-port",
        "sends FF twice, as telnet does, so telegrams with this octet are damaged -> use telnet://",
    );
    assert!(!found.iter().any(|(_, text)| text.contains("termination")), "{found:?}");
}

const STATION: &str = "[station]\nlisten = \"127.0.0.1:0\"\ndatabase = \"plant.db\"\n\n[[segment]]\nname = \"hall\"\nport = \"PORT\"\n\n\
                       [[segment.gauge]]\nname = \"chamber\"\naddress = 5\ndevice = \"bcg450\"\n";

#[test]
fn the_file_of_a_station_is_checked_with_its_ports_its_database_and_its_address() {
    let folder = Folder::new();
    fs::write(folder.path("hall.toml"), "devices = [\"bcg450@5\"]\npressure = \"1e-3 mbar\"\n").unwrap();
    let file = folder.name("plant.toml");
    fs::write(&file, STATION.replace("PORT", "sim:hall.toml")).unwrap();
    let (found, code) = doctor(&[&file]);
    assert_eq!(code, 0, "{found:?}");
    assert_finds(&found, "good", "the file of a station, segments: 1, gauges: 1");
    assert_finds(&found, "good", "the database will be");
    assert_finds(&found, "good", "the address of the dashboard");
    fs::write(&file, STATION.replace("PORT", "/dev/no-such-device")).unwrap();
    let (found, code) = doctor(&[&file]);
    assert_eq!(code, 3);
    assert_finds(&found, "bad-port", "segment hall: there is no port /dev/no-such-device");
    fs::write(&file, STATION.replace("bcg450", "bcg4500")).unwrap();
    let (found, code) = doctor(&[&file]);
    assert_eq!(code, 2);
    assert_finds(&found, "bad-file", "plant.toml:");
}

#[test]
fn a_database_is_checked_whole_and_a_damaged_one_is_a_problem() {
    let folder = Folder::new();
    fs::write(folder.path("hall.toml"), "devices = [\"bcg450@5\"]\npressure = \"1e-3 mbar\"\n").unwrap();
    let file = folder.name("plant.toml");
    fs::write(&file, STATION.replace("PORT", "sim:hall.toml")).unwrap();
    let mut station = Program::start(&["run", &file]);
    station.ready();
    station.terminate();
    assert_eq!(station.exit_code(), 0);
    let database = folder.name("plant.db");
    let (found, code) = doctor(&[&database]);
    assert_eq!(code, 0, "{found:?}");
    assert_finds(&found, "good", "the database is not damaged");
    let mut octets = fs::read(&database).unwrap();
    // Pages after the first one, which holds the list of tables.
    let page = 4096;
    octets[page..3 * page].fill(0xA5);
    fs::write(folder.path("damaged.db"), octets).unwrap();
    let (found, code) = doctor(&[&folder.name("damaged.db")]);
    assert_eq!(code, 2, "{found:?}");
    assert_finds(&found, "bad-file", "backup");
}

#[test]
fn other_files_are_recognised() {
    let folder = Folder::new();
    let of = |name: &str, text: &str| {
        fs::write(folder.path(name), text).unwrap();
        doctor(&[&folder.name(name)])
    };
    let (found, code) = of("segment.toml", "devices = [\"bcg450@5\"]\npressure = \"1e-3 mbar\"\n");
    assert_eq!(code, 0);
    assert_finds(&found, "good", "a segment in memory");
    let (found, code) = of("log.txt", "68 05 05 68 85 82 6D 3C 3E EE 16\nDC 02 02\n");
    assert_eq!(code, 0);
    assert_finds(&found, "good", "text with octets: 2 telegrams, 0 damaged");
    let (found, code) = of("scenario.toml", "no-such-key = 1\n");
    assert_eq!(code, 2);
    assert_finds(&found, "bad-file", "unknown field");
    let (found, code) = doctor(&[&folder.name("absent.toml")]);
    assert_eq!(code, 2);
    assert_finds(&found, "bad-file", "check the name");
}

/// 2026-11-21 12:00:00 UTC.
const NOON: Micros = Micros(1_795_262_400 * Micros::SECOND);

/// A database with a sample a second of each series.
fn database(path: &str, series: &[(&str, &[(f64, Quality)])]) {
    let settings = Settings {
        deadband: Deadband { decades: 0.0, max_interval: Duration::ZERO },
        full_rate_window: Duration::ZERO,
        outbox: None,
        retention: Retention { samples: None, ..Retention::default() },
    };
    let recorder = Recorder::start(Path::new(path), settings).unwrap();
    for (name, samples) in series {
        for (second, (pa, quality)) in (0..).zip(*samples) {
            let at = NOON.after(Duration::from_secs(second));
            recorder.push(&Arc::from(*name), Sample::new(at, Some(*pa), *quality));
        }
    }
    recorder.finish().unwrap();
}

#[test]
fn the_last_check_of_the_station_is_shown_with_its_time_and_its_damage() {
    let folder = Folder::new();
    let path = folder.name("plant.db");
    database(&path, &[]);
    let (found, _) = doctor(&[&path]);
    assert_finds(&found, "good", "the station has not checked this database yet");
    let store = |found: &[&str]| {
        let check = LastCheck { at: NOON, found: found.iter().map(|text| (*text).to_owned()).collect() };
        let recorder = Recorder::start(Path::new(&path), Settings::default()).unwrap();
        assert!(recorder.store_state(StationState::from(&check)));
        recorder.finish().unwrap();
    };
    store(&[]);
    let (found, code) = doctor(&[&path]);
    assert_finds(&found, "good", "the last check of the station, at 2026-11-21T12:00:00Z, found no damage");
    assert_eq!(code, 0);
    store(&["Tree 5 page 7 is wrong"]);
    let (found, _) = doctor(&[&path]);
    let damage =
        "the last check of the station, at 2026-11-21T12:00:00Z, found damage: Tree 5 page 7 is wrong -> restore";
    assert_finds(&found, "note", damage);
}

#[test]
fn samples_that_are_the_highest_integer_are_named_with_their_times() {
    const PASCAL: (f64, Quality) = (32767.0, Quality::Valid);
    const MICRON: (f64, Quality) = (32767.0 / 750.061_68 * 100.0, Quality::Valid);
    const UNSIGNED: (f64, Quality) = (65535.0, Quality::Valid);
    const OTHER: (f64, Quality) = (32766.0, Quality::Valid);
    let folder = Folder::new();
    let path = folder.name("plant.db");
    let series: [(&str, &[(f64, Quality)]); 4] = [
        ("chamber", &[OTHER, PASCAL, PASCAL, OTHER, MICRON]),
        ("rack.2", &[UNSIGNED, UNSIGNED]),
        // What the station records now, and a gauge with floats.
        ("bounded", &[(32767.0, Quality::Overrange), (32767.5, Quality::Valid)]),
        (
            "many",
            &[PASCAL, OTHER, PASCAL, OTHER, PASCAL, OTHER, PASCAL, OTHER, PASCAL, OTHER, PASCAL, PASCAL, OTHER, PASCAL],
        ),
    ];
    database(&path, &series);
    let (found, code) = doctor(&[&path]);
    assert_eq!(code, 0, "{found:?}");
    assert_finds(
        &found,
        "note",
        "chamber: valid samples that are the highest integer in a pressure unit (3): 327.67 mbar from 2026-11-21T12:00:01.000000Z to \
         2026-11-21T12:00:02.000000Z; 43.68574 mbar at 2026-11-21T12:00:04.000000Z -> read each one as this pressure or a higher one",
    );
    assert_finds(
        &found,
        "note",
        "rack.2: valid samples that are the highest integer in a pressure unit (2): 655.35 mbar from ",
    );
    assert_finds(
        &found,
        "note",
        "many: valid samples that are the highest integer in a pressure unit (8): 327.67 mbar at ",
    );
    assert_finds(&found, "note", "12:00:08.000000Z; 2 more periods -> ");
    assert!(found.iter().all(|(_, text)| !text.contains("bounded")), "{found:?}");

    // The file of the station names the device: 65535 is no highest integer of a BCG450.
    let file = folder.name("plant.toml");
    let (port, rack) = ("/dev/null", "\n[[segment.gauge]]\nname = \"rack\"\naddress = 6\ndevice = \"bcg450\"\n");
    fs::write(&file, STATION.replace("PORT", port) + rack).unwrap();
    let (found, _) = doctor(&[&file]);
    assert_finds(&found, "note", "chamber: valid samples that are the highest integer");
    assert!(found.iter().all(|(_, text)| !text.contains("rack.2")), "{found:?}");
}

#[test]
fn a_declared_module_with_integers_in_a_pressure_unit_is_noted() {
    let folder = Folder::new();
    let file = folder.name("plant.toml");
    let declared = "configuration = \"C6 87 8C 0A 0A 05 05 05 03\"\nunit = \"Pascal\"\n";
    let listening =
        STATION.replace("PORT", "/dev/null").replace("[[segment.gauge]]", "listen-only = true\n[[segment.gauge]]");
    fs::write(&file, listening.clone() + declared).unwrap();
    let sentence =
        "the gauge \"chamber\": its integers in Pascal show 0.01 to 327.67 mbar only: a higher pressure is over range";
    let (found, _) = doctor(&[&file]);
    assert_finds(&found, "note", sentence);
    let checked = run(&["run", &file, "--check", "--listen", "127.0.0.1:0"]);
    let said = String::from_utf8_lossy(&checked.stderr).into_owned();
    assert!(checked.status.success() && said.contains(sentence), "{said}");
    // Without the unit every pressure unit is named.
    fs::write(&file, listening.clone() + &declared.replace("unit = \"Pascal\"\n", "")).unwrap();
    let sentence = "the gauge \"chamber\": its integers show only 1.3332 to 43686 mbar in Torr, \
                    0.0013332 to 43.686 mbar in Micron, 1 to 32767 mbar in mbar, 0.01 to 327.67 mbar in Pascal: a higher pressure is over range";
    let (found, _) = doctor(&[&file]);
    assert_finds(&found, "note", sentence);
    let checked = run(&["run", &file, "--check", "--listen", "127.0.0.1:0"]);
    let said = String::from_utf8_lossy(&checked.stderr).into_owned();
    assert!(checked.status.success() && said.contains(sentence), "{said}");
    fs::write(&file, listening + &declared.replace("Pascal", "COUNTS")).unwrap();
    let (found, _) = doctor(&[&file]);
    assert!(found.iter().all(|(_, text)| !text.contains("its integers")), "{found:?}");
}
