//! Masters: the ring of the token, and the cycle of each master.

use super::{ADDRESSES, NO_STATION, Observer};
use crate::event::Change;
use crate::station::CycleState;
use profivac_dp::link::BitTime;

impl Observer {
    pub(super) fn master_heard(&mut self, address: u8, start: BitTime) {
        if let Some(station) = self.station_mut(address) {
            station.master_at = Some(start);
            station.heard_at = Some(start);
            station.unanswered_in_a_row = 0;
        }
    }

    pub(super) fn token(&mut self, from: u8, to: u8, start: BitTime) {
        self.totals.tokens = self.totals.tokens.saturating_add(1);
        self.master_heard(from, start);
        if let Some(station) = self.station_mut(to)
            && let Some(before) = station.token_at.replace(start)
        {
            let rotation_tbit = start - before;
            station.rotation.add(rotation_tbit);
            self.rotation.add(rotation_tbit);
        }
        let Some(next) = self.next.get_mut(usize::from(from)) else { return };
        if std::mem::replace(next, to) != to || !self.ring.contains(&from) {
            self.follow_ring(from);
        }
    }

    /// Reports the ring if it closes and has changed.
    pub(super) fn follow_ring(&mut self, start: u8) {
        let Some(mut ring) = self.closed_ring(start) else { return };
        let lowest = ring.iter().enumerate().min_by_key(|(_, station)| **station).map_or(0, |(index, _)| index);
        ring.rotate_left(lowest);
        if ring == self.ring {
            return;
        }
        self.event(None, Change::Ring(ring.clone()));
        let mut next = [NO_STATION; ADDRESSES];
        for address in &ring {
            if let Some(next) = next.get_mut(usize::from(*address)) {
                *next = self.next_of(*address);
            }
        }
        self.next = next;
        self.ring = ring;
    }

    /// The masters in the order of the token from `start`, if it comes back to it. The cost is that of one step for each address.
    fn closed_ring(&self, start: u8) -> Option<Vec<u8>> {
        let mut ring = Vec::new();
        let (mut here, mut seen) = (start, 0_u128);
        loop {
            // `NO_STATION` has no bit.
            let bit = 1_u128.checked_shl(here.into())?;
            if seen & bit != 0 {
                return (here == start).then_some(ring);
            }
            seen |= bit;
            ring.push(here);
            here = self.next_of(here);
        }
    }

    pub(super) fn next_of(&self, address: u8) -> u8 {
        self.next.get(usize::from(address)).copied().unwrap_or(NO_STATION)
    }

    /// Measures the interval of the slave and the cycle of the master.
    pub(super) fn cycle_request(&mut self, master: u8, slave: u8, start: BitTime) {
        if let Some(station) = self.station_mut(slave)
            && let Some(before) = station.exchange_requested_at.replace(start)
        {
            station.interval.add(start - before);
        }
        let bit = 1_u128.checked_shl(slave.into()).unwrap_or_default();
        let Some(master) = self.station_mut(master) else { return };
        if master.cycle_state.served & bit == 0 {
            if master.cycle_state.served == 0 {
                master.cycle_state.began = start;
            }
            master.cycle_state.served |= bit;
            return;
        }
        let cycle_tbit = start - master.cycle_state.began;
        master.cycle_state = CycleState { served: bit, began: start };
        master.cycle.add(cycle_tbit);
        self.cycle.add(cycle_tbit);
    }
}
