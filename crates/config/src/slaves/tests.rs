//! Slaves by their GSD files: what a file gives, and errors with positions.

use crate::{Config, ConfigError, parse};
use profivac_recorder::PointKind;
use profivac_station::alarm::{Condition, PointTest, Priority};
use profivac_station::config::{PointType, Slave, SlavePoint, WatchedRecord};
use std::fs;
use tempfile::TempDir;

const GSD: &str = "#Profibus_DP
Vendor_Name = \"Invented\"
Model_Name = \"Pump 1\"
Ident_Number = 0x0FA1
Modular_Station = 1
Max_Module = 4
Max_Input_Len = 16
Max_Output_Len = 4
Max_Data_Len = 20
Max_User_Prm_Data_Len = 1
Ext_User_Prm_Data_Ref(0) = 1
PrmText = 1
Text(0) = \"stop\"
Text(1) = \"keep\"
EndPrmText
ExtUserPrmData = 1 \"Without bus\"
Unsigned8 0 0-1
Prm_Text_Ref = 1
EndExtUserPrmData
Module = \"Speed\" 0x53
1
EndModule
Module = \"Control\" 0x21
2
EndModule
Module = \"Status\" 0x10
3
EndModule
SlotDefinition
Slot(1) = \"first\" 1 1
Slot(2) = \"second\" 2 2,3
Slot(3) = \"third\" 3 2,3
EndSlotDefinition
";

const FILE: &str = r#"[[segment]]
name = "hall"
port = "/dev/ttyUSB0"

[[segment.slave]]
name = "turbo"
address = 12
gsd = "pump.gsd"
modules = [1, "Control", 3]
parameters = { "Without bus" = "keep" }
own = true
outputs = "01 FF"

[[segment.slave.point]]
name = "speed"
slot = 1
octet = 2
type = "u16"
unit = "Hz"

[[segment.slave.point]]
name = "state"
module = "Status"
bit = 3
type = "bool"
texts = { 0 = "stopped", 1 = "running" }
"#;

fn folder() -> TempDir {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("pump.gsd"), GSD).unwrap();
    folder
}

fn read_in(folder: &TempDir, text: &str) -> Result<Config, ConfigError> {
    parse(text, &folder.path().join("hall.toml"))
}

fn slave(text: &str) -> Slave {
    read_in(&folder(), text).unwrap().segments[0].slaves[0].clone()
}

/// Line and column of the error, and its sentence.
fn error(text: &str) -> (String, String) {
    let error = read_in(&folder(), text).unwrap_err();
    (format!("{}:{}", error.line, error.column), error.problem.to_string())
}

#[test]
fn a_slave_has_the_octets_of_its_modules_and_parameters_and_the_places_of_its_points() {
    let slave = slave(FILE);
    assert_eq!((slave.name.as_str(), slave.address, slave.model().as_str()), ("turbo", 12, "Invented Pump 1"));
    assert_eq!(slave.gsd.chk_cfg(), [0x53, 0x21, 0x10]);
    assert_eq!(slave.gsd.user_prm(), [1]);
    assert_eq!((slave.is_owned, slave.outputs.as_slice(), slave.inputs()), (true, &[0x01, 0xFF][..], 9));
    let [speed, state] = slave.points.as_slice() else { panic!("{:?}", slave.points) };
    assert_eq!((speed.octet, speed.kind, speed.unit), (2, PointType::U16, Some("Hz")));
    assert_eq!(speed.place, "slot 1 Speed octet 2");
    // The status follows the eight octets of the speed.
    assert_eq!((state.octet, state.bit, state.place.as_str()), (8, 3, "slot 3 Status octet 0 bit 3"));
    assert_eq!(state.texts, [(0, "stopped".to_owned()), (1, "running".to_owned())]);
}

/// The file with MS2 in the GSD file, without ownership, and with a point in a record.
fn with_record(keys: &str) -> (TempDir, String) {
    let folder = folder();
    fs::write(
        folder.path().join("pump.gsd"),
        GSD.replace("Modular_Station", "C2_Read_Write_supp = 1\nModular_Station"),
    )
    .unwrap();
    let file = FILE.replace("own = true\noutputs = \"01 FF\"\n", "");
    (folder, format!("{file}\n[[segment.slave.point]]\nname = \"hours\"\ntype = \"u32\"\n{keys}\n"))
}

#[test]
fn a_point_may_be_in_a_record() {
    let place = |keys: &str| {
        let (folder, text) = with_record(keys);
        let slave = read_in(&folder, &text).unwrap().segments[0].slaves[0].clone();
        let [.., point] = slave.points.as_slice() else { panic!("{:?}", slave.points) };
        let WatchedRecord { slot, index, every } = point.record.unwrap();
        (slot, index, every.as_secs(), point.octet, point.place.clone())
    };
    assert_eq!(place("record = \"1/24\""), (1, 24, 10, 0, "record 1/24 octet 0".to_owned()));
    assert_eq!(
        place("record = \"0/254\"\nevery = \"1 min\"\noctet = 236"),
        (0, 254, 60, 236, "record 0/254 octet 236".to_owned())
    );
    for (keys, part) in [
        (
            "record = \"1/255\"",
            "expected a record as \"SLOT/INDEX\" like \"1/24\", each from 0 to 254, found \"1/255\"",
        ),
        ("record = \"24\"", "found \"24\""),
        ("record = \"1/24\"\nslot = 1", "expected record, or slot or module, found both"),
        ("record = \"1/24\"\nevery = \"0.5 s\"", "expected a time from 1 s to 1 h"),
        ("record = \"1/24\"\noctet = 237", "record 1/24 has the octets 0 to 239"),
        ("slot = 1\nevery = \"10 s\"", "expected every only with record"),
    ] {
        let (folder, text) = with_record(keys);
        let sentence = read_in(&folder, &text).unwrap_err().problem.to_string();
        assert!(sentence.contains(part), "{keys}: {sentence}");
    }
    let (folder, text) = with_record("record = \"1/24\"");
    let refused = |folder: &TempDir, text: &str| read_in(folder, text).unwrap_err().problem.to_string();
    let owned = text.replace("modules = [1", "own = true\noutputs = \"00 00\"\nmodules = [1");
    assert!(refused(&folder, &owned).contains("own = false"));
    let listening = text.replace("port = \"/dev/ttyUSB0\"\n", "port = \"/dev/ttyUSB0\"\nlisten-only = true\n");
    assert!(refused(&folder, &listening).contains("listen-only = true sends nothing"));
    fs::write(folder.path().join("pump.gsd"), GSD).unwrap();
    assert!(refused(&folder, &text).contains("C2_Read_Write_supp"));
}

/// The file with these outputs instead of octets.
fn with_outputs(keys: &str, outputs: &str) -> String {
    let file = FILE.replace("outputs = \"01 FF\"\n", keys);
    format!("{file}\n{outputs}")
}

fn output(name: &str, keys: &str) -> String {
    format!("[[segment.slave.output]]\nname = \"{name}\"\n{keys}\n")
}

#[test]
fn outputs_may_be_given_by_name_with_value_and_unit() {
    let speed =
        |value: &str| output("set speed", &format!("type = \"u16\"\nscale = 0.1\nunit = \"Hz\"\nvalue = {value}"));
    assert_eq!(slave(&with_outputs("", &speed("\"900 Hz\""))).outputs, [0x23, 0x28]);
    assert_eq!(slave(&with_outputs("", &speed("\"0.1Hz\""))).outputs, [0, 1]);
    let little = output("set", "type = \"i16\"\norder = \"little\"\nvalue = -2");
    assert_eq!(slave(&with_outputs("", &little)).outputs, [0xFE, 0xFF]);
    let texts = "octet = 0\ntype = \"u8\"\ntexts = { 0 = \"stop\", 5 = \"run\" }\nvalue = \"run\"";
    let (mode, bit) = (output("mode", texts), output("vent", "octet = 1\ntype = \"bool\"\nbit = 6\nvalue = \"on\""));
    let named = format!("{mode}{bit}");
    assert_eq!(slave(&with_outputs("outputs = \"FF 01\"\n", &named)).outputs, [5, 0x41], "over the octets");
    let off = bit.replace("\"on\"", "false");
    assert_eq!(slave(&with_outputs("outputs = { 2 = \"FF FF\" }\n", &off)).outputs, [0xFF, 0xBF]);
}

#[test]
fn a_wrong_output_by_name_has_its_place_and_what_is_possible() {
    let speed =
        |value: &str| output("set speed", &format!("type = \"u16\"\nscale = 0.1\nunit = \"Hz\"\nvalue = {value}"));
    let range = "expected a number with its unit from \"0 Hz\" to \"6553.5 Hz\", in steps of 0.1, found";
    let bit =
        |bit: u8| output(&format!("bit {bit}"), &format!("octet = 1\ntype = \"bool\"\nbit = {bit}\nvalue = \"on\""));
    let octet = output("low", "octet = 1\ntype = \"u8\"\nvalue = 1");
    let of_input = FILE.replace("octet = 2\n", "octet = 2\nvalue = 1\n");
    for (text, place, part) in [
        (with_outputs("", &speed("900")), "32:9", range),
        (with_outputs("", &speed("\"900 rpm\"")), "32:9", range),
        (with_outputs("", &speed("\"-1 Hz\"")), "32:9", range),
        (with_outputs("", &speed("\"0.15 Hz\"")), "32:9", range),
        (with_outputs("", &speed("true")), "32:9", range),
        (with_outputs("", &output("x", "type = \"u8\"")), "28:8", "expected the key value, found none"),
        (
            with_outputs("", &output("x", "slot = 3\ntype = \"u8\"\nvalue = 1")),
            "29:8",
            "modules with outputs: slot 2 Control",
        ),
        (with_outputs("", &output("x", "octet = 2\ntype = \"u8\"\nvalue = 1")), "29:9", "has the octets 0 to 1"),
        (with_outputs("", &octet), "11:7", "these outputs have no value: slot 2 Control octet 0;"),
        (
            with_outputs("", &format!("{}{}", bit(0), bit(7))),
            "11:7",
            "octet 0, slot 2 Control octet 1 bits 1, 2, 3, 4, 5, 6;",
        ),
        (
            with_outputs("outputs = \"00 00\"\n", &format!("{octet}{}", bit(3))),
            "34:8",
            "\"bit 3\" takes bits that another output has",
        ),
        (with_outputs("", &octet).replace("own = true\n", ""), "27:8", "outputs need own = true"),
        (of_input, "18:9", "value only in [[segment.slave.output]]"),
    ] {
        let (found, sentence) = error(&text);
        assert!(sentence.contains(part), "{text}: {sentence}");
        assert_eq!(found, place, "{text}: {sentence}");
    }
}

#[test]
fn a_number_has_the_deadband_of_the_file_and_a_code_has_none() {
    let slave = slave(&FILE.replace("unit = \"Hz\"", "unit = \"Hz\"\ndeadband = 0.5"));
    assert_eq!(slave.points.iter().map(|point| point.deadband).collect::<Vec<_>>(), [0.5, 0.0]);
    let kinds: Vec<_> = slave.points.iter().map(|point| point.recorded("turbo").kind).collect();
    assert_eq!(kinds, [PointKind::Number, PointKind::Code]);
}

#[test]
fn outputs_may_be_given_by_slot() {
    assert_eq!(slave(&FILE.replace("\"01 FF\"", "{ 2 = \"0A 0B\" }")).outputs, [0x0A, 0x0B]);
}

#[test]
fn a_slave_that_is_not_owned_needs_no_outputs() {
    let slave = slave(&FILE.replace("own = true\noutputs = \"01 FF\"\n", ""));
    assert_eq!((slave.is_owned, slave.outputs.len()), (false, 0));
}

#[test]
fn an_owned_slave_with_outputs_is_refused_without_explicit_outputs() {
    let (place, sentence) = error(&FILE.replace("outputs = \"01 FF\"\n", ""));
    assert_eq!(place, "11:7");
    assert!(
        sentence.contains("slot 2 Control (2 octets)") && sentence.contains("set outputs to 2 octets"),
        "{sentence}"
    );
    let without = FILE.replace("outputs = \"01 FF\"\n", "").replace("\"Control\"", "3").replace("[1, 3, 3]", "[1, 3]");
    let without = without.replace("module = \"Status\"\n", "slot = 2\n");
    assert!(slave(&without).is_owned, "a slave without outputs needs none");
}

#[test]
fn an_error_has_the_place_in_the_file_and_what_is_possible() {
    for (from, to, place, parts) in [
        ("[1, \"Control\", 3]", "[1, 7]", "9:11", &["no module 7", "1 (Speed)", "3 (Status)"][..]),
        ("[1, \"Control\", 3]", "[1, \"Contrl\"]", "9:11", &["no module \"Contrl\"", "did you mean \"Control\"?"]),
        ("[1, \"Control\", 3]", "[2, 1]", "9:11", &["slot 1", "it takes 1 (Speed)"]),
        ("\"keep\"", "\"jump\"", "10:16", &["Without bus cannot be jump", "0 (stop), 1 (keep)"]),
        ("\"keep\"", "2", "10:16", &["Without bus cannot be 2", "0 (stop), 1 (keep)"]),
        ("\"Without bus\" =", "\"With bus\" =", "10:16", &["no parameter With bus", "Without bus"]),
        ("\"01 FF\"", "\"01\"", "12:11", &["expected 2 octets of outputs for slot 2 Control", "found 1"]),
        ("\"01 FF\"", "\"0X FF\"", "12:11", &["hexadecimal", "0X FF"]),
        ("\"01 FF\"", "{ 1 = \"00\" }", "12:11", &["slot 1 has no module with outputs", "slot 2 Control (2 octets)"]),
        ("\"01 FF\"", "{}", "12:11", &["the outputs of slot 2 Control (2 octets) are missing"]),
        ("own = true", "own = false", "12:11", &["outputs need own = true"]),
        ("pump.gsd", "none.gsd", "8:7", &["none.gsd"]),
        ("slot = 1", "slot = 2", "16:8", &["\"speed\"", "slot 1 Speed, slot 3 Status"]),
        ("slot = 1\n", "", "15:8", &["several modules", "say slot", "slot 1 Speed, slot 3 Status"]),
        ("\"Status\"", "\"State\"", "23:10", &["\"state\"", "slot 1 Speed, slot 3 Status"]),
        ("octet = 2", "octet = 7", "17:9", &["needs the octets 7 to 8", "slot 1 Speed has the octets 0 to 7"]),
        ("\"u16\"", "\"u24\"", "18:8", &["one of bool, u8, i8, u16", "\"u24\""]),
        ("bit = 3", "bit = 8", "24:7", &["a bit from 0 to 7, found 8"]),
        ("bit = 3\n", "", "24:8", &["the key bit"]),
        ("unit = \"Hz\"", "order = \"middle\"", "19:9", &["big or little", "middle"]),
        ("unit = \"Hz\"", "scale = inf", "19:9", &["expected a number, found inf"]),
        ("unit = \"Hz\"", "scale = 0", "19:9", &["a number other than 0", "found 0"]),
        (
            "unit = \"Hz\"",
            "texts = { 65536 = \"fast\" }",
            "19:11",
            &["a code of the type", "65536", "u16 has 0 to 65535"],
        ),
        ("unit = \"Hz\"", "texts = { 1 = \"slow\", 01 = \"fast\" }", "19:23", &["a whole number as code", "01"]),
        ("1 = \"running\"", "2 = \"running\"", "26:26", &["a code of the type", "bool has 0 to 1"]),
        ("unit = \"Hz\"", "deadband = -1.0", "19:12", &["a number that is not negative, found -1"]),
        ("unit = \"Hz\"", "deadband = nan", "19:12", &["expected a number, found NaN"]),
        ("bit = 3", "bit = 3\ndeadband = 0.5", "25:12", &["deadband only for numbers", "each change is recorded"]),
        ("unit = \"Hz\"", "texts = { 1 = \"slow\" }\ndeadband = 0.5", "20:12", &["deadband only for numbers"]),
        ("unit = \"Hz\"", "status = 8", "19:10", &["needs octet 8", "0 to 7"]),
        ("1 = \"running\"", "on = \"running\"", "26:26", &["a whole number as code"]),
        ("name = \"state\"", "name = \"speed\"", "22:8", &["point \"speed\" is defined twice"]),
        ("address = 12", "address = 0", "7:11", &["address 0 is already used by the master"]),
        ("address = 12", "address = 126", "7:11", &["from 0 to 125"]),
    ] {
        assert!(FILE.contains(from), "{from}");
        let (found, sentence) = error(&FILE.replace(from, to));
        assert!(parts.iter().all(|part| sentence.contains(part)), "{to}: {sentence}");
        assert_eq!(found, place, "{to}: {sentence}");
    }
}

#[test]
fn the_station_owns_no_slave_on_a_segment_on_which_it_only_listens() {
    let (place, sentence) = error(&FILE.replace("port =", "listen-only = true\nport ="));
    assert_eq!(place, "12:7");
    assert!(sentence.contains("listen-only"), "{sentence}");
}

#[test]
fn a_gauge_and_a_slave_share_neither_name_nor_address() {
    let gauge = |name: &str, address: u8| {
        format!("[[segment.gauge]]\nname = \"{name}\"\naddress = {address}\ndevice = \"bcg450\"\n\n[[segment.slave]]")
    };
    let with = |name: &str, address| FILE.replacen("[[segment.slave]]", &gauge(name, address), 1);
    assert!(error(&with("turbo", 5)).1.contains("defined twice"));
    assert!(error(&with("chamber", 12)).1.contains("address 12 is already used by another gauge or slave"));
    assert!(read_in(&folder(), &with("chamber", 5)).is_ok());
}

#[test]
fn a_folder_must_have_the_files_of_one_device() {
    let folder = folder();
    let library = folder.path().join("library");
    fs::create_dir(&library).unwrap();
    fs::write(library.join("pump.gsd"), GSD).unwrap();
    let text = FILE.replace("pump.gsd", "library");
    assert!(read_in(&folder, &text).is_ok());
    fs::write(library.join("other.gsd"), GSD.replace("Pump 1", "Pump 2")).unwrap();
    let error = read_in(&folder, &text).unwrap_err();
    let sentence = error.problem.to_string();
    assert!(sentence.contains("other.gsd") && sentence.contains("pump.gsd"), "{sentence}");
    assert_eq!((error.line, error.column), (8, 7));
    for number in 3..=25 {
        fs::write(library.join(format!("{number}.gsd")), GSD.replace("Pump 1", &format!("Pump {number}"))).unwrap();
    }
    let sentence = read_in(&folder, &text).unwrap_err().problem.to_string();
    assert!(sentence.ends_with(" and 5 more; name one file"), "a folder can have thousands: {sentence}");
}

#[test]
fn the_alarms_of_points_have_their_limits_or_texts() {
    let with = |alarm: &str| {
        FILE.replace("unit = \"Hz\"\n", &format!("unit = \"Hz\"\n[[segment.slave.point.alarm]]\n{alarm}\n"))
    };
    let config = read_in(&folder(), &with("below = 900\npriority = \"high\"")).unwrap();
    let rule = config.alarms.iter().find(|rule| rule.name == "turbo: speed below 900 Hz").unwrap();
    let (gauge, point) = ("turbo".to_owned(), "speed".to_owned());
    assert_eq!(
        rule.condition,
        Condition::Point { gauge, point, test: PointTest::Below { limit: 900.0, reset: 900.0 }, unit: Some("Hz") }
    );
    assert_eq!(rule.priority, Priority::High);
    for (alarm, limit, reset) in [
        ("below = 900\nhysteresis = 5", 900.0, 905.0),
        ("below = 900\nreset = 910", 900.0, 910.0),
        ("above = 900\nhysteresis = 0.5", 900.0, 899.5),
        ("above = 900\nreset = 900", 900.0, 900.0),
    ] {
        let config = read_in(&folder(), &with(alarm)).unwrap();
        let rule = config.alarms.iter().find(|rule| rule.name.starts_with("turbo: speed")).unwrap();
        assert_eq!((rule.condition.limit(), rule.condition.reset()), (Some(limit), Some(reset)), "{alarm}");
    }
    for (alarm, part) in [
        ("above = 900\nreset = 901", "expected a reset not above the limit 900, found 901"),
        ("below = 900\nreset = 899", "expected a reset not below the limit 900, found 899"),
        ("below = 900\nreset = 910\nhysteresis = 5", "expected reset or hysteresis, found both"),
        ("below = 900\nhysteresis = -1", "expected a hysteresis of 0 or more, in its unit, found -1"),
        ("above = nan", "expected a number"),
        ("above = 1\nbelow = 0", "one of above, below and is"),
        ("delay = \"1 s\"", "one of above, below and is"),
        ("is = \"fast\"", "never is \"fast\"; its texts: none"),
        ("above = 1\npriority = \"most\"", "priority"),
    ] {
        let (_, sentence) = error(&with(alarm));
        assert!(sentence.contains(part), "{alarm}: {sentence}");
    }
    let text = format!("{FILE}[[segment.slave.point.alarm]]\nis = \"stopped\"\n");
    let config = read_in(&folder(), &text).unwrap();
    assert!(config.alarms.iter().any(|rule| rule.name == "turbo: state is stopped"));
    let (_, sentence) = error(&format!("{text}hysteresis = 1\n"));
    assert!(sentence.contains("expected reset and hysteresis with above or below only, found 1"), "{sentence}");
}

/// An alarm is known by its name: of two with one name an operator would acknowledge and shelve only one.
#[test]
fn two_alarms_of_points_never_have_one_name() {
    let alarm = |text: &str| format!("{FILE}[[segment.slave.point.alarm]]\n{text}\n");
    let twice = alarm("is = \"stopped\"\n[[segment.slave.point.alarm]]\nis = \"stopped\"\npriority = \"high\"");
    let (place, sentence) = error(&twice);
    assert_eq!(place, "30:6");
    assert!(sentence.contains("\"turbo: state is stopped\" is defined twice"), "{sentence}");
    let other = "[[alarm]]\nname = \"turbo: state is stopped\"\nsegment = \"hall\"\nstation = 12\nlost = 5";
    assert!(error(&alarm(&format!("is = \"stopped\"\n{other}"))).1.contains("defined twice"));
}

#[test]
fn a_bit_with_one_text_has_the_usual_word_for_the_other() {
    let text = FILE.replace("0 = \"stopped\", ", "");
    let config = read_in(&folder(), &format!("{text}[[segment.slave.point.alarm]]\nis = \"off\"\n")).unwrap();
    assert!(config.alarms.iter().any(|rule| rule.name == "turbo: state is off"));
    let (_, sentence) = error(&format!("{text}[[segment.slave.point.alarm]]\nis = \"on\"\n"));
    assert!(sentence.contains("its texts: off, running"), "{sentence}");
}

#[test]
fn each_slave_has_the_default_alarms_of_fault_and_no_data() {
    let config = read_in(&folder(), FILE).unwrap();
    let names: Vec<_> = config.alarms.iter().map(|rule| rule.name.as_str()).collect();
    assert!(names.contains(&"turbo: fault") && names.contains(&"turbo: no data"), "{names:?}");
    let excepted = format!("{FILE}\n[alarms]\nfault = {{ except = [\"turbo\"] }}\n");
    let config = read_in(&folder(), &excepted).unwrap();
    assert!(config.alarms.iter().all(|rule| rule.name != "turbo: fault"));
}

/// The station sends no parameters to a slave that it does not own, so only the rate concerns it.
#[test]
fn warnings_of_the_gsd_file_and_a_rate_that_it_does_not_have_are_notices() {
    let folder = folder();
    let gsd = GSD.replace("#Profibus_DP", "#Profibus_DP\nDPV1_Slave = 1\nPull_Plug_Alarm_required = 1\n9.6_supp = 1");
    let gsd = gsd.replace("Max_User_Prm_Data_Len = 1", "Max_User_Prm_Data_Len = 4").replace("Ref(0)", "Ref(3)");
    fs::write(folder.path().join("pump.gsd"), gsd).unwrap();
    let notices = |text: &str| {
        let config = read_in(&folder, text).unwrap();
        crate::notices(&config).iter().map(ToString::to_string).collect::<Vec<_>>()
    };
    let alarm = "the slave \"turbo\": the station requires pull and plug alarms, which the second user parameter does not \
                 enable; set its bit 80";
    let rate = "the slave \"turbo\": the GSD file does not have 19.2 kbit/s; it has 9.6 kbit/s: set a baud of the segment \
                that all its slaves have";
    assert_eq!(notices(FILE), [alarm, rate]);
    let at_its_rate = FILE.replace("ttyUSB0\"", "ttyUSB0\"\nbaud = 9600");
    assert_eq!(notices(&at_its_rate), [alarm]);
    let read_only = at_its_rate.replace("own = true\noutputs = \"01 FF\"\n", "");
    assert_eq!(notices(&read_only), [""; 0]);
    let at_the_found_rate = read_only.replace("baud = 9600", "listen-only = true");
    assert_eq!(notices(&at_the_found_rate), [""; 0]);
}

const TURBO: &str = r#"format = 1
name = "turbo"
title = "Turbo pump"
vendor = "A maker"
manual = "none"
ident = 0x1234
user-parameters = [{ name = "none", octets = "" }]
configurations = [{ inputs = 1, octets = "13" }, { outputs = 2, inputs = 2, octets = "20 16" }]
default-configuration = "20 16"
values = [
  { name = "speed",       inputs = 2, octet = 0, type = "UINT16", unit = "Hz", factor = 0.5 },
  { name = "temperature", inputs = 2, octet = 2, type = "FLOAT",  unit = "°C" },
  { name = "state",       inputs = 2, octet = 6, type = "UINT8",  codes = "state" },
  { name = "run",         outputs = 2, type = "BOOLEAN" },
  { name = "speed",       inputs = 1, type = "UINT32" },
]
[outputs]
2 = ["ignored 1"]
[inputs]
1 = ["ignored 4"]
2 = ["ignored 7"]
[codes.state]
names = [{ code = 0, name = "stopped" }, { code = 3, name = "at speed" }]
"#;

/// A station's file with the pump of [`TURBO`] and these keys.
fn with_turbo(keys: &str) -> Result<Config, ConfigError> {
    let folder = folder();
    fs::write(folder.path().join("turbo.toml"), TURBO).unwrap();
    let segment =
        "[[segment]]\nname = \"hall\"\nport = \"/dev/ttyUSB0\"\n[[segment.slave]]\nname = \"pump\"\naddress = 12\n";
    read_in(&folder, &format!("{segment}{keys}"))
}

#[test]
fn the_values_in_the_inputs_of_a_device_file_are_points() {
    let config = with_turbo("device = \"turbo.toml\"\n").unwrap();
    let slave = &config.segments[0].slaves[0];
    assert_eq!((slave.gsd.ident(), slave.gsd.chk_cfg(), slave.inputs()), (0x1234, &[0x20, 0x16][..], 7));
    let of = |point: &SlavePoint| (point.name.clone(), point.octet, point.kind, point.scale, point.unit);
    let points: Vec<_> = slave.points.iter().map(of).collect();
    let expected = [
        ("speed", 0, PointType::U16, 0.5, Some("Hz")),
        ("temperature", 2, PointType::F32, 1.0, Some("°C")),
        ("state", 6, PointType::U8, 1.0, None),
    ];
    let expected = expected.map(|(name, octet, kind, scale, unit)| (name.to_owned(), octet, kind, scale, unit));
    assert_eq!(points, expected);
    assert!(slave.points[1].place.ends_with(" octet 2"), "{}", slave.points[1].place);
    let inputs = [0x07, 0xD0, 0x41, 0xA4, 0, 0, 3];
    let texts: Vec<_> = slave.points.iter().map(|point| point.value(&inputs).text).collect();
    assert_eq!(texts, ["1000 Hz", "20.5 °C", "at speed"]);
}

#[test]
fn another_configuration_of_a_device_file_has_its_own_values_and_a_point_replaces_one() {
    let config = with_turbo("device = \"turbo.toml\"\nmodules = [1]\n").unwrap();
    let slave = &config.segments[0].slaves[0];
    assert_eq!((slave.gsd.chk_cfg(), slave.points.len(), slave.points[0].kind), (&[0x13][..], 1, PointType::U32));
    let point = "[[segment.slave.point]]\nname = \"speed\"\ntype = \"u16\"\nscale = 30.0\nunit = \"rpm\"\n";
    let config = with_turbo(&format!("device = \"turbo.toml\"\n{point}")).unwrap();
    let names: Vec<_> = config.segments[0].slaves[0].points.iter().map(|it| (it.name.as_str(), it.unit)).collect();
    assert_eq!(names, [("temperature", Some("°C")), ("state", None), ("speed", Some("rpm"))]);
}

/// The station sends zeros to its gauges.
#[test]
fn a_device_with_outputs_is_a_slave_and_no_gauge_that_the_station_owns() {
    let read = |keys: &str| {
        let folder = folder();
        fs::write(folder.path().join("turbo.toml"), TURBO).unwrap();
        let gauge = "[[segment.gauge]]\nname = \"pump\"\naddress = 12\ndevice = \"turbo.toml\"\n";
        let segment = format!("[[segment]]\nname = \"hall\"\nport = \"/dev/ttyUSB0\"\n{keys}{gauge}");
        read_in(&folder, &segment).map(drop).map_err(|error| error.problem.to_string())
    };
    assert!(read("").unwrap_err().starts_with("Turbo pump takes outputs, and zeros can stop a pump"));
    assert_eq!(read("listen-only = true\n"), Ok(()));
}

#[test]
fn a_slave_has_a_gsd_file_or_a_device() {
    for keys in ["", "device = \"turbo.toml\"\ngsd = \"pump.gsd\"\n"] {
        let problem = with_turbo(keys).unwrap_err().problem.to_string();
        assert!(problem.starts_with("expected either gsd (the GSD file of the slave) or device"), "{problem}");
    }
    let problem = with_turbo("device = \"turbine\"\n").unwrap_err().problem.to_string();
    assert!(problem.contains("unknown device \"turbine\""), "{problem}");
}
