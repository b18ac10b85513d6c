//! Pumps: roughing pumps, which exhaust to atmosphere, turbomolecular pumps, which need a backing pump, and capture pumps, which
//! keep the gas.

use crate::atmosphere::ROOM_K;
use crate::conductance::{Bulk, Conductance};
use crate::gas::{GAS_COUNT, Gas, Mixture};

/// The most points of a [`SpeedCurve`].
pub const MOST_POINTS: usize = 8;

/// The pumping speed of a roughing pump over its inlet pressure, relative to its nominal speed.
///
/// Between the points it is a power of the pressure, beyond them constant.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct SpeedCurve {
    /// The logarithm of the pressure in Pa and that of the factor.
    points: [(f64, f64); MOST_POINTS],
    count: usize,
}

impl SpeedCurve {
    /// A curve through points of inlet pressure in Pa and factor, in the order of the pressure.
    ///
    /// # Errors
    /// [`WrongCurve`] if there are too many points, if they are not in order, or if a number is not above zero.
    pub fn new(points: &[(f64, f64)]) -> Result<Self, WrongCurve> {
        let mut curve = Self { count: points.len(), ..Self::default() };
        if points.len() > MOST_POINTS {
            return Err(WrongCurve::Many(points.len()));
        }
        if !points.iter().all(|(pa, factor)| *pa > 0.0 && *factor > 0.0 && pa.is_finite() && factor.is_finite()) {
            return Err(WrongCurve::NotPositive);
        }
        if points.windows(2).any(|pair| pair[0].0 >= pair[1].0) {
            return Err(WrongCurve::Order);
        }
        for (target, (pa, factor)) in curve.points.iter_mut().zip(points) {
            *target = (pa.ln(), factor.ln());
        }
        Ok(curve)
    }

    /// The factor at an inlet pressure in Pa.
    #[must_use]
    pub fn factor(&self, pa: f64) -> f64 {
        let points = &self.points[..self.count];
        let (Some(first), Some(last)) = (points.first(), points.last()) else { return 1.0 };
        let at = pa.max(f64::MIN_POSITIVE).ln();
        let above = points.windows(2).find(|pair| at < pair[1].0);
        match above {
            _ if at <= first.0 => first.1.exp(),
            Some([(from, low), (to, high)]) => (low + (high - low) * (at - from) / (to - from)).exp(),
            _ => last.1.exp(),
        }
    }
}

/// Why points are not a [`SpeedCurve`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum WrongCurve {
    /// Too many points.
    #[error("expected at most {MOST_POINTS} points of pressure and speed, got {0}")]
    Many(usize),
    /// The pressures do not rise.
    #[error("expected points of pressure and speed in the order of the pressure")]
    Order,
    /// A pressure or a factor is not above zero.
    #[error("expected pressures and speeds above zero")]
    NotPositive,
}

/// A roughing pump: its flow is `S(p) (p - p_ult)`, which is 0 at its ultimate pressure.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Roughing {
    /// Pumping speed S, in m³/s.
    pub speed: f64,
    /// The speed over the inlet pressure.
    pub curve: SpeedCurve,
    /// Ultimate pressure of each gas, in Pa.
    pub ultimate: Mixture,
    /// Whether the pump runs. Its valve closes when it stops.
    pub running: bool,
}

impl Roughing {
    /// A dry pump with a pumping speed in m³/s. chosen: a tenth of its residual gas is water, the rest nitrogen.
    #[must_use]
    pub fn dry(speed: f64, ultimate_pa: f64) -> Self {
        let mut ultimate = Mixture::pure(Gas::N2, 0.9 * ultimate_pa);
        ultimate[Gas::H2o] = 0.1 * ultimate_pa;
        Self { speed, curve: SpeedCurve::default(), ultimate, running: true }
    }
}

/// A capture pump: an ion pump, a getter or a cryopump. It keeps the gas and has a capacity for each gas.
///
/// Its speed for a gas is `S (1 - captured / capacity)`. chosen: the linear fall to the capacity.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Capture {
    /// Pumping speed of each gas, in m³/s (not pressures).
    pub speeds: Mixture,
    /// Capacity for each gas, in Pa m³.
    pub capacities: Mixture,
    /// The total pressure above which it does not pump, in Pa.
    pub highest_pa: f64,
    /// Whether it runs. A stopped pump keeps its gas.
    pub running: bool,
    /// The captured gas, in Pa m³.
    pub captured: Mixture,
}

impl Capture {
    /// The present speed for each gas in m³/s, at a total pressure in Pa.
    pub(crate) fn passes(&self, pa: f64) -> [f64; GAS_COUNT] {
        let mut passes = [0.0; GAS_COUNT];
        if !self.running || pa > self.highest_pa {
            return passes;
        }
        for (target, gas) in passes.iter_mut().zip(Gas::all()) {
            let used = self.captured[gas] / self.capacities[gas];
            *target = if self.capacities[gas] > 0.0 { self.speeds[gas] * (1.0 - used).max(0.0) } else { 0.0 };
        }
        passes
    }
}

/// A turbomolecular pump between an inlet and a fore line.
///
/// The forward flow is `S p` and the backward flow `S/K p`, so without net flow the pressure ratio is the compression K. ln K
/// is proportional to the ratio of blade speed and molecular speed, thus to sqrt(M) (general knowledge), and falls to 0 above
/// the critical backing pressure. A stopped or braked rotor acts as an opening.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Turbo {
    /// Pumping speed for nitrogen, in m³/s.
    pub speed: f64,
    /// The speed for each gas relative to nitrogen.
    pub speed_factors: [f64; GAS_COUNT],
    /// Compression of nitrogen.
    pub compression: f64,
    /// ln K of each gas relative to nitrogen.
    pub compression_exponents: [f64; GAS_COUNT],
    /// Critical backing pressure in Pa: the logarithm of the compression is halved.
    pub critical_pa: f64,
    /// Inlet pressure in Pa at which the rotor has half of its speed.
    pub brake_pa: f64,
    /// Time from standstill to full speed and back, in s.
    pub spin_up_s: f64,
    /// Conductance of the stopped rotor.
    pub standstill: Conductance,
    /// Whether the motor is on.
    pub running: bool,
    /// Speed of the rotor, 0 to 1.
    pub rotor: f64,
    /// Pressure at the last stages, which follows the fore line with a lag, in Pa.
    pub stage_pa: f64,
}

/// Time constant of the last stages, in s. chosen
const FELT_S: f64 = 0.5;

impl Turbo {
    /// A typical pump with a pumping speed in m³/s, at standstill.
    ///
    /// chosen: the same speed for every gas; compression 1e9 for nitrogen, which by sqrt(M) is 2500 for helium and 260 for
    /// hydrogen, critical backing pressure 10 mbar, brake 0.1 mbar, two minutes to full speed.
    #[must_use]
    pub fn ordinary(speed: f64) -> Self {
        Self {
            speed,
            speed_factors: [1.0; GAS_COUNT],
            compression: 1e9,
            compression_exponents: mass_roots(),
            critical_pa: 1e3,
            brake_pa: 10.0,
            spin_up_s: 120.0,
            standstill: Conductance::fixed(0.0),
            running: false,
            rotor: 0.0,
            stage_pa: 0.0,
        }
    }

    /// Sets the pumping speed of a gas, in m³/s.
    #[must_use]
    pub fn with_speed(mut self, gas: Gas, speed: f64) -> Self {
        self.speed_factors[gas as usize] = speed / self.speed;
        self
    }

    /// Sets the compression of a gas.
    #[must_use]
    pub fn with_compression(mut self, gas: Gas, compression: f64) -> Self {
        self.compression_exponents[gas as usize] = compression.ln() / self.compression.ln();
        self
    }

    /// The pump after `seconds`: the rotor follows motor and load, the last stages follow the fore line.
    pub(crate) fn turned(&self, inlet_pa: f64, fore_pa: f64, seconds: f64) -> Self {
        let target = if self.running { 1.0 / (1.0 + inlet_pa / self.brake_pa) } else { 0.0 };
        let max_change = seconds / self.spin_up_s;
        Self {
            rotor: self.rotor + (target - self.rotor).clamp(-max_change, max_change),
            stage_pa: fore_pa + (self.stage_pa - fore_pa) * (-seconds / FELT_S).exp(),
            ..*self
        }
    }

    /// Forward and backward conductance of each gas, in m³/s. `relative` is sqrt(28/M) of each gas.
    pub(crate) fn passes(&self, inlet: &Bulk, fore: &Bulk, relative: &[f64; GAS_COUNT]) -> [[f64; GAS_COUNT]; 2] {
        // The opening of a rotor with nearly all of its speed does not matter, and its calculation takes time.
        let still = if self.rotor > 0.999 { 0.0 } else { 1.0 - self.rotor };
        let (molecular, viscous) = if still > 0.0 { self.standstill.parts(inlet, fore) } else { (0.0, 0.0) };
        let over = self.stage_pa / self.critical_pa;
        let exponent = self.rotor * self.compression.ln() / (1.0 + over.powi(4));
        let mut passes = [[0.0; GAS_COUNT]; 2];
        for gas in 0..GAS_COUNT {
            let speed =
                self.speed * self.speed_factors[gas] * self.rotor + (molecular * relative[gas] + viscous) * still;
            passes[0][gas] = speed;
            passes[1][gas] = speed * (-exponent * self.compression_exponents[gas]).exp();
        }
        passes
    }
}

/// sqrt(M/28) of each gas.
pub(crate) fn mass_roots() -> [f64; GAS_COUNT] {
    crate::conductance::relative_speeds().map(f64::recip)
}

/// Converts a flow in standard cubic centimetres per minute (at 0 °C and 1013.25 mbar) to Pa m³/s at room temperature, the
/// temperature of all gas in this crate.
#[must_use]
pub fn flow_of_sccm(sccm: f64) -> f64 {
    sccm * crate::atmosphere::STANDARD_PA * 1e-6 / 60.0 * ROOM_K / 273.15
}

/// Converts a flow in Pa m³/s of gas at a temperature in K to standard cubic centimetres per minute (at 0 °C and
/// 1013.25 mbar).
#[must_use]
pub fn sccm_of_flow(flow: f64, kelvin: f64) -> f64 {
    flow * 60.0 / (crate::atmosphere::STANDARD_PA * 1e-6) * 273.15 / kelvin
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::conductance::relative_speeds;

    fn n2(pa: f64) -> Bulk {
        Bulk::of_mixture(&Mixture::pure(Gas::N2, pa))
    }

    fn turning(rotor: f64) -> Turbo {
        Turbo { rotor, running: true, standstill: Conductance::fixed(0.03), ..Turbo::ordinary(0.3) }
    }

    #[test]
    fn the_compression_depends_on_the_molar_mass() {
        let [forward, back] = turning(1.0).passes(&n2(1e-6), &n2(1.0), &relative_speeds());
        let ratio = |gas: Gas| forward[gas as usize] / back[gas as usize];
        assert!((ratio(Gas::N2) / 1e9 - 1.0).abs() < 1e-6);
        assert!((200.0..400.0).contains(&ratio(Gas::H2)), "{}", ratio(Gas::H2));
        assert!(ratio(Gas::Ar) > 1e10);
    }

    #[test]
    fn a_stopped_rotor_and_a_pump_above_the_critical_pressure_compress_nothing() {
        for [forward, back] in [
            turning(0.0).passes(&n2(1.0), &n2(1.0), &relative_speeds()),
            Turbo { stage_pa: 1e4, ..turning(1.0) }.passes(&n2(1.0), &n2(1e4), &relative_speeds()),
        ] {
            let ratio = forward[Gas::N2 as usize] / back[Gas::N2 as usize];
            assert!(ratio < 1.01, "{ratio}");
        }
        let [forward, _] = turning(0.0).passes(&n2(1.0), &n2(1.0), &relative_speeds());
        assert_eq!(forward[0], 0.03);
    }

    #[test]
    fn the_rotor_spins_up_in_its_time_and_gas_brakes_it() {
        let mut turbo = Turbo { running: true, ..Turbo::ordinary(0.3) };
        turbo = turbo.turned(0.0, 0.0, 60.0);
        assert_eq!(turbo.rotor, 0.5);
        turbo = turbo.turned(0.0, 0.0, 600.0);
        assert_eq!(turbo.rotor, 1.0);
        turbo = turbo.turned(10.0, 0.0, 600.0);
        assert_eq!(turbo.rotor, 0.5);
        turbo.running = false;
        turbo = turbo.turned(0.0, 0.0, 30.0);
        assert_eq!(turbo.rotor, 0.25);
    }

    #[test]
    fn a_standard_cubic_centimetre_a_minute_is_counted_at_room_temperature() {
        // By definition: 1 cm³ at 1013.25 mbar and 0 °C per minute is 0.01689 mbar l/s.
        assert!((flow_of_sccm(1.0) * 273.15 / ROOM_K / 1.689e-3 - 1.0).abs() < 1e-3);
    }

    #[test]
    fn each_gas_can_have_its_own_speed_and_compression() {
        let turbo = Turbo { rotor: 1.0, ..turning(1.0) }.with_speed(Gas::H2, 0.22).with_compression(Gas::H2, 9e5);
        let [forward, back] = turbo.passes(&n2(1e-6), &n2(1.0), &relative_speeds());
        assert!((forward[Gas::H2 as usize] / 0.22 - 1.0).abs() < 1e-9);
        assert!((forward[Gas::H2 as usize] / back[Gas::H2 as usize] / 9e5 - 1.0).abs() < 1e-9);
        assert!((forward[Gas::N2 as usize] / 0.3 - 1.0).abs() < 1e-9);
    }

    #[test]
    fn the_speed_of_a_roughing_pump_follows_its_curve() {
        let curve = SpeedCurve::new(&[(1.0, 0.5), (100.0, 1.0), (1e5, 0.8)]).unwrap();
        for (pa, factor) in [(1e-3, 0.5), (1.0, 0.5), (10.0, 0.5_f64.sqrt()), (100.0, 1.0), (1e5, 0.8), (1e6, 0.8)] {
            assert!((curve.factor(pa) - factor).abs() < 1e-9, "{pa} Pa: {}", curve.factor(pa));
        }
        assert_eq!(SpeedCurve::default().factor(1.0), 1.0);
        assert_eq!(SpeedCurve::new(&[(2.0, 1.0), (1.0, 1.0)]), Err(WrongCurve::Order));
        assert_eq!(SpeedCurve::new(&[(0.0, 1.0)]), Err(WrongCurve::NotPositive));
        assert_eq!(SpeedCurve::new(&[(1.0, 1.0); 9]), Err(WrongCurve::Many(9)));
    }

    #[test]
    fn a_capture_pump_slows_down_until_it_is_full() {
        let mut pump = Capture {
            speeds: Mixture::pure(Gas::N2, 0.1),
            capacities: Mixture::pure(Gas::N2, 10.0),
            highest_pa: 1e-2,
            running: true,
            captured: Mixture::default(),
        };
        let speed = |pump: &Capture, pa: f64| pump.passes(pa)[Gas::N2 as usize];
        assert_eq!(speed(&pump, 1e-5), 0.1);
        assert_eq!(speed(&pump, 1.0), 0.0, "above its highest pressure");
        pump.captured[Gas::N2] = 5.0;
        assert_eq!(speed(&pump, 1e-5), 0.05);
        pump.captured[Gas::N2] = 11.0;
        assert_eq!(speed(&pump, 1e-5), 0.0);
        assert_eq!(pump.passes(1e-5)[Gas::Ar as usize], 0.0, "a gas that it does not pump");
    }

    #[test]
    fn a_flow_in_sccm_belongs_to_its_temperature() {
        let flow = flow_of_sccm(1.0);
        assert!((sccm_of_flow(flow, ROOM_K) - 1.0).abs() < 1e-12);
        // The divisor 0.016887 mbar l/s applies to gas at 0 °C; at 20 °C the flow is 7.3 % less.
        assert!((sccm_of_flow(0.016_887 * 0.1, 273.15) - 1.0).abs() < 1e-4);
        assert!((sccm_of_flow(0.016_887 * 0.1, ROOM_K) - 0.9318).abs() < 1e-4);
    }
}
