//! `--gsd` of `decode`, `sniff` and `doctor`: traffic of any slave in the words of its GSD file. All files are invented.

#![allow(clippy::unwrap_used, clippy::panic, reason = "a test")]

use crate::common::{Folder, Program, octets, run, sd2};
use serde_json::Value;
use std::fs;
use std::io::Write;
use std::net::TcpListener;
use std::process::Output;

const ISLAND: &str = "\
#Profibus_DP
Vendor_Name = \"Valves Ltd\"
Model_Name = \"Valve island\"
Ident_Number = 0xAAAB
500_supp = 1
Modular_Station = 1
Max_Module = 4
Max_User_Prm_Data_Len = 8
PrmText = 1
Text(0) = \"opens\"
Text(1) = \"closes\"
EndPrmText
ExtUserPrmData = 1 \"Valve without bus\"
Bit(0) 0 0-1
Prm_Text_Ref = 1
EndExtUserPrmData
Ext_User_Prm_Data_Const(0) = 0x10
Ext_User_Prm_Data_Ref(0) = 1
Unit_Diag_Bit(0) = \"no supply\"
Module = \"4DO\" 0x20
EndModule
Module = \"2DI\" 0x10
EndModule
";

/// An answer of slave 5 to master 2 from an access point.
fn answer(sap: u8, du: &str) -> String {
    let body = octets(&format!("82 85 08 3E {sap:02X} {du}"));
    let sum = body.iter().fold(0_u8, |sum, octet| sum.wrapping_add(*octet));
    let length = body.len();
    let hex: Vec<_> = body.iter().map(|octet| format!("{octet:02X}")).collect();
    format!("68 {length:02X} {length:02X} 68 {} {sum:02X} 16", hex.join(" "))
}

/// The start-up of the island with these user parameters and configuration, and a diagnosis without supply.
fn traffic(user: &str, config: &str) -> String {
    [
        sd2(5, 60, 0x6D, ""),
        answer(60, "00 0C 00 02 AA AB"),
        sd2(5, 61, 0x5D, &format!("88 01 0A 0B AA AB 00 {user}")),
        "E5".to_owned(),
        sd2(5, 62, 0x7D, config),
        "E5".to_owned(),
        sd2(5, 60, 0x5D, ""),
        answer(60, "08 0C 00 02 AA AB 02 01"),
    ]
    .join("\n")
}

/// A folder with the GSD file `ISLAND.GSD` and traffic in `log.txt`.
fn folder(user: &str, config: &str) -> Folder {
    let folder = Folder::new();
    fs::create_dir(folder.path("gsd")).unwrap();
    fs::write(folder.path("gsd/ISLAND.GSD"), ISLAND).unwrap();
    fs::write(folder.path("log.txt"), traffic(user, config)).unwrap();
    folder
}

fn shown(output: &Output) -> String {
    String::from_utf8_lossy(&output.stdout).into_owned()
}

fn complaint(output: &Output) -> String {
    String::from_utf8_lossy(&output.stderr).into_owned()
}

#[test]
fn decode_explains_a_slave_by_its_file() {
    let folder = folder("11", "20 10");
    let output = run(&["decode", "--gsd", &folder.name("gsd"), &folder.name("log.txt")]);
    let text = shown(&output);
    assert_eq!(output.status.code(), Some(0), "{text}");
    for sentence in [
        "is present: Valve island of Valves Ltd by the GSD file (ident AAAB)",
        "its parameters by the GSD file: Valve without bus = closes (1), default opens (0)\n",
        "its modules by the GSD file: slot 1 4DO, slot 2 2DI\n",
        "its diagnosis: Ext_Diag; vendor-specific octets 01: no supply\n",
    ] {
        assert!(text.contains(sentence), "{sentence}: {text}");
    }
    let row = text.lines().last().unwrap();
    assert!(row.starts_with("   5  Valve island "), "{row}");
    let title = text.lines().find(|line| line.starts_with("ADDR")).unwrap();
    assert_eq!(title.len(), row.len(), "the columns stand below each other");
}

#[test]
fn the_summary_in_json_has_devices_and_modules() {
    let folder = folder("11", "20 10");
    let lines = |options: &[&str]| shown(&run(&[&["decode", "--json", &folder.name("log.txt")], options].concat()));
    let slave = |text: &str| serde_json::from_str::<Value>(text.lines().last().unwrap()).unwrap()["slaves"][0].clone();
    let slave_5 = slave(&lines(&["--gsd", &folder.name("gsd/ISLAND.GSD")]));
    assert_eq!(slave_5["device"], "Valve island");
    assert_eq!(slave_5["possible_devices"][0], "Valve island of Valves Ltd");
    let module = serde_json::json!({ "slot": 2, "modules": ["2DI"], "inputs": [0, 1], "outputs": [1, 0] });
    assert_eq!(slave_5["modules"][1], module);
    let without = slave(&lines(&[]));
    assert!(without["device"].is_null() && without.get("modules").is_none(), "{without}");
}

#[test]
fn a_gsd_file_in_place_of_traffic_is_answered_with_the_command_to_use() {
    let folder = folder("11", "20 10");
    let file = folder.name("gsd/ISLAND.GSD");
    let output = run(&["decode", &file]);
    let words = complaint(&output);
    assert_eq!(output.status.code(), Some(2));
    for command in [format!("`profivac gsd show {file}`"), format!("`profivac decode --gsd {file} FILE`")] {
        assert!(words.contains(&command), "{words}");
    }
    let output = run(&["doctor", &file]);
    let text = shown(&output);
    assert_eq!(output.status.code(), Some(0), "{text}");
    assert!(text.contains("note     a GSD file: Valves Ltd Valve island, 2 modules"), "{text}");
    assert!(text.contains(&format!("next: `profivac gsd show {file}`")), "{text}");
    fs::write(&file, ISLAND.replace("Module = \"2DI\" 0x10\nEndModule", "Module = \"2DI\" 0x10, x\nEndModule"))
        .unwrap();
    let text = shown(&run(&["doctor", &file]));
    assert!(text.contains("1 fault\n") && text.contains(&format!("next: `profivac gsd check {file}`")), "{text}");
}

#[test]
fn what_a_file_is_follows_from_its_contents_and_not_from_its_name() {
    let folder = folder("11", "20 10");
    let comment = "; a comment before the header\n".repeat(20);
    fs::write(folder.path("island.txt"), comment + ISLAND).unwrap();
    let output = run(&["decode", &folder.name("island.txt")]);
    assert_eq!(output.status.code(), Some(2));
    assert!(complaint(&output).contains("is a GSD file, expected recorded traffic"), "{}", complaint(&output));
    let octets = octets(&traffic("11", "20 10"));
    for (name, contents) in [("log.gsd", traffic("11", "20 10").into_bytes()), ("line.gsd", octets)] {
        fs::write(folder.path(name), contents).unwrap();
        let output = run(&["decode", "--gsd", &folder.name("gsd"), &folder.name(name)]);
        assert_eq!(output.status.code(), Some(0), "{name}: {}", complaint(&output));
        assert!(shown(&output).contains("its modules by the GSD file: slot 1 4DO, slot 2 2DI\n"), "{name}");
    }
}

#[test]
fn a_folder_without_gsd_files_is_a_wrong_argument() {
    let folder = folder("11", "20 10");
    fs::create_dir(folder.path("empty")).unwrap();
    for command in ["decode", "doctor"] {
        let output = run(&[command, "--gsd", &folder.name("empty"), &folder.name("log.txt")]);
        assert_eq!(output.status.code(), Some(2), "{command}");
        assert!(complaint(&output).contains("expected GSD files in"), "{command}: {}", complaint(&output));
    }
}

#[test]
fn doctor_compares_traffic_with_the_file() {
    let examined = |folder: &Folder| {
        let output = run(&["doctor", "--gsd", &folder.name("gsd"), &folder.name("log.txt")]);
        (output.status.code(), shown(&output))
    };
    let (code, text) = examined(&folder("11", "20 10"));
    assert_eq!(code, Some(0), "{text}");
    assert!(text.contains("ok       slave 5: Valve island of Valves Ltd, slot 1 4DO, slot 2 2DI\n"), "{text}");
    assert!(
        text.contains("note     slave 5: its diagnosis reports Ext_Diag; vendor-specific octets 01: no supply\n"),
        "{text}"
    );
    let (code, text) = examined(&folder("11 00", "20 33"));
    assert_eq!(code, Some(3), "{text}");
    assert!(
        text.contains(
            "problem  slave 5: the configuration is not possible by the GSD file: no module for slot 2 begins with 33"
        ),
        "{text}"
    );
    let (code, text) = examined(&folder("11 00", "20 10"));
    assert_eq!(code, Some(3), "{text}");
    assert!(
        text.contains(
            "problem  slave 5: Set_Prm has 2 octets of user parameters, station and modules have 1 by the GSD file\n"
        ),
        "{text}"
    );
    let other = folder("11", "20 10");
    fs::write(other.path("gsd/ISLAND.GSD"), ISLAND.replace("0xAAAB", "0xAAAC")).unwrap();
    let (code, text) = examined(&other);
    assert_eq!(code, Some(0), "{text}");
    assert!(text.contains("note     slave 5: no GSD file of --gsd has the ident AAAB\n"), "{text}");
}

#[test]
fn the_statistics_of_sniff_have_slaves_modules_and_parameters() {
    let folder = folder("11", "20 10");
    let statistics = |options: &[&str]| {
        let server = TcpListener::bind("127.0.0.1:0").unwrap();
        let port = format!("tcp://{}", server.local_addr().unwrap());
        let gsd = folder.name("gsd");
        let mut program =
            Program::start(&[&["sniff", "--statistics", "--gsd", &gsd, "--port", &port], options].concat());
        let (mut line, _) = server.accept().unwrap();
        program.wait_for_complaint("listening on");
        for telegram in traffic("11", "20 10").lines() {
            line.write_all(&octets(telegram)).unwrap();
        }
        // The program ends when the port does, and prints what it has heard.
        drop(line);
        let text: String = std::iter::from_fn(|| program.next_line()).map(|line| line + "\n").collect();
        assert_eq!(program.exit_code(), 3);
        text
    };
    let text = statistics(&[]);
    for line in [
        "  Valve island\n",
        "station 5: Valve island of Valves Ltd by the GSD file\n",
        "station 5: slot 1 4DO, output octet 0\n",
        "station 5: slot 2 2DI, input octet 0\n",
        "station 5: parameters: Valve without bus = closes (1), default opens (0)\n",
        "station 5: diagnosis: vendor-specific octets 01: no supply\n",
    ] {
        assert!(text.contains(line), "{line}: {text}");
    }
    let json: Value = serde_json::from_str(&statistics(&["--json"])).unwrap();
    assert_eq!(json["stations"][1]["devices"][0], "Valve island", "{json}");
    assert_eq!(json["slaves"][0]["modules"][0]["modules"][0], "4DO", "{json}");
    assert_eq!(json["slaves"][0]["mismatches"], serde_json::json!([]));
}

#[test]
fn sniff_explains_a_slave_by_its_file() {
    let folder = folder("11", "20 10");
    let server = TcpListener::bind("127.0.0.1:0").unwrap();
    let port = format!("tcp://{}", server.local_addr().unwrap());
    let program = Program::start(&["sniff", "--gsd", &folder.name("gsd"), "--port", &port]);
    let (mut line, _) = server.accept().unwrap();
    program.wait_for_complaint("listening on");
    for telegram in traffic("11", "20 10").lines() {
        line.write_all(&octets(telegram)).unwrap();
    }
    assert!(program.line().contains("is present: Valve island of Valves Ltd by the GSD file"));
    while !program.line().ends_with("its modules by the GSD file: slot 1 4DO, slot 2 2DI") {}
}
