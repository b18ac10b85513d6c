//! The line of a segment whose gauges the station polls with its own master.

use super::bus_map::{BusState, own_master};
use super::find::{FindError, find_gauge};
use super::inbox::PortLost;
use super::line_observer::LineObserver;
use super::moment::{LineMoment, Moment};
use super::polled_gauge::{PolledGauge, next_defects, next_parameter, next_search};
use super::records::{defects_of, records_of};
use super::runner::{Context, Line, Lost, PUBLISH_INTERVAL, SERVE_INTERVAL};
use super::slave::{self, SegmentSlave};
use super::watched;
use crate::config;
use crate::control::error::Unavailable;
use crate::snapshot::SegmentSnapshot;
use crate::view::{BusStation, Gauge, Segment};
use profivac_client::cyclic::CyclicSlave;
use profivac_client::ms2;
use profivac_dp::link::BitTime;
use profivac_dp::master::Mode;
use profivac_host::clock::tbit_of;
use profivac_host::port::{Character, Port, PortError, Recorded, RecordedChunk, Recording};
use profivac_host::session::{BusMaster, BusSession, UnrestoredRecord, bus_parameters};
use profivac_listen::Chunk;
use std::collections::BTreeMap;
use std::sync::atomic::Ordering;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

/// The longest that the master waits for a line in use, and for a slow gauge. It serves the bus while it waits.
const TIMEOUT: Duration = Duration::from_secs(5);

/// The longest wait for slaves to leave data exchange.
const RELEASE_TIMEOUT: Duration = Duration::from_secs(1);

/// The line of a master of the station, with its gauges.
pub struct PolledLine {
    gauges: Arc<Mutex<Vec<PolledGauge>>>,
    slaves: Arc<Mutex<Vec<SegmentSlave>>>,
    /// The records that the last session could not restore, by address.
    unrestored: BTreeMap<u8, UnrestoredRecord>,
    /// When the next parameter may be read for gateways.
    watch_at: Instant,
    /// What this station and the others send, for the statistics of the line.
    recording: Recording,
    observer: LineObserver,
}

impl Line for PolledLine {
    type Open = BusSession;

    const LONGEST_PAUSE: Duration = Duration::from_secs(30);

    fn new(context: &Context) -> Self {
        let (now, config) = (context.now(), &context.config);
        let lost_at = |name: &str| context.lost_at(name, now);
        let gauge = |it: &config::Gauge| PolledGauge::new(it.clone(), now).lost_since(lost_at(&it.name));
        let slave = |it: &config::Slave| SegmentSlave::new(it.clone(), now).lost_since(lost_at(&it.name));
        let (gauges, slaves) = (config.gauges.iter().map(gauge).collect(), config.slaves.iter().map(slave).collect());
        Self {
            gauges: Arc::new(Mutex::new(gauges)),
            slaves: Arc::new(Mutex::new(slaves)),
            unrestored: BTreeMap::new(),
            watch_at: now.at,
            recording: Recording::begin(),
            observer: LineObserver::new(
                config,
                &config.gauges,
                config.baud,
                &context.services.recorder.captures(),
                now,
            ),
        }
    }

    fn open(&mut self, context: &Context) -> Result<BusSession, Lost> {
        let config::Segment { port, baud, master, .. } = &context.config;
        let opened = context.edge.open(port, *baud)?;
        let port: Box<dyn Port> = Box::new(Recorded::new(opened, self.recording.clone()));
        let bus = bus_parameters(*master, *baud, port.delivery());
        let mut session = BusSession::new(port, *baud, bus, TIMEOUT)?;
        session.master().set_mode(Mode::Operate);
        let now = context.now();
        self.gauges().iter_mut().for_each(|gauge| gauge.port_opened(now));
        self.slaves().iter_mut().for_each(|slave| slave.port_opened(now));
        session.set_background_task(self.background_task(context));
        // A selector that was moved when the port was lost is restored once the port is open again.
        for (address, record) in std::mem::take(&mut self.unrestored) {
            session.keep_unrestored(address, record);
        }
        Ok(session)
    }

    fn opened(config: &config::Segment) -> String {
        format!("{} is open", config.port)
    }

    fn serve(&mut self, context: &mut Context, session: &mut BusSession) -> Result<(), Lost> {
        let now = context.now();
        let due = self.gauges().iter().map(PolledGauge::due).chain(self.slaves().iter().map(SegmentSlave::due)).min();
        let wait = due.map_or(SERVE_INTERVAL, |due| due.saturating_duration_since(now.at).min(SERVE_INTERVAL));
        session.serve(&[], wait)?;
        while let Some(notice) = session.next_notice() {
            context.event(context.now(), notice);
        }
        self.observe_line(context);
        self.search_next(context, session)?;
        self.ask_slave(context, session)?;
        let (bus_time, baud, recorder) = (session.now(), session.baud(), &context.services.recorder);
        let line = LineMoment { now: context.now(), bus_time, baud };
        self.gauges().iter_mut().for_each(|gauge| gauge.sample(recorder, session.master(), line));
        let heard_at = BitTime(tbit_of(baud, self.recording.elapsed()));
        for slave in self.slaves().iter_mut() {
            slave.sample_owned(recorder, session.master(), line);
            let heard = LineMoment { bus_time: heard_at, ..line };
            slave.sample_heard(recorder, self.observer.observer(), BitTime(0), heard);
        }
        self.name_defects(context, session);
        self.read_watched(context, session);
        self.read_record(context, session);
        Ok(())
    }

    /// Answers one request, if there is one.
    fn answer(&mut self, context: &mut Context, session: &mut BusSession) -> Result<(), Lost> {
        let slave = |name: &str| slave(&self.gauges, name);
        let port = session.port_name().to_owned();
        let Context { inbox, services, edge, .. } = context;
        let answered = inbox.answer_next(services, slave, |slave| records_of(session, slave), || edge.now());
        let now = edge.now();
        if let Some((name, target)) = inbox.take_operated()
            && let Some(gauge) = self.gauges().iter_mut().find(|gauge| gauge.shown.config.name == name)
        {
            gauge.parameters_changed(&target, now);
        }
        answered.map_err(|PortLost| PortError::Lost(port).into())
    }

    fn reconfigure(&mut self, context: &Context, mut session: Option<&mut BusSession>, configs: Vec<config::Gauge>) {
        let now = context.now();
        self.observer.declare(&configs);
        let mut gauges = self.gauges();
        let mut old = std::mem::take(&mut *gauges);
        for config in configs {
            let kept = old.iter().position(|gauge| gauge.shown.config.is_same_slave(&config));
            gauges.push(match kept {
                Some(index) => old.remove(index).with_config(&context.services.recorder, config, now),
                None => PolledGauge::new(config, now),
            });
        }
        for mut removed in old {
            removed.disconnect(&context.services.recorder, "it was removed from the station's file", now);
            if let Some(session) = &mut session {
                removed.release(session);
            }
        }
    }

    /// Releases all slaves, and waits until they have left data exchange.
    fn release(&mut self, context: &Context, session: &mut BusSession) {
        let addresses: Vec<_> = session.master().addresses().collect();
        addresses.iter().for_each(|address| session.master().release(*address));
        let end = context.now().at + RELEASE_TIMEOUT;
        while session.master().exchanging() > 0 && context.now().at < end {
            if session.serve(&[], SERVE_INTERVAL).is_err() {
                break;
            }
        }
    }

    fn keep(&mut self, mut session: BusSession) {
        self.unrestored = session.take_all_unrestored();
    }

    fn disconnect(&mut self, context: &Context, now: Moment, problem: &str) {
        self.gauges().iter_mut().for_each(|gauge| gauge.disconnect(&context.services.recorder, problem, now));
        self.slaves().iter_mut().for_each(|slave| slave.disconnect(&context.services.recorder, problem, now));
    }

    fn snapshot(&self, context: &Context, session: Option<&mut BusSession>, now: Moment) -> SegmentSnapshot {
        let config = &context.config;
        let BusState { state, problem, cycle_ms, damaged_telegrams, others } =
            session.map_or(BusState::WAITING, |session| BusState::of(session, config));
        let (gauges, slaves) = (self.gauges(), self.slaves());
        let configured = configured_stations(&gauges, &slaves);
        let is_configured = |address| configured.iter().any(|station| station.address == address);
        let others = others.into_iter().filter(|other: &BusStation| !is_configured(other.address));
        let others: Vec<_> = others.collect();
        let mut stations: Vec<_> = std::iter::once(own_master(config.master)).chain(configured).chain(others).collect();
        stations.sort_by_key(|station| station.address);
        let segment = Segment {
            name: config.name.clone(),
            port: config.port.clone(),
            baud: config.baud.bits_per_second(),
            master: Some(config.master),
            listen_only: false,
            state,
            problem: context.problem.clone().or(problem),
            cycle_ms,
            damaged_telegrams,
            stations,
        };
        SegmentSnapshot { segment, gauges: views(&gauges, &slaves, &config.name, now) }
    }
}

impl PolledLine {
    /// The gauges. Not to be held during a request: the background task samples them meanwhile.
    fn gauges(&self) -> MutexGuard<'_, Vec<PolledGauge>> {
        self.gauges.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// The other slaves. Not to be held during a request, as the gauges.
    fn slaves(&self) -> MutexGuard<'_, Vec<SegmentSlave>> {
        self.slaves.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Searches for one slave that gives no values, reads it with RD_Inp, or asks for its modules, if its time has come.
    fn ask_slave(&self, context: &Context, session: &mut BusSession) -> Result<(), Lost> {
        let now = context.now();
        let turn = slave::next_request(&mut self.slaves(), now).map(|it| (it.config.clone(), it.question(now)));
        let Some((config, question)) = turn else { return Ok(()) };
        let answer = slave::ask(session, &config, context.config.master, question)?;
        let line = LineMoment { now: context.now(), bus_time: session.now(), baud: session.baud() };
        if let Some(slave) = self.slaves().iter_mut().find(|slave| slave.config.address == config.address) {
            slave.take_answer(&context.services.recorder, session.master(), line, answer);
        }
        Ok(())
    }

    /// Reads one DP-V1 record with points, if its time has come. A port that is lost meanwhile is found lost in the next cycle.
    fn read_record(&self, context: &Context, session: &mut BusSession) {
        let turn = slave::next_record(&mut self.slaves(), context.now());
        let Some((address, (slot, index))) = turn else { return };
        let read = ms2::read(session, address, slot, index);
        if let Some(slave) = self.slaves().iter_mut().find(|slave| slave.config.address == address) {
            slave.take_record(&context.services.recorder, (slot, index), &read, context.now());
        }
    }

    /// Samples and publishes the gauges while a request takes long.
    fn background_task(&self, context: &Context) -> impl FnMut(&mut BusMaster, BitTime) + Send + use<> {
        let (gauges, services, edge) = (Arc::clone(&self.gauges), context.services.clone(), Arc::clone(&context.edge));
        let slaves = Arc::clone(&self.slaves);
        let (is_abandoned, name) = (Arc::clone(&context.is_abandoned), context.config.name.clone());
        let (baud, mut publish_at) = (context.config.baud, edge.now().at);
        move |master, bus_time| {
            let (Ok(mut gauges), Ok(mut slaves)) = (gauges.try_lock(), slaves.try_lock()) else { return };
            let now = edge.now();
            let line = LineMoment { now, bus_time, baud };
            gauges.iter_mut().for_each(|gauge| gauge.sample(&services.recorder, master, line));
            slaves.iter_mut().for_each(|slave| slave.sample_owned(&services.recorder, master, line));
            if now.at >= publish_at && !is_abandoned.load(Ordering::Relaxed) {
                publish_at = now.at + PUBLISH_INTERVAL;
                let views = views(&gauges, &slaves, &name, now);
                services.snapshots.publish_gauges(&name, views, configured_stations(&gauges, &slaves));
            }
        }
    }

    /// Gives the observer of the line what was sent and received since the last call.
    fn observe_line(&mut self, context: &Context) {
        let baud = context.config.baud;
        for RecordedChunk { at, characters, .. } in self.recording.take() {
            let octet = |character: &Character| if let Character::Octet(octet) = character { *octet } else { 0 };
            let errors = characters.iter().enumerate().filter(|(_, character)| **character == Character::Error);
            let chunk = Chunk {
                start: Some(BitTime(tbit_of(baud, at))),
                octets: characters.iter().map(octet).collect(),
                errors: errors.map(|(position, _)| position).collect(),
                is_continued: false,
            };
            self.observer.hear(&chunk);
        }
        let bus_time = BitTime(tbit_of(baud, self.recording.elapsed()));
        self.observer.work(&context.services, bus_time, context.now());
    }

    /// Searches for one gauge that is missing, if its time has come.
    fn search_next(&self, context: &Context, session: &mut BusSession) -> Result<(), Lost> {
        let due = next_search(&mut self.gauges(), context.now()).map(|gauge| gauge.shown.config.clone());
        let Some(config) = due else { return Ok(()) };
        let found = match find_gauge(context.config.devices, session, &config, context.config.master) {
            Err(FindError::Port(error)) => return Err(error.into()),
            found => found,
        };
        if let Some(gauge) = self.gauges().iter_mut().find(|gauge| gauge.shown.config.address == config.address) {
            let (recorder, baud, now) = (&context.services.recorder, context.config.baud, context.now());
            gauge.search_finished(recorder, session.master(), baud, found, now);
        }
        Ok(())
    }

    /// Reads the defects of one gauge with an alarm, if its time has come. A port that is lost meanwhile is found lost in the next cycle.
    fn name_defects(&self, context: &Context, session: &mut BusSession) {
        let slave = next_defects(&mut self.gauges(), context.now()).map(|(slave, _)| slave);
        let Some((slave, defects)) = slave.and_then(|slave| Some((slave, defects_of(session, &slave)?))) else {
            return;
        };
        if let Some(gauge) = self.gauges().iter_mut().find(|gauge| gauge.shown.config.address == slave.address) {
            gauge.shown.take_defects(defects);
        }
    }

    /// Reads one parameter that a gateway shows, if its time has come. A port that is lost meanwhile is found lost in the next cycle.
    fn read_watched(&mut self, context: &Context, session: &mut BusSession) {
        let now = context.now();
        if now.at < self.watch_at || !context.services.snapshots.are_parameters_wanted() {
            return;
        }
        self.watch_at = now.at + watched::PAUSE;
        let Some((slave, parameter)) = next_parameter(&mut self.gauges(), now) else { return };
        let value = watched::read(session, &slave, parameter, || context.now());
        if let Some(gauge) = self.gauges().iter_mut().find(|gauge| gauge.shown.config.address == slave.address) {
            gauge.take_parameter(parameter, value, context.now());
        }
    }
}

/// The gauges and the other slaves as the API shows them.
fn views(gauges: &[PolledGauge], slaves: &[SegmentSlave], segment: &str, now: Moment) -> Vec<Gauge> {
    let slaves = slaves.iter().map(|slave| slave.view_at(segment, now));
    gauges.iter().map(|gauge| gauge.view_at(segment, now)).chain(slaves).collect()
}

/// The gauges and the other slaves as stations on the bus.
fn configured_stations(gauges: &[PolledGauge], slaves: &[SegmentSlave]) -> Vec<BusStation> {
    let slaves = slaves.iter().map(SegmentSlave::bus_station);
    gauges.iter().map(|gauge| gauge.shown.bus_station()).chain(slaves).collect()
}

/// The slave of a gauge in data exchange.
fn slave(gauges: &Mutex<Vec<PolledGauge>>, name: &str) -> Result<CyclicSlave, Unavailable> {
    let gauges = gauges.lock().unwrap_or_else(PoisonError::into_inner);
    let gauge = gauges.iter().find(|gauge| gauge.shown.config.name == name);
    let gauge = gauge.ok_or_else(|| Unavailable::UnknownGauge(name.to_owned()))?;
    gauge.shown.slave.ok_or_else(|| Unavailable::NoAnswer(name.to_owned()))
}
