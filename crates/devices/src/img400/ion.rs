//! The cathode of channel 1 or 2: emission, degas, and the two reasons for which the controller switches off by itself.
//! BG 5530 4.4.4, errata-pxg55x-img400 147 to 152.

use super::gauges::IonGauge;
use crate::model::{AccessError, Value};
use crate::profile::{Cathode, CathodeConditions, Thresholds};
use crate::simulation::Drive;

/// Emission and degas of an ionisation gauge.
#[derive(Clone, Debug)]
pub(super) struct Ion {
    thresholds: &'static Thresholds,
    cathode: Cathode,
    /// Emission Current, 0 to 6: 0, 0.1, 1, 1.6, 10, 45, 90 mA.
    current_code: u8,
    /// The pressure was too high: Overpressure Emission off.
    overpressure: bool,
    /// The key of the controller was pressed, emergency off: Environment Failure.
    key: bool,
}

impl Ion {
    /// After power-up: off.
    pub fn new(gauge: IonGauge) -> Self {
        let thresholds = gauge.thresholds();
        let mut cathode = Cathode::new(thresholds);
        cathode.set_automatic(false);
        Self { thresholds, cathode, current_code: 0, overpressure: false, key: false }
    }

    /// The same after power-up; the current is nonvolatile.
    pub fn restarted(&self, gauge: IonGauge) -> Self {
        Self { current_code: self.current_code, ..Self::new(gauge) }
    }

    pub const fn is_on(&self) -> bool {
        self.cathode.is_on()
    }

    pub const fn is_degassing(&self) -> bool {
        self.cathode.is_degassing()
    }

    /// Emission went off by itself, and nobody has acknowledged it.
    pub const fn is_alarmed(&self) -> bool {
        self.overpressure || self.key
    }

    /// The bits of Sensor Alarm.
    pub const fn alarm_bits(&self) -> u8 {
        (self.overpressure as u8) << 3 | (self.key as u8) << 4
    }

    /// Clear Emission Off Alarm, and Reset Error Condition. Emission stays off (152).
    pub const fn acknowledge(&mut self) {
        self.overpressure = false;
        self.key = false;
    }

    /// Sensor Warning: too high for degas (151).
    pub const fn is_too_high_for_degas(&self, pa: f64) -> bool {
        pa >= self.thresholds.degas_pa
    }

    /// Emission Current as a float that holds a code (147).
    pub fn current(&self) -> Value {
        Value::Float(self.current_code.into())
    }

    /// What it does to the sensor.
    // free choice: with code 0 the controller chooses 1.6 mA, and degas takes 45 mA
    pub const fn drive(&self) -> Drive {
        let milliamperes = match self.current_code {
            _ if !self.is_on() => return Drive::Off,
            _ if self.is_degassing() => 45.0,
            1 => 0.1,
            2 => 1.0,
            4 => 10.0,
            5 => 45.0,
            6 => 90.0,
            _ => 1.6,
        };
        Drive::Emission { milliamperes, degas: self.is_degassing() }
    }

    pub fn set_current(&mut self, value: &Value) -> Result<(), AccessError> {
        self.current_code =
            (0..=6u8).find(|code| Value::Float((*code).into()) == *value).ok_or(AccessError::OutOfRange)?;
        Ok(())
    }

    /// Hot Cathode Block State Command.
    pub fn command(&mut self, command: (u8, u8), able: bool, pa: f64) -> Result<(), AccessError> {
        let able = able && !self.is_alarmed();
        match command {
            (4, 0) => {}
            (4, 1) => self.acknowledge(),
            (command, value) => {
                return self.cathode.command(command, value, &CathodeConditions { able, control_pa: pa, gauge_pa: pa });
            }
        }
        Ok(())
    }

    /// The key EMIS: emergency off at any time; on only if the keys are not locked.
    pub fn press_key(&mut self, locked: bool, able: bool, pa: f64) {
        if self.is_on() {
            self.cathode.switch_off();
            self.key = true;
        } else if !locked {
            // What the bus would be refused, the key does not do either.
            let _ = self.command((3, 1), able, pa);
        }
    }

    /// The pressure or the gauge may have changed.
    pub fn follow(&mut self, able: bool, pa: f64, overpressure: bool) {
        if self.is_on() && able && (overpressure || pa > self.thresholds.off_pa) {
            self.overpressure = true;
        }
        let able = able && !self.is_alarmed();
        self.cathode.switch(&CathodeConditions { able, control_pa: pa, gauge_pa: pa });
    }

    pub fn advance(&mut self, seconds: f64) {
        self.cathode.advance(seconds);
    }
}
