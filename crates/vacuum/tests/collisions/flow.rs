//! Gas flows from a large space through a tube into vacuum, or into a gas of lower pressure: direct simulation (Bird 1994).

use crate::collisions::gas::{self, Model, Molecule};
use crate::collisions::tube::{Tube, WEIGHT_STEP};
use fastrand::Rng;
use std::f64::consts::PI;

/// A flow to simulate, and its grid.
#[derive(Clone, Copy, Debug)]
pub struct Setting {
    pub length: f64,
    pub delta: f64,
    pub model: Model,
    /// The pressure behind the tube, divided by that before it.
    pub behind: f64,
    pub cells_per_radius: u32,
    /// Simulated molecules in a cell at the wall of the tube, before it.
    pub molecules_per_cell: f64,
    /// Time before the average, and the time of the average, in radii per most probable speed.
    pub settle: f64,
    pub sample: f64,
    /// The boxes before and behind the tube: 2 reach to three radii, 3 to six.
    pub boxes: [u32; 2],
    pub seed: u64,
}

/// The flow relative to molecular flow through an opening of the same area.
#[derive(Clone, Copy, Debug)]
pub struct Flow {
    pub mean: f64,
    /// One standard deviation of the mean.
    pub deviation: f64,
}

/// The state of a simulation.
struct State {
    tube: Tube,
    setting: Setting,
    rng: Rng,
    volumes: Vec<(f64, u32)>,
    molecules: Vec<Molecule>,
    /// Simulated molecules per volume next to the tube where the density is 1.
    per_volume: f64,
    cross_section: f64,
    step: f64,
    /// The largest rate of a pair in each cell, and the fraction of a pair that remains from the last step.
    rates: Vec<(f64, f64)>,
    starts: Vec<u32>,
    order: Vec<u32>,
    /// The flow of the last part of the simulation: the gas before the tube moves towards it.
    flow: f64,
}

/// The end of the space before or behind the tube, from which molecules enter.
#[derive(Clone, Copy, Debug)]
struct Boundary {
    reach: f64,
    /// The doublings of its box.
    doublings: u32,
    /// The velocity towards the tube times the square of the distance.
    drift: f64,
    density: f64,
    is_behind: bool,
}

/// The parts of the average from which its uncertainty follows.
const PARTS: usize = 12;

/// Simulates a flow.
pub fn simulate(setting: Setting) -> Flow {
    let mut state = State::new(setting);
    let settle_parts = 8;
    for _ in 0..settle_parts {
        state.flow = state.average(setting.settle / f64::from(settle_parts));
    }
    let parts: Vec<f64> = (0..PARTS)
        .map(|_| {
            let part = state.average(setting.sample / PARTS as f64);
            state.flow += (part - state.flow) / 4.0;
            part
        })
        .collect();
    let mean = parts.iter().sum::<f64>() / PARTS as f64;
    let square = parts.iter().map(|part| (part - mean).powi(2)).sum::<f64>() / (PARTS - 1) as f64;
    Flow { mean, deviation: (square / PARTS as f64).sqrt() }
}

impl State {
    fn new(setting: Setting) -> Self {
        let tube = Tube::new(setting.length, setting.cells_per_radius, setting.boxes);
        let side = 1.0 / f64::from(setting.cells_per_radius);
        let volumes = tube.volumes();
        let cross_section = setting.model.cross_section(setting.delta);
        let between = if setting.delta > 0.0 { 0.9 / setting.delta } else { 1.0 };
        let mut state = Self {
            per_volume: setting.molecules_per_cell / (2.0 * PI * side * side),
            rates: vec![(2.5, 0.5); volumes.len()],
            starts: vec![0; volumes.len() + 1],
            order: Vec::new(),
            molecules: Vec::new(),
            rng: Rng::with_seed(setting.seed),
            step: (0.5 * side).min(0.8 * between),
            flow: 1.0,
            tube,
            setting,
            volumes,
            cross_section,
        };
        state.fill();
        state
    }

    /// Fills the space before the tube, and the tube with a density that falls along it.
    fn fill(&mut self) {
        let reach = self.tube.reach();
        let outermost = self.weight(self.tube.outermost());
        let most = PI * reach.powi(3) * self.per_volume;
        for _ in 0..(most / outermost) as u64 {
            let (z, r) = (-reach * self.rng.f64(), reach * self.rng.f64().sqrt());
            let (_, doublings) = self.tube.cell(z, r);
            let copies = (outermost / self.weight(doublings)).round() as u32;
            for copy in 0..copies {
                let (z, r) = if copy == 0 { (z, r) } else { self.near(z, r, doublings) };
                self.add_resting(z, r);
            }
        }
        self.fill_behind();
        for _ in 0..(PI * self.setting.length * self.per_volume) as u64 {
            let (along, r) = (self.rng.f64(), self.rng.f64().sqrt());
            if self.rng.f64() > (1.0 - self.setting.behind).min(0.8) * along {
                self.add_resting(along * self.setting.length, r);
            }
        }
    }

    /// Fills the space behind the tube with the gas of its pressure.
    fn fill_behind(&mut self) {
        let (reach, length) = (self.tube.reach_behind(), self.setting.length);
        let outermost = self.weight(self.tube.outermost_behind());
        let most = PI * reach.powi(3) * self.per_volume * self.setting.behind;
        for _ in 0..(most / outermost) as u64 {
            let (z, r) = (length + reach * self.rng.f64(), reach * self.rng.f64().sqrt());
            let (_, doublings) = self.tube.cell(z, r);
            let copies = (outermost / self.weight(doublings)).round() as u32;
            for copy in 0..copies {
                let (z, r) = if copy == 0 { (z, r) } else { self.near(z, r, doublings) };
                self.add_resting(z, r);
            }
        }
    }

    /// Another place within the same box.
    fn near(&mut self, z: f64, r: f64, doublings: u32) -> (f64, f64) {
        for _ in 0..32 {
            let plane = if z < 0.0 { 0.0 } else { self.setting.length };
            let near = (plane + (z - plane) * (0.9 + 0.2 * self.rng.f64()), r);
            if self.tube.cell(near.0, near.1).1 == doublings {
                return near;
            }
        }
        (z, r)
    }

    fn add_resting(&mut self, z: f64, r: f64) {
        let ((along, outward), (around, _)) = (gas::parallel(&mut self.rng), gas::parallel(&mut self.rng));
        let rotation = self.setting.model.rotation(&mut self.rng);
        let (cell, _) = self.tube.cell(z, r);
        self.molecules.push(Molecule { z, r, along, outward, around, rotation, cell });
    }

    fn weight(&self, doublings: u32) -> f64 {
        WEIGHT_STEP.powi(doublings as i32)
    }

    /// The mean flow over a time.
    fn average(&mut self, time: f64) -> f64 {
        let steps = (time / self.step).ceil().max(1.0) as u64;
        let mut sum = 0.0;
        for _ in 0..steps {
            sum += self.advance();
        }
        sum / steps as f64
    }

    /// One step: molecules fly, enter and collide. Returns the flow.
    fn advance(&mut self) -> f64 {
        let entered = self.fly();
        self.enter();
        self.sort();
        self.collide();
        let unit = self.per_volume * PI.sqrt() / 2.0;
        if self.setting.length > 0.0 {
            let within = |molecule: &&Molecule| molecule.z >= 0.0 && molecule.z < self.setting.length;
            let sum: f64 = self.molecules.iter().filter(within).map(|molecule| molecule.along).sum();
            return sum / self.setting.length / unit;
        }
        f64::from(entered) / self.step / unit
    }

    fn fly(&mut self) -> i32 {
        let mut entered = 0;
        let mut index = 0;
        let mut count = self.molecules.len();
        let mut copies = Vec::new();
        while index < count {
            let mut molecule = self.molecules[index];
            let before = self.volumes[molecule.cell as usize].1;
            let passed = self.tube.fly(&mut molecule, self.step, &self.setting.model, &mut self.rng);
            entered += passed.entered;
            let (cell, doublings) = if passed.lost { (0, 0) } else { self.tube.cell(molecule.z, molecule.r) };
            molecule.cell = cell;
            let expected = WEIGHT_STEP.powi(before as i32 - doublings as i32);
            let stays = if passed.lost { 0 } else { (expected + self.rng.f64()) as usize };
            if stays == 0 {
                count -= 1;
                self.molecules[index] = self.molecules[count];
                self.molecules.truncate(count);
                continue;
            }
            copies.extend(std::iter::repeat_n(molecule, stays - 1));
            self.molecules[index] = molecule;
            index += 1;
        }
        self.molecules.extend(copies);
        entered
    }

    /// Molecules enter through the outer boundaries from gases that move with the flow: towards the tube, and behind it away.
    fn enter(&mut self) {
        let reach = self.tube.reach();
        let dense = reach * self.setting.delta;
        let drift = self.flow / (4.0 * PI.sqrt()) * dense / (1.0 + dense);
        let before = Boundary { reach, doublings: self.tube.outermost(), drift, density: 1.0, is_behind: false };
        self.enter_through(before);
        let density = self.setting.behind;
        if density > 0.0 {
            let reach = self.tube.reach_behind();
            let dense = reach * self.setting.delta * density;
            let drift = -self.flow / density / (4.0 * PI.sqrt()) * dense / (1.0 + dense);
            let doublings = self.tube.outermost_behind();
            self.enter_through(Boundary { reach, doublings, drift, density, is_behind: true });
        }
    }

    fn enter_through(&mut self, boundary: Boundary) {
        let Boundary { reach, drift, .. } = boundary;
        for (area, round) in [(PI * reach * reach, false), (2.0 * PI * reach * reach, true)] {
            let most = drift.abs() / (reach * reach);
            let flux = boundary.density * (1.0 + 6.0 * most) / (2.0 * PI.sqrt());
            let expected = flux * area * self.step * self.per_volume / self.weight(boundary.doublings);
            for _ in 0..(expected + self.rng.f64()) as u64 {
                let (z, r) =
                    if round { (-reach * self.rng.f64(), reach) } else { (-reach, reach * self.rng.f64().sqrt()) };
                let drift = drift / (z * z + r * r).powf(1.5);
                self.enter_at(z, r, round, drift, most, boundary.is_behind);
            }
        }
    }

    /// A molecule at a place before the tube, or at its mirror image behind it.
    fn enter_at(&mut self, z: f64, r: f64, round: bool, drift: f64, most: f64, is_behind: bool) {
        let inward = gas::leaving(&mut self.rng);
        let (toward, beside) = (-z * drift, -r * drift);
        let across = if round { -beside } else { toward };
        if self.rng.f64() * (1.0 + 6.0 * most) > 1.0 + 2.0 * across * inward {
            return;
        }
        let (first, around) = gas::parallel(&mut self.rng);
        let (along, outward) = if round { (first + toward, -inward) } else { (inward, first + beside) };
        let (z, along) = if is_behind { (self.setting.length - z, -along) } else { (z, along) };
        let rotation = self.setting.model.rotation(&mut self.rng);
        let mut molecule = Molecule { z, r, along, outward, around, rotation, cell: 0 };
        let time = self.step * self.rng.f64();
        let passed = self.tube.fly(&mut molecule, time, &self.setting.model, &mut self.rng);
        if !passed.lost {
            molecule.cell = self.tube.cell(molecule.z, molecule.r).0;
            self.molecules.push(molecule);
        }
    }

    /// Puts the molecules in the order of their cells.
    fn sort(&mut self) {
        self.starts.fill(0);
        for molecule in &self.molecules {
            self.starts[molecule.cell as usize + 1] += 1;
        }
        for cell in 1..self.starts.len() {
            self.starts[cell] += self.starts[cell - 1];
        }
        let mut next = self.starts.clone();
        self.order.resize(self.molecules.len(), 0);
        for (number, molecule) in self.molecules.iter().enumerate() {
            let place = &mut next[molecule.cell as usize];
            self.order[*place as usize] = number as u32;
            *place += 1;
        }
        let sorted = self.order.iter().map(|number| self.molecules[*number as usize]).collect();
        self.molecules = sorted;
    }

    /// Collisions without a time counter (Bird 1994): the pairs of each cell are chosen so that the fastest of them always collides.
    fn collide(&mut self) {
        if self.setting.delta <= 0.0 {
            return;
        }
        for cell in 0..self.volumes.len() {
            let (first, end) = (self.starts[cell] as usize, self.starts[cell + 1] as usize);
            let count = end - first;
            if count < 2 {
                continue;
            }
            let (volume, doublings) = self.volumes[cell];
            let each = self.weight(doublings) / self.per_volume * self.cross_section * self.step / volume;
            let (fastest, left) = self.rates[cell];
            let pairs = 0.5 * (count * (count - 1)) as f64 * each * fastest + left;
            self.rates[cell].1 = pairs.fract();
            for _ in 0..pairs as u64 {
                self.try_pair(cell, first, count);
            }
        }
    }

    fn try_pair(&mut self, cell: usize, first: usize, count: usize) {
        let one = first + self.rng.usize(..count);
        let other = self.partner(one, first, count);
        let (mut a, mut b) = (self.molecules[one], self.molecules[other]);
        let (along, outward, around) = (a.along - b.along, a.outward - b.outward, a.around - b.around);
        let speed = (along * along + outward * outward + around * around).sqrt();
        let rate = self.setting.model.rate(speed);
        let fastest = self.rates[cell].0;
        if rate > fastest {
            self.rates[cell].0 = rate;
        }
        if self.rng.f64() * fastest < rate {
            self.setting.model.collide(&mut a, &mut b, speed, &mut self.rng);
            self.molecules[one] = a;
            self.molecules[other] = b;
        }
    }

    /// The nearest of some molecules of the cell: the distance of colliding molecules, not the cell, limits the resolution.
    fn partner(&mut self, one: usize, first: usize, count: usize) -> usize {
        let (z, r) = (self.molecules[one].z, self.molecules[one].r);
        let mut nearest = (one, f64::INFINITY);
        for _ in 0..CANDIDATES {
            let mut other = first + self.rng.usize(..count - 1);
            if other >= one {
                other += 1;
            }
            let candidate = &self.molecules[other];
            let distance = (candidate.z - z).powi(2) + (candidate.r - r).powi(2);
            if distance < nearest.1 {
                nearest = (other, distance);
            }
        }
        nearest.0
    }
}

/// The molecules among which the partner of a collision is the nearest.
const CANDIDATES: usize = 4;
