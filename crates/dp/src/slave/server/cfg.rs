//! Chk_Cfg and Get_Cfg: the configuration of the data exchange. profibus-wire 2.6 and 2.7.

use super::{NO_RESOURCE, Server};
use crate::link::{Indication, Reply};
use crate::slave::{CfgFault, Device, ExchangeState, Fault, Owner, SlaveState};
use profivac_wire::MAX_DU;
use profivac_wire::cfg::Lengths;
use profivac_wire::control::Status;

impl<D: Device, const CONNECTIONS: usize> Server<D, CONNECTIONS> {
    /// profibus-wire 2.6 and 3.2, transitions 8 to 11. In WAIT-PRM, and from a foreign master, the slave acknowledges and
    /// ignores the request (profibus-wire 10, point 7).
    pub(super) fn chk_cfg(&mut self, request: &Indication<'_>) -> Reply<'static> {
        let Some(owner) = self.state.owner().filter(|owner| owner.master == request.sa).copied() else {
            return Reply::ShortAck;
        };
        if self.state.is_exchanging() && self.device.get_cfg() == request.du {
            // Transition 10. The device would begin the exchange anew: a task that stands in the outputs would run again.
            return Reply::ShortAck;
        }
        match self.device.chk_cfg(request.du) {
            // Longer images do not fit a telegram: the slave would exchange empty ones.
            Ok(lengths) if usize::from(lengths.inputs.max(lengths.outputs)) > MAX_DU => self.enter_wait_prm(Fault::Cfg),
            Err(CfgFault) => self.enter_wait_prm(Fault::Cfg),
            Ok(lengths) => self.begin_exchange(owner, lengths),
        }
        Reply::ShortAck
    }

    /// Outputs are safe until the first exchange, also where another configuration replaces the present one: the images of
    /// the old configuration have no meaning in the new one.
    fn begin_exchange(&mut self, owner: Owner, lengths: Lengths) {
        // chosen: the slave announces an event that exists already, for a master that does not read the diagnosis first.
        let diag_flag = self.device.diagnosis().event;
        self.enter(SlaveState::DataExch(owner, ExchangeState { lengths, sync: false, freeze: false, diag_flag }));
    }

    /// profibus-wire 2.7
    pub(super) fn get_cfg(&self, request: &Indication<'_>) -> Reply<'_> {
        if !request.du.is_empty() {
            return NO_RESOURCE;
        }
        let cfg = self.device.get_cfg();
        if cfg.len() > MAX_DU { Reply::Status(Status::UserError) } else { Reply::Low(cfg) }
    }
}
