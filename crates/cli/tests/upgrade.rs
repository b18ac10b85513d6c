//! A station of version 0.1: its file and its database, as that version wrote them in `data/station_0_1`, go on with this program.
//!
//! The database is of 20 s with a BCG450 and a TPG300 in memory: 467 samples of five series, four events, one alarm.

#![allow(clippy::unwrap_used, clippy::panic, reason = "a test")]

use crate::common::{Folder, Program, get, run, until};
use std::fs;
use std::os::unix::fs::PermissionsExt;
use std::path::Path;

/// The rows of the database of version 0.1, by series.
const SAMPLES: [(&str, usize); 5] = [("chamber", 95), ("tpg.1", 93), ("tpg.2", 93), ("tpg.3", 93), ("tpg.4", 93)];

/// The station's files in a folder of their own. Returns the path of the station's file.
fn station(folder: &Folder) -> String {
    let from = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data/station_0_1");
    for name in ["plant.toml", "hall.toml", "plant.db"] {
        fs::copy(from.join(name), folder.path(name)).unwrap();
        fs::set_permissions(folder.path(name), fs::Permissions::from_mode(0o600)).unwrap();
    }
    folder.name("plant.toml")
}

/// The number of exported samples of each series, from the first one to that of the database's end.
fn exported(file: &str) -> Vec<(String, usize)> {
    let output = run(&["export", file, "--to", "2026-11-23T06:01:49Z"]);
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let text = String::from_utf8(output.stdout).unwrap();
    let header: Vec<&str> = text.lines().next().unwrap().split(',').collect();
    let column = header.iter().position(|name| *name == "gauge").unwrap_or_else(|| panic!("{header:?}"));
    let mut counts = std::collections::BTreeMap::new();
    for line in text.lines().skip(1) {
        *counts.entry(line.split(',').nth(column).unwrap().to_owned()).or_insert(0) += 1;
    }
    counts.into_iter().collect()
}

fn expected() -> Vec<(String, usize)> {
    SAMPLES.iter().map(|(name, count)| ((*name).to_owned(), *count)).collect()
}

#[test]
fn a_database_of_version_0_1_is_read_without_being_changed() {
    let folder = Folder::new();
    station(&folder);
    let before = fs::read(folder.path("plant.db")).unwrap();
    assert_eq!(exported(&folder.name("plant.db")), expected());
    assert_eq!(fs::read(folder.path("plant.db")).unwrap(), before);
}

#[test]
fn a_station_of_version_0_1_continues_with_its_file_its_database_and_its_alarm() {
    let folder = Folder::new();
    let file = station(&folder);
    let check = run(&["run", &file, "--check", "--listen", "127.0.0.1:0"]);
    assert!(check.status.success());
    let notice = String::from_utf8(check.stderr).unwrap();
    assert!(notice.contains("record") && notice.contains("database"), "the new name of the key: {notice}");
    let mut station = Program::start(&["run", &file]);
    let ready = station.ready();
    let address = ready.strip_prefix("http://").unwrap();
    assert!(get(address, "/api/alarms").contains("chamber high"));
    // An event is on the disk before the next answer; samples around it are kept.
    until(address, "/api/gauges", "\"quality\":\"valid\"");
    station.terminate();
    assert_eq!(station.exit_code(), 0);
    assert_eq!(exported(&file), expected(), "the rows of version 0.1");
    let all = run(&["export", &file]);
    let rows = String::from_utf8(all.stdout).unwrap().lines().count() - 1;
    assert!(rows > SAMPLES.iter().map(|(_, count)| count).sum(), "{rows}: the station goes on");
}
