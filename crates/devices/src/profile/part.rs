//! A measuring part: its sensor, its reading, and its safe state.

use crate::model::code_table::codes;
use crate::model::{MeasuringRange, Part, PartSpec, RangeStatus};
use crate::simulation::PartReading;

bitflags::bitflags! {
    /// Status Extension of an instance, and One Of N Status Extension.
    #[derive(Clone, Copy, Debug, PartialEq, Eq)]
    pub struct StatusExtension: u8 {
        /// Reading Invalid.
        const INVALID = 1 << 0;
        /// Overrange Exceeded.
        const OVER = 1 << 1;
        /// Underrange Exceeded.
        const UNDER = 1 << 2;
    }
}

impl StatusExtension {
    /// The status of a value from its range status and its validity.
    #[must_use]
    pub fn new(range: RangeStatus, valid: bool) -> Self {
        let bits = match range {
            RangeStatus::Under => Self::UNDER,
            RangeStatus::Within => Self::empty(),
            RangeStatus::Over => Self::OVER,
        };
        if valid { bits } else { bits | Self::INVALID }
    }
}

codes! {
    /// Safe State: the value that a device shows in place of an invalid one. errata-bpg-bcg-tpg 74 to 76.
    pub SafeState: Names;
    0 Zero          "zero";
    1 FullScale     "full-scale";
    2 HoldLastValue "hold-last-value";
    3 UseSafeValue  "use-safe-value";
}

/// An ideal sensor with the adjustments of the device.
#[derive(Clone, Copy, Debug)]
pub struct Sensor {
    /// The pressure it senses, in Pa.
    pub sensed_pa: f64,
    /// The factor of an adjustment.
    pub gain: f64,
    /// The offset of an adjustment, in Pa.
    pub offset_pa: f64,
}

impl Sensor {
    /// A sensor as from the factory, in ambient air.
    #[must_use]
    pub const fn in_air() -> Self {
        Self { sensed_pa: 101_325.0, gain: 1.0, offset_pa: 0.0 }
    }

    /// The pressure it indicates, in Pa; never below zero.
    #[must_use]
    pub fn indicated_pa(&self) -> f64 {
        (self.sensed_pa * self.gain + self.offset_pa).max(0.0)
    }

    /// The same sensor with the adjustments of the factory.
    #[must_use]
    pub const fn restarted(&self) -> Self {
        Self { sensed_pa: self.sensed_pa, ..Self::in_air() }
    }
}

/// The conditions that the readings of all parts of a device depend on.
#[derive(Clone, Copy, Debug)]
pub struct ReadingCondition {
    /// The device is in EXECUTING.
    pub executing: bool,
    /// An alarm or warning makes every reading invalid: errata-bpg-bcg-tpg 54.
    pub disturbed: bool,
    /// A common or manufacturer alarm, with which every part shows its Safe State: errata-bpg-bcg-tpg 75.
    pub alarmed: bool,
}

/// A measuring part with its parameters.
#[derive(Clone, Debug)]
pub struct MeasuringPart {
    /// Its entry in the tables.
    pub spec: &'static PartSpec,
    /// The sensor.
    pub sensor: Sensor,
    /// Sensor or electronics have failed: it has a sensor alarm.
    pub failed: bool,
    /// The reading in Pa, not clipped; `None` while the part does not measure.
    pub reading_pa: Option<f64>,
    /// Safe State.
    pub safe_state: SafeState,
    /// Safe Value in Pa.
    pub safe_value_pa: f64,
    last_pa: f64,
}

impl MeasuringPart {
    /// A part as it leaves the factory: Safe State Zero, Safe Value 0 (errata-bpg-bcg-tpg 73), no last value (76).
    #[must_use]
    pub const fn new(spec: &'static PartSpec) -> Self {
        Self {
            spec,
            sensor: Sensor::in_air(),
            failed: false,
            reading_pa: None,
            safe_state: SafeState::Zero,
            safe_value_pa: 0.0,
            last_pa: 0.0,
        }
    }

    /// The same part after power-up: without its parameters, but with its sensor.
    #[must_use]
    pub const fn restarted(&self) -> Self {
        Self { sensor: self.sensor.restarted(), failed: self.failed, ..Self::new(self.spec) }
    }

    /// Its instance and principle.
    #[must_use]
    pub const fn part(&self) -> Part {
        self.spec.part
    }

    /// Its measuring range.
    #[must_use]
    pub const fn measuring_range(&self) -> MeasuringRange {
        let limits = &self.spec.limits;
        MeasuringRange { lowest_pa: limits.under_pa, highest_pa: limits.full_scale_pa }
    }

    /// The range status of the reading; over while the part does not measure (errata-bpg-bcg-tpg 81).
    #[must_use]
    pub fn range(&self) -> RangeStatus {
        self.reading_pa.map_or(RangeStatus::Over, |pa| self.spec.limits.status_of(pa))
    }

    /// The indicated pressure in Pa, clipped to the range where the tables ask for it (errata-bpg-bcg-tpg 81).
    #[must_use]
    pub fn indicated_pa(&self) -> f64 {
        self.reading_pa.map_or(self.spec.limits.over_pa, |pa| self.spec.clip(pa))
    }

    /// Reading Valid: in EXECUTING, not disturbed, in range.
    #[must_use]
    pub fn is_valid(&self, condition: &ReadingCondition) -> bool {
        condition.executing && !condition.disturbed && self.range() == RangeStatus::Within
    }

    /// Status Extension (errata-bpg-bcg-tpg 57).
    #[must_use]
    pub fn status_extension(&self, condition: &ReadingCondition) -> StatusExtension {
        StatusExtension::new(self.range(), self.is_valid(condition))
    }

    /// Whether Safe State decides the value (errata-bpg-bcg-tpg 75).
    #[must_use]
    pub const fn is_safe(&self, condition: &ReadingCondition) -> bool {
        !condition.executing || condition.alarmed || self.failed
    }

    /// Process Value, in Pa.
    #[must_use]
    pub fn process_value_pa(&self, condition: &ReadingCondition) -> f64 {
        if self.is_safe(condition) { self.safe_pa() } else { self.indicated_pa() }
    }

    /// Keeps a valid value for Hold Last Value.
    pub fn remember(&mut self, condition: &ReadingCondition) {
        if self.is_valid(condition) {
            self.last_pa = self.indicated_pa();
        }
    }

    /// The value by Safe State, in Pa.
    const fn safe_pa(&self) -> f64 {
        match self.safe_state {
            SafeState::Zero => 0.0,
            SafeState::FullScale => self.spec.limits.full_scale_pa,
            SafeState::HoldLastValue => self.last_pa,
            SafeState::UseSafeValue => self.safe_value_pa,
        }
    }

    /// Sensor Alarm: sensor and electronics share one bit (tira41d1 3.3.2.3).
    #[must_use]
    pub const fn sensor_alarm(&self) -> [u8; 2] {
        [0, if self.failed { 1 << 1 } else { 0 }]
    }

    /// The reading for a report.
    #[must_use]
    pub fn indicated(&self, condition: &ReadingCondition) -> PartReading {
        PartReading {
            instance: self.part().instance,
            value_mbar: self.indicated_pa() / 100.0,
            valid: self.is_valid(condition),
        }
    }
}
