//! Start-ups, good and bad, on the simulated bus: the trace and the story next to it in `tests/golden/story`.

#![allow(clippy::unwrap_used, clippy::panic, reason = "a test")]

use profivac_client::pressure::Pressure;
use profivac_devices::model::Model;
use profivac_dp::link::active::{Active, BusParameters};
use profivac_dp::link::{Baud, BitTime};
use profivac_dp::master::{Master, Mode, Settings, SlaveParameters};
use profivac_explain::Decoder;
use profivac_explain::input::Capture;
use profivac_sim::{Segment, StationHandle, Trace};
use profivac_vacuum::Gas;
use profivac_virtual::device::{GasConditions, VirtualDevice};
use profivac_virtual::device_spec::{DeviceSpec, entry};
use profivac_virtual::nonvolatile::NonvolatileMemory;
use std::fs;
use std::path::PathBuf;

const BAUD: Baud = Baud::B500000;
const OWN: u8 = 2;

type OneMaster = Active<Master<2, 64>>;

/// A bus with a device at address 5 and a master that wants to exchange data with it.
struct Desk {
    bus: Segment,
    device: StationHandle<VirtualDevice>,
    master: StationHandle<OneMaster>,
    now: u64,
}

fn model(device: &str) -> &'static Model {
    entry(device).unwrap().model
}

impl Desk {
    fn new(device: &str, parameters: &SlaveParameters<'_>) -> Self {
        let spec: DeviceSpec = format!("{device}@5").parse().unwrap();
        let conditions = GasConditions {
            pressure: Pressure::from_mbar(1e-3),
            atmosphere: Pressure::from_mbar(1013.25),
            gas: Gas::N2,
        };
        let unit = spec.build(NonvolatileMemory::volatile(), BAUD).unwrap();
        let mut bus = Segment::new(BAUD);
        let device = bus.attach(VirtualDevice::new(unit, 5, BAUD, conditions));
        let mut master = Master::on(BusParameters::new(OWN, BAUD), Settings::new(BAUD), BitTime(0));
        master.user.add(parameters).unwrap();
        master.user.set_mode(Mode::Operate);
        let master = bus.attach(master);
        bus.set_trace_length(usize::MAX);
        Self { bus, device, master, now: 0 }
    }

    /// Time passes.
    fn run(&mut self, milliseconds: u64) {
        self.now += milliseconds * u64::from(BAUD.bits_per_second()) / 1000;
        self.bus.run_until(BitTime(self.now)).unwrap();
    }

    /// Compares trace and story with their goldens.
    fn golden(self, name: &str) {
        let trace: Trace = self.bus.trace().clone();
        let text = trace.to_string();
        golden(&format!("{name}.trace"), &text);
        golden(&format!("{name}.txt"), &story(&text));
    }
}

/// One sentence a line, with time and station.
fn story(trace: &str) -> String {
    let recording = Capture::read(trace.as_bytes(), Baud::B9600).unwrap();
    let baud = recording.baud.unwrap();
    let (mut teller, mut told) = (Decoder::new(baud, recording.times), Vec::new());
    recording.chunks.iter().for_each(|noted| teller.push(noted, &mut told));
    teller.end(&mut told);
    let notes = told.iter().flat_map(|told| &told.notes);
    let lines = notes.map(|note| {
        let seconds = note.at.unwrap().0 as f64 / f64::from(baud.bits_per_second());
        let station = note.station.map(|station| station.to_string()).unwrap_or_default();
        format!("{seconds:10.6} {station:>3}  {}\n", note.text)
    });
    lines.collect()
}

/// Compares with a golden, or writes it when `PROFIVAC_BLESS` is 1.
fn golden(name: &str, text: &str) {
    let path = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("tests/golden/story").join(name);
    if std::env::var("PROFIVAC_BLESS").is_ok_and(|bless| bless == "1") {
        fs::create_dir_all(path.parent().unwrap()).unwrap();
        fs::write(&path, text).unwrap();
        return;
    }
    let expected = fs::read_to_string(&path).unwrap_or_else(|error| panic!("{}: {error}", path.display()));
    for (number, (line, expected)) in (1..).zip(text.lines().zip(expected.lines())) {
        assert_eq!(line, expected, "{name}, line {number}");
    }
    assert_eq!(text.len(), expected.len(), "{name}");
}

/// The parameters that fit the device, with its default configuration and mbar.
fn fitting(model: &'static Model) -> SlaveParameters<'static> {
    let user_prm = model.user_prm.first().map_or(&[][..], |prm| prm.octets);
    SlaveParameters { user_prm, ..SlaveParameters::new(5, model.ident, model.default_configuration.octets) }
}

#[test]
fn every_device_starts() {
    for device in ["bcg450", "bpg400", "pcg550", "tpg500", "img400"] {
        let mut desk = Desk::new(device, &fitting(model(device)));
        desk.run(15);
        desk.golden(&format!("start-{device}"));
    }
}

#[test]
fn a_configuration_is_refused_with_both_strings() {
    let bcg = model("bcg450");
    let mut desk = Desk::new("bcg450", &SlaveParameters { cfg: &[0x44, 0x86, 0x05, 0x05, 0x0A, 0x08], ..fitting(bcg) });
    desk.run(11);
    desk.golden("refused-configuration");
}

#[test]
fn parameters_are_refused_with_their_reason() {
    let bcg = model("bcg450");
    let mut desk = Desk::new("bcg450", &SlaveParameters { user_prm: &[0, 0, 0, 0x10, 0x01], ..fitting(bcg) });
    desk.run(11);
    desk.golden("refused-user-parameters");
}

#[test]
fn a_power_cut_is_silence_and_a_start_again() {
    let mut desk = Desk::new("bcg450", &fitting(model("bcg450")));
    desk.run(14);
    desk.bus.station_mut(desk.device).set_power(false);
    desk.run(30);
    desk.bus.station_mut(desk.device).set_power(true);
    desk.run(40);
    desk.golden("power-cut");
}

#[test]
fn a_watchdog_that_expires_is_told_with_both_times() {
    let parameters = SlaveParameters { watchdog: Some([2, 1]), ..fitting(model("bcg450")) };
    let mut desk = Desk::new("bcg450", &parameters);
    desk.run(14);
    desk.bus.station_mut(desk.master).user.set_mode(Mode::Stop);
    desk.run(60);
    desk.bus.station_mut(desk.master).user.set_mode(Mode::Operate);
    desk.run(12);
    desk.golden("watchdog");
}

/// Whatever a file holds: a recording or a sentence, never a panic.
#[test]
fn no_file_does_harm() {
    let folder = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("tests/golden/story");
    let text = fs::read(folder.join("power-cut.trace")).unwrap();
    let trace: Trace = std::str::from_utf8(&text).unwrap().parse().unwrap();
    let lines: Vec<u8> =
        trace.entries.iter().flat_map(|entry| format!("{:02X?}\n", entry.octets).into_bytes()).collect();
    let octets: Vec<u8> = trace.entries.iter().flat_map(|entry| entry.octets.to_vec()).collect();
    let capture = profivac_sim::trace::pcapng::write(&trace, profivac_sim::trace::pcapng::USER0);
    let mut random = profivac_sim::Random::new(3);
    let mut told = 0;
    for round in 0..100 {
        let mut file = [&text, &lines, &octets, &capture][round % 4].clone();
        for _ in 0..1 + random.below(200) {
            let place = random.below(file.len() as u64) as usize;
            match random.below(3) {
                0 => file[place] = random.octet(),
                1 => file[place] ^= 1 << random.below(8),
                _ => drop(file.remove(place)),
            }
        }
        if let Ok(recording) = Capture::read(&file, Baud::B19200) {
            let (mut teller, mut all) = (Decoder::new(Baud::B19200, recording.times), Vec::new());
            recording.chunks.iter().for_each(|noted| teller.push(noted, &mut all));
            teller.end(&mut all);
            told += all.len();
        }
    }
    assert!(told > 5_000, "{told}");
}

/// Sentences about a dialogue that is written as a log.
fn told(log: &str) -> Vec<String> {
    let recording = Capture::read(log.as_bytes(), BAUD).unwrap();
    let (mut teller, mut told) = (Decoder::new(BAUD, recording.times), Vec::new());
    recording.chunks.iter().for_each(|noted| teller.push(noted, &mut told));
    teller.end(&mut told);
    told.into_iter().flat_map(|told| told.notes).map(|note| note.text).collect()
}

/// SD2 with access points, as master `master` asks and the slave at 5 answers.
fn asked(master: u8, sap: u8, fc: u8, du: &[u8]) -> String {
    frame(5, master, sap, 62, fc, du)
}

fn answered(master: u8, sap: u8, du: &[u8]) -> String {
    frame(master, 5, 62, sap, 0x08, du)
}

fn frame(da: u8, sa: u8, dsap: u8, ssap: u8, fc: u8, du: &[u8]) -> String {
    let frame = profivac_wire::DataTelegram { da, sa, dsap: Some(dsap), ssap: Some(ssap), fc, du };
    let mut out = [0; profivac_wire::MAX_TELEGRAM];
    let length = profivac_wire::Telegram::Data(frame).emit(&mut out).unwrap();
    format!("{}\n", profivac_sim::describe::Hex(&out[..length]))
}

#[test]
fn another_owner_and_what_a_master_may_not_do_are_told() {
    let diag = |fc, status: u8, owner| asked(3, 60, fc, &[]) + &answered(3, 60, &[status, 0x0C, 0, owner, 0x08, 0xE6]);
    let log = [
        diag(0x6D, 0, 2),
        diag(0x5D, 0, 3),
        asked(3, 61, 0x7D, &[0x88, 10, 10, 11, 0x08, 0xE6, 0]) + &frame(3, 5, 62, 61, 0x03, &[0]),
    ];
    assert_eq!(
        told(&log.concat()),
        [
            "is there: bcg450 (ident 08E6), belongs to master 2, exchanges data",
            "belongs to master 3 now, before to master 2",
            "does not take Set_Prm of master 3: RS: this service is not open to this master",
        ]
    );
}

#[test]
fn without_times_a_lost_slave_is_told_with_both_reasons() {
    let start = asked(2, 61, 0x5D, &[0x88, 1, 10, 11, 0x08, 0xE6, 0, 0, 0, 0, 5, 0x1C]) + "E5\n";
    let diag = |fc, second: u8, owner, first: u8| {
        asked(2, 60, fc, &[]) + &answered(2, 60, &[first, second, 0, owner, 0x08, 0xE6])
    };
    let story = told(&[start, diag(0x7D, 0x0C, 2, 0), diag(0x5D, 0x05, 0xFF, 2)].concat());
    assert_eq!(story[2], "has lost its parameters: its watchdog of 100 ms has expired, or it was restarted");
    assert_eq!(story[3], "belongs to nobody any more, before to master 2");
}

#[test]
fn repetitions_are_counted_and_silence_is_told_once() {
    let request = asked(2, 60, 0x5D, &[]);
    let answer = answered(2, 60, &[0, 0x0C, 0, 2, 0x08, 0xE6]);
    let log = request.clone() + &answer + &asked(2, 60, 0x7D, &[]).repeat(4) + &request + &answer;
    let recording = Capture::read(log.as_bytes(), BAUD).unwrap();
    let (mut teller, mut all) = (Decoder::new(BAUD, recording.times), Vec::new());
    recording.chunks.iter().for_each(|noted| teller.push(noted, &mut all));
    let counters = teller.explainer().counters(5);
    assert_eq!((counters.requests, counters.retries, counters.unanswered), (6, 3, 4));
    let texts = told(&log);
    assert_eq!(texts[1..], ["does not answer master 2 any more", "answers again, 4 requests were in vain"]);
}
