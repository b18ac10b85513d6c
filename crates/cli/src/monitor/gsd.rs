//! Slaves by their GSD files: the options, and what the command must know before it owns them.

use super::plan::{OwnedByGsd, Plan};
use crate::bus;
use crate::console::Signals;
use crate::device_files::known;
use crate::failure::Failure;
use crate::gauge::{confirm, is_interactive};
use crate::gsd_slaves::{GsdOptions, Wanted, modules_remark, rate_remark, selection};
use crate::output::notice;
use crate::values::{self, Octets, ValueError};
use crate::zeros::{RISK, Zeros};
use clap::Args;
use profivac_client::values::hex;
use profivac_dp::link::Baud;
use profivac_explain::gsd::Files;
use profivac_gsd_slave::{Catalog, Change, GsdSlave, Selection};
use profivac_host::scan::probe;
use profivac_host::session::BusSession;
use std::collections::BTreeMap;

/// The options for slaves by their GSD files.
#[derive(Args, Debug)]
pub struct GsdSlaves {
    #[command(flatten)]
    files: GsdOptions,
    /// The modules of a slave: numbers of its GSD file in slot order (9=3+7), or a TOML file with names and parameters (9=FILE.toml);
    /// default: the modules of its present configuration
    #[arg(long, value_name = "ADDR=MODULES", value_parser = addressed, requires = "paths")]
    modules: Vec<Addressed>,
    /// A parameter of a slave by its name in the GSD file; the last `=` stands before the value
    #[arg(long, value_name = "ADDR=NAME=VALUE", value_parser = addressed, requires = "paths")]
    set: Vec<Addressed>,
    /// The outputs of a slave that is no known device, in hex; the command owns no such slave with outputs unless they are given, or the
    /// user agrees to zeros (with --gsd, on a terminal)
    #[arg(long, value_name = "ADDR=HEX", value_parser = addressed)]
    outputs: Vec<Addressed>,
}

/// A text for the slave at an address.
#[derive(Clone, Debug)]
pub struct Addressed {
    address: u8,
    text: String,
}

/// Parses `ADDR=TEXT`. The first `=` separates, because an address has none.
fn addressed(text: &str) -> Result<Addressed, ValueError> {
    let (address, text) = text.split_once('=').unwrap_or((text, ""));
    Ok(Addressed { address: values::slave_address(address.trim())?, text: text.to_owned() })
}

/// The options by address.
#[derive(Default)]
struct Choices {
    modules: BTreeMap<u8, Selection>,
    changes: BTreeMap<u8, Vec<Change>>,
    outputs: BTreeMap<u8, Vec<u8>>,
}

impl Choices {
    fn addresses(&self) -> impl Iterator<Item = u8> {
        self.modules.keys().chain(self.changes.keys()).chain(self.outputs.keys()).copied()
    }

    fn is_about(&self, address: u8) -> bool {
        self.addresses().any(|one| one == address)
    }
}

impl GsdSlaves {
    /// Reads the files and asks each slave of the plans who it is; shows the outputs of those that the command will own, and asks. Changes
    /// nothing on the bus. While the user thinks, no session is open: this master would be in the ring and not pass the token on.
    pub fn prepare(&self, plans: &mut [Plan], signals: &Signals) -> Result<(), Failure> {
        let choices = self.choices()?;
        let missing = choices.addresses().find(|address| !plans.iter().any(|plan| plan.addresses.contains(address)));
        if let Some(address) = missing {
            return Err(Failure::usage(format!(
                "--modules, --set or --outputs for address {address}, which is not monitored; add it to the addresses"
            )));
        }
        for plan in plans.iter_mut() {
            plan.outputs.clone_from(&choices.outputs);
            plan.chosen = choices.modules.keys().chain(choices.changes.keys()).copied().collect();
        }
        if !self.files.is_given() {
            return Ok(());
        }
        let catalog = self.files.read()?;
        let files = Files::new(catalog.entries().map(|(_, entry)| entry.file.clone()));
        for plan in plans.iter_mut() {
            plan.files = files.clone();
            plan.by_gsd = find_all(plan, &catalog, &choices, signals)?;
        }
        for (address, owned) in plans.iter_mut().flat_map(|plan| &mut plan.by_gsd) {
            signals.check()?;
            owned.outputs = outputs(&owned.slave, *address, choices.outputs.get(address))?;
        }
        Ok(())
    }

    fn choices(&self) -> Result<Choices, Failure> {
        let mut choices = Choices::default();
        for Addressed { address, text } in &self.modules {
            if choices.modules.insert(*address, selection(text)?).is_some() {
                return Err(Failure::usage(format!("--modules for address {address} is given twice")));
            }
        }
        for Addressed { address, text } in &self.set {
            choices.changes.entry(*address).or_default().push(text.parse()?);
        }
        for Addressed { address, text } in &self.outputs {
            let Octets(octets) = values::octets(text).map_err(|error| Failure::usage(error.to_string()))?;
            if choices.outputs.insert(*address, octets).is_some() {
                return Err(Failure::usage(format!("--outputs for address {address} is given twice")));
            }
        }
        Ok(choices)
    }
}

/// A slave that the command will own by a GSD file, before its file is chosen.
struct FreeSlave {
    address: u8,
    ident: u16,
    /// The answer to Get_Cfg.
    get_cfg: Option<Vec<u8>>,
}

/// The slaves of a segment that the command will own by a GSD file, with outputs of zero.
fn find_all(
    plan: &Plan,
    catalog: &Catalog,
    choices: &Choices,
    signals: &Signals,
) -> Result<BTreeMap<u8, OwnedByGsd>, Failure> {
    signals.check()?;
    let mut session = plan.bus.open()?;
    let mut free = Vec::new();
    for address in &plan.addresses {
        signals.check()?;
        free.extend(find(&mut session, *address, plan.bus.master(), catalog, choices)?);
    }
    let baud = session.baud();
    // The choice of a file may be a question to the user.
    drop(session);
    let owned = |free: FreeSlave| {
        let slave = free.by_gsd(catalog, choices, baud)?;
        let outputs = vec![0; slave.lengths().outputs.into()];
        Ok((free.address, OwnedByGsd { slave, outputs }))
    };
    free.into_iter().map(owned).collect()
}

/// The slave at an address, if the command will own it by a GSD file. A known gauge stays one, unless an option is about it.
fn find(
    session: &mut BusSession,
    address: u8,
    master: u8,
    catalog: &Catalog,
    choices: &Choices,
) -> Result<Option<FreeSlave>, Failure> {
    // The search for the slaves reports later that one does not answer.
    let Some(status) = probe(session, address)?.and_then(|station| station.slave) else { return Ok(None) };
    let is_gauge = known().knows(status.ident);
    let is_known = !is_gauge && !catalog.by_ident(status.ident).is_empty();
    let is_owned = status.owner.is_some_and(|owner| owner != master);
    if is_owned && choices.is_about(address) {
        notice(&format_args!(
            "the slave at address {address} belongs to another master: it is read, and --modules, --set and --outputs are not used"
        ));
    }
    if is_owned || !(is_known || choices.is_about(address)) {
        return Ok(None);
    }
    Ok(Some(FreeSlave { address, ident: status.ident, get_cfg: bus::present_cfg(session, address)? }))
}

impl FreeSlave {
    /// The slave by its file, with notices about what it may refuse.
    fn by_gsd(&self, catalog: &Catalog, choices: &Choices, baud: Baud) -> Result<GsdSlave, Failure> {
        let Self { address, ident, get_cfg } = self;
        let (address, get_cfg) = (*address, get_cfg.as_deref());
        let changes = choices.changes.get(&address).map(Vec::as_slice).unwrap_or_default();
        let selection = choices.modules.get(&address);
        let slave = Wanted { address, ident: *ident, get_cfg, selection, changes }.find(catalog)?;
        if let Some(remark) = modules_remark(&slave, address, get_cfg) {
            notice(&format_args!("{remark}; the slave may refuse them"));
        }
        if let Some(remark) = rate_remark(&slave, baud) {
            notice(&format_args!("slave at address {address}: {remark}"));
        }
        Ok(slave)
    }
}

/// The outputs of a slave: those of the command line, else zeros if the user agrees.
fn outputs(slave: &GsdSlave, address: u8, given: Option<&Vec<u8>>) -> Result<Vec<u8>, Failure> {
    let zeros = Zeros::of_slave(address, slave);
    if let Some(given) = given {
        let listed = zeros.as_ref().map(Zeros::listed).unwrap_or_default();
        return checked(given, usize::from(slave.lengths().outputs), address, &listed);
    }
    let Some(zeros) = zeros else { return Ok(Vec::new()) };
    if !is_interactive() {
        return Err(Failure::usage(format!(
            "{zeros}; nothing was sent; without a terminal give its outputs, for instance --outputs \"{address}={}\"",
            hex(&zeros.octets())
        )));
    }
    confirm(&zeros.to_string(), false).map(|()| zeros.octets())
}

/// The outputs of the command line, if they are as long as those of the slave.
fn checked(given: &[u8], length: usize, address: u8, modules: &str) -> Result<Vec<u8>, Failure> {
    if given.len() == length {
        return Ok(given.to_vec());
    }
    Err(Failure::usage(format!(
        "expected {length} octets of outputs for the slave at address {address}{modules}, got {}",
        given.len()
    )))
}

/// The outputs of a slave without a GSD file, which its configuration `cfg` counts. They must be given.
pub fn outputs_of_unknown(plan: &Plan, address: u8, cfg: &[u8]) -> Result<Vec<u8>, Failure> {
    let zeros = Zeros::of_cfg(address, cfg).map(|zeros| zeros.octets()).unwrap_or_default();
    match plan.outputs.get(&address) {
        Some(given) => checked(given, zeros.len(), address, ""),
        None if zeros.is_empty() => Ok(zeros),
        None => Err(Failure::usage(format!(
            "the slave at address {address} is no known device and has {} octets of outputs; {RISK}; nothing was sent; give its \
             outputs, for instance --outputs \"{address}={}\"",
            zeros.len(),
            hex(&zeros)
        ))),
    }
}

#[cfg(test)]
#[allow(clippy::unwrap_used, reason = "a test")]
mod tests {
    use super::*;
    use crate::bus::{BusOptions, MasterOptions};
    use clap::Parser;
    use signal_hook::consts::SIGUSR1;

    #[derive(Debug, Parser)]
    struct Line {
        #[command(flatten)]
        slaves: GsdSlaves,
    }

    /// The port does not exist: to open it would be another error.
    #[test]
    fn a_signal_that_has_come_before_the_slaves_are_asked_ends_the_command() {
        let gsd = concat!(env!("CARGO_MANIFEST_DIR"), "/../../tests/support/gsd/pressure.gsd");
        let Line { slaves } = Line::try_parse_from(["monitor", "--gsd", gsd]).unwrap();
        let bus = BusOptions::new("/nowhere", &MasterOptions::new(Baud::B19200, 0, 126));
        let mut plans = [Plan::new(None, bus, vec![9])];
        let signals = Signals::of(&[SIGUSR1]).unwrap();
        assert!(!slaves.prepare(&mut plans, &signals).err().unwrap().is_interrupted());
        signal_hook::low_level::raise(SIGUSR1).unwrap();
        assert!(slaves.prepare(&mut plans, &signals).err().unwrap().is_interrupted());
    }
}
