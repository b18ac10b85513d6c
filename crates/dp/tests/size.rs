//! The memory of a station.

use profivac_dp::link::Receiver;
use profivac_dp::slave::Slave;

/// Without the device; a microcontroller has 8 KiB for a gauge.
#[test]
fn a_slave_and_its_receiver_take_less_than_3_kib() {
    let octets = size_of::<Slave<()>>() + size_of::<Receiver>();
    assert!(octets <= 3 * 1024, "{octets} octets");
}
