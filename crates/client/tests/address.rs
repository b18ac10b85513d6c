//! A new address is never one that another station uses.

#![allow(clippy::unwrap_used, clippy::panic, reason = "a test")]

use profivac_client::address::{AddressError, check};
use profivac_dp::link::Baud;
use profivac_host::port::{Character, Delivery, Port, PortError};
use profivac_host::readiness::Readiness;
use profivac_host::session::{BusSession, bus_parameters};
use profivac_virtual::segment_file::SegmentFile;
use std::path::Path;
use std::time::Duration;

const BAUD: Baud = Baud::B19200;

/// SD1 to address 6.
const TO_SIX: [u8; 2] = [0x10, 0x06];

/// A line that loses the first requests to address 6.
struct Lossy {
    port: Box<dyn Port>,
    lost: u8,
}

impl Port for Lossy {
    fn name(&self) -> &str {
        self.port.name()
    }

    fn readiness(&self) -> Vec<Readiness<'_>> {
        self.port.readiness()
    }

    fn receive(&mut self, heard: &mut Vec<Character>) -> Result<(), PortError> {
        self.port.receive(heard)
    }

    fn send(&mut self, octets: &[u8]) -> Result<(), PortError> {
        if self.lost > 0 && octets.starts_with(&TO_SIX) {
            self.lost -= 1;
            return Ok(());
        }
        self.port.send(octets)
    }
}

fn session(lost: u8) -> BusSession {
    let file = SegmentFile::parse("devices = [\"bcg450@126\", \"pcg550@6\"]", Path::new("bench.toml")).unwrap();
    let port = Box::new(Lossy { port: Box::new(file.run().unwrap()), lost });
    BusSession::new(port, BAUD, bus_parameters(0, BAUD, Delivery::Unpaced), Duration::from_secs(5)).unwrap()
}

#[test]
fn a_lost_answer_does_not_make_a_used_address_look_free() {
    for lost in 0..3 {
        let answer = check(&mut session(lost), 126, 6);
        assert!(matches!(answer, Err(AddressError::AddressInUse(6))), "{lost} lost: {answer:?}");
    }
}
