//! Hot cathode: electrons from a filament ionise the gas, and the ion current is measured.
//!
//! `I_ion = S I_e p + I_x`, with a sensitivity S for each gas. Electrons that strike the grid cause x-rays, and these the
//! current I_x, which does not depend on the gas. At high pressure S falls, the sooner the higher the emission, which is why
//! gauges reduce the emission there. Filament and grid outgas, most of all during degas, and oxygen burns the filament.

use super::imperfections::Tolerance;
use super::{Drive, Environment, GasExchange, Range};
use crate::gas::Gas;

/// A hot cathode, with the range of a Bayard-Alpert, an extractor or a high pressure gauge.
#[derive(Clone, Debug)]
pub struct HotCathode {
    range: Range,
    pub filament: Filament,
    /// The adsorbed gas of filament and grid, 0 to 1.
    adsorbed: f64,
}

/// The pressure in the gauge from outgassing of saturated filament and grid, in Pa: during degas, and in operation.
///
/// chosen: during degas it reaches the limit below which gauges permit degas; in operation it vanishes within hours.
const DEGAS_PA: f64 = 5e-4;
const WARM_PA: f64 = 2e-7;

/// The time constants of outgassing, in s: during degas, and in operation. A degas of three minutes removes most of the gas.
const DEGAS_S: f64 = 60.0;
const WARM_S: f64 = 3_600.0;

/// The time constant of adsorption in s at a pressure in Pa; it is inversely proportional to lower pressures.
const FILLED_S: f64 = 100.0;
const FILLED_PA: f64 = 100.0;

/// The pumping speed per emission current and its limit, in m³/s per mA and m³/s.
///
/// "Electrical clean-up of gases in an ionization gauge" (J. Appl. Phys. 27 (1956) 926): 0.1 l/s for nitrogen at most, by ions
/// that the walls of the gauge keep. chosen: proportional to the emission up to that.
const PUMPED_PER_MA: f64 = 1e-5;
const MOST_PUMPED: f64 = 1e-4;

/// The gas from saturated filament and grid in Pa m³/s: during degas (1e-5 mbar l/s), and in operation (1e-9 mbar l/s).
/// chosen
const DEGAS_FLOW: f64 = 1e-6;
const WARM_FLOW: f64 = 1e-10;

impl HotCathode {
    /// The gas that it releases and pumps.
    pub fn gas_exchange(&self, drive: Drive) -> GasExchange {
        let Drive::Emission { milliamperes, degas } = drive else { return GasExchange::default() };
        if self.filament.is_broken() {
            return GasExchange::default();
        }
        let outgassing = if degas { DEGAS_FLOW } else { WARM_FLOW * self.adsorbed };
        GasExchange { outgassing, speed: (PUMPED_PER_MA * milliamperes).min(MOST_PUMPED) }
    }

    pub const fn new(range: Range) -> Self {
        Self { range, filament: Filament { wear: 0.0, reported: false }, adsorbed: 1.0 }
    }

    /// The ion current divided by S and emission, in Pa of nitrogen. Without emission it is the value that the gauge would
    /// measure, because gauges check the pressure before they switch on.
    pub fn signal(&mut self, environment: &Environment, drive: Drive, seconds: f64) -> f64 {
        let given_off_pa = self.outgas_pa(environment.gas.total(), drive, seconds);
        let pa = environment.ionised_pa() + given_off_pa + self.x_ray_pa(drive);
        if drive != Drive::Off {
            self.filament.burn(environment, 10.0 * self.range.highest_pa, seconds);
        }
        if self.filament.is_broken() { 0.0 } else { pa / (1.0 + pa / self.saturation_pa(drive)) }
    }

    /// The pressure of nitrogen for an ion current, limited at 95 % of saturation.
    pub fn nitrogen_pa(&self, signal: f64, drive: Drive) -> f64 {
        let share = (signal / self.saturation_pa(drive)).min(0.95);
        signal.min(0.95 * self.saturation_pa(drive)) / (1.0 - share)
    }

    /// The pressure from outgassing of the gauge, in Pa. Adsorption and outgassing are exponential, so any step is exact.
    fn outgas_pa(&mut self, pa: f64, drive: Drive, seconds: f64) -> f64 {
        let (leaving, pressure_pa) = match drive {
            Drive::Off => (0.0, 0.0),
            Drive::Emission { degas: true, .. } => (1.0 / DEGAS_S, DEGAS_PA),
            Drive::On | Drive::Emission { .. } => (1.0 / WARM_S, WARM_PA),
        };
        let coming = pa.min(FILLED_PA) / FILLED_PA / FILLED_S;
        let rate = leaving + coming;
        if rate > 0.0 {
            let end = coming / rate;
            self.adsorbed = end + (self.adsorbed - end) * (-rate * seconds).exp();
        }
        self.adsorbed * pressure_pa
    }

    /// The apparent pressure of the x-ray current in Pa: half of the lowest pressure of the range, which it limits.
    ///
    /// JVST A 10, 2674: 3.7e-10 Torr at 1 mA and 2.8e-10 Torr at 10 mA for a commercial gauge, so it falls by an eighth of a
    /// decade for each decade of emission.
    fn x_ray_pa(&self, drive: Drive) -> f64 {
        match drive {
            Drive::Emission { milliamperes, .. } if milliamperes > 0.0 => {
                0.5 * self.range.lowest_pa * (milliamperes / 5.0).powf(-0.12)
            }
            _ => 0.0,
        }
    }

    /// The saturation pressure, in Pa. General knowledge: linear until the ion current is about 2 % of the emission, unusable
    /// at 20 to 30 %; lower with high emission.
    fn saturation_pa(&self, drive: Drive) -> f64 {
        let milliamperes = if let Drive::Emission { milliamperes, .. } = drive { milliamperes } else { 0.0 };
        2.0 * self.range.highest_pa / (1.0 + milliamperes)
    }

    /// chosen: a spread of 5 % between tubes, 1 % of noise, and an electrometer that resolves a tenth of the lowest
    /// pressure.
    pub const fn tolerance(&self) -> Tolerance {
        Tolerance {
            gain: 0.05,
            zero_pa: 0.0,
            zero_pa_per_k: 0.0,
            noise: 0.01,
            floor_pa: 0.02 * self.range.lowest_pa,
            drift_pa: 0.0,
            lag_s: 0.01,
        }
    }
}

/// The filament of a hot cathode.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Filament {
    wear: f64,
    reported: bool,
}

/// The life of a filament at ten times the permitted oxygen, in s. chosen: long enough for a gauge that switches off,
/// short enough to break otherwise.
const BURNS_S: f64 = 10.0;

impl Filament {
    /// Whether the filament is broken.
    #[must_use]
    pub fn is_broken(&self) -> bool {
        self.wear >= 1.0
    }

    /// The used part of its life, 0 to 1.
    #[must_use]
    pub const fn wear(&self) -> f64 {
        self.wear
    }

    /// Breaks the filament.
    pub const fn break_off(&mut self) {
        self.wear = 1.0;
    }

    /// Replaces the filament by a new one.
    pub const fn replace(&mut self) {
        *self = Self { wear: 0.0, reported: false };
    }

    /// Whether the filament has broken since the last call.
    pub fn has_just_broken(&mut self) -> bool {
        let has_broken = self.is_broken() && !self.reported;
        self.reported = self.is_broken();
        has_broken
    }

    /// Wear of a hot filament: proportional to the decades of the pressure above the permitted one. General knowledge: oxygen
    /// burns it, nitrogen does little harm. chosen: a factor of 100 between them.
    fn burn(&mut self, environment: &Environment, stands_pa: f64, seconds: f64) {
        let gas = &environment.gas;
        let oxidising = gas[Gas::O2] + 0.21 * gas[Gas::Air] + gas[Gas::H2o] + gas[Gas::Co2];
        let harmful_pa = oxidising + 0.01 * gas.total();
        if harmful_pa > stands_pa {
            self.wear = (self.wear + (harmful_pa / stands_pa).log10() * seconds / BURNS_S).min(1.0);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::REFERENCE_K;
    use super::*;
    use crate::gas::Mixture;

    const BAYARD_ALPERT: Range = Range { lowest_pa: 5e-8, highest_pa: 2.0 };
    const EXTRACTOR: Range = Range { lowest_pa: 1e-10, highest_pa: 1e-2 };

    const HIGH: Drive = Drive::Emission { milliamperes: 5.0, degas: false };
    const LOW: Drive = Drive::Emission { milliamperes: 0.025, degas: false };
    const DEGAS: Drive = Drive::Emission { milliamperes: 20.0, degas: true };

    fn environment(gas: Gas, pa: f64) -> Environment {
        Environment { gas: Mixture::pure(gas, pa), atmosphere_pa: 1e5, temperature_k: REFERENCE_K }
    }

    /// A gauge after weeks of operation.
    fn outgassed(range: Range) -> HotCathode {
        HotCathode { adsorbed: 0.0, ..HotCathode::new(range) }
    }

    fn indicated(range: Range, gas: Gas, pa: f64, drive: Drive) -> f64 {
        let mut cathode = outgassed(range);
        let signal = cathode.signal(&environment(gas, pa), drive, 0.0);
        cathode.nitrogen_pa(signal, drive)
    }

    #[test]
    fn each_gas_is_indicated_by_its_sensitivity() {
        for gas in Gas::all() {
            for (pa, drive) in [(1e-4, HIGH), (1e-2, LOW)] {
                let factor = pa / indicated(BAYARD_ALPERT, gas, pa, drive);
                assert!((factor / gas.ion_factor() - 1.0).abs() < 5e-3, "{gas} at {pa} Pa: {factor}");
            }
        }
    }

    #[test]
    fn below_the_range_the_x_ray_current_dominates() {
        for range in [BAYARD_ALPERT, EXTRACTOR] {
            let nothing = indicated(range, Gas::N2, 0.0, HIGH);
            assert!((nothing / range.lowest_pa - 0.5).abs() < 1e-6, "{nothing}");
            let at = |milliamperes| indicated(range, Gas::N2, 0.0, Drive::Emission { milliamperes, degas: false });
            // 3.7e-10 Torr at 1 mA is 2.8e-10 Torr at 10 mA.
            assert!((at(1.0) / at(10.0) / (3.7 / 2.8) - 1.0).abs() < 0.01, "{} {}", at(1.0), at(10.0));
        }
    }

    #[test]
    fn high_emission_saturates_at_lower_pressure() {
        let sensitivity = |pa, drive| outgassed(BAYARD_ALPERT).signal(&environment(Gas::N2, pa), drive, 0.0) / pa;
        assert!(sensitivity(1e-4, HIGH) > 0.99);
        assert!(sensitivity(0.5, LOW) > 0.85);
        assert!(sensitivity(0.5, HIGH) < 0.6);
        assert!(indicated(BAYARD_ALPERT, Gas::N2, 1e5, LOW) < 1e3, "saturated");
    }

    #[test]
    fn degas_raises_the_pressure_and_reduces_later_outgassing() {
        let mut cathode = HotCathode::new(BAYARD_ALPERT);
        let clean = environment(Gas::N2, 1e-7);
        let before = cathode.signal(&clean, HIGH, 1.0);
        let burst = cathode.signal(&clean, DEGAS, 1.0);
        assert!(burst > 100.0 * before, "{burst} after {before}");
        let end = cathode.signal(&clean, DEGAS, 179.0);
        assert!(end < burst / 10.0, "{end} after {burst}");
        let after = cathode.signal(&clean, HIGH, 1.0);
        assert!(after < 0.7 * before, "{after} after {before}");
        // The gauge adsorbs air again.
        cathode.signal(&environment(Gas::Air, 1e5), Drive::Off, 600.0);
        assert!(cathode.signal(&clean, HIGH, 0.0) > 0.99 * before);
    }

    #[test]
    fn a_gauge_pumps_by_its_emission_and_outgasses() {
        let cathode = HotCathode::new(BAYARD_ALPERT);
        assert_eq!(cathode.gas_exchange(HIGH), GasExchange { outgassing: WARM_FLOW, speed: 5e-5 });
        assert_eq!(cathode.gas_exchange(DEGAS), GasExchange { outgassing: DEGAS_FLOW, speed: 1e-4 });
        assert_eq!(cathode.gas_exchange(Drive::Off), GasExchange::default());
    }

    #[test]
    fn outgassing_does_not_depend_on_the_steps() {
        let run = |steps: u32| {
            let mut cathode = HotCathode::new(EXTRACTOR);
            (0..steps)
                .map(|_| cathode.signal(&environment(Gas::N2, 1e-3), HIGH, 7200.0 / f64::from(steps)))
                .last()
                .unwrap()
        };
        assert!((run(1) / run(1000) - 1.0).abs() < 1e-9);
    }

    #[test]
    fn a_hot_filament_breaks_in_air_and_lasts_longer_in_nitrogen() {
        let life = |gas, pa, drive| {
            let mut cathode = HotCathode::new(BAYARD_ALPERT);
            (0..6000).position(|_| {
                cathode.signal(&environment(gas, pa), drive, 0.01);
                cathode.filament.is_broken()
            })
        };
        let air = life(Gas::Air, 1e5, LOW).unwrap();
        let nitrogen = life(Gas::N2, 1e5, LOW).unwrap();
        assert!((200..400).contains(&air), "{air} hundredths of a second in air");
        assert!(nitrogen > air + 100, "{nitrogen} in nitrogen");
        assert_eq!(life(Gas::Air, 1e5, Drive::Off), None, "a cold one");
        assert_eq!(life(Gas::Air, 2.0, LOW), None, "within its range");
    }

    #[test]
    fn a_broken_filament_is_reported_once_and_can_be_replaced() {
        let mut cathode = outgassed(BAYARD_ALPERT);
        cathode.filament.break_off();
        assert!(cathode.filament.has_just_broken());
        assert!(!cathode.filament.has_just_broken());
        assert_eq!(cathode.signal(&environment(Gas::N2, 1e-3), HIGH, 1.0), 0.0);
        cathode.filament.replace();
        assert!(cathode.signal(&environment(Gas::N2, 1e-3), HIGH, 1.0) > 0.0);
    }
}
