//! How often the intervals of the joint fit contain the truth, for plants that nobody looked at while the fit was written.

#![allow(clippy::unwrap_used, clippy::panic, reason = "a test")]

mod plants;

use plants::Truth;
use profivac_identify::plant::{Plant, identify};

const NAMES: [&str; 6] = ["leak", "outgassing after 1 h", "exponent", "ultimate pressure", "speed", "volume"];

fn compared(truth: &Truth, plant: &Plant) -> Vec<(usize, f64, profivac_identify::Interval)> {
    let (pa, speed) = plant.speeds[plant.speeds.len() / 2];
    let mut all = vec![
        (0, truth.leak, plant.leak),
        (1, truth.outgassing_1h, plant.outgassing_1h),
        (2, truth.exponent, plant.exponent),
        (3, truth.ultimate_pa, plant.ultimate_pa),
        (4, truth.speed_at(pa), speed),
    ];
    if truth.dosed {
        all.push((5, truth.volume_m3, plant.volume_m3));
    }
    all
}

#[test]
fn coverage() {
    let from: u64 = std::env::var("FROM").unwrap().parse().unwrap();
    let count: u64 = std::env::var("COUNT").unwrap().parse().unwrap();
    let verbose = std::env::var("V").is_ok();
    let one = |seed: u64| {
        let truth = Truth::of(seed);
        let started = std::time::Instant::now();
        let record = truth.record(seed);
        let made = started.elapsed().as_secs_f64();
        let found = identify(&record);
        (seed, truth, record.samples.len(), made, started.elapsed().as_secs_f64() - made, found)
    };
    let halves: Vec<_> = std::thread::scope(|scope| {
        let threads = [0, 1].map(|half| {
            let one = &one;
            scope.spawn(move || (from..from + count).filter(|seed| seed % 2 == half).map(one).collect::<Vec<_>>())
        });
        threads.into_iter().flat_map(|thread| thread.join().unwrap()).collect()
    });
    let (mut held, mut all, mut time, mut made) = ([0; 6], [0; 6], 0.0, 0.0);
    let mut below = [0; 6];
    for (seed, truth, samples, making, seconds, found) in halves {
        time += seconds;
        made += making;
        let plant = match found {
            Ok(plant) => plant,
            Err(error) => {
                println!("{seed}: {error}");
                continue;
            }
        };
        for (place, true_value, interval) in compared(&truth, &plant) {
            all[place] += 1;
            held[place] += u32::from(interval.contains(true_value));
            if verbose && !interval.contains(true_value) {
                println!("{seed} {}: {true_value:.3e} not in {:.3e} .. {:.3e}; scatter {:.4} of {:.4}, {samples} samples, dose {}", NAMES[place], interval.low, interval.high, plant.scatter, truth.noise, truth.dosed);
            }
            below[place] += u32::from(true_value > interval.high);
        }
    }
    println!("{time:.1} s fits, {made:.1} s making");
    for (place, name) in NAMES.iter().enumerate() {
        println!("{name}: {} of {} ({} above)", held[place], all[place], below[place]);
    }
}
