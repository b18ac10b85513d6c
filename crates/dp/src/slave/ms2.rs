//! MS2: connections of class 2 masters, in whatever state MS0 is. profibus-wire 4.6 to 4.10.
//!
//! The resource manager on SAP 49 answers an Initiate at once with the access point of the connection; all else happens
//! there. RESERVED and JOB of the reference last no longer than the request that enters them, because the job is done at
//! once; what is left of its table are the four phases of [`Link`].

use super::acyclic::AcyclicServer;
use super::{Device, Dpv1Error, NO_RESOURCE, Relation, SERVICE_CLOSED, Slave};
use crate::link::{Baud, BitTime, Indication, Reply};
use profivac_wire::MAX_DU;
use profivac_wire::acyclic::initiate::{Capabilities, Initiate};
use profivac_wire::acyclic::record::MAX_RECORD_LENGTH;
use profivac_wire::acyclic::{
    Abort, AbortReason, ErrorCode, Function, InitiateRes, Negative, PduError, Request, ResourceManager, Response,
};
use profivac_wire::control::Status;

/// The access point of the first connection; the others follow downwards.
const FIRST_SAP: u8 = 48;

/// The longest Initiate the resource manager takes: Max_Initiate_PDU_Length of the GSD file. profibus-wire 4.6.3.
// free choice: what PA devices declare.
pub const MAX_INITIATE_PDU: u8 = 52;

/// One connection, or room for one.
#[derive(Clone, Debug)]
pub(super) struct Connection {
    state: Option<ConnectionState>,
    channel: AcyclicServer,
}

/// Who is at the other end, and how long nothing may happen.
#[derive(Clone, Copy, Debug)]
struct ConnectionState {
    peer: Peer,
    /// T: the greater Send_Timeout of both sides.
    timeout_tbit: u64,
    /// When patience with the present phase ends.
    deadline: BitTime,
    phase: Phase,
}

/// Master and access point; only both together are the peer.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Peer {
    sa: u8,
    ssap: Option<u8>,
}

/// | Phase | poll | other PDU | Abort | deadline |
/// |---|---|---|---|---|
/// | Open | SC | job, then Answered or Aborting | free | Aborting |
/// | Answered | response, then Open | RR | free | Aborting |
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
    pub(super) const FREE: Self = Self { state: None, channel: AcyclicServer::EMPTY };

    /// Back to the resource manager, without a word.
    pub(super) const fn close(&mut self) {
        self.state = None;
        self.channel.clear();
    }

    /// When the connection will lose patience.
    pub(super) fn deadline(&self) -> Option<BitTime> {
        self.state.map(|link| link.deadline)
    }

    /// Time has come to `now`. profibus-wire 4.9; polls restart nothing.
    pub(super) fn elapse(&mut self, now: BitTime) {
        while let Some(link) = self.state
            && link.deadline <= now
        {
            match link.phase {
                Phase::Open | Phase::Answered | Phase::Refused => self.abort(link, AbortReason::TIMEOUT, link.deadline),
                Phase::Aborting => self.close(),
            }
        }
    }

    fn abort(&mut self, link: ConnectionState, reason: AbortReason, now: BitTime) {
        self.channel.post(&Response::Abort(Abort::new(reason)));
        self.enter_phase(link, Phase::Aborting, now);
    }

    /// The response that was posted has T to be fetched.
    fn enter_phase(&mut self, link: ConnectionState, phase: Phase, now: BitTime) {
        self.state = Some(ConnectionState { phase, deadline: now + link.timeout_tbit, ..link });
    }

    /// The checks of profibus-wire 4.6.5. What is no Initiate at all leaves the connection free, so it answers RS.
    fn initiate(&mut self, peer: Peer, pdu: &[u8], baud: Baud, now: BitTime) {
        let request = Request::parse(pdu);
        let asked = if let Ok(Request::Initiate(initiate)) = &request { initiate.send_timeout } else { 0 };
        let timeout_ms = u64::from(asked.max(min_send_timeout(baud))).saturating_mul(10);
        let link =
            ConnectionState { peer, timeout_tbit: baud.tbit_of_ms(timeout_ms), deadline: now, phase: Phase::Open };
        match request {
            Ok(Request::Initiate(initiate)) => self.accept_initiate(link, &initiate, now),
            Err(PduError::Address) => self.abort(link, AbortReason::INVALID_REQUEST, now),
            Err(PduError::Length(Function::Initiate)) => self.abort(link, AbortReason::INVALID_ADDRESS, now),
            Ok(_) | Err(_) => {}
        }
    }

    /// The slave is an end point, not a gateway, and has one application without access levels (API and SCL 0).
    fn accept_initiate(&mut self, link: ConnectionState, initiate: &Initiate<'_>, now: BitTime) {
        let [features, _] = initiate.capabilities.features;
        let end = initiate.destination;
        if end.network.is_some() {
            self.abort(link, AbortReason::INVALID_ADDRESS, now);
        } else if (end.api, end.scl) != (0, 0) {
            // free choice of the code, as below
            self.refuse(link, ErrorCode::INVALID_PARAMETER, now);
        } else if features & Capabilities::DPV1_RW == 0 {
            self.refuse(link, ErrorCode::FEATURE_NOT_SUPPORTED, now);
        } else {
            self.channel.post(&Response::Initiate(InitiateRes {
                max_len_data_unit: MAX_RECORD_LENGTH as u8,
                // The slave's own, whatever was asked for: profibus-wire 10, point 26.
                capabilities: Capabilities::READ_WRITE,
                source: initiate.destination,
                destination: initiate.source,
            }));
            self.enter_phase(link, Phase::Answered, now);
        }
    }

    fn refuse(&mut self, link: ConnectionState, code: ErrorCode, now: BitTime) {
        self.channel.post(&Response::Negative(Negative::new(Function::Initiate, code)));
        self.enter_phase(link, Phase::Refused, now);
    }

    /// A telegram on the connection's access point: the table of [`Phase`].
    fn serve<D: Device>(&mut self, asker: Peer, pdu: &[u8], job: &mut ServeContext<'_, D>) -> Reply {
        let Some(link) = self.state.filter(|link| link.peer == asker) else { return SERVICE_CLOSED };
        if pdu.is_empty() {
            return self.poll(link, job);
        }
        match (link.phase, Request::parse(pdu)) {
            (_, Ok(Request::Abort(_))) => self.close(),
            // profibus-wire 10, point 20
            (Phase::Answered | Phase::Refused | Phase::Aborting, _) => return NO_RESOURCE,
            (Phase::Open, request) => self.execute(link, request, job),
        }
        Reply::ShortAck
    }

    fn poll<D>(&mut self, link: ConnectionState, job: &mut ServeContext<'_, D>) -> Reply {
        let reply = self.channel.fetch(job.du);
        match link.phase {
            Phase::Open => {}
            Phase::Answered => {
                let deadline = job.now + link.timeout_tbit.saturating_mul(2);
                self.state = Some(ConnectionState { phase: Phase::Open, deadline, ..link });
            }
            Phase::Refused | Phase::Aborting => self.close(),
        }
        reply
    }

    fn execute<D: Device>(
        &mut self,
        link: ConnectionState,
        request: Result<Request<'_>, PduError>,
        job: &mut ServeContext<'_, D>,
    ) {
        match request {
            Ok(Request::Idle(rest)) => self.channel.post(&Response::Idle(rest)),
            Ok(Request::Read(wanted)) => self.channel.read(job.device, job.via, wanted, job.du),
            Ok(Request::Write(record)) => self.channel.write(job.device, job.via, record),
            Ok(Request::DataTransport(_)) => {
                self.channel.refuse(Function::DataTransport, Dpv1Error::FEATURE_NOT_SUPPORTED);
            }
            Err(PduError::Length(function @ (Function::Read | Function::Write | Function::DataTransport))) => {
                self.channel.refuse(function, Dpv1Error::TYPE_CONFLICT);
            }
            Ok(Request::Initiate(_) | Request::AlarmAck(_) | Request::Abort(_)) | Err(_) => {
                return self.abort(link, AbortReason::INVALID_REQUEST, job.now);
            }
        }
        self.enter_phase(link, Phase::Answered, job.now);
    }
}

/// What a job needs beside its connection.
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

impl<D: Device, const CONNECTIONS: usize> Slave<D, CONNECTIONS> {
    /// SAP 49. Closed while no connection is free, and on a DP-V0 device.
    pub(super) fn resource_manager(&mut self, request: &Indication<'_>) -> Reply {
        let mut saps = (0..=FIRST_SAP).rev().zip(&mut self.ms2);
        let free = saps.find(|(_, connection)| connection.state.is_none());
        let Some((server_sap, connection)) = free.filter(|_| self.device.features().dpv1) else {
            return SERVICE_CLOSED;
        };
        if request.du.is_empty() {
            return Reply::ShortAck;
        }
        if request.du.len() > usize::from(MAX_INITIATE_PDU) {
            return NO_RESOURCE;
        }
        connection.initiate(Peer { sa: request.sa, ssap: request.ssap }, request.du, self.baud, self.now);
        let min_send_timeout = min_send_timeout(self.baud);
        let answer = Response::ResourceManager(ResourceManager { server_sap, min_send_timeout });
        answer.emit(&mut self.du).map_or(Reply::Status(Status::UserError), Reply::Low)
    }

    /// SAP 48 and below.
    pub(super) fn ms2(&mut self, sap: u8, request: &Indication<'_>) -> Reply {
        let Some(number) = FIRST_SAP.checked_sub(sap) else { return SERVICE_CLOSED };
        let Some(connection) = self.ms2.get_mut(usize::from(number)) else { return SERVICE_CLOSED };
        let via = Relation::Ms2(number);
        let mut job = ServeContext { device: &mut self.device, via, du: &mut self.du, now: self.now };
        connection.serve(Peer { sa: request.sa, ssap: request.ssap }, request.du, &mut job)
    }
}
