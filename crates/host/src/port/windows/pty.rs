//! Replaces `pty.rs` on Windows, which has no ptys.

use super::{Character, Port, PortError};
use crate::readiness::Readiness;
use profivac_dp::link::Baud;
use std::convert::Infallible;
use std::path::Path;

/// A pty: none exists on Windows.
#[derive(Debug)]
pub struct Pty(Infallible);

impl Pty {
    /// Always fails.
    ///
    /// # Errors
    /// [`PortError::NoPtys`].
    pub fn create(path: &Path) -> Result<Self, PortError> {
        Err(PortError::NoPtys(path.display().to_string()))
    }

    /// The line has this rate.
    #[must_use]
    pub const fn with_rate(self, _baud: Option<Baud>) -> Self {
        match self.0 {}
    }
}

impl Port for Pty {
    fn name(&self) -> &str {
        match self.0 {}
    }

    fn readiness(&self) -> Vec<Readiness<'_>> {
        match self.0 {}
    }

    fn receive(&mut self, _characters: &mut Vec<Character>) -> Result<(), PortError> {
        match self.0 {}
    }

    fn send(&mut self, _octets: &[u8]) -> Result<(), PortError> {
        match self.0 {}
    }
}
