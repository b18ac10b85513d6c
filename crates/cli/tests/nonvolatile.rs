//! Nonvolatile values survive the power switch, and with `--state` the process.

#![allow(clippy::unwrap_used, clippy::panic, reason = "a test")]

use crate::common::{End, Folder, Program, sd2};

/// A BCG450 whose switch is set outside 0 to 125, on its own line.
fn simulation(folder: &Folder, arguments: &[&str]) -> (Program, End) {
    let program = Program::start(&[&["simulate", "--pty", &folder.name("line"), "bcg450@126"], arguments].concat());
    program.ready();
    let line = End::pty(&folder.path("line"));
    (program, line)
}

/// Set_Slave_Add from 126 to 9, changeable afterwards: profibus-wire 2.11.
fn set_address_9(line: &mut End) {
    line.ask(&sd2(126, 55, 0x6D, "09 08 E6 00"), "E5");
}

#[test]
fn an_address_from_the_bus_survives_the_power_switch() {
    let folder = Folder::new();
    let (mut program, mut line) = simulation(&folder, &[]);
    assert_eq!(program.state(126)["address"], 126);
    set_address_9(&mut line);
    assert_eq!(program.tell("power 126 off"), "ok");
    assert_eq!(program.tell("power 126 on"), "ok");
    line.ask("10 09 02 49 54 16", "10 02 09 00 0B 16");
    assert_eq!(program.state(126)["address"], 9);
}

#[test]
fn without_a_folder_values_end_with_the_process() {
    let folder = Folder::new();
    let (mut program, mut line) = simulation(&folder, &[]);
    set_address_9(&mut line);
    assert_eq!(program.tell("quit"), "ok");
    program.exit_code();
    let (mut program, _line) = simulation(&folder, &[]);
    assert_eq!(program.state(126)["address"], 126);
}

#[test]
fn with_a_folder_acknowledged_values_survive_a_kill() {
    let folder = Folder::new();
    let state = folder.name("state");
    let (mut program, mut line) = simulation(&folder, &["--state", &state]);
    set_address_9(&mut line);
    program.kill();
    // The dangling link of the killed process is replaced.
    let (mut program, mut line) = simulation(&folder, &["--state", &state]);
    line.ask("10 09 02 49 54 16", "10 02 09 00 0B 16");
    assert_eq!(program.state(126)["address"], 9);
}

#[test]
fn every_address_has_its_own_memory() {
    let folder = Folder::new();
    let state = folder.name("state");
    let (mut program, _line) = simulation(&folder, &["--state", &state, "bcg450@7"]);
    assert_eq!(program.tell("quit"), "ok");
    for name in ["bcg450-126.state", "bcg450-7.state"] {
        assert!(std::path::Path::new(&state).join(name).is_file(), "{name}");
    }
}

#[test]
fn a_damaged_memory_is_reported_and_renamed() {
    let folder = Folder::new();
    std::fs::write(folder.path("bcg450-126.state"), "address = 09 00\n").unwrap();
    let (mut program, _line) = simulation(&folder, &["--state", &folder.name("")]);
    let message = program.complaint();
    assert!(
        message.starts_with("profivac: the nonvolatile memory of bcg450 at address 126 is damaged; it was renamed to "),
        "{message}"
    );
    assert_eq!(program.state(126)["address"], 126);
    let kept = std::fs::read_to_string(folder.path("bcg450-126.damaged-1")).unwrap();
    assert_eq!(kept, "address = 09 00\n");
}

/// The line with the check sum of a file that was changed by hand.
fn checked(body: &str) -> String {
    format!("{body}end, check sum {:08X}\n", crc32(body.as_bytes()))
}

/// CRC-32 of IEEE 802.3, bit by bit.
fn crc32(octets: &[u8]) -> u32 {
    !octets.iter().fold(u32::MAX, |sum, octet| {
        (0..8).fold(sum ^ u32::from(*octet), |sum, _| if sum & 1 == 1 { sum >> 1 ^ 0xEDB8_8320 } else { sum >> 1 })
    })
}

/// A file that can be read, but whose values are not those of this device, or not all of them: it is reported and kept.
#[test]
fn a_memory_that_is_not_completely_used_is_reported_and_kept() {
    let of_bcg = "# nonvolatile memory of bcg450 at address 126\n";
    for (body, message, address) in [
        (
            "# nonvolatile memory of pcg550 at address 126\naddress = 09 00\n".to_owned(),
            "is the memory of a pcg550; it was renamed to ",
            126,
        ),
        // Safe State 7 does not exist; the address is good.
        (
            format!("{of_bcg}parameter 1:2/39 = 07\naddress = 09 00\n"),
            "has values that the device does not take (1); it was kept as ",
            9,
        ),
        (
            format!("{of_bcg}parameter 1:2/39 = 01 01\naddress = 09\nhidden 0 = 00\n"),
            "has values that the device does not take (3); it was kept as ",
            126,
        ),
    ] {
        let folder = Folder::new();
        let (file, kept) = (folder.path("bcg450-126.state"), folder.path("bcg450-126.damaged-1"));
        let text = checked(&body);
        std::fs::write(&file, &text).unwrap();
        let (mut program, _line) = simulation(&folder, &["--state", &folder.name("")]);
        let complaint = program.complaint();
        let expected = format!("profivac: the nonvolatile memory of bcg450 at address 126 {message}");
        assert!(complaint.starts_with(&expected), "{complaint}");
        assert_eq!(
            (program.state(126)["address"].as_u64(), std::fs::read_to_string(&kept).unwrap()),
            (Some(address), text)
        );
        assert_eq!(program.tell("quit"), "ok");
        assert_eq!(program.exit_code(), 0);
        // The next start uses the rest and has nothing to report.
        let (mut program, _line) = simulation(&folder, &["--state", &folder.name("")]);
        assert_eq!(program.state(126)["address"].as_u64(), Some(address));
        assert_eq!(program.tell("quit"), "ok");
        assert!(!folder.path("bcg450-126.damaged-2").exists());
    }
}

/// A file that ends too early, at every length.
#[test]
fn a_memory_that_is_cut_off_is_reported_and_kept() {
    let folder = Folder::new();
    let text = checked("# nonvolatile memory of bcg450 at address 126\nparameter 1:2/39 = 01\naddress = 09 00\n");
    for (number, length) in (1..).zip([0, 1, 45, 68, text.len() / 2, text.len() - 1]) {
        std::fs::write(folder.path("bcg450-126.state"), &text[..length]).unwrap();
        let (mut program, _line) = simulation(&folder, &["--state", &folder.name("")]);
        assert!(program.complaint().contains("is damaged; it was renamed to "), "{length} octets");
        assert_eq!(program.state(126)["address"], 126, "{length} octets");
        let kept = std::fs::read_to_string(folder.path(&format!("bcg450-126.damaged-{number}"))).unwrap();
        assert_eq!(kept, text[..length]);
        assert_eq!(program.tell("quit"), "ok");
        program.exit_code();
    }
}
