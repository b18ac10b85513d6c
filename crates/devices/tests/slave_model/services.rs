//! Random services of four masters. The state of the model guides them, so that they come deep.

use crate::slave_model::acyclic::{Connection, Job};
use crate::slave_model::line::{Event, Step};
use crate::slave_model::model::{DeviceDiagnosis, Model, State};
use crate::slave_model::process::Process;
use crate::slave_model::telegram::{sd1, sd2, sd3, with_saps};
use fastrand::Rng;

/// Two class 1 masters and two class 2 masters.
pub const MASTERS: [u8; 4] = [2, 3, 7, 9];

/// A master and its frame count bit.
#[derive(Clone, Debug)]
struct Master {
    address: u8,
    /// The next FCB; `None` begins with FCV = 0.
    fcb: Option<bool>,
    last: Vec<u8>,
}

/// A random source of steps.
pub struct Services {
    random: Rng,
    masters: Vec<Master>,
    /// Whether the application of the device takes part.
    application: bool,
}

/// A request before its frame count bit: name, SAPs, data unit.
type Plan = (String, Option<(u8, u8)>, Vec<u8>);

impl Services {
    /// The steps of a seed.
    pub fn new(seed: u64, application: bool) -> Self {
        let masters = MASTERS.map(|address| Master { address, fcb: None, last: Vec::new() });
        Self { random: Rng::with_seed(seed), masters: masters.to_vec(), application }
    }

    fn chance(&mut self, percent: u32) -> bool {
        self.random.u32(0..100) < percent
    }

    fn octets(&mut self, length: usize) -> Vec<u8> {
        (0..length).map(|_| self.random.u8(..)).collect()
    }

    fn one_of<T: Clone>(&mut self, of: &[T]) -> T {
        of[self.random.usize(..of.len())].clone()
    }

    /// An idle time: mostly that of a busy line, seldom long, seldom exactly the end of a timer.
    fn gap<P: Process>(&mut self, model: &Model<P>, now: u64) -> u64 {
        match self.random.u32(0..1000) {
            0..=899 => self.random.u64(37..400),
            900..=959 => self.random.u64(0..80),
            960..=979 => self.random.u64(5_000..200_000),
            980..=985 => self.random.u64(200_000..4_000_000),
            _ => {
                let deadlines: Vec<u64> = model.deadlines();
                let end = if deadlines.is_empty() { now + 500 } else { self.one_of(&deadlines) };
                (end.saturating_sub(now) + 20).saturating_sub(self.random.u64(0..200))
            }
        }
    }

    /// The next step.
    pub fn next<P: Process>(&mut self, model: &Model<P>, now: u64) -> Step {
        let gap = self.gap(model, now);
        if self.chance(1) && self.application {
            return self.application(gap);
        }
        if self.chance(3) && !self.application {
            return Step { gap, event: Event::Settle, name: "the device settles".into() };
        }
        let octets = match self.random.u32(0..100) {
            0..=2 => self.odd(model),
            3..=5 => {
                let last = self.random.usize(..self.masters.len());
                let last = &self.masters[last];
                (format!("{}: the last request again", last.address), last.last.clone())
            }
            _ => self.request(model),
        };
        let (mut name, mut octets) = octets;
        if self.chance(2) && !octets.is_empty() {
            let position = self.random.usize(..octets.len());
            match self.random.u32(0..3) {
                0 => octets[position] ^= 1 << self.random.u8(0..8),
                1 => octets.truncate(position),
                _ => octets.insert(position, self.random.u8(..)),
            }
            name.push_str(", damaged");
        }
        Step { gap, event: Event::Octets(octets), name }
    }

    /// An event of the application, or of the power.
    fn application(&mut self, gap: u64) -> Step {
        let (event, name) = match self.random.u32(0..10) {
            0 => (Event::PowerUp, "power-up"),
            1 => (Event::RateFound, "bus lost and found"),
            2 => (Event::ReturnToWaitPrm, "the application leaves the master"),
            _ => {
                let length = self.one_of(&[0, 0, 1, 6, 40, 238]);
                let diagnosis = DeviceDiagnosis {
                    event: self.random.bool(),
                    static_diag: self.chance(20),
                    blocks: self.octets(length),
                };
                (Event::Diagnosis(diagnosis), "another diagnosis")
            }
        };
        Step { gap, event, name: name.into() }
    }

    /// Telegrams that are no service of DP.
    fn odd<P: Process>(&mut self, model: &Model<P>) -> (String, Vec<u8>) {
        let sa = self.one_of(&[2, 3, 7, 9, 0, 127, model.address]);
        let da = self.one_of(&[model.address, model.address, model.address, 127, model.address ^ 1]);
        match self.random.u32(0..9) {
            0 => ("token".into(), vec![0xDC, da, sa]),
            1 => ("short acknowledgement".into(), vec![0xE5]),
            2 => {
                let length = self.random.usize(1..20);
                ("noise".into(), self.octets(length))
            }
            3 => {
                let code = self.one_of(&[0x49, 0x4E, 0x4F, 0x00, 0x08, 0x03, 0xC0]);
                (format!("{sa}: FC {code:02X} to {da}"), sd1(da, sa, code))
            }
            4 => {
                let code = self.one_of(&[0x40, 0x41, 0x42, 0x47, 0x48, 0x4A, 0x4B, 0x43, 0x45, 0x63, 0x75, 0x6D]);
                (format!("{sa}: FC {code:02X} to {da}"), sd1(da, sa, code))
            }
            5 => {
                let (dae, sae) = (self.one_of(&[0x3C, 0x7C, 0xBC, 0x00]), self.one_of(&[0x3E, 0x7E, 0xFE]));
                ("odd address extension".into(), sd2(da | 0x80, sa | 0x80, 0x6D, &[dae, sae]))
            }
            6 => {
                let (dx, sx) = self.one_of(&[(0x80, 0), (0, 0x80)]);
                ("one address extension".into(), sd2(da | dx, sa | sx, 0x6D, &[0x3C, 0x3E]))
            }
            7 => {
                let sap = self.one_of(&[55, 60, 61, 63, 58]);
                let length = self.random.usize(0..4);
                let du = self.octets(length);
                (format!("{sa}: SDN to SAP {sap} of {da}"), with_saps(da, sa, 0x46, sap, 62, &du))
            }
            _ => {
                let (code, sap) = (self.one_of(&[0x6D, 0x4D, 0x49, 0x4C]), self.one_of(&[60, 59]));
                (format!("{sa}: FC {code:02X} to SAP {sap} of {da}"), with_saps(da, sa, code, sap, 62, &[]))
            }
        }
    }

    /// A service of a master.
    fn request<P: Process>(&mut self, model: &Model<P>) -> (String, Vec<u8>) {
        let owner = MASTERS.iter().position(|it| *it == model.master);
        let cyclic = self.random.u32(0..100) < 60;
        let position = match (cyclic, owner) {
            (true, Some(owner)) if !self.chance(6) => owner,
            (true, _) => self.random.usize(0..2),
            (false, _) if self.chance(90) => self.random.usize(2..4),
            _ => self.random.usize(0..4),
        };
        let address = self.masters[position].address;
        let (name, saps, du) = if cyclic { self.class_1(model, address) } else { self.class_2(model, address) };
        let name = format!("{address}: {name}");
        let station = model.address;
        if saps.is_some_and(|(dsap, _)| dsap == 58) {
            let da = self.one_of(&[127, 127, station]);
            let code = self.one_of(&[0x46, 0x44]);
            return (name, with_saps(da, address, code, 58, 62, &du));
        }
        let first = self.chance(2);
        let priority = self.random.u8(0x0C..0x0E);
        let uncounted = self.chance(1);
        let lost = self.chance(3);
        let master = &mut self.masters[position];
        let fc = match master.fcb {
            _ if uncounted => 0x40 | priority,
            Some(fcb) if !first => 0x50 | u8::from(fcb) << 5 | priority,
            _ => 0x60 | priority,
        };
        if !uncounted && !lost {
            master.fcb = Some(fc & 0x20 == 0);
        }
        let octets = match saps {
            Some((dsap, ssap)) if du.len() == 6 && priority == 0x0C => {
                sd3(station | 0x80, address | 0x80, fc, &[&[dsap, ssap], du.as_slice()].concat())
            }
            Some((dsap, ssap)) => with_saps(station, address, fc, dsap, ssap, &du),
            None if du.is_empty() => sd1(station, address, fc),
            None if du.len() == 8 && priority == 0x0C => sd3(station, address, fc, &du),
            None => sd2(station, address, fc, &du),
        };
        master.last.clone_from(&octets);
        (name, octets)
    }

    /// A service of a class 1 master, mostly the one that leads on.
    fn class_1<P: Process>(&mut self, model: &Model<P>, address: u8) -> Plan {
        let ssap = if self.chance(2) { self.random.u8(0..64) } else { 62 };
        let own = address == model.master;
        let choice = self.random.u32(0..100);
        let (sap, name, du) = match (model.state, choice) {
            (State::WaitPrm, 0..=39) => (61, "Set_Prm", self.set_prm(model, true)),
            (State::WaitCfg, 0..=49) if own => (62, "Chk_Cfg", self.chk_cfg(model, true)),
            (State::DataExch, 0..=44) if own => return self.data_exchange(model),
            (State::DataExch, 45..=64) if own => return self.ms1(model),
            (State::DataExch, 65..=71) if own => {
                let command = if self.chance(80) {
                    self.one_of(&[0, 2, 8, 4, 0x20, 0x10, 0x30, 0x28, 0x0C])
                } else {
                    self.random.u8(..)
                };
                let group = self.one_of(&[0, 0, 1, 2, 0xFF]);
                let mut du = vec![command, group];
                if self.chance(3) {
                    du.push(0);
                }
                (58, "Global_Control", du)
            }
            _ => match self.random.u32(0..100) {
                0..=29 => (60, "Slave_Diag", self.nothing()),
                30..=37 => (59, "Get_Cfg", self.nothing()),
                38..=45 => (56, "RD_Inp", self.nothing()),
                46..=53 => (57, "RD_Outp", self.nothing()),
                54..=61 => (61, "Set_Prm", self.set_prm(model, false)),
                62..=67 => (62, "Chk_Cfg", self.chk_cfg(model, false)),
                68..=75 => return self.data_exchange(model),
                76..=79 => return self.ms1(model),
                80..=83 => (58, "Global_Control", vec![self.random.u8(..), 0]),
                84..=91 => (55, "Set_Slave_Add", self.set_slave_add(model)),
                92..=94 => (61, "unlock", vec![0x40, 0, 0, 0, 0x12, 0x34, 0]),
                95..=96 => (61, "min T_SDR", vec![0, 0, 0, self.random.u8(0..60), 0, 0, 0]),
                _ => (self.one_of(&[50, 52, 53, 54, 58, 63]), "closed SAP", self.octets(2)),
            },
        };
        (name.into(), Some((sap, ssap)), du)
    }

    /// An empty data unit, seldom one that is not.
    fn nothing(&mut self) -> Vec<u8> {
        if self.chance(4) { self.octets(1) } else { Vec::new() }
    }

    fn set_prm<P: Process>(&mut self, model: &Model<P>, good: bool) -> Vec<u8> {
        let [high, low] = model.table.ident.to_be_bytes();
        let watchdog = self.chance(50);
        let modes = self.one_of(&[0, 0, 0x30, 0x20]);
        let status = 0x80 | modes | u8::from(watchdog) << 3;
        let (factor_1, factor_2) = (self.random.u8(1..40), self.random.u8(1..6));
        let tsdr = self.one_of(&[0, 11, 11, 5, 30, 60, 255]);
        let group = self.one_of(&[0, 1, 1, 3, 0x80]);
        let mut du = vec![status, factor_1, factor_2, tsdr, high, low, group];
        let mut user = self.one_of(&model.table.user_parameters);
        if let Some(first) = user.first_mut() {
            let bits = self.one_of(&[0x80, 0xC0, 0xC4, 0x80, 0x40, 0x84, 0]);
            *first |= bits & model.table.free_bits[0];
        }
        if let Some(second) = user.get_mut(1) {
            *second |= self.one_of(&[0_u8, 1]) & model.table.free_bits[1];
        }
        du.extend(user);
        if good && self.chance(80) {
            return du;
        }
        match self.random.u32(0..10) {
            0 => du[5] ^= 1,
            1 => du.truncate(self.random.usize(0..7)),
            2 => du.extend([0xAA, 0xBB, 0xCC]),
            3 => du[1] = 0,
            4 => du[0] |= 1 << self.random.u8(0..3),
            5 => {
                let position = self.random.usize(0..du.len());
                du[position] ^= 1 << self.random.u8(0..8);
            }
            6 => du.resize(self.one_of(&[8, 9, 10]), 0),
            7 => du[0] &= 0x3F,
            _ => {}
        }
        du
    }

    fn chk_cfg<P: Process>(&mut self, model: &Model<P>, good: bool) -> Vec<u8> {
        let present = model.table.configurations[model.configuration].octets.clone();
        let mut octets = self.one_of(&model.table.configurations).octets;
        if self.chance(50) {
            octets = present;
        }
        if good && self.chance(90) {
            return octets;
        }
        match self.random.u32(0..6) {
            0 => octets.push(0),
            1 => octets.truncate(octets.len() - 1),
            2 => octets[0] ^= 1,
            3 => {
                let length = self.random.usize(1..20);
                octets = self.octets(length);
            }
            _ => {}
        }
        octets
    }

    fn set_slave_add<P: Process>(&mut self, model: &Model<P>) -> Vec<u8> {
        let [high, low] = model.table.ident.to_be_bytes();
        let lock = if self.chance(1) { 0xFF } else { 0 };
        let mut du = vec![self.one_of(&[5, 6, 8, 126, 127, 200, 100]), high, low, lock];
        match self.random.u32(0..10) {
            0 => du[1] ^= 0x80,
            1 => du.truncate(self.random.usize(0..4)),
            2 => du.extend([1, 2, 3]),
            _ => {}
        }
        du
    }

    fn data_exchange<P: Process>(&mut self, model: &Model<P>) -> Plan {
        let (outputs, _) = model.lengths();
        let length = match self.random.u32(0..100) {
            0 => outputs + 1,
            1 => self.random.usize(0..245),
            2..=4 => 0,
            _ => outputs,
        };
        let suggested = model.process.suggested_outputs(&mut self.random, outputs).filter(|_| length == outputs);
        let du = suggested.unwrap_or_else(|| self.octets(length));
        ("Data_Exchange".into(), None, du)
    }

    fn ms1<P: Process>(&mut self, model: &Model<P>) -> Plan {
        let ssap = if self.chance(5) { 54 } else { 51 };
        let poll = if model.ms1 == Job::Idle { 20 } else { 85 };
        if self.chance(poll) {
            return ("MS1 poll".into(), Some((51, ssap)), Vec::new());
        }
        let du = match self.random.u32(0..200) {
            0 => self.octets(4),
            1 => vec![0x5C, 1, 1, 0],
            _ => self.access(model),
        };
        ("MS1 request".into(), Some((51, ssap)), du)
    }

    /// A Read or Write.
    fn access<P: Process>(&mut self, model: &Model<P>) -> Vec<u8> {
        if let Some(du) = model.process.suggested_access(&mut self.random) {
            return du;
        }
        let slot = self.one_of(&[1, 1, 1, 1, 0, 0, 2, 255, 254]);
        let index = match self.random.u32(0..10) {
            0..=6 => self.random.u8(0..7),
            7..=8 => 255,
            _ => self.random.u8(..),
        };
        let mut du = if index == 255 {
            match self.random.u32(0..8) {
                0..=2 => vec![0x5F, slot & 1, 255, 4, 8, 0, 0xFD, 0xE8],
                3..=5 => vec![0x5E, slot & 1, 255, self.one_of(&[68, 240, 10])],
                6 => vec![0x5F, slot, 255, 4, self.one_of(&[8, 8, 7]), 0, 0xFD, self.one_of(&[0xE8, 0xE9, 0])],
                _ => [vec![0x5F, slot & 1, 255, 68, 8, 0, 0xFD, 0xE8], vec![0; 64]].concat(),
            }
        } else if self.random.bool() {
            vec![0x5E, slot, index, self.one_of(&[240, 240, 4, 1, 2, 60])]
        } else {
            let length = self.one_of(&[1, 2, 3, 4, 4, 8, 9, 240]);
            let data = self.octets(usize::from(length));
            [vec![0x5F, slot, index, length], data].concat()
        };
        match self.random.u32(0..40) {
            0 => du[3] = 0,
            1 => du[3] = 241,
            2 => du.truncate(self.random.usize(1..4)),
            3 if du.len() < 200 => du.push(0),
            4 if du[0] == 0x5F && du.len() > 5 => du.truncate(du.len() - 1),
            5 if du[0] == 0x5F && index != 255 && du.len() > 4 => du[4] = 0xEE,
            _ => {}
        }
        du
    }

    fn class_2<P: Process>(&mut self, model: &Model<P>, address: u8) -> Plan {
        let mine: Vec<(u8, u8, bool)> = (0..model.connections.len())
            .filter_map(|position| match &model.connections[position] {
                Connection::Bound { sa, ssap, job, .. } if *sa == address => {
                    Some((48 - u8::try_from(position).ok()?, *ssap, *job == Job::Idle))
                }
                _ => None,
            })
            .collect();
        if mine.is_empty() || self.chance(5) {
            if self.chance(15) {
                let du = self.nothing();
                return ("Slave_Diag".into(), Some((60, 62)), du);
            }
            let ssap = self.one_of(&[50, 50, 50, 50, 33]);
            return ("Initiate".into(), Some((49, ssap)), self.initiate());
        }
        let (mut sap, mut ssap, idle) = self.one_of(&mine);
        if self.chance(2) {
            sap = self.one_of(&[48, 47, 46, 0, 10]);
        }
        if self.chance(1) {
            ssap ^= 1;
        }
        if self.chance(if idle { 10 } else { 80 }) {
            return ("MS2 poll".into(), Some((sap, ssap)), Vec::new());
        }
        let (name, du) = match self.random.u32(0..100) {
            0..=1 => ("Abort", vec![0x58, 0, 0x20]),
            2 => ("unknown function", vec![self.one_of(&[0x57, 0x5C, 0xDE, 0x00, 0x47, 0x56]), 0, 0, 0]),
            3..=12 => ("Idle", if self.chance(5) { vec![0x48, 1, 2] } else { vec![0x48] }),
            13..=17 => ("Data_Transport", self.one_of(&[vec![0x51, 0, 0, 1, 7], vec![0x51, 0, 0, 0], vec![0x51, 1]])),
            _ => ("MS2 request", self.access(model)),
        };
        (name.into(), Some((sap, ssap)), du)
    }

    fn initiate(&mut self) -> Vec<u8> {
        let timeout = self.one_of(&[100_u16, 50, 150, 300]);
        let [high, low] = timeout.to_be_bytes();
        let profile = self.one_of(&[0, 0x97]);
        let mut du = vec![0x57, 0, 0, 0, high, low, 1, 0, 0, 0, profile, 0, 0, 2, 0, 2, 0, 0, 0, 0];
        match self.random.u32(0..40) {
            30..=33 => return self.odd_initiate(),
            0 => du.truncate(self.random.usize(0..20)),
            1 => du[13] = 3,
            2 => du[15] = 1,
            3 => {
                du[12] = 1;
                du[13] = 8;
                du.extend([1, 2, 3, 4, 5, 6]);
            }
            4 => {
                du[12] = 1;
                du[13] = 9;
            }
            5 => du[0] = 0x5E,
            6 => du.extend([0; 10]),
            7 => {
                let position = self.random.usize(16..20);
                du[position] = 1;
            }
            8 => {
                let position = self.random.usize(6..10);
                du[position] ^= 1;
            }
            _ => {}
        }
        du
    }

    /// An Initiate with any time, features, profile and addresses of any length.
    fn odd_initiate(&mut self) -> Vec<u8> {
        let timeout = self.one_of(&[0, 1, 99, 100, 101, 500, 0x7FFF, 0xFFFF]);
        let [high, low] = u16::to_be_bytes(timeout);
        let features = self.random.u16(..).to_be_bytes();
        let profile = self.octets(4);
        let (s_type, d_type) = (self.one_of(&[0, 0, 1, 2, 255]), self.one_of(&[0, 0, 0, 1]));
        let (s_len, d_len) = (self.one_of(&[0, 1, 2, 2, 3, 8, 20, 200]), self.one_of(&[2, 2, 2, 2, 0, 1, 3, 8]));
        let mut du = vec![0x57, self.random.u8(..), 0, 0, high, low];
        du.extend(features);
        du.extend(profile);
        du.extend([s_type, s_len, d_type, d_len]);
        let addresses = usize::from(s_len) + usize::from(d_len) + self.one_of(&[0, 0, 0, 1, 5]);
        let octets = self.octets(addresses);
        du.extend(octets);
        if self.random.bool() {
            let from = 16 + usize::from(s_len);
            du.iter_mut().skip(from).take(2).for_each(|octet| *octet = 0);
            du[6] |= 1;
        }
        let shorter = self.one_of(&[0, 0, 0, 1, 2]);
        du.truncate(du.len() - shorter);
        du
    }
}
