//! Pumps: roughing pumps, which exhaust to atmosphere, and turbomolecular pumps, which need a backing pump.

use crate::atmosphere::ROOM_K;
use crate::conductance::Conductance;
use crate::gas::{GAS_COUNT, Gas, Mixture};

/// A roughing pump: its flow is `S (p - p_ult)`, which is 0 at its ultimate pressure.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Roughing {
    /// Pumping speed S, in m^3/s.
    pub speed: f64,
    /// Ultimate pressure of each gas, in Pa.
    pub ultimate: Mixture,
    /// Whether the pump runs. Its valve closes when it stops.
    pub running: bool,
}

impl Roughing {
    /// A dry pump with a pumping speed in m^3/s. Its residual gas is, by free choice, half water and half nitrogen.
    #[must_use]
    pub fn dry(speed: f64, ultimate_pa: f64) -> Self {
        let mut ultimate = Mixture::pure(Gas::N2, ultimate_pa / 2.0);
        ultimate[Gas::H2o] = ultimate_pa / 2.0;
        Self { speed, ultimate, running: true }
    }
}

/// A turbomolecular pump between an inlet and a fore line.
///
/// The forward flow is `S p` and the backward flow `S/K p`, so without net flow the pressure ratio is the compression K. ln K
/// is proportional to the ratio of blade speed and molecular speed, thus to sqrt(M) (general knowledge), and falls to 0 above
/// the critical backing pressure. A stopped or braked rotor acts as an opening.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Turbo {
    /// Pumping speed for nitrogen, in m^3/s.
    pub speed: f64,
    /// Compression of nitrogen.
    pub compression: f64,
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

/// Time constant of the last stages, in s. free choice
const FELT_S: f64 = 0.5;

impl Turbo {
    /// A typical pump with a pumping speed in m^3/s, at standstill.
    ///
    /// free choice: compression 1e9 for nitrogen, which by sqrt(M) is 2500 for helium and 260 for hydrogen (classical turbos of
    /// the catalogues have 1e9 and 1e2 to 1e4), critical backing pressure 10 mbar, brake 0.1 mbar, two minutes to full speed.
    #[must_use]
    pub const fn ordinary(speed: f64) -> Self {
        Self {
            speed,
            compression: 1e9,
            critical_pa: 1e3,
            brake_pa: 10.0,
            spin_up_s: 120.0,
            standstill: Conductance::fixed(0.0),
            running: false,
            rotor: 0.0,
            stage_pa: 0.0,
        }
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

    /// Forward and backward conductance of each gas, in m^3/s. `roots` is sqrt(M/28) of each gas.
    pub(crate) fn passes(&self, inlet_pa: f64, fore_pa: f64, roots: &[f64; GAS_COUNT]) -> [[f64; GAS_COUNT]; 2] {
        let (molecular, viscous) = self.standstill.parts_at((inlet_pa + fore_pa) / 2.0);
        let speed = self.speed * self.rotor + (molecular + viscous) * (1.0 - self.rotor);
        let over = self.stage_pa / self.critical_pa;
        let exponent = self.rotor * self.compression.ln() / (1.0 + over.powi(4));
        [[speed; GAS_COUNT], roots.map(|root| speed * (-exponent * root).exp())]
    }
}

/// sqrt(M/28) of each gas.
pub(crate) fn mass_roots() -> [f64; GAS_COUNT] {
    crate::conductance::relative_speeds().map(f64::recip)
}

/// Converts a flow in standard cubic centimetres per minute (at 0 °C and 1013.25 mbar) to Pa m^3/s at room temperature, the
/// temperature of all gas in this crate.
#[must_use]
pub fn flow_of_sccm(sccm: f64) -> f64 {
    sccm * crate::atmosphere::STANDARD_PA * 1e-6 / 60.0 * ROOM_K / 273.15
}

#[cfg(test)]
mod tests {
    use super::*;

    fn turning(rotor: f64) -> Turbo {
        Turbo { rotor, running: true, standstill: Conductance::fixed(0.03), ..Turbo::ordinary(0.3) }
    }

    #[test]
    fn the_compression_depends_on_the_molar_mass() {
        let [forward, back] = turning(1.0).passes(1e-6, 1.0, &mass_roots());
        let ratio = |gas: Gas| forward[gas as usize] / back[gas as usize];
        assert!((ratio(Gas::N2) / 1e9 - 1.0).abs() < 1e-6);
        assert!((200.0..400.0).contains(&ratio(Gas::H2)), "{}", ratio(Gas::H2));
        assert!(ratio(Gas::Ar) > 1e10);
    }

    #[test]
    fn a_stopped_rotor_and_a_pump_above_the_critical_pressure_compress_nothing() {
        for [forward, back] in [
            turning(0.0).passes(1.0, 1.0, &mass_roots()),
            Turbo { stage_pa: 1e4, ..turning(1.0) }.passes(1.0, 1e4, &mass_roots()),
        ] {
            let ratio = forward[Gas::N2 as usize] / back[Gas::N2 as usize];
            assert!(ratio < 1.01, "{ratio}");
        }
        let [forward, _] = turning(0.0).passes(1.0, 1.0, &mass_roots());
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
        // By definition: 1 cm^3 at 1013.25 mbar and 0 °C per minute is 0.01689 mbar l/s.
        assert!((flow_of_sccm(1.0) * 273.15 / ROOM_K / 1.689e-3 - 1.0).abs() < 1e-3);
    }
}
