//! `monitor` shows the inputs of a slave that is no known device as octets.

#![allow(clippy::unwrap_used, clippy::panic, reason = "a test")]

use crate::common::slave_line::{ADDRESS, SlaveLine};
use crate::common::{End, run, sd2};
use profivac_dp::slave::{CfgFault, Device, Dpv1Error, Features, Outputs, PrmFault, Relation};
use profivac_wire::cfg;
use serde_json::Value;
use std::process::Output;

/// Two octets of inputs and two of outputs, an ident number that no gauge has, and three octets of user parameters or none.
struct UnknownDevice {
    prm_length: usize,
    /// The record at slot 1, index 24.
    record: [u8; 2],
}

impl Device for UnknownDevice {
    fn ident_number(&self) -> u16 {
        0x1234
    }

    fn features(&self) -> Features {
        Features { dpv1: true, ..Features::default() }
    }

    fn read(&mut self, _via: Relation, slot: u8, index: u8, record: &mut [u8]) -> Result<usize, Dpv1Error> {
        if (slot, index) != (1, 24) {
            return Err(Dpv1Error::INVALID_INDEX);
        }
        record[..2].copy_from_slice(&self.record);
        Ok(2)
    }

    fn write(&mut self, _via: Relation, slot: u8, index: u8, record: &[u8]) -> Result<(), Dpv1Error> {
        if (slot, index) != (1, 24) {
            return Err(Dpv1Error::INVALID_INDEX);
        }
        self.record = record.try_into().map_err(|_| Dpv1Error::INVALID_RANGE)?;
        Ok(())
    }

    fn set_prm(&mut self, user: &[u8]) -> Result<(), PrmFault> {
        if user.len() == self.prm_length { Ok(()) } else { Err(PrmFault) }
    }

    fn chk_cfg(&mut self, octets: &[u8]) -> Result<cfg::Lengths, CfgFault> {
        if octets == self.get_cfg() { cfg::lengths(octets).map_err(|_| CfgFault) } else { Err(CfgFault) }
    }

    fn get_cfg(&self) -> &[u8] {
        &[0x11, 0x21]
    }

    fn outputs(&mut self, outputs: Outputs<'_>) {
        assert!(matches!(outputs, Outputs::Safe | Outputs::Data([0, 0])), "{outputs:02X?}");
    }

    fn inputs(&mut self, inputs: &mut [u8]) {
        inputs.copy_from_slice(&[0xAA, 0x05]);
    }
}

fn start(prm_length: usize) -> SlaveLine {
    SlaveLine::start(UnknownDevice { prm_length, record: [0x12, 0x34] })
}

fn monitor(line: &SlaveLine, options: &[&str]) -> Output {
    let command = ["monitor", "--port", &line.port(), "--own", "--for", "3", "--outputs", "9=00 00"];
    run(&[&command, options, &["9"]].concat())
}

/// Zeros can stop a pump or close a valve.
#[test]
fn an_unknown_slave_with_outputs_is_not_owned_unless_they_are_given() {
    let line = start(0);
    let own = |options: &[&str]| {
        run(&[&["monitor", "--port", &line.port(), "--own", "--for", "3"], options, &["9"]].concat())
    };
    let refused = own(&[]);
    assert_eq!(refused.status.code(), Some(2));
    let sentence = text(&refused.stderr);
    assert!(sentence.contains("2 octets of outputs") && sentence.contains("--outputs \"9=00 00\""), "{sentence}");
    assert_eq!(own(&["--outputs", "9=00"]).status.code(), Some(2));
    assert_eq!(line.owner(), Value::Null);
}

fn text(octets: &[u8]) -> String {
    String::from_utf8(octets.to_vec()).unwrap()
}

#[test]
fn the_inputs_of_an_unknown_slave_are_octets_in_every_form() {
    let line = start(0);
    let output = monitor(&line, &["--json"]);
    assert_eq!(output.status.code(), Some(0), "{}", text(&output.stderr));
    let row: Value = serde_json::from_str(text(&output.stdout).lines().next().unwrap()).unwrap();
    assert_eq!((&row["device"], &row["inputs"]), (&"0x1234".into(), &"AA 05".into()));
    assert_eq!((&row["state"], &row["pressure"]), (&"DATA".into(), &Value::Null));
    assert!(row["exchanges"].as_u64().unwrap() > 0, "{row}");
    let notice = "the slave at address 9 has the ident number 0x1234, which no known device has; its inputs are shown as octets, \
                  with its configuration 11 21, no user parameters and the outputs 00 00";
    assert!(text(&output.stderr).contains(notice), "{}", text(&output.stderr));
    let csv = ",9,0x1234,,,,0,DATA,\"\",";
    let table = "   9  0x1234       0  -                 DATA";
    for (options, shown) in [(&["--csv"][..], csv), (&[], table)] {
        let output = text(&monitor(&line, options).stdout);
        assert!(output.contains(shown) && output.contains("AA 05"), "{output}");
    }
    assert_eq!(line.owner(), Value::Null);
}

/// The owner keeps the slave.
#[test]
fn an_unknown_slave_of_another_master_is_read_without_ownership() {
    let line = start(0);
    let mut master = End::tcp(&line.address);
    master.ask(&sd2(ADDRESS, 61, 0x6D, "80 00 00 0B 12 34 00"), "E5");
    master.ask(&sd2(ADDRESS, 62, 0x5D, "11 21"), "E5");
    drop(master);
    let output = monitor(&line, &["--json"]);
    assert_eq!(output.status.code(), Some(0), "{}", text(&output.stderr));
    let row: Value = serde_json::from_str(text(&output.stdout).lines().next().unwrap()).unwrap();
    assert_eq!((&row["state"], &row["inputs"], &row["lost"]), (&"READ".into(), &"AA 05".into(), &0.into()));
    assert!(text(&output.stderr).contains("master 2 owns it, and its inputs are read with RD_Inp"));
    assert_eq!(line.owner(), 2);
}

#[test]
fn an_unknown_slave_that_waits_for_the_configuration_of_another_master_is_refused() {
    let line = start(0);
    let mut master = End::tcp(&line.address);
    master.ask(&sd2(ADDRESS, 61, 0x6D, "80 00 00 0B 12 34 00"), "E5");
    drop(master);
    let output = monitor(&line, &[]);
    assert_eq!(output.status.code(), Some(1));
    assert_eq!(text(&output.stderr), "profivac: the slave at address 9 belongs to master 2\n");
    assert_eq!(line.owner(), 2);
}

#[test]
fn an_unknown_slave_gets_the_user_parameters_of_the_command_line() {
    let line = start(3);
    let refused = monitor(&line, &["--json"]);
    assert_eq!(refused.status.code(), Some(1));
    let sentence = text(&refused.stderr);
    assert!(sentence.contains("no data from the slave at address 9: "), "{sentence}");
    assert!(sentence.contains("; give the user parameters of its GSD file with --prm HEX"), "{sentence}");
    let accepted = monitor(&line, &["--json", "--prm", "00 00 00"]);
    assert_eq!(accepted.status.code(), Some(0), "{}", text(&accepted.stderr));
    assert!(text(&accepted.stdout).contains("\"inputs\":\"AA 05\""));
}

#[test]
fn records_of_an_unknown_slave_are_read_and_written_as_octets_after_a_confirmation() {
    let line = start(3);
    let port = line.port();
    let at =
        |command: &'static str, rest: &[&str]| run(&[&[command, "--port", &port, "--address", "9"], rest].concat());
    let named = at("read", &["1/24"]);
    assert!(text(&named.stderr).contains("`profivac read --octets SLOT/INDEX` reads"), "{}", text(&named.stderr));
    assert_eq!(text(&at("read", &["--octets", "1/24"]).stdout), "1/24 = 12 34\n");
    let refused = at("read", &["--octets", "1/25"]);
    assert_eq!(refused.status.code(), Some(1), "{}", text(&refused.stderr));
    let unconfirmed = at("write", &["--octets", "1/24", "56 78"]);
    assert_eq!(unconfirmed.status.code(), Some(2));
    assert!(text(&unconfirmed.stderr).contains("nothing was sent; without a terminal add --yes"));
    assert_eq!(text(&at("read", &["--octets", "1/24"]).stdout), "1/24 = 12 34\n");
    let written = at("write", &["--octets", "--yes", "1/24", "56 78"]);
    assert_eq!((text(&written.stdout).as_str(), written.status.code()), ("1/24: 56 78 written\n", Some(0)));
    let rows: Value = serde_json::from_slice(&at("read", &["--octets", "--json", "1/24"]).stdout).unwrap();
    assert_eq!((&rows[0]["octets"], &rows[0]["name"]), (&"56 78".into(), &Value::Null));
    for wrong in [
        &["--octets", "1/24"][..],
        &["--octets", "1/24", "5"],
        &["--octets", "im0", "11"],
        &["--octets", "serial", "11"],
    ] {
        assert_eq!(at("write", wrong).status.code(), Some(2), "{wrong:?}");
        let failed = at("write", &[wrong, &["--json"]].concat());
        let printed: Value = serde_json::from_slice(&failed.stdout).unwrap();
        assert_eq!(printed["effect"], "not-sent", "{wrong:?}");
        assert_eq!(text(&failed.stderr), format!("profivac: {}\n", printed["error"].as_str().unwrap()));
    }
}
