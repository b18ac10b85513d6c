//! `export` and `backup` as programs: rows, files, and one sentence for every error.

#![allow(clippy::unwrap_used, reason = "a test")]

use crate::common::Folder;
use profivac_recorder::{
    Deadband, Micros, Point, PointKind, PointSample, Quality, Recorder, Retention, Sample, Settings,
};
use std::fs;
use std::path::Path;
use std::process::{Command, Output};
use std::sync::Arc;
use std::time::Duration;

/// 2026-11-21 12:00:00 UTC.
const NOON: Micros = Micros(1_795_262_400 * Micros::SECOND);

/// A station's file and its database: a gauge and two channels of a controller, with a sample a second.
fn station() -> (Folder, String) {
    let folder = Folder::new();
    let [file, record] = ["plant.toml", "plant.db"].map(|name| folder.name(name));
    fs::write(&file, "[station]\nname = 'hall'\n[[segment]]\nname = 'hall'\nport = '/dev/null'\n").unwrap();
    let settings = Settings {
        deadband: Deadband { decades: 0.0, max_interval: Duration::ZERO },
        full_rate_window: Duration::ZERO,
        outbox: None,
        retention: Retention { samples: None, ..Retention::default() },
    };
    let recorder = Recorder::start(Path::new(&record), settings).unwrap();
    for name in ["chamber", "tpg300 7.1", "tpg300 7.2"] {
        for second in 0..3 {
            let sample = Sample::new(NOON.after(Duration::from_secs(second)), Some(1e-4), Quality::Valid);
            recorder.push(&Arc::from(name), sample);
        }
    }
    recorder.finish().unwrap();
    (folder, file)
}

/// Runs a command in a fixed time zone.
fn run(arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_profivac")).args(arguments).env("TZ", "UTC").output().unwrap()
}

/// The exit code, standard output and standard error.
fn outcome(arguments: &[&str]) -> (i32, String, String) {
    let output = run(arguments);
    let text = |octets: &[u8]| String::from_utf8(octets.to_vec()).unwrap();
    (output.status.code().unwrap(), text(&output.stdout), text(&output.stderr))
}

#[test]
fn rows_go_to_standard_output() {
    let (_folder, file) = station();
    let (code, rows, _) = outcome(&[
        "export",
        &file,
        "--gauge",
        "chamber",
        "--from",
        "2026-11-21 12:00:01",
        "--to",
        "2026-11-21T12:00:01Z",
    ]);
    assert_eq!((code, rows.as_str()), (2, ""), "a beginning at the end");
    let (code, rows, _) = outcome(&["export", &file, "--gauge", "chamber", "--from", "2026-11-21 12:00:01"]);
    let expected = "\
time,gauge,pressure_pa,quality
2026-11-21T12:00:01.000000Z,chamber,1e-4,valid
2026-11-21T12:00:02.000000Z,chamber,1e-4,valid
";
    assert_eq!((code, rows.as_str()), (0, expected));
    let (_, rows, _) = outcome(&["export", &file, "--gauge", "tpg300 7"]);
    assert_eq!(rows.lines().count(), 7, "both channels of the controller: {rows}");
}

#[test]
fn a_file_is_whole_and_is_overwritten_only_on_request() {
    let (folder, file) = station();
    let to = folder.name("all.csv");
    let (code, _, notice) = outcome(&["export", &file, "--out", &to]);
    assert_eq!((code, notice), (0, format!("profivac: 9 rows in {to}\n")));
    assert_eq!(fs::read_to_string(&to).unwrap().lines().count(), 10);
    fs::write(&to, "mine").unwrap();
    let (code, _, notice) = outcome(&["export", &file, "--out", &to]);
    assert_eq!(
        (code, notice),
        (
            2,
            format!(
                "profivac: {to} exists already and was not changed; choose another name, or add --force to overwrite it\n"
            )
        )
    );
    assert_eq!(fs::read_to_string(&to).unwrap(), "mine");
    assert_eq!(outcome(&["export", &file, "--out", &to, "--force"]).0, 0);
    assert_eq!(fs::read_to_string(&to).unwrap().lines().count(), 10);
    assert!(!Path::new(&format!("{to}.part")).exists());
}

#[test]
fn parquet_needs_a_file() {
    let (folder, file) = station();
    let to = folder.name("all.parquet");
    let (code, _, notice) = outcome(&["export", &file, "--parquet", "--out", &to]);
    assert_eq!((code, notice), (0, format!("profivac: 9 rows in {to}\n")));
    let octets = fs::read(&to).unwrap();
    assert!(octets.starts_with(b"PAR1") && octets.ends_with(b"PAR1"));
    assert_eq!(outcome(&["export", &file, "--parquet"]).0, 2);
    let (code, _, notice) = outcome(&["export", &file, "--parquet", "--out", "-"]);
    assert_eq!(code, 2);
    assert!(notice.contains("expected a file for Parquet, got standard output"), "{notice}");
}

#[test]
fn an_unknown_gauge_and_a_missing_database_are_named() {
    let (folder, file) = station();
    let (code, _, notice) = outcome(&["export", &file, "--gauge", "chambre"]);
    assert_eq!(code, 2);
    assert!(notice.contains("has no gauge \"chambre\"; did you mean \"chamber\"?"), "{notice}");
    let absent = folder.name("absent.db");
    for command in [&["export", &absent][..], &["backup", &absent, "--to", &folder.name("copy.db")]] {
        let (code, _, notice) = outcome(command);
        assert_eq!((code, notice), (2, format!("profivac: {absent} does not exist\n")));
    }
}

/// The station of the other tests, with the speed of a turbo and the position of a gate.
fn station_with_points() -> (Folder, String) {
    let (folder, file) = station();
    let recorder = Recorder::start(Path::new(&folder.name("plant.db")), Settings::default()).unwrap();
    for (slave, name, unit, number) in [("turbo", "speed", Some("Hz"), 1000.5), ("gate", "position", None, 0.0)] {
        let (slave, name, unit) = (slave.to_owned(), name.to_owned(), unit.map(str::to_owned));
        let point = Arc::new(Point { slave, name, unit, kind: PointKind::Number });
        recorder.push_point(&point, 0.0, PointSample::new(NOON, Some(number), Quality::Valid));
    }
    recorder.finish().unwrap();
    (folder, file)
}

#[test]
fn points_are_exported_with_their_units_and_never_as_pressures() {
    let (folder, file) = station_with_points();
    let heading = "time,slave,point,unit,value,quality,text\n";
    let speed = "2026-11-21T12:00:00.000000Z,turbo,speed,Hz,1000.5,valid,\n";
    let position = "2026-11-21T12:00:00.000000Z,gate,position,,0,valid,\n";
    for (arguments, rows) in [
        (&["--points"][..], [speed, position].concat()),
        (&["--point", "turbo.speed"], speed.to_owned()),
        (&["--point", "turbo", "--to", "2026-11-21 11:00:00"], String::new()),
        (&["--point", "gate"], position.to_owned()),
    ] {
        let (code, found, notice) = outcome(&[&["export", file.as_str()], arguments].concat());
        assert_eq!((code, found, notice), (0, format!("{heading}{rows}"), String::new()), "{arguments:?}");
    }
    let (code, rows, notice) = outcome(&["export", &file]);
    assert_eq!((code, rows.lines().count()), (0, 10), "the pressures alone");
    assert!(notice.contains("also has 2 points of slaves") && notice.contains("--points"), "{notice}");
    let (code, _, notice) = outcome(&["export", &file, "--gauge", "turbo.speed"]);
    assert!(code == 2 && notice.contains("no pressures: use --point \"turbo.speed\""), "{notice}");
    let (code, _, notice) = outcome(&["export", &file, "--point", "turbo.sped"]);
    assert!(code == 2 && notice.contains("no point \"turbo.sped\"; did you mean \"turbo.speed\"?"), "{notice}");
    assert_eq!(outcome(&["export", &file, "--points", "--gauge", "chamber"]).0, 2);
    let to = folder.name("points.parquet");
    let (code, _, notice) = outcome(&["export", &file, "--points", "--parquet", "--out", &to]);
    assert_eq!((code, notice), (0, format!("profivac: 2 rows in {to}\n")));
    let (code, _, notice) = outcome(&["backup", &file, "--to", &folder.name("copy.db")]);
    let expected = "3 series and 2 points of slaves from 2026-11-21T12:00:00.000000Z to 2026-11-21T12:00:02.000000Z";
    assert!(code == 0 && notice.contains(expected), "{notice}");
    let (_, found, notice) = outcome(&["doctor", &folder.name("plant.db")]);
    assert!(found.contains("a database of 3 series and 2 points of slaves"), "{found}{notice}");
}

/// The database has the numbers of codes; their texts are in the station's file.
#[test]
fn a_code_is_exported_with_the_text_of_the_stations_file() {
    let (folder, file) = station();
    let gsd = "#Profibus_DP\nIdent_Number = 0x0FA7\nModule = \"m\" 0x10\n1\nEndModule\n";
    std::fs::write(folder.name("gate.gsd"), gsd).unwrap();
    let slave = "[[segment.slave]]\nname = \"gate\"\naddress = 9\ngsd = \"gate.gsd\"\n[[segment.slave.point]]\nname = \"state\"\n\
                 octet = 0\ntype = \"u8\"\ntexts = { 2 = \"open\" }\n";
    std::fs::write(&file, std::fs::read_to_string(&file).unwrap() + slave).unwrap();
    let recorder = Recorder::start(Path::new(&folder.name("plant.db")), Settings::default()).unwrap();
    let (slave, name) = ("gate".to_owned(), "state".to_owned());
    let point = Arc::new(Point { slave, name, unit: None, kind: PointKind::Code });
    recorder.push_point(&point, 0.0, PointSample::new(NOON, Some(2.0), Quality::Valid));
    recorder.finish().unwrap();
    let rows = |text: &str| {
        format!("time,slave,point,unit,value,quality,text\n2026-11-21T12:00:00.000000Z,gate,state,,2,valid,{text}\n")
    };
    assert_eq!(outcome(&["export", &file, "--points"]), (0, rows("open"), String::new()));
    assert_eq!(outcome(&["export", &folder.name("plant.db"), "--points"]), (0, rows(""), String::new()));
}

#[test]
fn a_database_without_points_says_so() {
    let (_folder, file) = station();
    let (code, _, notice) = outcome(&["export", &file, "--point", "turbo.speed"]);
    assert!(code == 2 && notice.contains("it has no points of slaves"), "{notice}");
    assert_eq!(outcome(&["export", &file]).2, "");
}

#[test]
fn a_backup_says_what_it_holds_and_is_a_record() {
    let (folder, file) = station();
    let copy = folder.name("copy.db");
    let (code, _, notice) = outcome(&["backup", &file, "--to", &copy]);
    assert_eq!(code, 0, "{notice}");
    assert!(notice.contains("3 series from 2026-11-21T12:00:00.000000Z to 2026-11-21T12:00:02.000000Z"), "{notice}");
    assert_eq!(outcome(&["export", &copy]).1, outcome(&["export", &file]).1);
    let (code, _, notice) = outcome(&["backup", &file, "--to", &copy]);
    assert_eq!((code, notice), (2, format!("profivac: {copy} exists; add --force to replace it\n")));
    let (code, json, _) = outcome(&["backup", &file, "--to", &copy, "--force", "--json"]);
    assert_eq!(code, 0);
    assert!(json.contains("\"series\": 3"), "{json}");
    let (code, _, notice) = outcome(&["backup", &file, "--to", &folder.name("plant.db"), "--force"]);
    assert_eq!(code, 2);
    assert!(notice.contains("is the database itself"), "{notice}");
}
