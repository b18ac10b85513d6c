//! A segment: a thread that owns a port and a master, and nothing of any other segment.
//!
//! ```text
//! Waiting ── port is there ── Running ── gauges are looked for, taken, watched ──┐
//!    ▲                          ▲ └──────────── serve, sample, answer ───────────┤
//!    └── port is lost, back-off ┴────────────────────────────────────────────────┘
//! ```

mod deeds;
mod exhibit;
mod member;
mod questions;

pub use exhibit::Exhibit;

use crate::config;
use crate::plant::{Plant, Question, Scenery};
use crate::view;
use member::Member;
use profivac_dp::link::Baud;
use profivac_dp::link::active::Standing;
use profivac_dp::master::Mode;
use profivac_host::port::PortError;
use profivac_host::session::{BusMaster, BusSession, SessionError, bus_parameters};
use profivac_recorder::EventKind;
use profivac_virtual::open;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{Receiver, RecvTimeoutError, Sender, TryRecvError, channel};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

/// How long the master waits for a line that is in use, and for a gauge that is slow. While it waits it serves.
const PATIENCE: Duration = Duration::from_secs(5);

/// The line is served at least so often, to look at orders and the clock.
const SERVE: Duration = Duration::from_millis(50);

/// How often what is seen is shown.
const SHOW: Duration = Duration::from_millis(100);

/// Pauses before a port is tried again: the first, and the longest.
const FIRST_PAUSE: Duration = Duration::from_millis(500);
const LONGEST_PAUSE: Duration = Duration::from_secs(30);

/// A master with room for every slave a bus can have is moved a few times while it is made.
const STACK: usize = 8 << 20;

/// What a segment is told.
enum Order {
    /// Its gauges are these from now on.
    Gauges(Vec<config::Gauge>),
    /// Slaves are given back, then it ends.
    Stop,
}

/// A segment that runs.
pub struct Running {
    config: config::Segment,
    plant: Arc<Plant>,
    orders: Sender<Order>,
    /// Nothing ever comes here: its other end is gone when the thread is.
    alive: Receiver<()>,
    /// The thread was left, and shows nothing any more.
    is_left: Arc<AtomicBool>,
    thread: JoinHandle<()>,
}

impl Running {
    /// Begins. What is in the way on the bus is shown, and tried again.
    ///
    /// # Errors
    /// When the system gives no thread.
    pub fn start(config: config::Segment, plant: Arc<Plant>) -> std::io::Result<Self> {
        let (orders, inbox) = channel();
        let (life, alive) = channel();
        let is_left = Arc::new(AtomicBool::new(false));
        let worker = Worker::new(config.clone(), Arc::clone(&plant), inbox, Arc::clone(&is_left));
        let thread = std::thread::Builder::new().name(config.name.clone()).stack_size(STACK);
        let thread = thread.spawn(move || {
            let _life: Sender<()> = life;
            worker.run();
        })?;
        Ok(Self { config, plant, orders, alive, is_left, thread })
    }

    /// What it was started with, or told since.
    #[must_use]
    pub const fn config(&self) -> &config::Segment {
        &self.config
    }

    /// Whether it can become `new` without being started again.
    #[must_use]
    pub fn can_become(&self, new: &config::Segment) -> bool {
        config::Segment { gauges: Vec::new(), ..self.config.clone() }
            == config::Segment { gauges: Vec::new(), ..new.clone() }
    }

    /// Takes other gauges; those that stay are not disturbed.
    pub fn become_like(&mut self, new: config::Segment) {
        if self.config != new {
            // A segment that has ended is started again by whoever watches it.
            self.orders.send(Order::Gauges(new.gauges.clone())).ok();
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
        self.orders.send(Order::Stop).ok();
    }

    /// Ends until `end`. What takes longer, a port that does not come back for instance, is left to itself.
    pub fn stop(self, end: Instant) {
        self.begin_to_stop();
        if self.alive.recv_timeout(end.saturating_duration_since(Instant::now())) == Err(RecvTimeoutError::Disconnected)
        {
            self.thread.join().ok();
        } else {
            self.is_left.store(true, Ordering::Relaxed);
            self.plant.abandon(&self.config.name);
        }
        self.plant.forget(&self.config.name);
    }
}

/// Why the line is not served any more.
enum Ended {
    Stopped,
    Lost(PortError),
}

impl From<PortError> for Ended {
    fn from(error: PortError) -> Self {
        Self::Lost(error)
    }
}

struct Worker {
    config: config::Segment,
    plant: Arc<Plant>,
    orders: Receiver<Order>,
    questions: Receiver<Question>,
    members: Arc<Mutex<Vec<Member>>>,
    is_left: Arc<AtomicBool>,
    trouble: Option<String>,
    show_at: Instant,
}

impl Worker {
    fn new(config: config::Segment, plant: Arc<Plant>, orders: Receiver<Order>, is_left: Arc<AtomicBool>) -> Self {
        let questions = plant.take_questions(&config.name);
        let members = Arc::new(Mutex::new(config.gauges.iter().cloned().map(Member::new).collect()));
        Self { config, plant, orders, questions, members, is_left, trouble: None, show_at: Instant::now() }
    }

    /// The gauges. Nobody may hold them while something is asked: meanwhile they are sampled.
    fn members(&self) -> MutexGuard<'_, Vec<Member>> {
        self.members.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn run(mut self) {
        let mut pause = FIRST_PAUSE;
        self.show(None);
        loop {
            let ended = match self.open() {
                Ok(mut tool) => {
                    pause = FIRST_PAUSE;
                    self.fine();
                    self.serve(&mut tool)
                }
                Err(error) => Ended::Lost(error),
            };
            match ended {
                Ended::Stopped => break,
                Ended::Lost(error) => self.lost(&error),
            }
            if self.rest(pause) {
                break;
            }
            pause = pause.saturating_mul(2).min(LONGEST_PAUSE);
        }
    }

    fn open(&self) -> Result<BusSession, PortError> {
        let config::Segment { port, baud, master, .. } = &self.config;
        let opened = BusSession::new(open::port(port, *baud)?, *baud, bus_parameters(*master, *baud), PATIENCE);
        match opened {
            Ok(mut tool) => {
                tool.master().set_mode(Mode::Operate);
                tool.do_beside(self.bystander());
                Ok(tool)
            }
            Err(SessionError::Port(error)) => Err(error),
            // The parameters of a checked file are possible.
            Err(
                SessionError::Parameters(_)
                | SessionError::Taken(_)
                | SessionError::AddressTaken(_)
                | SessionError::Babble,
            ) => Err(PortError::Lost(port.clone())),
        }
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
                show_at = Instant::now() + SHOW;
                plant.show_gauges(&name, members.iter().map(|member| member.gauge(&name)).collect());
            }
        }
    }

    /// The port is there.
    fn fine(&mut self) {
        self.trouble = None;
        let name = &self.config.name;
        self.plant.remark(None, EventKind::Bus, format!("segment {name}: {} is open", self.config.port));
    }

    /// The port is not there any more, or not yet.
    fn lost(&mut self, error: &PortError) {
        let sentence = error.to_string();
        self.members().iter_mut().for_each(|member| member.lose(&self.plant, &sentence));
        if self.trouble.as_ref() != Some(&sentence) {
            self.plant.remark(None, EventKind::Bus, format!("segment {}: {sentence}", self.config.name));
            self.trouble = Some(sentence);
        }
        self.show(None);
    }

    /// Waits before the port is tried again. Says whether to stop.
    fn rest(&mut self, pause: Duration) -> bool {
        let end = Instant::now() + pause;
        loop {
            questions::refuse(&self.questions, self.trouble.as_deref().unwrap_or("the segment does not run"));
            let left = end.saturating_duration_since(Instant::now());
            match self.orders.recv_timeout(left.min(SERVE)) {
                Ok(Order::Stop) => return true,
                Ok(Order::Gauges(gauges)) => self.take_gauges(gauges, None),
                Err(_) if left.is_zero() => return false,
                Err(_) => {}
            }
            if Instant::now() >= self.show_at {
                self.show(None);
            }
        }
    }

    /// Serves the line until it is lost or nobody needs it any more.
    fn serve(&mut self, tool: &mut BusSession) -> Ended {
        let ended = loop {
            if let Err(ended) = self.once(tool) {
                break ended;
            }
        };
        if matches!(ended, Ended::Stopped) {
            self.farewell(tool);
        }
        ended
    }

    fn once(&mut self, tool: &mut BusSession) -> Result<(), Ended> {
        match self.orders.try_recv() {
            Ok(Order::Stop) | Err(TryRecvError::Disconnected) => return Err(Ended::Stopped),
            Ok(Order::Gauges(gauges)) => self.take_gauges(gauges, Some(&mut *tool)),
            Err(TryRecvError::Empty) => {}
        }
        let due = self.members().iter().map(Member::due).min().unwrap_or_else(|| Instant::now() + SERVE);
        tool.serve(&[], due.saturating_duration_since(Instant::now()).min(SERVE))?;
        while let Some(remark) = tool.next_remark() {
            self.plant.remark(None, EventKind::Bus, format!("segment {}: {remark}", self.config.name));
        }
        self.look(tool)?;
        self.members().iter_mut().for_each(|member| member.sample(&self.plant, tool.master()));
        if Instant::now() >= self.show_at {
            self.show(Some(&mut *tool));
        }
        questions::answer(self, tool).map_err(|error| Ended::Lost(PortError::Lost(error)))
    }

    /// Looks for one gauge that is not there yet, if the time for it has come.
    fn look(&mut self, tool: &mut BusSession) -> Result<(), Ended> {
        let gauge = self.members().iter_mut().find_map(|member| member.begins_to_look().then(|| member.config.clone()));
        let Some(gauge) = gauge else { return Ok(()) };
        let met = member::meet(tool, &gauge, self.config.master)?;
        if let Some(member) = self.members().iter_mut().find(|member| member.config.address == gauge.address) {
            member.met(&self.plant, tool.master(), self.config.baud, met);
        }
        Ok(())
    }

    /// Other gauges; those that stay the same are not touched.
    fn take_gauges(&mut self, gauges: Vec<config::Gauge>, mut tool: Option<&mut BusSession>) {
        let mut members = self.members();
        let mut old = std::mem::take(&mut *members);
        for gauge in gauges {
            let kept = old.iter().position(|member| member.config.is_same_slave(&gauge));
            members.push(match kept {
                Some(place) => old.remove(place).renamed(gauge),
                None => Member::new(gauge),
            });
        }
        for mut gone in old {
            gone.lose(&self.plant, "it was taken out of the station");
            if let Some(tool) = &mut tool {
                gone.leave(tool);
            }
        }
    }

    /// Gives all slaves back.
    fn farewell(&mut self, tool: &mut BusSession) {
        let addresses: Vec<_> = tool.master().addresses().collect();
        addresses.iter().for_each(|address| tool.master().release(*address));
        let end = Instant::now() + Duration::from_secs(1);
        while tool.master().exchanging() > 0 && Instant::now() < end {
            if tool.serve(&[], SERVE).is_err() {
                break;
            }
        }
        self.members().iter_mut().for_each(|member| member.lose(&self.plant, "the segment was stopped"));
    }

    /// Shows what is seen now.
    fn show(&mut self, tool: Option<&mut BusSession>) {
        self.show_at = Instant::now() + SHOW;
        if self.is_left.load(Ordering::Relaxed) {
            return;
        }
        let config = &self.config;
        let (state, trouble, cycle_ms, damaged, others) = match tool {
            None => (view::SegmentState::Waiting, None, None, 0, Vec::new()),
            Some(tool) => seen(tool, config),
        };
        let own = view::OnBus {
            address: config.master,
            standing: view::Standing::Ourselves,
            name: None,
            device: None,
            ident: None,
            words: "our master".to_owned(),
        };
        let ours = self.members();
        let is_ours = |address| ours.iter().any(|member| member.config.address == address);
        let members = ours.iter().map(Member::on_bus);
        let others = others.into_iter().filter(|other: &view::OnBus| !is_ours(other.address));
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
        self.plant.show(Scenery { segment, gauges });
    }
}

type Seen = (view::SegmentState, Option<String>, Option<f64>, u32, Vec<view::OnBus>);

/// What the master sees.
fn seen(tool: &mut BusSession, config: &config::Segment) -> Seen {
    let standing = tool.standing();
    let (state, trouble) = match standing {
        Standing::InRing => (view::SegmentState::Running, None),
        Standing::AddressTaken => (view::SegmentState::Listening, Some(format!("our master {standing}"))),
        Standing::Offline | Standing::Listening | Standing::Ready => (view::SegmentState::Listening, None),
    };
    let cycle_ms = milliseconds(tool.master().cycle_tbit(), config.baud);
    let masters: Vec<_> = tool.masters().collect();
    let others = masters.into_iter().filter(|address| *address != config.master).map(|address| view::OnBus {
        address,
        standing: view::Standing::Master,
        name: None,
        device: None,
        ident: None,
        words: "another master in the ring".to_owned(),
    });
    let mut stations: Vec<_> = others.collect();
    for address in tool.slaves() {
        stations.push(view::OnBus {
            address,
            standing: view::Standing::Foreign,
            name: None,
            device: None,
            ident: None,
            words: "a slave that is not in the station's file".to_owned(),
        });
    }
    (state, trouble, cycle_ms, tool.damaged(), stations)
}

fn milliseconds(tbit: u64, baud: Baud) -> Option<f64> {
    (tbit > 0).then(|| tbit as f64 * 1e3 / f64::from(baud.bits_per_second()))
}
