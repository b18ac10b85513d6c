//! The least squares of a plant: its unknowns, their bounds, and Levenberg and Marquardt's method (MINPACK).

use super::model::{Numbers, State};
use super::number::{Dual, Number};
use super::record::{Group, NotIdentified, PlantRecord, Volume};
use levenberg_marquardt::{LeastSquaresProblem, LevenbergMarquardt};
use nalgebra::storage::Owned;
use nalgebra::{DMatrix, DVector, Dyn};

const HOUR_S: f64 = 3600.0;

/// The decades of pressure between two knots of the pumping speed, and the most knots.
const DECADES: f64 = 2.0;
const MOST_KNOTS: usize = 6;

/// The places of the unknowns; those behind them are the speeds at the knots, and the volume if it is not known.
pub(super) const LEAK: usize = 0;
pub(super) const OUTGASSING: usize = 1;
pub(super) const EXPONENT: usize = 2;
pub(super) const ULTIMATE: usize = 3;
const SHARE: usize = 4;
const RETURN: usize = 5;
const FIRST: usize = 6;
const OFFSET: usize = 7;
pub(super) const SPEEDS: usize = 8;

/// The usual values of unknowns that many records do not determine, each with a standard deviation. The exponent is near 1 for
/// metals and 1/2 for polymers; the share that does not return to the wall is anything from 0 to 1, and the logarithm of the time
/// constant of the return is wide. A wall begins to outgas within seconds of the start of the pump-down, or within a minute.
/// chosen
const USUAL: [(usize, f64, f64); 4] =
    [(EXPONENT, 1.0, 0.3), (SHARE, 0.5, 0.5), (RETURN, 10.0, 3.0), (OFFSET, 0.0, 3.0)];

/// The relative change of the sum of squares at which a fit ends.
pub(super) const EXACT: f64 = 1e-9;

/// The relative change at which a fit ends that is only compared with others: of a beginning, or beside a bound.
pub(super) const ROUGH: f64 = 1e-5;

/// The derivatives that one calculation of the model has: of all unknowns of a plant, or of those held at a bound, which are few.
const MANY: usize = 16;
const FEW: usize = 4;
const _: () = assert!(SPEEDS + MOST_KNOTS < MANY, "all unknowns, and the volume");

/// The least logarithm of the outgassing after an hour: a flow of one molecule a second, kT = 4.05e-21 Pa m³ at 20 °C. Without a bound
/// the fit of a record that shows no outgassing ends at a flow that is zero in floating point, where nothing depends on it any more and
/// the interval would be a single number.
const LEAST_OUTGASSING: f64 = -47.0;

/// How often an unknown is released from a bound in one fit.
const RELEASES: u32 = 3;

/// The most evaluations of a fit for each unknown. Where a fit of 25 random plants ended by itself it needed 16 at most; one walked for
/// 100 along a valley that is flat within the steps of the calculation. chosen
const MOST_EVALUATIONS: usize = 30;

/// The values that an unknown can have. Leak and ultimate pressure may not be negative, the exponent is that of a real wall. At a
/// bound the derivative is that of the values within: beyond it the numbers of a plant do not change.
const fn bounds(index: usize) -> [f64; 2] {
    match index {
        LEAK | ULTIMATE => [0.0, f64::INFINITY],
        OUTGASSING => [LEAST_OUTGASSING, f64::INFINITY],
        EXPONENT => [0.3, 2.0],
        SHARE => [0.0, 1.0],
        RETURN => [0.0, 25.0],
        OFFSET => [-4.0, 7.0],
        _ => [f64::NEG_INFINITY, f64::INFINITY],
    }
}

/// The direction of an unknown at a bound to the values within: 1 or -1.
fn inwards(index: usize, value: f64) -> f64 {
    if value >= bounds(index)[1] { -1.0 } else { 1.0 }
}

/// The value of an unknown, moved into its bounds.
pub(super) fn bounded(index: usize, value: f64) -> f64 {
    let [low, high] = bounds(index);
    value.max(low).min(high)
}

/// The same with derivatives, which are zero beyond the bounds.
fn within<T: Number>(index: usize, number: T) -> T {
    let [low, high] = bounds(index);
    if (low..=high).contains(&number.value()) { number } else { T::from(bounded(index, number.value())) }
}

/// Where each unknown is in the vector of the fit.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Unknowns {
    pub given_volume: Option<f64>,
    pub knots_at: Vec<f64>,
    /// The sizes of leak and ultimate pressure.
    pub leak_size: f64,
    pub ultimate_size: f64,
}

impl Unknowns {
    pub fn count(&self) -> usize {
        SPEEDS + self.knots_at.len() + usize::from(self.given_volume.is_none())
    }

    /// The numbers of a plant. An unknown beyond its bounds counts as at its bound, and what is usual leads it back.
    pub fn numbers<T: Number>(&self, values: &[T]) -> Numbers<T> {
        let at = |index: usize| values.get(index).copied().unwrap_or(T::from(0.0));
        let within = |index: usize| within(index, at(index));
        let knots = self.knots_at.iter().enumerate().map(|(index, pa)| (*pa, at(SPEEDS + index)));
        Numbers {
            volume: self.given_volume.map_or_else(|| at(self.count() - 1).exp(), T::from),
            leak: at(LEAK) * self.leak_size,
            outgassing: within(OUTGASSING).exp(),
            exponent: within(EXPONENT),
            ultimate: at(ULTIMATE) * self.ultimate_size,
            share: within(SHARE),
            return_s: within(RETURN).exp(),
            first: at(FIRST).exp(),
            offset_s: within(OFFSET).exp(),
            knots: knots.collect(),
        }
    }
}

/// The least squares of a record.
#[derive(Clone)]
pub(super) struct Problem<'a> {
    pub record: &'a PlantRecord,
    pub groups: &'a [Group],
    pub noise: f64,
    pub unknowns: Unknowns,
    pub values: DVector<f64>,
    /// The unknowns that the fit may change.
    pub free: Vec<usize>,
    /// Whether the caller wants no result any more.
    pub stopped: &'a dyn Fn() -> bool,
}

impl Problem<'_> {
    /// The states at the groups for some values.
    pub fn states(&self, values: &DVector<f64>) -> Vec<State<f64>> {
        let mut all = Vec::with_capacity(self.groups.len());
        self.walk(values.as_slice(), |state| all.push(state));
        all
    }

    /// Calculates the pressure and calls a function with the state at each group.
    fn walk<T: Number>(&self, values: &[T], mut at_group: impl FnMut(State<T>)) {
        let numbers = self.unknowns.numbers(values);
        let dose = self.record.dose();
        let Some(first) = self.groups.first() else { return };
        let mut now = first.at_s;
        let age = T::from(now) + numbers.offset_s;
        let mut state = State { dry: numbers.first * first.ln_pa.exp(), water: T::from(0.0), age };
        for group in self.groups {
            // The ends of the pieces between two groups: changes of the valve, the dose, and the group.
            let mut ends: Vec<f64> = self.record.phases.iter().map(|phase| phase.from_s).collect();
            ends.extend(dose.map(|dose| dose.at_s));
            ends.retain(|end| *end > now && *end < group.at_s);
            ends.push(group.at_s);
            ends.sort_by(f64::total_cmp);
            for end in ends {
                state = numbers.advance(state, end - now, self.record.pumped_at(now));
                now = end;
                if let Some(dose) = dose.filter(|dose| dose.at_s.total_cmp(&end).is_eq()) {
                    state.dry = state.dry + T::from(dose.amount) / numbers.volume;
                }
            }
            at_group(state);
        }
    }

    /// The logarithms of fitted by measured pressure and the distances from what is usual, in standard deviations.
    pub fn misses(&self, values: &DVector<f64>) -> DVector<f64> {
        let states = self.states(values);
        let misses = states.iter().zip(self.groups);
        let misses = misses.map(|(fitted, group)| (fitted.pa().ln() - group.ln_pa) * group.count.sqrt() / self.noise);
        let usual = USUAL.map(|(index, value, spread)| (values[index] - value) / spread);
        DVector::from_iterator(self.groups.len() + USUAL.len(), misses.chain(usual))
    }

    /// The derivatives of the misses by some unknowns, in their order.
    pub fn derivatives(&self, places: &[usize]) -> DMatrix<f64> {
        let mut matrix = DMatrix::zeros(self.groups.len() + USUAL.len(), places.len());
        let most = if places.len() <= FEW { FEW } else { MANY };
        for (chunk, first) in places.chunks(most).zip((0..).step_by(most)) {
            if most == FEW {
                self.derivatives_of::<FEW>(chunk, first, &mut matrix);
            } else {
                self.derivatives_of::<MANY>(chunk, first, &mut matrix);
            }
        }
        matrix
    }

    /// Writes the derivatives by at most `COUNT` unknowns into the columns from `first` on.
    fn derivatives_of<const COUNT: usize>(&self, places: &[usize], first: usize, matrix: &mut DMatrix<f64>) {
        let number = |(index, value): (usize, &f64)| {
            let place = places.iter().position(|place| *place == index);
            place.map_or_else(|| Dual::from(*value), |place| Dual::<COUNT>::unknown(*value, place))
        };
        let values: Vec<Dual<COUNT>> = self.values.iter().enumerate().map(number).collect();
        let mut groups = self.groups.iter().enumerate();
        self.walk(&values, |state| {
            let Some((row, group)) = groups.next() else { return };
            let pa = state.pa();
            let factor = group.count.sqrt() / self.noise / pa.value();
            for (column, slope) in (first..first + places.len()).zip(pa.slopes()) {
                matrix[(row, column)] = slope * factor;
            }
        });
        for (row, (index, _, spread)) in (self.groups.len()..).zip(USUAL) {
            if let Some(column) = places.iter().position(|place| *place == index) {
                matrix[(row, first + column)] = spread.recip();
            }
        }
    }

    /// The least squares over the free unknowns within their bounds, and their sum; `None` without a minimum.
    pub fn minimised(self, tolerance: f64) -> Option<(f64, Self)> {
        let permitted = self.free.clone();
        self.minimised_over(&permitted, tolerance)
    }

    /// The same over the permitted unknowns, of which those that are not free begin at a bound: a fit goes on from another one.
    ///
    /// An unknown that leaves its bounds stays at the bound as long as a value within would not fit better (active set).
    fn minimised_over(mut self, permitted: &[usize], tolerance: f64) -> Option<(f64, Self)> {
        let mut releases = RELEASES;
        loop {
            if (self.stopped)() {
                return None;
            }
            self = LevenbergMarquardt::new().with_tol(tolerance).with_patience(MOST_EVALUATIONS).minimize(self).0;
            let is_outside =
                |values: &DVector<f64>, index: usize| bounded(index, values[index]).total_cmp(&values[index]).is_ne();
            if self.free.iter().any(|index| is_outside(&self.values, *index)) {
                let values = self.values.clone();
                self.free.retain(|index| !is_outside(&values, *index));
                permitted.iter().for_each(|index| self.values[*index] = bounded(*index, values[*index]));
                continue;
            }
            let held: Vec<usize> = permitted.iter().copied().filter(|index| !self.free.contains(index)).collect();
            let misses = self.misses(&self.values);
            let slopes = self.derivatives(&held).transpose() * &misses;
            let is_better = |index: usize, slope: f64| slope * inwards(index, self.values[index]) < 0.0;
            let better = held.iter().zip(slopes.iter()).find(|(index, slope)| is_better(**index, **slope));
            match better.map(|(index, _)| *index).filter(|_| releases > 0) {
                Some(index) => {
                    releases -= 1;
                    self.free.push(index);
                }
                None => {
                    let sum = misses.norm_squared();
                    return sum.is_finite().then_some((sum, self));
                }
            }
        }
    }
}

impl LeastSquaresProblem<f64, Dyn, Dyn> for Problem<'_> {
    type ParameterStorage = Owned<f64, Dyn>;
    type ResidualStorage = Owned<f64, Dyn>;
    type JacobianStorage = Owned<f64, Dyn, Dyn>;

    fn set_params(&mut self, values: &DVector<f64>) {
        for (index, value) in self.free.iter().zip(values.iter()) {
            self.values[*index] = *value;
        }
    }

    fn params(&self) -> DVector<f64> {
        DVector::from_iterator(self.free.len(), self.free.iter().map(|index| self.values[*index]))
    }

    /// Without residuals the method ends.
    fn residuals(&self) -> Option<DVector<f64>> {
        if (self.stopped)() {
            return None;
        }
        Some(self.misses(&self.values)).filter(|misses| misses.iter().all(|miss| miss.is_finite()))
    }

    fn jacobian(&self) -> Option<DMatrix<f64>> {
        Some(self.derivatives(&self.free)).filter(|matrix| matrix.iter().all(|part| part.is_finite()))
    }
}

/// Where a fit begins: parts of the guessed leak and ultimate pressure, and the logarithm of the time constant in s with which water
/// returns to the wall.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Beginning {
    leak: f64,
    ultimate: f64,
    returns: f64,
}

/// Leak, outgassing and ultimate pressure explain the same base pressure, with a ridge between the explanations; the water of a wall
/// may return within hours or within minutes. One beginning reaches only the explanations on its side. chosen
const BEGINNINGS: [Beginning; 3] = [
    // All three explain the base pressure.
    Beginning { leak: 1.0, ultimate: 1.0, returns: 10.0 },
    // Outgassing alone does.
    Beginning { leak: 0.1, ultimate: 0.1, returns: 10.0 },
    // The water returns within twenty minutes, so that a rise slows down.
    Beginning { leak: 0.3, ultimate: 0.3, returns: 7.0 },
];

impl Beginning {
    fn of<'a>(self, problem: &Problem<'a>) -> Problem<'a> {
        let mut problem = problem.clone();
        problem.values[LEAK] *= self.leak;
        problem.values[ULTIMATE] *= self.ultimate;
        problem.values[RETURN] = self.returns;
        problem
    }
}

/// The best fit of all beginnings: each one is fitted roughly, and the best one exactly.
pub(super) fn best<'a>(
    record: &'a PlantRecord,
    groups: &'a [Group],
    noise: f64,
    stopped: &'a dyn Fn() -> bool,
) -> Result<(f64, Problem<'a>), NotIdentified> {
    let (unknowns, start) = guess(record, groups);
    let free = (0..unknowns.count()).collect();
    let problem = Problem { record, groups, noise, unknowns, values: start, free, stopped };
    let permitted = problem.free.clone();
    let fits = BEGINNINGS.into_iter().filter_map(|beginning| beginning.of(&problem).minimised(ROUGH));
    let (_, best) = fits.min_by(|(one, _), (two, _)| one.total_cmp(two)).ok_or(NotIdentified::NoMinimum)?;
    best.minimised_over(&permitted, EXACT).ok_or(NotIdentified::NoMinimum)
}

/// A first guess from the slopes of the record.
fn guess(record: &PlantRecord, groups: &[Group]) -> (Unknowns, DVector<f64>) {
    let samples: Vec<(f64, f64)> = groups.iter().map(|group| (group.at_s, group.ln_pa.exp())).collect();
    let lowest = samples.iter().map(|(_, pa)| *pa).fold(f64::INFINITY, f64::min);
    let highest = samples.iter().map(|(_, pa)| *pa).fold(0.0, f64::max);
    let volume = match record.volume {
        Volume::Given(m3) => m3,
        Volume::FromDose(dose) => {
            let before = samples.iter().rev().find(|(t, _)| *t < dose.at_s).map_or(0.0, |(_, pa)| *pa);
            let after = samples.iter().find(|(t, _)| *t > dose.at_s).map_or(1.0, |(_, pa)| *pa);
            dose.amount / (after - before).max(1e-3 * after)
        }
    };
    let count = (((highest / lowest).log10() / DECADES).round().max(1.0) as usize).min(MOST_KNOTS - 1);
    let knots_at: Vec<f64> =
        (0..=count).map(|knot| lowest.ln() + (highest / lowest).ln() * knot as f64 / count as f64).collect();
    let pairs = || samples.windows(2).filter_map(|pair| Some((pair.first()?, pair.get(1)?)));
    let fastest = pairs()
        .filter(|((t, _), _)| record.pumped_at(*t))
        .map(|((t, pa), (later, lower))| (pa / lower).ln() / (later - t))
        .fold(1e-6, f64::max);
    let speed = (fastest * volume).ln();
    let rising = pairs().filter(|((t, _), _)| !record.pumped_at(*t));
    let gas = rising.map(|((t, pa), (later, higher))| (higher - pa) / (later - t) * volume).filter(|gas| *gas > 0.0);
    let mut gases: Vec<f64> = gas.collect();
    gases.sort_by(f64::total_cmp);
    let gas = gases.get(gases.len() / 2).copied().unwrap_or_else(|| lowest * speed.exp());
    let end = samples.last().map_or(HOUR_S, |(t, _)| *t);
    let given_volume = match record.volume {
        Volume::Given(m3) => Some(m3),
        Volume::FromDose(_) => None,
    };
    let unknowns = Unknowns { given_volume, knots_at, leak_size: gas, ultimate_size: lowest };
    let mut values = vec![0.3, (0.7 * gas * end / HOUR_S).ln(), 1.0, 0.3, 0.5, 10.0, 0.0, 0.0];
    values.extend(std::iter::repeat_n(speed, count + 1));
    if unknowns.given_volume.is_none() {
        values.push(volume.ln());
    }
    (unknowns, DVector::from_vec(values))
}

#[cfg(test)]
#[allow(clippy::unwrap_used, reason = "a test")]
mod tests {
    use super::*;
    use crate::plant::plants::Truth;
    use crate::plant::record::Phase;

    /// A pump-down to a base pressure, and a rise.
    fn record() -> PlantRecord {
        let pa = |t: f64| 10.0 * (-t / 20.0).exp() + 1e-4 + 1e-2 / (t + 5.0) + 1e-6 * (t - 3000.0).max(0.0);
        let samples = (0..400).map(|index| f64::from(index) * 10.0).map(|t| (t, pa(t))).collect();
        let phases = vec![Phase { from_s: 0.0, pumped: true }, Phase { from_s: 3000.0, pumped: false }];
        PlantRecord { samples, phases, volume: Volume::Given(0.05), gauge_uncertainty: 0.0 }
    }

    /// The derivative of the misses by an unknown from five points, whose error is the fourth power of the change.
    fn of_five_points(problem: &Problem<'_>, index: usize) -> DVector<f64> {
        const CHANGE: f64 = 3e-5;
        let beside = |changes: f64| {
            let mut values = problem.values.clone();
            values[index] += changes * CHANGE;
            problem.misses(&values)
        };
        ((beside(1.0) - beside(-1.0)) * 8.0 - (beside(2.0) - beside(-2.0))) / (12.0 * CHANGE)
    }

    #[test]
    fn each_derivative_is_that_of_small_changes() {
        for seed in [70_000, 70_001, 70_002, 70_003] {
            let record = Truth::of(seed).record(seed);
            let groups = record.groups();
            let (unknowns, mut values) = guess(&record, &groups);
            // A wall of a second: the steps are those of its age above it, and a constant below.
            values[OFFSET] += 0.5;
            let free: Vec<usize> = (0..unknowns.count()).collect();
            let problem =
                Problem { record: &record, groups: &groups, noise: 0.01, unknowns, values, free, stopped: &|| false };
            let found = problem.derivatives(&problem.free);
            for index in problem.free.clone() {
                let expected = of_five_points(&problem, index);
                let apart = (found.column(index) - &expected).amax() / expected.amax();
                assert!(apart < 1e-7, "plant {seed}, unknown {index}: {apart:e} of {:e}", expected.amax());
            }
            for index in problem.free.clone() {
                let apart = (problem.derivatives(&[index]).column(0) - found.column(index)).amax();
                assert!(apart < 1e-12 * found.column(index).amax(), "plant {seed}, unknown {index} alone: {apart:e}");
            }
        }
    }

    #[test]
    fn an_unknown_at_its_upper_bound_has_a_derivative() {
        let record = record();
        let groups = record.groups();
        let (unknowns, mut values) = guess(&record, &groups);
        values[RETURN] = 5.0;
        for index in [EXPONENT, SHARE, RETURN, OFFSET] {
            let mut values = values.clone();
            values[index] = bounds(index)[1];
            let problem = Problem {
                record: &record,
                groups: &groups,
                noise: 0.01,
                unknowns: unknowns.clone(),
                values,
                free: vec![index],
                stopped: &|| false,
            };
            // Without the last rows, which hold what is usual.
            let column = problem.derivatives(&[index]);
            let steepest = column.rows(0, groups.len()).amax();
            assert!(steepest > 0.0, "unknown {index} at its upper bound: {steepest:e}");
        }
    }
}
