//! A lost answer is an error, never the reason for a guess.

#![allow(clippy::unwrap_used, clippy::panic, reason = "a test")]

use crate::changing_port::{Change, ChangingPort};
use profivac_client::class1::Class1Session;
use profivac_client::cyclic::CyclicSlave;
use profivac_client::identify;
use profivac_client::records::{Interruption, RecordError, Records, RefusalCodes, Unavailable};
use profivac_client::{ClientError, ErrorKind};
use profivac_devices::catalog::KnownDevices;
use profivac_devices::catalog::model_named;
use profivac_devices::model::AccessPath;
use profivac_dp::link::Baud;
use profivac_host::port::{Delivery, Port};
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
    let lost = identify::model(KnownDevices::BUILT_IN, ident, 5, &mut Unreadable(|| Interruption::NoAnswer.into()))
        .unwrap_err();
    assert_eq!(lost.kind(), ErrorKind::Line, "{lost}");
    let full = identify::model(KnownDevices::BUILT_IN, ident, 5, &mut Unreadable(|| Unavailable::NoConnection.into()))
        .unwrap_err();
    assert!(matches!(full, ClientError::Unavailable { reason: Unavailable::NoConnection, .. }), "{full}");
}

#[test]
fn a_gauge_that_refuses_its_configuration_is_taken_for_the_first_model_of_its_series() {
    let refused = || RecordError::Refused(RefusalCodes { code_1: None, code: 3 });
    let ident = model_named("psg554").unwrap().ident;
    assert_eq!(identify::model(KnownDevices::BUILT_IN, ident, 5, &mut Unreadable(refused)).unwrap().ident, ident);
}

/// Read of Data Type of a BCG450: slot 1, index 21.
const READ_DATA_TYPE: [u8; 3] = [0x5E, 1, 21];

/// A line on which every read of Data Type becomes a read of the next index while `disturbed` is set: the answer to the read
/// never comes. The check octet fits, so that no timeout has to pass.
fn disturbed_port(port: Box<dyn Port>, disturbed: Arc<AtomicBool>) -> ChangingPort {
    let change: Change = Box::new(move |octets| {
        let mut octets = octets.to_vec();
        let read = octets.windows(READ_DATA_TYPE.len()).position(|part| part == READ_DATA_TYPE);
        if let Some(at) = read.filter(|_| disturbed.load(Ordering::Relaxed)) {
            let check = octets.len() - 2;
            octets[at + 2] += 1;
            octets[check] = octets[check].wrapping_add(1);
        }
        Some(octets)
    });
    ChangingPort { port, change }
}

/// A gauge with the other number type would send pressures that its owner misreads.
#[test]
fn the_number_type_of_a_gauge_is_not_guessed_without_an_answer() {
    const BAUD: Baud = Baud::B1500000;
    let file = SegmentFile::parse("baud = 1500000\ndevices = [\"bcg450@5\"]", Path::new("bench.toml")).unwrap();
    let disturbed = Arc::new(AtomicBool::new(false));
    let port = Box::new(disturbed_port(Box::new(file.run().unwrap()), Arc::clone(&disturbed)));
    let parameters = bus_parameters(0, BAUD, Delivery::Unpaced);
    let mut session = BusSession::new(port, BAUD, parameters, Duration::from_secs(5)).unwrap();
    let slave = CyclicSlave::find(&mut session, 5, 0).unwrap();
    let open = |session: &mut _| Class1Session::open(session, &slave, AccessPath::Class1).map(drop);
    disturbed.store(true, Ordering::Relaxed);
    let unanswered = open(&mut session);
    assert!(matches!(unanswered, Err(RecordError::Interrupted(_))), "{unanswered:?}");
    disturbed.store(false, Ordering::Relaxed);
    assert!(open(&mut session).is_ok());
}
