//! The ring under every sequence of faults at consecutive telegrams, to a depth, with the real stations: afterwards it is complete
//! again within a bound. `PROFIVAC_RING_DEPTH` is the depth of a longer search.
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic, clippy::indexing_slicing, reason = "a test")]

mod line;

use line::{Fate, Line};
use std::collections::BTreeMap;

/// Longer than the time after which a token is missed.
const SILENCE_TBIT: u64 = 20_000;

/// The time within which the ring is complete after the last fault, which includes a master that is without power for 2,500 bit
/// times: 17 ms. The parts are the time after which the token is missed, the time in which a master learns the ring, and the search of
/// the GAP for the masters that are not in it. At a depth of 4 the longest recovery of two masters took 15,289, of three 19,083.
const BOUND_TBIT: u64 = 25_000;

/// The time for which a ring is watched after the bound.
const WATCHED_TBIT: u64 = 5_000;

/// What a search has found.
#[derive(Default)]
struct Found {
    sequences: u64,
    failures: Vec<String>,
    /// The longest time until a ring was complete, and the faults before it.
    longest: (u64, Vec<Fate>),
    /// The number of times of each kind of fault.
    kinds: BTreeMap<&'static str, u64>,
}

const fn kind(fate: Fate) -> &'static str {
    match fate {
        Fate::Received => "received",
        Fate::Lost => "lost",
        Fate::LostBy(_) => "lost by one",
        Fate::Damaged => "damaged",
        Fate::TokenTo(_) => "token with a wrong address",
        Fate::Late(_) => "late",
        Fate::PowerOff(_) => "without power",
    }
}

/// Tries every fault of the telegram that has just begun, and of the `depth` telegrams from it on.
fn explore(line: &Line, depth: usize, path: &mut Vec<Fate>, found: &mut Found) {
    for fate in line.fates() {
        *found.kinds.entry(kind(fate)).or_default() += 1;
        path.push(fate);
        let mut next = line.clone();
        next.apply(fate);
        let silence = next.now() + SILENCE_TBIT;
        if depth > 1 && next.run_to_telegram(silence) {
            explore(&next, depth - 1, path, found);
        } else {
            found.sequences += 1;
            let tbit = next.run_for(BOUND_TBIT);
            if tbit > found.longest.0 {
                found.longest = (tbit, path.clone());
            }
            if let Some(fault) = next.fault_of_ring(WATCHED_TBIT) {
                found.failures.push(format!("{path:?}: {fault}"));
            }
        }
        path.pop();
    }
}

/// The depth of a search: `usual` unless the environment has another.
fn depth(usual: usize) -> usize {
    std::env::var("PROFIVAC_RING_DEPTH").ok().map_or(usual, |text| text.parse().expect("a number"))
}

/// A complete ring at the beginning of a telegram.
fn complete(addresses: &[u8]) -> Line {
    let mut line = Line::new(addresses);
    line.run_for(BOUND_TBIT);
    assert_eq!(line.fault_of_ring(WATCHED_TBIT), None, "the ring of {addresses:?} at the start");
    assert!(line.run_to_telegram(line.now() + SILENCE_TBIT));
    line
}

/// Searches from a complete ring.
fn search(addresses: &[u8], depth: usize) -> Found {
    let mut found = Found::default();
    let mut line = complete(addresses);
    // The first fault at each telegram of a rotation: tokens, requests, answers.
    for _ in 0..3 * addresses.len() {
        explore(&line, depth, &mut Vec::new(), &mut found);
        assert!(line.run_to_telegram(line.now() + SILENCE_TBIT));
    }
    println!("{addresses:?}: {} sequences of {depth} faults, {:?}", found.sequences, found.kinds);
    println!("the longest recovery took {:?} bit times, the bound is {BOUND_TBIT}", found.longest);
    found
}

fn assert_recovers(addresses: &[u8], depth: usize) {
    let found = search(addresses, depth);
    let shown: Vec<_> = found.failures.iter().take(10).collect();
    assert!(shown.is_empty(), "{} of {} sequences: {shown:#?}", found.failures.len(), found.sequences);
    assert!(found.kinds.values().all(|number| *number > 0) && found.kinds.len() >= 6, "{:?}", found.kinds);
}

#[test]
fn two_masters_form_a_ring_again_after_every_sequence_of_faults() {
    assert_recovers(&[2, 5], depth(3));
}

#[test]
fn three_masters_form_a_ring_again_after_every_sequence_of_faults() {
    assert_recovers(&[1, 3, 6], depth(2));
}

#[test]
fn masters_form_a_ring_after_every_sequence_of_faults_at_their_start() {
    for addresses in [&[2, 5][..], &[1, 3, 6]] {
        let mut line = Line::new(addresses);
        assert!(line.run_to_telegram(line.now() + SILENCE_TBIT));
        let mut found = Found::default();
        explore(&line, depth(2), &mut Vec::new(), &mut found);
        let shown: Vec<_> = found.failures.iter().take(10).collect();
        assert!(shown.is_empty(), "{addresses:?}, {} of {}: {shown:#?}", found.failures.len(), found.sequences);
    }
}
