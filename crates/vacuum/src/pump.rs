//! Pumps: one that blows into the open, and one that needs another behind it.

use crate::atmosphere::ROOM_K;
use crate::conductance::Conductance;
use crate::gas::{GAS_COUNT, Gas, Mixture};

/// A roughing pump: takes `S (p - p_ult)`, so nothing at its ultimate pressure.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Roughing {
    /// Pumping speed, in m^3/s.
    pub speed: f64,
    /// What it leaves behind, gas by gas: its ultimate pressure.
    pub ultimate: Mixture,
    /// It runs. A pump that stands is closed by its valve.
    pub running: bool,
}

impl Roughing {
    /// A dry pump: what it leaves behind is air and the water in it.
    ///
    /// free choice: half water, half nitrogen.
    #[must_use]
    pub fn dry(speed: f64, ultimate_pa: f64) -> Self {
        let mut ultimate = Mixture::pure(Gas::N2, ultimate_pa / 2.0);
        ultimate[Gas::H2o] = ultimate_pa / 2.0;
        Self { speed, ultimate, running: true }
    }
}

/// A turbomolecular pump between an inlet and a fore line.
///
/// It passes `S p` forward and `S/K p` back, so that the ratio of the pressures is its compression K when nothing flows. ln K
/// grows with the speed of the blades over that of the molecules, so with sqrt(M) (general knowledge), and vanishes above the
/// critical backing pressure. A rotor that stands, or one that gas brakes, is an opening.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Turbo {
    /// Pumping speed for nitrogen, in m^3/s.
    pub speed: f64,
    /// Compression of nitrogen.
    pub compression: f64,
    /// At this pressure in the fore line the logarithm of the compression is half of what it was, in Pa.
    pub critical_pa: f64,
    /// At this pressure at the inlet the rotor turns half as fast, in Pa.
    pub brake_pa: f64,
    /// From standstill to full speed, in s, and back.
    pub spin_up_s: f64,
    /// What passes the rotor when it stands.
    pub standstill: Conductance,
    /// The motor is on.
    pub running: bool,
    /// How fast the rotor turns, 0 to 1.
    pub rotor: f64,
    /// The pressure in the fore line as the last stages have it, in Pa.
    pub stage_pa: f64,
}

/// The stages follow the pressure in the fore line within this time, in s. free choice
const FELT_S: f64 = 0.5;

impl Turbo {
    /// An ordinary one of this speed in m^3/s, standing.
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

    /// The same after the rotor has followed its motor and its load for so many seconds, and the stages the fore line.
    pub(crate) fn turned(&self, inlet_pa: f64, fore_pa: f64, seconds: f64) -> Self {
        let aim = if self.running { 1.0 / (1.0 + inlet_pa / self.brake_pa) } else { 0.0 };
        let most = seconds / self.spin_up_s;
        Self {
            rotor: self.rotor + (aim - self.rotor).clamp(-most, most),
            stage_pa: fore_pa + (self.stage_pa - fore_pa) * (-seconds / FELT_S).exp(),
            ..*self
        }
    }

    /// What it passes forward and back, gas by gas, in m^3/s. `roots` is sqrt(M/28) of each.
    pub(crate) fn passes(&self, inlet_pa: f64, fore_pa: f64, roots: &[f64; GAS_COUNT]) -> [[f64; GAS_COUNT]; 2] {
        let (molecules, wind) = self.standstill.parts_at((inlet_pa + fore_pa) / 2.0);
        let speed = self.speed * self.rotor + (molecules + wind) * (1.0 - self.rotor);
        let over = self.stage_pa / self.critical_pa;
        let exponent = self.rotor * self.compression.ln() / (1.0 + over.powi(4));
        [[speed; GAS_COUNT], roots.map(|root| speed * (-exponent * root).exp())]
    }
}

/// sqrt(M/28) of each gas.
pub(crate) fn mass_roots() -> [f64; GAS_COUNT] {
    crate::conductance::relative_speeds().map(f64::recip)
}

/// A flow in Pa m^3/s of so many standard cubic centimetres a minute: at 0 degrees and 1013.25 mbar, as everywhere the
/// gas is counted at room temperature.
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
    fn the_compression_is_that_of_the_gas() {
        let [forward, back] = turning(1.0).passes(1e-6, 1.0, &mass_roots());
        let ratio = |gas: Gas| forward[gas as usize] / back[gas as usize];
        assert!((ratio(Gas::N2) / 1e9 - 1.0).abs() < 1e-6);
        assert!((200.0..400.0).contains(&ratio(Gas::H2)), "{}", ratio(Gas::H2));
        assert!(ratio(Gas::Ar) > 1e10);
    }

    #[test]
    fn nothing_is_compressed_by_a_rotor_that_stands_or_above_the_critical_pressure() {
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
    fn the_rotor_takes_its_time_and_gas_brakes_it() {
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
        // field 5.3: 0.01689 mbar l/s at 0 degrees.
        assert!((flow_of_sccm(1.0) * 273.15 / ROOM_K / 1.689e-3 - 1.0).abs() < 1e-3);
    }
}
