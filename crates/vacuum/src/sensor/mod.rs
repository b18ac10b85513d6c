//! Sensors of gauges.
//!
//! A [`Sensor`] has an `Element`, which follows the formula of its principle, and, unless it is ideal, [`Imperfections`]:
//! noise, lag, drift, errors of zero and gain. An ideal sensor is an exact function of the gas. The indication is that of a
//! gauge before its adjustments: calibrated for nitrogen, in Pa, and negative if the zero is too low.

mod cold_cathode;
mod diaphragm;
mod element;
mod hot_cathode;
mod imperfections;
mod pirani;
#[cfg(test)]
mod tests;

use crate::gas::Mixture;
use element::Element;
pub use hot_cathode::Filament;
pub use imperfections::Imperfections;
use imperfections::Lag;

/// The calibration temperature of sensors, in K: 23 °C.
pub const REFERENCE_K: f64 = 296.15;

/// The environment of a gauge.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Environment {
    /// The gas at the sensor.
    pub gas: Mixture,
    /// The pressure outside the chamber, in Pa.
    pub atmosphere_pa: f64,
    /// The temperature of the gauge, in K.
    pub temperature_k: f64,
}

impl Environment {
    /// The pressure of nitrogen in Pa with the same ionisation: the sum of all gases by their sensitivities.
    fn ionised_pa(&self) -> f64 {
        self.gas.iter().map(|(gas, pa)| pa / gas.ion_factor()).sum()
    }
}

/// The measurement principle of a sensor.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Principle {
    /// Heat transfer.
    Pirani,
    /// Capacitance diaphragm.
    Diaphragm,
    /// Ionisation by electrons from a hot filament: Bayard-Alpert, extractor, high pressure gauge.
    HotCathode,
    /// Ionisation in a discharge in a magnetic field.
    ColdCathode,
    /// A piezo diaphragm for the pressure outside the chamber.
    Atmosphere,
}

/// The measurement range of a sensor, in Pa.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Range {
    /// The lowest pressure.
    pub lowest_pa: f64,
    /// The highest pressure, full scale.
    pub highest_pa: f64,
}

/// The supply of a sensor by its device.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Drive {
    /// No supply: no heater, no emission, no high voltage.
    Off,
    /// Supplied.
    On,
    /// Emission of a hot cathode.
    Emission {
        /// The emission current, in mA.
        milliamperes: f64,
        /// Whether the grid is heated to drive out gas.
        degas: bool,
    },
}

/// The effect of a gauge on the gas of its chamber.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct GasExchange {
    /// The released gas, mainly carbon monoxide, in Pa m³/s.
    pub outgassing: f64,
    /// Its pumping speed, in m³/s.
    pub speed: f64,
}

/// A sensor.
#[derive(Clone, Debug)]
pub struct Sensor {
    element: Element,
    real: Option<Real>,
}

/// The state of a real sensor beside its element.
#[derive(Clone, Debug)]
struct Real {
    imperfections: Imperfections,
    lag: Lag,
    time_s: f64,
}

impl Sensor {
    /// A sensor without imperfections: exact and without lag.
    #[must_use]
    pub fn ideal(principle: Principle, range: Range) -> Self {
        Self { element: Element::new(principle, range), real: None }
    }

    /// A sensor with imperfections. The seed selects its errors of zero and gain, its drift and its noise.
    #[must_use]
    pub fn real(principle: Principle, range: Range, seed: u64) -> Self {
        let element = Element::new(principle, range);
        let imperfections = Imperfections::new(&element.tolerance(), seed);
        Self { element, real: Some(Real { imperfections, lag: Lag::default(), time_s: 0.0 }) }
    }

    /// Advances the sensor by `seconds` and returns its indication, in Pa.
    ///
    /// Noise and drift are functions of seed and time, so they do not depend on the length of the steps.
    pub fn read(&mut self, environment: &Environment, drive: Drive, seconds: f64) -> f64 {
        let Some(Real { imperfections, lag, time_s }) = &mut self.real else {
            return self.element.ideal_pa(environment);
        };
        *time_s += seconds;
        let signal = self.element.signal(environment, drive, seconds, imperfections.seed);
        // A discharge that ignites has its current at once.
        if signal > 0.0 && self.element.is_discharge() && lag.is_at_zero() {
            *lag = Lag::default();
        }
        let lagged = lag.follow(signal, seconds, imperfections.lag_s);
        self.element.indicated_pa(imperfections.apply(lagged, *time_s, environment.temperature_k), drive)
    }

    /// The gas that the gauge releases and pumps. An ideal sensor does neither.
    #[must_use]
    pub fn gas_exchange(&self, environment: &Environment, drive: Drive) -> GasExchange {
        if self.real.is_some() { self.element.gas_exchange(environment, drive) } else { GasExchange::default() }
    }

    /// Removes the lag: the next indication is the settled one.
    pub fn settle(&mut self) {
        if let Some(real) = &mut self.real {
            real.lag = Lag::default();
        }
    }

    /// The imperfections; `None` for an ideal sensor.
    pub fn imperfections_mut(&mut self) -> Option<&mut Imperfections> {
        self.real.as_mut().map(|real| &mut real.imperfections)
    }

    /// Sets the contamination of the wire of a Pirani, 0 to 1: heat flows into the layer and less of it into the gas. No
    /// effect on an ideal sensor and on other principles.
    pub fn contaminate(&mut self, share: f64) {
        if let (Some(_), Element::Pirani(pirani)) = (&self.real, &mut self.element) {
            pirani.contamination = share.clamp(0.0, 1.0);
        }
    }

    /// Heats the head of a diaphragm to a temperature in K, which causes thermal transpiration. No effect on an ideal sensor
    /// and on other principles.
    pub const fn heat_head(&mut self, kelvin: f64) {
        if let (Some(_), Element::Diaphragm(diaphragm)) = (&self.real, &mut self.element) {
            diaphragm.head_k = Some(kelvin);
        }
    }

    /// The filament of a hot cathode. An ideal sensor has none, because it neither wears nor outgasses.
    #[must_use]
    pub const fn filament(&self) -> Option<&Filament> {
        match (&self.real, &self.element) {
            (Some(_), Element::HotCathode(cathode)) => Some(&cathode.filament),
            _ => None,
        }
    }

    /// The filament of a hot cathode, to break or replace it.
    pub const fn filament_mut(&mut self) -> Option<&mut Filament> {
        match (&self.real, &mut self.element) {
            (Some(_), Element::HotCathode(cathode)) => Some(&mut cathode.filament),
            _ => None,
        }
    }
}
