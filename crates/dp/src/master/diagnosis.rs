//! What a diagnosis means for the slave it comes from. profibus-wire 2.3, 3.9 and 3.10.

use super::event::{Trouble, What};
use super::slave::{Context, Handler};
use super::state::State;
use crate::link::active::Answer;
use heapless::Vec;
use profivac_wire::control::Status;
use profivac_wire::diag::{NO_MASTER, SlaveDiag, StationStatus};

/// What a diagnosis says about a slave that was parameterised.
enum Verdict {
    Ready,
    /// To be read again.
    NotReady,
    Static,
    Fault(Trouble),
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
    pub(super) fn diagnosis(&self) -> Option<SlaveDiag<'_>> {
        let Diagnosis { status, master_add, ident, ext_diag } = self.diagnosis.as_ref()?;
        Some(SlaveDiag { status: *status, master_add: *master_add, ident: *ident, ext_diag })
    }

    /// An answer to Slave_Diag.
    pub(super) fn diagnosed(&mut self, answer: &Answer<'_>, context: &mut Context<'_>) {
        self.count_retries(answer);
        if !matches!(answer.status, Status::DataLow | Status::DataHigh) {
            return self.restart(Trouble::Refused(answer.status), context);
        }
        let Ok(diag) = SlaveDiag::parse(answer.du) else {
            return self.restart(Trouble::Length { expected: 6, received: answer.du.len() }, context);
        };
        self.misses = 0;
        self.counters.diagnoses = self.counters.diagnoses.wrapping_add(1);
        self.keep(&diag, context);
        match self.state {
            State::Diag1 => match self.stranger(&diag, context.address) {
                Some(trouble) => self.restart(trouble, context),
                None => self.enter(State::Prm, context),
            },
            _ => self.judge(&diag, context),
        }
    }

    /// What the diagnosis of a slave that was parameterised leads to.
    fn judge(&mut self, diag: &SlaveDiag<'_>, context: &mut Context<'_>) {
        let waiting = match self.state {
            State::Diag2 { since, prm_reqs } => Some((since, prm_reqs)),
            _ => None,
        };
        match (self.verdict(diag, context.address), waiting) {
            (Verdict::Ready, None) => self.state = State::Data { diag: false },
            (Verdict::Ready, Some(_)) => {
                self.counters.starts = self.counters.starts.wrapping_add(1);
                self.enter(State::Data { diag: false }, context);
            }
            (Verdict::Fault(Trouble::PrmReq), Some((since, prm_reqs))) if prm_reqs < self.diag_update_delay => {
                self.state = State::Diag2 { since, prm_reqs: prm_reqs.saturating_add(1) };
            }
            (Verdict::Fault(trouble), _) => self.restart(trouble, context),
            (Verdict::NotReady, Some((since, _))) if context.now < since + context.settings.ready_tbit => {}
            (Verdict::NotReady, _) => self.restart(Trouble::NotReady, context),
            (Verdict::Static, Some(_)) => self.report(Trouble::StaticDiag, context),
            // The inputs are not valid as long as it stays: profibus-wire 3.3.
            (Verdict::Static, None) => {
                self.report(Trouble::StaticDiag, context);
                self.enter(State::Diag2 { since: context.now, prm_reqs: 0 }, context);
            }
        }
    }

    /// profibus-wire 3.9 and 3.10
    fn verdict(&self, diag: &SlaveDiag<'_>, address: u8) -> Verdict {
        let status = diag.status;
        match self.stranger(diag, address) {
            Some(trouble) => Verdict::Fault(trouble),
            None if status.contains(StationStatus::PRM_FAULT) => Verdict::Fault(Trouble::PrmFault),
            None if status.contains(StationStatus::CFG_FAULT) => Verdict::Fault(Trouble::CfgFault),
            None if status.contains(StationStatus::PRM_REQ) || diag.master_add == NO_MASTER => {
                Verdict::Fault(Trouble::PrmReq)
            }
            None if status.contains(StationStatus::STATION_NOT_READY) => Verdict::NotReady,
            None if status.contains(StationStatus::STAT_DIAG) => Verdict::Static,
            None => Verdict::Ready,
        }
    }

    /// Why the slave must not be parameterised by us: another master owns it, or it is another device.
    ///
    /// free choice: a wrong ident number is not tried. The slave would refuse it, but only after its outputs went safe.
    fn stranger(&self, diag: &SlaveDiag<'_>, address: u8) -> Option<Trouble> {
        match (diag.master_add, diag.ident) {
            (master, _) if master != NO_MASTER && master != address => Some(Trouble::Owned { master }),
            (_, received) if received != self.ident => Some(Trouble::Ident { expected: self.ident, received }),
            _ => None,
        }
    }

    /// Keeps the diagnosis, as much of it as there is room for, and tells if it is a new one.
    fn keep(&mut self, diag: &SlaveDiag<'_>, context: &mut Context<'_>) {
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
        self.note(What::Diagnosis, context);
    }
}
