//! The snapshots of all points over time.

use crate::plant::{self, Inputs, PointOf, Raw, Sink};
use crate::point::{Point, PointValue, Value};
use crate::signal::Signal;
use crate::state::State;
use profivac_recorder::Micros;
use profivac_station::services::Services;
use profivac_station::view::GaugeKind;
use std::collections::BTreeMap;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, PoisonError};
use std::thread::JoinHandle;
use std::time::Duration;
use tokio::sync::watch;

/// The time between two snapshots: half the shortest sampling interval that people use, so that no gateway is later than 200 ms.
pub const PERIOD: Duration = Duration::from_millis(100);

/// All points at one moment.
#[derive(Clone, Debug, Default)]
pub struct Snapshot {
    /// The points. The list is the same object as long as no point is added, removed or described differently.
    pub points: Arc<[Point]>,
    /// Their values, in the same order.
    pub values: Arc<[PointValue]>,
}

impl Snapshot {
    /// Whether `other` has the same points, so that positions in both mean the same point.
    #[must_use]
    pub fn has_points_of(&self, other: &Self) -> bool {
        Arc::ptr_eq(&self.points, &other.points)
    }

    /// All points with their values.
    pub fn iter(&self) -> impl Iterator<Item = (&Point, &PointValue)> {
        self.points.iter().zip(self.values.iter())
    }

    /// The positions of the points whose value or state differs from that in `old`, and how many updates were missed in between. Both
    /// have the same points.
    pub fn changes_since<'a>(&'a self, old: &'a Self) -> impl Iterator<Item = (usize, u64)> + 'a {
        let pairs = self.values.iter().zip(old.values.iter()).enumerate();
        pairs
            .filter(|(_, (new, old))| new.version != old.version)
            .map(|(index, (new, old))| (index, new.version.saturating_sub(old.version).saturating_sub(1)))
    }
}

/// What waits for new snapshots.
pub type Subscription = watch::Receiver<Arc<Snapshot>>;

/// Makes a snapshot from the inputs and the snapshot before.
struct Next<'a> {
    old: &'a [PointValue],
    values: Vec<PointValue>,
    now: Micros,
}

impl Sink for Next<'_> {
    fn subject(&mut self, _: impl FnOnce() -> PointOf) {}

    fn point(&mut self, signal: Signal, raw: Raw, state: State, at: Option<Micros>) {
        debug_assert!(plant::has_kind(signal, raw), "{signal:?} {raw:?}");
        let old = self.old.get(self.values.len());
        let new = match old.filter(|old| is_equal(&old.value, raw) && old.state == state) {
            Some(old) => PointValue { at: at.or(old.at), ..old.clone() },
            None => PointValue {
                value: value(raw),
                state,
                at: at.or(Some(self.now)),
                version: old.map_or(1, |old| old.version.saturating_add(1)),
            },
        };
        self.values.push(new);
    }
}

fn is_equal(old: &Value, new: Raw) -> bool {
    match (old, new) {
        (Value::None, Raw::None) => true,
        (Value::Float(old), Raw::Float(new)) => old.to_bits() == new.to_bits(),
        (Value::Integer(old), Raw::Integer(new)) => *old == new,
        (Value::Boolean(old), Raw::Boolean(new)) => *old == new,
        (Value::Text(old), Raw::Text(new)) => **old == *new,
        (Value::Choice(old), Raw::Choice(new)) => *old == new,
        (Value::Time(old), Raw::Time(new)) => *old == new,
        _ => false,
    }
}

fn value(raw: Raw) -> Value {
    match raw {
        Raw::None => Value::None,
        Raw::Float(number) => Value::Float(number),
        Raw::Integer(number) => Value::Integer(number),
        Raw::Boolean(value) => Value::Boolean(value),
        Raw::Text(text) => Value::Text(Arc::from(text)),
        Raw::Choice(number) => Value::Choice(number),
        Raw::Time(at) => Value::Time(at),
    }
}

/// The model in one thread: takes inputs and gives snapshots.
#[derive(Default)]
pub struct Modeller {
    structure: Option<u64>,
    last: Snapshot,
    /// The readings that each gauge had last. A gauge that is lost and searched again keeps its points.
    readings: BTreeMap<String, Vec<profivac_station::view::Reading>>,
}

impl Modeller {
    /// The snapshot of these inputs.
    pub fn next(&mut self, mut inputs: Inputs, now: Micros) -> Snapshot {
        self.keep_readings(&mut inputs);
        let structure = inputs.structure();
        if self.structure != Some(structure) {
            self.structure = Some(structure);
            let points: Arc<[Point]> = plant::points(&inputs).into();
            self.last = Snapshot { values: carried_over(&self.last, &points), points };
        }
        let mut next = Next { old: &self.last.values, values: Vec::with_capacity(self.last.points.len()), now };
        plant::walk(&inputs, &mut next);
        self.last = Snapshot { points: Arc::clone(&self.last.points), values: next.values.into() };
        self.last.clone()
    }

    /// Gives a gauge without readings those that it had, or those of the file, without their values.
    fn keep_readings(&mut self, inputs: &mut Inputs) {
        self.readings.retain(|name, _| inputs.gauges.iter().any(|gauge| gauge.name == *name));
        for gauge in inputs.gauges.iter_mut().filter(|gauge| gauge.kind == GaugeKind::Gauge) {
            if gauge.parameters.is_empty() {
                gauge.parameters = plant::default_parameters(gauge).into();
            }
            if gauge.readings.is_empty() {
                let known = self.readings.get(&gauge.name).cloned();
                gauge.readings = known.unwrap_or_else(|| plant::default_readings(gauge, &inputs.plan));
            } else {
                let absent = gauge.readings.iter().map(plant::without_value).collect();
                self.readings.insert(gauge.name.clone(), absent);
            }
        }
    }
}

/// The values of the points that both lists have, so that a changed file does not look like changed values.
fn carried_over(old: &Snapshot, points: &[Point]) -> Arc<[PointValue]> {
    let known: BTreeMap<_, _> = old.iter().map(|(point, value)| ((&point.subject, point.signal), value)).collect();
    let value =
        |point: &Point| known.get(&(&point.subject, point.signal)).map_or_else(PointValue::default, |it| (*it).clone());
    points.iter().map(value).collect()
}

/// While it lives, the segments read the parameters that gateways show.
struct ParameterReader(Arc<Services>);

impl ParameterReader {
    fn new(services: Arc<Services>) -> Self {
        services.snapshots().add_parameter_reader();
        Self(services)
    }
}

impl Drop for ParameterReader {
    fn drop(&mut self) {
        self.0.snapshots().remove_parameter_reader();
    }
}

/// The read model of a running station: a thread that publishes a snapshot every [`PERIOD`]. Dropping it ends the thread.
pub struct ReadModel {
    /// The thread has the only sender, so its end is seen here.
    snapshots: Subscription,
    is_stopped: Arc<AtomicBool>,
    thread: Mutex<Option<JoinHandle<()>>>,
}

impl ReadModel {
    /// Starts the thread. The first snapshot is there when this returns.
    ///
    /// # Errors
    /// When the system gives no thread.
    pub fn start(services: Arc<Services>) -> std::io::Result<Self> {
        let reader = ParameterReader::new(Arc::clone(&services));
        let mut modeller = Modeller::default();
        let (sender, snapshots) = watch::channel(Arc::new(modeller.next(Inputs::of(&services), Micros::now())));
        let is_stopped = Arc::new(AtomicBool::new(false));
        let own_flag = Arc::clone(&is_stopped);
        let thread = std::thread::Builder::new().name("read model".to_owned()).spawn(move || {
            let _reader = reader;
            while !own_flag.load(Ordering::Relaxed) {
                let next = modeller.next(Inputs::of(&services), Micros::now());
                sender.send_replace(Arc::new(next));
                std::thread::park_timeout(PERIOD);
            }
        })?;
        Ok(Self { snapshots, is_stopped, thread: Mutex::new(Some(thread)) })
    }

    /// The present snapshot.
    #[must_use]
    pub fn snapshot(&self) -> Arc<Snapshot> {
        Arc::clone(&self.snapshots.borrow())
    }

    /// Waits for new snapshots. The present one counts as not seen yet.
    #[must_use]
    pub fn subscribe(&self) -> Subscription {
        let mut subscription = self.snapshots.clone();
        subscription.mark_changed();
        subscription
    }

    /// Returns when the thread has ended, which before the model is dropped is a defect: no further snapshot comes.
    pub async fn ended(&self) {
        let mut subscription = self.snapshots.clone();
        while subscription.changed().await.is_ok() {}
    }
}

impl Drop for ReadModel {
    fn drop(&mut self) {
        self.is_stopped.store(true, Ordering::Relaxed);
        if let Some(thread) = self.thread.lock().unwrap_or_else(PoisonError::into_inner).take() {
            thread.thread().unpark();
            thread.join().ok();
        }
    }
}
