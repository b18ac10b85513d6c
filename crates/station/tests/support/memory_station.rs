//! A station with a gauge on a segment in memory, users who send requests, and an environment that tests change.

use super::{TIMEOUT, database, services, until};
use axum::body::{Body, to_bytes};
use axum::http::Request;
use profivac_client::cyclic::CyclicSlave;
use profivac_client::pressure::Pressure;
use profivac_dp::link::Baud;
use profivac_dp::link::active::BusParameters;
use profivac_station::api::router;
use profivac_station::segment::{DemoSegment, SegmentServices};
use profivac_station::services::Services;
use profivac_station::view::{BusStationState, Gauge};
use profivac_vacuum::Gas;
use profivac_virtual::device::{GasConditions, VirtualDevice};
use profivac_virtual::device_spec::{DeviceSpec, entry};
use profivac_virtual::memory_segment::MemorySegment;
use profivac_virtual::nonvolatile::NonvolatileMemory;
use profivac_web_server::auth::{Role, User};
use serde_json::Value;
use std::path::PathBuf;
use std::sync::Arc;
use std::sync::mpsc::{Receiver, RecvTimeoutError, Sender, channel};
use std::thread::JoinHandle;
use std::time::Duration;
use tempfile::TempDir;
use tower::ServiceExt;

const BAUD: Baud = Baud::B187500;

/// A viewer.
pub const VIEWER: (&str, Role) = ("Vera", Role::Viewer);
/// An operator.
pub const OPERATOR: (&str, Role) = ("Otto", Role::Operator);
/// An engineer.
pub const ENGINEER: (&str, Role) = ("Erna", Role::Engineer);

/// A user by name and role.
pub type Login = (&'static str, Role);

/// An action on the segment from outside.
type Action = Box<dyn FnOnce(&mut MemorySegment) + Send>;

/// The environment of the gauges.
pub struct Outside;

impl Outside {
    pub fn mbar(mbar: f64) -> GasConditions {
        let atmosphere = Pressure::from_mbar(1013.25);
        GasConditions { pressure: Pressure::from_mbar(mbar), atmosphere, gas: Gas::N2 }
    }
}

/// A station with a gauge called chamber on the segment hall.
pub struct MemoryStation {
    folder: TempDir,
    pub services: Arc<Services>,
    actions: Option<Sender<Action>>,
    thread: Option<JoinHandle<()>>,
}

impl MemoryStation {
    /// Starts a bcg450 at a pressure in mbar. Returns when the gauge measures it and is in data exchange.
    pub fn new(mbar: f64) -> Self {
        Self::with_device("bcg450@5", mbar)
    }

    /// The same with another device, at address 5.
    pub fn with_device(spec: &'static str, mbar: f64) -> Self {
        let folder = tempfile::tempdir().unwrap();
        let services = services(folder.path());
        let (actions, inbox) = channel();
        let segment = services.for_segments();
        let thread = std::thread::spawn(move || run(segment, spec, mbar, &inbox));
        let station = Self { folder, services, actions: Some(actions), thread: Some(thread) };
        station.until_pa(|pa| (pa / (mbar * 100.0) - 1.0).abs() < 0.1);
        until("it exchanges data", || {
            station.services.snapshots().gauge("chamber").filter(|gauge| gauge.state == BusStationState::DataExchange)
        });
        station
    }

    pub fn database(&self) -> PathBuf {
        database(self.folder.path())
    }

    pub fn gauge(&self) -> Gauge {
        self.services.snapshots().gauge("chamber").unwrap()
    }

    pub fn until_pa(&self, wanted: impl Fn(f64) -> bool) {
        until("a pressure", || {
            let gauge = self.services.snapshots().gauge("chamber")?;
            gauge.readings.first()?.pa.filter(|pa| wanted(*pa))
        });
    }

    /// Runs an action on the segment and waits for it.
    pub fn outside(&self, action: impl FnOnce(&mut MemorySegment) + Send + 'static) {
        self.ask_outside(action);
    }

    /// Runs an action on the segment and returns its result.
    pub fn ask_outside<T: Send + 'static>(&self, action: impl FnOnce(&mut MemorySegment) -> T + Send + 'static) -> T {
        let (answer, wait) = channel();
        let action: Action = Box::new(move |segment| answer.send(action(segment)).unwrap());
        self.actions.as_ref().unwrap().send(action).unwrap();
        wait.recv_timeout(TIMEOUT).unwrap()
    }

    /// Whether the gauge reports that it degasses.
    pub fn is_degassing(&self) -> bool {
        let (_, blocks) = self.get(VIEWER, "/api/gauges/chamber/blocks");
        let all = blocks.as_array().unwrap().iter().flat_map(|block| block["parameters"].as_array().unwrap());
        let status = all.clone().find(|parameter| parameter["target"] == "ba.degas-status");
        status.unwrap()["value"] == "on"
    }

    /// Sends a request and returns status and body of the answer.
    fn send(&self, user: Login, method: &str, path: &str, body: Option<&Value>) -> (u16, String) {
        self.send_as(user, method, path, "application/json", body.map_or_else(String::new, ToString::to_string))
    }

    pub fn send_as(&self, user: Login, method: &str, path: &str, kind: &str, body: String) -> (u16, String) {
        let runtime = tokio::runtime::Builder::new_current_thread().enable_time().build().unwrap();
        runtime.block_on(async {
            let request = request(user, method, path, kind, body);
            let (head, body) = router(Arc::clone(&self.services)).oneshot(request).await.unwrap().into_parts();
            let text = String::from_utf8(to_bytes(body, usize::MAX).await.unwrap().to_vec()).unwrap();
            (head.status.as_u16(), text)
        })
    }

    /// Requests an execution while the segment is blocked, and drops the request as soon as `taken` returns a value.
    pub fn execute_and_leave(&self, user: Login, armed: &Value, taken: impl FnMut() -> Option<()>) {
        let (release, released) = channel::<()>();
        let hold: Action = Box::new(move |_| released.recv().unwrap_or_default());
        self.actions.as_ref().unwrap().send(hold).unwrap();
        let runtime = tokio::runtime::Builder::new_multi_thread().worker_threads(1).enable_time().build().unwrap();
        let path = format!("/api/armed-commands/{}/execute", armed["id"].as_str().unwrap());
        let request = request(user, "POST", &path, "application/json", String::new());
        let asked = runtime.spawn(router(Arc::clone(&self.services)).oneshot(request));
        until("the segment has the command", taken);
        asked.abort();
        drop(release);
    }

    fn json(&self, user: Login, method: &str, path: &str, body: Option<&Value>) -> (u16, Value) {
        let (status, text) = self.send(user, method, path, body);
        let json = if text.is_empty() { Value::Null } else { serde_json::from_str(&text).unwrap() };
        (status, json)
    }

    pub fn get(&self, user: Login, path: &str) -> (u16, Value) {
        self.json(user, "GET", path, None)
    }

    pub fn text(&self, path: &str) -> String {
        self.send(VIEWER, "GET", path, None).1
    }

    pub fn post(&self, user: Login, path: &str, body: Option<&Value>) -> (u16, Value) {
        self.json(user, "POST", path, body)
    }

    /// The user takes control, which is free.
    pub fn take_control(&self, user: Login) {
        let (status, authority) = self.post(user, "/api/control-authority/request", None);
        assert_eq!((status, authority["holder"].as_str()), (200, Some(user.0)));
    }

    pub fn arm(&self, user: Login, request: &Value) -> (u16, Value) {
        self.post(user, "/api/gauges/chamber/arm", Some(request))
    }

    pub fn execute(&self, user: Login, armed: &Value) -> (u16, Value) {
        self.post(user, &format!("/api/armed-commands/{}/execute", armed["id"].as_str().unwrap()), None)
    }

    pub fn disarm(&self, user: Login, armed: &Value) -> (u16, Value) {
        self.json(user, "DELETE", &format!("/api/armed-commands/{}", armed["id"].as_str().unwrap()), None)
    }
}

impl Drop for MemoryStation {
    fn drop(&mut self) {
        self.actions = None;
        let ended = self.thread.take().unwrap().join();
        assert!(ended.is_ok() || std::thread::panicking());
    }
}

fn request(user: Login, method: &str, path: &str, kind: &str, body: String) -> Request<Body> {
    let user = User { name: Arc::from(user.0), role: user.1 };
    let request = Request::builder().method(method).uri(path).header("content-type", kind);
    request.extension(user).body(Body::from(body)).unwrap()
}

/// Runs the segment until the station is dropped.
fn run(services: SegmentServices, spec: &str, mbar: f64, inbox: &Receiver<Action>) {
    let name = spec.split(['@', ':']).next().unwrap().to_owned();
    let spec: DeviceSpec = spec.parse().unwrap();
    let unit = spec.build(NonvolatileMemory::volatile(), BAUD).unwrap();
    let device = VirtualDevice::new(unit, 5, BAUD, Outside::mbar(mbar));
    let model = entry(&name).unwrap().model;
    let unit = model.unit_named("mbar").unwrap();
    let watched = CyclicSlave {
        address: 5,
        model,
        configuration: model.default_configuration,
        unit,
        channels: Default::default(),
    };
    let bus = BusParameters::new(1, BAUD).check().unwrap();
    let mut segment = MemorySegment::new(vec![device], vec![watched], bus, BAUD).unwrap();
    let mut demo = DemoSegment::new(services, "hall", &mut segment, 1, |_| ("chamber".to_owned(), name.clone()));
    loop {
        match inbox.recv_timeout(Duration::from_millis(1)) {
            Ok(action) => action(&mut segment),
            Err(RecvTimeoutError::Timeout) => {}
            Err(RecvTimeoutError::Disconnected) => return,
        }
        segment.run_until(segment.seconds() + 0.02);
        demo.run_once(&mut segment);
    }
}
