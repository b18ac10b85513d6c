//! A measuring channel: its gauge, its switch, and its measured value.

use super::codes::{Filter, MeasurementStatus};
use crate::model::{MeasuringRange, Principle};

/// The controller renews its measured values in this time, in seconds. IF300P/IF301P manual 3.2.1.1.
pub(super) const REFRESH_S: f64 = 0.1;

/// The time that a reading must have been within its range before underrange control trusts it, in seconds. Manual
/// 3.2.3.2.
const TRUSTED_AFTER_S: f64 = 10.0;

/// Pressures are clamped to these, so that the filter has a logarithm. They are beyond the range of every gauge.
const LOWEST_PA: f64 = 1e-15;
const HIGHEST_PA: f64 = 1e9;

/// The gauge on a channel.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum TpgGauge {
    /// A Pirani gauge, on from power-up.
    Pirani,
    /// A cold cathode gauge, whose high voltage is switched.
    ColdCathode,
}

impl TpgGauge {
    /// Its principle.
    #[must_use]
    pub const fn principle(self) -> Principle {
        match self {
            Self::Pirani => Principle::Pirani,
            Self::ColdCathode => Principle::ColdCathode,
        }
    }

    /// The lowest and the highest pressure it measures, in Pa.
    // chosen: the manual leaves them to the gauges; a standard Pirani gauge and a cold cathode gauge
    pub(super) const fn measuring_range(self) -> MeasuringRange {
        match self {
            Self::Pirani => MeasuringRange { lowest_pa: 8e-2, highest_pa: 1e5 },
            Self::ColdCathode => MeasuringRange { lowest_pa: 1e-7, highest_pa: 1.0 },
        }
    }
}

/// The command of Sensor On_Off for one channel. 3.2.3.2.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum SensorSwitch {
    /// Off.
    Off = 1,
    /// Switched by the thresholds of the board.
    Automatic = 2,
    /// On.
    On = 3,
}

impl SensorSwitch {
    /// The command in the low two bits; 0 is no command.
    pub const fn from_field(field: u8) -> Option<Self> {
        match field & 0x03 {
            1 => Some(Self::Off),
            2 => Some(Self::Automatic),
            3 => Some(Self::On),
            _ => None,
        }
    }
}

/// A channel of the controller.
#[derive(Clone, Debug)]
pub(super) struct TpgChannel {
    gauge: Option<TpgGauge>,
    /// Gauge, electronics or plug are broken.
    pub failed: bool,
    /// The last command that switched it.
    switch: SensorSwitch,
    on: bool,
    sensed_pa: f64,
    /// The reading after the filter.
    filtered_pa: f64,
    /// The time for which it has been within its range, since it was switched on.
    steady_s: f64,
}

impl TpgChannel {
    /// A channel after power-up: a Pirani gauge is on, a cold cathode gauge is off until its control block or a command
    /// switches it on.
    // chosen: the manual leaves the state after power-up to the controller
    pub fn new(gauge: Option<TpgGauge>) -> Self {
        Self {
            gauge,
            failed: false,
            switch: SensorSwitch::Automatic,
            on: gauge == Some(TpgGauge::Pirani),
            sensed_pa: 1e5,
            filtered_pa: 1e5,
            steady_s: 0.0,
        }
    }

    /// The same channel after power-up, with the same gauge, pressure and failure.
    pub fn restarted(&self) -> Self {
        let Self { failed, sensed_pa, .. } = *self;
        Self { failed, sensed_pa, filtered_pa: sensed_pa, ..Self::new(self.gauge) }
    }

    pub const fn gauge(&self) -> Option<TpgGauge> {
        self.gauge
    }

    pub const fn is_on(&self) -> bool {
        self.on
    }

    pub const fn switch(&self) -> SensorSwitch {
        self.switch
    }

    pub fn is_cold_cathode(&self) -> bool {
        self.gauge == Some(TpgGauge::ColdCathode)
    }

    /// Whether underrange control may trust the reading.
    pub fn is_trusted(&self) -> bool {
        self.steady_s > TRUSTED_AFTER_S
    }

    /// Executes a command of Sensor On_Off. IF300P/IF301P manual 3.2.3.2. Automatic switches a Pirani gauge on, because
    /// no thresholds control it.
    pub fn command(&mut self, switch: SensorSwitch) {
        self.switch = switch;
        match switch {
            SensorSwitch::Off => self.turn(false),
            SensorSwitch::On => self.turn(true),
            SensorSwitch::Automatic => self.turn(self.on || !self.is_cold_cathode()),
        }
    }

    /// Switches the gauge. A gauge that is switched on shows its present pressure without delay.
    pub fn turn(&mut self, on: bool) {
        if on && !self.on {
            self.filtered_pa = self.sensed_pa;
            self.steady_s = 0.0;
        }
        self.on = on;
    }

    /// Sets the sensed pressure. The filter begins at the first signal of a cold cathode: a value between no signal and that
    /// one would be a valid ultra-high vacuum.
    // chosen: the manual does not describe ignition
    pub fn sense(&mut self, pa: f64) {
        let ignites = self.is_cold_cathode() && self.on && self.sensed_pa <= LOWEST_PA && pa > LOWEST_PA;
        self.sensed_pa = if pa > LOWEST_PA { pa.min(HIGHEST_PA) } else { LOWEST_PA };
        if ignites {
            self.filtered_pa = self.sensed_pa;
        }
    }

    /// Renews the measured value after `seconds`. The filter works on the logarithm, because the signals of the gauges
    /// are logarithmic.
    pub fn refresh(&mut self, seconds: f64, filter: Filter) {
        let rest = libm::exp(-seconds / filter.seconds());
        self.filtered_pa = self.sensed_pa * libm::pow(self.filtered_pa / self.sensed_pa, rest);
        match self.status() {
            MeasurementStatus::Ok => self.steady_s += seconds,
            _ if !self.is_trusted() => self.steady_s = 0.0,
            _ => {}
        }
    }

    /// Completes the filter at once.
    pub fn settle(&mut self) {
        self.filtered_pa = self.sensed_pa;
    }

    pub fn status(&self) -> MeasurementStatus {
        let Some(gauge) = self.gauge else { return MeasurementStatus::NoHardware };
        if !self.on {
            return MeasurementStatus::Off;
        }
        if self.failed {
            return MeasurementStatus::Error;
        }
        let MeasuringRange { lowest_pa, highest_pa } = gauge.measuring_range();
        match self.filtered_pa {
            pa if pa < lowest_pa => MeasurementStatus::Underrange,
            pa if pa > highest_pa => MeasurementStatus::Overrange,
            _ => MeasurementStatus::Ok,
        }
    }

    /// The measured value in Pa: clamped to the range of the gauge, 0 without one (errata-bpg-bcg-tpg 154).
    // chosen: outside its range a channel shows the limit
    pub fn measured_pa(&self) -> f64 {
        match (self.status(), self.gauge) {
            (MeasurementStatus::Ok | MeasurementStatus::Underrange | MeasurementStatus::Overrange, Some(gauge)) => {
                let MeasuringRange { lowest_pa, highest_pa } = gauge.measuring_range();
                self.filtered_pa.max(lowest_pa).min(highest_pa)
            }
            _ => 0.0,
        }
    }

    /// The pressure that a threshold compares: below the range 0, above it infinite.
    pub fn compared_pa(&self) -> Option<f64> {
        match self.status() {
            MeasurementStatus::Ok => Some(self.filtered_pa),
            MeasurementStatus::Underrange => Some(0.0),
            MeasurementStatus::Overrange => Some(f64::INFINITY),
            MeasurementStatus::Error | MeasurementStatus::Off | MeasurementStatus::NoHardware => None,
        }
    }
}
