//! `profivac st`: function blocks of a device for a PLC.

use crate::device_files::named;
use crate::failure::Failure;
use crate::output::out;
use clap::{Args, ValueEnum};
use profivac_client::st::{self, PlcopenTool};

/// Print function blocks of a device for a PLC, in structured text (IEC 61131-3) or as PLCopen XML.
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
    /// Print PLCopen XML, which engineering tools import in one step; for codesys unless you name another tool
    #[arg(
        long,
        value_name = "TOOL",
        value_enum,
        num_args = 0..=1,
        require_equals = true,
        default_missing_value = "codesys"
    )]
    plcopen: Option<Plcopen>,
}

/// The tools that read PLCopen XML, by their names on the command line.
#[derive(Clone, Copy, Debug, ValueEnum)]
enum Plcopen {
    /// CODESYS, TwinCAT and others
    Codesys,
    /// Beremiz and the OpenPLC Editor
    Beremiz,
}

impl From<Plcopen> for PlcopenTool {
    fn from(tool: Plcopen) -> Self {
        match tool {
            Plcopen::Codesys => Self::Codesys,
            Plcopen::Beremiz => Self::Beremiz,
        }
    }
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
  profivac st bcg450 --dialect tia > bcg450.scl
  profivac st bcg450 --plcopen > bcg450.xml";

/// Prints the blocks.
pub fn run(arguments: &Arguments) -> Result<(), Failure> {
    let model = named(&arguments.device)?;
    if !st::has_blocks(model) {
        let device = &arguments.device;
        return Err(Failure::usage(format!(
            "{device} sends no pressure and has no parameter channel, so it has no function blocks; `profivac gsd {device}` prints its \
             GSD file"
        )));
    }
    let blocks = match (arguments.plcopen, arguments.dialect) {
        (None, dialect) => st::st(model, dialect.into()),
        (Some(tool), Dialect::Standard) => st::plcopen(model, tool.into()),
        (Some(_), Dialect::Tia) => {
            return Err(Failure::usage(
                "TIA Portal does not import PLCopen XML: leave out --plcopen and add an external source file",
            ));
        }
    };
    out(blocks.trim_end());
    Ok(())
}
