//! A port that changes what it sends.

use profivac_dp::link::Baud;
use profivac_host::port::{Character, Delivery, Notice, Port, PortError};
use profivac_host::readiness::Readiness;

/// Returns the octets that are sent in place of a telegram; `None` loses it.
pub type Change = Box<dyn FnMut(&[u8]) -> Option<Vec<u8>> + Send>;

/// A port whose telegrams pass through a function.
pub struct ChangingPort {
    pub port: Box<dyn Port>,
    pub change: Change,
}

impl Port for ChangingPort {
    fn name(&self) -> &str {
        self.port.name()
    }

    fn delivery(&self) -> Delivery {
        self.port.delivery()
    }

    fn readiness(&self) -> Vec<Readiness<'_>> {
        self.port.readiness()
    }

    fn receive(&mut self, characters: &mut Vec<Character>) -> Result<(), PortError> {
        self.port.receive(characters)
    }

    fn send(&mut self, octets: &[u8]) -> Result<(), PortError> {
        match (self.change)(octets) {
            Some(octets) => self.port.send(&octets),
            None => Ok(()),
        }
    }

    fn set_baud(&mut self, baud: Baud) -> Result<(), PortError> {
        self.port.set_baud(baud)
    }

    fn next_notice(&mut self) -> Option<Notice> {
        self.port.next_notice()
    }

    fn generation(&self) -> u32 {
        self.port.generation()
    }
}
