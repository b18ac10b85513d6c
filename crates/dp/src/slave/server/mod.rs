//! The services of a slave without its link layer: state, images and the dispatch by access point. profibus-wire 2.2 and 3.
//!
//! A request comes as an argument, its [`Reply`] is the return value and borrows the octets from where they lie. Nothing
//! waits: the server answers from its present state.

mod cfg;
mod diag;
mod exchange;
mod ms1;
mod ms2;
mod prm;

pub(super) use exchange::Exchange;
pub use ms2::MAX_INITIATE_PDU;

use super::acyclic::AcyclicServer;
use super::{Device, Fault, Owner, SlaveState};
use crate::link::{Baud, BitTime, Indication, Reply, Responder};
use ms2::Connection;
use profivac_wire::acyclic::AlarmAck;
use profivac_wire::address::SetSlaveAdd;
use profivac_wire::control::Status;
use profivac_wire::{MAX_DU, Sap};

/// The least min T_SDR that a master can set. profibus-wire 1.12.
pub(super) const MIN_TSDR_TBIT: u8 = 11;

/// The highest address that a master can set.
const MAX_ADDRESS: u8 = 125;

/// RS.
const SERVICE_CLOSED: Reply<'static> = Reply::Status(Status::ServiceNotActivated);

/// RR.
const NO_RESOURCE: Reply<'static> = Reply::Status(Status::NoResource);

/// A reply with a data unit that was emitted into `du`; UE if that failed.
fn prepared<E>(du: &[u8; MAX_DU], emitted: Result<usize, E>) -> Reply<'_> {
    match emitted.ok().and_then(|length| du.get(..length)) {
        Some(du) => Reply::Low(du),
        None => Reply::Status(Status::UserError),
    }
}

/// The services of a slave with device `D`.
#[derive(Clone, Debug)]
pub(super) struct Server<D, const CONNECTIONS: usize> {
    pub(super) device: D,
    baud: Baud,
    pub(super) state: SlaveState,
    /// min T_SDR in bit times.
    pub(super) min_tsdr: u8,
    /// The outputs that the process has.
    outputs: [u8; MAX_DU],
    /// They come from the master; otherwise they are safe.
    outputs_valid: bool,
    /// The outputs that Sync holds back.
    held_outputs: [u8; MAX_DU],
    held_valid: bool,
    /// The inputs as sent last, or as frozen.
    inputs: [u8; MAX_DU],
    du: [u8; MAX_DU],
    ms1: AcyclicServer,
    /// The acknowledgement over SAP 50 whose response waits.
    acknowledged: Option<AlarmAck>,
    ms2: [Connection; CONNECTIONS],
    now: BitTime,
}

impl<D: Device, const CONNECTIONS: usize> Server<D, CONNECTIONS> {
    pub(super) fn new(device: D, baud: Baud) -> Self {
        Self {
            device,
            baud,
            state: SlaveState::POWER_UP,
            min_tsdr: MIN_TSDR_TBIT,
            outputs: [0; MAX_DU],
            outputs_valid: false,
            held_outputs: [0; MAX_DU],
            held_valid: false,
            inputs: [0; MAX_DU],
            du: [0; MAX_DU],
            ms1: AcyclicServer::EMPTY,
            acknowledged: None,
            ms2: [const { Connection::FREE }; CONNECTIONS],
            now: BitTime(0),
        }
    }

    /// Executes a request: each access point has one service, profibus-wire 2.2.
    #[inline]
    pub(super) fn serve(&mut self, request: &Indication<'_>, responder: &mut Responder) -> Reply<'_> {
        match request.sap {
            Sap::Default => self.data_exchange(request),
            Sap::SlaveDiag => self.slave_diag(request),
            Sap::SetPrm => self.set_prm(request),
            Sap::ChkCfg => self.chk_cfg(request),
            Sap::GetCfg => self.get_cfg(request),
            Sap::RdInp => self.rd_inp(request),
            Sap::RdOutp => self.rd_outp(request),
            Sap::SetSlaveAdd => self.set_slave_add(request, responder),
            Sap::Ms1 => self.ms1(request),
            Sap::ResourceManager => self.resource_manager(request),
            Sap::Ms2(sap) => self.ms2(sap, request),
            Sap::Alarm => self.alarm(request),
            // Global_Control is an SDN service and not answered as SRD. The slave does not open the others.
            Sap::GlobalControl | Sap::SetExtPrm | Sap::Other(_) => SERVICE_CLOSED,
        }
    }

    /// profibus-wire 1.11
    pub(super) fn ident(&mut self) -> Reply<'_> {
        let Some(ident) = self.device.ident() else { return SERVICE_CLOSED };
        let emitted = ident.emit(&mut self.du);
        prepared(&self.du, emitted)
    }

    /// profibus-wire 2.11. The slave acknowledges a request that does not fit and changes nothing (profibus-wire 10,
    /// point 15). The acknowledgement carries no address, so the new one may be valid at once.
    fn set_slave_add(&mut self, request: &Indication<'_>, responder: &mut Responder) -> Reply<'static> {
        if !matches!(self.state, SlaveState::WaitPrm(_)) || !self.device.address_is_settable() {
            return SERVICE_CLOSED;
        }
        if let Ok(wanted) = SetSlaveAdd::parse(request.du)
            && wanted.ident == self.device.ident_number()
            && wanted.address <= MAX_ADDRESS
            && let Some(address) = self.device.set_address(&wanted)
        {
            responder.set_address(address);
            self.close_connections();
        }
        Reply::ShortAck
    }

    /// chosen: MS2 connections end with the address.
    pub(super) fn close_connections(&mut self) {
        self.ms2.iter_mut().for_each(Connection::close);
    }

    /// Restarts the watchdog: every error-free request of the owner to this station does, for any service, and every
    /// accepted Global_Control. profibus-wire 3.6 and 10, point 16.
    #[inline]
    pub(super) fn restart_watchdog(&mut self, sa: u8) {
        let now = self.now;
        if let Some(Owner { master, watchdog: Some(watchdog), .. }) = self.state.owner_mut()
            && *master == sa
        {
            watchdog.deadline = now + watchdog.period_tbit;
        }
    }

    /// Advances the time to `now`: watchdog and connections may expire, and the device may have a new diagnosis.
    #[inline]
    pub(super) fn elapse(&mut self, now: BitTime) {
        self.now = now;
        self.ms2.iter_mut().for_each(|connection| connection.elapse(now));
        if let Some(Owner { watchdog: Some(watchdog), .. }) = self.state.owner()
            && watchdog.deadline <= now
        {
            self.enter_wait_prm(Fault::None);
        }
        self.note_diagnosis_change();
    }

    /// A new diagnosis of the device is announced.
    #[inline]
    fn note_diagnosis_change(&mut self) {
        if self.device.take_diagnosis_change()
            && let SlaveState::DataExch(_, exchange) = &mut self.state
        {
            exchange.diag_flag = true;
        }
    }

    /// When [`elapse`](Self::elapse) has something to do.
    pub(super) fn wake_at(&self) -> Option<BitTime> {
        let watchdog = self.state.owner().and_then(|owner| owner.watchdog).map(|watchdog| watchdog.deadline);
        self.ms2.iter().map(Connection::deadline).chain([watchdog]).flatten().min()
    }

    /// Enters a state. This is the only place that assigns the state: here the device learns that data exchange begins or
    /// ends, and MS1 ends with it.
    pub(super) fn enter(&mut self, state: SlaveState) {
        let was = self.state.is_exchanging();
        let is = state.is_exchanging();
        self.state = state;
        if was || is {
            self.set_safe_outputs();
        }
        if was != is {
            self.ms1.clear();
            self.acknowledged = None;
            self.device.set_exchanging(is);
        }
    }

    /// Back to WAIT-PRM with safe outputs.
    pub(super) fn enter_wait_prm(&mut self, fault: Fault) {
        self.enter(SlaveState::WaitPrm(fault));
    }
}
