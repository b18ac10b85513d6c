//! A segment in memory: the gauges of a demonstration are sampled, recorded and controlled like real ones.

use super::bus_map::{milliseconds, own_master};
use super::edge::{Edge, System};
use super::inbox::Inbox;
use super::line_observer::LineObserver;
use super::moment::{LineMoment, Moment};
use super::polled_gauge::{PolledGauge, next_defects};
use super::records::{defects_of, records_of};
use super::runner::PUBLISH_INTERVAL;
use super::services::SegmentServices;
use super::shown_gauge::ShownGauge;
use crate::alarm::Inputs;
use crate::config::{self, MEMORY_PORT};
use crate::control::error::Unavailable;
use crate::snapshot::SegmentSnapshot;
use crate::view::{Gauge, Segment, SegmentState, duration_ms};
use profivac_client::cyclic::CyclicSlave;
use profivac_devices::catalog::model_named;
use profivac_listen::{Chunk, TimeSource};
use profivac_recorder::validity::MAX_SILENCE;
use profivac_vacuum::Gas;
use profivac_virtual::memory_segment::{MemorySegment, Traffic};
use std::time::{Duration, Instant};

/// The time between two samples.
const POLL: Duration = Duration::from_millis(100);

/// A segment in memory that the station shows.
pub struct DemoSegment {
    name: String,
    master: u8,
    services: SegmentServices,
    gauges: Vec<PolledGauge>,
    inbox: Inbox,
    line: LineObserver,
    publish_at: Instant,
}

impl DemoSegment {
    /// Publishes the gauges of `segment` as the segment `name`. `names` gives the name and the device of the gauge at an address.
    #[must_use]
    pub fn new(
        services: SegmentServices,
        name: &str,
        segment: &mut MemorySegment,
        master: u8,
        names: impl Fn(u8) -> (String, String),
    ) -> Self {
        let now = System.now();
        segment.keep_traffic();
        let captures = services.recorder.captures();
        let mut line = LineObserver::of_line(name, segment.baud(), TimeSource::Exact, &captures, now);
        let inbox = Inbox::new(services.control.requests().accept(name));
        let of_slave = |slave: &CyclicSlave| PolledGauge::with_slave(gauge(slave, &names), *slave, now);
        let gauges: Vec<_> = segment.slaves().iter().map(of_slave).collect();
        gauges.iter().for_each(|gauge| line.declare(std::slice::from_ref(&gauge.shown.config)));
        let demo = Self { name: name.to_owned(), master, services, gauges, inbox, line, publish_at: now.at };
        demo.publish(segment, now);
        demo
    }

    /// Samples and publishes the gauges, and answers one request, or a part of one, if there is one. While it answers, time passes on the
    /// bus.
    pub fn run_once(&mut self, segment: &mut MemorySegment) {
        let now = System.now();
        self.observe_line(segment, now);
        self.sample(segment, now);
        self.name_defects(segment, now);
        if now.at >= self.publish_at {
            self.publish_at = now.at + PUBLISH_INTERVAL;
            self.publish(segment, now);
        }
        let slave = |name: &str| slave(&self.gauges, name);
        // A segment in memory has no port to lose.
        self.inbox.answer_next(&self.services, slave, |slave| records_of(segment, slave), || System.now()).ok();
    }

    /// Gives the observer of the line what was sent since the last call.
    fn observe_line(&mut self, segment: &mut MemorySegment, now: Moment) {
        for Traffic { start, octets, errors } in segment.take_traffic() {
            self.line.hear(&Chunk { start: Some(start), octets, errors, is_continued: false });
        }
        self.line.work(&self.services, segment.now(), now);
    }

    fn sample(&mut self, segment: &mut MemorySegment, now: Moment) {
        let (slaves, baud) = (segment.slaves().to_vec(), segment.baud());
        let line = LineMoment { now, bus_time: segment.now(), baud };
        let master = segment.master_mut();
        for (gauge, slave) in self.gauges.iter_mut().zip(slaves) {
            if gauge.takes_search_turn(now) {
                // The gauge was switched off for a while; in memory it is the same device again.
                gauge.search_finished(&self.services.recorder, master, baud, Ok(slave), now);
            }
            gauge.sample(&self.services.recorder, master, line);
        }
    }

    /// Reads the defects of one gauge with an alarm, if its time has come.
    fn name_defects(&mut self, segment: &mut MemorySegment, now: Moment) {
        let due = next_defects(&mut self.gauges, now);
        if let Some((defects, gauge)) = due.and_then(|(slave, gauge)| Some((defects_of(segment, &slave)?, gauge))) {
            gauge.shown.take_defects(defects);
        }
    }

    fn publish(&self, segment: &MemorySegment, now: Moment) {
        let gauges = self.gauges.iter().map(|gauge| gauge.view_at(&self.name, now)).collect();
        let damaged = self.line.observer().totals().damaged;
        let segment = Segment {
            damaged_telegrams: u32::try_from(damaged).unwrap_or(u32::MAX),
            ..view(&self.name, self.master, segment, self.gauges.iter().map(|gauge| &gauge.shown))
        };
        self.services.snapshots.publish(SegmentSnapshot { segment, gauges });
    }
}

fn slave(gauges: &[PolledGauge], name: &str) -> Result<CyclicSlave, Unavailable> {
    let gauge = gauges.iter().find(|gauge| gauge.shown.config.name == name);
    let gauge = gauge.ok_or_else(|| Unavailable::UnknownGauge(name.to_owned()))?;
    gauge.shown.slave.ok_or_else(|| Unavailable::NoAnswer(name.to_owned()))
}

/// The configuration of a gauge of the demonstration.
fn gauge(slave: &CyclicSlave, names: impl Fn(u8) -> (String, String)) -> config::Gauge {
    let (name, device) = names(slave.address);
    config::Gauge {
        name,
        address: slave.address,
        // What the bus does not tell apart has the name of the demonstration.
        device: model_named(&device).unwrap_or(slave.model),
        poll: POLL,
        gas: Gas::N2,
        levels: Vec::new(),
        configuration: None,
        unit: None,
    }
}

fn view<'a>(name: &str, master: u8, segment: &MemorySegment, gauges: impl Iterator<Item = &'a ShownGauge>) -> Segment {
    let mut stations: Vec<_> = gauges.map(ShownGauge::bus_station).chain([own_master(master)]).collect();
    stations.sort_by_key(|station| station.address);
    let baud = segment.baud();
    Segment {
        name: name.to_owned(),
        port: MEMORY_PORT.to_owned(),
        baud: baud.bits_per_second(),
        master: Some(master),
        listen_only: false,
        state: SegmentState::Running,
        problem: None,
        cycle_ms: milliseconds(segment.master().cycle_tbit(), baud),
        damaged_telegrams: 0,
        stations,
    }
}

/// The inputs of the alarms at the present time of a segment in memory. No clock takes part, so a test can evaluate hours of a plant
/// without waiting.
#[must_use]
pub fn simulated_inputs(
    segment: &MemorySegment,
    name: &str,
    master: u8,
    names: impl Fn(u8) -> (String, String),
) -> Inputs {
    let silence = |slave: &CyclicSlave| {
        let exchanged_at = segment.master().exchanged_at(slave.address)?;
        let bits = f64::from(segment.baud().bits_per_second());
        Some(Duration::from_secs_f64((segment.seconds() - exchanged_at.0 as f64 / bits).max(0.0)))
    };
    let observed = |slave: &CyclicSlave| {
        let (silence, mut shown) = (silence(slave), ShownGauge::starting(gauge(slave, &names), *slave));
        if let Some(silence) = silence.filter(|silence| *silence < MAX_SILENCE) {
            shown.observe(slave, &segment.values(slave), silence);
        }
        (shown, silence.map(duration_ms))
    };
    let observed: Vec<_> = segment.slaves().iter().map(observed).collect();
    let gauges = observed.iter().map(|(shown, age_ms)| Gauge { age_ms: *age_ms, ..shown.view(name) }).collect();
    Inputs {
        segments: vec![view(name, master, segment, observed.iter().map(|(shown, _)| shown))],
        gauges,
        buses: Default::default(),
        recorder_error: None,
        damage: None,
        archive: None,
    }
}
