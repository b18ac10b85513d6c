//! A lost answer is an error, never the reason for a guess.

#![allow(clippy::unwrap_used, clippy::panic, reason = "a test")]

use profivac_client::class1::Class1Session;
use profivac_client::cyclic::CyclicSlave;
use profivac_client::identify;
use profivac_client::records::{Interruption, RecordError, Records, RefusalCodes, Unavailable};
use profivac_client::{ClientError, ErrorKind};
use profivac_devices::catalog::model_named;
use profivac_devices::model::AccessPath;
use profivac_dp::link::Baud;
use profivac_host::port::{Character, Delivery, Port, PortError};
use profivac_host::readiness::Readiness;
use profivac_host::session::{BusSession, bus_parameters};
use profivac_virtual::segment_file::SegmentFile;
use std::path::Path;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;

/// A gauge whose Device Configuration cannot be read.
struct Unreadable(fn() -> RecordError);

impl Records for Unreadable {
    fn via(&self) -> AccessPath {
        AccessPath::Class2
    }

    fn read(&mut self, _slot: u8, _index: u8) -> Result<Vec<u8>, RecordError> {
        Err(self.0())
    }

    fn write(&mut self, _slot: u8, _index: u8, _octets: &[u8]) -> Result<(), RecordError> {
        panic!("identifying writes nothing")
    }
}

#[test]
fn a_model_of_a_series_is_not_guessed_after_a_lost_answer_or_without_a_connection() {
    let ident = model_named("psg554").unwrap().ident;
    let lost = identify::model(ident, 5, &mut Unreadable(|| Interruption::NoAnswer.into())).unwrap_err();
    assert_eq!(lost.kind(), ErrorKind::Line, "{lost}");
    let full = identify::model(ident, 5, &mut Unreadable(|| Unavailable::NoConnection.into())).unwrap_err();
    assert!(matches!(full, ClientError::Unavailable { reason: Unavailable::NoConnection, .. }), "{full}");
}

#[test]
fn a_gauge_that_refuses_its_configuration_is_taken_for_the_first_model_of_its_series() {
    let refused = || RecordError::Refused(RefusalCodes { code_1: None, code: 3 });
    let ident = model_named("psg554").unwrap().ident;
    assert_eq!(identify::model(ident, 5, &mut Unreadable(refused)).unwrap().ident, ident);
}

/// Read of Data Type of a BCG450: slot 1, index 21.
const READ_DATA_TYPE: [u8; 3] = [0x5E, 1, 21];

/// A line that loses every read of Data Type while `loses` is set.
struct Lossy {
    port: Box<dyn Port>,
    loses: Arc<AtomicBool>,
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
        let is_read = octets.windows(READ_DATA_TYPE.len()).any(|part| part == READ_DATA_TYPE);
        if is_read && self.loses.load(Ordering::Relaxed) { Ok(()) } else { self.port.send(octets) }
    }
}

/// Without its number type a gauge would be configured with one of two, and the other is what its other master expects.
#[test]
fn the_number_type_of_a_gauge_is_not_guessed_after_a_lost_telegram() {
    const BAUD: Baud = Baud::B19200;
    let file = SegmentFile::parse("devices = [\"bcg450@5\"]", Path::new("bench.toml")).unwrap();
    let loses = Arc::new(AtomicBool::new(false));
    let port = Box::new(Lossy { port: Box::new(file.run().unwrap()), loses: Arc::clone(&loses) });
    let parameters = bus_parameters(0, BAUD, Delivery::Unpaced);
    let mut session = BusSession::new(port, BAUD, parameters, Duration::from_secs(5)).unwrap();
    let slave = CyclicSlave::find(&mut session, 5, 0).unwrap();
    let open = |session: &mut _| Class1Session::open(session, &slave, AccessPath::Class1).map(drop);
    loses.store(true, Ordering::Relaxed);
    let lost = open(&mut session);
    assert!(matches!(lost, Err(RecordError::Interrupted(_))), "{lost:?}");
    loses.store(false, Ordering::Relaxed);
    assert!(open(&mut session).is_ok());
}
