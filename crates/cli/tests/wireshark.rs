//! The dissector in `contrib/wireshark` agrees with the codec on every telegram; the explanation of the same telegrams is a golden.
//! The trace contains every service; trace and output are in `tests/golden/wireshark`.

#![allow(clippy::unwrap_used, clippy::panic, reason = "a test")]

use crate::common::{Folder, run};
use crate::golden;
use profivac_dp::link::{Baud, BitTime};
use profivac_listen::flight::{FlightLimits, FlightRecorder};
use profivac_listen::{Chunk, Divider, TimeSource};
use profivac_sim::Trace;
use profivac_sim::dialogue::hex;
use profivac_sim::trace::Entry;
use profivac_wire::acyclic::{Request, Response};
use profivac_wire::control::{Control, FrameCount, Function};
use profivac_wire::diag::SlaveDiag;
use profivac_wire::prm::SetPrm;
use profivac_wire::{DataTelegram, MAX_TELEGRAM, Sap, Telegram, cfg};
use std::path::Path;
use std::process::Command;

/// Requests to the gauge at 5 and its answers: access point, FC, data unit; the answer likewise, or SC.
/// A master is at 2; it uses 62, 51 or 50 as its own access point.
const DIALOGUE: &[(&str, &str)] = &[
    ("60 6D", "08 02 05 00 FF 08 E6"),
    ("61 5D 88 02 05 0B 08 E6 01 80 00 00 05 1C", "SC"),
    ("62 7D C6 87 8E 0A 0A 05 05 05 08", "SC"),
    ("60 5D", "08 00 0C 00 02 08 E6"),
    ("59 7D", "08 C6 87 8E 0A 0A 05 05 05 08"),
    // The parameter channel reads Data Units; the gauge needs a cycle.
    ("- 5D 10 01 16 00 00 00 00 00", "08 00 00 00 00 00 00 00 00 80 00 02 38 51 B7 17"),
    ("- 7D 10 01 16 00 00 00 00 00", "08 10 01 16 00 00 00 05 1C 80 00 02 38 51 B7 17"),
    ("- 5D 00 00 00 00 00 00 00 00", "08 00 00 00 00 00 00 00 00 80 00 02 38 51 B7 17"),
    ("- 7D 20 01 16 00 00 00 00 00", "08 70 01 16 00 00 00 00 12 80 00 02 38 51 B7 17"),
    // It reports an alarm: high priority, then the diagnosis.
    ("- 5D 00 00 00 00 00 00 00 00", "0A 00 00 00 00 00 00 00 00 82 01 02 38 51 B7 17"),
    ("60 7D", "08 08 0C 00 02 08 E6 06 01 01 09 DE AD"),
    ("60 5D", "08 08 0C 00 02 08 E6 42 05 83 41 A6 C1"),
    ("60 7D", "08 00 0C 00 02 08 E6"),
    // MS1: a read, a write, a refused write.
    ("51 5D 5E 01 16 02", "SC"),
    ("51 7D", "08 5E 01 16 02 05 1C"),
    ("51 5D 5F 01 27 01 01", "SC"),
    ("51 7D", "08 5F 01 27 01"),
    ("51 5D 5F 01 13 04 00 00 00 00", "SC"),
    ("51 7D", "08 DF 80 B6 01"),
    ("51 5D 5C 01 01 08", "SC"),
    ("51 7D", "08 5C 01 01 08"),
    // MS2: the resource manager, Initiate, Idle, a read of a text, I&M0 selected, a transport, closed by the master.
    ("49 5D 57 00 00 00 00 64 01 00 00 00 00 00 00 02 00 02 00 00 00 00", "SC"),
    ("49 7D", "08@49 56 30 00 64"),
    ("48 5D", "08 57 F0 01 00 00 00 00 00 00 02 00 02 00 00 00 00"),
    ("48 7D 48", "SC"),
    ("48 5D", "08 48"),
    ("48 7D 5E 00 11 08", "SC"),
    ("48 5D", "08 5E 00 11 08 42 43 47 34 35 30 20 20"),
    ("48 7D 5E 01 13 04", "SC"),
    ("48 5D", "08 5E 01 13 04 38 51 B7 17"),
    ("48 7D 5E 09 13 04", "SC"),
    ("48 5D", "08 DE 80 B2 00"),
    ("48 7D 51 00 01 01 07", "SC"),
    ("48 5D", "08 51 00 01 01 08"),
    ("48 7D 58 00 20", "SC"),
    // Another connection, closed by the gauge.
    ("47 5D 5E 00 11 08", "SC"),
    ("47 7D", "08 58 01 13"),
    ("56 5D", "08 00 00 00 00 00 00 00 00 80 00 02 38 51 B7 17"),
    ("57 7D", "08 00 00 00 00 00 00 00 00"),
    ("55 5D 07 08 E6 00", "SC"),
    // Not open, failed, no resource, no data, not accepted.
    ("53 7D 01", "03"),
    ("52 5D", "01"),
    ("51 7D 5E 01 16 02", "02"),
    ("51 5D", "09"),
    ("- 7D 00 00 00 00 00 00 00 00", "0C 00 00 00 00 00 00 00 00 80 00 02 38 51 B7 17"),
    // A configuration that it does not have, parameters that it refuses.
    ("61 5D 88 02 05 0B 08 E6 01 80 00 00 05 1C", "SC"),
    ("62 7D 44 86 05 05 0A 08", "SC"),
    ("60 5D", "08 06 05 00 FF 08 E6"),
    ("61 7D B8 02 05 0B 08 E7 01", "SC"),
    ("60 5D", "08 42 05 00 FF 08 E6"),
];

fn emitted(telegram: Telegram<'_>) -> Vec<u8> {
    let mut out = [0; MAX_TELEGRAM];
    let length = telegram.emit(&mut out).unwrap();
    out[..length].to_vec()
}

/// The access point of a master for an access point of the slave: MS1 and MS2 have their own.
fn of_master(sap: u8) -> u8 {
    match sap {
        0..=49 => 50,
        50 | 51 => 51,
        _ => 62,
    }
}

/// `SAP FC DU`, or `- FC DU` without access points.
fn request(text: &str) -> (Option<u8>, Vec<u8>) {
    let (sap, rest) = text.split_once(' ').unwrap();
    let sap: Option<u8> = sap.parse().ok();
    let octets = hex(rest);
    let frame = DataTelegram { da: 5, sa: 2, dsap: sap, ssap: sap.map(of_master), fc: octets[0], du: &octets[1..] };
    (sap, emitted(Telegram::Data(frame)))
}

/// `FC DU`, or SC. An answer without data is an SD1 without access points.
fn answer(sap: Option<u8>, text: &str) -> Vec<u8> {
    if text == "SC" {
        return vec![0xE5];
    }
    let octets = hex(&text.replace("@49", ""));
    let (ssap, dsap) = if octets.len() > 1 { (sap, sap.map(of_master)) } else { (None, None) };
    emitted(Telegram::Data(DataTelegram { da: 2, sa: 5, dsap, ssap, fc: octets[0], du: &octets[1..] }))
}

/// All services, 60 bit times apart, and damaged telegrams at the end.
fn services() -> Trace {
    let mut telegrams: Vec<(Vec<u8>, Vec<usize>)> = Vec::new();
    let mut add = |octets: Vec<u8>| telegrams.push((octets, Vec::new()));
    for text in ["DC 02 02", "10 05 02 49 50 16", "10 02 05 00 07 16", "10 09 02 49 54 16", "10 09 02 4E 59 16"] {
        add(hex(text));
    }
    for (asked, message) in DIALOGUE {
        let (sap, octets) = request(asked);
        add(octets);
        add(answer(sap, message));
    }
    for text in [
        // Global_Control: Clear_Data, Operate, Sync for group 1.
        "68 07 07 68 FF 82 46 3A 3E 02 00 41 16",
        "68 07 07 68 FF 82 46 3A 3E 00 00 3F 16",
        "68 07 07 68 FF 82 46 3A 3E 20 01 60 16",
        // SD3, with and without access points; SDA; LSAP_Status; a master answers, the ring grows.
        "A2 05 02 7D 01 02 03 04 05 06 07 08 A8 16",
        "A2 85 82 7D 3E 3E 44 86 05 05 05 08 E1 16",
        "68 04 04 68 05 02 43 11 5B 16",
        "68 04 04 68 05 02 4F 3E 94 16",
        "10 03 02 49 4E 16",
        "10 02 03 20 25 16",
        "DC 03 02",
        "DC 02 03",
        // Damaged: check octet, end, length, truncated, no start delimiter, a missing extension.
        "68 05 05 68 85 82 6D 3C 3E EF 16",
        "10 05 02 49 50 17",
        "68 05 06 68 85 82 6D 3C 3E EE 16",
        "68 05 05 68 85",
        "00 FF 00",
        "68 03 03 68 85 02 49 D0 16",
    ] {
        add(hex(text));
    }
    telegrams.push((hex("10 05 02 49 50 16"), vec![2]));
    let mut trace = Trace { baud: Baud::B500000, entries: Default::default() };
    let mut start = BitTime(1000);
    for (octets, errors) in telegrams {
        let entry = Entry::new(start, octets, errors);
        start = entry.end() + 60;
        trace.entries.push_back(entry);
    }
    trace
}

/// Compares with a file of `tests/golden/wireshark`.
fn compare(name: &str, text: &str) {
    golden::compare(&format!("crates/cli/tests/golden/wireshark/{name}"), text);
}

/// The capture file that `decode` writes of the trace, and its output.
fn captured(folder: &Folder) -> (String, String) {
    let (text, capture) = (folder.name("services.trace"), folder.name("services.pcapng"));
    std::fs::write(&text, services().to_string()).unwrap();
    let output = run(&["decode", &text, "--out", &capture]);
    assert_eq!((output.status.code(), String::from_utf8_lossy(&output.stderr).as_ref()), (Some(0), ""));
    (capture, String::from_utf8(output.stdout).unwrap())
}

/// The output of tshark. As root it warns on standard error and loads scripts only if the init.lua of the distribution
/// permits it; without the script the protocol has no fields and tshark fails.
fn tshark(capture: &str, arguments: &[&str]) -> String {
    let script = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../contrib/wireshark/profibus.lua");
    let script = format!("lua_script:{}", script.canonicalize().unwrap().display());
    let output = Command::new("tshark").args(["-r", capture, "-X", &script]).args(arguments).output();
    let output = output.unwrap_or_else(|error| panic!("tshark ({error}): ./test installs it"));
    let complaint = String::from_utf8_lossy(&output.stderr).into_owned();
    assert!(output.status.success() && !complaint.contains("Lua"), "{complaint}");
    String::from_utf8(output.stdout).unwrap()
}

/// Fields of the dissector, in the order in which [`expected`] has them.
const FIELDS: [&str; 24] = [
    "sd",
    "da",
    "sa",
    "dsap",
    "ssap",
    "fc",
    "function",
    "status",
    "fcb",
    "fcv",
    "service",
    "ident",
    "diag.status",
    "diag.master",
    "prm.status",
    "prm.user",
    "cfg.outputs",
    "cfg.inputs",
    "pdu",
    "pdu.negative",
    "pdu.slot",
    "pdu.index",
    "pdu.data",
    "pdu.error_code_1",
];

/// The fields of a telegram by the codec, as tshark prints them.
fn expected(octets: &[u8]) -> Vec<String> {
    let mut row = vec![String::new(); FIELDS.len()];
    let mut set = |name: &str, text: String| row[FIELDS.iter().position(|field| *field == name).unwrap()] = text;
    set("sd", format!("{:#04x}", octets[0]));
    match Telegram::parse(octets) {
        Ok(Telegram::Token { da, sa }) => {
            set("da", da.to_string());
            set("sa", sa.to_string());
        }
        Ok(Telegram::Data(frame)) => fields(&frame, &mut set),
        Ok(Telegram::ShortAck) | Err(_) => {}
    }
    row
}

fn fields(frame: &DataTelegram<'_>, set: &mut impl FnMut(&str, String)) {
    set("da", frame.da.to_string());
    set("sa", frame.sa.to_string());
    frame.dsap.into_iter().for_each(|sap| set("dsap", sap.to_string()));
    frame.ssap.into_iter().for_each(|sap| set("ssap", sap.to_string()));
    set("fc", format!("{:#04x}", frame.fc));
    let (sap, is_request) = match frame.control() {
        Control::Request { function, count } => {
            set("function", format!("{:#04x}", frame.fc & 0x0F));
            let (fcb, fcv) = match count {
                FrameCount::Uncounted => (0, 0),
                FrameCount::First => (1, 0),
                FrameCount::Counted(bit) => (u8::from(bit), 1),
            };
            set("fcb", fcb.to_string());
            set("fcv", fcv.to_string());
            if matches!(function, Function::FdlStatus | Function::Ident | Function::LsapStatus) {
                return;
            }
            (frame.dsap, true)
        }
        Control::Response { .. } => {
            set("status", format!("{:#04x}", frame.fc & 0x0F));
            if frame.fc & 0x0F == 0 || (frame.ssap.is_none() && frame.du.is_empty()) {
                return;
            }
            (frame.ssap, false)
        }
    };
    let service = match Sap::from_octet(sap) {
        Sap::Default => "Data_Exchange".to_owned(),
        Sap::Ms2(sap) => format!("MS2 SAP {sap}"),
        Sap::ResourceManager => "MS2 Initiate".to_owned(),
        Sap::Ms1 => "MS1".to_owned(),
        Sap::SetExtPrm => "Set_Ext_Prm".to_owned(),
        Sap::SetSlaveAdd => "Set_Slave_Add".to_owned(),
        Sap::RdInp => "RD_Inp".to_owned(),
        Sap::RdOutp => "RD_Outp".to_owned(),
        Sap::GlobalControl => "Global_Control".to_owned(),
        Sap::GetCfg => "Get_Cfg".to_owned(),
        Sap::SlaveDiag => "Slave_Diag".to_owned(),
        Sap::SetPrm => "Set_Prm".to_owned(),
        Sap::ChkCfg => "Chk_Cfg".to_owned(),
        Sap::Alarm => "MS1 Alarm".to_owned(),
        Sap::Other(other) => format!("SAP {other}"),
    };
    set("service", service);
    data_unit(Sap::from_octet(sap), is_request, frame.du, set);
}

fn data_unit(sap: Sap, is_request: bool, du: &[u8], set: &mut impl FnMut(&str, String)) {
    match (sap, is_request) {
        (Sap::SlaveDiag, false) => {
            let diag = SlaveDiag::parse(du).unwrap();
            set("ident", format!("{:#06x}", diag.ident));
            set("diag.status", format!("0x{:02x}{:02x}{:02x}", du[0], du[1], du[2]));
            set("diag.master", diag.master_add.to_string());
        }
        (Sap::SetPrm, true) => {
            let prm = SetPrm::parse(du).unwrap();
            set("ident", format!("{:#06x}", prm.ident));
            set("prm.status", format!("{:#04x}", prm.status.bits()));
            set("prm.user", plain(prm.user));
        }
        (Sap::ChkCfg, true) | (Sap::GetCfg, false) => {
            let lengths = cfg::lengths(du).unwrap();
            set("cfg.outputs", lengths.outputs.to_string());
            set("cfg.inputs", lengths.inputs.to_string());
        }
        (Sap::SetSlaveAdd, true) => set("ident", format!("0x{:02x}{:02x}", du[1], du[2])),
        (Sap::Ms1 | Sap::Ms2(_) | Sap::ResourceManager, _) if !du.is_empty() => pdu(is_request, du, set),
        _ => {}
    }
}

fn pdu(is_request: bool, du: &[u8], set: &mut impl FnMut(&str, String)) {
    set("pdu", format!("{:#04x}", du[0] & 0x7F));
    set("pdu.negative", u8::from(du[0] & 0x80 != 0).to_string());
    let (slot, index, data) = match (is_request, Request::parse(du), Response::parse(du)) {
        (true, Ok(Request::Read(access)), _) | (false, _, Ok(Response::Write(access))) => {
            (access.slot, Some(access.index), &[][..])
        }
        (true, Ok(Request::Write(data) | Request::DataTransport(data)), _)
        | (false, _, Ok(Response::Read(data) | Response::DataTransport(data))) => {
            (data.slot, Some(data.index), data.data)
        }
        (true, Ok(Request::AlarmAck(ack)), _) | (false, _, Ok(Response::AlarmAck(ack))) => (ack.slot, None, &[][..]),
        (false, _, Ok(Response::Negative(refusal))) => {
            return set("pdu.error_code_1", format!("{:#04x}", refusal.code_1.0));
        }
        (true, Ok(Request::Idle(_) | Request::Initiate(_) | Request::Abort(_)), _) => return,
        (
            false,
            _,
            Ok(Response::Idle(_) | Response::Initiate(_) | Response::Abort(_) | Response::ResourceManager(_)),
        ) => return,
        other => panic!("{other:?}"),
    };
    set("pdu.slot", slot.to_string());
    index.into_iter().for_each(|index| set("pdu.index", index.to_string()));
    set("pdu.data", plain(data));
}

/// Octets as tshark prints them.
fn plain(octets: &[u8]) -> String {
    octets.iter().map(|octet| format!("{octet:02x}")).collect::<Vec<_>>().join(" ")
}

#[test]
fn the_dissector_agrees_with_the_codec() {
    let folder = Folder::new();
    let (capture, _) = captured(&folder);
    let fields: Vec<String> = FIELDS.iter().flat_map(|name| ["-e".to_owned(), format!("profibus.{name}")]).collect();
    let mut arguments = vec!["-T", "fields", "-E", "separator=|"];
    arguments.extend(fields.iter().map(String::as_str));
    let table = tshark(&capture, &arguments);
    let trace = services();
    assert_eq!(table.lines().count(), trace.entries.len());
    for (line, entry) in table.lines().zip(&trace.entries) {
        let row: Vec<&str> = line.split('|').map(|cell| cell.split(',').next().unwrap()).collect();
        let names: Vec<String> = FIELDS.iter().zip(&row).map(|(name, cell)| format!("{name}={cell}")).collect();
        let wanted: Vec<String> =
            FIELDS.iter().zip(expected(&entry.octets)).map(|(name, cell)| format!("{name}={cell}")).collect();
        assert_eq!(names, wanted, "{entry}");
    }
}

/// A pcapng file of the link type of PROFIBUS, for which Wireshark has no encapsulation.
#[test]
fn a_capture_of_link_type_257_is_dissected() {
    let folder = Folder::new();
    let (text, capture) = (folder.name("log.txt"), folder.name("log.pcapng"));
    std::fs::write(&text, "10 08 02 49 53 16\n").unwrap();
    let output = run(&["decode", &text, "--out", &capture, "--link-type", "profibus-dl"]);
    assert_eq!(output.status.code(), Some(0));
    assert_eq!(tshark(&capture, &["-T", "fields", "-e", "_ws.col.Protocol"]), "PROFIBUS\n");
}

/// Wireshark calls every link type that it has no name for "unknown".
#[test]
fn packets_of_another_unknown_link_type_are_not_profibus() {
    let folder = Folder::new();
    let (text, capture) = (folder.name("log.txt"), folder.name("log.pcapng"));
    std::fs::write(&text, "10 08 02 49 53 16\nE5\n10 08 02 49 53 16\n").unwrap();
    run(&["decode", &text, "--out", &capture, "--link-type", "profibus-dl"]);
    let protocols = |file: &[u8]| {
        std::fs::write(&capture, file).unwrap();
        tshark(&capture, &["-T", "fields", "-e", "_ws.col.Protocol"])
    };
    let file = std::fs::read(&capture).unwrap();
    let telegram = hex("10 08 02 49 53 16");
    let places: Vec<_> = (0..file.len()).filter(|at| file[*at..].starts_with(&telegram)).collect();
    let [first, second] = places.as_slice() else { panic!("{places:?}") };
    assert_eq!(protocols(&file), "PROFIBUS\nPROFIBUS\nPROFIBUS\n");
    // A damaged telegram behind a valid one is shown as one.
    let mut damaged = file.clone();
    damaged[*second + 4] = 0x54;
    assert_eq!(protocols(&damaged), "PROFIBUS\nPROFIBUS\nPROFIBUS\n");
    let mut other = damaged;
    other[*first + 4] = 0x54;
    assert!(!protocols(&other).contains("PROFIBUS"));
}

#[test]
fn the_columns_are_filled_and_damaged_telegrams_marked() {
    let folder = Folder::new();
    let (capture, _) = captured(&folder);
    let arguments = ["-T", "fields", "-E", "separator=|", "-e", "_ws.col.Protocol", "-e", "_ws.col.Source"];
    let rest = ["-e", "_ws.col.Destination", "-e", "_ws.col.Info", "-e", "_ws.expert.message"];
    let table = tshark(&capture, &[&arguments[..], &rest].concat());
    compare("columns.txt", &table.replace('\t', " "));
}

#[test]
fn the_explanation_of_all_services_is_the_golden() {
    let folder = Folder::new();
    let (_, explained) = captured(&folder);
    compare("services.trace", &services().to_string());
    compare("services.txt", &explained);
}

/// A capture file of telegrams without times, as `decode --out` writes it.
fn capture_without_times(folder: &Folder, telegrams: &[Vec<u8>]) -> String {
    let (text, capture) = (folder.name("log.txt"), folder.name("log.pcapng"));
    let lines = telegrams.iter().map(|octets| plain(octets) + "\n");
    std::fs::write(&text, lines.collect::<String>()).unwrap();
    assert_eq!(run(&["decode", &text, "--out", &capture]).status.code(), Some(0));
    capture
}

/// The fields of each packet after two passes: a link to a later packet needs the second one, as in the window of Wireshark.
fn rows(capture: &str, fields: &[&str]) -> Vec<String> {
    let fields: Vec<String> = fields.iter().flat_map(|name| ["-e".to_owned(), (*name).to_owned()]).collect();
    let mut arguments = vec!["-2", "-T", "fields", "-E", "separator=|"];
    arguments.extend(fields.iter().map(String::as_str));
    tshark(capture, &arguments).lines().map(str::to_owned).collect()
}

#[test]
fn requests_and_answers_are_linked_and_repetitions_and_silence_marked() {
    let folder = Folder::new();
    let exchange = request("- 5D 00").1;
    let diagnosis = request("60 6D").1;
    let telegrams = [
        diagnosis.clone(),
        answer(Some(60), "08 02 05 00 FF 08 E6"),
        exchange.clone(),
        exchange,
        answer(None, "08 00"),
        request("59 7D").1,
        hex("DC 02 02"),
        request("59 7D").1,
        // A damaged stretch that may have another request: the next one is no repetition.
        hex("10 05 02 49 51 16 10 05 02 49 51 16"),
        request("59 7D").1,
        hex("E5"),
    ];
    let capture = capture_without_times(&folder, &telegrams);
    let fields = ["profibus.response_in", "profibus.request_in", "profibus.repeats", "_ws.col.Info"];
    let rows = rows(&capture, &fields);
    let links: Vec<&str> = rows.iter().map(|row| row.rsplit_once('|').unwrap().0).collect();
    assert_eq!(links, ["2||", "|1|", "||", "5||3", "|4|", "||", "||", "||6", "||", "11||", "|10|"], "{rows:?}");
    for (row, end) in [(2, "(no answer)"), (3, "(repetition)"), (5, "(no answer)"), (7, "(repetition) (no answer)")] {
        assert!(rows[row].ends_with(end), "{}", rows[row]);
    }
    assert!(!rows[9].contains("repetition"), "{}", rows[9]);
}

#[test]
fn a_bare_refusal_names_the_service_and_module_status_has_slot_and_specifier() {
    let folder = Folder::new();
    let telegrams = [
        request("60 6D").1,
        answer(Some(60), "08 08 0C 00 02 08 E6 06 82 03 01 02 04"),
        request("59 5D").1,
        answer(None, "03"),
        request("- 7D 00").1,
        answer(None, "02"),
        answer(None, "01"),
    ];
    let capture = capture_without_times(&folder, &telegrams);
    let fields =
        ["profibus.diag.slot", "profibus.diag.specifier", "profibus.diag.module_status", "profibus.refused_service"];
    let rows = rows(&capture, &fields);
    let expected = [
        "|||",
        "3|1|module 0: wrong module,module 5: invalid data|",
        "|||",
        "|||Get_Cfg",
        "|||",
        "|||Data_Exchange",
        "|||",
    ];
    assert_eq!(rows, expected);
    let messages = tshark(&capture, &["-T", "fields", "-e", "_ws.expert.message", "-Y", "frame.number == 7"]);
    assert!(messages.contains("UE: refuses a request that is not in the capture"), "{messages}");
}

/// The rules are those of `decode`, for a device that is not known: profibus-wire 2.3.2.
#[test]
fn a_device_related_block_is_an_alarm_where_the_traffic_shows_dp_v1() {
    let folder = Folder::new();
    let dialogue = [
        ("60 6D", "08 08 0C 00 02 AA AB 04 02 03 09"),
        ("61 5D 88 02 05 0B AA AB 01 00 00 00", "SC"),
        ("60 7D", "08 08 0C 00 02 AA AB 04 02 03 09 04 82 00 01 83 41 B1 83 41 AF"),
        // MS2 refused, and answered: the slave may have a format for each mode.
        ("48 5D 5E 00 11 08", "03"),
        ("60 7D", "08 08 0C 00 02 AA AB 04 02 04 09"),
        ("48 5D 5E 00 11 08", "SC"),
        ("60 7D", "08 08 0C 00 02 AA AB 04 02 05 09"),
        ("61 5D 88 02 05 0B AA AB 01 80 00 00", "SC"),
        ("60 7D", "08 08 0C 00 02 AA AB 04 02 06 09"),
        ("61 5D 40 02 05 0B AA AB 01", "SC"),
        ("60 7D", "08 08 0C 00 02 AA AB 04 02 07 09"),
        // Prm_Fault, MS1, and another device at the address.
        ("61 5D 88 02 05 0B AA AB 01 00 00 00", "SC"),
        ("60 7D", "08 48 0D 00 FF AA AB 04 02 08 09"),
        ("51 5D 5E 00 11 08", "SC"),
        ("60 7D", "08 08 0C 00 02 AA AB 04 02 09 09"),
        ("60 5D", "08 08 0C 00 02 AA AC 04 02 0A 09 04 00 01 01 04 FE 01 01"),
        // Two user octets, and reserved bits: the first are of DP-V0, the second may be.
        ("61 5D 88 02 05 0B AA AC 01 80 02", "SC"),
        ("60 7D", "08 08 0C 00 02 AA AC 04 02 0B 09"),
        ("61 5D 88 02 05 0B AA AC 01 98 12 34", "SC"),
        ("60 7D", "08 08 0C 00 02 AA AC 04 02 0C 09"),
    ];
    let telegrams = dialogue.map(|(asked, message)| {
        let (sap, octets) = request(asked);
        [octets, answer(sap, message)]
    });
    let capture = capture_without_times(&folder, telegrams.as_flattened());
    let fields = ["profibus.diag.device", "profibus.diag.as_dpv1", "profibus.diag.alarm"];
    let rows = rows(&capture, &fields);
    let blocks: Vec<&str> = rows.iter().map(String::as_str).filter(|row| !row.starts_with('|')).collect();
    let expected = [
        "04 02 03 09|04 02 03 09|0x02",
        "04 02 03 09,04 82 00 01|04 82 00 01|0x82",
        "04 02 04 09||",
        "04 02 05 09|04 02 05 09|0x02",
        "04 02 06 09||0x02",
        "04 02 07 09||0x02",
        "04 02 08 09||0x02",
        "04 02 09 09||0x02",
        "04 02 0a 09,04 00 01 01,04 fe 01 01|04 02 0a 09,04 fe 01 01|0x02,0xfe",
        "04 02 0b 09||",
        "04 02 0c 09|04 02 0c 09|0x02",
    ];
    assert_eq!(blocks, expected);
    let tree = tshark(&capture, &["-V"]);
    assert!(tree.contains("Error of the channel: manufacturer specific (17)"), "{tree}");
    assert!(tree.contains("Error of the channel: reserved (15)"), "{tree}");
}

/// The same telegrams through the flight recorder of a segment.
#[test]
fn a_capture_of_the_flight_recorder_is_read_by_wireshark_and_by_decode() {
    let folder = Folder::new();
    let (mut divider, mut pieces) = (Divider::new(Baud::B19200, TimeSource::Exact), Vec::new());
    let trace = services();
    for entry in &trace.entries {
        let (start, octets) = (Some(entry.start), entry.octets.to_vec());
        divider.push(&Chunk { start, octets, errors: entry.errors.clone(), is_continued: false }, &mut pieces);
    }
    divider.end(&mut pieces);
    let limits = FlightLimits { before_ms: 3_600_000, ..FlightLimits::default() };
    let mut flight = FlightRecorder::new(Baud::B19200, limits);
    pieces.iter().for_each(|piece| flight.add(piece));
    let end = trace.entries.back().unwrap().start;
    flight.trigger(end, "a test");
    let capture = flight.take_capture(end + Baud::B19200.tbit_of_ms(60_000)).unwrap();
    let path = folder.name("flight.pcapng");
    std::fs::write(&path, capture.file()).unwrap();
    let (usual, explained) = captured(&folder);
    let fields = ["profibus.sd", "profibus.da", "profibus.sa", "profibus.service"];
    assert_eq!(rows(&path, &fields), rows(&usual, &fields));
    let output = run(&["decode", &path]);
    assert_eq!(output.status.code(), Some(0));
    let without_times = |text: &str| -> Vec<String> {
        text.lines().map(|line| line.trim_start_matches(|it: char| !it.is_alphabetic()).to_owned()).collect()
    };
    let decoded = String::from_utf8(output.stdout).unwrap();
    assert_eq!(without_times(&decoded), without_times(&explained));
}

/// A capture file needs times. Those that a source without times does not have are marked, and are none when the file is read again.
#[test]
fn invented_times_are_marked_in_the_capture_file() {
    let folder = Folder::new();
    let telegrams = [request("60 6D").1, answer(Some(60), "08 02 05 00 FF 08 E6")];
    let capture = capture_without_times(&folder, &telegrams);
    assert_eq!(rows(&capture, &["profibus.invented_time"]), ["1", "1"]);
    let explained = run(&["decode", "--raw", &capture]);
    assert!(String::from_utf8(explained.stdout).unwrap().starts_with("            #1         2 -> 5    Slave_Diag"));
    let (capture, _) = captured(&folder);
    assert!(rows(&capture, &["profibus.invented_time"]).iter().all(String::is_empty));
}
