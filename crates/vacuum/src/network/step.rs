//! A step of a plant.
//!
//! For each gas the plant is linear as long as its rates stand still, and [`Rates::step`] is then exact. But conductances and
//! pumps depend on the pressure. So each step is tried with the rates of its beginning; the rates of the end that was
//! reached tell what they would have moved differently. If that is nothing to speak of, the step stands; if it is little, the
//! step is made again with the mean of both; if it is more, it is halved. The length of the steps a caller takes hence
//! hardly matters.

use super::{InletState, Network, OpeningState, Outside, Supply};
use crate::conductance::{Conductance, relative_speeds};
use crate::gas::{GAS_COUNT, Gas};
use crate::pump::{Turbo, mass_roots};
use crate::series::{Edge, PerGas, Rates, Work, add, sum};

/// A step stands if other rates would have moved less than this part of the gas of every volume.
const STANDS: f64 = 1e-6;

/// It is made again with the mean of the rates if it is less than this, else halved.
const BLENDS: f64 = 0.005;

/// A step is halved if walls that slacken meanwhile would leave this part less in a volume.
const SLACKENS: f64 = 2e-3;

/// No step is halved below this, in s, nor below this part of the time that is to pass: so that it always comes to its end.
const SHORTEST_S: f64 = 1e-7;
const SHORTEST_PART: f64 = 1e-5;

/// A regulator opens fully when the pressure is this part below what it is set to. free choice
const BAND: f64 = 0.02;

/// What a step needs, made once.
#[derive(Clone, Debug, Default)]
pub(super) struct Step {
    /// Everything below is made for the plant as it is.
    pub(super) ready: bool,
    /// `now` holds the rates of the present.
    pub(super) current: bool,
    now: Rates,
    then: Rates,
    used: Rates,
    walls: Vec<PerGas>,
    /// How much less walls give off at the end of a step than on average, in Pa m^3/s.
    slack: Vec<f64>,
    tried: Vec<PerGas>,
    tried_left: PerGas,
    turned: Vec<Turbo>,
    net: [Vec<f64>; 2],
    work: Work,
    quickness: PerGas,
    roots: PerGas,
    /// The longest step that stood, in s.
    length: f64,
}

impl Network {
    /// Time passes.
    pub fn advance(&mut self, seconds: f64) {
        self.prepare();
        let shortest = SHORTEST_S.max(SHORTEST_PART * seconds);
        let mut rest = seconds;
        while rest > 0.0 {
            let length = rest.min(shortest.max(2.0 * self.step.length));
            let done = self.go(length, shortest);
            rest = if done == rest { 0.0 } else { rest - done };
        }
    }

    /// Makes what a step needs, after the plant was altered.
    fn prepare(&mut self) {
        if self.step.ready {
            return;
        }
        let zero = [0.0; GAS_COUNT];
        let edge = |(from, to): &(usize, usize)| Edge { from: *from, to: *to, forward: zero, back: zero };
        let volumes = self.volumes.len();
        let rates = Rates::new(volumes, self.ends.iter().map(edge).collect());
        self.step = Step {
            ready: true,
            current: false,
            now: rates.clone(),
            then: rates.clone(),
            used: rates,
            walls: vec![zero; volumes],
            slack: vec![0.0; volumes],
            tried: self.amounts.clone(),
            tried_left: zero,
            turned: self.turbos.clone(),
            net: [vec![0.0; volumes], vec![0.0; volumes]],
            work: Work::new(volumes),
            quickness: relative_speeds(),
            roots: mass_roots(),
            length: 1.0,
        };
    }

    /// Makes a step of at most this length, halved down to `shortest`, and says how long it was.
    fn go(&mut self, mut seconds: f64, shortest: f64) -> f64 {
        let mut step = std::mem::take(&mut self.step);
        if !step.current {
            self.rates(&self.amounts, &self.turbos, &mut step.now, &step.quickness, &step.roots);
        }
        loop {
            self.walls(seconds, &mut step);
            let [rates, slack] = self.attempt(seconds, &mut step);
            if rates < STANDS && slack < SLACKENS {
                break;
            }
            if rates < BLENDS && slack < SLACKENS || seconds <= shortest {
                self.again(seconds, &mut step);
                break;
            }
            seconds /= 2.0;
        }
        self.accept(seconds, &mut step);
        self.step = step;
        seconds
    }

    /// Tries a step with the rates of its beginning. Returns which part of the gas of a volume the rates of its end would have
    /// moved differently, at most, and which part comes from walls giving off the same all the time.
    fn attempt(&self, seconds: f64, step: &mut Step) -> [f64; 2] {
        self.apply(seconds, step, false);
        for (number, turned) in step.turned.iter_mut().enumerate() {
            let (inlet, fore) = self.ends[self.joins.len() + number];
            let [inlet, fore] = [inlet, fore].map(|volume| self.pa(&step.tried, volume));
            *turned = self.turbos[number].turned(inlet, fore, seconds);
        }
        self.rates(&step.tried, &step.turned, &mut step.then, &step.quickness, &step.roots);
        let [now, then] = &mut step.net;
        step.now.net(&step.tried, now);
        step.then.net(&step.tried, then);
        let mut worst = [0.0; 2];
        for (volume, amount) in step.tried.iter().enumerate() {
            // A gas that leaves its volume within the step has forgotten most of it.
            let passed = |(amount, leaving): (&f64, &f64)| amount * (1.0 + leaving * seconds);
            let amount: f64 = amount.iter().zip(&step.work.emptying[volume]).map(passed).sum();
            let differences = [(now[volume] - then[volume]).abs(), step.slack[volume]];
            for (worst, difference) in worst.iter_mut().zip(differences) {
                *worst = f64::max(*worst, if amount > 0.0 { difference * seconds / amount } else { 0.0 });
            }
        }
        worst
    }

    /// Makes the tried step once more, with the mean of the rates of its beginning and its end.
    fn again(&self, seconds: f64, step: &mut Step) {
        self.apply(seconds, step, true);
        self.rates(&step.tried, &step.turned, &mut step.then, &step.quickness, &step.roots);
    }

    fn apply(&self, seconds: f64, step: &mut Step, blended: bool) {
        step.used.copy_from(&step.now);
        if blended {
            step.used.blend(&step.then);
        }
        for (source, wall) in step.used.source.iter_mut().zip(&step.walls) {
            add(source, wall, 1.0);
        }
        step.tried.copy_from_slice(&self.amounts);
        step.tried_left = [0.0; GAS_COUNT];
        step.used.step(&mut step.tried, &mut step.tried_left, seconds, &mut step.work);
    }

    /// The tried step stands.
    fn accept(&mut self, seconds: f64, step: &mut Step) {
        for source in &step.used.source {
            add(&mut self.came, source, seconds);
        }
        add(&mut self.left, &step.tried_left, 1.0);
        for (volume, surface) in &mut self.surfaces {
            surface.advance(seconds, self.amounts[*volume][Gas::H2o as usize] / self.volumes[*volume]);
        }
        self.amounts.copy_from_slice(&step.tried);
        self.turbos.copy_from_slice(&step.turned);
        std::mem::swap(&mut step.now, &mut step.then);
        step.current = true;
        step.length = seconds;
    }

    /// What walls and loads give off in the next seconds.
    fn walls(&self, seconds: f64, step: &mut Step) {
        step.walls.copy_from_slice(&self.loads);
        step.slack.fill(0.0);
        for (volume, surface) in &self.surfaces {
            step.slack[*volume] += surface.outgas(seconds, &mut step.walls[*volume]);
        }
    }

    /// The total pressure in a volume that has `amounts`.
    fn pa(&self, amounts: &[PerGas], volume: usize) -> f64 {
        sum(&amounts[volume]) / self.volumes[volume]
    }

    /// All rates at these amounts, without the walls.
    fn rates(&self, amounts: &[PerGas], turbos: &[Turbo], rates: &mut Rates, quickness: &PerGas, roots: &PerGas) {
        rates.out.fill([0.0; GAS_COUNT]);
        rates.source.fill([0.0; GAS_COUNT]);
        let (joints, rotors) = rates.edges.split_at_mut(self.joins.len());
        for (join, edge) in self.joins.iter().zip(joints) {
            let mean = f64::midpoint(self.pa(amounts, edge.from), self.pa(amounts, edge.to));
            let passed = passes(&join.conductance, mean, join.opening, quickness);
            self.between(edge, &passed, &passed);
        }
        for (turbo, edge) in turbos.iter().zip(rotors) {
            let (inlet, fore) = (self.pa(amounts, edge.from), self.pa(amounts, edge.to));
            let [forward, back] = turbo.passes(inlet, fore, roots);
            self.between(edge, &forward, &back);
        }
        self.pumped(rates);
        self.holes.iter().for_each(|hole| self.through(hole, amounts, rates, quickness));
        self.feeds.iter().for_each(|feed| self.fed(feed, amounts, rates));
    }

    /// Conductances in m^3/s make rates in 1/s.
    fn between(&self, edge: &mut Edge, forward: &PerGas, back: &PerGas) {
        let (from, to) = (self.volumes[edge.from].recip(), self.volumes[edge.to].recip());
        edge.forward = forward.map(|conductance| conductance * from);
        edge.back = back.map(|conductance| conductance * to);
    }

    fn pumped(&self, rates: &mut Rates) {
        for (at, pump) in self.roughings.iter().filter(|(_, pump)| pump.running) {
            let rate = pump.speed / self.volumes[*at];
            rates.out[*at].iter_mut().for_each(|out| *out += rate);
            add(&mut rates.source[*at], pump.ultimate.as_array(), pump.speed);
        }
    }

    fn through(&self, hole: &OpeningState, amounts: &[PerGas], rates: &mut Rates, quickness: &PerGas) {
        if hole.opening == 0.0 {
            return;
        }
        let outside = match hole.outside {
            Outside::Air => self.atmosphere.mixture(),
            Outside::Gas(mixture) => mixture,
        };
        let mean = f64::midpoint(outside.total(), self.pa(amounts, hole.at));
        let passed = passes(&hole.conductance, mean, hole.opening, quickness);
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
            Supply::Pressure { pa, most } => {
                let total = self.pa(amounts, feed.at);
                // At the pressure itself rounding must not shut the valve and open it again.
                if total < pa * (1.0 + 1e-9) {
                    // slope (pa - total), which is `most` below the band, with the pressure of this gas on the side of what flows
                    // out: no step is too long for it, and none leads beyond the pressure.
                    let slope = most / (BAND * pa).max(pa - total);
                    let others = total - amounts[feed.at][gas] / self.volumes[feed.at];
                    *source += slope * (pa - others).max(0.0);
                    rates.out[feed.at][gas] += slope / self.volumes[feed.at];
                }
            }
        }
    }
}

/// What passes a conductance that is open so far, gas by gas in m^3/s.
fn passes(conductance: &Conductance, mean_pa: f64, opening: f64, quickness: &PerGas) -> PerGas {
    if opening == 0.0 {
        return [0.0; GAS_COUNT];
    }
    let (molecules, wind) = conductance.parts_at(mean_pa);
    quickness.map(|quick| opening * (molecules * quick + wind))
}
