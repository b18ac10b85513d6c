//! The hub transmits octets, disturbs them by its seed, and ends on command.

#![allow(clippy::unwrap_used, clippy::panic, reason = "a test")]

use crate::common::{End, Folder, Program, become_an_ordinary_user};

const TEXT: &str = "00 11 22 33 44 55 66 77 88 99 AA BB CC DD EE FF";

fn hub(folder: &Folder, arguments: &[&str]) -> (Program, End, End) {
    let (a, b) = (folder.name("a"), folder.name("b"));
    let hub = Program::start(&[&["hub", "--pty", &a, "--pty", &b], arguments].concat());
    assert_eq!(hub.ready(), [a, b].join(" "));
    (hub, End::pty(&folder.path("a")), End::pty(&folder.path("b")))
}

/// The first half of the octets that arrive when a text is sent 64 times.
fn disturbed(arguments: &[&str]) -> Vec<u8> {
    let folder = Folder::new();
    let (_hub, mut a, mut b) = hub(&folder, arguments);
    let mut received = Vec::new();
    for _ in 0..64 {
        a.send(TEXT);
    }
    while received.len() < 512 {
        let more = b.receive();
        assert!(!more.is_empty(), "only {} octets received", received.len());
        received.extend(more);
    }
    received.truncate(512);
    received
}

#[test]
fn octets_pass_both_ways() {
    let folder = Folder::new();
    let (_hub, mut a, mut b) = hub(&folder, &[]);
    a.send(TEXT);
    b.expect(TEXT);
    b.send(TEXT);
    a.expect(TEXT);
}

#[test]
fn the_lock_of_a_killed_master_does_not_end_the_hub() {
    become_an_ordinary_user();
    let folder = Folder::new();
    let (mut hub, mut a, mut b) = hub(&folder, &[]);
    for _ in 0..3 {
        a.lock();
        a.send(TEXT);
        b.expect(TEXT);
        drop(a);
        a = End::pty_of(&mut hub, &folder.path("a"));
        b.send(TEXT);
        a.expect(TEXT);
    }
}

#[test]
fn paced_octets_arrive_in_order() {
    let folder = Folder::new();
    let (_hub, mut a, mut b) = hub(&folder, &["--pace", "93750"]);
    a.send(TEXT);
    b.expect(TEXT);
}

#[test]
fn the_seed_determines_the_disturbances() {
    let first = disturbed(&["--flip", "0.05", "--drop", "0.05", "--seed", "7"]);
    assert_eq!(first, disturbed(&["--flip", "0.05", "--drop", "0.05", "--seed", "7"]));
    assert_ne!(first, disturbed(&["--flip", "0.05", "--drop", "0.05", "--seed", "8"]));
}

#[test]
fn commands_are_answered_and_quit_removes_the_ptys() {
    let folder = Folder::new();
    let (mut hub, ..) = hub(&folder, &[]);
    let a = folder.name("a");
    assert_eq!(
        hub.tell(&format!("mute {a} soon")),
        "error: expected a number of seconds, or a time like '10 min' or 2d, got \"soon\""
    );
    let unknown = hub.tell("mute c 1");
    assert_eq!(unknown, format!("error: no pty c; known: {a}, {}", folder.name("b")));
    assert_eq!(hub.tell("sing"), "error: expected mute PATH SECONDS or quit, got \"sing\"");
    assert_eq!(hub.tell("quit"), "ok");
    assert_eq!(hub.exit_code(), 0);
    assert!(!folder.path("a").is_symlink() && !folder.path("b").is_symlink());
}
