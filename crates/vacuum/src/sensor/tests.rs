//! Sensors: ideal ones are exact, real ones close to the true pressure and reproducible by seed.

use super::*;
use crate::gas::Gas;

const PRINCIPLES: [(Principle, Range); 5] = [
    (Principle::Pirani, Range { lowest_pa: 0.08, highest_pa: 1e5 }),
    (Principle::Diaphragm, Range { lowest_pa: 100.0, highest_pa: 1.5e5 }),
    (Principle::HotCathode, Range { lowest_pa: 5e-8, highest_pa: 2.0 }),
    (Principle::ColdCathode, Range { lowest_pa: 1e-7, highest_pa: 1.0 }),
    (Principle::Atmosphere, Range { lowest_pa: 3e4, highest_pa: 1.2e5 }),
];

const LOW_EMISSION: Drive = Drive::Emission { milliamperes: 0.025, degas: false };

fn environment(gas: Gas, pa: f64) -> Environment {
    Environment { gas: Mixture::pure(gas, pa), atmosphere_pa: 98_700.0, temperature_k: REFERENCE_K }
}

#[test]
fn an_ideal_sensor_in_nitrogen_indicates_the_true_pressure_after_any_call() {
    for (principle, range) in PRINCIPLES {
        let mut sensor = Sensor::ideal(principle, range);
        for (pa, drive) in [(1e-9, Drive::Off), (1e-3, LOW_EMISSION), (50.0, Drive::On), (2e5, Drive::On)] {
            let expected = if principle == Principle::Atmosphere { 98_700.0 } else { pa };
            assert_eq!(sensor.read(&environment(Gas::N2, pa), drive, 5.0), expected, "{principle:?}");
        }
        assert!(sensor.imperfections_mut().is_none() && sensor.filament().is_none());
        sensor.contaminate(1.0);
        assert_eq!(sensor.read(&environment(Gas::N2, 1e-9), Drive::On, 1.0) > 1.0, principle == Principle::Atmosphere);
    }
}

/// The mean of ten seconds in the middle of the range, after one day.
#[test]
fn a_real_sensor_is_close_to_the_true_pressure_but_not_exact() {
    let middles = [100.0, 1e4, 1e-3, 1e-3, 98_700.0];
    for ((principle, range), pa) in PRINCIPLES.into_iter().zip(middles) {
        for seed in 0..20 {
            let mut sensor = Sensor::real(principle, range, seed);
            sensor.read(&environment(Gas::N2, pa), LOW_EMISSION, 86_400.0);
            let values: Vec<f64> =
                (0..1000).map(|_| sensor.read(&environment(Gas::N2, pa), LOW_EMISSION, 0.01)).collect();
            let mean = values.iter().sum::<f64>() / 1000.0;
            let within = if principle == Principle::ColdCathode { 0.5 } else { 0.2 };
            assert!((mean / pa - 1.0).abs() < within, "{principle:?}, seed {seed}: {mean} at {pa} Pa");
            let moves = values.windows(2).filter(|pair| pair[0] != pair[1]).count();
            assert!(moves > 990, "{principle:?}, seed {seed}: {moves} of 999");
        }
    }
}

/// General knowledge: 3e-5 of full scale, see `Diaphragm::tolerance`.
#[test]
fn a_diaphragm_has_the_noise_of_its_full_scale() {
    let (principle, range) = PRINCIPLES[1];
    let mut sensor = Sensor::real(principle, range, 1);
    let values: Vec<f64> = (0..5000).map(|_| sensor.read(&environment(Gas::N2, 1e3), Drive::On, 0.01)).collect();
    let mean = values.iter().sum::<f64>() / 5000.0;
    let deviation = (values.iter().map(|value| (value - mean).powi(2)).sum::<f64>() / 5000.0).sqrt();
    assert!((deviation / (3e-5 * range.highest_pa) - 1.0).abs() < 0.05, "{deviation} Pa");
}

#[test]
fn the_same_seed_gives_the_same_sensor_with_any_steps() {
    for (principle, range) in PRINCIPLES {
        let run = |seed, steps: u32| {
            let mut sensor = Sensor::real(principle, range, seed);
            let environment = environment(Gas::Ar, 0.3);
            sensor.read(&environment, LOW_EMISSION, 0.0);
            (0..steps).map(|_| sensor.read(&environment, LOW_EMISSION, 3600.0 / f64::from(steps))).last().unwrap()
        };
        let once = run(3, 1);
        assert_eq!(once, run(3, 1), "{principle:?}");
        assert!((once / run(3, 360) - 1.0).abs() < 1e-6, "{principle:?}");
        assert_ne!(once, run(4, 1), "{principle:?}");
    }
}

#[test]
fn the_response_to_a_pressure_step_has_the_lag_of_the_principle() {
    for (principle, range, lag_s) in
        [(Principle::Pirani, PRINCIPLES[0].1, 0.08), (Principle::Diaphragm, PRINCIPLES[1].1, 0.03)]
    {
        let mut sensor = Sensor::real(principle, range, 5);
        let imperfections = sensor.imperfections_mut().unwrap();
        assert_eq!(imperfections.lag_s, lag_s);
        *imperfections =
            Imperfections { gain: 1.0, zero_pa: 0.0, noise: 0.0, floor_pa: 0.0, drift_pa: 0.0, ..*imperfections };
        sensor.read(&environment(Gas::N2, 0.0), Drive::On, 1.0);
        assert_eq!(sensor.read(&environment(Gas::N2, 100.0), Drive::On, 0.0), 0.0);
        let after = sensor.read(&environment(Gas::N2, 100.0), Drive::On, lag_s);
        assert!((after - 63.212).abs() < 1e-3, "{principle:?}: {after}");
        sensor.settle();
        assert_eq!(sensor.read(&environment(Gas::N2, 100.0), Drive::On, 0.0), 100.0);
    }
}

/// The lag of the signal must not show an ultra-high vacuum while the discharge ignites.
#[test]
fn a_cold_cathode_never_indicates_less_than_the_pressure_while_it_ignites() {
    let (principle, range) = PRINCIPLES[3];
    for seed in 0..20 {
        let mut sensor = Sensor::real(principle, range, seed);
        let read: Vec<f64> = (0..10_000).map(|_| sensor.read(&environment(Gas::N2, 2e-4), Drive::On, 1e-3)).collect();
        let first = read.iter().position(|pa| *pa > 0.0).unwrap();
        assert!(read[..first].iter().all(|pa| *pa == 0.0));
        assert!(read[first..].iter().all(|pa| *pa > 1e-4), "{:e}", read[first]);
    }
}

#[test]
fn a_head_is_heated_by_request() {
    let (principle, range) = PRINCIPLES[1];
    let read = |mut sensor: Sensor, heated: bool| {
        if let Some(imperfections) = sensor.imperfections_mut() {
            *imperfections =
                Imperfections { gain: 1.0, zero_pa: 0.0, noise: 0.0, floor_pa: 0.0, drift_pa: 0.0, ..*imperfections };
        }
        if heated {
            sensor.heat_head(373.15);
        }
        sensor.read(&environment(Gas::N2, 1e-2), Drive::On, 1.0) / 1e-2
    };
    assert_eq!(read(Sensor::real(principle, range, 1), false), 1.0);
    assert!((1.10..1.13).contains(&read(Sensor::real(principle, range, 1), true)));
    assert_eq!(read(Sensor::ideal(principle, range), true), 1.0);
}

#[test]
fn extreme_inputs_give_finite_indications() {
    for (principle, range) in PRINCIPLES {
        for pa in [0.0, 1e-14, 1e7] {
            let mut sensor = Sensor::real(principle, range, 9);
            for drive in [Drive::Off, Drive::On, LOW_EMISSION] {
                for seconds in [0.0, 1e-6, 1e7] {
                    let read = sensor.read(&environment(Gas::He, pa), drive, seconds);
                    assert!(read.is_finite(), "{principle:?} at {pa} Pa: {read}");
                }
            }
        }
    }
}
