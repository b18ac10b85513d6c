//! Start-ups and their failures on the simulated segment. The folder `tests/golden/notes` has a trace and the notes about it for
//! each.

#![allow(clippy::unwrap_used, clippy::panic, reason = "a test")]

use crate::decoded::decoded;
use crate::golden;
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
        let mut master = Master::on(BusParameters::new(OWN, BAUD).check().unwrap(), Settings::new(BAUD), BitTime(0));
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
        note_golden(&format!("{name}.trace"), &text);
        note_golden(&format!("{name}.txt"), &notes_text(&text));
    }
}

/// The notes about a trace, one per line, with time and station.
fn notes_text(trace: &str) -> String {
    let capture = Capture::read(trace.as_bytes(), Baud::B9600).unwrap();
    let baud = capture.baud.unwrap();
    let (_, explained) = decoded(&capture, baud);
    let notes = explained.iter().flat_map(|piece| &piece.notes);
    let lines = notes.map(|note| {
        let seconds = note.at.unwrap().0 as f64 / f64::from(baud.bits_per_second());
        let station = note.station.map(|station| station.to_string()).unwrap_or_default();
        format!("{seconds:10.6} {station:>3}  {}\n", note.text)
    });
    lines.collect()
}

/// Compares with a golden.
fn note_golden(name: &str, text: &str) {
    golden::compare(&format!("crates/explain/tests/golden/notes/{name}"), text);
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
fn the_reason_of_a_refused_set_prm_names_the_bits_that_differ() {
    let bcg = model("bcg450");
    for (user, end) in [
        (&[0x04_u8, 0, 0, 0x05, 0x1C], "sent 04 00 00 05 1C: it takes no WD_BASE_1MS (04) in DPV1_Status_1"),
        (&[0xC8, 0x01, 0, 0x05, 0x1C], "sent C8 01 00 05 1C: it takes no bits 08 in DPV1_Status_1"),
        (
            &[0xC0, 0x21, 0x08, 0x05, 0x1C],
            "sent C0 21 08 05 1C: it takes no DIAGNOSTIC_ALARM (20) in DPV1_Status_2, no PRM_STRUCTURE (08) in DPV1_Status_3",
        ),
        // The unit alone is wrong.
        (&[0xC0, 0x01, 0, 0x13, 0x08], "sent C0 01 00 13 08"),
    ] {
        let mut test = TestSegment::new("bcg450", &SlaveParameters { user_prm: user, ..fitting(bcg) });
        test.run(11);
        let notes = notes_text(&test.segment.trace().to_string());
        let refused = notes.lines().find(|line| line.contains("Set_Prm refused")).unwrap();
        assert!(refused.ends_with(end), "{refused}");
    }
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
            let index = random.below(file.len() as u64) as usize;
            match random.below(3) {
                0 => file[index] = random.octet(),
                1 => file[index] ^= 1 << random.below(8),
                _ => drop(file.remove(index)),
            }
        }
        if let Ok(capture) = Capture::read(&file, Baud::B19200) {
            let (_, explained) = decoded(&capture, Baud::B19200);
            count += explained.len();
        }
    }
    assert!(count > 5_000, "{count}");
}

/// The sentences about a log.
fn sentences(log: &str) -> Vec<String> {
    let (_, explained) = decoded(&Capture::read(log.as_bytes(), BAUD).unwrap(), BAUD);
    explained.into_iter().flat_map(|piece| piece.notes).map(|note| note.text).collect()
}

/// A request of `master` to the slave at address 5, as SD2 with access points.
fn request(master: u8, sap: u8, fc: u8, du: &[u8]) -> String {
    telegram(5, master, sap, 62, fc, du)
}

/// An answer of the slave at address 5, as SD2 with access points.
fn answer(master: u8, sap: u8, du: &[u8]) -> String {
    telegram(master, 5, 62, sap, 0x08, du)
}

fn telegram(da: u8, sa: u8, dsap: u8, ssap: u8, fc: u8, du: &[u8]) -> String {
    let data = profivac_wire::DataTelegram { da, sa, dsap: Some(dsap), ssap: Some(ssap), fc, du };
    let mut out = [0; profivac_wire::MAX_TELEGRAM];
    let length = profivac_wire::Telegram::Data(data).emit(&mut out).unwrap();
    format!("{}\n", profivac_sim::describe::Hex(&out[..length]))
}

#[test]
fn the_notes_show_a_new_owner_and_a_master_that_is_refused() {
    let diag = |fc, status: u8, owner| request(3, 60, fc, &[]) + &answer(3, 60, &[status, 0x0C, 0, owner, 0x08, 0xE6]);
    let log = [
        diag(0x6D, 0, 2),
        diag(0x5D, 0, 3),
        request(3, 61, 0x7D, &[0x88, 10, 10, 11, 0x08, 0xE6, 0]) + &telegram(3, 5, 62, 61, 0x03, &[0]),
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
    let (decoder, _) = decoded(&capture, BAUD);
    let counters = decoder.explainer().counters(5);
    assert_eq!((counters.requests, counters.repetitions, counters.unanswered), (6, 3, 4));
    let texts = sentences(&log);
    let expected = [
        "master 2 repeats Slave_Diag: no answer came",
        "does not answer master 2 any more",
        "answers again after 4 unanswered requests",
    ];
    assert_eq!(texts[1..], expected);
}

/// An answer of the slave at address 5 without data, as SD1.
fn bare(master: u8, status: u8) -> String {
    let data = profivac_wire::DataTelegram { da: master, sa: 5, dsap: None, ssap: None, fc: status, du: &[] };
    let mut out = [0; profivac_wire::MAX_TELEGRAM];
    let length = profivac_wire::Telegram::Data(data).emit(&mut out).unwrap();
    format!("{}\n", profivac_sim::describe::Hex(&out[..length]))
}

#[test]
fn every_refusal_has_a_sentence_that_names_the_service() {
    let exchange = "68 05 05 68 05 02 5D AA 55 63 16\n";
    let log = [exchange.to_owned() + &bare(2, 0x02), request(2, 60, 0x5D, &[]) + &bare(2, 0x03)];
    let log = log.concat()
        + &request(2, 59, 0x7D, &[])
        + &bare(2, 0x01)
        // The same refusal again has no sentence; after an answer it has one.
        + &request(2, 59, 0x5D, &[])
        + &bare(2, 0x01)
        + &request(2, 59, 0x7D, &[])
        + &answer(2, 59, &[0x11])
        + &request(2, 59, 0x5D, &[])
        + &bare(2, 0x01)
        // Its request was lost.
        + &bare(2, 0x03);
    assert_eq!(
        sentences(&log),
        [
            "refuses to exchange data: RR: it has no resource for that now",
            "refuses Slave_Diag of master 2: RS: this service is not open to this master",
            "refuses Get_Cfg of master 2: UE: its application has failed",
            "has the configuration 11",
            "refuses Get_Cfg of master 2: UE: its application has failed",
            "refuses a request of master 2 that was not received: RS: this service is not open to this master",
        ]
    );
}

#[test]
fn sessions_that_were_open_before_have_a_sentence() {
    let idle = request(2, 48, 0x5D, &[0x48]) + "E5\n" + &request(2, 48, 0x7D, &[]) + &answer(2, 48, &[0x48]);
    let exchange = "68 04 04 68 05 02 5D AA 0E 16\n68 04 04 68 02 05 08 01 10 16\n";
    assert_eq!(
        sentences(&(idle.clone() + &idle + exchange)),
        [
            "has an MS2 connection on SAP 48 with master 2; its opening was not received",
            "exchanges data with master 2, 1 octet out, 1 in; its start-up was not received",
        ]
    );
}

#[test]
fn a_repetition_has_a_sentence_with_its_reason() {
    let first = request(2, 60, 0x5D, &[]);
    let reply = answer(2, 60, &[0, 0x0C, 0, 2, 0x08, 0xE6]);
    let mut damaged = reply.clone();
    damaged.replace_range(21..23, "FF");
    for (between, reason) in [
        ("", "no answer came"),
        (damaged.as_str(), "the answer is damaged"),
        (reply.as_str(), "its master did not receive the answer"),
    ] {
        let texts = sentences(&(first.clone() + between + &first + &reply));
        assert!(texts.contains(&format!("master 2 repeats Slave_Diag: {reason}")), "{texts:?}");
    }
}

/// Behind damaged octets that may be requests, an equal frame count bit shows no repetition.
#[test]
fn an_equal_frame_count_bit_behind_a_damaged_stretch_is_no_repetition() {
    let first = request(2, 60, 0x5D, &[]);
    let reply = answer(2, 60, &[0, 0x0C, 0, 2, 0x08, 0xE6]);
    let mut damaged = request(2, 60, 0x7D, &[]) + &reply;
    damaged.replace_range(15..17, "FF");
    damaged.replace_range(60..62, "FF");
    let log = first.clone() + &reply + &damaged + &first + &reply;
    let capture = Capture::read(log.as_bytes(), BAUD).unwrap();
    let (decoder, _) = decoded(&capture, BAUD);
    assert_eq!(decoder.explainer().summary().damaged, 1);
    assert_eq!(decoder.explainer().counters(5).repetitions, 0);
}

#[test]
fn a_station_that_only_answers_is_a_slave() {
    use profivac_explain::explainer::Role;
    let roles = |log: &str| {
        let capture = Capture::read(log.as_bytes(), BAUD).unwrap();
        let (decoder, _) = decoded(&capture, BAUD);
        decoder.explainer().summary().roles.clone().into_iter().collect::<Vec<_>>()
    };
    assert_eq!(roles("68 05 05 68 04 27 08 00 00 33 16"), [(0x27, Role::Slave)]);
    assert_eq!(roles("10 02 03 20 25 16"), [(3, Role::Master)]);
    assert_eq!(roles("68 05 05 68 04 27 08 00 00 33 16 DC 02 27"), [(0x27, Role::Master)]);
}

/// A line that is never silent: octets are reported half a second after they came at the latest, whatever they are.
#[test]
fn octets_on_a_live_line_are_reported_within_a_second() {
    use profivac_dp::link::BitTime;
    use profivac_explain::frame::{Chunk, TimeSource};
    let noise =
        [vec![0x10, 0, 0, 0, 0, 0], vec![0xA2; 1], vec![0xDC, 0, 0], vec![0x68], vec![0], vec![0x68, 249, 249, 0x68]];
    for (noise, baud) in noise.iter().flat_map(|noise| [(noise, Baud::B9600), (noise, Baud::B12000000)]) {
        // An octet every 40 ms: no pause ends a telegram.
        let second = u64::from(baud.bits_per_second());
        let (mut decoder, mut explained, mut reported) = (Decoder::new(baud, TimeSource::Platform), Vec::new(), 0);
        for (number, octet) in (0_u64..500).zip(noise.iter().cycle()) {
            let now = number * second / 25;
            let octets = vec![*octet];
            decoder.push(&Chunk { start: Some(BitTime(now)), octets, ..Chunk::default() }, &mut explained);
            reported += explained.drain(..).map(|explained| explained.piece.octets.len() as u64).sum::<u64>();
            assert!(reported + 25 > number, "{noise:02X?}: {reported} of {number}");
        }
    }
}

#[test]
fn a_diagnosis_without_modules_has_a_whole_sentence() {
    let diag =
        |fc, ext: &[u8]| request(2, 60, fc, &[]) + &answer(2, 60, &[&[8, 0x0C, 0, 2, 0x08, 0xE6][..], ext].concat());
    let texts = sentences(&(diag(0x6D, &[0x42, 0]) + &diag(0x5D, &[0x05, 0x82, 0, 0, 0])));
    assert_eq!(texts[1], "its diagnosis: Ext_Diag; disturbed modules: none");
    assert_eq!(texts[2], "its diagnosis: Ext_Diag; module status of slot 0: all valid");
}
