//! TPG300 and TPG500, total pressure gauge controllers with the interface board IF300P or IF301P. i9973ber/a.
//!
//! No block device in the sense of the gauges: DP-V0 only, no device state, no exceptions. Two slots take measuring
//! boards with up to two channels each, four relays compare their values with thresholds, and two more pairs of
//! thresholds switch the cold cathodes of the boards.
//!
//! [`table`] is the manual's tables; the rest is what they do: `channel` measures, `control` compares with thresholds
//! and switches relays and cathodes, `settings` and `threshold` are what a master sets, `parameters` leads every row to
//! its value, `bench` has bus and people.

mod channel;
mod codes;
mod control;
mod parameters;
mod settings;
mod simulation;
pub mod table;
mod threshold;

pub use channel::TpgGauge;

use crate::model::Model;
use crate::profile::{BlockDevice, FittedChannels, Setup};
use crate::store::Store;
use channel::{Status, TpgChannel};
use settings::{FIRST_CHANNEL, Settings, THRESHOLDS};
use table::{Faults, Switch};
use threshold::Threshold;

/// A TPG300 or TPG500 with its nonvolatile memory.
pub type Tpg<S> = BlockDevice<TpgBehaviour, S>;

/// How many channels the controller has: A1, A2, B1, B2.
pub const CHANNELS: usize = 4;

impl<S: Store> Tpg<S> {
    /// A controller that has just been switched on: one of [`table::TPG300`] and [`table::TPG500`], with the gauges of
    /// A1, A2, B1 and B2.
    #[must_use]
    pub fn new(model: &'static Model, store: S, setup: Setup, gauges: [Option<TpgGauge>; CHANNELS]) -> Self {
        Self::from_behaviour(TpgBehaviour::new(model, gauges), store, &setup)
    }
}

/// Where the fields of Sensor On_Off begin. errata-bpg-bcg-tpg 128.
const FIELDS: [u32; CHANNELS] = [0, 2, 4, 6];

/// The controller with its boards.
#[derive(Clone, Debug)]
pub struct TpgBehaviour {
    model: &'static Model,
    channels: [TpgChannel; CHANNELS],
    fitted: FittedChannels<CHANNELS>,
    faults: Faults,
    settings: Settings,
    /// What was stored on request.
    kept: Settings,
    /// What hotstart stores: the switches, as in Sensor On_Off; 0 without hotstart.
    hotstart: [f64; 1],
    /// Power has just come, and hotstart has not acted.
    starting: bool,
    /// Volatility, until the storage is done.
    volatility: u8,
    thresholds: [Threshold; THRESHOLDS],
    /// Sensor On_Off as it came last.
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
            volatility: 0,
            thresholds: [Threshold::default(); THRESHOLDS],
            sensor_on_off: 0,
            since_refresh_s: 0.0,
        }
    }

    /// The channel in this slot.
    fn channel(&self, slot: u8) -> Option<&TpgChannel> {
        self.channels.get(usize::from(slot.checked_sub(FIRST_CHANNEL)?))
    }

    /// Measurement status. Without its link the interface board knows no channel: errata-bpg-bcg-tpg 156.
    fn status(&self, slot: u8) -> Status {
        match self.channel(slot) {
            _ if self.faults.comm => Status::Error,
            Some(channel) => channel.status(),
            None => Status::NoHardware,
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
    // free choice: the command travels in every cycle, and acting on changes alone lets self monitoring have the last
    // word
    fn command(&mut self, octet: u8) {
        let changed = octet ^ core::mem::replace(&mut self.sensor_on_off, octet);
        self.switch(octet, changed);
    }

    /// Switches every channel whose field is not 0 in both octets.
    fn switch(&mut self, octet: u8, mask: u8) {
        for (channel, shift) in self.channels.iter_mut().zip(FIELDS) {
            if let Some(switch) = Switch::of(octet >> shift).filter(|_| mask >> shift & 0x03 != 0) {
                channel.command(switch);
            }
        }
    }

    /// How every channel is switched, as in Sensor On_Off.
    fn switches(&self) -> u8 {
        self.channels.iter().rev().fold(0, |octet, channel| octet << 2 | channel.switch() as u8)
    }

    /// After power-up every channel is as it was when hotstart was stored.
    fn start_hot(&mut self) {
        let [hotstart] = self.hotstart;
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "it was an octet")]
        self.switch(hotstart as u8, u8::MAX);
    }
}
