//! `profivac address`: sets the station address of a slave.

use crate::advice;
use crate::bus::BusOptions;
use crate::device_files::names_with_ident;
use crate::failure::Failure;
use crate::gauge::confirm;
use crate::output::{json, out};
use crate::values;
use clap::Args;
use profivac_client::address::{AddressError, change, check};
use profivac_host::session::BusSession;
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
    /// The present address; 126 if the slave has none yet
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
    set(&mut session, (from, to), slave.ident, lock)?;
    let devices = names_with_ident(slave.ident);
    let row = Row { from, to, ident: format!("0x{:04X}", slave.ident), devices, locked: lock };
    let name = if row.devices.is_empty() { "unknown".to_owned() } else { row.devices.join(" or ") };
    let locked = if lock { ", locked" } else { "" };
    out(&if arguments.json { json(&row) } else { format!("{} ({name}): address {from} -> {to}{locked}", row.ident) });
    Ok(())
}

/// Changes the address. When the line fails or a signal comes meanwhile, the slave may have taken it.
fn set(session: &mut BusSession, (from, to): (u8, u8), ident: u16, lock: bool) -> Result<(), Failure> {
    change(session, from, to, ident, lock).map_err(|error| match error {
        AddressError::Session(error) => {
            let failure = Failure::from(error);
            let remedy = "`profivac scan` shows where it is";
            failure.with_sentence(&format!("{failure}; the slave may have address {from} or {to} now: {remedy}"))
        }
        error => error.into(),
    })
}

impl From<AddressError> for Failure {
    fn from(error: AddressError) -> Self {
        let sentence = format!("{error}{}", advice::after_address_change(&error));
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

#[cfg(test)]
#[allow(clippy::unwrap_used, reason = "a test")]
mod tests {
    use super::*;
    use profivac_client::Bus;

    #[test]
    fn a_signal_while_the_address_is_changed_names_both_addresses() {
        let mut bus = Bus::on(profivac_virtual::open::devices(&["bcg450@126"]).unwrap()).open().unwrap();
        bus.session().set_cancellation(Some(Box::new(|| true)));
        let failure = set(bus.session(), (126, 5), 0x08E6, false).unwrap_err();
        let sentence =
            "interrupted by a signal; the slave may have address 126 or 5 now: `profivac scan` shows where it is";
        assert_eq!((failure.to_string().as_str(), failure.is_interrupted()), (sentence, true));
    }
}
