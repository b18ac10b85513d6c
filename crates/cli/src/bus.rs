//! The options of every command that is a master on a bus.

use crate::failure::Failure;
use crate::values;
use clap::Args;
use profivac_dp::link::Baud;
use profivac_dp::link::active::BusParameters;
use profivac_host::conform::PortWire;
use profivac_host::port;
use profivac_host::tool::{Tool, bus_parameters};
use std::time::Duration;

/// Where the bus is and how to be a master on it.
#[derive(Args, Debug)]
pub struct Bus {
    /// A serial device, a pty, or tcp://HOST:PORT
    #[arg(long, value_name = "PORT")]
    port: String,
    /// Bits per second
    #[arg(long, value_name = "RATE", default_value = "19200", value_parser = values::baud)]
    baud: Baud,
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
    /// A master on the bus that has not said anything yet.
    pub fn open(&self) -> Result<Tool, Failure> {
        let bus = self.parameters();
        bus.check().map_err(|error| Failure::usage(error.to_string()))?;
        Ok(Tool::new(port::open(&self.port, self.baud)?, self.baud, bus, self.timeout)?)
    }

    /// A station on the bus that says anything, also what no master would.
    pub fn probe(&self) -> Result<PortWire, Failure> {
        Ok(PortWire::new(port::open(&self.port, self.baud)?, self.baud, self.parameters()))
    }

    fn parameters(&self) -> BusParameters {
        let bus = bus_parameters(self.master, self.baud);
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
