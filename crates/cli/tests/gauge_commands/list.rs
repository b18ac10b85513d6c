//! `list` and `dump`: the complete tree.

use crate::common::run;
use crate::gauge_commands::{Line, compare};
use serde_json::Value;

const DEVICES: [&str; 12] = [
    "pcg550", "pcg552", "pcg554", "psg550", "psg552", "psg554", "bpg400", "hpg400", "bcg450", "tpg300", "tpg500",
    "img400",
];

fn listed(arguments: &[&str]) -> (Option<i32>, String, String) {
    let output = run(&[&["list"], arguments].concat());
    let text = |octets| String::from_utf8(octets).unwrap();
    (output.status.code(), text(output.stdout), text(output.stderr))
}

#[test]
fn every_device_is_listed_without_a_bus() {
    for device in DEVICES {
        let (code, printed, message) = listed(&["--device", device]);
        assert_eq!(code, Some(0), "{message}");
        // Other tests cover the differences between the gauges of a series.
        if ["pcg550", "psg550", "bpg400", "hpg400", "bcg450", "tpg300", "img400"].contains(&device) {
            compare(&format!("list/{device}.txt"), &printed);
        }
        let (_, json, _) = listed(&["--device", device, "--json"]);
        let rows: Vec<Value> = serde_json::from_str(&json).unwrap();
        assert_eq!(rows.len(), printed.lines().filter(|line| line.starts_with("  ")).count(), "{device}");
    }
}

#[test]
fn a_gauge_on_the_bus_is_recognised() {
    let line = Line::with(&["psg554@5", "pcg552@6:atm=off"]);
    let printed = line.output("list", 5, &["trip-point.2"]);
    assert!(
        printed.starts_with(
            "psg554 (PSG554, tira56e1 at address 5)\n\nslot 3: Trip Point 2 - Trip Point Function Block\n"
        ),
        "{printed}"
    );
    let rows: Vec<Value> = serde_json::from_str(&line.output("list", 6, &["--json", "setpoint-mode"])).unwrap();
    assert_eq!(rows.len(), 2);
    assert_eq!((&rows[0]["name"], &rows[0]["section"]), (&"trip-point.1/setpoint-mode".into(), &"11.2.13".into()));
    assert_eq!(rows[0]["codes"][1]["name"], "low-trip-point-by-atmosphere");
}

#[test]
fn an_unknown_name_cannot_be_listed() {
    let (code, _, message) = listed(&["--device", "bcg450", "zzz"]);
    assert_eq!(
        (code, message.as_str()),
        (Some(2), "profivac: bcg450 has no parameter or command \"zzz\"; `profivac list` shows all\n")
    );
    let (code, _, message) = listed(&["--device", "bcg451"]);
    assert_eq!(code, Some(2));
    assert!(message.starts_with("profivac: unknown device \"bcg451\"; known: pcg550, "), "{message}");
    for incomplete in
        [&[][..], &["--port", "/tmp/line"], &["--address", "5"], &["--device", "bcg450", "--port", "/tmp/line"]]
    {
        let (code, _, message) = listed(incomplete);
        assert_eq!(code, Some(2), "{incomplete:?}: {message}");
    }
}

#[test]
fn a_dump_has_every_value() {
    let line = Line::with(&["bcg450@5", "pcg550@6", "img400@7", "bpg400@8"]);
    for (address, device) in [(5, "bcg450"), (6, "pcg550"), (7, "img400"), (8, "bpg400")] {
        compare(&format!("dump/{device}.txt"), &line.output("dump", address, &[]));
    }
    let rows: Vec<Value> = serde_json::from_str(&line.output("dump", 5, &["--json", "safe"])).unwrap();
    assert_eq!(rows.len(), 6);
    assert_eq!((&rows[0]["name"], &rows[0]["text"]), (&"pirani.safe-state".into(), &"zero".into()));
    assert_eq!((&rows[0]["setting"], &rows[0]["error"]), (&true.into(), &Value::Null));
}

#[test]
fn a_controller_without_acyclic_services_is_dumped_by_the_parameter_channel() {
    let line = Line::with(&["tpg500@6"]);
    line.fails(
        "dump",
        6,
        &[],
        1,
        "tpg300 or tpg500 at address 6: no parameter of it can be read by this service; say --via pkw",
    );
    compare("dump/tpg500.txt", &line.output("dump", 6, &["--via", "pkw", "--own"]));
}
