//! The exact step of a network of volumes with constant rates.
//!
//! Amounts of gas n (in Pa m³) follow n' = A n + q. With L not less than the rate at which any volume empties, P = 1 + A/L has no
//! negative entry, and
//!
//! ```text
//! n(h) = sum over k of w_k (P^k n),   w_k = exp(-L h) (L h)^k / k!
//! ```
//!
//! is the exponential as a sum of positive terms (uniformisation; general knowledge: Jensen 1953, used for Markov chains). So
//! pressures stay positive, no digits cancel between 1e-9 and 1e+5 Pa, and gas is conserved: the gas that leaves through pumps
//! is one more volume of the same sum. The sum has about L h terms. If these are too many, because a small volume empties
//! quickly, the transition matrix of a short time is squared until it covers the step.

use crate::gas::GAS_COUNT;

/// A number for each gas.
pub type PerGas = [f64; GAS_COUNT];

/// The longest `L h` in one sum.
const LONGEST: f64 = 64.0;

/// The longest `L h` of the transition matrix before squaring.
const SHORT: f64 = 1.0;

/// The sum ends when the remaining terms are smaller than this fraction of it.
const TAIL: f64 = 1e-12;

/// Two volumes that exchange gas.
#[derive(Clone, Debug, PartialEq)]
pub struct Edge {
    /// The one volume.
    pub from: usize,
    /// The other volume.
    pub to: usize,
    /// The fraction of the gas of `from` that flows to `to`, in 1/s.
    pub forward: PerGas,
    /// The fraction of the gas of `to` that flows to `from`, in 1/s.
    pub back: PerGas,
}

/// All rates of a network.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Rates {
    /// Flow between volumes.
    pub edges: Vec<Edge>,
    /// Flow out of the network, as a fraction of each volume in 1/s.
    pub out: Vec<PerGas>,
    /// Sources of each volume, in Pa m³/s.
    pub source: Vec<PerGas>,
}

/// Buffers of the sum, so that a step does not allocate.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Work {
    term: Vec<PerGas>,
    next: Vec<PerGas>,
    keep: Vec<PerGas>,
    /// The transition matrix: the fraction of the gas of volume `from`, or of the sources, that is in volume `to`, or has
    /// left. Row `from`, column `to`.
    table: Vec<PerGas>,
    squared: Vec<PerGas>,
    column: Vec<PerGas>,
    /// The rate at which each gas left each volume in the last step, in 1/s.
    pub emptying: Vec<PerGas>,
}

impl Work {
    /// Buffers for `volumes` volumes.
    pub fn new(volumes: usize) -> Self {
        let lanes = vec![[0.0; GAS_COUNT]; volumes];
        let table = vec![[0.0; GAS_COUNT]; (volumes + 1) * (volumes + 1)];
        Self {
            term: lanes.clone(),
            next: lanes.clone(),
            keep: lanes.clone(),
            emptying: lanes.clone(),
            table: table.clone(),
            squared: table,
            column: lanes,
        }
    }
}

impl Work {
    /// Squares the matrix: it covers twice the time.
    fn square(&mut self, volumes: usize) {
        let width = volumes + 1;
        for from in 0..=volumes {
            let line = from * width;
            let squared = &mut self.squared[line..line + width];
            // The sources give the same amount in the second half; gas that has left does not return.
            squared.fill([0.0; GAS_COUNT]);
            if from == volumes {
                squared.copy_from_slice(&self.table[line..line + width]);
            }
            add(&mut squared[volumes], &self.table[line + volumes], 1.0);
            for over in 0..volumes {
                let part = self.table[line + over];
                for (sum, more) in squared.iter_mut().zip(&self.table[over * width..]) {
                    for gas in 0..GAS_COUNT {
                        sum[gas] += part[gas] * more[gas];
                    }
                }
            }
            if from < volumes {
                normalise(squared);
            }
        }
        std::mem::swap(&mut self.table, &mut self.squared);
    }

    /// Applies the matrix to `amounts`.
    fn apply(&mut self, amounts: &mut [PerGas], left: &mut PerGas) {
        let volumes = amounts.len();
        let width = volumes + 1;
        self.term.copy_from_slice(amounts);
        let (sources, away) = self.table[volumes * width..].split_at(volumes);
        amounts.copy_from_slice(sources);
        away.iter().for_each(|away| add(left, away, 1.0));
        for (from, term) in self.term.iter().enumerate() {
            let line = &self.table[from * width..(from + 1) * width];
            for (sum, part) in amounts.iter_mut().chain([&mut *left]).zip(line) {
                for gas in 0..GAS_COUNT {
                    sum[gas] += term[gas] * part[gas];
                }
            }
        }
    }
}

/// Normalises the fractions of each gas to the sum 1 after rounding.
fn normalise(parts: &mut [PerGas]) {
    for gas in 0..GAS_COUNT {
        let whole: f64 = parts.iter().map(|part| part[gas]).sum();
        parts.iter_mut().for_each(|part| part[gas] /= whole);
    }
}

impl Rates {
    /// Zero rates for `volumes` volumes and these edges.
    pub fn new(volumes: usize, edges: Vec<Edge>) -> Self {
        let lanes = vec![[0.0; GAS_COUNT]; volumes];
        Self { edges, out: lanes.clone(), source: lanes }
    }

    /// Advances `amounts` by `seconds` and adds the gas that leaves the network to `left`.
    pub fn step(&self, amounts: &mut [PerGas], left: &mut PerGas, seconds: f64, work: &mut Work) {
        self.leaving(&mut work.keep);
        let quickest = work.keep.iter().flatten().copied().fold(1e-6 / seconds, f64::max);
        work.emptying.copy_from_slice(&work.keep);
        for gas in work.keep.iter_mut().flatten() {
            *gas = (1.0 - *gas / quickest).max(0.0);
        }
        if quickest * seconds <= LONGEST {
            self.piece(amounts, left, quickest, quickest * seconds, 1.0, work);
        } else {
            self.squares(amounts, left, quickest, seconds, work);
        }
    }

    /// The step by repeated squaring of the matrix of a short time.
    fn squares(&self, amounts: &mut [PerGas], left: &mut PerGas, quickest: f64, seconds: f64, work: &mut Work) {
        let volumes = amounts.len();
        let times = (quickest * seconds / SHORT).log2().ceil();
        let length = quickest * seconds * (-times).exp2();
        let mut column = std::mem::take(&mut work.column);
        for from in 0..=volumes {
            column.fill([0.0; GAS_COUNT]);
            let mut away = [0.0; GAS_COUNT];
            let sources = if from == volumes { 1.0 } else { 0.0 };
            column.iter_mut().skip(from).take(1).for_each(|amount| *amount = [1.0; GAS_COUNT]);
            self.piece(&mut column, &mut away, quickest, length, sources, work);
            let line = from * (volumes + 1);
            work.table[line..line + volumes].copy_from_slice(&column);
            work.table[line + volumes] = away;
        }
        work.column = column;
        for _ in 0..times as u32 {
            work.square(volumes);
        }
        work.apply(amounts, left);
    }

    /// The rate at which each volume empties.
    fn leaving(&self, leaving: &mut [PerGas]) {
        leaving.copy_from_slice(&self.out);
        for edge in &self.edges {
            add(&mut leaving[edge.from], &edge.forward, 1.0);
            add(&mut leaving[edge.to], &edge.back, 1.0);
        }
    }

    /// Evaluates one sum.
    fn piece(
        &self,
        amounts: &mut [PerGas],
        left: &mut PerGas,
        quickest: f64,
        length: f64,
        sources: f64,
        work: &mut Work,
    ) {
        let mut weight = (-length).exp();
        let mut weights = weight;
        let mut away = [0.0; GAS_COUNT];
        let mut gone = [0.0; GAS_COUNT];
        work.term.copy_from_slice(amounts);
        amounts.iter_mut().for_each(|amount| scale(amount, weight));
        let (mut k, mut before) = (0.0, 0.0);
        // Gas of the sources appears one term later, so the tail is counted without the last term.
        while 1.0 - before > TAIL && (k < length || weight > TAIL * TAIL) {
            self.term(work, &mut gone, quickest.recip(), sources);
            before = weights;
            k += 1.0;
            weight *= length / k;
            weights += weight;
            for (sum, term) in amounts.iter_mut().zip(&work.term) {
                add(sum, term, weight);
            }
            add(&mut away, &gone, weight);
        }
        // The omitted terms are distributed over the included ones, so gas is conserved.
        amounts.iter_mut().for_each(|amount| scale(amount, weights.recip()));
        add(left, &away, weights.recip());
    }

    /// The next term: P times the last one.
    fn term(&self, work: &mut Work, gone: &mut PerGas, slowness: f64, sources: f64) {
        let given = slowness * sources;
        let Work { term, next, keep, .. } = work;
        for (number, next) in next.iter_mut().enumerate() {
            for gas in 0..GAS_COUNT {
                next[gas] = term[number][gas] * keep[number][gas] + self.source[number][gas] * given;
                gone[gas] += term[number][gas] * self.out[number][gas] * slowness;
            }
        }
        for edge in &self.edges {
            for gas in 0..GAS_COUNT {
                next[edge.to][gas] += term[edge.from][gas] * edge.forward[gas] * slowness;
                next[edge.from][gas] += term[edge.to][gas] * edge.back[gas] * slowness;
            }
        }
        std::mem::swap(term, next);
    }

    /// Writes the net growth of all gas in each volume to `net`, in Pa m³/s, and stores the fraction that leaves, in 1/s.
    pub fn net(&self, amounts: &[PerGas], net: &mut [f64]) {
        for ((net, amount), (out, source)) in net.iter_mut().zip(amounts).zip(self.out.iter().zip(&self.source)) {
            *net = sum(source) - product(amount, out);
        }
        for edge in &self.edges {
            let flow = product(&amounts[edge.from], &edge.forward) - product(&amounts[edge.to], &edge.back);
            net[edge.from] -= flow;
            net[edge.to] += flow;
        }
    }

    /// Replaces the rates by their mean with `other`.
    pub fn blend(&mut self, other: &Self) {
        for (mine, others) in self.edges.iter_mut().zip(&other.edges) {
            mean(&mut mine.forward, &others.forward);
            mean(&mut mine.back, &others.back);
        }
        self.out.iter_mut().zip(&other.out).for_each(|(mine, others)| mean(mine, others));
        self.source.iter_mut().zip(&other.source).for_each(|(mine, others)| mean(mine, others));
    }

    /// Copies `other` without allocation.
    pub fn copy_from(&mut self, other: &Self) {
        self.edges.clone_from_slice(&other.edges);
        self.out.copy_from_slice(&other.out);
        self.source.copy_from_slice(&other.source);
    }
}

/// The sum of all gases.
pub fn sum(lanes: &PerGas) -> f64 {
    lanes.iter().sum()
}

/// Adds `factor` times `more`.
pub fn add(lanes: &mut PerGas, more: &PerGas, factor: f64) {
    for gas in 0..GAS_COUNT {
        lanes[gas] += factor * more[gas];
    }
}

fn scale(lanes: &mut PerGas, factor: f64) {
    lanes.iter_mut().for_each(|gas| *gas *= factor);
}

fn product(left: &PerGas, right: &PerGas) -> f64 {
    left.iter().zip(right).map(|(left, right)| left * right).sum()
}

fn mean(lanes: &mut PerGas, others: &PerGas) {
    for gas in 0..GAS_COUNT {
        lanes[gas] = f64::midpoint(lanes[gas], others[gas]);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn pair(forward: f64, back: f64, out: f64) -> Rates {
        let edge = Edge { from: 0, to: 1, forward: [forward; GAS_COUNT], back: [back; GAS_COUNT] };
        let mut rates = Rates::new(2, vec![edge]);
        rates.out[1] = [out; GAS_COUNT];
        rates
    }

    fn after(rates: &Rates, start: [f64; 2], seconds: f64) -> ([f64; 2], f64) {
        let mut amounts = start.map(|amount| [amount; GAS_COUNT]);
        let mut left = [0.0; GAS_COUNT];
        rates.step(&mut amounts, &mut left, seconds, &mut Work::new(2));
        (amounts.map(|amount| amount[3]), left[3])
    }

    #[test]
    fn one_volume_empties_exponentially() {
        for (rate, seconds) in [(0.6, 0.01), (0.6, 1.0), (30.0, 1.0), (1e-9, 1.0), (500.0, 1.0)] {
            let ([_, there], left) = after(&pair(0.0, 0.0, rate), [0.0, 1e5], seconds);
            let expected = 1e5 * f64::exp(-rate * seconds);
            assert!((there - expected).abs() < 1e-9 * expected.max(1e-200), "{there:e} after {seconds} s at {rate}/s");
            assert!((there + left - 1e5).abs() < 1e-7);
        }
    }

    #[test]
    fn two_volumes_reach_their_mean() {
        let ([one, other], _) = after(&pair(0.2, 0.1, 0.0), [3.0, 0.0], 1.0);
        // n1 = 1 + 2 exp(-0.3 t)
        assert!((one - (1.0 + 2.0 * f64::exp(-0.3))).abs() < 1e-11, "{one}");
        assert!((one + other - 3.0).abs() < 1e-12);
    }

    #[test]
    fn thirteen_decades_of_pressure_do_not_disturb_each_other() {
        // With a compression of 1e9 the chamber ends at exactly 1e-9 of the fore line.
        let ([one, other], _) = after(&pair(10.0, 1e-8, 0.0), [0.0, 1.0], 10.0);
        assert!((one / other / 1e-9 - 1.0).abs() < 1e-6, "{:e}", one / other);
    }

    #[test]
    fn a_quick_volume_beside_a_slow_one_gives_the_same_result() {
        let mut rates = pair(1e6, 1e3, 0.5);
        rates.source[0] = [2.0; GAS_COUNT];
        for seconds in [1e-3, 1.0, 1e4] {
            let ([one, other], left) = after(&rates, [3.0, 0.0], seconds);
            assert!(((one + other + left) / (3.0 + 2.0 * seconds) - 1.0).abs() < 1e-9, "{one} {other} {left}");
            assert!((other / one / 1e3 - 1.0).abs() < 0.01, "{one} {other}");
        }
        let ([one, other], _) = after(&rates, [3.0, 0.0], 1e4);
        assert!(((one + other) / 4.0 - 1.0).abs() < 0.01, "{one} {other}");
    }

    #[test]
    fn the_gas_of_a_source_is_conserved() {
        for rate in [0.0, 1e-9, 1e-6, 1e-3] {
            let mut rates = pair(0.0, 0.0, rate);
            rates.source[1] = [2.0; GAS_COUNT];
            let ([_, there], left) = after(&rates, [0.0, 0.0], 3.0);
            assert!(((there + left) / 6.0 - 1.0).abs() < 1e-11, "{there} and {left} at {rate}/s");
        }
    }

    #[test]
    fn a_source_and_a_pump_reach_equilibrium() {
        let mut rates = pair(0.0, 0.0, 2.0);
        rates.source[1] = [1.0; GAS_COUNT];
        let ([_, there], left) = after(&rates, [0.0, 0.0], 3.0);
        assert!((there - (1.0 - f64::exp(-6.0)) / 2.0).abs() < 1e-11);
        assert!((there + left - 3.0).abs() < 1e-11);
    }
}
