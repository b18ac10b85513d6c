//! Runs a segment: opens its port, serves it, opens it again after it was lost, takes other gauges, publishes, stops.
//!
//! The same for both kinds of [`Line`]: one that the station polls, and one that it only hears. A step takes the time from the
//! [`Edge`]; what serves the line is blocking and gets the edge with the [`Context`].

use super::edge::{Edge, SegmentCommand};
use super::inbox::Inbox;
use super::moment::Moment;
use super::services::SegmentServices;
use crate::config;
use crate::snapshot::SegmentSnapshot;
use profivac_host::port::PortError;
use profivac_host::session::SessionError;
use profivac_recorder::{EventKind, Micros};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{Receiver, RecvTimeoutError, TryRecvError};
use std::time::{Duration, Instant};

/// The longest time without a look at commands and clock.
pub const SERVE_INTERVAL: Duration = Duration::from_millis(50);

/// The time between two snapshots.
pub const PUBLISH_INTERVAL: Duration = Duration::from_millis(100);

/// The first pause before a port is opened again; each further pause is twice as long, up to [`Line::LONGEST_PAUSE`].
pub const FIRST_PAUSE: Duration = Duration::from_millis(500);

/// The problem of a gauge on a segment that was stopped.
const STOPPED: &str = "the segment was stopped";

/// Why a line is not served any more, in a sentence: it is opened again.
#[derive(Debug)]
pub struct Lost(pub String);

impl From<SessionError> for Lost {
    fn from(error: SessionError) -> Self {
        Self(error.to_string())
    }
}

impl From<PortError> for Lost {
    fn from(error: PortError) -> Self {
        Self(error.to_string())
    }
}

/// What a runner starts with.
pub struct RunnerSetup {
    pub config: config::Segment,
    pub services: SegmentServices,
    pub commands: Receiver<SegmentCommand>,
    /// The thread did not stop in time, and must not publish any more.
    pub is_abandoned: Arc<AtomicBool>,
    pub edge: Arc<dyn Edge>,
}

/// What runner and line share.
pub struct Context {
    pub config: config::Segment,
    pub services: SegmentServices,
    pub edge: Arc<dyn Edge>,
    pub inbox: Inbox,
    /// The reason why the port is not open.
    pub problem: Option<String>,
    /// The thread did not stop in time, and must not publish any more.
    pub is_abandoned: Arc<AtomicBool>,
}

impl Context {
    /// The present moment.
    pub fn now(&self) -> Moment {
        self.edge.now()
    }

    /// Since when a gauge that is made `now` has no readings: the segment may have been stopped before.
    pub fn lost_at(&self, gauge: &str, now: Moment) -> Micros {
        self.services.snapshots.loss(gauge).unwrap_or(now.wall)
    }

    /// Records an event of the segment.
    pub fn event(&self, now: Moment, text: impl std::fmt::Display) {
        let text = format!("segment {}: {text}", self.config.name);
        self.services.recorder.event_at(now.wall, None, EventKind::Bus, text);
    }
}

/// A line with its gauges, polled or heard.
pub trait Line: Sized {
    /// The open port, and what serves it.
    type Open;

    /// The longest pause before a port is opened again.
    const LONGEST_PAUSE: Duration;

    /// The line of a segment before its port is open.
    fn new(context: &Context) -> Self;

    /// Opens the port.
    ///
    /// # Errors
    /// [`Lost`] with the reason.
    fn open(&mut self, context: &Context) -> Result<Self::Open, Lost>;

    /// What an event says of an open port.
    fn opened(config: &config::Segment) -> String;

    /// Serves the line once, for [`SERVE_INTERVAL`] at most while nothing is to be done, and samples the gauges.
    ///
    /// # Errors
    /// [`Lost`] when the port is to be opened again.
    fn serve(&mut self, context: &mut Context, open: &mut Self::Open) -> Result<(), Lost>;

    /// Answers or refuses requests of users.
    ///
    /// # Errors
    /// [`Lost`] when the port is to be opened again.
    fn answer(&mut self, context: &mut Context, open: &mut Self::Open) -> Result<(), Lost>;

    /// Takes other gauges. Gauges that stay are not disturbed.
    fn reconfigure(&mut self, context: &Context, open: Option<&mut Self::Open>, gauges: Vec<config::Gauge>);

    /// Leaves the line before the segment stops.
    fn release(&mut self, context: &Context, open: &mut Self::Open);

    /// Keeps what outlasts a port that was lost.
    fn keep(&mut self, open: Self::Open);

    /// Ends the readings of all gauges for this reason.
    fn disconnect(&mut self, context: &Context, now: Moment, problem: &str);

    /// The present state.
    fn snapshot(&self, context: &Context, open: Option<&mut Self::Open>, now: Moment) -> SegmentSnapshot;
}

/// Whether the port is open.
enum Phase<O> {
    Closed { open_at: Instant },
    Open(O),
    Stopped,
}

/// What follows a step.
enum Next<O> {
    Same,
    Opened(O),
    Lost(Lost),
    Stopped,
}

/// A segment that runs.
pub struct Runner<L: Line> {
    parts: Parts<L>,
    phase: Phase<L::Open>,
}

/// A runner without its port.
struct Parts<L> {
    context: Context,
    line: L,
    commands: Receiver<SegmentCommand>,
    /// The pause that follows the next loss of the port.
    pause: Duration,
    publish_at: Instant,
}

impl<L: Line> Runner<L> {
    /// A segment whose port is opened in the first step. Its gauges are published at once: a request right after the start finds them.
    pub fn new(setup: RunnerSetup) -> Self {
        let RunnerSetup { config, services, commands, is_abandoned, edge } = setup;
        let inbox = Inbox::new(services.control.requests().accept(&config.name));
        let context = Context { config, services, edge, inbox, problem: None, is_abandoned };
        let (line, now) = (L::new(&context), context.now());
        let mut parts = Parts { context, line, commands, pause: FIRST_PAUSE, publish_at: now.at };
        parts.publish(None);
        Self { parts, phase: Phase::Closed { open_at: now.at } }
    }

    /// Runs until the station stops it.
    pub fn run(mut self) {
        while self.step() {}
    }

    /// Serves the line, or waits before it is opened, for a short time. Returns whether the segment goes on: only
    /// [`SegmentCommand::Stop`] ends it.
    pub fn step(&mut self) -> bool {
        let next = match &mut self.phase {
            Phase::Closed { open_at } => self.parts.wait(*open_at),
            Phase::Open(open) => self.parts.serve(open),
            Phase::Stopped => return false,
        };
        match next {
            Next::Same => {}
            Next::Opened(open) => self.phase = Phase::Open(open),
            Next::Stopped => self.phase = Phase::Stopped,
            Next::Lost(lost) => self.lose(lost),
        }
        !matches!(self.phase, Phase::Stopped)
    }

    fn lose(&mut self, lost: Lost) {
        let closed = Phase::Closed { open_at: self.parts.context.now().at };
        if let Phase::Open(open) = std::mem::replace(&mut self.phase, closed) {
            self.parts.line.keep(open);
        }
        self.phase = Phase::Closed { open_at: self.parts.lose(lost) };
    }
}

impl<L: Line> Parts<L> {
    /// Opens the port if its time has come; waits for a command otherwise.
    fn wait(&mut self, open_at: Instant) -> Next<L::Open> {
        let left = open_at.saturating_duration_since(self.context.now().at);
        if left.is_zero() {
            return self.open();
        }
        let problem = self.context.problem.as_deref().unwrap_or("the segment does not run");
        self.context.inbox.refuse_all(&self.context.services, problem);
        match self.context.edge.command(&self.commands, left.min(SERVE_INTERVAL)) {
            Ok(SegmentCommand::Gauges(gauges)) => self.line.reconfigure(&self.context, None, gauges),
            Ok(SegmentCommand::Stop) | Err(RecvTimeoutError::Disconnected) => {
                return self.stop();
            }
            Err(RecvTimeoutError::Timeout) => {}
        }
        self.publish_if_due(None);
        Next::Same
    }

    fn open(&mut self) -> Next<L::Open> {
        match self.line.open(&self.context) {
            Ok(open) => {
                (self.pause, self.context.problem) = (FIRST_PAUSE, None);
                self.context.event(self.context.now(), L::opened(&self.context.config));
                Next::Opened(open)
            }
            Err(lost) => Next::Lost(lost),
        }
    }

    fn serve(&mut self, open: &mut L::Open) -> Next<L::Open> {
        match self.commands.try_recv() {
            Ok(SegmentCommand::Stop) | Err(TryRecvError::Disconnected) => {
                self.line.release(&self.context, open);
                return self.stop();
            }
            Ok(SegmentCommand::Gauges(gauges)) => self.line.reconfigure(&self.context, Some(&mut *open), gauges),
            Err(TryRecvError::Empty) => {}
        }
        let served = self.line.serve(&mut self.context, open).and_then(|()| {
            self.publish_if_due(Some(&mut *open));
            self.line.answer(&mut self.context, open)
        });
        served.map_or_else(Next::Lost, |()| Next::Same)
    }

    /// Ends all readings, and keeps the times at which they ended.
    fn stop(&mut self) -> Next<L::Open> {
        let now = self.context.now();
        self.line.disconnect(&self.context, now, STOPPED);
        if !self.context.is_abandoned.load(Ordering::Relaxed) {
            let SegmentSnapshot { gauges, .. } = self.line.snapshot(&self.context, None, now);
            self.context.services.snapshots.keep_losses(gauges);
        }
        Next::Stopped
    }

    /// Notes why the line is not served any more. Returns when the port is opened again.
    fn lose(&mut self, Lost(problem): Lost) -> Instant {
        let now = self.context.now();
        self.line.disconnect(&self.context, now, &problem);
        if self.context.problem.as_ref() != Some(&problem) {
            self.context.event(now, &problem);
            self.context.problem = Some(problem);
        }
        self.publish(None);
        let pause = self.pause;
        self.pause = pause.saturating_mul(2).min(L::LONGEST_PAUSE);
        now.at.checked_add(pause).unwrap_or(now.at)
    }

    fn publish_if_due(&mut self, open: Option<&mut L::Open>) {
        if self.context.now().at >= self.publish_at {
            self.publish(open);
        }
    }

    fn publish(&mut self, open: Option<&mut L::Open>) {
        let now = self.context.now();
        self.publish_at = now.at + PUBLISH_INTERVAL;
        if !self.context.is_abandoned.load(Ordering::Relaxed) {
            self.context.services.snapshots.publish(self.line.snapshot(&self.context, open, now));
        }
    }
}
