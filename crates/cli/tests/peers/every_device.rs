//! Every device in every configuration, with the parameters of a foreign master taken from the tables of the devices.
//!
//! This does not prove the tables: other tests compare them with the manuals, and `gauge` has the values of one gauge a second
//! time. It proves that a device accepts from a foreign master what its tables declare; the result is `docs/pyprofibus.md`.

use crate::common::{Folder, Program, text};
use crate::golden;
use crate::peers::profirust_master;
use crate::peers::pyprofibus_rows::{Outcome, Rows};
use crate::peers::slave::Slave;
use profivac_devices::catalog::MODELS;
use profivac_devices::model::{Configuration, Field, Model, UserPrm};
use profivac_virtual::device_spec::DeviceSpec;
use std::io::Write;

/// The address of the first device; the others have the next addresses.
const FIRST: u8 = 10;

/// A device of the simulation.
struct Variant {
    model: &'static Model,
    /// The keys after the name; empty for the defaults.
    keys: &'static str,
    address: u8,
}

impl Variant {
    fn spec(&self) -> String {
        let colon = if self.keys.is_empty() { "" } else { ":" };
        format!("{}@{}{colon}{}", self.model.name, self.address, self.keys)
    }

    fn slave(&self, configuration: &Configuration, user: &UserPrm) -> Slave {
        Slave {
            address: self.address,
            ident: self.model.ident,
            cfg: configuration.octets.to_vec(),
            user_prm: user.octets.to_vec(),
            outputs: configuration.output_octets(),
            inputs: configuration.input_octets(),
        }
    }
}

/// All devices; those with an optional atmosphere sensor in both variants.
fn variants() -> Vec<Variant> {
    let keys = |model: &Model| match format!("{}@{FIRST}:atm=off", model.name).parse::<DeviceSpec>() {
        Ok(_) => vec!["atm=on", "atm=off"],
        Err(_) => vec![""],
    };
    let kinds = MODELS.iter().flat_map(|model| keys(model).into_iter().map(|keys| (*model, keys)));
    (FIRST..).zip(kinds).map(|(address, (model, keys))| Variant { model, keys, address }).collect()
}

/// A line with all devices.
fn simulator(folder: &Folder, variants: &[Variant]) -> Program {
    let specs: Vec<String> = variants.iter().map(Variant::spec).collect();
    let mut arguments = vec!["simulate", "--pty"];
    let line = folder.name("line");
    arguments.push(&line);
    arguments.extend(specs.iter().map(String::as_str));
    let program = Program::start(&arguments);
    program.ready();
    program
}

/// The user parameter strings that fit a configuration. The TTR telegram fits only the string of the compatibility mode, and that
/// string fits no other telegram (errata-pxg55x-img400 49).
fn user_strings(model: &'static Model, configuration: &Configuration) -> impl Iterator<Item = &'static UserPrm> {
    let is_ttr = configuration.inputs.is_some_and(|telegram| telegram.fields == [Field::TtrValue]);
    model.user_prm.iter().filter(move |user| is_ttr == (user.name == "TTR compatibility mode"))
}

/// The result with every user parameter string, or with the first that fails.
fn result(rows: &mut Rows, variant: &Variant, configuration: &Configuration) -> String {
    let inputs = configuration.input_octets();
    let expected = Outcome { state: "Data_Exchange".to_owned(), inputs: Some(inputs as u64) };
    for user in user_strings(variant.model, configuration) {
        let Outcome { state, inputs } = match rows.bring_up(&variant.slave(configuration, user)) {
            outcome if outcome == expected => continue,
            outcome => outcome,
        };
        return format!("{}: {state}, {inputs:?} octets in", user.name);
    }
    expected.state
}

/// One row of the page.
fn row(rows: &mut Rows, variant: &Variant, configuration: &Configuration) -> [String; 6] {
    let outputs = configuration.output_octets();
    [
        [variant.model.name, variant.keys].join(" ").trim_end().to_owned(),
        text(configuration.octets),
        if outputs == 0 { "0 *".to_owned() } else { outputs.to_string() },
        configuration.input_octets().to_string(),
        user_strings(variant.model, configuration).count().to_string(),
        result(rows, variant, configuration),
    ]
}

const HEADING: [&str; 6] = ["Device", "Configuration", "Out", "In", "User parameters", "Result"];

const PAGE: &str = "\
# Every device with pyprofibus

pyprofibus 1.13 is an independent class 1 master. Over a pty it takes every device from FDL_Status to Data_Exchange, in
every configuration of the device's manual, once for each user parameter string that fits the configuration. Then it
exchanges data three times. Octets are counted from the master's side; pyprofibus compares the length of every answer
with `In`.

`*` pyprofibus refuses a slave without outputs, although it can exchange data with one. The test skips this check and
changes nothing else in the master.

This page does not cover timing and parity, because a pty has neither; the ident number, because pyprofibus does not
compare it with the diagnosis; the contents of extended diagnosis, because pyprofibus discards them; DP-V1, because
pyprofibus does not support it.

A test in `crates/cli/tests/peers` prints this page and compares it with every run; `cargo xtask goldens` writes it again.

";

/// The page, each column as wide as its widest cell.
fn page(rows: &[[String; 6]]) -> String {
    let width = |column: usize| rows.iter().map(|row| row[column].len()).max().unwrap_or(0).max(HEADING[column].len());
    let widths: [usize; 6] = std::array::from_fn(width);
    let line = |cells: [&str; 6]| {
        let padded = cells.iter().zip(widths).map(|(cell, width)| format!(" {cell:width$} |"));
        format!("|{}\n", padded.collect::<String>())
    };
    let rule: String = widths.iter().map(|width| format!("{}|", "-".repeat(width + 2))).collect();
    let rows = rows.iter().map(|row| line(row.each_ref().map(String::as_str)));
    format!("{PAGE}{}|{rule}\n{}", line(HEADING), rows.collect::<String>())
}

#[test]
fn pyprofibus_brings_up_every_device_in_every_configuration() {
    let (folder, variants) = (Folder::new(), variants());
    let _simulator = simulator(&folder, &variants);
    let mut master = Rows::start(&folder.path("line"));
    let rows: Vec<_> = variants
        .iter()
        .flat_map(|variant| variant.model.configurations.iter().map(move |configuration| (variant, configuration)))
        .map(|(variant, configuration)| row(&mut master, variant, configuration))
        .collect();
    let page = page(&rows);
    // Written directly, because the output of a passing test is not shown.
    std::io::stderr().write_all(page.as_bytes()).unwrap();
    for row in &rows {
        assert_eq!(row[5], "Data_Exchange", "{} {}", row[0], row[1]);
    }
    golden::compare("docs/pyprofibus.md", &page);
}

/// In the default configuration, the answer to Get_Cfg.
#[test]
fn profirust_brings_up_every_device() {
    let (folder, variants) = (Folder::new(), variants());
    let _simulator = simulator(&folder, &variants);
    for variant in &variants {
        let configuration = variant.model.default_configuration;
        let user = user_strings(variant.model, configuration).next().unwrap();
        let master = profirust_master::start(&folder.path("line"), &variant.slave(configuration, user));
        master.until_exchanging();
        master.until(&variant.spec(), |inputs| inputs.iter().any(|octet| *octet != 0));
    }
}

/// A gauge that a file describes is a slave as the built-in ones are.
#[test]
fn pyprofibus_brings_up_a_device_of_a_file_in_every_configuration() {
    let folder = Folder::new();
    let (line, file) = (folder.name("line"), folder.name("bpg402.toml"));
    std::fs::write(&file, include_str!("../../../../docs/devices/files/bpg402.toml")).unwrap();
    let described = profivac_device_file::known_devices(&[file.clone().into()]).unwrap();
    let variant = Variant { model: described.named("bpg402").unwrap(), keys: "", address: FIRST };
    let simulator = Program::start(&["simulate", "--pty", &line, &format!("{file}@{FIRST}")]);
    simulator.ready();
    let mut master = Rows::start(&folder.path("line"));
    for configuration in variant.model.configurations {
        assert_eq!(result(&mut master, &variant, configuration), "Data_Exchange", "{:02X?}", configuration.octets);
    }
}
