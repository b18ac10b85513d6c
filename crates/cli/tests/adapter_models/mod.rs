//! The operations of profivac through models of serial adapters: docs/adapters.md has the table, which is made in simulated time, where
//! nothing depends on the speed of the computer. The other end of the line is a virtual gauge. The same models are in front of a pty in
//! [`pty`].

#![allow(clippy::unwrap_used, clippy::panic, reason = "a test")]

mod adapter;
mod pty;
mod relay;
mod simulated;

use crate::adapter_page;
use adapter::{ADAPTERS, Adapter, FRAME, Holding, Loss, timer, usb};
use profivac_client::cyclic::CyclicSlave;
use profivac_client::{Gauge, identify, settings};
use profivac_conform::dialogue::SlaveUnderTest;
use profivac_conform::expected::Reason;
use profivac_conform::{CheckResult, Outcome, PortLink, run as run_checks};
use profivac_dp::link::Baud;
use profivac_dp::link::active::BusParameters;
use profivac_dp::master::services;
use profivac_host::clock::tbit_of;
use profivac_host::port::{LateAnswerRemedy, Notice};
use profivac_host::scan;
use profivac_host::session::{BusSession, Reply, bus_parameters};
use profivac_vacuum::Gas;
use profivac_virtual::device::{GasConditions, VirtualDevice};
use profivac_virtual::device_spec::DeviceSpec;
use profivac_virtual::nonvolatile::NonvolatileMemory;
use simulated::ModelPort;
use std::ops::ControlFlow;
use std::time::Duration;

const ADDRESS: u8 = 5;

/// The adapter with a virtual BCG450 on its line.
fn port(adapter: Adapter, baud: Baud) -> ModelPort<Vec<VirtualDevice>> {
    let spec: DeviceSpec = format!("bcg450@{ADDRESS}").parse().unwrap();
    let unit = spec.build(NonvolatileMemory::volatile(), baud).unwrap();
    let pressure = |mbar| profivac_client::pressure::Pressure::from_mbar(mbar);
    let around = GasConditions { pressure: pressure(1e-3), atmosphere: pressure(1013.25), gas: Gas::N2 };
    ModelPort::new(adapter, baud, vec![VirtualDevice::new(unit, ADDRESS, baud, around)])
}

/// A master on the adapter.
fn session(adapter: Adapter, baud: Baud) -> BusSession {
    let bus = bus_parameters(0, baud, adapter.delivery);
    // Bounds a hang only: simulated time passes at any speed.
    BusSession::new(Box::new(port(adapter, baud)), baud, bus, Duration::from_secs(3600)).unwrap()
}

fn gauge(session: &mut BusSession) -> Result<Gauge<profivac_client::ms2::Ms2<'_>>, String> {
    let slave = identify::wait_for_slave(session, ADDRESS).map_err(|error| error.to_string())?;
    assert_eq!(slave.ident, 0x08E6);
    Gauge::open(session, ADDRESS).map_err(|error| error.to_string())
}

fn scans(adapter: Adapter, baud: Baud) -> Result<(), String> {
    let mut session = session(adapter, baud);
    let mut found = Vec::new();
    scan::probe_all(&mut session, 1..=10, &mut found).map_err(|error| error.to_string())?;
    match &found[..] {
        [station] if station.slave.is_some_and(|slave| slave.ident == 0x08E6) => Ok(()),
        [] => Err("finds no station".to_owned()),
        other => Err(format!("{other:?}")),
    }
}

fn reads(adapter: Adapter, baud: Baud) -> Result<(), String> {
    let mut session = session(adapter, baud);
    let value = gauge(&mut session)?.read("pirani.process-value").map_err(|error| error.to_string())?;
    assert!(!value.text.is_empty());
    Ok(())
}

fn dumps(adapter: Adapter, baud: Baud) -> Result<(), String> {
    let mut session = session(adapter, baud);
    let dump = settings::dump(&mut gauge(&mut session)?).map_err(|error| error.to_string())?;
    let unread = dump.readings.iter().filter(|(_, reading)| reading.is_err()).count();
    assert!(dump.readings.len() > 50, "{}", dump.readings.len());
    if unread > 0 { Err(format!("{unread} parameters were not read")) } else { Ok(()) }
}

fn conforms(adapter: Adapter, baud: Baud) -> Result<(), String> {
    let bus = bus_parameters(0, baud, adapter.delivery);
    let (cfg, user_prm, slot_time) = {
        let mut session = session(adapter, baud);
        let slave = CyclicSlave::find(&mut session, ADDRESS, 0).map_err(|error| error.to_string())?;
        let reply = session.request(&services::get_cfg(ADDRESS)).map_err(|error| error.to_string())?;
        let Reply::Answer { du, .. } = reply else { return Err("no configuration".to_owned()) };
        (du, slave.parameters(baud).user_prm.to_vec(), session.timing().slot_time)
    };
    let subject = SlaveUnderTest { address: ADDRESS, ident: 0x08E6, cfg, user_prm, stated: None };
    let slot_tbit = bus.slot_tbit.max(u32::try_from(tbit_of(baud, slot_time)).unwrap());
    let bus = BusParameters { slot_tbit, ..bus };
    let mut link = PortLink::new(Box::new(port(adapter, baud)), baud, bus);
    let other_master = link.listen().map_err(|error| error.to_string())?;
    assert_eq!(other_master, None);
    let results = run_checks(&mut link, &subject, |_| ControlFlow::Continue(())).map_err(|error| error.to_string())?;
    let is_silent = |result: &CheckResult| matches!(result.outcome, Outcome::NotTested(Reason::Silent));
    if results.iter().any(is_silent) {
        return Err("ends without a result, because the slave seems not to answer".to_owned());
    }
    let is_undecided = |reason: &Reason| matches!(reason, Reason::Disturbed | Reason::Varies | Reason::Undecided(_));
    let undecided =
        |result: &CheckResult| matches!(&result.outcome, Outcome::NotTested(reason) if is_undecided(reason));
    if link.late_answer().is_some() && results.iter().any(undecided) {
        return Err("ends without a result, because an answer was late".to_owned());
    }
    let broken: Vec<_> = results
        .iter()
        .filter(|result| matches!(result.outcome, Outcome::Broken { .. }))
        .map(|result| result.check.name)
        .collect();
    if broken.is_empty() { Ok(()) } else { Err(format!("{} broken: {}", broken.len(), broken.join(", "))) }
}

type Operation = fn(Adapter, Baud) -> Result<(), String>;

const OPERATIONS: [(&str, Operation); 4] = [("scan", scans), ("read", reads), ("dump", dumps), ("conform", conforms)];

/// A row of the table for each outcome at this rate.
fn rows(adapter: Adapter, baud: Baud) -> Vec<String> {
    let outcome = |operation: Operation| operation(adapter, baud).err().unwrap_or_else(|| "works".to_owned());
    let mut groups: Vec<(String, Vec<&str>)> = Vec::new();
    for (name, operation) in OPERATIONS {
        let outcome = outcome(operation);
        match groups.iter_mut().find(|(known, _)| *known == outcome) {
            Some((_, names)) => names.push(name),
            None => groups.push((outcome, vec![name])),
        }
    }
    let row = |(outcome, names): (String, Vec<&str>)| {
        format!("| {} | {} | {} | {outcome} |\n", adapter.name, baud.bits_per_second(), names.join(", "))
    };
    groups.into_iter().map(row).collect()
}

/// The rates of each model: the highest one that every operation of the table is tried at is that of the adapter.
fn rates(adapter: &Adapter) -> &'static [Baud] {
    match adapter.holding {
        Holding::Fifo { .. } => &[Baud::B9600, Baud::B19200],
        Holding::Packets { .. } => &[Baud::B19200, Baud::B500000],
    }
}

#[test]
fn the_table_of_the_models_is_that_of_the_page_about_adapters() {
    let mut table = "| Model of an adapter | bit/s | Operation | Outcome |\n|---|--:|---|---|\n".to_owned();
    for adapter in ADAPTERS {
        for baud in rates(&adapter) {
            table.extend(rows(adapter, *baud));
        }
    }
    adapter_page::check_table("adapter_models", &table);
}

/// Serves the line until the session reports a late answer.
fn late_answer(session: &mut BusSession) -> Notice {
    let mut notices = (0..1000).filter_map(|_| {
        session.serve(&[], FRAME).unwrap();
        session.next_notice()
    });
    notices.next().unwrap_or_else(|| panic!("no notice"))
}

/// The slot time of a bus that has been configured for a faster adapter is too short for this one.
#[test]
fn a_master_that_is_alone_raises_its_slot_time_after_a_late_answer_and_says_so() {
    let adapter = usb("slow", 64, 40, timer(1));
    let baud = Baud::B19200;
    let mut session = session(adapter, baud);
    let before = session.timing();
    let asked = |session: &mut BusSession| session.request(&services::slave_diag(ADDRESS)).unwrap();
    assert!(matches!(asked(&mut session), Reply::NoAnswer(_)), "the first answer is late");
    let notice = late_answer(&mut session);
    let Notice::LateAnswer { turnaround_ms, remedy: LateAnswerRemedy::Raised, .. } = notice else {
        panic!("{notice:?}")
    };
    assert!(turnaround_ms >= 40, "{turnaround_ms}");
    let after = session.timing();
    assert!(after.slot_time > before.slot_time && after.slot_time > after.turnaround, "{after:?}");
    for _ in 0..20 {
        assert!(matches!(asked(&mut session), Reply::Answer { .. }), "{}", session.timing());
    }
}

#[test]
fn a_slot_time_that_the_user_gave_stays_and_the_notice_says_which_one_is_needed() {
    let mut session = session(usb("slow", 64, 40, timer(1)), Baud::B19200).with_fixed_slot_time();
    let before = session.timing().slot_time;
    let _late = session.request(&services::slave_diag(ADDRESS)).unwrap();
    let notice = late_answer(&mut session);
    assert!(notice.to_string().contains("set the slot time of each master on the line to at least"), "{notice}");
    assert_eq!(session.timing().slot_time, before);
}

/// An answer to FDL status has six characters.
#[test]
fn a_scan_finds_a_slave_although_characters_of_its_first_answers_are_lost() {
    for loses in (1..=6).map(Loss::One).chain([Loss::UpTo(6)]) {
        for adapter in ADAPTERS.into_iter().take(3).map(|adapter| Adapter { loses, ..adapter }) {
            for baud in rates(&adapter) {
                assert_eq!(scans(adapter, *baud), Ok(()), "{} at {baud}", adapter.name);
            }
        }
    }
}

#[test]
fn a_longer_pause_than_assumed_within_an_answer_is_tolerated_and_measured() {
    // Packets of four characters, 30 ms apart: the driver claims 1 ms.
    let adapter = usb("slow", 4, 30, timer(1));
    let baud = Baud::B500000;
    let bus = BusParameters { slot_tbit: 16_383 * 2, ..bus_parameters(0, baud, adapter.delivery) };
    let mut session = BusSession::new(Box::new(port(adapter, baud)), baud, bus, Duration::from_secs(3600)).unwrap();
    let reply = session.request(&services::slave_diag(ADDRESS)).unwrap();
    assert!(matches!(reply, Reply::Answer { .. }), "{reply:?}");
    let timing = session.timing();
    assert!(timing.pause >= Duration::from_millis(25) && timing.tolerated_pause >= timing.pause, "{timing}");
}

/// 40 ms are 20000 bit times at 500 kbit/s, and a slot time has at most 16383.
#[test]
fn an_answer_that_no_slot_time_waits_for_is_reported_with_what_to_do() {
    let mut session = session(usb("slow", 64, 40, timer(1)), Baud::B500000);
    let _late = session.request(&services::slave_diag(ADDRESS)).unwrap();
    let notice = late_answer(&mut session).to_string();
    assert!(notice.ends_with("use an adapter with less delay, or a lower rate"), "{notice}");
}
