//! Molecules, their velocities and their collisions.
//!
//! Units: the radius of the tube, the most probable speed of the gas before the tube, the mass of a molecule, and the number
//! density before the tube are 1; k T before the tube is then 1/2.

use fastrand::Rng;
use std::f64::consts::{PI, TAU};

/// A simulated molecule: its place along and off the axis, its velocity there, its rotational energy and its cell.
#[derive(Clone, Copy, Debug)]
pub struct Molecule {
    pub z: f64,
    pub r: f64,
    pub along: f64,
    pub outward: f64,
    pub around: f64,
    pub rotation: f64,
    pub cell: u32,
}

/// How molecules collide: variable hard spheres (Bird 1994), with or without two degrees of freedom of rotation.
#[derive(Clone, Copy, Debug)]
pub struct Model {
    /// The exponent of the viscosity over the temperature: 1/2 for hard spheres.
    exponent: f64,
    /// The gamma function of 5/2 - exponent.
    gamma: f64,
    /// The probability that a collision exchanges rotational energy (Larsen and Borgnakke): 0 for a monatomic gas.
    exchange: f64,
}

impl Model {
    /// Hard spheres without rotation: a monatomic gas.
    pub const SPHERES: Self = Self { exponent: 0.5, gamma: 1.0, exchange: 0.0 };
    /// Nitrogen: exponent 0.74, every fifth collision exchanges rotational energy (Bird 1994).
    pub const NITROGEN: Self = Self { exponent: 0.74, gamma: 0.921_375, exchange: 0.2 };

    /// The cross-section of molecules that approach with speed 1 in a gas of rarefaction parameter `delta`.
    ///
    /// The viscosity of the model is 15 sqrt(π m k T) / (2 (5 - 2w) (7 - 2w) σ), w being the exponent, and δ = p / η.
    pub fn cross_section(&self, delta: f64) -> f64 {
        let w = self.exponent;
        let at_temperature = 2.0 * delta * 15.0 * (PI / 2.0).sqrt() / (2.0 * (5.0 - 2.0 * w) * (7.0 - 2.0 * w));
        at_temperature * 2.0_f64.powf(w - 0.5) / self.gamma
    }

    /// The cross-section times the speed of approach, relative to that of speed 1.
    pub fn rate(&self, speed: f64) -> f64 {
        if self.exponent > 0.5 { speed.powf(2.0 - 2.0 * self.exponent) } else { speed }
    }

    /// Collides two molecules that approach with a speed.
    pub fn collide(&self, one: &mut Molecule, other: &mut Molecule, speed: f64, rng: &mut Rng) {
        let speed = self.exchange_rotation(one, other, speed, rng);
        let along = 2.0 * rng.f64() - 1.0;
        let across = (1.0 - along * along).sqrt();
        let angle = TAU * rng.f64();
        let half = [along, across * angle.cos(), across * angle.sin()].map(|part| part * speed / 2.0);
        let middle =
            [(one.along + other.along) / 2.0, (one.outward + other.outward) / 2.0, (one.around + other.around) / 2.0];
        (one.along, one.outward, one.around) = (middle[0] + half[0], middle[1] + half[1], middle[2] + half[2]);
        (other.along, other.outward, other.around) = (middle[0] - half[0], middle[1] - half[1], middle[2] - half[2]);
    }

    /// Divides the energy of a collision between its motion and the rotation of the molecules; returns the speed after it.
    fn exchange_rotation(&self, one: &mut Molecule, other: &mut Molecule, speed: f64, rng: &mut Rng) -> f64 {
        if self.exchange <= 0.0 {
            return speed;
        }
        let mut motion = speed * speed / 4.0;
        for molecule in [one, other] {
            if rng.f64() < self.exchange {
                let total = motion + molecule.rotation;
                molecule.rotation = total * (1.0 - rng.f64().powf(1.0 / (2.5 - self.exponent)));
                motion = total - molecule.rotation;
            }
        }
        2.0 * motion.sqrt()
    }

    /// The rotational energy of a molecule that leaves a wall or comes from the gas before the tube.
    pub fn rotation(&self, rng: &mut Rng) -> f64 {
        if self.exchange > 0.0 { -0.5 * positive(rng).ln() } else { 0.0 }
    }
}

/// A random number above 0, up to 1.
fn positive(rng: &mut Rng) -> f64 {
    1.0 - rng.f64()
}

/// The two velocities parallel to a surface of a molecule in equilibrium with it.
pub fn parallel(rng: &mut Rng) -> (f64, f64) {
    let (size, angle) = ((-positive(rng).ln()).sqrt(), TAU * rng.f64());
    (size * angle.cos(), size * angle.sin())
}

/// The velocity away from a surface of a molecule that leaves it in equilibrium.
pub fn leaving(rng: &mut Rng) -> f64 {
    (-positive(rng).ln()).sqrt()
}
