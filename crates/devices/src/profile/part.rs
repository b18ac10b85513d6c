//! One measuring part: what it senses, what it may say, and what it says instead.

use crate::instrument::Principle;
use crate::model::{Counts, Refusal, Value};

/// What the tables say about a measuring part.
#[derive(Debug)]
pub struct Facts {
    /// The instance.
    pub instance: u8,
    /// How it senses.
    pub principle: Principle,
    /// Its range.
    pub limits: Limits,
    /// Its COUNTS.
    pub counts: Counts,
}

/// The range of an instance in Pa.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Limits {
    /// Underrange: the lowest valid value.
    pub under_pa: f64,
    /// Overrange: the highest valid value.
    pub over_pa: f64,
    /// Full Scale.
    pub full_scale_pa: f64,
}

/// Where a value lies.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Range {
    /// Below underrange.
    Under,
    /// Valid.
    Within,
    /// Above overrange.
    Over,
}

/// The limits belong to the range (errata-bpg-bcg-tpg 55), also after a conversion between units.
const SLACK: f64 = 1e-9;

impl Limits {
    /// Where `pa` lies.
    #[must_use]
    pub fn judge(&self, pa: f64) -> Range {
        match pa {
            _ if pa < self.under_pa * (1.0 - SLACK) => Range::Under,
            _ if pa > self.over_pa * (1.0 + SLACK) => Range::Over,
            _ => Range::Within,
        }
    }
}

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
    pub fn new(range: Range, valid: bool) -> Self {
        let place = match range {
            Range::Under => Self::UNDER,
            Range::Within => Self::empty(),
            Range::Over => Self::OVER,
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
    pub fn of(value: &Value) -> Result<Self, Refusal> {
        Ok(match value.integer()? {
            0u8 => Self::Zero,
            1 => Self::FullScale,
            2 => Self::HoldLastValue,
            3 => Self::UseSafeValue,
            _ => return Err(Refusal::Range),
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
    /// The pressure it indicates, in Pa; never below zero.
    #[must_use]
    pub fn indicated_pa(&self) -> f64 {
        (self.sensed_pa * self.gain + self.offset_pa).max(0.0)
    }

    /// The same sensor with the adjustments of the factory.
    #[must_use]
    pub fn restarted(&self) -> Self {
        Self { sensed_pa: self.sensed_pa, ..Self::default() }
    }
}

impl Default for Sensor {
    /// Ambient air until somebody says otherwise.
    fn default() -> Self {
        Self { sensed_pa: 101_325.0, gain: 1.0, offset_pa: 0.0 }
    }
}

/// A measuring part with what a master has set for it.
#[derive(Clone, Debug)]
pub struct MeasuringPart {
    /// What the tables say.
    pub facts: &'static Facts,
    /// The sensor.
    pub sensor: Sensor,
    /// Safe State.
    pub safe_state: SafeState,
    /// Safe Value in Pa.
    pub safe_value_pa: f64,
    last_pa: f64,
}

impl MeasuringPart {
    /// A part as it leaves the factory: Safe State Zero, Safe Value 0 (errata-bpg-bcg-tpg 73), no last value (76).
    #[must_use]
    pub fn new(facts: &'static Facts) -> Self {
        let sensor = Sensor::default();
        Self { facts, sensor, safe_state: SafeState::Zero, safe_value_pa: 0.0, last_pa: 0.0 }
    }

    /// The same part when power returns: parameters and memory are gone, the sensor is still in its chamber.
    #[must_use]
    pub fn restarted(&self) -> Self {
        Self { sensor: self.sensor.restarted(), ..Self::new(self.facts) }
    }

    /// Remembers a valid value.
    pub const fn remember(&mut self, pa: f64) {
        self.last_pa = pa;
    }

    /// What Safe State says to show, in Pa.
    #[must_use]
    pub const fn safe_pa(&self) -> f64 {
        match self.safe_state {
            SafeState::Zero => 0.0,
            SafeState::FullScale => self.facts.limits.full_scale_pa,
            SafeState::HoldLastValue => self.last_pa,
            SafeState::UseSafeValue => self.safe_value_pa,
        }
    }
}
