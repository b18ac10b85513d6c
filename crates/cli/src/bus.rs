//! The options of every command that acts as a master.

use crate::console::Signals;
use crate::device_files::DeviceFileOptions;
use crate::failure::Failure;
use crate::output::{notice, notices};
use crate::values::{self, Rate};
use clap::Args;
use clap::builder::NonEmptyStringValueParser;
use profivac_conform::PortLink;
use profivac_dp::link::Baud;
use profivac_dp::link::active::BusParameters;
use profivac_dp::master::services;
use profivac_host::clock::{duration_of, tbit_of};
use profivac_host::port::{self, Delivery, Port};
use profivac_host::rate;
use profivac_host::scan::{FoundStation, probe_all};
use profivac_host::session::{BusSession, MAX_SLOT_TBIT, Reply, bus_parameters};
use profivac_station::config::Segment;
use profivac_virtual::open;
use std::time::Duration;

/// The highest address of a master (EN 50170-4: 126 and 127 are no addresses of masters).
const MAX_MASTER: u8 = 125;

/// The timeout unless `--timeout` sets another.
const TIMEOUT: Duration = Duration::from_secs(5);

/// The port and the options of the master.
#[derive(Args, Clone, Debug)]
pub struct BusOptions {
    /// A serial device, a pty, tcp://HOST:PORT, or sim:FILE.toml for a segment in memory
    #[arg(long, value_name = "PORT", value_parser = NonEmptyStringValueParser::new())]
    port: String,
    #[command(flatten)]
    options: MasterOptions,
}

/// The options of the master.
#[derive(Args, Clone, Debug)]
pub struct MasterOptions {
    /// Bits per second; with auto, a serial device listens at each rate until it receives a telegram
    #[arg(long, value_name = "RATE|auto", default_value = "19200", value_parser = values::rate)]
    baud: Rate,
    /// The address of this master; no other station may have it
    #[arg(long, value_name = "N", default_value_t = 0)]
    master: u8,
    /// The highest station address (HSA) that is searched
    #[arg(long, value_name = "N", default_value_t = 126)]
    hsa: u8,
    /// The slot time in bit times; default: the standard's value for the rate plus the latency of the port
    #[arg(long, value_name = "BITS")]
    slot_time: Option<u32>,
    /// Print the latency of the port and the bus timing derived from it
    #[arg(long, short)]
    verbose: bool,
    /// The longest wait for an answer, in seconds; default: 5. It also limits the wait until the token ring admits the master; without
    /// the option that wait is longer where the ring needs more time
    #[arg(long, value_name = "SECONDS", value_parser = values::seconds, allow_hyphen_values = true)]
    timeout: Option<Duration>,
    #[command(flatten)]
    device_files: DeviceFileOptions,
}

impl MasterOptions {
    /// A master at this address, with defaults for the rest.
    pub const fn new(baud: Baud, master: u8, hsa: u8) -> Self {
        let device_files = DeviceFileOptions::none();
        Self { baud: Rate::Known(baud), master, hsa, slot_time: None, verbose: false, timeout: None, device_files }
    }
}

/// A session whose waits a signal ends.
fn cancellable(mut session: BusSession) -> Result<BusSession, Failure> {
    session.set_cancellation(Some(Signals::of_command()?.cancellation()?));
    Ok(session)
}

impl BusOptions {
    /// The bus at `port`.
    pub fn new(port: &str, line: &MasterOptions) -> Self {
        Self { port: port.to_owned(), options: line.clone() }
    }

    /// The bus of a segment of a station's file.
    pub fn of_segment(segment: &Segment, line: &MasterOptions) -> Self {
        let line = MasterOptions { baud: Rate::Known(segment.baud), master: segment.master, ..line.clone() };
        Self { port: segment.port.clone(), options: line }
    }

    /// The same bus, for a master with another address.
    fn with_master(&self, master: u8) -> Self {
        Self { port: self.port.clone(), options: MasterOptions { master, ..self.options.clone() } }
    }

    /// The station that has the address of this master too: while the master uses the address, that station cannot be asked. So it is
    /// asked from the lowest address that is free, on the port of `session`; `seen` are the others that answered.
    pub fn station_at_own_address(
        &self,
        session: BusSession,
        seen: &[FoundStation],
    ) -> Result<Option<FoundStation>, Failure> {
        let own = self.master();
        let is_free = |address: &u8| *address != own && !seen.iter().any(|station| station.address == *address);
        let Some(free) = (0..=self.hsa().min(MAX_MASTER)).find(is_free) else { return Ok(None) };
        Signals::caught().map_or(Ok(()), Signals::check)?;
        let baud = session.baud();
        let mut session = cancellable(self.with_master(free).session_on(session.into_port(), baud)?)?;
        let mut found = Vec::new();
        probe_all(&mut session, [own], &mut found)?;
        Ok(found.pop())
    }

    /// Opens the port to listen, and finds its rate if that is `auto`.
    pub fn open_to_listen(&self) -> Result<(Box<dyn Port>, Baud), Failure> {
        self.options.device_files.read()?;
        open_port_to_listen(&self.port, self.options.baud)
    }

    /// Opens the port and makes a master that has sent nothing yet. A lost port is an error. From here on a signal ends the waits of
    /// the session and not the program: a connection has to be closed, a value restored, the token passed on. A command that a signal
    /// has ended opens no further session.
    pub fn open(&self) -> Result<BusSession, Failure> {
        self.open_unless(Signals::caught())
    }

    fn open_unless(&self, caught: Option<&Signals>) -> Result<BusSession, Failure> {
        caught.map_or(Ok(()), Signals::check)?;
        cancellable(self.open_session()?.0)
    }

    /// The same for a command that runs for long: a lost port is opened again until that succeeds.
    pub fn open_lasting(&self) -> Result<BusSession, Failure> {
        let (session, baud) = self.open_session()?;
        Ok(session.with_reopening(open::opener(&self.port, baud)))
    }

    /// Opens the port for `conform`, which also sends telegrams that no master sends. A session on this port had a slot time of
    /// `slot_time` in the end.
    pub fn open_probe(&self, slot_time: Duration) -> Result<PortLink, Failure> {
        let (port, baud) = open_port(&self.port, self.options.baud)?;
        Ok(self.probe_on(port, baud, slot_time))
    }

    /// The same on a port that is open.
    pub fn probe_on(&self, port: Box<dyn Port>, baud: Baud, slot_time: Duration) -> PortLink {
        let bus = self.parameters(baud, port.delivery());
        let measured_tbit = u32::try_from(tbit_of(baud, slot_time)).unwrap_or(u32::MAX);
        let bus = BusParameters { slot_tbit: bus.slot_tbit.max(measured_tbit), ..bus };
        self.report_timing(&*port, baud, &bus);
        PortLink::new(port, baud, bus)
    }

    fn open_session(&self) -> Result<(BusSession, Baud), Failure> {
        self.options.device_files.read()?;
        self.check()?;
        let (port, baud) = open_port(&self.port, self.options.baud)?;
        Ok((self.session_on(port, baud)?, baud))
    }

    /// Fails if the parameters of the master are out of range. They are checked before the port is opened.
    pub fn check(&self) -> Result<(), Failure> {
        let bus = self.parameters(self.options.baud.initial(), Delivery::Unpaced);
        bus.check().map(|_| ()).map_err(|error| Failure::usage(error.to_string()))
    }

    /// A master that has sent nothing yet, on a port that is open.
    pub fn session_on(&self, port: Box<dyn Port>, baud: Baud) -> Result<BusSession, Failure> {
        let bus = self.parameters(baud, port.delivery());
        self.report_timing(&*port, baud, &bus);
        let (name, is_timed) = (port.name().to_owned(), port.is_timed());
        let mut session = BusSession::new(port, baud, bus, self.options.timeout.unwrap_or(TIMEOUT))?;
        let verbose = self.options.verbose;
        let slot_time = duration_of(baud, bus.slot_tbit.into());
        session.on_close(move |timing, notices| {
            notices.iter().for_each(notice);
            if timing.turnaround > slot_time && (verbose || is_timed) {
                notice(&late_advice(baud, timing.turnaround));
            }
            if verbose {
                notice(&format_args!("{name}: {timing}"));
            }
        });
        if self.options.slot_time.is_some() {
            session = session.with_fixed_slot_time();
        }
        Ok(if self.options.timeout.is_none() { session.wait_for_ring_entry() } else { session })
    }

    /// The bus parameters of the master on a port with this rate and delivery.
    pub fn parameters(&self, baud: Baud, delivery: Delivery) -> BusParameters {
        let bus = bus_parameters(self.options.master, baud, delivery);
        BusParameters { hsa: self.options.hsa, slot_tbit: self.options.slot_time.unwrap_or(bus.slot_tbit), ..bus }
    }

    /// With `--verbose`: the latency of the port and the bus timing derived from it.
    fn report_timing(&self, port: &dyn Port, baud: Baud, bus: &BusParameters) {
        if !self.options.verbose {
            return;
        }
        let delivery = port.delivery();
        let milliseconds = |tbit: u64| duration_of(baud, tbit).as_secs_f64() * 1e3;
        notice(&format_args!(
            "{}: {delivery}; pauses up to {:.1} ms within a telegram are tolerated; slot time {} bit times ({:.1} ms)",
            port.name(),
            milliseconds(delivery.idle_tbit(baud)),
            bus.slot_tbit,
            milliseconds(bus.slot_tbit.into()),
        ));
    }

    /// Fails if `address` is the address of this master; `option` is the option or argument that named it.
    pub fn check_not_own_address(&self, address: u8, option: &str) -> Result<(), Failure> {
        if address == self.options.master {
            return Err(Failure::usage(format!(
                "{option} {address} is the address of this master; choose another with --master N"
            )));
        }
        Ok(())
    }

    /// The name of the port.
    pub fn port(&self) -> &str {
        &self.port
    }

    /// The rate.
    pub const fn rate(&self) -> Rate {
        self.options.baud
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

/// What to do when an answer came `turnaround` after its request, later than the slot time.
pub fn late_advice(baud: Baud, turnaround: Duration) -> String {
    let (turnaround_tbit, longest) = (tbit_of(baud, turnaround), u64::from(MAX_SLOT_TBIT));
    let remedy = match turnaround_tbit.saturating_mul(2).min(longest) {
        needed if needed >= turnaround_tbit => format!("run it again with --slot-time {needed}"),
        _ => "use an adapter with less delay, or a lower rate".to_owned(),
    };
    format!("answers come later than the slot time with which the command began: {remedy}")
}

/// The configuration that the slave returns to Get_Cfg; `None` if it returns none.
pub fn present_cfg(session: &mut BusSession, address: u8) -> Result<Option<Vec<u8>>, Failure> {
    match session.request(&services::get_cfg(address))? {
        Reply::Answer { du, .. } if !du.is_empty() => Ok(Some(du)),
        Reply::Answer { .. } | Reply::NoAnswer(_) => Ok(None),
    }
}

/// Opens a port, and finds its rate if that is `auto`.
pub fn open_port(name: &str, rate: Rate) -> Result<(Box<dyn Port>, Baud), Failure> {
    at_rate(open::port_unless(name, rate.initial(), &Signals::have_arrived)?, name, rate)
}

/// Opens a port to listen, a serial device for reading alone. With `auto` listens at each rate until it receives a telegram.
pub fn open_port_to_listen(name: &str, rate: Rate) -> Result<(Box<dyn Port>, Baud), Failure> {
    let initial = rate.initial();
    let port = if name.starts_with("sim:") {
        open::port(name, initial)?
    } else {
        port::open_to_listen_unless(name, initial, &Signals::have_arrived)?
    };
    at_rate(port, name, rate)
}

/// Sets the rate of an open port.
fn at_rate(mut port: Box<dyn Port>, name: &str, rate: Rate) -> Result<(Box<dyn Port>, Baud), Failure> {
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

#[cfg(test)]
#[allow(clippy::unwrap_used, reason = "a test")]
mod tests {
    use super::*;
    use signal_hook::consts::SIGUSR2;

    /// The port does not exist: to open it is another error.
    #[test]
    fn a_command_that_a_signal_has_ended_opens_no_further_session() {
        let signals = Signals::of(&[SIGUSR2]).unwrap();
        let bus = BusOptions::new("/nowhere", &MasterOptions::new(Baud::B19200, 0, 126));
        assert!(!bus.open_unless(Some(&signals)).err().unwrap().is_interrupted());
        signal_hook::low_level::raise(SIGUSR2).unwrap();
        assert!(bus.open_unless(Some(&signals)).err().unwrap().is_interrupted());
    }
}
