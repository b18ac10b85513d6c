//! The handle of a segment's thread.

use super::edge::{Edge, SegmentCommand, System};
use super::heard_line::HeardLine;
use super::polled_line::PolledLine;
use super::runner::{Runner, RunnerSetup};
use super::services::SegmentServices;
use crate::config;
use crate::view::Gauge;
use profivac_recorder::{EventKind, PointSample, Quality, Sample};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{Receiver, RecvTimeoutError, Sender, channel};
use std::thread::JoinHandle;
use std::time::Instant;

/// The stack of the thread: a master with room for every slave of a bus is moved several times while it is built.
const STACK: usize = 8 << 20;

/// A running segment.
pub struct SegmentHandle {
    config: config::Segment,
    services: SegmentServices,
    commands: Sender<SegmentCommand>,
    /// Carries no messages: it disconnects when the thread ends.
    alive: Receiver<()>,
    /// The thread did not stop in time, and must not publish any more.
    is_abandoned: Arc<AtomicBool>,
    thread: JoinHandle<()>,
}

impl SegmentHandle {
    /// Starts the thread. Problems of port and bus are published, and the thread tries again.
    ///
    /// # Errors
    /// When the system gives no thread.
    pub fn start(config: config::Segment, services: SegmentServices) -> std::io::Result<Self> {
        let (commands, inbox) = channel();
        let (life, alive) = channel();
        let is_abandoned = Arc::new(AtomicBool::new(false));
        let setup = RunnerSetup {
            config: config.clone(),
            services: services.clone(),
            commands: inbox,
            is_abandoned: Arc::clone(&is_abandoned),
            edge: Arc::new(System),
        };
        let thread = std::thread::Builder::new().name(config.name.clone()).stack_size(STACK);
        // The gauges are published before the thread runs: a request right after the start finds them.
        let run: Box<dyn FnOnce() + Send> = if config.listen_only {
            let runner = Runner::<HeardLine>::new(setup);
            Box::new(|| runner.run())
        } else {
            let runner = Runner::<PolledLine>::new(setup);
            Box::new(|| runner.run())
        };
        let thread = thread.spawn(move || {
            let _life: Sender<()> = life;
            run();
        })?;
        Ok(Self { config, services, commands, alive, is_abandoned, thread })
    }

    /// The present configuration.
    #[must_use]
    pub const fn config(&self) -> &config::Segment {
        &self.config
    }

    /// Whether the segment can take a new configuration without a restart: only its gauges differ.
    #[must_use]
    pub fn can_reconfigure(&self, new: &config::Segment) -> bool {
        config::Segment { gauges: Vec::new(), ..self.config.clone() }
            == config::Segment { gauges: Vec::new(), ..new.clone() }
    }

    /// Takes other gauges. Gauges that stay are not disturbed.
    pub fn reconfigure(&mut self, new: config::Segment) {
        if self.config != new {
            // A thread that has ended is restarted with the new configuration.
            self.commands.send(SegmentCommand::Gauges(new.gauges.clone())).ok();
            self.config = new;
        }
    }

    /// Whether the thread has ended, which only a defect can cause.
    #[must_use]
    pub fn has_ended(&self) -> bool {
        self.thread.is_finished()
    }

    /// Tells the thread to release its slaves and to stop.
    pub fn begin_to_stop(&self) {
        self.commands.send(SegmentCommand::Stop).ok();
    }

    /// Stops the thread, waiting until `end`. A thread that takes longer, for instance in a port that does not answer, is abandoned.
    pub fn stop(self, end: Instant) {
        self.begin_to_stop();
        let remaining = end.saturating_duration_since(System.now().at);
        if self.alive.recv_timeout(remaining) == Err(RecvTimeoutError::Disconnected) {
            self.thread.join().ok();
        } else {
            self.is_abandoned.store(true, Ordering::Relaxed);
            record_abandoned(&self.services, &self.config);
        }
        self.services.snapshots.remove(&self.config.name);
        self.services.control.requests().close(&self.config.name);
    }
}

/// Records an event and a gap for each series and point of a segment that did not stop in time.
fn record_abandoned(services: &SegmentServices, segment: &config::Segment) {
    let text = format!("segment {} did not stop in time and was abandoned", segment.name);
    let now = System.now().wall;
    services.recorder.event_at(now, None, EventKind::Station, text);
    let gauges: Vec<_> =
        services.snapshots.gauges().into_iter().filter(|gauge| gauge.segment == segment.name).collect();
    let lost = |gauge: &Gauge| Gauge { lost_at: gauge.lost_at.or(Some(now)), ..gauge.clone() };
    services.snapshots.keep_losses(gauges.iter().map(lost));
    let readings =
        gauges.into_iter().flat_map(|gauge| gauge.readings).filter(|reading| reading.quality != Quality::Stale);
    for reading in readings {
        services.recorder.push(&Arc::from(reading.series), Sample::gap(now));
    }
    for slave in &segment.slaves {
        let shown = services.snapshots.gauge(&slave.name).map(|gauge| gauge.parameters).unwrap_or_default();
        for (settings, _) in slave.points.iter().zip(shown.iter()).filter(|(_, point)| point.quality != Quality::Stale)
        {
            services.recorder.push_point(&Arc::new(settings.recorded(&slave.name)), 0.0, PointSample::gap(now));
        }
    }
}
