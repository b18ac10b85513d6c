//! Lines from standard input and the wish to stop, beside whatever else a command waits for.

use profivac_host::port;
use rustix::fd::{AsFd, BorrowedFd};
use rustix::io::Errno;
use signal_hook::consts::{SIGHUP, SIGINT, SIGTERM};
use std::io;
use std::os::unix::net::UnixStream;
use std::time::Duration;

/// A line longer than this is no command.
const MAX_LINE: usize = 4096;

/// What people and scripts say.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Input {
    /// A line.
    Line(String),
    /// A signal.
    Stop,
}

/// The signals that end a program. They are no longer deadly, but make a descriptor readable.
#[derive(Debug)]
pub struct Signals(UnixStream);

impl Signals {
    /// Catches SIGHUP, SIGINT and SIGTERM from here on.
    pub fn catch() -> io::Result<Self> {
        Self::of(&[SIGHUP, SIGINT, SIGTERM])
    }

    /// Catches these signals from here on.
    pub fn of(all: &[i32]) -> io::Result<Self> {
        let (signals, handler) = UnixStream::pair()?;
        signals.set_nonblocking(true)?;
        for signal in all {
            signal_hook::low_level::pipe::register(*signal, handler.try_clone()?)?;
        }
        Ok(Self(signals))
    }

    /// Whether one has come.
    pub fn are_pending(&self) -> bool {
        port::wait(&[self.as_fd()], Duration::ZERO).is_ok_and(|ready| ready.first() == Some(&true))
    }

    /// Forgets signals that came: what follows are new ones.
    pub fn clear(&mut self) {
        let mut buffer = [0; 64];
        while let Ok(1..) = rustix::io::read(&self.0, &mut buffer) {}
    }
}

impl AsFd for Signals {
    fn as_fd(&self) -> BorrowedFd<'_> {
        self.0.as_fd()
    }
}

/// Standard input and the signals that end a program.
#[derive(Debug)]
pub struct Console {
    stdin: io::Stdin,
    /// End of file has not come.
    open: bool,
    partial_line: Vec<u8>,
    signals: Signals,
}

impl Console {
    /// Listens to both.
    pub fn open() -> io::Result<Self> {
        Ok(Self { stdin: io::stdin(), open: true, partial_line: Vec::new(), signals: Signals::catch()? })
    }

    /// What to wait for.
    pub fn descriptors(&self) -> Vec<BorrowedFd<'_>> {
        let stdin = self.open.then(|| self.stdin.as_fd());
        [Some(self.signals.as_fd()), stdin].into_iter().flatten().collect()
    }

    /// What was said, if what is [`watched`](Self::watched) became `readable`.
    pub fn take_input(&mut self, readable: &[bool]) -> Vec<Input> {
        let mut said = Vec::new();
        if readable.get(1) == Some(&true) {
            self.read(&mut said);
        }
        if readable.first() == Some(&true) {
            said.push(Input::Stop);
        }
        said
    }

    fn read(&mut self, said: &mut Vec<Input>) {
        let mut buffer = [0; MAX_LINE];
        match rustix::io::read(&self.stdin, &mut buffer) {
            Ok(0) => self.open = false,
            Ok(length) => self.partial_line.extend(buffer.iter().take(length)),
            Err(Errno::INTR | Errno::AGAIN) => {}
            Err(_) => self.open = false,
        }
        lines(&mut self.partial_line, said);
        // The last line may end with the file.
        if (!self.open && !self.partial_line.is_empty()) || self.partial_line.len() > MAX_LINE {
            said.push(line(&std::mem::take(&mut self.partial_line)));
        }
    }
}

/// Takes the complete lines out of what has been read.
fn lines(begun: &mut Vec<u8>, said: &mut Vec<Input>) {
    while let Some(end) = begun.iter().position(|octet| *octet == b'\n') {
        let complete: Vec<u8> = begun.drain(..=end).collect();
        said.push(line(&complete));
    }
}

fn line(octets: &[u8]) -> Input {
    Input::Line(String::from_utf8_lossy(octets).trim().to_owned())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lines_are_taken_as_they_become_complete() {
        let mut begun = b"state 5\r\n\nqui".to_vec();
        let mut said = Vec::new();
        lines(&mut begun, &mut said);
        assert_eq!(said, [Input::Line("state 5".to_owned()), Input::Line(String::new())]);
        assert_eq!(begun, b"qui");
    }
}
