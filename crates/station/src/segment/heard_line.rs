//! The line of a segment on which the station only listens.
//!
//! It has a [`Tap`] and no other access to the port. A tap receives and has no function that sends, and it never gives its port away. A
//! serial device is opened for reading alone, so that the operating system refuses to send as well.

use super::heard_gauge::{Heard, HeardGauge};
use super::line_observer::LineObserver;
use super::moment::{LineMoment, Moment};
use super::readings::Assumed;
use super::runner::{Context, Line, Lost, SERVE_INTERVAL};
use super::slave::SegmentSlave;
use crate::config;
use crate::snapshot::SegmentSnapshot;
use crate::view::{BusStation, BusStationState, Segment, SegmentState};
use profivac_client::cyclic::CyclicValues;
use profivac_devices::model::Model;
use profivac_dp::link::{Baud, BitTime};
use profivac_host::clock::duration_of;
use profivac_host::port::{Port, PortError};
use profivac_host::rate;
use profivac_listen::gauge::{GaugeFacts, Origin};
use profivac_listen::observer::Totals;
use profivac_listen::station::{Station, StationState};
use profivac_listen::{MAX_TELEGRAM, Tap, TapEvent};
use profivac_recorder::validity::MAX_SILENCE;
use std::time::{Duration, Instant};

/// Without a telegram for this time the line is silent.
const SILENT_AFTER: Duration = Duration::from_secs(3);

/// The time after which a detected baud rate is checked.
pub const RATE_CHECK_INTERVAL: Duration = Duration::from_secs(10);

/// Minimum traffic per interval for judging the baud rate, in octets. chosen: more than a disturbance on a silent line.
const LEAST_OCTETS: u64 = 512;

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

/// The line of another master, with the gauges of the station's file.
pub struct HeardLine {
    gauges: Vec<HeardGauge>,
    slaves: Vec<SegmentSlave>,
    /// The observer while the port is not open: what it knows of the line outlasts a port that was lost.
    kept: Option<LineObserver>,
    /// The telegrams so far, and when the last one came.
    telegrams: u64,
    telegram_at: Option<Instant>,
}

/// An open port, and the line behind it.
pub struct Listening {
    tap: Tap,
    /// When the port was opened. The time of the line stands still while no port is open, so it does not age a data exchange from before.
    opened: BitTime,
    observer: LineObserver,
    rate: RateCheck,
}

impl Line for HeardLine {
    type Open = Listening;

    /// A start of the other master that is not heard leaves units unknown, and a port that only receives disturbs nobody.
    const LONGEST_PAUSE: Duration = Duration::from_secs(1);

    fn new(context: &Context) -> Self {
        let now = context.now();
        let (config, lost_at) = (&context.config, |name: &str| context.lost_at(name, now));
        let gauge = |it: &config::Gauge| HeardGauge::new(it.clone(), now).lost_since(lost_at(&it.name));
        let slave = |it: &config::Slave| SegmentSlave::new(it.clone(), now).lost_since(lost_at(&it.name));
        let (gauges, slaves) = (config.gauges.iter().map(gauge).collect(), config.slaves.iter().map(slave).collect());
        Self { gauges, slaves, kept: None, telegrams: 0, telegram_at: None }
    }

    /// Opens the port, and finds the baud rate if the file does not name it.
    fn open(&mut self, context: &Context) -> Result<Listening, Lost> {
        let config::Segment { port, baud, detects_baud, .. } = &context.config;
        let mut opened = context.edge.open_to_listen(port, *baud)?;
        let baud = if *detects_baud { detected(&mut *opened, *baud)? } else { *baud };
        let now = context.now();
        let kept = self.kept.take().filter(|kept| kept.observer().baud() == baud);
        // A line that is opened again and again at the same rate has had its first round.
        if kept.is_none() {
            self.gauges.iter_mut().for_each(|gauge| gauge.port_opened(now));
            self.slaves.iter_mut().for_each(|slave| slave.port_opened(now));
        }
        let observer = kept.unwrap_or_else(|| {
            LineObserver::new(&context.config, &self.configs(), baud, &context.services.recorder.captures(), now)
        });
        let first = observer.observer().now();
        let tap = Tap::starting_at(opened, baud, first);
        let rate = RateCheck::new(now.at, observer.observer().totals());
        Ok(Listening { tap, opened: first, observer, rate })
    }

    fn opened(config: &config::Segment) -> String {
        format!("listening on {}, the station sends nothing", config.port)
    }

    fn serve(&mut self, context: &mut Context, open: &mut Listening) -> Result<(), Lost> {
        let Listening { tap, opened, observer, rate } = open;
        let (event, _) = tap.receive(&[], SERVE_INTERVAL)?;
        let (bus_time, now) = (tap.now(), context.now());
        match event {
            TapEvent::Octets(chunk) => observer.hear(&chunk),
            TapEvent::Silence => observer.silence(),
            TapEvent::Nothing => {}
        }
        observer.work(&context.services, bus_time, now);
        let telegrams = observer.observer().totals().telegrams;
        if std::mem::replace(&mut self.telegrams, telegrams) != telegrams {
            self.telegram_at = Some(now.at);
        }
        // Right after the opening no telegram may have come yet: a gauge is missing after the silence that ends every reading.
        let is_loss_known = duration_of(observer.observer().baud(), bus_time - *opened) >= MAX_SILENCE;
        for gauge in self.gauges.iter_mut().filter(|gauge| gauge.is_due(now)) {
            let heard = heard(observer, &gauge.shown.config, *opened, bus_time);
            if heard.exchanged.is_some() || is_loss_known {
                gauge.take_heard(&context.services.recorder, heard, now);
            }
        }
        let line = LineMoment { now, bus_time, baud: observer.observer().baud() };
        for slave in &mut self.slaves {
            slave.sample_heard(&context.services.recorder, observer.observer(), *opened, line);
            if is_loss_known {
                let problem = silence_of(observer, slave.config.address);
                slave.note_silence(&context.services.recorder, &problem, now);
            }
        }
        if context.config.detects_baud && rate.is_wrong(now.at, observer.observer().totals()) {
            let rate = observer.observer().baud();
            return Err(Lost(format!(
                "the line has octets and hardly any telegrams at {rate}: its baud rate is searched again"
            )));
        }
        Ok(())
    }

    /// Refuses every request: on this segment the station sends nothing.
    fn answer(&mut self, context: &mut Context, _: &mut Listening) -> Result<(), Lost> {
        let problem = format!(
            "segment {} is listen-only: the station sends nothing on it, so it reads and writes no parameters; use the master that owns the gauge",
            context.config.name
        );
        context.inbox.refuse_all(&context.services, &problem);
        Ok(())
    }

    fn reconfigure(&mut self, context: &Context, open: Option<&mut Listening>, configs: Vec<config::Gauge>) {
        let now = context.now();
        if let Some(observer) = open.map(|open| &mut open.observer).or(self.kept.as_mut()) {
            observer.declare(&configs);
        }
        let mut old = std::mem::take(&mut self.gauges);
        for config in configs {
            let kept = old.iter().position(|gauge| gauge.shown.config.is_same_slave(&config));
            self.gauges.push(match kept {
                Some(index) => old.remove(index).with_config(&context.services.recorder, config, now),
                None => HeardGauge::new(config, now),
            });
        }
        for mut removed in old {
            removed.disconnect(&context.services.recorder, "it was removed from the station's file", now);
        }
    }

    /// A listener leaves nothing behind.
    fn release(&mut self, _: &Context, _: &mut Listening) {}

    fn keep(&mut self, open: Listening) {
        self.kept = Some(open.observer);
    }

    fn disconnect(&mut self, context: &Context, now: Moment, problem: &str) {
        self.gauges.iter_mut().for_each(|gauge| gauge.disconnect(&context.services.recorder, problem, now));
        self.slaves.iter_mut().for_each(|slave| slave.disconnect(&context.services.recorder, problem, now));
    }

    fn snapshot(&self, context: &Context, open: Option<&mut Listening>, now: Moment) -> SegmentSnapshot {
        let config = &context.config;
        let is_silent = self.telegram_at.is_none_or(|at| now.at.saturating_duration_since(at) >= SILENT_AFTER);
        let (state, problem) = match (&open, is_silent) {
            (None, _) => (SegmentState::Waiting, context.problem.clone()),
            (Some(_), true) => (SegmentState::Listening, Some("no telegram was received for 3 s".to_owned())),
            (Some(_), false) => (SegmentState::Running, None),
        };
        let observer = open.map(|open| &open.observer);
        let configured = self.gauges.iter().map(|gauge| gauge.shown.bus_station());
        let configured: Vec<_> = configured.chain(self.slaves.iter().map(SegmentSlave::bus_station)).collect();
        let is_configured = |address| configured.iter().any(|station| station.address == address);
        let others = observer.into_iter().flat_map(others).filter(|other| !is_configured(other.address));
        let others: Vec<_> = others.collect();
        let mut stations: Vec<_> = configured.into_iter().chain(others).collect();
        stations.sort_by_key(|station| station.address);
        let observer = observer.map(LineObserver::observer);
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
        let slaves = self.slaves.iter().map(|slave| slave.view_at(&config.name, now));
        let gauges = self.gauges.iter().map(|gauge| gauge.view_at(&config.name, now)).chain(slaves).collect();
        SegmentSnapshot { segment, gauges }
    }
}

impl HeardLine {
    /// The gauges as the station's file has them now.
    fn configs(&self) -> Vec<config::Gauge> {
        self.gauges.iter().map(|gauge| gauge.shown.config.clone()).collect()
    }
}

/// The baud rate of the line; for a port without a rate, the rate in the file.
fn detected(port: &mut dyn Port, baud: Baud) -> Result<Baud, PortError> {
    match rate::detect(port) {
        Err(PortError::NoBaudRate(_)) => Ok(baud),
        found => found,
    }
}

/// The heard facts about a gauge of the station's file. Another device at its address is no reading, as for a gauge that the station polls,
/// and neither is a data exchange from before the port was `opened`.
fn heard(line: &LineObserver, gauge: &config::Gauge, opened: BitTime, now: BitTime) -> Heard {
    let observer = line.observer();
    let station = observer.station(gauge.address);
    let exchanged_at = station.and_then(|station| station.knowledge.exchanged_at());
    let other = station.and_then(|station| other_device(station, gauge.device));
    let reading = observer.reading(gauge.address).filter(|_| other.is_none());
    let unknown = station.map(|station| station.knowledge.unknown()).unwrap_or_default();
    let unknown: Vec<String> = unknown.iter().map(ToString::to_string).collect();
    let is_undecoded = exchanged_at.is_some() && reading.is_none();
    let problem = match other {
        Some(other) => other,
        None if is_undecoded => unknown.join("; "),
        None => silence_of(line, gauge.address),
    };
    Heard {
        assumed: reading.as_ref().and_then(|reading| assumed(&reading.facts)),
        slave: reading.as_ref().map(|reading| reading.facts.slave),
        values: reading.map_or_else(CyclicValues::default, |reading| reading.values),
        exchanged: exchanged_at.filter(|at| *at > opened).map(|at| (at, duration_of(observer.baud(), now - at))),
        unknown: if exchanged_at.is_some() { unknown } else { Vec::new() },
        problem,
    }
}

/// Why no data exchange with the station at this address is heard.
fn silence_of(line: &LineObserver, address: u8) -> String {
    match line.observer().state(address) {
        None => "no telegram of a station at its address was heard".to_owned(),
        // Of the last seconds, or before the port was lost.
        Some(StationState::Exchanging) => "its data exchange is not heard any more".to_owned(),
        Some(state) => format!("the station at its address is {}", state.text()),
    }
}

/// The sentence about a device with another Ident_Number than the station's file says.
fn other_device(station: &Station, configured: &Model) -> Option<String> {
    let (ident, device) = (station.knowledge.ident()?, configured.name);
    if ident == configured.ident {
        return None;
    }
    let names = station.described.devices().names_with_ident(ident).collect::<Vec<_>>().join(" or ");
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
