//! Pirani: a wire is kept at a constant temperature, and its heating power is a measure of the pressure.
//!
//! Three mechanisms of heat transfer follow each other with rising pressure: molecular transfer, proportional to the pressure
//! and to the factors of the manual's table; conduction, independent of the pressure; and convection. General knowledge:
//! `P = P_end + eps p / (1 + p / p_c(gas))`, inverted with the curve of nitrogen, so the indication of other gases deviates
//! where their conductivity matters.

use super::Range;
use super::imperfections::Tolerance;
use crate::gas::{Gas, Mixture};

/// The signal up to which the power is proportional to the pressure, in Pa of nitrogen.
///
/// chosen: the manual's factors apply up to 1 mbar of any gas; for the lightest gas this is the signal of 2 mbar.
const MOLECULAR_PA: f64 = 200.0;

/// The limit of conduction through nitrogen, in Pa. General knowledge: `p_c` is about 10 mbar; above 50 mbar conduction
/// hardly depends on the pressure.
const CONDUCTION_PA: f64 = 3_000.0;

/// The pressure at which convection begins, in Pa of nitrogen. General knowledge: above about 50 mbar.
const CONVECTION_FROM_PA: f64 = 5_000.0;

/// The increase of the signal by convection. chosen: a small cell, with an indication of about 70 mbar in argon at
/// atmospheric pressure.
const CONVECTION: f64 = 0.003;

/// Heat transfer relative to nitrogen: thermal conductivity, and density divided by viscosity, which drives convection.
///
/// General knowledge: tables of conductivity and viscosity at 20 to 25 °C and 1 bar. Air has the values of nitrogen, because
/// gauges are calibrated with either.
const fn heat(gas: Gas) -> (f64, f64) {
    match gas {
        Gas::N2 | Gas::Air => (1.0, 1.0),
        Gas::O2 => (1.02, 0.99),
        Gas::Co => (0.97, 1.01),
        Gas::Co2 => (0.64, 1.88),
        Gas::H2o => (0.72, 1.17),
        Gas::He => (6.0, 0.129),
        Gas::Ne => (1.90, 0.404),
        Gas::Ar => (0.69, 1.125),
        Gas::Kr => (0.37, 2.11),
        Gas::Xe => (0.213, 3.62),
        Gas::H2 => (7.05, 0.144),
        Gas::Freon12 => (0.376, 6.08),
    }
}

/// A Pirani element.
#[derive(Clone, Debug)]
pub struct Pirani {
    range: Range,
    /// The contamination of the wire, 0 to 1.
    pub contamination: f64,
}

impl Pirani {
    pub const fn new(range: Range) -> Self {
        Self { range, contamination: 0.0 }
    }

    /// The indication without imperfections, in Pa. It is exact for gases with the conductivity of nitrogen.
    pub fn ideal_pa(gas: &Mixture) -> f64 {
        let heat = Heat::of(gas);
        if heat.is_molecular() || heat.is_like_nitrogen() { heat.molecular } else { Self::nitrogen_pa(heat.signal()) }
    }

    /// The signal. General knowledge: a layer on the wire reduces the heat transfer to the gas and radiates. chosen:
    /// half of the sensitivity and 2e-2 mbar of nitrogen at full contamination.
    pub fn signal(&self, gas: &Mixture) -> f64 {
        Heat::of(gas).signal() * (1.0 - 0.5 * self.contamination) + 2.0 * self.contamination
    }

    /// The pressure of nitrogen for a signal, in Pa. A negative signal is returned unchanged.
    pub fn nitrogen_pa(signal: f64) -> f64 {
        if signal <= MOLECULAR_PA {
            return signal;
        }
        let room = CONDUCTION_PA - MOLECULAR_PA;
        let above = signal - MOLECULAR_PA;
        let conducted = above / (1.0 - above / room);
        if above < room && MOLECULAR_PA + conducted <= CONVECTION_FROM_PA {
            return MOLECULAR_PA + conducted;
        }
        // above = y / (1 + y / room) + k (y - onset), with y the pressure beyond the molecular part.
        let above = above + CONVECTION * (CONVECTION_FROM_PA - MOLECULAR_PA);
        let (a, b) = (CONVECTION / room, 1.0 + CONVECTION - above / room);
        let root = (b * b + 4.0 * a * above).sqrt();
        let y = if b > 0.0 { 2.0 * above / (b + root) } else { (root - b) / (2.0 * a) };
        MOLECULAR_PA + y
    }

    /// chosen, similar to data sheets: 1 % of the power, and a zero error that limits the range at its lower end.
    pub const fn tolerance(&self) -> Tolerance {
        // The Pirani of a combination gauge measures to lower pressures than its manual states.
        let lowest_pa = self.range.lowest_pa.min(0.1);
        Tolerance {
            gain: 0.01,
            zero_pa: 0.4 * lowest_pa,
            zero_pa_per_k: 0.1 * lowest_pa,
            noise: 1e-3,
            floor_pa: 0.1 * lowest_pa,
            drift_pa: 0.1 * lowest_pa,
            lag_s: 0.08,
        }
    }
}

/// The heat transfer of a gas.
struct Heat {
    /// Molecular transfer: the equivalent pressure of nitrogen, in Pa.
    molecular: f64,
    /// Thermal conductivity relative to nitrogen.
    conductivity: f64,
    /// Convection: the equivalent pressure of nitrogen, in Pa.
    buoyancy: f64,
}

impl Heat {
    /// The heat transfer of a mixture, weighted by molecular transfer. chosen: the same weights for conductivity.
    fn of(gas: &Mixture) -> Self {
        let mut heat = Self { molecular: 0.0, conductivity: 0.0, buoyancy: 0.0 };
        for (gas, pa) in gas.iter().filter(|(_, pa)| *pa > 0.0) {
            let (conductivity, buoyancy) = self::heat(gas);
            let molecular = pa / gas.pirani_factor();
            heat.molecular += molecular;
            heat.conductivity += molecular * conductivity;
            heat.buoyancy += pa * buoyancy;
        }
        heat.conductivity /= heat.molecular;
        heat
    }

    fn is_molecular(&self) -> bool {
        self.molecular <= MOLECULAR_PA
    }

    #[expect(clippy::float_cmp, reason = "nothing but nitrogen and air is exactly like nitrogen")]
    fn is_like_nitrogen(&self) -> bool {
        self.conductivity == 1.0 && self.buoyancy == self.molecular
    }

    /// The power, in Pa of nitrogen where it is linear.
    fn signal(&self) -> f64 {
        if self.is_molecular() {
            return self.molecular;
        }
        let room = CONDUCTION_PA * self.conductivity - MOLECULAR_PA;
        let above = self.molecular - MOLECULAR_PA;
        let convection = CONVECTION * self.conductivity * (self.buoyancy - CONVECTION_FROM_PA).max(0.0);
        MOLECULAR_PA + above / (1.0 + above / room) + convection
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const MBAR: f64 = 100.0;

    fn indicated(gas: Gas, mbar: f64) -> f64 {
        Pirani::ideal_pa(&Mixture::pure(gas, mbar * MBAR)) / MBAR
    }

    /// Pressures from 1e-6 mbar to 2 bar, ten per decade.
    fn pressures() -> impl Iterator<Item = f64> {
        (-60..=33).map(|tenth| 10f64.powf(f64::from(tenth) / 10.0))
    }

    #[test]
    fn nitrogen_is_indicated_correctly_with_and_without_the_signal() {
        for mbar in pressures() {
            assert_eq!(indicated(Gas::N2, mbar), mbar * MBAR / MBAR);
            let signal = Heat::of(&Mixture::pure(Gas::N2, mbar * MBAR)).signal();
            assert!((Pirani::nitrogen_pa(signal) / (mbar * MBAR) - 1.0).abs() < 1e-9, "{mbar} mbar");
        }
    }

    #[test]
    fn up_to_1_mbar_the_factors_of_the_manual_apply() {
        for gas in Gas::all() {
            for mbar in pressures().filter(|mbar| *mbar <= 1.0) {
                let factor = mbar / indicated(gas, mbar);
                assert!((factor / gas.pirani_factor() - 1.0).abs() < 1e-12, "{gas} at {mbar} mbar: {factor}");
            }
        }
    }

    /// Where conduction dominates, the indications of light and heavy gases deviate in opposite directions.
    #[test]
    fn light_gases_are_indicated_too_high_and_heavy_gases_too_low() {
        for (gas, low, high) in [
            (Gas::He, 1.2, 1e9),
            (Gas::H2, 2.0, 1e9),
            (Gas::Ne, 0.7, 1e9),
            (Gas::Ar, 0.0, 0.6),
            (Gas::Kr, 0.0, 0.42),
            (Gas::Xe, 0.0, 0.34),
        ] {
            let ratios: Vec<f64> = [5.0, 20.0, 60.0].iter().map(|mbar| indicated(gas, *mbar) / mbar).collect();
            assert!(ratios.iter().all(|ratio| (low..high).contains(ratio)), "{gas}: {ratios:?}");
            let rises = ratios.windows(2).all(|pair| pair[0] < pair[1]);
            assert_eq!(rises, high > 1.0, "{gas}: {ratios:?}");
        }
        // Known accidents: argon at atmospheric pressure is indicated as rough vacuum, little helium as atmosphere.
        assert!((50.0..200.0).contains(&indicated(Gas::Ar, 1000.0)), "{}", indicated(Gas::Ar, 1000.0));
        assert!(indicated(Gas::He, 50.0) > 1000.0, "{}", indicated(Gas::He, 50.0));
        assert!(indicated(Gas::H2, 30.0) > 1000.0, "{}", indicated(Gas::H2, 30.0));
    }

    #[test]
    fn the_indication_is_monotonic_and_continuous() {
        for gas in Gas::all() {
            let readings: Vec<f64> = pressures().map(|mbar| indicated(gas, mbar)).collect();
            for pair in readings.windows(2) {
                assert!(pair[1] > pair[0], "{gas}: {pair:?}");
            }
            for edge in [1.0, 2.0, 6.0, 50.0] {
                let step = indicated(gas, edge * 1.000_001) / indicated(gas, edge) - 1.0;
                assert!(step < 1e-4, "{gas} at {edge} mbar: {step}");
            }
        }
    }

    #[test]
    fn a_mixture_is_indicated_between_its_gases() {
        let mut gas = Mixture::pure(Gas::Ar, 500.0 * MBAR);
        gas[Gas::N2] = 500.0 * MBAR;
        let mbar = Pirani::ideal_pa(&gas) / MBAR;
        assert!(indicated(Gas::Ar, 1000.0) < mbar && mbar < 1000.0, "{mbar}");
    }

    #[test]
    fn a_contaminated_wire_indicates_too_high_in_vacuum_and_too_low_in_gas() {
        let read = |contamination: f64, mbar: f64| {
            let pirani = Pirani { contamination, ..Pirani::new(Range { lowest_pa: 0.05, highest_pa: 1e5 }) };
            Pirani::nitrogen_pa(pirani.signal(&Mixture::pure(Gas::N2, mbar * MBAR))) / MBAR
        };
        assert!((read(0.2, 1e-6) / 4.001e-3 - 1.0).abs() < 1e-3, "{}", read(0.2, 1e-6));
        assert!(read(0.2, 10.0) < 9.0);
        assert!((read(0.0, 10.0) / 10.0 - 1.0).abs() < 1e-9);
    }

    #[test]
    fn near_atmosphere_one_percent_of_the_power_is_many_percent_of_the_pressure() {
        let signal = Heat::of(&Mixture::pure(Gas::N2, 1e5)).signal();
        let error = Pirani::nitrogen_pa(signal * 1.01) / 1e5 - 1.0;
        assert!((0.05..0.2).contains(&error), "{error}");
    }

    #[test]
    fn no_gas_is_indicated_as_zero() {
        assert_eq!(Pirani::ideal_pa(&Mixture::default()), 0.0);
        assert_eq!(Pirani::nitrogen_pa(-0.5), -0.5);
    }
}
