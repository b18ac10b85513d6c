//! `profivac field-test`: its archive, its replay, and lines that are not as they should be.
//!
//! With `PROFIVAC_FIELD_PORT=/dev/ttyUSB0` (and `PROFIVAC_FIELD_BAUD`, by default 19200) the replay test runs on this port
//! first. Otherwise it uses `tests/field/virtual.tar`, which `PROFIVAC_BLESS=1` makes again.

#![allow(clippy::unwrap_used, clippy::panic, reason = "a test")]

use crate::common::slave_line::SlaveLine;
use crate::common::{Folder, Program, octets, run, run_on_terminal};
use profivac_dp::slave::{CfgFault, Device, Features, Outputs, PrmFault};
use profivac_wire::cfg::Lengths;
use serde_json::Value;
use std::collections::HashMap;
use std::io::{Read, Write};
use std::net::{TcpListener, TcpStream};
use std::path::Path;
use std::process::Output;

/// A slot time of 200 ms, in bit times, so that a loaded computer misses no answer.
const PATIENTLY: &str = "--slot-time=4000";

const STORED: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/field/virtual.tar");

fn complaint(output: &Output) -> String {
    String::from_utf8_lossy(&output.stderr).into_owned()
}

/// The files of an archive by name.
fn files(path: &Path) -> HashMap<String, Vec<u8>> {
    let mut archive = tar::Archive::new(std::fs::File::open(path).unwrap());
    let read = |entry: std::io::Result<tar::Entry<'_, std::fs::File>>| {
        let mut entry = entry.unwrap();
        let name = entry.path().unwrap().file_name().unwrap().to_str().unwrap().to_owned();
        let mut octets = Vec::new();
        entry.read_to_end(&mut octets).unwrap();
        (name, octets)
    };
    archive.entries().unwrap().map(read).collect()
}

fn report(path: &Path) -> Value {
    serde_json::from_slice(&files(path)["report.json"]).unwrap()
}

/// What `profivac decode` prints about the capture of an archive.
fn decoded(folder: &Folder, archive: &Path) -> String {
    let capture = folder.path("capture.pcapng");
    std::fs::write(&capture, &files(archive)["capture.pcapng"]).unwrap();
    let output = run(&["decode", capture.to_str().unwrap()]);
    assert!(output.status.success(), "{}", complaint(&output));
    String::from_utf8(output.stdout).unwrap()
}

/// Virtual gauges on TCP: the program and its port.
fn gauges(devices: &[&str]) -> (Program, String) {
    let program = Program::start(&[&["simulate", "--tcp", "127.0.0.1:0"], devices].concat());
    let port = format!("tcp://{}", program.ready());
    (program, port)
}

/// Replays an archive, whose results must be the same.
fn replay(archive: &str) -> String {
    let output = run(&["field-test", "--replay", archive]);
    let text = String::from_utf8_lossy(&output.stdout).into_owned();
    let advice = "if the rules of `conform` changed, make the archive again with PROFIVAC_BLESS=1";
    assert!(output.status.success(), "{text}{}{advice}", complaint(&output));
    text
}

/// Writes report and capture of the archive `from` to `to`, with a report that `edit` has changed.
fn repack(from: &Path, to: &Path, edit: impl Fn(&mut Value)) {
    let mut report = report(from);
    edit(&mut report);
    let report = serde_json::to_vec_pretty(&report).unwrap();
    let capture = files(from).remove("capture.pcapng").unwrap();
    let mut archive = tar::Builder::new(Vec::new());
    for (name, octets) in [("report.json", report), ("capture.pcapng", capture)] {
        let mut header = tar::Header::new_ustar();
        header.set_size(octets.len() as u64);
        header.set_mode(0o644);
        archive.append_data(&mut header, name, octets.as_slice()).unwrap();
    }
    std::fs::write(to, archive.into_inner().unwrap()).unwrap();
}

/// The kernel of the computer that made the archive is not part of it.
fn bless() {
    let folder = Folder::new();
    let path = folder.name("virtual.tar");
    let (_gauges, port) = gauges(&["bcg450@5", "pcg550@9"]);
    let options = ["--hsa", "10", "--cycles", "20", "--allow-writes", PATIENTLY, "--out", &path];
    let output = run(&[&["field-test", "--port", &port][..], &options].concat());
    assert!(output.status.success(), "{}", complaint(&output));
    repack(Path::new(&path), Path::new(STORED), |report| report["kernel"] = Value::Null);
}

#[test]
fn an_archive_replays_with_the_results_of_its_run() {
    if let Ok(port) = std::env::var("PROFIVAC_FIELD_PORT") {
        let baud = std::env::var("PROFIVAC_FIELD_BAUD").unwrap_or_else(|_| "19200".to_owned());
        let folder = Folder::new();
        let path = folder.name("hardware.tar");
        let output = run(&["field-test", "--port", &port, "--baud", &baud, "--out", &path]);
        assert!(output.status.success(), "{}", complaint(&output));
        replay(&path);
        return;
    }
    if std::env::var("PROFIVAC_BLESS").is_ok_and(|bless| bless == "1") {
        bless();
    }
    let text = replay(STORED);
    assert!(text.starts_with("stations: 2, slaves: 2, rules with the same outcome: "), "{text}");
    assert!(text.ends_with(", rules that the archive does not have: 0\n"), "{text}");
    let rules = report(Path::new(STORED))["slaves"][0]["rules"].as_array().unwrap().clone();
    assert!(rules.iter().any(|rule| rule["name"] == "start-up.exchange"), "{rules:?}");
    assert!(rules.iter().all(|rule| rule["reason"] != NEEDS_WRITES), "the archive has rules that write");
}

/// The reason of a rule that a read-only run does not test.
const NEEDS_WRITES: &str = "it needs requests that change the slave";

#[test]
fn a_replay_with_other_results_is_exit_code_1_and_names_them() {
    let folder = Folder::new();
    let path = folder.path("altered.tar");
    repack(Path::new(STORED), &path, |report| report["slaves"][0]["configuration"] = "44 86 05 05 05 09".into());
    let output = run(&["field-test", "--replay", path.to_str().unwrap()]);
    assert_eq!(output.status.code(), Some(1), "{}", complaint(&output));
    let text = String::from_utf8_lossy(&output.stdout);
    assert!(text.starts_with("the configuration of slave 5: \"44 86 05 05 05 09\" in the archive"), "{text}");
    assert!(complaint(&output).contains("the replay differs from the archive in 1 result;"), "{}", complaint(&output));
}

#[test]
fn an_archive_whose_options_no_run_can_have_is_refused() {
    let folder = Folder::new();
    let path = folder.path("altered.tar");
    for (key, value, reason) in [
        ("cycles", 1_000_000_000_000_000_u64, "found 1000000000000000 cycles in place of 1 to 100000"),
        ("cycles", 0, "found 0 cycles in place of 1 to 100000"),
        ("hsa", 200, "200"),
        ("master", 200, "200"),
    ] {
        repack(Path::new(STORED), &path, |report| report["options"][key] = value.into());
        let output = run(&["field-test", "--replay", path.to_str().unwrap()]);
        assert_eq!(output.status.code(), Some(2), "{key} {value}: {}", complaint(&output));
        assert!(complaint(&output).contains(reason), "{}", complaint(&output));
    }
}

/// Also the promise of the read-only run: no telegram that parameterises reaches the line.
#[test]
fn a_run_without_writes_measures_and_leaves_no_private_data_in_its_archive() {
    let folder = Folder::new();
    let (line, path) = (folder.name("customer-line"), folder.path("line.tar"));
    let gauges = Program::start(&["simulate", "--pty", &line, "bcg450@5"]);
    gauges.ready();
    let out = path.to_str().unwrap();
    // The longest slot time: every request must be answered within it, also on a loaded computer.
    let slot = "--slot-time=16383";
    let output = run(&["field-test", "--port", &line, "--hsa", "6", "--cycles", "25", slot, "--out", out]);
    assert!(output.status.success(), "{}", complaint(&output));
    let report = report(&path);
    assert_eq!((&report["complete"], &report["port"]["name"]), (&Value::from(true), &Value::from("pty")));
    let slave = &report["slaves"][0];
    let figures = &slave["figures"];
    assert_eq!((&figures["requests"], &figures["answered"]), (&Value::from(50), &Value::from(50)), "{figures}");
    assert_eq!(figures["turnaround"]["count"], 50);
    let count =
        |outcome: &str| slave["rules"].as_array().unwrap().iter().filter(|rule| rule["outcome"] == outcome).count();
    let withheld = slave["rules"].as_array().unwrap().iter().filter(|rule| rule["reason"] == NEEDS_WRITES).count();
    assert!(withheld > 0 && count("broken") == 0 && count("passed") > 0, "{slave}");
    let (reading, writing) = (decoded(&folder, &path), decoded(&folder, Path::new(STORED)));
    assert!(reading.contains("is present: bcg450"), "{reading}");
    for words in ["sets its parameters", "asks for the configuration", "exchanges data with"] {
        assert!(writing.contains(words), "{words}: {writing}");
        assert!(!reading.contains(words), "{words}: {reading}");
    }
    let host = std::fs::read_to_string("/proc/sys/kernel/hostname").unwrap_or_default();
    for (name, octets) in files(&path) {
        let text = String::from_utf8_lossy(&octets).into_owned();
        let folder = folder.name("");
        for private in ["customer-line", folder.trim_end_matches('/'), host.trim()].iter().filter(|text| text.len() > 3)
        {
            assert!(!text.contains(private), "{private} in {name}");
        }
    }
    replay(out);
}

/// Two modules have the same configuration octets and different parameters.
const UNCLEAR: &str = "#Profibus_DP
Vendor_Name = \"Acme\"
Model_Name = \"Valve station\"
Ident_Number = 0x1234
Modular_Station = 1
Max_Module = 4
19.2_supp = 1
Module = \"4DO\" 0x20
7
EndModule
Module = \"4DO HF\" 0x20
8
Ext_Module_Prm_Data_Len = 1
Ext_User_Prm_Data_Const(0) = 0x55
EndModule
";

/// A slave with outputs that is no gauge, its port, and the folder of its GSD file, which is called `customer`.
fn valves(folder: &Folder) -> (Program, String, String) {
    let gsd = folder.name("customer");
    std::fs::create_dir(&gsd).unwrap();
    std::fs::write(folder.path("customer/valves.gsd"), UNCLEAR).unwrap();
    let (program, port) = gauges(&[&format!("{gsd}/valves.gsd@4:modules=7")]);
    (program, port, gsd)
}

fn number_of_rules(slave: &Value, outcome: &str) -> usize {
    slave["rules"].as_array().unwrap().iter().filter(|rule| rule["outcome"] == outcome).count()
}

#[test]
fn a_gsd_file_that_leaves_the_modules_unclear_costs_no_rule_that_reads_and_is_not_named_in_the_archive() {
    let folder = Folder::new();
    let (_slave, port, gsd) = valves(&folder);
    for (name, options) in [("reading.tar", &[][..]), ("writing.tar", &["--allow-writes", "--own"])] {
        let path = folder.path(name);
        let fixed = ["field-test", "--port", &port, "--hsa", "4", "--cycles", "1", PATIENTLY, "--gsd", &gsd];
        let output = run(&[&fixed[..], &["--out", path.to_str().unwrap()], options].concat());
        assert_eq!(output.status.code(), Some(0), "{}", complaint(&output));
        assert!(complaint(&output).contains("customer/valves.gsd: modules with the same"), "{}", complaint(&output));
        let slave = &report(&path)["slaves"][0];
        assert!(number_of_rules(slave, "passed") > 0, "{slave}");
        assert_eq!(slave["rules_note"], Value::Null);
        assert!(
            slave["limits_note"].as_str().unwrap().starts_with("the modules of the slave are not clear"),
            "{slave}"
        );
        assert!(!decoded(&folder, &path).contains("sets its parameters"));
        for (name, octets) in files(&path) {
            assert!(!String::from_utf8_lossy(&octets).contains("customer"), "{name}");
        }
        replay(path.to_str().unwrap());
    }
}

/// Zeros can stop a pump or close a valve.
#[test]
fn a_slave_that_is_no_gauge_gets_zeros_only_if_the_user_agrees() {
    let folder = Folder::new();
    let (_slave, port, _) = valves(&folder);
    let fixed = ["field-test", "--port", &port, "--hsa", "4", "--cycles", "1", "--allow-writes", PATIENTLY];
    let zeros = "the slave at address 4 gets 1 octets of outputs, all zero; zeros can stop a pump or close a valve";
    let script = folder.path("script.tar");
    let output = run(&[&fixed[..], &["--out", script.to_str().unwrap()]].concat());
    assert_eq!(output.status.code(), Some(0), "{}", complaint(&output));
    let advice = format!("{zeros}; only rules that read are tested with it; without a terminal add --own to test all");
    assert!(complaint(&output).contains(&advice), "{}", complaint(&output));
    let asked = folder.path("asked.tar");
    let arguments = [&fixed[..], &["--out", asked.to_str().unwrap()]].concat();
    let (code, _, shown) = run_on_terminal(&arguments, "Continue? [y/N] ", "n\n");
    assert_eq!(code, 0, "{shown}");
    assert!(shown.contains(zeros), "{shown}");
    for path in [script, asked] {
        let slave = &report(&path)["slaves"][0];
        assert!(slave["limits_note"].as_str().unwrap().starts_with("nobody has agreed to zeros"), "{slave}");
        assert!(number_of_rules(slave, "passed") > 0, "{slave}");
        assert!(!decoded(&folder, &path).contains("sets its parameters"));
        replay(path.to_str().unwrap());
    }
}

/// A slave that answers Get_Cfg without a configuration.
struct WithoutCfg;

impl Device for WithoutCfg {
    fn ident_number(&self) -> u16 {
        0x1234
    }

    fn features(&self) -> Features {
        Features::default()
    }

    fn set_prm(&mut self, _: &[u8]) -> Result<(), PrmFault> {
        panic!("a slave without configuration gets no parameters")
    }

    fn chk_cfg(&mut self, _: &[u8]) -> Result<Lengths, CfgFault> {
        Err(CfgFault)
    }

    fn get_cfg(&self) -> &[u8] {
        &[]
    }

    fn outputs(&mut self, _: Outputs<'_>) {}

    fn inputs(&mut self, _: &mut [u8]) {}
}

#[test]
fn without_get_cfg_the_rules_that_read_are_tested_and_the_report_says_why_not_all() {
    let (folder, line) = (Folder::new(), SlaveLine::start(WithoutCfg));
    let path = folder.path("silent.tar");
    let out = path.to_str().unwrap();
    let output = run(&[
        "field-test",
        "--port",
        &line.port(),
        "--hsa",
        "10",
        "--cycles",
        "1",
        "--allow-writes",
        "--own",
        PATIENTLY,
        "--out",
        out,
    ]);
    assert_eq!(output.status.code(), Some(0), "{}", complaint(&output));
    let slave = &report(&path)["slaves"][0];
    assert!(slave["limits_note"].as_str().unwrap().starts_with("the slave does not answer Get_Cfg: "), "{slave}");
    assert_eq!((&slave["rules_note"], &slave["configuration"]), (&Value::Null, &Value::Null));
    assert!(number_of_rules(slave, "passed") > 0, "{slave}");
    let text = String::from_utf8(files(&path)["report.txt"].clone()).unwrap();
    assert!(text.contains("the slave does not answer Get_Cfg"), "{text}");
    replay(out);
}

/// A line on which this test is the other side, one connection for each opening of the port.
fn server() -> (TcpListener, String) {
    let server = TcpListener::bind("127.0.0.1:0").unwrap();
    let port = format!("tcp://{}", server.local_addr().unwrap());
    (server, port)
}

fn field_test(port: &str, path: &Path, options: &[&str]) -> Program {
    let fixed = ["field-test", "--port", port, "--out", path.to_str().unwrap(), "--hsa", "6"];
    Program::start(&[&fixed[..], options].concat())
}

#[test]
fn beside_another_master_nothing_is_sent_and_its_data_are_not_in_the_archive() {
    let folder = Folder::new();
    let path = folder.path("line.tar");
    let (server, port) = server();
    // It listens for six slot times: 5 s, enough for a loaded computer to send two tokens and a telegram.
    let mut program = field_test(&port, &path, &["--slot-time", "16383"]);
    let (mut line, _) = server.accept().unwrap();
    let outputs = "68 07 07 68 05 02 7D 41 42 43 44 8E 16";
    line.write_all(&octets(&format!("DC 02 02 {outputs} DC 02 02"))).unwrap();
    assert_eq!(program.exit_code(), 3);
    let mut sent = Vec::new();
    line.read_to_end(&mut sent).unwrap();
    assert_eq!(sent, [0; 0], "it only listens");
    server.set_nonblocking(true).unwrap();
    assert!(server.accept().is_err(), "the line was opened again");
    let report = report(&path);
    assert_eq!((&report["complete"], &report["other_masters"][0]), (&Value::from(false), &Value::from(2)));
    assert!(report["end"].as_str().unwrap().starts_with("master 2 is using the line"), "{}", report["end"]);
    let capture = &files(&path)["capture.pcapng"];
    let has = |octets: &[u8]| capture.windows(octets.len()).any(|window| window == octets);
    assert!(has(&[0x68, 7, 7, 0x68, 5, 2, 0x7D, 0, 0, 0, 0]) && !has(b"ABCD"));
}

#[test]
fn a_port_that_is_lost_leaves_a_partial_archive_that_says_so() {
    let folder = Folder::new();
    let path = folder.path("line.tar");
    let (server, port) = server();
    let mut program = field_test(&port, &path, &[]);
    let _listening = server.accept().unwrap();
    let (mut line, _): (TcpStream, _) = server.accept().unwrap();
    line.read_exact(&mut [0; 6]).unwrap();
    drop((line, server));
    assert_eq!(program.exit_code(), 3);
    let report = report(&path);
    assert_eq!(
        (&report["complete"], &report["end"]),
        (&Value::from(false), &Value::from("lost tcp: it was unplugged, or its other side was closed"))
    );
    let output = run(&["field-test", "--replay", path.to_str().unwrap()]);
    assert_eq!(output.status.code(), Some(2));
    assert!(complaint(&output).contains("found one that ended early: lost tcp"), "{}", complaint(&output));
}

#[test]
fn ctrl_c_leaves_a_partial_archive_with_the_figures_so_far() {
    let folder = Folder::new();
    let path = folder.path("line.tar");
    let (_gauges, port) = gauges(&["bcg450@5"]);
    let mut program = field_test(&port, &path, &["--cycles", "100000", PATIENTLY]);
    program.wait_for_complaint("slave 5: measuring");
    program.interrupt();
    assert_eq!(program.exit_code(), 3);
    let report = report(&path);
    assert_eq!((&report["complete"], &report["end"]), (&Value::from(false), &Value::from("interrupted by a signal")));
    assert_eq!(report["slaves"][0]["figures"]["missing"], 0);
    let left: Vec<_> = std::fs::read_dir(folder.path("")).unwrap().map(|file| file.unwrap().file_name()).collect();
    assert_eq!(left, ["line.tar"], "the temporary file has become the archive");
}

/// A line between the program and the virtual gauges at `gauges`. A run opens it once for each step: listen, scan, the rules of
/// each slave, the measurement of each slave. In the step `number` it is cut after this many requests.
fn line_cut_in_step(number: usize, requests: usize, gauges: &str) -> String {
    let (server, port) = server();
    let gauges = gauges.strip_prefix("tcp://").unwrap().to_owned();
    std::thread::spawn(move || {
        for (step, master) in server.incoming().enumerate() {
            let (mut master, mut line) = (master.unwrap(), TcpStream::connect(&gauges).unwrap());
            let (mut answers, mut back) = (line.try_clone().unwrap(), master.try_clone().unwrap());
            for stream in [&master, &line] {
                stream.set_nodelay(true).unwrap();
            }
            std::thread::spawn(move || std::io::copy(&mut answers, &mut back));
            let mut left = if step == number { requests } else { usize::MAX };
            let mut request = [0; 512];
            // A master sends the next request after the answer, so the octets that come at once are one request.
            while let Ok(length @ 1..) = master.read(&mut request) {
                if left > 0 {
                    line.write_all(&request[..length]).unwrap();
                    left -= 1;
                }
            }
            line.shutdown(std::net::Shutdown::Both).ok();
        }
    });
    port
}

#[test]
fn a_slave_that_vanishes_is_given_up_and_the_run_goes_on() {
    let folder = Folder::new();
    let path = folder.path("line.tar");
    let (_gauges, port) = gauges(&["bcg450@3", "bcg450@5"]);
    let mut program = field_test(&line_cut_in_step(4, 20, &port), &path, &["--cycles", "30", PATIENTLY]);
    assert_eq!(program.exit_code(), 3);
    let report = report(&path);
    assert_eq!(report["complete"], true);
    assert_eq!(report["end"], "the slave at address 3 stopped answering");
    let [gone, there] = [0, 1].map(|number| &report["slaves"][number]);
    assert_eq!(gone["figures_note"], "the slave left 10 requests unanswered and was given up");
    // A computer with other work loses answers of its own, so only the sums are certain.
    let [answered, missing] = ["answered", "missing"].map(|key| gone["figures"][key].as_u64().unwrap());
    assert!((1..=20).contains(&answered) && missing >= 10, "{answered} answered, {missing} missing");
    let asked = there["figures"]["answered"].as_u64().unwrap() + there["figures"]["missing"].as_u64().unwrap();
    assert_eq!((&there["address"], asked), (&Value::from(5), 60));
    replay(path.to_str().unwrap());
}

#[test]
fn a_line_without_stations_is_a_complete_archive_and_exit_code_3() {
    let folder = Folder::new();
    let (path, line, other) = (folder.path("line.tar"), folder.name("line"), folder.name("other"));
    let hub = Program::start(&["hub", "--pty", &line, "--pty", &other]);
    hub.ready();
    let output = run(&["field-test", "--port", &line, "--hsa", "3", "--out", path.to_str().unwrap()]);
    assert_eq!(output.status.code(), Some(3), "{}", complaint(&output));
    let report = report(&path);
    assert_eq!((&report["complete"], &report["stations"]), (&Value::from(true), &Value::Array(Vec::new())));
    assert!(report["end"].as_str().unwrap().starts_with("no station answers on pty"), "{}", report["end"]);
}

#[test]
fn what_cannot_begin_leaves_no_file() {
    let folder = Folder::new();
    let (absent, path) = (folder.name("absent"), folder.name("line.tar"));
    let missing = run(&["field-test", "--port", &absent, "--out", &path]);
    assert_eq!(missing.status.code(), Some(3));
    assert!(complaint(&missing).contains(&format!("there is no port {absent}")), "{}", complaint(&missing));
    assert_eq!(std::fs::read_dir(folder.path("")).unwrap().count(), 0);
    let compressed = run(&["field-test", "--port", &absent, "--out", &folder.name("line.tar.gz")]);
    assert!(complaint(&compressed).contains("the archive is not compressed"), "{}", complaint(&compressed));
    std::fs::write(&path, "mine").unwrap();
    let taken = run(&["field-test", "--port", &absent, "--out", &path]);
    assert_eq!((compressed.status.code(), taken.status.code()), (Some(2), Some(2)));
    assert!(complaint(&taken).contains("exists already: give another name with --out"), "{}", complaint(&taken));
    assert_eq!(std::fs::read(&path).unwrap(), b"mine");
    let unreachable = run(&["field-test", "--port", &absent, "--out", &folder.name("missing/line.tar")]);
    assert!(complaint(&unreachable).contains("cannot be written"), "{}", complaint(&unreachable));
    assert_eq!(unreachable.status.code(), Some(2));
}
