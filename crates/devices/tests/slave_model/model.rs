//! The slave as `docs/spec` describes it: layer 2 and DP-V0. One function for each service.
//!
//! Where `docs/spec` leaves a point open, the model has the behaviour of the slave, and the point is a row of
//! [`crate::slave_model::open_points::OPEN`]; `open(N)` beside the code names the row.

use crate::slave_model::acyclic::{Connection, Job};
use crate::slave_model::process::{Process, Refusal};
use crate::slave_model::tables::Table;
use crate::slave_model::telegram::{Frame, sd1, sd2, with_saps};
use std::collections::BTreeMap;

/// The states of section 3.1, without Power-On, in which a slave is silent.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum State {
    WaitPrm,
    WaitCfg,
    DataExch,
}

/// An answer before its addresses.
#[derive(Clone, Debug)]
pub enum Reply {
    /// `E5`.
    Sc,
    /// A telegram without data, with this response code.
    Status(u8),
    /// Data with this response code.
    Data(u8, Vec<u8>),
}

pub const RR: Reply = Reply::Status(0x02);
pub const RS: Reply = Reply::Status(0x03);
/// Reply data, low and high.
pub const DL: u8 = 0x08;
const DH: u8 = 0x0A;
/// No master.
pub const NONE: u8 = 0xFF;
/// max T_SDR at 1.5 Mbit/s. Section 1.12.
const MAX_TSDR: u8 = 150;
/// 10 ms at 1.5 Mbit/s.
pub const TEN_MS: u64 = 15_000;

/// The device-dependent part of the diagnosis.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct DeviceDiagnosis {
    pub event: bool,
    pub static_diag: bool,
    pub blocks: Vec<u8>,
}

/// A request behind layer 2.
#[derive(Clone, Debug)]
pub struct Request {
    pub sa: u8,
    pub saps: Option<(u8, u8)>,
    pub du: Vec<u8>,
}

/// The model of a slave.
#[derive(Clone, Debug)]
pub struct Model<P> {
    pub table: Table,
    pub process: P,
    pub address: u8,
    /// SA, FCB and answer of the last counted request. Section 1.9.
    memory: Option<(u8, bool, Option<Vec<u8>>)>,
    pub state: State,
    pub master: u8,
    prm_fault: bool,
    cfg_fault: bool,
    not_supported: bool,
    /// Watchdog time and the moment of expiry.
    pub watchdog: Option<(u64, u64)>,
    pub min_tsdr: u8,
    group: u8,
    fail_safe: bool,
    pub dpv1_enable: bool,
    /// The place of the configuration in the table.
    pub configuration: usize,
    /// Sync: outputs that are held back.
    sync: bool,
    held: Option<Vec<u8>>,
    /// Outputs at the process; `None` is the safe state.
    active: Option<Vec<u8>>,
    frozen: Option<Vec<u8>>,
    pub diagnosis: DeviceDiagnosis,
    pub diag_flag: bool,
    pub ms1: Job,
    /// I&M0 was called on MS1.
    pub ms1_called: bool,
    pub connections: Vec<Connection>,
    /// Counts of the services, states and errors that came.
    pub reached: BTreeMap<&'static str, u64>,
}

impl<P: Process> Model<P> {
    /// After power-up.
    pub fn new(table: Table, process: P, address: u8) -> Self {
        let configuration = table.default_configuration;
        Self {
            table,
            process,
            address,
            memory: None,
            state: State::WaitPrm,
            master: NONE,
            prm_fault: false,
            cfg_fault: false,
            not_supported: false,
            watchdog: None,
            min_tsdr: 11,
            group: 0,
            fail_safe: false,
            dpv1_enable: false,
            configuration,
            sync: false,
            held: None,
            active: None,
            frozen: None,
            diagnosis: DeviceDiagnosis::default(),
            diag_flag: false,
            ms1: Job::Idle,
            ms1_called: false,
            connections: vec![Connection::Free; 2],
            reached: BTreeMap::new(),
        }
    }

    /// Power returns. The configuration that the device has is its own matter.
    pub fn power_up(&mut self) {
        let fresh = Self::new(self.table.clone(), self.process.clone(), self.address);
        let (diagnosis, configuration) = (self.diagnosis.clone(), self.configuration);
        let reached = std::mem::take(&mut self.reached);
        *self = fresh;
        (self.diagnosis, self.configuration, self.reached) = (diagnosis, configuration, reached);
        self.process.outputs(None);
        self.reach("power-up");
    }

    /// The bus was lost and found again. profibus-wire 3.2, transition 15.
    pub fn rate_found(&mut self) {
        self.reach("rate found");
        if self.watchdog.is_some() {
            self.leave();
        }
        self.memory = None;
        self.connections.fill(Connection::Free);
    }

    /// The application leaves the master. profibus-wire 3.2, transitions 16 and 17.
    pub fn return_to_wait_prm(&mut self) {
        self.reach("application leaves the master");
        self.leave();
    }

    /// The application has another diagnosis. Section 3.3.
    pub fn set_diagnosis(&mut self, diagnosis: DeviceDiagnosis) {
        self.reach("diagnosis changed");
        self.diagnosis = diagnosis;
        self.diag_flag = self.state == State::DataExch;
    }

    /// Counts what was reached.
    pub fn reach(&mut self, what: &'static str) {
        *self.reached.entry(what).or_default() += 1;
    }

    /// Output and input octets of the configuration.
    pub fn lengths(&self) -> (usize, usize) {
        let it = &self.table.configurations[self.configuration];
        (it.outputs, it.inputs)
    }

    /// The timers up to `now`. Sections 3.6 and 4.9.
    pub fn expire(&mut self, now: u64) {
        if let Some((_, deadline)) = self.watchdog
            && deadline <= now
        {
            self.reach("watchdog expired");
            self.leave();
        }
        self.expire_connections(now);
    }

    /// The next moment at which a timer expires.
    pub fn deadlines(&self) -> Vec<u64> {
        let watchdog = self.watchdog.map(|(_, deadline)| deadline);
        let connections = self.connections.iter().filter_map(Connection::deadline);
        connections.chain(watchdog).collect()
    }

    /// Layer 2: what happens with a valid telegram, and the answer. Sections 1.3 to 1.9.
    pub fn frame(&mut self, now: u64, frame: &Frame) -> Option<Vec<u8>> {
        let (da, sa) = (frame.da & 0x7F, frame.sa & 0x7F);
        let (request, alternative) = (frame.fc & 0x40 != 0, frame.fc & 0x80 != 0);
        if !request || alternative {
            self.reach("FC of a response ignored");
            return None;
        }
        if sa == self.address || sa == 127 || (da != self.address && da != 127) {
            self.reach("address ignored");
            return None;
        }
        let request = self.request(frame);
        let (code, fcb, fcv) = (frame.fc & 0x0F, frame.fc & 0x20 != 0, frame.fc & 0x10 != 0);
        if matches!(code, 0x4 | 0x6) {
            self.sdn(now, sa, request.as_ref(), da == self.address);
            return None;
        }
        if da == 127 {
            self.reach("broadcast without SDN ignored");
            return None;
        }
        if !matches!(code, 0x3 | 0x5 | 0x9 | 0xC | 0xD | 0xE | 0xF) {
            self.reach("function code ignored");
            return None;
        }
        if sa == self.master {
            self.trigger(now);
        }
        if matches!(code, 0x9 | 0xE | 0xF) {
            return Some(self.link_service(code, sa));
        }
        if fcv {
            if let Some((memory_sa, memory_fcb, Some(answer))) = &self.memory
                && (*memory_sa, *memory_fcb) == (sa, fcb)
            {
                let answer = answer.clone();
                self.reach("repetition");
                return Some(answer);
            }
            self.memory = Some((sa, fcb, None));
        } else if fcb {
            self.reach("first request");
            self.memory = Some((sa, true, None));
        } else {
            self.reach("uncounted request");
        }
        let address = self.address;
        let reply = match &request {
            // DP has no SDA: section 1.8.
            _ if matches!(code, 0x3 | 0x5) => {
                self.reach("SDA");
                RS
            }
            None => {
                self.reach("odd address extension");
                RS
            }
            Some(request) => self.confirmed(now, request),
        };
        let answer = self.encode(&reply, address, frame.sa, request.and_then(|it| it.saps));
        if (fcv || fcb)
            && let Some(memory) = &mut self.memory
        {
            memory.2 = Some(answer.clone());
        }
        Some(answer)
    }

    /// The service access points, or `None` if the address extensions are odd. Section 1.3.
    fn request(&self, frame: &Frame) -> Option<Request> {
        let extended = (frame.da & 0x80 != 0, frame.sa & 0x80 != 0);
        let (saps, du) = match (extended, frame.data.as_slice()) {
            ((false, false), du) => (None, du),
            // open(11): 63 is the global SAP, which no answer can have.
            ((true, true), [dae, sae, du @ ..]) if dae & 0xC0 == 0 && *sae < 63 => (Some((*dae, *sae)), du),
            _ => return None,
        };
        Some(Request { sa: frame.sa & 0x7F, saps, du: du.to_vec() })
    }

    /// FDL status, Ident and LSAP status. Section 1.11.
    fn link_service(&mut self, code: u8, sa: u8) -> Vec<u8> {
        match (code, self.table.ident_strings.clone()) {
            (0x9, _) => {
                self.reach("FDL status");
                sd1(sa, self.address, 0x00)
            }
            (0xE, Some(strings)) => {
                self.reach("Ident");
                let mut du: Vec<u8> = strings.iter().map(|it| u8::try_from(it.len()).expect("short")).collect();
                strings.iter().for_each(|it| du.extend(it.as_bytes()));
                sd2(sa, self.address, DL, &du)
            }
            _ => {
                self.reach("LSAP status or Ident refused");
                sd1(sa, self.address, 0x03)
            }
        }
    }

    /// Addresses of an answer: everything is swapped. Section 1.3.
    fn encode(&self, reply: &Reply, address: u8, sa: u8, saps: Option<(u8, u8)>) -> Vec<u8> {
        let sa = sa & 0x7F;
        match (reply, saps) {
            (Reply::Sc, _) => vec![0xE5],
            (Reply::Status(code), _) => sd1(sa, address, *code),
            (Reply::Data(code, du), Some((dsap, ssap))) => with_saps(sa, address, *code, ssap, dsap, du),
            (Reply::Data(code, du), None) if du.is_empty() => sd1(sa, address, *code),
            (Reply::Data(code, du), None) => sd2(sa, address, *code, du),
        }
    }

    /// Any request of the lock master restarts the watchdog. Section 3.6.
    fn trigger(&mut self, now: u64) {
        if let Some((time, deadline)) = &mut self.watchdog {
            *deadline = now + *time;
        }
    }

    /// Services with an answer. Sections 2.1 and 2.2.
    fn confirmed(&mut self, now: u64, request: &Request) -> Reply {
        let Some((dsap, ssap)) = request.saps else { return self.data_exchange(now, request) };
        match dsap {
            0..=49 => self.ms2(now, request, dsap, ssap),
            51 => self.ms1(now, request),
            55 => self.set_slave_add(request),
            56 => self.rd_inp(request),
            57 => self.rd_outp(request),
            59 => self.get_cfg(request),
            60 => self.slave_diag(request),
            61 => self.set_prm(now, request),
            62 => self.chk_cfg(request),
            _ => {
                self.reach("SAP not activated");
                RS
            }
        }
    }

    /// Section 2.3.
    fn slave_diag(&mut self, request: &Request) -> Reply {
        if !request.du.is_empty() {
            self.reach("Slave_Diag with data");
            return RR;
        }
        self.reach(match self.state {
            State::WaitPrm => "Slave_Diag in Wait_Prm",
            State::WaitCfg => "Slave_Diag in Wait_Cfg",
            State::DataExch if request.sa == self.master => "Slave_Diag of the owner",
            State::DataExch => "Slave_Diag of another master",
        });
        let bit = |set: bool, bit: u8| u8::from(set) << bit;
        let status_1 = bit(self.state != State::DataExch, 1)
            | bit(self.cfg_fault, 2)
            | bit(self.diagnosis.event, 3)
            | bit(self.not_supported, 4)
            | bit(self.prm_fault, 6);
        let status_2 = bit(self.state == State::WaitPrm, 0)
            | bit(self.diagnosis.static_diag, 1)
            | bit(true, 2)
            | bit(self.watchdog.is_some(), 3)
            | bit(self.frozen.is_some(), 4)
            | bit(self.sync, 5);
        for (set, what) in [
            (self.cfg_fault, "diagnosis with Cfg_Fault"),
            (self.diagnosis.event, "diagnosis with Ext_Diag"),
            (self.not_supported, "diagnosis with Not_Supported"),
            (self.prm_fault, "diagnosis with Prm_Fault"),
            (self.diagnosis.static_diag, "diagnosis with Stat_Diag"),
            (self.watchdog.is_some(), "diagnosis with WD_On"),
            (self.frozen.is_some(), "diagnosis with Freeze_Mode"),
            (self.sync, "diagnosis with Sync_Mode"),
        ] {
            if set {
                self.reach(what);
            }
        }
        let [high, low] = self.table.ident.to_be_bytes();
        let mut du = vec![status_1, status_2, 0, self.master, high, low];
        du.extend(&self.diagnosis.blocks);
        if request.sa == self.master && !self.diagnosis.static_diag {
            self.diag_flag = false;
        }
        Reply::Data(DL, du)
    }

    /// Section 2.7.
    fn get_cfg(&mut self, request: &Request) -> Reply {
        if !request.du.is_empty() {
            self.reach("Get_Cfg with data");
            return RR;
        }
        self.reach("Get_Cfg");
        Reply::Data(DL, self.table.configurations[self.configuration].octets.clone())
    }

    /// The evaluation order of profibus-wire 2.4; profibus-wire 3.2, transitions 3 to 7.
    fn set_prm(&mut self, now: u64, request: &Request) -> Reply {
        let du = request.du.as_slice();
        if self.master != NONE && request.sa != self.master {
            self.reach("Set_Prm of another master");
            return Reply::Sc;
        }
        let [status, factor_1, factor_2, tsdr, high, low, group, user @ ..] = du else {
            return self.prm_fault("Set_Prm too short");
        };
        let (lock, unlock) = (status & 0x80 != 0, status & 0x40 != 0);
        let tsdr = (*tsdr != 0).then_some((*tsdr).clamp(11, MAX_TSDR));
        if unlock {
            self.reach("Set_Prm unlocks");
            self.leave();
            return Reply::Sc;
        }
        if !lock {
            self.reach("Set_Prm changes min T_SDR only");
            self.min_tsdr = tsdr.unwrap_or(self.min_tsdr);
            return Reply::Sc;
        }
        if u16::from_be_bytes([*high, *low]) != self.table.ident {
            return self.prm_fault("Set_Prm with another ident number");
        }
        let dpv1 = [0, 1, 2].map(|it| user.get(it).copied().unwrap_or(0));
        if self.table.dpv1 {
            if matches!(user.len(), 1 | 2) {
                return self.prm_fault("Set_Prm of 8 or 9 octets");
            }
            if status & 0x07 != 0 || dpv1[0] & 0x18 != 0 || dpv1[1] & 0x02 != 0 || dpv1[2] & 0x60 != 0 {
                return self.prm_fault("Set_Prm with reserved bits");
            }
        }
        let watchdog = status & 0x08 != 0;
        if watchdog && (*factor_1 == 0 || *factor_2 == 0) {
            return self.prm_fault("Set_Prm with a watchdog factor 0");
        }
        if !self.process.set_prm(&self.table, user) {
            return self.prm_fault("Set_Prm with wrong user parameters");
        }
        self.reach(if self.state == State::DataExch { "Set_Prm in Data_Exch" } else { "Set_Prm ok" });
        self.leave();
        let dpv1 = if self.table.dpv1 { dpv1 } else { [0; 3] };
        let base = if dpv1[0] & 0x04 != 0 { TEN_MS / 10 } else { TEN_MS };
        let time = base * u64::from(*factor_1) * u64::from(*factor_2);
        self.not_supported = (status & 0x20 != 0 && !self.table.sync) || (status & 0x10 != 0 && !self.table.freeze);
        self.watchdog = watchdog.then_some((time, now + time));
        self.min_tsdr = tsdr.unwrap_or(self.min_tsdr);
        self.group = *group;
        self.fail_safe = dpv1[0] & 0x40 != 0;
        self.dpv1_enable = dpv1[0] & 0x80 != 0;
        self.master = request.sa;
        self.state = State::WaitCfg;
        Reply::Sc
    }

    /// Transition 4.
    fn prm_fault(&mut self, why: &'static str) -> Reply {
        self.reach(why);
        self.leave();
        self.prm_fault = true;
        Reply::Sc
    }

    /// profibus-wire 2.6; profibus-wire 3.2, transitions 8 to 11.
    fn chk_cfg(&mut self, request: &Request) -> Reply {
        if self.state == State::WaitPrm || request.sa != self.master {
            self.reach("Chk_Cfg ignored");
            return Reply::Sc;
        }
        let Some(index) = self.process.chk_cfg(&self.table, &request.du) else {
            self.reach("Chk_Cfg wrong");
            self.leave();
            self.cfg_fault = true;
            return Reply::Sc;
        };
        let again = self.state == State::DataExch;
        self.reach(if again { "Chk_Cfg in Data_Exch" } else { "Chk_Cfg ok" });
        if again && index == self.configuration {
            return Reply::Sc;
        }
        // open(9): another configuration begins the exchange again.
        self.configuration = index;
        self.state = State::DataExch;
        // open(4): an event or static diagnosis is announced from the first exchange on.
        self.diag_flag = self.diagnosis.event || self.diagnosis.static_diag;
        self.safe();
        self.process.begin_exchange();
        Reply::Sc
    }

    /// Section 2.8.
    fn data_exchange(&mut self, now: u64, request: &Request) -> Reply {
        if self.state != State::DataExch || request.sa != self.master {
            self.reach("Data_Exchange refused");
            return RS;
        }
        let (outputs, _) = self.lengths();
        let du = &request.du;
        let fits = if du.len() == outputs {
            self.reach("Data_Exchange");
            if self.sync {
                self.reach("outputs held by Sync");
                self.held = Some(du.clone());
            } else {
                self.apply(now, Some(du.clone()));
            }
            true
        } else if du.is_empty() && self.fail_safe {
            self.reach("Data_Exchange in Clear with Fail_Safe");
            self.safe_in_exchange();
            true
        } else {
            self.reach("Data_Exchange with a wrong length");
            self.process.rewind();
            false
        };
        let inputs = self.inputs();
        let reply = match (inputs.is_empty(), self.diag_flag) {
            (true, false) => Reply::Sc,
            (_, true) => {
                self.reach("Data_Exchange with DH");
                Reply::Data(DH, inputs)
            }
            (_, false) => Reply::Data(DL, inputs),
        };
        if !fits {
            self.leave();
        }
        reply
    }

    /// The inputs, frozen or fresh.
    fn inputs(&mut self) -> Vec<u8> {
        let (_, inputs) = self.lengths();
        self.frozen.clone().unwrap_or_else(|| self.process.inputs(inputs))
    }

    /// Outputs reach the process.
    fn apply(&mut self, _now: u64, outputs: Option<Vec<u8>>) {
        self.process.outputs(outputs.as_deref());
        self.active = outputs;
    }

    /// Section 2.10.
    fn rd_inp(&mut self, request: &Request) -> Reply {
        if self.state != State::DataExch {
            self.reach("RD_Inp refused");
            return RS;
        }
        if !request.du.is_empty() {
            self.reach("RD_Inp with data");
            return RR;
        }
        self.reach("RD_Inp");
        let inputs = self.inputs();
        if inputs.is_empty() { Reply::Sc } else { Reply::Data(DL, inputs) }
    }

    /// Section 2.10.
    fn rd_outp(&mut self, request: &Request) -> Reply {
        if self.state != State::DataExch {
            self.reach("RD_Outp refused");
            return RS;
        }
        if !request.du.is_empty() {
            self.reach("RD_Outp with data");
            return RR;
        }
        self.reach("RD_Outp");
        let (outputs, _) = self.lengths();
        let active = self.active.clone().unwrap_or_else(|| vec![0; outputs]);
        if active.is_empty() { Reply::Sc } else { Reply::Data(DL, active) }
    }

    /// Section 2.11.
    fn set_slave_add(&mut self, request: &Request) -> Reply {
        if self.state != State::WaitPrm || !self.table.address_settable {
            self.reach("Set_Slave_Add refused");
            return RS;
        }
        let &[address, high, low, lock, ..] = request.du.as_slice() else {
            self.reach("Set_Slave_Add too short");
            return Reply::Sc;
        };
        if address > 125 || u16::from_be_bytes([high, low]) != self.table.ident {
            self.reach("Set_Slave_Add without effect");
            return Reply::Sc;
        }
        if self.process.set_address(address, lock != 0) {
            self.reach("Set_Slave_Add");
            // open(6): connections end with the address; so they do if it stays the same.
            self.address = address;
            self.memory = None;
            self.connections.fill(Connection::Free);
        } else {
            self.reach("Set_Slave_Add without effect");
        }
        Reply::Sc
    }

    /// An unconfirmed request: Global_Control only. Section 2.9.
    fn sdn(&mut self, now: u64, sa: u8, request: Option<&Request>, to_this: bool) {
        if to_this && sa == self.master {
            self.trigger(now);
        }
        let Some(Request { saps: Some((58, _)), du, .. }) = request else {
            self.reach("SDN ignored");
            return;
        };
        // open(7): octets behind the second one are ignored.
        let &[command, select, ref rest @ ..] = du.as_slice() else {
            self.reach("Global_Control too short");
            return;
        };
        if !rest.is_empty() {
            self.reach("Global_Control too long");
        }
        if self.state != State::DataExch || sa != self.master {
            self.reach("Global_Control refused");
            return;
        }
        if select != 0 && select & self.group == 0 {
            self.reach("Global_Control for another group");
            return;
        }
        self.trigger(now);
        self.global_control(now, command);
    }

    /// Section 2.9.
    fn global_control(&mut self, now: u64, command: u8) {
        let bit = |number: u8| command & (1 << number) != 0;
        let (clear, unfreeze, freeze, unsync, sync) = (bit(1), bit(2), bit(3), bit(4), bit(5));
        if command & 0xC1 != 0 {
            self.reach("Global_Control with reserved bits");
            self.not_support();
        }
        if (sync && !unsync && !self.table.sync) || (freeze && !unfreeze && !self.table.freeze) {
            self.reach("Global_Control that the device does not support");
            self.not_support();
        }
        if clear {
            self.reach("Clear_Data");
            self.safe_in_exchange();
        }
        if self.table.sync {
            if unsync {
                self.reach("Unsync");
                self.transfer(now);
                self.sync = false;
            } else if sync {
                self.reach("Sync");
                self.transfer(now);
                self.sync = true;
            }
        }
        if self.table.freeze {
            if unfreeze {
                self.reach("Unfreeze");
                self.frozen = None;
            } else if freeze {
                self.reach("Freeze");
                let (_, inputs) = self.lengths();
                self.frozen = Some(self.process.inputs(inputs));
            }
        }
    }

    /// open(3): Not_Supported is announced, each time; the modes are not.
    fn not_support(&mut self) {
        self.diag_flag = true;
        self.not_supported = true;
    }

    /// The outputs that Sync held reach the process.
    fn transfer(&mut self, now: u64) {
        if let Some(held) = self.held.take() {
            self.apply(now, Some(held));
        }
    }

    /// Safe outputs during exchange: what Sync holds is dropped.
    fn safe_in_exchange(&mut self) {
        self.held = None;
        self.apply(0, None);
    }

    /// The entry of Data_Exch: safe outputs, no modes.
    fn safe(&mut self) {
        self.sync = false;
        self.frozen = None;
        self.safe_in_exchange();
    }

    /// Wait_Prm without a master: the end of every relation, transitions 4, 5, 13, 14, 16.
    pub fn leave(&mut self) {
        if self.state == State::DataExch {
            self.process.end_exchange();
        }
        self.safe();
        self.state = State::WaitPrm;
        self.master = NONE;
        self.watchdog = None;
        self.diag_flag = false;
        (self.prm_fault, self.cfg_fault, self.not_supported) = (false, false, false);
        (self.fail_safe, self.dpv1_enable, self.group) = (false, false, 0);
        self.ms1 = Job::Idle;
        self.ms1_called = false;
    }

    /// A refusal as a negative response. Section 4.1.2.
    pub fn negative(function: u8, refusal: Refusal) -> Vec<u8> {
        vec![function | 0x80, 0x80, refusal.0, refusal.1]
    }
}
