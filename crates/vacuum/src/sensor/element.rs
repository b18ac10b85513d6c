//! The elements of the five principles: each converts gas to a signal, and a signal to a pressure of nitrogen.
//!
//! Signals are in Pa of nitrogen where the element is linear. Elsewhere the gauge linearises the signal with the curve of
//! nitrogen.

use super::cold_cathode::ColdCathode;
use super::diaphragm::Diaphragm;
use super::hot_cathode::HotCathode;
use super::imperfections::Tolerance;
use super::pirani::Pirani;
use super::{Drive, Environment, GasExchange, Principle, Range};

/// The element of a sensor.
#[derive(Clone, Debug)]
pub enum Element {
    Pirani(Pirani),
    Diaphragm(Diaphragm),
    HotCathode(HotCathode),
    ColdCathode(ColdCathode),
    Atmosphere,
}

impl Element {
    pub fn new(principle: Principle, range: Range) -> Self {
        match principle {
            Principle::Pirani => Self::Pirani(Pirani::new(range)),
            Principle::Diaphragm => Self::Diaphragm(Diaphragm::new(range)),
            Principle::HotCathode => Self::HotCathode(HotCathode::new(range)),
            Principle::ColdCathode => Self::ColdCathode(ColdCathode::new(range)),
            Principle::Atmosphere => Self::Atmosphere,
        }
    }

    /// The indication without imperfections, in Pa.
    pub fn ideal_pa(&self, environment: &Environment) -> f64 {
        match self {
            Self::Pirani(_) => Pirani::ideal_pa(&environment.gas),
            Self::Diaphragm(_) => environment.gas.total(),
            Self::HotCathode(_) | Self::ColdCathode(_) => environment.ionised_pa(),
            Self::Atmosphere => environment.atmosphere_pa,
        }
    }

    /// Advances by `seconds` and returns the signal.
    pub fn signal(&mut self, environment: &Environment, drive: Drive, seconds: f64, seed: u64) -> f64 {
        match self {
            Self::Pirani(pirani) => pirani.signal(&environment.gas),
            Self::Diaphragm(diaphragm) => diaphragm.signal(environment),
            Self::HotCathode(cathode) => cathode.signal(environment, drive, seconds),
            Self::ColdCathode(cathode) => cathode.signal(environment.ionised_pa(), drive, seconds, seed),
            Self::Atmosphere => environment.atmosphere_pa,
        }
    }

    /// Whether its signal is the current of a discharge, which ignites at once.
    pub const fn is_discharge(&self) -> bool {
        matches!(self, Self::ColdCathode(_))
    }

    /// The gas that it releases and pumps.
    pub fn gas_exchange(&self, environment: &Environment, drive: Drive) -> GasExchange {
        match self {
            Self::HotCathode(cathode) => cathode.gas_exchange(drive),
            Self::ColdCathode(cathode) => cathode.gas_exchange(environment.gas.total()),
            Self::Pirani(_) | Self::Diaphragm(_) | Self::Atmosphere => GasExchange::default(),
        }
    }

    /// The indication in Pa of a gauge calibrated with nitrogen, for a signal.
    pub fn indicated_pa(&self, signal: f64, drive: Drive) -> f64 {
        match self {
            Self::Pirani(_) => Pirani::nitrogen_pa(signal),
            Self::Diaphragm(_) | Self::Atmosphere => signal,
            Self::HotCathode(cathode) => cathode.nitrogen_pa(signal, drive),
            Self::ColdCathode(cathode) => cathode.nitrogen_pa(signal),
        }
    }

    /// The spread of imperfections.
    pub const fn tolerance(&self) -> Tolerance {
        match self {
            Self::Pirani(pirani) => pirani.tolerance(),
            Self::Diaphragm(diaphragm) => diaphragm.tolerance(),
            Self::HotCathode(cathode) => cathode.tolerance(),
            Self::ColdCathode(_) => ColdCathode::TOLERANCE,
            Self::Atmosphere => PIEZO,
        }
    }
}

/// The tolerance of a piezo diaphragm. General knowledge, similar to data sheets: 0.5 %, a few mbar, fast.
const PIEZO: Tolerance = Tolerance {
    gain: 2e-3,
    zero_pa: 100.0,
    zero_pa_per_k: 5.0,
    noise: 0.0,
    floor_pa: 5.0,
    drift_pa: 20.0,
    lag_s: 0.03,
};
