//! Data exchange with the owner, RD_Inp and RD_Outp for all masters, and Global_Control. profibus-wire 2.8 to 2.10.

use super::{NO_RESOURCE, SERVICE_CLOSED, Server};
use crate::link::{BitTime, Indication, Reply};
use crate::slave::{Device, ExchangeState, Fault, Outputs, Owner, SlaveState};
use profivac_wire::cfg::Lengths;
use profivac_wire::global::{ControlCommand, GlobalControl};
use profivac_wire::{MAX_DU, Sap};

/// A Data_Exchange whose answer may be prepared.
#[derive(Clone, Copy, Debug)]
pub(in crate::slave) struct Exchange {
    pub(in crate::slave) master: u8,
    pub(in crate::slave) lengths: Lengths,
}

impl<D: Device, const CONNECTIONS: usize> Server<D, CONNECTIONS> {
    /// profibus-wire 2.8: the input image, DH instead of DL while a diagnosis is pending.
    #[inline]
    pub(super) fn data_exchange(&mut self, request: &Indication<'_>) -> Reply<'_> {
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
        let pending = self.diagnosis_is_pending(exchange);
        if !fits {
            // The slave answers as usual and leaves data exchange: profibus-wire 10, points 9 and 10.
            self.enter_wait_prm(Fault::None);
        }
        match pending {
            true => Reply::High(image(&self.inputs, exchange.lengths.inputs)),
            false => image_reply(&self.inputs, exchange.lengths.inputs),
        }
    }

    /// The next Data_Exchange, if its answer may be prepared: after an exchange, without Sync and Freeze, with inputs, and
    /// if the device allows it.
    #[inline]
    pub(in crate::slave) fn next_exchange(&self) -> Option<Exchange> {
        let SlaveState::DataExch(Owner { master, .. }, ExchangeState { lengths, sync, freeze, .. }) = &self.state
        else {
            return None;
        };
        let outputs = image(&self.outputs, lengths.outputs);
        let is_steady = self.outputs_valid && !sync && !freeze && lengths.inputs > 0;
        (is_steady && self.device.keeps_inputs(outputs, outputs))
            .then_some(Exchange { master: *master, lengths: *lengths })
    }

    /// Writes the inputs of the next Data_Exchange to `image`. Returns whether a diagnosis is pending.
    #[inline]
    pub(in crate::slave) fn next_inputs(&mut self, image: &mut [u8]) -> bool {
        self.note_diagnosis_change();
        self.device.inputs(image);
        match self.state {
            SlaveState::DataExch(_, exchange) => self.diagnosis_is_pending(exchange),
            SlaveState::WaitPrm(_) | SlaveState::WaitCfg(_) => false,
        }
    }

    /// Executes the expected Data_Exchange, which ended at `end`, except for the reply, which is prepared. Returns `false`, and changes
    /// nothing, if the inputs follow the new outputs.
    #[inline]
    pub(in crate::slave) fn exchange_prepared(&mut self, end: BitTime, du: &[u8]) -> bool {
        let Some(outputs) = self.outputs.get_mut(..du.len()) else { return false };
        if !self.device.keeps_inputs(outputs, du) {
            return false;
        }
        outputs.copy_from_slice(du);
        self.device.outputs(Outputs::Data(du));
        self.now = end;
        if let SlaveState::DataExch(Owner { watchdog: Some(watchdog), .. }, _) = &mut self.state {
            watchdog.deadline = end + watchdog.period_tbit;
        }
        true
    }

    /// profibus-wire 2.10: the image as Data_Exchange would return it.
    pub(super) fn rd_inp(&mut self, request: &Indication<'_>) -> Reply<'_> {
        let SlaveState::DataExch(_, exchange) = self.state else { return SERVICE_CLOSED };
        if !request.du.is_empty() {
            return NO_RESOURCE;
        }
        if !exchange.freeze {
            self.sample_inputs(exchange);
        }
        image_reply(&self.inputs, exchange.lengths.inputs)
    }

    /// profibus-wire 2.10: the outputs that the process has, not those that Sync holds back.
    pub(super) fn rd_outp(&self, request: &Indication<'_>) -> Reply<'_> {
        let SlaveState::DataExch(_, exchange) = self.state else { return SERVICE_CLOSED };
        if !request.du.is_empty() {
            return NO_RESOURCE;
        }
        image_reply(&self.outputs, exchange.lengths.outputs)
    }

    /// Executes an SDN: only Global_Control, and only from the owner during data exchange. profibus-wire 2.9.
    pub(in crate::slave) fn unconfirmed(&mut self, request: &Indication<'_>) {
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
        // Both bits of a pair cancel each other, so such a command requires no feature.
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

    /// Gives the outputs that Sync holds back to the process.
    fn apply_held_outputs(&mut self, exchange: ExchangeState) {
        if core::mem::take(&mut self.held_valid) {
            self.outputs = self.held_outputs;
            self.outputs_valid = true;
            self.device.outputs(Outputs::Data(image(&self.outputs, exchange.lengths.outputs)));
        }
    }

    /// The diagnosis flag stays set as long as the device has a static diagnosis. profibus-wire 3.3.
    #[inline]
    fn diagnosis_is_pending(&self, exchange: ExchangeState) -> bool {
        exchange.diag_flag || self.device.diagnosis().static_diag
    }

    #[inline]
    fn sample_inputs(&mut self, exchange: ExchangeState) {
        if let Some(image) = self.inputs.get_mut(..usize::from(exchange.lengths.inputs)) {
            self.device.inputs(image);
        }
    }

    #[inline]
    fn store_outputs(&mut self, du: &[u8], sync: bool) {
        let image = if sync { &mut self.held_outputs } else { &mut self.outputs };
        if let Some(target) = image.get_mut(..du.len()) {
            target.copy_from_slice(du);
        }
        if sync {
            self.held_valid = true;
        } else {
            self.outputs_valid = true;
            self.device.outputs(Outputs::Data(du));
        }
    }

    pub(super) fn set_safe_outputs(&mut self) {
        self.outputs = [0; MAX_DU];
        self.outputs_valid = false;
        self.held_valid = false;
        self.device.outputs(Outputs::Safe);
    }
}

#[inline]
fn image(octets: &[u8; MAX_DU], length: u8) -> &[u8] {
    octets.get(..usize::from(length)).unwrap_or_default()
}

/// An image of this length; SC if it has no octets.
#[inline]
fn image_reply(octets: &[u8; MAX_DU], length: u8) -> Reply<'_> {
    if length == 0 { Reply::ShortAck } else { Reply::Low(image(octets, length)) }
}
