//! The rules of a GSD file: a slave that keeps them, and one that breaks each.

use super::faulty::{Fault, FaultyLine, Frame, MANAGER, MS1, RS, is_exchanging, leave, status};
use super::slave::sample;
use super::{broken, outcome, results};
use profivac_conform::dialogue::Stated;
use profivac_conform::expected::Reason;
use profivac_conform::{Outcome, checks};

/// A bit of the first octet of a diagnosis.
const NOT_SUPPORTED: u8 = 0x10;

fn everything() -> Stated {
    Stated { max_diag_len: Some(8), sync: true, freeze: true, fail_safe: true, dpv1: true, ms1: true, ms2: true }
}

fn results_with(stated: Stated, fault: &Fault) -> Vec<profivac_conform::CheckResult> {
    let (line, mut subject) = sample();
    subject.stated = Some(stated);
    results(&mut FaultyLine::new(line, fault), &subject)
}

const NO_FAULT: Fault = Fault::Answers(|_, _, answer| answer);

#[test]
fn a_slave_that_is_as_its_file_states_keeps_every_rule() {
    let results = results_with(everything(), &NO_FAULT);
    assert_eq!(results.len(), checks::all().chain(checks::of_gsd()).count());
    for result in results {
        assert_eq!(result.outcome, Outcome::Passed, "{}", result.check.name);
    }
}

#[test]
fn what_a_file_does_not_state_is_not_tested_and_without_a_file_no_rule_of_it_is() {
    let results = results_with(Stated::default(), &NO_FAULT);
    for check in checks::of_gsd() {
        assert_eq!(outcome(&results, check.name), &Outcome::NotTested(Reason::NotStated), "{}", check.name);
    }
    let (mut line, subject) = sample();
    assert_eq!(super::results(&mut line, &subject).len(), checks::all().count());
}

#[test]
fn a_diagnosis_that_is_longer_than_the_file_states_is_a_broken_rule() {
    for (most, is_broken) in [(8, false), (7, true)] {
        let results = results_with(Stated { max_diag_len: Some(most), ..Stated::default() }, &NO_FAULT);
        let broken = broken(&results);
        assert_eq!(!broken.is_empty(), is_broken, "{most}: {broken:?}");
        assert!(
            broken
                .iter()
                .all(|broken| broken.starts_with("gsd.diagnosis-length: expected a diagnosis of at most 7 octets"))
        );
    }
}

/// The same slaves break no rule if their files do not state the service.
#[test]
fn a_service_that_the_file_states_and_the_slave_lacks_is_a_broken_rule() {
    let unsupported = Fault::Reports(|du| du[0] |= NOT_SUPPORTED);
    let no_ms1 = Fault::Answers(|_, request, answer| if request.dsap == MS1 { status(request, RS) } else { answer });
    let no_ms2 =
        Fault::Answers(|_, request, answer| if request.dsap == MANAGER { status(request, RS) } else { answer });
    let no_empty_outputs = Fault::Reacts(|| {
        Box::new(|line, octets| {
            let is_empty = Frame::parse(octets).is_some_and(|one| one.is_exchange() && one.du.is_empty());
            if is_empty && is_exchanging(&line.slave) {
                leave(line);
            }
            line.send(octets)
        })
    });
    for (fault, names) in [
        (&unsupported, &["gsd.sync", "gsd.freeze"][..]),
        (&no_ms1, &["gsd.ms1"]),
        (&no_ms2, &["gsd.ms2"]),
        (&no_empty_outputs, &["gsd.fail-safe"]),
    ] {
        let found = broken(&results_with(everything(), fault));
        assert!(found.len() == names.len(), "{names:?}: {found:#?}");
        assert!(found.iter().zip(names).all(|(found, name)| found.starts_with(&format!("{name}:"))), "{found:#?}");
        assert_eq!(broken(&results_with(Stated::default(), fault)), Vec::<String>::new(), "{names:?}");
    }
}

#[test]
fn the_page_about_gsd_files_names_every_rule() {
    let page = std::fs::read_to_string(golden_path()).unwrap();
    for check in checks::of_gsd() {
        assert!(page.contains(&format!("| `{}` | {} |", check.name, check.rule)), "{}", check.name);
    }
}

fn golden_path() -> std::path::PathBuf {
    std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("../../docs/gsd-slaves.md")
}
