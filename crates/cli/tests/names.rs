//! `profivac names`: what a gateway publishes, without a bus.

#![allow(clippy::unwrap_used, clippy::panic, clippy::indexing_slicing, reason = "a test")]

use crate::common::{Folder, run};
use serde_json::Value;
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

/// The output for a plant with these tables of gateways.
fn names(tables: &str, arguments: &[&str]) -> Output {
    let folder = Folder::new();
    std::fs::write(folder.path("plant.toml"), format!("{PLANT}{tables}")).unwrap();
    run(&[&["names", &folder.name("plant.toml")], arguments].concat())
}

fn stdout(output: &Output) -> String {
    assert_eq!(output.status.code(), Some(0), "{}", String::from_utf8_lossy(&output.stderr));
    String::from_utf8(output.stdout.clone()).unwrap()
}

fn refusal(output: &Output) -> String {
    assert_eq!(output.status.code(), Some(2));
    assert!(output.stdout.is_empty());
    String::from_utf8(output.stderr.clone()).unwrap()
}

#[test]
fn the_table_names_every_metric_with_its_labels() {
    let text = stdout(&names("[prometheus]\n", &["--for", "prometheus"]));
    let line = |name: &str, label: &str| {
        let found = text.lines().find(|line| line.starts_with(name) && line.contains(label));
        found.unwrap_or_else(|| panic!("no {name} with {label} in\n{text}"))
    };
    assert!(text.starts_with("NAME "), "{text}");
    assert!(line("profivac_reading_pressure_pascals ", "gauge=\"chamber\"").contains("segment=\"hall\""));
    line("profivac_reading_pressure_pascals ", "gauge=\"fore line\",channel=\"4\"");
    assert!(line("profivac_reading_state ", "gauge=\"chamber\"").contains("ok under_range over_range off"));
}

#[test]
fn csv_and_json_have_the_same_rows() {
    let csv = stdout(&names("[prometheus]\n", &["--for", "prometheus", "--csv"]));
    let json: Vec<Value> =
        serde_json::from_str(&stdout(&names("[prometheus]\n", &["--for", "prometheus", "--json"]))).unwrap();
    assert_eq!(csv.lines().next(), Some("name,labels,kind,unit,values,signal,description"));
    assert_eq!(csv.lines().count(), json.len() + 1);
    assert_eq!(json[0]["name"].as_str(), csv.lines().nth(1).and_then(|line| line.split(',').next()));
}

#[test]
fn a_gateway_without_a_table_is_wrong_usage_and_the_error_says_what_to_add() {
    let error = refusal(&names("[prometheus]\n", &["--for", "epics"]));
    assert!(error.contains("plant.toml has no table [epics]") && error.contains("add the table"), "{error}");
    let error = refusal(&names("", &["--for", "ethercat"]));
    assert!(error.contains("epics") && error.contains("prometheus"), "{error}");
}

#[test]
fn the_map_of_modbus_has_a_row_for_each_register_of_a_slot() {
    let csv = stdout(&names("[modbus]\n", &["--for", "modbus", "--csv"]));
    assert_eq!(csv.lines().next(), Some("register,type,subject,name,unit,description"));
    assert!(csv.contains("\n100,float32,chamber,pressure,Pa,"), "{csv}");
    assert!(csv.contains("\n120,float32,fore line.1,pressure,Pa,"), "{csv}");
}

#[test]
fn gauges_that_do_not_fit_into_the_map_of_modbus_are_a_bad_file() {
    let folder = Folder::new();
    let plant = PLANT.replace("\"tpg300\"", "\"tpg300\"\nmodbus = 3").replace("\"bcg450\"", "\"bcg450\"\nmodbus = 5");
    std::fs::write(folder.path("plant.toml"), format!("{plant}[modbus]\n")).unwrap();
    let error = refusal(&run(&["names", &folder.name("plant.toml"), "--for", "modbus"]));
    assert!(error.contains("belongs to \"chamber\"") && error.contains("with the key modbus"), "{error}");
    let checked = refusal(&run(&["run", &folder.name("plant.toml"), "--check", "--listen", "127.0.0.1:0"]));
    assert!(checked.contains(error.trim()), "{checked}");
}
