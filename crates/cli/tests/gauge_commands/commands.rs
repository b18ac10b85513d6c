//! `address`, `completions`, and the help texts.

use crate::common::run;
use crate::gauge_commands::{Line, PATIENTLY, without_late_answers};

fn text(octets: Vec<u8>) -> String {
    String::from_utf8(octets).unwrap()
}

fn address(line: &Line, rest: &[&str]) -> (i32, String, String) {
    let done = run(&[&["address", "--port", &line.path, PATIENTLY], rest].concat());
    (done.status.code().unwrap(), text(done.stdout), without_late_answers(&text(done.stderr)))
}

#[test]
fn a_slave_gets_an_address_and_keeps_it() {
    let mut line = Line::with(&["bcg450@126", "pcg550@6"]);
    let (code, printed, message) = address(&line, &["--from", "126", "--to", "5"]);
    assert_eq!((code, printed.as_str()), (0, "0x08E6 (bcg450): address 126 -> 5\n"), "{message}");
    assert_eq!(line.output("read", 5, &["0/25"]), "device.device-state = IDLE\n");
    line.tell("power 126 off");
    line.tell("power 126 on");
    line.tell("advance 10");
    let (code, printed, _) = address(&line, &["--from", "5", "--to", "9", "--json"]);
    let row: serde_json::Value = serde_json::from_str(&printed).unwrap();
    assert_eq!((code, &row["to"], &row["locked"]), (0, &9.into(), &false.into()));
}

#[test]
fn an_address_that_cannot_be_set_is_refused() {
    let line = Line::with(&["bcg450@126", "pcg550@6"]);
    let fails = |rest: &[&str], code: i32, sentence: &str| {
        assert_eq!(address(&line, rest), (code, String::new(), format!("profivac: {sentence}\n")), "{rest:?}");
    };
    fails(&["--from", "126", "--to", "6"], 2, "address 6 is taken: a station answers there");
    fails(&["--from", "9", "--to", "10"], 3, "no slave answers at address 9");
    let switch = "the slave at address 6 does not take an address over the bus: its address switch sets the address, or it does not have \
                  the service (ServiceNotActivated)";
    fails(&["--from", "6", "--to", "7"], 1, switch);
    fails(&["--from", "126", "--to", "0"], 2, "--to 0 is the address of this master; choose another with --master N");
    let lock = "address 5 would be locked: only the address switch of the device could change it again; nothing was sent; without \
                a terminal add --yes";
    fails(&["--from", "126", "--to", "5", "--lock"], 2, lock);
}

#[test]
fn a_locked_slave_keeps_its_address() {
    let line = Line::with(&["bcg450@126"]);
    let (code, printed, message) = address(&line, &["--from", "126", "--to", "5", "--lock", "--yes"]);
    assert_eq!((code, printed.as_str()), (0, "0x08E6 (bcg450): address 126 -> 5, locked\n"), "{message}");
    let kept = "profivac: the slave at address 5 kept its address: it is locked against changes, or its address switch sets it\n";
    assert_eq!(address(&line, &["--from", "5", "--to", "9"]), (1, String::new(), kept.to_owned()));
}

#[test]
fn every_shell_gets_its_completions() {
    for (shell, sign) in [("bash", "_profivac()"), ("zsh", "#compdef profivac"), ("fish", "complete -c profivac")] {
        let done = run(&["completions", shell]);
        assert_eq!(done.status.code(), Some(0));
        let printed = text(done.stdout);
        assert!(printed.contains(sign) && printed.contains("restore"), "{shell}");
    }
    assert_eq!(run(&["completions", "tcsh"]).status.code(), Some(2));
}

#[test]
fn every_help_text_has_examples() {
    let commands = crate::common::commands();
    assert!(commands.len() > 25, "{commands:?}");
    for command in commands {
        let done = run(&[&command, "--help"]);
        let printed = text(done.stdout);
        assert_eq!(done.status.code(), Some(0));
        assert!(printed.contains("Examples:\n") && printed.contains(&format!("  profivac {command} ")), "{printed}");
    }
}
