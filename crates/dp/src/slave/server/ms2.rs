//! MS2: connections of class 2 masters, in any state of MS0. profibus-wire 4.6 to 4.10.
//!
//! The resource manager on SAP 49 answers an Initiate at once with the access point of the connection; everything else
//! happens there. The reference's states RESERVED and JOB last no longer than the request that enters them, because the slave
//! executes it at once; the rest of its table are the four phases of [`ConnectionState`].

use super::{NO_RESOURCE, SERVICE_CLOSED, Server, prepared};
use crate::link::{Baud, BitTime, Indication, Reply};
use crate::slave::acyclic::AcyclicServer;
use crate::slave::{Device, Dpv1Error, Relation};
use profivac_wire::MAX_DU;
use profivac_wire::acyclic::initiate::{Capabilities, Initiate};
use profivac_wire::acyclic::record::MAX_RECORD_LENGTH;
use profivac_wire::acyclic::{
    Abort, AbortReason, ErrorCode, Function, InitiateRes, Negative, PduError, Request, ResourceManager, Response,
};

/// The access point of the first connection; the others follow downwards.
const FIRST_SAP: u8 = 48;

/// The unit of Send_Timeout, in milliseconds. profibus-wire 4.6.3.
const SEND_TIMEOUT_UNIT_MS: u64 = 10;

/// The longest Initiate that the resource manager accepts: Max_Initiate_PDU_Length of the GSD file. profibus-wire 4.6.3.
// chosen: the length that PA devices declare.
pub const MAX_INITIATE_PDU: u8 = 52;

/// One connection, or room for one.
#[derive(Clone, Debug)]
pub(super) struct Connection {
    state: Option<ConnectionState>,
    server: AcyclicServer,
}

/// The peer of a connection, its timeout and its phase.
#[derive(Clone, Copy, Debug)]
struct ConnectionState {
    peer: Peer,
    /// T: the greater Send_Timeout of both sides.
    timeout_tbit: u64,
    /// When the present phase times out.
    deadline: BitTime,
    phase: Phase,
}

/// Address and access point of a master; only both together identify the peer.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Peer {
    sa: u8,
    ssap: Option<u8>,
}

impl Peer {
    const fn of(request: &Indication<'_>) -> Self {
        Self { sa: request.sa, ssap: request.ssap }
    }
}

/// | Phase | poll | other PDU | Abort | deadline |
/// |---|---|---|---|---|
/// | Open | SC | execute, then Answered or Aborting | free | Aborting |
/// | Answered | SC while the device executes; response, then Open | RR | free | Aborting |
/// | Refused | response, then free | RR | free | Aborting |
/// | Aborting | Abort, then free | RR | free | free |
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Phase {
    /// Waits for a request, 2 T.
    Open,
    /// A response waits for a poll, T.
    Answered,
    /// The refusal of Initiate waits for a poll, T.
    Refused,
    /// An Abort of the slave waits for a poll, T.
    Aborting,
}

impl Connection {
    pub(super) const FREE: Self = Self { state: None, server: AcyclicServer::EMPTY };

    /// Frees the connection without an Abort.
    pub(super) const fn close(&mut self) {
        self.state = None;
        self.server.clear();
    }

    /// When the present phase times out.
    pub(super) fn deadline(&self) -> Option<BitTime> {
        self.state.map(|state| state.deadline)
    }

    /// Advances the time to `now`. profibus-wire 4.9; polls restart no timer.
    pub(super) fn elapse(&mut self, now: BitTime) {
        while let Some(state) = self.state
            && state.deadline <= now
        {
            match state.phase {
                Phase::Open | Phase::Answered | Phase::Refused => {
                    self.abort(state, AbortReason::TIMEOUT, state.deadline);
                }
                Phase::Aborting => self.close(),
            }
        }
    }

    fn abort(&mut self, state: ConnectionState, reason: AbortReason, now: BitTime) {
        self.server.post(&Response::Abort(Abort::new(reason)));
        self.enter_phase(state, Phase::Aborting, now);
    }

    /// Enters a phase in which the posted response can be fetched for T.
    fn enter_phase(&mut self, state: ConnectionState, phase: Phase, now: BitTime) {
        self.state = Some(ConnectionState { phase, deadline: now + state.timeout_tbit, ..state });
    }

    /// The checks of profibus-wire 4.6.5. A PDU that is no Initiate at all leaves the connection free, so it answers RS.
    fn initiate(&mut self, peer: Peer, pdu: &[u8], baud: Baud, now: BitTime) {
        let request = Request::parse(pdu);
        let wanted = if let Ok(Request::Initiate(initiate)) = &request { initiate.send_timeout } else { 0 };
        let timeout_ms = u64::from(wanted.max(min_send_timeout(baud))).saturating_mul(SEND_TIMEOUT_UNIT_MS);
        let timeout_tbit = baud.tbit_of_ms(timeout_ms);
        let state = ConnectionState { peer, timeout_tbit, deadline: now, phase: Phase::Open };
        match request {
            Ok(Request::Initiate(initiate)) => self.accept_initiate(state, &initiate, now),
            Err(PduError::Address) => self.abort(state, AbortReason::INVALID_REQUEST, now),
            Err(PduError::Length(Function::Initiate)) => self.abort(state, AbortReason::INVALID_ADDRESS, now),
            Ok(_) | Err(_) => {}
        }
    }

    /// The slave is an end point, not a gateway, and has one application without access levels (API and SCL 0).
    fn accept_initiate(&mut self, state: ConnectionState, initiate: &Initiate<'_>, now: BitTime) {
        let [features, _] = initiate.capabilities.features;
        let end = initiate.destination;
        if end.network.is_some() {
            self.abort(state, AbortReason::INVALID_ADDRESS, now);
        } else if (end.api, end.scl) != (0, 0) {
            // chosen code, as below
            self.refuse(state, ErrorCode::INVALID_PARAMETER, now);
        } else if features & Capabilities::DPV1_RW == 0 {
            self.refuse(state, ErrorCode::FEATURE_NOT_SUPPORTED, now);
        } else {
            self.server.post(&Response::Initiate(InitiateRes {
                max_len_data_unit: MAX_RECORD_LENGTH as u8,
                // The slave's own capabilities, independent of the request: profibus-wire 10, point 26.
                capabilities: Capabilities::READ_WRITE,
                source: initiate.destination,
                destination: initiate.source,
            }));
            self.enter_phase(state, Phase::Answered, now);
        }
    }

    fn refuse(&mut self, state: ConnectionState, code: ErrorCode, now: BitTime) {
        self.server.post(&Response::Negative(Negative::new(Function::Initiate, code)));
        self.enter_phase(state, Phase::Refused, now);
    }

    /// Serves a telegram on the connection's access point: the table of [`Phase`].
    fn serve<D: Device>(&mut self, requester: Peer, pdu: &[u8], context: &mut ServeContext<'_, D>) -> Reply<'_> {
        let Some(state) = self.state.filter(|state| state.peer == requester) else { return SERVICE_CLOSED };
        if pdu.is_empty() {
            return self.poll(state, context);
        }
        match (state.phase, Request::parse(pdu)) {
            (_, Ok(Request::Abort(_))) => self.close(),
            // profibus-wire 10, point 20
            (Phase::Answered | Phase::Refused | Phase::Aborting, _) => return NO_RESOURCE,
            (Phase::Open, request) => self.execute(state, request, context),
        }
        Reply::ShortAck
    }

    fn poll<D: Device>(&mut self, state: ConnectionState, context: &mut ServeContext<'_, D>) -> Reply<'_> {
        let length = self.server.take_length(context.device, context.via, context.du);
        let now = context.now;
        match state.phase {
            Phase::Open => {}
            // Not yet: the response can be fetched until T has passed.
            Phase::Answered if self.server.is_executing() => {}
            Phase::Answered => {
                let deadline = now + state.timeout_tbit.saturating_mul(2);
                self.state = Some(ConnectionState { phase: Phase::Open, deadline, ..state });
            }
            Phase::Refused | Phase::Aborting => self.close(),
        }
        self.server.reply(length)
    }

    fn execute<D: Device>(
        &mut self,
        state: ConnectionState,
        request: Result<Request<'_>, PduError>,
        context: &mut ServeContext<'_, D>,
    ) {
        match request {
            Ok(Request::Idle(rest)) => self.server.post(&Response::Idle(rest)),
            Ok(Request::Read(wanted)) => self.server.read(context.device, context.via, wanted, context.du),
            Ok(Request::Write(record)) => self.server.write(context.device, context.via, record),
            Ok(Request::DataTransport(_)) => {
                self.server.refuse(Function::DataTransport, Dpv1Error::FEATURE_NOT_SUPPORTED);
            }
            Err(PduError::Length(function @ (Function::Read | Function::Write | Function::DataTransport))) => {
                self.server.refuse(function, Dpv1Error::TYPE_CONFLICT);
            }
            Ok(Request::Initiate(_) | Request::AlarmAck(_) | Request::Abort(_)) | Err(_) => {
                return self.abort(state, AbortReason::INVALID_REQUEST, context.now);
            }
        }
        self.enter_phase(state, Phase::Answered, context.now);
    }
}

/// The parts of the slave that a connection needs to serve a request.
struct ServeContext<'a, D> {
    device: &'a mut D,
    via: Relation,
    du: &'a mut [u8; MAX_DU],
    now: BitTime,
}

/// The least Send_Timeout of a slave, in 10 ms. profibus-wire 4.6.2.
const fn min_send_timeout(baud: Baud) -> u16 {
    match baud {
        Baud::B9600 | Baud::B19200 | Baud::B45450 | Baud::B93750 | Baud::B187500 => 400,
        Baud::B500000 => 200,
        Baud::B1500000 | Baud::B3000000 | Baud::B6000000 | Baud::B12000000 => 100,
    }
}

impl<D: Device, const CONNECTIONS: usize> Server<D, CONNECTIONS> {
    /// SAP 49. Closed while no connection is free, and on a device without MS2.
    pub(super) fn resource_manager(&mut self, request: &Indication<'_>) -> Reply<'_> {
        let mut saps = (0..=FIRST_SAP).rev().zip(&mut self.ms2);
        let free = saps.find(|(_, connection)| connection.state.is_none());
        let Some((server_sap, connection)) = free.filter(|_| self.device.has_ms2()) else {
            return SERVICE_CLOSED;
        };
        if request.du.is_empty() {
            return Reply::ShortAck;
        }
        if request.du.len() > usize::from(MAX_INITIATE_PDU) {
            return NO_RESOURCE;
        }
        connection.initiate(Peer::of(request), request.du, self.baud, self.now);
        let min_send_timeout = min_send_timeout(self.baud);
        let answer = Response::ResourceManager(ResourceManager { server_sap, min_send_timeout });
        let emitted = answer.emit(&mut self.du);
        prepared(&self.du, emitted)
    }

    /// SAP 48 and below.
    pub(super) fn ms2(&mut self, sap: u8, request: &Indication<'_>) -> Reply<'_> {
        let Some(number) = FIRST_SAP.checked_sub(sap) else { return SERVICE_CLOSED };
        let Some(connection) = self.ms2.get_mut(usize::from(number)) else { return SERVICE_CLOSED };
        let via = Relation::Ms2(number);
        let mut context = ServeContext { device: &mut self.device, via, du: &mut self.du, now: self.now };
        connection.serve(Peer::of(request), request.du, &mut context)
    }
}
