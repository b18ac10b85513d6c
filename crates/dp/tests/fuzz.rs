//! Octets and services at random. A failure names its seed; `PROFIVAC_FUZZ=100` makes the runs a hundred times as long.
//!
//! Any octets: nothing panics, the slave answers only requests to its address that have an answer, no answer is
//! early, every answer is a telegram, and afterwards the slave is as usable as before.

use crate::rig;

use fastrand::Rng;
use profivac_dp::link::{Baud, BitTime, CHARACTER_TBIT, Received, Receiver, Station};
use profivac_dp::slave::{Slave, SlaveState};
use profivac_wire::control::{Control, FrameCount, Function, Status};
use profivac_wire::{BROADCAST, DataTelegram, MAX_DU, Telegram};
use rig::{Gauge, INITIATE, SLAVE, emit, hex, text};

/// The factor for the length of the runs.
fn times() -> usize {
    std::env::var("PROFIVAC_FUZZ").ok().and_then(|times| times.parse().ok()).unwrap_or(1)
}

/// Valid data units by access point; `None` for Data_Exchange.
const MEANINGFUL: [(Option<u8>, &[&str]); 16] = [
    (None, &["05 06", "05 06", "05 06", "05", ""]),
    (Some(60), &["", "", "00"]),
    (
        Some(61),
        &[
            "80 01 01 00 12 34 00 80 00 00",
            "88 01 01 00 12 34 00 80 00 00",
            "88 FF FF 14 12 34 06 C0 00 00",
            "B8 05 0A 00 12 34 01 84 00 00",
            "40 00 00 00 12 34 00",
            "00 00 00 14 12 34 00",
            "80 01 01 00 12 35 00",
        ],
    ),
    (Some(62), &["11 21", "11 21", "11 21", "21"]),
    (Some(59), &["", "00"]),
    (Some(58), &["20 00", "08 00", "02 00", "30 00", "0C 01", "FF FF"]),
    (Some(56), &["", "00"]),
    (Some(57), &["", "00"]),
    (Some(55), &["08 12 34 00", "08 12 34 FF", "09 FF FF 00"]),
    (Some(53), &["05 81 00 00 00"]),
    (
        Some(51),
        &[
            "",
            "",
            "",
            "5E 01 10 04",
            "5E 00 10 F0",
            "5F 01 10 02 AA BB",
            "5F 00 FF 04 08 00 FD E8",
            "5E 00 FF 44",
            "5C 00 01 08",
        ],
    ),
    (Some(50), &["", "5C 00 01 08"]),
    (Some(49), &["", INITIATE, INITIATE, INITIATE, "57", "48"]),
    (
        Some(48),
        &[
            "",
            "",
            "",
            "5E 00 10 04",
            "5F 01 10 01 AA",
            "48",
            "51 00 00 01 00",
            "58 00 20",
            "5F 00 FF 04 08 00 FD E8",
            "5E 00 FF F0",
            "00",
        ],
    ),
    (Some(47), &["", "", "", "5E 00 10 04", "48", "58 00 20"]),
    (Some(10), &["", "48"]),
];

/// A valid or invalid request.
struct Request {
    data: DataTelegram<'static>,
    du: Vec<u8>,
}

impl Request {
    fn random(rng: &mut Rng) -> Self {
        let (dsap, units) = MEANINGFUL[rng.usize(..MEANINGFUL.len())];
        let mut du = hex(units[rng.usize(..units.len())]);
        if rng.u8(..10) == 0 {
            mutate(&mut du, rng);
        }
        let function = match rng.u8(..40) {
            0 => Function::FdlStatus,
            1 => Function::Ident,
            2 => Function::LsapStatus,
            3 => Function::SdaLow,
            _ if dsap == Some(58) => Function::SdnHigh,
            _ if rng.bool() => Function::SrdLow,
            _ => Function::SrdHigh,
        };
        let count = match rng.u8(..8) {
            0 => FrameCount::Uncounted,
            1 => FrameCount::First,
            even => FrameCount::Counted(even % 2 == 0),
        };
        let ssap = dsap.map(|dsap| if dsap <= 49 { 50 } else { *[62, 62, 51, 54].get(rng.usize(..4)).unwrap_or(&62) });
        let data = DataTelegram {
            da: [SLAVE, SLAVE, SLAVE, SLAVE, SLAVE, SLAVE, BROADCAST, 9][rng.usize(..8)],
            sa: [1, 2, 2, 2, 2, 3, SLAVE, BROADCAST][rng.usize(..8)],
            dsap,
            ssap,
            fc: Control::Request { function, count }.to_octet(),
            du: &[],
        };
        Self { data, du }
    }

    fn octets(&self) -> Vec<u8> {
        let du = &self.du[..self.du.len().min(MAX_DU)];
        emit(&Telegram::Data(DataTelegram { du, ..self.data }))
    }
}

/// A few octets altered, lost, doubled or added.
fn mutate(octets: &mut Vec<u8>, rng: &mut Rng) {
    for _ in 0..rng.usize(1..4) {
        let position = rng.usize(..=octets.len());
        match rng.u8(..5) {
            0 => octets.insert(position, rng.u8(..)),
            1 => octets.truncate(position),
            _ if position == octets.len() => octets.push(rng.u8(..)),
            2 => drop(octets.remove(position)),
            3 => octets[position] ^= 1 << rng.u8(..8),
            _ => octets[position] = rng.u8(..),
        }
    }
}

/// A slave on a line.
struct Line {
    receiver: Receiver,
    slave: Slave<Gauge>,
    now: BitTime,
    received: u64,
    answered: u64,
}

impl Line {
    fn new() -> Self {
        let (receiver, slave) = (Receiver::new(BitTime(0)), Slave::new(Gauge::default(), SLAVE, Baud::B1500000));
        Self { receiver, slave, now: BitTime(0), received: 0, answered: 0 }
    }

    fn passes(&mut self, tbit: u64) {
        self.now = self.now + tbit;
        assert_eq!(self.slave.poll(self.now), None, "a slave never speaks unasked");
        assert!(self.slave.wake_at().is_none_or(|wake| wake > self.now), "an expired timer does not expire again");
        self.device_agrees();
    }

    /// The state of the device agrees with that of the slave; outside data exchange its outputs are safe.
    fn device_agrees(&mut self) {
        let exchanging = matches!(self.slave.state(), SlaveState::DataExch(..));
        let device = self.slave.device_mut();
        assert_eq!(device.running, exchanging);
        assert!(device.running || !device.driven, "outputs without a master");
        device.seen.clear();
    }

    /// Characters without a gap. Returns the answers.
    fn receive(&mut self, octets: &[u8]) -> Vec<Vec<u8>> {
        let mut answers = Vec::new();
        for octet in octets {
            self.now = self.now + CHARACTER_TBIT;
            if let Received::Telegram(telegram) = self.receiver.octet(self.now, *octet) {
                self.received += 1;
                answers.extend(telegram_at(&mut self.slave, self.now, &telegram));
            }
        }
        self.answered += answers.len() as u64;
        self.now = self.now + CHARACTER_TBIT * answers.iter().map(|answer| answer.len() as u64).sum::<u64>();
        self.device_agrees();
        answers
    }
}

/// Whether a station at `address` must answer.
fn expects_answer(telegram: &Telegram<'_>, address: u8) -> bool {
    let Telegram::Data(data) = telegram else { return false };
    let Control::Request { function, .. } = data.control() else { return false };
    let answered = !matches!(function, Function::SdnLow | Function::SdnHigh | Function::Other(_));
    answered && data.da == address && data.sa != address && data.sa != BROADCAST
}

/// Sends one telegram and checks what holds for every answer.
fn telegram_at(slave: &mut Slave<Gauge>, end: BitTime, telegram: &Telegram<'_>) -> Option<Vec<u8>> {
    let (owed, earliest) = (expects_answer(telegram, slave.address()), end + u64::from(slave.min_tsdr_tbit()));
    let Some(transmit) = slave.telegram(end, telegram) else {
        assert!(!owed, "no answer to {telegram:?}");
        return None;
    };
    assert!(owed, "{telegram:?} was answered by {}", text(transmit.octets));
    assert_eq!(transmit.not_before, earliest, "{telegram:?}");
    let answer = Telegram::parse(transmit.octets);
    let fits = match (telegram, answer) {
        (_, Ok(Telegram::ShortAck)) => true,
        (Telegram::Data(request), Ok(Telegram::Data(answer))) => (answer.da, answer.fc & 0xF0) == (request.sa, 0),
        _ => false,
    };
    assert!(fits, "{telegram:?} was answered by {answer:?}");
    Some(transmit.octets.to_vec())
}

#[test]
fn a_slave_answers_the_requests_among_ten_million_octets_and_nothing_else() {
    let seed = 0x5EED_0001;
    println!("seed {seed:#X}");
    let mut rng = Rng::with_seed(seed);
    let mut line = Line::new();
    let mut octets = 0;
    while octets < 10_000_000 * times() {
        let mut stream = match rng.u8(..8) {
            0 => random(&mut rng),
            // A start delimiter first, because the receiver ignores other first octets.
            1 => [&[[0x10, 0x68, 0xA2, 0xDC, 0xE5][rng.usize(..5)]], &*random(&mut rng)].concat(),
            _ => Request::random(&mut rng).octets(),
        };
        if rng.bool() {
            mutate(&mut stream, &mut rng);
        }
        octets += stream.len();
        let idle = [0, 20, 33, 33, 33, 40, 1000, 100_000][rng.usize(..8)];
        line.passes(idle);
        if rng.u8(..20) == 0 {
            line.receiver.character_error(line.now);
        }
        let answers = line.receive(&stream);
        // The driver may receive its own telegram.
        if rng.u8(..4) == 0 {
            let echoes: Vec<_> = answers.iter().flat_map(|answer| line.receive(answer)).collect();
            assert!(echoes.is_empty(), "an answer was answered");
        }
        rename(&mut line);
    }
    let (received, answered) = (line.received, line.answered);
    println!("{octets} octets, {received} telegrams, {answered} answers");
    assert!(received > 200_000 && answered > 80_000, "{received} telegrams, {answered} answers");
}

fn random(rng: &mut Rng) -> Vec<u8> {
    (0..rng.usize(..40)).map(|_| rng.u8(..)).collect()
}

/// A mutated Set_Slave_Add may have moved the slave, or locked its address.
fn rename(line: &mut Line) {
    line.slave.device_mut().no_add_chg = false;
    if line.slave.address() != SLAVE {
        line.slave.power_up(SLAVE);
    }
}

/// The answers that the state allows, by the reply matrix alone: profibus-wire 2.2.
fn is_allowed(before: &SlaveState, data: &DataTelegram<'_>, answer: &Answer) -> bool {
    let owns = before.owner().is_some_and(|owner| owner.master == data.sa);
    let exchanging = matches!(before, SlaveState::DataExch(..));
    let dpv1 = before.owner().is_some_and(|owner| owner.dpv1);
    let open = match data.dsap {
        None => exchanging && owns,
        Some(51) => exchanging && owns && dpv1,
        Some(55) => matches!(before, SlaveState::WaitPrm(_)),
        Some(56 | 57) => exchanging,
        // No alarms, no DP-V2, no SDN service as SRD.
        Some(50 | 53 | 58) => false,
        Some(59..=62) => true,
        // MS2 is open to its peer in every state.
        Some(_) => return true,
    };
    open != (*answer == Answer::Closed)
}

#[derive(PartialEq, Eq)]
enum Answer {
    Closed,
    Other,
}

fn classify(octets: &[u8]) -> Answer {
    match Telegram::parse(octets) {
        Ok(Telegram::Data(data)) if data.control() == Control::slave(Status::ServiceNotActivated) => Answer::Closed,
        _ => Answer::Other,
    }
}

#[test]
fn services_of_three_masters_in_any_order_and_at_any_time_get_allowed_answers_only() {
    for seed in 0..20 {
        let mut rng = Rng::with_seed(seed);
        let mut line = Line::new();
        line.passes(33);
        for step in 0..5_000 * times() {
            let wait = [33, 33, 33, 33, 500, 15_000, 1_600_000, 5_000_000][rng.usize(..8)];
            line.passes(wait);
            let device = line.slave.device_mut();
            (device.changed, device.static_diag, device.event) = (rng.u8(..9) == 0, rng.u8(..9) == 0, rng.u8(..9) == 0);
            let request = Request::random(&mut rng);
            let (before, repeated) = (*line.slave.state(), request.is_counted());
            let answers = line.receive(&request.octets());
            if let ([answer], false) = (&answers[..], repeated) {
                let context = format!("seed {seed}, step {step}: {:?} in {before:?}", request.data);
                assert!(is_allowed(&before, &request.data, &classify(answer)), "{context}: {}", text(answer));
            }
            if rng.u8(..50) == 0 {
                line.receive(&request.octets());
            }
            rename(&mut line);
        }
        is_still_usable(&mut line, &format!("seed {seed}"));
    }
}

impl Request {
    /// Whether the request may look like a repetition, or is no SRD.
    fn is_counted(&self) -> bool {
        match self.data.control() {
            Control::Request { function: Function::SrdLow | Function::SrdHigh, count } => {
                matches!(count, FrameCount::Counted(_))
            }
            _ => true,
        }
    }
}

/// After all timers have expired and the owner has released the slave, a master starts it and all connections are free.
fn is_still_usable(line: &mut Line, context: &str) {
    line.passes(1_500_000 * 3000);
    let owner = line.slave.state().owner().map_or(2, |owner| owner.master);
    let mut ask = |sa: u8, dsap: Option<u8>, du: &str| {
        let fc = Control::Request { function: Function::SrdLow, count: FrameCount::First }.to_octet();
        let ssap = dsap.map(|dsap| if dsap <= 49 { 50 } else { 62 });
        let data = DataTelegram { da: SLAVE, sa, dsap, ssap, fc, du: &hex(du) };
        line.passes(100);
        let answers = line.receive(&emit(&Telegram::Data(data)));
        assert_eq!(answers.len(), 1, "{context}");
        answers.concat()
    };
    assert_eq!(ask(owner, Some(61), "40 00 00 00 12 34 00"), [0xE5], "{context}");
    assert_eq!(ask(2, Some(61), "80 01 01 00 12 34 00"), [0xE5], "{context}");
    assert_eq!(ask(2, Some(62), "11 21"), [0xE5], "{context}");
    assert_eq!(ask(2, None, "05 06").len(), 11, "{context}");
    for sap in [48, 47] {
        assert_eq!(ask(1, Some(49), INITIATE)[9..11], [0x56, sap], "{context}");
    }
}
