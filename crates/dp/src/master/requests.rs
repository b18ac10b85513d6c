//! The acyclic requests of a master: MS2, MS1, parameter channel.
//!
//! The user submits a request and gets a [`Handle`], whose type says which outcome it has; nothing blocks.
//! [`Master::outcome`] returns the outcome, and an event announces it ([`EventKind::Acyclic`](super::EventKind::Acyclic)).
//! Requests need the token and time, so the caller that drives the station drives them too. While the station has no token,
//! [`Master::elapse`] advances the time.

use super::acyclic::{ExpectedResponse, Handle, SubmitError};
use super::ms1::{self, Ms1Parameters, Ms1Request};
use super::ms2::{self, Connection, Ms2Parameters, Phase};
use super::pkw::{self, PkwParameters, PkwTask};
use super::scheduler::{ExchangeStatus, Operation};
use super::{ExchangeError, MAX_ADDRESS, Master, Mode, Pending};
use crate::link::BitTime;
use profivac_wire::acyclic::record::MAX_RECORD_LENGTH;
use profivac_wire::acyclic::{AbortReason, Access, AlarmAck, Request as Pdu, Transfer};
use profivac_wire::prm::Dpv1Status1;

/// The highest address for MS2: slaves wait for an address at 126, and MS2 works there too.
const MAX_MS2_ADDRESS: u8 = MAX_ADDRESS.saturating_add(1);

impl<const SLAVES: usize, const OCTETS: usize, const EVENTS: usize, const ACYCLIC: usize>
    Master<SLAVES, OCTETS, EVENTS, ACYCLIC>
{
    /// Opens an MS2 connection to any slave of the bus, in any state and with any owner. The first outcome is
    /// [`Opened`](super::Opened) or the [`ConnectionEnd`](super::ConnectionEnd); after `Opened` the handle has the end as a
    /// second outcome.
    ///
    /// # Errors
    /// [`SubmitError`]: no slot is free, or no slave can have this address.
    pub fn ms2_open(&mut self, address: u8, parameters: &Ms2Parameters) -> Result<Handle<ms2::Connect>, SubmitError> {
        if address > MAX_MS2_ADDRESS || address == self.address {
            return Err(SubmitError::Address(address));
        }
        self.acyclic.open(address, parameters)
    }

    /// Reads up to `wanted` octets, 1 to 240, of a record. Index 255 is Call, profibus-wire 5.1. One request at a time for
    /// each connection; an outcome that was not taken is dropped.
    ///
    /// # Errors
    /// [`SubmitError`]: the connection is unknown, not open or busy, or `wanted` is 0.
    pub fn ms2_read(
        &mut self,
        connection: Handle<ms2::Connect>,
        slot: u8,
        index: u8,
        wanted: u8,
    ) -> Result<Handle<ms2::Read>, SubmitError> {
        // A connection with shorter data units gets a request for less: it cannot transfer a longer record.
        let most = self.max_len_data_unit(connection)?;
        let length = if most == 0 { wanted } else { wanted.min(most) };
        let access = Access { slot, index, length };
        self.acyclic.submit_ms2(connection, ExpectedResponse::Read(access), length.into(), &Pdu::Read(access))
    }

    /// Writes a record of 1 to 240 octets. The master sends it only once, even if telegrams are lost.
    ///
    /// # Errors
    /// [`SubmitError`]: the connection is unknown, not open or busy, or carries fewer octets.
    pub fn ms2_write(
        &mut self,
        connection: Handle<ms2::Connect>,
        slot: u8,
        index: u8,
        data: &[u8],
    ) -> Result<Handle<ms2::Write>, SubmitError> {
        let expected = ExpectedResponse::Write(access(slot, index, data)?);
        self.acyclic.submit_ms2(connection, expected, data.len(), &Pdu::Write(Transfer { slot, index, data }))
    }

    /// Sends Data_Transport; the slave returns data of its own.
    ///
    /// # Errors
    /// [`SubmitError`]: the connection is unknown, not open or busy, or carries fewer octets.
    pub fn ms2_transport(
        &mut self,
        connection: Handle<ms2::Connect>,
        slot: u8,
        index: u8,
        data: &[u8],
    ) -> Result<Handle<ms2::Transport>, SubmitError> {
        access(slot, index, data)?;
        let length = self.max_len_data_unit(connection)?;
        let expected = ExpectedResponse::Transport(Access { slot, index, length });
        self.acyclic.submit_ms2(connection, expected, data.len(), &Pdu::DataTransport(Transfer { slot, index, data }))
    }

    fn max_len_data_unit(&self, connection: Handle<ms2::Connect>) -> Result<u8, SubmitError> {
        self.acyclic.ms2.get(connection.key).map(Connection::max_len_data_unit).ok_or(SubmitError::UnknownHandle)
    }

    /// Closes a connection with an Abort of the user, reason 0. The outcome of the connection reports that the slave has been
    /// sent the Abort.
    ///
    /// # Errors
    /// [`SubmitError::UnknownHandle`].
    pub fn ms2_close(&mut self, connection: Handle<ms2::Connect>) -> Result<(), SubmitError> {
        self.ms2_abort(connection, AbortReason::User(0))
    }

    /// Closes a connection for a reason.
    ///
    /// # Errors
    /// [`SubmitError::UnknownHandle`].
    pub fn ms2_abort(&mut self, connection: Handle<ms2::Connect>, reason: AbortReason) -> Result<(), SubmitError> {
        self.acyclic.ms2.get_mut(connection.key).ok_or(SubmitError::UnknownHandle)?.close(reason);
        Ok(())
    }

    /// The phase of a connection; `None` if the handle is unknown.
    pub fn ms2_phase(&self, connection: Handle<ms2::Connect>) -> Option<Phase> {
        self.acyclic.ms2.get(connection.key).map(Connection::phase)
    }

    /// Reads up to `wanted` octets, 1 to 240, of a record of a slave of this master by MS1. One request at a time for each
    /// slave.
    ///
    /// # Errors
    /// [`SubmitError`]: the slave is not in data exchange with DP-V1 enabled, it is busy, or no slot is free.
    pub fn ms1_read(
        &mut self,
        address: u8,
        slot: u8,
        index: u8,
        wanted: u8,
        parameters: &Ms1Parameters,
    ) -> Result<Handle<ms1::Read>, SubmitError> {
        let access = Access { slot, index, length: wanted };
        self.submit_ms1(address, ExpectedResponse::Read(access), &Pdu::Read(access), wanted.into(), parameters)
    }

    /// Writes a record of 1 to 240 octets by MS1. The master sends it only once, even if telegrams are lost.
    ///
    /// # Errors
    /// [`SubmitError`], as [`ms1_read`](Self::ms1_read).
    pub fn ms1_write(
        &mut self,
        address: u8,
        slot: u8,
        index: u8,
        data: &[u8],
        parameters: &Ms1Parameters,
    ) -> Result<Handle<ms1::Write>, SubmitError> {
        let expected = ExpectedResponse::Write(access(slot, index, data)?);
        self.submit_ms1(address, expected, &Pdu::Write(Transfer { slot, index, data }), data.len(), parameters)
    }

    /// Acknowledges an alarm of the diagnosis. profibus-wire 4.5. A slave without that alarm leaves data exchange.
    ///
    /// # Errors
    /// [`SubmitError`], as [`ms1_read`](Self::ms1_read).
    pub fn ms1_alarm_ack(
        &mut self,
        address: u8,
        alarm: AlarmAck,
        parameters: &Ms1Parameters,
    ) -> Result<Handle<ms1::AcknowledgeAlarm>, SubmitError> {
        self.submit_ms1(address, ExpectedResponse::AlarmAck(alarm), &Pdu::AlarmAck(alarm), 1, parameters)
    }

    fn submit_ms1<O: Operation>(
        &mut self,
        address: u8,
        expected: ExpectedResponse,
        pdu: &Pdu<'_>,
        octets: usize,
        parameters: &Ms1Parameters,
    ) -> Result<Handle<O>, SubmitError> {
        let too_long = SubmitError::Length { octets, room: MAX_RECORD_LENGTH };
        if octets == 0 || octets > MAX_RECORD_LENGTH {
            return Err(too_long);
        }
        let starts = self.starts(address).ok_or(SubmitError::NotExchanging(address))?;
        if !self.slave(address).is_some_and(|slave| enables_dpv1(slave.user_prm())) {
            return Err(SubmitError::NotEnabled(address));
        }
        self.acyclic.submit_ms1(Ms1Request::new((address, starts), expected, pdu, parameters).ok_or(too_long)?)
    }

    /// Reads a parameter in the parameter channel of a slave of this master. With `width`, in octets, a value of another
    /// width is no answer. One task at a time for each slave.
    ///
    /// # Errors
    /// [`SubmitError`]: the slave is not in data exchange, the master not in Operate, the slave has no channel or is busy, or
    /// no slot is free.
    pub fn pkw_read(
        &mut self,
        address: u8,
        slot: u8,
        index: u8,
        width: Option<usize>,
        parameters: &PkwParameters,
    ) -> Result<Handle<pkw::Task>, SubmitError> {
        let relation = self.channel(address, parameters)?;
        self.acyclic.submit_pkw(PkwTask::read(relation, (slot, index), width, parameters))
    }

    /// Writes a parameter in the parameter channel. The outcome is the value in the slave's answer.
    ///
    /// # Errors
    /// [`SubmitError`], as [`pkw_read`](Self::pkw_read).
    pub fn pkw_write(
        &mut self,
        address: u8,
        slot: u8,
        index: u8,
        value: pkw::Value,
        parameters: &PkwParameters,
    ) -> Result<Handle<pkw::Task>, SubmitError> {
        let relation = self.channel(address, parameters)?;
        self.acyclic.submit_pkw(PkwTask::write(relation, (slot, index), value, parameters))
    }

    /// The address of a slave whose parameter channel can be used now, and how often it has entered data exchange.
    fn channel(&self, address: u8, parameters: &PkwParameters) -> Result<(u8, u32), SubmitError> {
        let starts = self.starts(address).ok_or(SubmitError::NotExchanging(address))?;
        let slave = self.slave(address).ok_or(SubmitError::NotExchanging(address))?;
        if self.mode != Mode::Operate || self.controls.is_cleared(slave.group) {
            return Err(SubmitError::NotOperating);
        }
        let outputs = pkw::part(slave.outputs(), parameters.outputs_at);
        let inputs = slave.inputs().and_then(|inputs| pkw::part(inputs, parameters.inputs_at));
        outputs.and(inputs).map(|_| (address, starts)).ok_or(SubmitError::NoChannel)
    }

    /// The outcome of a request, once; `None` while there is none.
    ///
    /// A connection has two outcomes: that it was opened, and its end. If it ends while a request is under way, the end is
    /// the outcome of whichever of the two handles is asked first, and both are used up.
    pub fn outcome<O: Operation>(&mut self, handle: Handle<O>) -> Option<O::Outcome<'_>> {
        O::take(&mut self.acyclic, handle)
    }

    /// Whether a request or connection has ended; an outcome may still be taken.
    pub fn is_over<O: Operation>(&self, handle: Handle<O>) -> bool {
        O::is_over(&self.acyclic, handle)
    }

    /// Advances the time to `now` while the station has no token, so that timeouts end as if it had.
    #[inline]
    pub fn elapse(&mut self, now: BitTime) {
        self.now = self.now.max(now);
        // The confirmation of a pending message is evaluated first.
        if self.acyclic.is_idle() || matches!(self.pending, Pending::Acyclic(_)) {
            return;
        }
        self.acyclic.elapse_connections(now, &mut self.events.sink());
        if self.acyclic.has_class_1() {
            self.elapse_class_1(now);
        }
    }

    /// Advances the time of the requests that belong to a data exchange.
    fn elapse_class_1(&mut self, now: BitTime) {
        let (slaves, indices) = (&self.slaves, &self.index_by_address);
        let (operate, controls) = (self.mode == Mode::Operate, &self.controls);
        let status = |address: u8| {
            let slave = slaves.get(usize::from(*indices.get(usize::from(address))?))?;
            let operating = operate && !controls.is_cleared(slave.group);
            slave.state().is_exchanging().then_some(ExchangeStatus { starts: slave.counters().starts, operating })
        };
        self.acyclic.elapse_class_1(now, status, &mut self.events.sink());
        while let Some(address) = self.acyclic.take_late() {
            self.with(address, |slave, context| slave.restart(ExchangeError::Ms1, context));
        }
    }

    /// How often a slave that exchanges data has entered data exchange.
    fn starts(&self, address: u8) -> Option<u32> {
        let slave = self.slave(address)?;
        slave.state().is_exchanging().then_some(slave.counters().starts)
    }
}

/// The access that the response to a write of `data` has.
fn access(slot: u8, index: u8, data: &[u8]) -> Result<Access, SubmitError> {
    let octets = data.len();
    match u8::try_from(octets) {
        Ok(length) if (1..=MAX_RECORD_LENGTH).contains(&octets) => Ok(Access { slot, index, length }),
        _ => Err(SubmitError::Length { octets, room: MAX_RECORD_LENGTH }),
    }
}

/// Whether user parameters enable DP-V1: DPV1_Enable in the first DPV1_Status octet. profibus-wire 2.4.
fn enables_dpv1(user_prm: &[u8]) -> bool {
    user_prm.first().is_some_and(|status| Dpv1Status1::from_bits_retain(*status).contains(Dpv1Status1::DPV1_ENABLE))
}
