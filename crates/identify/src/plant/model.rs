//! The pressure of a plant with known numbers.

const HOUR_S: f64 = 3600.0;

/// The age of the wall changes by this part within a step of the calculation at most, the logarithm of the pressure by twice
/// [`CHANGE`]. A step is no shorter than the least part of the time that is calculated.
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
pub(super) struct Numbers {
    /// In m³.
    pub volume: f64,
    /// The flow of the leak, in Pa m³/s.
    pub leak: f64,
    /// The outgassing after an hour, in Pa m³/s.
    pub outgassing: f64,
    /// The exponent of time with which the outgassing falls.
    pub exponent: f64,
    /// The lowest pressure of the pump, in Pa.
    pub ultimate: f64,
    /// The share of outgassing that does not return to the wall.
    pub share: f64,
    /// The time constant of the return of the water, in s.
    pub return_s: f64,
    /// The true pressure of the first sample divided by its indication.
    pub first: f64,
    /// The age of the wall at the start of the pump-down, in s.
    pub offset_s: f64,
    /// Natural logarithms of a pressure in Pa and of the speed there in m³/s.
    pub knots: Vec<(f64, f64)>,
}

/// The gas of a chamber: what does not return to the wall and the water, in Pa, and the age of the wall, in s.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct State {
    pub dry: f64,
    pub water: f64,
    pub age: f64,
}

impl State {
    pub fn pa(self) -> f64 {
        (self.dry + self.water).max(f64::MIN_POSITIVE)
    }
}

impl Numbers {
    pub fn speed(&self, pa: f64) -> f64 {
        let at = pa.max(f64::MIN_POSITIVE).ln();
        let (Some(first), Some(last)) = (self.knots.first(), self.knots.last()) else { return 0.0 };
        let above = self.knots.windows(2).find(|pair| pair.get(1).is_some_and(|high| at < high.0));
        match above {
            _ if at <= first.0 => first.1.exp(),
            Some([(from, low), (to, high)]) => (low + (high - low) * (at - from) / (to - from)).exp(),
            _ => last.1.exp(),
        }
    }

    /// The outgassing of a wall of an age in s, in Pa m³/s.
    pub fn outgassed(&self, age: f64) -> f64 {
        self.outgassing * (HOUR_S / age.max(YOUNGEST_S)).powf(self.exponent)
    }

    /// The state after `seconds` more. The sources change linearly in each step; the speed is that of its middle.
    pub fn advance(&self, mut state: State, seconds: f64, pumped: bool) -> State {
        let rate = |state: State| if pumped { self.speed(state.pa()) / self.volume } else { 0.0 };
        let (mut left, mut outgassed) = (seconds, self.outgassed(state.age));
        let mut steps = 0;
        while left > 0.0 {
            let here = rate(state);
            steps += 1;
            let least = if steps > MOST_STEPS { seconds * LEAST_STEP } else { 0.0 };
            let mut step = left.min((STEP * state.age.max(1.0)).max(least));
            let mut half = self.moved(state, outgassed, state.water, step / 2.0, here).0;
            // Only the speed depends on the pressure, so a step is as long as the pressure stays similar.
            while (half.pa() / state.pa()).ln().abs() > CHANGE && step > seconds * LEAST_STEP {
                step /= 2.0;
                half = self.moved(state, outgassed, state.water, step / 2.0, here).0;
            }
            (state, outgassed) = self.moved(state, outgassed, half.water, step, rate(half));
            left -= step;
        }
        state
    }

    /// The state after a step at a rate of pumping in 1/s with its outgassing, from the outgassing before and the mean water
    /// pressure of the step.
    fn moved(&self, state: State, before: f64, water: f64, step: f64, rate: f64) -> (State, f64) {
        // The returning water makes the wall younger.
        let wetted = water * self.volume / (self.return_s * self.outgassing * HOUR_S);
        let age = relaxed(state.age, [1.0; 2], wetted, step).max(YOUNGEST_S);
        let after = self.outgassed(age);
        let steady = self.leak / self.volume + self.ultimate * rate;
        let dry = [before, after].map(|outgassed| steady + self.share * outgassed / self.volume);
        let wet = [before, after].map(|outgassed| (1.0 - self.share) * outgassed / self.volume);
        let moved = State {
            dry: relaxed(state.dry, dry, rate, step),
            water: relaxed(state.water, wet, rate + self.return_s.recip(), step),
            age,
        };
        (moved, after)
    }
}

/// The solution of `x' = source - rate x` after a step in which the source changes linearly.
fn relaxed(value: f64, [before, after]: [f64; 2], rate: f64, step: f64) -> f64 {
    let x = rate * step;
    let mean = if x < 1e-4 { 1.0 - x / 2.0 } else { -(-x).exp_m1() / x };
    let change = if x < 1e-4 { 0.5 - x / 6.0 } else { (1.0 - mean) / x };
    value + ((before - rate * value) * mean + (after - before) * change) * step
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
        let begun = std::time::Instant::now();
        let after = numbers.advance(state, 3.2e9, false);
        assert!(after.pa().is_finite() && after.pa() > 0.0, "{after:?}");
        // Without the limit there are 4.5e10 steps, which take an hour; with it there are 21 000.
        assert!(begun.elapsed().as_secs() < 30);
    }
}
