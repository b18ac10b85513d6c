//! `report` as a program: the selected pump-down, the output file, and one sentence for every error.

#![allow(clippy::unwrap_used, clippy::panic, reason = "a test")]

use crate::common::Folder;
use profivac_recorder::{Deadband, Micros, Quality, Recorder, Retention, Sample, Settings};
use std::fs;
use std::path::Path;
use std::process::{Command, Output};
use std::sync::Arc;
use std::time::Duration;

/// 2026-11-21 12:00:00 UTC.
const NOON: Micros = Micros(1_795_262_400 * Micros::SECOND);

const STATION: &str = "
[station]
name = 'Target <hall>'
[[segment]]
name = 'hall'
port = '/dev/null'
[[segment.gauge]]
name = 'chamber'
address = 5
device = 'bcg450'
levels = { ready = '5e-3 mbar' }
";

/// A station's file and its database: two pump-downs of 1000 s, the second a day later; a gauge with constant pressure, and a
/// controller with two channels.
fn station() -> (Folder, String, String) {
    let folder = Folder::new();
    let [file, record] = ["plant.toml", "plant.db"].map(|name| folder.name(name));
    fs::write(&file, STATION).unwrap();
    let retention = Retention { samples: None, ..Retention::default() };
    let settings =
        Settings { deadband: Deadband::default(), full_rate_window: Duration::ZERO, retention, outbox: None };
    let recorder = Recorder::start(Path::new(&record), settings).unwrap();
    let gauges: [Arc<str>; 4] = ["chamber", "still", "tpg300 7.1", "tpg300 7.2"].map(Arc::from);
    for day in 0..2_u32 {
        for second in 0..1_000_u32 {
            let t = (f64::from(second) - 100.0).max(0.0);
            let pa = (101_325.0 * (-t / 20.0).exp()).max(1e-2);
            let at = NOON.after(Duration::from_secs((day * 86_400 + second).into()));
            for (gauge, pa) in gauges.iter().zip([pa, 3.0, pa.max(1.0), pa.max(10.0)]) {
                recorder.push(gauge, Sample::new(at, Some(pa), Quality::Valid));
            }
        }
    }
    recorder.finish().unwrap();
    (folder, file, record)
}

/// Runs `report` in a fixed time zone.
fn run(arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_profivac")).args(arguments).env("TZ", "UTC").output().unwrap()
}

fn out(output: &Output) -> String {
    String::from_utf8(output.stdout.clone()).unwrap()
}

fn stderr_of(output: &Output) -> String {
    String::from_utf8(output.stderr.clone()).unwrap()
}

#[test]
fn the_last_pump_down_becomes_a_page_that_is_never_overwritten() {
    let (folder, file, _) = station();
    let page = folder.name("page.html");
    let made = run(&["report", &file, "--out", &page]);
    assert_eq!(made.status.code(), Some(0), "{}", stderr_of(&made));
    let why = stderr_of(&made);
    assert!(why.starts_with("profivac: the last pump-down: from 2026-11-22 "), "{why}");
    assert!(why.contains("was last at 1010 mbar") && why.contains("the end of the database"), "{why}");
    let text = fs::read_to_string(&page).unwrap();
    for wanted in ["<h1>Target &lt;hall&gt;</h1>", "BCG450-SP", "ready: 5\u{a0}×\u{a0}10⁻³\u{a0}mbar", "tpg300 7.1"]
    {
        assert!(text.contains(wanted), "{wanted}");
    }
    // A gauge with constant pressure has no curve.
    assert!(!text.contains("still</"), "{text}");
    let again = run(&["report", &file, "--out", &page]);
    assert_eq!(again.status.code(), Some(2));
    assert!(
        stderr_of(&again).contains(
            "page.html exists already and was not changed; choose another name, or add --force to overwrite it"
        ),
        "{}",
        stderr_of(&again)
    );
    assert_eq!(run(&["report", &file, "--out", &page, "--force"]).status.code(), Some(0));
}

#[test]
fn the_default_file_name_contains_title_and_date() {
    let (folder, file, _) = station();
    let program = env!("CARGO_BIN_EXE_profivac");
    let mut command = Command::new(program);
    let made = command.args(["report", &file, "--title", "Abnahme: Kammer 7/ü"]).env("TZ", "UTC");
    let made = made.current_dir(folder.path("")).output().unwrap();
    assert_eq!(made.status.code(), Some(0), "{}", stderr_of(&made));
    assert!(folder.path("abnahme-kammer-7-ü-2026-11-22-1201.html").exists(), "{}", stderr_of(&made));
}

#[test]
fn json_and_pages_can_go_to_standard_output() {
    let (_folder, _, record) = station();
    let made =
        run(&["report", &record, "--gauge", "chamber", "--volume", "100 l", "--to-pressure", "2e-2 mbar", "--json"]);
    let report: serde_json::Value = serde_json::from_str(&out(&made)).unwrap();
    let gauge = &report["gauges"][0];
    assert_eq!((&report["title"], &gauge["name"]), (&"plant".into(), &"chamber".into()));
    let speed = gauge["quickest"]["speed_m3_per_s"].as_f64().unwrap();
    assert!((speed / 5e-3 - 1.0).abs() < 0.02, "{speed}");
    let asked = report["asked"].as_array().unwrap().iter().position(|asked| asked["pa"] == 2.0).unwrap();
    let s = gauge["times"][asked]["s"].as_f64().unwrap();
    assert!((s / (20.0 * (101_325.0_f64 / 2.0).ln()) - 1.0).abs() < 0.01, "{s}");
    let page = run(&["report", &record, "--gauge", "tpg300 7", "--unit", "torr", "--out", "-"]);
    let text = out(&page);
    assert!(text.starts_with("<!doctype html>") && text.ends_with("</html>\n"));
    assert!(text.contains("tpg300 7.1") && text.contains("tpg300 7.2") && text.contains("Torr"), "{text}");
}

#[test]
fn pump_downs_are_listed_and_a_time_selects_one() {
    let (_folder, _, record) = station();
    let listed = out(&run(&["report", &record, "--list"]));
    let rows: Vec<_> = listed.lines().skip(1).map(|line| line.split_whitespace().next().unwrap()).collect();
    assert_eq!(rows, ["2026-11-21", "2026-11-22"], "{listed}");
    assert!(listed.contains("vented") && listed.contains("open"), "{listed}");
    let listed: serde_json::Value = serde_json::from_str(&out(&run(&["report", &record, "--list", "--json"]))).unwrap();
    let begin = listed[0]["begin"].as_str().unwrap();
    assert_eq!((begin, listed.as_array().unwrap().len()), ("2026-11-21T12:01:40Z", 2));
    let first = run(&["report", &record, "--to", "2026-11-21T12:15:00Z", "--json"]);
    let report: serde_json::Value = serde_json::from_str(&out(&first)).unwrap();
    assert_eq!((&report["begin"], &report["end"]), (&begin.into(), &"2026-11-21T12:15:00Z".into()));
    let asked = run(&["report", &record, "--from", "2026-11-21T12:00:00Z", "--to", "2026-11-21T12:05:00Z", "--json"]);
    let report: serde_json::Value = serde_json::from_str(&out(&asked)).unwrap();
    assert_eq!(report["seconds"], 300.0);
}

#[test]
fn every_error_is_one_sentence() {
    let (folder, file, record) = station();
    let other = folder.name("notes.db");
    fs::write(
        &other,
        "a shopping list, and much longer than the head of a database is, which has a hundred octets or so",
    )
    .unwrap();
    let empty = folder.name("empty.db");
    fs::write(&empty, "").unwrap();
    let bare = folder.name("bare.toml");
    fs::write(&bare, "[[segment]]\nname = 'a'\nport = 'b'\n").unwrap();
    let none = folder.name("none.db");
    for (arguments, sentence) in [
        (vec![none.as_str()], "none.db does not exist"),
        (vec![&bare], "bare.db does not exist; `profivac run "),
        (vec![&other], "notes.db is not a database of a station: file is not a database"),
        (vec![&empty], "empty.db: expected a database of profivac, found an empty one"),
        (vec![&record, "--gauge", "chambre"], "has no gauge \"chambre\"; did you mean \"chamber\"?"),
        (vec![&record, "--gauge", "xyz"], "has no gauge \"xyz\"; known: chamber, still, tpg300 7.1, tpg300 7.2"),
        (vec![&record, "--gauge", "still"], "found no pump-down in "),
        (vec![&record, "--from", "soon"], "expected a time like '2026-11-21 14:00'"),
        (
            vec![&record, "--from", "2026-11-22", "--to", "2026-11-21"],
            "expected a beginning before the end, got 2026-11-22",
        ),
        (vec![&record, "--from", "2027-01-01"], "no samples from 2027-01-01"),
        (vec![&record, "--from", "2020-01-01", "--to", "2020-01-02"], "no samples from 2020-01-01"),
        (vec![&record, "--from", "2026-11-21T18:00:00Z", "--to", "2026-11-21T19:00:00Z"], "no samples from 2026-11-21"),
        (vec![&record, "--from", "2026-11-21T17:00:00Z", "--to", "2026-11-21T17:30:00Z"], "no samples from 2026-11-21"),
        (
            vec![&record, "--gauge", "chamber", "--from", "2026-11-21T17:00:00Z", "--to", "2026-11-21T17:30:00Z"],
            "no samples from 2026-11-21",
        ),
        (vec![&record, "--to", "2020-01-01"], "found no pump-down in "),
        (vec![&record, "--volume", "50"], "expected a volume like '50 l' or '1.2 m3', got \"50\""),
        (vec![&record, "--unit", "psi"], "expected a unit, one of mbar, Pa, hPa, Torr, micron, got \"psi\""),
        (
            vec![&file, "--out", "/no/such/folder/page.html"],
            "/no/such/folder/page.html cannot be written: No such file or directory",
        ),
    ] {
        let ended = run(&[vec!["report"], arguments.clone()].concat());
        assert_eq!(ended.status.code(), Some(2), "{arguments:?}: {}", stderr_of(&ended));
        assert!(stderr_of(&ended).contains(sentence), "{arguments:?}: {}", stderr_of(&ended));
        assert!(ended.stdout.is_empty());
    }
}

#[test]
fn a_database_of_a_newer_program_is_refused() {
    let (folder, _, record) = station();
    let newer = folder.name("newer.db");
    let mut octets = fs::read(&record).unwrap();
    // The user version of a database is the big-endian number at octet 60.
    octets[60..64].copy_from_slice(&99_u32.to_be_bytes());
    fs::write(&newer, octets).unwrap();
    let ended = run(&["report", &newer]);
    assert_eq!(ended.status.code(), Some(2));
    assert!(
        stderr_of(&ended).contains("newer.db has tables of version 99, this program knows version "),
        "{}",
        stderr_of(&ended)
    );
}

#[test]
fn the_database_of_a_demonstration_can_be_reported() {
    let folder = Folder::new();
    let record = folder.name("demo.db");
    let shown = run(&["demo", "--headless", "--for", "3", "--speed", "4", "--record", &record]);
    assert_eq!(shown.status.code(), Some(0), "{}", stderr_of(&shown));
    let made = run(&["report", &record, "--from", "-1h", "--gauge", "bcg450 5", "--json"]);
    let report: serde_json::Value = serde_json::from_str(&out(&made)).unwrap();
    let gauge = &report["gauges"][0];
    let [first, lowest] = ["first", "lowest"].map(|seen| gauge[seen]["pa"].as_f64().unwrap());
    assert!((9e4..1.2e5).contains(&first) && lowest < 1e4, "{gauge}");
    let again = run(&["demo", "--headless", "--for", "1", "--record", &record]);
    assert_eq!(again.status.code(), Some(2));
    assert!(stderr_of(&again).contains("exists already; a demonstration needs a new file"), "{}", stderr_of(&again));
}
