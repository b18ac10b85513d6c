//! What sensors make of the vacuum around them.
//!
//! A [`Sensor`] is an `Element` that follows its formula and, unless it is ideal, the [`Flaws`] of a real one:
//! noise, lag, drift, errors of zero and gain. An ideal one is an exact function of the gas. What a sensor indicates is
//! what a gauge would show before its own adjustments: calibrated for nitrogen, in Pa, and below zero where its zero is off.

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

/// Where sensors are calibrated, in K: 23 °C.
pub const REFERENCE_K: f64 = 296.15;

/// What surrounds a gauge.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Environment {
    /// The gas in front of it.
    pub gas: Mixture,
    /// The pressure outside of the chamber, in Pa.
    pub atmosphere_pa: f64,
    /// The temperature of the gauge, in K.
    pub temperature_k: f64,
}

/// How a sensor senses.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Principle {
    /// Heat transfer.
    Pirani,
    /// Capacitance diaphragm.
    Diaphragm,
    /// Ions made by electrons from a hot filament: Bayard-Alpert, extractor, high pressure gauge.
    HotCathode,
    /// Ions made in a discharge in a magnetic field.
    ColdCathode,
    /// A piezo diaphragm that measures the pressure outside.
    Atmosphere,
}

/// What a sensor is made for, in Pa.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Range {
    /// The lowest pressure it is to measure.
    pub lowest_pa: f64,
    /// The highest, full scale.
    pub highest_pa: f64,
}

/// What a device does to its sensor.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Drive {
    /// Nothing: no heater, no emission, no high voltage.
    Off,
    /// It is supplied.
    On,
    /// A hot cathode emits.
    Emission {
        /// In mA.
        milliamperes: f64,
        /// The grid is heated to drive the gas out.
        degas: bool,
    },
}

/// A sensor.
#[derive(Clone, Debug)]
pub struct Sensor {
    element: Element,
    real: Option<Real>,
}

/// What a real sensor has beside its formula.
#[derive(Clone, Debug)]
struct Real {
    imperfections: Imperfections,
    lag: Lag,
    time_s: f64,
}

impl Sensor {
    /// A sensor without a fault of its own: exact, at once, and always the same.
    #[must_use]
    pub fn ideal(principle: Principle, range: Range) -> Self {
        Self { element: Element::new(principle, range), real: None }
    }

    /// A sensor as it is bought. The seed says which: how far zero and gain are off, how it drifts, how it is noisy.
    #[must_use]
    pub fn real(principle: Principle, range: Range, seed: u64) -> Self {
        let element = Element::new(principle, range);
        let flaws = Imperfections::new(&element.tolerance(), seed);
        Self { element, real: Some(Real { imperfections: flaws, lag: Lag::default(), time_s: 0.0 }) }
    }

    /// Time passes, and the sensor indicates this much, in Pa. With 0 s nothing moves that takes time.
    ///
    /// Noise and drift are functions of seed and time: it does not matter in which steps time passes.
    pub fn read(&mut self, around: &Environment, drive: Drive, seconds: f64) -> f64 {
        let Some(Real { imperfections: flaws, lag, time_s }) = &mut self.real else {
            return self.element.ideal_pa(around);
        };
        *time_s += seconds;
        let signal = self.element.signal(around, drive, seconds, flaws.seed);
        let lagged = lag.follow(signal, seconds, flaws.lag_s);
        self.element.indicated_pa(flaws.apply(lagged, *time_s, around.temperature_k), drive)
    }

    /// The sensor has had all the time that its lag wants.
    pub fn settle(&mut self) {
        if let Some(real) = &mut self.real {
            real.lag = Lag::default();
        }
    }

    /// What is wrong with it; nothing is with an ideal one.
    pub fn imperfections_mut(&mut self) -> Option<&mut Imperfections> {
        self.real.as_mut().map(|real| &mut real.imperfections)
    }

    /// How dirty the wire of a Pirani is, from 0 to 1: heat goes into the layer, and less of it into the gas. An ideal
    /// sensor and other principles stay as they are.
    pub fn contaminate(&mut self, share: f64) {
        if let (Some(_), Element::Pirani(pirani)) = (&self.real, &mut self.element) {
            pirani.contamination = share.clamp(0.0, 1.0);
        }
    }

    /// The head of a diaphragm is kept at this temperature, in K, and thermal transpiration begins. An ideal sensor and other
    /// principles stay as they are.
    pub const fn heat_head(&mut self, kelvin: f64) {
        if let (Some(_), Element::Diaphragm(diaphragm)) = (&self.real, &mut self.element) {
            diaphragm.head_k = Some(kelvin);
        }
    }

    /// The filament of a hot cathode; an ideal one wears out as little as it has gas to give off.
    #[must_use]
    pub const fn filament(&self) -> Option<&Filament> {
        match (&self.real, &self.element) {
            (Some(_), Element::HotCathode(cathode)) => Some(&cathode.filament),
            _ => None,
        }
    }

    /// The same, to break or replace it.
    pub const fn filament_mut(&mut self) -> Option<&mut Filament> {
        match (&self.real, &mut self.element) {
            (Some(_), Element::HotCathode(cathode)) => Some(&mut cathode.filament),
            _ => None,
        }
    }
}
