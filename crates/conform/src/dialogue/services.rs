//! The services of a slave, as the checks use them: start-up, data exchange, diagnosis, acyclic requests.

use super::Dialogue;
use super::step::{StepError, StepResult, require};
use super::telegrams::{Answer, octets, request_octets, set_prm_octets};
use crate::expected::{Closed, Expected, Pdu};
use crate::probe::Received;
use profivac_host::port::PortError;
use profivac_wire::acyclic::{self, Abort, AbortReason, Request};
use profivac_wire::cfg::{self, Lengths};
use profivac_wire::control::{Control, FrameCount, Function};
use profivac_wire::diag::{SlaveDiag, StationStatus};
use profivac_wire::prm::{PrmStatus, SetPrm};
use profivac_wire::{MAX_DU, Sap};
use std::time::Duration;

/// Number of polls for a slave that is not ready. With the pause between them they take one second.
const READY_TRIES: usize = 100;
const READY_PAUSE: Duration = Duration::from_millis(10);

/// The last access point of a connection of MS2 (profibus-wire 2.1).
const LAST_MS2: u8 = 48;

impl<'a> Dialogue<'a> {
    /// Sends a request that the slave must acknowledge.
    pub(crate) fn expect_acknowledged(&mut self, sap: Sap, du: &[u8]) -> StepResult {
        let answer = self.request(sap, du)?;
        require(answer.is_acknowledgement(), Expected::Acknowledgement)
    }

    /// Sends a request that the slave must answer with RS.
    pub(crate) fn expect_closed(&mut self, sa: u8, sap: Sap, du: &[u8], reason: Closed) -> StepResult {
        let answer = self.request_from(sa, sap, du)?;
        require(answer.is_closed(), Expected::Closed(reason))
    }

    /// Reads the diagnosis from `sa`. Returns its octets, at least six.
    pub(crate) fn diagnosis_octets(&mut self, sa: u8) -> StepResult<Vec<u8>> {
        let answer = self.request_from(sa, Sap::SlaveDiag, &[])?;
        let whole = answer.has_data_status() && SlaveDiag::parse(&answer.du).is_ok() && answer.du.len() <= MAX_DU;
        require(whole, Expected::Diagnosis)?;
        Ok(answer.du)
    }

    /// Reads the diagnosis. Returns its fixed part.
    pub(crate) fn diagnosis(&mut self) -> StepResult<Diagnosis> {
        let du = self.diagnosis_octets(self.own_address())?;
        let diag = SlaveDiag::parse(&du).map_err(|_| StepError::Unexpected(Expected::Diagnosis))?;
        Ok(Diagnosis { status: diag.status, master_add: diag.master_add, ident: diag.ident })
    }

    /// A Set_Prm that the slave accepts: with Lock_Req, and with the watchdog factors `wd_fact`; zeros switch the watchdog off.
    pub(crate) fn prm(&self, wd_fact: [u8; 2]) -> SetPrm<'a> {
        let watched = if wd_fact == [0, 0] { PrmStatus::empty() } else { PrmStatus::WD_ON };
        SetPrm {
            status: PrmStatus::LOCK_REQ | watched,
            wd_fact,
            min_tsdr: 11,
            ident: self.slave.ident,
            group: 0,
            user: &self.slave.user_prm,
        }
    }

    /// Sends Set_Prm. Only the diagnosis shows whether the slave accepts it.
    pub(crate) fn set_prm(&mut self, prm: &SetPrm<'_>) -> Result<(), PortError> {
        self.tell(Sap::SetPrm, &set_prm_octets(prm))
    }

    /// A Set_Prm that releases the slave.
    pub(crate) fn unlock_prm(&self) -> SetPrm<'a> {
        SetPrm { status: PrmStatus::UNLOCK_REQ, user: &[], wd_fact: [0, 0], min_tsdr: 0, ..self.prm([0, 0]) }
    }

    /// Releases the slave: it waits for parameters afterwards.
    pub(crate) fn release(&mut self) -> Result<(), PortError> {
        self.set_prm(&self.unlock_prm())
    }

    /// Ends what a disturbed or failed test may have left behind, so that a repetition begins as the test did: ownership of the second
    /// master, and connections of MS2. The slave may have opened one whose access point the testing master does not know.
    pub(crate) fn settle(&mut self) -> Result<(), PortError> {
        let unlock = set_prm_octets(&self.unlock_prm());
        self.tell_from(self.other_master_address(), Sap::SetPrm, &unlock)?;
        if std::mem::take(&mut self.has_initiated) {
            let abort = request_octets(&Request::Abort(Abort::new(AbortReason::User(0))));
            (0..=LAST_MS2).try_for_each(|sap| self.tell(Sap::Ms2(sap), &abort))?;
        }
        Ok(())
    }

    /// Releases the slave. Returns whether it answers at all: this, or else FDL status.
    pub(crate) fn release_and_listen(&mut self) -> Result<bool, PortError> {
        let answer = self.request(Sap::SetPrm, &set_prm_octets(&self.unlock_prm()));
        match answer {
            Ok(_) => Ok(true),
            Err(StepError::Port(error)) => Err(error),
            Err(StepError::Unexpected(_)) => {
                let fc = Control::Request { function: Function::FdlStatus, count: FrameCount::Uncounted }.to_octet();
                let telegram = octets(self.slave.address, self.own_address(), Sap::Default, fc, &[]);
                Ok(matches!(self.send(&telegram)?, Received::Telegram(_)))
            }
        }
    }

    /// Sends the configuration under test. Only the diagnosis shows whether the slave accepts it.
    pub(crate) fn chk_cfg(&mut self) -> Result<(), PortError> {
        self.tell(Sap::ChkCfg, &self.slave.cfg)
    }

    /// Releases the slave and parameterises it: it waits for its configuration afterwards.
    pub(crate) fn parameterise(&mut self) -> Result<(), PortError> {
        self.release()?;
        self.set_prm(&self.prm([0, 0]))
    }

    /// Starts data exchange with the watchdog off.
    pub(crate) fn start(&mut self) -> StepResult {
        self.start_with(&self.prm([0, 0]))
    }

    /// Starts data exchange with these parameters, and waits until the slave is ready.
    pub(crate) fn start_with(&mut self, prm: &SetPrm<'_>) -> StepResult {
        self.release()?;
        self.set_prm(prm)?;
        self.chk_cfg()?;
        self.await_exchange()
    }

    /// Sends Data_Exchange until the slave takes part in it. No slave needs Slave_Diag for that (profibus-wire 3.3).
    pub(crate) fn await_exchange(&mut self) -> StepResult {
        for _ in 0..READY_TRIES {
            if self.is_exchanging()? {
                return Ok(());
            }
            self.link.wait(READY_PAUSE)?;
        }
        Err(StepError::Unexpected(Expected::Ready))
    }

    /// Numbers of output and input octets.
    pub(crate) fn lengths(&self) -> Lengths {
        cfg::lengths(&self.slave.cfg).unwrap_or_default()
    }

    /// Outputs of zero.
    pub(crate) fn outputs(&self) -> Vec<u8> {
        vec![0; usize::from(self.lengths().outputs)]
    }

    /// Sends Data_Exchange with `outputs` from `sa`. Returns whether the slave took part: with inputs of any length, or with SC.
    pub(crate) fn is_exchanging_with(&mut self, sa: u8, outputs: &[u8]) -> Result<bool, PortError> {
        match self.request_from(sa, Sap::Default, outputs) {
            Ok(answer) => Ok(answer.has_data_status() || answer.is_acknowledgement()),
            Err(StepError::Unexpected(_)) => Ok(false),
            Err(StepError::Port(error)) => Err(error),
        }
    }

    /// As [`is_exchanging_with`](Self::is_exchanging_with) with the testing master and outputs of zero.
    pub(crate) fn is_exchanging(&mut self) -> Result<bool, PortError> {
        self.is_exchanging_with(self.own_address(), &self.outputs())
    }

    /// Requires that the slave takes part in data exchange.
    pub(crate) fn expect_exchange(&mut self) -> StepResult {
        let exchanging = self.is_exchanging()?;
        require(exchanging, Expected::Exchange)
    }

    /// Requires that the slave does not take part in data exchange.
    pub(crate) fn expect_no_exchange(&mut self) -> StepResult {
        let exchanging = self.is_exchanging()?;
        require(!exchanging, Expected::NoExchange)
    }

    /// Reads the inputs with Data_Exchange.
    pub(crate) fn inputs(&mut self) -> StepResult<Vec<u8>> {
        let answer = self.request(Sap::Default, &self.outputs())?;
        let count = usize::from(self.lengths().inputs);
        let whole = answer.has_data_status() || (answer.is_acknowledgement() && count == 0);
        require(whole && answer.du.len() == count, Expected::Octets(count))?;
        Ok(answer.du)
    }

    /// Polls an access point of DP-V1 for a response.
    pub(crate) fn poll(&mut self, sap: Sap) -> StepResult<Answer> {
        for _ in 0..READY_TRIES {
            let answer = self.request(sap, &[])?;
            if !answer.is_acknowledgement() {
                return Ok(answer);
            }
            self.link.wait(READY_PAUSE)?;
        }
        Err(StepError::Unexpected(Expected::Pdu(Pdu::Response)))
    }

    /// Sends a request of DP-V1 and polls for the response. Returns the answer with the response.
    pub(crate) fn acyclic(&mut self, sap: Sap, request: &acyclic::Request<'_>) -> StepResult<Answer> {
        self.acyclic_octets(sap, &request_octets(request))
    }

    /// As [`acyclic`](Self::acyclic) with any octets.
    pub(crate) fn acyclic_octets(&mut self, sap: Sap, du: &[u8]) -> StepResult<Answer> {
        let answer = self.request(sap, du)?;
        // The response may come at once (profibus-wire 4.2).
        if answer.is_acknowledgement() { self.poll(sap) } else { Ok(answer) }
    }
}

/// The fixed part of a diagnosis.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Diagnosis {
    /// Station_Status.
    pub status: StationStatus,
    /// Diag_Master_Add.
    pub master_add: u8,
    /// Ident_Number.
    pub ident: u16,
}

impl Diagnosis {
    /// Requires that all `bits` are 1.
    ///
    /// # Errors
    /// [`StepError::Unexpected`].
    pub(crate) fn require_set(&self, bits: StationStatus) -> StepResult {
        require(self.status.contains(bits), Expected::set(bits))
    }

    /// Requires that all `bits` are 0.
    ///
    /// # Errors
    /// [`StepError::Unexpected`].
    pub(crate) fn require_clear(&self, bits: StationStatus) -> StepResult {
        require(!self.status.intersects(bits), Expected::clear(bits))
    }

    /// Requires this Diag_Master_Add.
    ///
    /// # Errors
    /// [`StepError::Unexpected`].
    pub(crate) fn require_master(&self, master: u8) -> StepResult {
        require(self.master_add == master, Expected::MasterAdd(master))
    }
}
