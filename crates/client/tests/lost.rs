//! A lost answer is an error, never the reason for a guess.

#![allow(clippy::unwrap_used, clippy::panic, reason = "a test")]

use profivac_client::identify;
use profivac_client::records::{Interruption, RecordError, Records, RefusalCodes, Unavailable};
use profivac_client::{ClientError, ErrorKind};
use profivac_devices::catalog::model_named;
use profivac_devices::model::AccessPath;

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
