//! Segments with their stations, and their events.

use super::gauges::Fake;
use profivac_recorder::EventKind;
use profivac_station::view::{BusStation, BusStationState, Segment, SegmentState};

/// Seconds, gauge, kind, sentence.
pub const EVENTS: [(f64, Option<&str>, EventKind, &str); 9] = [
    (-90_000.0, None, EventKind::Station, "the file was read again"),
    (-26_000.0, Some("chamber"), EventKind::Command, "chamber: degas was begun by the profivac command"),
    (-25_820.0, Some("chamber"), EventKind::Gauge, "chamber: degas has ended"),
    (-3_000.0, Some("gate 1"), EventKind::Bus, "gate 1: it does not answer"),
    (-2_100.0, Some("gate 1"), EventKind::Bus, "gate 1: it exchanges data"),
    (-1_400.0, Some("cryostat"), EventKind::Gauge, "cryostat: ionisation part: electronics or sensor failure"),
    (-600.0, Some("vessel"), EventKind::Note, "valve to the pump closed"),
    (-540.0, Some("gate 1"), EventKind::Bus, "gate 1: it does not answer"),
    (-300.0, None, EventKind::Bus, "segment bench: /dev/ttyUSB2: the port is lost"),
];

/// All segments.
pub fn all(fakes: &[Fake], second: f64) -> Vec<Segment> {
    let wobble = (second / 3.0).sin();
    let hall = segment("hall", "/dev/ttyUSB0", 93_750, Some(38.4 + 0.6 * wobble), 3);
    let beam = segment("beam line", "/dev/ttyUSB1", 500_000, Some(9.7 + 0.1 * wobble), 0);
    let bench = Segment {
        state: SegmentState::Waiting,
        problem: Some("/dev/ttyUSB2: the port is lost".to_owned()),
        ..segment("bench", "/dev/ttyUSB2", 19_200, None, 0)
    };
    let mut all = vec![hall, beam, bench];
    for fake in fakes {
        if all.iter().all(|segment| segment.name != fake.segment) {
            all.push(segment(fake.segment, "/dev/ttyUSB3", 1_500_000, Some(12.5 + 0.1 * wobble), 0));
        }
    }
    for segment in &mut all {
        let ours = fakes.iter().filter(|fake| fake.segment == segment.name).map(on_bus);
        segment.stations.extend(ours);
    }
    if let Some(hall) = all.first_mut() {
        hall.stations.push(other(2, BusStationState::OtherMaster, "another master in the ring"));
        hall.stations.push(other(60, BusStationState::Unconfigured, "a slave that is not in the station's file"));
    }
    all
}

fn segment(name: &str, port: &str, baud: u32, cycle_ms: Option<f64>, damaged: u32) -> Segment {
    Segment {
        name: name.to_owned(),
        port: port.to_owned(),
        baud,
        master: Some(1),
        listen_only: false,
        state: SegmentState::Running,
        problem: None,
        cycle_ms,
        damaged_telegrams: damaged,
        stations: vec![other(1, BusStationState::OwnMaster, "our master")],
    }
}

fn other(address: u8, state: BusStationState, words: &str) -> BusStation {
    BusStation { address, state, name: None, device: None, ident: None, description: words.to_owned() }
}

fn on_bus(fake: &Fake) -> BusStation {
    let words = match (fake.problem, fake.state) {
        (Some(problem), _) => problem.to_owned(),
        (None, BusStationState::DataExchange) => "in data exchange".to_owned(),
        (None, BusStationState::Fault) => fake.exceptions.join(", "),
        (None, _) => "is being brought into data exchange".to_owned(),
    };
    BusStation {
        address: fake.address,
        state: fake.state,
        name: Some(fake.name.to_owned()),
        device: Some(fake.device.to_owned()),
        ident: Some(format!("0x{:04X}", fake.model().ident)),
        description: words,
    }
}
