//! The pressure of a plant with known numbers.

use super::number::Number;

const HOUR_S: f64 = 3600.0;

/// Largest relative change of the wall's age within a step. The logarithm of the pressure may change by 2 × [`CHANGE`]. A step takes at
/// least [`LEAST_STEP`] of the calculated time.
const STEP: f64 = 0.07;
const CHANGE: f64 = 0.07;
const LEAST_STEP: f64 = 1e-3;

/// After this number of steps of one calculation the age of the wall limits them no more: a wall that returning water keeps young would
/// need hundreds of millions of them for a gap of months.
const MOST_STEPS: u32 = 20_000;

/// The least age of a wall, in s.
const YOUNGEST_S: f64 = 0.01;

/// The numbers of a plant.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Numbers<T> {
    /// In m³.
    pub volume: T,
    /// The flow of the leak, in Pa m³/s.
    pub leak: T,
    /// The outgassing after an hour, in Pa m³/s.
    pub outgassing: T,
    /// The exponent of time with which the outgassing falls.
    pub exponent: T,
    /// The lowest pressure of the pump, in Pa.
    pub ultimate: T,
    /// The share of outgassing that does not return to the wall.
    pub share: T,
    /// The time constant of the return of the water, in s.
    pub return_s: T,
    /// The true pressure of the first sample divided by its indication.
    pub first: T,
    /// The age of the wall at the start of the pump-down, in s.
    pub offset_s: T,
    /// Natural logarithms of a pressure in Pa and of the speed there in m³/s.
    pub knots: Vec<(f64, T)>,
}

/// Parts of the rates of change that stay as they are: those by the leak in Pa/s, those of dry gas and of water by outgassing in
/// 1/m³, the part of the age of the wall that returning water takes in 1/(Pa s), and the rate of the return in 1/s.
struct Shares<T> {
    leak: T,
    dry: T,
    wet: T,
    wetting: T,
    returning: T,
}

/// The gas of a chamber: what does not return to the wall and the water, in Pa, and the age of the wall, in s.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct State<T> {
    pub dry: T,
    pub water: T,
    pub age: T,
}

impl<T: Number> State<T> {
    pub fn pa(self) -> T {
        (self.dry + self.water).at_least(f64::MIN_POSITIVE)
    }
}

impl<T: Number> Numbers<T> {
    pub fn speed(&self, pa: T) -> T {
        let at = pa.value().max(f64::MIN_POSITIVE).ln();
        let (Some(first), Some(last)) = (self.knots.first(), self.knots.last()) else { return T::from(0.0) };
        let above = self.knots.windows(2).find(|pair| pair.get(1).is_some_and(|high| at < high.0));
        match above {
            _ if at <= first.0 => first.1.exp(),
            Some([(from, low), (to, high)]) => {
                let part = (at - from) / (to - from);
                let higher = high.value() - low.value();
                let speed = (low.value() + higher * (at - from) / (to - from)).exp();
                let steepness = higher / (to - from);
                T::chained(
                    speed,
                    [(speed * (1.0 - part), low), (speed * part, high), (speed * steepness / pa.value(), &pa)],
                )
            }
            _ => last.1.exp(),
        }
    }

    /// The outgassing of a wall of an age in s, in Pa m³/s.
    pub fn outgassed(&self, age: T) -> T {
        let age = age.at_least(YOUNGEST_S);
        let hours = HOUR_S / age.value();
        let exponent = self.exponent.value();
        let power = hours.powf(exponent);
        let flow = self.outgassing.value() * power;
        T::chained(
            flow,
            [(power, &self.outgassing), (flow * hours.ln(), &self.exponent), (-flow * exponent / age.value(), &age)],
        )
    }

    /// The state after `seconds` more. The sources change linearly in each step; the speed is that of its middle.
    pub fn advance(&self, state: State<T>, seconds: f64, pumped: bool) -> State<T> {
        self.advance_in_steps(state, seconds, pumped).0
    }

    /// The same, with the number of steps.
    fn advance_in_steps(&self, mut state: State<T>, seconds: f64, pumped: bool) -> (State<T>, u32) {
        let shares = Shares {
            leak: self.leak / self.volume,
            dry: self.share / self.volume,
            wet: (T::from(1.0) - self.share) / self.volume,
            wetting: self.volume / (self.return_s * self.outgassing * HOUR_S),
            returning: T::from(1.0) / self.return_s,
        };
        let rate = |state: &State<T>| if pumped { self.speed(state.pa()) / self.volume } else { T::from(0.0) };
        let (mut left, mut outgassed) = (T::from(seconds), self.outgassed(state.age));
        let mut steps = 0_u32;
        while left.value() > 0.0 {
            let here = rate(&state);
            steps += 1;
            let least = if steps > MOST_STEPS { seconds * LEAST_STEP } else { 0.0 };
            // The age is a function of the unknowns, so the step is one too, with derivatives.
            let mut step = left.smaller((state.age.at_least(1.0) * STEP).at_least(least));
            let mut half = self.moved(&shares, &state, &outgassed, &state.water, &(step * 0.5), &here).0;
            // Only the speed depends on the pressure, so a step is as long as the pressure stays similar.
            while (half.pa().value() / state.pa().value()).ln().abs() > CHANGE && step.value() > seconds * LEAST_STEP {
                step = step * 0.5;
                half = self.moved(&shares, &state, &outgassed, &state.water, &(step * 0.5), &here).0;
            }
            (state, outgassed) = self.moved(&shares, &state, &outgassed, &half.water, &step, &rate(&half));
            left = left - step;
        }
        (state, steps)
    }

    /// The state after a step at a rate of pumping in 1/s with its outgassing, from the outgassing before and the mean water
    /// pressure of the step.
    fn moved(&self, shares: &Shares<T>, state: &State<T>, before: &T, water: &T, step: &T, rate: &T) -> (State<T>, T) {
        // The returning water makes the wall younger.
        let aging = T::from(1.0);
        let age = relaxed(&state.age, [&aging; 2], &(*water * shares.wetting), step).at_least(YOUNGEST_S);
        let after = self.outgassed(age);
        let steady = shares.leak + self.ultimate * *rate;
        let dry = [&(steady + shares.dry * *before), &(steady + shares.dry * after)];
        let wet = [&(shares.wet * *before), &(shares.wet * after)];
        let moved = State {
            dry: relaxed(&state.dry, dry, rate, step),
            water: relaxed(&state.water, wet, &(*rate + shares.returning), step),
            age,
        };
        (moved, after)
    }
}

/// The solution of `x' = source - rate x` after a step in which the source changes linearly.
fn relaxed<T: Number>(number: &T, [before, after]: [&T; 2], rate: &T, step: &T) -> T {
    let x = rate.value() * step.value();
    let is_short = x < 1e-4;
    // The mean of exp(-u) from 0 to x, that of the change of the source, and the derivatives of both by x.
    let mean = if is_short { 1.0 - x / 2.0 } else { -(-x).exp_m1() / x };
    let change = if is_short { 0.5 - x / 6.0 } else { (1.0 - mean) / x };
    let mean_by_x = if is_short { -0.5 } else { (1.0 - x * mean - mean) / x };
    let change_by_x = if is_short { -1.0 / 6.0 } else { -(mean_by_x + change) / x };
    let start = before.value() - rate.value() * number.value();
    let rise = after.value() - before.value();
    let slope = start * mean + rise * change;
    let by_x = (start * mean_by_x + rise * change_by_x) * step.value();
    T::chained(
        number.value() + slope * step.value(),
        [
            (1.0 - x * mean, number),
            ((mean - change) * step.value(), before),
            (change * step.value(), after),
            ((by_x - number.value() * mean) * step.value(), rate),
            (slope + by_x * rate.value(), step),
        ],
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Water that returns within a second to a wall with little of it keeps the wall young for a century.
    #[test]
    fn a_gap_of_a_century_has_a_bounded_number_of_steps() {
        let numbers = Numbers {
            volume: 1.0,
            leak: 0.0,
            outgassing: 1e-9,
            exponent: 1.0,
            ultimate: 0.0,
            share: 0.0,
            return_s: 1.0,
            first: 1.0,
            offset_s: 1.0,
            knots: vec![(0.0, -10.0)],
        };
        let state = State { dry: 1.0, water: 1e3, age: 1.0 };
        let (after, steps) = numbers.advance_in_steps(state, 3.2e9, false);
        assert!(after.pa().is_finite() && after.pa() > 0.0, "{after:?}");
        // Without the limit there are 4.5e10 steps, which take an hour.
        assert!((MOST_STEPS..2 * MOST_STEPS).contains(&steps), "{steps}");
    }
}
