//! The options of every command that is a master on a bus.

use crate::failure::Failure;
use crate::output::{remark, remarks};
use crate::values::{self, Rate};
use clap::Args;
use clap::builder::NonEmptyStringValueParser;
use profivac_conform::PortWire;
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
pub struct Bus {
    /// A serial device, a pty, tcp://HOST:PORT, or sim:FILE.toml for a segment in memory
    #[arg(long, value_name = "PORT", value_parser = NonEmptyStringValueParser::new())]
    port: String,
    #[command(flatten)]
    line: Line,
}

/// How to be a master on a bus.
#[derive(Args, Clone, Debug)]
pub struct Line {
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

impl Bus {
    /// A bus at `port`.
    pub fn at(port: &str, line: &Line) -> Self {
        Self { port: port.to_owned(), line: line.clone() }
    }

    /// A segment of a station's file.
    pub fn of(segment: &Segment, line: &Line) -> Self {
        let line = Line { baud: Rate::Known(segment.baud), master: segment.master, ..line.clone() };
        Self { port: segment.port.clone(), line }
    }

    /// A master on the bus that has not said anything yet. A port that is lost ends it.
    pub fn open(&self) -> Result<BusSession, Failure> {
        self.open_at().map(|(tool, _)| tool)
    }

    /// The same for a command that runs for long: a port that is lost is looked for until it is back.
    pub fn open_lasting(&self) -> Result<BusSession, Failure> {
        let (tool, baud) = self.open_at()?;
        Ok(tool.lasting(open::again(&self.port, baud)))
    }

    /// A station on the bus that says anything, also what no master would.
    pub fn probe(&self) -> Result<PortWire, Failure> {
        let (port, baud) = open_port(&self.port, self.line.baud)?;
        Ok(PortWire::new(port, baud, self.parameters(baud)))
    }

    fn open_at(&self) -> Result<(BusSession, Baud), Failure> {
        // What can be wrong before anything is opened.
        self.parameters(self.line.baud.known()).check().map_err(|error| Failure::usage(error.to_string()))?;
        let (port, baud) = open_port(&self.port, self.line.baud)?;
        let tool = BusSession::new(port, baud, self.parameters(baud), self.line.timeout.unwrap_or(TIMEOUT))?;
        Ok((if self.line.timeout.is_none() { tool.patient() } else { tool }, baud))
    }

    fn parameters(&self, baud: Baud) -> BusParameters {
        let bus = bus_parameters(self.line.master, baud);
        BusParameters { hsa: self.line.hsa, slot_tbit: self.line.slot_time.unwrap_or(bus.slot_tbit), ..bus }
    }

    /// Nobody else has the address of this master.
    pub fn check_other(&self, address: u8, option: &str) -> Result<(), Failure> {
        if address == self.line.master {
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
        self.line.master
    }

    /// The highest station address.
    pub const fn hsa(&self) -> u8 {
        self.line.hsa
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
