//! The acyclic requests of a master: MS2, MS1, parameter channel.
//!
//! Each is handed in and named by a [`Handle`]; nothing blocks. [`Master::outcome`] has what became of it, and the event
//! queue says when to ask ([`What::Acyclic`](super::What::Acyclic)). They need the token and time: whoever drives the station
//! drives them. Where the station is not asked for work, because it has no token, [`Master::elapse`] lets time pass.
//!
//! ```no_run
//! use profivac_dp::link::active::{Active, BusParameters};
//! use profivac_dp::link::{Baud, BitTime};
//! use profivac_dp::master::{Master, Ms2Parameters, Outcome, Settings};
//!
//! # fn drive(_: &mut Active<Master<0, 0>>) {}
//! let mut station = Master::<0, 0>::on(BusParameters::new(2, Baud::B19200), Settings::new(Baud::B19200), BitTime(0));
//! let connection = station.user.ms2_open(5, &Ms2Parameters::new(Baud::B19200))?;
//! loop {
//!     drive(&mut station); // telegrams and time
//!     match station.user.outcome(connection) {
//!         None => {}
//!         Some(Outcome::Opened(_)) => station.user.ms2_read(connection, 1, 19, 240)?,
//!         Some(Outcome::Read(record)) => {
//!             assert_eq!(record.len(), 4);
//!             station.user.ms2_close(connection)?;
//!         }
//!         Some(other) => break println!("{other:?}"),
//!     }
//! }
//! # Ok::<(), profivac_dp::master::NotTaken>(())
//! ```

use super::acyclic::{ExchangeStatus, ExpectedResponse, Handle, Outcome, SubmitError};
use super::ms1::{self, Ms1Parameters};
use super::ms2::{self, Ms2Parameters, Phase};
use super::pkw::{self, PkwParameters};
use super::{HandlerState, MAX_ADDRESS, Master, Mode};
use crate::link::BitTime;
use profivac_wire::acyclic::record::MAX_RECORD_LENGTH;
use profivac_wire::acyclic::{AbortReason, Access, AlarmAck, Request as Pdu, Transfer};

/// The first DPV1_Status octet: DP-V1 is enabled. profibus-wire 2.4.
const DPV1_ENABLE: u8 = 0x80;

/// The highest address a slave can be called at: 126 is where slaves wait for one, and MS2 works there too.
const MAX_MS2_ADDRESS: u8 = MAX_ADDRESS.saturating_add(1);

impl<const SLAVES: usize, const OCTETS: usize, const EVENTS: usize, const ACYCLIC: usize>
    Master<SLAVES, OCTETS, EVENTS, ACYCLIC>
{
    /// Opens an MS2 connection to any slave of the bus, whoever owns it and in whatever state it is. Its first outcome is
    /// [`Outcome::Opened`] or [`Outcome::Ended`].
    ///
    /// # Errors
    /// [`NotTaken`]: no place is left, or no slave can have this address.
    pub fn ms2_open(&mut self, address: u8, parameters: &Ms2Parameters) -> Result<Handle, SubmitError> {
        if address > MAX_MS2_ADDRESS || address == self.address {
            return Err(SubmitError::Address(address));
        }
        self.acyclic.open(address, parameters)
    }

    /// Reads up to `wanted` octets, 1 to 240, of a record: [`Outcome::Read`] or [`Outcome::Refused`]. Index 255 is Call,
    /// profibus-wire 5.1.
    ///
    /// # Errors
    /// [`NotTaken`]: the connection is gone, not open or busy, or carries fewer octets.
    pub fn ms2_read(&mut self, connection: Handle, slot: u8, index: u8, wanted: u8) -> Result<(), SubmitError> {
        // A connection that carries less is asked for less: a record longer than that cannot be read whole on it.
        let most = self.acyclic.ms2.get(connection).ok_or(SubmitError::UnknownHandle)?.max_len_data_unit();
        let length = if most == 0 { wanted } else { wanted.min(most) };
        let access = Access { slot, index, length };
        self.acyclic.submit(connection, ExpectedResponse::Read(access), length.into(), &Pdu::Read(access))
    }

    /// Writes a record of 1 to 240 octets: [`Outcome::Written`] or [`Outcome::Refused`]. It is sent once, whatever gets
    /// lost.
    ///
    /// # Errors
    /// [`NotTaken`]: the connection is gone, not open or busy, or carries fewer octets.
    pub fn ms2_write(&mut self, connection: Handle, slot: u8, index: u8, data: &[u8]) -> Result<(), SubmitError> {
        let expected = ExpectedResponse::Write(access(slot, index, data)?);
        self.acyclic.submit(connection, expected, data.len(), &Pdu::Write(Transfer { slot, index, data }))
    }

    /// Data_Transport: [`Outcome::Transported`] or [`Outcome::Refused`].
    ///
    /// # Errors
    /// [`NotTaken`]: the connection is gone, not open or busy, or carries fewer octets.
    pub fn ms2_transport(&mut self, connection: Handle, slot: u8, index: u8, data: &[u8]) -> Result<(), SubmitError> {
        access(slot, index, data)?;
        let length = self.acyclic.ms2.get(connection).ok_or(SubmitError::UnknownHandle)?.max_len_data_unit();
        let expected = ExpectedResponse::Transport(Access { slot, index, length });
        self.acyclic.submit(connection, expected, data.len(), &Pdu::DataTransport(Transfer { slot, index, data }))
    }

    /// Closes a connection with an Abort of the user, reason 0. [`Outcome::Ended`] says when the slave was told.
    ///
    /// # Errors
    /// [`NotTaken::Gone`].
    pub fn ms2_close(&mut self, connection: Handle) -> Result<(), SubmitError> {
        self.ms2_abort(connection, AbortReason::User(0))
    }

    /// Closes a connection for a reason.
    ///
    /// # Errors
    /// [`NotTaken::Gone`].
    pub fn ms2_abort(&mut self, connection: Handle, reason: AbortReason) -> Result<(), SubmitError> {
        self.acyclic.ms2.get_mut(connection).ok_or(SubmitError::UnknownHandle)?.close(reason);
        Ok(())
    }

    /// Where a connection stands; `None` if the handle means none.
    pub fn ms2_phase(&self, connection: Handle) -> Option<Phase> {
        self.acyclic.ms2.get(connection).map(ms2::Connection::phase)
    }

    /// Reads up to `wanted` octets, 1 to 240, of a record of a slave of this master by MS1: [`Outcome::Read`],
    /// [`Outcome::Refused`] or [`Outcome::Failed`]. One request at a time for each slave.
    ///
    /// # Errors
    /// [`NotTaken`]: the slave is not in data exchange with DP-V1 enabled, it is busy, or no place is left.
    pub fn ms1_read(
        &mut self,
        address: u8,
        slot: u8,
        index: u8,
        wanted: u8,
        parameters: &Ms1Parameters,
    ) -> Result<Handle, SubmitError> {
        let access = Access { slot, index, length: wanted };
        self.ms1(address, ExpectedResponse::Read(access), &Pdu::Read(access), wanted.into(), parameters)
    }

    /// Writes a record of 1 to 240 octets by MS1: [`Outcome::Written`], [`Outcome::Refused`] or [`Outcome::Failed`]. It is
    /// sent once, whatever gets lost.
    ///
    /// # Errors
    /// [`NotTaken`], as [`ms1_read`](Self::ms1_read).
    pub fn ms1_write(
        &mut self,
        address: u8,
        slot: u8,
        index: u8,
        data: &[u8],
        parameters: &Ms1Parameters,
    ) -> Result<Handle, SubmitError> {
        let expected = ExpectedResponse::Write(access(slot, index, data)?);
        self.ms1(address, expected, &Pdu::Write(Transfer { slot, index, data }), data.len(), parameters)
    }

    /// Acknowledges an alarm of the diagnosis: [`Outcome::Acknowledged`]. profibus-wire 4.5. A slave without that alarm
    /// leaves data exchange.
    ///
    /// # Errors
    /// [`NotTaken`], as [`ms1_read`](Self::ms1_read).
    pub fn ms1_alarm_ack(
        &mut self,
        address: u8,
        alarm: AlarmAck,
        parameters: &Ms1Parameters,
    ) -> Result<Handle, SubmitError> {
        self.ms1(address, ExpectedResponse::AlarmAck(alarm), &Pdu::AlarmAck(alarm), 1, parameters)
    }

    fn ms1(
        &mut self,
        address: u8,
        expected: ExpectedResponse,
        pdu: &Pdu<'_>,
        octets: usize,
        parameters: &Ms1Parameters,
    ) -> Result<Handle, SubmitError> {
        let too_long = SubmitError::Length { octets, room: MAX_RECORD_LENGTH };
        if octets == 0 || octets > MAX_RECORD_LENGTH {
            return Err(too_long);
        }
        let starts = self.starts(address).ok_or(SubmitError::NotExchanging(address))?;
        let enabled = self.slave(address).is_some_and(|slave| has_dpv1(slave.user_prm()));
        if !enabled {
            return Err(SubmitError::NotEnabled(address));
        }
        self.acyclic.ms1(ms1::Ms1Request::new((address, starts), expected, pdu, parameters).ok_or(too_long)?)
    }

    /// Reads a parameter in the parameter channel of a slave of this master: [`Outcome::Value`], [`Outcome::Denied`] or
    /// [`Outcome::Failed`]. With `width` a value of another width is no answer. One instruction at a time for each slave.
    ///
    /// # Errors
    /// [`NotTaken`]: the slave is not in data exchange, the master not in Operate, there is no channel, it is busy, or no
    /// place is left.
    pub fn pkw_read(
        &mut self,
        address: u8,
        slot: u8,
        index: u8,
        width: Option<usize>,
        parameters: &PkwParameters,
    ) -> Result<Handle, SubmitError> {
        let relation = self.channel(address, parameters)?;
        self.acyclic.pkw(pkw::PkwTask::read(relation, (slot, index), width, parameters))
    }

    /// Writes a parameter in the parameter channel: [`Outcome::Value`] with what the slave answers, [`Outcome::Denied`] or
    /// [`Outcome::Failed`].
    ///
    /// # Errors
    /// [`NotTaken`], as [`pkw_read`](Self::pkw_read).
    pub fn pkw_write(
        &mut self,
        address: u8,
        slot: u8,
        index: u8,
        value: pkw::Value,
        parameters: &PkwParameters,
    ) -> Result<Handle, SubmitError> {
        let relation = self.channel(address, parameters)?;
        self.acyclic.pkw(pkw::PkwTask::write(relation, (slot, index), value, parameters))
    }

    /// Whether there is a parameter channel that can be used now.
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

    /// The outcome behind a handle, once. A handle of MS2 has one for each request and a last one, [`Outcome::Ended`]; the
    /// others have one. `None` while there is nothing to tell.
    pub fn outcome(&mut self, handle: Handle) -> Option<Outcome<'_>> {
        self.acyclic.outcome(handle)
    }

    /// Whether nothing more will become of a handle, but for an outcome to be taken.
    pub fn is_over(&self, handle: Handle) -> bool {
        self.acyclic.is_over(handle)
    }

    /// Time has come to `now`, without the token: waiting for responses ends as if this station had been asked for work.
    pub fn elapse(&mut self, now: BitTime) {
        self.now = self.now.max(now);
        if let super::Pending::Acyclic(_) = self.pending {
            // What becomes of the message on its way is told before anything else is decided.
            return;
        }
        let (slaves, places) = (&self.slaves, &self.index_by_address);
        let (operate, controls) = (self.mode == Mode::Operate, &self.controls);
        let stands = |address: u8| {
            let slave = slaves.get(usize::from(*places.get(usize::from(address))?))?;
            let operating = operate && !controls.is_cleared(slave.group);
            matches!(slave.state(), HandlerState::Data { .. })
                .then_some(ExchangeStatus { starts: slave.counters().starts, operating })
        };
        self.acyclic.elapse(now, stands, &mut self.events.sink());
        if let Some(address) = self.acyclic.take_late() {
            self.with(address, |slave, context| slave.restart(super::ExchangeError::Ms1, context));
        }
    }

    /// How often a slave that exchanges data has come there.
    fn starts(&self, address: u8) -> Option<u32> {
        let slave = self.slave(address)?;
        matches!(slave.state(), HandlerState::Data { .. }).then_some(slave.counters().starts)
    }
}

/// The Access that a Write of `data` is answered with.
fn access(slot: u8, index: u8, data: &[u8]) -> Result<Access, SubmitError> {
    let octets = data.len();
    match u8::try_from(octets) {
        Ok(length) if (1..=MAX_RECORD_LENGTH).contains(&octets) => Ok(Access { slot, index, length }),
        _ => Err(SubmitError::Length { octets, room: MAX_RECORD_LENGTH }),
    }
}

/// Whether Set_Prm enables DP-V1.
fn has_dpv1(user_prm: &[u8]) -> bool {
    user_prm.first().is_some_and(|status| status & DPV1_ENABLE != 0)
}
