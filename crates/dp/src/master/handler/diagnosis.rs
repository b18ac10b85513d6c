//! The evaluation of a diagnosis in the handler of the slave. profibus-wire 2.3, 3.9 and 3.10.

use super::super::event::{EventKind, ExchangeError};
use super::super::services::MIN_SLAVE_DIAG;
use super::super::state::HandlerState;
use super::{Context, Handler};
use crate::link::active::Answer;
use heapless::Vec;
use profivac_wire::control::Status;
use profivac_wire::diag::{NO_MASTER, SlaveDiag, StationStatus};

/// The meaning of a diagnosis for a slave that was parameterised.
enum Assessment {
    Ready,
    /// The diagnosis must be read again.
    NotReady,
    Static,
    Fault(ExchangeError),
}

/// The last diagnosis.
#[derive(Clone, Debug)]
pub(super) struct Diagnosis<const OCTETS: usize> {
    status: StationStatus,
    master_add: u8,
    ident: u16,
    ext_diag: Vec<u8, OCTETS>,
}

impl<const OCTETS: usize> Handler<OCTETS> {
    pub(in crate::master) fn diagnosis(&self) -> Option<SlaveDiag<'_>> {
        let Diagnosis { status, master_add, ident, ext_diag } = self.diagnosis.as_ref()?;
        Some(SlaveDiag { status: *status, master_add: *master_add, ident: *ident, ext_diag })
    }

    /// An answer to Slave_Diag.
    pub(super) fn diagnosed(&mut self, answer: &Answer<'_>, context: &mut Context<'_>) {
        self.count_repetitions(answer);
        if !matches!(answer.status, Status::DataLow | Status::DataHigh) {
            return self.restart(ExchangeError::Refused(answer.status), context);
        }
        let Ok(diag) = SlaveDiag::parse(answer.du) else {
            return self
                .restart(ExchangeError::Length { expected: MIN_SLAVE_DIAG, received: answer.du.len() }, context);
        };
        self.misses = 0;
        self.counters.diagnoses = self.counters.diagnoses.wrapping_add(1);
        self.store(&diag, context);
        match self.state {
            HandlerState::Diag1 => match self.foreign_reason(&diag, context.address) {
                Some(error) => self.restart(error, context),
                None => self.enter(HandlerState::Prm, context),
            },
            _ => self.evaluate(&diag, context),
        }
    }

    /// Evaluates the diagnosis of a slave that was parameterised.
    fn evaluate(&mut self, diag: &SlaveDiag<'_>, context: &mut Context<'_>) {
        let waiting = match self.state {
            HandlerState::Diag2 { since, prm_reqs } => Some((since, prm_reqs)),
            _ => None,
        };
        match (self.assess(diag, context.address), waiting) {
            (Assessment::Ready, None) => self.state = HandlerState::Data { diag: false },
            (Assessment::Ready, Some(_)) => {
                self.counters.starts = self.counters.starts.wrapping_add(1);
                self.enter(HandlerState::Data { diag: false }, context);
            }
            (Assessment::Fault(ExchangeError::PrmReq), Some((since, prm_reqs)))
                if prm_reqs < self.diag_update_delay =>
            {
                self.state = HandlerState::Diag2 { since, prm_reqs: prm_reqs.saturating_add(1) };
            }
            (Assessment::Fault(error), _) => self.restart(error, context),
            (Assessment::NotReady, Some((since, _))) if context.now < since + context.settings.ready_tbit => {}
            (Assessment::NotReady, _) => self.restart(ExchangeError::NotReady, context),
            (Assessment::Static, Some(_)) => self.report(ExchangeError::StaticDiag, context),
            // The inputs are not valid while Stat_Diag is set: profibus-wire 3.3.
            (Assessment::Static, None) => {
                self.report(ExchangeError::StaticDiag, context);
                self.enter(HandlerState::Diag2 { since: context.now, prm_reqs: 0 }, context);
            }
        }
    }

    /// profibus-wire 3.9 and 3.10
    fn assess(&self, diag: &SlaveDiag<'_>, address: u8) -> Assessment {
        let status = diag.status;
        match self.foreign_reason(diag, address) {
            Some(error) => Assessment::Fault(error),
            None if status.contains(StationStatus::PRM_FAULT) => Assessment::Fault(ExchangeError::PrmFault),
            None if status.contains(StationStatus::CFG_FAULT) => Assessment::Fault(ExchangeError::CfgFault),
            None if status.contains(StationStatus::PRM_REQ) || diag.master_add == NO_MASTER => {
                Assessment::Fault(ExchangeError::PrmReq)
            }
            None if status.contains(StationStatus::STATION_NOT_READY) => Assessment::NotReady,
            None if status.contains(StationStatus::STAT_DIAG) => Assessment::Static,
            None => Assessment::Ready,
        }
    }

    /// The reason why this master must not parameterise the slave: another master owns it, or it is another device.
    ///
    /// chosen: the master does not try a wrong ident number. The slave would refuse it, but only after its outputs became
    /// safe.
    fn foreign_reason(&self, diag: &SlaveDiag<'_>, address: u8) -> Option<ExchangeError> {
        match (diag.master_add, diag.ident) {
            (master, _) if master != NO_MASTER && master != address => Some(ExchangeError::Owned { master }),
            (_, received) if received != self.ident => Some(ExchangeError::Ident { expected: self.ident, received }),
            _ => None,
        }
    }

    /// Stores the diagnosis, cut to the room for it, and reports it if it is new.
    fn store(&mut self, diag: &SlaveDiag<'_>, context: &mut Context<'_>) {
        let room = diag.ext_diag.len().min(OCTETS);
        let mut status = diag.status;
        if room < diag.ext_diag.len() {
            status |= StationStatus::EXT_DIAG_OVERFLOW;
        }
        let kept = SlaveDiag { status, ext_diag: diag.ext_diag.get(..room).unwrap_or_default(), ..*diag };
        if self.diagnosis() == Some(kept) {
            return;
        }
        let ext_diag = Vec::from_slice(kept.ext_diag).unwrap_or_default();
        let SlaveDiag { master_add, ident, .. } = kept;
        self.diagnosis = Some(Diagnosis { status, master_add, ident, ext_diag });
        self.push_event(EventKind::Diagnosis, context);
    }
}
