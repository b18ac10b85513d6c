//! `profivac st`: function blocks of a device for a PLC.

use crate::device_files::named;
use crate::failure::Failure;
use crate::output::out;
use clap::{Args, ValueEnum};
use profivac_client::st;

/// Print function blocks of a device for a PLC, in structured text (IEC 61131-3).
///
/// One block decodes each telegram of the inputs to a pressure with its quality; one reads and writes parameters in the parameter channel.
#[derive(Args, Debug)]
#[command(after_help = EXAMPLES)]
pub struct Arguments {
    /// The device, for instance bcg450, or a device file
    #[arg(value_name = "DEVICE|FILE.toml")]
    device: String,
    /// The engineering tool
    #[arg(long, value_enum, default_value_t = Dialect::Standard)]
    dialect: Dialect,
}

/// The dialects by their names on the command line.
#[derive(Clone, Copy, Debug, ValueEnum)]
enum Dialect {
    /// IEC 61131-3, for CODESYS, TwinCAT and others
    Standard,
    /// An external source of TIA Portal (SCL)
    Tia,
}

impl From<Dialect> for st::Dialect {
    fn from(dialect: Dialect) -> Self {
        match dialect {
            Dialect::Standard => Self::Standard,
            Dialect::Tia => Self::Tia,
        }
    }
}

const EXAMPLES: &str = "\
Examples:
  profivac st bcg450 > bcg450.st
  profivac st bcg450 --dialect tia > bcg450.scl";

/// Prints the blocks.
pub fn run(arguments: &Arguments) -> Result<(), Failure> {
    out(st::st(named(&arguments.device)?, arguments.dialect.into()).trim_end());
    Ok(())
}
