//! Password checks on many threads reuse memory. The test has a process of its own, because it reads the memory of the process.

#![allow(clippy::unwrap_used, reason = "a test")]

use profivac_web_server::auth::password::Hash;
use std::fs;
use std::sync::{Barrier, Mutex};

/// The resident memory of the process, in KiB.
fn resident() -> u64 {
    let status = fs::read_to_string("/proc/self/status").unwrap();
    let line = status.lines().find_map(|line| line.strip_prefix("VmRSS:")).unwrap();
    line.split_whitespace().next().unwrap().parse().unwrap()
}

#[test]
fn password_checks_on_many_threads_use_the_memory_of_one() {
    const THREADS: usize = 24;
    let hash = Hash::of("tin whisker plateau").unwrap();
    let (turn, all) = (Mutex::new(()), Barrier::new(THREADS));
    let before = resident();
    let after = std::thread::scope(|scope| {
        let guesses = || {
            all.wait();
            for _ in 0..3 {
                let _turn = turn.lock().unwrap();
                assert!(!hash.matches("tin whisker"));
            }
            // All threads still exist when the memory is read.
            all.wait();
            let now = resident();
            all.wait();
            now
        };
        let threads: Vec<_> = (0..THREADS).map(|_| scope.spawn(guesses)).collect();
        threads.into_iter().map(|thread| thread.join().unwrap()).max().unwrap()
    });
    let grown = after.saturating_sub(before) >> 10;
    assert!(grown < 100, "the process has grown by {grown} MiB");
}
