//! The cathode of channel 1 or 2: emission, degas, and the two events with which the controller switches it off by
//! itself. BG 5530 4.4.4, errata-pxg55x-img400 147 to 152.

use super::codes::{EmissionCurrent, HotCathodeCommand};
use super::gauges::IonGauge;
use crate::model::{AccessError, Value, command_code};
use crate::profile::{Cathode, CathodeConditions, Thresholds};
use crate::simulation::Drive;

/// Emission and degas of an ionisation gauge.
#[derive(Clone, Debug)]
pub(super) struct IonCathode {
    thresholds: &'static Thresholds,
    cathode: Cathode,
    /// Emission Current.
    current: EmissionCurrent,
    /// The pressure was too high: Overpressure Emission off.
    overpressure: bool,
    /// The key of the controller was pressed, emergency off: Environment Failure.
    key: bool,
}

impl IonCathode {
    /// The cathode after power-up: off.
    pub fn new(gauge: IonGauge) -> Self {
        let thresholds = gauge.thresholds();
        let mut cathode = Cathode::new(thresholds);
        cathode.set_automatic(false);
        Self { thresholds, cathode, current: EmissionCurrent::Milliampere0, overpressure: false, key: false }
    }

    /// The same cathode after power-up; the current is nonvolatile.
    pub fn restarted(&self, gauge: IonGauge) -> Self {
        Self { current: self.current, ..Self::new(gauge) }
    }

    /// Whether the emission is on.
    pub const fn is_on(&self) -> bool {
        self.cathode.is_on()
    }

    /// Whether degas runs.
    pub const fn is_degassing(&self) -> bool {
        self.cathode.is_degassing()
    }

    /// The controller has switched the emission off by itself, and no master has acknowledged it.
    pub const fn is_alarmed(&self) -> bool {
        self.overpressure || self.key
    }

    /// The bits of Sensor Alarm.
    pub const fn alarm_bits(&self) -> u8 {
        (self.overpressure as u8) << 3 | (self.key as u8) << 4
    }

    /// Acknowledges the alarm: Clear Emission Off Alarm, and Reset Error Condition. Emission stays off (152).
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
        Value::Float(self.current.code().into())
    }

    /// How the controller drives the sensor.
    // chosen: with code 0 the controller chooses 1.6 mA, and degas takes 45 mA
    pub const fn drive(&self) -> Drive {
        let milliamperes = match self.current {
            _ if !self.is_on() => return Drive::Off,
            _ if self.is_degassing() => 45.0,
            EmissionCurrent::Milliampere01 => 0.1,
            EmissionCurrent::Milliampere1 => 1.0,
            EmissionCurrent::Milliampere0 | EmissionCurrent::Milliampere16 => 1.6,
            EmissionCurrent::Milliampere10 => 10.0,
            EmissionCurrent::Milliampere45 => 45.0,
            EmissionCurrent::Milliampere90 => 90.0,
        };
        Drive::Emission { milliamperes, degas: self.is_degassing() }
    }

    /// Sets Emission Current.
    pub fn set_current(&mut self, value: &Value) -> Result<(), AccessError> {
        self.current = value.coded()?;
        Ok(())
    }

    /// Executes a Hot Cathode Block State Command.
    pub fn command(&mut self, code: u16, able: bool, pa: f64) -> Result<(), AccessError> {
        const KEEP_ALARM: u16 = command_code(4, 0);
        if code == KEEP_ALARM {
            return Ok(());
        }
        let conditions = self.conditions(able, pa);
        match HotCathodeCommand::from_code(code).ok_or(AccessError::OutOfRange)? {
            HotCathodeCommand::Inactive => {}
            HotCathodeCommand::DegasOff => self.cathode.stop_degas(),
            HotCathodeCommand::DegasOn => return self.cathode.start_degas(&conditions),
            HotCathodeCommand::EmissionOff => self.cathode.switch_off(),
            HotCathodeCommand::EmissionOn => return self.cathode.switch_on(&conditions),
            HotCathodeCommand::ClearEmissionOffAlarm => self.acknowledge(),
        }
        Ok(())
    }

    /// The conditions of the cathode, which stays off until its alarm is acknowledged.
    const fn conditions(&self, able: bool, pa: f64) -> CathodeConditions {
        CathodeConditions { able: able && !self.is_alarmed(), control_pa: pa, gauge_pa: pa }
    }

    /// The operator has pressed the key EMIS: emergency off at any time; on only if the keys are not locked.
    pub fn press_key(&mut self, locked: bool, able: bool, pa: f64) {
        if self.is_on() {
            self.cathode.switch_off();
            self.key = true;
        } else if !locked {
            // The key has no effect where the command would be refused.
            let _ = self.command(HotCathodeCommand::EmissionOn.code(), able, pa);
        }
    }

    /// Switches the emission after a change of pressure or gauge.
    pub fn update(&mut self, able: bool, pa: f64, overpressure: bool) {
        if self.is_on() && able && (overpressure || pa > self.thresholds.off_pa) {
            self.overpressure = true;
        }
        self.cathode.update_emission(&self.conditions(able, pa));
    }

    /// Advances the degas time.
    pub fn advance(&mut self, seconds: f64) {
        self.cathode.advance(seconds);
    }
}
