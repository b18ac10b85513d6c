//! `profivac device`: devices as files, and files as devices.

#![allow(clippy::unwrap_used, reason = "a test")]

use crate::common::{Folder, run, run_on_terminal};
use profivac_client::names::ParameterNames;
use profivac_devices::catalog::MODELS;
use std::fs;
use std::process::Output;

fn stdout(output: &Output) -> &str {
    std::str::from_utf8(&output.stdout).unwrap_or_default()
}

fn stderr(output: &Output) -> &str {
    std::str::from_utf8(&output.stderr).unwrap_or_default()
}

/// A device file like bcg450 with another Ident_Number.
const LIKE: &str = "format = 1\nname = \"mine\"\ntitle = \"Mine\"\nlike = \"bcg450\"\nident = 0x0B00\n";

#[test]
fn list_names_every_built_in_device() {
    let text = run(&["device", "list"]);
    let json: serde_json::Value = serde_json::from_slice(&run(&["device", "list", "--json"]).stdout).unwrap();
    for (number, model) in MODELS.into_iter().enumerate() {
        let line = stdout(&text).lines().nth(number).unwrap();
        assert!(line.starts_with(model.name) && line.ends_with(model.manual), "{line}");
        assert_eq!(json[number]["ident"], model.ident);
    }
    assert_eq!((text.status.code(), json.as_array().map(Vec::len)), (Some(0), Some(MODELS.len())));
}

#[test]
fn a_device_that_is_shown_is_a_file_that_gives_the_same_lists() {
    let folder = Folder::new();
    for model in MODELS {
        let shown = run(&["device", "show", model.name]);
        let file = folder.name(&format!("{}.toml", model.name));
        let own = format!("\nname = \"{}\"\n", model.name);
        assert_eq!(stdout(&shown).matches(&own).count(), 1);
        fs::write(&file, stdout(&shown).replace(&own, "\nname = \"same\"\n")).unwrap();
        let checked = run(&["device", "check", &file]);
        assert_eq!(checked.status.code(), Some(0), "{}", stderr(&checked));
        let list = |device: &str| serde_json::from_slice(&run(&["list", "--json", "--device", device]).stdout).unwrap();
        let (of_name, mut of_file): (serde_json::Value, serde_json::Value) = (list(model.name), list(&file));
        let commands = of_file.to_string().matches("\"from_device_file\":true").count();
        let all = ParameterNames::of(model);
        assert_eq!(commands, all.commands().count(), "each command of a file is marked: {}", model.name);
        for row in of_file.as_array_mut().unwrap() {
            for code in row["codes"].as_array_mut().unwrap() {
                code.as_object_mut().unwrap().remove("from_device_file");
            }
        }
        assert!(all.all().len() > 10 && of_name == of_file, "{}", model.name);
        let [of_name, of_file] = [model.name, &file].map(|device| run(&["gsd", device]));
        assert!(!of_name.stdout.is_empty() && of_name.stdout == of_file.stdout, "{}", model.name);
        let blocks = run(&["st", &file]);
        assert!(stdout(&blocks).contains("FUNCTION_BLOCK PV_SAME_"), "{}", stderr(&blocks));
    }
}

#[test]
fn check_compares_with_the_gsd_file_of_the_vendor() {
    let folder = Folder::new();
    let (file, gsd) = (folder.name("mine.toml"), folder.name("mine.gsd"));
    fs::write(&file, LIKE).unwrap();
    let own = run(&["gsd", &file]);
    fs::write(&gsd, &own.stdout).unwrap();
    let checked = run(&["device", "check", &file, "--gsd", &gsd]);
    assert_eq!(checked.status.code(), Some(0), "{}", stderr(&checked));
    let summary = stdout(&checked);
    assert!(
        summary.ends_with("mine.toml: mine (Mine), ident 0B00, like bcg450: 8 configurations, 91 parameters\n"),
        "{summary}"
    );
    let text = stdout(&own)
        .replace("0x0B00", "0x0B01")
        .replace("0x44,0x86", "0x44,0x87")
        .replace("DPV1_Slave              = 1", "DPV1_Slave = 0");
    fs::write(&gsd, text).unwrap();
    let checked = run(&["device", "check", &file, "--gsd", &gsd]);
    assert_eq!(checked.status.code(), Some(2));
    for expected in [
        "mine: ident is 0x0B00, Ident_Number of the GSD file 0x0B01; one of them is of another device",
        "mine: dpv1 = true, DPV1_Slave of the GSD file is 0; compare with the manual",
        "mine: configuration \"44 86 05 05 05 08\": no module for slot 1 begins with 44 86",
        "1 of 1 device files cannot be used as they are; the lines above say where and why",
    ] {
        assert!(stderr(&checked).contains(expected), "{}", stderr(&checked));
    }
    assert_eq!(stderr(&checked).lines().count(), 4, "{}", stderr(&checked));
}

#[test]
fn check_goes_on_after_a_wrong_file_and_refuses_two_of_one_name() {
    let folder = Folder::new();
    let [one, wrong, two] = ["one.toml", "wrong.toml", "two.toml"].map(|name| folder.name(name));
    fs::write(&one, LIKE).unwrap();
    fs::write(&two, LIKE).unwrap();
    fs::write(&wrong, LIKE.replace("bcg450", "bcg451")).unwrap();
    let checked = run(&["device", "check", &one, &wrong, &two]);
    assert_eq!(checked.status.code(), Some(2));
    for expected in [
        "wrong.toml:4:8: expected a device that profivac has, one of: pcg550,",
        "found \"bcg451\"; did you mean \"bcg450\"?",
        "one.toml and ",
        "both have the name \"mine\"; rename one",
        "2 of 3 device files cannot be used as they are",
    ] {
        assert!(stderr(&checked).contains(expected), "{}", stderr(&checked));
    }
}

#[test]
fn a_wrong_file_in_place_of_a_device_is_bad_usage() {
    let folder = Folder::new();
    let file = folder.name("wrong.toml");
    fs::write(&file, LIKE.replace("ident", "idnt")).unwrap();
    for command in [&["list", "--device", &file][..], &["gsd", &file], &["st", &file], &["device", "show", &file]] {
        let output = run(command);
        assert_eq!(output.status.code(), Some(2), "{command:?}");
        let expected = "wrong.toml:5:1: unknown field `idnt`, expected one of `format`,";
        assert!(stderr(&output).contains(expected), "{}", stderr(&output));
        assert!(stderr(&output).contains("; did you mean `ident`?"), "{}", stderr(&output));
    }
    let missing = run(&["list", "--device", &folder.name("missing.toml")]);
    assert_eq!(missing.status.code(), Some(2));
    assert!(stderr(&missing).contains("missing.toml: the file cannot be read: "), "{}", stderr(&missing));
}

/// The example of the page, as a file.
#[test]
fn the_example_of_the_page_is_a_device_file() {
    let page = include_str!("../../../docs/device-files.md");
    let first = page.split_once("## A first file").unwrap().1;
    let example = first.split("```toml\n").nth(1).and_then(|rest| rest.split("```").next()).unwrap();
    let folder = Folder::new();
    let file = folder.name("my-gauge.toml");
    fs::write(&file, example).unwrap();
    let checked = run(&["device", "check", &file]);
    assert_eq!(checked.status.code(), Some(0), "{}", stderr(&checked));
    let list = run(&["list", "--device", &file, "filament"]);
    assert!(stdout(&list).contains("device.filament"), "{}", stdout(&list));
}

#[test]
fn the_schema_is_json() {
    let schema: serde_json::Value = serde_json::from_slice(&run(&["device", "schema"]).stdout).unwrap();
    assert_eq!(schema["properties"]["format"]["const"], 1);
}

/// The BPG402-SP of the gallery.
const BPG402: &str = include_str!("../../../docs/devices/files/bpg402.toml");

/// A line in memory with a gauge of a device file at address 7, and the option that names the file.
fn line_with(folder: &Folder, device: &str) -> (String, [String; 2]) {
    let file = folder.name("bpg402.toml");
    fs::write(&file, device).unwrap();
    let line = folder.name("line.toml");
    // The file is beside the segment.
    fs::write(&line, "devices = [\"bpg402.toml@7\", \"bcg450@5\"]\npressure = \"5e-6 mbar\"\nstate = \"memory\"\n")
        .unwrap();
    (format!("sim:{line}"), ["--device-files".to_owned(), file])
}

fn told(port: &str, files: &[String], command: &[&str]) -> Output {
    let files: Vec<&str> = files.iter().map(String::as_str).collect();
    run(&[&command[..1], &["--port", port], &files, &command[1..]].concat())
}

#[test]
fn a_gauge_of_a_device_file_is_found_read_and_written_by_its_names() {
    let folder = Folder::new();
    let place = r#"  { index = 220, name = "Place", type = "VSTRING(50)", access = "1/2_R/W", store = "N" },"#;
    let limit = r#"  { index = 220, name = "Own Limit", type = "BY_TYPE", access = "1/2_R/W", store = "N" },"#;
    let parts = "name = \"Analog Sensor Input Function Block\"\n";
    let device = BPG402
        .replacen("without = [206]\nparameters = [", &format!("without = [206]\nparameters = [\n{place}"), 1)
        .replacen(parts, &format!("{parts}parameters = [\n{limit}\n]\n"), 1);
    let (port, files) = line_with(&folder, &device);
    let unknown = told(&port, &[], &["scan", "--hsa", "10"]);
    assert!(stdout(&unknown).contains("unknown") && stdout(&unknown).contains("bcg450"), "{}", stdout(&unknown));
    let found = told(&port, &files, &["scan", "--hsa", "10"]);
    assert!(stdout(&found).contains("bpg402") && !stdout(&found).contains("unknown"), "{}", stdout(&found));
    let told = |command: &[&str]| {
        let output = told(&port, &files, command);
        assert_eq!(output.status.code(), Some(0), "{command:?}: {}", stderr(&output));
        stdout(&output).to_owned()
    };
    assert!(told(&["list", "--address", "7"]).contains("ba.active-filament"));
    // A row with the behaviour of the BCG450, one that only the file has, and one of the moved set points.
    told(&["write", "--address", "7", "pirani.safe-state", "use-safe-value"]);
    assert!(told(&["read", "--address", "7", "pirani.safe-state"]).contains("use-safe-value"));
    assert!(told(&["read", "--address", "7", "ba.active-filament"]).contains("false"));
    told(&["write", "--address", "7", "ba.active-filament", "1", "--yes"]);
    // A pressure stays the same pressure in another unit, and a long text is kept as a whole.
    told(&["write", "--address", "7", "pirani.own-limit", "2e-3 mbar"]);
    told(&["write", "--address", "7", "pirani.data-units", "Pascal"]);
    let limit = told(&["read", "--address", "7", "pirani.own-limit"]);
    assert!(limit.contains("0.002 mbar") || limit.contains("0.2 Pascal"), "{limit}");
    let place = "the third chamber of the old line, door to the yard";
    assert_eq!(place.len(), 51);
    told(&["write", "--address", "7", "device.place", &place[..50]]);
    assert!(told(&["read", "--address", "7", "device.place"]).contains(&place[..50]));
    assert!(told(&["read", "--address", "7", "ba.active-filament"]).contains("true"), "it survives the power");
    assert!(told(&["read", "--address", "7", "setpoint-b.process-value"]).contains("Pascal"), "all have the same unit");
    let all: serde_json::Value = serde_json::from_str(&told(&["dump", "--address", "7", "--json"])).unwrap();
    assert!(all.to_string().contains("BPG402-SP"), "Device Configuration is the title of the file");
    let monitored = told(&["monitor", "--for", "2", "--own", "--json", "7"]);
    assert!(monitored.contains("bpg402") && monitored.contains("\"valid\""), "{monitored}");
}

/// Its conditions and its risk are as good as the file: the user sees that before and after.
#[test]
fn a_command_of_a_device_file_is_marked_wherever_it_is_given() {
    let folder = Folder::new();
    let (port, files) = line_with(&folder, BPG402);
    let listed = told(&port, &files, &["list", "--address", "7", "command"]);
    assert!(stdout(&listed).starts_with("bpg402 (BPG402-SP, tira47e1, from a device file at address 7)"), "{listed:?}");
    assert!(stdout(&listed).contains("commands of a device file: inactive, degas-off"), "{}", stdout(&listed));
    let refused = told(&port, &files, &["write", "--address", "7", "reset"]);
    assert!(
        stderr(&refused).contains("until it is ready (a command of a device file); nothing was sent"),
        "{refused:?}"
    );
    let done = told(&port, &files, &["write", "--address", "7", "execute"]);
    assert!(stdout(&done).trim_end().ends_with("(a command of a device file)"), "{done:?}");
    let json = told(&port, &files, &["write", "--address", "7", "--json", "execute"]);
    let change: serde_json::Value = serde_json::from_slice(&json.stdout).unwrap();
    assert_eq!(change["from_device_file"], true, "{}", stderr(&json));
    let built_in = told(&port, &files, &["write", "--address", "5", "execute"]);
    assert_eq!(built_in.status.code(), Some(0), "{built_in:?}");
    assert!(!stdout(&built_in).contains("device file"), "{}", stdout(&built_in));
    let devices = run(&["device", "list", &files[0], &files[1]]);
    assert!(stdout(&devices).trim_end().ends_with("BPG402-SP  INFICON AG       tira47e1 (device file)"), "{devices:?}");
}

#[test]
fn every_parameter_of_a_gauge_of_a_device_file_has_an_answer_of_its_length() {
    let folder = Folder::new();
    let (port, files) = line_with(&folder, BPG402);
    let dumped = told(&port, &files, &["dump", "--address", "7", "--json"]);
    assert_eq!(dumped.status.code(), Some(0), "{}", stderr(&dumped));
    let parameters: serde_json::Value = serde_json::from_slice(&dumped.stdout).unwrap();
    let rows = parameters.as_array().unwrap();
    let refused: Vec<_> = rows.iter().filter(|row| !row["error"].is_null()).collect();
    assert!(rows.len() > 60 && refused.is_empty(), "{} rows: {refused:?}", rows.len());
    let conformed = told(&port, &files, &["conform", "--address", "7", "--own"]);
    assert_eq!(conformed.status.code(), Some(0), "{}{}", stdout(&conformed), stderr(&conformed));
}

/// No built-in device is like it: its blocks name behaviours of the library.
#[test]
fn a_gauge_of_named_behaviours_is_simulated_read_and_conforms() {
    let folder = Folder::new();
    let (file, line) = (folder.name("own.toml"), folder.name("line.toml"));
    fs::write(&file, include_str!("../../device-file/tests/own_gauge.toml")).unwrap();
    fs::write(&line, "devices = [\"own.toml@7\"]\npressure = \"5e-6 mbar\"\n").unwrap();
    let files = ["--device-files".to_owned(), file.clone()];
    let told = |command: &[&str]| told(&format!("sim:{line}"), &files, command);
    let monitored = told(&["monitor", "--for", "2", "--own", "--json", "7"]);
    assert!(stdout(&monitored).contains("own-gauge") && stdout(&monitored).contains("\"valid\""), "{monitored:?}");
    let read = told(&["read", "--address", "7", "ba.overrange"]);
    assert!(stdout(&read).contains("0.01 mbar"), "{read:?}");
    let conformed = told(&["conform", "--address", "7", "--own"]);
    assert_eq!(conformed.status.code(), Some(0), "{}{}", stdout(&conformed), stderr(&conformed));
    let checked = run(&["device", "check", &file]);
    assert!(stdout(&checked).trim_end().ends_with("; simulated without: the adjustment of the Pirani"), "{checked:?}");
}

/// Keys of a device whose outputs have a name.
const OUTPUTS: &str = "configurations = [{ outputs = 9, inputs = 9, octets = \"A1 94\" }]\n\
                       values = [{ name = \"start\", outputs = 9, type = \"BOOLEAN\" }]\n\
                       [outputs]\n9 = [\"ignored 2\"]\n\
                       [inputs]\n9 = [\"exception-status\", \"process-value float\"]\n";

/// monitor sends zeros to a known gauge, which can stop a pump.
#[test]
fn monitor_does_not_own_a_device_whose_file_names_outputs() {
    let folder = Folder::new();
    let (port, files) = line_with(&folder, &format!("{LIKE}{OUTPUTS}"));
    let monitored = told(&port, &files, &["monitor", "--for", "1", "--own", "7"]);
    assert_eq!(monitored.status.code(), Some(1), "{monitored:?}");
    assert!(stderr(&monitored).contains("takes outputs, and zeros can stop a pump"), "{}", stderr(&monitored));
    let conformed = told(&port, &files, &["conform", "--address", "7", "--own"]);
    assert_eq!(conformed.status.code(), Some(2), "{conformed:?}");
    assert!(stderr(&conformed).contains("give the user parameters with --prm"), "{}", stderr(&conformed));
}

/// The station refuses to own it as a gauge.
#[test]
fn init_writes_a_device_whose_file_names_outputs_as_a_slave() {
    let folder = Folder::new();
    let (port, files) = line_with(&folder, &format!("{LIKE}{OUTPUTS}"));
    let made = told(&port, &files, &["init", "--hsa", "10"]);
    assert_eq!(made.status.code(), Some(0), "{}", stderr(&made));
    for lines in [
        "\n[[segment.gauge]]\nname = \"bcg450 5\"\naddress = 5\ndevice = \"bcg450\"\n",
        "\n[[segment.slave]]\nname = \"mine 7\"\naddress = 7\ndevice = \"mine\"\n",
    ] {
        assert!(format!("{}\n", stdout(&made)).contains(lines), "{}", stdout(&made));
    }
}

/// With --prm nothing but the question is before the zeros.
#[test]
fn conform_asks_before_it_sends_zeros_to_a_device_whose_file_names_outputs() {
    let folder = Folder::new();
    let (port, [option, file]) = line_with(&folder, &format!("{LIKE}{OUTPUTS}"));
    let arguments = ["conform", "--port", &port, &option, &file, "--address", "7", "--prm", "00 00 00 05 1C"];
    let (code, _, shown) = run_on_terminal(&arguments, "Continue? [y/N] ", "n\n");
    assert_eq!(code, 2, "{shown}");
    let zeros = "the slave at address 7 gets 2 octets of outputs, all zero; zeros can stop a pump or close a valve";
    assert!(shown.contains(zeros), "{shown}");
}

#[test]
fn traffic_of_a_gauge_of_a_device_file_has_its_names() {
    let folder = Folder::new();
    let (_, files) = line_with(&folder, BPG402);
    let log = folder.name("log.txt");
    // Slave_Diag and its answer.
    let lines = ["68 05 05 68 87 82 6D 3C 3E", "68 0B 0B 68 82 87 08 3E 3C 0C 0C 00 FF FF F0"];
    let octets = |line: &str| line.split(' ').map(|it| u8::from_str_radix(it, 16).unwrap()).collect::<Vec<_>>();
    let telegram = |line: &str| {
        let mut telegram = octets(line);
        telegram.push(telegram[4..].iter().fold(0, |sum: u8, octet| sum.wrapping_add(*octet)));
        telegram.push(0x16);
        telegram.iter().map(|octet| format!("{octet:02X}")).collect::<Vec<_>>().join(" ")
    };
    fs::write(&log, lines.map(telegram).join("\n")).unwrap();
    let [option, file] = &files;
    let with = run(&["decode", option, file, &log]);
    assert!(stdout(&with).contains("bpg402"), "{}{}", stdout(&with), stderr(&with));
    assert!(!stdout(&run(&["decode", &log])).contains("bpg402"));
}

#[test]
fn a_wrong_device_file_ends_the_command_with_its_place() {
    let folder = Folder::new();
    let (port, [option, file]) = line_with(&folder, BPG402);
    let wrong = folder.name("wrong.toml");
    fs::write(&wrong, "format = 1\nname = 5\n").unwrap();
    let output = told(&port, &[option.clone(), wrong.clone()], &["scan", "--hsa", "10"]);
    assert_eq!(output.status.code(), Some(2));
    assert!(stderr(&output).contains(&format!("{wrong}:2:")), "{}", stderr(&output));
    let same = folder.name("same.toml");
    fs::write(&same, BPG402).unwrap();
    let both = told(&port, &[option.clone(), file, option, same.clone()], &["scan", "--hsa", "10"]);
    // The same contents are the same device.
    assert_eq!(both.status.code(), Some(0), "{}", stderr(&both));
}

/// A file like bcg450 with this name and Ident_Number.
fn like(name: &str, ident: u16) -> String {
    LIKE.replace("mine", name).replace("Mine", name).replace("0x0B00", &format!("{ident:#06X}"))
}

#[test]
fn two_files_with_one_ident_number_are_no_guess() {
    let folder = Folder::new();
    let (port, [option, file]) = line_with(&folder, BPG402);
    let other = folder.name("other.toml");
    fs::write(&other, like("other", 0xFFF0)).unwrap();
    let files = [option.clone(), file, option, other];
    let found = told(&port, &files, &["scan", "--hsa", "10"]);
    assert!(stdout(&found).contains("bpg402 or other"), "{}", stdout(&found));
    let read = told(&port, &files, &["read", "--address", "7", "device.device-state"]);
    assert_eq!(read.status.code(), Some(2));
    assert!(
        stderr(&read).contains("of bpg402 and other: name the device file of one of them only"),
        "{}",
        stderr(&read)
    );
}

#[test]
fn a_wrong_file_of_the_user_is_a_notice_and_stops_nothing() {
    let folder = Folder::new();
    let devices = folder.path("config").join("profivac/devices");
    fs::create_dir_all(&devices).unwrap();
    fs::write(devices.join("good.toml"), like("good", 0x0B00)).unwrap();
    fs::write(devices.join("wrong.toml"), "format = 1\nname = 5\n").unwrap();
    let line = folder.name("line.toml");
    fs::write(&line, "devices = [\"good@7\"]\n").unwrap();
    let plant = folder.name("plant.toml");
    let segment = "[[segment]]\nname = \"a\"\nport = \"sim:line.toml\"\n[[segment.gauge]]\nname = \"chamber\"\n";
    fs::write(&plant, format!("{segment}address = 7\ndevice = \"good\"\n")).unwrap();
    let told = |command: &[&str]| {
        let mut program = std::process::Command::new(env!("CARGO_BIN_EXE_profivac"));
        let output = program.args(command).env("XDG_CONFIG_HOME", folder.path("config")).output().unwrap();
        assert_eq!(output.status.code(), Some(0), "{command:?}: {}", stderr(&output));
        output
    };
    let found = told(&["scan", "--port", &format!("sim:{line}"), "--hsa", "10"]);
    assert!(stdout(&found).contains("good"), "{}", stdout(&found));
    assert!(stderr(&found).contains("wrong.toml:2:") && stderr(&found).contains("is left out"), "{}", stderr(&found));
    assert!(stdout(&told(&["list", "--device", "good"])).contains("pirani.safe-state"));
    told(&["run", "--check", &plant, "--listen", "127.0.0.1:0"]);
}

#[test]
fn a_text_of_a_device_file_is_no_code_of_a_function_block() {
    let folder = Folder::new();
    let file = folder.name("mine.toml");
    fs::write(&file, format!("{LIKE}manual = \"m *) x := 1; (*\"\n")).unwrap();
    let blocks = run(&["st", &file]);
    let first = stdout(&blocks).lines().next().unwrap_or_default();
    assert!(first.contains("x := 1") && first.matches("(*").count() == 1 && !first.contains("*)"), "{first}");
}

#[test]
fn a_device_without_a_pressure_and_a_channel_has_no_function_blocks() {
    let folder = Folder::new();
    let file = folder.name("tic253.toml");
    fs::write(&file, include_str!("../../../docs/devices/files/tic253.toml")).unwrap();
    for options in [&[][..], &["--dialect", "tia"], &["--plcopen"]] {
        let refused = run(&[&["st", &file], options].concat());
        assert_eq!((refused.status.code(), stdout(&refused)), (Some(2), ""), "{options:?}");
        assert!(stderr(&refused).contains("so it has no function blocks; `profivac gsd "), "{}", stderr(&refused));
    }
}

#[test]
fn the_function_blocks_of_a_device_file_are_plcopen_xml() {
    let folder = Folder::new();
    let file = folder.name("mine.toml");
    fs::write(&file, format!("{LIKE}manual = \"a < b ]]> c & d\"\n")).unwrap();
    for (option, tool, manual) in [
        ("--plcopen", "<xhtml xmlns=", "a &lt; b ]]&gt; c &amp; d"),
        ("--plcopen=codesys", "<xhtml xmlns=", "a &lt; b ]]&gt; c &amp; d"),
        ("--plcopen=beremiz", "<xhtml:p><![CDATA[", "a < b ]] > c & d"),
    ] {
        let blocks = run(&["st", option, &file]);
        assert_eq!(blocks.status.code(), Some(0), "{}", stderr(&blocks));
        for expected in ["<pou name=\"PV_MINE_CHANNEL\" pouType=\"functionBlock\">", tool, manual] {
            assert!(stdout(&blocks).contains(expected), "{option}: {expected} in {}", stdout(&blocks));
        }
    }
    let refused = run(&["st", "bcg450", "--plcopen", "--dialect", "tia"]);
    assert_eq!((refused.status.code(), stdout(&refused)), (Some(2), ""));
    assert!(stderr(&refused).contains("TIA Portal does not import PLCopen XML"), "{}", stderr(&refused));
}
