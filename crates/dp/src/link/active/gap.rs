//! The GAP of an active station: the addresses between it and its successor, and the live list.
//! profibus-wire 1.13.

use crate::link::time::BitTime;
use profivac_wire::control::StationType;

/// The number of station addresses.
const ADDRESSES: u8 = 127;

/// The addresses to ask, and their answers.
#[derive(Clone, Debug)]
pub(super) struct Gap {
    own: u8,
    hsa: u8,
    /// The pause between two scans of the GAP.
    pause_tbit: u64,
    /// The station polls no address before this time.
    not_before: BitTime,
    /// Every scan begins with the pause.
    delayed: bool,
    /// The address asked last.
    cursor: u8,
    stations: [Option<StationType>; ADDRESSES as usize],
}

impl Gap {
    /// A GAP with an empty live list.
    pub(super) const fn new(own: u8, hsa: u8, pause_tbit: u64) -> Self {
        Self {
            own,
            hsa,
            pause_tbit,
            not_before: BitTime(0),
            delayed: false,
            cursor: own,
            stations: [None; ADDRESSES as usize],
        }
    }

    /// The address to ask in the token visit that ends at `now`, if the GAP is being scanned. One address per visit, from this
    /// station to `successor`, then a pause.
    ///
    /// The pause is G x T_TR and not G rotations; profibus-wire 1.13 has both. An idle ring rotates so fast that G rotations
    /// would end at once, and every cycle would be a slot time longer.
    #[inline]
    pub(super) fn next_address(&mut self, now: BitTime, successor: u8) -> Option<u8> {
        if now < self.not_before {
            return None;
        }
        let next = if self.cursor >= self.hsa { 0 } else { self.cursor.saturating_add(1) };
        if self.contains(next, successor) {
            self.cursor = next;
            return Some(next);
        }
        self.cursor = self.own;
        self.not_before = now + self.pause_tbit;
        None
    }

    /// Whether `address` is between this station and its successor. A station that is alone has all addresses in its GAP.
    const fn contains(&self, address: u8, successor: u8) -> bool {
        let end = if successor == self.own { ADDRESSES } else { self.steps_to(successor) };
        0 < self.steps_to(address) && self.steps_to(address) < end
    }

    /// The distance to `address`, upwards and around.
    const fn steps_to(&self, address: u8) -> u8 {
        if address >= self.own {
            address.saturating_sub(self.own)
        } else {
            address.saturating_add(ADDRESSES).saturating_sub(self.own)
        }
    }

    /// The next visit after `now` begins a scan.
    pub(super) fn scan(&mut self, now: BitTime) {
        self.cursor = self.own;
        self.not_before = if self.delayed { now + self.pause_tbit } else { now };
    }

    /// `address` does not take the token: the next visit after `now` asks the addresses behind it, or continues the present
    /// scan. The address itself is asked in the next scan only: a station that only claims to be a master must not cost a slot
    /// time in every visit.
    pub(super) fn scan_behind(&mut self, address: u8, now: BitTime) {
        if self.delayed {
            self.scan(now);
        } else if now < self.not_before {
            self.cursor = address;
            self.not_before = now;
        }
    }

    /// Every scan begins with the pause.
    pub(super) const fn delay_scans(&mut self) {
        self.delayed = true;
    }

    /// Sets the highest station address and starts a new scan.
    pub(super) const fn set_hsa(&mut self, hsa: u8) {
        self.hsa = hsa;
        self.cursor = self.own;
        self.not_before = BitTime(0);
    }

    /// Sets the station type that `address` answered to FDL status; `None` if it did not answer.
    pub(super) fn set_station(&mut self, address: u8, station: Option<StationType>) {
        if let Some(target) = self.stations.get_mut(usize::from(address)) {
            *target = station;
        }
    }

    /// The stations that answered the last FDL status request.
    pub(super) fn live_list(&self) -> impl Iterator<Item = (u8, StationType)> {
        (0..).zip(&self.stations).filter_map(|(address, station)| station.map(|station| (address, station)))
    }
}

#[cfg(test)]
mod tests {
    extern crate std;
    use super::*;
    use std::vec::Vec;

    const PAUSE_TBIT: u64 = 1000;

    /// The addresses asked in visits 10 bit times apart, as text.
    fn addresses_asked(gap: &mut Gap, successor: u8, visits: u64) -> std::string::String {
        let visit = |visit: u64| gap.next_address(BitTime(visit.saturating_mul(10)), successor);
        let visits: Vec<_> = (1..=visits).map(visit).collect();
        let words = visits.iter().map(|asked| asked.map_or("-".into(), |address| std::format!("{address}")));
        words.collect::<Vec<_>>().join(" ")
    }

    #[test]
    fn one_address_is_asked_per_visit_from_the_own_address_to_the_successor() {
        for (own, hsa, successor, expected) in [
            // Alone: all addresses but its own, around the highest address.
            (2, 5, 2, "3 4 5 0 1 -"),
            (0, 2, 0, "1 2 -"),
            (5, 5, 5, "0 1 2 3 4 -"),
            (0, 0, 0, "-"),
            // Two and more: only the addresses between.
            (2, 20, 5, "3 4 -"),
            (5, 8, 2, "6 7 8 0 1 -"),
            (2, 20, 3, "-"),
            (20, 20, 0, "-"),
            // A successor above HSA: another master has another HSA.
            (2, 5, 9, "3 4 5 -"),
            (9, 5, 2, "0 1 -"),
        ] {
            let mut gap = Gap::new(own, hsa, PAUSE_TBIT);
            let visits = expected.split(' ').count() as u64;
            assert_eq!(addresses_asked(&mut gap, successor, visits), expected, "{own} before {successor}, HSA {hsa}");
            assert_eq!(
                gap.next_address(BitTime(visits.saturating_mul(10)) + PAUSE_TBIT.saturating_sub(1), successor),
                None,
                "the pause"
            );
            let again = gap
                .next_address(BitTime(visits.saturating_mul(10)) + PAUSE_TBIT, successor)
                .map_or("-".into(), |next| std::format!("{next}"));
            assert_eq!(Some(again.as_str()), expected.split(' ').next(), "after the pause");
        }
    }

    #[test]
    fn a_successor_that_goes_and_a_new_hsa_end_the_pause() {
        let mut gap = Gap::new(2, 20, PAUSE_TBIT);
        assert_eq!(addresses_asked(&mut gap, 5, 4), "3 4 - -");
        // Five has left, and so has seven: the addresses behind five were not asked yet.
        gap.scan_behind(5, BitTime(5));
        gap.scan_behind(7, BitTime(5));
        assert_eq!(addresses_asked(&mut gap, 9, 4), "6 7 8 -");
        gap.scan(BitTime(5));
        assert_eq!(addresses_asked(&mut gap, 9, 7), "3 4 5 6 7 8 -");
        gap.set_hsa(4);
        assert_eq!(addresses_asked(&mut gap, 2, 5), "3 4 0 1 -");
    }

    #[test]
    fn a_station_with_delayed_scans_asks_after_the_first_pause() {
        let mut gap = Gap::new(2, 20, 35);
        gap.delay_scans();
        gap.scan(BitTime(0));
        assert_eq!(addresses_asked(&mut gap, 5, 6), "- - - 3 4 -");
    }

    #[test]
    fn a_successor_that_was_found_ends_the_scan() {
        let mut gap = Gap::new(2, 20, PAUSE_TBIT);
        assert_eq!(addresses_asked(&mut gap, 2, 3), "3 4 5");
        assert_eq!(addresses_asked(&mut gap, 5, 2), "- -");
    }

    #[test]
    fn the_live_list_drops_a_station_that_does_not_answer_any_more() {
        let mut gap = Gap::new(2, 126, PAUSE_TBIT);
        gap.set_station(8, Some(StationType::Slave));
        gap.set_station(3, Some(StationType::MasterNotReady));
        gap.set_station(200, Some(StationType::Slave));
        assert_eq!(gap.live_list().collect::<Vec<_>>(), [(3, StationType::MasterNotReady), (8, StationType::Slave)]);
        gap.set_station(3, None);
        assert_eq!(gap.live_list().collect::<Vec<_>>(), [(8, StationType::Slave)]);
    }
}
