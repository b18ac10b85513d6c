//! A time step of a plant.
//!
//! With constant rates the plant is linear for each gas, and [`Rates::step`] is exact. But conductances and pumps depend on
//! the pressure. So each step is tried with the rates at its start. The rates at its end give an estimate of the error: if it
//! is negligible, the step is accepted; if it is small, the step is repeated with the mean of both rates; otherwise the step
//! is halved. The result hence depends little on the step length of the caller.

use super::{InletState, Network, OpeningState, Outside, Supply};
use crate::conductance::{Bulk, Conductance, relative_speeds};
use crate::gas::{GAS_COUNT, Gas, Mixture};
use crate::pump::Turbo;
use crate::series::{Edge, PerGas, Rates, Work, add, sum};

/// A step is accepted if the error is below this fraction of the gas of every volume.
const ACCEPTED_ERROR: f64 = 1e-6;

/// A step is repeated with the mean of the rates if the error is below this fraction, else halved.
const BLENDED_ERROR: f64 = 0.005;

/// A step is halved if the decrease of outgassing during the step is above this fraction of the gas of a volume.
const OUTGASSING_ERROR: f64 = 2e-3;

/// The shortest step in s, and as a fraction of the requested time, so that every call ends.
const SHORTEST_S: f64 = 1e-7;
const SHORTEST_FRACTION: f64 = 1e-5;

/// The proportional band of a regulator, as a fraction of its set point. chosen
const BAND: f64 = 0.02;

/// Buffers and intermediate values of a step.
#[derive(Clone, Debug, Default)]
pub(super) struct Step {
    /// Whether the values below fit the present plant.
    pub(super) ready: bool,
    /// Whether `now` holds the present rates.
    pub(super) current: bool,
    now: Rates,
    then: Rates,
    used: Rates,
    walls: Vec<PerGas>,
    /// The difference of outgassing at the end of a step from its mean, in Pa m³/s.
    slack: Vec<f64>,
    /// The water that returns to the walls, as a conductance in m³/s.
    returning: Vec<f64>,
    /// The mean properties of the gas of each volume.
    bulks: Vec<Bulk>,
    tried: Vec<PerGas>,
    tried_left: PerGas,
    turned: Vec<Turbo>,
    net: [Vec<f64>; 2],
    work: Work,
    relative_speeds: PerGas,
    /// The length of the last accepted step, in s.
    length: f64,
}

impl Network {
    /// Advances the plant by `seconds`.
    pub fn advance(&mut self, seconds: f64) {
        self.prepare();
        let shortest = SHORTEST_S.max(SHORTEST_FRACTION * seconds);
        let mut rest = seconds;
        while rest > 0.0 {
            let length = rest.min(shortest.max(2.0 * self.step.length));
            let done = self.advance_once(length, shortest);
            rest = if done == rest { 0.0 } else { rest - done };
        }
    }

    /// Prepares the buffers after a change of the plant.
    fn prepare(&mut self) {
        if self.step.ready {
            return;
        }
        let zero = [0.0; GAS_COUNT];
        let edge = |(from, to): &(usize, usize)| Edge { from: *from, to: *to, forward: zero, back: zero };
        let volumes = self.volumes.len();
        let rates = Rates::new(volumes, self.connections.iter().map(edge).collect());
        self.step = Step {
            ready: true,
            current: false,
            now: rates.clone(),
            then: rates.clone(),
            used: rates,
            walls: vec![zero; volumes],
            slack: vec![0.0; volumes],
            returning: vec![0.0; volumes],
            bulks: Vec::with_capacity(volumes),
            tried: self.amounts.clone(),
            tried_left: zero,
            turned: self.turbo_pumps.clone(),
            net: [vec![0.0; volumes], vec![0.0; volumes]],
            work: Work::new(volumes),
            relative_speeds: relative_speeds(),
            length: 1.0,
        };
    }

    /// Makes a step of at most `seconds`, halved down to `shortest` if needed, and returns its length.
    fn advance_once(&mut self, mut seconds: f64, shortest: f64) -> f64 {
        let mut step = std::mem::take(&mut self.step);
        if !step.current {
            self.rates(&self.amounts, &self.turbo_pumps, &mut step.now, &step.relative_speeds, &mut step.bulks);
        }
        loop {
            self.walls(seconds, &mut step);
            let [rates, slack] = self.attempt(seconds, &mut step);
            if rates < ACCEPTED_ERROR && slack < OUTGASSING_ERROR {
                break;
            }
            if rates < BLENDED_ERROR && slack < OUTGASSING_ERROR || seconds <= shortest {
                self.repeat(seconds, &mut step);
                break;
            }
            seconds /= 2.0;
        }
        self.accept(seconds, &mut step);
        self.step = step;
        seconds
    }

    /// Tries a step with the rates at its start. Returns two errors as the largest fraction of the gas of a volume: from the
    /// change of the rates, and from the change of outgassing.
    fn attempt(&self, seconds: f64, step: &mut Step) -> [f64; 2] {
        self.apply(seconds, step, false);
        for (number, turned) in step.turned.iter_mut().enumerate() {
            let (inlet, fore) = self.connections[self.joints.len() + number];
            let [inlet, fore] = [inlet, fore].map(|volume| self.pa(&step.tried, volume));
            *turned = self.turbo_pumps[number].turned(inlet, fore, seconds);
        }
        self.rates(&step.tried, &step.turned, &mut step.then, &step.relative_speeds, &mut step.bulks);
        let [now, then] = &mut step.net;
        step.now.net(&step.tried, now);
        step.then.net(&step.tried, then);
        let mut worst = [0.0; 2];
        for (volume, amount) in step.tried.iter().enumerate() {
            // Gas that leaves its volume within the step keeps little of the error.
            let passed = |(amount, leaving): (&f64, &f64)| amount * (1.0 + leaving * seconds);
            let amount: f64 = amount.iter().zip(&step.work.emptying[volume]).map(passed).sum();
            let differences = [(now[volume] - then[volume]).abs(), step.slack[volume]];
            for (worst, difference) in worst.iter_mut().zip(differences) {
                *worst = f64::max(*worst, if amount > 0.0 { difference * seconds / amount } else { 0.0 });
            }
        }
        worst
    }

    /// Repeats the tried step with the mean of the rates at its start and end.
    fn repeat(&self, seconds: f64, step: &mut Step) {
        self.apply(seconds, step, true);
        self.rates(&step.tried, &step.turned, &mut step.then, &step.relative_speeds, &mut step.bulks);
    }

    fn apply(&self, seconds: f64, step: &mut Step, blended: bool) {
        step.used.copy_from(&step.now);
        if blended {
            step.used.blend(&step.then);
        }
        for (source, wall) in step.used.source.iter_mut().zip(&step.walls) {
            add(source, wall, 1.0);
        }
        for ((out, returning), m3) in step.used.out.iter_mut().zip(&step.returning).zip(&self.volumes) {
            out[Gas::H2o as usize] += returning / m3;
        }
        step.tried.copy_from_slice(&self.amounts);
        step.tried_left = [0.0; GAS_COUNT];
        step.used.step(&mut step.tried, &mut step.tried_left, seconds, &mut step.work);
    }

    /// Accepts the tried step.
    fn accept(&mut self, seconds: f64, step: &mut Step) {
        for source in &step.used.source {
            add(&mut self.entered, source, seconds);
        }
        add(&mut self.left, &step.tried_left, 1.0);
        for (volume, surface) in &mut self.surfaces {
            let water = [&self.amounts, &step.tried].map(|amounts| amounts[*volume][Gas::H2o as usize]);
            surface.advance(seconds, f64::midpoint(water[0], water[1]) / self.volumes[*volume]);
        }
        for (volume, pump) in &mut self.capture_pumps {
            let passes = pump.passes(sum(&self.amounts[*volume]) / self.volumes[*volume]);
            let mut captured = *pump.captured.as_array();
            for gas in 0..GAS_COUNT {
                let mean = f64::midpoint(self.amounts[*volume][gas], step.tried[*volume][gas]);
                captured[gas] += passes[gas] * mean / self.volumes[*volume] * seconds;
            }
            pump.captured = Mixture::from(captured);
        }
        self.amounts.copy_from_slice(&step.tried);
        self.turbo_pumps.copy_from_slice(&step.turned);
        std::mem::swap(&mut step.now, &mut step.then);
        step.current = true;
        step.length = seconds;
    }

    /// Sets the sources of walls and loads for the next `seconds`.
    fn walls(&self, seconds: f64, step: &mut Step) {
        step.walls.copy_from_slice(&self.loads);
        step.slack.fill(0.0);
        step.returning.fill(0.0);
        for (volume, surface) in &self.surfaces {
            let water_pa = self.amounts[*volume][Gas::H2o as usize] / self.volumes[*volume];
            let exchange = surface.outgas(seconds, water_pa, &mut step.walls[*volume]);
            step.slack[*volume] += exchange.slack;
            step.returning[*volume] += exchange.returning;
        }
    }

    /// The total pressure of a volume with `amounts`, in Pa.
    fn pa(&self, amounts: &[PerGas], volume: usize) -> f64 {
        sum(&amounts[volume]) / self.volumes[volume]
    }

    /// Calculates all rates at `amounts`, without the walls. `bulks` is a buffer.
    fn rates(
        &self,
        amounts: &[PerGas],
        turbos: &[Turbo],
        rates: &mut Rates,
        relative_speeds: &PerGas,
        bulks: &mut Vec<Bulk>,
    ) {
        rates.out.fill([0.0; GAS_COUNT]);
        rates.source.fill([0.0; GAS_COUNT]);
        bulks.clear();
        bulks.extend(amounts.iter().zip(&self.volumes).map(|(amount, m3)| Bulk::of(amount, m3.recip())));
        let (joints, rotors) = rates.edges.split_at_mut(self.joints.len());
        for (join, edge) in self.joints.iter().zip(joints) {
            let ends = [&bulks[edge.from], &bulks[edge.to]];
            let passed = passes(&join.conductance, ends, join.opening, relative_speeds);
            self.between(edge, &passed, &passed);
        }
        for (turbo, edge) in turbos.iter().zip(rotors) {
            let [forward, back] = turbo.passes(&bulks[edge.from], &bulks[edge.to], relative_speeds);
            self.between(edge, &forward, &back);
        }
        self.pumped(rates, bulks);
        self.openings.iter().for_each(|hole| self.through(hole, bulks, rates, relative_speeds));
        self.inlets.iter().for_each(|feed| self.fed(feed, amounts, rates));
    }

    /// Converts conductances in m³/s to rates in 1/s.
    fn between(&self, edge: &mut Edge, forward: &PerGas, back: &PerGas) {
        let (from, to) = (self.volumes[edge.from].recip(), self.volumes[edge.to].recip());
        edge.forward = forward.map(|conductance| conductance * from);
        edge.back = back.map(|conductance| conductance * to);
    }

    fn pumped(&self, rates: &mut Rates, bulks: &[Bulk]) {
        for (at, pump) in self.roughing_pumps.iter().filter(|(_, pump)| pump.running) {
            let speed = pump.speed * pump.curve.factor(bulks[*at].pa);
            let rate = speed / self.volumes[*at];
            rates.out[*at].iter_mut().for_each(|out| *out += rate);
            add(&mut rates.source[*at], pump.ultimate.as_array(), speed);
        }
        for (at, seal) in &self.seals {
            add(&mut rates.out[*at], seal.conductances(), self.volumes[*at].recip());
            add(&mut rates.source[*at], seal.flow(&self.atmosphere.mixture()).as_array(), 1.0);
        }
        for (at, pump) in &self.capture_pumps {
            add(&mut rates.out[*at], &pump.passes(bulks[*at].pa), self.volumes[*at].recip());
        }
        for ((out, speed), m3) in rates.out.iter_mut().zip(&self.gauge_speeds).zip(&self.volumes) {
            if *speed > 0.0 {
                out.iter_mut().for_each(|out| *out += speed / m3);
            }
        }
    }

    fn through(&self, hole: &OpeningState, bulks: &[Bulk], rates: &mut Rates, relative_speeds: &PerGas) {
        if hole.opening == 0.0 {
            return;
        }
        let outside = match hole.outside {
            Outside::Air => self.atmosphere.mixture(),
            Outside::Gas(mixture) => mixture,
        };
        let ends = [&Bulk::of_mixture(&outside), &bulks[hole.at]];
        let passed = passes(&hole.conductance, ends, hole.opening, relative_speeds);
        add(&mut rates.out[hole.at], &passed, self.volumes[hole.at].recip());
        for ((source, passed), pa) in rates.source[hole.at].iter_mut().zip(passed).zip(outside.as_array()) {
            *source += passed * pa;
        }
    }

    fn fed(&self, feed: &InletState, amounts: &[PerGas], rates: &mut Rates) {
        let gas = feed.gas as usize;
        let source = &mut rates.source[feed.at][gas];
        match feed.supply {
            Supply::Closed => {}
            Supply::Flow(flow) => *source += flow,
            Supply::Pressure { pa, max_flow } => {
                let total = self.pa(amounts, feed.at);
                // At the set point, rounding must not close and open the valve alternately.
                if total < pa * (1.0 + 1e-9) {
                    // The flow is slope (pa - total), and `max_flow` below the band. The term with the pressure of this gas counts
                    // as flow out of the volume. So a step of any length is stable, and the pressure never exceeds the set point.
                    let slope = max_flow / (BAND * pa).max(pa - total);
                    let others = total - amounts[feed.at][gas] / self.volumes[feed.at];
                    *source += slope * (pa - others).max(0.0);
                    rates.out[feed.at][gas] += slope / self.volumes[feed.at];
                }
            }
        }
    }
}

/// The conductance of each gas through an element with the given opening, in m³/s.
fn passes(conductance: &Conductance, ends: [&Bulk; 2], opening: f64, relative_speeds: &PerGas) -> PerGas {
    if opening == 0.0 {
        return [0.0; GAS_COUNT];
    }
    let (molecular, viscous) = conductance.parts(ends[0], ends[1]);
    relative_speeds.map(|speed| opening * (molecular * speed + viscous))
}
