//! In every segment a gauge loses power, the line is cut and noise is on the line: the station recovers, and the other gauges and
//! segments are not affected.

#![allow(clippy::unwrap_used, clippy::panic, clippy::indexing_slicing, reason = "a test")]

use crate::support;
use crate::support::tcp_segment::{Fault, TcpSegment, config};
use profivac_recorder::{Micros, Quality};
use profivac_station::services::Services;
use profivac_station::station::Station;
use profivac_station::view::BusStationState;

const DEVICES: [&str; 3] = ["bcg450@5", "psg550@6", "tpg300@7"];

fn until(services: &Services, what: &str, seen: impl Fn(&Services) -> bool) {
    support::until(what, || seen(services).then_some(()));
}

fn is_exchanging(services: &Services, gauge: &str) -> bool {
    services.snapshots().gauge(gauge).is_some_and(|gauge| gauge.state == BusStationState::DataExchange)
}

fn all_exchange(services: &Services, count: usize) -> bool {
    services.snapshots().gauges().iter().filter(|gauge| gauge.state == BusStationState::DataExchange).count() == count
}

#[test]
fn a_segment_recovers_from_each_fault_and_the_others_are_not_affected() {
    let folder = tempfile::tempdir().unwrap();
    let segments: Vec<_> = (0..3).map(|_| TcpSegment::start(&DEVICES)).collect();
    let station = Station::start(config(&segments, &DEVICES, "20 ms", folder.path())).unwrap();
    let services = station.services();
    until(&services, "all gauges", |services| all_exchange(services, 9));
    for (number, segment) in segments.iter().enumerate() {
        let [gauge, neighbour] = [format!("g{number}.5"), format!("g{number}.6")];
        segment.apply(Fault::Power(5, false));
        until(&services, "a gauge without power", |services| {
            services.snapshots().gauge(&gauge).unwrap().state == BusStationState::Missing
        });
        assert!(is_exchanging(&services, &neighbour), "{neighbour}");
        segment.apply(Fault::Power(5, true));
        until(&services, "the gauge has power again", |services| is_exchanging(services, &gauge));
        segment.send_noise(&[0x68, 0xFF, 0x10, 0xDC, 0x01, 0x05, 0xE5, 0x00, 0x16].repeat(40));
        segment.apply(Fault::Cut);
        until(&services, "the line is cut", |services| services.snapshots().segments()[number].problem.is_some());
        let others = (0..3).filter(|other| *other != number);
        assert!(
            others.map(|other| format!("g{other}.6")).all(|other| is_exchanging(&services, &other)),
            "the other segments are not affected"
        );
        segment.apply(Fault::Mend);
        until(&services, "the line is whole again", |services| all_exchange(services, 9));
    }
    station.stop().unwrap();
    let reader = services.recorder().open_reader().unwrap();
    for number in 0..3 {
        let samples = reader.samples(&format!("g{number}.5"), Micros(0), Micros(i64::MAX)).unwrap();
        let gaps = samples.iter().filter(|sample| sample.quality == Quality::Stale).count();
        assert!(gaps >= 3, "the loss of power, the cut line and the end are gaps: {gaps}");
    }
    assert_eq!(services.recorder().health().lost_samples, 0);
}
