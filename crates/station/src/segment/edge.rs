//! What a segment has from outside: the time, ports, and the wait for a command. Everything else of a segment takes the time as an
//! argument, so that tests run it in virtual time.

use super::moment::Moment;
use crate::config;
use profivac_dp::link::Baud;
use profivac_host::port::{Port, PortError, open_to_listen};
use profivac_recorder::Micros;
use profivac_virtual::open;
use std::sync::mpsc::{Receiver, RecvTimeoutError};
use std::time::{Duration, Instant};

/// A command to a segment.
pub enum SegmentCommand {
    /// These are the gauges from now on.
    Gauges(Vec<config::Gauge>),
    /// Release the slaves and stop.
    Stop,
}

/// What a segment has from outside.
pub trait Edge: Send + Sync {
    /// The present moment.
    fn now(&self) -> Moment;

    /// Opens the port of this name for a master.
    ///
    /// # Errors
    /// A [`PortError`] that names the port and says what to do.
    fn open(&self, name: &str, baud: Baud) -> Result<Box<dyn Port>, PortError>;

    /// Opens the port of this name to receive only.
    ///
    /// # Errors
    /// A [`PortError`] that names the port and says what to do.
    fn open_to_listen(&self, name: &str, baud: Baud) -> Result<Box<dyn Port>, PortError>;

    /// Waits for a command, at most `at_most`.
    ///
    /// # Errors
    /// When there is none in this time, or the station has dropped the segment.
    fn command(
        &self,
        commands: &Receiver<SegmentCommand>,
        at_most: Duration,
    ) -> Result<SegmentCommand, RecvTimeoutError>;
}

/// The clocks and the ports of the system.
pub struct System;

impl Edge for System {
    fn now(&self) -> Moment {
        Moment { at: Instant::now(), wall: Micros::now() }
    }

    fn open(&self, name: &str, baud: Baud) -> Result<Box<dyn Port>, PortError> {
        open::port(name, baud)
    }

    /// A segment in memory has no device that could be opened for reading alone.
    fn open_to_listen(&self, name: &str, baud: Baud) -> Result<Box<dyn Port>, PortError> {
        if name.starts_with("sim:") { open::port(name, baud) } else { open_to_listen(name, baud) }
    }

    fn command(
        &self,
        commands: &Receiver<SegmentCommand>,
        at_most: Duration,
    ) -> Result<SegmentCommand, RecvTimeoutError> {
        commands.recv_timeout(at_most)
    }
}
