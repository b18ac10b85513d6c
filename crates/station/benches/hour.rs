//! An hour with faults in every segment: `cargo bench -p profivac-station --bench hour`.
//!
//! Gauges lose power, lines are cut, somebody babbles, in every segment every few seconds. What is printed: how much memory
//! the process takes, how often what happened, and whether all gauges are well at the end. PROFIVAC_BENCH_SECONDS makes it
//! shorter.

#![allow(clippy::unwrap_used, missing_docs, reason = "a benchmark")]

#[path = "../tests/hardship/mod.rs"]
mod hardship;

use hardship::{Bench, Blow};
use profivac_station::services::Services;
use profivac_station::station::Station;
use profivac_station::view::BusStationState;
use std::time::{Duration, Instant};

const SEGMENTS: usize = 2;
const DEVICES: [&str; 4] = ["bcg450@5", "psg550@6", "tpg300@7", "img400@8"];

/// Between two blows, and for a gauge or a line to be down.
const BETWEEN: Duration = Duration::from_secs(2);

fn main() {
    let seconds = std::env::var("PROFIVAC_BENCH_SECONDS").ok().and_then(|text| text.parse().ok()).unwrap_or(3600);
    let folder = tempfile::tempdir().unwrap();
    let benches: Vec<_> = (0..SEGMENTS).map(|_| Bench::start(&DEVICES)).collect();
    let station = Station::start(hardship::config(&benches, &DEVICES, "200 ms", folder.path())).unwrap();
    let plant = station.services();
    wait_until_well(&plant);
    let mut random = fastrand::Rng::with_seed(1);
    let (mut cuts, mut powers, mut babbles) = (0_u32, 0_u32, 0_u32);
    let (begun, total) = (Instant::now(), Duration::from_secs(seconds));
    let mut told = 0;
    while begun.elapsed() < total {
        for bench in &benches {
            let address = random.u8(5..9);
            match random.u8(0..4) {
                0 => {
                    cuts += 1;
                    bench.strike(Blow::Cut);
                    std::thread::sleep(BETWEEN);
                    bench.strike(Blow::Mend);
                }
                1 | 2 => {
                    powers += 1;
                    bench.strike(Blow::Power(address, false));
                    std::thread::sleep(BETWEEN);
                    bench.strike(Blow::Power(address, true));
                }
                _ => {
                    babbles += 1;
                    let noise: Vec<_> = std::iter::repeat_with(|| random.u8(..)).take(2000).collect();
                    bench.babble(&noise);
                }
            }
        }
        std::thread::sleep(BETWEEN);
        let tenth = (begun.elapsed().as_secs() * 10) / seconds.max(1);
        if tenth > told {
            told = tenth;
            println!("{:>5} s: {} kB", begun.elapsed().as_secs(), memory_kb());
        }
    }
    let well = wait_until_well(&plant);
    println!(
        "{SEGMENTS} segments, {} gauges: {cuts} cut lines, {powers} power cuts, {babbles} times noise",
        DEVICES.len() * SEGMENTS
    );
    println!(
        "all well {:.1} s after the last; {} samples lost",
        well.as_secs_f64(),
        plant.recorder().health().lost_samples
    );
    station.stop();
}

/// How long it took until all gauges exchange data. A station in which something is stuck never gets there.
fn wait_until_well(plant: &Services) -> Duration {
    let begun = Instant::now();
    // An IMG 400 with its ion gauges off reports that.
    let is_well = |standing| matches!(standing, BusStationState::Exchanging | BusStationState::Faulty);
    let well = |plant: &Services| plant.gauges().iter().filter(|gauge| is_well(gauge.standing)).count();
    while well(plant) < SEGMENTS * DEVICES.len() {
        assert!(begun.elapsed() < Duration::from_secs(120), "something is stuck: {:#?}", plant.gauges());
        std::thread::sleep(Duration::from_millis(100));
    }
    begun.elapsed()
}

fn memory_kb() -> u64 {
    let status = std::fs::read_to_string("/proc/self/status").unwrap();
    let line = status.lines().find_map(|line| line.strip_prefix("VmRSS:")).unwrap();
    line.trim().trim_end_matches(" kB").parse().unwrap()
}
