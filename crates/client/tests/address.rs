//! A new address is never one that another station uses.

#![allow(clippy::unwrap_used, clippy::panic, reason = "a test")]

use crate::changing_port::{Change, ChangingPort};
use profivac_client::address::{AddressError, check};
use profivac_dp::link::Baud;
use profivac_host::port::Delivery;
use profivac_host::session::{BusSession, bus_parameters};
use profivac_virtual::segment_file::SegmentFile;
use std::path::Path;
use std::time::Duration;

const BAUD: Baud = Baud::B19200;

/// SD1 to address 6.
const TO_SIX: [u8; 2] = [0x10, 0x06];

/// A session on a line that loses the first requests to address 6.
fn session(mut lost: u8) -> BusSession {
    let file = SegmentFile::parse("devices = [\"bcg450@126\", \"pcg550@6\"]", Path::new("bench.toml")).unwrap();
    let change: Change = Box::new(move |octets| {
        let is_lost = lost > 0 && octets.starts_with(&TO_SIX);
        lost -= u8::from(is_lost);
        (!is_lost).then(|| octets.to_vec())
    });
    let port = Box::new(ChangingPort { port: Box::new(file.run().unwrap()), change });
    BusSession::new(port, BAUD, bus_parameters(0, BAUD, Delivery::Unpaced), Duration::from_secs(5)).unwrap()
}

#[test]
fn a_lost_answer_does_not_make_a_used_address_look_free() {
    for lost in 0..3 {
        let answer = check(&mut session(lost), 126, 6);
        assert!(matches!(answer, Err(AddressError::AddressInUse(6))), "{lost} lost: {answer:?}");
    }
}
