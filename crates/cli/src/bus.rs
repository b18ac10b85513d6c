//! The options of every command that is a master on a bus.

use crate::failure::Failure;
use crate::output::{remark, remarks};
use crate::values::{self, Rate};
use clap::Args;
use profivac_dp::link::Baud;
use profivac_dp::link::active::BusParameters;
use profivac_host::conform::PortWire;
use profivac_host::port::Port;
use profivac_host::tool::{Tool, bus_parameters};
use profivac_host::{open, rate};
use std::time::Duration;

/// Where the bus is and how to be a master on it.
#[derive(Args, Debug)]
pub struct Bus {
    /// A serial device, a pty, tcp://HOST:PORT, or sim:FILE.toml for a segment in memory
    #[arg(long, value_name = "PORT")]
    port: String,
    /// Bits per second; on a serial device auto listens until a telegram of another master is heard at some rate
    #[arg(long, value_name = "RATE|auto", default_value = "19200", value_parser = values::rate)]
    baud: Rate,
    /// The address of this master
    #[arg(long, value_name = "N", default_value_t = 0)]
    master: u8,
    /// The highest station address
    #[arg(long, value_name = "N", default_value_t = 126)]
    hsa: u8,
    /// How long to wait for the beginning of an answer, in bit times; by default what the rate asks for and 20 ms more
    #[arg(long, value_name = "BITS")]
    slot_time: Option<u32>,
    /// How long to wait for the line, and for somebody to answer
    #[arg(long, value_name = "SECONDS", default_value = "5", value_parser = values::seconds, allow_hyphen_values = true)]
    timeout: Duration,
}

impl Bus {
    /// A master on the bus that has not said anything yet. A port that is lost ends it.
    pub fn open(&self) -> Result<Tool, Failure> {
        self.open_at().map(|(tool, _)| tool)
    }

    /// The same for a command that runs for long: a port that is lost is looked for until it is back.
    pub fn open_lasting(&self) -> Result<Tool, Failure> {
        let (tool, baud) = self.open_at()?;
        Ok(tool.lasting(open::again(&self.port, baud)))
    }

    /// A station on the bus that says anything, also what no master would.
    pub fn probe(&self) -> Result<PortWire, Failure> {
        let (port, baud) = open_port(&self.port, self.baud)?;
        Ok(PortWire::new(port, baud, self.parameters(baud)))
    }

    fn open_at(&self) -> Result<(Tool, Baud), Failure> {
        // What can be wrong before anything is opened.
        self.parameters(self.baud.known()).check().map_err(|error| Failure::usage(error.to_string()))?;
        let (port, baud) = open_port(&self.port, self.baud)?;
        Ok((Tool::new(port, baud, self.parameters(baud), self.timeout)?, baud))
    }

    fn parameters(&self, baud: Baud) -> BusParameters {
        let bus = bus_parameters(self.master, baud);
        BusParameters { hsa: self.hsa, slot_tbit: self.slot_time.unwrap_or(bus.slot_tbit), ..bus }
    }

    /// The name of the port.
    pub fn port(&self) -> &str {
        &self.port
    }

    /// The address of this master.
    pub const fn master(&self) -> u8 {
        self.master
    }

    /// The highest station address.
    pub const fn hsa(&self) -> u8 {
        self.hsa
    }
}

/// Opens a port, and finds its rate if nobody knows it.
pub fn open_port(name: &str, rate: Rate) -> Result<(Box<dyn Port>, Baud), Failure> {
    let mut port = open::port(name, rate.known())?;
    let baud = match rate {
        Rate::Known(baud) => baud,
        Rate::Auto => {
            let found = rate::search(&mut *port)?;
            remark(&format_args!("{name} runs at {found}"));
            found
        }
    };
    remarks(|| port.next_remark());
    Ok((port, baud))
}
