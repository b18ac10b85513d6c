//! The thread of a segment.

use super::bus_map::{BusState, own_master};
use super::find::{FindError, find_gauge};
use super::gauge_session::{GaugeSession, next_defects, next_search};
use super::inbox::{Inbox, PortLost};
use super::line_observer::LineObserver;
use super::records::{defects_of, records_of};
use super::services::SegmentServices;
use super::watched;
use crate::config;
use crate::control::error::Unavailable;
use crate::snapshot::SegmentSnapshot;
use crate::view::{BusStation, Segment};
use profivac_client::cyclic::CyclicSlave;
use profivac_client::names::NamedParameter;
use profivac_dp::link::BitTime;
use profivac_dp::master::Mode;
use profivac_host::clock::tbit_of;
use profivac_host::port::{Character, Port, PortError, Recorded, RecordedChunk, Recording};
use profivac_host::session::{BusMaster, BusSession, SessionError, UnrestoredRecord, bus_parameters};
use profivac_listen::Chunk;
use profivac_recorder::EventKind;
use profivac_virtual::open;
use std::collections::BTreeMap;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{Receiver, TryRecvError};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

/// The longest that the master waits for a line in use, and for a slow gauge. It serves the bus while it waits.
const TIMEOUT: Duration = Duration::from_secs(5);

/// The longest time without a look at commands and clock.
const SERVE_INTERVAL: Duration = Duration::from_millis(50);

/// The time between two snapshots.
const PUBLISH_INTERVAL: Duration = Duration::from_millis(100);

/// The longest wait for slaves to leave data exchange.
const RELEASE_TIMEOUT: Duration = Duration::from_secs(1);

/// The first pause before a port is opened again; each further pause is twice as long.
const FIRST_PAUSE: Duration = Duration::from_millis(500);

/// The longest pause before a port is opened again.
const LONGEST_PAUSE: Duration = Duration::from_secs(30);

/// A command to the thread.
pub enum SegmentCommand {
    /// These are the gauges from now on.
    Gauges(Vec<config::Gauge>),
    /// Release the slaves and stop.
    Stop,
}

/// The reason why the thread does not serve the bus any more.
enum ServeEnd {
    /// The station has stopped the segment.
    Stopped,
    /// The port was lost.
    Lost(SessionError),
}

impl From<SessionError> for ServeEnd {
    fn from(error: SessionError) -> Self {
        Self::Lost(error)
    }
}

impl From<PortError> for ServeEnd {
    fn from(error: PortError) -> Self {
        Self::Lost(error.into())
    }
}

/// What the thread of a segment starts with.
pub struct ThreadSetup {
    pub config: config::Segment,
    pub services: SegmentServices,
    pub commands: Receiver<SegmentCommand>,
    /// The thread did not stop in time, and must not publish any more.
    pub is_abandoned: Arc<AtomicBool>,
}

/// The state of the thread.
pub struct SegmentThread {
    config: config::Segment,
    services: SegmentServices,
    commands: Receiver<SegmentCommand>,
    inbox: Inbox,
    gauges: Arc<Mutex<Vec<GaugeSession>>>,
    is_abandoned: Arc<AtomicBool>,
    /// The records that the last session could not restore, by address.
    unrestored: BTreeMap<u8, UnrestoredRecord>,
    /// The reason why the port is not open.
    problem: Option<String>,
    publish_at: Instant,
    /// When the next parameter may be read for gateways.
    watch_at: Instant,
    /// What this station and the others send, for the statistics of the line.
    recording: Recording,
    line: LineObserver,
}

impl SegmentThread {
    pub fn new(ThreadSetup { config, services, commands, is_abandoned }: ThreadSetup) -> Self {
        let inbox = Inbox::new(services.control.requests().accept(&config.name));
        let gauges = Arc::new(Mutex::new(config.gauges.iter().cloned().map(GaugeSession::new).collect()));
        let publish_at = Instant::now();
        let unrestored = BTreeMap::new();
        let line = LineObserver::new(&config, config.baud, &services.recorder.captures());
        let (problem, recording) = (None, Recording::begin());
        Self {
            config,
            services,
            commands,
            inbox,
            gauges,
            is_abandoned,
            unrestored,
            problem,
            publish_at,
            watch_at: publish_at,
            recording,
            line,
        }
    }

    /// The gauges. Not to be held during a request: the background task samples them meanwhile.
    fn gauges(&self) -> MutexGuard<'_, Vec<GaugeSession>> {
        self.gauges.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Runs until the station stops it.
    pub fn run(mut self) {
        let mut pause = FIRST_PAUSE;
        loop {
            let ended = match self.open() {
                Ok(mut session) => {
                    pause = FIRST_PAUSE;
                    self.port_opened();
                    for (address, record) in std::mem::take(&mut self.unrestored) {
                        session.keep_unrestored(address, record);
                    }
                    let ended = self.serve(&mut session);
                    // A selector that was moved when the port was lost is restored once the port is open again.
                    self.unrestored = session.take_all_unrestored();
                    ended
                }
                Err(error) => ServeEnd::Lost(error),
            };
            match ended {
                ServeEnd::Stopped => break,
                ServeEnd::Lost(error) => self.port_lost(&error),
            }
            if self.pause(pause) {
                break;
            }
            pause = pause.saturating_mul(2).min(LONGEST_PAUSE);
        }
    }

    fn open(&self) -> Result<BusSession, SessionError> {
        let config::Segment { port, baud, master, .. } = &self.config;
        let port: Box<dyn Port> = Box::new(Recorded::new(open::port(port, *baud)?, self.recording.clone()));
        let bus = bus_parameters(*master, *baud, port.delivery());
        let mut session = BusSession::new(port, *baud, bus, TIMEOUT)?;
        session.master().set_mode(Mode::Operate);
        session.set_background_task(self.background_task());
        Ok(session)
    }

    /// Samples and publishes the gauges while a request takes long.
    fn background_task(&self) -> impl FnMut(&mut BusMaster) + Send + use<> {
        let (gauges, services) = (Arc::clone(&self.gauges), self.services.clone());
        let (is_abandoned, name) = (Arc::clone(&self.is_abandoned), self.config.name.clone());
        let mut publish_at = Instant::now();
        move |master| {
            let Ok(mut gauges) = gauges.try_lock() else { return };
            let now = Instant::now();
            gauges.iter_mut().for_each(|gauge| gauge.sample(&services.recorder, master, now));
            if now >= publish_at && !is_abandoned.load(Ordering::Relaxed) {
                publish_at = now + PUBLISH_INTERVAL;
                services.snapshots.publish_gauges(&name, gauges.iter().map(|gauge| gauge.view(&name)).collect());
            }
        }
    }

    fn port_opened(&mut self) {
        self.problem = None;
        let text = format!("segment {}: {} is open", self.config.name, self.config.port);
        self.services.recorder.event_now(None, EventKind::Bus, text);
    }

    fn port_lost(&mut self, error: &SessionError) {
        let problem = error.to_string();
        self.gauges().iter_mut().for_each(|gauge| gauge.disconnect(&self.services.recorder, &problem));
        if self.problem.as_ref() != Some(&problem) {
            let text = format!("segment {}: {problem}", self.config.name);
            self.services.recorder.event_now(None, EventKind::Bus, text);
            self.problem = Some(problem);
        }
        self.publish(None);
    }

    /// Waits before the port is opened again. Returns whether to stop.
    fn pause(&mut self, pause: Duration) -> bool {
        let end = Instant::now() + pause;
        loop {
            let problem = self.problem.as_deref().unwrap_or("the segment does not run");
            self.inbox.refuse_all(&self.services, problem);
            let left = end.saturating_duration_since(Instant::now());
            match self.commands.recv_timeout(left.min(SERVE_INTERVAL)) {
                Ok(SegmentCommand::Stop) => return true,
                Ok(SegmentCommand::Gauges(gauges)) => self.reconfigure(gauges, None),
                Err(_) if left.is_zero() => return false,
                Err(_) => {}
            }
            if Instant::now() >= self.publish_at {
                self.publish(None);
            }
        }
    }

    /// Serves the bus until the port is lost or the segment stops.
    fn serve(&mut self, session: &mut BusSession) -> ServeEnd {
        let ended = loop {
            if let Err(ended) = self.serve_once(session) {
                break ended;
            }
        };
        if matches!(ended, ServeEnd::Stopped) {
            self.release_slaves(session);
        }
        ended
    }

    fn serve_once(&mut self, session: &mut BusSession) -> Result<(), ServeEnd> {
        match self.commands.try_recv() {
            Ok(SegmentCommand::Stop) | Err(TryRecvError::Disconnected) => return Err(ServeEnd::Stopped),
            Ok(SegmentCommand::Gauges(gauges)) => self.reconfigure(gauges, Some(&mut *session)),
            Err(TryRecvError::Empty) => {}
        }
        let due = self.gauges().iter().map(GaugeSession::due).min().unwrap_or_else(|| Instant::now() + SERVE_INTERVAL);
        session.serve(&[], due.saturating_duration_since(Instant::now()).min(SERVE_INTERVAL))?;
        while let Some(notice) = session.next_notice() {
            let text = format!("segment {}: {notice}", self.config.name);
            self.services.recorder.event_now(None, EventKind::Bus, text);
        }
        self.observe_line();
        self.search_next(session)?;
        let now = Instant::now();
        self.gauges().iter_mut().for_each(|gauge| gauge.sample(&self.services.recorder, session.master(), now));
        self.name_defects(session);
        self.read_watched(session);
        if Instant::now() >= self.publish_at {
            self.publish(Some(&mut *session));
        }
        self.answer_next(session)
    }

    /// Gives the observer of the line what was sent and received since the last call.
    fn observe_line(&mut self) {
        let baud = self.config.baud;
        for RecordedChunk { at, characters, .. } in self.recording.take() {
            let octet = |character: &Character| if let Character::Octet(octet) = character { *octet } else { 0 };
            let errors = characters.iter().enumerate().filter(|(_, character)| **character == Character::Error);
            let chunk = Chunk {
                start: Some(BitTime(tbit_of(baud, at))),
                octets: characters.iter().map(octet).collect(),
                errors: errors.map(|(position, _)| position).collect(),
                is_continued: false,
            };
            self.line.hear(&chunk);
        }
        self.line.work(&self.services, BitTime(tbit_of(baud, self.recording.elapsed())));
    }

    /// Answers one request, if there is one.
    fn answer_next(&mut self, session: &mut BusSession) -> Result<(), ServeEnd> {
        let slave = |name: &str| slave(&self.gauges, name);
        let port = session.port_name().to_owned();
        let answered = self.inbox.answer_next(&self.services, slave, |slave| records_of(session, slave), Instant::now);
        if let Some(name) = self.inbox.take_operated()
            && let Some(gauge) = self.gauges().iter_mut().find(|gauge| gauge.config.name == name)
        {
            gauge.parameters_changed();
        }
        answered.map_err(|PortLost| PortError::Lost(port).into())
    }

    /// Searches for one gauge that is missing, if its time has come.
    fn search_next(&mut self, session: &mut BusSession) -> Result<(), ServeEnd> {
        let now = Instant::now();
        let gauge = next_search(&mut self.gauges(), now).map(|gauge| gauge.config.clone());
        let Some(config) = gauge else { return Ok(()) };
        let found = match find_gauge(session, &config, self.config.master) {
            Err(FindError::Port(error)) => return Err(error.into()),
            found => found,
        };
        if let Some(gauge) = self.gauges().iter_mut().find(|gauge| gauge.config.address == config.address) {
            gauge.search_finished(&self.services.recorder, session.master(), self.config.baud, found);
        }
        Ok(())
    }

    /// Reads the defects of one gauge with an alarm, if its time has come. A port that is lost meanwhile is found lost in the next cycle.
    fn name_defects(&self, session: &mut BusSession) {
        let now = Instant::now();
        let slave = next_defects(&mut self.gauges(), now).map(|(slave, _)| slave);
        let Some((slave, defects)) = slave.and_then(|slave| Some((slave, defects_of(session, &slave)?))) else {
            return;
        };
        if let Some(gauge) = self.gauges().iter_mut().find(|gauge| gauge.config.address == slave.address) {
            gauge.take_defects(defects);
        }
    }

    /// Reads one parameter that a gateway shows, if its time has come. A port that is lost meanwhile is found lost in the next cycle.
    fn read_watched(&mut self, session: &mut BusSession) {
        let now = Instant::now();
        if now < self.watch_at || !self.services.snapshots.are_parameters_wanted() {
            return;
        }
        self.watch_at = now + watched::PAUSE;
        let Some((slave, parameter)) = takes_parameter_turn(&mut self.gauges()) else { return };
        let value = watched::read(session, &slave, parameter);
        if let Some(gauge) = self.gauges().iter_mut().find(|gauge| gauge.config.address == slave.address) {
            gauge.take_parameter(parameter, value);
        }
    }

    /// Takes other gauges. Gauges that stay are not disturbed.
    fn reconfigure(&mut self, configs: Vec<config::Gauge>, mut session: Option<&mut BusSession>) {
        self.line.declare(&configs);
        let mut gauges = self.gauges();
        let mut old = std::mem::take(&mut *gauges);
        for config in configs {
            let kept = old.iter().position(|gauge| gauge.config.is_same_slave(&config));
            gauges.push(match kept {
                Some(index) => old.remove(index).with_config(config),
                None => GaugeSession::new(config),
            });
        }
        for mut removed in old {
            removed.disconnect(&self.services.recorder, "it was removed from the station's file");
            if let Some(session) = &mut session {
                removed.release(session);
            }
        }
    }

    /// Releases all slaves, and waits until they have left data exchange.
    fn release_slaves(&mut self, session: &mut BusSession) {
        let addresses: Vec<_> = session.master().addresses().collect();
        addresses.iter().for_each(|address| session.master().release(*address));
        let end = Instant::now() + RELEASE_TIMEOUT;
        while session.master().exchanging() > 0 && Instant::now() < end {
            if session.serve(&[], SERVE_INTERVAL).is_err() {
                break;
            }
        }
        let problem = "the segment was stopped";
        self.gauges().iter_mut().for_each(|gauge| gauge.disconnect(&self.services.recorder, problem));
    }

    /// Publishes a snapshot.
    pub fn publish(&mut self, session: Option<&mut BusSession>) {
        self.publish_at = Instant::now() + PUBLISH_INTERVAL;
        if self.is_abandoned.load(Ordering::Relaxed) {
            return;
        }
        let config = &self.config;
        let BusState { state, problem, cycle_ms, damaged_telegrams, others } =
            session.map_or(BusState::WAITING, |session| BusState::of(session, config));
        let gauges = self.gauges();
        let is_configured = |address| gauges.iter().any(|gauge| gauge.config.address == address);
        let configured = gauges.iter().map(GaugeSession::bus_station);
        let others = others.into_iter().filter(|other: &BusStation| !is_configured(other.address));
        let mut stations: Vec<_> = std::iter::once(own_master(config.master)).chain(configured).chain(others).collect();
        stations.sort_by_key(|station| station.address);
        let segment = Segment {
            name: config.name.clone(),
            port: config.port.clone(),
            baud: config.baud.bits_per_second(),
            master: Some(config.master),
            listen_only: false,
            state,
            problem: self.problem.clone().or(problem),
            cycle_ms,
            damaged_telegrams,
            stations,
        };
        let gauges = gauges.iter().map(|gauge| gauge.view(&config.name)).collect();
        self.services.snapshots.publish(SegmentSnapshot { segment, gauges });
    }
}

/// The parameter that has waited longest for its reading, and its slave. Sets the time of its next reading.
fn takes_parameter_turn(gauges: &mut [GaugeSession]) -> Option<(CyclicSlave, &'static NamedParameter)> {
    let with_due = gauges.iter_mut().filter_map(|gauge| Some((gauge.parameter_due()?, gauge)));
    let (_, first) = with_due.min_by_key(|(due, _)| *due)?;
    first.takes_parameter_turn()
}

/// The slave of a gauge in data exchange.
fn slave(gauges: &Mutex<Vec<GaugeSession>>, name: &str) -> Result<CyclicSlave, Unavailable> {
    let gauges = gauges.lock().unwrap_or_else(PoisonError::into_inner);
    let gauge = gauges.iter().find(|gauge| gauge.config.name == name);
    let gauge = gauge.ok_or_else(|| Unavailable::UnknownGauge(name.to_owned()))?;
    gauge.slave.ok_or_else(|| Unavailable::NoAnswer(name.to_owned()))
}
