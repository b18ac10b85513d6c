//! A second slave, written from `docs/spec` alone, beside the real one: the same random services, the same answers.
//!
//! The model ([`model`], [`acyclic`]) is plain and uses neither the code of `dp` nor of `wire`. Services of two class 1
//! masters and two class 2 masters come in any order and at any time. Each answer is compared octet by octet, and with it
//! the state, the address, min T_SDR and the watchdog. A difference is reduced to the shortest list of steps that shows it.
//!
//! `PROFIVAC_FUZZ=N` makes the runs N times as long. `PROFIVAC_SEED=N` runs one more seed.
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic, reason = "this is test code")]

mod acyclic;
mod coverage;
mod gauge;
mod line;
mod model;
mod open_points;
mod page;
mod process;
mod services;
mod shrink;
mod simple;
mod tables;
mod telegram;

use gauge::{Gauge, Peek};
use line::{Driven, Line, Step};
use model::Model;
use page::Page;
use process::{Process, Simple};
use profivac_devices::SimulatedDevice;
use profivac_devices::bcg450::Bcg450;
use profivac_devices::img400::{Gauges, Img400};
use profivac_devices::profile::{Behaviour, Setup};
use profivac_devices::pxg55x::{Pxg55x, Pxg55xModel};
use profivac_devices::store::RamStore;
use profivac_devices::tpg::table::TPG300;
use profivac_devices::tpg::{Tpg, TpgGauge};
use profivac_dp::link::Baud;
use profivac_dp::slave::{Device, Slave};
use services::Services;
use simple::SimpleDevice;
use std::collections::BTreeMap;
use std::hash::{BuildHasher, Hasher, RandomState};
use tables::Table;

const ADDRESS: u8 = 5;
/// Steps of a conversation, which begins at power-up.
const STEPS: usize = 1500;

/// How often something was reached.
type Reached = BTreeMap<&'static str, u64>;

/// The environment variable as a number.
fn number(name: &str) -> Option<u64> {
    std::env::var(name).ok().map(|it| it.parse().unwrap_or_else(|_| panic!("{name} must be a number, found {it}")))
}

/// Fixed seeds, one that differs each time, and one of the caller.
fn seeds(count: u64) -> Vec<u64> {
    let factor = number("PROFIVAC_FUZZ").unwrap_or(1);
    let mut seeds: Vec<u64> = (0..count * factor).collect();
    seeds.push(RandomState::new().build_hasher().finish());
    seeds.extend(number("PROFIVAC_SEED"));
    seeds
}

/// Runs conversations with pairs of slave and model and returns what was reached.
fn converse<D: Driven>(name: &str, count: u64, application: bool, pair: impl Fn() -> Line<D>) -> Reached {
    let mut reached = Reached::new();
    let seeds = seeds(count);
    println!(
        "{name}: {} conversations of {STEPS} steps; seeds 0 to {} and {}",
        seeds.len(),
        seeds.len() - 2,
        seeds[seeds.len() - 1]
    );
    for seed in seeds {
        let mut line = pair();
        let mut services = Services::new(seed, application);
        let mut steps: Vec<Step> = Vec::new();
        for _ in 0..STEPS {
            let step = services.next(&line.model, line.now);
            steps.push(step);
            if line.step(&steps[steps.len() - 1]).difference.is_some() {
                shrink::report(name, seed, steps, &pair);
            }
        }
        for (what, count) in line.model.reached.into_iter().chain(line.model.process.reached()) {
            *reached.entry(what).or_default() += count;
        }
    }
    for (what, count) in &reached {
        println!("{count:>9} {what}");
    }
    reached
}

/// Everything of the list was reached often enough.
fn assert_reached(reached: &Reached, wanted: &[&str]) {
    let seldom = |what: &&&str| reached.get(**what).is_none_or(|count| *count < coverage::LEAST);
    let seldom: Vec<_> = wanted.iter().filter(seldom).collect();
    assert!(seldom.is_empty(), "reached fewer than {} times: {seldom:?}", coverage::LEAST);
}

fn simple() -> Line<SimpleDevice> {
    let table = Table::simple();
    let slave = Slave::new(SimpleDevice::new(table.clone()), ADDRESS, Baud::B1500000);
    Line::new(slave, Model::new(table, Simple::new(), ADDRESS))
}

#[test]
fn the_slave_with_a_simple_device_answers_as_the_model() {
    let reached = converse("simple", 200, true, simple);
    assert_reached(&reached, coverage::SIMPLE);
    println!("open points that the model answers as the slave does:");
    for (number, section, behaviour) in open_points::OPEN {
        println!("{number:>3} {section:<20} {behaviour}");
    }
}

/// A gauge and the model with its page.
fn gauge<B: Behaviour + Clone>(device: &Gauge<B>, page: &Page) -> Line<Gauge<B>> {
    let mut page = page.clone();
    page.table.im0 = device.im0();
    let address = device.station_address();
    let process = Peek::new(page.clone(), device.clone());
    let slave = Slave::new(device.clone(), address, Baud::B1500000);
    Line::new(slave, Model::new(page.table, process, address))
}

/// Runs conversations with a gauge.
fn converse_with<B: Behaviour + Clone>(mut device: Gauge<B>, text: &str) {
    device.settle();
    let page = Page::of(text, device.name(), device.station_address() == 126);
    let name = page.table.name.clone();
    let reached = converse(&name, 40, false, || gauge(&device, &page));
    assert_reached(&reached, coverage::ALL);
    if page.table.ms1 && page.table.ms2 {
        assert_reached(&reached, coverage::DPV1);
    }
    if page.has_selector() {
        assert_reached(&reached, coverage::SELECTOR);
    }
}

/// The stored address holds, and Set_Slave_Add changes it.
fn stored() -> Setup {
    Setup::new(126)
}

/// The address switch holds.
fn switched() -> Setup {
    Setup::new(ADDRESS)
}

#[test]
fn a_bcg450_answers_as_the_model() {
    converse_with(Bcg450::new(RamStore::default(), stored()), include_str!("../../../../docs/devices/bcg450.md"));
}

#[test]
fn a_pcg550_answers_as_the_model() {
    let model = Pxg55xModel::named("pcg550", Some(false)).expect("a model");
    converse_with(
        Pxg55x::new(RamStore::default(), model, stored()),
        include_str!("../../../../docs/devices/pcg55x.md"),
    );
}

#[test]
fn a_psg550_answers_as_the_model() {
    let model = Pxg55xModel::named("psg550", None).expect("a model");
    converse_with(
        Pxg55x::new(RamStore::default(), model, switched()),
        include_str!("../../../../docs/devices/psg55x.md"),
    );
}

#[test]
fn a_tpg300_answers_as_the_model() {
    let gauges = [Some(TpgGauge::Pirani), Some(TpgGauge::ColdCathode), None, None];
    let device = Tpg::new(&TPG300, RamStore::default(), switched(), gauges);
    converse_with(device, include_str!("../../../../docs/devices/tpg.md"));
}

#[test]
fn an_img400_answers_as_the_model() {
    let device = Img400::new(RamStore::default(), stored(), Gauges::default());
    converse_with(device, include_str!("../../../../docs/devices/img400.md"));
}
