//! The live stream of a station: what its events hold.

use crate::alarm::view::{AlarmOverview, AlarmView, AlarmsNow};
use crate::plant::LivePlant;
use crate::services::Services;
use crate::view::{ControlAuthorityView, Gauge, GaugeKind, ReadProgress, Reading, Segment, Station, WatchedParameter};
use axum::extract::State;
use axum::http::{Extensions, HeaderMap};
use axum::response::Response;
use profivac_devices::reading::is_pressure;
use profivac_web_server::live_source::{Changes, LiveSource, LiveState, stream};
use serde::Serialize;
use serde_json::Value;
use std::collections::BTreeMap;
use std::sync::Arc;
use std::time::{Duration, Instant};
use utoipa::ToSchema;

/// The interval between two events. chosen: a reader cannot follow faster numbers.
const PERIOD: Duration = Duration::from_millis(250);

/// Pressures have this number of digits in the live stream. The dashboard shows three; more would only cost bandwidth.
const DIGITS: i32 = 5;

/// So many alarms of the live stream have their present value. chosen: a page shows fewer at a time, and in a flood each value would change at each
/// reading.
const ALARM_VALUES: usize = 50;

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

/// The parts of the snapshot that have changed. `segments`, `gauges` and `standing_alarms` have the entries that have changed, and `null` for
/// one that is gone; the other parts are whole.
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
    /// Its gauges with their readings, by name: pressures with five digits, ages in whole seconds, without `read_ms`, and with
    /// `parameters` of slaves only, which are their points.
    gauges: BTreeMap<String, Gauge>,
    /// The names of the gauges in the order of the station's file.
    gauge_order: Vec<String>,
    /// The user with control authority, and a request for it.
    control_authority: ControlAuthorityView,
    /// The gauges whose parameters are being read.
    read_progress: Vec<ReadProgress>,
    /// The number of alarms by state and priority.
    alarms: AlarmOverview,
    /// All alarms that are neither normal nor shelved nor out of service nor suppressed, by name. The 50 most urgent have a present value, with
    /// five digits; `/api/alarms` has the others.
    standing_alarms: BTreeMap<String, AlarmView>,
    /// The states of the parts of the plant.
    plant: LivePlant,
    /// Changes when `/api/directory` changes.
    directory_revision: u64,
}

impl LiveState for Snapshot {
    fn changes_since(&self, before: &Self) -> Changes {
        let Self {
            station,
            segments,
            gauges,
            gauge_order,
            control_authority,
            read_progress,
            alarms,
            standing_alarms,
            plant,
            directory_revision,
        } = self;
        Changes::default()
            .part("station", &before.station, station)
            .entries("segments", &before.segments, segments)
            .entries("gauges", &before.gauges, gauges)
            .part("gauge_order", &before.gauge_order, gauge_order)
            .part("control_authority", &before.control_authority, control_authority)
            .part("read_progress", &before.read_progress, read_progress)
            .part("alarms", &before.alarms, alarms)
            .entries("standing_alarms", &before.standing_alarms, standing_alarms)
            .part("plant", &before.plant, plant)
            .part("directory_revision", &before.directory_revision, directory_revision)
    }
}

/// The gauge as the stream sends it: what changes at each reading without news for a page is rounded or left out.
fn for_live(gauge: Gauge) -> Gauge {
    let mut readings = gauge.readings;
    readings.sort_by_key(|reading| reading.instance);
    for Reading { pa, corrected_pa, .. } in &mut readings {
        (*pa, *corrected_pa) = (pa.map(rounded), corrected_pa.map(rounded));
    }
    // A gauge that is read regularly has the same age in whole seconds all the time.
    let age_ms = gauge.age_ms.map(|age| age / 1000 * 1000);
    let points = match gauge.kind {
        GaugeKind::Gauge => Arc::default(),
        GaugeKind::Slave => {
            gauge.parameters.iter().map(|point| WatchedParameter { read_at: None, ..point.clone() }).collect()
        }
    };
    Gauge { readings, age_ms, read_at: None, parameters: points, ..gauge }
}

/// The alarms as the stream sends them, the most urgent first.
fn standing(alarms: Vec<AlarmView>) -> BTreeMap<String, AlarmView> {
    let shown = alarms.into_iter().enumerate().map(|(number, alarm)| {
        let value = alarm.value.filter(|_| number < ALARM_VALUES).map(rounded);
        (alarm.name.clone(), AlarmView { value, ..alarm })
    });
    shown.collect()
}

/// The pressure with [`DIGITS`] digits. A number that is no pressure stays as it is.
fn rounded(pa: f64) -> f64 {
    if !is_pressure(pa) {
        return pa;
    }
    let decimals = DIGITS - 1 - pa.log10().floor() as i32;
    let scale = 10_f64.powi(decimals.abs());
    // Powers of ten up to 1e22 are exact, so that the quotient is the nearest number to the digits.
    let rounded = if decimals < 0 { (pa / scale).round() * scale } else { (pa * scale).round() / scale };
    if rounded.is_finite() { rounded } else { pa }
}

/// The state of a station for the live stream.
pub fn source(services: Arc<Services>) -> LiveSource<Snapshot> {
    LiveSource::of(PERIOD, move || state(&services))
}

fn state(services: &Services) -> Snapshot {
    let gauges = services.snapshots().gauges();
    let segments = services.snapshots().segments();
    let AlarmsNow { overview, standing: alarms } = services.alarms().overview();
    Snapshot {
        station: services.station(),
        segments: segments.into_iter().map(|segment| (segment.name.clone(), segment)).collect(),
        gauge_order: gauges.iter().map(|gauge| gauge.name.clone()).collect(),
        gauges: gauges.into_iter().map(|gauge| (gauge.name.clone(), for_live(gauge))).collect(),
        control_authority: services.control().authority(Instant::now()),
        read_progress: services.snapshots().read_progress(),
        alarms: overview,
        standing_alarms: standing(alarms),
        plant: services.plant().live(),
        directory_revision: services.directory().revision(),
    }
}

/// The state of the station and its changes, up to four a second
///
/// Server-sent events. The event `snapshot` has the whole state and comes first; each event `change` has the parts of it that have
/// changed. A slow client gets fewer events, and misses no change. The stream is compressed for a client that accepts gzip. It ends with
/// the session of its client.
#[utoipa::path(get, path = "/api/live", responses((status = 200, content_type = "text/event-stream", body = LiveEvent)))]
pub async fn live(
    State(source): State<Arc<LiveSource<Snapshot>>>,
    headers: HeaderMap,
    extensions: Extensions,
) -> Response {
    stream(source, &headers, &extensions)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::alarm::{Condition, Priority, Rule};
    use crate::snapshot::SegmentSnapshot;
    use crate::view::{BusStationState, SegmentState};
    use flate2::Compression;
    use flate2::write::GzEncoder;
    use profivac_recorder::{Quality, Recorder, Settings};
    use std::io::Write;
    use tempfile::TempDir;

    fn plant() -> (LiveSource<Snapshot>, Arc<Services>, TempDir) {
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
            is_defect: false,
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
            state: BusStationState::DataExchange,
            gas: "n2".to_owned(),
            age_ms: Some(12),
            poll_ms: 200,
            stale_after_ms: 3000,
            ..Gauge::default()
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
        assert_eq!((name, &first["gauges"]["a"]["readings"][0]["pa"]), ("snapshot", &Value::from(1.0)));
        assert_eq!(first["gauge_order"], serde_json::json!(["a", "b"]));
        publish(
            &services,
            "north",
            vec![gauge("a".to_owned(), "north", 1.0), gauge("b".to_owned(), "north", 2.123_456)],
        );
        let (name, data) = source.event(&mut has, begin + PERIOD);
        let change: Value = serde_json::from_str(&data).unwrap();
        let changed = change["gauges"].as_object().unwrap();
        assert_eq!((name, changed.keys().map(String::as_str).collect::<Vec<_>>()), ("change", vec!["b"]));
        let whole = serde_json::to_value(for_live(gauge("b".to_owned(), "north", 2.1235))).unwrap();
        assert_eq!(changed["b"], whole);
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
        assert_eq!(change["gauges"]["a"]["readings"][0]["pa"], 40.0);
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

    #[test]
    fn a_pressure_has_five_digits() {
        let mut random = fastrand::Rng::with_seed(2);
        for _ in 0..10_000 {
            let pa = 10_f64.powf(-12.0 + 18.0 * random.f64());
            assert_eq!(rounded(pa).to_string(), format!("{pa:.4e}").parse::<f64>().unwrap().to_string(), "{pa}");
        }
        assert_eq!([0.0, -1.0, f64::MIN_POSITIVE].map(rounded), [0.0, -1.0, f64::MIN_POSITIVE], "no pressure");
        assert_eq!([99_999.9, 1e5, 123_456.0, 9.999_96e-9].map(rounded), [1e5, 1e5, 123_460.0, 1e-8]);
    }

    /// What would change the stream at each reading without a change on a page.
    #[test]
    fn the_time_of_a_reading_and_the_parameters_of_gateways_change_nothing() {
        let before = gauge("a".to_owned(), "north", 1.0);
        let later = Gauge { age_ms: Some(999), read_at: Some(profivac_model::Micros(7)), ..before.clone() };
        assert_eq!(for_live(later), for_live(before));
    }

    /// In a flood a page must know each alarm: a gauge whose alarm is missing would look sound.
    #[test]
    fn all_alarms_are_in_the_stream_and_only_the_most_urgent_have_a_value() {
        let alarm = |number: usize| {
            let rule = Rule {
                name: format!("alarm {number:03}"),
                condition: Condition::NotRecording,
                priority: Priority::High,
                delay: Duration::ZERO,
                off_delay: Duration::ZERO,
                message: None,
            };
            AlarmView { value: Some(1.234_567 + number as f64), ..AlarmView::planned(&rule) }
        };
        let sent = standing((0..500).map(alarm).collect());
        assert_eq!(sent.len(), 500);
        let with_value: Vec<_> = sent.values().filter_map(|alarm| Some((alarm.name.as_str(), alarm.value?))).collect();
        assert_eq!(with_value.len(), ALARM_VALUES);
        assert_eq!((with_value[0], with_value[49]), (("alarm 000", 1.2346), ("alarm 049", 50.235)));
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
