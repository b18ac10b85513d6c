//! The thresholds of relays and cold cathodes. IF300P/IF301P manual 3.2.4.2, errata-bpg-bcg-tpg 140 to 144.

use super::TpgBehaviour;
use super::channel::SensorSwitch;
use super::codes::UnderrangeControl;
use super::settings::FIRST_CHANNEL;
use crate::profile::switched;

/// The positions of the blocks: relays 1 to 4, then one cold cathode block for each board, with the slots of its
/// channels.
pub(super) const RELAYS: core::ops::Range<usize> = 0..4;
const BOARDS: [(usize, [u8; 2]); 2] = [(4, [1, 2]), (5, [3, 4])];

impl TpgBehaviour {
    /// Switches cathodes and relays after a change of the measured values. Cathodes first, because relays may compare
    /// them.
    pub(super) fn control(&mut self) {
        for (block, slots) in BOARDS {
            self.compare(block, self.compared_pa(self.source(block)));
            for slot in slots {
                self.control_cathode(block, slot);
            }
        }
        for relay in RELAYS {
            self.compare(relay, self.relay_pa(self.source(relay)));
        }
    }

    /// Compares a pressure with the thresholds of a block.
    fn compare(&mut self, block: usize, pressure: Option<f64>) {
        if let (Some(limits), Some(threshold)) = (self.settings.limits.get(block), self.thresholds.get_mut(block)) {
            threshold.activated = switched(pressure, limits.lower_pa, limits.upper_pa, threshold.activated);
        }
    }

    /// The slot of the channel that a block compares.
    fn source(&self, block: usize) -> u8 {
        self.settings.limits.get(block).map_or(0, |limits| limits.source)
    }

    /// The pressure of the channel in this slot, as thresholds compare it.
    fn compared_pa(&self, slot: u8) -> Option<f64> {
        self.channel(slot)?.compared_pa()
    }

    /// The pressure that a relay compares. With underrange control a cold cathode must have measured for ten seconds;
    /// from then on underrange is a low pressure like any other. 3.2.3.2.
    fn relay_pa(&self, slot: u8) -> Option<f64> {
        let channel = self.channel(slot)?;
        let waits = self.settings.underrange == UnderrangeControl::RelayWaitsForValidValue
            && channel.is_cold_cathode()
            && !channel.is_trusted();
        if waits { None } else { channel.compared_pa() }
    }

    /// Switches a cold cathode by the block of its board, under automatic control. A block whose source is the cathode
    /// itself monitors it: it only switches off, and a new command is needed to switch on again.
    // chosen: the manual names one block per board and leaves open what it does to two cathodes on the board
    fn control_cathode(&mut self, block: usize, slot: u8) {
        let (Some(limits), Some(threshold)) = (self.settings.limits.get(block), self.thresholds.get(block)) else {
            return;
        };
        let (own, activated) = (limits.source == slot, threshold.activated);
        let exceeded = self.compared_pa(limits.source).is_some_and(|pa| pa > limits.upper_pa);
        let position = usize::from(slot.saturating_sub(FIRST_CHANNEL));
        let Some(channel) = self.channels.get_mut(position).filter(|channel| channel.is_cold_cathode()) else { return };
        match (own, channel.switch()) {
            (true, _) if exceeded => channel.turn(false),
            (false, SensorSwitch::Automatic) => channel.turn(activated),
            _ => {}
        }
    }
}
