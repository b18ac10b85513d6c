//! Helium at a leak, recognised in records of the simulation and in random ones.

#![allow(clippy::unwrap_used, clippy::panic, reason = "a test")]

use profivac_identify::Interval;
use profivac_identify::rise::GasDependence;
use profivac_identify::spray::{LeakPressure, Spray, find, neutral_speeds, response};
use profivac_vacuum::network::{Outside, Supply};
use profivac_vacuum::pump::Capture;
use profivac_vacuum::{Atmosphere, Conductance, Gas, Mixture, Network};

fn normal(random: &mut fastrand::Rng) -> f64 {
    (0..12).map(|_| random.f64()).sum::<f64>() - 6.0
}

const GAUGES: [GasDependence; 3] = [GasDependence::None, GasDependence::Ionisation, GasDependence::Conduction];

/// When helium is sprayed, in s.
const SPRAYED_S: [f64; 2] = [300.0, 390.0];

const VOLUME_M3: f64 = 0.05;

/// A chamber with a pump, a leak, and hydrogen that enters steadily.
#[derive(Clone, Copy)]
struct Plant {
    /// The speed for air and for helium, in m³/s.
    speeds: [f64; 2],
    /// The flow of air through the leak, in Pa m³/s.
    leak: f64,
    /// The flow of hydrogen, in Pa m³/s.
    other: f64,
}

/// A leak of 1e-6 mbar l/s, with as much other gas.
const WELD: Plant = Plant { speeds: [0.005, 0.005], leak: 1e-7, other: 1e-7 };

impl Plant {
    fn indication(gas: &Mixture, gauge: GasDependence) -> f64 {
        gas.iter().map(|(gas, pa)| pa / gauge.factor(gas)).sum()
    }

    /// Fifteen minutes at the base pressure, as a gauge indicates them every second, with noise of 1 %.
    fn record(&self, gauge: GasDependence, seed: u64) -> Vec<(f64, f64)> {
        let mut random = fastrand::Rng::with_seed(seed);
        let mut network = Network::new(Atmosphere { humidity: 0.0, ..Atmosphere::default() });
        let chamber = network.add_volume(VOLUME_M3, Mixture::pure(Gas::N2, 1e-5));
        let [air, helium] = self.speeds;
        let mut speeds = Mixture::default();
        Gas::all().for_each(|gas| speeds[gas] = if gas == Gas::He { helium } else { air });
        let mut capacities = Mixture::default();
        Gas::all().for_each(|gas| capacities[gas] = 1e9);
        let pump = Capture { speeds, capacities, highest_pa: 1.0, running: true, captured: Mixture::default() };
        network.add_capture_pump(chamber, pump);
        let leak = network.add_opening(chamber, Conductance::leak(self.leak), Outside::Air);
        network.set_opening(leak, 1.0);
        let inlet = network.add_inlet(chamber, Gas::H2);
        network.set_inlet(inlet, Supply::Flow(self.other));
        network.advance(1000.0);
        let mut samples = Vec::new();
        for second in 0..900 {
            let t = f64::from(second);
            let noise = 1.0 + 0.01 * normal(&mut random);
            samples.push((t, Self::indication(&network.mixture(chamber), gauge) * noise));
            if SPRAYED_S.contains(&t) {
                let atmosphere_pa = network.atmosphere().pressure_pa;
                let helium = Outside::Gas(Mixture::pure(Gas::He, atmosphere_pa));
                network.set_outside(leak, if t < 350.0 { helium } else { Outside::Air });
            }
            network.advance(1.0);
        }
        samples
    }
}

/// The mean from a time to another.
fn mean(samples: &[(f64, f64)], from_s: f64, to_s: f64) -> f64 {
    let inside: Vec<f64> = samples.iter().filter(|(t, _)| (from_s..to_s).contains(t)).map(|(_, pa)| *pa).collect();
    inside.iter().sum::<f64>() / inside.len() as f64
}

/// The figures that docs/comparison.md states.
#[test]
fn the_response_to_helium_has_the_stated_sign_and_size() {
    let expected = [[-0.65, 1.69], [-0.94, -0.54], [-0.57, 2.36]];
    for (gauge, expected) in GAUGES.into_iter().zip(expected) {
        let found = response(gauge);
        assert!(found.iter().zip(expected).all(|(one, two)| (one - two).abs() < 0.006), "{gauge:?} {found:?}");
    }
    let [molecular, viscous] = neutral_speeds(GasDependence::Ionisation);
    assert!((molecular - 2.19).abs() < 0.01 && (viscous - 6.35).abs() < 0.05, "{molecular} {viscous}");
}

#[test]
fn helium_at_a_leak_is_recognised_with_times_size_and_leak_for_each_gauge() {
    for gauge in GAUGES {
        let samples = WELD.record(gauge, 1);
        let found = find(&samples);
        let [spray] = found[..] else { panic!("{gauge:?}: {found:?}") };
        let base = mean(&samples, 0.0, 300.0);
        let change = mean(&samples, 360.0, 390.0) - base;
        assert_eq!(change < 0.0, gauge == GasDependence::Ionisation, "{gauge:?}: {change}");
        let near = |interval: Interval, truth: f64, slack: f64| {
            interval.low - slack <= truth
                && truth <= interval.high + slack
                && interval.high - interval.low < 0.5 * truth.abs()
        };
        assert!(near(spray.change_pa, change, 0.03 * base), "{gauge:?}: {change:e} {spray:?}");
        assert!(near(spray.from_s, 300.0, 0.5) && near(spray.to_s, 390.0, 0.5), "{gauge:?}: {spray:?}");
        // V/S is 10 s.
        assert!(near(spray.tau_s, 10.0, 0.5), "{gauge:?}: {spray:?}");
        assert!((spray.base_pa / base - 1.0).abs() < 0.02 && spray.misfit < 1.5, "{gauge:?}: {spray:?}");
        let LeakPressure::Air(air) = spray.air_pa(gauge) else { panic!("{gauge:?}: {spray:?}") };
        let leak = air.scaled(WELD.speeds[0]);
        assert!(leak.contains(WELD.leak), "{gauge:?}: {leak:?}");
    }
}

/// An ion pump takes helium a tenth as fast: the air of the leak goes at once and the helium comes slowly, so the first change is a
/// fall too.
#[test]
fn with_an_ion_pump_the_first_fall_is_recognised() {
    let ion_pump = Plant { speeds: [0.005, 0.0005], ..WELD };
    let found = find(&ion_pump.record(GasDependence::Ionisation, 2));
    let [spray] = found[..] else { panic!("{found:?}") };
    let LeakPressure::Air(air) = spray.air_pa(GasDependence::Ionisation) else { panic!("{spray:?}") };
    assert!(air.scaled(0.005).contains(WELD.leak), "{spray:?}");
}

#[test]
fn a_rise_of_an_ion_gauge_is_another_gas_and_a_fall_by_everything_is_no_leak_alone() {
    let spray = |change: f64| Spray {
        from_s: Interval::normal(0.0, 0.1),
        to_s: Interval::normal(60.0, 0.1),
        tau_s: Interval::normal(5.0, 0.1),
        change_pa: Interval::normal(change, 0.01),
        base_pa: 1.0,
        misfit: 1.0,
    };
    assert_eq!(spray(0.5).air_pa(GasDependence::Ionisation), LeakPressure::OtherSign);
    assert_eq!(spray(-0.99).air_pa(GasDependence::Ionisation), LeakPressure::TooLarge);
    assert_eq!(spray(3.0).air_pa(GasDependence::Conduction), LeakPressure::TooLarge);
    // A Pirani that rises by a fifth: the leak is at least 8 % of its indication.
    let LeakPressure::Air(air) = spray(0.2).air_pa(GasDependence::Conduction) else { panic!() };
    assert!((air.low - 0.076).abs() < 0.002 && air.high == 1.0, "{air:?}");
}

/// A gas that comes and goes: start, end, time constant, height divided by the base.
#[derive(Clone, Copy, Debug)]
struct Pulse {
    from_s: f64,
    to_s: f64,
    tau_s: f64,
    height: f64,
}

impl Pulse {
    fn at(&self, t: f64) -> f64 {
        let filled = |s: f64| 1.0 - (-s.max(0.0) / self.tau_s).exp();
        let left = filled(t.min(self.to_s) - self.from_s) * (-(t - self.to_s).max(0.0) / self.tau_s).exp();
        1.0 + self.height * left
    }
}

/// The tail of a pump-down from an age of two hours, times a course, with noise, each second for twenty minutes.
fn tail(noise: f64, random: &mut fastrand::Rng, course: impl Fn(f64) -> f64) -> Vec<(f64, f64)> {
    let one = |t: f64| 1e-5 * 7200.0 / (7200.0 + t) * course(t) * (1.0 + noise * normal(random));
    (0..1200).map(f64::from).map(one).enumerate().map(|(t, pa)| (t as f64, pa)).collect()
}

/// The intervals of changes, times and time constants contain the truth about as often as they claim, and nearly all are found.
#[test]
fn the_intervals_of_two_hundred_random_sprays_contain_the_truth() {
    let mut counts = [0; 5];
    for seed in 0..200 {
        let mut random = fastrand::Rng::with_seed(seed);
        let tau_s = 2.0 * 20_f64.powf(random.f64());
        let from_s = 300.0 + 100.0 * random.f64();
        let pulse = Pulse {
            from_s,
            to_s: from_s + tau_s.max(10.0) * (1.0 + 4.0 * random.f64()),
            tau_s,
            height: if random.bool() { 1.0 } else { -0.4 } * (0.2 + 0.8 * random.f64()),
        };
        let samples = tail(0.01, &mut random, |t| pulse.at(t));
        let found = find(&samples);
        let [spray] = found[..] else { continue };
        let height = pulse.height * 1e-5 * 7200.0 / (7200.0 + pulse.to_s);
        let truths =
            [(spray.change_pa, height), (spray.from_s, pulse.from_s), (spray.to_s, pulse.to_s), (spray.tau_s, tau_s)];
        counts[0] += 1;
        for (count, (interval, truth)) in counts.iter_mut().skip(1).zip(truths) {
            *count += u32::from(interval.contains(truth));
        }
    }
    println!("found, change, start, end, time constant: {counts:?}");
    assert!(counts[0] >= 190, "{counts:?}");
    assert!(counts.iter().skip(1).all(|count| f64::from(*count) >= 0.9 * f64::from(counts[0])), "{counts:?}");
}

/// Courses without a spray: a quiet tail, a step, a burst, a slow wave, a ramp that ends at once, a rise that stays.
#[test]
fn nothing_is_recognised_where_no_gas_came_and_went() {
    type Course = fn(f64) -> f64;
    let courses: [(&str, Course); 8] = [
        ("quiet", |_| 1.0),
        ("step", |t| if t < 400.0 { 1.0 } else { 1.4 }),
        ("burst", |t| if t < 400.0 { 1.0 } else { 1.0 + 0.8 * (-(t - 400.0) / 15.0).exp() }),
        ("wave", |t| 1.0 + 0.03 * (t / 1200.0 * std::f64::consts::TAU).sin()),
        ("ramp", |t| if (400.0..500.0).contains(&t) { 1.0 + (t - 400.0) / 100.0 } else { 1.0 }),
        ("closed valve", |t| {
            let opened = 1.0 + 12.0 * (-(t - 600.0) / 4.0).exp();
            if t < 600.0 { 1.0 + (t - 400.0).max(0.0) / 200.0 * 12.0 } else { opened }
        }),
        ("closed valve and water", |t| {
            let filled = 4.0 * (1.0 - (-(t - 400.0_f64).max(0.0) / 60.0).exp());
            1.0 + filled * if t < 600.0 { 1.0 } else { (-(t - 600.0) / 10.0).exp() }
        }),
        ("rise", |t| 1.0 + (t - 400.0).max(0.0) / 100.0),
    ];
    for (name, course) in courses {
        for seed in 0..40 {
            let mut random = fastrand::Rng::with_seed(seed);
            let samples = tail(0.01, &mut random, course);
            let found = find(&samples);
            assert!(found.is_empty(), "{name}, seed {seed}: {found:?}");
        }
    }
}

#[test]
fn several_sprays_are_several_and_records_without_sense_have_none() {
    let mut random = fastrand::Rng::with_seed(5);
    let pulses = [200.0, 500.0, 800.0].map(|from_s| Pulse { from_s, to_s: from_s + 60.0, tau_s: 6.0, height: 0.5 });
    let samples = tail(0.005, &mut random, |t| pulses.iter().map(|pulse| pulse.at(t)).product());
    let found = find(&samples);
    assert_eq!(found.len(), 3, "{found:?}");
    for wrong in [vec![], vec![(0.0, 1.0); 100], vec![(0.0, f64::NAN); 100], vec![(1.0, -1.0); 50]] {
        assert_eq!(find(&wrong), []);
    }
    let backwards: Vec<(f64, f64)> = (0..200).map(|t| (f64::from(200 - t), 1.0)).collect();
    assert_eq!(find(&backwards), []);
}
