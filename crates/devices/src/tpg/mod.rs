//! TPG300 and TPG500, total pressure gauge controllers with the interface board IF300P or IF301P. i9973ber/a.
//!
//! Unlike the gauges they have no DP-V1, no device state and no exceptions. Two slots take measuring boards with up to
//! two channels each, four relays compare their values with thresholds, and two more pairs of thresholds switch the
//! cold cathodes of the boards.
//!
//! [`table`] has the manual's tables, [`codes`] the code tables. `channel` measures, `control` compares with thresholds and
//! switches relays and cathodes, `settings` and `threshold` have the settings of a master, `parameters` reads and
//! writes every row, `simulation` has cyclic data and front panel.

mod channel;
pub mod codes;
mod control;
mod faults;
mod parameters;
mod settings;
mod simulation;
pub mod table;
mod threshold;

pub use channel::TpgGauge;

use crate::model::Model;
use crate::profile::{BlockDevice, FittedChannels, Setup};
use crate::store::Store;
use channel::{SensorSwitch, TpgChannel};
use codes::{MeasurementStatus, Volatility};
use faults::Faults;
use settings::{FIRST_CHANNEL, Settings, THRESHOLDS};
use threshold::Threshold;

/// A TPG300 or TPG500 with its nonvolatile memory.
pub type Tpg<S> = BlockDevice<TpgBehaviour, S>;

/// The number of channels of the controller: A1, A2, B1, B2.
pub const CHANNELS: usize = 4;

impl<S: Store> Tpg<S> {
    /// A controller that has just been switched on: one of [`table::TPG300`] and [`table::TPG500`], with the gauges of
    /// A1, A2, B1 and B2.
    #[must_use]
    pub fn new(model: &'static Model, store: S, setup: Setup, gauges: [Option<TpgGauge>; CHANNELS]) -> Self {
        Self::from_behaviour(TpgBehaviour::new(model, gauges), store, &setup)
    }
}

/// The first bit of each field of Sensor On_Off. errata-bpg-bcg-tpg 128.
const FIELDS: [u32; CHANNELS] = [0, 2, 4, 6];

/// The controller with its boards.
#[derive(Clone, Debug)]
pub struct TpgBehaviour {
    model: &'static Model,
    channels: [TpgChannel; CHANNELS],
    fitted: FittedChannels<CHANNELS>,
    faults: Faults,
    settings: Settings,
    /// The settings that were stored on request.
    kept: Settings,
    /// The stored switches for hotstart, as in Sensor On_Off; 0 without hotstart.
    hotstart: [f64; 1],
    /// The device has just started, and hotstart has not acted.
    starting: bool,
    /// Volatility, until the storage is done.
    volatility: Volatility,
    thresholds: [Threshold; THRESHOLDS],
    /// The last octet of Sensor On_Off.
    sensor_on_off: u8,
    /// Time since the measured values were renewed.
    since_refresh_s: f64,
}

impl TpgBehaviour {
    fn new(model: &'static Model, gauges: [Option<TpgGauge>; CHANNELS]) -> Self {
        Self {
            model,
            channels: gauges.map(TpgChannel::new),
            fitted: FittedChannels::new(gauges.map(|gauge| gauge.map(TpgGauge::principle))),
            faults: Faults::NONE,
            settings: Settings::factory(&gauges),
            kept: Settings::factory(&gauges),
            hotstart: [0.0],
            starting: true,
            volatility: Volatility::ReadyToStore,
            thresholds: [Threshold::default(); THRESHOLDS],
            sensor_on_off: 0,
            since_refresh_s: 0.0,
        }
    }

    /// The channel in this slot.
    fn channel(&self, slot: u8) -> Option<&TpgChannel> {
        self.channels.get(usize::from(slot.checked_sub(FIRST_CHANNEL)?))
    }

    /// Measurement status. Without its link the interface board has no channels: errata-bpg-bcg-tpg 156.
    fn status(&self, slot: u8) -> MeasurementStatus {
        match self.channel(slot) {
            _ if self.faults.comm => MeasurementStatus::Error,
            Some(channel) => channel.status(),
            None => MeasurementStatus::NoHardware,
        }
    }

    /// Measured value in Pa.
    fn measured_pa(&self, slot: u8) -> f64 {
        match self.channel(slot) {
            Some(channel) if !self.faults.comm => channel.measured_pa(),
            _ => 0.0,
        }
    }

    /// Sensor On_Off: a channel whose field has changed is switched. IF300P/IF301P manual 3.2.3.2.
    // chosen: the command is in every cycle; acting only on changes leaves the decision to self monitoring
    fn command(&mut self, octet: u8) {
        let changed = octet ^ core::mem::replace(&mut self.sensor_on_off, octet);
        self.switch(octet, changed);
    }

    /// Switches every channel whose field is not 0 in both octets.
    fn switch(&mut self, octet: u8, mask: u8) {
        for (channel, shift) in self.channels.iter_mut().zip(FIELDS) {
            if let Some(switch) = SensorSwitch::from_field(octet >> shift).filter(|_| mask >> shift & 0x03 != 0) {
                channel.command(switch);
            }
        }
    }

    /// The switches of all channels, as in Sensor On_Off.
    fn switches(&self) -> u8 {
        self.channels.iter().rev().fold(0, |octet, channel| octet << 2 | channel.switch() as u8)
    }

    /// Switches every channel as it was when hotstart was stored.
    fn start_hot(&mut self) {
        let [hotstart] = self.hotstart;
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "it was an octet")]
        self.switch(hotstart as u8, u8::MAX);
    }
}
