//! `dump --out`, `diff` and `restore`: the settings of a gauge and its replacement.

use crate::gauge_commands::Line;
use serde_json::Value;
use std::fs;

/// The name of a file with the settings of the gauge at `address`.
fn dumped(line: &Line, address: u8) -> String {
    let file = line.folder.name("gauge.toml");
    let done = line.run("dump", address, &["--out", &file, "--force"]);
    assert_eq!((done.code, done.out.as_str()), (0, ""), "{}", done.err);
    assert!(done.err.ends_with(&format!("readings in {file}\n")), "{}", done.err);
    file
}

fn replaced(file: &str, old: &str, new: &str) {
    let text = fs::read_to_string(file).unwrap();
    assert!(text.contains(old), "no {old} in {text}");
    fs::write(file, text.replacen(old, new, 1)).unwrap();
}

#[test]
fn only_different_settings_are_written_to_a_replacement() {
    let line = Line::with(&["pcg550@5", "pcg550@6:unit=torr,serial=4711"]);
    line.output("write", 5, &["trip-point.1/low-trip-point", "2e-3 mbar"]);
    line.output("write", 5, &["trip-point.1/low-trip-point-hysteresis", "1e-4 mbar"]);
    line.output("write", 5, &["trip-point.2/setpoint-mode", "setpoint-mode-profibus-only"]);
    line.output("write", 5, &["trip-point.2/high-trip-enable", "on"]);
    line.output("write", 5, &["cdg.safe-state", "use-safe-value"]);
    let file = dumped(&line, 5);
    let done = line.run("diff", 5, &[&file]);
    assert_eq!((done.code, done.err.as_str()), (0, "profivac: no differences in 34 settings\n"));

    let would = line.run("restore", 6, &[&file, "--dry-run"]);
    assert_eq!(would.code, 0);
    let planned = "\
cdg.data-unit: Torr -> mbar
pirani.data-unit: Torr -> mbar
atm.data-unit: Torr -> mbar
trip-point.1/data-units: Torr -> mbar
trip-point.2/data-units: Torr -> mbar
cdg.safe-state: zero -> use-safe-value
trip-point.2/setpoint-mode: setpoint-mode -> setpoint-mode-profibus-only
trip-point.1/low-trip-point: 3.7503083e-5 Torr -> 1.5001234e-3 Torr
trip-point.1/low-trip-point-hysteresis: 3.7503085e-6 Torr -> 7.5006166e-5 Torr
trip-point.2/high-trip-enable: false -> true
";
    assert_eq!(would.out, planned);
    assert_eq!(would.err, "profivac: 10 of 34 settings differed and would be written\n");
    assert_eq!(line.output("read", 6, &["cdg.data-unit"]), "cdg.data-unit = Torr\n");

    // All instances share one unit, so it is written once.
    let done = line.run("restore", 6, &[&file]);
    let written = "\
cdg.data-unit: Torr -> mbar
cdg.safe-state: zero -> use-safe-value
trip-point.2/setpoint-mode: setpoint-mode -> setpoint-mode-profibus-only
trip-point.1/low-trip-point: 5e-5 mbar -> 2e-3 mbar
trip-point.1/low-trip-point-hysteresis: 5e-6 mbar -> 1e-4 mbar
trip-point.2/high-trip-enable: false -> true
";
    assert_eq!((done.code, done.out.as_str()), (0, written));
    assert_eq!(done.err, "profivac: 6 of 34 settings differed and were written\n");
    assert_eq!(line.run("restore", 6, &[&file]).err, "profivac: 0 of 34 settings differed and were written\n");
    assert_eq!(line.output("read", 6, &["serial-number"]), "device.serial-number = 4711\n");
}

#[test]
fn differences_are_shown_as_a_table_and_as_json() {
    let line = Line::with(&["img400@5"]);
    let file = dumped(&line, 5);
    line.output("write", 5, &["relay.1/low-trip-point", "1e-4 hPa"]);
    let table = "\
NAME                              FILE      GAUGE
relay.1/low-trip-point            1e-3 hPa  1e-4 hPa
relay.1/low-trip-upper-threshold  2e-3 hPa  1.1e-3 hPa
";
    // As diff(1): 1 with differences, 0 without.
    let done = line.run("diff", 5, &[&file]);
    assert_eq!((done.code, done.out.as_str(), done.err.as_str()), (1, table, ""));
    let done = line.run("diff", 5, &[&file, "--json"]);
    assert_eq!((done.code, done.err.as_str()), (1, ""));
    let rows: Vec<Value> = serde_json::from_str(&done.out).unwrap();
    let expected = serde_json::json!({"name": "relay.1/low-trip-point", "file": "1e-3 hPa", "gauge": "1e-4 hPa"});
    assert_eq!((rows.len(), &rows[0]), (2, &expected));
    let restored: Vec<Value> = serde_json::from_str(&line.output("restore", 5, &[&file, "--json"])).unwrap();
    assert_eq!((&restored[0]["before"], &restored[0]["after"]), (&"1e-4 hPa".into(), &"1e-3 hPa".into()));
    let done = line.run("diff", 5, &[&file, "--json"]);
    assert_eq!((done.code, done.out.as_str()), (0, "[]\n"));
    assert_eq!(line.run("diff", 5, &[&file]).code, 0);
}

/// Settings that change each other end as in the file.
#[test]
fn settings_that_change_each_other_are_all_restored() {
    let line = Line::with(&["img400@5", "img400@6"]);
    line.output("write", 5, &["relay.1/low-trip-point", "1e-4 hPa"]);
    line.output("write", 5, &["relay.1/hysteresis", "5e-5 hPa"]);
    let file = dumped(&line, 5);
    line.output("write", 6, &["relay.1/low-trip-point", "3e-3 hPa"]);
    line.output("write", 6, &["relay.1/hysteresis", "2e-3 hPa"]);
    line.output("restore", 6, &[&file]);
    assert_eq!(line.run("diff", 6, &[&file]).err, "profivac: no differences in 49 settings\n");
}

/// 1e-3 mbar and 500 mbar are 0 and 32767 as integers in Pascal.
#[test]
fn a_setting_that_integers_show_as_a_bound_is_left_out_and_keeps_its_value() {
    let line = Line::with(&["bcg450@5:unit=pascal", "bcg450@6:unit=pascal"]);
    for address in [5, 6] {
        line.output("write", address, &["pirani.safe-value", "0.1 Pascal"]);
        line.output("write", address, &["cdg.safe-value", "50000 Pascal"]);
        line.output("write", address, &["pirani.data-type", "integer"]);
    }
    assert_eq!(line.output("read", 5, &["cdg.safe-value"]), "cdg.safe-value = 32767 Pascal or more\n");
    let file = dumped(&line, 5);
    let done = line.run("restore", 6, &[&file]);
    assert_eq!((done.code, done.out.as_str()), (0, ""), "{}", done.err);
    for name in ["pirani.safe-value", "cdg.safe-value"] {
        assert!(done.err.contains("not in the file, because the integers") && done.err.contains(name), "{}", done.err);
    }
    line.output("write", 6, &["pirani.data-type", "float"]);
    assert_eq!(line.output("read", 6, &["pirani.safe-value"]), "pirani.safe-value = 0.1 Pascal\n");
    assert_eq!(line.output("read", 6, &["cdg.safe-value"]), "cdg.safe-value = 50000 Pascal\n");
}

#[test]
fn a_refused_setting_is_reported_and_the_others_are_written() {
    let line = Line::with(&["bcg450@5"]);
    let file = dumped(&line, 5);
    replaced(&file, "\"pirani.data-units\" = \"mbar\"", "\"pirani.data-units\" = \"Torr\"");
    replaced(&file, "\"ba.safe-state\" = \"zero\"", "\"ba.safe-state\" = \"full-scale\"");
    line.output("write", 5, &["execute"]);
    let done = line.run("restore", 5, &[&file]);
    assert_eq!(done.code, 1);
    let mut lines = done.out.lines();
    assert!(
        lines
            .next()
            .unwrap()
            .starts_with("pirani.data-units: mbar unchanged: bcg450 at address 5, pirani.data-units (slot 1"),
        "{}",
        done.out
    );
    assert_eq!((lines.next(), lines.next()), (Some("ba.safe-state: zero -> full-scale"), None));
    assert_eq!(done.err, "profivac: the gauge refused 1 of 2 differing settings\n");
}

#[test]
fn a_file_of_another_device_is_refused() {
    let line = Line::with(&["bcg450@5", "bpg400@6"]);
    let file = dumped(&line, 5);
    for command in ["diff", "restore"] {
        let other =
            format!("{file}: the file is of bcg450 with the ident number 0x08E6, the gauge is bpg400 with 0x06A9");
        line.fails(command, 6, &[&file], 2, &other);
    }
}

/// Gauges of a series have one ident number and different parts.
#[test]
fn a_file_of_another_gauge_of_the_series_is_refused() {
    let line = Line::with(&["pcg550@5", "pcg554@6"]);
    let file = dumped(&line, 5);
    for command in ["diff", "restore"] {
        let other = format!(
            "{file}: the file is of pcg550, the gauge is pcg554; if it replaces the other device, write device = \"pcg554\" in the file"
        );
        line.fails(command, 6, &[&file], 2, &other);
    }
    replaced(&file, "device = \"pcg550\"", "device = \"pcg554\"");
    assert_eq!(line.run("diff", 6, &[&file]).code, 0);
}

/// A gauge in IDLE sends its safe value, which looks like a pressure.
#[test]
fn a_dump_shows_why_a_pressure_is_not_valid() {
    let line = Line::with(&["--pressure", "5e-6 mbar", "bcg450@5"]);
    let lines = |target: &str| line.output("dump", 5, &[target]);
    let file = fs::read_to_string(dumped(&line, 5)).unwrap();
    assert!(file.contains("\"ba.process-value\" = \"0 mbar\"  # not valid: the gauge is in IDLE\n"), "{file}");
    assert!(lines("ba.process-value").contains("0 mbar  (not valid: the gauge is in IDLE)"), "{}", lines("ba.process"));
    line.output("write", 5, &["execute"]);
    let shown = lines("process-value");
    for (name, reason) in
        [("pirani", "5.5e-3 mbar  (not valid: under range)"), ("cdg", "1 mbar  (not valid: under range)")]
    {
        let name = format!("{name}.process-value");
        let row = shown.lines().find(|row| row.contains(&name)).unwrap();
        assert!(row.ends_with(reason), "{shown}");
    }
    assert!(shown.lines().any(|row| row.contains("ba.process-value") && row.ends_with("mbar")), "{shown}");
    let json: serde_json::Value =
        serde_json::from_str(&line.output("dump", 5, &["--json", "cdg.process-value"])).unwrap();
    assert_eq!((&json[0]["valid"], &json[0]["reason"]), (&false.into(), &"under range".into()));
}

#[test]
fn the_error_for_a_wrong_file_has_line_and_column_before_anything_is_written() {
    let line = Line::with(&["bcg450@5"]);
    let good = dumped(&line, 5);
    let text = fs::read_to_string(&good).unwrap();
    let bad = line.folder.name("bad.toml");
    for (old, new, sentence) in [
        ("\"pirani.safe-state\" = \"zero\"", "\"pirani.safe-state\" = ", "line 8, column 23: "),
        (
            "\"zero\"",
            "\"never\"",
            "line 8, column 23: pirani.safe-state (1:1/39): expected one of zero, full-scale, hold-last-value, use-safe-value, got \"never\"",
        ),
        (
            "\"pirani.safe-value\"",
            "\"pirani.save-value\"",
            "line 9, column 23: bcg450 has no parameter or command \"pirani.save-value\"; did you mean pirani.safe-value",
        ),
        (
            "\"pirani.safe-value\"",
            "\"pirani.process-value\"",
            "line 9, column 26: pirani.process-value is no setting of bcg450",
        ),
        ("device = ", "devize = ", "line 1, column 1: "),
    ] {
        fs::write(
            &bad,
            text.replacen("\"ba.safe-state\" = \"zero\"", "\"ba.safe-state\" = \"full-scale\"", 1)
                .replacen(old, new, 1),
        )
        .unwrap();
        let done = line.run("restore", 5, &[&bad]);
        assert_eq!((done.code, done.out.as_str()), (2, ""), "{new}: {}", done.err);
        assert!(done.err.starts_with(&format!("profivac: {bad}: {sentence}")), "{new}: {}", done.err);
    }
    assert_eq!(line.output("read", 5, &["ba.safe-state"]), "ba.safe-state = zero\n");
    let missing = line.run("diff", 5, &["/nowhere.toml"]);
    assert_eq!(missing.code, 2);
    assert!(missing.err.starts_with("profivac: /nowhere.toml cannot be read: No such file"), "{}", missing.err);
    let nowhere = line.run("dump", 5, &["--out", "/nowhere/gauge.toml"]);
    assert_eq!(nowhere.code, 2, "{}", nowhere.err);
}

/// A controller: sets of thresholds are opened and closed, and a notice names what is not stored.
#[test]
fn a_controller_is_restored_by_the_parameter_channel() {
    let line = Line::with(&["tpg300@5"]);
    let file = line.folder.name("gauge.toml");
    let pkw = ["--via", "pkw", "--own"];
    let with = |rest: &[&'static str]| [&pkw[..], rest].concat();
    assert_eq!(line.run("dump", 5, &[&pkw[..], &["--out", &file, "--force"]].concat()).code, 0);
    replaced(&file, "\"relay.2/upper-threshold\" = \"2e-3 mbar\"", "\"relay.2/upper-threshold\" = \"7e-3 mbar\"");
    replaced(&file, "\"a1.filter-time-constant\" = \"medium\"", "\"a1.filter-time-constant\" = \"slow\"");
    let done = line.run("restore", 5, &[&pkw[..], &[file.as_str()]].concat());
    let written = "a1.filter-time-constant: medium -> slow\nrelay.2/upper-threshold: 2e-3 mbar -> 7e-3 mbar\n";
    assert_eq!((done.code, done.out.as_str()), (0, written), "{}", done.err);
    assert!(
        done.err.contains("stores some of these settings only on request; send `profivac write ... store`"),
        "{}",
        done.err
    );
    let valid = line.output("read", 5, &with(&["relay.2/threshold-validation"]));
    assert_eq!(valid, "relay.2/threshold-validation = valid\n");
    assert_eq!(line.output("write", 5, &with(&["--yes", "store"])), "device.volatility: store done\n");
}

#[test]
fn a_settings_file_carries_units_and_its_pressures_lie_in_the_measuring_range() {
    let line = Line::with(&["bcg450@5"]);
    let file = dumped(&line, 5);
    let text = fs::read_to_string(&file).unwrap();
    let row = text.lines().position(|line| line.starts_with("\"pirani.safe-value\"")).unwrap() + 1;
    let fails = |command, value: &str, rest: &[&str], sentence: &str| {
        fs::write(
            &file,
            text.replace("\"pirani.safe-value\" = \"0 mbar\"", &format!("\"pirani.safe-value\" = \"{value}\"")),
        )
        .unwrap();
        let done = line.run(command, 5, &[&[file.as_str()][..], rest].concat());
        assert_eq!((done.code, done.out.as_str()), (2, ""), "{}", done.err);
        let place = format!("profivac: {file}: line {row}, column 23: pirani.safe-value (1:1/40): ");
        assert_eq!(done.err, format!("{place}{sentence}\n"));
    };
    let unitless = "expected a pressure of 0 or more with its unit, such as '1500 mbar', got \"2\" without a unit; in the present \
                    unit of the gauge it is '2 mbar'";
    fails("diff", "2", &[], unitless);
    fails("restore", "2", &["--force"], unitless);
    let beyond = "1e9 mbar is outside the measuring range, which is 5e-10 mbar to 1500 mbar; to write it all the same add --force";
    fails("restore", "1e9 mbar", &[], beyond);
    fails("restore", "1e9 mbar", &["--dry-run"], beyond);
    assert_eq!(line.output("restore", 5, &[&file, "--force"]), "pirani.safe-value: 0 mbar -> 1e9 mbar\n");
    // What the gauge already has is no error: nothing is written.
    assert_eq!(line.run("restore", 5, &[&file]).code, 0);
}

/// The file of a gauge that was replaced may be the only memory of it.
#[test]
fn a_dump_overwrites_a_file_only_with_force() {
    let line = Line::with(&["bcg450@5"]);
    let file = dumped(&line, 5);
    fs::write(&file, "mine").unwrap();
    let again = line.run("dump", 5, &["--out", &file]);
    let sentence = format!(
        "profivac: {file} exists already and was not changed; choose another name, or add --force to overwrite it\n"
    );
    assert_eq!((again.code, again.err), (2, sentence));
    assert_eq!(fs::read_to_string(&file).unwrap(), "mine");
    assert_eq!(line.run("dump", 5, &["--out", &file, "--force"]).code, 0);
    assert!(fs::read_to_string(&file).unwrap().contains("bcg450"));
}
