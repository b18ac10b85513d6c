//! More than one token: rings that merge, spurious tokens, two masters with one address.

use super::line::{BAUD, Bounds, Line, Master, master, slave_of};
use crate::common::Plain;
use profivac_dp::link::active::RingState;
use profivac_dp::link::{BitTime, Station, Transmit};
use profivac_dp::slave::Slave;
use profivac_sim::Fault;
use profivac_sim::stations::Tester;
use profivac_wire::Telegram;

/// Two rings on the two sides of a cut; the cable is repaired at many different times of their rotations.
#[test]
fn two_rings_that_merge_become_one_in_time() {
    for (left, right) in [(&[2][..], &[5][..]), (&[2, 5], &[9]), (&[2, 5], &[3, 9]), (&[2, 9], &[5, 7])] {
        for after in (0..2_000).step_by(23) {
            let places: Vec<(u8, u64)> =
                left.iter().map(|address| (*address, 0)).chain(right.iter().map(|address| (*address, 4))).collect();
            let mut line = Line::along(&places);
            line.segment.inject(Fault::Cut(Some(2)));
            for side in [left, right] {
                line.until_known(side);
            }
            line.segment.run_for(after).unwrap();
            line.segment.inject(Fault::Cut(None));
            let all: Vec<u8> = [left, right].concat();
            line.without_token_rules(Bounds::of(&all).begin(all.len()));
            line.stays_complete(&all)
                .unwrap_or_else(|violation| panic!("{left:?} and {right:?} after {after}: {violation}"));
        }
    }
}

/// Two masters that claim the token at the same bit time send synchronously from then on: neither receives the other, and no
/// slave receives either. Their different addresses separate them.
#[test]
fn two_synchronous_masters_find_each_other() {
    for (one, other) in [(7, 13), (0, 15), (2, 3), (8, 9), (4, 12)] {
        let mut line = Line::new(&[]);
        // T_TO is 2 x 300 longer for each address: the lower address begins to listen later by this time.
        for (address, begins) in [(one, u64::from(other - one) * 600), (other, 0)] {
            line.segment.attach(Slave::<_>::new(Plain::new(), slave_of(address), BAUD));
            let master = line.segment.attach(master(address, BitTime(begins)));
            line.masters.push((address, master));
        }
        line.segment.set_trace_length(usize::MAX);
        line.without_token_rules(20_000);
        let starts: Vec<_> = line.segment.trace().entries.iter().map(|entry| entry.start).collect();
        assert!(starts.windows(2).any(|pair| pair[0] == pair[1]), "{one} and {other} were never synchronous");
        line.without_token_rules(Bounds::of(&[one, other]).begin(2));
        line.stays_complete(&[one, other]).unwrap_or_else(|violation| panic!("{one} and {other}: {violation}"));
    }
}

/// A spurious token at many different times: from a master of the ring, to a master of the ring, from and to unused addresses.
#[test]
fn a_spurious_token_disappears() {
    for token in [[0xDC, 5, 2], [0xDC, 9, 2], [0xDC, 2, 9], [0xDC, 5, 7], [0xDC, 7, 9], [0xDC, 2, 2], [0xDC, 200, 130]]
    {
        for after in (0..2_000).step_by(29) {
            let mut line = Line::just_complete(&[2, 5, 9]);
            let tester = line.segment.attach(Tester::new());
            line.segment.exempt(tester.id());
            let at = line.segment.now() + after;
            line.segment.station_mut(tester).send(at, &token);
            line.without_token_rules(after + Bounds::of(&[2, 5, 9]).begin(3));
            line.stays_complete(&[2, 5, 9])
                .unwrap_or_else(|violation| panic!("{token:02X?} after {after}: {violation}"));
        }
    }
}

#[test]
fn a_second_master_with_an_address_of_the_ring_is_silent_until_the_first_leaves() {
    let mut line = Line::complete(&[2, 5, 9]);
    let now = line.segment.now();
    let duplicate = line.segment.attach(master(5, now));
    line.segment.run_for(100_000).unwrap();
    line.stays_complete(&[2, 5, 9]).unwrap();
    let silent = line.segment.station(duplicate);
    assert_eq!((silent.ring_state(), silent.user.answered + silent.user.failed), (RingState::AddressTaken, 0));
    assert!(silent.ring_counters().own_address >= 2);
    assert_eq!(line.master(5).ring_counters().own_address, 0, "its own address was never received");
    // The first leaves; the second replaces it.
    line.switch_off(5);
    line.segment.run_for(Bounds::of(&[2, 5, 9]).token_lost(1) + Bounds::of(&[2, 5, 9]).join()).unwrap();
    line.masters[1].1 = duplicate;
    line.stays_complete(&[2, 5, 9]).unwrap();
}

#[test]
fn a_second_master_is_silent_beside_a_single_one() {
    let mut line = Line::complete(&[2]);
    let now = line.segment.now();
    let duplicate = line.segment.attach(master(2, now));
    line.segment.run_for(100_000).unwrap();
    line.stays_complete(&[2]).unwrap();
    assert_eq!(line.segment.station(duplicate).ring_state(), RingState::AddressTaken);
    line.switch_off(2);
    line.segment.run_for(Bounds::of(&[2]).token_lost(0) * 2).unwrap();
    line.masters[0].1 = duplicate;
    line.stays_complete(&[2]).unwrap();
}

/// Two masters with one address are connected when a cable is repaired: one leaves the ring, and the others form a ring.
#[test]
fn two_masters_with_one_address_that_meet_do_not_babble() {
    for after in (0..1_500).step_by(37) {
        let mut line = Line::along(&[(2, 0), (5, 0)]);
        let duplicate = line.segment.attach_at(4, master(5, BitTime(0)));
        line.segment.inject(Fault::Cut(Some(2)));
        line.segment.run_for(60_000 + after).unwrap();
        assert_eq!(line.segment.station(duplicate).ring_state(), RingState::InRing);
        line.segment.inject(Fault::Cut(None));
        line.without_token_rules(Bounds::of(&[2, 5]).begin(3));
        if line.master(5).ring_state() != RingState::InRing {
            line.masters[1].1 = duplicate;
        }
        line.stays_complete(&[2, 5]).unwrap_or_else(|violation| panic!("{after}: {violation}"));
    }
}

/// A master behind an adapter that echoes its telegrams: before or after the notification that they were sent.
struct Echoing {
    master: Master,
    early: bool,
    sent: Vec<u8>,
}

impl Echoing {
    fn echo(&mut self, end: BitTime) {
        let Ok(telegram) = Telegram::parse(&self.sent) else { return };
        for _ in 1..self.sent.len() {
            self.master.activity(end);
        }
        assert_eq!(self.master.telegram(end, &telegram), None);
    }
}

impl Station for Echoing {
    fn telegram(&mut self, end: BitTime, telegram: &Telegram<'_>) -> Option<Transmit<'_>> {
        let transmit = self.master.telegram(end, telegram)?;
        self.sent = transmit.octets.to_vec();
        Some(transmit)
    }

    fn activity(&mut self, end: BitTime) {
        self.master.activity(end);
    }

    fn sent(&mut self, end: BitTime) {
        if self.early {
            self.echo(end);
        }
        self.master.sent(end);
        if !self.early {
            self.echo(end + 2);
        }
    }

    fn poll(&mut self, now: BitTime) -> Option<Transmit<'_>> {
        let transmit = self.master.poll(now)?;
        self.sent = transmit.octets.to_vec();
        Some(transmit)
    }

    fn wake_at(&self) -> Option<BitTime> {
        self.master.wake_at()
    }
}

#[test]
fn an_adapter_with_echo_is_not_taken_for_a_second_master() {
    for early in [false, true] {
        let mut line = Line::complete(&[2, 9]);
        let now = line.segment.now();
        line.segment.attach(Slave::<_>::new(Plain::new(), slave_of(5), BAUD));
        let echoing = line.segment.attach(Echoing { master: master(5, now), early, sent: Vec::new() });
        line.segment.run_for(Bounds::of(&[2, 5, 9]).join()).unwrap();
        line.segment.expect_ring(&[2, 5, 9], line.segment.now());
        line.segment.run_for(50_000).unwrap();
        let master = &line.segment.station(echoing).master;
        assert_eq!((master.ring_state(), master.ring_counters().own_address), (RingState::InRing, 0));
        assert!(master.user.answered > 20 && master.user.failed == 0);
        // The loss of a successor is detected although the token is echoed.
        line.switch_off(9);
        line.segment.expect_ring(&[2, 5], line.segment.now() + Bounds::of(&[2, 5]).token_lost(1));
        line.segment.run_for(50_000).unwrap();
        assert_eq!(line.segment.station(echoing).master.masters().collect::<Vec<_>>(), [2, 5]);
    }
}
