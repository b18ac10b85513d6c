//! A segment of a station in virtual time.

use super::plant::{BAUD, Plant, VirtualEdge};
use crate::config;
use crate::segment::edge::SegmentCommand;
use crate::segment::runner::{Line, Runner, RunnerSetup};
use crate::services::Services;
use crate::view::{BusStationState, Gauge, Segment};
use profivac_devices::catalog::{KnownDevices, model_named};
use profivac_recorder::{Event, Micros, PointSample, Recorder, Sample, Settings};
use std::sync::Arc;
use std::sync::mpsc::{Sender, channel};
use std::time::Duration;
use tempfile::TempDir;

/// The sampling interval of the gauges.
pub const POLL: Duration = Duration::from_millis(20);

/// The port of the segment.
pub const PORT: &str = "/dev/ttyVirtual";

pub struct Fixture<L: Line> {
    _folder: TempDir,
    pub services: Arc<Services>,
    pub edge: VirtualEdge,
    pub commands: Sender<SegmentCommand>,
    runner: Runner<L>,
}

/// A gauge: `chamber bcg450 5`.
pub fn gauge(text: &str) -> config::Gauge {
    let [name, device, address] = text.split(' ').collect::<Vec<_>>()[..] else { panic!("{text}") };
    let plain = config::Gauge::plain(name.to_owned(), address.parse().unwrap(), model_named(device).unwrap());
    config::Gauge { poll: POLL, ..plain }
}

/// A segment whose master polls these gauges.
pub fn polled(gauges: &[&str]) -> config::Segment {
    config::Segment {
        devices: KnownDevices::BUILT_IN,
        name: "hall".to_owned(),
        port: PORT.to_owned(),
        baud: BAUD,
        detects_baud: false,
        listen_only: false,
        master: 1,
        gauges: gauges.iter().map(|text| gauge(text)).collect(),
        slaves: Vec::new(),
    }
}

fn started<L: Line>(
    config: config::Segment,
    services: &Services,
    edge: &VirtualEdge,
) -> (Sender<SegmentCommand>, Runner<L>) {
    let (commands, inbox) = channel();
    let setup = RunnerSetup {
        config,
        services: services.for_segments(),
        commands: inbox,
        is_abandoned: Arc::default(),
        edge: Arc::new(edge.clone()),
    };
    (commands, Runner::new(setup))
}

impl<L: Line> Fixture<L> {
    pub fn new(config: config::Segment, edge: VirtualEdge) -> Self {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("plant.db");
        let recorder = Recorder::start(&path, Settings::default()).unwrap();
        let services = Arc::new(Services::new("Hall".to_owned(), path, recorder));
        let (commands, runner) = started(config, &services, &edge);
        Self { _folder: folder, services, edge, commands, runner }
    }

    /// Stops the segment, as the station does.
    pub fn stop(&mut self) {
        self.commands.send(SegmentCommand::Stop).unwrap();
        while self.step() {}
        let (services, segment) = (self.services.for_segments(), self.segment());
        services.snapshots.remove(&segment.name);
        services.control.requests().close(&segment.name);
    }

    /// Starts a segment that was stopped.
    pub fn start(&mut self, config: config::Segment) {
        (self.commands, self.runner) = started(config, &self.services, &self.edge);
    }

    /// Makes a step. Returns whether the segment goes on.
    pub fn step(&mut self) -> bool {
        self.runner.step()
    }

    /// Changes the plant between two steps.
    pub fn change(&self, change: impl FnOnce(&mut Plant)) {
        change(&mut self.edge.plant());
    }

    /// The times in seconds from the present loss of the port to the first attempt to open it, and between two attempts.
    pub fn pauses(&self) -> Vec<f64> {
        let plant = self.edge.plant();
        let moments: Vec<_> = plant.lost.iter().chain(&plant.openings).collect();
        moments.windows(2).map(|pair| (*pair[1] - *pair[0]).as_secs_f64()).collect()
    }

    pub fn run_for(&mut self, time: Duration) {
        let end = self.edge.elapsed() + time;
        while self.edge.elapsed() < end {
            assert!(self.step(), "the segment has ended");
        }
    }

    /// Runs until a gauge is as wanted, for `limit` of virtual time at most.
    pub fn until(&mut self, name: &str, limit: Duration, wanted: impl Fn(&Gauge) -> bool) -> Gauge {
        let end = self.edge.elapsed() + limit;
        loop {
            let gauge = self.gauge(name);
            if wanted(&gauge) {
                return gauge;
            }
            assert!(self.edge.elapsed() < end, "after {limit:?}: {gauge:?}; {:?}", self.segment());
            assert!(self.step(), "the segment has ended");
        }
    }

    pub fn exchanging(&mut self, name: &str) -> Gauge {
        self.until(name, Duration::from_secs(60), |gauge| gauge.state == BusStationState::DataExchange)
    }

    pub fn until_problem(&mut self, name: &str, part: &str) -> Gauge {
        let has_part = |gauge: &Gauge| gauge.problem.as_deref().is_some_and(|problem| problem.contains(part));
        self.until(name, Duration::from_secs(60), has_part)
    }

    pub fn gauge(&self, name: &str) -> Gauge {
        self.services.snapshots().gauge(name).unwrap()
    }

    pub fn segment(&self) -> Segment {
        self.services.snapshots().segments().remove(0)
    }

    pub fn samples(&self, name: &str) -> Vec<Sample> {
        assert!(self.services.recorder().flush());
        self.services.recorder().open_reader().unwrap().samples(name, Micros(0), Micros(i64::MAX)).unwrap()
    }

    /// The recorded values of a point.
    pub fn point_samples(&self, slave: &str, name: &str) -> Vec<PointSample> {
        assert!(self.services.recorder().flush());
        let reader = self.services.recorder().open_reader().unwrap();
        let point = reader.point(slave, name, None).unwrap().unwrap();
        reader.point_page(&point, Micros(0), Micros(i64::MAX), u32::MAX).unwrap()
    }

    /// The number of samples of a gauge, those included that the recorder thins out.
    pub fn count(&self, name: &str) -> u32 {
        assert!(self.services.recorder().flush());
        let reader = self.services.recorder().open_reader().unwrap();
        let spans = reader.trend(name, Micros(0), Micros(i64::MAX), 1).unwrap();
        spans.iter().map(|span| span.summary.count).sum()
    }

    /// The events with this part, the first one first.
    pub fn events(&self, part: &str) -> Vec<Event> {
        assert!(self.services.recorder().flush());
        let reader = self.services.recorder().open_reader().unwrap();
        let events = reader.events(Micros(0), Micros(i64::MAX), 1000).unwrap();
        events.into_iter().rev().filter(|event| event.text.contains(part)).collect()
    }
}
