//! Slave_Diag: the diagnosis of a slave. profibus-wire 2.3 and 3.3.

use super::{NO_RESOURCE, Server, prepared};
use crate::link::{Indication, Reply};
use crate::slave::{Device, Fault, SlaveState};
use profivac_wire::diag::{NO_MASTER, SlaveDiag, StationStatus};

impl<D: Device, const CONNECTIONS: usize> Server<D, CONNECTIONS> {
    /// profibus-wire 2.3; a request with data is refused, profibus-wire 10, point 8.
    pub(super) fn slave_diag(&mut self, request: &Indication<'_>) -> Reply<'_> {
        if !request.du.is_empty() {
            return NO_RESOURCE;
        }
        let diagnosis = self.device.diagnosis();
        let mut status = StationStatus::ALWAYS_ONE | self.state_bits();
        status.set(StationStatus::EXT_DIAG, diagnosis.event);
        status.set(StationStatus::STAT_DIAG, diagnosis.static_diag);
        let diag = SlaveDiag {
            status,
            master_add: self.state.owner().map_or(NO_MASTER, |owner| owner.master),
            ident: self.device.ident_number(),
            ext_diag: diagnosis.blocks,
        };
        let emitted = diag.emit(&mut self.du);
        // The owner has fetched the diagnosis: profibus-wire 3.3. One that does not fit a telegram stays pending.
        if emitted.is_ok()
            && let SlaveState::DataExch(owner, exchange) = &mut self.state
            && owner.master == request.sa
        {
            exchange.diag_flag = false;
            self.device.diagnosis_fetched();
        }
        prepared(&self.du, emitted)
    }

    /// The bits of the diagnosis that follow from the state alone.
    fn state_bits(&self) -> StationStatus {
        let mut status = match self.state {
            SlaveState::WaitPrm(fault) => {
                StationStatus::STATION_NOT_READY
                    | StationStatus::PRM_REQ
                    | match fault {
                        Fault::None => StationStatus::empty(),
                        Fault::Prm => StationStatus::PRM_FAULT,
                        Fault::Cfg => StationStatus::CFG_FAULT,
                    }
            }
            SlaveState::WaitCfg(_) => StationStatus::STATION_NOT_READY,
            SlaveState::DataExch(_, exchange) => {
                let mut status = StationStatus::empty();
                status.set(StationStatus::SYNC_MODE, exchange.sync);
                status.set(StationStatus::FREEZE_MODE, exchange.freeze);
                status
            }
        };
        if let Some(owner) = self.state.owner() {
            status.set(StationStatus::WD_ON, owner.watchdog.is_some());
            status.set(StationStatus::NOT_SUPPORTED, owner.not_supported);
        }
        status
    }
}
