//! Gauges lose power, lines are cut, somebody babbles: in every segment, again and again. Nothing is stuck, and what is
//! well stays well.

#![allow(clippy::unwrap_used, clippy::panic, clippy::indexing_slicing, reason = "a test")]

mod hardship;

use hardship::{Bench, Blow};
use profivac_recorder::{Micros, Quality};
use profivac_station::services::Services;
use profivac_station::station::Station;
use profivac_station::view::BusStationState;
use std::time::{Duration, Instant};

const PATIENCE: Duration = Duration::from_secs(90);
const DEVICES: [&str; 3] = ["bcg450@5", "psg550@6", "tpg300@7"];

fn until(plant: &Services, what: &str, mut seen: impl FnMut(&Services) -> bool) {
    let end = Instant::now() + PATIENCE;
    while !seen(plant) {
        assert!(Instant::now() < end, "never seen: {what}: {:#?}", plant.gauges());
        std::thread::yield_now();
    }
}

fn is_well(plant: &Services, gauge: &str) -> bool {
    plant.gauge(gauge).is_some_and(|gauge| gauge.standing == BusStationState::Exchanging)
}

fn all_well(plant: &Services, count: usize) -> bool {
    plant.gauges().iter().filter(|gauge| gauge.standing == BusStationState::Exchanging).count() == count
}

#[test]
fn every_blow_is_survived_and_nobody_else_feels_it() {
    let folder = tempfile::tempdir().unwrap();
    let benches: Vec<_> = (0..3).map(|_| Bench::start(&DEVICES)).collect();
    let station = Station::start(hardship::config(&benches, &DEVICES, "20 ms", folder.path())).unwrap();
    let plant = station.services();
    until(&plant, "all gauges", |plant| all_well(plant, 9));
    for (number, bench) in benches.iter().enumerate() {
        let [gauge, neighbour] = [format!("g{number}.5"), format!("g{number}.6")];
        bench.strike(Blow::Power(5, false));
        until(&plant, "a gauge without power", |plant| {
            plant.gauge(&gauge).unwrap().standing == BusStationState::Missing
        });
        assert!(is_well(&plant, &neighbour), "{neighbour}");
        bench.strike(Blow::Power(5, true));
        until(&plant, "the gauge has power again", |plant| is_well(plant, &gauge));
        bench.babble(&[0x68, 0xFF, 0x10, 0xDC, 0x01, 0x05, 0xE5, 0x00, 0x16].repeat(40));
        bench.strike(Blow::Cut);
        until(&plant, "the line is cut", |plant| plant.segments()[number].trouble.is_some());
        let others = (0..3).filter(|other| *other != number);
        assert!(others.map(|other| format!("g{other}.6")).all(|other| is_well(&plant, &other)), "other segments go on");
        bench.strike(Blow::Mend);
        until(&plant, "the line is whole again", |plant| all_well(plant, 9));
    }
    station.stop();
    let reader = plant.open_reader().unwrap();
    for number in 0..3 {
        let samples = reader.samples(&format!("g{number}.5"), Micros(0), Micros(i64::MAX)).unwrap();
        let gaps = samples.iter().filter(|sample| sample.quality == Quality::Gap).count();
        assert!(gaps >= 3, "power, line and end leave gaps: {gaps}");
    }
    assert_eq!(plant.recorder().health().lost_samples, 0);
}
