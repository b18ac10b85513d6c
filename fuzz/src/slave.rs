//! A slave of each device: telegrams with right check octets, damaged ones, any octets, pauses, and events at the device.
//!
//! The slave never speaks unasked, answers only requests that have an answer, every answer is a telegram to the asking station, and
//! after all timers have expired the slave still answers a request for its diagnosis. After a Data_Exchange that it accepts, RD_Outp
//! returns the outputs of the request, and RD_Inp the inputs of the answer.

use crate::script::Script;
use profivac_devices::{Action, Potentiometer, Switch};
use profivac_dp::link::{Baud, BitTime, CHARACTER_TBIT, Received, Receiver};
use profivac_virtual::device::GaugeSlave;
use profivac_virtual::device_spec::{DEVICES, DeviceSpec};
use profivac_virtual::nonvolatile::NonvolatileMemory;
use profivac_wire::cfg::lengths;
use profivac_wire::control::{Control, FrameCount, Function};
use profivac_wire::{BROADCAST, DataTelegram, MAX_DU, MAX_TELEGRAM, Telegram};

const BAUD: Baud = Baud::B1500000;
const ADDRESS: u8 = 5;
/// The shortest time between a request and its answer.
const MIN_TSDR_TBIT: u64 = 11;
/// A master that only reads.
const READER: u8 = 99;

/// A slave on a line.
struct Line {
    receiver: Receiver,
    slave: Box<dyn GaugeSlave>,
    now: BitTime,
    /// The last telegram of a master.
    last: Vec<u8>,
    /// The frame count bit of the next request of each of four masters; `None` before the first.
    count: [Option<bool>; 4],
    /// The access point of the last MS2 connection.
    connection: u8,
    /// Source and frame control of the last two telegrams to the slave, the later one first.
    asked: [(u8, u8); 2],
}

/// The octets of a telegram.
fn emit(frame: DataTelegram<'_>) -> Vec<u8> {
    let mut octets = [0; MAX_TELEGRAM];
    let length = Telegram::Data(frame).emit(&mut octets).unwrap_or_default();
    octets[..length].to_vec()
}

/// Whether a station at `address` must answer.
fn expects_answer(telegram: &Telegram<'_>, address: u8) -> bool {
    let Telegram::Data(frame) = telegram else { return false };
    let Control::Request { function, .. } = frame.control() else { return false };
    let answered = !matches!(function, Function::SdnLow | Function::SdnHigh | Function::Other(_));
    answered && frame.da == address && frame.sa != address && frame.sa != BROADCAST
}

/// Passes a telegram to the slave and checks its answer.
fn answer(slave: &mut dyn GaugeSlave, end: BitTime, telegram: &Telegram<'_>) -> Option<Vec<u8>> {
    let owed = expects_answer(telegram, slave.station_address());
    let Some(transmit) = slave.telegram(end, telegram) else {
        assert!(!owed, "no answer to {telegram:?}");
        return None;
    };
    assert!(owed, "{telegram:?} was answered by {:02X?}", transmit.octets);
    assert!(transmit.not_before >= end + MIN_TSDR_TBIT, "an early answer to {telegram:?}");
    let answer = Telegram::parse(transmit.octets);
    let fits = match (telegram, answer) {
        (_, Ok(Telegram::ShortAck)) => true,
        (Telegram::Data(request), Ok(Telegram::Data(answer))) => (answer.da, answer.fc & 0xF0) == (request.sa, 0),
        _ => false,
    };
    assert!(fits, "{telegram:?} was answered by {answer:?}");
    Some(transmit.octets.to_vec())
}

impl Line {
    fn new(device: u8) -> Self {
        let name = DEVICES[usize::from(device) % DEVICES.len()].model.name;
        let spec: DeviceSpec = format!("{name}@{ADDRESS}").parse().expect("a built-in device");
        let slave = spec.build(NonvolatileMemory::volatile(), BAUD).expect("a device without keys");
        let receiver = Receiver::new(BitTime(0));
        Self {
            receiver,
            slave,
            now: BitTime(0),
            last: Vec::new(),
            count: [None; 4],
            connection: 48,
            asked: [(0, 0); 2],
        }
    }

    fn passes(&mut self, tbit: u64) {
        self.now = self.now + tbit;
        assert_eq!(self.slave.poll(self.now), None, "a slave never speaks unasked");
        assert!(self.slave.wake_at().is_none_or(|wake| wake > self.now), "an expired timer does not expire again");
    }

    /// Characters without a gap; returns the last answer to them.
    fn receive(&mut self, octets: &[u8]) -> Option<Vec<u8>> {
        let (mut sent, mut last) = (0, None);
        for octet in octets {
            self.now = self.now + CHARACTER_TBIT;
            let Received::Telegram(telegram) = self.receiver.octet(self.now, *octet) else { continue };
            if let Telegram::Data(frame) = &telegram
                && frame.da == self.slave.station_address()
            {
                self.asked = [(frame.sa, frame.fc), self.asked[0]];
            }
            let Some(answer) = answer(&mut *self.slave, self.now, &telegram) else { continue };
            self.slave.sent(self.now);
            sent += answer.len() as u64;
            // The access point that an MS2 connection has got.
            if let [_, _, _, _, _, _, _, _, 49, 0x56, sap, ..] = answer[..] {
                self.connection = sap;
            }
            last = Some(answer);
        }
        self.now = self.now + CHARACTER_TBIT * sent;
        last
    }

    /// Whether the last request is certainly new: the one before came from the same master, with the other frame count bit.
    const fn is_new(&self) -> bool {
        let [(sa, fc), (before_sa, before_fc)] = self.asked;
        // SRD, and the frame count bit valid; or the first request, whose bit is 1.
        let is_counted = matches!(fc & 0x5E, 0x5C);
        let is_first_or_counted = matches!(before_fc & 0x5E, 0x5C) || matches!(before_fc & 0x7E, 0x6C);
        sa == before_sa && is_counted && is_first_or_counted && (fc ^ before_fc) & 0x20 != 0
    }

    /// The length of the outputs in the present configuration.
    fn outputs(&self) -> usize {
        lengths(self.slave.device().get_cfg()).map_or(0, |lengths| usize::from(lengths.outputs))
    }

    /// A Data_Exchange. The slave stores the outputs of a new one that it accepts, and gives the same inputs again.
    fn exchange(&mut self, variant: u8, du: &[u8]) {
        let is_expected = self.slave.is_exchanging() && du.len() == self.outputs();
        let answer = self.request(variant, None, du);
        let address = self.slave.station_address();
        if !(is_expected && self.is_new() && self.slave.is_exchanging()) || address == READER {
            return;
        }
        let inputs = match answer.as_deref().map(Telegram::parse) {
            Some(Ok(Telegram::Data(frame))) if matches!(frame.fc & 0x0F, 8 | 10) => frame.du.to_vec(),
            Some(Ok(Telegram::ShortAck)) => Vec::new(),
            // Another master owns it.
            _ => return,
        };
        for (name, dsap, expected) in [("outputs", 57, du), ("inputs", 56, &inputs)] {
            let fc = Control::Request { function: Function::SrdLow, count: FrameCount::First }.to_octet();
            let request = emit(DataTelegram { da: address, sa: READER, dsap: Some(dsap), ssap: Some(62), fc, du: &[] });
            self.now = self.now + 33;
            let answer = self.receive(&request);
            let found = match answer.as_deref().map(Telegram::parse) {
                Some(Ok(Telegram::Data(frame))) => frame.du.to_vec(),
                Some(Ok(Telegram::ShortAck)) => Vec::new(),
                other => panic!("{name}: {other:?}"),
            };
            assert_eq!(found, expected, "the {name} after a Data_Exchange");
        }
    }

    /// A request with a right check octet; returns the answer. `variant` changes what is usual.
    fn request(&mut self, variant: u8, dsap: Option<u8>, du: &[u8]) -> Option<Vec<u8>> {
        let master = usize::from(variant & 3);
        let count = match (self.count[master], variant & 0x10 != 0) {
            _ if variant & 0xC0 == 0xC0 => FrameCount::Uncounted,
            // A repetition.
            (Some(next), true) => FrameCount::Counted(!next),
            (Some(next), false) => {
                self.count[master] = Some(!next);
                FrameCount::Counted(next)
            }
            (None, _) => {
                self.count[master] = Some(false);
                FrameCount::First
            }
        };
        let function = match (dsap, variant & 0x20 != 0) {
            (Some(58), false) => Function::SdnHigh,
            (_, true) => Function::SrdLow,
            _ => Function::SrdHigh,
        };
        let ssap = dsap.map(|dsap| match dsap {
            51 => 51,
            ..=50 => 50,
            _ => 62,
        });
        let da = if dsap == Some(58) { BROADCAST } else { self.slave.station_address() };
        let fc = Control::Request { function, count }.to_octet();
        let du = &du[..du.len().min(MAX_DU - 2)];
        self.last = emit(DataTelegram { da, sa: 2 + master as u8, dsap, ssap, fc, du });
        self.now = self.now + 33;
        let last = std::mem::take(&mut self.last);
        let answer = self.receive(&last);
        self.last = last;
        answer
    }

    /// Something happens at the device.
    fn device_event(&mut self, script: &mut Script<'_>) {
        let (kind, which) = (script.choice(), script.choice());
        let device = self.slave.device_mut();
        let faults = profivac_devices::model::Fault::ALL;
        let action = match kind % 8 {
            0 => Action::Fault { fault: faults[usize::from(which >> 1) % faults.len()], active: which & 1 == 1 },
            1 => Action::Button(which & 3),
            2 => Action::Switch(match which & 3 {
                0 => Switch::Degas(which & 4 != 0),
                1 => Switch::LowHigh(which >> 4),
                _ => Switch::CalAdj(which >> 4),
            }),
            3 => {
                let potentiometer = if which & 1 == 0 { Potentiometer::A } else { Potentiometer::B };
                Action::Potentiometer { potentiometer, volts: f64::from(which) / 16.0 }
            }
            4 => {
                let part = usize::from(which) % device.parts().len().max(1);
                let exponent = f64::from(script.choice()) / 16.0 - 10.0;
                return if part < device.parts().len() {
                    device.sense(part, 10.0_f64.powf(exponent))
                };
            }
            5 => return device.advance(f64::from(which) * f64::from(which) / 64.0),
            6 => return device.settle(),
            _ => {
                device.set_power(false);
                device.set_power(true);
                self.count = [None; 4];
                return self.slave.power_up();
            }
        };
        // Not every device has everything.
        let _ = device.operate(action);
    }

    /// One step of the script.
    fn step(&mut self, kind: u8, script: &mut Script<'_>) {
        let variant = script.choice();
        let ident = self.slave.device().ident_number().to_be_bytes();
        match kind % 20 {
            0 => {
                let [status, factor, tsdr, group] =
                    [script.choice(), script.choice(), script.choice(), script.choice()];
                let mut du = vec![status | 0x80, factor, 1, tsdr, ident[0], ident[1], group];
                du.extend(script.piece(40));
                self.request(variant, Some(61), &du);
            }
            // As an owner usually starts it, with DPV1 if the variant says so.
            1 => {
                let du = [if variant & 4 == 0 { 0x80 } else { 0x88 }, 1, 1, 11, ident[0], ident[1], 0, 0x80, 0, 0];
                let length = if variant & 8 == 0 { 10 } else { 7 };
                self.request(variant, Some(61), &du[..length]);
            }
            2 => {
                let mut cfg = self.slave.device().get_cfg().to_vec();
                if variant & 4 != 0 {
                    cfg = script.piece(20).to_vec();
                }
                self.request(variant, Some(62), &cfg);
            }
            // Outputs of the right length, with the same ones some cycles before.
            3 | 4 => {
                let cycles = script.choice() % 6;
                let mut du = script.piece(64).to_vec();
                du.resize(self.outputs(), 0);
                (0..cycles).for_each(|_| self.exchange(variant, &du));
                if let Some(last) = du.last_mut() {
                    *last ^= kind >> 4;
                }
                self.exchange(variant, &du);
            }
            5 => {
                let du = script.piece(64);
                self.exchange(variant, du);
            }
            6 => drop(self.request(variant, Some(60), &[])),
            7 => drop(self.request(variant, Some(script.one_of(&[59, 56, 57, 60])), &[])),
            8 => {
                let du = script.take(2);
                self.request(variant, Some(58), du);
            }
            9 => {
                let [address, locked] = [script.choice(), script.choice()];
                let mut du = vec![address, ident[0], ident[1], locked];
                du.extend(script.piece(8));
                self.request(variant, Some(55), &du);
            }
            10 => {
                let du = script.piece(244);
                self.request(variant, Some(51), du);
            }
            11 => drop(self.request(variant, Some(51), &[])),
            12 => {
                let mut du = vec![0x57, 0, 0, 0, script.choice(), 1, 0, 0, 0, 2, 0, 0, 0, 0, 0, 0];
                if variant & 4 != 0 {
                    du.extend(script.piece(20));
                }
                self.request(variant, Some(49), &du);
            }
            13 => {
                let du = script.piece(244);
                self.request(variant, Some(self.connection), du);
            }
            14 => drop(self.request(variant, Some(self.connection), &[])),
            15 => {
                let (dsap, du) = (script.choice(), script.piece(244));
                self.request(variant, Some(dsap & 0x3F), du);
            }
            16 => {
                let octets = script.piece(255);
                self.receive(octets);
            }
            17 => {
                let mut octets = self.last.clone();
                let index = usize::from(script.choice()) % octets.len().max(1);
                match variant % 3 {
                    0 => octets.truncate(index),
                    1 => octets.iter_mut().skip(index).take(1).for_each(|octet| *octet ^= variant | 1),
                    _ => octets.insert(index, variant),
                }
                self.passes(33);
                self.receive(&octets);
            }
            18 => {
                let tbit = script.pause_tbit();
                self.passes(tbit);
                if variant & 0xF0 == 0xF0 {
                    self.receiver.character_error(self.now);
                }
            }
            _ => self.device_event(script),
        }
    }

    /// A request for the diagnosis, from a new master, after all timers have expired.
    fn still_answers(&mut self) {
        self.passes(BAUD.tbit_of_ms(700_000));
        let address = self.slave.station_address();
        let fc = Control::Request { function: Function::SrdLow, count: FrameCount::First }.to_octet();
        let request = DataTelegram { da: address, sa: 100, dsap: Some(60), ssap: Some(62), fc, du: &[] };
        if address == request.sa {
            return;
        }
        let answer = answer(&mut *self.slave, self.now, &Telegram::Data(request));
        let found = answer.as_deref().map(Telegram::parse);
        let Some(Ok(Telegram::Data(frame))) = found else { panic!("no diagnosis: {found:?}") };
        assert_eq!((frame.dsap, frame.ssap), (Some(62), Some(60)));
        assert!(frame.du.len() >= 6, "a diagnosis of {} octets", frame.du.len());
    }
}

/// Runs the target. The first octet chooses the device.
pub fn run(octets: &[u8]) {
    let mut script = Script::new(octets);
    let mut line = Line::new(script.choice());
    line.passes(33);
    while let Some(kind) = script.octet() {
        line.step(kind, &mut script);
    }
    line.still_answers();
}
