//! Why a port cannot be used. Each message says what to do about it.

use profivac_dp::link::Baud;
use rustix::io::Errno;
use std::error::Error;
use std::fmt;

/// The reason why a port cannot be used.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum PortError {
    /// No device, file or listening host has this name.
    #[error("there is no port {0}: plug in the adapter, or start the program that serves it")]
    NotFound(String),
    /// Another program has locked the port.
    #[error("{0} is in use by another program: end that program first; `fuser -v` names it")]
    InUse(String),
    /// The user may not open the port.
    #[error("no permission to open {0}: for a serial device, join its group (usually dialout) and log in again")]
    PermissionDenied(String),
    /// The file is neither a serial device nor a pty.
    #[error("{0} is not a serial device")]
    NotSerial(String),
    /// The adapter does not support the baud rate.
    #[error("{name} cannot run at {baud}{}: use another adapter or another rate", or_else(*offered))]
    UnsupportedRate {
        /// The port.
        name: String,
        /// The requested rate.
        baud: Baud,
        /// The rate at which it would run instead, in bit/s, if that is known.
        offered: Option<u32>,
    },
    /// The adapter does not support the character format of PROFIBUS.
    #[error("{name} cannot send 8 data bits with even parity and one stop bit (8E1): the driver set {offered} instead")]
    UnsupportedCharacter {
        /// The port.
        name: String,
        /// The format that the driver set instead.
        offered: CharacterFormat,
    },
    /// The port has no baud rate, so none can be detected.
    #[error("{0} has no transmission rate to detect")]
    NoBaudRate(String),
    /// No telegram was received at any rate.
    #[error(
        "no telegram on {name} at any of {} bit/s: detection needs another master that sends; otherwise give the rate as a number",
        rates(tried)
    )]
    NoTelegram {
        /// The port.
        name: String,
        /// The rates that were tried.
        tried: Vec<Baud>,
    },
    /// The path of a pty belongs to another file.
    #[error("{0} exists already: remove it, or stop the program that serves it")]
    AlreadyExists(String),
    /// The system cannot create a link at the path of a pty.
    #[error(
        "no link to a pty can be created at {path} ({source}): choose a path in a folder that exists and takes new files"
    )]
    NotCreatable {
        /// The path.
        path: String,
        /// The error of the system.
        source: std::io::Error,
    },
    /// The text is not `HOST:PORT`.
    #[error("expected HOST:PORT, got {0:?} (an IPv6 address in brackets: [::1]:4000)")]
    InvalidAddress(String),
    /// The host name has no address.
    #[error("{name}: the name of the host cannot be resolved: {source}")]
    UnresolvedHost {
        /// The port.
        name: String,
        /// The error of the resolver.
        source: std::io::Error,
    },
    /// The host did not answer.
    #[error(
        "{name} does not answer within {seconds} s: check that the serial server is switched on and in this network"
    )]
    Unreachable {
        /// The port.
        name: String,
        /// The timeout.
        seconds: u64,
    },
    /// The file that describes the port is wrong. Only ports of other crates are described by files.
    #[error(transparent)]
    File(Box<dyn Error + Send + Sync>),
    /// The port was open and is gone.
    #[error("lost {0}: it was unplugged, or its other side was closed")]
    Lost(String),
    /// Another error of the operating system.
    #[error("{name}: {source}")]
    System {
        /// The port.
        name: String,
        /// The error.
        source: std::io::Error,
    },
}

/// Data bits, parity and stop bits of a serial device.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct CharacterFormat {
    /// 5 to 8.
    pub data_bits: u8,
    /// The parity bit.
    pub parity: Parity,
    /// 1 or 2.
    pub stop_bits: u8,
}

/// The parity bit of a character.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Parity {
    /// No parity bit.
    None,
    /// Even parity, as PROFIBUS requires it.
    Even,
    /// Odd parity.
    Odd,
}

impl CharacterFormat {
    /// 8E1, the format of PROFIBUS.
    pub const PROFIBUS: Self = Self { data_bits: 8, parity: Parity::Even, stop_bits: 1 };
}

impl fmt::Display for CharacterFormat {
    /// The usual three characters: `8E1`.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let parity = match self.parity {
            Parity::None => 'N',
            Parity::Even => 'E',
            Parity::Odd => 'O',
        };
        write!(f, "{}{parity}{}", self.data_bits, self.stop_bits)
    }
}

fn or_else(offered: Option<u32>) -> String {
    offered.map_or(String::new(), |offered| format!(", it would run at {offered} bit/s"))
}

fn rates(tried: &[Baud]) -> String {
    tried.iter().map(|baud| baud.bits_per_second().to_string()).collect::<Vec<_>>().join(", ")
}

impl PortError {
    /// The meaning of an error number when a port is opened.
    pub(super) fn opening(name: &str, errno: Errno) -> Self {
        match errno {
            Errno::NOENT | Errno::NODEV | Errno::NXIO | Errno::NOTDIR => Self::NotFound(name.to_owned()),
            Errno::BUSY | Errno::WOULDBLOCK => Self::InUse(name.to_owned()),
            Errno::ACCESS | Errno::PERM => Self::PermissionDenied(name.to_owned()),
            Errno::NOTTY | Errno::ISDIR => Self::NotSerial(name.to_owned()),
            // The slave side of a pty reports this when its server has ended.
            Errno::IO => Self::NotFound(name.to_owned()),
            _ => Self::system(name, errno),
        }
    }

    /// The meaning of an error number on a port that is open.
    pub(super) fn using(name: &str, errno: Errno) -> Self {
        match errno {
            Errno::IO | Errno::NXIO | Errno::NODEV | Errno::PIPE | Errno::CONNRESET | Errno::BADF => {
                Self::Lost(name.to_owned())
            }
            _ => Self::system(name, errno),
        }
    }

    /// An error of the operating system on the port `name`.
    pub fn system(name: &str, source: impl Into<std::io::Error>) -> Self {
        Self::System { name: name.to_owned(), source: source.into() }
    }
}
