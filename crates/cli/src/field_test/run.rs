//! The steps of a field test.

use super::capture::{self, Packet};
use super::expectation;
use super::figures;
use super::line::Line;
use super::read_only::ReadOnlyLink;
use super::redact::Redaction;
use super::replay::NOT_RECORDED;
use super::report::{
    FORMAT, GsdFacts, Options, PortFacts, Report, Slave, Step, StepName, kernel_release, public_sentence,
};
use crate::bus::BusOptions;
use crate::conform;
use crate::console::Signals;
use crate::device_files::known;
use crate::failure::Failure;
use crate::gauge::{ask, is_interactive};
use crate::gsd_slaves::Wanted;
use crate::output::notice;
use crate::scan;
use crate::zeros::Zeros;
use profivac_client::values::hex;
use profivac_conform::dialogue::{Link, SlaveUnderTest, octets};
use profivac_conform::probe::Received;
use profivac_conform::{CheckResult, PortLink, checks, run as run_checks};
use profivac_dp::link::Baud;
use profivac_dp::link::active::Request;
use profivac_dp::master::services;
use profivac_gsd_slave::{Catalog, GsdSlave};
use profivac_host::clock::tbit_of;
use profivac_host::port::{Direction, Port};
use profivac_host::scan::{FoundStation, probe};
use profivac_host::session::{BusSession, Reply};
use profivac_wire::Sap;
use serde_json::{Value, json};
use std::collections::BTreeMap;
use std::fmt::Write;
use std::ops::ControlFlow;
use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::time::{Duration, Instant};

/// Requests without an answer in succession after which a slave counts as gone. chosen.
const MAX_MISSING: usize = 10;

/// The longest note about the rules of a slave, in characters. chosen: a sentence.
const MAX_NOTE: usize = 300;

/// Why only rules that read are tested.
const UNCLEAR: &str =
    "the modules of the slave are not clear from the GSD files: rules of the file and rules that write were not tested";
const NO_CONFIGURATION: &str = "the slave does not answer Get_Cfg: rules of the file and rules that write were not tested, because they need its configuration";
const NOT_AGREED: &str = "nobody has agreed to zeros as the outputs of the slave: rules that write were not tested";

/// FDL status, and Slave_Diag with FCV 0 and FCB 1: each is a new request, whatever the slave got before.
const FDL_STATUS: u8 = 0x49;
const SRD_HIGH_FIRST: u8 = 0x6D;

/// The highest address of a slave that a master can own.
const MAX_OWNED: u8 = 125;

/// A run, with what it has found so far.
pub struct Run<'a> {
    bus: &'a BusOptions,
    line: Line,
    signals: Option<&'a Signals>,
    /// Counts the requests that an archive does not contain.
    unknown: Arc<AtomicUsize>,
    /// The result. Its end is written by [`finish`](Self::finish).
    pub report: Report,
    /// The range of recorded chunks of each step.
    ranges: Vec<std::ops::Range<usize>>,
    /// Slaves that stopped answering.
    vanished: Vec<u8>,
    /// The slot time of the session that scanned; zero before.
    slot_time: Duration,
    /// Where the parameters of slaves of any vendor come from.
    pub gsd: GsdSource,
    /// The user has agreed on the command line to zeros as the outputs of any slave.
    pub own: bool,
}

/// GSD files, or what an archive has of them.
pub enum GsdSource {
    /// Files of the command line.
    Files(Catalog),
    /// From an archive, by address.
    Recorded {
        /// The facts of the files.
        facts: BTreeMap<u8, GsdFacts>,
        /// Why only rules that read were tested.
        notes: BTreeMap<u8, String>,
    },
}

/// The files that a run produces.
pub struct Files {
    /// The capture file.
    pub capture: Vec<u8>,
    /// When characters were sent and delivered.
    pub pieces: String,
}

impl<'a> Run<'a> {
    /// A run that has done nothing yet. A signal ends it between two requests.
    pub fn new(
        bus: &'a BusOptions,
        line: Line,
        options: Options,
        signals: Option<&'a Signals>,
        unknown: Arc<AtomicUsize>,
    ) -> Self {
        let report = Report {
            format: FORMAT,
            version: env!("CARGO_PKG_VERSION").to_owned(),
            kernel: kernel_release(),
            complete: false,
            end: String::new(),
            options,
            port: None,
            other_masters: Vec::new(),
            steps: Vec::new(),
            stations: Vec::new(),
            slaves: Vec::new(),
        };
        Self {
            bus,
            line,
            signals,
            unknown,
            report,
            ranges: Vec::new(),
            vanished: Vec::new(),
            slot_time: Duration::ZERO,
            gsd: GsdSource::Files(Catalog::default()),
            own: false,
        }
    }

    /// Runs all steps. The report keeps the results before a failure.
    pub fn all_steps(&mut self) -> Result<(), Failure> {
        self.step(StepName::Listen, None, Self::listen)?;
        self.step(StepName::Scan, None, Self::scan)?;
        let addresses: Vec<u8> = self.report.slaves.iter().map(|slave| slave.address).collect();
        for address in &addresses {
            self.step(StepName::Conform, Some(*address), |run| run.conform(*address))?;
        }
        for address in &addresses {
            self.step(StepName::Measure, Some(*address), |run| run.measure(*address))?;
        }
        Ok(())
    }

    /// Completes the report after the last step. Returns the files, and the result of the command.
    pub fn finish(&mut self, done: Result<(), Failure>) -> (Files, Result<(), Failure>) {
        self.report.complete = done.is_ok();
        let done = done.and_then(|()| self.verdict());
        let end = done.as_ref().err().map_or_else(|| "every step ran".to_owned(), ToString::to_string);
        let public = self.report.port.as_ref().map_or("the port", |port| port.name.as_str());
        self.report.end = public_sentence(&end, self.bus.port(), public);
        if let Some(port) = &mut self.report.port {
            port.notices = std::mem::take(&mut self.line.notices);
        }
        (self.files(), done)
    }

    /// A run without a slave, or with one that stopped answering, is a failure although every step ran.
    fn verdict(&self) -> Result<(), Failure> {
        let addresses = self.vanished.iter().map(u8::to_string).collect::<Vec<_>>().join(", ");
        match (self.report.stations.is_empty(), self.vanished.is_empty()) {
            (true, _) => Err(Failure::no_answer(format!(
                "no station answers on {}: check wiring, termination and rate",
                self.bus.port()
            ))),
            (false, false) => Err(Failure::no_answer(format!("the slave at address {addresses} stopped answering"))),
            (false, true) => Ok(()),
        }
    }

    fn files(&mut self) -> Files {
        let (baud, is_timed) = (self.baud(), self.has_rate());
        let options = &self.report.options;
        let beside_others = (!self.report.other_masters.is_empty()).then_some(options.master);
        let redaction = Redaction::new(options.with_serial_numbers, beside_others);
        let (mut packets, mut pieces): (Vec<Packet>, _) = (Vec::new(), "us,direction,characters\n".to_owned());
        for (step, range) in self.report.steps.iter_mut().zip(&self.ranges) {
            let mut chunks = self.line.recording().since(range.start);
            chunks.truncate(range.len());
            let new = capture::packets(&chunks, baud, is_timed, redaction);
            step.packets = new.len();
            packets.extend(new);
            for chunk in &chunks {
                let direction = match chunk.direction {
                    Direction::Sent => "sent",
                    Direction::Received => "received",
                };
                // Writing to a text cannot fail.
                writeln!(pieces, "{},{direction},{}", chunk.at.as_micros(), chunk.characters.len()).ok();
            }
        }
        Files { capture: capture::write(&packets, baud), pieces }
    }

    fn baud(&self) -> Baud {
        self.report.options.rate().unwrap_or(self.bus.rate().initial())
    }

    fn has_rate(&self) -> bool {
        self.report.port.as_ref().is_some_and(|port| port.has_rate)
    }

    /// Runs one step and registers the recorded chunks, also if it failed.
    fn step(
        &mut self,
        name: StepName,
        address: Option<u8>,
        work: impl FnOnce(&mut Self) -> Result<(), Failure>,
    ) -> Result<(), Failure> {
        let (first, begun) = (self.line.recording().count(), self.line.recording().elapsed());
        self.line.begin_step();
        let done = self.interrupted().and_then(|()| work(self));
        let seconds = self.line.recording().elapsed().saturating_sub(begun).as_secs_f64();
        self.ranges.push(first..self.line.recording().count());
        // The number of packets is known when the run ends.
        self.report.steps.push(Step { name, address, packets: 0, seconds });
        done
    }

    /// A session whose waits a signal ends.
    fn session_on(&self, port: Box<dyn Port>, baud: Baud) -> Result<BusSession, Failure> {
        let mut session = self.bus.session_on(port, baud)?;
        session.set_cancellation(self.signals.map(Signals::cancellation).transpose()?);
        Ok(session)
    }

    fn interrupted(&self) -> Result<(), Failure> {
        match self.signals {
            Some(signals) if signals.are_pending() => Err(Failure::interrupted()),
            _ if self.line.recording().is_full() => Err(Failure::no_answer(
                "the recording is full, and everything after this moment is missing; test fewer slaves at once, or use fewer --cycles",
            )),
            _ => Ok(()),
        }
    }

    /// Sends nothing. Another master ends the run.
    fn listen(&mut self) -> Result<(), Failure> {
        let (port, baud) = self.line.open()?;
        let slot_tbit = self.bus.parameters(baud, port.delivery()).slot_tbit;
        self.report.options.baud = baud.bits_per_second();
        self.report.port = Some(PortFacts::of(&*port, baud, slot_tbit));
        progress("listening for other masters");
        let mut link = self.bus.probe_on(port, baud, self.slot_time);
        self.refuse_other_masters(&mut link)
    }

    fn refuse_other_masters(&mut self, link: &mut PortLink) -> Result<(), Failure> {
        let master = link.listen()?;
        self.end_beside(master)
    }

    fn end_beside(&mut self, other_master: Option<u8>) -> Result<(), Failure> {
        other_master.map_or(Ok(()), |master| Err(self.other_master(master)))
    }

    fn other_master(&mut self, master: u8) -> Failure {
        self.report.other_masters.push(master);
        Failure::no_answer(format!(
            "master {master} is using the line; field-test would disturb it and needs the line without other masters"
        ))
    }

    fn scan(&mut self) -> Result<(), Failure> {
        let (port, baud) = self.line.open()?;
        let mut session = self.session_on(port, baud)?;
        progress(&format!("asking addresses 0 to {}", self.bus.hsa()));
        // One lost telegram must not hide a slave: silent addresses are asked again.
        for _ in 0..2 {
            self.ask_silent_addresses(&mut session)?;
        }
        self.slot_time = session.timing().slot_time;
        progress(&format!(
            "stations that answer: {}, slaves among them: {}",
            self.report.stations.len(),
            self.report.slaves.len()
        ));
        Ok(())
    }

    fn ask_silent_addresses(&mut self, session: &mut BusSession) -> Result<(), Failure> {
        let mut pace = Pace::begin();
        for address in (0..=self.bus.hsa()).filter(|address| *address != self.bus.master()) {
            if self.has_answered(address) {
                continue;
            }
            self.interrupted()?;
            pace.report(|| format!("address {address} of {}", self.bus.hsa()));
            let found = probe(session, address)?;
            let other = session.masters().find(|master| *master != self.bus.master());
            self.end_beside(other)?;
            if let Some(station) = found {
                self.add_station(session, &station)?;
            }
        }
        Ok(())
    }

    fn has_answered(&self, address: u8) -> bool {
        let address = u64::from(address);
        self.report.stations.iter().any(|station| station.get("address").and_then(Value::as_u64) == Some(address))
    }

    fn add_station(&mut self, session: &mut BusSession, station: &FoundStation) -> Result<(), Failure> {
        // A row always has a JSON form.
        self.report.stations.push(serde_json::to_value(scan::Row::of(station)).unwrap_or_default());
        let Some(status) = station.slave else { return Ok(()) };
        let address = station.address;
        let mut slave = Slave::at(address);
        let owner = status.owner.filter(|owner| *owner != self.bus.master());
        slave.rules_note = owner.map(|owner| format!("the slave belongs to master {owner}"));
        // The slave is in the report before the requests that may fail.
        self.report.slaves.push(slave);
        let diagnosis = data_of(session, &services::slave_diag(address))?;
        let configuration = data_of(session, &services::get_cfg(address))?;
        if let Some(slave) = self.slave_mut(address) {
            slave.diagnosis = diagnosis.map(|du| hex(&du));
            slave.configuration = configuration.map(|du| hex(&du));
        }
        Ok(())
    }

    fn slave_mut(&mut self, address: u8) -> Option<&mut Slave> {
        self.report.slaves.iter_mut().find(|slave| slave.address == address)
    }

    fn conform(&mut self, address: u8) -> Result<(), Failure> {
        let may_write = self.report.options.allow_writes && address <= MAX_OWNED;
        let Some(slave) = self.report.slaves.iter().find(|slave| slave.address == address) else { return Ok(()) };
        if slave.rules_note.is_some() {
            return Ok(());
        }
        let cfg = slave.configuration.as_deref().map(octets_of).unwrap_or_default();
        let ident = slave.diagnosis.as_deref().map(octets_of).and_then(|du| ident(&du)).unwrap_or_default();
        let has_cfg = !cfg.is_empty();
        let Limits { facts, note } = self.limits(address, ident, &cfg, may_write && has_cfg)?;
        let note = if may_write && !has_cfg { Some(NO_CONFIGURATION.to_owned()) } else { note };
        let writes = may_write && note.is_none();
        progress(&format!("slave {address}: testing the rules{}", if writes { ", with writes" } else { "" }));
        let user_prm = match (writes, &facts) {
            (true, Some(facts)) => Some(octets_of(&facts.user_prm)),
            (true, None) => self.user_prm(address)?,
            (false, _) => Some(Vec::new()),
        };
        let Some(user_prm) = user_prm else { return Ok(()) };
        let stated = facts.as_ref().map(|facts| facts.stated.clone());
        if let Some(slave) = self.slave_mut(address) {
            slave.gsd = facts;
            slave.limits_note = note;
        }
        let subject = SlaveUnderTest { address, ident, cfg, user_prm, stated };
        let (port, baud) = self.line.open()?;
        let mut link = self.bus.probe_on(port, baud, self.slot_time);
        self.refuse_other_masters(&mut link)?;
        self.test_rules(&mut link, &subject, writes)?;
        self.end_beside(link.other_master())
    }

    /// What the GSD file of a slave says, and whether only rules that read are tested.
    fn limits(&self, address: u8, ident: u16, cfg: &[u8], may_write: bool) -> Result<Limits, Failure> {
        let catalog = match &self.gsd {
            GsdSource::Recorded { facts, notes } => {
                let (facts, note) = (facts.get(&address).cloned(), notes.get(&address).cloned());
                return Ok(Limits { facts, note });
            }
            GsdSource::Files(catalog) => catalog,
        };
        let slave = match gsd_slave(catalog, address, ident, cfg) {
            Ok(slave) => slave,
            Err(failure) if failure.is_interrupted() => return Err(failure),
            Err(failure) => {
                // It names files, and the archive contains no names of files.
                notice(&failure);
                return Ok(Limits { facts: None, note: Some(UNCLEAR.to_owned()) });
            }
        };
        let zeros = conform::zeros(address, ident, slave.as_ref(), cfg).filter(|_| may_write && !self.own);
        let is_agreed = zeros.map_or(Ok(true), |zeros| agree(&zeros))?;
        Ok(Limits { facts: slave.as_ref().map(GsdFacts::of), note: (!is_agreed).then(|| NOT_AGREED.to_owned()) })
    }

    /// The user parameters that keep the unit of a gauge. `None` if they are unknown.
    fn user_prm(&mut self, address: u8) -> Result<Option<Vec<u8>>, Failure> {
        let (port, baud) = self.line.open()?;
        let mut session = self.session_on(port, baud)?;
        match conform::known_prm(&mut session, address, self.bus.master()) {
            Ok(user_prm) => Ok(Some(user_prm)),
            Err(failure) if failure.is_port() => Err(failure),
            Err(failure) => self.note_rules(address, &failure.to_string()).map(|()| None),
        }
    }

    fn note_rules(&mut self, address: u8, note: &str) -> Result<(), Failure> {
        if let Some(slave) = self.slave_mut(address) {
            slave.rules_note = Some(note.chars().take(MAX_NOTE).collect());
        }
        Ok(())
    }

    fn test_rules(&mut self, link: &mut dyn Link, subject: &SlaveUnderTest, writes: bool) -> Result<(), Failure> {
        let mut rows = Vec::new();
        let of_gsd = subject.stated.iter().flat_map(|_| checks::of_gsd()).count();
        let all = checks::all().count().saturating_add(of_gsd);
        let (mut pace, recording) = (Pace::begin(), self.line.recording().clone());
        let (unknown, signals) = (Arc::clone(&self.unknown), self.signals);
        let mut before = unknown.load(Ordering::Relaxed);
        let redaction = Redaction::new(self.report.options.with_serial_numbers, None);
        let report = |finding: &CheckResult| {
            let now = unknown.load(Ordering::Relaxed);
            let row = row(finding, now == before);
            rows.push(without_records(row, redaction));
            pace.report(|| format!("slave {}: {} of {all} rules", subject.address, rows.len()));
            before = now;
            let must_end = signals.is_some_and(Signals::are_pending) || recording.is_full();
            if must_end { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
        };
        let done = if writes {
            run_checks(link, subject, report)
        } else {
            run_checks(&mut ReadOnlyLink(link), subject, report)
        };
        if let Some(slave) = self.slave_mut(subject.address) {
            slave.rules = rows;
        }
        done?;
        self.interrupted()
    }

    fn measure(&mut self, address: u8) -> Result<(), Failure> {
        let (port, baud) = self.line.open()?;
        let slot_tbit =
            u64::from(self.bus.parameters(baud, port.delivery()).slot_tbit).max(tbit_of(baud, self.slot_time));
        let is_timed = port.is_timed();
        let mut link = self.bus.probe_on(port, baud, self.slot_time);
        self.refuse_other_masters(&mut link)?;
        progress(&format!("slave {address}: measuring {} requests of two services", self.report.options.cycles));
        let first = self.line.recording().count();
        let done = self.send_cycles(&mut link, address);
        let figures = figures::of(&self.line.recording().since(first), baud, is_timed, slot_tbit);
        let is_gone = matches!(&done, Ok(false));
        let notices =
            self.report.port.as_ref().map(|port| expectation::of(&figures, port, baud, slot_tbit)).unwrap_or_default();
        if let Some(slave) = self.slave_mut(address) {
            slave.timing_notices = notices;
            slave.figures = Some(figures);
            slave.figures_note =
                is_gone.then(|| format!("the slave left {MAX_MISSING} requests unanswered and was given up"));
        }
        if is_gone {
            notice(&format_args!("the slave at address {address} stopped answering"));
            self.vanished.push(address);
        }
        self.end_beside(link.other_master())?;
        done.map(|_| ())
    }

    /// Returns whether the slave answered until the end. Ends when another master is received.
    fn send_cycles(&self, link: &mut PortLink, address: u8) -> Result<bool, Failure> {
        let own = self.bus.master();
        let requests = [
            octets(address, own, Sap::Default, FDL_STATUS, &[]),
            octets(address, own, Sap::SlaveDiag, SRD_HIGH_FIRST, &[]),
        ];
        let mut missing: usize = 0;
        let (mut pace, cycles) = (Pace::begin(), self.report.options.cycles);
        for done in 0..cycles {
            self.interrupted()?;
            pace.report(|| format!("slave {address}: {done} of {cycles} requests of each service"));
            if link.other_master().is_some() {
                return Ok(true);
            }
            for request in &requests {
                let received = link.send_and_receive(request)?;
                missing = if received == Received::Nothing { missing.saturating_add(1) } else { 0 };
                if missing >= MAX_MISSING {
                    return Ok(false);
                }
            }
        }
        Ok(true)
    }
}

/// What is tested of a slave.
struct Limits {
    facts: Option<GsdFacts>,
    /// Why only rules that read are tested.
    note: Option<String>,
}

/// The slave by its GSD file; none for a known gauge, and if no file has the ident.
fn gsd_slave(catalog: &Catalog, address: u8, ident: u16, cfg: &[u8]) -> Result<Option<GsdSlave>, Failure> {
    if catalog.by_ident(ident).is_empty() || known().knows(ident) {
        return Ok(None);
    }
    Wanted { address, ident, get_cfg: Some(cfg), selection: None, changes: &[] }.find(catalog).map(Some)
}

/// Whether the user agrees to zeros as the outputs of a slave. Without a terminal nobody does.
fn agree(zeros: &Zeros) -> Result<bool, Failure> {
    if is_interactive() {
        return ask(&zeros.to_string());
    }
    notice(&format_args!("{zeros}; only rules that read are tested with it; without a terminal add --own to test all"));
    Ok(false)
}

/// A rule in the report.
fn row(finding: &CheckResult, is_recorded: bool) -> Value {
    if is_recorded {
        // A row always has a JSON form.
        return serde_json::to_value(conform::Row::of(finding)).unwrap_or_default();
    }
    let check = finding.check;
    json!({ "name": check.name, "rule": check.rule, "section": check.section, "outcome": NOT_RECORDED })
}

/// The row without the contents of records in its octets.
fn without_records(mut row: Value, redaction: Redaction) -> Value {
    for (key, direction) in [("asked", Direction::Sent), ("came", Direction::Received)] {
        if let Some(Value::String(text)) = row.get_mut(key)
            && text.split_whitespace().all(|octet| u8::from_str_radix(octet, 16).is_ok())
        {
            *text = hex(&redaction.of(direction, &octets_of(text)));
        }
    }
    row
}

/// The data of an answer. A request without an answer is repeated once.
fn data_of(session: &mut BusSession, request: &Request<'_>) -> Result<Option<Vec<u8>>, Failure> {
    for _ in 0..2 {
        if let Reply::Answer { du, .. } = session.request(request)? {
            return Ok(Some(du).filter(|du| !du.is_empty()));
        }
    }
    Ok(None)
}

/// Ident_Number of a diagnosis.
fn ident(du: &[u8]) -> Option<u16> {
    profivac_host::scan::SlaveStatus::parse(du).map(|status| status.ident)
}

/// The octets of [`hex`].
fn octets_of(text: &str) -> Vec<u8> {
    text.split_whitespace().filter_map(|octet| u8::from_str_radix(octet, 16).ok()).collect()
}

fn progress(message: &str) {
    notice(&message);
}

/// The shortest time between two lines of progress of one step. chosen.
const PROGRESS_INTERVAL: Duration = Duration::from_secs(2);

/// Limits the lines of progress of a step that takes long.
struct Pace {
    /// When the last line was printed, or the step began.
    last: Instant,
}

impl Pace {
    fn begin() -> Self {
        Self { last: Instant::now() }
    }

    /// Prints a line if the last one is long ago.
    fn report(&mut self, message: impl FnOnce() -> String) {
        if self.is_due(Instant::now()) {
            progress(&message());
        }
    }

    fn is_due(&mut self, now: Instant) -> bool {
        let is_due = now.saturating_duration_since(self.last) >= PROGRESS_INTERVAL;
        if is_due {
            self.last = now;
        }
        is_due
    }
}

#[cfg(test)]
#[allow(clippy::unwrap_used, reason = "a test")]
mod tests {
    use super::*;
    use profivac_host::port::{Port, Recorded, Recording, Stream};
    use std::os::unix::net::UnixStream;

    #[test]
    fn a_step_prints_a_line_of_progress_every_two_seconds_however_many_requests_it_sends() {
        let mut pace = Pace::begin();
        let begun = pace.last;
        let at = |ms| begun + Duration::from_millis(ms);
        let printed: Vec<_> = (0..=6_500).step_by(100).filter(|ms| pace.is_due(at(*ms))).collect();
        assert_eq!(printed, [2_000, 4_000, 6_000]);
    }

    #[test]
    fn a_full_recording_ends_the_run_and_the_report_says_so() {
        let bus = BusOptions::new("port", &crate::bus::MasterOptions::new(Baud::B19200, 0, 6));
        let options =
            Options { baud: 19_200, master: 0, hsa: 6, cycles: 1, allow_writes: false, with_serial_numbers: false };
        let recording = Recording::with_limit(0);
        let line = Line::recorded_by(recording.clone(), &bus);
        let mut run = Run::new(&bus, line, options, None, Arc::default());
        assert!(run.interrupted().is_ok());
        let (_other, ours) = UnixStream::pair().unwrap();
        Recorded::new(Box::new(Stream::new("line".to_owned(), ours, Vec::new())), recording).send(&[0xE5]).unwrap();
        let done = run.interrupted();
        let (_, done) = run.finish(done);
        assert!(done.is_err() && !run.report.complete);
        assert!(run.report.end.starts_with("the recording is full, and everything after"), "{}", run.report.end);
    }

    #[test]
    fn the_octets_of_a_broken_rule_do_not_show_a_record() {
        // A Read response with eight octets.
        let record = "68 11 11 68 80 85 08 32 03 5E 00 17 08 41 42 43 44 45 46 47 48 E3 16";
        let row = json!({ "asked": "10 05 00 49 4E 16", "came": record });
        let without = without_records(row.clone(), Redaction::new(false, None));
        assert_eq!(without["asked"], row["asked"]);
        let came = without["came"].as_str().unwrap_or_default();
        assert!(came.contains("5E 00 17 08 00 00 00 00 00 00 00 00") && !came.contains("41"), "{came}");
        assert_eq!(without_records(row.clone(), Redaction::new(true, None)), row);
        let silent = json!({ "came": "nothing" });
        assert_eq!(without_records(silent.clone(), Redaction::new(false, None)), silent);
    }
}
