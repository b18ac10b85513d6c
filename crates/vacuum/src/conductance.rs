//! Conductance of openings, tubes and leaks, from molecular to choked flow.
//!
//! The flow from pressure p1 to p2 passes an opening and a tube in series, with the pressure px between them:
//!
//! | Part | Flow relative to A v/4 of the mean gas | Source |
//! |---|---|---|
//! | molecular | the transmission probability W(l/r) of opening and tube | Berman, J. Appl. Phys. 36 (1965) 3356 |
//! | opening | (1 - s) (p1 - px) + s q_v, s = δ^1.16 / (2.45 + δ^1.16); q_v: the nozzle W_c p1 ψ(px/p1), for small differences (1.49 + 0.376 δ) (p1 - px), and between them both in series | isentropic nozzle, Sampson's law; s, 1.49 and the part in series: fitted to the table below |
//! | tube | q ((1 - s) (1/W - 1) + s (3 l/8 r + 0.25 l/(l + 3.7 r))) = G(δ)/G(0) (px - pe) - inertia; it leaves at the speed of sound at most: pe ≥ s (pc/p1) q / W_c | G: Sharipov and Seleznev, J. Phys. Chem. Ref. Data 27 (1998) 657, with a minimum that is shallower by l/(l + 3.95 r) |
//! | inertia | 3√π/32 δ s 1.6 q² / 2π ln(px/pe) / (1 + δ r / 910 l) | momentum of isothermal laminar flow, general knowledge; 1.6 and 910 fitted |
//!
//! The fitted numbers bring the flow into vacuum within 3 % of that of colliding molecules, for tubes from 0 to 10 radii and δ from
//! 0.3 to 100 (`tests/collisions`, table in docs/vacuum.md).
//!
//! δ = p r / (η v_p) is the rarefaction parameter, with the most probable speed v_p = sqrt(2 R T / M). In molecular flow each
//! gas flows independently, with the root of its mass; the rest of the flow takes all gases alike.

use crate::atmosphere::{ROOM_K, STANDARD_PA};
use crate::gas::{GAS_COUNT, Gas, Mixture};
use std::f64::consts::PI;

/// The gas constant, in J/(mol K).
pub const R: f64 = 8.314_463;

/// The rarefaction parameter below which the flow through a tube is linear in the pressures, to 1e-3.
const LINEAR: f64 = 0.03;

/// The largest conductance of an opening in viscous flow relative to A v/4. It limits the conductance for pressure differences
/// below 0.4 %, where the root of the nozzle law would make it infinite. chosen
const STEEPEST: f64 = 60.0;

/// The discharge coefficient of a thin opening with sharp edges for a diatomic gas: nitrogen flows into vacuum at 1.51 times its
/// molecular flow, and isentropic at 1.72 times. Fitted to the flows of colliding molecules (`tests/collisions`); Fujimoto and
/// Usami, J. Fluids Eng. 106 (1984) 367, measured 1.51 (formula from memory).
pub const SHARP_DISCHARGE: f64 = 0.88;

/// The loss of a sharp edge rises by this part per unit of the ratio of specific heats: a monatomic gas flows into vacuum at 1.53 times
/// its molecular flow (Sharipov, J. Fluid Mech. 518 (2004) 35, from memory), and isentropic at 1.82 times.
const LOSS_BY_HEAT_RATIO: f64 = 1.21;

/// The viscous part of the flow into an opening is δ^SHARE / (HALF + δ^SHARE).
const SHARE: f64 = 1.16;
const HALF: f64 = 2.45;

/// The viscous flow of small differences relative to molecular flow: this number, and 0.376 δ by Sampson's law.
const SMALL: f64 = 1.49;
const SAMPSON: f64 = 0.376;

/// Gas behind a tube joins the flow of small differences and that of a nozzle in series by this part, times the fourth root of the
/// quotient of the pressures; behind a thin opening by the second part, times the square of the quotient.
const SERIES: f64 = 0.45;
const THIN_SERIES: f64 = 0.1;

/// An opening is thin for tubes up to about this length in radii. The jet through a longer one touches its wall again.
const THIN: f64 = 0.05;

/// The contraction of an incompressible jet behind a thin opening with sharp edges (Kirchhoff: π/(π + 2)).
const CONTRACTION: f64 = 0.611;

/// The force that the walls about such an opening lack, for the momentum of the jet (Jobson, Proc. Inst. Mech. Eng. 169 (1955) 767).
const FORCE_DEFECT: f64 = 1.0 / CONTRACTION - 0.5 / (CONTRACTION * CONTRACTION);

/// The momentum of the flow in a tube relative to that of a uniform flow: 4/3 for a parabola, more with the losses where it forms.
const MOMENTUM: f64 = 1.6;

/// A flow becomes a parabola within about δ/910 radii of a tube; in a shorter one it stays uniform, and needs no more momentum.
const UNIFORM: f64 = 910.0;

/// Poiseuille's law in the units of [`TubeFlow`]: 3 sqrt(pi) / 32 per δ.
const LAMINAR: f64 = 0.166_167;

/// The friction at the entrance of a tube in viscous flow, beside that of Poiseuille's law, for tubes of some radii.
const ENTRANCE: f64 = 0.25;
const ENTRANCE_LENGTH: f64 = 3.7;

/// In a tube of this length in radii half of the molecules that fly far along a long tube reach its wall or end instead.
const FAR: f64 = 3.95;

/// The flow of air from 1 atm at which half of a leak is viscous, in Pa m³/s (3e-6 mbar l/s).
///
/// Leaks are molecular below 1e-7 mbar l/s, laminar above 1e-4 mbar l/s and between them in transition (Leakage Testing Handbook
/// of the Jet Propulsion Laboratory, after leakdetection-technology.com, "The flow of gases in leaks"). This is the middle.
const HALF_VISCOUS: f64 = 3e-7;

/// The mean speed of the molecules of a gas at room temperature, in m/s.
#[must_use]
pub fn mean_speed_m_per_s(gas: Gas) -> f64 {
    mean_speed(gas.molar_mass_kg_per_mol())
}

fn mean_speed(molar_mass: f64) -> f64 {
    (8.0 * R * ROOM_K / (PI * molar_mass)).sqrt()
}

/// The mean speed of each gas relative to nitrogen: sqrt(28/M), in the order of [`Gas::all`].
pub(crate) fn relative_speeds() -> [f64; GAS_COUNT] {
    let mut relative_speeds = [1.0; GAS_COUNT];
    for (target, gas) in relative_speeds.iter_mut().zip(Gas::all()) {
        *target = (Gas::N2.molar_mass_kg_per_mol() / gas.molar_mass_kg_per_mol()).sqrt();
    }
    relative_speeds
}

/// The transmission probability of a round tube in molecular flow, for its length divided by its radius.
///
/// Berman 1965; above 1000 its asymptote.
#[must_use]
pub fn transmission(length_per_radius: f64) -> f64 {
    let l = length_per_radius;
    if l < 1e-6 {
        return 1.0;
    }
    if l > 1e3 {
        return 8.0 / (3.0 * l) - (2.0 * l.ln() + 91.0 / 18.0) / (l * l);
    }
    let root = (l * l + 4.0).sqrt();
    let above = (8.0 - l * l) * root + l.powi(3) - 16.0;
    let below = 72.0 * l * root - 288.0 * (l + root).ln() + 288.0 * 2.0_f64.ln();
    // Both vanish with the third power of a short tube.
    let last = if l < 1e-2 { 0.0 } else { above * above / below };
    1.0 + l * l / 4.0 - l / 4.0 * root - last
}

/// The Poiseuille coefficient of a long tube relative to molecular flow, for a rarefaction parameter: the interpolation of the
/// kinetic solutions that Sharipov and Seleznev (1998) tabulate.
#[must_use]
pub fn long_tube_factor(delta: f64) -> f64 {
    tube_factor(delta, 1.0)
}

/// [`long_tube_factor`] for a tube in which molecules fly as far as in a long one with this share: a short tube has no minimum.
fn tube_factor(delta: f64, far: f64) -> f64 {
    const MOLECULAR: f64 = 1.504_5;
    molecular_part(delta, far) + (0.25 * delta + 1.018) * delta / (1.0 + delta) / MOLECULAR
}

/// The part of [`tube_factor`] that vanishes in viscous flow.
fn molecular_part(delta: f64, far: f64) -> f64 {
    if delta <= 0.0 {
        return 1.0;
    }
    (1.0 + 0.04 * far * delta.powf(0.7) * delta.ln()) / (1.0 + 0.78 * far * delta.powf(0.8))
}

/// The largest flow through a nozzle divided by A p1 sqrt(R T / M): isentropic, for a ratio of specific heats.
#[must_use]
pub fn choked_factor(heat_ratio: f64) -> f64 {
    let exponent = (heat_ratio + 1.0) / (2.0 * (heat_ratio - 1.0));
    heat_ratio.sqrt() * (2.0 / (heat_ratio + 1.0)).powf(exponent)
}

/// The flow through a nozzle relative to the choked one, for the ratio of the pressures behind and before it.
///
/// The ellipse of ISO 6358 about the critical ratio; it deviates from the isentropic function by less than 0.5 %.
#[must_use]
pub fn discharge(ratio: f64, heat_ratio: f64) -> f64 {
    let critical = (2.0 / (heat_ratio + 1.0)).powf(heat_ratio / (heat_ratio - 1.0));
    ellipse(ratio, critical)
}

fn ellipse(ratio: f64, critical: f64) -> f64 {
    let beyond = ((ratio - critical) / (1.0 - critical)).max(0.0);
    (1.0 - beyond * beyond).max(0.0).sqrt()
}

/// The flow of a gas through a thin opening with sharp edges, divided by A sqrt(p1 ρ1), for the quotient of the pressures: the jet
/// contracts less, the lower the pressure behind, and so the flow rises below the critical quotient too.
///
/// From the balance of momentum with [`FORCE_DEFECT`] (Jobson 1955).
fn jet(ratio: f64, heat_ratio: f64, critical: f64) -> f64 {
    if ratio >= 1.0 {
        return 0.0;
    }
    let throat = ratio.max(critical);
    let density = throat.powf(heat_ratio.recip());
    let square = 2.0 * heat_ratio / (heat_ratio - 1.0) * density * density * (1.0 - throat / density);
    let momentum = square / density + throat - ratio;
    let root = (momentum * momentum - 4.0 * FORCE_DEFECT * square * (1.0 - ratio)).max(0.0).sqrt();
    2.0 * (1.0 - ratio) / (momentum + root) * square.sqrt()
}

/// A gas as a continuum: the mean properties of a mixture.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bulk {
    /// Total pressure, in Pa.
    pub pa: f64,
    /// Mean molar mass, in kg/mol.
    pub molar_mass: f64,
    /// Viscosity in Pa s, with weights of the root of the molar mass (Herning and Zipperer 1936).
    pub viscosity: f64,
    /// Ratio of specific heats.
    pub heat_ratio: f64,
}

/// The weights of each gas in the sums of [`Bulk`].
#[derive(Clone, Copy, Debug, Default)]
struct Weights {
    mass: f64,
    root: f64,
    drag: f64,
    heat: f64,
}

/// Below this pressure in Pa the properties of the mixture do not matter: the flow is molecular in every tube of up to a metre.
const THIN_PA: f64 = 1e-5;

impl Bulk {
    /// The mean properties of partial pressures in the order of [`Gas::all`], each multiplied by `scale` to be in Pa.
    pub(crate) fn of(parts: &[f64; GAS_COUNT], scale: f64) -> Self {
        let sum: f64 = parts.iter().sum();
        let pa = sum * scale;
        if pa < THIN_PA {
            return Self::nitrogen(pa);
        }
        let mut total = Weights::default();
        for (part, weights) in parts.iter().zip(WEIGHTS.iter()) {
            total.mass += part * weights.mass;
            total.root += part * weights.root;
            total.drag += part * weights.drag;
            total.heat += part * weights.heat;
        }
        Self { pa, molar_mass: total.mass / sum, viscosity: total.drag / total.root, heat_ratio: total.heat / sum }
    }

    /// The mean properties of a mixture.
    #[must_use]
    pub fn of_mixture(mixture: &Mixture) -> Self {
        Self::of(mixture.as_array(), 1.0)
    }

    const fn nitrogen(pa: f64) -> Self {
        Self {
            pa,
            molar_mass: Gas::N2.molar_mass_kg_per_mol(),
            viscosity: Gas::N2.viscosity_pa_s(),
            heat_ratio: Gas::N2.heat_ratio(),
        }
    }

    /// The rarefaction parameter at this pressure for a radius in m, divided by the pressure.
    fn delta_per_pa(&self, radius: f64) -> f64 {
        radius / (self.viscosity * (2.0 * R * ROOM_K / self.molar_mass).sqrt())
    }
}

static WEIGHTS: std::sync::LazyLock<[Weights; GAS_COUNT]> = std::sync::LazyLock::new(|| {
    let mut weights = [Weights::default(); GAS_COUNT];
    for (weights, gas) in weights.iter_mut().zip(Gas::all()) {
        let mass = gas.molar_mass_kg_per_mol();
        *weights =
            Weights { mass, root: mass.sqrt(), drag: mass.sqrt() * gas.viscosity_pa_s(), heat: gas.heat_ratio() };
    }
    weights
});

/// A conductance: gas flow per pressure difference.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Conductance {
    /// A molecular conductance at every pressure, in m³/s for nitrogen.
    Fixed(f64),
    /// A conductance for all gases alike at every pressure, in m³/s.
    Viscous(f64),
    /// A leak: `molecular` in m³/s for nitrogen, and `laminar` in m³/s per Pa of mean pressure for the viscosity of air.
    Leak {
        /// The molecular conductance for nitrogen, in m³/s.
        molecular: f64,
        /// The laminar conductance per mean pressure, for air, in m³/s per Pa.
        laminar: f64,
    },
    /// A round tube with its opening.
    Tube(Tube),
}

/// A round tube with its opening.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Tube {
    radius: f64,
    area: f64,
    /// The transmission probability in molecular flow.
    transmission: f64,
    /// Its length divided by its radius.
    length: f64,
    /// The discharge coefficient of the opening for a diatomic gas in viscous flow.
    discharge: f64,
}

/// The molecular part (for nitrogen) and the viscous part (for all gases alike) of a conductance, both in m³/s.
pub type Parts = (f64, f64);

impl Conductance {
    /// A molecular conductance at every pressure, in m³/s for nitrogen.
    #[must_use]
    pub const fn fixed(m3_per_s: f64) -> Self {
        Self::Fixed(m3_per_s)
    }

    /// A conductance of the same size for all gases at every pressure, in m³/s.
    #[must_use]
    pub const fn viscous(m3_per_s: f64) -> Self {
        Self::Viscous(m3_per_s)
    }

    /// A leak with this flow of dry air from 1 atm into vacuum, in Pa m³/s. Small leaks are molecular, large ones laminar.
    #[must_use]
    pub fn leak(flow: f64) -> Self {
        let viscous = flow / (flow + HALF_VISCOUS);
        let to_nitrogen = (Gas::Air.molar_mass_kg_per_mol() / Gas::N2.molar_mass_kg_per_mol()).sqrt();
        Self::Leak {
            molecular: (1.0 - viscous) * flow / STANDARD_PA * to_nitrogen,
            laminar: 2.0 * viscous * flow / (STANDARD_PA * STANDARD_PA),
        }
    }

    /// A round tube with a rounded opening; diameter and length in m. A length of 0 is a thin opening.
    #[must_use]
    pub fn tube(diameter_m: f64, length_m: f64) -> Self {
        Self::tube_with_discharge(diameter_m, length_m, 1.0)
    }

    /// A round tube with the discharge coefficient of its opening: 1 for a rounded one, [`SHARP_DISCHARGE`] for sharp edges.
    #[must_use]
    pub fn tube_with_discharge(diameter_m: f64, length_m: f64, discharge: f64) -> Self {
        let radius = diameter_m / 2.0;
        let length = length_m / radius;
        Self::Tube(Tube { radius, area: PI * radius * radius, transmission: transmission(length), length, discharge })
    }

    /// The molecular conductance for nitrogen, in m³/s.
    #[must_use]
    pub fn molecular(&self) -> f64 {
        match self {
            Self::Fixed(molecular) | Self::Leak { molecular, .. } => *molecular,
            Self::Viscous(_) => 0.0,
            Self::Tube(tube) => tube.area * tube.transmission * mean_speed_m_per_s(Gas::N2) / 4.0,
        }
    }

    /// The conductance between two gases, for the difference of their pressures.
    #[must_use]
    pub fn parts(&self, one: &Bulk, other: &Bulk) -> Parts {
        let (high, low) = if one.pa >= other.pa { (one, other) } else { (other, one) };
        match self {
            Self::Fixed(molecular) => (*molecular, 0.0),
            Self::Viscous(viscous) => (0.0, *viscous),
            Self::Leak { molecular, laminar } => {
                let fluidity = Gas::Air.viscosity_pa_s() / high.viscosity;
                (*molecular, laminar * fluidity * f64::midpoint(high.pa, low.pa))
            }
            Self::Tube(tube) => tube.parts(high, low.pa),
        }
    }
}

/// The flow of one gas between two pressures through a tube, with all flows relative to A v/4 and in Pa.
struct TubeFlow<'a> {
    tube: &'a Tube,
    delta_per_pa: f64,
    /// The choked flow per pressure, and without the loss of the edge.
    choked: f64,
    lossless: f64,
    critical: f64,
    /// The part of the flow into the opening that contracts as behind a thin one with sharp edges, 0 to 1.
    contracting: f64,
    /// Its flow into vacuum, for [`jet`].
    jet: f64,
    heat_ratio: f64,
    /// The viscous part of the flow into the opening, 0 to 1.
    viscous: f64,
    /// See [`tube_factor`].
    far: f64,
    /// The inertia of the flow, divided by its square and the logarithm of the pressures.
    inertia: f64,
    high_pa: f64,
    /// See [`SERIES`].
    series: f64,
}

impl Tube {
    fn parts(&self, high: &Bulk, low_pa: f64) -> Parts {
        let speed = mean_speed(high.molar_mass) / 4.0;
        let delta_per_pa = high.delta_per_pa(self.radius);
        let delta = delta_per_pa * high.pa;
        let powered = delta.powf(SHARE);
        let viscous = powered / (HALF + powered);
        // sqrt(R T / M) is sqrt(pi/8) of the mean speed.
        let lossless = choked_factor(high.heat_ratio) * (2.0 * PI).sqrt();
        let loss = (1.0 - self.discharge) * LOSS_BY_HEAT_RATIO * (high.heat_ratio - 1.4);
        let uniform = if self.length > 0.0 { 1.0 / (1.0 + delta / (UNIFORM * self.length)) } else { 0.0 };
        let critical = (2.0 / (high.heat_ratio + 1.0)).powf(high.heat_ratio / (high.heat_ratio - 1.0));
        let sharp = ((1.0 - self.discharge) / (1.0 - SHARP_DISCHARGE)).clamp(0.0, 1.0);
        let contracting = if self.thin() > 1e-3 { sharp * self.thin() } else { 0.0 };
        // Equal pressures have the conductance of almost equal ones.
        let low_pa = low_pa.min(high.pa * (1.0 - 1e-7));
        let flow = TubeFlow {
            tube: self,
            delta_per_pa,
            choked: (self.discharge - loss) * lossless,
            lossless,
            critical,
            contracting,
            jet: if contracting > 0.0 { jet(0.0, high.heat_ratio, critical) } else { 1.0 },
            heat_ratio: high.heat_ratio,
            viscous,
            far: self.length / (self.length + FAR),
            inertia: LAMINAR * delta_per_pa * viscous * MOMENTUM * uniform / (2.0 * PI),
            high_pa: high.pa,
            series: if high.pa > 0.0 { self.series(low_pa / high.pa) } else { 0.0 },
        };
        let whole = if delta < LINEAR { flow.linear(low_pa) } else { flow.between(low_pa) / (high.pa - low_pa) };
        let mean = delta_per_pa * f64::midpoint(high.pa, low_pa);
        // In dense gas the molecular part of the tube's law is part of the viscous flow.
        let share = (molecular_part(mean, 1.0) / (1.0 + (mean / 40.0).powi(2))).min(whole / self.transmission);
        let molecular = share * self.transmission;
        let nitrogen = self.area * mean_speed_m_per_s(Gas::N2) / 4.0;
        (molecular * nitrogen, (whole - molecular).max(0.0) * self.area * speed)
    }
}

impl Tube {
    /// Whether the opening is thin, 1 to 0.
    fn thin(&self) -> f64 {
        1.0 / (1.0 + (self.length / THIN).powi(2))
    }

    /// See [`SERIES`].
    fn series(&self, ratio: f64) -> f64 {
        let thin = self.thin();
        SERIES * ratio.sqrt().sqrt() * (1.0 - thin) + THIN_SERIES * ratio * ratio * thin
    }
}

impl TubeFlow<'_> {
    /// The viscous flow through the opening relative to that into vacuum, for the quotient of the pressures.
    fn shape(&self, ratio: f64) -> f64 {
        let attached = ellipse(ratio, self.critical);
        if self.contracting > 0.0 {
            let contracted = jet(ratio, self.heat_ratio, self.critical) / self.jet;
            attached + self.contracting * (contracted - attached)
        } else {
            attached
        }
    }

    /// The conductance where it hardly depends on the pressures.
    fn linear(&self, low_pa: f64) -> f64 {
        let opening = self.opening(low_pa) / (self.high_pa - low_pa);
        let mean = self.delta_per_pa * f64::midpoint(self.high_pa, low_pa);
        let tube = tube_factor(mean, self.far) / self.resistance();
        if tube.is_finite() { opening * tube / (opening + tube) } else { opening }
    }

    /// The resistance of the tube without its opening: molecular, then Poiseuille's with that of the entrance.
    fn resistance(&self) -> f64 {
        let length = self.tube.length;
        let molecular = self.tube.transmission.recip() - 1.0;
        let laminar = 3.0 / 8.0 * length + ENTRANCE * length / (length + ENTRANCE_LENGTH);
        molecular + self.viscous * (laminar - molecular)
    }

    /// The flow through opening and tube: the pressure between them follows from equal flows (Anderson and Björck's method).
    fn between(&self, low_pa: f64) -> f64 {
        let resistance = self.resistance();
        if resistance < 1e-9 {
            return self.opening(low_pa);
        }
        let excess = |pa: f64| self.excess(pa, low_pa, resistance);
        let (mut low, mut high) = (low_pa, self.high_pa);
        let (mut at_low, mut at_high) = (excess(low), excess(high));
        let mut pa = low;
        for _ in 0..60 {
            pa = (low * at_high - high * at_low) / (at_high - at_low);
            let found = excess(pa);
            if found.abs() < 1e-9 {
                break;
            }
            // The end that stays weighs less, so that both ends move.
            let less = |before: f64| Some(1.0 - found / before).filter(|less| *less > 0.0).unwrap_or(0.5);
            if found > 0.0 {
                at_high *= less(at_low);
                (low, at_low) = (pa, found);
            } else {
                at_low *= less(at_high);
                (high, at_high) = (pa, found);
            }
        }
        self.opening(pa)
    }

    /// The flow through the opening to a pressure.
    fn opening(&self, pa: f64) -> f64 {
        let difference = self.high_pa - pa;
        let nozzle = self.choked * self.high_pa * self.shape(pa / self.high_pa);
        let slope = SMALL + SAMPSON * self.delta_per_pa * self.high_pa;
        // See STEEPEST for the limit.
        let steepest = difference * slope.min(STEEPEST);
        let ratio = (nozzle / steepest).powi(4);
        let apart = if ratio.is_finite() { nozzle / (1.0 + ratio).sqrt().sqrt() } else { steepest };
        let small = difference * slope;
        let in_series = if small > 0.0 { nozzle * small / (nozzle + small) } else { 0.0 };
        let viscous = apart + self.series * (in_series - apart).min(0.0);
        (1.0 - self.viscous) * difference + self.viscous * viscous
    }

    /// The pressure at which a flow leaves a tube with the speed of sound: below it the flow would need more pressure for its momentum than
    /// friction leaves, so that pe G(δ)/G(0) = inertia / ln(px/pe), with the slip flow in G.
    fn sonic(&self, flow: f64) -> f64 {
        const SLIP: f64 = 1.018 / 1.504_5;
        let square = self.inertia * flow * flow;
        // Of the quadratic equation, without a difference of nearly equal numbers.
        2.0 * square / (SLIP + (SLIP * SLIP + 4.0 * LAMINAR * self.delta_per_pa * square).sqrt())
    }

    /// What the flow into the opening needs to pass the tube, less what the pressures give, relative to their sum: 1 to -1. It needs
    /// friction and inertia, and leaves at the speed of sound at most.
    fn excess(&self, pa: f64, low_pa: f64, resistance: f64) -> f64 {
        let flow = self.opening(pa);
        // The static pressure of choked flow that fills the tube is the critical part of that before the opening.
        let choked = (1.0 - self.contracting) * self.viscous * self.critical / self.lossless * flow;
        let exit = choked.max(self.sonic(flow)).max(low_pa).min(pa);
        let driven = (pa - exit) * tube_factor(self.delta_per_pa * f64::midpoint(pa, exit), self.far);
        let inertia = if exit > 0.0 { self.inertia * flow * flow * (pa / exit).ln() } else { 0.0 };
        let needed = resistance * flow + inertia;
        (needed - driven) / (needed + driven).max(f64::MIN_POSITIVE)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn near(value: f64, expected: f64, relative: f64) {
        assert!((value / expected - 1.0).abs() < relative, "{value} instead of {expected}");
    }

    fn air(pa: f64) -> Bulk {
        Bulk::of_mixture(&Mixture::pure(Gas::Air, pa))
    }

    /// The conductance of a tube for air, in m³/s.
    fn of_air(tube: &Conductance, high_pa: f64, low_pa: f64) -> f64 {
        let (molecular, viscous) = tube.parts(&air(high_pa), &air(low_pa));
        molecular * (Gas::N2.molar_mass_kg_per_mol() / Gas::Air.molar_mass_kg_per_mol()).sqrt() + viscous
    }

    #[test]
    fn conductances_of_air_match_the_textbook() {
        // 11.6 l/s per cm² = 116 m/s; 12.1 d^3/l (cm, l/s) = 121 d^3/l (m, m³/s).
        near(mean_speed_m_per_s(Gas::Air) / 4.0, 116.0, 0.005);
        near(PI / 12.0 * mean_speed_m_per_s(Gas::Air), 121.0, 0.005);
        // 135 d^4/l p (cm, mbar, l/s) = 1350 d^4/l p (m, Pa, m³/s).
        near(PI / (128.0 * Gas::Air.viscosity_pa_s()), 1350.0, 0.005);
    }

    #[test]
    fn short_tubes_have_the_transmission_of_clausing() {
        // Clausing, Ann. Phys. 12 (1932) 961; the values of the exact calculations.
        for (l, expected) in [(1.0, 0.672), (2.0, 0.514), (4.0, 0.357), (10.0, 0.191), (20.0, 0.109)] {
            near(transmission(l), expected, 5e-3);
        }
        near(transmission(1e-6), 1.0, 1e-5);
        near(transmission(999.9), transmission(1000.1), 1e-3);
        near(transmission(0.009_99), transmission(0.010_01), 1e-4);
    }

    #[test]
    fn a_long_tube_has_molecular_then_laminar_flow() {
        let tube = Conductance::tube(0.01, 5.0);
        let molecular = PI / 12.0 * mean_speed_m_per_s(Gas::Air) * 1e-6 / 5.0;
        near(of_air(&tube, 1e-6, 0.0), molecular, 0.01);
        // 1350 d^4/l times the mean pressure.
        near(of_air(&tube, 2000.0, 1900.0), 1350.0 * 1e-8 / 5.0 * 1950.0, 0.02);
        // Between 2000 and 1000 Pa the gas leaves with 51 m/s, which takes 3 % of the pressure difference.
        near(of_air(&tube, 2000.0, 1000.0), 0.97 * 1350.0 * 1e-8 / 5.0 * 1500.0, 0.01);
    }

    #[test]
    fn the_speed_of_sound_limits_the_flow_through_an_opening() {
        let area = PI * 0.05 * 0.05;
        near(of_air(&Conductance::tube(0.1, 0.0), 1e5, 1.0) / area, 200.0, 0.01);
        assert!(of_air(&Conductance::tube(0.1, 0.1), 1e5, 1.0) < 200.0 * area);
        near(of_air(&Conductance::tube_with_discharge(0.1, 0.0, 0.8), 1e5, 1.0) / area, 160.0, 0.01);
    }

    #[test]
    fn a_jet_behind_a_sharp_edge_contracts_less_into_vacuum() {
        let critical = discharge_critical();
        let contraction = |ratio: f64| jet(ratio, 1.4, critical) / nozzle(ratio);
        // Jobson 1955: 0.61 for small differences, 0.87 into vacuum.
        near(contraction(0.999), CONTRACTION, 0.01);
        near(contraction(0.0), 0.872, 0.001);
        near(jet(critical * (1.0 + 1e-9), 1.4, critical), jet(critical * (1.0 - 1e-9), 1.4, critical), 1e-6);
    }

    #[test]
    fn a_thin_opening_has_the_flow_of_one_without_length() {
        for behind in [1.0, 1e4, 5e4, 9e4] {
            let flow =
                |length: f64| of_air(&Conductance::tube_with_discharge(0.1, length, SHARP_DISCHARGE), 1e5, behind);
            near(flow(1e-5), flow(0.0), 0.005);
        }
    }

    fn discharge_critical() -> f64 {
        (2.0_f64 / 2.4).powf(3.5)
    }

    /// The isentropic flow divided by A sqrt(p1 ρ1).
    fn nozzle(ratio: f64) -> f64 {
        let throat = ratio.max(discharge_critical());
        (7.0 * (throat.powf(2.0 / 1.4) - throat.powf(2.4 / 1.4))).sqrt()
    }

    #[test]
    fn the_flow_rises_smoothly_with_the_pressure_and_falls_with_that_behind() {
        let lengths = [0.0, 1e-5, 0.000_3, 0.000_6, 0.001, 0.003, 0.01, 0.1, 10.0];
        for (length, discharge) in lengths.into_iter().flat_map(|length| [(length, 1.0), (length, SHARP_DISCHARGE)]) {
            let tube = Conductance::tube_with_discharge(0.02, length, discharge);
            let mut before = 0.0;
            for tenth in -60..=50 {
                let pa = 10_f64.powf(f64::from(tenth) / 10.0);
                let flow = of_air(&tube, pa, 0.0) * pa;
                assert!(flow > before, "{length} m at {pa} Pa: {flow} after {before}");
                near(of_air(&tube, pa * 1.000_01, 0.0), of_air(&tube, pa, 0.0), 2e-3);
                before = flow;
                let mut behind = flow;
                for part in [1e-3, 0.1, 0.3, 0.5, 0.52, 0.53, 0.54, 0.6, 0.7, 0.8, 0.9, 0.99, 0.9999] {
                    let flow = of_air(&tube, pa, part * pa) * pa * (1.0 - part);
                    assert!(
                        flow <= behind * (1.0 + 1e-6),
                        "{length} m from {pa} Pa to {part} of it: {flow} after {behind}"
                    );
                    behind = flow;
                }
            }
        }
    }

    #[test]
    fn leaks_are_molecular_or_viscous_by_their_size() {
        let ratio = |flow: f64| {
            let leak = Conductance::leak(flow);
            let of = |gas: Gas| {
                let gas_pa = Bulk::of_mixture(&Mixture::pure(gas, STANDARD_PA));
                let (molecular, viscous) = leak.parts(&gas_pa, &air(1e-4));
                molecular * relative_speeds()[gas as usize] + viscous
            };
            near(of(Gas::Air) * STANDARD_PA, flow, 1e-6);
            of(Gas::He) / of(Gas::Air)
        };
        // sqrt(28.97/4.003), and the viscosities 18.2 and 19.6.
        near(ratio(1e-10), 2.69, 0.01);
        near(ratio(1e-3), 0.929, 0.01);
        assert!((1.5..2.6).contains(&ratio(1e-7)), "{}", ratio(1e-7));
    }

    #[test]
    fn light_gases_are_faster_than_nitrogen() {
        let relative_speeds = relative_speeds();
        near(relative_speeds[Gas::H2 as usize], 3.728, 1e-3);
        near(relative_speeds[Gas::Ar as usize], 0.8374, 1e-3);
        near(relative_speeds[Gas::N2 as usize], 1.0, 1e-12);
    }

    #[test]
    fn hydrogen_flows_by_its_own_viscosity() {
        let tube = Conductance::tube(0.01, 5.0);
        let of = |gas: Gas| {
            let [high, low] = [2000.0, 1000.0].map(|pa| Bulk::of_mixture(&Mixture::pure(gas, pa)));
            let (molecular, viscous) = tube.parts(&high, &low);
            molecular * relative_speeds()[gas as usize] + viscous
        };
        near(of(Gas::H2) / of(Gas::Air), 18.2 / 8.8, 0.05);
    }
}
