//! One measuring part: what it senses, what it may say, and what it says instead.

use crate::model::{AccessError, PartSpec, RangeStatus, Value};
use crate::simulation::{MeasuringRange, Part, PartReading};

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
    /// From the place of the value and whether it is valid.
    #[must_use]
    pub fn new(range: RangeStatus, valid: bool) -> Self {
        let place = match range {
            RangeStatus::Under => Self::UNDER,
            RangeStatus::Within => Self::empty(),
            RangeStatus::Over => Self::OVER,
        };
        if valid { place } else { place | Self::INVALID }
    }
}

/// What a device shows instead of a value it must not show. errata-bpg-bcg-tpg 74 to 76.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum SafeState {
    /// The number 0 in any unit.
    #[default]
    Zero,
    /// Full Scale.
    FullScale,
    /// The last valid value measured in EXECUTING.
    HoldLastValue,
    /// Safe Value.
    UseSafeValue,
}

impl SafeState {
    /// The mode with this code.
    ///
    /// # Errors
    /// [`Refusal::Range`] if there is none.
    pub fn of(value: &Value) -> Result<Self, AccessError> {
        Ok(match value.integer()? {
            0u8 => Self::Zero,
            1 => Self::FullScale,
            2 => Self::HoldLastValue,
            3 => Self::UseSafeValue,
            _ => return Err(AccessError::OutOfRange),
        })
    }

    /// Its code.
    #[must_use]
    pub const fn code(self) -> u8 {
        match self {
            Self::Zero => 0,
            Self::FullScale => 1,
            Self::HoldLastValue => 2,
            Self::UseSafeValue => 3,
        }
    }
}

/// An ideal sensor with the adjustments a device makes to it.
#[derive(Clone, Copy, Debug)]
pub struct Sensor {
    /// What it senses, in Pa.
    pub sensed_pa: f64,
    /// What an adjustment multiplies it by.
    pub gain: f64,
    /// What an adjustment adds, in Pa.
    pub offset_pa: f64,
}

impl Sensor {
    /// As from the factory, in ambient air until somebody says otherwise.
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

/// What concerns the values of all parts of a device.
#[derive(Clone, Copy, Debug)]
pub struct ReadingCondition {
    /// The device measures.
    pub executing: bool,
    /// Something is wrong that makes every reading invalid: errata-bpg-bcg-tpg 54.
    pub disturbed: bool,
    /// A common or manufacturer alarm, for which every part shows its Safe State: errata-bpg-bcg-tpg 75.
    pub alarmed: bool,
}

/// A measuring part with what a master has set for it.
#[derive(Clone, Debug)]
pub struct MeasuringPart {
    /// What the tables say.
    pub facts: &'static PartSpec,
    /// The sensor.
    pub sensor: Sensor,
    /// Sensor or electronics have failed: a sensor alarm.
    pub failed: bool,
    /// What the device takes for the reading, in Pa, not clipped; `None` while the part does not measure.
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
    pub const fn new(facts: &'static PartSpec) -> Self {
        Self {
            facts,
            sensor: Sensor::in_air(),
            failed: false,
            reading_pa: None,
            safe_state: SafeState::Zero,
            safe_value_pa: 0.0,
            last_pa: 0.0,
        }
    }

    /// The same part when power returns: parameters and memory are gone, the sensor is still what and where it was.
    #[must_use]
    pub const fn restarted(&self) -> Self {
        Self { sensor: self.sensor.restarted(), failed: self.failed, ..Self::new(self.facts) }
    }

    /// The instance and how it senses.
    #[must_use]
    pub const fn part(&self) -> Part {
        self.facts.part
    }

    /// What the part is made for.
    #[must_use]
    pub const fn span(&self) -> MeasuringRange {
        let limits = &self.facts.limits;
        MeasuringRange { lowest_pa: limits.under_pa, highest_pa: limits.full_scale_pa }
    }

    /// Where the reading lies; on the high side while the part does not measure (errata-bpg-bcg-tpg 81).
    #[must_use]
    pub fn range(&self) -> RangeStatus {
        self.reading_pa.map_or(RangeStatus::Over, |pa| self.facts.limits.status_of(pa))
    }

    /// What the part indicates, in Pa, clipped where it does not measure (errata-bpg-bcg-tpg 81).
    #[must_use]
    pub fn indicated_pa(&self) -> f64 {
        self.reading_pa.map_or(self.facts.limits.over_pa, |pa| self.facts.clip(pa))
    }

    /// Reading Valid: measuring, nothing wrong, in range.
    #[must_use]
    pub fn is_valid(&self, condition: &ReadingCondition) -> bool {
        condition.executing && !condition.disturbed && self.range() == RangeStatus::Within
    }

    /// Status Extension (errata-bpg-bcg-tpg 57).
    #[must_use]
    pub fn status_extension(&self, condition: &ReadingCondition) -> StatusExtension {
        StatusExtension::new(self.range(), self.is_valid(condition))
    }

    /// Whether Safe State rules the value (errata-bpg-bcg-tpg 75).
    #[must_use]
    pub const fn is_safe(&self, condition: &ReadingCondition) -> bool {
        !condition.executing || condition.alarmed || self.failed
    }

    /// Process Value, in Pa.
    #[must_use]
    pub fn process_value_pa(&self, condition: &ReadingCondition) -> f64 {
        if self.is_safe(condition) { self.safe_pa() } else { self.indicated_pa() }
    }

    /// A valid value is remembered for Hold Last Value.
    pub fn remember(&mut self, condition: &ReadingCondition) {
        if self.is_valid(condition) {
            self.last_pa = self.indicated_pa();
        }
    }

    /// What Safe State says to show, in Pa.
    const fn safe_pa(&self) -> f64 {
        match self.safe_state {
            SafeState::Zero => 0.0,
            SafeState::FullScale => self.facts.limits.full_scale_pa,
            SafeState::HoldLastValue => self.last_pa,
            SafeState::UseSafeValue => self.safe_value_pa,
        }
    }

    /// Sensor Alarm: sensor and electronics share one bit (tira41d1 3.3.2.3).
    #[must_use]
    pub const fn sensor_alarm(&self) -> [u8; 2] {
        [0, if self.failed { 1 << 1 } else { 0 }]
    }

    /// What people see of it.
    #[must_use]
    pub fn indicated(&self, condition: &ReadingCondition) -> PartReading {
        PartReading {
            instance: self.part().instance,
            value_mbar: self.indicated_pa() / 100.0,
            valid: self.is_valid(condition),
        }
    }
}
