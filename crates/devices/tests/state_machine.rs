//! The state diagram of the block devices as a text to compare with the manuals: errata-bpg-bcg-tpg 84 to 89,
//! errata-pxg55x-img400 19 and 77.
#![allow(clippy::unwrap_used, clippy::expect_used, reason = "this is test code")]

use crate::support::golden;
use profivac_devices::profile::{DeviceState, StateEvent, TRANSITIONS};
use std::fmt::Write;

const STATES: [DeviceState; 7] = [
    DeviceState::Init,
    DeviceState::SelfTesting,
    DeviceState::Idle,
    DeviceState::SelfTestException,
    DeviceState::Executing,
    DeviceState::Abort,
    DeviceState::CriticalFault,
];

const EVENTS: [StateEvent; 10] = [
    StateEvent::Reset,
    StateEvent::Abort,
    StateEvent::Recover,
    StateEvent::Execute,
    StateEvent::Stop,
    StateEvent::PerformDiagnostic,
    StateEvent::Initialised,
    StateEvent::Passed,
    StateEvent::Failed,
    StateEvent::Fault,
];

#[test]
fn every_event_has_its_result_in_every_state() {
    let mut text = String::from("from               event              to, or the code of the refusal\n");
    for state in STATES {
        for event in EVENTS {
            let result = match state.next(event) {
                Ok(to) => to.name().to_string(),
                Err(refusal) => refusal.channel_code().to_string(),
            };
            writeln!(text, "{:<18} {:<18} {result}", state.name(), format!("{event:?}")).unwrap();
        }
    }
    text += "\nTransitions by their numbers\n";
    let mut transitions: Vec<_> = TRANSITIONS.iter().collect();
    transitions.sort_by_key(|transition| transition.number);
    for transition in transitions {
        let from: Vec<&str> = transition.from.iter().map(|state| state.name()).collect();
        writeln!(text, "{:>2}  {} -> {}", transition.number, from.join(", "), transition.to.name()).unwrap();
    }
    golden::check("device_states.txt", &text);
}
