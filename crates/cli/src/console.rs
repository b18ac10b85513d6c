//! Lines from standard input and signals, as descriptors that a command waits for beside its others.

#[cfg(unix)]
#[path = "console/unix.rs"]
mod system;
#[cfg(windows)]
#[path = "console/windows.rs"]
mod system;

pub use system::{SIGHUP, SIGINT, SIGTERM, Silence, Stdin, read, silence, stdin};

use crate::failure::Failure;
use crate::output::out;
use profivac_host::readiness::{Local, Readiness, pair, wait};
use std::io::{self, Read as _};
use std::ops::ControlFlow;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, LazyLock, OnceLock};
use std::time::Duration;

/// The longest line in octets; a longer one is no command.
const MAX_LINE: usize = 4096;

/// Input of a user or a script.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Input {
    /// A line, without white space at its ends.
    Line(String),
    /// A line of more than [`MAX_LINE`] octets.
    LongLine,
    /// A signal that ends the program.
    Stop,
}

/// The meaning of an octet that a terminal passes on while it shows nothing.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(unix, expect(dead_code, reason = "a terminal of Unix edits the line itself"))]
pub enum Key {
    /// A part of the line.
    Octet(u8),
    /// The line ends.
    End,
    /// The character before is deleted.
    Delete,
    /// The command ends.
    Interrupt,
}

/// See [`Signals::of_command`].
static COMMAND: OnceLock<Signals> = OnceLock::new();

/// Whether a signal that ends the program has arrived and was caught, see [`Signals::have_arrived`].
static ARRIVED: LazyLock<Arc<AtomicBool>> = LazyLock::new(Arc::default);

/// The signals that end a program, as a descriptor that becomes readable.
#[derive(Debug)]
pub struct Signals(Local);

impl Signals {
    /// Catches SIGHUP, SIGINT and SIGTERM from now on.
    pub fn catch() -> io::Result<Self> {
        let all = [SIGHUP, SIGINT, SIGTERM];
        for signal in all {
            system::set_flag(signal, &ARRIVED)?;
        }
        Self::of(&all)
    }

    /// Whether one of the signals that [`catch`](Self::catch) catches has arrived, for a wait without a descriptor. Before the first call
    /// of that a signal ends the program itself.
    pub fn have_arrived() -> bool {
        ARRIVED.load(Ordering::Relaxed)
    }

    /// Catches these signals from now on.
    pub fn of(all: &[i32]) -> io::Result<Self> {
        let (signals, handler) = pair()?;
        signals.set_nonblocking(true)?;
        for signal in all {
            system::pass_on(*signal, handler.try_clone()?)?;
        }
        Ok(Self(signals))
    }

    /// The signals that end a command, caught at the first call: all sessions of a command share them, so that no signal is lost between
    /// two.
    pub fn of_command() -> io::Result<&'static Self> {
        match Self::caught() {
            Some(caught) => Ok(caught),
            None => Self::catch().map(|caught| COMMAND.get_or_init(|| caught)),
        }
    }

    /// The same, if they are caught already.
    pub fn caught() -> Option<&'static Self> {
        COMMAND.get()
    }

    /// Fails if a signal has arrived.
    pub fn check(&self) -> Result<(), Failure> {
        if self.are_pending() { Err(Failure::interrupted()) } else { Ok(()) }
    }

    /// Whether a signal has arrived.
    pub fn are_pending(&self) -> bool {
        wait(&[self.readiness()], Duration::ZERO).is_ok_and(|ready| ready.first() == Some(&true))
    }

    /// Returns true once a signal has arrived: for [`BusSession::set_cancellation`](profivac_host::session::BusSession::set_cancellation).
    pub fn cancellation(&self) -> io::Result<Box<dyn Fn() -> bool + Send>> {
        let signals = Self(self.0.try_clone()?);
        Ok(Box::new(move || signals.are_pending()))
    }

    /// Becomes readable when a signal has arrived.
    pub fn readiness(&self) -> Readiness<'_> {
        Readiness::of(&self.0)
    }

    /// Discards the signals that have arrived.
    pub fn clear(&mut self) {
        ARRIVED.store(false, Ordering::Relaxed);
        let mut buffer = [0; 64];
        while let Ok(1..) = self.0.read(&mut buffer) {}
    }
}

/// Standard input and the signals that end a program.
#[derive(Debug)]
pub struct Console {
    stdin: Stdin,
    /// Whether standard input has not ended.
    open: bool,
    partial_line: PartialLine,
    signals: Signals,
}

impl Console {
    /// Opens standard input and catches signals.
    pub fn open() -> io::Result<Self> {
        Ok(Self { stdin: stdin()?, open: true, partial_line: PartialLine::default(), signals: Signals::catch()? })
    }

    /// The descriptors to wait for.
    pub fn descriptors(&self) -> Vec<Readiness<'_>> {
        let stdin = self.open.then(|| Readiness::of(&self.stdin));
        [Some(self.signals.readiness()), stdin].into_iter().flatten().collect()
    }

    /// The input, when [`descriptors`](Self::descriptors) became `readable`.
    pub fn take_input(&mut self, readable: &[bool]) -> Vec<Input> {
        let mut input = Vec::new();
        if readable.get(1) == Some(&true) {
            self.read(&mut input);
        }
        if readable.first() == Some(&true) {
            input.push(Input::Stop);
        }
        input
    }

    fn read(&mut self, input: &mut Vec<Input>) {
        let mut buffer = [0; MAX_LINE];
        match read(&self.stdin, &mut buffer) {
            Ok(0) => self.open = false,
            Ok(length) => self.partial_line.push(buffer.get(..length).unwrap_or(&buffer), input),
            Err(error) if matches!(error.kind(), io::ErrorKind::Interrupted | io::ErrorKind::WouldBlock) => {}
            Err(_) => self.open = false,
        }
        if !self.open {
            self.partial_line.end(input);
        }
    }
}

impl Input {
    /// The line with the command; breaks at a signal. A line that is too long is answered here, because a part of it could be another command.
    pub fn command(&self) -> ControlFlow<(), Option<&str>> {
        match self {
            Self::Line(line) => ControlFlow::Continue(Some(line)),
            Self::LongLine => {
                out(&format!("error: expected a line of at most {MAX_LINE} octets; nothing was done"));
                ControlFlow::Continue(None)
            }
            Self::Stop => ControlFlow::Break(()),
        }
    }
}

/// The beginning of a line that has not ended.
#[derive(Debug, Default)]
struct PartialLine {
    octets: Vec<u8>,
    /// The line has more octets than these.
    is_too_long: bool,
}

impl PartialLine {
    /// Takes octets, and passes on the lines that have ended.
    fn push(&mut self, octets: &[u8], input: &mut Vec<Input>) {
        for octet in octets {
            match octet {
                b'\n' => self.end_line(input),
                _ if self.octets.len() < MAX_LINE => self.octets.push(*octet),
                _ => self.is_too_long = true,
            }
        }
    }

    fn end_line(&mut self, input: &mut Vec<Input>) {
        let octets = std::mem::take(&mut self.octets);
        input.push(if std::mem::take(&mut self.is_too_long) { Input::LongLine } else { line(&octets) });
    }

    /// Passes on the last line, which may lack a line end.
    fn end(&mut self, input: &mut Vec<Input>) {
        if !self.octets.is_empty() {
            self.end_line(input);
        }
    }
}

fn line(octets: &[u8]) -> Input {
    Input::Line(String::from_utf8_lossy(octets).trim().to_owned())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn complete_lines_are_taken_and_a_partial_line_stays() {
        let (mut partial, mut input) = (PartialLine::default(), Vec::new());
        partial.push(b"state 5\r\n\nqui", &mut input);
        assert_eq!(input, [Input::Line("state 5".to_owned()), Input::Line(String::new())]);
        partial.end(&mut input);
        assert_eq!(input.last(), Some(&Input::Line("qui".to_owned())));
    }

    #[test]
    fn a_line_that_is_too_long_is_one_input_and_no_command() {
        let (mut partial, mut input) = (PartialLine::default(), Vec::new());
        for octets in [&[b'A'; MAX_LINE], &[b'B'; MAX_LINE], &[b'C'; MAX_LINE]] {
            partial.push(octets, &mut input);
            assert_eq!(input, []);
        }
        partial.push(b"power 9 off\nstate 9\n", &mut input);
        assert_eq!(input, [Input::LongLine, Input::Line("state 9".to_owned())]);
        input.clear();
        partial.push(&[b'A'; MAX_LINE], &mut input);
        partial.push(b"\n", &mut input);
        assert_eq!(input, [Input::Line("A".repeat(MAX_LINE))]);
        input.clear();
        partial.push(&[b'A'; MAX_LINE + 1], &mut input);
        partial.end(&mut input);
        assert_eq!(input, [Input::LongLine]);
    }
}
