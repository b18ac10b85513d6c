//! Ports: the connections of a segment to the outside.
//!
//! | Port | Opened by | The other side |
//! |---|---|---|
//! | [`Serial`] | a device name | a line, or a pty that another program serves |
//! | [`Pty`] | a path that becomes a link | a program that opens the path as its serial port |
//! | [`TcpServer`] | an address to listen on | any number of clients, which share one line |
//! | [`TcpClient`] | `tcp://host:port` | a serial server, or a [`TcpServer`] |
//! | [`TelnetClient`] | `telnet://host:port`, `rfc2217://host:port` | a serial server that speaks telnet; RFC 2217 sets its rate and 8E1 |
//! | [`Stream`] | the same program | a segment in memory |
//! | [`Reopening`] | any of them | the same, lost and opened again |
//! | [`Recorded`] | any of them | the same, with a record of its traffic |
//!
//! A port never blocks and never panics: octets that the other side does not take are dropped, and a lost port is an error.
//! A condition that impairs the port without stopping it is a [`Notice`].

mod adapter;
mod delivery;
mod doubled_ff;
#[cfg(all(test, target_os = "linux"))]
mod driver_rates;
mod echo;
mod error;
#[cfg(windows)]
pub mod list;
#[cfg(unix)]
mod marks;
mod notice;
#[cfg_attr(windows, path = "windows/pty.rs")]
mod pty;
mod recorded;
mod reopening;
#[cfg_attr(windows, path = "windows/serial.rs")]
mod serial;
mod server;
mod settings;
mod stream;
mod tcp;
mod telnet;
mod time;

#[cfg(target_os = "linux")]
#[path = "linux.rs"]
mod system;
#[cfg(windows)]
#[path = "windows/system.rs"]
mod system;
#[cfg(not(any(target_os = "linux", windows)))]
#[path = "other.rs"]
mod system;

pub use adapter::AdapterFacts;
pub use delivery::{Delivery, SCHEDULING_DELAY};
pub use error::{CharacterFormat, Parity, PortError};
pub use notice::{LateAnswerRemedy, Notice, StoreDamage};
pub use pty::Pty;
pub use recorded::{Direction, Recorded, RecordedChunk, Recording};
pub use reopening::{Opener, Reopening};
pub use serial::{Serial, check_access, is_serial_port};
pub use stream::Stream;
pub use system::{adapter_facts, delivery as delivery_of, open_elsewhere};
pub use tcp::{TcpClient, TcpServer};
pub use telnet::TelnetClient;
pub use time::{PortClock, wait_for_port};

use crate::readiness::Readiness;
use profivac_dp::link::Baud;
use std::time::Duration;

/// A received character.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Character {
    /// A character without error.
    Octet(u8),
    /// A character with a parity or framing error.
    Error,
}

/// Finds the other programs that have the device of a port open: a [`Notice::OpenElsewhere`] for each. It takes some milliseconds, so it
/// may run in a thread.
pub type ReaderSearch = Box<dyn FnOnce() -> Vec<Notice> + Send>;

/// An open port.
pub trait Port: Send {
    /// The name of the port as the user wrote it.
    fn name(&self) -> &str;

    /// How received characters reach the program. It may change with [`set_baud`](Self::set_baud) and when the port is
    /// opened again.
    fn delivery(&self) -> Delivery {
        Delivery::Unpaced
    }

    /// Whether the port sends at a baud rate. If not, octets arrive when they are sent.
    fn is_timed(&self) -> bool {
        self.delivery().is_timed()
    }

    /// The sources that become readable when [`receive`](Self::receive) has something to do.
    fn readiness(&self) -> Vec<Readiness<'_>>;

    /// Appends the received characters to `characters`, possibly none.
    ///
    /// # Errors
    /// [`PortError::Lost`] when nothing can arrive any more.
    fn receive(&mut self, characters: &mut Vec<Character>) -> Result<(), PortError>;

    /// Sends `octets`. Drops what the other side does not take, with a [`Notice::OctetsDropped`].
    ///
    /// # Errors
    /// [`PortError::Lost`] when nothing can be sent any more.
    fn send(&mut self, octets: &[u8]) -> Result<(), PortError>;

    /// Changes the baud rate.
    ///
    /// # Errors
    /// [`PortError::NoBaudRate`] for a port without a rate, [`PortError::UnsupportedRate`] if the adapter does not have
    /// this one.
    fn set_baud(&mut self, _baud: Baud) -> Result<(), PortError> {
        Err(PortError::NoBaudRate(self.name().to_owned()))
    }

    /// Takes the oldest notice.
    fn next_notice(&mut self) -> Option<Notice> {
        None
    }

    /// How to find the programs that may take received octets away. `None` for a port that no other program can read.
    fn reader_search(&self) -> Option<ReaderSearch> {
        None
    }

    /// The time on the clock of a simulated port, since it was opened. `None`: the clock of the system applies.
    fn simulated_time(&self) -> Option<Duration> {
        None
    }

    /// Advances the clock of a simulated port by at most `at_most`, and only until it has received something.
    fn simulate(&mut self, _at_most: Duration) {}

    /// Changes whenever the port was lost and opened again: protocols on it must start again.
    fn generation(&self) -> u32 {
        0
    }
}

/// How the name of a port begins that is the serial number of its USB adapter: `usb:A50285BI`.
const USB: &str = "usb:";

/// The present name of the port of a USB adapter, which changes when the adapter is plugged in elsewhere.
fn port_of_adapter(name: &str, serial: &str) -> Result<String, PortError> {
    system::port_of_serial(serial).ok_or_else(|| PortError::NotFound(name.to_owned()))
}

/// Opens the port `name`: `tcp://`, `telnet://` or `rfc2217://` with HOST:PORT, `usb:` with the serial number of an adapter, or the name
/// of a serial device or pty.
///
/// # Errors
/// A [`PortError`] that names the port and says what to do.
pub fn open(name: &str, baud: Baud) -> Result<Box<dyn Port>, PortError> {
    open_unless(name, baud, &|| false)
}

/// The same, but a server that has another client is waited for only until `is_cancelled` returns `true`: a program that catches signals
/// ends the wait with one.
///
/// # Errors
/// As [`open`], and [`PortError::Interrupted`].
pub fn open_unless(name: &str, baud: Baud, is_cancelled: &dyn Fn() -> bool) -> Result<Box<dyn Port>, PortError> {
    if let Some(serial) = name.strip_prefix(USB) {
        return Ok(Box::new(Serial::open(&port_of_adapter(name, serial)?, baud)?));
    }
    Ok(match name.split_once("://") {
        Some(("tcp", address)) => Box::new(server::open(name, is_cancelled, || TcpClient::connect(address))?),
        Some((scheme @ ("telnet" | "rfc2217"), address)) => {
            let baud = (scheme == "rfc2217").then_some(baud);
            let begin = || TelnetClient::begin(name.to_owned(), tcp::connect(name, address)?, baud);
            Box::new(server::open(name, is_cancelled, begin)?)
        }
        Some((scheme, _)) if !scheme.contains('/') => return Err(PortError::UnknownScheme(name.to_owned())),
        _ => Box::new(Serial::open(name, baud)?),
    })
}

/// Opens the port `name` to listen: a serial device or pty for reading alone, so that the operating system refuses to send. A TCP
/// connection has no such mode.
///
/// # Errors
/// As [`open`].
pub fn open_to_listen(name: &str, baud: Baud) -> Result<Box<dyn Port>, PortError> {
    open_to_listen_unless(name, baud, &|| false)
}

/// The same with the wait of [`open_unless`].
///
/// # Errors
/// As [`open_unless`].
pub fn open_to_listen_unless(
    name: &str,
    baud: Baud,
    is_cancelled: &dyn Fn() -> bool,
) -> Result<Box<dyn Port>, PortError> {
    if name.contains("://") {
        return open_unless(name, baud, is_cancelled);
    }
    if let Some(serial) = name.strip_prefix(USB) {
        return Ok(Box::new(Serial::open_to_listen(&port_of_adapter(name, serial)?, baud)?));
    }
    Ok(Box::new(Serial::open_to_listen(name, baud)?))
}

/// The largest number of octets read at once.
const CHUNK: usize = 4096;

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_unknown_kind_of_port_names_those_that_exist() {
        for open in [open, open_to_listen] {
            for name in ["udp://x:1", "socket://x:1", "serial:///dev/ttyUSB0"] {
                let refused = open(name, Baud::B19200).map(|_| ()).unwrap_err().to_string();
                assert!(refused.starts_with(&format!("{name} is no kind of port: ")), "{refused}");
                for kind in ["/dev/ttyUSB0", "tcp://", "telnet://", "rfc2217://", "sim:"] {
                    assert!(refused.contains(kind), "{refused}");
                }
            }
            assert!(matches!(open("telnet://x", Baud::B19200), Err(PortError::InvalidAddress(_))));
        }
    }
}
