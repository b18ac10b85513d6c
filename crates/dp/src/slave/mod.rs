//! A passive DP station. profibus-wire 2 and 3.
//!
//! [`Slave`] joins the link layer's [`Responder`] to a [`Device`]. A request travels down as arguments, its reply comes back
//! as a return value, and nothing in between waits: what takes time is answered by the state of things now.

mod acyclic;
mod cfg;
mod device;
mod diag;
mod exchange;
mod ms1;
mod ms2;
mod prm;
mod state;

pub use device::{CfgFault, Device, Diagnosis, Dpv1Error, Features, Outputs, PrmFault, Relation};
pub use ms2::MAX_INITIATE_PDU;
pub use state::{ExchangeState, Fault, Owner, SlaveState, Watchdog};

use crate::link::{Accepted, Baud, BitTime, Indication, Listening, Reply, Responder, Station, Transmit};
use acyclic::AcyclicServer;
use ms2::Connection;
use profivac_wire::address::SetSlaveAdd;
use profivac_wire::control::Status;
use profivac_wire::{MAX_DU, Sap, Telegram};

/// The earliest start of an answer that a station may be told. profibus-wire 1.12.
const MIN_TSDR_TBIT: u8 = 11;

/// The highest address a slave can be given.
const MAX_ADDRESS: u8 = 125;

/// A passive DP station with `D` behind it and room for so many MS2 connections, at most 49.
#[derive(Clone, Debug)]
pub struct Slave<D, const CONNECTIONS: usize = 2> {
    responder: Responder,
    device: D,
    baud: Baud,
    state: SlaveState,
    /// min T_SDR in bit times.
    min_tsdr: u8,
    /// The outputs the process sees.
    outputs: [u8; MAX_DU],
    /// The outputs Sync holds back.
    held_outputs: [u8; MAX_DU],
    held_valid: bool,
    /// The inputs as sent last, or as frozen.
    inputs: [u8; MAX_DU],
    du: [u8; MAX_DU],
    ms1: AcyclicServer,
    ms2: [Connection; CONNECTIONS],
    now: BitTime,
}

impl<D: Device> Slave<D> {
    /// A slave at `address` that has just been switched on.
    pub fn new(device: D, address: u8, baud: Baud) -> Self {
        Self::with_connections(device, address, baud)
    }
}

impl<D: Device, const CONNECTIONS: usize> Slave<D, CONNECTIONS> {
    /// As [`Slave::new`], with the number of MS2 connections the type says.
    pub fn with_connections(device: D, address: u8, baud: Baud) -> Self {
        Self {
            responder: Responder::new(address),
            device,
            baud,
            state: SlaveState::POWER_UP,
            min_tsdr: MIN_TSDR_TBIT,
            outputs: [0; MAX_DU],
            held_outputs: [0; MAX_DU],
            held_valid: false,
            inputs: [0; MAX_DU],
            du: [0; MAX_DU],
            ms1: AcyclicServer::EMPTY,
            ms2: [const { Connection::FREE }; CONNECTIONS],
            now: BitTime(0),
        }
    }

    /// Power returns: the slave forgets masters, parameters and answers. Resetting the device is the caller's business.
    pub fn power_up(&mut self, address: u8) {
        self.enter_wait_prm(Fault::None);
        self.set_address(address);
        self.min_tsdr = MIN_TSDR_TBIT;
    }

    /// The bus was lost and found again, at `baud`: frame counts are forgotten and connections closed, what MS0 was doing goes
    /// on. A watched slave has lost its master before it could lose the rate. profibus-wire 3.6 and 3.2, transition 15.
    /// Times after this call are in bit times of `baud` and may begin anew.
    pub fn rate_found(&mut self, baud: Baud) {
        if self.watchdog_is_running() {
            self.enter_wait_prm(Fault::None);
        }
        self.baud = baud;
        self.set_address(self.responder.address());
    }

    /// Whether the response watchdog runs.
    pub fn watchdog_is_running(&self) -> bool {
        self.state.owner().is_some_and(|owner| owner.watchdog.is_some())
    }

    /// The application gives up data exchange or wants to be parameterised anew: profibus-wire 3.2, transitions 16 and
    /// 17.
    pub fn return_to_wait_prm(&mut self) {
        self.enter_wait_prm(Fault::None);
    }

    /// As [`Responder::forget_answer`], for whoever tests a master.
    pub const fn forget_answer(&mut self) {
        self.responder.forget_answer();
    }

    /// The device.
    pub const fn device(&self) -> &D {
        &self.device
    }

    /// The device, to let time pass or pressure change.
    pub const fn device_mut(&mut self) -> &mut D {
        &mut self.device
    }

    /// The state.
    pub const fn state(&self) -> &SlaveState {
        &self.state
    }

    /// The station address.
    pub const fn address(&self) -> u8 {
        self.responder.address()
    }

    /// min T_SDR in bit times.
    pub const fn min_tsdr_tbit(&self) -> u8 {
        self.min_tsdr
    }

    /// Which service answers what, profibus-wire 2.2.
    fn serve(&mut self, request: &Indication<'_>) -> Reply {
        match request.sap {
            Sap::Default => self.data_exchange(request),
            Sap::SlaveDiag => self.slave_diag(request),
            Sap::SetPrm => self.set_prm(request),
            Sap::ChkCfg => self.chk_cfg(request),
            Sap::GetCfg => self.get_cfg(request),
            Sap::RdInp => self.rd_inp(request),
            Sap::RdOutp => self.rd_outp(request),
            Sap::SetSlaveAdd => self.set_slave_add(request),
            Sap::Ms1 => self.ms1(request),
            Sap::ResourceManager => self.resource_manager(request),
            Sap::Ms2(sap) => self.ms2(sap, request),
            // An SDN service asked for as SRD, and access points the slave does not open: it raises no alarms, so it has no
            // extra access point to acknowledge them (profibus-wire 2.1).
            Sap::GlobalControl | Sap::SetExtPrm | Sap::Alarm | Sap::Other(_) => SERVICE_CLOSED,
        }
    }

    /// profibus-wire 1.11
    fn ident(&mut self) -> Reply {
        let Some(ident) = self.device.ident() else { return SERVICE_CLOSED };
        ident.emit(&mut self.du).map_or(Reply::Status(Status::UserError), Reply::Low)
    }

    /// profibus-wire 2.11. What does not fit is acknowledged and changes nothing (profibus-wire 10, point 15). The
    /// acknowledgement carries no address, so the new one may hold at once.
    fn set_slave_add(&mut self, request: &Indication<'_>) -> Reply {
        if !matches!(self.state, SlaveState::WaitPrm(_)) || !self.device.address_is_settable() {
            return SERVICE_CLOSED;
        }
        if let Ok(wanted) = SetSlaveAdd::parse(request.du)
            && wanted.ident == self.device.ident_number()
            && wanted.address <= MAX_ADDRESS
            && let Some(address) = self.device.set_address(&wanted)
        {
            self.set_address(address);
        }
        Reply::ShortAck
    }

    /// Nobody has spoken to the station under its new address. profibus-wire 1.9; free choice for MS2.
    fn set_address(&mut self, address: u8) {
        self.responder.set_address(address);
        self.ms2.iter_mut().for_each(Connection::close);
    }

    /// Every error-free request of the owner to this station restarts the watchdog, whatever the service, and so does a
    /// Global_Control that is accepted. profibus-wire 3.6 and 10, point 16.
    fn restart_watchdog(&mut self, sa: u8) {
        let now = self.now;
        if let Some(Owner { master, watchdog: Some(watchdog), .. }) = self.state.owner_mut()
            && *master == sa
        {
            watchdog.deadline = now + watchdog.period_tbit;
        }
    }

    /// Time has come to `now`: the watchdog or connections may expire, and the device may have something to report.
    fn elapse(&mut self, now: BitTime) {
        self.now = now;
        self.ms2.iter_mut().for_each(|connection| connection.elapse(now));
        if let Some(Owner { watchdog: Some(watchdog), .. }) = self.state.owner()
            && watchdog.deadline <= now
        {
            self.enter_wait_prm(Fault::None);
        }
        if self.device.take_diagnosis_change()
            && let SlaveState::DataExch(_, exchange) = &mut self.state
        {
            exchange.diag_flag = true;
        }
    }

    /// The only place where the state is assigned: entering and leaving data exchange are told to the device here, and MS1
    /// lives and dies with it.
    fn enter(&mut self, state: SlaveState) {
        let was = matches!(self.state, SlaveState::DataExch(..));
        let is = matches!(state, SlaveState::DataExch(..));
        self.state = state;
        if was || is {
            self.set_safe_outputs();
        }
        if was != is {
            self.ms1.clear();
            self.device.set_exchanging(is);
        }
    }

    /// Back to WAIT-PRM with safe outputs.
    fn enter_wait_prm(&mut self, fault: Fault) {
        self.enter(SlaveState::WaitPrm(fault));
    }
}

const SERVICE_CLOSED: Reply = Reply::Status(Status::ServiceNotActivated);
const NO_RESOURCE: Reply = Reply::Status(Status::NoResource);

impl<D: Device, const CONNECTIONS: usize> Station for Slave<D, CONNECTIONS> {
    fn telegram(&mut self, end: BitTime, telegram: &Telegram<'_>) -> Option<Transmit<'_>> {
        self.elapse(end);
        let Telegram::Data(frame) = telegram else { return None };
        let not_before = end + u64::from(self.min_tsdr);
        let accepted = self.responder.accept(frame);
        if !matches!(accepted, Accepted::Ignored) && frame.da == self.responder.address() {
            self.restart_watchdog(frame.sa);
        }
        match accepted {
            Accepted::Ignored => None,
            Accepted::Unconfirmed(request) => {
                self.unconfirmed(&request);
                None
            }
            Accepted::Repetition => Some(self.responder.repeat(not_before)),
            Accepted::LinkLayer(status) => self.responder.answer(frame, Reply::Status(status), &[], not_before),
            Accepted::Ident => {
                let reply = self.ident();
                self.responder.answer(frame, reply, &self.du, not_before)
            }
            Accepted::Confirmed(request) => {
                let reply = self.serve(&request);
                // The images are sent from where they lie.
                let du = match request.sap {
                    Sap::Default | Sap::RdInp => &self.inputs,
                    Sap::RdOutp => &self.outputs,
                    _ => &self.du,
                };
                self.responder.answer(frame, reply, du, not_before)
            }
        }
    }

    fn poll(&mut self, now: BitTime) -> Option<Transmit<'_>> {
        self.elapse(now);
        None
    }

    fn wake_at(&self) -> Option<BitTime> {
        let watchdog = self.state.owner().and_then(|owner| owner.watchdog).map(|watchdog| watchdog.deadline);
        self.ms2.iter().map(Connection::deadline).chain([watchdog]).flatten().min()
    }

    fn listening(&self) -> Listening {
        Listening::Own(self.responder.address())
    }
}
