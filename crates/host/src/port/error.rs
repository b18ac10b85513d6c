//! Why a port cannot be used, in one sentence that says what to do.

use profivac_dp::link::Baud;
use rustix::io::Errno;

/// Why a port cannot be used.
#[derive(Debug, thiserror::Error)]
pub enum PortError {
    /// There is nothing of this name.
    #[error("there is no port {0}: is the adapter plugged in, or the program running that makes it?")]
    NotFound(String),
    /// Somebody else has it.
    #[error("{0} is in use by another program: end that first (fuser -v tells which it is)")]
    InUse(String),
    /// The user may not open it.
    #[error("no permission to open {0}: for a serial device, join its group (mostly dialout) and log in again")]
    PermissionDenied(String),
    /// The name stands for something that carries no octets.
    #[error("{0} is not a serial device")]
    NotSerial(String),
    /// The adapter has no such rate.
    #[error("{name} cannot run at {baud}, it offers {offered} bit/s")]
    UnsupportedRate {
        /// The port.
        name: String,
        /// What was asked for.
        baud: Baud,
        /// What the driver made of it.
        offered: u32,
    },
    /// The adapter has no such characters.
    #[error("{name} cannot send 8 data bits with even parity and one stop bit (8E1), it offers {offered}")]
    UnsupportedCharacter {
        /// The port.
        name: String,
        /// What the driver made of it, like `8N1`.
        offered: String,
    },
    /// The port does not run at a rate, so there is none to be searched for.
    #[error("{0} has no rate that could be searched for: give it as a number (--baud 19200)")]
    NoBaudRate(String),
    /// Nobody was heard at any rate.
    #[error("no telegram on {name} at any of {tried} bit/s: a rate is found by listening to another master")]
    NoTelegram {
        /// The port.
        name: String,
        /// The rates tried.
        tried: String,
    },
    /// The path of a pty is taken by something else.
    #[error("{0} exists already: remove it, or stop the program that serves it")]
    AlreadyExists(String),
    /// No `HOST:PORT`.
    #[error("expected HOST:PORT, got {0:?} (an IPv6 address in brackets: [::1]:4000)")]
    InvalidAddress(String),
    /// The host has no address.
    #[error("{name}: the name of the host cannot be resolved: {source}")]
    UnresolvedHost {
        /// The port.
        name: String,
        /// What the system says.
        source: std::io::Error,
    },
    /// Nothing came back from the host.
    #[error("{name} does not answer within {seconds} s: is the serial server switched on and in this network?")]
    Unreachable {
        /// The port.
        name: String,
        /// How long it was waited for.
        seconds: u64,
    },
    /// A file that describes a segment says something it cannot.
    #[error("{0}")]
    File(String),
    /// It worked, and does not any more.
    #[error("lost {0}: it was unplugged, or its other side was closed")]
    Lost(String),
    /// Anything else the system says.
    #[error("{name}: {source}")]
    System {
        /// The port.
        name: String,
        /// What the system says.
        source: std::io::Error,
    },
}

impl PortError {
    /// What an error means when a port is opened.
    pub(super) fn opening(name: &str, errno: Errno) -> Self {
        match errno {
            Errno::NOENT | Errno::NODEV | Errno::NXIO | Errno::NOTDIR => Self::NotFound(name.to_owned()),
            Errno::BUSY | Errno::WOULDBLOCK => Self::InUse(name.to_owned()),
            Errno::ACCESS | Errno::PERM => Self::PermissionDenied(name.to_owned()),
            Errno::NOTTY | Errno::ISDIR => Self::NotSerial(name.to_owned()),
            // What opening the other side of a pty says once its server is gone.
            Errno::IO => Self::NotFound(name.to_owned()),
            _ => Self::system(name, errno),
        }
    }

    /// What an error means once a port was open.
    pub(super) fn using(name: &str, errno: Errno) -> Self {
        match errno {
            Errno::IO | Errno::NXIO | Errno::NODEV | Errno::PIPE | Errno::CONNRESET | Errno::BADF => {
                Self::Lost(name.to_owned())
            }
            _ => Self::system(name, errno),
        }
    }

    pub(super) fn system(name: &str, source: impl Into<std::io::Error>) -> Self {
        Self::System { name: name.to_owned(), source: source.into() }
    }
}
