//! Masters that join, leave and return in the regular way.

use super::line::{BAUD, Bounds, HSA, Line};
use crate::common::Plain;
use profivac_dp::link::active::RingState;
use profivac_dp::slave::Slave;
use profivac_wire::control::StationType;

#[test]
fn one_two_three_and_five_masters_make_a_ring() {
    for addresses in [&[2][..], &[2, 3], &[0, 15], &[9, 2, 5], &[1, 4, 7, 10, 13], &[11, 12, 13, 14, 15]] {
        let mut line = Line::complete(addresses);
        line.segment.run_for(200_000).unwrap();
        line.stays_complete(addresses).unwrap();
        for (_, master) in &line.masters {
            assert_eq!(line.segment.station(*master).user.failed, 0, "{addresses:?}");
        }
    }
}

#[test]
fn a_new_master_joins_at_any_address() {
    for newcomer in [0, 1, 3, 7, 12, HSA] {
        let mut line = Line::complete(&[2, 5, 9]);
        line.add(newcomer);
        let all = [2, 5, 9, newcomer];
        line.becomes_complete(&all, Bounds::of(&all).join()).unwrap();
        for (address, _) in &line.masters {
            let counters = line.master(*address).ring_counters();
            // No master needed a repeated token, not even from the new one.
            assert_eq!((counters.repeated, counters.left_out, counters.given_up), (0, 0, 0), "{newcomer} at {address}");
        }
    }
}

#[test]
fn a_new_master_reports_its_state_before_it_joins() {
    let mut line = Line::complete(&[2, 9]);
    line.add(5);
    let mut seen = Vec::new();
    while seen.last() != Some(&RingState::InRing) {
        let state = line.master(5).ring_state();
        if seen.last() != Some(&state) {
            seen.push(state);
        }
        line.segment.run_for(10).unwrap();
    }
    assert_eq!(seen, [RingState::Listening, RingState::Ready, RingState::InRing]);
}

#[test]
fn a_master_that_leaves_passes_the_token_and_is_silent() {
    let length = 2000;
    for after in (0..length).step_by(7) {
        let mut line = Line::just_complete(&[2, 5, 9]);
        line.segment.run_for(after).unwrap();
        let leaver = line.handle(5);
        line.segment.station_mut(leaver).leave();
        line.becomes_complete(&[2, 9], Bounds::of(&[2, 9]).token_lost(1)).unwrap();
        let master = line.master(5);
        assert_eq!((master.ring_state(), master.user.failed), (RingState::Offline, 0), "after {after}");
        assert_eq!(master.masters().collect::<Vec<_>>(), [2, 9]);
        // The token was not lost, so no master claimed it.
        for address in [5, 9] {
            assert_eq!(line.master(address).ring_counters().claimed, 0, "{address}, after {after}");
        }
        assert_eq!(line.master(2).ring_counters().claimed, 1, "the first claim, after {after}");
    }
}

#[test]
fn the_line_is_silent_after_the_last_master_leaves_until_it_returns() {
    let mut line = Line::complete(&[2]);
    let only = line.handle(2);
    line.segment.station_mut(only).leave();
    line.segment.run_for(5_000).unwrap();
    let last = line.segment.trace().entries.back().unwrap().end();
    line.segment.run_for(100_000).unwrap();
    assert_eq!(line.segment.trace().entries.back().unwrap().end(), last);
    let now = line.segment.now();
    line.segment.station_mut(only).listen(now);
    line.becomes_complete(&[2], Bounds::of(&[2]).begin(1)).unwrap();
}

#[test]
fn the_other_masters_stay_in_the_ring_when_masters_leave_and_return() {
    let mut line = Line::complete(&[1, 4, 7, 10, 13]);
    for gone in [&[4][..], &[1], &[13], &[4, 7], &[1, 13]] {
        let rest: Vec<u8> = [1, 4, 7, 10, 13].into_iter().filter(|address| !gone.contains(address)).collect();
        for address in gone {
            line.switch_off(*address);
        }
        line.becomes_complete(&rest, Bounds::of(&rest).token_lost(gone.len() as u64)).unwrap();
        for address in gone {
            line.switch_on(*address);
        }
        let all = [1, 4, 7, 10, 13];
        line.becomes_complete(&all, gone.len() as u64 * Bounds::of(&all).join()).unwrap();
    }
}

#[test]
fn slaves_between_the_masters_are_found_and_disturb_no_master() {
    let mut line = Line::complete(&[2, 9]);
    for address in [3, 4, 12] {
        line.segment.attach(Slave::<_>::new(Plain::new(), address, BAUD));
    }
    line.segment.run_for(Bounds::of(&[2, 9]).join()).unwrap();
    line.stays_complete(&[2, 9]).unwrap();
    let slaves = |master| {
        let live = line.master(master).live_list().filter(|(_, kind)| *kind == StationType::Slave);
        live.map(|(address, _)| address).collect::<Vec<_>>()
    };
    // The GAP of 2 ends before 9, that of 9 begins after it.
    assert_eq!((slaves(2), slaves(9)), (vec![3, 4], vec![12]));
    assert_eq!((line.master(2).user.failed, line.master(9).user.failed), (0, 0));
}

#[test]
fn a_master_above_hsa_joins_when_hsa_is_raised() {
    let mut line = Line::complete(&[2, 5]);
    line.add(HSA + 3);
    line.segment.run_for(Bounds::of(&[2, 5]).join()).unwrap();
    assert_eq!(line.master(HSA + 3).ring_state(), RingState::Ready);
    line.stays_complete(&[2, 5]).unwrap();
    for address in [2, 5] {
        let master = line.handle(address);
        line.segment.station_mut(master).set_hsa(HSA + 5).unwrap();
    }
    let all = [2, 5, HSA + 3];
    // Five more addresses to poll.
    line.becomes_complete(&all, 2 * Bounds::of(&all).join()).unwrap();
    // Lowering HSA again removes no master from the ring.
    for address in [2, 5] {
        let master = line.handle(address);
        line.segment.station_mut(master).set_hsa(HSA).unwrap();
    }
    line.segment.run_for(Bounds::of(&all).join()).unwrap();
    line.stays_complete(&all).unwrap();
}
