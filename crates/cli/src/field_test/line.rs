//! The line of a field test: a port, or an archive in its place. Both are recorded.

use super::replay::Replay;
use super::report::public_notice;
use crate::bus::BusOptions;
use crate::failure::Failure;
use crate::output::notice;
use crate::values::Rate;
use profivac_dp::link::Baud;
use profivac_host::port::{Port, Recorded, Recording};
use profivac_host::rate;
use profivac_virtual::open;

/// Where the octets come from.
enum Source {
    /// A port, which each step opens for itself.
    Port(String),
    /// An archive.
    Archive(Replay),
}

/// The line of a run.
pub struct Line {
    source: Source,
    rate: Rate,
    recording: Recording,
    /// Notices of the port without paths, each once.
    pub notices: Vec<String>,
}

impl Line {
    /// The line at the port of these options. Opens nothing.
    pub fn at_port(bus: &BusOptions) -> Self {
        Self::new(Source::Port(bus.port().to_owned()), bus.rate())
    }

    /// The line of an archive.
    pub fn of_archive(replay: Replay, baud: Baud) -> Self {
        Self::new(Source::Archive(replay), Rate::Known(baud))
    }

    /// The line at the port of these options, with this recording.
    #[cfg(test)]
    pub fn recorded_by(recording: Recording, bus: &BusOptions) -> Self {
        Self { recording, ..Self::at_port(bus) }
    }

    fn new(source: Source, rate: Rate) -> Self {
        Self { source, rate, recording: Recording::begin(), notices: Vec::new() }
    }

    /// The recording.
    pub const fn recording(&self) -> &Recording {
        &self.recording
    }

    /// The next step begins.
    pub fn begin_step(&mut self) {
        match &mut self.source {
            Source::Port(_) => {}
            Source::Archive(replay) => replay.begin_step(),
        }
    }

    /// Opens the line, after the last opening was closed. The first opening detects the rate if it is unknown.
    pub fn open(&mut self) -> Result<(Box<dyn Port>, Baud), Failure> {
        let mut port = match &mut self.source {
            Source::Port(name) => open::port(name, self.rate.initial())?,
            Source::Archive(replay) => replay.open(),
        };
        self.take_notices(&mut *port);
        let mut port: Box<dyn Port> = Box::new(Recorded::new(port, self.recording.clone()));
        let baud = match self.rate {
            Rate::Known(baud) => baud,
            Rate::Auto => {
                let found = rate::detect(&mut *port)?;
                notice(&format_args!("{} runs at {found}", port.name()));
                self.rate = Rate::Known(found);
                found
            }
        };
        Ok((port, baud))
    }

    fn take_notices(&mut self, port: &mut dyn Port) {
        while let Some(message) = port.next_notice() {
            let public = public_notice(&message);
            let is_new = public.as_ref().is_none_or(|public| !self.notices.contains(public));
            if is_new {
                notice(&message);
                self.notices.extend(public);
            }
        }
    }
}
