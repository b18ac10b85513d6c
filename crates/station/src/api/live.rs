//! The live stream of a station: what its events hold.

use crate::alarm::view::{AlarmCount, AlarmOverview, AlarmView, DeclaredPlantState};
use crate::plant::LivePlant;
use crate::services::Services;
use crate::view::{
    BusStationState, ControlAuthorityView, Gauge, GaugeKind, PressureLevel, ReadProgress, Reading, Segment, Station,
    WatchedParameter,
};
use axum::extract::State;
use axum::http::{Extensions, HeaderMap};
use axum::response::Response;
use profivac_web_server::live_source::{LiveSource, stream};
use serde::Serialize;
use serde_json::Value;
use std::collections::BTreeMap;
use std::sync::Arc;
use std::time::{Duration, Instant};
use utoipa::ToSchema;

/// The interval between two events. free choice: a reader cannot follow faster numbers.
const PERIOD: Duration = Duration::from_millis(250);

/// Pressures have this number of digits in the live stream. The dashboard shows three; more would only cost bandwidth.
const DIGITS: usize = 5;

/// Data of the live stream. The event `snapshot` comes first and once.
#[derive(Debug, Serialize, ToSchema)]
#[serde(untagged)]
#[expect(dead_code, reason = "describes the events, which are sent as text")]
pub enum LiveEvent {
    /// The event `snapshot`.
    Snapshot(Box<Snapshot>),
    /// The event `change`.
    Change(Change),
}

/// A JSON merge patch (RFC 7396) of the snapshot: only what has changed. A property that becomes `null`, and an entry that disappears,
/// is `null` here.
#[derive(Debug, Serialize, ToSchema)]
#[schema(value_type = Object)]
pub struct Change(Value);

/// The state of the station at one moment.
#[derive(Debug, Serialize, ToSchema)]
pub struct Snapshot {
    /// The station.
    station: Station,
    /// Its segments, by name.
    segments: BTreeMap<String, Segment>,
    /// Its gauges with their readings, by name.
    gauges: BTreeMap<String, LiveGauge>,
    /// The names of the gauges in the order of the station's file.
    gauge_order: Vec<String>,
    /// The user with control authority, and a request for it.
    control_authority: ControlAuthorityView,
    /// The gauges whose parameters are being read.
    read_progress: Vec<ReadProgress>,
    /// The active alarms.
    alarms: LiveAlarms,
    /// The states of the parts of the plant.
    plant: LivePlant,
    /// Changes when `/api/directory` changes.
    directory_revision: u64,
}

/// A point of a slave in the live stream.
#[derive(Debug, Serialize, ToSchema)]
pub struct LivePoint {
    /// Its name.
    name: String,
    /// Its place in the inputs.
    place: String,
    /// The unit of its number.
    unit: Option<&'static str>,
    /// The number; `null` without a value.
    number: Option<f64>,
    /// The value in words, with its unit.
    text: String,
    /// The quality: `valid`, `fault`, `stale`.
    #[schema(value_type = String)]
    quality: &'static str,
}

impl From<&WatchedParameter> for LivePoint {
    fn from(point: &WatchedParameter) -> Self {
        Self {
            name: point.target.clone(),
            place: point.name.clone(),
            unit: point.unit,
            number: point.number,
            text: point.text.clone(),
            quality: point.quality.word(),
        }
    }
}

/// A gauge, or another slave of the station's file, in the live stream.
#[derive(Debug, Serialize, ToSchema)]
pub struct LiveGauge {
    /// Its name.
    name: String,
    /// A gauge with readings, or a slave with points.
    kind: GaugeKind,
    /// Its segment.
    segment: String,
    /// Its address.
    address: u8,
    /// The device: `bcg450`.
    device: String,
    /// Whether parameters are read and commands are sent while it exchanges data: the device has DP-V1.
    has_dpv1: bool,
    /// Another master owns it and the station only listens: no parameter is read and no command is sent.
    listen_only: bool,
    /// The assumptions about its configuration and unit, in sentences.
    assumptions: Vec<String>,
    /// The state.
    state: BusStationState,
    /// Why it is not in data exchange, in a sentence.
    problem: Option<String>,
    /// The alarms that it reports: its defects.
    exceptions: Vec<String>,
    /// The warnings that it reports, without those that the qualities of its readings explain.
    warnings: Vec<String>,
    /// The gas for which the readings are corrected.
    gas: String,
    /// Pressures that trends mark with a line.
    levels: Vec<PressureLevel>,
    /// The readings, by series.
    readings: BTreeMap<String, Reading>,
    /// The points of a slave, in the order of the station's file.
    points: Vec<LivePoint>,
    /// The age of the readings in milliseconds, rounded down to whole seconds; `null` if there never was one.
    age_ms: Option<u64>,
    /// The poll interval in milliseconds.
    poll_ms: u64,
    /// The age in milliseconds from which the readings are stale.
    stale_after_ms: u64,
}

impl From<Gauge> for LiveGauge {
    fn from(gauge: Gauge) -> Self {
        let readings = gauge.readings.into_iter().map(|reading| (reading.series.clone(), rounded(reading))).collect();
        let is_slave = gauge.kind == GaugeKind::Slave;
        Self {
            kind: gauge.kind,
            points: gauge.parameters.iter().filter(|_| is_slave).map(LivePoint::from).collect(),
            name: gauge.name,
            segment: gauge.segment,
            address: gauge.address,
            device: gauge.device,
            has_dpv1: gauge.has_dpv1,
            listen_only: gauge.listen_only,
            assumptions: gauge.assumptions,
            state: gauge.state,
            problem: gauge.problem,
            exceptions: gauge.exceptions,
            warnings: gauge.warnings,
            gas: gauge.gas,
            levels: gauge.levels,
            readings,
            // A gauge that is read regularly has the same age all the time.
            age_ms: gauge.age_ms.map(|age| age / 1000 * 1000),
            poll_ms: gauge.poll_ms,
            stale_after_ms: gauge.stale_after_ms,
        }
    }
}

/// The reading with [`DIGITS`] digits.
fn rounded(reading: Reading) -> Reading {
    let round = |pa: f64| format!("{pa:.*e}", DIGITS - 1).parse().unwrap_or(pa);
    Reading { pa: reading.pa.map(round), corrected_pa: reading.corrected_pa.map(round), ..reading }
}

/// The alarms at one moment, in the live stream.
#[derive(Debug, Serialize, ToSchema)]
pub struct LiveAlarms {
    /// Why this overview may be wrong: the alarms were not evaluated for a while, or cannot be stored.
    problem: Option<String>,
    /// Alarms of high priority.
    high: AlarmCount,
    /// Alarms of medium priority.
    medium: AlarmCount,
    /// Alarms of low priority.
    low: AlarmCount,
    /// The number of shelved alarms.
    shelved: usize,
    /// The number of alarms out of service.
    out_of_service: usize,
    /// The number of alarms that a plant state suppresses.
    suppressed: usize,
    /// The declared plant states, in the order of the station's file.
    plant_states: Vec<DeclaredPlantState>,
    /// Alarms that are neither normal nor shelved nor out of service nor suppressed, by name, up to 50.
    alarms: BTreeMap<String, AlarmView>,
    /// Their names, the most urgent first.
    order: Vec<String>,
    /// The number of such alarms beyond the list.
    not_listed: usize,
}

impl From<AlarmOverview> for LiveAlarms {
    fn from(overview: AlarmOverview) -> Self {
        let AlarmOverview {
            problem,
            high,
            medium,
            low,
            shelved,
            out_of_service,
            suppressed,
            plant_states,
            alarms,
            not_listed,
        } = overview;
        let order = alarms.iter().map(|alarm| alarm.name.clone()).collect();
        let alarms = alarms.into_iter().map(|alarm| (alarm.name.clone(), alarm)).collect();
        Self {
            problem,
            high,
            medium,
            low,
            shelved,
            out_of_service,
            suppressed,
            plant_states,
            alarms,
            order,
            not_listed,
        }
    }
}

/// The state of a station for the live stream.
pub fn source(services: Arc<Services>) -> LiveSource {
    LiveSource::of(PERIOD, move || state(&services))
}

fn state(services: &Services) -> Value {
    let gauges = services.snapshots().gauges();
    let segments = services.snapshots().segments();
    let snapshot = Snapshot {
        station: services.station(),
        segments: segments.into_iter().map(|segment| (segment.name.clone(), segment)).collect(),
        gauge_order: gauges.iter().map(|gauge| gauge.name.clone()).collect(),
        gauges: gauges.into_iter().map(|gauge| (gauge.name.clone(), gauge.into())).collect(),
        control_authority: services.control().authority(Instant::now()),
        read_progress: services.snapshots().read_progress(),
        alarms: services.alarms().overview().into(),
        plant: services.plant().live(),
        directory_revision: services.directory().revision(),
    };
    // Numbers, texts and lists always have a JSON form.
    serde_json::to_value(&snapshot).unwrap_or_default()
}

/// The state of the station and its changes, up to four a second
///
/// Server-sent events. The event `snapshot` has the whole state and comes first; each event `change` is a JSON merge patch (RFC 7396) of
/// the state. A slow client gets fewer events, and misses no change. The stream is compressed for a client that accepts gzip. It ends with
/// the session of its client.
#[utoipa::path(get, path = "/api/live", responses((status = 200, content_type = "text/event-stream", body = LiveEvent)))]
pub async fn live(State(source): State<Arc<LiveSource>>, headers: HeaderMap, extensions: Extensions) -> Response {
    stream(source, &headers, &extensions)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::snapshot::SegmentSnapshot;
    use crate::view::SegmentState;
    use flate2::Compression;
    use flate2::write::GzEncoder;
    use profivac_recorder::{Quality, Recorder, Settings};
    use std::io::Write;
    use tempfile::TempDir;

    fn plant() -> (LiveSource, Arc<Services>, TempDir) {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("plant.db");
        let recorder = Recorder::start(&file, Settings::default()).unwrap();
        let services = Arc::new(Services::new("hall".to_owned(), file, recorder));
        (source(Arc::clone(&services)), services, folder)
    }

    fn reading(series: &str, pa: f64) -> Reading {
        Reading {
            series: series.to_owned(),
            instance: 1,
            principle: Some(profivac_devices::Principle::Pirani),
            pa: Some(pa),
            limit_pa: None,
            corrected_pa: Some(pa),
            quality: Quality::Valid,
            cause: None,
        }
    }

    fn gauge(name: String, segment: &str, pa: f64) -> Gauge {
        Gauge {
            readings: vec![reading(&name, pa)],
            name,
            kind: GaugeKind::Gauge,
            segment: segment.to_owned(),
            address: 5,
            device: "bcg450".to_owned(),
            has_dpv1: true,
            listen_only: false,
            assumptions: Vec::new(),
            state: BusStationState::DataExchange,
            problem: None,
            exceptions: Vec::new(),
            warnings: Vec::new(),
            gas: "n2".to_owned(),
            levels: Vec::new(),
            age_ms: Some(12),
            parameters: Arc::default(),
            read_at: None,
            lost_at: None,
            poll_ms: 200,
            stale_after_ms: 3000,
        }
    }

    fn publish(services: &Services, segment: &str, gauges: Vec<Gauge>) {
        let view = Segment {
            name: segment.to_owned(),
            port: "/dev/ttyUSB0".to_owned(),
            baud: 19200,
            master: Some(0),
            listen_only: false,
            state: SegmentState::Running,
            problem: None,
            cycle_ms: Some(1.0),
            damaged_telegrams: 0,
            stations: Vec::new(),
        };
        services.snapshots().publish(SegmentSnapshot { segment: view, gauges });
    }

    #[test]
    fn the_first_event_has_everything_and_the_next_one_the_changes() {
        let (source, services, _folder) = plant();
        publish(&services, "north", vec![gauge("a".to_owned(), "north", 1.0), gauge("b".to_owned(), "north", 2.0)]);
        let (mut has, begin) = (None, Instant::now());
        let (name, data) = source.event(&mut has, begin);
        let first: Value = serde_json::from_str(&data).unwrap();
        assert_eq!((name, &first["gauges"]["a"]["readings"]["a"]["pa"]), ("snapshot", &Value::from(1.0)));
        assert_eq!(first["gauge_order"], serde_json::json!(["a", "b"]));
        publish(
            &services,
            "north",
            vec![gauge("a".to_owned(), "north", 1.0), gauge("b".to_owned(), "north", 2.123_456)],
        );
        let (name, data) = source.event(&mut has, begin + PERIOD);
        let change: Value = serde_json::from_str(&data).unwrap();
        let expected = serde_json::json!({"b": {"readings": {"b": {"pa": 2.1235, "corrected_pa": 2.1235}}}});
        assert_eq!((name, &change["gauges"]), ("change", &expected));
        assert!(change.get("segments").is_none() && change.get("alarms").is_none(), "{change}");
    }

    /// A client whose line is blocked for a while is not polled; its next event has all changes since its last one.
    #[test]
    fn a_slow_client_misses_no_change_and_has_no_queue() {
        let (source, services, _folder) = plant();
        let begin = Instant::now();
        let (mut fast, mut slow) = (None, None);
        publish(&services, "north", vec![gauge("a".to_owned(), "north", 1.0)]);
        source.event(&mut slow, begin);
        source.event(&mut fast, begin);
        for step in 1..=40_u32 {
            publish(&services, "north", vec![gauge("a".to_owned(), "north", f64::from(step))]);
            source.event(&mut fast, begin + PERIOD * step);
        }
        let (_, data) = source.event(&mut slow, begin + PERIOD * 40);
        let change: Value = serde_json::from_str(&data).unwrap();
        assert_eq!(change["gauges"]["a"]["readings"]["a"]["pa"], 40.0);
        assert!(Arc::ptr_eq(slow.as_ref().unwrap(), fast.as_ref().unwrap()), "both have the same state");
    }

    #[test]
    fn all_clients_share_a_state_for_one_period() {
        let (source, _services, _folder) = plant();
        let (mut one, mut other, begin) = (None, None, Instant::now());
        source.event(&mut one, begin);
        source.event(&mut other, begin + PERIOD / 2);
        assert!(Arc::ptr_eq(one.as_ref().unwrap(), other.as_ref().unwrap()));
        // The second tick of a client may be a little early.
        let before = one.clone();
        let (_, patch) = source.event(&mut one, begin + PERIOD * 9 / 10);
        let (_, same) = source.event(&mut other, begin + PERIOD);
        assert!(!Arc::ptr_eq(before.as_ref().unwrap(), one.as_ref().unwrap()), "a new state");
        assert!(Arc::ptr_eq(&patch, &same), "the patch is made once");
    }

    /// 480 gauges on 16 segments whose pressures all change in all digits between two events.
    #[test]
    fn the_changes_of_480_gauges_fit_into_50_kilobytes_per_second() {
        let (source, services, _folder) = plant();
        let mut random = fastrand::Rng::with_seed(1);
        let (mut has, begin) = (None, Instant::now());
        let mut encoder = GzEncoder::new(Vec::new(), Compression::default());
        let mut sizes = Vec::new();
        for step in 0..9_u32 {
            for segment in 0..16 {
                let name = format!("segment {segment:02}");
                let mut pa = || 10_f64.powf(-8.0 + 6.0 * random.f64());
                let gauges = (0..30).map(|number| gauge(format!("gauge {segment:02}-{number:02}"), &name, pa()));
                publish(&services, &name, gauges.collect());
            }
            let (_, data) = source.event(&mut has, begin + PERIOD * step);
            encoder.write_all(data.as_bytes()).unwrap();
            encoder.flush().unwrap();
            sizes.push(std::mem::take(encoder.get_mut()).len());
        }
        let second: usize = sizes[1..5].iter().sum();
        assert!(second < 50_000, "{sizes:?}");
    }
}
