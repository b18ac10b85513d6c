//! Start-ups and their failures on the simulated segment. The folder `tests/golden/notes` has a trace and the notes about it for
//! each.

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

/// A segment with a device at address 5 and a master that starts it.
struct TestSegment {
    segment: Segment,
    device: StationHandle<VirtualDevice>,
    master: StationHandle<OneMaster>,
    now: u64,
}

fn model(device: &str) -> &'static Model {
    entry(device).unwrap().model
}

impl TestSegment {
    fn new(device: &str, parameters: &SlaveParameters<'_>) -> Self {
        let spec: DeviceSpec = format!("{device}@5").parse().unwrap();
        let conditions = GasConditions {
            pressure: Pressure::from_mbar(1e-3),
            atmosphere: Pressure::from_mbar(1013.25),
            gas: Gas::N2,
        };
        let built = spec.build(NonvolatileMemory::volatile(), BAUD).unwrap();
        let mut segment = Segment::new(BAUD);
        let device = segment.attach(VirtualDevice::new(built, 5, BAUD, conditions));
        let mut master = Master::on(BusParameters::new(OWN, BAUD), Settings::new(BAUD), BitTime(0));
        master.user.add(parameters).unwrap();
        master.user.set_mode(Mode::Operate);
        let master = segment.attach(master);
        segment.set_trace_length(usize::MAX);
        Self { segment, device, master, now: 0 }
    }

    /// Runs the segment.
    fn run(&mut self, milliseconds: u64) {
        self.now += milliseconds * u64::from(BAUD.bits_per_second()) / 1000;
        self.segment.run_until(BitTime(self.now)).unwrap();
    }

    /// Compares the trace and its notes with their goldens.
    fn golden(self, name: &str) {
        let trace: Trace = self.segment.trace().clone();
        let text = trace.to_string();
        golden(&format!("{name}.trace"), &text);
        golden(&format!("{name}.txt"), &notes_text(&text));
    }
}

/// The notes about a trace, one per line, with time and station.
fn notes_text(trace: &str) -> String {
    let capture = Capture::read(trace.as_bytes(), Baud::B9600).unwrap();
    let baud = capture.baud.unwrap();
    let (mut decoder, mut explained) = (Decoder::new(baud, capture.times), Vec::new());
    capture.chunks.iter().for_each(|chunk| decoder.push(chunk, &mut explained));
    decoder.end(&mut explained);
    let notes = explained.iter().flat_map(|piece| &piece.notes);
    let lines = notes.map(|note| {
        let seconds = note.at.unwrap().0 as f64 / f64::from(baud.bits_per_second());
        let station = note.station.map(|station| station.to_string()).unwrap_or_default();
        format!("{seconds:10.6} {station:>3}  {}\n", note.text)
    });
    lines.collect()
}

/// Compares with a golden, or writes it when `PROFIVAC_BLESS` is 1.
fn golden(name: &str, text: &str) {
    let path = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("tests/golden/notes").join(name);
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

/// Parameters with the default configuration and the first user parameters of the device.
fn fitting(model: &'static Model) -> SlaveParameters<'static> {
    let user_prm = model.user_prm.first().map_or(&[][..], |prm| prm.octets);
    SlaveParameters { user_prm, ..SlaveParameters::new(5, model.ident, model.default_configuration.octets) }
}

#[test]
fn the_notes_show_the_start_up_of_every_family_of_devices() {
    for device in ["bcg450", "bpg400", "pcg550", "tpg500", "img400"] {
        let mut test = TestSegment::new(device, &fitting(model(device)));
        test.run(15);
        test.golden(&format!("start-{device}"));
    }
}

#[test]
fn the_notes_show_both_configurations_when_a_slave_refuses_chk_cfg() {
    let bcg = model("bcg450");
    let mut test =
        TestSegment::new("bcg450", &SlaveParameters { cfg: &[0x44, 0x86, 0x05, 0x05, 0x0A, 0x08], ..fitting(bcg) });
    test.run(11);
    test.golden("refused-configuration");
}

#[test]
fn the_notes_show_the_reason_when_a_slave_refuses_set_prm() {
    let bcg = model("bcg450");
    let mut test = TestSegment::new("bcg450", &SlaveParameters { user_prm: &[0, 0, 0, 0x10, 0x01], ..fitting(bcg) });
    test.run(11);
    test.golden("refused-user-parameters");
}

#[test]
fn the_notes_show_the_silence_and_the_restart_of_a_slave_without_power() {
    let mut test = TestSegment::new("bcg450", &fitting(model("bcg450")));
    test.run(14);
    test.segment.station_mut(test.device).set_power(false);
    test.run(30);
    test.segment.station_mut(test.device).set_power(true);
    test.run(40);
    test.golden("power-cut");
}

#[test]
fn the_notes_show_the_pause_and_the_limit_when_a_watchdog_expires() {
    let parameters = SlaveParameters { watchdog: Some([2, 1]), ..fitting(model("bcg450")) };
    let mut test = TestSegment::new("bcg450", &parameters);
    test.run(14);
    test.segment.station_mut(test.master).user.set_mode(Mode::Stop);
    test.run(60);
    test.segment.station_mut(test.master).user.set_mode(Mode::Operate);
    test.run(12);
    test.golden("watchdog");
}

/// Reading a damaged file gives a capture or an error, never a panic.
#[test]
fn the_decoder_never_panics_on_a_damaged_file() {
    let folder = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("tests/golden/notes");
    let text = fs::read(folder.join("power-cut.trace")).unwrap();
    let trace: Trace = std::str::from_utf8(&text).unwrap().parse().unwrap();
    let lines: Vec<u8> =
        trace.entries.iter().flat_map(|entry| format!("{:02X?}\n", entry.octets).into_bytes()).collect();
    let octets: Vec<u8> = trace.entries.iter().flat_map(|entry| entry.octets.to_vec()).collect();
    let pcapng = profivac_sim::trace::pcapng::write(&trace, profivac_sim::trace::pcapng::USER0);
    let mut random = profivac_sim::Random::new(3);
    let mut count = 0;
    for round in 0..100 {
        let mut file = [&text, &lines, &octets, &pcapng][round % 4].clone();
        for _ in 0..1 + random.below(200) {
            let place = random.below(file.len() as u64) as usize;
            match random.below(3) {
                0 => file[place] = random.octet(),
                1 => file[place] ^= 1 << random.below(8),
                _ => drop(file.remove(place)),
            }
        }
        if let Ok(capture) = Capture::read(&file, Baud::B19200) {
            let (mut decoder, mut explained) = (Decoder::new(Baud::B19200, capture.times), Vec::new());
            capture.chunks.iter().for_each(|chunk| decoder.push(chunk, &mut explained));
            decoder.end(&mut explained);
            count += explained.len();
        }
    }
    assert!(count > 5_000, "{count}");
}

/// The sentences about a log.
fn sentences(log: &str) -> Vec<String> {
    let capture = Capture::read(log.as_bytes(), BAUD).unwrap();
    let (mut decoder, mut explained) = (Decoder::new(BAUD, capture.times), Vec::new());
    capture.chunks.iter().for_each(|chunk| decoder.push(chunk, &mut explained));
    decoder.end(&mut explained);
    explained.into_iter().flat_map(|piece| piece.notes).map(|note| note.text).collect()
}

/// A request of `master` to the slave at address 5, as SD2 with access points.
fn request(master: u8, sap: u8, fc: u8, du: &[u8]) -> String {
    frame(5, master, sap, 62, fc, du)
}

/// An answer of the slave at address 5, as SD2 with access points.
fn answer(master: u8, sap: u8, du: &[u8]) -> String {
    frame(master, 5, 62, sap, 0x08, du)
}

fn frame(da: u8, sa: u8, dsap: u8, ssap: u8, fc: u8, du: &[u8]) -> String {
    let frame = profivac_wire::DataTelegram { da, sa, dsap: Some(dsap), ssap: Some(ssap), fc, du };
    let mut out = [0; profivac_wire::MAX_TELEGRAM];
    let length = profivac_wire::Telegram::Data(frame).emit(&mut out).unwrap();
    format!("{}\n", profivac_sim::describe::Hex(&out[..length]))
}

#[test]
fn the_notes_show_a_new_owner_and_a_master_that_is_refused() {
    let diag = |fc, status: u8, owner| request(3, 60, fc, &[]) + &answer(3, 60, &[status, 0x0C, 0, owner, 0x08, 0xE6]);
    let log = [
        diag(0x6D, 0, 2),
        diag(0x5D, 0, 3),
        request(3, 61, 0x7D, &[0x88, 10, 10, 11, 0x08, 0xE6, 0]) + &frame(3, 5, 62, 61, 0x03, &[0]),
    ];
    assert_eq!(
        sentences(&log.concat()),
        [
            "is present: bcg450 (ident 08E6), belongs to master 2, exchanges data",
            "belongs to master 3 now, before it belonged to master 2",
            "does not take Set_Prm of master 3: RS: this service is not open to this master",
        ]
    );
}

#[test]
fn without_times_the_notes_show_both_reasons_for_lost_parameters() {
    let start = request(2, 61, 0x5D, &[0x88, 1, 10, 11, 0x08, 0xE6, 0, 0, 0, 0, 5, 0x1C]) + "E5\n";
    let diag = |fc, second: u8, owner, first: u8| {
        request(2, 60, fc, &[]) + &answer(2, 60, &[first, second, 0, owner, 0x08, 0xE6])
    };
    let texts = sentences(&[start, diag(0x7D, 0x0C, 2, 0), diag(0x5D, 0x05, 0xFF, 2)].concat());
    assert_eq!(texts[2], "has lost its parameters: its watchdog of 100 ms has expired, or it was restarted");
    assert_eq!(texts[3], "has no owner any more, before it belonged to master 2");
}

#[test]
fn the_explainer_counts_repetitions_and_reports_a_silent_slave_once() {
    let first = request(2, 60, 0x5D, &[]);
    let reply = answer(2, 60, &[0, 0x0C, 0, 2, 0x08, 0xE6]);
    let log = first.clone() + &reply + &request(2, 60, 0x7D, &[]).repeat(4) + &first + &reply;
    let capture = Capture::read(log.as_bytes(), BAUD).unwrap();
    let (mut decoder, mut explained) = (Decoder::new(BAUD, capture.times), Vec::new());
    capture.chunks.iter().for_each(|chunk| decoder.push(chunk, &mut explained));
    let counters = decoder.explainer().counters(5);
    assert_eq!((counters.requests, counters.retries, counters.unanswered), (6, 3, 4));
    let texts = sentences(&log);
    assert_eq!(texts[1..], ["does not answer master 2 any more", "answers again after 4 unanswered requests"]);
}
