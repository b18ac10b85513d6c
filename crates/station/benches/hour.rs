//! An hour with faults in every segment: `cargo bench -p profivac-station --bench hour`.
//!
//! In every segment a gauge loses power, the line is cut or noise is on the line, every few seconds. The bench prints the memory of the
//! process, the number of faults of each kind, and whether all gauges are in data exchange at the end. PROFIVAC_BENCH_SECONDS makes
//! it shorter.

#![allow(clippy::unwrap_used, reason = "a benchmark")]

#[path = "../tests/support/mod.rs"]
mod support;
#[path = "../../../tests/support/until.rs"]
mod until;

use profivac_station::services::Services;
use profivac_station::station::Station;
use profivac_station::view::BusStationState;
use std::time::{Duration, Instant};
use support::tcp_segment::{Fault, TcpSegment, config};

const SEGMENTS: usize = 2;
const DEVICES: [&str; 4] = ["bcg450@5", "psg550@6", "tpg300@7", "img400@8"];

/// The time between two faults, and the duration of a fault.
const BETWEEN: Duration = Duration::from_secs(2);

fn main() {
    let seconds = std::env::var("PROFIVAC_BENCH_SECONDS").ok().and_then(|text| text.parse().ok()).unwrap_or(3600);
    let folder = tempfile::tempdir().unwrap();
    let segments: Vec<_> = (0..SEGMENTS).map(|_| TcpSegment::start(&DEVICES)).collect();
    let station = Station::start(config(&segments, &DEVICES, "200 ms", folder.path())).unwrap();
    let services = station.services();
    wait_until_well(&services);
    let mut random = fastrand::Rng::with_seed(1);
    let (mut cuts, mut powers, mut noises) = (0_u32, 0_u32, 0_u32);
    let (begun, total) = (Instant::now(), Duration::from_secs(seconds));
    let mut told = 0;
    while begun.elapsed() < total {
        for segment in &segments {
            let address = random.u8(5..9);
            match random.u8(0..4) {
                0 => {
                    cuts += 1;
                    segment.apply(Fault::Cut);
                    std::thread::sleep(BETWEEN);
                    segment.apply(Fault::Mend);
                }
                1 | 2 => {
                    powers += 1;
                    segment.apply(Fault::Power(address, false));
                    std::thread::sleep(BETWEEN);
                    segment.apply(Fault::Power(address, true));
                }
                _ => {
                    noises += 1;
                    let noise: Vec<_> = std::iter::repeat_with(|| random.u8(..)).take(2000).collect();
                    segment.send_noise(&noise);
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
    let well = wait_until_well(&services);
    println!(
        "{SEGMENTS} segments, {} gauges: {cuts} cut lines, {powers} power cuts, {noises} times noise",
        DEVICES.len() * SEGMENTS
    );
    println!(
        "all well {:.1} s after the last; {} samples lost",
        well.as_secs_f64(),
        services.recorder().health().lost_samples
    );
    station.stop().unwrap();
}

/// How long it took until all gauges exchange data. A station in which something is stuck never gets there.
fn wait_until_well(services: &Services) -> Duration {
    let begun = Instant::now();
    // An IMG 400 with its ion gauges off reports that.
    let is_well = |state| matches!(state, BusStationState::DataExchange | BusStationState::Fault);
    let well = |services: &Services| services.snapshots().gauges().iter().filter(|gauge| is_well(gauge.state)).count();
    while well(services) < SEGMENTS * DEVICES.len() {
        assert!(begun.elapsed() < Duration::from_secs(120), "something is stuck: {:#?}", services.snapshots().gauges());
        std::thread::sleep(Duration::from_millis(100));
    }
    begun.elapsed()
}

fn memory_kb() -> u64 {
    let status = std::fs::read_to_string("/proc/self/status").unwrap();
    let line = status.lines().find_map(|line| line.strip_prefix("VmRSS:")).unwrap();
    line.trim().trim_end_matches(" kB").parse().unwrap()
}
