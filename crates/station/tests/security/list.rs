//! The list in docs/security.md names existing tests only.

use std::fs;
use std::path::{Path, PathBuf};

fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../..")
}

/// Appends the text of all test sources below a folder.
fn tests(folder: &Path, all: &mut String) {
    for entry in fs::read_dir(folder).unwrap().map(Result::unwrap) {
        let path = entry.path();
        let name = entry.file_name().to_string_lossy().into_owned();
        if path.is_dir() && name != "node_modules" && name != "dist" {
            tests(&path, all);
        } else if name.ends_with(".rs") || name.ends_with(".test.mjs") {
            *all += &fs::read_to_string(&path).unwrap();
        }
    }
}

#[test]
fn every_item_of_the_list_names_an_existing_test() {
    let list = fs::read_to_string(root().join("docs/security.md")).unwrap();
    let mut all = String::new();
    for name in ["config", "station", "web-server", "recorder", "cli"] {
        tests(&root().join("crates").join(name), &mut all);
    }
    let rows: Vec<_> = list.lines().filter(|line| line.starts_with("| ") && line.contains("| `")).collect();
    assert!(rows.len() > 40, "{}", rows.len());
    for row in rows {
        let cell = row.trim_end_matches('|').rsplit('|').next().unwrap();
        for name in cell.split('`').skip(1).step_by(2) {
            let exists = all.contains(&format!("fn {name}()")) || all.contains(&format!("test('{name}'"));
            assert!(exists, "there is no test {name:?}: {row}");
        }
    }
}

/// The sources below a folder without the unit tests, which are at their ends or in files of their own.
fn sources(folder: &Path) -> Vec<String> {
    fs::read_dir(folder)
        .unwrap()
        .flat_map(|entry| {
            let path = entry.unwrap().path();
            match path.extension() {
                _ if path.is_dir() => sources(&path),
                _ if path.ends_with("tests.rs") => Vec::new(),
                Some(kind) if kind == "rs" => {
                    let text = fs::read_to_string(&path).unwrap();
                    vec![text.split("#[cfg(test)]").next().unwrap_or_default().to_owned()]
                }
                _ => Vec::new(),
            }
        })
        .collect()
}

/// No input can become a command of the operating system: the port layer starts `setserial` with the path of a device, and
/// nothing else starts a program.
#[test]
fn the_station_starts_no_program_but_setserial() {
    for name in
        ["wire", "dp", "devices", "vacuum", "host", "client", "virtual", "recorder", "web-server", "station", "config"]
    {
        let all = sources(&root().join("crates").join(name).join("src")).concat();
        let started: Vec<_> = all.split("Command::new(").skip(1).filter_map(|rest| rest.split(')').next()).collect();
        let expected = if name == "host" { vec!["\"setserial\""] } else { Vec::new() };
        assert_eq!(started, expected, "{name}");
    }
}
