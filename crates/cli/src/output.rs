//! Data on standard output, remarks on standard error.
//!
//! Whoever reads them may stop reading, and a disk may be full. Nothing panics over it; what could not be written is
//! remembered, and [`check`] turns it into the end of the command: at the latest when it is done, because a command whose
//! output is lost has not done what it was asked for.

use crate::failure::Failure;
use profivac_host::port::Notice;
use std::fmt::Display;
use std::io::{self, ErrorKind, IsTerminal, Write};
use std::sync::OnceLock;

/// What kept output from being written, first.
static WRITE_ERROR: OnceLock<ErrorKind> = OnceLock::new();

/// Writes lines.
pub fn out(lines: &str) {
    let mut out = io::stdout().lock();
    keep_error(writeln!(out, "{lines}").and_then(|()| out.flush()));
}

/// What could not be written is lost.
fn keep_error(written: io::Result<()>) {
    if let Err(error) = written {
        WRITE_ERROR.get_or_init(|| error.kind());
    }
}

/// Whether all output was written: for a command that goes on for long, so that it ends when nobody reads it any more.
pub fn check() -> Result<(), Failure> {
    match WRITE_ERROR.get() {
        None => Ok(()),
        // Whoever closed the pipe knows: as quiet as a program that the system ends for it.
        Some(ErrorKind::BrokenPipe) => Err(Failure::quiet()),
        Some(kind) => Err(Failure::no_answer(format!("standard output cannot be written: {kind}"))),
    }
}

/// What the command line library has to say: help to standard output, complaints to standard error.
pub fn print_usage(said: &clap::Error) -> Result<(), Failure> {
    let printed = said.print();
    if said.use_stderr() {
        return Err(Failure::quiet_usage());
    }
    keep_error(printed.and_then(|()| io::stdout().flush()));
    check()
}

/// Something as JSON.
pub fn json(value: &impl serde::Serialize) -> String {
    // Texts, numbers and lists always have a JSON form.
    serde_json::to_string_pretty(value).unwrap_or_default()
}

/// Says what somebody should know although the command goes on. Nobody has to listen.
pub fn notice(said: &impl Display) {
    writeln!(io::stderr().lock(), "profivac: {said}").ok();
}

/// Says all that there is to remark.
pub fn notices(mut next: impl FnMut() -> Option<Notice>) {
    while let Some(said) = next() {
        notice(&said);
    }
}

/// How far something is that takes long on a slow line: one line on a terminal that is gone afterwards, otherwise nothing.
pub struct Progress<W: Write> {
    to: Option<W>,
    label: &'static str,
    shown: bool,
}

impl Progress<io::Stderr> {
    /// Counts these, where people look at standard error.
    pub fn of(what: &'static str) -> Self {
        Self { to: io::stderr().is_terminal().then(io::stderr), label: what, shown: false }
    }
}

impl<W: Write> Progress<W> {
    /// So many of all are done.
    pub fn update(&mut self, done: usize, all: usize) {
        if let Some(to) = &mut self.to {
            write!(to, "\rprofivac: {done} of {all} {}", self.label).and_then(|()| to.flush()).ok();
            self.shown = true;
        }
    }
}

impl<W: Write> Drop for Progress<W> {
    /// What comes next begins on an empty line.
    fn drop(&mut self) {
        if let Some(to) = self.to.as_mut().filter(|_| self.shown) {
            write!(to, "\r\x1b[K").and_then(|()| to.flush()).ok();
        }
    }
}

#[cfg(test)]
#[allow(clippy::unwrap_used, reason = "a test")]
mod tests {
    use super::*;

    #[test]
    fn progress_is_one_line_that_is_gone_at_the_end() {
        let mut terminal = Vec::new();
        let mut progress = Progress { to: Some(&mut terminal), label: "parameters", shown: false };
        progress.update(9, 10);
        progress.update(10, 10);
        drop(progress);
        let text = String::from_utf8(terminal).unwrap();
        assert_eq!(text, "\rprofivac: 9 of 10 parameters\rprofivac: 10 of 10 parameters\r\x1b[K");
    }

    #[test]
    fn what_never_began_leaves_no_mark() {
        let mut terminal = Vec::new();
        drop(Progress { to: Some(&mut terminal), label: "parameters", shown: false });
        assert!(terminal.is_empty());
    }
}
