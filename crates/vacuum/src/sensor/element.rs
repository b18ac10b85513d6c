//! The five principles under one roof: each turns gas into a signal, and its signal into the pressure of nitrogen.
//!
//! Signals are in Pa of nitrogen where the sensor is linear; where it rolls off, the signal does and the gauge straightens
//! it out again with the curve of nitrogen.

use super::cold_cathode::ColdCathode;
use super::diaphragm::Diaphragm;
use super::hot_cathode::HotCathode;
use super::imperfections::Tolerance;
use super::pirani::Pirani;
use super::{Drive, Environment, Principle, Range};

/// What senses.
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

    /// What one without a flaw indicates.
    pub fn ideal_pa(&self, around: &Environment) -> f64 {
        match self {
            Self::Pirani(_) => Pirani::ideal_pa(&around.gas),
            Self::Diaphragm(_) => around.gas.total(),
            Self::HotCathode(_) | Self::ColdCathode(_) => ionised_pa(around),
            Self::Atmosphere => around.atmosphere_pa,
        }
    }

    /// Time passes, and this is the signal.
    pub fn signal(&mut self, around: &Environment, drive: Drive, seconds: f64, seed: u64) -> f64 {
        match self {
            Self::Pirani(pirani) => pirani.signal(&around.gas),
            Self::Diaphragm(diaphragm) => diaphragm.signal(around),
            Self::HotCathode(cathode) => cathode.signal(around, drive, seconds),
            Self::ColdCathode(cathode) => cathode.signal(ionised_pa(around), drive, seconds, seed),
            Self::Atmosphere => around.atmosphere_pa,
        }
    }

    /// What a gauge that was calibrated with nitrogen makes of a signal.
    pub fn indicated_pa(&self, signal: f64, drive: Drive) -> f64 {
        match self {
            Self::Pirani(_) => Pirani::nitrogen_pa(signal),
            Self::Diaphragm(_) | Self::Atmosphere => signal,
            Self::HotCathode(cathode) => cathode.nitrogen_pa(signal, drive),
            Self::ColdCathode(cathode) => cathode.nitrogen_pa(signal),
        }
    }

    /// How far one that is bought may be from the formula.
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

/// General knowledge, of the order of data sheets: 0.5 %, a few mbar, quick.
const PIEZO: Tolerance = Tolerance {
    gain: 2e-3,
    zero_pa: 100.0,
    zero_pa_per_k: 5.0,
    noise: 0.0,
    floor_pa: 5.0,
    drift_pa: 20.0,
    lag_s: 0.03,
};

/// What an ionisation gauge for nitrogen sees: each gas by its sensitivity.
pub fn ionised_pa(around: &Environment) -> f64 {
    around.gas.iter().map(|(gas, pa)| pa / gas.ion_factor()).sum()
}
