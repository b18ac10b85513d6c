//! Snapshots of one segment, hall, with one gauge, chamber.

use profivac_devices::Principle;
use profivac_recorder::Quality;
use profivac_station::alarm::Inputs;
use profivac_station::snapshot::SegmentSnapshot;
use profivac_station::view::{BusStationState, Gauge, GaugeKind, Reading, Segment, SegmentState};
use profivac_web_server::auth::{Actor, Role, User};
use std::sync::Arc;

/// An engineer at a neighbouring computer.
pub fn actor(name: &str) -> Actor {
    Actor { user: User { name: Arc::from(name), role: Role::Engineer }, peer: Some([10, 0, 0, 7].into()) }
}

/// The inputs of the alarms while the gauge shows this reading.
pub fn inputs(pa: f64, quality: Quality) -> Inputs {
    let SegmentSnapshot { segment, gauges } = snapshot(pa, quality);
    let buses = Default::default();
    Inputs { segments: vec![segment], gauges, buses, recorder_error: None, damage: None, archive: None }
}

/// The inputs of the alarms while the gauge has given no data for a minute.
pub fn silent() -> Inputs {
    let mut inputs = inputs(1.0, Quality::Stale);
    for gauge in &mut inputs.gauges {
        gauge.age_ms = Some(60_000);
    }
    inputs
}

/// The snapshot of the segment while the gauge shows this reading.
pub fn snapshot(pa: f64, quality: Quality) -> SegmentSnapshot {
    let reading = Reading {
        series: "chamber".to_owned(),
        instance: 1,
        principle: Some(Principle::HotCathode),
        pa: (quality == Quality::Valid).then_some(pa),
        limit_pa: quality.has_pressure().then_some(pa).filter(|_| quality != Quality::Valid),
        corrected_pa: None,
        quality,
        cause: None,
        is_defect: false,
    };
    SegmentSnapshot { segment: segment(), gauges: vec![gauge(vec![reading])] }
}

/// The segment hall, running.
pub fn segment() -> Segment {
    Segment {
        name: "hall".to_owned(),
        port: "/dev/ttyUSB0".to_owned(),
        baud: 19200,
        master: Some(0),
        listen_only: false,
        state: SegmentState::Running,
        problem: None,
        cycle_ms: None,
        damaged_telegrams: 0,
        stations: Vec::new(),
    }
}

/// The gauge chamber, in data exchange.
pub fn gauge(readings: Vec<Reading>) -> Gauge {
    Gauge {
        name: "chamber".to_owned(),
        kind: GaugeKind::Gauge,
        segment: "hall".to_owned(),
        address: 5,
        device: "bcg450".to_owned(),
        model: profivac_devices::catalog::model_named("bcg450"),
        has_dpv1: true,
        state: BusStationState::DataExchange,
        gas: "n2".to_owned(),
        readings,
        age_ms: Some(10),
        poll_ms: 200,
        stale_after_ms: 3000,
        ..Gauge::default()
    }
}
