//! A slave by its GSD file: in data exchange with the station's master, or read without ownership.
//!
//! The station owns a slave only if its file says so. All others are heard on the line while another master exchanges data with them;
//! on a segment with a master of the station, RD_Inp reads those that are not heard.

use super::moment::{LineMoment, Moment};
use super::slave_words::reports;
use crate::config;
use crate::recording::RecorderHandle;
use crate::view::{self, BusStationState, GaugeKind, WatchedParameter};
use profivac_dp::link::BitTime;
use profivac_dp::master::services;
use profivac_host::clock::duration_of;
use profivac_host::port::PortError;
use profivac_host::scan;
use profivac_host::session::{BusMaster, BusSession, Reply, SessionError, add_or_restart};
use profivac_listen::gauge::Knowledge;
use profivac_listen::{Hex, Observer};
use profivac_recorder::validity::{self, MAX_SILENCE};
use profivac_recorder::{EventKind, Micros, Quality};
use profivac_wire::control::Status;
use profivac_wire::diag::{SlaveDiag, StationStatus};
use std::sync::Arc;
use std::time::{Duration, Instant};

/// The time between two searches for a slave that gives no data. chosen: as for gauges.
const SEARCH_INTERVAL: Duration = Duration::from_secs(3);

/// The shortest time between two events of a point. chosen: a bit that toggles with each sample must not fill the list of events.
const TOLD_INTERVAL: Duration = Duration::from_secs(10);

/// The time after which a slave that is read with RD_Inp is asked again for its modules and its diagnosis. chosen: its master may give it
/// other modules between two requests, and each check takes four requests.
const VERIFY_INTERVAL: Duration = Duration::from_secs(10);

/// The most events about the diagnosis of a slave in a minute. chosen: a loose contact must not fill the list of events; the last texts
/// are told a minute later.
const EVENTS_PER_MINUTE: u8 = 6;

/// How many events may still be recorded in this minute.
struct Allowance {
    began: Instant,
    used: u8,
}

impl Allowance {
    const fn new(now: Instant) -> Self {
        Self { began: now, used: 0 }
    }

    /// Whether one more event is recorded.
    fn take(&mut self, now: Instant) -> bool {
        if now.saturating_duration_since(self.began) >= Duration::from_mins(1) {
            *self = Self::new(now);
        }
        let is_allowed = self.used < EVENTS_PER_MINUTE;
        self.used = self.used.saturating_add(u8::from(is_allowed));
        is_allowed
    }
}

/// A slave of the station's file.
pub struct SegmentSlave {
    /// The configuration.
    pub config: config::Slave,
    state: BusStationState,
    problem: Option<String>,
    /// Its last diagnosis: the octets, its texts, and whether it is a fault.
    diagnosis: Vec<u8>,
    reports: Vec<String>,
    has_fault: bool,
    /// The texts of the last event about the diagnosis, and how many of them may follow.
    told_reports: Vec<String>,
    allowance: Allowance,
    /// The points. Views share them: a view is made ten times a second.
    points: Arc<[WatchedParameter]>,
    /// The text of each point with texts, as the last event says it, and when.
    told: Vec<Option<(String, Instant)>>,
    /// The last data exchange on the line and on the clocks of the station.
    exchange: (Option<BitTime>, Moment),
    /// When it gave the present values.
    read: Option<Moment>,
    lost_at: Option<Micros>,
    sample_at: Instant,
    search_at: Instant,
    /// When its modules and its diagnosis are read again, with RD_Inp.
    verify_at: Instant,
    /// The master has it in its list.
    is_added: bool,
    /// Another master exchanges data with it, and the line shows it.
    is_heard: bool,
}

impl SegmentSlave {
    /// A slave of which nothing is known yet.
    pub fn new(config: config::Slave, now: Moment) -> Self {
        Self {
            points: planned_points(&config).into(),
            told: vec![None; config.points.len()],
            config,
            state: BusStationState::Missing,
            problem: None,
            diagnosis: Vec::new(),
            reports: Vec::new(),
            has_fault: false,
            told_reports: Vec::new(),
            allowance: Allowance::new(now.at),
            exchange: (None, now),
            read: None,
            lost_at: None,
            sample_at: now.at,
            search_at: now.at,
            verify_at: now.at,
            is_added: false,
            is_heard: false,
        }
    }

    /// When it needs to be sampled or searched.
    pub const fn due(&self) -> Instant {
        if self.is_searched() { self.search_at } else { self.sample_at }
    }

    /// Whether the station waits for it: it exchanges no data with it, hears none and has read none.
    const fn is_searched(&self) -> bool {
        if self.config.is_owned { !self.is_added } else { !self.is_heard && !self.has_values() }
    }

    /// When the station is to search it, or to read it with RD_Inp; `None` for one that needs no request.
    fn request_due(&self) -> Option<Instant> {
        let is_asked = if self.config.is_owned { !self.is_added } else { !self.is_heard };
        is_asked.then(|| self.due())
    }

    fn request_begins(&mut self, now: Moment) {
        self.search_at = now.at + SEARCH_INTERVAL;
        self.sample_at = now.at + self.config.poll;
    }

    /// Whether it gives values now.
    pub const fn has_values(&self) -> bool {
        matches!(self.state, BusStationState::DataExchange | BusStationState::Fault)
    }

    /// Whether RD_Inp may be believed: the slave was asked lately and is the device of the station's file, with its modules.
    pub fn is_verified(&self, now: Moment) -> bool {
        self.has_values() && now.at < self.verify_at
    }

    /// Takes the present inputs of a slave that the station owns, if its time has come.
    pub fn sample_owned(&mut self, recorder: &RecorderHandle, master: &mut BusMaster, line: LineMoment) {
        let now = line.now;
        if !self.is_added || self.sample_at > now.at {
            return;
        }
        self.sample_at = now.at + self.config.poll;
        let address = self.config.address;
        if let Some(at) = master.exchanged_at(address).filter(|at| self.exchange.0 != Some(*at)) {
            self.exchange = (Some(at), line.of(at));
        }
        let (is_exchanging, read) = self.exchange;
        match master.inputs(address).filter(|_| is_exchanging.is_some() && now.since(read) < MAX_SILENCE) {
            Some(inputs) => {
                let diagnosis = master.diagnosis(address).map(|diag| octets_of(&diag)).unwrap_or_default();
                self.take_values(recorder, &diagnosis, inputs, read, now);
            }
            None => {
                let problem = master.exchange_error(address).map(|error| error.to_string());
                let state = if problem.is_some() { BusStationState::Missing } else { BusStationState::Starting };
                self.lose(recorder, state, problem, now);
                // It may have values soon, however seldom it is sampled.
                self.sample_at = self.sample_at.min(now.at + MAX_SILENCE);
            }
        }
    }

    /// Takes what was heard of a slave that the station does not own, if its time has come. `opened` is when the line was opened.
    pub fn sample_heard(&mut self, recorder: &RecorderHandle, observer: &Observer, opened: BitTime, line: LineMoment) {
        let now = line.now;
        let station = observer.station(self.config.address).filter(|_| !self.config.is_owned);
        let heard = station.and_then(|it| Some((it, it.knowledge.exchanged_at().filter(|at| *at > opened)?)));
        let heard = heard.map(|(station, at)| (station, at, duration_of(line.baud, line.bus_time - at)));
        let heard = heard.filter(|(_, _, silence)| *silence < MAX_SILENCE);
        let was_heard = std::mem::replace(&mut self.is_heard, heard.is_some());
        if was_heard && !self.is_heard {
            // Its silence is a loss at once, however seldom it is sampled.
            self.sample_at = self.sample_at.min(now.at);
        }
        let Some((station, at, silence)) = heard.filter(|_| self.sample_at <= now.at) else { return };
        self.sample_at = now.at + self.config.poll;
        if let Some(problem) = self.contradiction(&station.knowledge) {
            return self.lose(recorder, BusStationState::Missing, Some(problem), now);
        }
        if self.exchange.0 != Some(at) {
            self.exchange = (Some(at), now.before(silence));
        }
        self.take_values(recorder, &station.diagnosis_octets, station.knowledge.inputs(), self.exchange.1, now);
    }

    /// Another device or other modules than the station's file says.
    fn contradiction(&self, knowledge: &Knowledge) -> Option<String> {
        if let Some(ident) = knowledge.ident().filter(|ident| *ident != self.config.gsd.ident()) {
            return Some(other_device(ident, &self.config));
        }
        let heard = knowledge.heard_configuration();
        (!heard.is_empty() && heard != self.config.gsd.chk_cfg()).then(|| other_modules(heard, &self.config))
    }

    /// Notes that nothing was heard on a line on which the station only listens.
    pub fn note_silence(&mut self, recorder: &RecorderHandle, problem: &str, now: Moment) {
        if !self.is_heard && self.sample_at <= now.at {
            self.sample_at = now.at + self.config.poll.min(MAX_SILENCE);
            self.lose(recorder, BusStationState::Missing, Some(problem.to_owned()), now);
        }
    }

    /// Takes the answer to a request: adds a slave of the station to the master with its outputs, takes the inputs of another one, or notes
    /// the problem.
    pub fn take_answer(
        &mut self,
        recorder: &RecorderHandle,
        master: &mut BusMaster,
        line: LineMoment,
        answer: Result<Answer, String>,
    ) {
        let taken = answer.and_then(|answer| match answer {
            Answer::Present => self.add(master, line),
            Answer::Inputs { inputs, diagnosis } => {
                if diagnosis.is_some() {
                    self.verify_at = line.now.at + VERIFY_INTERVAL;
                }
                let diagnosis = diagnosis.unwrap_or_else(|| self.diagnosis.clone());
                self.take_values(recorder, &diagnosis, &inputs, line.now, line.now);
                Ok(())
            }
        });
        match taken {
            Ok(()) if self.config.is_owned => self.lose(recorder, BusStationState::Starting, None, line.now),
            Ok(()) => {}
            Err(problem) => self.lose(recorder, BusStationState::Missing, Some(problem), line.now),
        }
    }

    /// Adds the slave to the master. Its outputs are set before the first exchange.
    fn add(&mut self, master: &mut BusMaster, line: LineMoment) -> Result<(), String> {
        let parameters = self.config.gsd.parameters(self.config.address, line.baud);
        add_or_restart(master, &parameters).map_err(|error| error.to_string())?;
        let outputs = master.outputs_mut(self.config.address).unwrap_or_default();
        if outputs.len() != self.config.outputs.len() {
            master.remove(self.config.address);
            return Err("its outputs have another length than the station's file".to_owned());
        }
        outputs.copy_from_slice(&self.config.outputs);
        (self.is_added, self.exchange, self.sample_at) = (true, (None, line.now), line.now.at);
        Ok(())
    }

    /// Ends the values because the port is lost or the segment stops.
    pub fn disconnect(&mut self, problem: &str, now: Moment) {
        (self.is_added, self.is_heard, self.search_at, self.sample_at) = (false, false, now.at, now.at);
        self.end(BusStationState::Missing, now);
        self.problem = Some(problem.to_owned());
    }

    /// Takes the inputs of an exchange, and the last diagnosis; empty octets if there is none.
    fn take_values(&mut self, recorder: &RecorderHandle, diagnosis: &[u8], inputs: &[u8], read: Moment, now: Moment) {
        let diag = SlaveDiag::parse(diagnosis).ok().filter(|diag| diag.ident == self.config.gsd.ident());
        if let Some(problem) = self.unusable(inputs, diag.as_ref()) {
            return self.lose(recorder, BusStationState::Missing, Some(problem), now);
        }
        if let Some(diag) = diag.filter(|_| self.diagnosis != diagnosis) {
            self.diagnosis = diagnosis.to_vec();
            self.reports = reports(&self.config, &diag);
            self.has_fault = diag.status.contains(StationStatus::EXT_DIAG);
        }
        self.tell_diagnosis(recorder, now);
        self.note_problem(recorder, None, now);
        self.state = if self.has_fault { BusStationState::Fault } else { BusStationState::DataExchange };
        self.lost_at = None;
        if self.read.replace(read) != Some(read) {
            let values = self.config.points.iter().map(|point| {
                let config::PointValue { number, text, quality } = point.value(inputs);
                WatchedParameter { number, text, quality, read_at: Some(read.wall), ..planned_point(point) }
            });
            self.points = values.collect();
            self.tell_changes(recorder, now);
        }
    }

    /// Why the inputs are no values.
    fn unusable(&self, inputs: &[u8], diag: Option<&SlaveDiag<'_>>) -> Option<String> {
        if inputs.len() != self.config.inputs() {
            let (found, expected) = (inputs.len(), self.config.inputs());
            return Some(format!(
                "its inputs have {found} octets, the modules in the station's file {expected}: compare modules with the configuration \
                 of its master"
            ));
        }
        // profibus-wire 2.3
        let diag = diag.filter(|diag| diag.status.contains(StationStatus::STAT_DIAG))?;
        let texts: String = reports(&self.config, diag).iter().map(|text| format!(": {text}")).collect();
        Some(format!("it reports that its inputs are not valid (Stat_Diag){texts}"))
    }

    /// Records an event for each point with texts that has another one: the state of a pump, the limit switch of a valve.
    fn tell_changes(&mut self, recorder: &RecorderHandle, now: Moment) {
        let points = self.config.points.iter().zip(self.points.iter()).zip(&mut self.told);
        for ((settings, point), told) in points {
            if !settings.has_texts() || point.quality != Quality::Valid {
                continue;
            }
            let text = point.text_without_remark();
            let is_known = told
                .as_ref()
                .is_some_and(|(told, at)| told == text || now.at.saturating_duration_since(*at) < TOLD_INTERVAL);
            if is_known {
                continue;
            }
            if told.replace((text.to_owned(), now.at)).is_some() {
                let text = format!("{}: {} is {text}", self.config.name, point.target);
                recorder.event_at(now.wall, Some(&self.config.name), EventKind::Gauge, text);
            }
        }
    }

    /// Records an event if the diagnosis has other texts than the last event.
    fn tell_diagnosis(&mut self, recorder: &RecorderHandle, now: Moment) {
        if self.told_reports == self.reports || !self.allowance.take(now.at) {
            return;
        }
        let sentence = if self.reports.is_empty() { "no diagnosis".to_owned() } else { self.reports.join(", ") };
        let text = format!("{}: {sentence}", self.config.name);
        recorder.event_at(now.wall, Some(&self.config.name), EventKind::Gauge, text);
        self.told_reports.clone_from(&self.reports);
    }

    /// The slave gives no values: `state` and `problem` say why.
    fn lose(&mut self, recorder: &RecorderHandle, state: BusStationState, problem: Option<String>, now: Moment) {
        self.end(state, now);
        if problem.is_some() {
            self.note_problem(recorder, problem, now);
        }
    }

    fn end(&mut self, state: BusStationState, now: Moment) {
        if self.lost_at.is_none() || self.state != state {
            self.lost_at = Some(now.wall);
        }
        self.state = state;
        if self.points.iter().any(|point| point.quality != Quality::Stale) {
            self.points = planned_points(&self.config).into();
        }
        self.reports.clear();
        self.told_reports.clear();
        self.diagnosis.clear();
        self.has_fault = false;
    }

    /// Sets the problem, and records an event if it is another one than before.
    fn note_problem(&mut self, recorder: &RecorderHandle, problem: Option<String>, now: Moment) {
        if self.problem != problem || (problem.is_none() && !self.has_values()) {
            let sentence = problem.as_deref().unwrap_or("in data exchange");
            let text = format!("{}: {sentence}", self.config.name);
            recorder.event_at(now.wall, Some(&self.config.name), EventKind::Bus, text);
            self.problem = problem;
        }
    }

    /// The slave as a station on the bus.
    pub fn bus_station(&self) -> view::BusStation {
        let description = match (&self.problem, self.state) {
            (Some(problem), _) => problem.clone(),
            (None, BusStationState::DataExchange) if self.config.is_owned => "in data exchange".to_owned(),
            (None, BusStationState::DataExchange) => "in data exchange with another master".to_owned(),
            (None, BusStationState::Fault) => view::fault_text(&self.reports, &[]),
            (None, _) => "is being brought into data exchange".to_owned(),
        };
        view::BusStation {
            address: self.config.address,
            state: self.state,
            name: Some(self.config.name.clone()),
            device: Some(self.config.model()),
            ident: Some(format!("0x{:04X}", self.config.gsd.ident())),
            description,
        }
    }

    /// The slave as the API shows it.
    pub fn view_at(&self, segment: &str, now: Moment) -> view::Gauge {
        let (exceptions, warnings) =
            if self.has_fault { (self.reports.clone(), Vec::new()) } else { (Vec::new(), self.reports.clone()) };
        view::Gauge {
            listen_only: !self.config.is_owned,
            state: self.state,
            problem: self.problem.clone(),
            exceptions,
            warnings,
            parameters: Arc::clone(&self.points),
            age_ms: self.read.map(|read| view::duration_ms(now.since(read))),
            read_at: self.read.map(|read| read.wall),
            lost_at: self.lost_at,
            ..planned_slave(&self.config, segment)
        }
    }
}

/// The slave that is searched or read next: the one that has waited longest. On a slow line a request takes longer than `poll`, and in
/// the order of the file the first slave would take all turns. Sets the time of its next turn.
pub fn next_request(slaves: &mut [SegmentSlave], now: Moment) -> Option<&mut SegmentSlave> {
    let due = slaves.iter_mut().filter_map(|slave| Some((slave.request_due()?, slave)));
    let (_, slave) = due.filter(|(due, _)| *due <= now.at).min_by_key(|(due, _)| *due)?;
    slave.request_begins(now);
    Some(slave)
}

/// What a slave answered.
pub enum Answer {
    /// It is the device of the GSD file, and no other master owns it.
    Present,
    /// It is the device of the GSD file with the modules of the station's file, and gave its inputs.
    Inputs {
        /// The inputs.
        inputs: Vec<u8>,
        /// Its diagnosis; empty without an answer, `None` if the slave was not verified again.
        diagnosis: Option<Vec<u8>>,
    },
}

/// Searches a slave that the station owns, or reads the inputs of another one with RD_Inp; unless it `is_verified`, asks for its ident
/// number, its modules and its diagnosis first. The inner result has the problem of the slave, in a sentence.
///
/// # Errors
/// When the port is lost.
pub fn ask(
    session: &mut BusSession,
    slave: &config::Slave,
    master: u8,
    is_verified: bool,
) -> Result<Result<Answer, String>, PortError> {
    let answer = if slave.is_owned { search(session, slave, master) } else { read_inputs(session, slave, is_verified) };
    match answer {
        Err(SessionError::Port(error)) => Err(error),
        Err(error) => Ok(Err(error.to_string())),
        Ok(answer) => Ok(answer),
    }
}

fn search(session: &mut BusSession, slave: &config::Slave, master: u8) -> Result<Result<Answer, String>, SessionError> {
    let owner = present(session, slave)?;
    Ok(owner.and_then(|owner| match owner.filter(|owner| *owner != master) {
        Some(owner) => Err(format!("master {owner} owns it: with own = false the station reads it without ownership")),
        None => Ok(Answer::Present),
    }))
}

/// The owner of the slave, if it answers and is the device of the GSD file.
fn present(session: &mut BusSession, slave: &config::Slave) -> Result<Result<Option<u8>, String>, SessionError> {
    let status = scan::probe(session, slave.address)?.and_then(|station| station.slave);
    Ok(match status {
        None => Err("no slave answers".to_owned()),
        Some(status) if status.ident != slave.gsd.ident() => Err(other_device(status.ident, slave)),
        Some(status) => Ok(status.owner),
    })
}

fn read_inputs(
    session: &mut BusSession,
    slave: &config::Slave,
    is_verified: bool,
) -> Result<Result<Answer, String>, SessionError> {
    let diagnosis = if is_verified {
        None
    } else {
        match verify(session, slave)? {
            Ok(diagnosis) => Some(diagnosis),
            Err(problem) => return Ok(Err(problem)),
        }
    };
    let Reply::Answer { status, du, .. } = session.request(&services::rd_inp(slave.address))? else {
        return Ok(Err("no slave answers".to_owned()));
    };
    Ok(match status {
        Status::DataLow | Status::DataHigh => Ok(Answer::Inputs { inputs: du, diagnosis }),
        // A slave without inputs.
        Status::NoReply => Ok(Answer::Inputs { inputs: Vec::new(), diagnosis }),
        Status::ServiceNotActivated => {
            Err("it is in data exchange with no master: with own = true the station exchanges data with it".to_owned())
        }
        status => Err(format!("expected inputs as the answer to RD_Inp, got the status {status:?}")),
    })
}

/// The diagnosis of the slave, if it is the device of the GSD file and Get_Cfg gives the modules of the station's file. A slave that refuses
/// Get_Cfg is believed. chosen: its inputs have the right length.
fn verify(session: &mut BusSession, slave: &config::Slave) -> Result<Result<Vec<u8>, String>, SessionError> {
    if let Err(problem) = present(session, slave)? {
        return Ok(Err(problem));
    }
    let Reply::Answer { status, du: modules, .. } = session.request(&services::get_cfg(slave.address))? else {
        return Ok(Err("no slave answers".to_owned()));
    };
    if matches!(status, Status::DataLow | Status::DataHigh) && modules != slave.gsd.chk_cfg() {
        return Ok(Err(other_modules(&modules, slave)));
    }
    Ok(Ok(match session.request(&services::slave_diag(slave.address))? {
        Reply::Answer { du, .. } => du,
        Reply::NoAnswer(_) => Vec::new(),
    }))
}

fn other_modules(octets: &[u8], slave: &config::Slave) -> String {
    let (found, expected) = (Hex(octets), Hex(slave.gsd.chk_cfg()));
    format!("its master configures it with {found}, the modules in the station's file give {expected}: correct modules")
}

fn octets_of(diag: &SlaveDiag<'_>) -> Vec<u8> {
    let mut octets = vec![0; diag.ext_diag.len().saturating_add(6)];
    let length = diag.emit(&mut octets).unwrap_or_default();
    octets.truncate(length);
    octets
}

fn other_device(ident: u16, slave: &config::Slave) -> String {
    format!(
        "it has the ident number 0x{ident:04X}, the GSD file of the station's file 0x{:04X}: another device has the address",
        slave.gsd.ident()
    )
}

fn planned_point(point: &config::SlavePoint) -> WatchedParameter {
    WatchedParameter {
        target: point.name.clone(),
        name: point.place.clone(),
        unit: point.unit,
        number: None,
        text: String::new(),
        quality: Quality::Stale,
        read_at: None,
    }
}

fn planned_points(slave: &config::Slave) -> Vec<WatchedParameter> {
    slave.points.iter().map(planned_point).collect()
}

/// A slave of the station's file before anything was heard of it: with its points, without their values.
#[must_use]
pub fn planned_slave(config: &config::Slave, segment: &str) -> view::Gauge {
    view::Gauge {
        name: config.name.clone(),
        kind: GaugeKind::Slave,
        segment: segment.to_owned(),
        address: config.address,
        device: config.model(),
        has_dpv1: false,
        listen_only: !config.is_owned,
        assumptions: Vec::new(),
        state: BusStationState::Missing,
        problem: None,
        exceptions: Vec::new(),
        warnings: Vec::new(),
        gas: String::new(),
        levels: Vec::new(),
        readings: Vec::new(),
        parameters: planned_points(config).into(),
        age_ms: None,
        read_at: None,
        lost_at: None,
        poll_ms: view::duration_ms(config.poll),
        stale_after_ms: validity::stale_after_ms(view::duration_ms(config.poll)),
    }
}
