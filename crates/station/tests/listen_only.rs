//! A segment on which the station only listens: readings, statistics and captures of the bus of another master, and no octet sent.

#![allow(clippy::unwrap_used, clippy::panic, clippy::indexing_slicing, reason = "a test")]

mod support;

use profivac_devices::catalog::model_named;
use profivac_listen::gauge::Origin;
use profivac_listen::station::StationState;
use profivac_recorder::{Micros, Quality};
use profivac_station::config::Config;
use profivac_station::station::Station;
use profivac_station::view::{BusStationState, SegmentState};
use profivac_wire::{DataTelegram, MAX_TELEGRAM, Telegram};
use std::io::{ErrorKind, Read, Write};
use std::net::TcpListener;
use std::path::Path;
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::Duration;
use support::until;

const MASTER: u8 = 2;
const SLAVE: u8 = 12;

/// A bus of another master behind a TCP port. It counts the octets that a listener sends.
struct ForeignBus {
    port: u16,
    sent_by_listener: Arc<AtomicU64>,
}

fn emit(da: u8, sa: u8, saps: Option<(u8, u8)>, fc: u8, du: &[u8]) -> Vec<u8> {
    let mut octets = vec![0; MAX_TELEGRAM];
    let (dsap, ssap) = saps.map_or((None, None), |(dsap, ssap)| (Some(dsap), Some(ssap)));
    let length = Telegram::Data(DataTelegram { da, sa, dsap, ssap, fc, du }).emit(&mut octets).unwrap();
    octets.truncate(length);
    octets
}

/// One start-up of a BCG450 with pressures in Torr, as a PLC does it.
fn start_up() -> Vec<Vec<u8>> {
    let model = model_named("bcg450").unwrap();
    let torr = model.unit_named("Torr").unwrap();
    let user = model.user_prm.iter().find(|prm| prm.unit_code() == torr.code).unwrap();
    let [high, low] = model.ident.to_be_bytes();
    let prm = [&[0x88, 1, 100, 11, high, low, 0][..], user.octets].concat();
    let diagnosis = [0x00, 0x0C, 0x00, MASTER, high, low];
    vec![
        emit(SLAVE, MASTER, Some((61, 62)), 0x6D, &prm),
        vec![0xE5],
        emit(SLAVE, MASTER, Some((62, 62)), 0x5D, model.configurations[1].octets),
        vec![0xE5],
        emit(SLAVE, MASTER, Some((60, 62)), 0x7D, &[]),
        emit(MASTER, SLAVE, Some((62, 60)), 0x08, &diagnosis),
    ]
}

/// One cycle: a token, an exchange, and every tenth time a repetition.
fn cycle(number: u64) -> Vec<Vec<u8>> {
    let inputs = [&[0x80, 0x00, 0x02][..], &1.0e-4_f32.to_be_bytes()].concat();
    let request = emit(SLAVE, MASTER, None, if number.is_multiple_of(2) { 0x7D } else { 0x5D }, &[]);
    let answer = emit(MASTER, SLAVE, None, 0x08, &inputs);
    let repetition = if number.is_multiple_of(10) { vec![request.clone()] } else { Vec::new() };
    [vec![vec![0xDC, MASTER, MASTER]], repetition, vec![request, answer]].concat()
}

impl ForeignBus {
    fn begin() -> Self {
        let listener = TcpListener::bind("127.0.0.1:0").unwrap();
        let port = listener.local_addr().unwrap().port();
        let sent_by_listener = Arc::new(AtomicU64::new(0));
        let counter = Arc::clone(&sent_by_listener);
        std::thread::spawn(move || {
            let Ok((mut stream, _)) = listener.accept() else { return };
            // The time in which the listener could send paces the bus.
            stream.set_read_timeout(Some(Duration::from_millis(10))).unwrap();
            stream.set_nodelay(true).unwrap();
            for number in 0_u64.. {
                let telegrams = if number == 3 { start_up() } else { cycle(number) };
                for telegram in telegrams {
                    if stream.write_all(&telegram).is_err() {
                        return;
                    }
                    match stream.read(&mut [0; 64]) {
                        Ok(0) => return,
                        Ok(count) => drop(counter.fetch_add(count as u64, Ordering::Relaxed)),
                        Err(error) => assert!(matches!(error.kind(), ErrorKind::WouldBlock | ErrorKind::TimedOut)),
                    }
                }
            }
        });
        Self { port, sent_by_listener }
    }

    fn config(&self, folder: &Path) -> Config {
        let text = format!(
            "[[segment]]\nname = \"plc\"\nport = \"tcp://127.0.0.1:{}\"\nlisten-only = true\n\
             [[segment.gauge]]\nname = \"furnace\"\naddress = {SLAVE}\ndevice = \"bcg450\"\npoll = \"50 ms\"\n\
             [[alarm]]\nname = \"repetitions\"\nsegment = \"plc\"\nstation = {SLAVE}\nrepetitions = 1.0\ndelay = \"0 s\"\n",
            self.port
        );
        Config::parse(&text, &folder.join("plant.toml")).unwrap()
    }
}

#[test]
fn a_listen_only_segment_records_the_gauges_of_another_master_and_sends_nothing() {
    let folder = tempfile::tempdir().unwrap();
    let bus = ForeignBus::begin();
    let station = Station::start(bus.config(folder.path())).unwrap();
    let services = station.services();
    let gauge = until("the gauge", || {
        let gauge = services.snapshots().gauge("furnace")?;
        (gauge.state == BusStationState::DataExchange && gauge.assumptions.is_empty()).then_some(gauge)
    });
    assert!(gauge.listen_only);
    let pa = gauge.readings[0].pa.unwrap();
    assert!((pa / 0.013_332_2 - 1.0).abs() < 1e-4, "1e-4 Torr: {pa}");
    assert_eq!((gauge.readings[0].quality, gauge.readings[0].series.as_str()), (Quality::Valid, "furnace"));
    let segment = services.snapshots().segments().remove(0);
    assert_eq!((segment.state, segment.listen_only, segment.master), (SegmentState::Running, true, None));
    let states: Vec<_> = segment.stations.iter().map(|station| (station.address, station.state)).collect();
    assert_eq!(states, [(MASTER, BusStationState::OtherMaster), (SLAVE, BusStationState::DataExchange)]);

    let report = until("the report", || {
        services
            .snapshots()
            .buses()
            .report("plc")
            .filter(|it| it.stations.len() == 2 && it.stations[1].total.repeated > 2)
    });
    let slave = &report.stations[1];
    assert_eq!(
        (slave.state, slave.configuration_origin, slave.unit_origin),
        (StationState::Exchanging, Some(Origin::Heard), Some(Origin::Heard))
    );
    assert_eq!((slave.longest_sequence, slave.owner, report.ring.as_slice()), (1, Some(MASTER), &[MASTER][..]));
    until("the alarm", || {
        services
            .alarms()
            .all()
            .into_iter()
            .find(|alarm| alarm.name == "repetitions" && alarm.value.is_some_and(|value| value > 1.0))
    });

    let refused = services.control().requests().blocks("furnace").unwrap_err().to_string();
    assert!(refused.contains("segment plc is listen-only: the station sends nothing on it"), "{refused}");

    assert!(services.snapshots().buses().request_capture("plc", "the test"));
    let captures = services.snapshots().buses().captures("plc").unwrap();
    let capture = until("a capture", || captures.list().unwrap().pop());
    let trace =
        profivac_sim::trace::pcapng::read(&captures.read(&capture.name).unwrap(), profivac_dp::link::Baud::B19200)
            .unwrap();
    assert!(trace.entries.len() > 20, "{}", trace.entries.len());

    station.stop();
    assert_eq!(bus.sent_by_listener.load(Ordering::Relaxed), 0, "no octet was sent");
    let samples = services.recorder().open_reader().unwrap().samples("furnace", Micros(0), Micros(i64::MAX)).unwrap();
    assert!(samples.iter().any(|sample| sample.quality == Quality::Valid));
    assert_eq!(samples.last().unwrap().quality, Quality::Stale, "the end of the station is a gap");
}

/// The line of the station's own master is observed too.
#[test]
fn a_segment_with_a_master_has_the_same_statistics() {
    let folder = tempfile::tempdir().unwrap();
    let devices = folder.path().join("hall.toml");
    std::fs::write(&devices, "devices = [\"bcg450@5\"]\nbaud = 187500\n").unwrap();
    let text = format!(
        "[[segment]]\nname = \"hall\"\nport = \"sim:{}\"\nbaud = 187500\nmaster = 1\n\
         [[segment.gauge]]\nname = \"chamber\"\naddress = 5\ndevice = \"bcg450\"\n",
        devices.display()
    );
    let station = Station::start(Config::parse(&text, &folder.path().join("plant.toml")).unwrap()).unwrap();
    let services = station.services();
    let report = until("the report", || {
        let report = services.snapshots().buses().report("hall")?;
        let slave = report.stations.iter().find(|station| station.address == 5)?;
        (slave.state == StationState::Exchanging && slave.total.exchanges > 3).then_some(report)
    });
    assert_eq!((report.stations[0].address, report.stations[0].state), (1, StationState::Master));
    let slave = &report.stations[1];
    assert_eq!(
        (slave.configuration_origin, slave.devices.as_slice()),
        (Some(Origin::Heard), &["bcg450".to_owned()][..])
    );
    assert!(!report.parameters.is_empty(), "the station reads the unit over MS2");
    station.stop();
}

#[test]
fn the_keys_of_a_listen_only_segment_are_checked() {
    let config = |segment: &str, gauge: &str| {
        let text = format!(
            "[[segment]]\nname = \"plc\"\nport = \"/dev/null\"\n{segment}\n[[segment.gauge]]\nname = \"g\"\naddress = 0\ndevice = \"bcg450\"\n{gauge}\n"
        );
        Config::parse(&text, Path::new("plant.toml")).map_err(|error| error.to_string())
    };
    let listening = config("listen-only = true", "unit = \"Torr\"").unwrap();
    let segment = &listening.segments[0];
    assert!(segment.listen_only && segment.detects_baud);
    assert_eq!(segment.gauges[0].unit.unwrap().name, "Torr");
    assert!(!config("listen-only = true\nbaud = 93750", "").unwrap().segments[0].detects_baud);
    let refused = |segment: &str, gauge: &str, expected: &str| {
        let error = config(segment, gauge).unwrap_err();
        assert!(error.contains(expected), "{error}");
    };
    refused("listen-only = true\nmaster = 1", "", "a segment with listen-only = true has no master");
    refused("master = 1", "unit = \"Torr\"", "the key unit is for segments with listen-only = true");
    refused("listen-only = true", "unit = \"parsec\"", "expected a unit of a bcg450");
    refused("listen-only = true", "configuration = \"00 11\"", "expected the octets of Chk_Cfg of a bcg450, one of: ");
}
