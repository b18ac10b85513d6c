//! The station reads over MS2 which part of a gauge is broken when an alarm begins, and names it in the words of the manual.

#![allow(clippy::unwrap_used, clippy::panic, clippy::indexing_slicing, reason = "a test")]

use crate::support::memory_station::MemoryStation;
use crate::support::until;
use profivac_station::view::{BusStationState, Gauge};
use profivac_virtual::action_text::ActionText;

fn set_fault(station: &MemoryStation, name: &'static str, present: bool) {
    station.outside(move |segment| {
        segment.devices_mut().for_each(|device| device.operate_text(ActionText::Fault { name, present }).unwrap());
    });
}

fn until_exceptions(station: &MemoryStation, wanted: &[&str]) -> Gauge {
    until("the defects are named", || {
        station.services.snapshots().gauge("chamber").filter(|gauge| gauge.exceptions == wanted)
    })
}

#[test]
fn a_broken_filament_is_named_with_its_part_and_forgotten_when_it_is_repaired() {
    let station = MemoryStation::new(1e-6);
    set_fault(&station, "sensor2", true);
    let gauge = until_exceptions(&station, &["ionisation part: electronics or sensor failure"]);
    assert_eq!(gauge.state, BusStationState::Fault);
    set_fault(&station, "sensor2", false);
    let gauge = until_exceptions(&station, &[]);
    assert_eq!(gauge.state, BusStationState::DataExchange);
}

#[test]
fn each_group_of_alarms_is_named() {
    let station = MemoryStation::new(1e-6);
    set_fault(&station, "eeprom", true);
    until_exceptions(&station, &["EEPROM exception"]);
    set_fault(&station, "comm", true);
    until_exceptions(&station, &["EEPROM exception", "internal communication error"]);
}
