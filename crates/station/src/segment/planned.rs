//! The segments of a station's file before they start.

use super::polled_gauge::planned_gauge;
use super::slave::planned_slave;
use crate::config;
use crate::snapshot::SegmentSnapshot;
use crate::view::{Segment, SegmentState};

/// The segments of a file before they start, in its order. The points of gateways have this order.
#[must_use]
pub fn planned_segments(segments: &[config::Segment]) -> Vec<SegmentSnapshot> {
    segments.iter().map(planned_segment).collect()
}

/// A segment of the file before it starts: without data, with the gauges that it will have.
fn planned_segment(config: &config::Segment) -> SegmentSnapshot {
    let config::Segment { name, listen_only, .. } = config;
    let segment = Segment {
        name: name.clone(),
        port: config.port.clone(),
        baud: config.baud.bits_per_second(),
        master: (!listen_only).then_some(config.master),
        listen_only: *listen_only,
        state: SegmentState::Waiting,
        problem: None,
        cycle_ms: None,
        damaged_telegrams: 0,
        stations: Vec::new(),
    };
    let gauges = config.gauges.iter().map(|gauge| planned_gauge(gauge, name, *listen_only));
    let slaves = config.slaves.iter().map(|slave| planned_slave(slave, name));
    SegmentSnapshot { segment, gauges: gauges.chain(slaves).collect() }
}
