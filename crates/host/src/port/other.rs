//! What Linux has and other systems do not, or do differently. Unverified: nobody has built or run this.
//!
//! Serial devices and TCP need no more than POSIX. Adapters have to switch their transmitter by themselves, and a pty is
//! noticed to be opened when the stations on it wake the next time, which virtual devices do every 100 ms.

use super::remark::Remark;
use rustix::fd::{BorrowedFd, OwnedFd};
use rustix::io::Errno;
use std::fs;
use std::path::Path;

/// Whether a device is the other side of a pty, as macOS and the BSDs call them.
pub fn is_pty(name: &str) -> bool {
    let device = fs::canonicalize(name).unwrap_or_default();
    let device = device.to_string_lossy();
    device.starts_with("/dev/ttys") || device.starts_with("/dev/pts/") || device.starts_with("/dev/ttyp")
}

/// Sets a device of copper up as well as it can be, and says what cannot be.
pub fn set_up(_device: &OwnedFd, name: &str) -> Vec<Remark> {
    vec![Remark::Direction(name.to_owned())]
}

/// Would report every opening of the other side of a pty.
#[derive(Debug)]
pub struct Openings;

impl Openings {
    /// Watches nothing.
    pub fn of(_side: &Path) -> Result<Self, Errno> {
        Ok(Self)
    }

    /// Nothing becomes readable with an opening.
    pub fn watched(&self) -> Option<BorrowedFd<'_>> {
        None
    }

    /// There is nothing to forget.
    pub fn forget(&self) {}
}
