//! A gauge on a segment in memory that a station shows, people who ask it, and a world outside that tests may change.

#![allow(clippy::unwrap_used, clippy::panic, clippy::indexing_slicing, reason = "a test")]
#![allow(dead_code, reason = "each test uses its part")]

use axum::body::{Body, to_bytes};
use axum::http::Request;
use profivac_client::cyclic::CyclicSlave;
use profivac_client::pressure::Pressure;
use profivac_dp::link::Baud;
use profivac_recorder::{Recorder, Settings};
use profivac_station::api::router;
use profivac_station::auth::{Role, User};
use profivac_station::segment::DemoSegment;
use profivac_station::services::Services;
use profivac_station::view::{BusStationState, Gauge};
use profivac_vacuum::Gas;
use profivac_virtual::device::{GasConditions, VirtualDevice};
use profivac_virtual::device_spec::{DeviceSpec, entry};
use profivac_virtual::memory_segment::MemorySegment;
use profivac_virtual::nonvolatile::NonvolatileMemory;
use serde_json::Value;
use std::path::PathBuf;
use std::sync::Arc;
use std::sync::mpsc::{Receiver, RecvTimeoutError, Sender, channel};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};
use tempfile::TempDir;
use tower::ServiceExt;

const BAUD: Baud = Baud::B187500;

/// Long enough for a computer that is busy with something else.
const PATIENCE: Duration = Duration::from_secs(60);

/// People by name and role.
pub const VIEWER: (&str, Role) = ("Vera", Role::Viewer);
pub const OPERATOR: (&str, Role) = ("Otto", Role::Operator);
pub const ENGINEER: (&str, Role) = ("Erna", Role::Engineer);

type Who = (&'static str, Role);

/// Something that is done to the segment from outside.
type Blow = Box<dyn FnOnce(&mut MemorySegment) + Send>;

/// What is around the gauges.
pub struct Outside;

impl Outside {
    pub fn mbar(mbar: f64) -> GasConditions {
        let atmosphere = Pressure::from_mbar(1013.25);
        GasConditions { pressure: Pressure::from_mbar(mbar), atmosphere, gas: Gas::N2 }
    }
}

/// A station with a bcg450 called chamber.
pub struct Desk {
    folder: TempDir,
    pub plant: Arc<Services>,
    blows: Option<Sender<Blow>>,
    thread: Option<JoinHandle<()>>,
}

impl Desk {
    /// In a vacuum of so many mbar. Returns when the gauge measures it and its emission is on.
    pub fn new(mbar: f64) -> Self {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("plant.db");
        let recorder = Recorder::start(&file, Settings::default()).unwrap();
        let plant = Arc::new(Services::new("Target hall".to_owned(), file, recorder));
        let (blows, inbox) = channel();
        let shown = Arc::clone(&plant);
        let thread = std::thread::spawn(move || live(shown, mbar, &inbox));
        let desk = Self { folder, plant, blows: Some(blows), thread: Some(thread) };
        desk.until_pa(|pa| (pa / (mbar * 100.0) - 1.0).abs() < 0.1);
        until("it exchanges data", || {
            desk.plant.gauge("chamber").filter(|gauge| gauge.standing == BusStationState::Exchanging)
        });
        desk
    }

    pub fn file(&self) -> PathBuf {
        self.folder.path().join("plant.db")
    }

    pub fn gauge(&self) -> Gauge {
        self.plant.gauge("chamber").unwrap()
    }

    pub fn until_pa(&self, wanted: impl Fn(f64) -> bool) {
        until("a pressure", || {
            let gauge = self.plant.gauge("chamber")?;
            gauge.readings.first()?.pa.filter(|pa| wanted(*pa))
        });
    }

    /// Does something to the segment, and returns when it is done.
    pub fn outside(&self, blow: impl FnOnce(&mut MemorySegment) + Send + 'static) {
        self.ask_outside(blow);
    }

    /// Asks the segment something from outside.
    pub fn ask_outside<T: Send + 'static>(&self, question: impl FnOnce(&mut MemorySegment) -> T + Send + 'static) -> T {
        let (answer, wait) = channel();
        let blow: Blow = Box::new(move |scene| answer.send(question(scene)).unwrap());
        self.blows.as_ref().unwrap().send(blow).unwrap();
        wait.recv_timeout(PATIENCE).unwrap()
    }

    /// Whether the gauge heats its electrodes, by its own word.
    pub fn is_degassing(&self) -> bool {
        let (_, blocks) = self.get(VIEWER, "/api/gauges/chamber/blocks");
        let all = blocks.as_array().unwrap().iter().flat_map(|block| block["parameters"].as_array().unwrap());
        let status = all.clone().find(|parameter| parameter["target"] == "ba.degas-status");
        status.unwrap()["value"] == "on"
    }

    /// Status and body of an answer.
    fn send(&self, who: Who, method: &str, path: &str, body: Option<&Value>) -> (u16, String) {
        self.send_as(who, method, path, "application/json", body.map_or_else(String::new, ToString::to_string))
    }

    pub fn send_as(&self, who: Who, method: &str, path: &str, kind: &str, body: String) -> (u16, String) {
        let runtime = tokio::runtime::Builder::new_current_thread().enable_time().build().unwrap();
        runtime.block_on(async {
            let request = request(who, method, path, kind, body);
            let (head, body) = router(Arc::clone(&self.plant)).oneshot(request).await.unwrap().into_parts();
            let text = String::from_utf8(to_bytes(body, usize::MAX).await.unwrap().to_vec()).unwrap();
            (head.status.as_u16(), text)
        })
    }

    /// Asks to fire while the segment is held up, and leaves as soon as `taken` sees that it was taken.
    pub fn fire_and_leave(&self, who: Who, armed: &Value, taken: impl FnMut() -> Option<()>) {
        let (release, gate) = channel::<()>();
        let hold: Blow = Box::new(move |_| gate.recv().unwrap_or_default());
        self.blows.as_ref().unwrap().send(hold).unwrap();
        let runtime = tokio::runtime::Builder::new_multi_thread().worker_threads(1).enable_time().build().unwrap();
        let path = format!("/api/orders/{}/fire", armed["order"].as_str().unwrap());
        let request = request(who, "POST", &path, "application/json", String::new());
        let asked = runtime.spawn(router(Arc::clone(&self.plant)).oneshot(request));
        until("it is taken", taken);
        asked.abort();
        drop(release);
    }

    fn json(&self, who: Who, method: &str, path: &str, body: Option<&Value>) -> (u16, Value) {
        let (status, text) = self.send(who, method, path, body);
        let json = if text.is_empty() { Value::Null } else { serde_json::from_str(&text).unwrap() };
        (status, json)
    }

    pub fn get(&self, who: Who, path: &str) -> (u16, Value) {
        self.json(who, "GET", path, None)
    }

    pub fn text(&self, path: &str) -> String {
        self.send(VIEWER, "GET", path, None).1
    }

    pub fn post(&self, who: Who, path: &str, body: Option<&Value>) -> (u16, Value) {
        self.json(who, "POST", path, body)
    }

    /// Somebody takes the mastership, which is free.
    pub fn masters(&self, who: Who) {
        let (status, mastership) = self.post(who, "/api/mastership/ask", None);
        assert_eq!((status, mastership["holder"].as_str()), (200, Some(who.0)));
    }

    pub fn arm(&self, who: Who, wish: &Value) -> (u16, Value) {
        self.post(who, "/api/gauges/chamber/arm", Some(wish))
    }

    pub fn fire(&self, who: Who, armed: &Value) -> (u16, Value) {
        self.post(who, &format!("/api/orders/{}/fire", armed["order"].as_str().unwrap()), None)
    }

    pub fn delete(&self, who: Who, armed: &Value) -> (u16, Value) {
        self.json(who, "DELETE", &format!("/api/orders/{}", armed["order"].as_str().unwrap()), None)
    }
}

impl Drop for Desk {
    fn drop(&mut self) {
        self.blows = None;
        let ended = self.thread.take().unwrap().join();
        assert!(ended.is_ok() || std::thread::panicking());
    }
}

/// Waits until something is seen.
pub fn until<T>(what: &str, mut seen: impl FnMut() -> Option<T>) -> T {
    let end = Instant::now() + PATIENCE;
    loop {
        if let Some(seen) = seen() {
            return seen;
        }
        assert!(Instant::now() < end, "never seen: {what}");
        std::thread::yield_now();
    }
}

fn request(who: Who, method: &str, path: &str, kind: &str, body: String) -> Request<Body> {
    let person = User { name: Arc::from(who.0), role: who.1 };
    let request = Request::builder().method(method).uri(path).header("content-type", kind);
    request.extension(person).body(Body::from(body)).unwrap()
}

/// The segment, until nobody can do anything to it any more.
fn live(plant: Arc<Services>, mbar: f64, inbox: &Receiver<Blow>) {
    let spec: DeviceSpec = "bcg450@5".parse().unwrap();
    let unit = spec.build(NonvolatileMemory::volatile(), BAUD).unwrap();
    let device = VirtualDevice::new(unit, 5, BAUD, Outside::mbar(mbar));
    let model = entry("bcg450").unwrap().model;
    let unit = model.unit_named("mbar").unwrap();
    let watched = CyclicSlave {
        address: 5,
        model,
        configuration: model.default_configuration,
        unit,
        principles: Default::default(),
    };
    let mut scene = MemorySegment::new(vec![device], vec![watched], 1, BAUD).unwrap();
    let mut exhibit = DemoSegment::new(plant, "hall", &scene, 1, |_| ("chamber".to_owned(), "bcg450".to_owned()));
    loop {
        match inbox.recv_timeout(Duration::from_millis(1)) {
            Ok(blow) => blow(&mut scene),
            Err(RecvTimeoutError::Timeout) => {}
            Err(RecvTimeoutError::Disconnected) => return,
        }
        scene.run_until(scene.seconds() + 0.02);
        exhibit.run_once(&mut scene);
    }
}
