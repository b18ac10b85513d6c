//! The plant of the pictures agrees with the tables of its devices.

#![allow(clippy::indexing_slicing, reason = "a test")]
#![allow(dead_code, reason = "the example uses more")]

#[path = "../examples/fake_plant/gauges.rs"]
mod gauges;
#[path = "../examples/fake_plant/segments.rs"]
mod segments;

use gauges::Fake;
use profivac_recorder::Quality;
use profivac_station::view::{BusStationState, Reading};

/// Seconds of the week before the start and of the first hour, some of them close to each other.
fn seconds() -> impl Iterator<Item = f64> {
    (-604_800..3_600).step_by(977).map(f64::from)
}

fn check(fake: &Fake, reading: &Reading, second: f64) {
    let model = fake.model();
    let case = format!("{} at {second} s: {reading:?}", reading.series);
    let spec = model.parts.iter().find(|spec| spec.part.instance == reading.instance);
    assert_eq!(spec.map(|spec| spec.part.principle), reading.principle, "{case}");
    let range = spec.map_or(0.0..=f64::INFINITY, |spec| spec.limits.under_pa..=spec.limits.over_pa);
    let ends = spec.map(|spec| (spec.limits.under_pa, spec.limits.over_pa));
    match reading.quality {
        Quality::Valid => assert!(reading.pa.is_some_and(|pa| pa > 0.0 && range.contains(&pa)), "{case}"),
        Quality::Underrange => assert_eq!(reading.limit_pa, ends.map(|(low, _)| low), "{case}"),
        Quality::Overrange => assert_eq!(reading.limit_pa, ends.map(|(_, high)| high), "{case}"),
        Quality::Fault => assert_eq!(fake.state, BusStationState::Fault, "{case}"),
        Quality::Stale | Quality::Assumed => {}
        Quality::Off | Quality::Missing => assert!(!model.features.dpv1, "{case}: only a channel has no gauge"),
    }
}

#[test]
fn every_reading_is_one_that_its_device_can_give() {
    for fake in gauges::all(true) {
        for second in seconds() {
            let gauge = fake.view(second, None);
            gauge.readings.iter().for_each(|reading| check(&fake, reading, second));
        }
        for told in [1e-12, 1e-3, 5e4, 1e7] {
            fake.view(0.0, Some(told)).readings.iter().for_each(|reading| check(&fake, reading, 0.0));
        }
    }
}

#[test]
fn a_controller_has_all_its_channels_and_no_principle_that_it_does_not_report() {
    let all = gauges::all(false);
    for fake in all.iter().filter(|fake| fake.device.starts_with("tpg")) {
        let readings = fake.view(0.0, None).readings;
        assert_eq!(readings.iter().map(|reading| reading.instance).collect::<Vec<_>>(), [1, 2, 3, 4]);
        assert!(readings.iter().all(|reading| reading.principle.is_none()), "i9973ber/a 3.2 names no gauge");
    }
    assert!(all.iter().any(|fake| fake.device == "tpg500"));
}

#[test]
fn a_defect_has_words_that_the_client_gives_it() {
    for fake in gauges::all(false).iter().filter(|fake| !fake.exceptions.is_empty()) {
        let parts = fake.model().parts.iter().map(|spec| spec.part.principle.part_name());
        let words: Vec<_> = parts
            .flat_map(|part| fake.model().alarms.sensor.iter().map(move |bit| format!("{part}: {}", bit.name)))
            .collect();
        assert!(fake.exceptions.iter().all(|it| words.contains(&(*it).to_owned())), "{:?}", fake.exceptions);
    }
}

#[test]
fn the_bus_map_has_the_ident_numbers_of_the_devices() {
    let fakes = gauges::all(false);
    let stations = segments::all(&fakes, 0.0).into_iter().flat_map(|segment| segment.stations);
    let idents: Vec<_> = stations.filter_map(|station| Some((station.device?, station.ident?))).collect();
    for expected in [("bcg450", "0x08E6"), ("tpg500", "0x05D9"), ("pcg550", "0x0C85"), ("bpg400", "0x06A9")] {
        assert!(idents.iter().any(|(device, ident)| (device.as_str(), ident.as_str()) == expected), "{expected:?}");
    }
    assert!(idents.iter().all(|(device, _)| !device.starts_with("img")), "no controller with one reading");
}
