//! Tests against closed forms: the results must be the parameters of the model.

use super::*;
use profivac_identify::rise::Cause;
use profivac_recorder::{Deadband, Micros, Quality, Sample};
use std::time::Duration;

/// 1013.25 mbar.
const AIR: f64 = 101_325.0;

const START: Micros = Micros(1_795_000_000 * Micros::SECOND);

fn at(s: f64) -> Micros {
    START.after(Duration::from_secs_f64(s))
}

fn valid(s: f64, pa: f64) -> Sample {
    Sample::new(at(s), Some(pa), Quality::Valid)
}

/// Five samples a second, thinned by the default deadband.
fn recorded(seconds: f64, pressure: impl Fn(f64) -> f64) -> Vec<Sample> {
    let count = (seconds * 5.0) as u32;
    let all = (0..=count).map(|number| f64::from(number) / 5.0).map(|s| valid(s, pressure(s)));
    let mut filter = profivac_recorder::deadband::DeadbandFilter::default();
    let mut kept: Vec<_> = all.flat_map(|sample| filter.push(&Deadband::default(), sample)).collect();
    kept.extend(filter.flush());
    kept
}

fn whole(samples: &[Sample]) -> Trace {
    Trace::new(samples, TimeRange { start: samples[0].at, end: samples[samples.len() - 1].at })
}

#[track_caller]
fn near(found: f64, expected: f64, percent: f64) {
    assert!((found / expected - 1.0).abs() < percent / 100.0, "{found} is not {expected}");
}

#[track_caller]
fn reached(trace: &Trace, pa: f64) -> f64 {
    match crossing(trace, pa) {
        Crossing::Reached { s } => s,
        other => panic!("{pa}: {other:?}"),
    }
}

/// 100 l and 20 l/s: a time constant of 5 s, after 30 s at atmosphere.
fn exponential(s: f64) -> f64 {
    AIR * (-(s - 30.0).max(0.0) / 5.0).exp()
}

#[test]
fn the_end_of_a_range_behind_the_time_range_is_no_pressure() {
    let over = Sample::new(at(20.0), Some(1e5), Quality::Overrange);
    let samples = [valid(0.0, 1.0), valid(10.0, 1.0), over];
    let trace = Trace::new(&samples, TimeRange { start: at(0.0), end: at(15.0) });
    let [first, _, last] = trace.ends().unwrap();
    assert_eq!((first, last), ((0.0, 1.0), (10.0, 1.0)));
}

#[test]
fn an_exponential_fall_has_its_times_and_its_speed_within_a_percent() {
    let samples = recorded(120.0, exponential);
    let [found] = find(&samples, 0)[..] else { panic!("one") };
    assert!((time_range::seconds(at(30.0), found.span.start)).abs() < 0.25, "{:?}", found.span);
    let trace = Trace::new(&samples, found.span);
    for pa in [1e4, 1e3, 1e2, 1.0, 1e-2] {
        near(reached(&trace, pa), 5.0 * (AIR / pa).ln(), 1.0);
    }
    let falls = falls(&trace);
    let volume_l = 100.0;
    near(volume_l * quickest(&falls).unwrap().per_s, 20.0, 1.0);
    assert!(falls.len() > 60, "{} points over 7.8 decades", falls.len());
    for fall in falls.iter().skip(3) {
        near(volume_l * fall.per_s, 20.0, 2.0);
    }
}

#[test]
fn the_final_slope_of_metal_is_one_and_of_polymers_a_half() {
    for n in [1.0, 0.5] {
        let trace = whole(&recorded(10_000.0, |s| 1e-3 * (s + 1.0).powf(-n)));
        let slope = final_slope(&trace).unwrap();
        near(slope.exponent, n, 1.0);
        near(slope.tenth_s, 10_000.0 * 10_f64.powf(1.0 / n), 5.0);
        assert!(slope.error < 0.01);
    }
}

#[test]
fn a_constant_pressure_has_no_slope() {
    let trace = whole(&recorded(3_000.0, |_| 1e-5));
    assert!(final_slope(&trace).unwrap().exponent.abs() < 1e-6);
    assert_eq!(final_slope(&whole(&recorded(60.0, |_| 1e-5))), None);
}

/// A roughing pump with 2 l/s down to 10 Pa, a minute of waiting, then a turbopump with 50 l/s, on 100 l.
fn staged(s: f64) -> f64 {
    let rough = AIR * (-s / 50.0).exp();
    let after = (s - 600.0).max(0.0);
    if after > 0.0 { 1e-6 + 10.0 * (-after / 2.0).exp() } else { rough.max(10.0) }
}

#[test]
fn two_pump_stages_are_one_pump_down_with_two_speeds() {
    let samples = recorded(700.0, staged);
    assert_eq!(find(&samples, 0).len(), 1);
    let trace = whole(&samples);
    near(reached(&trace, 100.0), 50.0 * (AIR / 100.0).ln(), 1.0);
    near(reached(&trace, 1.0), 600.0 + 2.0 * 10_f64.ln(), 1.0);
    let falls = falls(&trace);
    near(100.0 * quickest(&falls).unwrap().per_s, 50.0, 3.0);
    let rough = falls.iter().find(|fall| fall.pa < 1e3).unwrap();
    near(100.0 * rough.per_s, 2.0, 3.0);
}

/// A pump-down, a venting within ten seconds, another pump-down.
fn vented(s: f64) -> f64 {
    match s {
        ..300.0 => (AIR * (-s / 5.0).exp()).max(1e-3),
        300.0..310.0 => 1e-3 * (AIR / 1e-3).powf((s - 300.0) / 10.0),
        310.0..400.0 => AIR,
        _ => (AIR * (-(s - 400.0) / 8.0).exp()).max(1e-2),
    }
}

#[test]
fn a_venting_ends_a_pump_down_and_another_one_begins() {
    let samples = recorded(700.0, vented);
    let found = find(&samples, 3);
    let spans: Vec<_> = found
        .iter()
        .map(|one| [one.span.start, one.span.end].map(|at| time_range::seconds(START, at).round()))
        .collect();
    assert_eq!(spans.len(), 2, "{found:?}");
    assert!(spans[0][0] < 1.0 && (299.0..=301.0).contains(&spans[0][1]), "{spans:?}");
    assert!((399.0..=401.0).contains(&spans[1][0]) && spans[1][1] >= 640.0, "{spans:?}");
    assert_eq!(found.iter().map(|one| (one.gauge, one.is_vented)).collect::<Vec<_>>(), [(3, true), (3, false)]);
}

#[test]
fn noise_of_five_percent_moves_times_and_speed_little() {
    let mut random = fastrand::Rng::with_seed(7);
    let samples: Vec<_> = (0..1_500)
        .map(|number| f64::from(number) / 5.0)
        .map(|s| valid(s, AIR * (-(s - 30.0).max(0.0) / 20.0).exp() * (1.0 + 0.1 * (random.f64() - 0.5))))
        .collect();
    let [found] = find(&samples, 0)[..] else { panic!("one") };
    assert!(time_range::seconds(at(30.0), found.span.start).abs() < 2.0, "{:?}", found.span);
    let trace = Trace::new(&samples, TimeRange { start: at(30.0), ..found.span });
    for pa in [1e3, 1.0] {
        near(reached(&trace, pa), 20.0 * (AIR / pa).ln(), 2.0);
    }
    let falls = falls(&trace);
    near(100.0 * quickest(&falls).unwrap().per_s, 5.0, 20.0);
}

#[test]
fn a_pressure_crossed_in_a_gap_has_the_times_of_the_gap() {
    let mut samples = recorded(100.0, |s| AIR * (-s / 5.0).exp());
    let level = 1e2;
    let passed = 5.0 * (AIR / level).ln();
    samples.retain(|sample| (time_range::seconds(START, sample.at) - passed).abs() > 4.0);
    samples.push(Sample::gap(at(passed - 3.9)));
    samples.sort_by_key(|sample| sample.at);
    let trace = whole(&samples);
    let Crossing::Between { from_s, to_s } = crossing(&trace, level) else { panic!("{:?}", crossing(&trace, level)) };
    assert!(from_s < passed && passed < to_s && to_s - from_s < 9.0, "{from_s} {to_s}");
    near(trace.seconds_of(Quality::Stale), 7.9, 5.0);
    near(reached(&trace, 1.0), 5.0 * AIR.ln(), 1.0);
}

#[test]
fn minutes_without_a_sample_are_a_gap() {
    let samples = [valid(0.0, AIR), valid(1.0, 1e4), valid(2.0, 9e3), valid(600.0, 1.0), valid(601.0, 0.9)];
    let trace = whole(&samples);
    assert_eq!(
        trace.sections.iter().map(|section| section.quality).collect::<Vec<_>>(),
        [Quality::Valid, Quality::Stale, Quality::Valid]
    );
    assert_eq!(crossing(&trace, 10.0), Crossing::Between { from_s: 2.0, to_s: 600.0 });
}

#[test]
fn a_pressure_above_the_range_has_no_exact_time() {
    let over = |s| Sample::new(at(s), Some(1.0), Quality::Overrange);
    let samples = [over(0.0), over(50.0), over(60.0), valid(60.2, 0.5), valid(100.0, 1e-3), valid(101.0, 1e-3)];
    let trace = whole(&samples);
    assert_eq!(crossing(&trace, 100.0), Crossing::Before { s: 60.2 });
    assert_eq!(crossing(&trace, 0.7), Crossing::Reached { s: 60.2 });
    near(reached(&trace, 1e-2), 60.2 + 39.8 * 50_f64.ln() / 500_f64.ln(), 0.1);
    assert_eq!(crossing(&trace, 1e-4), Crossing::Not);
}

/// A gauge that is switched over, or a chamber behind a valve: the first and the last decade were crossed at some time between two samples.
#[test]
fn a_jump_over_decades_has_the_times_of_both_samples() {
    let over = |s| Sample::new(at(s), Some(AIR), Quality::Overrange);
    let under = |s| Sample::new(at(s), Some(1e-6), Quality::Underrange);
    let between = Crossing::Between { from_s: 0.5, to_s: 1.125 };
    for samples in
        [[over(0.0), over(0.5), under(1.125), under(2.0)], [valid(0.0, AIR), valid(0.5, AIR), under(1.125), under(2.0)]]
    {
        let trace = whole(&samples);
        assert_eq!([1e4, 1.0, 1e-6].map(|pa| crossing(&trace, pa)), [between; 3], "{samples:?}");
    }
    let trace = whole(&[over(0.0), over(0.5), valid(1.125, 1e-3), valid(2.0, 1e-4)]);
    assert_eq!([1e4, 1e-3].map(|pa| crossing(&trace, pa)), [between; 2]);
}

#[test]
fn underrange_counts_as_reached_only_down_to_the_end_of_the_range() {
    let under = |s| Sample::new(at(s), Some(1e-3), Quality::Underrange);
    let samples = [valid(0.0, 1.0), valid(9.9, 2e-3), under(10.0), under(20.0)];
    let trace = whole(&samples);
    assert_eq!(crossing(&trace, 1e-3), Crossing::Reached { s: 10.0 });
    assert_eq!(crossing(&trace, 9e-4), Crossing::Unknown { since_s: 10.0, end_pa: 1e-3 });
}

/// Any time below the range may have been below the pressure, even if the gauge measures again at the end.
#[test]
fn a_time_below_the_range_leaves_open_whether_a_pressure_was_reached() {
    let under = |s| Sample::new(at(s), Some(1e-3), Quality::Underrange);
    let trace =
        whole(&[valid(0.0, 1.0), valid(9.9, 2e-3), under(10.0), under(20.0), valid(20.1, 2e-3), valid(30.0, 1.0)]);
    assert_eq!(crossing(&trace, 9e-4), Crossing::Unknown { since_s: 10.0, end_pa: 1e-3 });
    assert_eq!(crossing(&trace, 1e-3), Crossing::Reached { s: 10.0 });
    let measured = whole(&[valid(0.0, 1.0), valid(10.0, 2e-3), valid(20.0, 2e-3)]);
    assert_eq!(crossing(&measured, 9e-4), Crossing::Not);
}

#[test]
fn a_pressure_may_be_unreached_or_reached_from_the_beginning() {
    let trace = whole(&recorded(60.0, |s| 5.0 + 4.0 * (-s / 5.0).exp()));
    assert_eq!(crossing(&trace, 1.0), Crossing::Not);
    assert_eq!(crossing(&trace, 10.0), Crossing::Already);
    assert!(falls(&trace).is_empty() && find(&recorded(60.0, |s| 5.0 + 4.0 * (-s / 5.0).exp()), 0).is_empty());
}

#[test]
fn one_sample_or_none_is_no_pump_down() {
    let one = [valid(0.0, AIR)];
    assert!(find(&one, 0).is_empty());
    let trace = whole(&one);
    assert_eq!((crossing(&trace, 1.0), falls(&trace).len(), final_slope(&trace)), (Crossing::Not, 0, None));
    assert_eq!(trace.ends(), Some([(0.0, AIR); 3]));
    let none = Trace::new(&[], TimeRange { start: START, end: at(1.0) });
    assert_eq!((none.ends(), crossing(&none, 1.0), pressure_rises(&none, &[]).len()), (None, Crossing::Not, 0));
}

#[test]
fn readings_without_a_pressure_count_neither_as_pressures_nor_as_crossings() {
    for quality in [Quality::Fault, Quality::Off, Quality::Missing, Quality::Stale] {
        let sample = |number: i32| Sample::new(at(f64::from(number)), Some(1.0), quality);
        let samples: Vec<_> = (0..100).map(sample).collect();
        assert!(find(&samples, 0).is_empty(), "{quality:?}");
        let trace = whole(&samples);
        assert_eq!((trace.ends(), crossing(&trace, 1e9)), (None, Crossing::Not), "{quality:?}");
        assert_eq!(trace.seconds_of(quality), 99.0, "{quality:?}");
    }
}

#[test]
fn the_gauge_that_measured_atmosphere_gives_the_beginning() {
    let pirani = recorded(400.0, |s| (AIR * (-s / 5.0).exp()).max(5e-2));
    let ion = recorded(400.0, |s| if s < 70.0 { 1.0 } else { (-(s - 70.0) / 12.0).exp().max(1e-7) });
    let found = [find(&ion, 0), find(&pirani, 1)].concat();
    assert_eq!(found.len(), 2);
    assert!(found[0].decades() > found[1].decades());
    let [one] = select(found)[..] else { panic!("one") };
    assert_eq!(one.gauge, 1);
}

#[test]
fn a_single_outlier_does_not_change_a_time() {
    let mut samples = recorded(100.0, |s| AIR * (-s / 5.0).exp());
    let index = samples.len() / 4;
    samples[index].pa = Some(1e-5);
    let trace = whole(&samples);
    near(reached(&trace, 1.0), 5.0 * AIR.ln(), 1.0);
}

#[test]
fn a_closed_valve_is_a_rise_with_its_leak_rate() {
    let leak = 2e-6;
    let samples = recorded(900.0, |s| match s {
        ..300.0 => (AIR * (-s / 5.0).exp()).max(1e-4),
        300.0..600.0 => 1e-4 + leak * (s - 300.0),
        _ => 1e-4 + leak * 300.0 * (-(s - 600.0) / 2.0).exp(),
    });
    let trace = whole(&samples);
    let rises = pressure_rises(&trace, &[0.0]);
    let [rise] = rises[..] else { panic!("{rises:?}") };
    near(rise.from_s, 300.0, 2.0);
    near(rise.to_s, 600.0, 2.0);
    near(rise.pumped_s.unwrap(), 300.0, 1.0);
    let fit = rise.fit.unwrap();
    let found = fit.leak_pa_per_s;
    assert!(found.contains(leak) && found.low >= 0.97 * leak, "{found:?}");
    near(found.mean, leak, 1.0);
    assert_eq!(fit.cause, Cause::Leak);
    assert_eq!(find(&samples, 0).len(), 1);
}

/// 20 l with outgassing behind a pump of 200 l/s that starts slowly: the fall shows a tenth of its speed, the rise all of it.
#[test]
fn a_rise_gives_the_speed_that_a_fall_hides() {
    let (speed, volume, gas) = (0.2, 0.02, |s: f64| 1e-6 * 3_600.0 / s);
    let closed = 3_000.0;
    let samples = recorded(3_600.0, |s| {
        let base = gas(s.max(60.0)) / speed;
        if s < closed {
            AIR * (-s / 20.0).exp() + base
        } else {
            base + gas(closed) * closed * (s / closed).ln() / volume
        }
    });
    let trace = whole(&samples);
    let fastest = quickest(&falls(&trace)).unwrap().per_s * volume;
    assert!(fastest < 0.01 * speed, "{fastest}");
    let rises = pressure_rises(&trace, &[0.0]);
    let [rise] = rises[..] else { panic!("{rises:?}") };
    near(rise.fit.unwrap().pumped_per_s.unwrap() * volume, speed, 6.0);
}

#[test]
fn the_next_sample_gives_the_value_at_the_end() {
    let invalid = |s| Sample::new(at(s), None, Quality::Fault);
    let span = |end| TimeRange { start: at(0.0), end: at(end) };
    let lost = [valid(0.0, 1.0), invalid(1.0), invalid(55.0)];
    assert_eq!(Trace::new(&lost, span(40.0)).seconds_of(Quality::Fault), 39.0);
    let falling = [valid(0.0, 100.0), valid(50.0, 1.0)];
    let trace = Trace::new(&falling, span(25.0));
    near(trace.ends().unwrap()[2].1, 10.0, 0.1);
    assert_eq!(Trace::new(&[valid(0.0, 100.0), valid(500.0, 1.0)], span(25.0)).ends(), Some([(0.0, 100.0); 3]));
}

#[test]
fn the_sample_before_gives_the_value_at_the_beginning() {
    let samples = [valid(0.0, 500.0), valid(50.0, 400.0), valid(51.0, 4.0), valid(52.0, 3.0)];
    let trace = Trace::new(&samples, TimeRange { start: at(10.0), end: at(52.0) });
    assert_eq!(trace.sections[0].points[0], (0.0, 500.0));
    assert_eq!(trace.samples, 3);
}

#[test]
fn noise_at_the_end_of_a_range_is_no_speed() {
    // Three high samples, then three low ones, with a falling floor: a median of five does not remove this noise.
    let floor = |number: i32| if number / 3 % 2 == 0 { 1e-2 } else { 5e-3 * (-f64::from(number) / 400.0).exp() };
    let pressure = |number: i32| AIR * (-f64::from(number) / 50.0).exp() + floor(number);
    let samples: Vec<_> = (0..2_000).map(|number| valid(f64::from(number) / 5.0, pressure(number))).collect();
    near(100.0 * quickest(&falls(&whole(&samples))).unwrap().per_s, 10.0, 50.0);
}

/// Samples of every quality, with any pressure that fits into a 32-bit float, and with intervals from a microsecond to years.
fn odd(random: &mut fastrand::Rng) -> Vec<Sample> {
    let (mut now, count) = (START.0, random.usize(1..200));
    let sample = |_| {
        now += 10_i64.pow(random.u32(0..14));
        let exponent = if random.bool() { random.f64() * 83.0 - 45.0 } else { random.f64() * 4.0 };
        let quality = Quality::ALL[[0, 0, 0, 0, 1, 2, 3, 4][random.usize(0..8)]];
        Sample::new(Micros(now), Some(10_f64.powf(exponent)), quality)
    };
    (0..count).map(sample).collect()
}

#[test]
fn results_for_random_samples_are_finite_numbers() {
    let mut random = fastrand::Rng::with_seed(5);
    let (mut found_any, mut fallen) = (0, 0);
    for _ in 0..2_000 {
        let samples = odd(&mut random);
        let found = find(&samples, 0);
        let spans = found.iter().map(|one| one.span).chain([TimeRange { start: START, end: at(1e9) }]);
        for span in spans {
            let trace = Trace::new(&samples, span);
            let inside = |s: f64| (0.0..=span.seconds()).contains(&s);
            for pa in [1e-46, 1e-6, 1.0, 1e39] {
                match crossing(&trace, pa) {
                    Crossing::Reached { s } | Crossing::Before { s } | Crossing::Unknown { since_s: s, .. } => {
                        assert!(inside(s), "{s}")
                    }
                    Crossing::Between { from_s, to_s } => assert!(inside(from_s) && inside(to_s) && from_s <= to_s),
                    Crossing::Already | Crossing::Not => {}
                }
            }
            let falls = falls(&trace);
            assert!(falls.iter().all(|fall| inside(fall.s) && fall.pa.is_finite() && fall.per_s.is_finite()));
            assert!(pressure_rises(&trace, &[]).iter().all(|rise| rise.from_s <= rise.to_s && rise.to_pa.is_finite()));
            assert!(final_slope(&trace).is_none_or(|slope| slope.exponent.is_finite() && slope.error.is_finite()));
            fallen += falls.len();
        }
        assert!(found.iter().all(|one| one.decades() >= 2.0 && one.span.start < one.span.end), "{found:?}");
        found_any += found.len();
    }
    assert!(found_any > 1_000 && fallen > 1_000, "{found_any} pump-downs and {fallen} falls are too few for this test");
}
