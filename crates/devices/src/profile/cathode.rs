//! A hot cathode: emission, its automatic mode, degas. tira41d1 3.3.3.5 to 3.3.3.9; numbers in brackets are those of
//! errata-bpg-bcg-tpg (95 to 102).

use super::hysteresis::switched;
use crate::model::{AccessError, Value};
use crate::simulation::Drive;

/// The pressures at which a hot cathode is switched, in Pa.
#[derive(Debug, PartialEq)]
pub struct Thresholds {
    /// Above this pressure of the controlling part the emission goes off.
    pub off_pa: f64,
    /// Below this pressure of the controlling part it may go on.
    pub on_pa: f64,
    /// Degas On Limit; the operating current changes there too.
    pub degas_pa: f64,
}

/// Degas ends after three minutes.
const DEGAS_S: f64 = 180.0;

/// The emission current.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum EmissionCurrent {
    /// No emission.
    Off,
    /// 25 uA.
    Low,
    /// 5 mA.
    High,
    /// 20 mA.
    Degas,
}

impl EmissionCurrent {
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

    /// Checks a write of Emission Current. The gauge chooses the current: one of the four is accepted and has no effect
    /// (98).
    ///
    /// # Errors
    /// [`AccessError::OutOfRange`] for another current.
    pub fn check(value: &Value) -> Result<(), AccessError> {
        let is_one = Self::ALL.iter().any(|current| Value::Float(current.milliamperes()) == *value);
        if is_one { Ok(()) } else { Err(AccessError::OutOfRange) }
    }

    /// How the current drives the sensor.
    pub fn drive(self) -> Drive {
        match self {
            Self::Off => Drive::Off,
            current => Drive::Emission { milliamperes: current.milliamperes().into(), degas: current == Self::Degas },
        }
    }
}

/// The conditions that the emission depends on.
#[derive(Clone, Copy, Debug)]
pub struct CathodeConditions {
    /// The device is in EXECUTING, and neither cathode nor controlling part has failed.
    pub able: bool,
    /// The reading of the controlling part, in Pa.
    pub control_pa: f64,
    /// The reading of the gauge, in Pa.
    pub gauge_pa: f64,
}

/// Emission, user mode and degas.
#[derive(Clone, Debug)]
pub struct Cathode {
    thresholds: &'static Thresholds,
    on: bool,
    /// The pressure is low enough for the high current.
    high: bool,
    automatic: bool,
    /// Switched off by a command in automatic mode; holds until the pressure was too high once (102).
    held_off: bool,
    /// The rest of the degas time.
    degas_s: f64,
    /// A degas was refused because of the pressure (96).
    degas_refused: bool,
}

impl Cathode {
    /// After power-up: off, automatic mode (100).
    #[must_use]
    pub const fn new(thresholds: &'static Thresholds) -> Self {
        Self {
            thresholds,
            on: false,
            high: false,
            automatic: true,
            held_off: false,
            degas_s: 0.0,
            degas_refused: false,
        }
    }

    /// Sets other thresholds: a switch on the gauge was moved.
    pub const fn set_thresholds(&mut self, thresholds: &'static Thresholds) {
        self.thresholds = thresholds;
    }

    /// Whether the emission is on.
    #[must_use]
    pub const fn is_on(&self) -> bool {
        self.on
    }

    /// Whether the gauge switches the emission on by itself.
    #[must_use]
    pub const fn is_automatic(&self) -> bool {
        self.automatic
    }

    /// Whether degas runs.
    #[must_use]
    pub const fn is_degassing(&self) -> bool {
        self.degas_s > 0.0
    }

    /// The present current.
    #[must_use]
    pub const fn current(&self) -> EmissionCurrent {
        match self.on {
            false => EmissionCurrent::Off,
            true if self.is_degassing() => EmissionCurrent::Degas,
            true if self.high => EmissionCurrent::High,
            true => EmissionCurrent::Low,
        }
    }

    /// "Pressure too high for degas": only while degas runs or was refused (96).
    #[must_use]
    pub const fn is_too_high_for_degas(&self, gauge_pa: f64) -> bool {
        (self.is_degassing() || self.degas_refused) && gauge_pa >= self.thresholds.degas_pa
    }

    /// Switches the emission after a change of pressure or device state.
    pub fn update_emission(&mut self, conditions: &CathodeConditions) {
        let too_high = conditions.control_pa > self.thresholds.off_pa;
        if too_high {
            self.held_off = false;
        }
        if too_high || !conditions.able {
            self.on = false;
        } else if self.automatic && !self.held_off && conditions.control_pa < self.thresholds.on_pa {
            self.on = true;
        }
        if !self.on {
            self.degas_s = 0.0;
        }
    }

    /// Chooses the current after a change of the gauge's pressure, and clears a refused degas below the limit.
    ///
    /// chosen: the manuals have one limit for the current. A high current stays until the pressure is a tenth
    /// above it; otherwise noise would switch it.
    pub fn update_current(&mut self, gauge_pa: f64) {
        let limit_pa = self.thresholds.degas_pa;
        self.degas_refused &= gauge_pa >= limit_pa;
        self.high = self.on && switched(Some(gauge_pa), limit_pa, 1.1 * limit_pa, self.high);
    }

    /// Advances the degas time.
    pub fn advance(&mut self, seconds: f64) {
        self.degas_s = (self.degas_s - seconds).max(0.0);
    }

    /// Ends degas. Always accepted (95).
    pub const fn stop_degas(&mut self) {
        self.degas_s = 0.0;
        self.degas_refused = false;
    }

    /// Starts degas. A degas that runs is not prolonged.
    ///
    /// # Errors
    /// [`AccessError::StateConflict`] at the limit and above, and without emission (95).
    pub fn start_degas(&mut self, conditions: &CathodeConditions) -> Result<(), AccessError> {
        if self.is_degassing() {
            return Ok(());
        }
        if !self.on || conditions.gauge_pa >= self.thresholds.degas_pa {
            self.degas_refused = conditions.gauge_pa >= self.thresholds.degas_pa;
            return Err(AccessError::StateConflict);
        }
        self.degas_s = DEGAS_S;
        Ok(())
    }

    /// Switches the emission off. Always accepted; in automatic mode it holds until the pressure has been too high
    /// (102).
    pub const fn switch_off(&mut self) {
        self.held_off = self.automatic;
        self.on = false;
    }

    /// Switches the emission on.
    ///
    /// # Errors
    /// [`AccessError::StateConflict`] at the limit and above, or when the gauge is not able to (102).
    pub fn switch_on(&mut self, conditions: &CathodeConditions) -> Result<(), AccessError> {
        if !self.on && (!conditions.able || conditions.control_pa >= self.thresholds.on_pa) {
            return Err(AccessError::StateConflict);
        }
        self.held_off = false;
        self.on = true;
        Ok(())
    }

    /// Executes a write of Emission Status: 0 switches off, 1 switches on (97).
    ///
    /// # Errors
    /// [`AccessError::OutOfRange`] for other codes, otherwise as [`switch_on`](Self::switch_on).
    pub fn write_emission_status(&mut self, code: u8, conditions: &CathodeConditions) -> Result<(), AccessError> {
        match code {
            0 => self.switch_off(),
            1 => return self.switch_on(conditions),
            _ => return Err(AccessError::OutOfRange),
        }
        Ok(())
    }

    /// Sets automatic or manual mode. Setting the present mode again changes nothing (102).
    pub const fn set_automatic(&mut self, automatic: bool) {
        self.held_off &= self.automatic == automatic;
        self.automatic = automatic;
    }
}
