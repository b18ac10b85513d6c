//! DP-V1 on a slave: whether the device-related blocks of its diagnosis are alarms and status messages. profibus-wire 2.3.2.

use super::cycle::{Answer, Request};
use profivac_sim::describe::Hex;
use profivac_wire::Sap;
use profivac_wire::diag::{SlaveDiag, StationStatus};
use profivac_wire::ext_diag::{Message, MessageKind};
use profivac_wire::prm::{Dpv1Status1, Dpv1Status2, Dpv1Status3, PrmStatus, SetPrm};

/// The format of the device-related blocks in the diagnosis of a slave.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum DeviceBlocks {
    /// Each block is an alarm or a status message.
    Messages,
    /// Each block has the format of the vendor: the device has no DP-V1.
    Vendor,
    /// Each block has the format of the vendor, but a DP-V1 slave may send Module_Status also in DP-V0 mode.
    VendorOrModuleStatus,
    /// Each block may be an alarm, a status message, or have the format of the vendor.
    Unknown,
}

impl DeviceBlocks {
    /// A block of this format as text. `content` is the block without its header.
    #[must_use]
    pub fn text(self, content: &[u8]) -> String {
        if content.is_empty() {
            return "an empty device-related block".to_owned();
        }
        let octets = Hex(content);
        let message = Message::parse(content).ok().filter(|message| !message.kind.is_reserved());
        match (self, message) {
            (Self::Messages, Some(message)) => message.to_string(),
            (Self::Unknown, Some(message))
            | (Self::VendorOrModuleStatus, Some(message @ Message { kind: MessageKind::MODULE_STATUS, .. })) => {
                format!("device-related octets {octets} (as DP-V1: {message})")
            }
            (Self::Vendor | Self::VendorOrModuleStatus, _) => format!("vendor-specific octets {octets}"),
            (Self::Messages | Self::Unknown, None) => format!("device-related octets {octets}"),
        }
    }
}

/// The mode of a slave.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Mode {
    DpV0,
    DpV1,
}

/// What the traffic of one slave shows about DP-V1. It takes every answer of the slave, in the order of the line.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Dpv1Traffic {
    /// The Ident_Number of the last diagnosis.
    ident: Option<u16>,
    /// The mode of the last Set_Prm that no diagnosis has refused, or of a service that only a slave in this mode answers.
    mode: Option<Mode>,
    /// The slave has worked in DP-V1 mode or has answered on MS2, which needs no DPV1_Enable.
    has_dpv1: bool,
}

impl Dpv1Traffic {
    /// Takes an answer of the slave.
    pub fn answered(&mut self, request: &Request, answer: Answer<'_>) {
        match request.sap {
            Sap::SetPrm if answer.is_ack() => self.parameterised(&request.du),
            Sap::SlaveDiag => self.diagnosed(answer.du),
            Sap::Ms1 | Sap::Alarm if !answer.is_refusal() => self.enter(Mode::DpV1),
            Sap::Ms2(_) | Sap::ResourceManager if !answer.is_refusal() => self.has_dpv1 = true,
            _ => {}
        }
    }

    /// The format of the device-related blocks. `dpv1_slave` is DPV1_Slave of the GSD file, from whatever knows the device; `None`
    /// if it is not known. It decides before the traffic: a mode does not change it (profibus-wire 2.3.2).
    #[must_use]
    pub const fn device_blocks(&self, dpv1_slave: Option<bool>) -> DeviceBlocks {
        match (dpv1_slave, self.mode, self.has_dpv1) {
            (Some(true), _, _) | (None, Some(Mode::DpV1), _) | (None, None, true) => DeviceBlocks::Messages,
            (Some(false), _, _) => DeviceBlocks::Vendor,
            (None, Some(Mode::DpV0), false) => DeviceBlocks::VendorOrModuleStatus,
            // chosen: a DP-V1 slave in DP-V0 mode may have a second format, and the traffic does not show whether it has.
            (None, Some(Mode::DpV0), true) | (None, None, false) => DeviceBlocks::Unknown,
        }
    }

    /// Takes an acknowledged Set_Prm. One without Lock_Req, or with Unlock_Req, sets no mode (profibus-wire 2.4).
    fn parameterised(&mut self, du: &[u8]) {
        let Ok(prm) = SetPrm::parse(du) else { return };
        if prm.status.contains(PrmStatus::LOCK_REQ) && !prm.status.contains(PrmStatus::UNLOCK_REQ) {
            self.change(requested_mode(prm.user));
        }
    }

    fn enter(&mut self, mode: Mode) {
        self.change(Some(mode));
    }

    fn change(&mut self, mode: Option<Mode>) {
        self.has_dpv1 |= self.mode == Some(Mode::DpV1);
        self.mode = mode;
    }

    /// Takes a diagnosis: another device may be at the address, or the slave has refused Set_Prm.
    fn diagnosed(&mut self, du: &[u8]) {
        let Ok(diag) = SlaveDiag::parse(du) else { return };
        if self.ident.is_some_and(|known| known != diag.ident) {
            *self = Self::default();
        }
        self.ident = Some(diag.ident);
        if diag.status.contains(StationStatus::PRM_FAULT) {
            self.mode = None;
        }
    }
}

/// The mode that user parameters request. A slave in DP-V1 mode has three status octets and refuses reserved bits in them (profibus-wire
/// 2.4): fewer octets, or a first one without DPV1_Enable, are of DP-V0. `None` for reserved bits: the octets may be the vendor's.
fn requested_mode(user: &[u8]) -> Option<Mode> {
    let [first, second, third, ..] = *user else { return Some(Mode::DpV0) };
    let (first, second) = (Dpv1Status1::from_bits_retain(first), Dpv1Status2::from_bits_retain(second));
    let has_reserved = first.intersects(Dpv1Status1::RESERVED)
        || second.intersects(Dpv1Status2::RESERVED)
        || Dpv1Status3::from_bits_retain(third).intersects(Dpv1Status3::RESERVED);
    match first.contains(Dpv1Status1::DPV1_ENABLE) {
        true => (!has_reserved).then_some(Mode::DpV1),
        false => Some(Mode::DpV0),
    }
}
