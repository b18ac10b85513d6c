//! What the tests of alarms look at: one segment with one gauge.

#![allow(dead_code, reason = "each test uses what it needs")]

use profivac_station::alarm::Inputs;
use profivac_station::auth::{Role, User};
use profivac_station::control::Actor;
use profivac_station::services::SegmentSnapshot;
use profivac_station::view::{BusStationState, Gauge, Reading, Segment, SegmentState};
use std::sync::Arc;

/// An engineer at a computer beside.
pub fn actor(name: &str) -> Actor {
    Actor { user: User { name: Arc::from(name), role: Role::Engineer }, peer: Some([10, 0, 0, 7].into()) }
}

/// The gauge `chamber` on the segment `hall` shows this now.
pub fn sight(pa: f64, quality: &'static str) -> Inputs {
    let SegmentSnapshot { segment, gauges } = scenery(pa, quality);
    Inputs { segments: vec![segment], gauges, recorder_error: None }
}

/// It has been silent for a minute.
pub fn silent() -> Inputs {
    let mut sight = sight(1.0, "gap");
    for gauge in &mut sight.gauges {
        gauge.age_ms = Some(60_000);
    }
    sight
}

/// The same as a segment shows it.
pub fn scenery(pa: f64, quality: &'static str) -> SegmentSnapshot {
    let known = ["valid", "overrange", "underrange"].contains(&quality);
    let reading = Reading {
        series: "chamber".to_owned(),
        instance: 1,
        principle: Some("hot-cathode"),
        pa: known.then_some(pa),
        corrected_pa: None,
        quality,
    };
    let gauge = Gauge {
        name: "chamber".to_owned(),
        segment: "hall".to_owned(),
        address: 5,
        device: "bcg450".to_owned(),
        standing: BusStationState::Exchanging,
        trouble: None,
        exceptions: Vec::new(),
        gas: "n2".to_owned(),
        levels: Vec::new(),
        readings: vec![reading],
        age_ms: Some(10),
        poll_ms: 200,
    };
    let segment = Segment {
        name: "hall".to_owned(),
        port: "/dev/ttyUSB0".to_owned(),
        baud: 19200,
        master: 0,
        state: SegmentState::Running,
        trouble: None,
        cycle_ms: None,
        damaged: 0,
        stations: Vec::new(),
    };
    SegmentSnapshot { segment, gauges: vec![gauge] }
}
