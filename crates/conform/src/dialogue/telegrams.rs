//! Requests as octets, and answers parsed.

use super::step::{StepError, StepResult};
use crate::expected::{Expected, Pdu};
use crate::probe::Received;
use profivac_wire::acyclic::{self, Response};
use profivac_wire::control::{Control, FrameCount, Function, Status};
use profivac_wire::global::ControlCommand;
use profivac_wire::prm::SetPrm;
use profivac_wire::sap::{MASTER_MS0, MASTER_MS1, MASTER_MS2};
use profivac_wire::{DataTelegram, MAX_DU, MAX_TELEGRAM, Sap, Telegram};

/// A valid answer of the slave. SC is the same as SD1 with NR (profibus-wire 1.5). Addresses and access points are not
/// compared with the request: two rules of their own do that.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Answer {
    /// Its status.
    pub status: Status,
    /// Its data unit.
    pub du: Vec<u8>,
}

impl Answer {
    /// Whether it is SC or NR.
    #[must_use]
    pub fn is_acknowledgement(&self) -> bool {
        self.status == Status::NoReply && self.du.is_empty()
    }

    /// Whether it is RS.
    #[must_use]
    pub fn is_closed(&self) -> bool {
        self.status == Status::ServiceNotActivated
    }

    /// Whether it has the status of an answer with data, DL or DH.
    #[must_use]
    pub const fn has_data_status(&self) -> bool {
        matches!(self.status, Status::DataLow | Status::DataHigh)
    }
}

/// The access point of the master for an access point of the slave (profibus-wire 2.1).
const fn ssap_of(sap: Sap) -> Option<u8> {
    match sap {
        Sap::Default => None,
        Sap::Ms1 => Some(MASTER_MS1),
        Sap::Ms2(_) | Sap::ResourceManager => Some(MASTER_MS2),
        _ => Some(MASTER_MS0),
    }
}

/// FC of FDL status.
pub const FDL_STATUS: u8 = request(Function::FdlStatus, FrameCount::Uncounted);

/// FC of a first request with data, high priority.
pub const SRD_HIGH_FIRST: u8 = request(Function::SrdHigh, FrameCount::First);

/// FC of Global_Control: data without an acknowledgement, high priority.
const SDN_HIGH: u8 = request(Function::SdnHigh, FrameCount::Uncounted);

const fn request(function: Function, count: FrameCount) -> u8 {
    Control::Request { function, count }.to_octet()
}

/// The octets of Global_Control with a command for the slaves of a group; group 0 is all slaves.
pub fn global_control(da: u8, sa: u8, command: ControlCommand, group: u8) -> Vec<u8> {
    octets(da, sa, Sap::GlobalControl, SDN_HIGH, &[command.bits(), group])
}

/// The octets of a telegram.
pub fn octets(da: u8, sa: u8, sap: Sap, fc: u8, du: &[u8]) -> Vec<u8> {
    telegram_octets(DataTelegram { da, sa, dsap: sap.to_octet(), ssap: ssap_of(sap), fc, du })
}

/// The octets of a data telegram.
pub fn telegram_octets(telegram: DataTelegram<'_>) -> Vec<u8> {
    let mut out = [0; MAX_TELEGRAM];
    let length = Telegram::Data(telegram).emit(&mut out).unwrap_or_default();
    out.get(..length).unwrap_or_default().to_vec()
}

/// The octets of a Set_Prm.
pub fn set_prm_octets(prm: &SetPrm<'_>) -> Vec<u8> {
    let mut du = [0; MAX_DU];
    let length = prm.emit(&mut du).unwrap_or_default();
    du.get(..length).unwrap_or_default().to_vec()
}

/// The octets of a PDU.
pub fn request_octets(request: &acyclic::Request<'_>) -> Vec<u8> {
    let mut du = [0; MAX_DU];
    let length = request.emit(&mut du).unwrap_or_default();
    du.get(..length).unwrap_or_default().to_vec()
}

/// Parses an answer.
///
/// # Errors
/// [`StepError::Unexpected`] if it is not a valid answer.
pub fn parse_answer(received: &Received) -> StepResult<Answer> {
    let invalid = || StepError::Unexpected(Expected::Answer);
    let Received::Telegram(octets) = received else { return Err(invalid()) };
    match Telegram::parse(octets) {
        Ok(Telegram::ShortAck) => Ok(Answer { status: Status::NoReply, du: Vec::new() }),
        Ok(Telegram::Data(data)) => match data.control() {
            Control::Response { status, .. } => Ok(Answer { status, du: data.du.to_vec() }),
            Control::Request { .. } => Err(invalid()),
        },
        Ok(Telegram::Token { .. }) | Err(_) => Err(invalid()),
    }
}

/// Parses a response of DP-V1.
///
/// # Errors
/// [`StepError::Unexpected`] with `expected` if it is none.
pub fn response(du: &[u8], expected: Pdu) -> StepResult<Response<'_>> {
    Response::parse(du).map_err(|_| StepError::Unexpected(Expected::Pdu(expected)))
}
