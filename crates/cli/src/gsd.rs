//! `profivac gsd`: the GSD file of a device.

use crate::failure::Failure;
use crate::output::out;
use clap::Args;
use profivac_virtual::device_spec::entry;

/// Print the GSD file of a device, for the engineering tool of a master.
///
/// profivac generates it from the device's tables; it is not the vendor's file. Every configuration of the manual is a module.
#[derive(Args, Debug)]
#[command(after_help = EXAMPLES)]
pub struct Arguments {
    /// The device, for instance bcg450
    #[arg(value_name = "DEVICE")]
    device: String,
}

const EXAMPLES: &str = "\
Examples:
  profivac gsd bcg450 > INFI08E6.GSD";

/// Prints the file.
pub fn run(arguments: &Arguments) -> Result<(), Failure> {
    let entry = entry(&arguments.device)?;
    out(profivac_client::gsd::gsd(entry.model).trim_end());
    Ok(())
}
