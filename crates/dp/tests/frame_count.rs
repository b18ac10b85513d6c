//! Repetitions: one frame count memory per station for all services. profibus-wire 1.9 and 9.2.

use crate::rig;

use fastrand::Rng;
use profivac_wire::control::{Control, FrameCount, Function};
use profivac_wire::{DataTelegram, Telegram};
use rig::{Answer, Gauge, MASTER, Rig, SLAVE, Seen, emit, hex, low, text};

const FIRST: FrameCount = FrameCount::First;
const UNCOUNTED: FrameCount = FrameCount::Uncounted;
const ZERO: FrameCount = FrameCount::Counted(false);
const ONE: FrameCount = FrameCount::Counted(true);

/// A slave in data exchange with master 2; the test sets every frame count bit.
struct Counted {
    rig: Rig,
}

impl Counted {
    /// The last request counted `ONE`.
    fn new() -> Self {
        let mut counted = Self { rig: Rig::exchanging(Gauge::default()) };
        counted.dx(MASTER, FIRST, &[0, 0]);
        counted.rig.device().seen.clear();
        counted
    }

    fn srd(&mut self, sa: u8, count: FrameCount, sap: Option<u8>, du: &[u8]) -> String {
        let fc = Control::Request { function: Function::SrdHigh, count }.to_octet();
        let ssap = sap.map(|_| 62);
        let data = DataTelegram { da: SLAVE, sa, dsap: sap, ssap, fc, du };
        self.rig.raw(&emit(&Telegram::Data(data))).map(|answer| text(&answer)).unwrap_or_default()
    }

    fn dx(&mut self, sa: u8, count: FrameCount, outputs: &[u8]) -> String {
        self.srd(sa, count, None, outputs)
    }

    /// The number of times that outputs reached the process.
    fn executed(&mut self) -> usize {
        self.rig.device().seen.iter().filter(|seen| matches!(seen, Seen::Outputs(_))).count()
    }
}

#[test]
fn a_repetition_gets_the_same_answer_and_is_not_executed() {
    let mut slave = Counted::new();
    let answer = slave.dx(MASTER, ZERO, &[5, 6]);
    slave.rig.device().inputs = vec![9, 9];
    assert_eq!(slave.dx(MASTER, ZERO, &[5, 6]), answer);
    assert_eq!(slave.dx(MASTER, ZERO, &[7, 8]), answer, "regardless of its data");
    assert_eq!(slave.executed(), 1);
    assert_ne!(slave.dx(MASTER, ONE, &[5, 6]), answer);
    assert_eq!(slave.executed(), 2);
}

#[test]
fn a_repeated_first_request_is_executed_twice() {
    let mut slave = Counted::new();
    slave.dx(MASTER, FIRST, &[5, 6]);
    slave.dx(MASTER, FIRST, &[5, 6]);
    assert_eq!(slave.executed(), 2);
    slave.dx(MASTER, ONE, &[5, 6]);
    assert_eq!(slave.executed(), 2, "the first counts as one");
    slave.dx(MASTER, ZERO, &[5, 6]);
    assert_eq!(slave.executed(), 3);
}

/// SC, RS, RR and data are repeated alike.
#[test]
fn every_kind_of_answer_is_repeated() {
    for (sap, du, answer) in [
        (61, "00 00 00 00 12 34 00", "E5"),
        (52, "", "10 02 08 03 0D 16"),
        (60, "00", "10 02 08 02 0C 16"),
        (59, "", "68 07 07 68 82 88 08 3E 3B 11 21 BD 16"),
    ] {
        let mut slave = Counted::new();
        assert_eq!(slave.srd(MASTER, ZERO, Some(sap), &hex(du)), answer);
        assert_eq!(slave.srd(MASTER, ZERO, None, &[5, 6]), answer, "the answer held, not a new one");
    }
}

#[test]
fn another_requester_is_new_with_any_count() {
    for count in [ZERO, ONE] {
        let mut slave = Counted::new();
        slave.dx(MASTER, count, &[5, 6]);
        let diagnosis = slave.srd(3, count, Some(60), &[]);
        assert!(diagnosis.starts_with("68 0B"), "{diagnosis}");
        slave.rig.device().seen.clear();
        slave.dx(MASTER, count, &[5, 6]);
        assert_eq!(slave.executed(), 1, "the first requester is new again");
    }
}

/// The ET200S of profibus-wire 1.9: the same count on the same access point after others is new.
#[test]
fn the_memory_is_not_kept_per_access_point() {
    let mut slave = Counted::new();
    let before = slave.srd(MASTER, ZERO, Some(60), &[]);
    slave.srd(MASTER, ONE, Some(59), &[]);
    slave.rig.device().static_diag = true;
    assert_ne!(slave.srd(MASTER, ZERO, Some(60), &[]), before);
}

#[test]
fn uncounted_telegrams_do_not_disturb() {
    let mut slave = Counted::new();
    let answer = slave.dx(MASTER, ZERO, &[5, 6]);
    for octets in [
        "10 08 02 49 53 16",
        "10 08 03 49 54 16",
        "10 08 02 4E 58 16",
        "10 08 02 4F 59 16",
        "68 07 07 68 FF 82 46 3A 3E 00 00 3F 16",
        "68 07 07 68 88 82 46 3A 3E 00 00 C8 16",
        // to another station, a token, a response, SC
        "10 09 02 49 54 16",
        "68 05 05 68 09 02 7D AA 55 87 16",
        "DC 02 02",
        "10 02 09 00 0B 16",
        "E5",
    ] {
        slave.rig.raw(&hex(octets));
        assert_eq!(slave.dx(MASTER, ZERO, &[5, 6]), answer, "{octets}");
    }
    assert_eq!(slave.executed(), 1);
}

#[test]
fn an_uncounted_request_is_always_new() {
    let mut slave = Counted::new();
    let answer = slave.dx(MASTER, ZERO, &[5, 6]);
    assert!(slave.srd(MASTER, UNCOUNTED, Some(60), &[]).starts_with("68 0B"));
    assert!(slave.srd(MASTER, UNCOUNTED, Some(60), &[]).starts_with("68 0B"));
    assert_eq!(slave.dx(MASTER, ZERO, &[5, 6]), answer, "and the memory stays");
    assert_eq!(slave.executed(), 1);
}

#[test]
fn without_a_held_answer_nothing_is_a_repetition() {
    let mut slave = Counted::new();
    slave.dx(MASTER, ZERO, &[5, 6]);
    slave.rig.slave.forget_answer();
    slave.dx(MASTER, ZERO, &[5, 6]);
    assert_eq!(slave.executed(), 2);
}

/// True once in `n` calls on average.
fn once_in(random: &mut Rng, n: u32) -> bool {
    random.u32(..n) == 0
}

/// The next step of a master after a request and its repetition were lost.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum AfterLoss {
    /// With a first request, as profibus-wire 1.10 asks for.
    BeginAnew,
    /// With the same count and another service: a known fault of a master in wide use.
    KeepCount,
}

/// What the slave does with its stored answer while other stations communicate.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Held {
    Kept,
    Dropped,
}

/// A master with one frame count bit that accepts any answer, on a line that loses telegrams both ways.
struct MasterWithoutChecks {
    slave: Rig,
    random: Rng,
    count: FrameCount,
    after_loss: AfterLoss,
    held: Held,
    /// Access points of slave and master: MS1, or an MS2 connection.
    acyclic: (u8, u8),
    losses: u32,
}

impl MasterWithoutChecks {
    fn new(seed: u64, after_loss: AfterLoss, held: Held, acyclic: (u8, u8)) -> Self {
        let mut slave = Rig::exchanging(Gauge::default());
        assert_eq!(slave.connect(MASTER), MS2.0);
        Self { slave, random: Rng::with_seed(seed), count: FIRST, after_loss, held, acyclic, losses: 0 }
    }

    /// A request and its repetition. `None` if both were lost.
    fn request(&mut self, sap: Option<(u8, u8)>, du: &[u8]) -> Option<Vec<u8>> {
        let fc = Control::Request { function: Function::SrdLow, count: self.count }.to_octet();
        let (dsap, ssap) = sap.unzip();
        let octets = emit(&Telegram::Data(DataTelegram { da: SLAVE, sa: MASTER, dsap, ssap, fc, du }));
        for _ in 0..2 {
            if self.held == Held::Dropped && once_in(&mut self.random, 3) {
                self.slave.slave.forget_answer();
            }
            if once_in(&mut self.random, 5) {
                continue;
            }
            let answer = self.slave.raw(&octets);
            if !once_in(&mut self.random, 5) {
                self.count = if self.count == ZERO { ONE } else { ZERO };
                return answer;
            }
        }
        self.losses += 1;
        if self.after_loss == AfterLoss::BeginAnew {
            self.count = FIRST;
        }
        None
    }

    /// One exchange and one step of an acyclic read, repeated. Returns the number of reads that succeeded, or the first
    /// answer that belongs to the other service.
    fn run(&mut self, rounds: usize) -> Result<usize, String> {
        let mut reads = 0;
        let mut is_requested = false;
        let response = DataTelegram {
            da: MASTER,
            sa: SLAVE,
            dsap: Some(self.acyclic.1),
            ssap: Some(self.acyclic.0),
            fc: 0x08,
            du: &hex("5E 01 10 04 11 22 33 44"),
        };
        let response = text(&emit(&Telegram::Data(response)));
        for _ in 0..rounds {
            if let Some(answer) = self.request(None, &[5, 6])
                && text(&answer) != "68 05 05 68 02 08 08 01 02 15 16"
            {
                return Err(format!("to Data_Exchange came {}", text(&answer)));
            }
            let pdu = if is_requested { Vec::new() } else { hex("5E 01 10 04") };
            let Some(answer) = self.request(Some(self.acyclic), &pdu) else { continue };
            match text(&answer).as_str() {
                // The response was received, or there was none: the read starts again if the response was lost.
                "E5" => is_requested = !is_requested,
                "10 02 08 02 0C 16" => is_requested = true,
                read if read == response => {
                    is_requested = false;
                    reads += 1;
                }
                other => return Err(format!("to the read came {other}")),
            }
        }
        Ok(reads)
    }
}

const SEEDS: std::ops::Range<u64> = 1..21;
const MS1: (u8, u8) = (51, 51);
const MS2: (u8, u8) = (48, 50);

#[test]
fn cyclic_and_acyclic_octets_never_mix_whether_the_slave_keeps_its_answer_or_not() {
    for (held, acyclic) in [(Held::Kept, MS1), (Held::Dropped, MS1), (Held::Kept, MS2), (Held::Dropped, MS2)] {
        for seed in SEEDS {
            let case = format!("seed {seed}, answer {held:?}, access point {}", acyclic.0);
            let mut master = MasterWithoutChecks::new(seed, AfterLoss::BeginAnew, held, acyclic);
            let reads = master.run(500).unwrap_or_else(|mixed| panic!("{case}: {mixed}"));
            assert!(reads > 100 && master.losses > 50, "{case}: {reads} reads, {} losses", master.losses);
        }
    }
}

/// The same test finds the fault of a master that does not start with a first contact.
#[test]
fn a_master_that_keeps_its_count_confuses_the_answers_as_the_standard_warns() {
    for seed in SEEDS {
        let mixed = MasterWithoutChecks::new(seed, AfterLoss::KeepCount, Held::Kept, MS2).run(500);
        assert!(mixed.is_err(), "seed {seed}: {mixed:?}");
    }
}

#[test]
fn a_write_is_executed_once_however_often_its_acknowledgement_is_lost() {
    let mut rig = Rig::exchanging(Gauge::default());
    let sap = rig.connect(3);
    assert_eq!(rig.ms2(3, sap, "5F 01 10 01 AA"), Answer::Ack);
    for _ in 0..5 {
        assert_eq!(rig.again(), "E5");
    }
    let writes = rig.device().seen.iter().filter(|seen| matches!(seen, Seen::Write(..))).count();
    assert_eq!(writes, 1);
    assert_eq!(rig.ms2(3, sap, ""), low("5F 01 10 01"));
}
