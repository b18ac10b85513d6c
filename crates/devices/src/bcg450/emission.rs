//! Emission and degas of the Bayard-Alpert part. tira41d1 3.3.3.5 to 3.3.3.9, errata-bpg-bcg-tpg 95 to 102.

use crate::model::{Refusal, mbar};

/// Above this pressure of the Pirani the emission goes off.
const OFF_PA: f64 = mbar(3.2e-2);

/// Below this pressure of the Pirani it may go on.
const ON_PA: f64 = mbar(2.4e-2);

/// Degas On Limit. free choice: the operating current changes there too, as on the sister gauges.
const DEGAS_PA: f64 = mbar(7.2e-6);

/// Degas ends by itself after three minutes.
const DEGAS_S: f64 = 180.0;

/// What the emission does.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Current {
    /// Nothing.
    Off,
    /// 25 uA.
    Low,
    /// 5 mA.
    High,
    /// 20 mA.
    Degas,
}

impl Current {
    /// The codes of Emission Status are 0 to 3, in this order.
    pub const ALL: [Self; 4] = [Self::Off, Self::Low, Self::High, Self::Degas];

    /// The current in mA.
    pub const fn milliamperes(self) -> f32 {
        match self {
            Self::Off => 0.0,
            Self::Low => 0.025,
            Self::High => 5.0,
            Self::Degas => 20.0,
        }
    }
}

/// What the emission depends on.
#[derive(Clone, Copy, Debug)]
pub struct Conditions {
    /// In EXECUTING, and neither Pirani nor Bayard-Alpert part has failed.
    pub able: bool,
    /// What the Pirani reads, in Pa.
    pub pirani_pa: f64,
    /// What the gauge reads, in Pa.
    pub gauge_pa: f64,
}

/// Emission, user mode and degas.
#[derive(Clone, Debug)]
pub struct Emission {
    on: bool,
    automatic: bool,
    /// Switched off by hand in automatic mode; holds until the pressure was too high once (102).
    held_off: bool,
    /// What is left of the degas time.
    degas_s: f64,
    /// A degas was refused because of the pressure (96).
    degas_refused: bool,
}

impl Default for Emission {
    /// After power-up: off, automatic mode (100).
    fn default() -> Self {
        Self { on: false, automatic: true, held_off: false, degas_s: 0.0, degas_refused: false }
    }
}

impl Emission {
    pub const fn is_on(&self) -> bool {
        self.on
    }

    pub const fn is_automatic(&self) -> bool {
        self.automatic
    }

    pub const fn is_degassing(&self) -> bool {
        self.degas_s > 0.0
    }

    /// The current at this pressure of the gauge.
    pub const fn current(&self, gauge_pa: f64) -> Current {
        match self.on {
            false => Current::Off,
            true if self.is_degassing() => Current::Degas,
            true if gauge_pa < DEGAS_PA => Current::High,
            true => Current::Low,
        }
    }

    /// "Pressure too high for degas": only while somebody wants it (96).
    pub const fn is_too_high_for_degas(&self, gauge_pa: f64) -> bool {
        (self.is_degassing() || self.degas_refused) && gauge_pa >= DEGAS_PA
    }

    /// The pressure or the state of the device may have changed.
    pub fn switch(&mut self, able: bool, pirani_pa: f64) {
        if pirani_pa > OFF_PA {
            self.held_off = false;
        }
        if !able || pirani_pa > OFF_PA {
            self.on = false;
        } else if self.automatic && !self.held_off && pirani_pa < ON_PA {
            self.on = true;
        }
        if !self.on {
            self.degas_s = 0.0;
        }
    }

    /// The pressure of the gauge may have changed.
    pub fn forget_refused_degas(&mut self, gauge_pa: f64) {
        self.degas_refused &= gauge_pa >= DEGAS_PA;
    }

    pub fn advance(&mut self, seconds: f64) {
        self.degas_s = (self.degas_s - seconds).max(0.0);
    }

    /// Hot Cathode Block State Command.
    pub fn command(&mut self, command: u8, value: u8, conditions: &Conditions) -> Result<(), Refusal> {
        match (command, value) {
            (0, _) => Ok(()),
            (1, 0) => self.stop_degas(),
            (1, 1) => self.start_degas(conditions),
            (3, 0) => self.switch_off(),
            (3, 1) => self.switch_on(conditions),
            (128, 0) => self.set_mode(false),
            (128, 1) => self.set_mode(true),
            _ => Err(Refusal::Range),
        }
    }

    /// Always accepted (95).
    pub fn stop_degas(&mut self) -> Result<(), Refusal> {
        self.degas_s = 0.0;
        self.degas_refused = false;
        Ok(())
    }

    /// Below the limit only, with the emission on (95). A degas that runs is not prolonged.
    pub fn start_degas(&mut self, conditions: &Conditions) -> Result<(), Refusal> {
        if self.is_degassing() {
            return Ok(());
        }
        if !self.on || conditions.gauge_pa >= DEGAS_PA {
            self.degas_refused = conditions.gauge_pa >= DEGAS_PA;
            return Err(Refusal::Conflict);
        }
        self.degas_s = DEGAS_S;
        Ok(())
    }

    /// Always accepted; in automatic mode it holds (102).
    pub fn switch_off(&mut self) -> Result<(), Refusal> {
        self.held_off = self.automatic;
        self.on = false;
        Ok(())
    }

    /// Below the limit only, with both parts in order (102).
    pub fn switch_on(&mut self, conditions: &Conditions) -> Result<(), Refusal> {
        if !self.on && (!conditions.able || conditions.pirani_pa >= ON_PA) {
            return Err(Refusal::Conflict);
        }
        self.held_off = false;
        self.on = true;
        Ok(())
    }

    fn set_mode(&mut self, automatic: bool) -> Result<(), Refusal> {
        self.automatic = automatic;
        self.held_off = false;
        Ok(())
    }
}
