//! LAS, the list of active stations: the masters in the ring, learnt from the tokens. profibus-wire 1.13.
//!
//! A token proves that its sender is in the ring, and that no address between sender and receiver is. The receiver proves its
//! presence when it passes the token on. A token has no checksum, so an address that no master can have is noise, and the next
//! rotation corrects the effect of a damaged token.

/// The highest address a master can have.
const MAX_MASTER: u8 = 125;

/// The progress of learning the list.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Progress {
    /// No rotation has begun since this station began to listen.
    Waiting,
    /// The first whole rotation is in progress.
    First,
    /// Another rotation is in progress, and has to equal the one before.
    Second,
    /// Two rotations were equal, or this station made the ring itself. From now on the list follows every token.
    Complete,
}

/// The list, as seen by one station.
#[derive(Clone, Debug)]
pub(super) struct Las {
    own: u8,
    progress: Progress,
    /// One bit for each other station of the ring.
    others: u128,
    /// The same for the rotation in progress.
    rotation: u128,
    /// The last token: a repeated one begins no new rotation.
    last: (u8, u8),
}

impl Las {
    /// A station that has received no token yet.
    pub(super) const fn new(own: u8) -> Self {
        Self { own, progress: Progress::Waiting, others: 0, rotation: 0, last: (own, own) }
    }

    /// A station that makes a new ring.
    pub(super) const fn alone(own: u8) -> Self {
        Self { progress: Progress::Complete, ..Self::new(own) }
    }

    /// Whether the list is complete.
    pub(super) const fn is_complete(&self) -> bool {
        matches!(self.progress, Progress::Complete)
    }

    /// Station `sa` has sent a token to `da`.
    pub(super) fn observe_token(&mut self, da: u8, sa: u8) {
        let repeated = (da, sa) == self.last && da != sa;
        self.last = (da, sa);
        match self.progress {
            Progress::Complete => self.follow(da, sa),
            Progress::Waiting | Progress::First | Progress::Second if repeated => {}
            Progress::Waiting | Progress::First | Progress::Second => self.learn(da, sa),
        }
    }

    /// Follows a token with a complete list: `sa` is in the ring, and no address between it and `da`.
    fn follow(&mut self, da: u8, sa: u8) {
        self.others &= !between(sa, da);
        self.insert(sa);
    }

    /// Learns from a token. A rotation ends where the token goes to a lower address, or to its sender.
    fn learn(&mut self, da: u8, sa: u8) {
        self.rotation |= bit(sa);
        if da > sa {
            return;
        }
        let heard = core::mem::take(&mut self.rotation);
        self.progress = match self.progress {
            Progress::Waiting => Progress::First,
            Progress::Second if heard == self.others => Progress::Complete,
            Progress::First | Progress::Second | Progress::Complete => {
                self.others = heard & !bit(self.own);
                Progress::Second
            }
        };
    }

    /// `address` is in the ring from now on.
    pub(super) const fn insert(&mut self, address: u8) {
        self.others |= bit(address) & !bit(self.own);
    }

    /// `address` did not take the token.
    pub(super) const fn remove(&mut self, address: u8) {
        self.others &= !bit(address);
    }

    /// NS, the successor: this station itself if it is alone.
    pub(super) const fn next(&self) -> u8 {
        let above = self.others & !up_to(self.own);
        let candidates = if above != 0 { above } else { self.others };
        if candidates == 0 { self.own } else { candidates.trailing_zeros() as u8 }
    }

    /// PS, the predecessor: this station itself if it is alone.
    pub(super) const fn previous(&self) -> u8 {
        let below = self.others & up_to(self.own);
        let candidates = if below != 0 { below } else { self.others };
        if candidates == 0 { self.own } else { 127_u32.saturating_sub(candidates.leading_zeros()) as u8 }
    }

    /// Whether the token may come from `sa`: it is PS, or a newcomer to which PS has just passed the token.
    pub(super) fn is_predecessor(&self, sa: u8) -> bool {
        let previous = self.previous();
        sa == previous || self.last == (sa, previous)
    }

    /// The other masters in the ring, in the order of their addresses.
    pub(super) fn others(&self) -> impl Iterator<Item = u8> + use<> {
        let others = self.others;
        (0..=MAX_MASTER).filter(move |address| others & bit(*address) != 0)
    }
}

/// Whether a token from `sa` to `da` skips `address`.
pub(super) const fn passes(address: u8, da: u8, sa: u8) -> bool {
    address != sa && between(sa, da) & bit(address) != 0
}

/// Whether masters can have these addresses.
pub(super) const fn is_token(da: u8, sa: u8) -> bool {
    da <= MAX_MASTER && sa <= MAX_MASTER
}

const fn bit(address: u8) -> u128 {
    if address <= MAX_MASTER { 1 << address } else { 0 }
}

/// The bits from 0 to `address`.
const fn up_to(address: u8) -> u128 {
    if address >= 127 { u128::MAX } else { (1_u128 << address.saturating_add(1)).wrapping_sub(1) }
}

/// The addresses after `sa` and before `da`, around the highest address if necessary: all others if both are equal.
const fn between(sa: u8, da: u8) -> u128 {
    let after_sa = !up_to(sa);
    let before_da = up_to(da) & !bit(da);
    if sa < da { after_sa & before_da } else { after_sa | before_da }
}

#[cfg(test)]
mod tests {
    extern crate std;
    use super::*;
    use std::vec::Vec;

    /// A list after `tokens`, each from the first address to the second.
    fn after_tokens(own: u8, tokens: &[(u8, u8)]) -> Las {
        let mut las = Las::new(own);
        tokens.iter().for_each(|(sa, da)| las.observe_token(*da, *sa));
        las
    }

    fn others(las: &Las) -> Vec<u8> {
        las.others().collect()
    }

    /// `times` rotations of a ring of 3, 9 and 15.
    fn rotations(times: usize) -> Vec<(u8, u8)> {
        [(3, 9), (9, 15), (15, 3)].repeat(times)
    }

    #[test]
    fn two_equal_rotations_complete_the_list() {
        // Half a rotation, which does not count, and two whole ones.
        let all = [&rotations(1)[1..], &rotations(2)].concat();
        for length in 0..all.len() {
            assert!(!after_tokens(7, &all[..length]).is_complete(), "{length} tokens");
        }
        let las = after_tokens(7, &all);
        assert!(las.is_complete());
        assert_eq!((others(&las), las.previous(), las.next()), (std::vec![3, 9, 15], 3, 9));
    }

    #[test]
    fn after_different_rotations_the_station_listens_to_another() {
        let tokens = [rotations(2), std::vec![(3, 9), (9, 12), (12, 15), (15, 3)]].concat();
        let mut las = after_tokens(7, &tokens);
        assert!(!las.is_complete());
        [(3, 9), (9, 12), (12, 15), (15, 3)].iter().for_each(|(sa, da)| las.observe_token(*da, *sa));
        assert_eq!((las.is_complete(), others(&las)), (true, std::vec![3, 9, 12, 15]));
    }

    #[test]
    fn a_repeated_token_is_no_rotation() {
        let las = after_tokens(7, &[(15, 3), (3, 15), (15, 3), (15, 3), (15, 3)]);
        assert!(!las.is_complete());
        // A master that is alone sends the same token repeatedly, and each is a rotation.
        assert!(after_tokens(7, &[(3, 3), (3, 3), (3, 3)]).is_complete());
    }

    #[test]
    fn the_list_follows_masters_that_enter_and_leave() {
        let mut las = after_tokens(7, &rotations(3));
        las.observe_token(15, 3);
        assert_eq!((others(&las), las.next()), (std::vec![3, 15], 15), "9 was left out");
        las.observe_token(15, 12);
        assert_eq!((others(&las), las.next()), (std::vec![3, 12, 15], 12), "12 has the token, so it is in the ring");
        las.observe_token(9, 3);
        assert_eq!(others(&las), [3, 12, 15], "whether 9 takes the token is not known yet");
        las.remove(3);
        assert_eq!((las.previous(), las.next()), (15, 12));
    }

    #[test]
    fn the_token_comes_from_the_predecessor_or_from_a_master_it_has_let_in() {
        let mut las = after_tokens(7, &rotations(3));
        assert!(las.is_predecessor(3) && !las.is_predecessor(5));
        las.observe_token(5, 3);
        assert!(las.is_predecessor(5));
        las.observe_token(7, 5);
        assert!(las.is_predecessor(5) && !las.is_predecessor(9));
    }

    #[test]
    fn previous_and_next_go_around_the_end() {
        for (own, masters, previous, next) in [
            (2, &[][..], 2, 2),
            (2, &[5], 5, 5),
            (2, &[5, 9], 9, 5),
            (9, &[2, 5], 5, 2),
            (0, &[125], 125, 125),
            (125, &[0, 124], 124, 0),
        ] {
            let mut las = Las::alone(own);
            masters.iter().for_each(|address| las.insert(*address));
            assert_eq!((las.previous(), las.next()), (previous, next), "{own} among {masters:?}");
        }
    }

    #[test]
    fn a_token_goes_past_those_between_its_ends() {
        for (address, sa, da, past) in [
            (5, 2, 9, true),
            (5, 9, 2, false),
            (1, 9, 2, true),
            (10, 9, 2, true),
            (2, 9, 2, false),
            (9, 9, 2, false),
            (5, 2, 2, true),
            (2, 2, 2, false),
            (0, 125, 1, true),
        ] {
            assert_eq!(passes(address, da, sa), past, "{sa} to {da} past {address}");
        }
    }

    #[test]
    fn no_address_is_too_high_for_the_list() {
        for progress in [Progress::Waiting, Progress::Complete] {
            for sa in 0..=u8::MAX {
                for da in 0..=u8::MAX {
                    let mut las = Las { progress, ..Las::new(7) };
                    las.observe_token(da, sa);
                    las.insert(da);
                    assert!(las.next() <= MAX_MASTER && las.previous() <= MAX_MASTER);
                    assert!(las.others().all(|address| address != 7));
                }
            }
        }
        assert!(is_token(125, 0) && !is_token(126, 0) && !is_token(0, 127) && !is_token(200, 200));
    }
}
