//! Pump-downs compared with the usual ones: the time to each decade of pressure against the last ten.
//!
//! The statistic is robust: the median of the logarithms of the times, and as spread the largest of 1.4826 times the median of the
//! absolute deviations, the 80th percentile of the absolute deviations over 1.28, and 2 %. A time deviates if its logarithm differs from
//! the median by more spreads than `SPREADS` has for the number of pump-downs. With noise of any size one level of one pump-down in
//! ten thousand deviates by chance (calculated with normal noise).

use super::find::PumpDown;
use super::trace::Trace;
use super::{Crossing, crossing};
use profivac_recorder::Micros;
use serde::Serialize;
use std::collections::VecDeque;

/// The levels, as decades of mbar.
const DECADES: std::ops::RangeInclusive<i32> = -11..=2;

/// How many pump-downs are the usual ones.
pub const USUAL_RUNS: usize = 10;

/// The limit in spreads for at least this number of pump-downs. Fewer than five are not compared.
const SPREADS: [(usize, f64); 4] = [(10, 8.0), (8, 10.0), (6, 12.0), (5, 15.0)];

/// The least spread, of the logarithm: 2 %. chosen: no pump is steadier, and a limit below 16 % would tell of small things.
const LEAST_SPREAD: f64 = 0.02;

/// The limit against a single chosen pump-down, of the logarithm. chosen
const SINGLE_LIMIT: f64 = 0.16;

/// Pump-downs are of one kind if they begin within this distance, in decades: not one from air and one from 1 mbar. chosen
const SAME_START: f64 = 0.5;

/// A level needs this distance from the initial pressure, in decades. chosen: half of the first decade belongs to the valve.
const BELOW_START: f64 = 0.5;

/// The shortest time that is compared, in s. chosen: several samples
const SHORTEST_S: f64 = 2.0;

/// A pump-down with the times at which it reached each decade.
#[derive(Clone, Debug, PartialEq)]
pub struct Run {
    /// The beginning.
    pub start: Micros,
    /// The last sample, or the venting.
    pub end: Micros,
    /// The pressure at the beginning, in Pa.
    pub start_pa: f64,
    /// The lowest pressure, in Pa.
    pub lowest_pa: f64,
    /// Whether a venting ended it.
    pub is_vented: bool,
    /// The time from the beginning to the next sample in s: so uncertain is the beginning.
    pub start_gap_s: f64,
    /// Pressures in Pa and the seconds to them, the highest pressure first. A pressure in a gap is left out.
    pub reached: Vec<(f64, f64)>,
}

impl Run {
    /// The times of a pump-down. The trace begins with it.
    #[must_use]
    pub fn new(one: &PumpDown, trace: &Trace) -> Self {
        let levels = DECADES.rev().map(|decade| 100.0 * 10_f64.powi(decade));
        let below = one.start_pa * 10_f64.powf(-BELOW_START);
        let reached = levels.filter(|pa| *pa < below).filter_map(|pa| match crossing(trace, pa) {
            Crossing::Reached { s } if s >= SHORTEST_S => Some((pa, s)),
            _ => None,
        });
        let first = trace.valid().next().and_then(|section| section.points.iter().find(|(s, _)| *s > 0.0));
        Self {
            start_gap_s: first.map_or(0.0, |(s, _)| *s),
            start: one.span.start,
            end: one.span.end,
            start_pa: one.start_pa,
            lowest_pa: one.lowest_pa,
            is_vented: one.is_vented,
            reached: reached.collect(),
        }
    }

    /// The time to a pressure in s.
    #[must_use]
    pub fn time_to(&self, pa: f64) -> Option<f64> {
        self.reached.iter().find(|(level, _)| (level / pa - 1.0).abs() < 1e-9).map(|(_, s)| *s)
    }

    /// The duration in s.
    #[must_use]
    pub fn seconds(&self) -> f64 {
        self.end.0.saturating_sub(self.start.0) as f64 / Micros::SECOND as f64
    }

    fn is_like(&self, other: &Self) -> bool {
        (self.start_pa / other.start_pa).log10().abs() <= SAME_START
    }
}

/// The usual time to a pressure.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Usual {
    /// The median, in s.
    pub s: f64,
    /// A shorter time deviates, in s.
    pub least_s: f64,
    /// A longer time deviates, in s.
    pub most_s: f64,
    /// The number of pump-downs.
    pub runs: usize,
}

impl Usual {
    /// The usual time of some times in s; `None` if they are fewer than five.
    #[must_use]
    pub fn of(times: &[f64]) -> Option<Self> {
        let (_, spreads) = SPREADS.into_iter().find(|(runs, _)| times.len() >= *runs)?;
        let mut logs: Vec<f64> = times.iter().map(|s| s.ln()).collect();
        let middle = median(&mut logs);
        let mut away: Vec<f64> = logs.iter().map(|log| (log - middle).abs()).collect();
        let by_median = 1.4826 * median(&mut away);
        let by_fifths = away.get(away.len() * 4 / 5).map_or(0.0, |far| far / 1.2816);
        let limit = spreads * by_median.max(by_fifths).max(LEAST_SPREAD);
        Some(Self::around(middle, limit, times.len()))
    }

    /// A single chosen time.
    fn single(s: f64) -> Self {
        Self::around(s.ln(), SINGLE_LIMIT, 1)
    }

    fn around(middle: f64, limit: f64, runs: usize) -> Self {
        Self { s: middle.exp(), least_s: (middle - limit).exp(), most_s: (middle + limit).exp(), runs }
    }

    /// The same with limits that are at least this far away, in s.
    fn widened(self, s: f64) -> Self {
        Self { least_s: self.least_s.min(self.s - s), most_s: self.most_s.max(self.s + s), ..self }
    }

    fn deviation(&self, s: f64, is_reached: bool) -> Option<Direction> {
        if s > self.most_s {
            Some(Direction::Later)
        } else if is_reached && s < self.least_s {
            Some(Direction::Earlier)
        } else {
            None
        }
    }
}

/// The median; the values are sorted.
fn median(values: &mut [f64]) -> f64 {
    values.sort_by(f64::total_cmp);
    let half = values.len() / 2;
    let upper = values.get(half).copied().unwrap_or(f64::NAN);
    let lower = values.get(half.saturating_sub(1)).copied().unwrap_or(upper);
    if values.len().is_multiple_of(2) { f64::midpoint(lower, upper) } else { upper }
}

/// The direction of a deviation.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Direction {
    /// Later than usual, or not yet reached after the longest usual time.
    Later,
    /// Earlier than usual.
    Earlier,
}

impl Direction {
    /// Its word.
    #[must_use]
    pub const fn word(self) -> &'static str {
        match self {
            Self::Later => "later",
            Self::Earlier => "earlier",
        }
    }
}

/// One level of a pump-down beside the usual time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Level {
    /// The pressure, in Pa.
    pub pa: f64,
    /// The time to it in s; `None` if it was not reached.
    pub s: Option<f64>,
    /// The usual time; `None` if too few pump-downs have reached it.
    pub usual: Option<Usual>,
    /// Whether and how it deviates.
    pub deviation: Option<Direction>,
}

/// Where a pump-down deviates.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Pattern {
    /// At every compared level.
    FromTheBeginning,
    /// At low pressure only.
    AtLowPressure,
    /// At high pressure only.
    AtHighPressure,
}

/// A pump-down beside the usual ones.
#[derive(Clone, Debug, PartialEq)]
pub struct Comparison {
    /// The pump-down.
    pub run: Run,
    /// Its levels, the highest pressure first.
    pub levels: Vec<Level>,
    /// The beginning of the first of the deviating pump-downs in a row that end with this one.
    pub since: Option<Micros>,
}

impl Comparison {
    /// The first level that deviates.
    #[must_use]
    pub fn first(&self) -> Option<&Level> {
        self.levels.iter().find(|level| level.deviation.is_some())
    }

    /// The last level that deviates: the lowest pressure.
    #[must_use]
    pub fn last(&self) -> Option<&Level> {
        self.levels.iter().rev().find(|level| level.deviation.is_some())
    }

    /// Where it deviates; `None` if it does not.
    #[must_use]
    pub fn pattern(&self) -> Option<Pattern> {
        let compared: Vec<bool> =
            self.levels.iter().filter(|level| level.usual.is_some()).map(|level| level.deviation.is_some()).collect();
        if !compared.contains(&true) {
            return None;
        }
        match (compared.first(), compared.last()) {
            (Some(true), Some(true)) => Some(Pattern::FromTheBeginning),
            (Some(true), _) => Some(Pattern::AtHighPressure),
            _ => Some(Pattern::AtLowPressure),
        }
    }

    fn of(run: &Run, usual: impl Fn(f64) -> Option<Usual>) -> Self {
        let below = run.start_pa * 10_f64.powf(-BELOW_START);
        let levels = DECADES.rev().map(|decade| 100.0 * 10_f64.powi(decade)).filter(|pa| *pa < below);
        let levels = levels.filter_map(|pa| {
            let (s, usual) = (run.time_to(pa), usual(pa));
            // A level that lies in a gap is neither reached nor late.
            let waited = s.or_else(|| (run.lowest_pa > pa).then(|| run.seconds()));
            let deviation = usual.zip(waited).and_then(|(usual, waited)| usual.deviation(waited, s.is_some()));
            (s.is_some() || usual.is_some()).then_some(Level { pa, s, usual, deviation })
        });
        Self { run: run.clone(), levels: levels.collect(), since: None }
    }
}

/// Compares pump-downs in the order of time, each with the last ten usual ones before it. Ten deviating ones in a row are the new
/// usual ones.
#[must_use]
pub fn compare(runs: &[Run]) -> Vec<Comparison> {
    let mut usual: VecDeque<&Run> = VecDeque::new();
    let mut deviating: Vec<&Run> = Vec::new();
    let mut compared = Vec::new();
    for run in runs {
        let alike: Vec<&Run> = usual.iter().copied().filter(|past| past.is_like(run)).collect();
        let gap_s = run.start_gap_s + alike.iter().map(|past| past.start_gap_s).fold(0.0, f64::max);
        let times = |pa: f64| {
            let times: Vec<f64> = alike.iter().filter_map(|past| past.time_to(pa)).collect();
            Usual::of(&times).map(|usual| usual.widened(gap_s))
        };
        let mut comparison = Comparison::of(run, times);
        if comparison.first().is_some() {
            deviating.push(run);
            comparison.since = deviating.first().map(|first| first.start);
            if deviating.len() >= USUAL_RUNS {
                usual.clear();
                usual.extend(deviating.drain(..));
            }
        } else {
            deviating.clear();
            usual.push_back(run);
        }
        // Of each kind at most ten: those of other kinds stay, so that one pump-down from 1 mbar does not displace one from air.
        while usual.iter().filter(|past| past.is_like(run)).count() > USUAL_RUNS
            && let Some(oldest) = usual.iter().position(|past| past.is_like(run))
        {
            usual.remove(oldest);
        }
        compared.push(comparison);
    }
    compared
}

/// Compares pump-downs with a chosen one.
#[must_use]
pub fn compare_with(reference: &Run, runs: &[Run]) -> Vec<Comparison> {
    let compared = |run: &Run| {
        let gap_s = run.start_gap_s + reference.start_gap_s;
        Comparison::of(run, |pa| reference.time_to(pa).map(|s| Usual::single(s).widened(gap_s)))
    };
    runs.iter().map(compared).collect()
}

#[cfg(test)]
mod tests {
    use super::super::find::find;
    use super::*;
    use profivac_recorder::{Quality, Sample};

    /// A number with the normal distribution.
    fn normal(random: &mut fastrand::Rng) -> f64 {
        let (radius, turn) = ((-2.0 * (1.0 - random.f64()).ln()).sqrt(), std::f64::consts::TAU * random.f64());
        radius * turn.cos()
    }

    /// A chamber of 100 l: a roughing pump, then outgassing over a turbo, and a leak.
    #[derive(Clone, Copy)]
    struct Plant {
        tau_s: f64,
        /// The pressure of outgassing after an hour, and that of a leak, in Pa.
        outgassing_pa: f64,
        leak_pa: f64,
    }

    const CLEAN: Plant = Plant { tau_s: 20.0, outgassing_pa: 1e-4, leak_pa: 1e-6 };

    impl Plant {
        fn pa(&self, s: f64) -> f64 {
            1e5 * (-s / self.tau_s).exp() + self.outgassing_pa * 3600.0 / (s + 1.0) + self.leak_pa
        }

        /// A pump-down of four hours, as a recorder with a deadband has it, with 1 % noise.
        fn run(&self, day: i64, random: &mut fastrand::Rng) -> Run {
            let start = day * 86_400 * Micros::SECOND;
            let at = |s: f64| Micros(start + (s * 1e6) as i64);
            let mut samples: Vec<Sample> =
                (0..20).map(|s| Sample::new(at(f64::from(s) - 20.0), Some(1e5), Quality::Valid)).collect();
            let mut s = 0.0;
            while s < 14_400.0 {
                let pa = self.pa(s) * (1.0 + 0.01 * normal(random));
                samples.push(Sample::new(at(s), Some(pa), Quality::Valid));
                s += (s * 0.01).clamp(1.0, 60.0);
            }
            let found = find(&samples, 0);
            let one = found.last().unwrap();
            Run::new(one, &Trace::new(&samples, one.span))
        }
    }

    /// A plant whose speed and outgassing vary from run to run.
    fn varied(plant: Plant, sigma: f64, random: &mut fastrand::Rng) -> Plant {
        Plant {
            tau_s: plant.tau_s * (0.3 * sigma * normal(random)).exp(),
            outgassing_pa: plant.outgassing_pa * (sigma * normal(random)).exp(),
            ..plant
        }
    }

    /// Whether it deviates since the pump-down of this day. With noise the top may end some seconds early.
    fn is_since(one: &Comparison, day: i64) -> bool {
        one.since.is_some_and(|since| since.0.abs_diff(day * 86_400 * Micros::SECOND) < 30 * Micros::SECOND as u64)
    }

    /// The first level with a deviation, in mbar, for each of the runs.
    fn deviations(runs: &[Run]) -> Vec<Option<f64>> {
        compare(runs).iter().map(|one| one.first().map(|level| level.pa / 100.0)).collect()
    }

    #[test]
    fn two_hundred_normal_runs_have_no_deviation_whatever_their_noise() {
        for (seed, sigma) in [(1, 0.0), (2, 0.02), (3, 0.05), (4, 0.1), (5, 0.2), (6, 0.4)] {
            let mut random = fastrand::Rng::with_seed(seed);
            let runs: Vec<Run> = (0..200).map(|day| varied(CLEAN, sigma, &mut random).run(day, &mut random)).collect();
            assert!(runs.iter().all(|run| run.reached.len() >= 6), "{:?}", runs[0]);
            let wrong = deviations(&runs).iter().filter(|found| found.is_some()).count();
            assert_eq!(wrong, 0, "with a variation of {sigma}");
        }
    }

    /// Outgassing a third larger makes 1e-5 mbar a third later: twenty minutes instead of an hour, as known from the plant.
    #[test]
    fn a_known_deviation_is_found_in_each_of_fifty_trials() {
        for trial in 0..50 {
            let mut random = fastrand::Rng::with_seed(100 + trial);
            let mut runs: Vec<Run> =
                (0..12).map(|day| varied(CLEAN, 0.02, &mut random).run(day, &mut random)).collect();
            let wet = Plant { outgassing_pa: 1.4e-4, leak_pa: 1e-6, ..CLEAN };
            runs.push(wet.run(12, &mut random));
            let compared = compare(&runs);
            let last = compared.last().unwrap();
            let level = last.levels.iter().find(|level| (level.pa / 1e-4 - 1.0).abs() < 1e-6).unwrap();
            assert_eq!(level.deviation, Some(Direction::Later), "trial {trial}: {level:?}");
            let later = level.s.unwrap() - level.usual.unwrap().s;
            // 0.4 of 3636 s.
            assert!((later / 1454.0 - 1.0).abs() < 0.15, "trial {trial}: {later}");
            assert_eq!(last.pattern(), Some(Pattern::AtLowPressure), "trial {trial}");
            assert!(is_since(last, 12), "trial {trial}: {:?}", last.since);
            assert!(compared.iter().rev().skip(1).all(|one| one.first().is_none()), "trial {trial}");
        }
    }

    #[test]
    fn a_slow_roughing_pump_deviates_from_the_beginning_and_a_small_change_does_not() {
        let mut random = fastrand::Rng::with_seed(7);
        let mut runs: Vec<Run> = (0..10).map(|day| varied(CLEAN, 0.02, &mut random).run(day, &mut random)).collect();
        let changed = [(1.5, Some(Direction::Later)), (0.6, Some(Direction::Earlier)), (1.05, None)];
        for (slower, expected) in changed {
            runs.push(Plant { tau_s: CLEAN.tau_s * slower, ..CLEAN }.run(11, &mut random));
            let compared = compare(&runs);
            let last = compared.last().unwrap();
            assert_eq!(last.first().and_then(|level| level.deviation), expected, "{slower}");
            if expected.is_some() {
                // Below 1e-3 mbar the outgassing counts and not the pump.
                assert_eq!(last.pattern(), Some(Pattern::AtHighPressure));
            }
            runs.pop();
        }
    }

    #[test]
    fn a_level_that_is_not_reached_is_late_after_the_longest_usual_time() {
        let mut random = fastrand::Rng::with_seed(8);
        let mut runs: Vec<Run> = (0..10).map(|day| CLEAN.run(day, &mut random)).collect();
        runs.push(Plant { leak_pa: 1e-3, ..CLEAN }.run(10, &mut random));
        let compared = compare(&runs);
        let level = compared.last().unwrap().last().unwrap();
        assert!((level.pa / 1e-4 - 1.0).abs() < 1e-6 && level.s.is_none(), "{level:?}");
        assert_eq!(level.deviation, Some(Direction::Later));
        // Half of the time: neither reached nor late.
        let mut short = runs.pop().unwrap();
        short.end = Micros(short.start.0 + 1800 * Micros::SECOND);
        short.reached.retain(|(_, s)| *s < 1800.0);
        runs.push(short);
        let compared = compare(&runs);
        let level = *compared.last().unwrap().levels.iter().find(|level| level.pa < 1.1e-4).unwrap();
        assert_eq!((level.s, level.deviation), (None, None));
    }

    #[test]
    fn a_lasting_change_is_told_since_its_first_day_and_usual_after_ten() {
        let mut random = fastrand::Rng::with_seed(9);
        let wet = Plant { outgassing_pa: 2e-4, ..CLEAN };
        let plants = (0..10).map(|_| CLEAN).chain((0..12).map(|_| wet));
        let runs: Vec<Run> = plants.enumerate().map(|(day, plant)| plant.run(day as i64, &mut random)).collect();
        let compared = compare(&runs);
        assert!(compared[..10].iter().all(|one| one.since.is_none()));
        assert!(compared[10..20].iter().all(|one| is_since(one, 10)));
        assert!(compared[20..].iter().all(|one| one.since.is_none()));
    }

    #[test]
    fn four_runs_are_too_few_and_runs_from_another_pressure_are_of_another_kind() {
        let mut random = fastrand::Rng::with_seed(10);
        let mut runs: Vec<Run> = (0..4).map(|day| CLEAN.run(day, &mut random)).collect();
        runs.push(Plant { tau_s: 60.0, ..CLEAN }.run(4, &mut random));
        assert_eq!(deviations(&runs), [None; 5]);
        let mut runs: Vec<Run> = (0..10).map(|day| CLEAN.run(day, &mut random)).collect();
        let mut other = Plant { tau_s: 60.0, ..CLEAN }.run(11, &mut random);
        other.start_pa = 1e4;
        runs.push(other);
        assert_eq!(deviations(&runs).last(), Some(&None));
    }

    /// With a sample a minute the beginning is known to a minute.
    #[test]
    fn a_sparse_recording_of_the_beginning_is_no_deviation() {
        let mut random = fastrand::Rng::with_seed(13);
        let mut runs: Vec<Run> = (0..10).map(|day| CLEAN.run(day, &mut random)).collect();
        let mut sparse = CLEAN.run(10, &mut random);
        sparse.reached.iter_mut().for_each(|(_, s)| *s += 55.0);
        runs.push(sparse);
        assert!(deviations(&runs).last().unwrap().is_some());
        runs.last_mut().unwrap().start_gap_s = 60.0;
        assert_eq!(deviations(&runs).last(), Some(&None));
    }

    #[test]
    fn a_chosen_run_is_the_reference_of_all_others() {
        let mut random = fastrand::Rng::with_seed(11);
        let usual = CLEAN.run(0, &mut random);
        let runs = [CLEAN.run(1, &mut random), Plant { outgassing_pa: 2e-4, ..CLEAN }.run(2, &mut random)];
        let compared = compare_with(&usual, &runs);
        assert_eq!(compared[0].first(), None);
        assert_eq!(compared[1].first().and_then(|level| level.deviation), Some(Direction::Later));
        assert_eq!(compared[1].last().unwrap().usual.unwrap().runs, 1);
    }
}
