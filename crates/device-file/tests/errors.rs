//! What a wrong file is told: the position, and what to do.

use profivac_device_file::{DeviceFile, MAX_OCTETS};
use std::fs;
use std::path::Path;

/// The smallest device.
const SMALL: &str = r#"format = 1
name = "small"
title = "Small"
vendor = "Nobody"
manual = "none"
ident = 0x1234
units = [{ code = 1, name = "mbar", per-mbar = 1.0 }]
user-parameters = [{ name = "none", octets = "" }]
configurations = [{ inputs = 4, octets = "42 84 05 08" }]
[inputs]
4 = ["exception-status", "process-value float"]
[codes.mode]
names = [{ code = 0, name = "off" }, { code = 1, name = "on" }]
[[block]]
name = "Device Block"
at = [{ slot = 0, name = "Device" }]
parameters = [
  { index = 15, name = "Mode", type = "UINT8", access = "1/2_R/W", store = "N", section = "3.1", codes = "mode" },
]
"#;

fn said(text: &str) -> String {
    DeviceFile::parse(text).map(|file| file.name().to_owned()).unwrap_or_else(|error| error.to_string())
}

/// What is said about the small device in which `old` is `new`.
fn changed(old: &str, new: &str) -> String {
    assert_eq!(SMALL.matches(old).count(), 1, "{old}");
    said(&SMALL.replace(old, new))
}

#[test]
fn the_smallest_device_is_read() {
    assert_eq!(said(SMALL), "small");
}

#[test]
fn a_wrong_value_has_its_position_and_the_right_ones() {
    for (old, new, expected) in [
        ("format = 1", "format = 2", "device file:1:10: this profivac reads format 1, found 2: use a newer profivac"),
        ("format = 1\n", "", "device file:1:1: expected the key format = 1; add it as the first line"),
        (
            "[inputs]",
            "[gsd]\nmax-diagnosis-octets = 5\n[inputs]",
            "device file:11:24: expected 6 to 244 octets of diagnosis, found 5",
        ),
        (
            "4 = [\"exc",
            "04 = [\"exc",
            "device file:11:6: expected the number of a telegram from 0 to 255 without leading zeros, found \"04\"",
        ),
        (
            "\"small\"",
            "\"Small\"",
            "device file:2:8: expected a name of at most 32 small letters, digits and hyphens, found \"Small\"",
        ),
        (
            "\"small\"",
            "\"small-sp\"",
            "device file:2:8: a name ends without -sp: write \"small\"; title has the name on the device",
        ),
        (
            "\"small\"",
            "\"bcg-450\"",
            "device file:2:8: \"bcg-450\" is the name of a device that profivac has (BCG450-SP); choose another, for instance \
             \"my-bcg-450\"",
        ),
        (
            "vendor = \"Nobody\"\n",
            "",
            "device file:2:8: expected the key vendor; add it, or name a device with like that has it",
        ),
        ("0x1234", "70000", "device file:6:9: invalid value: integer `70000`, expected u16"),
        (
            "units = [{ code",
            "units = [{ cod",
            "device file:7:12: unknown field `cod`, expected one of `code`, `name`, `alias`, `per-mbar`; did you mean `code`?",
        ),
        (
            "per-mbar = 1.0",
            "per-mbar = -1.0",
            "device file:7:48: expected the number of units for one mbar, from 1e-9 to 1e9",
        ),
        ("inputs = 4,", "inputs = 5,", "device file:9:30: expected a telegram of [inputs], one of: 4; found 5"),
        (
            "42 84 05 08",
            "42 85 05 08",
            "device file:9:42: the octets do not announce the telegrams, which have 0 octets of outputs and 5 of inputs; in the special \
             format these fields are \"42 84 05 08\"; compare octets and fields with the manual",
        ),
        (
            "42 84 05 08",
            "42 84 05 0x8",
            "device file:9:42: expected octets as hexadecimal pairs like \"44 86 05\", found \"42 84 05 0x8\"",
        ),
        ("\"UINT8\"", "\"UINT9\"", "device file:18:39: expected a type, one of: BOOLEAN, INT8,"),
        ("\"1/2_R/W\"", "\"1/2_X\"", "device file:18:57: expected the access marks of the manual, of: 0_XI,"),
        (
            "store = \"N\"",
            "store = \"Q\"",
            "device file:18:76: expected a store class, one of: N, V, R, D, -; found \"Q\"",
        ),
        (
            "codes = \"mode\"",
            "codes = \"mod\"",
            "device file:18:106: expected a table of [codes], \"units\" or \"version\"; found \"mod\"; did you mean \"mode\"?",
        ),
        (
            "codes = \"mode\"",
            "codes = \"mode\", range = [0, 1]",
            "device file:18:3: a parameter has one of codes, range and per-mille; delete the others",
        ),
        (
            "\"exception-status\"",
            "\"exception-stats\"",
            "device file:11:6: expected a field, one of: parameter-channel,",
        ),
        (
            "{ code = 1, name = \"on\" }",
            "{ code = 0, name = \"on\" }",
            "device file:13:38: the code 0 is here twice; delete one of both",
        ),
        (
            "title = \"Small\"",
            "title = \"Sm\\u0007all\"",
            "device file:3:9: expected a text without control characters, found \"Sm\\u{7}all\"",
        ),
        (
            "title = \"Small\"",
            "title = 'Sm\"all'",
            "device file:3:9: expected a text without quotation marks, which end it in a GSD file; found \"Sm\\\"all\"",
        ),
        (
            "at = [{ slot = 0, name = \"Device\" }]\n",
            "",
            "device file:15:8: expected the locations of the block: at = [{ slot = 0, name = \"Device\" }], or at = [] if the device does not have it",
        ),
        (
            "title = \"Small\"",
            "title = \"Small\"\nbehaviour = \"bcg450\"",
            "device file:4:13: the behaviour of bcg450 expects the block \"One Of N Analog Input Function Block\" here: begin with",
        ),
        (
            "title = \"Small\"",
            "title = \"Small\"\nbehaviour = \"bcg451\"",
            "device file:4:13: expected a device that profivac has, one of: pcg550,",
        ),
        (
            "\"Device Block\"",
            "\"Device Block\"\nwithout = [3]",
            "device file:16:12: without is for a file with like; delete it",
        ),
    ] {
        let found = changed(old, new);
        assert!(found.starts_with(expected), "{new}\n found {found}\nwanted {expected}");
    }
}

#[test]
fn an_index_is_in_a_block_once_and_a_block_in_a_file_once() {
    let row = "  { index = 15, name = \"Mode\", type = \"UINT8\", access = \"1/2_R/W\", store = \"N\", section = \"3.1\", codes = \"mode\" },\n";
    let found = changed(row, &row.repeat(2));
    assert_eq!(found, "device file:19:3: index 15 is in this block twice; delete one row");
    let block = SMALL.split_once("[[block]]").unwrap().1;
    let found = said(&format!("{SMALL}[[block]]{block}"));
    assert_eq!(found, "device file:21:8: the block \"Device Block\" is here twice; give each a name of its own");
    let other = block.replace("Device Block", "Other").replace("UINT8", "UINT16");
    let found = said(&format!("{SMALL}[[block]]{other}"));
    assert_eq!(found, "device file:24:3: slot 0, instance 0, index 15 is UINT8 in an earlier block and UINT16 here");
    // Slot and index alone address a record: instance 0 and instance 1 would be the same one.
    let other = block.replace("Device Block", "Other").replace("slot = 0,", "slot = 0, instance = 1,");
    let found = said(&format!("{SMALL}[[block]]{other}"));
    assert!(
        found.starts_with(
            "device file:24:3: slot 0, index 15 is of instance 0 in an earlier block and of instance 1 here: "
        ),
        "{found}"
    );
}

fn read(path: &Path) -> String {
    DeviceFile::read(path).map(|file| file.name().to_owned()).unwrap_or_else(|error| error.to_string())
}

#[test]
fn a_file_above_one_mebibyte_and_what_is_no_file_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("large.toml");
    let largest = format!("{SMALL}#{}", " ".repeat(MAX_OCTETS as usize - SMALL.len() - 1));
    fs::write(&path, &largest).unwrap();
    assert_eq!(read(&path), "small");
    fs::write(&path, largest + " ").unwrap();
    let large = read(&path);
    assert!(
        large.ends_with("large.toml: the file cannot be read: expected a text of at most 1048576 octets, got more"),
        "{large}"
    );
    let device = read(Path::new("/dev/zero"));
    assert_eq!(device, "/dev/zero: expected a file, found a folder or a device of the system; check the path");
    let missing = read(&folder.path().join("missing.toml"));
    assert!(missing.contains("missing.toml: the file cannot be read: "), "{missing}");
}

#[test]
fn files_that_are_like_each_other_in_a_circle_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    for (name, like) in [("a", "b"), ("b", "a")] {
        let text = format!(
            "format = 1\nname = {name:?}\ntitle = {name:?}\nlike = \"../{}/{like}.toml\"\n",
            folder.path().file_name().unwrap().to_str().unwrap()
        );
        fs::write(folder.path().join(format!("{name}.toml")), text).unwrap();
    }
    let found = read(&folder.path().join("a.toml"));
    assert!(found.contains("b.toml:4:8: the devices are like each other in a circle: "), "{found}");
    assert!(found.ends_with("a.toml; delete one like"), "{found}");
}

#[test]
fn a_long_chain_of_files_is_refused() {
    let folder = tempfile::tempdir().unwrap();
    for number in 0..20 {
        let text = format!("format = 1\nname = \"g{number}\"\ntitle = \"G\"\nlike = \"g{}.toml\"\n", number + 1);
        fs::write(folder.path().join(format!("g{number}.toml")), text).unwrap();
    }
    let found = read(&folder.path().join("g0.toml"));
    assert!(found.ends_with("g7.toml:4:8: expected at most 8 devices of which each is like the next"), "{found}");
}
