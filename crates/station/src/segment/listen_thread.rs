//! The thread of a segment on which the station only listens.
//!
//! It has a [`Tap`] and no other access to the port. A tap receives and has no function that sends, and it never gives its port away. A
//! serial device is opened for reading alone, so that the operating system refuses to send as well.

use super::gauge_session::{GaugeSession, Heard};
use super::inbox::Inbox;
use super::line_observer::LineObserver;
use super::readings::Assumed;
use super::services::SegmentServices;
use super::thread::{SegmentCommand, ThreadSetup};
use crate::config;
use crate::snapshot::SegmentSnapshot;
use crate::view::{BusStation, BusStationState, Segment, SegmentState};
use profivac_client::cyclic::CyclicValues;
use profivac_client::identify::device_names;
use profivac_dp::link::{Baud, BitTime};
use profivac_host::clock::duration_of;
use profivac_host::port::{Port, PortError, open_to_listen};
use profivac_host::rate;
use profivac_listen::gauge::{GaugeFacts, Origin};
use profivac_listen::observer::Totals;
use profivac_listen::station::{Station, StationState};
use profivac_listen::{MAX_TELEGRAM, Tap, TapEvent};
use profivac_recorder::EventKind;
use profivac_virtual::device_spec::entry;
use profivac_virtual::open;

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{Receiver, TryRecvError};
use std::time::{Duration, Instant};

/// The longest time without a look at commands and clock.
const SERVE_INTERVAL: Duration = Duration::from_millis(50);

/// The time between two snapshots.
const PUBLISH_INTERVAL: Duration = Duration::from_millis(100);

/// The pause before a port is opened again.
const PAUSE: Duration = Duration::from_secs(1);

/// Without a telegram for this time the line is silent.
const SILENT_AFTER: Duration = Duration::from_secs(3);

/// The time after which a detected baud rate is checked.
const RATE_CHECK_INTERVAL: Duration = Duration::from_secs(10);

/// Minimum traffic per interval for judging the baud rate, in octets. chosen: more than a disturbance on a silent line.
const LEAST_OCTETS: u64 = 512;

/// Why a segment does not listen any more.
enum ListenEnd {
    /// The station stops it.
    Stopped,
    /// The line carries octets and hardly any telegrams: it has another baud rate than the detected one.
    OtherRate,
}

/// Checks a detected baud rate: at a wrong one there are octets and hardly any telegrams.
struct RateCheck {
    began: Instant,
    telegrams: u64,
    octets: u64,
}

impl RateCheck {
    const fn new(now: Instant, totals: &Totals) -> Self {
        Self { began: now, telegrams: totals.telegrams, octets: totals.octets }
    }

    /// Whether the octets since the last check have fewer telegrams than the longest telegrams would be.
    fn is_wrong(&mut self, now: Instant, totals: &Totals) -> bool {
        if now.saturating_duration_since(self.began) < RATE_CHECK_INTERVAL {
            return false;
        }
        let telegrams = totals.telegrams.saturating_sub(self.telegrams);
        let octets = totals.octets.saturating_sub(self.octets);
        *self = Self::new(now, totals);
        octets >= LEAST_OCTETS && telegrams.saturating_mul(MAX_TELEGRAM as u64) < octets
    }
}

/// The state of the thread.
pub struct ListenThread {
    config: config::Segment,
    services: SegmentServices,
    commands: Receiver<SegmentCommand>,
    inbox: Inbox,
    gauges: Vec<GaugeSession>,
    is_abandoned: Arc<AtomicBool>,
    line: Option<LineObserver>,
    /// The reason why the port is not open.
    problem: Option<String>,
    telegrams: u64,
    telegram_at: Option<Instant>,
    publish_at: Instant,
}

impl ListenThread {
    pub fn new(ThreadSetup { config, services, commands, is_abandoned }: ThreadSetup) -> Self {
        let inbox = Inbox::new(services.control.requests().accept(&config.name));
        let gauges = config.gauges.iter().cloned().map(GaugeSession::listening).collect();
        let publish_at = Instant::now();
        let (line, problem, telegram_at) = (None, None, None);
        Self {
            config,
            services,
            commands,
            inbox,
            gauges,
            is_abandoned,
            line,
            problem,
            telegrams: 0,
            telegram_at,
            publish_at,
        }
    }

    /// Runs until the station stops it.
    pub fn run(mut self) {
        loop {
            match self.open() {
                Ok(mut tap) => {
                    self.problem = None;
                    let text = format!(
                        "segment {}: listening on {}, the station sends nothing",
                        self.config.name, self.config.port
                    );
                    self.services.recorder.event_now(None, EventKind::Bus, text);
                    match self.listen(&mut tap) {
                        Ok(ListenEnd::Stopped) => break,
                        Ok(ListenEnd::OtherRate) => self.search_rate_again(),
                        Err(error) => self.port_lost(&error),
                    }
                }
                Err(error) => self.port_lost(&error),
            }
            if self.pause() {
                break;
            }
        }
        let problem = "the segment was stopped";
        self.gauges.iter_mut().for_each(|gauge| gauge.disconnect(&self.services.recorder, problem));
    }

    /// Opens the port, and finds the baud rate if the file does not name it.
    fn open(&mut self) -> Result<Tap, PortError> {
        let config::Segment { port, baud, detects_baud, .. } = &self.config;
        let mut opened = open_port(port, *baud)?;
        let baud = if *detects_baud { detected(&mut *opened, *baud)? } else { *baud };
        if self.line.as_ref().is_none_or(|line| line.observer().baud() != baud) {
            self.line = Some(LineObserver::new(&self.config, baud, &self.services.recorder.captures()));
        }
        let first = self.line.as_ref().map_or(BitTime(0), |line| line.observer().now());
        Ok(Tap::starting_at(opened, baud, first))
    }

    fn search_rate_again(&mut self) {
        let rate = self.line.as_ref().map_or(self.config.baud, |line| line.observer().baud());
        let problem =
            format!("the line has octets and hardly any telegrams at {rate}: its baud rate is searched again");
        self.gauges.iter_mut().for_each(|gauge| gauge.disconnect(&self.services.recorder, &problem));
        let text = format!("segment {}: {problem}", self.config.name);
        self.services.recorder.event_now(None, EventKind::Bus, text);
        self.problem = Some(problem);
        self.publish(None);
    }

    fn port_lost(&mut self, error: &PortError) {
        let problem = error.to_string();
        self.gauges.iter_mut().for_each(|gauge| gauge.disconnect(&self.services.recorder, &problem));
        if self.problem.as_ref() != Some(&problem) {
            let text = format!("segment {}: {problem}", self.config.name);
            self.services.recorder.event_now(None, EventKind::Bus, text);
            self.problem = Some(problem);
        }
        self.publish(None);
    }

    /// Waits before the port is opened again. Returns whether to stop.
    fn pause(&mut self) -> bool {
        let end = Instant::now() + PAUSE;
        while Instant::now() < end {
            self.refuse_requests();
            match self.commands.recv_timeout(SERVE_INTERVAL) {
                Ok(SegmentCommand::Stop) => return true,
                Ok(SegmentCommand::Gauges(gauges)) => self.reconfigure(gauges),
                Err(_) => {}
            }
            self.publish(None);
        }
        false
    }

    /// Listens until the segment stops.
    fn listen(&mut self, tap: &mut Tap) -> Result<ListenEnd, PortError> {
        let mut rate = RateCheck::new(Instant::now(), self.totals());
        loop {
            match self.commands.try_recv() {
                Ok(SegmentCommand::Stop) | Err(TryRecvError::Disconnected) => return Ok(ListenEnd::Stopped),
                Ok(SegmentCommand::Gauges(gauges)) => self.reconfigure(gauges),
                Err(TryRecvError::Empty) => {}
            }
            self.refuse_requests();
            let (event, _) = tap.receive(&[], SERVE_INTERVAL)?;
            let now = tap.now();
            let Some(line) = &mut self.line else { return Ok(ListenEnd::Stopped) };
            match event {
                TapEvent::Octets(chunk) => line.hear(&chunk),
                TapEvent::Silence => line.silence(),
                TapEvent::Nothing => {}
            }
            line.work(&self.services, now);
            let telegrams = line.observer().totals().telegrams;
            if std::mem::replace(&mut self.telegrams, telegrams) != telegrams {
                self.telegram_at = Some(Instant::now());
            }
            self.sample(now);
            if Instant::now() >= self.publish_at {
                self.publish(Some(now));
            }
            if self.config.detects_baud && rate.is_wrong(Instant::now(), self.totals()) {
                return Ok(ListenEnd::OtherRate);
            }
        }
    }

    /// The totals of the line so far.
    fn totals(&self) -> &Totals {
        const NONE: Totals = Totals { telegrams: 0, octets: 0, damaged: 0, unattributed: 0, tokens: 0 };
        self.line.as_ref().map_or(&NONE, |line| line.observer().totals())
    }

    /// Refuses every request: on this segment the station sends nothing.
    fn refuse_requests(&mut self) {
        let problem = format!(
            "segment {} is listen-only: the station sends nothing on it, so it reads and writes no parameters; use the master that owns the gauge",
            self.config.name
        );
        self.inbox.refuse_all(&self.services, &problem);
    }

    fn sample(&mut self, now: BitTime) {
        let Some(line) = &self.line else { return };
        for gauge in &mut self.gauges {
            if gauge.takes_sample_turn() {
                gauge.take_heard(&self.services.recorder, heard(line, &gauge.config, now));
            }
        }
    }

    fn reconfigure(&mut self, configs: Vec<config::Gauge>) {
        let mut old = std::mem::take(&mut self.gauges);
        if let Some(line) = &mut self.line {
            line.declare(&configs);
        }
        for config in configs {
            let kept = old.iter().position(|gauge| gauge.config.is_same_slave(&config));
            self.gauges.push(match kept {
                Some(index) => old.remove(index).with_config(config),
                None => GaugeSession::listening(config),
            });
        }
        for mut removed in old {
            removed.disconnect(&self.services.recorder, "it was removed from the station's file");
        }
    }

    /// Publishes a snapshot; `now` is the bit time while the port is open.
    pub fn publish(&mut self, now: Option<BitTime>) {
        self.publish_at = Instant::now() + PUBLISH_INTERVAL;
        if self.is_abandoned.load(Ordering::Relaxed) {
            return;
        }
        let config = &self.config;
        let is_silent = self.telegram_at.is_none_or(|at| at.elapsed() >= SILENT_AFTER);
        let (state, problem) = match (now, is_silent) {
            (None, _) => (SegmentState::Waiting, self.problem.clone()),
            (Some(_), true) => (SegmentState::Listening, Some("no telegram was received for 3 s".to_owned())),
            (Some(_), false) => (SegmentState::Running, None),
        };
        let line = self.line.as_ref().filter(|_| now.is_some());
        let is_configured = |address| self.gauges.iter().any(|gauge| gauge.config.address == address);
        let others = line.into_iter().flat_map(others).filter(|other| !is_configured(other.address));
        let mut stations: Vec<_> = self.gauges.iter().map(GaugeSession::bus_station).chain(others).collect();
        stations.sort_by_key(|station| station.address);
        let observer = line.map(LineObserver::observer);
        let baud = observer.map_or(config.baud, profivac_listen::Observer::baud);
        let segment = Segment {
            name: config.name.clone(),
            port: config.port.clone(),
            baud: baud.bits_per_second(),
            master: None,
            listen_only: true,
            state,
            problem,
            cycle_ms: observer
                .and_then(|it| it.cycle().mean_tbit())
                .map(|tbit| duration_of(baud, tbit).as_secs_f64() * 1e3),
            damaged_telegrams: observer.map_or(0, |it| u32::try_from(it.totals().damaged).unwrap_or(u32::MAX)),
            stations,
        };
        let gauges = self.gauges.iter().map(|gauge| gauge.view(&config.name)).collect();
        self.services.snapshots.publish(SegmentSnapshot { segment, gauges });
    }
}

/// Opens a port to listen. A segment in memory has no device that could be opened for reading alone.
fn open_port(name: &str, baud: Baud) -> Result<Box<dyn Port>, PortError> {
    if name.starts_with("sim:") { open::port(name, baud) } else { open_to_listen(name, baud) }
}

/// The baud rate of the line. A port without a rate has that of the file.
fn detected(port: &mut dyn Port, baud: Baud) -> Result<Baud, PortError> {
    match rate::detect(port) {
        Err(PortError::NoBaudRate(_)) => Ok(baud),
        found => found,
    }
}

/// The heard facts about a gauge of the station's file. Another device at its address is no reading, as for a gauge that the station polls.
fn heard(line: &LineObserver, gauge: &config::Gauge, now: BitTime) -> Heard {
    let observer = line.observer();
    let station = observer.station(gauge.address);
    let exchanged_at = station.and_then(|station| station.knowledge.exchanged_at());
    let other = station.and_then(|station| other_device(station, &gauge.device));
    let reading = observer.reading(gauge.address).filter(|_| other.is_none());
    let unknown = station.map(|station| station.knowledge.unknown()).unwrap_or_default();
    let unknown: Vec<String> = unknown.iter().map(ToString::to_string).collect();
    let is_undecoded = exchanged_at.is_some() && reading.is_none();
    let problem = match (other, observer.state(gauge.address)) {
        (Some(other), _) => other,
        (None, _) if is_undecoded => unknown.join("; "),
        (None, None) => "no telegram of a station at its address was heard".to_owned(),
        (None, Some(state)) => format!("the station at its address is {}", state.text()),
    };
    Heard {
        assumed: reading.as_ref().and_then(|reading| assumed(&reading.facts)),
        slave: reading.as_ref().map(|reading| reading.facts.slave),
        values: reading.map_or_else(CyclicValues::default, |reading| reading.values),
        silence: exchanged_at.map(|at| duration_of(observer.baud(), now - at)),
        unknown: if exchanged_at.is_some() { unknown } else { Vec::new() },
        problem,
    }
}

/// The sentence about a device whose Ident_Number is not that of the station's file.
fn other_device(station: &Station, device: &str) -> Option<String> {
    let (ident, configured) = (station.knowledge.ident()?, entry(device).ok()?.model);
    if ident == configured.ident {
        return None;
    }
    let names = device_names(ident).join(" or ");
    let found = if names.is_empty() { format!("device with ident {ident:04X}") } else { names };
    Some(format!("it is a {found}, the station's file says {device}"))
}

/// The assumption on which the pressures of a gauge depend.
fn assumed(facts: &GaugeFacts) -> Option<Assumed> {
    match (facts.model.max(facts.configuration), facts.unit) {
        (Origin::Assumed, _) => Some(Assumed::Configuration),
        (_, Origin::Assumed) => Some(Assumed::Unit),
        (Origin::Heard | Origin::Configured, Origin::Heard | Origin::Configured) => None,
    }
}

/// The stations on the line.
fn others(line: &LineObserver) -> Vec<BusStation> {
    let observer = line.observer();
    let view = |(address, station): (u8, &Station)| {
        let state = station.state(observer.now(), observer.baud())?;
        let shown = match state {
            StationState::Master => BusStationState::OtherMaster,
            StationState::Missing => BusStationState::Missing,
            StationState::Exchanging
            | StationState::NotConfigured
            | StationState::NoMaster
            | StationState::NotAddressed => BusStationState::Unconfigured,
        };
        let ident = station.knowledge.ident().map(|ident| format!("0x{ident:04X}"));
        Some(BusStation {
            address,
            state: shown,
            name: None,
            device: None,
            ident,
            description: state.text().to_owned(),
        })
    };
    observer.stations().filter_map(view).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_rate_at_which_octets_are_hardly_ever_telegrams_is_not_kept() {
        let table = [
            // telegrams and octets of an interval, whether the rate is wrong
            (0, 0, false),
            // A disturbance on a silent line.
            (0, LEAST_OCTETS - 1, false),
            (0, LEAST_OCTETS, true),
            // Octets of a wrong rate that look like a short acknowledgement or a token now and then.
            (10, 100_000, true),
            // The longest telegrams, each damaged one sent twice.
            (1000, 250_000, false),
            (50_000, 1_000_000, false),
        ];
        for (telegrams, octets, is_wrong) in table {
            let began = Instant::now();
            let mut check = RateCheck::new(began, &Totals::default());
            let totals = Totals { telegrams, octets, ..Totals::default() };
            assert!(!check.is_wrong(began + RATE_CHECK_INTERVAL / 2, &totals), "the interval has not passed");
            assert_eq!(check.is_wrong(began + RATE_CHECK_INTERVAL, &totals), is_wrong, "{telegrams} {octets}");
            assert!(!check.is_wrong(began + RATE_CHECK_INTERVAL * 2, &totals), "an interval counts its own octets");
        }
    }
}
