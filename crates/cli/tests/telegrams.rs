//! Virtual devices answer telegrams on every port, share one line, and are silent without power.

#![allow(clippy::unwrap_used, clippy::panic, reason = "a test")]

use crate::common::{End, Folder, Program, sd1, sd2};

const FDL_STATUS_5: &str = "10 05 02 49 50 16";
const FDL_STATUS_6: &str = "10 06 02 49 51 16";
const PRESENT_5: &str = "10 02 05 00 07 16";
const PRESENT_6: &str = "10 02 06 00 08 16";

/// Slave_Diag of a BCG450 that no master has parameterised: Prm_Req and Station_Not_Ready, no master, its ident number.
const DIAG_5_AFTER_POWER_UP: &str = "68 0B 0B 68 82 85 08 3E 3C 02 05 00 FF 08 E6 7D 16";

fn on_a_pty(folder: &Folder, arguments: &[&str]) -> (Program, End) {
    let path = folder.name("line");
    let program = Program::start(&[&["simulate", "--pty", &path], arguments].concat());
    assert_eq!(program.ready(), path);
    let end = End::pty(&folder.path("line"));
    (program, end)
}

#[test]
fn a_device_on_a_pty_answers() {
    let folder = Folder::new();
    let (_program, mut line) = on_a_pty(&folder, &["bcg450@5"]);
    line.ask(FDL_STATUS_5, PRESENT_5);
    line.ask(&sd2(5, 60, 0x6D, ""), DIAG_5_AFTER_POWER_UP);
}

/// Set_Prm with mbar (tira41d1 1.5), Chk_Cfg with telegram 5 (tira41d1 2.3), and the pressures read cyclically.
#[test]
fn the_pressure_of_the_simulation_is_exchanged() {
    let folder = Folder::new();
    let (mut program, mut line) = on_a_pty(&folder, &["--pressure", "2e-8 mbar", "bcg450@5"]);
    line.ask(&sd2(5, 61, 0x5D, "80 00 00 0B 08 E6 00 00 00 00 05 1C"), "E5");
    line.ask(&sd2(5, 62, 0x7D, "44 86 05 05 05 08"), "E5");
    let mut fc = 0x7D;
    for (set, mbar) in [
        ("", 2e-8),
        ("pressure 5e-6 mbar", 5e-6),
        ("pressure 1 mTorr", 1.333_223_7e-3),
        ("gas he", 1.333_223_7e-3 / 5.9),
    ] {
        if !set.is_empty() {
            assert_eq!(program.tell(set), "ok");
        }
        fc ^= 0x20;
        let inputs = line.exchange(&sd1(5, fc), 7);
        let value = f64::from(f32::from_be_bytes(inputs[3..].try_into().unwrap()));
        assert!((value / mbar - 1.0).abs() < 1e-6, "{set}: {value} mbar");
    }
    assert_eq!(program.state(5)["device_state"], "EXECUTING");
}

#[test]
fn clients_of_a_tcp_port_share_the_line() {
    let program = Program::start(&["simulate", "--tcp", "127.0.0.1:0", "bcg450@5"]);
    let address = program.ready();
    assert!(address.starts_with("127.0.0.1:") && !address.ends_with(":0"), "{address}");
    let mut master = End::tcp(&address);
    master.ask(FDL_STATUS_5, PRESENT_5);
    let mut listener = End::tcp(&address);
    listener.ask(FDL_STATUS_5, PRESENT_5);
    master.expect(&[FDL_STATUS_5, PRESENT_5].join(" "));
    master.ask(&sd2(5, 60, 0x6D, ""), DIAG_5_AFTER_POWER_UP);
    listener.expect(&[&sd2(5, 60, 0x6D, ""), DIAG_5_AFTER_POWER_UP].join(" "));
}

#[test]
fn devices_at_every_rate_answer_paced_or_not() {
    for baud in ["9600", "93750", "12000000"] {
        for pace in [&["--pace"][..], &[]] {
            let folder = Folder::new();
            let (_program, mut line) = on_a_pty(&folder, &[&["--baud", baud, "bcg450@5"], pace].concat());
            line.ask(FDL_STATUS_5, PRESENT_5);
            line.ask(&sd2(5, 60, 0x6D, ""), DIAG_5_AFTER_POWER_UP);
        }
    }
}

#[test]
fn a_device_survives_damaged_telegrams_and_a_master_that_reopens_the_port() {
    let folder = Folder::new();
    let (_program, mut line) = on_a_pty(&folder, &["bcg450@5"]);
    line.ask(FDL_STATUS_5, PRESENT_5);
    for damaged in ["68 05 04 68 85", "10 05 02 49 51 16", "FF"] {
        line.send(damaged);
        drop(line);
        line = End::pty(&folder.path("line"));
        line.insist(FDL_STATUS_5, PRESENT_5);
    }
}

#[test]
fn devices_share_a_line_and_are_silent_without_power() {
    let folder = Folder::new();
    let (mut program, mut line) = on_a_pty(&folder, &["bcg450@5", "bcg450@6"]);
    line.ask(FDL_STATUS_5, PRESENT_5);
    line.ask(FDL_STATUS_6, PRESENT_6);
    assert_eq!(program.tell("power 5 off"), "ok");
    line.send(FDL_STATUS_5);
    line.ask(FDL_STATUS_6, PRESENT_6);
    assert_eq!(program.tell("power 5 on"), "ok");
    line.ask(&sd2(5, 60, 0x6D, ""), DIAG_5_AFTER_POWER_UP);
}

#[test]
fn devices_on_a_hub_receive_all_requests() {
    let folder = Folder::new();
    let names = ["master", "a", "b"].map(|name| folder.name(name));
    let mut hub = Program::start(&["hub", "--pty", &names[0], "--pty", &names[1], "--pty", &names[2]]);
    assert_eq!(hub.ready(), names.join(" "));
    let five = Program::start(&["simulate", "--serial", &names[1], "bcg450@5"]);
    let six = Program::start(&["simulate", "--serial", &names[2], "bcg450@6"]);
    five.ready();
    six.ready();
    let mut line = End::pty(&folder.path("master"));
    for _ in 0..10 {
        line.ask(FDL_STATUS_5, PRESENT_5);
        line.ask(FDL_STATUS_6, PRESENT_6);
    }
    assert_eq!(hub.tell(&format!("mute {} 3600", names[1])), "ok");
    line.send(FDL_STATUS_5);
    line.ask(FDL_STATUS_6, PRESENT_6);
    assert_eq!(hub.tell(&format!("mute {} 0", names[1])), "ok");
    line.ask(FDL_STATUS_5, PRESENT_5);
}
