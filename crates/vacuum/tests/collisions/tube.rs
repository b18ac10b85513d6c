//! The tube, the space before and behind it, its cells, and the paths of molecules between its walls.

use crate::collisions::gas::{self, Model, Molecule};
use fastrand::Rng;
use std::f64::consts::PI;

/// The boxes before and behind the tube have this size, then twice, four times it: each with cells twice as large.
const BOX: f64 = 1.5;

/// A molecule of the next larger box stands for this many times more molecules.
pub const WEIGHT_STEP: f64 = 3.0;

/// A round tube of radius 1 in a plate, with its cells.
#[derive(Clone, Debug)]
pub struct Tube {
    pub length: f64,
    /// Cells along the side of a box: even.
    box_cells: u32,
    boxes_before: u32,
    boxes_behind: u32,
    tube_cells: (u32, u32),
}

/// Where a molecule is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Space {
    Before,
    Within,
    Behind,
}

/// What a path did.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Passed {
    /// Passages of the entrance: forward less back.
    pub entered: i32,
    /// The molecule left through the outer boundary.
    pub lost: bool,
}

impl Tube {
    /// A tube of this length in radii with about this number of cells per radius.
    pub fn new(length: f64, cells_per_radius: u32, [boxes_before, boxes_behind]: [u32; 2]) -> Self {
        let box_cells = (BOX * f64::from(cells_per_radius) / 2.0).ceil() as u32 * 2;
        let along = (length * f64::from(cells_per_radius)).ceil() as u32;
        Self { length, box_cells, boxes_before, boxes_behind, tube_cells: (along, cells_per_radius) }
    }

    /// The size of the space before the tube.
    pub fn reach(&self) -> f64 {
        BOX * f64::from(1_u32 << self.outermost())
    }

    /// The doublings of the outermost box before the tube.
    pub const fn outermost(&self) -> u32 {
        self.boxes_before - 1
    }

    /// The size of the space behind the tube.
    pub fn reach_behind(&self) -> f64 {
        BOX * f64::from(1_u32 << self.outermost_behind())
    }

    /// The doublings of the outermost box behind the tube.
    pub const fn outermost_behind(&self) -> u32 {
        self.boxes_behind - 1
    }

    pub fn cells(&self) -> usize {
        let boxes = self.boxes_before + self.boxes_behind;
        (boxes * self.box_cells * self.box_cells + self.tube_cells.0 * self.tube_cells.1) as usize
    }

    /// The cell of a place, and how many doublings its box is away from the tube.
    pub fn cell(&self, z: f64, r: f64) -> (u32, u32) {
        let per_box = self.box_cells * self.box_cells;
        if z < 0.0 {
            let (cell, doublings) = self.in_box(-z, r);
            (doublings * per_box + cell, doublings)
        } else if z >= self.length {
            let (cell, doublings) = self.in_box(z - self.length, r);
            ((self.boxes_before + doublings) * per_box + cell, doublings)
        } else {
            let along = (z / self.length * f64::from(self.tube_cells.0)) as u32;
            let off = ((r * f64::from(self.tube_cells.1)) as u32).min(self.tube_cells.1 - 1);
            let first = (self.boxes_before + self.boxes_behind) * per_box;
            (first + along.min(self.tube_cells.0 - 1) * self.tube_cells.1 + off, 0)
        }
    }

    fn in_box(&self, distance: f64, r: f64) -> (u32, u32) {
        let (mut size, mut doublings) = (BOX, 0);
        while distance.max(r) >= size && doublings < 8 {
            size *= 2.0;
            doublings += 1;
        }
        let scale = f64::from(self.box_cells) / size;
        let last = self.box_cells - 1;
        let (along, off) = (((distance * scale) as u32).min(last), ((r * scale) as u32).min(last));
        (along * self.box_cells + off, doublings)
    }

    /// The volume of each cell, and the doublings of its box.
    pub fn volumes(&self) -> Vec<(f64, u32)> {
        let mut volumes = Vec::with_capacity(self.cells());
        for of_box in (0..self.boxes_before).chain(0..self.boxes_behind) {
            let side = BOX * f64::from(1_u32 << of_box) / f64::from(self.box_cells);
            for _ in 0..self.box_cells {
                volumes.extend((0..self.box_cells).map(|off| (ring(off, side) * side, of_box)));
            }
        }
        let side = 1.0 / f64::from(self.tube_cells.1);
        for _ in 0..self.tube_cells.0 {
            let along = self.length / f64::from(self.tube_cells.0);
            volumes.extend((0..self.tube_cells.1).map(|off| (ring(off, side) * along, 0)));
        }
        volumes
    }

    /// Moves a molecule for a time, with diffuse reflection from the walls.
    pub fn fly(&self, molecule: &mut Molecule, mut time: f64, model: &Model, rng: &mut Rng) -> Passed {
        let mut passed = Passed::default();
        let mut space = self.space(molecule.z);
        loop {
            let (to_plane, plane) = match (space, molecule.along > 0.0) {
                (Space::Before, true) | (Space::Within, false) => (-molecule.z / molecule.along, 0.0),
                (Space::Within, true) | (Space::Behind, false) => {
                    ((self.length - molecule.z) / molecule.along, self.length)
                }
                (Space::Before, false) | (Space::Behind, true) => (f64::INFINITY, 0.0),
            };
            let to_wall = if space == Space::Within { to_wall(molecule) } else { f64::INFINITY };
            let next = to_plane.min(to_wall).max(0.0);
            if next >= time {
                advance(molecule, time);
                passed.lost = self.outside(space, molecule);
                return passed;
            }
            advance(molecule, next);
            time -= next;
            if to_wall < to_plane {
                molecule.r = 1.0;
                (molecule.along, molecule.around) = gas::parallel(rng);
                molecule.outward = -gas::leaving(rng);
                molecule.rotation = model.rotation(rng);
                continue;
            }
            molecule.z = plane;
            let forward = molecule.along > 0.0;
            if space != Space::Within && molecule.r >= 1.0 {
                (molecule.outward, molecule.around) = gas::parallel(rng);
                molecule.along = if forward { -gas::leaving(rng) } else { gas::leaving(rng) };
                molecule.rotation = model.rotation(rng);
                continue;
            }
            let tube = if self.length > 0.0 {
                Space::Within
            } else if forward {
                Space::Behind
            } else {
                Space::Before
            };
            let at_entrance = self.length <= 0.0 || plane == 0.0;
            passed.entered += if !at_entrance {
                0
            } else if forward {
                1
            } else {
                -1
            };
            space = match (space, forward) {
                (Space::Before | Space::Behind, _) => tube,
                (Space::Within, true) => Space::Behind,
                (Space::Within, false) => Space::Before,
            };
            // A molecule on a plane belongs to the space that it enters.
            if !forward {
                molecule.z -= 1e-12;
            }
        }
    }

    fn space(&self, z: f64) -> Space {
        if z < 0.0 {
            Space::Before
        } else if z < self.length {
            Space::Within
        } else {
            Space::Behind
        }
    }

    fn outside(&self, space: Space, molecule: &Molecule) -> bool {
        match space {
            Space::Before => -molecule.z >= self.reach() || molecule.r >= self.reach(),
            Space::Within => false,
            Space::Behind => {
                let reach = self.reach_behind();
                molecule.z - self.length >= reach || molecule.r >= reach
            }
        }
    }
}

/// The cross-section of a ring.
fn ring(number: u32, side: f64) -> f64 {
    let (inner, outer) = (f64::from(number) * side, f64::from(number + 1) * side);
    PI * (outer * outer - inner * inner)
}

/// The time until a molecule in the tube meets its wall.
fn to_wall(molecule: &Molecule) -> f64 {
    let square = molecule.outward * molecule.outward + molecule.around * molecule.around;
    let half = molecule.r * molecule.outward;
    let root = (half * half + square * (1.0 - molecule.r * molecule.r).max(0.0)).sqrt();
    // At the wall and outward: at once.
    ((root - half) / square).max(0.0)
}

/// A straight path, seen from the axis.
fn advance(molecule: &mut Molecule, time: f64) {
    molecule.z += molecule.along * time;
    let (ahead, aside) = (molecule.r + molecule.outward * time, molecule.around * time);
    let r = ahead.hypot(aside);
    if r > 0.0 {
        let (outward, around) = (molecule.outward, molecule.around);
        molecule.outward = (outward * ahead + around * aside) / r;
        molecule.around = (around * ahead - outward * aside) / r;
    }
    molecule.r = r;
}
