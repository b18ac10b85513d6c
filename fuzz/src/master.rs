//! A master with two slaves whose answers the script changes, and a user who submits requests.
//!
//! Cyclic data, diagnosis, MS1, MS2 and the parameter channel run side by side over two virtual gauges. The master has no deadline in
//! the past and sends only telegrams. Where the first octet of the script is 255, the answers are right at the end, and every acyclic
//! request must end.

use crate::script::Script;
use profivac_dp::link::active::{Active, BusParameters};
use profivac_dp::link::{Baud, BitTime, CHARACTER_TBIT, Station};
use profivac_dp::master::pkw::Value;
use profivac_dp::master::{
    Handle, Master, Mode, Ms1Parameters, Ms2Parameters, Phase, PkwParameters, Settings, SlaveParameters, ms1, ms2, pkw,
    services,
};
use profivac_virtual::device::GaugeSlave;
use profivac_virtual::device_spec::DeviceSpec;
use profivac_virtual::nonvolatile::NonvolatileMemory;
use profivac_wire::acyclic::AlarmAck;
use profivac_wire::control::{Control, StationType, Status};
use profivac_wire::global::ControlCommand;
use profivac_wire::{DataTelegram, MAX_TELEGRAM, Telegram};

const BAUD: Baud = Baud::B1500000;
/// The slaves: one with its parameters in the parameter channel and over MS2, a controller without DPV1, and one that is absent.
const SLAVES: [(u8, &str); 2] = [(8, "bcg450"), (9, "tpg300")];
const ABSENT: u8 = 10;
/// The most polls at one bit time: one for each slave, connection and request that ends.
const POLLS: u32 = 64;

type TestMaster = Master<4, 64, 8, 3>;

/// Handles of the requests so far.
#[derive(Default)]
struct Handles {
    connections: Vec<Handle<ms2::Connect>>,
    reads: Vec<Handle<ms2::Read>>,
    writes: Vec<Handle<ms2::Write>>,
    transports: Vec<Handle<ms2::Transport>>,
    ms1_reads: Vec<Handle<ms1::Read>>,
    ms1_writes: Vec<Handle<ms1::Write>>,
    alarms: Vec<Handle<ms1::AcknowledgeAlarm>>,
    tasks: Vec<Handle<pkw::Task>>,
}

/// Whether all handles of a list are over.
macro_rules! are_over {
    ($user:expr, $($list:expr),+) => { true $(&& $list.iter().all(|handle| $user.is_over(*handle)))+ };
}

/// Takes the outcomes of the last handle of each list.
macro_rules! take {
    ($user:expr, $($list:expr),+) => {{ $(if let Some(handle) = $list.last() { let _ = $user.outcome(*handle); })+ }};
}

/// A master and its slaves.
struct Bus {
    station: Active<TestMaster>,
    slaves: Vec<Box<dyn GaugeSlave>>,
    now: BitTime,
    polls: u32,
    handles: Handles,
}

impl Bus {
    fn new() -> Self {
        let bus = BusParameters { gap_factor: 10, hsa: 4, ..BusParameters::new(2, BAUD) };
        let mut station: Active<TestMaster> =
            Master::on(bus.check().expect("possible parameters"), Settings::new(BAUD), BitTime(0));
        let mut slaves = Vec::new();
        for (address, device) in SLAVES {
            let spec: DeviceSpec = format!("{device}@{address}").parse().expect("a built-in device");
            let slave = spec.build(NonvolatileMemory::volatile(), BAUD).expect("a device without keys");
            let (ident, cfg) = (slave.device().ident_number(), slave.device().get_cfg().to_vec());
            let dpv1 = [0x80, 0, 0];
            let user_prm: &[u8] = if device == "bcg450" { &dpv1 } else { &[] };
            let parameters = SlaveParameters { user_prm, ..SlaveParameters::new(address, ident, &cfg) };
            station.user.add(&parameters).expect("room for it");
            slaves.push(slave);
        }
        station.user.add(&SlaveParameters::new(ABSENT, 0x1234, &[0x11, 0x21])).expect("room for it");
        station.user.set_mode(Mode::Operate);
        Self { station, slaves, now: BitTime(0), polls: 0, handles: Handles::default() }
    }

    /// One telegram of the master, or one deadline, and the answer; `change` may change it.
    fn step(&mut self, change: impl FnOnce(&DataTelegram<'_>, Option<Vec<u8>>) -> Option<Vec<u8>>) {
        let due = self.station.wake_at().expect("a master always has a deadline");
        self.polls = if due <= self.now { self.polls + 1 } else { 0 };
        assert!(self.polls < POLLS, "it waits for {due}, and it is {}", self.now);
        self.now = self.now.max(due);
        let Some(transmit) = self.station.poll(self.now) else { return };
        self.polls = 0;
        let request = transmit.octets.to_vec();
        self.now = self.now.max(transmit.not_before) + request.len() as u64 * CHARACTER_TBIT;
        self.station.sent(self.now);
        let telegram = Telegram::parse(&request).expect("a master sends telegrams");
        let mut answer = None;
        for slave in &mut self.slaves {
            slave.poll(self.now);
            answer = answer.or(slave.telegram(self.now, &telegram).map(|answer| answer.octets.to_vec()));
        }
        let Telegram::Data(asked) = &telegram else { return };
        let Some(answer) = change(asked, answer) else { return };
        self.now = self.now + 11 + answer.len() as u64 * CHARACTER_TBIT;
        match Telegram::parse(&answer) {
            Ok(telegram) => drop(self.station.telegram(self.now, &telegram)),
            Err(_) => self.station.activity(self.now),
        }
    }

    /// The user of the master does something.
    fn user(&mut self, script: &mut Script<'_>) {
        let kind = script.choice();
        let address = [8, 8, 9, ABSENT][usize::from(kind >> 6)];
        let (user, handles) = (&mut self.station.user, &mut self.handles);
        let connection = handles.connections.last().copied();
        match kind % 24 {
            0 | 1 => {
                let ms2 = Ms2Parameters { pace_tbit: 100, ..Ms2Parameters::new(BAUD) };
                handles.connections.extend(user.ms2_open(address, &ms2));
            }
            2 | 3 => {
                let (slot, index, length) = (script.choice(), script.choice(), script.choice());
                handles.reads.extend(connection.and_then(|it| user.ms2_read(it, slot, index, length).ok()));
            }
            4 => {
                let (slot, index, data) = (script.choice(), script.choice(), script.piece(250));
                handles.writes.extend(connection.and_then(|it| user.ms2_write(it, slot, index, data).ok()));
            }
            5 => {
                let (slot, index, data) = (script.choice(), script.choice(), script.piece(250));
                handles.transports.extend(connection.and_then(|it| user.ms2_transport(it, slot, index, data).ok()));
            }
            6 => drop(connection.map(|it| user.ms2_close(it))),
            7 | 8 => {
                let ms1 = ms1_parameters(script);
                let (slot, index, length) = (script.choice(), script.choice(), script.choice());
                handles.ms1_reads.extend(user.ms1_read(address, slot, index, length, &ms1));
            }
            9 => {
                let ms1 = ms1_parameters(script);
                let (slot, index, data) = (script.choice(), script.choice(), script.piece(250));
                handles.ms1_writes.extend(user.ms1_write(address, slot, index, data, &ms1));
            }
            10 => {
                let ack = AlarmAck { slot: script.choice(), alarm_type: script.choice(), specifier: script.choice() };
                handles.alarms.extend(user.ms1_alarm_ack(address, ack, &Ms1Parameters::new(BAUD)));
            }
            11 | 12 => {
                let pkw = pkw_parameters(script);
                let (slot, index, length) = (script.choice(), script.choice(), usize::from(script.choice() % 5));
                handles.tasks.extend(user.pkw_read(address, slot, index, Some(length), &pkw));
            }
            13 => {
                let pkw = pkw_parameters(script);
                let (slot, index, word) = (script.choice(), script.choice(), script.number());
                handles.tasks.extend(user.pkw_write(address, slot, index, Value::Word(word), &pkw));
            }
            14 => drop(user.submit_request(&services::slave_diag(address))),
            15 => drop(user.take_confirmation()),
            16 => drop(user.next_event()),
            17 => user.restart(address),
            18 => user.set_mode([Mode::Operate, Mode::Clear, Mode::Stop][usize::from(script.choice() % 3)]),
            19 => drop(user.control(ControlCommand::from_bits_retain(script.choice()), script.choice())),
            20 => user.release(address),
            21 => {
                if let Some(outputs) = user.outputs_mut(address) {
                    outputs.iter_mut().for_each(|octet| *octet = script.choice());
                }
            }
            22 => drop(user.submit_request(&services::set_slave_add(address, script.piece(8)))),
            _ => take!(
                user,
                handles.connections,
                handles.reads,
                handles.writes,
                handles.transports,
                handles.ms1_reads,
                handles.ms1_writes,
                handles.alarms,
                handles.tasks
            ),
        }
    }

    /// Whether all acyclic requests have ended. Closes the connections that are open.
    fn all_ended(&mut self) -> bool {
        let user = &mut self.station.user;
        let mut open = false;
        for connection in &self.handles.connections {
            if let Some(phase) = user.ms2_phase(*connection) {
                let _ = user.ms2_close(*connection);
                open |= phase != Phase::Ended;
            }
        }
        let handles = &self.handles;
        !open
            && are_over!(
                user,
                handles.reads,
                handles.writes,
                handles.transports,
                handles.ms1_reads,
                handles.ms1_writes,
                handles.alarms,
                handles.tasks
            )
    }
}

fn ms1_parameters(script: &mut Script<'_>) -> Ms1Parameters {
    let code = script.choice();
    Ms1Parameters { response_tbit: u64::from(code) << 8, rejections: code & 3, ..Ms1Parameters::new(BAUD) }
}

fn pkw_parameters(script: &mut Script<'_>) -> PkwParameters {
    let code = script.choice();
    let at = usize::from(code >> 6);
    PkwParameters { outputs_at: at, inputs_at: at, cycles: u32::from(code & 0x1F), byte_ak: 10 }
}

/// Replaces an answer.
fn hostile(asked: &DataTelegram<'_>, answer: Option<Vec<u8>>, kind: u8, script: &mut Script<'_>) -> Option<Vec<u8>> {
    match kind % 8 {
        0 => None,
        1 => Some(vec![0xE5]),
        // Without a right check octet.
        2 => answer.map(|mut octets| {
            let position = usize::from(script.choice()) % octets.len();
            octets[position] ^= script.choice();
            octets
        }),
        // With one: data, status or addresses are different.
        3 => {
            let octets = answer?;
            let Ok(Telegram::Data(frame)) = Telegram::parse(&octets) else { return Some(octets) };
            let mut du = frame.du.to_vec();
            match script.choice() % 4 {
                0 => du.truncate(usize::from(script.choice())),
                1 => du.extend(script.piece(40)),
                _ => {
                    let position = usize::from(script.choice());
                    du.iter_mut().skip(position).zip(script.piece(4)).for_each(|(octet, new)| *octet = *new);
                }
            }
            emit(DataTelegram { du: &du, ..frame })
        }
        4 => emit(DataTelegram { da: asked.sa, sa: asked.da, dsap: None, ssap: None, fc: script.choice(), du: &[] }),
        5 => Some(script.piece(255).to_vec()),
        // Any data unit, addressed rightly.
        _ => {
            let status = if kind & 0x40 == 0 { Status::DataLow } else { Status::DataHigh };
            let fc = Control::Response { station: StationType::Slave, status }.to_octet();
            let (dsap, ssap) = if kind & 0x80 == 0 { (asked.ssap, asked.dsap) } else { (None, None) };
            emit(DataTelegram { da: asked.sa, sa: asked.da, dsap, ssap, fc, du: script.piece(244) })
        }
    }
}

fn emit(frame: DataTelegram<'_>) -> Option<Vec<u8>> {
    let mut octets = [0; MAX_TELEGRAM];
    let length = Telegram::Data(frame).emit(&mut octets).ok()?;
    Some(octets[..length].to_vec())
}

/// Runs the target.
pub fn run(octets: &[u8]) {
    let mut script = Script::new(octets);
    let must_end = script.choice() == 0xFF;
    let mut bus = Bus::new();
    // Both slaves are in data exchange after these.
    (0..60).for_each(|_| bus.step(|_, answer| answer));
    while let Some(kind) = script.octet() {
        match kind & 3 {
            0 => (0..kind >> 2).for_each(|_| bus.step(|_, answer| answer)),
            1 | 2 => bus.step(|asked, answer| hostile(asked, answer, kind >> 2 ^ kind << 6, &mut script)),
            _ => bus.user(&mut script),
        }
    }
    if !must_end {
        return;
    }
    let limit = bus.now + BAUD.tbit_of_ms(9000);
    bus.station.user.set_mode(Mode::Operate);
    while !bus.all_ended() {
        bus.step(|_, answer| answer);
        assert!(bus.now < limit, "a request never ends");
    }
}
