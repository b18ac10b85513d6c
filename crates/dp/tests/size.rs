//! The memory of a station.

use profivac_dp::link::Receiver;
use profivac_dp::slave::Slave;

/// The limit for a slave without its device: a microcontroller of a gauge has about 8 KiB.
#[test]
fn a_slave_and_its_receiver_take_less_than_3_kib() {
    let octets = size_of::<Slave<()>>() + size_of::<Receiver>();
    assert!(octets <= 3 * 1024, "{octets} octets");
}
