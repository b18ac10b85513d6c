//! A segment: a thread that owns a port and a master, and nothing of any other segment.
//!
//! ```text
//! Waiting ── port is there ── Running ── gauges are looked for, taken, watched ──┐
//!    ▲                          ▲ └──────────── serve, sample, answer ───────────┤
//!    └── port is lost, back-off ┴────────────────────────────────────────────────┘
//! ```

mod demo_segment;
mod execute;
mod gauge_session;
mod requests;

pub use demo_segment::DemoSegment;

use crate::config;
use crate::services::{SegmentRequest, SegmentSnapshot, Services};
use crate::view;
use gauge_session::GaugeSession;
use profivac_dp::link::Baud;
use profivac_dp::link::active::RingState;
use profivac_dp::master::Mode;
use profivac_host::port::PortError;
use profivac_host::session::{BusMaster, BusSession, SessionError, UnrestoredRecord, bus_parameters};
use profivac_recorder::EventKind;
use profivac_virtual::open;
use std::collections::BTreeMap;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{Receiver, RecvTimeoutError, Sender, TryRecvError, channel};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

/// How long the master waits for a line that is in use, and for a gauge that is slow. While it waits it serves.
const TIMEOUT: Duration = Duration::from_secs(5);

/// The line is served at least so often, to look at orders and the clock.
const SERVE_INTERVAL: Duration = Duration::from_millis(50);

/// How often what is seen is shown.
const PUBLISH_INTERVAL: Duration = Duration::from_millis(100);

/// Pauses before a port is tried again: the first, and the longest.
const FIRST_PAUSE: Duration = Duration::from_millis(500);
const LONGEST_PAUSE: Duration = Duration::from_secs(30);

/// A master with room for every slave a bus can have is moved a few times while it is made.
const STACK: usize = 8 << 20;

/// What a segment is told.
enum SegmentCommand {
    /// Its gauges are these from now on.
    Gauges(Vec<config::Gauge>),
    /// Slaves are given back, then it ends.
    Stop,
}

/// A segment that runs.
pub struct SegmentHandle {
    config: config::Segment,
    plant: Arc<Services>,
    orders: Sender<SegmentCommand>,
    /// Nothing ever comes here: its other end is gone when the thread is.
    alive: Receiver<()>,
    /// The thread was left, and shows nothing any more.
    is_abandoned: Arc<AtomicBool>,
    thread: JoinHandle<()>,
}

impl SegmentHandle {
    /// Begins. What is in the way on the bus is shown, and tried again.
    ///
    /// # Errors
    /// When the system gives no thread.
    pub fn start(config: config::Segment, plant: Arc<Services>) -> std::io::Result<Self> {
        let (orders, inbox) = channel();
        let (life, alive) = channel();
        let is_left = Arc::new(AtomicBool::new(false));
        let worker = SegmentThread::new(config.clone(), Arc::clone(&plant), inbox, Arc::clone(&is_left));
        let thread = std::thread::Builder::new().name(config.name.clone()).stack_size(STACK);
        let thread = thread.spawn(move || {
            let _life: Sender<()> = life;
            worker.run();
        })?;
        Ok(Self { config, plant, orders, alive, is_abandoned: is_left, thread })
    }

    /// What it was started with, or told since.
    #[must_use]
    pub const fn config(&self) -> &config::Segment {
        &self.config
    }

    /// Whether it can become `new` without being started again.
    #[must_use]
    pub fn can_reconfigure(&self, new: &config::Segment) -> bool {
        config::Segment { gauges: Vec::new(), ..self.config.clone() }
            == config::Segment { gauges: Vec::new(), ..new.clone() }
    }

    /// Takes other gauges; those that stay are not disturbed.
    pub fn reconfigure(&mut self, new: config::Segment) {
        if self.config != new {
            // A segment that has ended is started again by whoever watches it.
            self.orders.send(SegmentCommand::Gauges(new.gauges.clone())).ok();
            self.config = new;
        }
    }

    /// Whether its thread has ended, which only a defect can bring about.
    #[must_use]
    pub fn has_ended(&self) -> bool {
        self.thread.is_finished()
    }

    /// Begins to give the slaves back and to end.
    pub fn begin_to_stop(&self) {
        self.orders.send(SegmentCommand::Stop).ok();
    }

    /// Ends until `end`. What takes longer, a port that does not come back for instance, is left to itself.
    pub fn stop(self, end: Instant) {
        self.begin_to_stop();
        if self.alive.recv_timeout(end.saturating_duration_since(Instant::now())) == Err(RecvTimeoutError::Disconnected)
        {
            self.thread.join().ok();
        } else {
            self.is_abandoned.store(true, Ordering::Relaxed);
            self.plant.abandon(&self.config.name);
        }
        self.plant.forget(&self.config.name);
    }
}

/// Why the line is not served any more.
enum ServeEnd {
    Stopped,
    Lost(SessionError),
}

impl From<PortError> for ServeEnd {
    fn from(error: PortError) -> Self {
        Self::Lost(error.into())
    }
}

struct SegmentThread {
    config: config::Segment,
    plant: Arc<Services>,
    orders: Receiver<SegmentCommand>,
    questions: Receiver<SegmentRequest>,
    members: Arc<Mutex<Vec<GaugeSession>>>,
    is_left: Arc<AtomicBool>,
    /// The records that the last session could not set back, by address.
    unrestored: BTreeMap<u8, UnrestoredRecord>,
    trouble: Option<String>,
    show_at: Instant,
}

impl SegmentThread {
    fn new(
        config: config::Segment,
        plant: Arc<Services>,
        orders: Receiver<SegmentCommand>,
        is_left: Arc<AtomicBool>,
    ) -> Self {
        let questions = plant.accept_requests(&config.name);
        let members = Arc::new(Mutex::new(config.gauges.iter().cloned().map(GaugeSession::new).collect()));
        Self {
            config,
            plant,
            orders,
            questions,
            members,
            is_left,
            unrestored: BTreeMap::new(),
            trouble: None,
            show_at: Instant::now(),
        }
    }

    /// The gauges. Nobody may hold them while something is asked: meanwhile they are sampled.
    fn members(&self) -> MutexGuard<'_, Vec<GaugeSession>> {
        self.members.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn run(mut self) {
        let mut pause = FIRST_PAUSE;
        self.publish(None);
        loop {
            let ended = match self.open() {
                Ok(mut tool) => {
                    pause = FIRST_PAUSE;
                    self.clear_fault();
                    for (address, record) in std::mem::take(&mut self.unrestored) {
                        tool.keep_unrestored(address, record);
                    }
                    let ended = self.serve(&mut tool);
                    // A selector that was moved when the port was lost is restored once the port is open again.
                    self.unrestored = tool.take_all_unrestored();
                    ended
                }
                Err(error) => ServeEnd::Lost(error),
            };
            match ended {
                ServeEnd::Stopped => break,
                ServeEnd::Lost(error) => self.lost(&error),
            }
            if self.rest(pause) {
                break;
            }
            pause = pause.saturating_mul(2).min(LONGEST_PAUSE);
        }
    }

    fn open(&self) -> Result<BusSession, SessionError> {
        let config::Segment { port, baud, master, .. } = &self.config;
        let mut session = BusSession::new(open::port(port, *baud)?, *baud, bus_parameters(*master, *baud), TIMEOUT)?;
        session.master().set_mode(Mode::Operate);
        session.set_background_task(self.bystander());
        Ok(session)
    }

    /// What goes on while something that takes long is asked: gauges are sampled and shown.
    fn bystander(&self) -> impl FnMut(&mut BusMaster) + Send + use<> {
        let (members, plant, is_left) = (Arc::clone(&self.members), Arc::clone(&self.plant), Arc::clone(&self.is_left));
        let name = self.config.name.clone();
        let mut show_at = Instant::now();
        move |master| {
            let Ok(mut members) = members.try_lock() else { return };
            members.iter_mut().for_each(|member| member.sample(&plant, master));
            if Instant::now() >= show_at && !is_left.load(Ordering::Relaxed) {
                show_at = Instant::now() + PUBLISH_INTERVAL;
                plant.publish_gauges(&name, members.iter().map(|member| member.gauge(&name)).collect());
            }
        }
    }

    /// The port is there.
    fn clear_fault(&mut self) {
        self.trouble = None;
        let name = &self.config.name;
        self.plant.record_event(None, EventKind::Bus, format!("segment {name}: {} is open", self.config.port));
    }

    /// The port is not there any more, or not yet.
    fn lost(&mut self, error: &SessionError) {
        let sentence = error.to_string();
        self.members().iter_mut().for_each(|member| member.disconnect(&self.plant, &sentence));
        if self.trouble.as_ref() != Some(&sentence) {
            self.plant.record_event(None, EventKind::Bus, format!("segment {}: {sentence}", self.config.name));
            self.trouble = Some(sentence);
        }
        self.publish(None);
    }

    /// Waits before the port is tried again. Says whether to stop.
    fn rest(&mut self, pause: Duration) -> bool {
        let end = Instant::now() + pause;
        loop {
            requests::refuse_all(&self.questions, self.trouble.as_deref().unwrap_or("the segment does not run"));
            let left = end.saturating_duration_since(Instant::now());
            match self.orders.recv_timeout(left.min(SERVE_INTERVAL)) {
                Ok(SegmentCommand::Stop) => return true,
                Ok(SegmentCommand::Gauges(gauges)) => self.reconfigure_gauges(gauges, None),
                Err(_) if left.is_zero() => return false,
                Err(_) => {}
            }
            if Instant::now() >= self.show_at {
                self.publish(None);
            }
        }
    }

    /// Serves the line until it is lost or nobody needs it any more.
    fn serve(&mut self, tool: &mut BusSession) -> ServeEnd {
        let ended = loop {
            if let Err(ended) = self.serve_once(tool) {
                break ended;
            }
        };
        if matches!(ended, ServeEnd::Stopped) {
            self.release_slaves(tool);
        }
        ended
    }

    fn serve_once(&mut self, tool: &mut BusSession) -> Result<(), ServeEnd> {
        match self.orders.try_recv() {
            Ok(SegmentCommand::Stop) | Err(TryRecvError::Disconnected) => return Err(ServeEnd::Stopped),
            Ok(SegmentCommand::Gauges(gauges)) => self.reconfigure_gauges(gauges, Some(&mut *tool)),
            Err(TryRecvError::Empty) => {}
        }
        let due = self.members().iter().map(GaugeSession::due).min().unwrap_or_else(|| Instant::now() + SERVE_INTERVAL);
        tool.serve(&[], due.saturating_duration_since(Instant::now()).min(SERVE_INTERVAL))?;
        while let Some(remark) = tool.next_notice() {
            self.plant.record_event(None, EventKind::Bus, format!("segment {}: {remark}", self.config.name));
        }
        self.search_next(tool)?;
        self.members().iter_mut().for_each(|member| member.sample(&self.plant, tool.master()));
        if Instant::now() >= self.show_at {
            self.publish(Some(&mut *tool));
        }
        requests::answer_next(self, tool).map_err(|error| ServeEnd::Lost(PortError::Lost(error).into()))
    }

    /// Looks for one gauge that is not there yet, if the time for it has come.
    fn search_next(&mut self, tool: &mut BusSession) -> Result<(), ServeEnd> {
        let gauge =
            self.members().iter_mut().find_map(|member| member.takes_search_turn().then(|| member.config.clone()));
        let Some(gauge) = gauge else { return Ok(()) };
        let met = gauge_session::find_gauge(tool, &gauge, self.config.master)?;
        if let Some(member) = self.members().iter_mut().find(|member| member.config.address == gauge.address) {
            member.search_finished(&self.plant, tool.master(), self.config.baud, met);
        }
        Ok(())
    }

    /// Other gauges; those that stay the same are not touched.
    fn reconfigure_gauges(&mut self, gauges: Vec<config::Gauge>, mut tool: Option<&mut BusSession>) {
        let mut members = self.members();
        let mut old = std::mem::take(&mut *members);
        for gauge in gauges {
            let kept = old.iter().position(|member| member.config.is_same_slave(&gauge));
            members.push(match kept {
                Some(place) => old.remove(place).with_config(gauge),
                None => GaugeSession::new(gauge),
            });
        }
        for mut gone in old {
            gone.disconnect(&self.plant, "it was taken out of the station");
            if let Some(tool) = &mut tool {
                gone.release(tool);
            }
        }
    }

    /// Gives all slaves back.
    fn release_slaves(&mut self, tool: &mut BusSession) {
        let addresses: Vec<_> = tool.master().addresses().collect();
        addresses.iter().for_each(|address| tool.master().release(*address));
        let end = Instant::now() + Duration::from_secs(1);
        while tool.master().exchanging() > 0 && Instant::now() < end {
            if tool.serve(&[], SERVE_INTERVAL).is_err() {
                break;
            }
        }
        self.members().iter_mut().for_each(|member| member.disconnect(&self.plant, "the segment was stopped"));
    }

    /// Shows what is seen now.
    fn publish(&mut self, tool: Option<&mut BusSession>) {
        self.show_at = Instant::now() + PUBLISH_INTERVAL;
        if self.is_left.load(Ordering::Relaxed) {
            return;
        }
        let config = &self.config;
        let (state, trouble, cycle_ms, damaged, others) = match tool {
            None => (view::SegmentState::Waiting, None, None, 0, Vec::new()),
            Some(tool) => bus_state(tool, config),
        };
        let own = view::BusStation {
            address: config.master,
            standing: view::BusStationState::Ourselves,
            name: None,
            device: None,
            ident: None,
            words: "our master".to_owned(),
        };
        let ours = self.members();
        let is_ours = |address| ours.iter().any(|member| member.config.address == address);
        let members = ours.iter().map(GaugeSession::bus_station);
        let others = others.into_iter().filter(|other: &view::BusStation| !is_ours(other.address));
        let mut stations: Vec<_> = std::iter::once(own).chain(members).chain(others).collect();
        stations.sort_by_key(|station| station.address);
        let segment = view::Segment {
            name: config.name.clone(),
            port: config.port.clone(),
            baud: config.baud.bits_per_second(),
            master: config.master,
            state,
            trouble: self.trouble.clone().or(trouble),
            cycle_ms,
            damaged,
            stations,
        };
        let gauges = ours.iter().map(|member| member.gauge(&config.name)).collect();
        self.plant.publish(SegmentSnapshot { segment, gauges });
    }
}

type BusState = (view::SegmentState, Option<String>, Option<f64>, u32, Vec<view::BusStation>);

/// What the master sees.
fn bus_state(tool: &mut BusSession, config: &config::Segment) -> BusState {
    let standing = tool.standing();
    let (state, trouble) = match standing {
        RingState::InRing => (view::SegmentState::Running, None),
        RingState::AddressTaken => (view::SegmentState::Listening, Some(format!("our master {standing}"))),
        RingState::Offline | RingState::Listening | RingState::Ready => (view::SegmentState::Listening, None),
    };
    let cycle_ms = milliseconds(tool.master().cycle_tbit(), config.baud);
    let masters: Vec<_> = tool.masters().collect();
    let others = masters.into_iter().filter(|address| *address != config.master).map(|address| view::BusStation {
        address,
        standing: view::BusStationState::Master,
        name: None,
        device: None,
        ident: None,
        words: "another master in the ring".to_owned(),
    });
    let mut stations: Vec<_> = others.collect();
    for address in tool.known_slaves() {
        stations.push(view::BusStation {
            address,
            standing: view::BusStationState::Foreign,
            name: None,
            device: None,
            ident: None,
            words: "a slave that is not in the station's file".to_owned(),
        });
    }
    (state, trouble, cycle_ms, tool.damaged_telegrams(), stations)
}

fn milliseconds(tbit: u64, baud: Baud) -> Option<f64> {
    (tbit > 0).then(|| tbit as f64 * 1e3 / f64::from(baud.bits_per_second()))
}
