//! A slave tested against the rules of PROFIBUS DP.

use crate::bus::Line;
use crate::devices;
use crate::failure::Failure;
use crate::whole::Whole;
use profivac_client::cyclic::CyclicSlave;
use profivac_client::discover::CyclicError;
use profivac_client::values::hex;
use profivac_client::{Bus, ClientError, identify};
use profivac_conform::dialogue::{LoggedCycle, SlaveUnderTest};
use profivac_conform::expected::Reason;
use profivac_conform::probe::Received;
use profivac_conform::{CheckResult, Outcome, PortLink, run};
use profivac_dp::link::active::BusParameters;
use profivac_dp::master::services;
use profivac_host::clock::tbit_of;
use profivac_host::port::Port;
use profivac_host::session::{BusSession, Reply, bus_parameters};
use profivac_virtual::open;
use pyo3::prelude::*;
use pyo3::types::PyBytes;
use std::ops::ControlFlow;
use std::path::PathBuf;
use std::time::Duration;

/// Name, rule, section, outcome, expected, reason, the rule that is the reason, whether the line left it open, request, answer.
type RuleRow = (
    (&'static str, &'static str, &'static str),
    &'static str,
    Option<String>,
    Option<String>,
    Option<&'static str>,
    bool,
    Option<Py<PyBytes>>,
    Option<String>,
);

/// Tests the slave at an address of a port that this program alone uses. Calls `report` with each rule, without a return value.
#[pyfunction]
#[expect(clippy::too_many_arguments, reason = "the package names each of them")]
pub fn conform(
    py: Python<'_>,
    port: &str,
    address: Whole<u8>,
    cfg: Option<Vec<u8>>,
    user_prm: Option<Vec<u8>>,
    baud: Whole<u32>,
    master: Whole<u8>,
    timeout: f64,
    device_files: Vec<PathBuf>,
    report: Py<PyAny>,
) -> PyResult<()> {
    let (Whole(address), Whole(master)) = (address, master);
    let line = Line::new(baud.0, master, timeout)?.knowing(devices::known(&device_files)?);
    if address > 125 || address == master {
        return Err(Failure::usage(format!(
            "expected the address of a slave from 0 to 125 other than that of this master, {master}; got {address}"
        ))
        .into());
    }
    let mut raised = None;
    let done = py.detach(|| {
        test(port, address, (cfg, user_prm), line, |result| {
            let reported = Python::attach(|py| {
                report.call1(py, (row(py, result),))?;
                py.check_signals()
            });
            raised = reported.err();
            if raised.is_some() { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
        })
    });
    match raised {
        Some(error) => Err(error),
        None => Ok(done?),
    }
}

fn open_port(name: &str, line: Line) -> Result<Box<dyn Port>, Failure> {
    let devices: Vec<&str> = match name.strip_prefix("sim:") {
        Some(devices) if devices.contains('@') && !devices.ends_with(".toml") => devices.split_whitespace().collect(),
        _ => Vec::new(),
    };
    let opened = if devices.is_empty() { open::port(name, line.baud) } else { open::devices(&devices) };
    opened.map_err(|error| Failure::line(&error))
}

/// Reads identity, configuration and unit of the slave, then runs the rules on the port, opened again.
fn test(
    port: &str,
    address: u8,
    given: (Option<Vec<u8>>, Option<Vec<u8>>),
    line: Line,
    report: impl FnMut(&CheckResult) -> ControlFlow<()>,
) -> Result<(), Failure> {
    let (subject, slot_time) = {
        let bus = Bus::on(open_port(port, line)?).baud(line.baud).master(line.master).timeout(line.timeout);
        let mut bus = bus.open()?;
        let subject = subject(bus.session(), address, given, line)?;
        (subject, bus.session().timing().slot_time)
    };
    let mut link = probe(open_port(port, line)?, line, slot_time);
    if let Some(master) = link.listen().map_err(|error| Failure::line(&error))? {
        return Err(Failure::line(format!(
            "master {master} is using the line; conform needs a line without other masters"
        )));
    }
    run(&mut link, &subject, report).map_err(|error| Failure::line(&error))?;
    Ok(())
}

fn probe(port: Box<dyn Port>, line: Line, slot_time: Duration) -> PortLink {
    let bus = bus_parameters(line.master, line.baud, port.delivery());
    let measured_tbit = u32::try_from(tbit_of(line.baud, slot_time)).unwrap_or(u32::MAX);
    PortLink::new(port, line.baud, BusParameters { slot_tbit: bus.slot_tbit.max(measured_tbit), ..bus })
}

/// What the rules need to know about the slave, read without changing it.
fn subject(
    session: &mut BusSession,
    address: u8,
    (cfg, user_prm): (Option<Vec<u8>>, Option<Vec<u8>>),
    line: Line,
) -> Result<SlaveUnderTest, Failure> {
    let slave = identify::wait_for_slave(session, address)?;
    if let Some(owner) = slave.owner.filter(|owner| *owner != line.master) {
        return Err(Failure::refused(format!("the slave at address {address} belongs to master {owner}")));
    }
    let user_prm = match user_prm {
        Some(octets) => octets,
        None => known_prm(session, address, line)?,
    };
    let cfg = match cfg {
        Some(octets) => octets,
        None => present_cfg(session, address)?,
    };
    Ok(SlaveUnderTest { address, ident: slave.ident, cfg, user_prm, stated: None })
}

/// The user parameters that keep the unit of a gauge; none for an unknown slave.
fn known_prm(session: &mut BusSession, address: u8, line: Line) -> Result<Vec<u8>, Failure> {
    match CyclicSlave::find_among(line.devices, session, address, line.master) {
        Ok(slave) => Ok(slave.parameters(session.baud()).user_prm.to_vec()),
        Err(CyclicError::Client(ClientError::UnknownDevice { .. })) => Ok(Vec::new()),
        Err(CyclicError::UnreadableUnit { .. }) => Err(Failure::usage(format!(
            "the unit of the gauge at address {address} cannot be read, and Set_Prm sets one; give the user parameters with user_prm"
        ))),
        Err(CyclicError::NeedsOutputs(_)) => Err(Failure::usage(format!(
            "the slave at address {address} takes outputs, and conform sends zeros, which can stop a pump or close a valve; to test it all \
             the same give the user parameters with user_prm"
        ))),
        Err(error) => Err(error.into()),
    }
}

fn present_cfg(session: &mut BusSession, address: u8) -> Result<Vec<u8>, Failure> {
    match session.request(&services::get_cfg(address)).map_err(ClientError::from)? {
        Reply::Answer { du, .. } if !du.is_empty() => Ok(du),
        Reply::Answer { .. } | Reply::NoAnswer(_) => Err(Failure::refused(format!(
            "the slave at address {address} does not answer Get_Cfg; give its configuration with cfg"
        ))),
    }
}

fn row(py: Python<'_>, CheckResult { check, outcome }: &CheckResult) -> RuleRow {
    let head = (check.name, check.rule, check.section);
    match outcome {
        Outcome::Passed => (head, "passed", None, None, None, false, None, None),
        Outcome::NotTested(reason) => {
            let because = match reason {
                Reason::After(rule) | Reason::Undecided(rule) => Some(*rule),
                _ => None,
            };
            let is_open = matches!(reason, Reason::Disturbed | Reason::Varies | Reason::Undecided(_) | Reason::Silent);
            (head, "not-tested", None, Some(reason.to_string()), because, is_open, None, None)
        }
        Outcome::Broken { expected, shown } => {
            let sent = shown.as_ref().map(|shown| PyBytes::new(py, &shown.sent).unbind());
            let answer = shown.as_ref().map(answer_text);
            (head, "broken", Some(expected.to_string()), None, None, false, sent, answer)
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
