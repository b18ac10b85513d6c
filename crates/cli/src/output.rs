//! Data on standard output, notices on standard error.
//!
//! A reader may close the pipe, and a disk may be full. Neither panics: the first write error is kept, and [`check`] returns it
//! as a failure, at the latest when the command is done, because a command whose output is lost has failed.

use crate::failure::Failure;
use profivac_host::port::Notice;
use std::fmt::Display;
use std::io::{self, ErrorKind, IsTerminal, Write};
use std::sync::OnceLock;

/// The first error that prevented output from being written.
static WRITE_ERROR: OnceLock<ErrorKind> = OnceLock::new();

/// Writes lines to standard output.
pub fn out(lines: &str) {
    let mut out = io::stdout().lock();
    keep_error(writeln!(out, "{lines}").and_then(|()| out.flush()));
}

/// A line without control characters, which a file can contain and a terminal would obey.
pub fn visible(line: &str) -> String {
    let mut visible = String::with_capacity(line.len());
    for one in line.chars() {
        if one.is_control() {
            visible.extend(one.escape_default());
        } else {
            visible.push(one);
        }
    }
    visible
}

/// JSON in one line without control characters. Those of ASCII are escaped already, and a text of a GSD file can have others.
pub fn visible_json(json: &str) -> String {
    let mut visible = String::with_capacity(json.len());
    for one in json.chars() {
        if one.is_control() {
            visible.push_str(&format!("\\u{:04x}", u32::from(one)));
        } else {
            visible.push(one);
        }
    }
    visible
}

/// Keeps the first write error for [`check`].
fn keep_error(written: io::Result<()>) {
    if let Err(error) = written {
        WRITE_ERROR.get_or_init(|| error.kind());
    }
}

/// Fails if output could not be written. A command that runs for long calls it, so that it ends when its reader has gone.
pub fn check() -> Result<(), Failure> {
    match WRITE_ERROR.get() {
        None => Ok(()),
        // The reader has closed the pipe and needs no message.
        Some(ErrorKind::BrokenPipe) => Err(Failure::quiet()),
        Some(kind) => Err(Failure::no_answer(format!("standard output cannot be written: {kind}"))),
    }
}

/// Prints what the command line parser returns: help to standard output, errors to standard error.
pub fn print_usage(message: &clap::Error) -> Result<(), Failure> {
    let printed = message.print();
    if message.use_stderr() {
        return Err(Failure::quiet_usage());
    }
    keep_error(printed.and_then(|()| io::stdout().flush()));
    check()
}

/// A value as indented JSON.
pub fn json(value: &impl serde::Serialize) -> String {
    // Strings, numbers and lists always have a JSON form.
    serde_json::to_string_pretty(value).unwrap_or_default()
}

/// Prints a notice on standard error, which may have several lines. A failure to do so is ignored.
pub fn notice(message: &impl Display) {
    writeln!(io::stderr().lock(), "profivac: {}", visible_lines(&message.to_string())).ok();
}

fn visible_lines(text: &str) -> String {
    text.split('\n').map(visible).collect::<Vec<_>>().join("\n")
}

/// Prints all pending notices of a port.
pub fn notices(mut next: impl FnMut() -> Option<Notice>) {
    while let Some(message) = next() {
        notice(&message);
    }
}

/// The progress of a long operation: one line on a terminal, cleared at the end; nothing if standard error is no terminal.
pub struct Progress<W: Write> {
    to: Option<W>,
    label: &'static str,
    shown: bool,
}

impl Progress<io::Stderr> {
    /// Shows progress on standard error if that is a terminal; `label` is what is counted, in the plural.
    pub fn of(what: &'static str) -> Self {
        Self { to: io::stderr().is_terminal().then(io::stderr), label: what, shown: false }
    }
}

impl<W: Write> Progress<W> {
    /// Shows that `done` of `all` are done.
    pub fn update(&mut self, done: usize, all: usize) {
        if let Some(to) = &mut self.to {
            write!(to, "\rprofivac: {done} of {all} {}", self.label).and_then(|()| to.flush()).ok();
            self.shown = true;
        }
    }
}

impl<W: Write> Drop for Progress<W> {
    /// Clears the line.
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
    fn progress_is_one_line_that_is_cleared_at_the_end() {
        let mut terminal = Vec::new();
        let mut progress = Progress { to: Some(&mut terminal), label: "parameters", shown: false };
        progress.update(9, 10);
        progress.update(10, 10);
        drop(progress);
        let text = String::from_utf8(terminal).unwrap();
        assert_eq!(text, "\rprofivac: 9 of 10 parameters\rprofivac: 10 of 10 parameters\r\x1b[K");
    }

    #[test]
    fn control_characters_are_shown_and_lines_stay() {
        assert_eq!(visible("a\u{1b}[2Jb\u{9b}c\n"), "a\\u{1b}[2Jb\\u{9b}c\\n");
        assert_eq!(visible_lines("a\u{7}\nb"), "a\\u{7}\nb");
        let json = serde_json::to_string("\u{1b}\u{9b}\u{7f} ä").unwrap();
        assert_eq!(visible_json(&json), "\"\\u001b\\u009b\\u007f ä\"");
        assert_eq!(serde_json::from_str::<String>(&visible_json(&json)).unwrap(), "\u{1b}\u{9b}\u{7f} ä");
    }

    #[test]
    fn progress_without_a_step_writes_nothing() {
        let mut terminal = Vec::new();
        drop(Progress { to: Some(&mut terminal), label: "parameters", shown: false });
        assert!(terminal.is_empty());
    }
}
