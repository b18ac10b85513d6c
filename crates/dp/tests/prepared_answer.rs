//! A slave that prepares its answers, and one that does not, behave the same: the same random telegrams, damaged ones included, changes of
//! the device and times give the same answers at the same times, the same states and the same calls of the device.
//! A failure names its seed.

use crate::rig;

use fastrand::Rng;
use profivac_dp::link::{Baud, BitTime, CHARACTER_TBIT, Received, Receiver, Station, T_SYN_TBIT};
use profivac_dp::slave::{Slave, SlaveState};
use profivac_wire::control::{Control, FrameCount, Function};
use profivac_wire::{BROADCAST, DataTelegram, Telegram};
use rig::{Answer, Gauge, INITIATE, MASTER, RS, Rig, SLAVE, emit, hex};

const SEEDS: u64 = 60;
const STEPS: usize = 3_000;

/// Another master, and another slave.
const STRANGER: u8 = 3;
const NEIGHBOUR: u8 = 9;

/// Two octets each way, or eight outputs, which some masters send as SD3.
const CONFIGURATIONS: [&str; 2] = ["11 21", "11 27"];

/// Requests other than Data_Exchange, with access point and data unit.
const SERVICES: [(u8, &[&str]); 13] = [
    (60, &["", "", "00"]),
    (
        61,
        &[
            "80 01 01 00 12 34 00 80 00 00",
            "88 01 01 00 12 34 00 80 00 00",
            "B8 02 01 14 12 34 01 84 00 00",
            "40 00 00 00 12 34 00",
            "00 00 00 20 12 34 00",
        ],
    ),
    (62, &["11 21", "11 27", "21"]),
    (59, &[""]),
    (56, &["", "00"]),
    (57, &["", "00"]),
    (55, &["09 12 34 00", "09 FF FF 00"]),
    (51, &["", "5E 01 10 04", "5F 01 10 02 AA BB", "5C 00 01 08"]),
    (50, &["", "5C 00 01 08"]),
    (49, &["", INITIATE, INITIATE]),
    (48, &["", "5E 00 10 04", "5F 01 10 01 AA", "48"]),
    (47, &["", "5E 00 10 04", "48"]),
    (10, &[""]),
];

/// Commands of Global_Control: Clear, Sync, Unsync, Freeze, Unfreeze, several at once, to all or a group.
const COMMANDS: [&str; 8] = ["00 00", "02 00", "20 00", "10 00", "08 00", "04 00", "2A 01", "3C 02"];

/// The octets of a request, and what is wrong with them on the line.
struct Sent {
    octets: Vec<u8>,
    /// A parity error in place of this octet.
    error_at: Option<usize>,
    /// A pause before this octet.
    pause_at: Option<usize>,
}

/// What a slave did with a request.
#[derive(Debug, PartialEq, Eq)]
struct Seen {
    answer: Option<(BitTime, Vec<u8>)>,
    damaged: u32,
    telegrams: usize,
}

/// A slave behind a receiver.
struct Side {
    receiver: Receiver,
    slave: Slave<Gauge>,
    /// How often inputs were collected between a request and its answer.
    collected: usize,
}

impl Side {
    fn new(gauge: Gauge) -> Self {
        Self { receiver: Receiver::new(BitTime(0)), slave: Slave::new(gauge, SLAVE, Baud::B1500000), collected: 0 }
    }

    /// Receives octets, the first of which begins at `now`.
    fn receive(&mut self, mut now: BitTime, sent: &Sent) -> Seen {
        let mut seen = Seen { answer: None, damaged: 0, telegrams: 0 };
        for (position, octet) in sent.octets.iter().enumerate() {
            now = now + CHARACTER_TBIT + if sent.pause_at == Some(position) { 3 * T_SYN_TBIT } else { 0 };
            if sent.error_at == Some(position) {
                self.receiver.character_error(now);
                continue;
            }
            let Received::Telegram(telegram) = self.receiver.octet(now, *octet) else { continue };
            seen.telegrams += 1;
            let collected = self.slave.device().collected;
            let answer = self.slave.telegram(now, &telegram);
            seen.answer = answer.map(|answer| (answer.not_before, answer.octets.to_vec()));
            self.collected += self.slave.device().collected - collected;
        }
        seen.damaged = self.receiver.damaged();
        seen
    }
}

/// The two slaves, and the master's memory.
struct Pair {
    prepared: Side,
    general: Side,
    /// Calls of the devices that are compared already.
    compared: usize,
    now: BitTime,
    fcb: bool,
    outputs: Vec<u8>,
    rng: Rng,
}

impl Pair {
    fn new(seed: u64) -> Self {
        let mut rng = Rng::with_seed(seed);
        let configurations = CONFIGURATIONS.map(hex).to_vec();
        let gauge = Gauge { echo: rng.bool(), configurations, ..Gauge::default() };
        let general = Gauge { keeps_inputs: false, ..gauge.clone() };
        let (prepared, general) = (Side::new(gauge), Side::new(general));
        Self { prepared, general, compared: 0, now: BitTime(0), fcb: false, outputs: vec![0; 2], rng }
    }

    fn both(&mut self, change: impl Fn(&mut Slave<Gauge>)) {
        change(&mut self.prepared.slave);
        change(&mut self.general.slave);
    }

    /// Both slaves receive the same, answer the same and are in the same state afterwards.
    fn send(&mut self, sent: &Sent) {
        let begins = self.now;
        let prepared = self.prepared.receive(begins, sent);
        let general = self.general.receive(begins, sent);
        assert_eq!(prepared, general, "at {begins}: {:02X?}", sent.octets);
        if general.telegrams > 0 {
            self.compare(&format!("at {begins} after {:02X?}", sent.octets));
        }
        let ends = general
            .answer
            .as_ref()
            .map_or(BitTime(0), |(not_before, octets)| *not_before + CHARACTER_TBIT * octets.len() as u64);
        let pauses = if sent.pause_at.is_some() { 3 * T_SYN_TBIT } else { 0 };
        self.now = ends.max(begins + CHARACTER_TBIT * sent.octets.len() as u64 + pauses);
        if general.answer.is_some() && self.rng.u8(..20) > 0 {
            let now = self.now;
            self.both(|slave| slave.sent(now));
        }
    }

    /// Everything that a program or a master can see of the slaves.
    fn compare(&mut self, when: &str) {
        let [prepared, general] = [&self.prepared.slave, &self.general.slave];
        assert_eq!(prepared.state(), general.state(), "{when}");
        assert_eq!(prepared.address(), general.address(), "{when}");
        assert_eq!(prepared.min_tsdr_tbit(), general.min_tsdr_tbit(), "{when}");
        assert_eq!(prepared.wake_at(), general.wake_at(), "{when}");
        let [prepared, general] = [prepared.device(), general.device()];
        assert_eq!(prepared.inputs, general.inputs, "{when}");
        assert_eq!(prepared.seen.get(self.compared..), general.seen.get(self.compared..), "{when}");
        self.compared = general.seen.len();
    }

    fn request(&mut self, frame: DataTelegram<'_>) {
        let mut octets = match (frame.dsap, frame.du) {
            (None, &[a, b, c, d, e, f, g, h]) if self.rng.bool() => {
                let body = [frame.da, frame.sa, frame.fc, a, b, c, d, e, f, g, h];
                let sum = body.iter().fold(0_u8, |sum, octet| sum.wrapping_add(*octet));
                [&[0xA2][..], &body, &[sum, 0x16]].concat()
            }
            _ => emit(&Telegram::Data(frame)),
        };
        let position = self.rng.usize(..octets.len());
        let (mut error_at, mut pause_at) = (None, None);
        match self.rng.u8(..100) {
            0 => octets[position] ^= 1 << self.rng.u8(..8),
            1 => drop(octets.remove(position)),
            2 => octets.insert(position, self.rng.u8(..)),
            3 => octets.truncate(position),
            4 => error_at = Some(position),
            5 => pause_at = Some(position.max(1)),
            _ => {}
        }
        self.send(&Sent { octets, error_at, pause_at });
    }

    /// A request that the slave counts, with the next FCB of the owner, sometimes a repetition or another frame count.
    fn counted(&mut self, sa: u8, dsap: Option<u8>, ssap: Option<u8>, du: &[u8]) {
        let count = match self.rng.u8(..30) {
            0 => FrameCount::First,
            1 => FrameCount::Uncounted,
            2 | 3 => FrameCount::Counted(self.fcb),
            _ => FrameCount::Counted(!self.fcb),
        };
        match count {
            FrameCount::First => self.fcb = true,
            FrameCount::Counted(fcb) => self.fcb = fcb,
            FrameCount::Uncounted => {}
        }
        let function = if self.rng.u8(..15) == 0 { Function::SrdLow } else { Function::SrdHigh };
        let fc = Control::Request { function, count }.to_octet();
        let da = self.prepared.slave.address();
        self.request(DataTelegram { da, sa, dsap, ssap, fc, du });
    }

    fn exchange(&mut self) {
        if let SlaveState::DataExch(_, exchange) = self.general.slave.state() {
            self.outputs.resize(usize::from(exchange.lengths.outputs), 0);
        }
        if self.rng.u8(..3) == 0 {
            self.outputs.iter_mut().for_each(|octet| *octet = self.rng.u8(..));
        }
        let mut outputs = self.outputs.clone();
        match self.rng.u8(..60) {
            0 => outputs.push(1),
            1 => drop(outputs.pop()),
            2 => outputs.clear(),
            _ => {}
        }
        let sa = if self.rng.u8(..40) == 0 { STRANGER } else { MASTER };
        let ssap = if self.rng.u8(..60) == 0 { Some(62) } else { None };
        self.counted(sa, None, ssap, &outputs);
    }

    fn service(&mut self) {
        let (sap, units) = SERVICES[self.rng.usize(..SERVICES.len())];
        let du = hex(units[self.rng.usize(..units.len())]);
        let sa = if sap <= 50 || self.rng.u8(..8) == 0 { STRANGER } else { MASTER };
        self.counted(sa, Some(sap), Some(if sap <= 50 { 50 } else { 62 }), &du);
    }

    /// Something that is no request for an answer of this station: a token, an answer of a neighbour, a request to it, Global_Control.
    fn other_telegram(&mut self) {
        let fc = Control::Request { function: Function::SdnHigh, count: FrameCount::Uncounted }.to_octet();
        let command = hex(COMMANDS[self.rng.usize(..COMMANDS.len())]);
        let telegram = match self.rng.u8(..8) {
            0 => Telegram::Token { da: MASTER, sa: MASTER },
            1 => Telegram::ShortAck,
            2 => Telegram::Data(DataTelegram {
                da: NEIGHBOUR,
                sa: MASTER,
                dsap: None,
                ssap: None,
                fc: 0x5D,
                du: &[1, 2],
            }),
            3 => Telegram::Data(DataTelegram { da: MASTER, sa: NEIGHBOUR, dsap: None, ssap: None, fc: 8, du: &[1, 2] }),
            4 => Telegram::Data(DataTelegram::short(SLAVE, MASTER, Control::from_octet(0x49))),
            to => Telegram::Data(DataTelegram {
                da: if to == 5 { SLAVE } else { BROADCAST },
                sa: MASTER,
                dsap: Some(58),
                ssap: Some(62),
                fc,
                du: &command,
            }),
        };
        self.send(&Sent { octets: emit(&telegram), error_at: None, pause_at: None });
    }

    /// The device changes between two cycles.
    fn change(&mut self) {
        let (what, value) = (self.rng.u8(..5), self.rng.u8(..));
        self.both(|slave| {
            let gauge = slave.device_mut();
            match what {
                0 | 1 if gauge.echo => {}
                0 | 1 => gauge.inputs = vec![value, !value],
                2 => gauge.static_diag = value < 60,
                3 => gauge.event = value > 128,
                _ => gauge.blocks = vec![2, value],
            }
            gauge.changed |= what > 2;
        });
    }

    /// Something that happens to the slave without a telegram.
    fn interfere(&mut self) {
        match self.rng.u8(..40) {
            0 => self.both(|slave| slave.power_up(SLAVE)),
            1 => self.both(|slave| slave.rate_found(Baud::B1500000)),
            2 => self.both(Slave::return_to_wait_prm),
            3..10 => self.both(Slave::forget_answer),
            _ => {
                let now = self.now;
                self.both(|slave| assert_eq!(slave.poll(now), None));
                self.compare("after a poll");
            }
        }
    }

    fn start(&mut self) {
        let cfg = hex(CONFIGURATIONS[self.rng.usize(..CONFIGURATIONS.len())]);
        let watchdog = ["80 01 01", "88 01 01", "88 01 02"][self.rng.usize(..3)];
        let group = self.rng.u8(..3);
        self.counted(MASTER, Some(61), Some(62), &hex(&format!("{watchdog} 00 12 34 0{group} 80 00 00")));
        self.counted(MASTER, Some(62), Some(62), &cfg);
        if self.rng.bool() {
            self.counted(MASTER, Some(60), Some(62), &[]);
        }
    }

    fn step(&mut self) {
        let idle_tbit = match self.rng.u16(..400) {
            // Longer than the watchdog, longer than a connection lasts.
            0 => self.rng.u64(10_000..40_000),
            1 => self.rng.u64(1_000_000..5_000_000),
            2..5 => self.rng.u64(..33),
            _ => self.rng.u64(33..300),
        };
        self.now = self.now + idle_tbit;
        // A clock that is corrected goes back.
        if self.rng.u16(..400) == 0 {
            self.now = BitTime(self.now.0.saturating_sub(self.rng.u64(..50_000)));
        }
        if !self.general.slave.state().is_exchanging() && self.rng.bool() {
            return self.start();
        }
        match self.rng.u8(..40) {
            0 | 1 => self.service(),
            2 | 3 => self.other_telegram(),
            4..8 => self.change(),
            8 => self.interfere(),
            _ => self.exchange(),
        }
    }
}

#[test]
fn a_slave_with_prepared_answers_answers_and_remembers_as_one_without() {
    let (mut released, mut collected) = (0, 0);
    for seed in 0..SEEDS {
        println!("seed {seed}");
        let mut pair = Pair::new(seed);
        for _ in 0..STEPS {
            pair.step();
        }
        released += pair.general.collected - pair.prepared.collected;
        collected += pair.general.collected;
    }
    println!("{released} of {collected}");
    assert!(released * 3 > collected, "{released} of {collected} answers were prepared: too few to prove something");
}

/// The slave in data exchange with a watchdog of 10 ms, after an exchange.
fn watched() -> Rig {
    let mut rig = Rig::new(Gauge::default());
    assert_eq!(rig.ms0(MASTER, 61, &hex("88 01 01 00 12 34 00 80 00 00")), Answer::Ack);
    assert_eq!(rig.ms0(MASTER, 62, &hex("11 21")), Answer::Ack);
    assert_eq!(rig.dx(MASTER, &[5, 6]), Answer::Low(vec![1, 2]));
    rig
}

#[test]
fn the_expected_request_is_answered_with_inputs_that_were_collected_before() {
    let mut rig = watched();
    let collected = rig.slave.device().collected;
    assert_eq!(rig.dx(MASTER, &[7, 8]), Answer::Low(vec![1, 2]));
    // Once, for the next answer.
    assert_eq!(rig.slave.device().collected, collected + 1);
    assert_eq!(rig.slave.device().seen.last(), Some(&rig::Seen::Outputs(vec![7, 8])));
}

#[test]
fn a_prepared_answer_ends_with_a_timer_even_if_the_clock_goes_back_afterwards() {
    let expire_by_poll = |slave: &mut Slave<Gauge>, late| assert_eq!(slave.poll(late), None);
    let expire_by_token = |slave: &mut Slave<Gauge>, late| {
        assert_eq!(slave.telegram(late, &Telegram::Token { da: MASTER, sa: MASTER }), None);
    };
    for expire in [expire_by_poll as fn(&mut Slave<Gauge>, BitTime), expire_by_token] {
        let mut rig = watched();
        let late = rig.now + 100_000;
        expire(&mut rig.slave, late);
        assert!(!rig.slave.state().is_exchanging());
        assert_eq!(rig.dx(MASTER, &[5, 6]), RS);
    }
}
