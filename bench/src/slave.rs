//! Services as a slave sees them, from the first octet of the request to the answer.

use crate::rig::{Mirror, SlaveRig, counted, request};
use profivac_devices::SimulatedDevice;
use profivac_devices::bcg450::Bcg450;
use profivac_devices::profile::Setup;
use profivac_devices::store::RamStore;
use profivac_wire::Sap;
use profivac_wire::control::FrameCount;
use std::hint::black_box;

/// Five octets out, two in.
const CFG: [u8; 2] = [0x24, 0x11];
const OUTPUTS: [u8; 5] = [1, 2, 3, 4, 5];
const OTHER_OUTPUTS: [u8; 5] = [6, 7, 8, 9, 10];

/// Parameter channel, process data with a float.
const BCG450_CFG: [u8; 9] = [0xC6, 0x87, 0x8E, 0x0A, 0x0A, 0x05, 0x05, 0x05, 0x08];
/// mbar, with MS1.
const BCG450_USER: [u8; 5] = [0x80, 0x00, 0x00, 0x05, 0x1C];
/// Read four octets of slot 1, index 19: the process value.
const READ: [u8; 4] = [0x5E, 1, 19, 4];

const ADDRESS: u8 = SlaveRig::<Mirror>::ADDRESS;

fn mirror(may_prepare: bool) -> SlaveRig<Mirror> {
    SlaveRig::exchanging(Mirror { may_prepare, ..Mirror::default() }, &[], &CFG)
}

/// Two requests whose outputs differ.
fn exchanges() -> [Vec<u8>; 2] {
    [(true, OUTPUTS), (false, OTHER_OUTPUTS)]
        .map(|(fcb, outputs)| request(ADDRESS, Sap::Default, FrameCount::Counted(fcb), &outputs))
}

/// Data_Exchange, the request in one piece; the answer is prepared in the idle time, which counts.
pub fn in_one_piece(times: u32) {
    let mut rig = mirror(true);
    for request in exchanges().iter().cycle().take(times as usize) {
        black_box(rig.receive(black_box(request)));
        rig.rest();
    }
}

/// The same, octet by octet.
pub fn octet_by_octet(times: u32) {
    let mut rig = mirror(true);
    for request in exchanges().iter().cycle().take(times as usize) {
        black_box(rig.receive_each(black_box(request)));
        rig.rest();
    }
}

/// Everything but the last octet of the request and what follows from it, up to the answer: all other octets, after which the line is
/// disturbed, so that the next request starts a new telegram, and the work of the idle time.
pub fn all_but_last(times: u32) {
    let mut rig = mirror(true);
    rig.receive(&exchanges()[0]);
    for request in exchanges().iter().cycle().take(times as usize) {
        let [octets @ .., _] = black_box(request.as_slice()) else { continue };
        black_box(rig.receive_each(octets));
        rig.receiver.character_error(rig.now);
        rig.slave.device_mut();
        rig.rest();
    }
}

/// Data_Exchange octet by octet with a device whose answers cannot be prepared.
pub fn unprepared(times: u32) {
    let mut rig = mirror(false);
    for request in exchanges().iter().cycle().take(times as usize) {
        black_box(rig.receive_each(black_box(request)));
    }
}

/// The same without the last octet.
pub fn unprepared_all_but_last(times: u32) {
    let mut rig = mirror(false);
    rig.receive(&exchanges()[0]);
    for request in exchanges().iter().cycle().take(times as usize) {
        let [octets @ .., _] = black_box(request.as_slice()) else { continue };
        black_box(rig.receive_each(octets));
        rig.receiver.character_error(rig.now);
    }
}

fn bcg450() -> SlaveRig<Bcg450<RamStore>> {
    let mut gauge = Bcg450::new(RamStore::default(), Setup::new(ADDRESS));
    gauge.settle();
    SlaveRig::exchanging(gauge, &BCG450_USER, &BCG450_CFG)
}

/// Requests without a task in the parameter channel.
fn rests() -> [Vec<u8>; 2] {
    counted(|count| request(ADDRESS, Sap::Default, count, &[0; 8]))
}

/// Data_Exchange with a BCG450 and an idle parameter channel.
pub fn bcg450_exchange(times: u32) {
    let mut rig = bcg450();
    for request in rests().iter().cycle().take(times as usize) {
        black_box(rig.receive(black_box(request)));
    }
}

/// The request of an MS1 read, and the poll that fetches its response.
fn read_and_poll() -> [Vec<u8>; 2] {
    [(true, &READ[..]), (false, &[])].map(|(fcb, du)| request(ADDRESS, Sap::Ms1, FrameCount::Counted(fcb), du))
}

/// An MS1 read of a BCG450.
pub fn ms1_read(times: u32) {
    let mut rig = bcg450();
    let requests = read_and_poll();
    for _ in 0..times {
        for request in black_box(&requests) {
            black_box(rig.receive(request));
        }
    }
}

/// Slot 1, index 19 through the parameter channel: the instruction, then AK 0 that ends it.
fn channel_read() -> [Vec<u8>; 2] {
    [(true, [0x10, 1, 19, 0, 0, 0, 0, 0]), (false, [0; 8])]
        .map(|(fcb, du)| request(ADDRESS, Sap::Default, FrameCount::Counted(fcb), &du))
}

/// A read through the parameter channel of a BCG450.
pub fn parameter_channel_read(times: u32) {
    let mut rig = bcg450();
    let requests = channel_read();
    for _ in 0..times {
        for request in black_box(&requests) {
            black_box(rig.receive(request));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use profivac_dp::slave::Device;

    #[test]
    fn each_exchange_is_answered_with_two_octets_and_its_outputs_arrive() {
        for may_prepare in [true, false] {
            let mut rig = mirror(may_prepare);
            for (request, outputs) in exchanges().iter().zip([OUTPUTS, OTHER_OUTPUTS]) {
                assert_eq!(request.len(), 14);
                assert_eq!(rig.receive(request), 11);
                assert_eq!(rig.slave.device().outputs[..5], outputs);
                rig.rest();
            }
            for request in exchanges() {
                assert_eq!(rig.receive_each(&request), 11);
                rig.rest();
            }
        }
    }

    #[test]
    fn a_request_without_its_last_octet_is_not_answered() {
        assert_eq!(mirror(true).receive_each(&exchanges()[0][..13]), 0);
    }

    #[test]
    fn the_bcg450_answers_with_fifteen_octets() {
        let mut rig = bcg450();
        assert_eq!(rests().map(|request| rig.receive(&request)), [24, 24]);
    }

    #[test]
    fn the_ms1_read_is_acknowledged_and_its_response_has_four_octets() {
        let mut rig = bcg450();
        assert_eq!(read_and_poll().map(|request| rig.receive(&request)), [1, 19]);
    }

    #[test]
    fn the_parameter_channel_answers_with_a_double_word_and_then_rests() {
        let mut rig = bcg450();
        let mut ak = |octets: &[u8]| {
            assert_eq!(rig.receive(octets), 24);
            let mut inputs = [0; 15];
            rig.slave.device_mut().inputs(&mut inputs);
            inputs[0] >> 4
        };
        assert_eq!(channel_read().map(|request| ak(&request)), [2, 0]);
    }
}
