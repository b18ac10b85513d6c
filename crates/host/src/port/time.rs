//! The clock of a port: simulated, or the system's.

use super::{Port, PortError};
use crate::clock::{Clock, tbit_of};
use crate::readiness::{Readiness, wait};
use profivac_dp::link::{Baud, BitTime};
use std::time::Duration;

/// Waits until `port` or one of `others` is readable, at most `at_most`. On a port in simulated time this is simulated time. Returns for
/// each of `others` whether it is readable.
///
/// # Errors
/// [`PortError::System`].
pub fn wait_for_port(port: &mut dyn Port, others: &[Readiness<'_>], at_most: Duration) -> Result<Vec<bool>, PortError> {
    if port.simulated_time().is_some() {
        port.simulate(at_most);
        return Ok(vec![false; others.len()]);
    }
    let sources: Vec<_> = others.iter().copied().chain(port.readiness()).collect();
    let mut readable = wait(&sources, at_most).map_err(|error| PortError::system(port.name(), error))?;
    readable.truncate(others.len());
    Ok(readable)
}

/// A clock in bit times that follows the simulated time of a port, or else the system.
#[derive(Clone, Copy, Debug)]
pub struct PortClock {
    clock: Clock,
    baud: Baud,
    first: BitTime,
    /// The simulated time at its start.
    began: Duration,
}

impl PortClock {
    /// A clock that shows `first` now.
    #[must_use]
    pub fn starting_at(first: BitTime, baud: Baud, port: &dyn Port) -> Self {
        let began = port.simulated_time().unwrap_or_default();
        Self { clock: Clock::starting_at(first, baud), baud, first, began }
    }

    /// The time it shows. `port` is the one with which it started.
    #[must_use]
    pub fn now(&self, port: &dyn Port) -> BitTime {
        match port.simulated_time() {
            None => self.clock.now(),
            Some(time) => self.first + tbit_of(self.baud, time.saturating_sub(self.began)),
        }
    }
}
