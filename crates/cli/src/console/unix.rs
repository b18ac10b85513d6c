//! Signals and standard input on Unix: both are descriptors.

pub use signal_hook::consts::{SIGHUP, SIGINT, SIGTERM};

use super::Key;
use profivac_host::readiness::Local;
use rustix::termios::{LocalModes, OptionalActions, Termios, tcgetattr, tcsetattr};
use std::io;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

/// Standard input, which can be waited for.
pub use std::io::Stdin;

/// Standard input.
pub fn stdin() -> io::Result<Stdin> {
    Ok(io::stdin())
}

/// Reads what standard input has now.
pub fn read(stdin: &Stdin, buffer: &mut [u8]) -> io::Result<usize> {
    Ok(rustix::io::read(stdin, buffer)?)
}

/// Writes an octet to `to` for each signal from now on.
pub fn pass_on(signal: i32, to: Local) -> io::Result<()> {
    signal_hook::low_level::pipe::register(signal, to).map(drop)
}

/// Sets a flag with each signal from now on.
pub fn set_flag(signal: i32, flag: &Arc<AtomicBool>) -> io::Result<()> {
    signal_hook::flag::register(signal, Arc::clone(flag)).map(drop)
}

/// A terminal that does not show what is typed, until this is dropped.
#[derive(Debug)]
pub struct Silence(Termios);

/// Hides what is typed.
pub fn silence() -> io::Result<Silence> {
    let before = tcgetattr(io::stdin())?;
    let mut silent = before.clone();
    silent.local_modes.remove(LocalModes::ECHO);
    tcsetattr(io::stdin(), OptionalActions::Flush, &silent)?;
    Ok(Silence(before))
}

impl Silence {
    /// The meaning of an octet of a line: the terminal edits the line itself.
    pub const fn key(octet: u8) -> Key {
        Key::Octet(octet)
    }
}

impl Drop for Silence {
    fn drop(&mut self) {
        // An error cannot be reported any more.
        tcsetattr(io::stdin(), OptionalActions::Now, &self.0).ok();
    }
}
