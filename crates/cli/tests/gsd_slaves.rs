//! Slaves of any vendor by their GSD files: `scan`, `monitor` and `conform` with `--gsd`.

#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic, clippy::indexing_slicing, reason = "a test")]

use crate::common::slave_line::{ADDRESS, SlaveLine};
use crate::common::{End, Folder, on_terminal, run, run_on_terminal, sd2};
use profivac_dp::slave::{CfgFault, Device, Diagnosis, Features, Outputs, PrmFault};
use profivac_wire::cfg;
use serde_json::Value;
use std::fs;
use std::io::{self, Write};
use std::net::{Shutdown, TcpListener, TcpStream};
use std::process::Output;
use std::sync::mpsc::{Receiver, channel};
use std::sync::{Arc, Mutex};
use std::thread;
use std::time::Duration;

/// Waits longer for answers: the load of the computer delays them too.
const PATIENTLY: &str = "--slot-time=4000";

/// An input module, an output module with a parameter, and one with the same octets and another parameter.
const STATION: &str = "#Profibus_DP
Vendor_Name = \"Acme\"
Model_Name = \"Valve station\"
Ident_Number = 0x1234
Modular_Station = 1
Max_Module = 4
ExtUserPrmData = 1 \"Delay\"
Unsigned8 5 0-20
EndExtUserPrmData
Unit_Diag_Bit(1) = \"no air\"
Channel_Diag(17) = \"coil open\"
Module = \"4DI\" 0x10
3
EndModule
Module = \"4DO\" 0x20
7
Ext_Module_Prm_Data_Len = 1
Ext_User_Prm_Data_Ref(0) = 1
EndModule
Module = \"4DO HF\" 0x20
8
Ext_Module_Prm_Data_Len = 1
Ext_User_Prm_Data_Const(0) = 0x55
EndModule
";

/// The slave with the octets of such a file.
struct Station {
    cfg: &'static [u8],
    prm: &'static [u8],
    outputs: Arc<Mutex<Vec<Vec<u8>>>>,
}

impl Device for Station {
    fn ident_number(&self) -> u16 {
        0x1234
    }

    fn features(&self) -> Features {
        Features::default()
    }

    fn set_prm(&mut self, user: &[u8]) -> Result<(), PrmFault> {
        if user == self.prm { Ok(()) } else { Err(PrmFault) }
    }

    fn chk_cfg(&mut self, octets: &[u8]) -> Result<cfg::Lengths, CfgFault> {
        if octets == self.cfg { cfg::lengths(octets).map_err(|_| CfgFault) } else { Err(CfgFault) }
    }

    fn get_cfg(&self) -> &[u8] {
        self.cfg
    }

    fn outputs(&mut self, outputs: Outputs<'_>) {
        if let Outputs::Data(octets) = outputs {
            self.outputs.lock().unwrap().push(octets.to_vec());
        }
    }

    fn inputs(&mut self, inputs: &mut [u8]) {
        inputs.fill(0xA5);
    }

    fn diagnosis(&self) -> Diagnosis<'_> {
        // No air; channel 2 of identifier 0, an input, has the error 17.
        Diagnosis { event: true, static_diag: false, blocks: &[0x02, 0x02, 0x80, 0x42, 0x31] }
    }
}

struct Bench {
    line: SlaveLine,
    folder: Folder,
    outputs: Arc<Mutex<Vec<Vec<u8>>>>,
}

impl Bench {
    /// A slave with this configuration and these parameters, and a folder with files.
    fn new(cfg: &'static [u8], prm: &'static [u8], files: &[(&str, &str)]) -> Self {
        let outputs = Arc::default();
        let line = SlaveLine::start(Station { cfg, prm, outputs: Arc::clone(&outputs) });
        let folder = Folder::new();
        for (name, text) in files {
            fs::write(folder.path(name), text).unwrap();
        }
        Self { line, folder, outputs }
    }

    fn valves() -> Self {
        Self::new(&[0x10, 0x20], &[9], &[("valves.gsd", STATION)])
    }

    fn run(&self, command: &[&str], options: &[&str]) -> Output {
        let gsd = self.folder.name("");
        run(&[command, &["--port", &self.line.port(), "--gsd", &gsd], options].concat())
    }

    fn monitor(&self, options: &[&str]) -> Output {
        self.run(&["monitor"], &[&["--for", "3", "--own", "--json", "9"], options].concat())
    }
}

fn text(octets: &[u8]) -> String {
    String::from_utf8(octets.to_vec()).unwrap()
}

fn refused(output: &Output) -> String {
    assert_eq!(output.status.code(), Some(2), "{}", text(&output.stderr));
    text(&output.stderr)
}

#[test]
fn scan_names_a_slave_by_its_gsd_file() {
    let bench = Bench::valves();
    let table = bench.run(&["scan", "--hsa", "9"], &[]);
    assert!(text(&table.stdout).contains("Acme Valve station (valves.gsd)\n"), "{}", text(&table.stdout));
    let rows: Value = serde_json::from_slice(&bench.run(&["scan", "--hsa", "9"], &["--json"]).stdout).unwrap();
    assert_eq!(rows[0]["gsd"][0]["vendor"], "Acme");
    assert_eq!(rows[0]["gsd"][0]["file"], Value::from(bench.folder.name("valves.gsd")));
    assert_eq!(rows[0].get("narrowed_by"), None);
}

#[test]
fn scan_lists_all_devices_of_an_ident_and_narrows_them_by_the_configuration() {
    let other = STATION.replace("Valve station", "Drive").replace("0x10\n", "0x31\n");
    let third = STATION.replace("Valve station", "Valve station 2");
    let files = [("valves.gsd", STATION), ("drive.gsd", &other), ("valves2.gsd", &third)];
    let bench = Bench::new(&[0x10, 0x20], &[9], &files);
    let output = bench.run(&["scan", "--hsa", "9"], &[]);
    let (shown, said) = (text(&output.stdout), text(&output.stderr));
    assert!(shown.contains("Acme Valve station (valves.gsd) or Acme Valve station 2 (valves2.gsd)\n"), "{shown}");
    let remark = "address 9: 3 devices of the GSD files have the ident 0x1234; only the named devices can have its configuration 10 20";
    assert!(said.contains(remark), "{said}");
    let rows: Value = serde_json::from_slice(&bench.run(&["scan", "--hsa", "9"], &["--json"]).stdout).unwrap();
    assert_eq!((rows[0]["gsd"].as_array().unwrap().len(), &rows[0]["narrowed_by"]), (2, &"10 20".into()));
}

#[test]
fn scan_says_when_no_device_of_the_ident_has_the_configuration() {
    let other = STATION.replace("Valve station", "Drive");
    let bench = Bench::new(&[0x33], &[], &[("valves.gsd", STATION), ("drive.gsd", &other)]);
    let output = bench.run(&["scan", "--hsa", "9"], &[]);
    assert!(text(&output.stdout).contains("Acme Drive (drive.gsd) or Acme Valve station (valves.gsd)"));
    assert!(text(&output.stderr).contains("none of them can have its configuration 33"), "{}", text(&output.stderr));
}

#[test]
fn monitor_owns_a_slave_with_the_modules_and_parameters_of_its_file() {
    let bench = Bench::valves();
    let output = bench.monitor(&["--modules", "9=3+7", "--set", "9=Delay=9", "--outputs", "9=0F"]);
    let said = text(&output.stderr);
    assert_eq!(output.status.code(), Some(0), "{said}");
    let row: Value = serde_json::from_str(text(&output.stdout).lines().last().unwrap()).unwrap();
    assert_eq!((&row["device"], &row["state"]), (&"Valve station".into(), &"DATA".into()));
    assert_eq!(row["modules"], serde_json::json!([{"slot": 1, "module": "4DI", "inputs": "A5"}]));
    let remarks = row["remarks"].to_string();
    assert!(remarks.contains("no air"), "{remarks}");
    assert!(
        remarks.contains("identifier 0 (slot 1, module 4DI), input channel 2 (bit): error 17 coil open"),
        "{remarks}"
    );
    assert!(said.contains(
        "it gets slot 1 4DI, slot 2 4DO with the configuration 10 20, the user parameters 09 and the outputs 0F"
    ));
    let outputs = bench.outputs.lock().unwrap().clone();
    assert!(!outputs.is_empty() && outputs.iter().all(|octets| octets == &[0x0F]), "{outputs:02X?}");
    assert_eq!(bench.line.owner(), Value::Null);
}

/// Two modules of the file have the same octets.
#[test]
fn the_diagnosis_names_the_modules_that_the_user_has_chosen() {
    let bench = Bench::new(&[0x20, 0x10], &[5], &[("valves.gsd", STATION)]);
    let output = bench.monitor(&["--modules", "9=7+3", "--outputs", "9=00"]);
    assert_eq!(output.status.code(), Some(0), "{}", text(&output.stderr));
    let said = text(&output.stdout);
    assert!(said.contains("identifier 0 (slot 1, module 4DO), input channel 2 (bit): error 17 coil open"), "{said}");
    assert!(!said.contains("4DO HF"), "{said}");
}

#[test]
fn modules_and_parameters_can_be_in_a_file() {
    let bench = Bench::valves();
    let path = bench.folder.name("choice.toml");
    fs::write(&path, "[modules]\n1 = \"4DI\"\n2 = \"4DO\"\n[slot.2.parameters]\nDelay = 9\n").unwrap();
    let modules = format!("9={path}");
    let output = bench.monitor(&["--modules", &modules, "--outputs", "9=00"]);
    assert_eq!(output.status.code(), Some(0), "{}", text(&output.stderr));
    fs::write(&path, "[modules]\n1 = \"4DI\"\n2 = \"4D0\"\n").unwrap();
    let said = refused(&bench.monitor(&["--modules", &modules, "--outputs", "9=00"]));
    assert!(said.contains("did you mean \"4DO\"?"), "{said}");
}

/// Zeros can stop a pump or close a valve.
#[test]
fn a_slave_with_outputs_is_not_owned_by_a_script_that_does_not_give_them() {
    let bench = Bench::valves();
    let choice = ["--modules", "9=3+7", "--set", "9=Delay=9"];
    let said = refused(&bench.monitor(&choice));
    assert!(said.contains("slot 2 4DO: 00") && said.contains("zeros can stop a pump"), "{said}");
    assert!(said.contains("nothing was sent") && said.contains("--outputs \"9=00\""), "{said}");
    let said = refused(&bench.monitor(&[&choice[..], &["--outputs", "9=00 00"]].concat()));
    assert!(said.contains("expected 1 octets of outputs") && said.contains("got 2"), "{said}");
    assert!(bench.outputs.lock().unwrap().is_empty());
}

#[test]
fn on_a_terminal_monitor_shows_the_outputs_and_asks() {
    let bench = Bench::valves();
    let gsd = bench.folder.name("");
    let port = bench.line.port();
    let arguments = [
        "monitor",
        "--port",
        &port,
        "--gsd",
        &gsd,
        "--modules",
        "9=3+7",
        "--set",
        "9=Delay=9",
        "--own",
        "--json",
        "--for",
        "3",
        "9",
    ];
    let (code, _, shown) = run_on_terminal(&arguments, "Continue? [y/N] ", "n\n");
    assert_eq!(code, 2, "{shown}");
    assert!(shown.contains("slot 2 4DO: 00"), "{shown}");
    assert!(bench.outputs.lock().unwrap().is_empty());
    let (code, out, shown) = run_on_terminal(&arguments, "Continue? [y/N] ", "y\n");
    assert_eq!(code, 0, "{shown}");
    assert!(out.contains("\"module\":\"4DI\""), "{out}");
}

/// A line to the slave that tells when the program has closed it.
fn watched_line(slave: &str) -> (String, Receiver<()>) {
    let server = TcpListener::bind("127.0.0.1:0").unwrap();
    let port = format!("tcp://{}", server.local_addr().unwrap());
    let (slave, (sender, closed)) = (slave.to_owned(), channel());
    thread::spawn(move || {
        for master in server.incoming().map_while(Result::ok) {
            let line = TcpStream::connect(&slave).unwrap();
            let (mut to, mut from) = (line.try_clone().unwrap(), line);
            let (mut back, mut master) = (master.try_clone().unwrap(), master);
            for stream in [&master, &from] {
                stream.set_nodelay(true).unwrap();
            }
            thread::spawn(move || io::copy(&mut from, &mut back));
            io::copy(&mut master, &mut to).ok();
            to.shutdown(Shutdown::Both).ok();
            if sender.send(()).is_err() {
                return;
            }
        }
    });
    (port, closed)
}

/// A master that waits for an answer of the user must not be in the token ring.
#[test]
fn while_the_user_is_asked_no_session_is_open() {
    let bench = Bench::valves();
    let gsd = bench.folder.name("");
    for command in [
        &["monitor", "--modules", "9=3+7", "--set", "9=Delay=9", "--own", "--json", "9"][..],
        &["conform", "--modules", "3+7", "--set", "Delay=9", "--address", "9"],
    ] {
        let (port, closed) = watched_line(&bench.line.address);
        let arguments = [command, &["--port", &port, "--gsd", &gsd, PATIENTLY]].concat();
        let (code, _, shown, _) = on_terminal(&arguments, "Continue? [y/N] ", |_, terminal| {
            closed.recv_timeout(Duration::from_secs(60)).expect("the session is open while the user is asked");
            terminal.write_all(b"n\n").unwrap();
        });
        assert_eq!(code, 2, "{shown}");
        assert!(shown.contains("slot 2 4DO: 00"), "{shown}");
    }
    assert!(bench.outputs.lock().unwrap().is_empty());
}

/// The label of the slave tells the user which device it is.
#[test]
fn on_a_terminal_the_user_chooses_among_devices_with_one_ident_and_no_session_is_open() {
    let other = STATION.replace("Valve station", "Valve station 2");
    let bench = Bench::new(&[0x10], &[], &[("a.gsd", STATION), ("b.gsd", &other)]);
    let gsd = bench.folder.name("");
    let prompt = "Number of the right one [1-2, Enter: none] ";
    for command in [&["monitor", "--own", "--json", "9"][..], &["conform", "--address", "9"]] {
        let (port, closed) = watched_line(&bench.line.address);
        let arguments = [command, &["--port", &port, "--gsd", &gsd, PATIENTLY]].concat();
        let (code, _, shown, rest) = on_terminal(&arguments, prompt, |_, terminal| {
            closed.recv_timeout(Duration::from_secs(60)).expect("the session is open while the user is asked");
            terminal.write_all(b"\n").unwrap();
        });
        assert_eq!(code, 2, "{shown}{rest}");
        assert!(shown.contains("1  Acme Valve station in "), "{shown}");
        assert!(shown.contains("2  Acme Valve station 2 in "), "{shown}");
        assert!(rest.contains("no device was chosen; name the right file with --gsd"), "{rest}");
    }
    let port = bench.line.port();
    let arguments = ["monitor", "--port", &port, "--gsd", &gsd, PATIENTLY, "--own", "--json", "--for", "3", "9"];
    let (code, out, shown) = run_on_terminal(&arguments, prompt, "2\n");
    assert_eq!(code, 0, "{shown}");
    assert!(out.contains("\"module\":\"4DI\""), "{out}");
}

/// Without a GSD file the outputs are counted.
#[test]
fn conform_asks_before_it_sends_zeros_to_a_slave_that_is_no_gauge() {
    let bench = Bench::valves();
    let port = bench.line.port();
    let arguments = ["conform", "--port", &port, "--address", "9"];
    let (code, _, shown) = run_on_terminal(&arguments, "Continue? [y/N] ", "n\n");
    assert_eq!(code, 2, "{shown}");
    assert!(
        shown.contains("the slave at address 9 gets 1 octets of outputs, all zero; zeros can stop a pump"),
        "{shown}"
    );
    assert!(bench.outputs.lock().unwrap().is_empty());
    assert_eq!(bench.line.owner(), Value::Null);
}

#[test]
fn modules_that_the_slave_does_not_have_are_wrong_usage_of_conform() {
    let bench = Bench::valves();
    let said = refused(&bench.run(&["conform"], &["--address", "9", "--own", "--modules", "7+3"]));
    let sentence =
        "the slave at address 9 has the configuration 10 20, the chosen modules need 20 10; choose the plugged modules";
    assert!(said.contains(sentence), "{said}");
}

#[test]
fn monitor_says_that_the_slave_may_refuse_modules_and_that_the_file_lacks_the_rate() {
    let file = STATION.replace("Ident_Number", "500_supp = 1\nIdent_Number");
    let bench = Bench::new(&[0x10, 0x20], &[9], &[("valves.gsd", &file)]);
    let output = bench.monitor(&["--modules", "9=7+3", "--outputs", "9=00"]);
    let said = text(&output.stderr);
    assert!(
        said.contains("the slave at address 9 has the configuration 10 20, the chosen modules need 20 10; the slave may refuse them"),
        "{said}"
    );
    assert!(said.contains("slave at address 9: the GSD file does not have 19.2 kbit/s; it has 500 kbit/s"), "{said}");
}

#[test]
fn a_slave_without_outputs_needs_no_agreement() {
    let bench = Bench::new(&[0x10], &[], &[("valves.gsd", STATION)]);
    let output = bench.monitor(&[]);
    assert_eq!(output.status.code(), Some(0), "{}", text(&output.stderr));
    assert!(text(&output.stdout).contains("\"module\":\"4DI\""), "the modules of Get_Cfg");
}

#[test]
fn modules_with_the_same_octets_and_other_parameters_must_be_chosen() {
    let said = refused(&Bench::valves().monitor(&["--outputs", "9=00"]));
    assert!(said.contains("slot 2") && said.contains("7 (4DO), 8 (4DO HF)") && said.contains("--modules"), "{said}");
}

#[test]
fn a_slave_of_another_master_is_read_by_module_and_keeps_its_owner() {
    let bench = Bench::valves();
    let mut master = End::tcp(&bench.line.address);
    master.ask(&sd2(ADDRESS, 61, 0x6D, "80 00 00 0B 12 34 00 09"), "E5");
    master.ask(&sd2(ADDRESS, 62, 0x5D, "10 20"), "E5");
    drop(master);
    let output = bench.monitor(&[]);
    assert_eq!(output.status.code(), Some(0), "{}", text(&output.stderr));
    let row: Value = serde_json::from_str(text(&output.stdout).lines().last().unwrap()).unwrap();
    assert_eq!((&row["state"], &row["modules"][0]["module"]), (&"READ".into(), &"4DI".into()));
    assert!(row["remarks"].to_string().contains("coil open"), "{row}");
    assert_eq!(bench.line.owner(), 2);
}

#[test]
fn wrong_choices_are_refused_with_the_possible_ones() {
    let bench = Bench::valves();
    for (options, part) in [
        (&["--modules", "9=3+9"][..], "the file has no module 9; it has 3 (4DI), 7 (4DO), 8 (4DO HF)"),
        (&["--modules", "9=3,7"], "3+7"),
        (&["--modules", "9=3+7", "--set", "9=Dealy=9"], "did you mean \"Delay\"?"),
        (&["--modules", "9=3+7", "--set", "9=Delay=21"], "0 to 20"),
        (&["--modules", "8=3+7"], "address 8, which is not monitored"),
        (&["--modules", "9=missing.toml"], "missing.toml cannot be read"),
    ] {
        let said = refused(&bench.monitor(&[options, &["--outputs", "9=00"]].concat()));
        assert!(said.contains(part), "{said}");
    }
    let without = run(&["monitor", "--port", "none", "--own", "--modules", "9=3", "9"]);
    assert!(refused(&without).contains("--gsd"));
    let missing = run(&["scan", "--port", "none", "--gsd", "missing.gsd"]);
    assert!(refused(&missing).contains("missing.gsd cannot be read"));
}

#[test]
fn two_files_with_one_ident_are_both_named_before_a_slave_is_owned() {
    let other = STATION.replace("Valve station", "Valve station 2");
    let bench = Bench::new(&[0x10], &[], &[("a.gsd", STATION), ("b.gsd", &other)]);
    let said = refused(&bench.monitor(&[]));
    assert!(["a.gsd", "b.gsd"].iter().all(|name| said.contains(&bench.folder.name(name))), "{said}");
    let languages = Bench::new(&[0x10], &[], &[("a.gse", STATION), ("a.gsg", &other)]);
    assert_eq!(languages.monitor(&[]).status.code(), Some(0));
}
