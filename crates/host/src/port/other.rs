//! Replaces `linux.rs` on other systems. `./test` compiles it for macOS; it has never run there.
//!
//! Serial devices and TCP need only POSIX. Adapters must switch their transmitter themselves. The opening of a pty is
//! detected when the stations on it wake next, which virtual devices do every 100 ms.

use super::notice::Notice;
use super::{AdapterFacts, Delivery};
use crate::readiness::Readiness;
use rustix::fd::OwnedFd;
use rustix::io::Errno;
use std::fs;
use std::path::Path;
use std::time::Duration;

/// Whether a device is the slave side of a pty, by the names of macOS and the BSDs.
pub fn is_pty(path: impl AsRef<Path>) -> bool {
    let device = fs::canonicalize(path).unwrap_or_default();
    let device = device.to_string_lossy();
    device.starts_with("/dev/ttys") || device.starts_with("/dev/pts/") || device.starts_with("/dev/ttyp")
}

/// Returns the notice that the kernel does not switch the transmitter.
pub fn set_up(_device: &OwnedFd, name: &str) -> Vec<Notice> {
    vec![Notice::TransmitterNotSwitched(name.to_owned())]
}

/// Nothing is known about the driver: characters come as late as by the slowest usual adapter.
pub fn delivery(_name: &str) -> Delivery {
    Delivery::Usb { hold: Duration::from_millis(16), is_known: false }
}

/// Other programs are unknown.
pub fn open_elsewhere(_name: &str) -> Vec<Notice> {
    Vec::new()
}

/// Nothing is known about the hardware.
pub fn adapter_facts(_name: &str) -> AdapterFacts {
    AdapterFacts::default()
}

/// Nothing is known about adapters.
pub fn port_of_serial(_serial: &str) -> Option<String> {
    None
}

/// The driver reports the rate itself.
pub fn real_rate(_name: &str, _wanted: u32) -> Option<u32> {
    None
}

/// Reports no openings of the slave side of a pty.
#[derive(Debug)]
pub struct OpenEvents;

impl OpenEvents {
    /// Always succeeds.
    pub fn new() -> Result<Self, Errno> {
        Ok(Self)
    }

    /// Watches nothing.
    pub fn watch(&self, _side: &Path) -> Result<(), Errno> {
        Ok(())
    }

    /// Never becomes readable.
    pub fn readiness(&self) -> Option<Readiness<'_>> {
        None
    }

    /// No events exist.
    pub fn drain(&self) -> bool {
        false
    }
}

/// Claims nothing: a link in use is known by its age alone.
#[derive(Debug)]
pub struct LinkClaim;

impl LinkClaim {
    /// Always succeeds.
    pub fn of(_path: &Path) -> std::io::Result<Self> {
        Ok(Self)
    }

    /// Always false.
    pub fn is_held(_path: &Path) -> bool {
        false
    }
}
