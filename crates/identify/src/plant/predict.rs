//! What follows from the numbers of a plant: pressures and times to come, and what would help most.

use super::fit::bounded;
use super::model::{Numbers, State};
use super::{LAW, Plant};
use crate::interval::{Interval, SIGMAS};
use nalgebra::DVector;

const HOUR_S: f64 = 3600.0;

/// A time that is not reached within a year is not stated.
const YEAR_S: f64 = 365.0 * 24.0 * HOUR_S;

/// The standard uncertainty of the exponent of the pumping speed below the lowest pressure of the record, where the fit takes the
/// speed as constant: 7 % per decade. chosen
const BELOW: f64 = 0.03;

/// A change that lowers the pressure.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Remedy {
    /// Close the leak.
    CloseLeak,
    /// Bake the chamber, which leaves a hundredth of the outgassing (chosen).
    Bake,
    /// A pump of twice the effective speed.
    LargerPump,
    /// A better fore vacuum or pump, with a tenth of the ultimate pressure.
    BetterPump,
}

impl Remedy {
    /// All of them.
    pub const ALL: [Self; 4] = [Self::CloseLeak, Self::Bake, Self::LargerPump, Self::BetterPump];

    fn applied(self, numbers: &Numbers<f64>) -> Numbers<f64> {
        let mut better = numbers.clone();
        match self {
            Self::CloseLeak => better.leak = 0.0,
            Self::Bake => better.outgassing *= 0.01,
            Self::LargerPump => better.knots.iter_mut().for_each(|(_, speed)| *speed += std::f64::consts::LN_2),
            Self::BetterPump => better.ultimate *= 0.1,
        }
        better
    }
}

impl Plant {
    /// The time of the last group of samples, in s after the start of the pump-down.
    #[must_use]
    pub const fn end_s(&self) -> f64 {
        self.end_s
    }

    /// The pressure in Pa, as the gauge will indicate it, with its 95 % band if the pumping goes on until `seconds` after the
    /// start of the pump-down.
    #[must_use]
    pub fn predicted_pa(&self, seconds: f64) -> Interval {
        let found = self.band(|numbers| self.pressure(numbers, seconds));
        let further = self.beyond(found.mean);
        let wider = |bound: f64| (bound / found.mean).ln().hypot(further).exp();
        Interval { low: found.mean / wider(found.low), high: found.mean * wider(found.high), ..found }
    }

    /// 1.96 standard deviations of the logarithm of a predicted pressure beside those of the unknowns: of the laws, and of the pumping
    /// speed below the lowest pressure of the record.
    fn beyond(&self, pa: f64) -> f64 {
        let lowest = self.unknowns.knots_at.first().copied().unwrap_or(0.0);
        SIGMAS * LAW.hypot(BELOW * (lowest - pa.ln()).max(0.0))
    }

    /// The time in s after the start of the pump-down at which the pressure reaches a target in Pa, with its 95 % band; `None`
    /// if it certainly does not within a year. The upper bound is infinite if the target may not be reached at all; the mean too, if it
    /// is more likely not.
    #[must_use]
    pub fn time_to_pa(&self, target_pa: f64) -> Option<Interval> {
        let found = self.band(|numbers| self.time(numbers, target_pa));
        // A pressure that may be higher by a part is reached as late as one that is lower by it.
        let numbers = self.unknowns.numbers(self.values.as_slice());
        let further = self.beyond(target_pa);
        let [early, late] = [further, -further].map(|part| self.time(&numbers, target_pa * part.exp()));
        if !found.mean.is_finite() {
            let low = found.low.min(early);
            return low.is_finite().then_some(Interval { low, high: f64::INFINITY, ..found });
        }
        let wider = |one: f64, other: f64| (one / found.mean).ln().hypot((other / found.mean).ln()).exp();
        Some(Interval {
            low: found.mean / wider(found.low, early),
            high: found.mean * wider(found.high, late),
            ..found
        })
    }

    /// The pressure after another day of pumping divided by that with each remedy, with its 95 % band, the best remedy first.
    #[must_use]
    pub fn remedies(&self) -> Vec<(Remedy, Interval)> {
        let end = self.end_s + 24.0 * HOUR_S;
        let mut all: Vec<_> = Remedy::ALL
            .map(|remedy| {
                let factor =
                    |numbers: &Numbers<f64>| self.pressure(numbers, end) / self.pressure(&remedy.applied(numbers), end);
                (remedy, self.hull(factor))
            })
            .into();
        all.sort_by(|(_, one), (_, two)| two.mean.total_cmp(&one.mean));
        all
    }

    /// The parts of the pressure with the valve open at a time in Pa, with their 95 % bands: by the leak, by outgassing, and by
    /// the pump.
    #[must_use]
    pub fn parts_pa(&self, seconds: f64) -> [Interval; 3] {
        let over_speed = |numbers: &Numbers<f64>, flow: &dyn Fn(State<f64>) -> f64| {
            let state = self.state(numbers, seconds);
            flow(state) / numbers.speed(state.pa())
        };
        // A leak may be zero, which has no logarithm: its band is that of the profiles alone.
        let leak = self.hull(|numbers| over_speed(numbers, &|_| numbers.leak));
        let walls = self.band(|numbers| over_speed(numbers, &|state| numbers.outgassed(state.age)));
        let [leak, walls] = [leak, walls].map(|part| part.widened(self.gauge_uncertainty.hypot(LAW)));
        [leak, walls, self.ultimate_pa]
    }

    /// The pressure if the pumping goes on from the first group until `seconds`.
    fn pressure(&self, numbers: &Numbers<f64>, seconds: f64) -> f64 {
        self.state(numbers, seconds).pa()
    }

    /// The state of the chamber then.
    fn state(&self, numbers: &Numbers<f64>, seconds: f64) -> State<f64> {
        let (from, state) = self.start;
        if seconds > from { numbers.advance(state, seconds - from, true) } else { state }
    }

    fn time(&self, numbers: &Numbers<f64>, target_pa: f64) -> f64 {
        let (mut now, mut state) = self.start;
        if state.pa() <= target_pa {
            return now;
        }
        while now < YEAR_S {
            let step = (now * 0.02).max(0.1);
            let next = numbers.advance(state, step, true);
            let (pa, lower) = (state.pa(), next.pa());
            if lower <= target_pa {
                // Between the two the logarithms are a straight line.
                let part = if lower < pa { (pa / target_pa).ln() / (pa / lower).ln() } else { 1.0 };
                return now + step * part;
            }
            (now, state) = (now + step, next);
        }
        f64::INFINITY
    }

    /// A quantity above zero with its 95 % band: the larger of 1.96 standard deviations of its logarithm and of the hull.
    fn band(&self, quantity: impl Fn(&Numbers<f64>) -> f64) -> Interval {
        let found = self.hull(&quantity);
        let variance = self.variance(&|values: &DVector<f64>| self.at(&quantity, values).ln());
        let spread = (SIGMAS * variance.max(0.0).sqrt()).exp();
        if !spread.is_finite() {
            return found;
        }
        Interval { low: found.low.min(found.mean / spread), high: found.high.max(found.mean * spread), ..found }
    }

    /// A quantity with its range over the unknowns at the bounds of their intervals.
    fn hull(&self, quantity: impl Fn(&Numbers<f64>) -> f64) -> Interval {
        let mean = self.at(&quantity, &self.values);
        let corners = self.corners.iter().map(|values| self.at(&quantity, values));
        let [low, high] = corners.fold([mean; 2], |[low, high], value| [low.min(value), high.max(value)]);
        Interval { mean, low, high }
    }

    /// A quantity at values, which count as within their bounds.
    fn at(&self, quantity: impl Fn(&Numbers<f64>) -> f64, values: &DVector<f64>) -> f64 {
        let inside = DVector::from_fn(values.len(), |index, _| bounded(index, values[index]));
        quantity(&self.unknowns.numbers(inside.as_slice()))
    }

    /// The variance of a function of the unknowns.
    fn variance(&self, of: &impl Fn(&DVector<f64>) -> f64) -> f64 {
        let gradient = DVector::from_fn(self.values.len(), |index, _| {
            // A tenth of the uncertainty of the number shows how the function changes within it.
            let step = (0.1 * self.covariance[(index, index)].sqrt()).max(1e-6);
            let [below, above] = [-step, step].map(|change| {
                let mut values = self.values.clone();
                values[index] += change;
                of(&values)
            });
            (above - below) / (2.0 * step)
        });
        gradient.dot(&(&self.covariance * &gradient))
    }
}
