//! `names --for epics`: the PVs of a station, and the lists for other programs.

#![allow(clippy::unwrap_used, clippy::panic, reason = "a test")]

use crate::common::{Folder, run};
use std::process::Output;

const PLANT: &str = r#"
[[segment]]
name = "hall"
port = "sim:hall.toml"

[[segment.gauge]]
name = "chamber"
address = 5
device = "bcg450"

[[segment.gauge]]
name = "fore line"
address = 6
device = "tpg300"
"#;

fn stdout(output: &Output) -> String {
    assert_eq!(output.status.code(), Some(0), "{}", String::from_utf8_lossy(&output.stderr));
    String::from_utf8(output.stdout.clone()).unwrap()
}

fn refusal(output: &Output) -> String {
    assert_eq!(output.status.code(), Some(2));
    String::from_utf8(output.stderr.clone()).unwrap()
}

#[test]
fn the_pvs_of_epics_have_their_types_and_lists_for_archiver_and_phoebus_are_written() {
    let folder = Folder::new();
    std::fs::write(folder.path("plant.toml"), format!("{PLANT}[epics]\nprefix = 'VAC:'\n")).unwrap();
    let (list, screen) = (folder.name("pvs.txt"), folder.name("vacuum.bob"));
    let arguments =
        ["names", &folder.name("plant.toml"), "--for", "epics", "--csv", "--archiver", &list, "--bob", &screen];
    let csv = stdout(&run(&arguments));
    assert_eq!(csv.lines().next(), Some("name,record,unit,values,point,description"));
    assert!(csv.contains("\nVAC:CHAMBER:P,ai,mbar,,chamber.pressure,"), "{csv}");
    assert!(csv.contains("\nVAC:FORE_LINE:CH4:STATE,mbbi,"), "{csv}");
    assert!(std::fs::read_to_string(list).unwrap().lines().any(|line| line == "VAC:CHAMBER:P"));
    assert!(std::fs::read_to_string(&screen).unwrap().contains("<pv_name>VAC:CHAMBER:P</pv_name>"));
    std::fs::write(folder.path("other.toml"), format!("{PLANT}[prometheus]\n")).unwrap();
    let error = refusal(&run(&["names", &folder.name("other.toml"), "--for", "prometheus", "--bob", &screen]));
    assert!(error.contains("belong to --for epics"), "{error}");
}

#[test]
fn equal_names_of_epics_are_an_error_of_the_file_before_anything_starts() {
    let folder = Folder::new();
    let text = format!("{PLANT}[epics]\nname = '{{segment}}:{{signal}}'\n");
    std::fs::write(folder.path("plant.toml"), text).unwrap();
    for arguments in [
        &["run", &folder.name("plant.toml"), "--check", "--listen", "127.0.0.1:0"][..],
        &["names", &folder.name("plant.toml"), "--for", "epics"],
    ] {
        let error = refusal(&run(arguments));
        assert!(error.contains("both have the name hall:GAUGE_STATE"), "{error}");
    }
}
