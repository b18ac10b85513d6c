//! Why a port cannot be used. Each message says what to do about it.

use profivac_dp::link::Baud;
#[cfg(unix)]
use rustix::io::Errno;
use std::error::Error;
use std::fmt;

/// The reason why a port cannot be used.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum PortError {
    /// No device, file or listening host has this name.
    NotFound(String),
    /// The path is a link that is older than the pty it leads to: its program was killed, and another program has the pty by now.
    LeftOver(String),
    /// Another program has locked the port.
    InUse(String),
    /// Another program has locked the pty (TIOCEXCL). The lock outlives the program if a signal ended it.
    PtyLocked(String),
    /// Another program listens at the address.
    AddressInUse(String),
    /// The user may not open the port.
    PermissionDenied(String),
    /// The file is neither a serial device nor a pty.
    NotSerial(String),
    /// The adapter does not support the baud rate.
    UnsupportedRate {
        /// The port.
        name: String,
        /// The requested rate.
        baud: Baud,
        /// The rate at which it would run instead, in bit/s, if that is known.
        offered: Option<u32>,
    },
    /// The adapter does not support the character format of PROFIBUS.
    UnsupportedCharacter {
        /// The port.
        name: String,
        /// The format that the driver set instead.
        offered: CharacterFormat,
    },
    /// The port has no baud rate, so none can be detected.
    NoBaudRate(String),
    /// No telegram was received at any rate.
    NoTelegram {
        /// The port.
        name: String,
        /// The rates that were tried.
        tried: Vec<Baud>,
    },
    /// The system has no ptys.
    NoPtys(String),
    /// The path of a pty belongs to another file.
    AlreadyExists(String),
    /// The system cannot create a link at the path of a pty.
    NotCreatable {
        /// The path.
        path: String,
        /// The error of the system.
        source: std::io::Error,
    },
    /// A name with `://` whose first part is no kind of port.
    UnknownScheme(String),
    /// The text is not `HOST:PORT`.
    InvalidAddress(String),
    /// The host name has no address.
    UnresolvedHost {
        /// The port.
        name: String,
        /// The error of the resolver.
        source: std::io::Error,
    },
    /// The host did not answer.
    Unreachable {
        /// The port.
        name: String,
        /// The timeout.
        seconds: u64,
    },
    /// The server closes each connection before it has passed anything.
    ServerBusy {
        /// The port.
        name: String,
        /// What the server says; may be empty.
        words: String,
    },
    /// The caller has ended the wait for the port, see [`open_unless`](super::open_unless).
    Interrupted(String),
    /// The file that describes the port is wrong. Only ports of other crates are described by files.
    File(Box<dyn Error + Send + Sync>),
    /// The port was open and is gone.
    Lost(String),
    /// Another error of the operating system.
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

/// Whether a name of a port is a path, and not the last part of one (`ttyUSB0`).
fn is_path(name: &str) -> bool {
    name.contains('/')
}

fn is_tcp(name: &str) -> bool {
    ["tcp://", "telnet://", "rfc2217://"].iter().any(|scheme| name.starts_with(scheme))
}

/// Whether a name that is no port is a host and a port: `192.168.1.5:4000`.
fn is_host_and_port(name: &str) -> bool {
    let parts = name.rsplit_once(':').filter(|(host, _)| !host.is_empty() && !is_path(host));
    parts.is_some_and(|(_, port)| port.parse::<u16>().is_ok())
}

/// Whether a name is a port of Windows: `COM3`.
pub(super) fn is_windows_port(name: &str) -> bool {
    let number = name.get(..3).filter(|start| start.eq_ignore_ascii_case("com")).and_then(|_| name.get(3..));
    number.is_some_and(|number| number.parse::<u16>().is_ok())
}

fn rates(tried: &[Baud]) -> String {
    tried.iter().map(|baud| baud.bits_per_second().to_string()).collect::<Vec<_>>().join(", ")
}

impl fmt::Display for PortError {
    /// The condition, and behind a colon the remedy.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.condition(f)?;
        self.remedy().map_or(Ok(()), |remedy| write!(f, ": {remedy}"))
    }
}

impl PortError {
    /// What the user can do, if the error shows it.
    #[must_use]
    pub fn remedy(&self) -> Option<&'static str> {
        match self {
            Self::NotFound(name) if is_tcp(name) => {
                Some("start the program that serves it, or check the address and the port of the serial server")
            }
            Self::NotFound(name) if is_host_and_port(name) => Some("a line over TCP has the name tcp://HOST:PORT"),
            Self::NotFound(name) if name.starts_with("usb:") => {
                Some("plug in the adapter with this serial number; `profivac doctor` lists the adapters")
            }
            Self::NotFound(name) if is_windows_port(name) && cfg!(windows) => {
                Some("plug in the adapter; `profivac doctor` lists the ports of this computer")
            }
            Self::NotFound(name) if is_windows_port(name) => Some(
                "COM ports exist on Windows; on Linux a serial device is a path such as /dev/ttyUSB0; a line over TCP is tcp://HOST:PORT",
            ),
            Self::NotFound(name) if is_path(name) => Some("plug in the adapter, or start the program that serves it"),
            Self::NotFound(_) if cfg!(windows) => {
                Some("give the name of a serial port, such as COM5; `profivac doctor` lists the ports of this computer")
            }
            Self::NotFound(_) => {
                Some("give the path of a serial device, such as /dev/ttyUSB0, or start the program that serves it")
            }
            Self::LeftOver(_) => Some("start that program again; if the link is right, make it again"),
            Self::InUse(_) if cfg!(windows) => Some("end that program first; Windows does not name it"),
            Self::InUse(_) => Some("end that program first; `fuser -v`, as root, names it"),
            Self::PtyLocked(_) => Some(
                "end the program that `fuser -v`, as root, names; if it names none, a signal ended that program: start the \
                 program that serves the pty again",
            ),
            Self::AddressInUse(_) if cfg!(windows) => {
                Some("end that program first, or choose another port; `netstat -abno`, as administrator, names it")
            }
            Self::AddressInUse(_) => {
                Some("end that program first, or choose another port; `ss -ltnp`, as root, names it")
            }
            Self::PermissionDenied(_) => Some("for a serial device, join its group (usually dialout) and log in again"),
            Self::UnsupportedRate { .. } => Some("use another adapter or another rate"),
            Self::NoTelegram { .. } => {
                Some("detection needs another master that sends; otherwise give the rate as a number")
            }
            Self::NoPtys(_) => Some("serve the line with --tcp and open it as tcp://HOST:PORT"),
            Self::AlreadyExists(_) => Some("remove it, or stop the program that serves it"),
            Self::NotCreatable { .. } => Some("choose a path in a folder that exists and takes new files"),
            Self::Unreachable { .. } => Some("check that the serial server is switched on and in this network"),
            Self::ServerBusy { .. } => {
                Some("another program may be connected to it: end that program, or let the server take more clients")
            }
            Self::UnknownScheme(_) => Some(
                "a port is a path such as /dev/ttyUSB0 or COM5, usb:SERIAL, tcp://HOST:PORT for raw octets, telnet://HOST:PORT, rfc2217://HOST:PORT for a server whose rate is set from here, or sim:FILE.toml",
            ),
            Self::NotSerial(_)
            | Self::UnsupportedCharacter { .. }
            | Self::NoBaudRate(_)
            | Self::InvalidAddress(_)
            | Self::UnresolvedHost { .. }
            | Self::Interrupted(_)
            | Self::File(_)
            | Self::Lost(_)
            | Self::System { .. } => None,
        }
    }

    /// The sentence without the remedy.
    #[must_use]
    pub fn found(&self) -> String {
        struct Found<'a>(&'a PortError);
        impl fmt::Display for Found<'_> {
            fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                self.0.condition(f)
            }
        }
        Found(self).to_string()
    }

    fn condition(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::NotFound(name) if is_tcp(name) => write!(f, "{name}: connection refused, no program listens there"),
            Self::NotFound(name) => write!(f, "there is no port {name}"),
            Self::LeftOver(name) => write!(
                f,
                "{name} is older than the pty it leads to: the program that made the link was killed, or the pty has \
                 another owner or mode since"
            ),
            Self::InUse(name) | Self::AddressInUse(name) => write!(f, "{name} is in use by another program"),
            Self::PtyLocked(name) => write!(f, "{name} is locked by another program"),
            Self::PermissionDenied(name) => write!(f, "no permission to open {name}"),
            Self::NotSerial(name) => write!(f, "{name} is not a serial device"),
            Self::UnsupportedRate { name, baud, offered } => {
                write!(f, "{name} cannot run at {baud}{}", or_else(*offered))
            }
            Self::UnsupportedCharacter { name, offered } => write!(
                f,
                "{name} cannot send 8 data bits with even parity and one stop bit (8E1): the driver set {offered} instead"
            ),
            Self::NoBaudRate(name) => write!(f, "{name} has no transmission rate to detect"),
            Self::NoTelegram { name, tried } => {
                write!(f, "no telegram on {name} at any of {} bit/s", rates(tried))
            }
            Self::NoPtys(path) => write!(f, "no pty can be made at {path}, Windows has none"),
            Self::AlreadyExists(path) => write!(f, "{path} exists already"),
            Self::NotCreatable { path, source } => {
                write!(f, "no link to a pty can be created at {path} ({source})")
            }
            Self::UnknownScheme(name) => write!(f, "{name} is no kind of port"),
            Self::InvalidAddress(text) => {
                write!(f, "expected HOST:PORT, got {text:?} (an IPv6 address in brackets: [::1]:4000)")
            }
            Self::UnresolvedHost { name, source } => {
                write!(f, "{name}: the name of the host cannot be resolved: {source}")
            }
            Self::Unreachable { name, seconds } => write!(f, "{name} does not answer within {seconds} s"),
            Self::ServerBusy { name, words } if words.is_empty() => {
                write!(f, "the server at {name} closes each connection at once")
            }
            Self::ServerBusy { name, words } => {
                write!(f, "the server at {name} closes each connection at once and says '{words}'")
            }
            Self::Interrupted(name) => write!(f, "{name}: interrupted while the server closed each connection at once"),
            Self::File(error) => write!(f, "{error}"),
            Self::Lost(name) => write!(f, "lost {name}: it was unplugged, or its other side was closed"),
            Self::System { name, source } => write!(f, "{name}: {source}"),
        }
    }

    /// The meaning of an error number when a port is opened.
    #[cfg(unix)]
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

    /// The meaning of an error of Windows when a port is opened: access is denied while another program has it open.
    #[cfg(windows)]
    pub(super) fn opening(name: &str, error: std::io::Error) -> Self {
        match error.kind() {
            std::io::ErrorKind::NotFound => Self::NotFound(name.to_owned()),
            std::io::ErrorKind::PermissionDenied | std::io::ErrorKind::ResourceBusy => Self::InUse(name.to_owned()),
            _ => Self::system(name, error),
        }
    }

    /// The meaning of an error number on a port that is open.
    #[cfg(unix)]
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_port_that_is_not_there_has_the_remedy_for_its_kind() {
        for (name, sentence) in [
            ("tcp://127.0.0.1:9", "tcp://127.0.0.1:9: connection refused, no program listens there: start"),
            ("rfc2217://10.0.0.1:9", "rfc2217://10.0.0.1:9: connection refused, no program listens there: start"),
            ("192.168.1.5:4000", "there is no port 192.168.1.5:4000: a line over TCP has the name tcp://HOST:PORT"),
            ("server:4000", "there is no port server:4000: a line over TCP has the name"),
            ("COM3", "there is no port COM3: COM ports exist on Windows; on Linux a serial device is a path"),
            ("usb:A1", "there is no port usb:A1: plug in the adapter with this serial number"),
            ("ttyUSB0", "there is no port ttyUSB0: give the path"),
            ("/dev/pci:1", "there is no port /dev/pci:1: plug in"),
            ("common", "there is no port common: give the path"),
        ] {
            let shown = PortError::NotFound(name.to_owned()).to_string();
            assert!(shown.starts_with(sentence), "{shown}");
        }
    }

    #[test]
    fn a_sentence_is_what_was_found_and_the_remedy() {
        let missing = PortError::NotFound("/dev/x".to_owned());
        assert_eq!(missing.found(), "there is no port /dev/x");
        assert_eq!(
            missing.to_string(),
            "there is no port /dev/x: plug in the adapter, or start the program that serves it"
        );
        let part = PortError::NotFound("ttyUSB0".to_owned());
        let expected = "there is no port ttyUSB0: give the path of a serial device, such as /dev/ttyUSB0, or start the program that serves it";
        assert_eq!(part.to_string(), expected);
        let address = PortError::InvalidAddress("x".to_owned());
        assert_eq!(address.remedy(), None);
        assert_eq!(address.to_string(), "expected HOST:PORT, got \"x\" (an IPv6 address in brackets: [::1]:4000)");
        assert_eq!(address.found(), address.to_string());
    }
}
