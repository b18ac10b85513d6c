//! The rates of USB adapters as their drivers in Linux set and report them: docs/adapters.md has the table.

#![allow(clippy::unwrap_used, reason = "a test")]

use super::settings::wrong_rate;
use super::system;
use profivac_dp::link::Baud;

#[path = "../../../../tests/support/adapter_page.rs"]
mod adapter_page;

/// A driver with a chip.
struct Driver {
    name: &'static str,
    /// The rate that the driver reports and the rate at which the chip runs, for a rate that it was asked for.
    set: fn(u32) -> (u32, u32),
    /// The rate that profivac calculates for a driver that reports the rate it was asked for.
    calculated: fn(u32) -> Option<u32>,
}

const DRIVERS: [Driver; 5] = [
    Driver { name: "CP2102, `cp210x`", set: cp2102, calculated: |_| None },
    Driver { name: "CP2102N, `cp210x`", set: cp2102n, calculated: |_| None },
    Driver { name: "PL2303HXD, `pl2303`", set: pl2303hxd, calculated: |_| None },
    Driver { name: "PL2303G, `pl2303`", set: pl2303g, calculated: |_| None },
    Driver { name: "CH340 and CH341, `ch341`", set: ch341, calculated: |wanted| Some(system::rate_of_ch341(wanted)) },
];

/// The rates of the CP2102 from 38400 on, each with the highest rate for which it is taken. Silicon Labs AN205; the driver
/// limits the rate to 1 Mbit/s.
const CP2102_RATES: [(u32, u32); 16] = [
    (38_400, 38_601),
    (51_200, 51_558),
    (56_000, 56_280),
    (57_600, 58_053),
    (64_000, 64_111),
    (76_800, 77_608),
    (115_200, 117_028),
    (128_000, 129_347),
    (153_600, 156_868),
    (230_400, 237_832),
    (250_000, 254_234),
    (256_000, 273_066),
    (460_800, 491_520),
    (500_000, 567_138),
    (576_000, 670_254),
    (921_600, u32::MAX),
];

fn cp2102(wanted: u32) -> (u32, u32) {
    let lower = [9_600, 19_200].contains(&wanted).then_some(wanted);
    let higher = || CP2102_RATES.iter().find(|(_, highest)| wanted <= *highest).map(|(rate, _)| *rate);
    let rate = lower.or_else(higher).unwrap();
    (rate, rate)
}

/// 24 MHz divided by a whole number, up to 3 Mbit/s.
fn cp2102n(wanted: u32) -> (u32, u32) {
    const CLOCK: u32 = 24_000_000;
    let wanted = wanted.min(3_000_000);
    let rate = CLOCK / ((CLOCK + wanted / 2) / wanted);
    (rate, rate)
}

/// The rates that a PL2303 takes as they are, as far as they matter here.
const PL2303_RATES: [u32; 15] = [
    9_600, 14_400, 19_200, 28_800, 38_400, 57_600, 115_200, 230_400, 460_800, 614_400, 921_600, 1_228_800, 2_457_600,
    3_000_000, 6_000_000,
];

/// Other rates are 384 MHz divided by a number of nine bits and a power of four, up to 12 Mbit/s.
fn pl2303hxd(wanted: u32) -> (u32, u32) {
    if PL2303_RATES.contains(&wanted) {
        return (wanted, wanted);
    }
    let (mut divisor, mut exponent) = (384_000_000 / wanted, 0);
    while divisor >= 512 {
        (divisor, exponent) = (divisor / 4, exponent + 2);
    }
    let rate = (384_000_000 / divisor) >> exponent;
    (rate, rate)
}

/// It takes the nearest of its rates.
fn pl2303g(wanted: u32) -> (u32, u32) {
    let rate = PL2303_RATES.into_iter().min_by_key(|rate| rate.abs_diff(wanted)).unwrap();
    (rate, rate)
}

/// 48 MHz divided by a power of two and a number from 2 to 256, or from 9 for the odd powers, up to 3 Mbit/s. The driver takes the
/// nearest, and reports the rate that it was asked for.
fn ch341(wanted: u32) -> (u32, u32) {
    const CLOCK: u32 = 48_000_000;
    let limited = wanted.min(3_000_000);
    let even = [12, 9, 6, 3].into_iter().flat_map(|power| (2..=256).map(move |number| CLOCK / (number << power)));
    let odd = [11, 8, 5, 2].into_iter().flat_map(|power| (9..=256).map(move |number| CLOCK / (number << power)));
    let rate = even.chain(odd).min_by_key(|rate| rate.abs_diff(limited)).unwrap();
    (wanted, rate)
}

/// A row for each rate, and whether the real rate is one with which the line works.
fn row(driver: &Driver, baud: Baud) -> (String, bool, bool) {
    let wanted = baud.bits_per_second();
    let (reported, real) = (driver.set)(wanted);
    let refused = wrong_rate(wanted, [(driver.calculated)(wanted), Some(reported)]);
    let is_usable = real.abs_diff(wanted) <= wanted / 50;
    let deviation = (f64::from(real) - f64::from(wanted)) / f64::from(wanted) * 100.0;
    let outcome = refused.map_or_else(|| "taken".to_owned(), |rate| format!("refused: it would run at {rate} bit/s"));
    let row = format!("| {} | {wanted} | {reported} | {real} | {deviation:+.2} % | {outcome} |\n", driver.name);
    (row, refused.is_none(), is_usable)
}

/// profivac takes exactly the rates at which the adapter runs, and the page about adapters shows them.
#[test]
fn a_rate_is_refused_if_the_adapter_runs_at_another_one() {
    let mut table =
        "| Adapter, driver | bit/s | Reported | Real | Deviation | profivac |\n|---|--:|--:|--:|--:|---|\n".to_owned();
    for driver in &DRIVERS {
        for baud in Baud::ALL {
            let (row, is_taken, is_usable) = row(driver, baud);
            assert_eq!(is_taken, is_usable, "{row}");
            table.push_str(&row);
        }
    }
    adapter_page::check_table("driver_rates", &table);
}
