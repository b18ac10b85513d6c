//! `profivac address`: sets the station address of a slave.

use crate::bus::BusOptions;
use crate::failure::Failure;
use crate::gauge::confirm;
use crate::output::{json, out};
use crate::values;
use clap::Args;
use profivac_client::address::{AddressError, change, check};
use serde::Serialize;

/// Set the station address of a slave.
///
/// The address switch of the device must be set outside 0 to 125, and no master may own the slave. The new address must be free.
/// After the change the command checks that the slave answers at the new address.
#[derive(Args, Debug)]
#[command(after_help = EXAMPLES)]
pub struct Arguments {
    #[command(flatten)]
    bus: BusOptions,
    /// The present address; 126 for a slave without an address of its own
    #[arg(long, value_name = "N", value_parser = values::any_address)]
    from: u8,
    /// The new address
    #[arg(long, value_name = "N", value_parser = values::slave_address)]
    to: u8,
    /// Lock the address: the slave then refuses every new address over the bus
    #[arg(long)]
    lock: bool,
    /// Do not ask for confirmation
    #[arg(long)]
    yes: bool,
    /// Print JSON
    #[arg(long)]
    json: bool,
}

const EXAMPLES: &str = "\
Examples:
  profivac address --port /dev/ttyUSB0 --from 126 --to 5
  profivac address --port /dev/ttyUSB0 --from 126 --to 5 --lock";

#[derive(Debug, Serialize)]
struct Row {
    from: u8,
    to: u8,
    ident: String,
    devices: Vec<&'static str>,
    locked: bool,
}

/// Checks both addresses, asks for confirmation of a lock, changes the address, checks it.
pub fn run(arguments: &Arguments) -> Result<(), Failure> {
    let Arguments { from, to, lock, .. } = *arguments;
    for (option, address) in [("--from", from), ("--to", to)] {
        arguments.bus.check_not_own_address(address, option)?;
    }
    let mut session = arguments.bus.open()?;
    let slave = check(&mut session, from, to)?;
    if lock {
        let risk = format!("address {to} would be locked: only the address switch of the device could change it again");
        confirm(&risk, arguments.yes)?;
    }
    change(&mut session, from, to, slave.ident, lock)?;
    let devices = slave.device_names();
    let row = Row { from, to, ident: format!("0x{:04X}", slave.ident), devices, locked: lock };
    let name = if row.devices.is_empty() { "unknown".to_owned() } else { row.devices.join(" or ") };
    let locked = if lock { ", locked" } else { "" };
    out(&if arguments.json { json(&row) } else { format!("{} ({name}): address {from} -> {to}{locked}", row.ident) });
    Ok(())
}

impl From<AddressError> for Failure {
    fn from(error: AddressError) -> Self {
        let sentence = error.to_string();
        match error {
            AddressError::Session(error) => error.into(),
            AddressError::AddressInUse(_) => Self::usage(sentence),
            AddressError::OwnedByOther { .. } | AddressError::ServiceClosed(..) | AddressError::NotChanged(_) => {
                Self::refused(sentence)
            }
            _ => Self::no_answer(sentence),
        }
    }
}
