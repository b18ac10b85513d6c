//! Data exchange: what the owner sends and gets, what others may look at, and Global_Control. profibus-wire 2.8 to 2.10.

use super::{Device, ExchangeState, Fault, NO_RESOURCE, Outputs, SERVICE_CLOSED, Slave, SlaveState};
use crate::link::{Indication, Reply};
use profivac_wire::global::{ControlCommand, GlobalControl};
use profivac_wire::{MAX_DU, Sap};

impl<D: Device, const CONNECTIONS: usize> Slave<D, CONNECTIONS> {
    /// profibus-wire 2.8: the input image, DH instead of DL while a diagnosis is pending.
    pub(super) fn data_exchange(&mut self, request: &Indication<'_>) -> Reply {
        let SlaveState::DataExch(owner, exchange) = self.state else { return SERVICE_CLOSED };
        if owner.master != request.sa {
            return SERVICE_CLOSED;
        }
        let expected = usize::from(exchange.lengths.outputs);
        let fits = match request.du.len() {
            length if length == expected => {
                self.store_outputs(request.du, exchange.sync);
                true
            }
            0 if owner.fail_safe => {
                self.set_safe_outputs();
                true
            }
            _ => false,
        };
        if !exchange.freeze {
            self.sample_inputs(exchange);
        }
        let reply = match (self.diagnosis_is_pending(exchange), exchange.lengths.inputs) {
            (true, length) => Reply::High(usize::from(length)),
            (false, length) => image_reply(length),
        };
        if !fits {
            // Answered as usual, then the slave leaves: profibus-wire 10, points 9 and 10.
            self.enter_wait_prm(Fault::None);
        }
        reply
    }

    /// profibus-wire 2.10: the image as Data_Exchange would return it.
    pub(super) fn rd_inp(&mut self, request: &Indication<'_>) -> Reply {
        let SlaveState::DataExch(_, exchange) = self.state else { return SERVICE_CLOSED };
        if !request.du.is_empty() {
            return NO_RESOURCE;
        }
        if !exchange.freeze {
            self.sample_inputs(exchange);
        }
        image_reply(exchange.lengths.inputs)
    }

    /// profibus-wire 2.10: what the process sees, not what Sync holds back.
    pub(super) fn rd_outp(&mut self, request: &Indication<'_>) -> Reply {
        let SlaveState::DataExch(_, exchange) = self.state else { return SERVICE_CLOSED };
        if !request.du.is_empty() {
            return NO_RESOURCE;
        }
        image_reply(exchange.lengths.outputs)
    }

    /// SDN: only Global_Control, and only from the owner during data exchange. profibus-wire 2.9.
    pub(super) fn unconfirmed(&mut self, request: &Indication<'_>) {
        let SlaveState::DataExch(owner, exchange) = self.state else { return };
        let Ok(control) = GlobalControl::parse(request.du) else { return };
        if request.sap == Sap::GlobalControl && owner.master == request.sa && control.selects(owner.group) {
            self.restart_watchdog(request.sa);
            self.control(exchange, control.command);
        }
    }

    fn control(&mut self, mut exchange: ExchangeState, command: ControlCommand) {
        let features = self.device.features();
        let sync = command.intersects(ControlCommand::SYNC | ControlCommand::UNSYNC);
        let freeze = command.intersects(ControlCommand::FREEZE | ControlCommand::UNFREEZE);
        // Both bits of a pair cancel, and what cancels asks for nothing that must be supported.
        let begins = |on, off| command.contains(on) && !command.contains(off);
        let unsupported = (begins(ControlCommand::SYNC, ControlCommand::UNSYNC) && !features.sync)
            || (begins(ControlCommand::FREEZE, ControlCommand::UNFREEZE) && !features.freeze)
            // profibus-wire 10, point 14
            || command.intersects(ControlCommand::RESERVED);
        if command.contains(ControlCommand::CLEAR_DATA) {
            self.set_safe_outputs();
        }
        if sync && features.sync {
            self.apply_held_outputs(exchange);
            exchange.sync = !command.contains(ControlCommand::UNSYNC);
        }
        if freeze && features.freeze {
            exchange.freeze = !command.contains(ControlCommand::UNFREEZE);
            self.sample_inputs(exchange);
        }
        if let SlaveState::DataExch(owner, present) = &mut self.state {
            owner.not_supported |= unsupported;
            *present = ExchangeState { diag_flag: present.diag_flag || unsupported, ..exchange };
        }
    }

    /// The outputs that Sync holds back reach the process.
    fn apply_held_outputs(&mut self, exchange: ExchangeState) {
        if core::mem::take(&mut self.held_valid) {
            self.outputs = self.held_outputs;
            let image = self.outputs.get(..usize::from(exchange.lengths.outputs)).unwrap_or_default();
            self.device.outputs(Outputs::Data(image));
        }
    }

    /// The diagnosis flag stays as long as the device has a static diagnosis. profibus-wire 3.3.
    fn diagnosis_is_pending(&mut self, exchange: ExchangeState) -> bool {
        exchange.diag_flag || self.device.diagnosis().static_diag
    }

    fn sample_inputs(&mut self, exchange: ExchangeState) {
        if let Some(image) = self.inputs.get_mut(..usize::from(exchange.lengths.inputs)) {
            self.device.inputs(image);
        }
    }

    fn store_outputs(&mut self, du: &[u8], sync: bool) {
        let image = if sync { &mut self.held_outputs } else { &mut self.outputs };
        if let Some(place) = image.get_mut(..du.len()) {
            place.copy_from_slice(du);
        }
        if sync {
            self.held_valid = true;
        } else {
            self.device.outputs(Outputs::Data(du));
        }
    }

    pub(super) fn set_safe_outputs(&mut self) {
        self.outputs = [0; MAX_DU];
        self.held_valid = false;
        self.device.outputs(Outputs::Safe);
    }
}

/// An image of so many octets, SC where there are none.
const fn image_reply(length: u8) -> Reply {
    if length == 0 { Reply::ShortAck } else { Reply::Low(length as usize) }
}
