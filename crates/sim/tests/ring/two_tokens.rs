//! More than one token: rings that merge, a token out of nowhere, two masters with one address.

use crate::common::Plain;
use crate::line::{BAUD, Bounds, Line, Master, master, slave_of};
use profivac_dp::link::active::RingState;
use profivac_dp::link::{BitTime, Station, Transmit};
use profivac_dp::slave::Slave;
use profivac_sim::Fault;
use profivac_sim::stations::Tester;
use profivac_wire::Telegram;

/// Two rings on the two sides of a cut, and the cable is mended at every so many bit times of their rotations.
#[test]
fn two_rings_that_merge_are_one_in_time() {
    for (left, right) in [(&[2][..], &[5][..]), (&[2, 5], &[9]), (&[2, 5], &[3, 9]), (&[2, 9], &[5, 7])] {
        for after in (0..2_000).step_by(23) {
            let places: Vec<(u8, u64)> =
                left.iter().map(|address| (*address, 0)).chain(right.iter().map(|address| (*address, 4))).collect();
            let mut line = Line::along(&places);
            line.bus.inject(Fault::Cut(Some(2)));
            for side in [left, right] {
                line.until_known(side);
            }
            line.bus.run_for(after).unwrap();
            line.bus.inject(Fault::Cut(None));
            let all: Vec<u8> = [left, right].concat();
            line.in_confusion(Bounds::of(&all).begin(all.len()));
            line.stays_whole(&all).unwrap_or_else(|foul| panic!("{left:?} and {right:?} after {after}: {foul}"));
        }
    }
}

/// Two masters that claim the line at the same bit time speak in step from then on: neither hears the other, and no slave
/// understands either. Their addresses part them.
#[test]
fn two_masters_in_step_find_each_other() {
    for (one, other) in [(7, 13), (0, 15), (2, 3), (8, 9), (4, 12)] {
        let mut line = Line::new(&[]);
        // T_TO is 2 x 300 longer for each address: the lower one begins to listen so much later.
        for (address, begins) in [(one, u64::from(other - one) * 600), (other, 0)] {
            line.bus.attach(Slave::<_>::new(Plain::new(), slave_of(address), BAUD));
            let master = line.bus.attach(master(address, BitTime(begins)));
            line.masters.push((address, master));
        }
        line.bus.set_trace_length(usize::MAX);
        line.in_confusion(20_000);
        let starts: Vec<_> = line.bus.trace().entries.iter().map(|entry| entry.start).collect();
        assert!(starts.windows(2).any(|pair| pair[0] == pair[1]), "{one} and {other} were never in step");
        line.in_confusion(Bounds::of(&[one, other]).begin(2));
        line.stays_whole(&[one, other]).unwrap_or_else(|foul| panic!("{one} and {other}: {foul}"));
    }
}

/// A token that none of the ring has sent, at every so many bit times: from a member, to a member, from and to nobody.
#[test]
fn a_token_out_of_nowhere_does_not_stay() {
    for token in [[0xDC, 5, 2], [0xDC, 9, 2], [0xDC, 2, 9], [0xDC, 5, 7], [0xDC, 7, 9], [0xDC, 2, 2], [0xDC, 200, 130]]
    {
        for after in (0..2_000).step_by(29) {
            let mut line = Line::soon_whole(&[2, 5, 9]);
            let ghost = line.bus.attach(Tester::new());
            line.bus.exempt(ghost.id());
            let at = line.bus.now() + after;
            line.bus.station_mut(ghost).send(at, &token);
            line.in_confusion(after + Bounds::of(&[2, 5, 9]).begin(3));
            line.stays_whole(&[2, 5, 9]).unwrap_or_else(|foul| panic!("{token:02X?} after {after}: {foul}"));
        }
    }
}

#[test]
fn a_second_master_with_an_address_of_the_ring_keeps_silent_until_the_first_is_gone() {
    let mut line = Line::whole(&[2, 5, 9]);
    let now = line.bus.now();
    let twin = line.bus.attach(master(5, now));
    line.bus.run_for(100_000).unwrap();
    line.stays_whole(&[2, 5, 9]).unwrap();
    let silent = line.bus.station(twin);
    assert_eq!((silent.ring_state(), silent.user.answered + silent.user.failed), (RingState::AddressTaken, 0));
    assert!(silent.ring_counters().own_address >= 2);
    assert_eq!(line.master(5).ring_counters().own_address, 0, "it was never heard");
    // The first goes; the second takes its place.
    line.switch_off(5);
    line.bus.run_for(Bounds::of(&[2, 5, 9]).token_lost(1) + Bounds::of(&[2, 5, 9]).join()).unwrap();
    line.masters[1].1 = twin;
    line.stays_whole(&[2, 5, 9]).unwrap();
}

#[test]
fn a_second_master_keeps_silent_beside_one_that_is_alone() {
    let mut line = Line::whole(&[2]);
    let now = line.bus.now();
    let twin = line.bus.attach(master(2, now));
    line.bus.run_for(100_000).unwrap();
    line.stays_whole(&[2]).unwrap();
    assert_eq!(line.bus.station(twin).ring_state(), RingState::AddressTaken);
    line.switch_off(2);
    line.bus.run_for(Bounds::of(&[2]).token_lost(0) * 2).unwrap();
    line.masters[0].1 = twin;
    line.stays_whole(&[2]).unwrap();
}

/// Two masters with one address that meet when a cable is mended: one of them withdraws, and the rest is a ring.
#[test]
fn two_masters_with_one_address_that_meet_do_not_babble() {
    for after in (0..1_500).step_by(37) {
        let mut line = Line::along(&[(2, 0), (5, 0)]);
        let twin = line.bus.attach_at(4, master(5, BitTime(0)));
        line.bus.inject(Fault::Cut(Some(2)));
        line.bus.run_for(60_000 + after).unwrap();
        assert_eq!(line.bus.station(twin).ring_state(), RingState::InRing);
        line.bus.inject(Fault::Cut(None));
        line.in_confusion(Bounds::of(&[2, 5]).begin(3));
        if line.master(5).ring_state() != RingState::InRing {
            line.masters[1].1 = twin;
        }
        line.stays_whole(&[2, 5]).unwrap_or_else(|foul| panic!("{after}: {foul}"));
    }
}

/// A master behind an adapter that gives back what it sends: before the news that it has left, or after.
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
fn an_adapter_that_echoes_is_no_second_master() {
    for early in [false, true] {
        let mut line = Line::whole(&[2, 9]);
        let now = line.bus.now();
        line.bus.attach(Slave::<_>::new(Plain::new(), slave_of(5), BAUD));
        let echoing = line.bus.attach(Echoing { master: master(5, now), early, sent: Vec::new() });
        line.bus.run_for(Bounds::of(&[2, 5, 9]).join()).unwrap();
        line.bus.expect_ring(&[2, 5, 9], line.bus.now());
        line.bus.run_for(50_000).unwrap();
        let master = &line.bus.station(echoing).master;
        assert_eq!((master.ring_state(), master.ring_counters().own_address), (RingState::InRing, 0));
        assert!(master.user.answered > 20 && master.user.failed == 0);
        // A successor that goes is noticed although the token comes back.
        line.switch_off(9);
        line.bus.expect_ring(&[2, 5], line.bus.now() + Bounds::of(&[2, 5]).token_lost(1));
        line.bus.run_for(50_000).unwrap();
        assert_eq!(line.bus.station(echoing).master.masters().collect::<Vec<_>>(), [2, 5]);
    }
}
