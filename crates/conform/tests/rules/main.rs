//! The rules against slaves that keep them, and against one faulty slave for each of them.

#![allow(clippy::unwrap_used, clippy::panic, clippy::indexing_slicing, reason = "a test")]

mod alternatives;
mod compound;
mod counting;
mod damaged;
mod disturbed;
mod faults;
mod faulty;
#[path = "../../../../tests/support/golden.rs"]
mod golden;
mod gsd;
mod page;
mod slave;

use alternatives::ALTERNATIVES;
use compound::COMPOUND;
use disturbed::{ALL, Disturbances, DisturbedLine, NOTICED};
use faulty::FaultyLine;
use profivac_conform::dialogue::{self, CheckError, Dialogue, Link, SlaveUnderTest};
use profivac_conform::expected::{Expected, Reason, Service};
use profivac_conform::probe::Received;
use profivac_conform::{CheckResult, Outcome, checks, run};
use profivac_devices::catalog::MODELS;
use profivac_host::port::PortError;
use profivac_wire::Sap;
use slave::{ADDRESS, Line, SampleSlave, sample, sample_with, virtual_device};
use std::fs;
use std::ops::ControlFlow;
use std::path::Path;
use std::time::Duration;

fn results(link: &mut dyn Link, slave: &SlaveUnderTest) -> Vec<CheckResult> {
    run(link, slave, |_| ControlFlow::Continue(())).unwrap()
}

/// The rules that a slave breaks, with what was expected and shown.
fn broken(results: &[CheckResult]) -> Vec<String> {
    let broken = |result: &CheckResult| match &result.outcome {
        Outcome::Broken { expected, shown } => {
            Some(format!("{}: expected {expected}, {shown:02X?}", result.check.name))
        }
        Outcome::Passed | Outcome::NotTested(_) => None,
    };
    results.iter().filter_map(broken).collect()
}

#[test]
fn every_virtual_device_breaks_no_rule() {
    for model in MODELS {
        let (mut line, subject) = virtual_device(model.name);
        assert_eq!(broken(&results(&mut line, &subject)), Vec::<String>::new(), "{}", model.name);
    }
}

/// A device is tested in all services that it has. Their user parameters leave MS1 closed.
#[test]
fn a_rule_is_not_tested_on_a_virtual_device_for_want_of_a_service_only() {
    for model in MODELS {
        let (mut line, subject) = virtual_device(model.name);
        for result in results(&mut line, &subject) {
            let lacks = match result.outcome {
                Outcome::Passed => continue,
                Outcome::NotTested(Reason::Without(service)) => service,
                other => panic!("{}: {}: {other:?}", model.name, result.check.name),
            };
            let expected = match lacks {
                Service::Sync | Service::Freeze | Service::Ms1 => true,
                Service::Ms2 => !model.features.dpv1,
                _ => false,
            };
            assert!(expected, "{}: {}: {lacks:?}", model.name, result.check.name);
        }
    }
}

/// A rule that no correct slave is tested against could not be trusted.
#[test]
fn the_small_slave_keeps_every_rule() {
    let (mut line, subject) = sample();
    for result in results(&mut line, &subject) {
        assert_eq!(result.outcome, Outcome::Passed, "{}", result.check.name);
    }
}

/// Inputs only, outputs only, neither.
#[test]
fn a_slave_without_inputs_or_outputs_keeps_every_rule() {
    for cfg in [&[0x11][..], &[0x21], &[0x00]] {
        let (mut line, subject) = sample_with(cfg);
        for result in results(&mut line, &subject) {
            assert_eq!(result.outcome, Outcome::Passed, "{cfg:02X?}: {}", result.check.name);
        }
    }
}

#[test]
fn each_faulty_slave_breaks_its_own_rule_and_no_other() {
    let mut wrong = Vec::new();
    for slave in faults::all() {
        let (line, subject) = sample();
        let broken = broken(&results(&mut FaultyLine::new(line, &slave.fault), &subject));
        if broken.len() != 1 || !broken[0].starts_with(&format!("{}:", slave.rule)) {
            wrong.push(format!("{}: {broken:#?}", slave.rule));
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

#[test]
fn a_slave_that_uses_an_alternative_of_the_reference_breaks_no_rule() {
    for (does, alternative) in ALTERNATIVES {
        let (line, subject) = sample();
        let results = results(&mut FaultyLine::new(line, alternative), &subject);
        assert_eq!(broken(&results), Vec::<String>::new(), "a slave that {does}");
        for result in results {
            let unprepared = matches!(result.outcome, Outcome::NotTested(Reason::Unprepared(_)));
            assert!(!unprepared, "a slave that {does}: {}: {:?}", result.check.name, result.outcome);
        }
    }
}

#[test]
fn a_fault_of_several_services_is_one_broken_rule() {
    for (rule, does, fault) in COMPOUND {
        let (line, subject) = sample();
        let broken = broken(&results(&mut FaultyLine::new(line, fault), &subject));
        let once = broken.len() == 1 && broken[0].starts_with(&format!("{rule}:"));
        assert!(once, "a slave that {does}: {broken:#?}");
    }
}

/// And no rule is untested for another reason: each consequence is foreseen, and each check leaves the slave as it was.
#[test]
fn what_a_faulty_slave_leaves_untested_names_its_fault() {
    for slave in faults::all() {
        let (line, subject) = sample();
        for result in results(&mut FaultyLine::new(line, &slave.fault), &subject) {
            if let Outcome::NotTested(reason) = result.outcome {
                assert_eq!(reason, Reason::After(slave.rule), "{}", result.check.name);
            }
        }
    }
}

/// The probabilities with which a telegram or a wait is disturbed: on a loaded computer, on a bad one, on a useless line.
const PROBABILITIES: [f64; 3] = [LOADED, 0.02, 0.2];
const LOADED: f64 = 0.002;

/// The results of a slave on lines with these disturbances, each run with another seed.
fn disturbed<L: Link>(
    disturbances: Disturbances,
    seeds: std::ops::Range<u64>,
    make: impl Fn() -> (L, SlaveUnderTest),
) -> impl Iterator<Item = ((u64, f64), Vec<CheckResult>)> {
    let runs = seeds.flat_map(|seed| PROBABILITIES.map(|probability| (seed, probability)));
    runs.map(move |(seed, probability)| {
        let (line, subject) = make();
        let mut line = DisturbedLine::new(line, disturbances, probability, seed);
        ((seed, probability), results(&mut line, &subject))
    })
}

/// Also if a request is lost on its way, which nothing but the missing answer shows.
#[test]
fn a_line_that_loses_damages_and_delays_telegrams_breaks_no_rule_of_a_correct_slave() {
    for (run, results) in disturbed(ALL, 0..20, sample) {
        assert_eq!(broken(&results), Vec::<String>::new(), "{run:?}");
    }
    for model in MODELS {
        for (run, results) in disturbed(ALL, 0..1, || virtual_device(model.name)) {
            assert_eq!(broken(&results), Vec::<String>::new(), "{}: {run:?}", model.name);
        }
    }
    for (does, alternative) in ALTERNATIVES {
        let slave = || {
            let (line, subject) = sample();
            (FaultyLine::new(line, alternative), subject)
        };
        for (run, results) in disturbed(ALL, 0..1, slave) {
            assert_eq!(broken(&results), Vec::<String>::new(), "a slave that {does}: {run:?}");
        }
    }
}

/// On a loaded computer each fault is found all the same.
#[test]
fn a_faulty_slave_on_a_disturbed_line_breaks_no_other_rule() {
    let mut wrong = Vec::new();
    for slave in faults::all() {
        let make = || {
            let (line, subject) = sample();
            (FaultyLine::new(line, &slave.fault), subject)
        };
        for (run, results) in disturbed(NOTICED, 0..1, make) {
            let broken = broken(&results);
            let is_own = broken.iter().all(|broken| broken.starts_with(&format!("{}:", slave.rule)));
            if !is_own || (broken.is_empty() && run.1 == LOADED) {
                wrong.push(format!("{}: {run:?}: {broken:#?}", slave.rule));
            }
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

/// The outcome of the rule with this name.
fn outcome<'a>(results: &'a [CheckResult], name: &str) -> &'a Outcome {
    &results.iter().find(|result| result.check.name == name).unwrap().outcome
}

/// The slave may have sent them whole.
#[test]
fn damaged_answers_in_every_repetition_leave_a_rule_and_those_that_need_it_untested() {
    let damaged = faulty::Fault::Answers(
        |_, request, answer| {
            if request.dsap == faulty::SLAVE_DIAG { Received::Damaged } else { answer }
        },
    );
    let (line, subject) = sample();
    let results = results(&mut FaultyLine::new(line, &damaged), &subject);
    assert_eq!(broken(&results), Vec::<String>::new());
    assert_eq!(outcome(&results, "diagnosis.answer"), &Outcome::NotTested(Reason::Disturbed));
    for name in ["layer2.access-points", "start-up.prm-req", "control.sync"] {
        assert_eq!(outcome(&results, name), &Outcome::NotTested(Reason::Undecided("diagnosis.answer")), "{name}");
    }
    assert_eq!(outcome(&results, "start-up.exchange"), &Outcome::Passed);
}

#[test]
fn a_wrong_answer_that_does_not_come_again_leaves_a_rule_untested() {
    let once = faulty::Fault::Reacts(|| {
        let mut is_first = true;
        Box::new(move |line, octets| {
            let received = line.send(octets);
            let is_status =
                faulty::Frame::parse(octets).is_some_and(|request| request.function() == faulty::FDL_STATUS);
            if is_status && std::mem::take(&mut is_first) { faulty::sc() } else { received }
        })
    });
    let (line, subject) = sample();
    let results = results(&mut FaultyLine::new(line, &once), &subject);
    assert_eq!(outcome(&results, "layer2.fdl-status"), &Outcome::NotTested(Reason::Varies));
    assert_eq!(outcome(&results, "layer2.addresses"), &Outcome::NotTested(Reason::Undecided("layer2.fdl-status")));
    assert_eq!(broken(&results), Vec::<String>::new());
}

#[test]
fn every_rule_has_one_faulty_slave_in_the_order_of_the_rules() {
    let rules: Vec<_> = checks::all().map(|check| check.name).collect();
    let faulty: Vec<_> = faults::all().map(|slave| slave.rule).collect();
    assert_eq!(faulty, rules);
}

#[test]
fn every_rule_needs_rules_that_are_tested_before_it() {
    let mut before: Vec<&str> = Vec::new();
    for check in checks::all() {
        assert!(!before.contains(&check.name), "{} occurs twice", check.name);
        for needed in check.needs.iter().chain(check.shares) {
            assert!(before.contains(needed), "{} needs {needed}", check.name);
        }
        before.push(check.name);
    }
}

/// `cargo xtask goldens` writes the page.
#[test]
fn the_page_of_rules_and_faulty_slaves_is_up_to_date() {
    golden::compare("docs/conform-rules.md", &page::print());
}

/// A consequence names the fault behind it, also over several rules.
#[test]
fn what_a_broken_rule_prevents_is_not_tested_and_names_it() {
    let never_ready = faults::all().find(|slave| slave.rule == "start-up.exchange").unwrap();
    let (line, subject) = sample();
    let results = results(&mut FaultyLine::new(line, &never_ready.fault), &subject);
    for name in ["start-up.unlock", "read.inputs-image", "watchdog.restart", "noise.state"] {
        assert_eq!(outcome(&results, name), &Outcome::NotTested(Reason::After("start-up.exchange")), "{name}");
    }
}

/// A slave of DP-V0 that says nothing on access points that it does not have.
#[test]
fn a_slave_that_is_silent_on_closed_access_points_breaks_one_rule() {
    let silent = faulty::Fault::Answers(|_, request, answer| {
        let closed = matches!(request.dsap, Some(0..=55)) || faulty::is_rs(&answer) && request.dsap.is_some();
        if closed { Received::Nothing } else { answer }
    });
    let (line, subject) = sample();
    let results = results(&mut FaultyLine::new(line, &silent), &subject);
    let broken = broken(&results);
    assert!(broken.len() == 1 && broken[0].starts_with("layer2.closed:"), "{broken:#?}");
    for name in ["ms1.poll", "ms2.manager", "ms2.idle"] {
        assert_eq!(outcome(&results, name), &Outcome::NotTested(Reason::Unprepared(Expected::Answer)), "{name}");
    }
}

#[test]
fn every_rule_cites_a_section_of_the_reference() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../docs/spec/profibus-wire");
    let reference: String =
        fs::read_dir(folder).unwrap().map(|file| fs::read_to_string(file.unwrap().path()).unwrap()).collect();
    for check in checks::all() {
        let anchor = format!("<a id=\"{}\"></a>", check.section);
        assert!(reference.contains(&anchor), "{}: {}", check.name, check.section);
    }
}

/// A slave that says nothing after a number of telegrams.
struct DyingLine {
    line: Line<SampleSlave>,
    telegrams: usize,
}

impl Link for DyingLine {
    fn address(&self) -> u8 {
        self.line.address()
    }

    fn send_and_receive(&mut self, octets: &[u8]) -> Result<Received, PortError> {
        let Some(left) = self.telegrams.checked_sub(1) else { return Ok(Received::Nothing) };
        self.telegrams = left;
        self.line.send_and_receive(octets)
    }

    fn wait(&mut self, time: Duration) -> Result<(), PortError> {
        self.line.wait(time)
    }
}

/// Not even a rule that asks for silence passes.
#[test]
fn no_rule_passes_or_breaks_on_a_slave_that_does_not_answer_any_more() {
    let (line, subject) = sample();
    let mut whole = DyingLine { line, telegrams: usize::MAX };
    results(&mut whole, &subject);
    for telegrams in (0..usize::MAX - whole.telegrams).step_by(11) {
        let (line, subject) = sample();
        let outcomes = results(&mut DyingLine { line, telegrams }, &subject);
        let tested = outcomes.iter().take_while(|result| result.outcome == Outcome::Passed).count();
        for result in &outcomes[tested..] {
            assert_eq!(result.outcome, Outcome::NotTested(Reason::Silent), "{telegrams}: {}", result.check.name);
        }
    }
}

/// A link that is lost after a number of telegrams.
struct LostLine {
    line: Line<SampleSlave>,
    telegrams: usize,
}

impl Link for LostLine {
    fn address(&self) -> u8 {
        self.line.address()
    }

    fn send_and_receive(&mut self, octets: &[u8]) -> Result<Received, PortError> {
        self.telegrams = self.telegrams.checked_sub(1).ok_or_else(|| PortError::Lost("line".to_owned()))?;
        self.line.send_and_receive(octets)
    }

    fn wait(&mut self, time: Duration) -> Result<(), PortError> {
        self.line.wait(time)
    }
}

impl LostLine {
    fn new(telegrams: usize) -> (Self, SlaveUnderTest) {
        let (line, subject) = sample();
        (Self { line, telegrams }, subject)
    }
}

/// A lost port is no fault of the slave, at whichever telegram of a check it is lost.
#[test]
fn a_lost_port_ends_every_check_as_a_lost_port() {
    for check in checks::all() {
        let (mut whole, subject) = LostLine::new(usize::MAX);
        (check.run)(&mut Dialogue::new(&mut whole, &subject)).unwrap();
        for telegrams in 0..usize::MAX - whole.telegrams {
            let (mut lost, subject) = LostLine::new(telegrams);
            let ended = (check.run)(&mut Dialogue::new(&mut lost, &subject));
            let is_lost = matches!(ended, Err(CheckError::Port(PortError::Lost(_))));
            assert!(is_lost, "{} after {telegrams} telegrams: {ended:?}", check.name);
        }
    }
}

#[test]
fn a_lost_port_ends_the_run() {
    let (mut lost, subject) = LostLine::new(500);
    let mut outcomes = Vec::new();
    let ended = run(&mut lost, &subject, |result| {
        outcomes.push(result.outcome.clone());
        ControlFlow::Continue(())
    });
    assert!(matches!(ended, Err(PortError::Lost(_))));
    assert!(!outcomes.is_empty() && outcomes.iter().all(|outcome| *outcome == Outcome::Passed), "{outcomes:?}");
}

/// The slave waits for parameters and has no owner.
#[test]
fn a_run_that_ends_after_any_check_releases_the_slave() {
    for count in 1..checks::all().count() {
        let (mut line, subject) = sample();
        let mut reported = 0;
        let results = run(&mut line, &subject, |_| {
            reported += 1;
            if reported == count { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
        });
        assert_eq!(results.unwrap().len(), count);
        let diagnosis = dialogue::octets(ADDRESS, 2, Sap::SlaveDiag, 0x6D, &[]);
        let Received::Telegram(answer) = line.send_and_receive(&diagnosis).unwrap() else {
            panic!("no diagnosis after {count}")
        };
        const DU: usize = 9;
        assert_eq!((answer[DU + 1] & 1, answer[DU + 3]), (1, 0xFF), "after {count}");
    }
}
