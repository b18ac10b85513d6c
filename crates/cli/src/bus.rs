//! The options of every command that is a master on a bus.

use crate::failure::Failure;
use crate::output::{notice, notices};
use crate::values::{self, Rate};
use clap::Args;
use clap::builder::NonEmptyStringValueParser;
use profivac_conform::PortLink;
use profivac_dp::link::Baud;
use profivac_dp::link::active::BusParameters;
use profivac_host::port::Port;
use profivac_host::rate;
use profivac_host::session::{BusSession, bus_parameters};
use profivac_station::config::Segment;
use profivac_virtual::open;
use std::time::Duration;

/// How long a command waits if nobody says otherwise.
const TIMEOUT: Duration = Duration::from_secs(5);

/// Where the bus is and how to be a master on it.
#[derive(Args, Clone, Debug)]
pub struct BusOptions {
    /// A serial device, a pty, tcp://HOST:PORT, or sim:FILE.toml for a segment in memory
    #[arg(long, value_name = "PORT", value_parser = NonEmptyStringValueParser::new())]
    port: String,
    #[command(flatten)]
    options: MasterOptions,
}

/// How to be a master on a bus.
#[derive(Args, Clone, Debug)]
pub struct MasterOptions {
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
    /// How long to wait for the line, and for somebody to answer; by default 5, and for the line as long as a ring of such
    /// masters may take to let this one in
    #[arg(long, value_name = "SECONDS", value_parser = values::seconds, allow_hyphen_values = true)]
    timeout: Option<Duration>,
}

impl BusOptions {
    /// A bus at `port`.
    pub fn new(port: &str, line: &MasterOptions) -> Self {
        Self { port: port.to_owned(), options: line.clone() }
    }

    /// A segment of a station's file.
    pub fn of_segment(segment: &Segment, line: &MasterOptions) -> Self {
        let line = MasterOptions { baud: Rate::Known(segment.baud), master: segment.master, ..line.clone() };
        Self { port: segment.port.clone(), options: line }
    }

    /// A master on the bus that has not said anything yet. A port that is lost ends it.
    pub fn open(&self) -> Result<BusSession, Failure> {
        self.open_session().map(|(tool, _)| tool)
    }

    /// The same for a command that runs for long: a port that is lost is looked for until it is back.
    pub fn open_lasting(&self) -> Result<BusSession, Failure> {
        let (tool, baud) = self.open_session()?;
        Ok(tool.lasting(open::opener(&self.port, baud)))
    }

    /// A station on the bus that says anything, also what no master would.
    pub fn open_probe(&self) -> Result<PortLink, Failure> {
        let (port, baud) = open_port(&self.port, self.options.baud)?;
        Ok(PortLink::new(port, baud, self.parameters(baud)))
    }

    fn open_session(&self) -> Result<(BusSession, Baud), Failure> {
        // What can be wrong before anything is opened.
        self.parameters(self.options.baud.initial()).check().map_err(|error| Failure::usage(error.to_string()))?;
        let (port, baud) = open_port(&self.port, self.options.baud)?;
        let tool = BusSession::new(port, baud, self.parameters(baud), self.options.timeout.unwrap_or(TIMEOUT))?;
        Ok((if self.options.timeout.is_none() { tool.wait_for_ring_entry() } else { tool }, baud))
    }

    fn parameters(&self, baud: Baud) -> BusParameters {
        let bus = bus_parameters(self.options.master, baud);
        BusParameters { hsa: self.options.hsa, slot_tbit: self.options.slot_time.unwrap_or(bus.slot_tbit), ..bus }
    }

    /// Nobody else has the address of this master.
    pub fn check_not_own_address(&self, address: u8, option: &str) -> Result<(), Failure> {
        if address == self.options.master {
            return Err(Failure::usage(format!("{option} {address} is the address of this master; say --master N")));
        }
        Ok(())
    }

    /// The name of the port.
    pub fn port(&self) -> &str {
        &self.port
    }

    /// The address of this master.
    pub const fn master(&self) -> u8 {
        self.options.master
    }

    /// The highest station address.
    pub const fn hsa(&self) -> u8 {
        self.options.hsa
    }
}

/// Opens a port, and finds its rate if nobody knows it.
pub fn open_port(name: &str, rate: Rate) -> Result<(Box<dyn Port>, Baud), Failure> {
    let mut port = open::port(name, rate.initial())?;
    let baud = match rate {
        Rate::Known(baud) => baud,
        Rate::Auto => {
            let found = rate::detect(&mut *port)?;
            notice(&format_args!("{name} runs at {found}"));
            found
        }
    };
    notices(|| port.next_notice());
    Ok((port, baud))
}
