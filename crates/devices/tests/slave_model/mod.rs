//! A second slave, written from `docs/spec` alone, beside the real one: the same random services, the same answers.
//!
//! The model ([`model`], [`acyclic`]) is plain and uses neither the code of `dp` nor of `wire`. Services of two class 1
//! masters and two class 2 masters come in any order and at any time. Each answer is compared octet by octet, and with it
//! the state, the address, min T_SDR and the watchdog. A difference is reduced to the shortest list of steps that shows it.
//!
//! What parameters of gauges contain is in [`contents`], from the manuals and the errata; [`open_points`] has what they leave open.
//!
//! `PROFIVAC_FUZZ=N` makes the runs N times as long. `PROFIVAC_SEED=N` runs one more seed.
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic, reason = "this is test code")]

mod acyclic;
mod contents;
mod coverage;
mod faults;
mod gauge;
mod line;
mod model;
mod open_points;
mod page;
mod process;
mod rows;
mod services;
mod shrink;
mod simple;
mod tables;
mod telegram;

use contents::{Common, Contents};
use gauge::{Gauge, Peek};
use line::{Driven, Line, Step};
use model::Model;
use page::Page;
use process::{Process, Simple};
use profivac_devices::bcg450::Bcg450;
use profivac_devices::img400::{Gauges, Img400};
use profivac_devices::profile::{Behaviour, Setup};
use profivac_devices::pxg55x::{Pxg55x, Pxg55xModel};
use profivac_devices::store::RamStore;
use profivac_devices::tpg::table::TPG300;
use profivac_devices::tpg::{Tpg, TpgGauge};
use profivac_devices::xpg400::{Xpg400, Xpg400Model};
use profivac_devices::{Principle, SimulatedDevice};
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
fn gauge<B: Behaviour + Clone>(device: &Gauge<B>, page: &Page, contents: &Contents) -> Line<Gauge<B>> {
    let mut page = page.clone();
    page.table.im0 = device.im0();
    let address = device.station_address();
    let process = Peek::new(page.clone(), contents.clone(), device.clone());
    let slave = Slave::new(device.clone(), address, Baud::B1500000);
    Line::new(slave, Model::new(page.table, process, address))
}

/// Runs conversations with a gauge.
fn converse_with<B: Behaviour + Clone>(mut device: Gauge<B>, mbar: f64, contents: Contents, text: &str) {
    sense_all(&mut device, mbar);
    SimulatedDevice::settle(&mut device);
    let page = Page::of(text, device.name(), device.station_address() == 126);
    let name = page.table.name.clone();
    let atmosphere = page.rows.iter().any(|row| row.instance == Some(3));
    rows::check(&page, &rows::of(&name, atmosphere));
    let reached = converse(&name, 40, false, || gauge(&device, &page, &contents));
    assert_reached(&reached, coverage::ALL);
    if page.table.ms1 && page.table.ms2 {
        assert_reached(&reached, coverage::DPV1);
    }
    if page.has_selector() {
        assert_reached(&reached, coverage::SELECTOR);
    }
}

/// Every sensor in a chamber at this pressure.
fn sense_all(device: &mut impl SimulatedDevice, mbar: f64) {
    let ambient: Vec<bool> = device.parts().iter().map(|part| part.principle == Principle::Atmosphere).collect();
    for (part, _) in ambient.into_iter().enumerate().filter(|(_, ambient)| !ambient) {
        device.sense(part, mbar * 100.0);
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

/// Torr of a millibar, errata-bpg-bcg-tpg 83.
const TORR: f64 = 0.750_061_68;

/// The page of the BCG450.
const BCG450: &str = include_str!("../../../../docs/devices/bcg450.md");

/// A BCG450 at this pressure.
fn bcg450(mbar: f64) {
    let contents = Contents::new(Common::new(TORR, 0x7FFF), contents::bcg450::Bcg450::new(mbar));
    converse_with(Bcg450::new(RamStore::default(), stored()), mbar, contents, BCG450);
}

#[test]
fn the_comparison_finds_each_fault_that_is_put_into_the_answers() {
    let mut device = Bcg450::new(RamStore::default(), stored());
    sense_all(&mut device, 1e-6);
    SimulatedDevice::settle(&mut device);
    let page = Page::of(BCG450, device.name(), true);
    let contents = Contents::new(Common::new(TORR, 0x7FFF), contents::bcg450::Bcg450::new(1e-6));
    let differs = |fault, seed| {
        let mut line = gauge(&device, &page, &contents);
        line.fault = fault;
        let mut services = Services::new(seed, false);
        (0..STEPS).any(|_| {
            let step = services.next(&line.model, line.now);
            line.step(&step).difference.is_some()
        })
    };
    assert!(!(0..20).any(|seed| differs(None, seed)), "a difference without a fault");
    for (name, fault) in faults::FAULTS {
        let seed = (0..200).find(|seed| differs(Some(*fault), *seed));
        println!("{name}: seed {seed:?}");
        assert!(seed.is_some(), "{name}: not found in 200 conversations");
    }
}

#[test]
fn a_bcg450_in_high_vacuum_answers_as_the_model() {
    bcg450(1e-6);
}

#[test]
fn a_bcg450_in_rough_vacuum_answers_as_the_model() {
    bcg450(200.0);
}

#[test]
fn a_bpg400_answers_as_the_model() {
    let contents = Contents::new(Common::new(TORR, 0x7FFF), contents::xpg400::Xpg400::new(false, 1e-6));
    let device = Xpg400::new(RamStore::default(), Xpg400Model::Bpg, stored());
    converse_with(device, 1e-6, contents, include_str!("../../../../docs/devices/bpg400.md"));
}

#[test]
fn an_hpg400_answers_as_the_model() {
    let contents = Contents::new(Common::new(TORR, 0x7FFF), contents::xpg400::Xpg400::new(true, 1e-2 * 3.0));
    let device = Xpg400::new(RamStore::default(), Xpg400Model::Hpg, stored());
    converse_with(device, 1e-2 * 3.0, contents, include_str!("../../../../docs/devices/hpg400.md"));
}

/// A PCG55x or PSG55x at this pressure.
fn pxg55x(name: &str, atmosphere: Option<bool>, setup: Setup, mbar: f64, text: &str) {
    let mut common = Common::new(contents::pxg55x::TORR, 0x7FFF);
    // errata-pxg55x-img400 84.
    common.type_in_idle = false;
    let psg = atmosphere.is_none();
    let contents = Contents::new(common, contents::pxg55x::Pxg55x::new(psg, atmosphere == Some(true), mbar));
    let model = Pxg55xModel::named(name, atmosphere).expect("a model");
    converse_with(Pxg55x::new(RamStore::default(), model, setup), mbar, contents, text);
}

#[test]
fn a_pcg550_answers_as_the_model() {
    pxg55x("pcg550", Some(false), stored(), 1e-2, include_str!("../../../../docs/devices/pcg55x.md"));
}

#[test]
fn a_pcg550_with_an_atmosphere_sensor_answers_as_the_model() {
    pxg55x("pcg550", Some(true), stored(), 200.0, include_str!("../../../../docs/devices/pcg55x-atm.md"));
}

#[test]
fn a_psg550_answers_as_the_model() {
    pxg55x("psg550", None, switched(), 1e-2, include_str!("../../../../docs/devices/psg55x.md"));
}

#[test]
fn a_tpg300_answers_as_the_model() {
    let gauges = [Some(TpgGauge::Pirani), Some(TpgGauge::ColdCathode), None, None];
    let device = Tpg::new(&TPG300, RamStore::default(), switched(), gauges);
    let mut common = Common::new(TORR, 0x7FFF);
    common.unit_in_idle = false;
    let contents = Contents::new(common, contents::tpg::Tpg::new(gauges.map(|it| it.is_some())));
    converse_with(device, 1e-2, contents, include_str!("../../../../docs/devices/tpg.md"));
}

#[test]
fn an_img400_answers_as_the_model() {
    let device = Img400::new(RamStore::default(), stored(), Gauges::default());
    let mut common = Common::new(TORR, 0xFFFF);
    // BG 5530 4.4.2: only the exchange matters.
    common.type_in_idle = false;
    let contents = Contents::new(common, contents::img400::Img400::new(1e-6));
    converse_with(device, 1e-6, contents, include_str!("../../../../docs/devices/img400.md"));
}
