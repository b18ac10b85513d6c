//! One measuring channel: the gauge on it, whether it is switched on, and what it shows.

use super::table::{Filter, Switch};
use crate::simulation::{MeasuringRange, Principle};

/// The controller renews its measured values in this time, in seconds. IF300P/IF301P manual 3.2.1.1.
pub(super) const REFRESH_S: f64 = 0.1;

/// How long a reading must have been within its range before underrange control trusts it, in seconds. Manual 3.2.3.2.
const TRUSTED_AFTER_S: f64 = 10.0;

/// Pressures beyond these are the same to every gauge; between them the filter has a logarithm to work with.
const LOWEST_PA: f64 = 1e-15;
const HIGHEST_PA: f64 = 1e9;

/// The gauge a measuring board reads on a channel.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum TpgGauge {
    /// A Pirani gauge, on from power-up.
    Pirani,
    /// A cold cathode gauge, whose high voltage is switched.
    ColdCathode,
}

impl TpgGauge {
    /// How it senses.
    #[must_use]
    pub const fn principle(self) -> Principle {
        match self {
            Self::Pirani => Principle::Pirani,
            Self::ColdCathode => Principle::ColdCathode,
        }
    }

    /// The lowest and the highest pressure it measures, in Pa.
    // free choice: the manual leaves them to the gauges; a standard Pirani gauge and a cold cathode gauge
    pub(super) const fn span(self) -> MeasuringRange {
        match self {
            Self::Pirani => MeasuringRange { lowest_pa: 8e-2, highest_pa: 1e5 },
            Self::ColdCathode => MeasuringRange { lowest_pa: 1e-7, highest_pa: 1.0 },
        }
    }
}

/// Measurement status. IF300P/IF301P manual 3.2.4.1.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u8)]
pub(super) enum Status {
    Ok = 0,
    Underrange = 1,
    Overrange = 2,
    /// Also of a gauge that is not plugged in: its board is there, and "no hardware" is a channel without one
    /// (errata-bpg-bcg-tpg 124).
    Error = 3,
    Off = 4,
    NoHardware = 5,
}

/// A channel of the controller.
#[derive(Clone, Debug)]
pub(super) struct TpgChannel {
    gauge: Option<TpgGauge>,
    /// Gauge, electronics or plug are broken.
    pub failed: bool,
    /// The last command that switched it.
    switch: Switch,
    on: bool,
    sensed_pa: f64,
    /// The reading after the filter.
    filtered_pa: f64,
    /// How long it has been within its range, since it was switched on.
    steady_s: f64,
}

impl TpgChannel {
    /// After power-up a Pirani gauge is on, a cold cathode gauge waits for its control block or a command.
    // free choice: the manual leaves the state after power-up to the controller
    pub fn new(gauge: Option<TpgGauge>) -> Self {
        Self {
            gauge,
            failed: false,
            switch: Switch::Automatic,
            on: gauge == Some(TpgGauge::Pirani),
            sensed_pa: 1e5,
            filtered_pa: 1e5,
            steady_s: 0.0,
        }
    }

    /// Power returns; the gauge is still in its chamber, and as broken as before.
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

    pub const fn switch(&self) -> Switch {
        self.switch
    }

    pub fn is_cold_cathode(&self) -> bool {
        self.gauge == Some(TpgGauge::ColdCathode)
    }

    /// Whether underrange control may trust the reading.
    pub fn is_trusted(&self) -> bool {
        self.steady_s > TRUSTED_AFTER_S
    }

    /// Sensor On_Off. IF300P/IF301P manual 3.2.3.2. Automatic on a Pirani gauge means on, nothing controls it.
    pub fn command(&mut self, switch: Switch) {
        self.switch = switch;
        match switch {
            Switch::Off => self.turn(false),
            Switch::On => self.turn(true),
            Switch::Automatic => self.turn(self.on || !self.is_cold_cathode()),
        }
    }

    /// Switches the gauge. A gauge that comes on shows what it senses at once.
    pub fn turn(&mut self, on: bool) {
        if on && !self.on {
            self.filtered_pa = self.sensed_pa;
            self.steady_s = 0.0;
        }
        self.on = on;
    }

    pub fn sense(&mut self, pa: f64) {
        self.sensed_pa = if pa > LOWEST_PA { pa.min(HIGHEST_PA) } else { LOWEST_PA };
    }

    /// The measured value is renewed after `seconds`. The filter works on the logarithm, as the gauges' signals are.
    pub fn refresh(&mut self, seconds: f64, filter: Filter) {
        let rest = libm::exp(-seconds / filter.seconds());
        self.filtered_pa = self.sensed_pa * libm::pow(self.filtered_pa / self.sensed_pa, rest);
        match self.status() {
            Status::Ok => self.steady_s += seconds,
            _ if !self.is_trusted() => self.steady_s = 0.0,
            _ => {}
        }
    }

    /// The filter has had all the time it wants.
    pub fn settle(&mut self) {
        self.filtered_pa = self.sensed_pa;
    }

    pub fn status(&self) -> Status {
        let Some(gauge) = self.gauge else { return Status::NoHardware };
        if !self.on {
            return Status::Off;
        }
        if self.failed {
            return Status::Error;
        }
        let MeasuringRange { lowest_pa, highest_pa } = gauge.span();
        match self.filtered_pa {
            pa if pa < lowest_pa => Status::Underrange,
            pa if pa > highest_pa => Status::Overrange,
            _ => Status::Ok,
        }
    }

    /// The measured value in Pa: kept within the range of the gauge, 0 where there is none (errata-bpg-bcg-tpg 154).
    // free choice: outside its range a channel shows the limit
    pub fn measured_pa(&self) -> f64 {
        match (self.status(), self.gauge) {
            (Status::Ok | Status::Underrange | Status::Overrange, Some(gauge)) => {
                let MeasuringRange { lowest_pa, highest_pa } = gauge.span();
                self.filtered_pa.max(lowest_pa).min(highest_pa)
            }
            _ => 0.0,
        }
    }

    /// The pressure a threshold compares: beyond the range it is lower or higher than any threshold.
    pub fn compared_pa(&self) -> Option<f64> {
        match self.status() {
            Status::Ok => Some(self.filtered_pa),
            Status::Underrange => Some(0.0),
            Status::Overrange => Some(f64::INFINITY),
            Status::Error | Status::Off | Status::NoHardware => None,
        }
    }
}
