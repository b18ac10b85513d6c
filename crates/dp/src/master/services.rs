//! The single requests of DP-V0, for tools: to be handed to [`Master::submit`](super::Master::submit). None of them changes
//! a slave but [`set_slave_add`]; there is no Set_Prm among them. profibus-wire 2.
//!
//! What [`Master::take`](super::Master::take) returns then is read by the functions of the second half. The link layer has
//! matched the answer by source, access points, function code and form; they look at its status and its length.

use crate::link::active::{Answer, Confirmation, Failure, Request};
use core::fmt;
use profivac_wire::Sap;
use profivac_wire::cfg::{self, CfgError, Lengths};
use profivac_wire::control::{Function, StationType, Status};
use profivac_wire::diag::SlaveDiag;
use profivac_wire::sap::MASTER_MS0;

/// FDL status: who is there.
#[must_use]
pub const fn fdl_status(da: u8) -> Request<'static> {
    Request { da, function: Function::FdlStatus, dsap: None, ssap: None, du: &[] }
}

/// Slave_Diag.
#[must_use]
pub const fn slave_diag(da: u8) -> Request<'static> {
    ms0(da, Sap::SlaveDiag, &[])
}

/// Get_Cfg.
#[must_use]
pub const fn get_cfg(da: u8) -> Request<'static> {
    ms0(da, Sap::GetCfg, &[])
}

/// RD_Inp.
#[must_use]
pub const fn rd_inp(da: u8) -> Request<'static> {
    ms0(da, Sap::RdInp, &[])
}

/// RD_Outp.
#[must_use]
pub const fn rd_outp(da: u8) -> Request<'static> {
    ms0(da, Sap::RdOutp, &[])
}

/// Set_Slave_Add, with the data unit that [`SetSlaveAdd`](profivac_wire::address::SetSlaveAdd) emits.
#[must_use]
pub const fn set_slave_add(da: u8, du: &[u8]) -> Request<'_> {
    ms0(da, Sap::SetSlaveAdd, du)
}

/// Data_Exchange: SRD high without access points.
pub(super) const fn data_exchange(da: u8, du: &[u8]) -> Request<'_> {
    Request { da, function: Function::SrdHigh, dsap: None, ssap: None, du }
}

/// A service of the relation between master and slave: SRD high.
pub(super) const fn ms0(da: u8, sap: Sap, du: &[u8]) -> Request<'_> {
    Request { da, function: Function::SrdHigh, dsap: sap.to_octet(), ssap: Some(MASTER_MS0), du }
}

/// Why a request has no result.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ServiceError {
    /// No answer came that fits the request.
    Failed(Failure),
    /// The station answers like this.
    Refused(Status),
    /// The data unit of the answer has the wrong length.
    Length {
        /// How many octets it should have; at least so many in a diagnosis.
        expected: usize,
        /// How many it has.
        received: usize,
    },
    /// What came is no configuration.
    Cfg(CfgError),
    /// Such a message has no answer.
    Unconfirmed,
}

impl fmt::Display for ServiceError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Failed(failure) => failure.fmt(f),
            Self::Refused(Status::ServiceNotActivated) => f.write_str("the service is closed now (RS)"),
            Self::Refused(Status::NoResource) => f.write_str("the request does not fit (RR)"),
            Self::Refused(Status::UserError) => f.write_str("the application of the station has failed (UE)"),
            Self::Refused(Status::NoReply) => f.write_str("it acknowledges where it should answer with data"),
            Self::Refused(status) if status.carries_data() => {
                f.write_str("it answers with data where it should only acknowledge")
            }
            Self::Refused(status) => write!(f, "it answers {status:?}"),
            Self::Length { expected, received } => write!(f, "its answer has {received} octets instead of {expected}"),
            Self::Cfg(defect) => write!(f, "its configuration is none: {defect}"),
            Self::Unconfirmed => f.write_str("such a message has no answer"),
        }
    }
}

impl core::error::Error for ServiceError {}

/// What [`fdl_status`] found out.
///
/// # Errors
/// [`NoResult`].
pub const fn station_type(confirmation: &Confirmation<'_>) -> Result<StationType, ServiceError> {
    match answered(confirmation) {
        Ok(answer) => match answer.status {
            Status::Ok => Ok(answer.station),
            status => Err(ServiceError::Refused(status)),
        },
        Err(reason) => Err(reason),
    }
}

/// What [`slave_diag`] found out.
///
/// # Errors
/// [`NoResult`].
pub fn diagnosis<'a>(confirmation: &Confirmation<'a>) -> Result<SlaveDiag<'a>, ServiceError> {
    let du = data(confirmation)?;
    SlaveDiag::parse(du).map_err(|_| ServiceError::Length { expected: 6, received: du.len() })
}

/// What [`get_cfg`] found out: the identifiers, and how much is exchanged with them.
///
/// # Errors
/// [`NoResult`].
pub fn configuration<'a>(confirmation: &Confirmation<'a>) -> Result<(&'a [u8], Lengths), ServiceError> {
    let du = data(confirmation)?;
    cfg::lengths(du).map(|lengths| (du, lengths)).map_err(ServiceError::Cfg)
}

/// What [`rd_inp`] or [`rd_outp`] found out. `expected` is the length of the image, where it is known: from the own
/// configuration, or from [`configuration`].
///
/// # Errors
/// [`NoResult`].
pub fn image<'a>(confirmation: &Confirmation<'a>, expected: Option<usize>) -> Result<&'a [u8], ServiceError> {
    let answer = answered(confirmation)?;
    // SC where there is nothing to be read: profibus-wire 2.2.
    let du = if answer.status == Status::NoReply { &[] } else { data(confirmation)? };
    match expected {
        Some(expected) if expected != du.len() => Err(ServiceError::Length { expected, received: du.len() }),
        _ => Ok(du),
    }
}

/// Whether [`set_slave_add`] was acknowledged. That is all a slave says: it acknowledges an address that it does not take
/// as well, so whoever wants to be sure asks at the new one.
///
/// # Errors
/// [`NoResult`].
pub const fn acknowledged(confirmation: &Confirmation<'_>) -> Result<(), ServiceError> {
    match answered(confirmation) {
        Ok(Answer { status: Status::NoReply, .. }) => Ok(()),
        Ok(answer) => Err(ServiceError::Refused(answer.status)),
        Err(reason) => Err(reason),
    }
}

const fn answered<'a>(confirmation: &Confirmation<'a>) -> Result<Answer<'a>, ServiceError> {
    match confirmation {
        Confirmation::Answer(answer) => Ok(*answer),
        Confirmation::Failed(failure) => Err(ServiceError::Failed(*failure)),
        Confirmation::Sent => Err(ServiceError::Unconfirmed),
    }
}

const fn data<'a>(confirmation: &Confirmation<'a>) -> Result<&'a [u8], ServiceError> {
    match answered(confirmation) {
        Ok(answer) if answer.status.carries_data() => Ok(answer.du),
        Ok(answer) => Err(ServiceError::Refused(answer.status)),
        Err(reason) => Err(reason),
    }
}

#[cfg(test)]
mod tests {
    extern crate std;
    use super::*;
    use std::string::ToString;

    fn answer(status: Status, du: &[u8]) -> Confirmation<'_> {
        Confirmation::Answer(Answer { station: StationType::Slave, status, du, retries: 0 })
    }

    #[test]
    fn an_image_of_nothing_is_acknowledged_and_has_a_length_too() {
        assert_eq!(image(&answer(Status::NoReply, &[]), None), Ok(&[][..]));
        assert_eq!(image(&answer(Status::NoReply, &[]), Some(0)), Ok(&[][..]));
        assert_eq!(
            image(&answer(Status::NoReply, &[]), Some(2)),
            Err(ServiceError::Length { expected: 2, received: 0 })
        );
        assert_eq!(image(&answer(Status::DataHigh, &[1, 2]), None), Ok(&[1, 2][..]));
    }

    #[test]
    fn what_an_answer_says_instead_is_told_in_words() {
        for (status, words) in [
            (Status::ServiceNotActivated, "the service is closed now (RS)"),
            (Status::NoResource, "the request does not fit (RR)"),
            (Status::UserError, "the application of the station has failed (UE)"),
            (Status::NoReply, "it acknowledges where it should answer with data"),
        ] {
            assert_eq!(diagnosis(&answer(status, &[])).unwrap_err().to_string(), words);
            assert_eq!(configuration(&answer(status, &[])).unwrap_err().to_string(), words);
        }
        let data = acknowledged(&answer(Status::DataLow, &[1])).unwrap_err();
        assert_eq!(data.to_string(), "it answers with data where it should only acknowledge");
        assert_eq!(acknowledged(&Confirmation::Sent), Err(ServiceError::Unconfirmed));
        assert_eq!(station_type(&Confirmation::Failed(Failure::Silence)).unwrap_err().to_string(), "no answer");
    }
}
