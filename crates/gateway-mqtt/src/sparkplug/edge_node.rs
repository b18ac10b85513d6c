//! The edge node of one connection, as a state machine without input and output: it gets what happens and returns what to publish.
//!
//! | Phase | What happens | It publishes | Next phase |
//! |---|---|---|---|
//! | Subscribing | the broker has accepted the subscriptions | | Waiting; Ready without a primary host |
//! | Waiting | the primary host is online | | Ready |
//! | Ready | births are asked for | NBIRTH, DBIRTH of each device | Backlog |
//! | Backlog | samples of the outage | DDATA, historical | Backlog |
//! | Backlog | the database has no more | DDATA, NDATA of the last seconds | Live |
//! | Live | a new snapshot | DDATA, NDATA, DBIRTH, DDEATH | Live |
//! | Backlog, Live | a rebirth is due | NBIRTH, DBIRTH of each device | the same |
//! | Ready, Backlog, Live | the primary host is offline | NDEATH | Ended |
//!
//! Assertions of Sparkplug 3.0 are cited by their identifiers, which begin with `tck-id-`.

use super::backlog::{Recorded, Series};
use super::metric::{self, Identity};
use super::payload::{Metric, MetricValue, Payload, datatype};
use crate::message::{Delivery, Message};
use crate::topic::level;
use crate::tracker::Tracker;
use profivac_gateway::signal::gauge_state;
use profivac_gateway::{Point, PointValue, Signal, Snapshot, Value};
use profivac_recorder::Micros;
use profivac_station::config::gateways::mqtt::DataStyle;
use prost::Message as _;
use serde::Deserialize;
use std::collections::{BTreeMap, BTreeSet, HashMap, HashSet, VecDeque};
use std::sync::Arc;
use std::time::Duration;

/// The namespace (tck-id-topic-structure-namespace-a).
const NAMESPACE: &str = "spBv1.0";

/// The one command.
pub const REBIRTH: &str = "Node Control/Rebirth";

/// The metric that connects a birth with its death.
pub const BD_SEQ: &str = "bdSeq";

/// How far the clock of the primary host may be ahead of that of the station.
const CLOCK_TOLERANCE: Duration = Duration::from_secs(86_400);

/// The shortest time between two births. chosen: several hosts that ask at the same time get one answer.
pub const REBIRTH_PAUSE: Duration = Duration::from_secs(2);

/// The snapshots that are kept until the end of the backlog: four seconds, more than the database is late.
const RECENT: usize = 40;

/// The names of the edge node.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Names {
    /// The group.
    pub group: String,
    /// The edge node.
    pub edge_node: String,
    /// The primary host, if the edge node waits for one.
    pub primary_host: Option<String>,
    /// What identifies a metric in data.
    pub data: DataStyle,
}

impl Names {
    /// The topic of a message of the edge node, or of a device.
    #[must_use]
    pub fn topic(&self, verb: &str, device: Option<&str>) -> String {
        let Self { group, edge_node, .. } = self;
        let device = device.map(|device| format!("/{device}")).unwrap_or_default();
        format!("{NAMESPACE}/{group}/{verb}/{edge_node}{device}")
    }

    fn state_topic(&self) -> Option<String> {
        self.primary_host.as_ref().map(|host| format!("{NAMESPACE}/STATE/{host}"))
    }

    /// tck-id-message-flow-edge-node-ncmd-subscribe, tck-id-message-flow-device-dcmd-subscribe; the broker delivers with `QoS` 1.
    #[must_use]
    pub fn subscriptions(&self) -> Vec<String> {
        let commands = [self.topic("NCMD", None), self.topic("DCMD", Some("+"))];
        commands.into_iter().chain(self.state_topic()).collect()
    }
}

/// The state of a primary host.
#[derive(Deserialize)]
struct HostState {
    online: bool,
    timestamp: u64,
}

/// The state of the edge node.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Phase {
    /// The broker has not accepted the subscriptions yet.
    Subscribing,
    /// The primary host is not online.
    Waiting,
    /// Births may be published.
    Ready,
    /// The samples of the outage are published.
    Backlog,
    /// The present values are published.
    Live,
    /// The edge node has died.
    Ended,
}

/// What a received message means.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Reaction {
    /// Nothing is to be done now.
    None,
    /// The host has gone: publish this and disconnect.
    Disconnect(Message),
    /// The message was refused, for this reason.
    Refused(String),
}

/// A gauge as a device.
#[derive(Clone, Debug)]
struct Device {
    /// Its element of the topic.
    id: String,
    /// The positions of its points.
    positions: Vec<usize>,
    /// The position of its state.
    state: Option<usize>,
}

/// The signals of a series that the record has.
#[derive(Clone, Debug)]
struct RecordedSignals {
    device: usize,
    signals: Vec<(Signal, Identity)>,
}

/// The points of the edge node and of its devices.
#[derive(Clone, Debug, Default)]
struct Layout {
    node: Vec<usize>,
    devices: Vec<Device>,
    series: HashMap<Series, RecordedSignals>,
    /// The device of each point.
    of_point: Vec<Option<usize>>,
}

impl Layout {
    fn new(points: &[Point], style: DataStyle) -> Self {
        let mut layout = Self::default();
        let mut numbers: BTreeMap<&str, usize> = BTreeMap::new();
        for (position, point) in points.iter().enumerate() {
            let Some(gauge) = point.subject.gauge() else {
                layout.node.push(position);
                layout.of_point.push(None);
                continue;
            };
            let number = *numbers.entry(gauge).or_insert_with(|| {
                layout.devices.push(Device { id: level(gauge), positions: Vec::new(), state: None });
                layout.devices.len().saturating_sub(1)
            });
            layout.of_point.push(Some(number));
            if let Some(device) = layout.devices.get_mut(number) {
                device.positions.push(position);
                if point.signal == Signal::GaugeState {
                    device.state = Some(position);
                }
            }
            if let Some(series) = Series::of(point) {
                let empty = || RecordedSignals { device: number, signals: Vec::new() };
                let entry = layout.series.entry(series).or_insert_with(empty);
                entry.signals.push((point.signal, Identity::of(style, position, point)));
            }
        }
        layout
    }
}

/// The births that were published.
struct Born {
    layout: Layout,
    tracker: Tracker,
    /// The devices whose birth was published, and no death since.
    alive: BTreeSet<usize>,
    at: Micros,
}

/// An edge node, from its CONNECT to its end.
pub struct EdgeNode {
    names: Names,
    bd_seq: u8,
    seq: u8,
    phase: Phase,
    /// The timestamp of the last state of the primary host.
    host_at: Option<u64>,
    wants_rebirth: bool,
    born: Option<Born>,
    /// The last snapshots, with the times at which they came.
    recent: VecDeque<(Micros, Arc<Snapshot>)>,
}

impl EdgeNode {
    /// An edge node that is about to connect with this number. `host_at` is the timestamp of the last state of the primary host.
    #[must_use]
    pub const fn new(names: Names, bd_seq: u8, host_at: Option<u64>) -> Self {
        Self {
            names,
            bd_seq,
            seq: 0,
            phase: Phase::Subscribing,
            host_at,
            wants_rebirth: false,
            born: None,
            recent: VecDeque::new(),
        }
    }

    /// Its phase.
    #[must_use]
    pub const fn phase(&self) -> Phase {
        self.phase
    }

    /// The timestamp of the last state of the primary host.
    #[must_use]
    pub const fn host_at(&self) -> Option<u64> {
        self.host_at
    }

    /// The NDEATH: the will of the connection, and the last message before an intended end
    /// (tck-id-operational-behavior-edge-node-intentional-disconnect-ndeath). It has no sequence number
    /// (tck-id-payloads-sequence-num-always-included), `QoS` 1 and is not retained
    /// (tck-id-message-flow-edge-node-birth-publish-will-message-qos, -will-retained).
    #[must_use]
    pub fn death(&self, now: Micros) -> Message {
        let timestamp = Some(metric::milliseconds(now));
        let payload = Payload { timestamp, metrics: vec![self.bd_seq_metric(now)], seq: None };
        Message {
            topic: self.names.topic("NDEATH", None),
            payload: payload.encode_to_vec(),
            delivery: Delivery::AtLeastOnce,
            is_retained: false,
        }
    }

    /// The broker has accepted the subscriptions.
    pub fn subscribed(&mut self) {
        if self.phase == Phase::Subscribing {
            // tck-id-message-flow-edge-node-birth-publish-phid-wait
            self.phase = if self.names.primary_host.is_some() { Phase::Waiting } else { Phase::Ready };
        }
    }

    /// A message of a subscription.
    pub fn message(&mut self, topic: &str, payload: &[u8], now: Micros) -> Reaction {
        if self.names.state_topic().as_deref() == Some(topic) {
            self.host_state(payload, now)
        } else if topic == self.names.topic("NCMD", None) {
            self.command(payload)
        } else {
            Reaction::Refused(format!("{topic}: the gateway is read-only and executes no command of a device"))
        }
    }

    fn host_state(&mut self, payload: &[u8], now: Micros) -> Reaction {
        let Ok(HostState { online, timestamp }) = serde_json::from_slice(payload) else {
            return Reaction::Refused("the state of the primary host is not {\"online\":…,\"timestamp\":…}".to_owned());
        };
        // A time in the far future would make every later state an earlier one.
        if timestamp > metric::milliseconds(now.after(CLOCK_TOLERANCE)) {
            return Reaction::Refused(format!(
                "the state of the primary host has a time in the future: {timestamp} ms since 1970"
            ));
        }
        // tck-id-message-flow-edge-node-birth-publish-phid-wait-timestamp
        if self.host_at.is_some_and(|last| timestamp < last) {
            return Reaction::None;
        }
        self.host_at = Some(timestamp);
        match (self.phase, online) {
            (Phase::Waiting | Phase::Subscribing, true) => self.phase = Phase::Ready,
            (Phase::Ready, false) => self.phase = Phase::Waiting,
            // tck-id-operational-behavior-edge-node-termination-host-offline
            (Phase::Backlog | Phase::Live, false) => {
                self.phase = Phase::Ended;
                return Reaction::Disconnect(self.death(now));
            }
            (Phase::Ready | Phase::Backlog | Phase::Live | Phase::Ended, true)
            | (Phase::Waiting | Phase::Subscribing | Phase::Ended, false) => {}
        }
        Reaction::None
    }

    fn command(&mut self, payload: &[u8]) -> Reaction {
        let Ok(payload) = Payload::decode(payload) else {
            return Reaction::Refused("a command that is no payload of Sparkplug B".to_owned());
        };
        let is_rebirth = |metric: &&Metric| metric.name.as_deref() == Some(REBIRTH);
        // tck-id-operational-behavior-data-commands-ncmd-rebirth-value
        let rebirth = payload.metrics.iter().find(is_rebirth);
        if rebirth.is_some_and(|metric| metric.value == Some(MetricValue::Boolean(true))) {
            self.wants_rebirth = self.born.is_some();
            return Reaction::None;
        }
        let names: Vec<_> = payload.metrics.iter().filter_map(|metric| metric.name.as_deref()).take(3).collect();
        Reaction::Refused(format!("a command other than {REBIRTH} = true; the gateway is read-only: {names:?}"))
    }

    /// Whether births are to be published: after a rebirth command, at the earliest [`REBIRTH_PAUSE`] after the births before.
    #[must_use]
    pub fn is_rebirth_due(&self, now: Micros) -> bool {
        // A clock that was set back must not keep a host waiting.
        let is_due = |born: &Born| now >= born.at.after(REBIRTH_PAUSE) || now < born.at;
        self.wants_rebirth && self.born.as_ref().is_some_and(is_due)
    }

    /// The births: NBIRTH with sequence number 0, and DBIRTH for each device that is there or is in `with_samples`, the gauges of which the
    /// record has samples of the outage (tck-id-operational-behavior-data-commands-rebirth-action-2,
    /// tck-id-message-flow-device-birth-publish-nbirth-wait).
    pub fn births(&mut self, snapshot: &Arc<Snapshot>, with_samples: &HashSet<Series>, now: Micros) -> Vec<Message> {
        let layout = Layout::new(&snapshot.points, self.names.data);
        self.seq = 0;
        self.wants_rebirth = false;
        let mut messages = vec![self.node_birth(&layout, snapshot, now)];
        let needed: BTreeSet<usize> =
            with_samples.iter().filter_map(|series| layout.series.get(series)).map(|series| series.device).collect();
        let before = self.born.as_ref().filter(|born| born.tracker.has_points_of(snapshot)).map(|born| &born.alive);
        let mut alive = BTreeSet::new();
        for (number, device) in layout.devices.iter().enumerate() {
            let was_alive = before.is_some_and(|alive| alive.contains(&number));
            let keeps = self.phase == Phase::Backlog && was_alive;
            if needed.contains(&number) || keeps || is_present(device, snapshot).unwrap_or(was_alive) {
                alive.insert(number);
            }
        }
        for device in alive.iter().filter_map(|number| layout.devices.get(*number)) {
            messages.push(self.device_birth(device, snapshot, now));
        }
        let tracker = Tracker::new(Arc::clone(snapshot), now);
        self.born = Some(Born { layout, tracker, alive, at: now });
        if self.phase == Phase::Ready {
            self.phase = Phase::Backlog;
        }
        messages
    }

    /// The samples of the outage, in their order: one DDATA for each device, with original times and `is_historical`.
    pub fn samples(&mut self, samples: &[(Series, Recorded)], now: Micros) -> Vec<Message> {
        let Some(born) = self.born.as_ref().filter(|_| self.phase == Phase::Backlog) else { return Vec::new() };
        let mut of_devices: BTreeMap<usize, Vec<Metric>> = BTreeMap::new();
        for (series, sample) in samples {
            let Some(series) = born.layout.series.get(series) else { continue };
            // Data only for metrics that were born.
            if !born.alive.contains(&series.device) {
                continue;
            }
            let metrics = of_devices.entry(series.device).or_default();
            for (signal, identity) in &series.signals {
                if let Some((value, quality)) = metric::of_recorded(*signal, sample) {
                    metrics.push(metric::historical(identity.clone(), sample.at(), value, quality));
                }
            }
        }
        let ids: BTreeMap<usize, String> =
            of_devices.keys().filter_map(|it| Some((*it, born.layout.devices.get(*it)?.id.clone()))).collect();
        let device = |(number, metrics)| ids.get(&number).map(|id| self.publish("DDATA", Some(id), metrics, now));
        of_devices.into_iter().filter_map(device).collect()
    }

    /// The samples up to `until` were published: what follows is the present. It begins with the values at `until`, because a host shows no
    /// historical value as the present one.
    pub fn caught_up(&mut self, until: Micros, now: Micros) -> Vec<Message> {
        if self.phase != Phase::Backlog {
            return Vec::new();
        }
        self.phase = Phase::Live;
        let recent = std::mem::take(&mut self.recent);
        let first = recent.iter().rposition(|(at, _)| *at <= until).unwrap_or_default();
        let present = recent.into_iter().skip(first);
        present.flat_map(|(_, snapshot)| self.present(&snapshot, now).0).collect()
    }

    /// A new snapshot: the messages, and the updates that newer ones have replaced. While a rebirth is wanted, data stops
    /// (tck-id-operational-behavior-data-commands-rebirth-action-1).
    pub fn snapshot(&mut self, snapshot: &Arc<Snapshot>, now: Micros) -> (Vec<Message>, u64) {
        match self.phase {
            Phase::Backlog => {
                self.recent.push_back((now, Arc::clone(snapshot)));
                if self.recent.len() > RECENT {
                    self.recent.pop_front();
                }
                (Vec::new(), 0)
            }
            Phase::Live if !self.wants_rebirth => self.present(snapshot, now),
            Phase::Live | Phase::Subscribing | Phase::Waiting | Phase::Ready | Phase::Ended => (Vec::new(), 0),
        }
    }

    /// The messages of a snapshot.
    fn present(&mut self, snapshot: &Arc<Snapshot>, now: Micros) -> (Vec<Message>, u64) {
        let Some(mut born) = self.born.take() else { return (Vec::new(), 0) };
        if !born.tracker.has_points_of(snapshot) {
            // A metric that no birth has announced must not be published: all births again.
            self.born = Some(born);
            return (self.births(snapshot, &HashSet::new(), now), 0);
        }
        let changes = born.tracker.next(snapshot, now);
        let mut of_devices: BTreeMap<Option<usize>, Vec<Metric>> = BTreeMap::new();
        for position in changes.positions {
            let Some((point, value)) = at(snapshot, position) else { continue };
            let device = born.layout.of_point.get(position).copied().flatten();
            let identity = Identity::of(self.names.data, position, point);
            of_devices.entry(device).or_default().push(metric::data(identity, point, value, now));
        }
        // tck-id-operational-behavior-data-publish-nbirth-order, -dbirth-order
        of_devices.values_mut().for_each(|metrics| metrics.sort_by_key(|metric| metric.timestamp));
        let mut messages = Vec::new();
        if let Some(metrics) = of_devices.remove(&None) {
            messages.push(self.publish("NDATA", None, metrics, now));
        }
        for (number, device) in born.layout.devices.iter().enumerate() {
            let was_alive = born.alive.contains(&number);
            let is_alive = is_present(device, snapshot).unwrap_or(was_alive);
            match (was_alive, is_alive) {
                (true, true) => {
                    if let Some(metrics) = of_devices.remove(&Some(number)) {
                        messages.push(self.publish("DDATA", Some(&device.id), metrics, now));
                    }
                }
                // tck-id-operational-behavior-device-ddeath
                (true, false) => {
                    born.alive.remove(&number);
                    messages.push(self.publish("DDEATH", Some(&device.id), Vec::new(), now));
                }
                (false, true) => {
                    born.alive.insert(number);
                    messages.push(self.device_birth(device, snapshot, now));
                }
                (false, false) => {}
            }
        }
        self.born = Some(born);
        (messages, changes.missed)
    }

    /// tck-id-topics-nbirth-bdseq-included, tck-id-topics-nbirth-rebirth-metric, tck-id-topics-nbirth-metrics. The rebirth metric has no
    /// alias (tck-id-operational-behavior-data-commands-rebirth-name-aliases).
    fn node_birth(&mut self, layout: &Layout, snapshot: &Snapshot, now: Micros) -> Message {
        let rebirth = Metric {
            name: Some(REBIRTH.to_owned()),
            timestamp: Some(metric::milliseconds(now)),
            datatype: Some(datatype::BOOLEAN),
            value: Some(MetricValue::Boolean(false)),
            ..Metric::default()
        };
        let control = [self.bd_seq_metric(now), rebirth];
        let metrics = control.into_iter().chain(births(self.names.data, &layout.node, snapshot, now)).collect();
        self.publish("NBIRTH", None, metrics, now)
    }

    fn device_birth(&mut self, device: &Device, snapshot: &Snapshot, now: Micros) -> Message {
        let metrics = births(self.names.data, &device.positions, snapshot, now).collect();
        self.publish("DBIRTH", Some(&device.id), metrics, now)
    }

    /// tck-id-message-flow-edge-node-birth-publish-will-message-payload-bdSeq: an Int64.
    fn bd_seq_metric(&self, now: Micros) -> Metric {
        Metric {
            name: Some(BD_SEQ.to_owned()),
            timestamp: Some(metric::milliseconds(now)),
            datatype: Some(datatype::INT64),
            value: Some(MetricValue::Long(self.bd_seq.into())),
            ..Metric::default()
        }
    }

    /// A message with the next sequence number (tck-id-payloads-sequence-num-incrementing), `QoS` 0, not retained
    /// (tck-id-topics-nbirth-mqtt and its neighbours).
    fn publish(&mut self, verb: &str, device: Option<&str>, metrics: Vec<Metric>, now: Micros) -> Message {
        let payload = Payload { timestamp: Some(metric::milliseconds(now)), metrics, seq: Some(self.seq.into()) };
        self.seq = self.seq.wrapping_add(1);
        Message {
            topic: self.names.topic(verb, device),
            payload: payload.encode_to_vec(),
            delivery: Delivery::AtMostOnce,
            is_retained: false,
        }
    }
}

fn births<'a>(
    style: DataStyle,
    positions: &'a [usize],
    snapshot: &'a Snapshot,
    now: Micros,
) -> impl Iterator<Item = Metric> + 'a {
    let known = positions.iter().filter_map(|position| Some((*position, at(snapshot, *position)?)));
    known.map(move |(position, (point, value))| metric::birth(Identity::of(style, position, point), point, value, now))
}

fn at(snapshot: &Snapshot, position: usize) -> Option<(&Point, &PointValue)> {
    snapshot.points.get(position).zip(snapshot.values.get(position))
}

/// Whether a gauge is in data exchange or reports a defect; `None` while it starts, which is no end and no beginning.
fn is_present(device: &Device, snapshot: &Snapshot) -> Option<bool> {
    let state = device.state.and_then(|position| snapshot.values.get(position));
    match state.map(|state| &state.value) {
        Some(Value::Choice(gauge_state::STARTING)) => None,
        Some(Value::Choice(gauge_state::MISSING)) | None => Some(false),
        Some(_) => Some(true),
    }
}
