//! Plants with numbers that the fit does not know, identified from noisy records.

#![allow(clippy::unwrap_used, clippy::panic, reason = "a test")]

use crate::support::normal;
use profivac_identify::plant::{Dose, NotIdentified, Phase, PlantRecord, Remedy, Volume, identify, identify_unless};
use profivac_vacuum::network::Outside;
use profivac_vacuum::pump::Roughing;
use profivac_vacuum::surface::{Material, Surface};
use profivac_vacuum::{Atmosphere, Conductance, Gas, Mixture, Network};
use std::cell::Cell;

const HOUR_S: f64 = 3600.0;

/// A chamber of glass, whose water has the law of the fit, with a pump of a constant speed.
struct Truth {
    volume_m3: f64,
    speed: f64,
    leak: f64,
    outgassing_1h: f64,
    ultimate_pa: f64,
}

impl Truth {
    fn of(seed: u64) -> Self {
        let mut random = fastrand::Rng::with_seed(seed);
        let mut between = |from: f64, to: f64| from * (to / from).powf(random.f64());
        Self {
            volume_m3: between(0.02, 0.5),
            speed: between(0.05, 0.5),
            leak: between(1e-7, 3e-6),
            outgassing_1h: between(5e-7, 1e-5),
            ultimate_pa: between(1e-7, 1e-6),
        }
    }

    /// Eight hours of pumping from 10 Pa, an hour with a closed valve with a dose in its middle, and noise of 1 %.
    fn record(&self, seed: u64, with_dose: bool) -> PlantRecord {
        let mut random = fastrand::Rng::with_seed(!seed);
        let mut network = Network::new(Atmosphere { humidity: 0.0, ..Atmosphere::default() });
        let chamber = network.add_volume(self.volume_m3, Mixture::pure(Gas::N2, 10.0));
        let pump = network.add_roughing_pump(
            chamber,
            Roughing { ultimate: Mixture::pure(Gas::N2, self.ultimate_pa), ..Roughing::dry(self.speed, 0.0) },
        );
        // 1.05e-6 Pa m/s of glass after an hour.
        let glass = Surface::fresh(self.outgassing_1h / 1.05e-6, Material::named("glass").unwrap());
        network.add_wall(chamber, glass);
        let leak = Conductance::viscous(self.leak / network.atmosphere().pressure_pa);
        let leak = network.add_opening(chamber, leak, Outside::Air);
        network.set_opening(leak, 1.0);
        let dose_inlet = network.add_inlet(chamber, Gas::N2);
        let closed = 8.0 * HOUR_S;
        let dose = Dose { at_s: closed + 1805.0, amount: 0.02 * self.volume_m3 };
        let mut samples = Vec::new();
        let mut step = |network: &mut Network, t: &mut f64, seconds: f64| {
            network.advance(seconds);
            *t += seconds;
            samples.push((*t, network.mixture(chamber).total() * (1.0 + 0.01 * normal(&mut random))));
        };
        let mut t = 0.0;
        while t < 60.0 {
            step(&mut network, &mut t, 0.1);
        }
        while t < closed - 0.1 {
            step(&mut network, &mut t, 10.0);
        }
        network.run_roughing(pump, false);
        let closed = t;
        let dose = Dose { at_s: closed + 1800.0, ..dose };
        while t < closed + HOUR_S {
            let due = with_dose && (t - dose.at_s).abs() < 5.0;
            if due {
                network.set_inlet(dose_inlet, profivac_vacuum::network::Supply::Flow(dose.amount / 10.0));
            }
            step(&mut network, &mut t, 10.0);
            if due {
                network.set_inlet(dose_inlet, profivac_vacuum::network::Supply::Closed);
            }
        }
        // The gas enters between two samples.
        let dose = Dose { at_s: dose.at_s + 5.0, ..dose };
        PlantRecord {
            samples,
            phases: vec![Phase { from_s: 0.0, pumped: true }, Phase { from_s: closed, pumped: false }],
            volume: if with_dose { Volume::FromDose(dose) } else { Volume::Given(self.volume_m3) },
            gauge_uncertainty: 0.0,
        }
    }
}

#[test]
fn three_plants_with_unknown_numbers_are_identified_within_their_intervals() {
    for seed in [11, 12, 13] {
        let truth = Truth::of(seed);
        let plant = identify(&truth.record(seed, false)).unwrap();
        for (what, found, truth) in [
            ("leak", plant.leak, truth.leak),
            ("outgassing", plant.outgassing_1h, truth.outgassing_1h),
            ("ultimate pressure", plant.ultimate_pa, truth.ultimate_pa),
        ] {
            assert!(found.contains(truth), "{seed}: {what} {truth:e}, {found:?}");
        }
        let speed = plant.speeds.last().unwrap().1;
        assert!(speed.contains(truth.speed), "{seed}: speed {:e}, {speed:?}", truth.speed);
        assert!((plant.exponent.mean - 1.0).abs() < 0.15, "{seed}: {:?}", plant.exponent);
        assert!(plant.scatter < 0.02, "{seed}: {}", plant.scatter);
    }
}

/// Each interval claims 95 %.
#[test]
fn the_intervals_of_twenty_plants_contain_the_truth_about_as_often_as_they_claim() {
    const NAMES: [&str; 4] = ["leak", "outgassing", "ultimate pressure", "speed"];
    let mut held = [0; 4];
    for seed in 100..120 {
        let truth = Truth::of(seed);
        let plant = identify(&truth.record(seed, false)).unwrap();
        let speed = plant.speeds.last().unwrap().1;
        let contains = [
            plant.leak.contains(truth.leak),
            plant.outgassing_1h.contains(truth.outgassing_1h),
            plant.ultimate_pa.contains(truth.ultimate_pa),
            speed.contains(truth.speed),
        ];
        held.iter_mut().zip(contains).for_each(|(held, contains)| *held += u32::from(contains));
    }
    println!("{NAMES:?} of twenty: {held:?}");
    assert!(held.iter().all(|held| *held >= 17), "{NAMES:?} of twenty: {held:?}");
}

#[test]
fn a_known_dose_gives_the_volume() {
    for seed in [21, 22] {
        let truth = Truth::of(seed);
        let plant = identify(&truth.record(seed, true)).unwrap();
        let apart = (plant.volume_m3.mean / truth.volume_m3 - 1.0).abs();
        assert!(apart < 0.01, "{seed}: {:?} instead of {}", plant.volume_m3, truth.volume_m3);
        assert!(plant.volume_m3.contains(truth.volume_m3), "{seed}: {:?}", plant.volume_m3);
    }
}

#[test]
fn a_prediction_beside_the_record_holds_and_a_target_has_a_time() {
    let truth = Truth::of(11);
    let record = truth.record(11, false);
    let cut = PlantRecord {
        samples: record.samples.iter().copied().filter(|(t, _)| *t < 2.0 * HOUR_S || *t >= 8.0 * HOUR_S).collect(),
        ..record.clone()
    };
    let plant = identify(&cut).unwrap();
    for hours in [4.0, 6.0, 7.9] {
        let (_, pa) = record.samples.iter().find(|(t, _)| *t >= hours * HOUR_S).unwrap();
        let predicted = plant.predicted_pa(hours * HOUR_S);
        assert!((predicted.mean / pa - 1.0).abs() < 0.1, "{hours} h: {predicted:?} instead of {pa:e}");
        assert!(predicted.low < predicted.mean && predicted.mean < predicted.high);
    }
    let (seconds, pa) = record.samples.iter().copied().find(|(t, _)| *t >= 5.0 * HOUR_S).unwrap();
    let time = plant.time_to_pa(pa).unwrap();
    assert!(time.low < seconds && seconds < time.high * 1.2, "{time:?} instead of {seconds}");
    assert!(plant.time_to_pa(1e-12).is_none(), "below the ultimate pressure");
}

#[test]
fn the_best_remedy_is_that_of_the_largest_part() {
    let leaky = Truth { volume_m3: 0.1, speed: 0.2, leak: 1e-5, outgassing_1h: 1e-6, ultimate_pa: 1e-8 };
    let plant = identify(&leaky.record(1, false)).unwrap();
    let (best, better) = plant.remedies()[0];
    assert_eq!(best, Remedy::CloseLeak);
    assert!(better.low > 10.0, "{better:?}");
    let wet = Truth { volume_m3: 0.1, speed: 0.2, leak: 1e-9, outgassing_1h: 1e-4, ultimate_pa: 1e-8 };
    assert_eq!(identify(&wet.record(2, false)).unwrap().remedies()[0].0, Remedy::Bake);
}

#[test]
fn records_that_cannot_be_fitted_are_refused() {
    let good = Truth::of(11).record(11, false);
    let with = |change: &dyn Fn(&mut PlantRecord)| {
        let mut record = good.clone();
        change(&mut record);
        identify(&record).unwrap_err()
    };
    assert_eq!(with(&|record| record.samples.truncate(5)), NotIdentified::Few(5));
    assert_eq!(with(&|record| record.samples[3].1 = -1.0), NotIdentified::Sample(3));
    for impossible in [f64::NAN, f64::INFINITY, 0.0, 1e300, 1e-300] {
        assert_eq!(with(&|record| record.samples[7].1 = impossible), NotIdentified::Sample(7));
    }
    assert_eq!(with(&|record| record.samples[4].0 = 0.0), NotIdentified::Sample(3));
    assert_eq!(with(&|record| record.phases.clear()), NotIdentified::Phases);
    assert_eq!(with(&|record| record.volume = Volume::Given(0.0)), NotIdentified::Volume);
    let early = Dose { at_s: 100.0, amount: 1.0 };
    assert_eq!(with(&|record| record.volume = Volume::FromDose(early)), NotIdentified::DoseWhilePumped);
}

/// The fit finds hardly any outgassing in a minute of a pump-down. Its interval goes down to almost nothing and is no single number.
#[test]
fn a_minute_of_a_pump_down_does_not_determine_the_outgassing() {
    let mut random = fastrand::Rng::with_seed(8);
    let pressure = |second: i32| 100.0 * 0.8_f64.powi(second) + 1e-2;
    let record = PlantRecord {
        samples: (0..60).map(|t| (f64::from(t), pressure(t) * (1.0 + 0.02 * (random.f64() - 0.5)))).collect(),
        phases: vec![Phase { from_s: 0.0, pumped: true }],
        volume: Volume::Given(0.05),
        gauge_uncertainty: 0.0,
    };
    let found = identify(&record).unwrap().outgassing_1h;
    assert!(found.high > 1e3 * found.low, "{found:?}");
}

/// A caller that gives up after some evaluations gets that as the reason, long before the fit would end.
#[test]
fn a_search_that_is_stopped_ends_with_that_reason() {
    let pressure = |t: f64| 100.0 * (-t / 20.0).exp() + 1e-2 / (t + 1.0);
    let record = PlantRecord {
        samples: (0..3_000).map(|second| (f64::from(second), pressure(f64::from(second)))).collect(),
        phases: vec![Phase { from_s: 0.0, pumped: true }],
        volume: Volume::Given(0.1),
        gauge_uncertainty: 0.0,
    };
    let calls = Cell::new(0_u32);
    let stopped = |after: u32| {
        calls.set(0);
        let stop = || {
            calls.set(calls.get() + 1);
            calls.get() > after
        };
        (identify_unless(&record, &stop).map(drop), calls.get())
    };
    let (found, all) = stopped(u32::MAX);
    assert_eq!(found, Ok(()));
    for after in [0, 5, all / 2] {
        let (found, calls) = stopped(after);
        assert_eq!(found, Err(NotIdentified::Stopped));
        assert!(calls < after + 200, "{calls} of {all} after {after}");
    }
}
