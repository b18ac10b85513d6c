//! Who else is there: the GAP of an active station and the list of what was found in it. profibus-wire 1.13.

use profivac_wire::control::StationType;

/// The addresses to ask, and what they answered.
#[derive(Clone, Debug)]
pub(super) struct Gap {
    own: u8,
    hsa: u8,
    /// G: one address every so many token visits.
    factor: u8,
    /// Visits since an address was asked.
    visits: u8,
    /// Which address was asked last.
    cursor: u8,
    live: [Option<StationType>; 127],
}

impl Gap {
    /// Nobody is known yet.
    pub(super) const fn new(own: u8, hsa: u8, factor: u8) -> Self {
        Self { own, hsa, factor, visits: 0, cursor: own, live: [None; 127] }
    }

    /// A token visit ends: the address to ask in it, if this visit is for asking.
    ///
    /// free choice: the visits for asking are spread evenly, one in G, instead of asking in each until the GAP is through
    /// and pausing then. A cycle of slaves then takes the same time always.
    pub(super) fn visit(&mut self) -> Option<u8> {
        self.visits = self.visits.saturating_add(1);
        if self.visits < self.factor {
            return None;
        }
        self.visits = 0;
        let next = self.after(self.cursor);
        // Our own address comes up once per round, and is passed over.
        let next = if next == self.own { self.after(next) } else { next };
        self.cursor = next;
        (next != self.own).then_some(next)
    }

    const fn after(&self, address: u8) -> u8 {
        if address >= self.hsa { 0 } else { address.saturating_add(1) }
    }

    /// What `address` answered to FDL status, or that it did not.
    pub(super) fn note(&mut self, address: u8, station: Option<StationType>) {
        if let Some(place) = self.live.get_mut(usize::from(address)) {
            *place = station;
        }
    }

    /// Everybody that answered when asked last.
    pub(super) fn live(&self) -> impl Iterator<Item = (u8, StationType)> {
        (0..).zip(&self.live).filter_map(|(address, station)| station.map(|station| (address, station)))
    }
}

#[cfg(test)]
mod tests {
    extern crate std;
    use super::*;
    use std::vec::Vec;

    fn asked(gap: &mut Gap, visits: usize) -> Vec<Option<u8>> {
        (0..visits).map(|_| gap.visit()).collect()
    }

    #[test]
    fn every_address_up_to_hsa_but_the_own_is_asked_in_turn() {
        let some = |addresses: &[u8]| addresses.iter().copied().map(Some).collect::<Vec<_>>();
        assert_eq!(asked(&mut Gap::new(2, 5, 1), 7), some(&[3, 4, 5, 0, 1, 3, 4]));
        assert_eq!(asked(&mut Gap::new(0, 2, 1), 4), some(&[1, 2, 1, 2]));
        assert_eq!(asked(&mut Gap::new(5, 5, 1), 6), some(&[0, 1, 2, 3, 4, 0]));
        assert_eq!(asked(&mut Gap::new(0, 0, 1), 2), [None, None]);
    }

    #[test]
    fn the_factor_leaves_visits_without_a_question() {
        assert_eq!(asked(&mut Gap::new(2, 126, 3), 6), [None, None, Some(3), None, None, Some(4)]);
    }

    #[test]
    fn the_live_list_forgets_who_does_not_answer_any_more() {
        let mut gap = Gap::new(2, 126, 1);
        gap.note(8, Some(StationType::Slave));
        gap.note(3, Some(StationType::MasterNotReady));
        gap.note(200, Some(StationType::Slave));
        assert_eq!(gap.live().collect::<Vec<_>>(), [(3, StationType::MasterNotReady), (8, StationType::Slave)]);
        gap.note(3, None);
        assert_eq!(gap.live().collect::<Vec<_>>(), [(8, StationType::Slave)]);
    }
}
