//! Random answers, random requests, random times: no acyclic request makes a master panic, and each one ends.
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic, reason = "helpers of tests are tests")]

use crate::support;

use profivac_dp::link::active::Active;
use profivac_dp::link::{Baud, BitTime, CHARACTER_TBIT, Station};
use profivac_dp::master::pkw::Value;
use profivac_dp::master::{
    Handle, Master, Mode, Ms1Parameters, Ms2Parameters, Operation, Phase, PkwParameters, Settings, SlaveParameters,
    ms1, ms2, pkw, services,
};
use profivac_dp::slave::{Features, Slave};
use profivac_wire::acyclic::AlarmAck;
use profivac_wire::control::{Control, StationType, Status};
use profivac_wire::{DataTelegram, Telegram};
use support::plain::Plain;
use support::{Random, bus};

const BAUD: Baud = Baud::B1500000;
const IDENT: u16 = 0x1234;
/// Parameter channel both ways.
const CFG: [u8; 2] = [0x97, 0xA7];

type Any = Active<TestMaster>;

type TestMaster = Master<2, 16, 8, 3>;

/// A handle of any operation.
#[derive(Clone, Copy, Debug)]
enum AnyHandle {
    Connection(Handle<ms2::Connect>),
    Read(Handle<ms2::Read>),
    Write(Handle<ms2::Write>),
    Transport(Handle<ms2::Transport>),
    Ms1Read(Handle<ms1::Read>),
    Ms1Write(Handle<ms1::Write>),
    Alarm(Handle<ms1::AcknowledgeAlarm>),
    Task(Handle<pkw::Task>),
}

impl AnyHandle {
    /// Takes the outcome, if there is one.
    fn take(self, user: &mut TestMaster) {
        fn take<O: Operation>(user: &mut TestMaster, handle: Handle<O>) {
            let _ = user.outcome(handle);
        }
        match self {
            Self::Connection(handle) => take(user, handle),
            Self::Read(handle) => take(user, handle),
            Self::Write(handle) => take(user, handle),
            Self::Transport(handle) => take(user, handle),
            Self::Ms1Read(handle) => take(user, handle),
            Self::Ms1Write(handle) => take(user, handle),
            Self::Alarm(handle) => take(user, handle),
            Self::Task(handle) => take(user, handle),
        }
    }

    fn is_over(self, user: &TestMaster) -> bool {
        match self {
            Self::Connection(handle) => user.is_over(handle),
            Self::Read(handle) => user.is_over(handle),
            Self::Write(handle) => user.is_over(handle),
            Self::Transport(handle) => user.is_over(handle),
            Self::Ms1Read(handle) => user.is_over(handle),
            Self::Ms1Write(handle) => user.is_over(handle),
            Self::Alarm(handle) => user.is_over(handle),
            Self::Task(handle) => user.is_over(handle),
        }
    }
}

/// A master, its slaves, and the handles of all requests so far.
struct Bus {
    station: Any,
    slaves: Vec<Slave<Plain>>,
    now: BitTime,
    handles: Vec<AnyHandle>,
    /// One in this number of answers is replaced; 0: none.
    spoil: usize,
}

impl Bus {
    fn new() -> Self {
        let mut station: Any = Master::on(bus().check().unwrap(), Settings::new(BAUD), BitTime(0));
        let features = Features { sync: true, freeze: true, dpv1: true, ms1: true };
        let mut slaves = Vec::new();
        for address in [8, 9] {
            let device = Plain { features, record: vec![address; 5], ..Plain::new(IDENT, &CFG) };
            slaves.push(Slave::new(device, address, BAUD));
            let slave = SlaveParameters { user_prm: &[0x80, 0, 0], ..SlaveParameters::new(address, IDENT, &CFG) };
            station.user.add(&slave).unwrap();
        }
        station.user.set_mode(Mode::Operate);
        Self { station, slaves, now: BitTime(0), handles: Vec::new(), spoil: 0 }
    }

    /// One telegram of the master and its answer.
    fn step(&mut self, random: &mut Random) {
        self.now = self.now.max(self.station.wake_at().unwrap_or(self.now));
        let Some(transmit) = self.station.poll(self.now) else { return };
        let request = transmit.octets.to_vec();
        self.now = self.now.max(transmit.not_before) + request.len() as u64 * CHARACTER_TBIT;
        self.station.sent(self.now);
        let telegram = Telegram::parse(&request).unwrap();
        let mut answer = None;
        for slave in &mut self.slaves {
            slave.poll(self.now);
            answer = answer.or(slave.telegram(self.now, &telegram).map(|answer| answer.octets.to_vec()));
        }
        if self.spoil > 0 && random.below(self.spoil) == 0 {
            answer = spoilt(&telegram, answer, random);
        }
        let Some(answer) = answer else { return };
        self.now = self.now + 11 + answer.len() as u64 * CHARACTER_TBIT;
        match Telegram::parse(&answer) {
            Ok(telegram) => drop(self.station.telegram(self.now, &telegram)),
            Err(_) => self.station.activity(self.now),
        }
    }

    /// The user submits a request, takes an outcome or changes the mode.
    fn meddle(&mut self, random: &mut Random) {
        let [address, slot, index] =
            [8 + (random.next() & 1) as u8, random.next() as u8 & 3, 14 + random.next() as u8 % 4];
        let any = self.handles.get(random.below(self.handles.len().max(1))).copied();
        let data = vec![slot; random.below(260)];
        let (ms1, ms2, pkw) = parameters(random);
        let user = &mut self.station.user;
        let begun = match random.below(60) {
            0..4 => user.ms2_open(address, &ms2).ok().map(AnyHandle::Connection),
            4..6 => user.ms1_read(address, slot, index, random.next() as u8, &ms1).ok().map(AnyHandle::Ms1Read),
            6 => user.ms1_write(address, slot, index, &data, &ms1).ok().map(AnyHandle::Ms1Write),
            7 => user
                .ms1_alarm_ack(address, AlarmAck { slot, alarm_type: 1, specifier: index }, &ms1)
                .ok()
                .map(AnyHandle::Alarm),
            8..10 => user.pkw_read(address, slot, index, Some(random.below(5)), &pkw).ok().map(AnyHandle::Task),
            10 => user.pkw_write(address, slot, index, Value::Word(7), &pkw).ok().map(AnyHandle::Task),
            _ => None,
        };
        self.handles.extend(begun);
        let user = &mut self.station.user;
        let connection = match any {
            Some(AnyHandle::Connection(connection)) => Some(connection),
            _ => None,
        };
        let begun = match (random.below(40), connection) {
            (0..4, Some(it)) => user.ms2_read(it, slot, index, random.next() as u8).ok().map(AnyHandle::Read),
            (4..6, Some(it)) => user.ms2_write(it, slot, index, &data).ok().map(AnyHandle::Write),
            (6, Some(it)) => user.ms2_transport(it, slot, index, &data).ok().map(AnyHandle::Transport),
            (7, Some(it)) => {
                let _ = user.ms2_close(it);
                None
            }
            _ => None,
        };
        match (random.below(40), any) {
            (8..12, Some(handle)) => handle.take(user),
            (12, _) => drop(user.submit_request(&services::slave_diag(address))),
            (13, _) => drop(user.take_confirmation()),
            (14..20, _) => drop(user.next_event()),
            (20, _) if random.below(20) == 0 => user.restart(address),
            (21, _) if random.below(20) == 0 => user.set_mode(Mode::Clear),
            (22, _) => user.set_mode(Mode::Operate),
            (23, _) if random.below(20) == 0 => self.station.listen(self.now),
            (24, _) if random.below(20) == 0 => self.slaves[usize::from(address & 1)].power_up(address),
            _ => {}
        }
        self.handles.extend(begun);
    }

    /// Whether a request is still under way.
    fn is_pending(&mut self, handle: AnyHandle) -> bool {
        let user = &mut self.station.user;
        if let AnyHandle::Connection(connection) = handle
            && let Some(phase) = user.ms2_phase(connection)
        {
            user.ms2_close(connection).unwrap();
            return phase != Phase::Ended;
        }
        !handle.is_over(user)
    }
}

/// Arbitrary times and offsets, also invalid ones.
fn parameters(random: &mut Random) -> (Ms1Parameters, Ms2Parameters, PkwParameters) {
    let pace_tbit = [0, 100, 1500][random.below(3)];
    let ms1 = Ms1Parameters { pace_tbit, response_tbit: random.next() % 60_000, rejections: random.next() as u8 & 3 };
    let ms2 = Ms2Parameters {
        send_timeout: random.next() as u16 & 7,
        response_timeout: random.next() as u16 & 7,
        pace_tbit,
        rejections: random.next() as u8 & 3,
        destination: ((random.next() & 1) as u8, 0),
        ..Ms2Parameters::new(BAUD)
    };
    let at = random.below(3);
    let pkw = PkwParameters { outputs_at: at / 2, inputs_at: at / 2, cycles: random.next() as u32 % 20, byte_ak: 10 };
    (ms1, ms2, pkw)
}

/// A changed answer in place of the slave's.
fn spoilt(request: &Telegram<'_>, answer: Option<Vec<u8>>, random: &mut Random) -> Option<Vec<u8>> {
    let Telegram::Data(asked) = request else { return answer };
    let kind = random.below(8);
    if let (0..2, Some(mut octets)) = (kind, answer.clone()) {
        let position = random.below(octets.len());
        octets[position] = random.next() as u8;
        if octets.len() > 9 && kind == 0 {
            let end = octets.len() - 2;
            octets[end] = octets[4..end].iter().fold(0, |sum: u8, octet| sum.wrapping_add(*octet));
        }
        return Some(octets);
    }
    let statuses =
        [Status::DataLow, Status::DataHigh, Status::NoResource, Status::UserError, Status::ServiceNotActivated];
    let functions = [0x48, 0x51, 0x56, 0x57, 0x58, 0x5C, 0x5E, 0x5F, 0xD7, 0xDE, 0xDF, 0x77];
    let mut du = vec![functions[random.below(12)], random.next() as u8 & 3, 14 + random.next() as u8 % 4];
    du.extend((0..random.below(20)).map(|_| random.next() as u8 & 0x1F));
    let status = statuses[random.below(5)];
    let fc = Control::Response { station: StationType::Slave, status }.to_octet();
    let has_data = matches!(status, Status::DataLow | Status::DataHigh);
    let (dsap, ssap) = if has_data { (asked.ssap, asked.dsap) } else { (None, None) };
    let du = if has_data { &du[..] } else { &[] };
    let data = DataTelegram { da: asked.sa, sa: asked.da, dsap, ssap, fc, du };
    match kind {
        2 => None,
        3 => Some(vec![0xE5]),
        _ => {
            let mut octets = [0; 255];
            let length = Telegram::Data(data).emit(&mut octets).unwrap();
            Some(octets[..length].to_vec())
        }
    }
}

#[test]
fn every_request_ends_for_any_answers() {
    let mut random = Random::new(0x00AC_7C1C);
    let (mut begun, mut values) = (0, 0);
    for round in 0..300 {
        let mut bus = Bus::new();
        for _ in 0..200 {
            bus.step(&mut random);
        }
        bus.spoil = 1 + round % 9;
        for _ in 0..2000 {
            bus.step(&mut random);
            bus.meddle(&mut random);
        }
        begun += bus.handles.len();
        // From here on the answers are right, or the slaves are absent: every request must end.
        bus.spoil = 0;
        if random.below(2) == 0 {
            bus.slaves.clear();
        }
        let limit = bus.now + BAUD.tbit_of_ms(9000);
        for handle in bus.handles.clone() {
            while bus.is_pending(handle) {
                bus.step(&mut random);
                assert!(bus.now < limit, "{handle:?} of round {round} never ends");
            }
        }
        values += works_afterwards(bus, &mut random);
    }
    println!("{begun} requests begun; {values} times it worked afterwards");
    assert!(begun > 10_000 && values > 100, "{begun}, {values}");
}

/// A new connection reads the value, if the slaves are still there.
fn works_afterwards(mut bus: Bus, random: &mut Random) -> usize {
    if bus.slaves.is_empty() {
        return 0;
    }
    // Connections that are still open at the slave end by their own timers.
    let until = bus.now + BAUD.tbit_of_ms(9000);
    while bus.now < until {
        bus.step(random);
    }
    let connection = bus.station.user.ms2_open(8, &Ms2Parameters::new(BAUD)).unwrap();
    let mut read = None;
    for _ in 0..20_000 {
        let user = &mut bus.station.user;
        match read {
            None => {
                if let Some(opened) = user.outcome(connection) {
                    opened.unwrap();
                    read = Some(user.ms2_read(connection, 1, 16, 240).unwrap());
                }
            }
            Some(read) => {
                if let Some(record) = user.outcome(read) {
                    assert_eq!(record.unwrap(), bus.slaves[0].device().record);
                    return 1;
                }
            }
        }
        bus.step(random);
    }
    panic!("no value");
}
