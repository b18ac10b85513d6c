//! `profivac conform`: tests a slave against the rules.

use crate::bus::{self, BusOptions};
use crate::console::Signals;
use crate::device_files::known;
use crate::failure::Failure;
use crate::gauge::{confirm, is_interactive};
use crate::gsd_slaves::{GsdOptions, Wanted, modules_remark, rate_remark, selection};
use crate::output::{json, notice, out};
use crate::values::{self, Octets};
use crate::zeros::{Zeros, is_gauge};
use clap::Args;
use profivac_client::ClientError;
use profivac_client::cyclic::CyclicSlave;
use profivac_client::discover::CyclicError;
use profivac_client::values::hex;
use profivac_conform::dialogue::{LoggedCycle, SlaveUnderTest, Stated};
use profivac_conform::expected::Reason;
use profivac_conform::probe::Received;
use profivac_conform::{CheckResult, Outcome, run as run_checks};
use profivac_gsd_slave::GsdSlave;
use profivac_host::scan::{SlaveStatus, probe_all};
use profivac_host::session::BusSession;
use serde::Serialize;
use std::io::{Write, stderr};
use std::ops::ControlFlow;
use std::time::Duration;

/// Test a slave against the rules of PROFIBUS DP, and show request, answer and section for each.
///
/// The slave may be any DP slave, not only a gauge. The command sets its parameters, exchanges data with outputs of zero, and releases
/// it, many times: the relays of a gauge open and close. It shows the outputs of any other slave and asks first, because zeros can stop a
/// pump or close a valve. It also sends damaged telegrams. The slave must not be in use, and no other master may use the line. The
/// stored values of the slave do not change.
///
/// Each rule is passed, broken, or not tested. A broken rule was reproduced several times. A rule is not tested if the slave lacks the
/// service, if the slave breaks another rule that the test needs, or if the line or the computer damaged or delayed octets in each
/// repetition. With `--gsd` the slave gets the configuration and the parameters of its GSD file, and more rules test what the file
/// states: docs/gsd-slaves.md lists them. Exit code 1 means that the slave breaks a rule, 3 that it no longer answers, or that rules
/// were not tested because of the line or the computer.
#[derive(Args, Debug)]
#[command(after_help = EXAMPLES)]
pub struct Arguments {
    #[command(flatten)]
    bus: BusOptions,
    /// The address of the slave
    #[arg(long, value_name = "N", value_parser = values::slave_address)]
    address: u8,
    /// The configuration that the slave accepts, in hex; default: the answer to Get_Cfg
    #[arg(long, value_name = "HEX", value_parser = values::octets)]
    cfg: Option<Octets>,
    /// The user parameters that the slave accepts, in hex; default: those that keep the unit of a known gauge, otherwise none
    #[arg(long, value_name = "HEX", value_parser = values::octets)]
    prm: Option<Octets>,
    #[command(flatten)]
    gsd: GsdOptions,
    /// The modules of the slave: numbers of its GSD file in slot order (3+7), or a TOML file with names and parameters; default: the
    /// modules of its present configuration
    #[arg(long, value_name = "MODULES", requires = "paths", conflicts_with = "cfg")]
    modules: Option<String>,
    /// Set a parameter of the slave by its name in the GSD file; the last `=` separates name and value
    #[arg(long, value_name = "NAME=VALUE", requires = "paths", conflicts_with = "prm")]
    set: Vec<String>,
    /// Take ownership of the slave without an announcement, and send zeros as its outputs without asking; required without a
    /// terminal
    #[arg(long)]
    own: bool,
    /// Print JSON
    #[arg(long)]
    json: bool,
}

const EXAMPLES: &str = "\
Examples:
  profivac conform --port /dev/ttyUSB0 --address 5
  profivac conform --port /tmp/line --address 5 --own --json > report.json
  profivac conform --port tcp://127.0.0.1:4000 --address 9 --cfg '11 21' --prm '00 00 00'
  profivac conform --port /dev/ttyUSB0 --address 9 --gsd VALVES.GSD --modules 3+7 --set 'State without bus=closed'

Sections are those of the protocol reference that docs/conformance.md follows.";

/// Runs all checks and prints their outcome. A broken rule is exit code 1.
pub fn run(arguments: &Arguments) -> Result<(), Failure> {
    let address = arguments.address;
    arguments.bus.check_not_own_address(address, "--address")?;
    if arguments.own {
        // The user has agreed.
    } else if is_interactive() {
        notice(&format_args!(
            "conform takes ownership of the slave at address {address}, sets its parameters and releases it, many times"
        ));
    } else {
        return Err(Failure::usage(
            "conform takes ownership of the slave and sets its parameters; without a terminal add --own",
        ));
    }
    let signals = Signals::catch()?;
    let (subject, slot_time, zeros) = subject(arguments)?;
    if let Some(zeros) = zeros.filter(|_| !arguments.own) {
        confirm(&zeros.to_string(), false)?;
    }
    let mut wire = arguments.bus.open_probe(slot_time)?;
    if let Some(master) = wire.listen()? {
        return Err(Failure::no_answer(format!(
            "master {master} is using the line; conform needs a line without other masters"
        )));
    }
    let (mut rows, mut stopped) = (Vec::new(), false);
    let findings = run_checks(&mut wire, &subject, |finding| {
        if arguments.json {
            rows.push(Row::of(finding));
        } else {
            out(&line(finding));
        }
        stopped = signals.are_pending();
        if stopped { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
    });
    if arguments.json {
        out(&json(&rows));
    }
    let findings = findings?;
    if stopped {
        return Err(Failure::no_answer("interrupted by a signal; the slave is released"));
    }
    let late = wire.late_answer().map(|turnaround| bus::late_advice(wire.baud(), turnaround));
    verdict(address, &findings, late)
}

/// The end of the command. `late` is the advice after answers that came later than the slot time.
fn verdict(address: u8, findings: &[CheckResult], late: Option<String>) -> Result<(), Failure> {
    let count = |wanted: fn(&Outcome) -> bool| findings.iter().filter(|finding| wanted(&finding.outcome)).count();
    let broken = count(|outcome| matches!(outcome, Outcome::Broken { .. }));
    let untested = count(|outcome| matches!(outcome, Outcome::NotTested(_)));
    let passed = count(|outcome| *outcome == Outcome::Passed);
    writeln!(stderr(), "{passed} rules passed, {broken} broken, {untested} not tested").ok();
    let silent = count(|outcome| *outcome == Outcome::NotTested(Reason::Silent));
    let undecided = count(|outcome| {
        matches!(outcome, Outcome::NotTested(Reason::Disturbed | Reason::Varies | Reason::Undecided(_)))
    });
    match broken {
        0 if undecided > 0 && late.is_some() => Err(Failure::no_answer(format!(
            "rules of the slave at address {address} that were not tested: {undecided}, because {}",
            late.unwrap_or_default()
        ))),
        0 if undecided > 0 => Err(Failure::no_answer(format!(
            "the line or the computer disturbed the test of the slave at address {address}; rules not tested for this reason: \
             {undecided}; repeat the command while the computer has nothing else to do, and check cable and termination"
        ))),
        0 if silent > 0 => Err(Failure::no_answer(format!(
            "the slave at address {address} does not answer any more; rules not tested for this reason: {silent}"
        ))),
        0 => Ok(()),
        1 => Err(Failure::refused(format!("the slave at address {address} breaks a rule"))),
        _ => Err(Failure::refused(format!("the slave at address {address} breaks {broken} rules"))),
    }
}

/// Reads identity, configuration and unit of the slave without changing it. Returns them with the slot time of the session, and the
/// outputs that a slave other than a known gauge gets.
fn subject(arguments: &Arguments) -> Result<(SlaveUnderTest, Duration, Option<Zeros>), Failure> {
    let mut session = arguments.bus.open()?;
    let (address, master) = (arguments.address, arguments.bus.master());
    let slave = find_slave(&mut session, address)?;
    if let Some(owner) = slave.owner.filter(|owner| *owner != master) {
        return Err(Failure::refused(format!("the slave at address {address} belongs to master {owner}")));
    }
    let present = bus::present_cfg(&mut session, address)?;
    let user_prm = match &arguments.prm {
        Some(octets) => Some(octets.0.clone()),
        // Those of the file.
        None if arguments.gsd.is_given() => None,
        None => Some(known_prm(&mut session, address, master)?),
    };
    let (baud, slot_time) = (session.baud(), session.timing().slot_time);
    // The choice of a file may be a question to the user.
    drop(session);
    let by_gsd = arguments.by_gsd(slave.ident, present.as_deref())?;
    // A slave that refuses other modules than it has breaks no rule.
    let other_modules = by_gsd.as_ref().and_then(|slave| modules_remark(slave, address, present.as_deref()));
    if let Some(remark) = other_modules.filter(|_| arguments.modules.is_some()) {
        return Err(Failure::usage(format!(
            "{remark}; choose the plugged modules, or leave --modules out; --cfg HEX tests another configuration that the slave accepts"
        )));
    }
    let of_file = || by_gsd.as_ref().map(|slave| slave.user_prm().to_vec());
    let user_prm = user_prm.or_else(of_file).unwrap_or_default();
    let cfg = match (&arguments.cfg, &by_gsd) {
        (Some(octets), _) => octets.0.clone(),
        (None, Some(slave)) => slave.chk_cfg().to_vec(),
        (None, None) => present.ok_or_else(|| without_configuration(address))?,
    };
    if let Some(remark) = by_gsd.as_ref().and_then(|slave| rate_remark(slave, baud)) {
        notice(&format_args!("slave at address {address}: {remark}"));
    }
    let zeros = zeros(address, slave.ident, by_gsd.as_ref(), &cfg);
    let stated = by_gsd.as_ref().map(stated);
    Ok((SlaveUnderTest { address, ident: slave.ident, cfg, user_prm, stated }, slot_time, zeros))
}

/// The outputs of zero that a test sends to a slave other than a known gauge, whose relays the help of the commands names.
pub fn zeros(address: u8, ident: u16, by_gsd: Option<&GsdSlave>, cfg: &[u8]) -> Option<Zeros> {
    // With --cfg the slave may get another configuration than the file describes.
    let described = by_gsd.filter(|slave| slave.chk_cfg() == cfg);
    if is_gauge(known(), ident) {
        return None;
    }
    described.map_or_else(|| Zeros::of_cfg(address, cfg), |slave| Zeros::of_slave(address, slave))
}

impl Arguments {
    /// The slave by its GSD file, if the command line has one.
    fn by_gsd(&self, ident: u16, present: Option<&[u8]>) -> Result<Option<GsdSlave>, Failure> {
        if !self.gsd.is_given() {
            return Ok(None);
        }
        let catalog = self.gsd.read()?;
        let chosen = self.modules.as_deref().map(selection).transpose()?;
        let changes = self.set.iter().map(|text| text.parse()).collect::<Result<Vec<_>, _>>()?;
        let get_cfg = self.cfg.as_ref().map(|octets| octets.0.as_slice()).or(present);
        let wanted = Wanted { address: self.address, ident, get_cfg, selection: chosen.as_ref(), changes: &changes };
        wanted.find(&catalog).map(Some)
    }
}

/// What the GSD file of a slave states.
pub fn stated(slave: &GsdSlave) -> Stated {
    let general = &slave.device().general;
    let has = |keyword: Option<bool>| keyword == Some(true);
    Stated {
        max_diag_len: general.max_diag_data_len.and_then(|most| u8::try_from(most).ok()),
        sync: has(general.sync_mode_supp),
        freeze: has(general.freeze_mode_supp),
        fail_safe: has(general.fail_safe),
        dpv1: slave.is_dpv1(),
        ms1: has(general.c1_read_write_supp),
        ms2: has(general.c2_read_write_supp),
    }
}

fn find_slave(session: &mut BusSession, address: u8) -> Result<SlaveStatus, Failure> {
    let missing = || Failure::no_answer(format!("no slave answers at address {address}"));
    let mut found = Vec::new();
    probe_all(session, [address], &mut found)?;
    found.first().and_then(|seen| seen.slave).ok_or_else(missing)
}

/// The user parameters that keep the unit of a gauge; none for an unknown slave.
pub fn known_prm(session: &mut BusSession, address: u8, master: u8) -> Result<Vec<u8>, Failure> {
    match CyclicSlave::find_among(known(), session, address, master) {
        Ok(watched) => Ok(watched.parameters(session.baud()).user_prm.to_vec()),
        Err(CyclicError::Client(ClientError::UnknownDevice { .. })) => Ok(Vec::new()),
        Err(CyclicError::UnreadableUnit { .. }) => Err(Failure::usage(format!(
            "the unit of the gauge at address {address} cannot be read, and Set_Prm sets one; give the user parameters with \
             --prm, see `profivac gsd`"
        ))),
        Err(CyclicError::NeedsOutputs(_)) => Err(Failure::usage(format!(
            "the slave at address {address} takes outputs, and conform sends zeros, which can stop a pump or close a valve; to test it all \
             the same give the user parameters with --prm, see `profivac gsd`"
        ))),
        Err(error) => Err(error.into()),
    }
}

fn without_configuration(address: u8) -> Failure {
    Failure::refused(format!(
        "the slave at address {address} does not answer Get_Cfg; give its configuration with --cfg HEX"
    ))
}

/// A finding as a line; for a broken rule also request and answer.
fn line(finding: &CheckResult) -> String {
    let check = finding.check;
    let head = |word: &str| format!("{word:<8}{:<32}{} ({})", check.name, check.rule, check.section);
    match &finding.outcome {
        Outcome::Passed => head("ok"),
        Outcome::NotTested(reason) => format!("{}\n        not tested: {reason}", head("-")),
        Outcome::Broken { expected, shown } => {
            let shown = shown.as_ref().map(|shown| {
                format!("\n        request   {}\n        answer    {}", hex(&shown.sent), answer_text(shown))
            });
            format!("{}{}\n        expected  {expected}", head("BROKEN"), shown.unwrap_or_default())
        }
    }
}

fn answer_text(shown: &LoggedCycle) -> String {
    match &shown.received {
        Received::Nothing => "nothing".to_owned(),
        Received::Damaged => "octets that are not a telegram".to_owned(),
        Received::Telegram(octets) => hex(octets),
    }
}

/// A check in the JSON output.
#[derive(Debug, Serialize)]
pub struct Row {
    name: &'static str,
    rule: &'static str,
    section: &'static str,
    outcome: &'static str,
    /// What a broken rule expects.
    expected: Option<String>,
    /// Why a rule was not tested.
    reason: Option<String>,
    /// The rule that is the reason: it is broken, or was not tested itself.
    because: Option<&'static str>,
    asked: Option<String>,
    came: Option<String>,
}

impl Row {
    /// A finding as the JSON output shows it.
    pub fn of(finding: &CheckResult) -> Self {
        let CheckResult { check, outcome } = finding;
        let row = Self {
            name: check.name,
            rule: check.rule,
            section: check.section,
            outcome: "passed",
            expected: None,
            reason: None,
            because: None,
            asked: None,
            came: None,
        };
        match outcome {
            Outcome::Passed => row,
            Outcome::NotTested(reason) => {
                let because = match reason {
                    Reason::After(rule) | Reason::Undecided(rule) => Some(*rule),
                    _ => None,
                };
                Self { outcome: "not-tested", reason: Some(reason.to_string()), because, ..row }
            }
            Outcome::Broken { expected, shown } => Self {
                outcome: "broken",
                expected: Some(expected.to_string()),
                asked: shown.as_ref().map(|shown| hex(&shown.sent)),
                came: shown.as_ref().map(answer_text),
                ..row
            },
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use profivac_conform::checks;
    use profivac_conform::expected::{Expected, Service};

    fn finding(outcome: Outcome) -> CheckResult {
        CheckResult { check: checks::all().next().unwrap(), outcome }
    }

    #[test]
    fn a_broken_rule_is_shown_with_request_and_answer() {
        let shown = LoggedCycle { sent: vec![0x10, 8], received: Received::Telegram(vec![0xE5]) };
        let broken = Outcome::Broken { expected: Expected::FdlStatus, shown: Some(shown) };
        let expected = "\
BROKEN  layer2.fdl-status               FDL status is answered with status OK (1.11)
        request   10 08
        answer    E5
        expected  SD1 with status OK (0 in bits 0 to 3, 6 and 7 of FC)";
        assert_eq!(line(&finding(broken)), expected);
    }

    #[test]
    fn a_rule_that_was_not_tested_says_why() {
        let untested = finding(Outcome::NotTested(Reason::After("start-up.exchange")));
        let expected = "\
-       layer2.fdl-status               FDL status is answered with status OK (1.11)
        not tested: the slave breaks start-up.exchange";
        assert_eq!(line(&untested), expected);
        let row = Row::of(&untested);
        assert_eq!((row.outcome, row.because, row.expected), ("not-tested", Some("start-up.exchange"), None));
        assert_eq!(row.reason.as_deref(), Some("the slave breaks start-up.exchange"));
    }

    #[test]
    fn a_broken_rule_fails_with_a_count() {
        let untested = finding(Outcome::NotTested(Reason::Without(Service::Ms2)));
        assert!(verdict(5, &[finding(Outcome::Passed), untested], None).is_ok());
        let broken = || finding(Outcome::Broken { expected: Expected::Answer, shown: None });
        let silent =
            verdict(5, &[finding(Outcome::Passed), finding(Outcome::NotTested(Reason::Silent))], None).unwrap_err();
        assert_eq!(
            silent.to_string(),
            "the slave at address 5 does not answer any more; rules not tested for this reason: 1"
        );
        let undecided = [Reason::Disturbed, Reason::Varies, Reason::Undecided("layer2.closed")]
            .map(|reason| finding(Outcome::NotTested(reason)));
        assert_eq!(
            verdict(5, &undecided, None).unwrap_err().to_string(),
            "the line or the computer disturbed the test of the slave at address 5; rules not tested for this reason: 3; repeat the \
             command while the computer has nothing else to do, and check cable and termination"
        );
        let sentence = |findings: &[CheckResult]| verdict(5, findings, None).unwrap_err().to_string();
        assert_eq!(sentence(&[broken()]), "the slave at address 5 breaks a rule");
        assert_eq!(sentence(&[broken(), broken()]), "the slave at address 5 breaks 2 rules");
    }
}
