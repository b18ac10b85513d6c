//! A slave by its GSD file: in data exchange with the station's master, or read without ownership.
//!
//! The station owns a slave only if its file says so. All others are heard on the line while another master exchanges data with them;
//! on a segment with a master of the station, RD_Inp reads those that are not heard.

mod events;
mod mismatch;
mod points;
mod question;
mod record;
mod shown;

pub use question::{Answer, Question, ask};
pub use record::next_record;
pub use shown::planned_slave;

use super::allowance::Allowance;
use super::first_round::FirstRound;
use super::loss::{self, Looked};
use super::moment::{LineMoment, Moment};
use crate::config;
use crate::recording::RecorderHandle;
use crate::view::{BusStationState, WatchedParameter};
use mismatch::{other_device, other_modules, other_plugged};
use points::{planned_points, valued_point};
use profivac_dp::link::BitTime;
use profivac_dp::master::ExchangeError;
use profivac_explain::dpv1::DeviceBlocks;
use profivac_explain::gsd::Described;
use profivac_host::clock::duration_of;
use profivac_host::session::{BusMaster, add_or_restart};
use profivac_listen::Observer;
use profivac_listen::gauge::Knowledge;
use profivac_recorder::validity::MAX_SILENCE;
use profivac_recorder::{Micros, Point, PointSample, Quality};
use profivac_wire::diag::{SlaveDiag, StationStatus};
use record::{Record, records};
use std::sync::Arc;
use std::time::{Duration, Instant};

/// The time between two searches for a slave that gives no data. chosen: as for gauges.
const SEARCH_INTERVAL: Duration = Duration::from_secs(3);

/// The time after which a slave that is read with RD_Inp is asked again for its modules and its diagnosis. chosen: its master may give it
/// other modules between two requests, and each check takes four requests.
const VERIFY_INTERVAL: Duration = Duration::from_secs(10);

/// The shortest time between two questions to a slave that exchanges data with no master. chosen: the values of its records would be too old
/// after [`SEARCH_INTERVAL`].
const IDLE_INTERVAL: Duration = Duration::from_secs(1);

/// The modules that an owned slave has according to Get_Cfg. The station asks for them once after each refusal.
#[derive(PartialEq, Eq)]
enum Plugged {
    /// The slave has not refused its parameters or its configuration.
    Unasked,
    /// It has, and is to be asked.
    Wanted,
    /// How they differ from those in the station's file; `None` if they do not, or if the slave did not answer.
    Known(Option<String>),
}

/// A slave of the station's file.
pub struct SegmentSlave {
    /// The configuration.
    pub config: config::Slave,
    /// The slave in the words of its GSD file.
    described: Described,
    state: BusStationState,
    problem: Option<String>,
    /// Its last diagnosis: the octets, its texts, and whether it is a fault.
    diagnosis: Vec<u8>,
    reports: Vec<String>,
    has_fault: bool,
    /// The texts of the last event about the diagnosis, and how many of them may follow.
    told_reports: Vec<String>,
    diagnosis_events: Allowance,
    /// How many events about loss and return may follow.
    problem_events: Allowance,
    /// The modules of an owned slave that refuses its parameters or its configuration.
    plugged: Plugged,
    /// The points. Views share them: a view is made ten times a second.
    points: Arc<[WatchedParameter]>,
    /// The points as the recorder knows them, in the same order.
    series: Vec<Arc<Point>>,
    /// The text of each point with texts, as the last event says it, and when.
    told: Vec<Option<(String, Instant)>>,
    /// The records of points, of a slave that the station does not own.
    records: Vec<Record>,
    /// The last data exchange on the line and on the clocks of the station.
    exchange: (Option<BitTime>, Moment),
    first_round: FirstRound,
    looked: Looked,
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
    /// It exchanges data with no master, and its records are read: all its points are there.
    is_idle: bool,
}

impl SegmentSlave {
    /// A slave of which nothing is known yet.
    pub fn new(config: config::Slave, now: Moment) -> Self {
        Self {
            points: planned_points(&config).into(),
            series: config.points.iter().map(|point| Arc::new(point.recorded(&config.name))).collect(),
            told: vec![None; config.points.len()],
            records: records(&config, now.at),
            described: Described::chosen(config.gsd.file(), &config.gsd.configuration()),
            config,
            state: BusStationState::Missing,
            problem: None,
            diagnosis: Vec::new(),
            reports: Vec::new(),
            has_fault: false,
            told_reports: Vec::new(),
            diagnosis_events: Allowance::new(now.at),
            problem_events: Allowance::new(now.at),
            plugged: Plugged::Unasked,
            exchange: (None, now),
            first_round: FirstRound::begin(now),
            looked: Looked::begin(now),
            read: None,
            lost_at: Some(now.wall),
            sample_at: now.at,
            search_at: now.at,
            verify_at: now.at,
            is_added: false,
            is_heard: false,
            is_idle: false,
        }
    }

    /// The same slave, without values since this time.
    pub fn lost_since(self, at: Micros) -> Self {
        Self { lost_at: Some(at), ..self }
    }

    /// The port was opened: the slave is not missed until it was asked.
    pub fn port_opened(&mut self, now: Moment) {
        self.first_round.port_opened(now);
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
        if self.plugged == Plugged::Wanted {
            return Some(self.search_at);
        }
        let is_asked = if self.config.is_owned { !self.is_added } else { !self.is_heard };
        is_asked.then(|| self.due())
    }

    /// The question of its next request.
    pub fn question(&self, now: Moment) -> Question {
        match self.config.is_owned {
            true if self.plugged == Plugged::Wanted => Question::Modules,
            true => Question::Search,
            false => Question::Inputs { is_verified: self.is_verified(now) },
        }
    }

    fn request_begins(&mut self, now: Moment) {
        self.search_at = now.at + SEARCH_INTERVAL;
        self.sample_at = now.at + self.config.poll;
    }

    /// Whether it gives values now.
    pub const fn has_values(&self) -> bool {
        matches!(self.state, BusStationState::DataExchange | BusStationState::Fault)
    }

    /// Whether its records may be read: it was asked lately and is the device of the station's file. Another device may have its address
    /// otherwise.
    const fn gives_records(&self) -> bool {
        self.has_values() || self.is_idle
    }

    /// Whether RD_Inp may be believed: the slave was asked lately and is the device of the station's file, with its modules.
    fn is_verified(&self, now: Moment) -> bool {
        self.has_values() && now.at < self.verify_at
    }

    /// Takes the present inputs of a slave that the station owns, if its time has come.
    pub fn sample_owned(&mut self, recorder: &RecorderHandle, master: &mut BusMaster, line: LineMoment) {
        let now = line.now;
        let has_looked = self.looked.looks(now);
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
                self.plugged = Plugged::Unasked;
                let diagnosis = master.diagnosis(address).map(|diag| octets_of(&diag)).unwrap_or_default();
                self.take_values(recorder, &diagnosis, inputs, read, now);
            }
            None => {
                let is_silent = has_looked && is_exchanging.is_some() && now.since(read) >= MAX_SILENCE;
                let problem = loss::reason(master, address, is_silent).map(|error| self.refusal(error));
                if problem.is_some() {
                    self.first_round.end();
                }
                let state = if problem.is_some() { BusStationState::Missing } else { BusStationState::Starting };
                self.lose(recorder, state, problem, now);
                // It may have values soon, however seldom it is sampled.
                self.sample_at = self.sample_at.min(now.at + MAX_SILENCE);
            }
        }
    }

    /// An error of the data exchange in words. The modules of a slave that refuses its parameters or its configuration belong to it.
    fn refusal(&mut self, error: ExchangeError) -> String {
        let is_refusal = matches!(error, ExchangeError::PrmFault | ExchangeError::CfgFault);
        match &self.plugged {
            // Without power, or with another owner, it may get other modules.
            _ if !is_refusal => self.plugged = Plugged::Unasked,
            Plugged::Unasked => self.plugged = Plugged::Wanted,
            Plugged::Known(Some(difference)) => return format!("{error}: {difference}"),
            Plugged::Wanted | Plugged::Known(None) => {}
        }
        error.to_string()
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

    /// Takes the answer to a request: adds a slave of the station to the master with its outputs, takes its modules, takes the inputs of
    /// another one, or notes the problem.
    pub fn take_answer(
        &mut self,
        recorder: &RecorderHandle,
        master: &mut BusMaster,
        line: LineMoment,
        answer: Result<Answer, String>,
    ) {
        let taken = answer.and_then(|answer| match answer {
            Answer::Present => {
                self.add(master, line)?;
                self.lose(recorder, BusStationState::Starting, None, line.now);
                Ok(())
            }
            Answer::Modules(octets) => {
                let is_other = !octets.is_empty() && octets != self.config.gsd.chk_cfg();
                self.plugged = Plugged::Known(is_other.then(|| other_plugged(&octets, &self.config)));
                Ok(())
            }
            Answer::Idle => self.take_idle(recorder, line.now),
            Answer::Inputs { inputs, diagnosis } => {
                if diagnosis.is_some() {
                    self.verify_at = line.now.at + VERIFY_INTERVAL;
                }
                let diagnosis = diagnosis.unwrap_or_else(|| self.diagnosis.clone());
                self.take_values(recorder, &diagnosis, &inputs, line.now, line.now);
                Ok(())
            }
        });
        if let Err(problem) = taken {
            self.first_round.end();
            self.lose(recorder, BusStationState::Missing, Some(problem), line.now);
        }
    }

    /// Takes that the slave exchanges data with no master: its inputs are no values. MS2 needs no data exchange (profibus-wire 4.6), so a slave
    /// whose points are all in records gives values. chosen: the points of other slaves are stale together, as an alarm reports them.
    fn take_idle(&mut self, recorder: &RecorderHandle, now: Moment) -> Result<(), String> {
        if self.records.is_empty() || self.config.points.iter().any(|point| point.record.is_none()) {
            let problem = "no master exchanges data with it: with own = true the station does";
            return Err(problem.to_owned());
        }
        self.forget_diagnosis();
        (self.is_idle, self.state) = (true, BusStationState::Missing);
        // A slave that refuses all its records gives nothing.
        if self.records.iter().any(Record::is_answered) {
            (self.read, self.lost_at) = (Some(now), None);
        }
        self.search_at = now.at + self.config.poll.max(IDLE_INTERVAL);
        let problem = "no master exchanges data with it: its records are read";
        self.note_problem(recorder, Some(problem.to_owned()), now);
        Ok(())
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
    pub fn disconnect(&mut self, recorder: &RecorderHandle, problem: &str, now: Moment) {
        (self.is_added, self.is_heard, self.search_at, self.sample_at) = (false, false, now.at, now.at);
        self.plugged = Plugged::Unasked;
        self.end(recorder, BusStationState::Missing, now);
        self.problem = Some(problem.to_owned());
    }

    /// Takes the inputs of an exchange, and the last diagnosis; empty octets if there is none.
    fn take_values(&mut self, recorder: &RecorderHandle, diagnosis: &[u8], inputs: &[u8], read: Moment, now: Moment) {
        self.first_round.end();
        let diag = SlaveDiag::parse(diagnosis).ok().filter(|diag| diag.ident == self.config.gsd.ident());
        if let Some(problem) = self.unusable(inputs, diag.as_ref()) {
            return self.lose(recorder, BusStationState::Missing, Some(problem), now);
        }
        if let Some(diag) = diag.filter(|_| self.diagnosis != diagnosis) {
            self.diagnosis = diagnosis.to_vec();
            let reports = self.conditions(&diag);
            if self.reports != reports {
                self.diagnosis_events.changed();
            }
            self.reports = reports;
            self.has_fault = diag.status.contains(StationStatus::EXT_DIAG);
        }
        self.tell_diagnosis(recorder, now);
        self.note_problem(recorder, None, now);
        self.state = if self.has_fault { BusStationState::Fault } else { BusStationState::DataExchange };
        (self.is_idle, self.lost_at) = (false, None);
        if self.read.replace(read) != Some(read) {
            let values = self.config.points.iter().zip(self.points.iter()).map(|(point, present)| match point.record {
                Some(_) => present.clone(),
                None => valued_point(point, inputs, read),
            });
            self.points = values.collect();
            self.record(recorder, read.wall, |point| point.record.is_none());
            self.tell_changes(recorder, now);
        }
    }

    /// Records the values of these points, with the time of their data exchange or of the answer to their record.
    fn record(&self, recorder: &RecorderHandle, at: Micros, of: impl Fn(&config::SlavePoint) -> bool) {
        for ((settings, point), series) in self.config.points.iter().zip(self.points.iter()).zip(&self.series) {
            if !of(settings) {
                continue;
            }
            recorder.push_point(series, settings.deadband, PointSample::new(at, point.number, point.quality));
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
        let texts: String = self.conditions(diag).iter().map(|text| format!("; {text}")).collect();
        Some(format!("it reports that its inputs are not valid (Stat_Diag){texts}"))
    }

    /// What the extended diagnosis reports, in the words of the GSD file.
    fn conditions(&self, diag: &SlaveDiag<'_>) -> Vec<String> {
        let blocks = if self.config.gsd.is_dpv1() { DeviceBlocks::Messages } else { DeviceBlocks::Vendor };
        self.described.conditions(diag.ext_diag, blocks)
    }

    /// The slave gives no values: `state` and `problem` say why.
    fn lose(&mut self, recorder: &RecorderHandle, state: BusStationState, problem: Option<String>, now: Moment) {
        self.end(recorder, state, now);
        if problem.is_some() {
            self.note_problem(recorder, problem, now);
        }
    }

    /// Ends the values, with a gap in their record.
    fn end(&mut self, recorder: &RecorderHandle, state: BusStationState, now: Moment) {
        if self.lost_at.is_none() || self.state != state {
            self.lost_at = Some(now.wall);
        }
        (self.is_idle, self.state) = (false, state);
        if self.points.iter().any(|point| point.quality != Quality::Stale) {
            self.series.iter().for_each(|series| recorder.push_point(series, 0.0, PointSample::gap(now.wall)));
            self.points = planned_points(&self.config).into();
        }
        self.records.iter_mut().for_each(|record| record.restart(now.at));
        self.forget_diagnosis();
    }

    fn forget_diagnosis(&mut self) {
        self.reports.clear();
        self.told_reports.clear();
        self.diagnosis.clear();
        self.has_fault = false;
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

fn octets_of(diag: &SlaveDiag<'_>) -> Vec<u8> {
    let mut octets = vec![0; diag.ext_diag.len().saturating_add(6)];
    let length = diag.emit(&mut octets).unwrap_or_default();
    octets.truncate(length);
    octets
}
