//! The single requests of DP-V0, for [`Master::submit_request`](super::Master::submit_request). Only [`set_slave_add`] changes
//! the slave; Set_Prm is not among them. profibus-wire 2.
//!
//! The functions of the second half evaluate the result of [`Master::take_confirmation`](super::Master::take_confirmation).
//! The link layer has already compared source, access points, function code and form of the answer; these functions check its
//! status and its length.
//!
//! ```
//! use profivac_dp::link::active::{Answer, Confirmation, Failure};
//! use profivac_dp::master::services::{self, ServiceError};
//! use profivac_wire::control::{StationType, Status};
//!
//! let request = services::slave_diag(8);
//! assert_eq!((request.da, request.dsap), (8, Some(60)));
//! let confirmation = Confirmation::Failed(Failure::Silence);
//! assert_eq!(services::diagnosis(&confirmation), Err(ServiceError::Failed(Failure::Silence)));
//!
//! // Two octets of inputs and two of outputs: the answer to Get_Cfg, and then to RD_Inp.
//! let answer = |du| Confirmation::Answer(Answer { station: StationType::Slave, status: Status::DataLow, du, repetitions: 0 });
//! let (octets, lengths) = services::configuration(&answer(&[0x11, 0x21]))?;
//! assert_eq!((octets, lengths.inputs, lengths.outputs), (&[0x11, 0x21][..], 2, 2));
//! assert_eq!(services::get_cfg(8).dsap, Some(59));
//! let inputs = services::image(&answer(&[7, 9]), Some(lengths.inputs.into()))?;
//! assert_eq!((inputs, services::rd_inp(8).dsap), (&[7, 9][..], Some(56)));
//! # Ok::<(), ServiceError>(())
//! ```

use crate::link::active::{Answer, Confirmation, Failure, Request};
use core::fmt;
use profivac_wire::Sap;
use profivac_wire::cfg::{self, CfgError, Lengths};
use profivac_wire::control::{Function, StationType, Status};
use profivac_wire::diag::SlaveDiag;
use profivac_wire::sap::MASTER_MS0;

/// The fixed octets of a diagnosis.
pub(super) const MIN_SLAVE_DIAG: usize = 6;

/// FDL status: whether a station is at the address, and its type.
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

/// A service of MS0: SRD high with access points.
pub(super) const fn ms0(da: u8, sap: Sap, du: &[u8]) -> Request<'_> {
    Request { da, function: Function::SrdHigh, dsap: sap.to_octet(), ssap: Some(MASTER_MS0), du }
}

/// The reason why a service has no result.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub enum ServiceError {
    /// No answer came that matches the request.
    Failed(Failure),
    /// The station answered with this status.
    Refused(Status),
    /// The data unit of the answer has the wrong length.
    Length {
        /// The expected length in octets; the least length for a diagnosis.
        expected: usize,
        /// The received length in octets.
        received: usize,
    },
    /// The data are no valid configuration.
    Cfg(CfgError),
    /// The request has no answer.
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

/// The station type from the answer to [`fdl_status`].
///
/// # Errors
/// [`ServiceError`].
pub const fn station_type(confirmation: &Confirmation<'_>) -> Result<StationType, ServiceError> {
    match answered(confirmation) {
        Ok(answer) => match answer.status {
            Status::Ok => Ok(answer.station),
            status => Err(ServiceError::Refused(status)),
        },
        Err(reason) => Err(reason),
    }
}

/// The diagnosis from the answer to [`slave_diag`].
///
/// # Errors
/// [`ServiceError`].
pub fn diagnosis<'a>(confirmation: &Confirmation<'a>) -> Result<SlaveDiag<'a>, ServiceError> {
    let du = data(confirmation)?;
    SlaveDiag::parse(du).map_err(|_| ServiceError::Length { expected: MIN_SLAVE_DIAG, received: du.len() })
}

/// The configuration from the answer to [`get_cfg`]: the identifiers and the lengths of inputs and outputs.
///
/// # Errors
/// [`ServiceError`].
pub fn configuration<'a>(confirmation: &Confirmation<'a>) -> Result<(&'a [u8], Lengths), ServiceError> {
    let du = data(confirmation)?;
    cfg::lengths(du).map(|lengths| (du, lengths)).map_err(ServiceError::Cfg)
}

/// The image from the answer to [`rd_inp`] or [`rd_outp`]. `expected` is the length of the image if known, from the own
/// configuration or from [`configuration`].
///
/// # Errors
/// [`ServiceError`].
pub fn image<'a>(confirmation: &Confirmation<'a>, expected: Option<usize>) -> Result<&'a [u8], ServiceError> {
    let answer = answered(confirmation)?;
    // SC means an image without octets: profibus-wire 2.2.
    let du = if answer.status == Status::NoReply { &[] } else { data(confirmation)? };
    match expected {
        Some(expected) if expected != du.len() => Err(ServiceError::Length { expected, received: du.len() }),
        _ => Ok(du),
    }
}

/// Checks that the slave acknowledged [`set_slave_add`]. A slave also acknowledges an address that it does not accept, so the
/// caller has to ask at the new address.
///
/// # Errors
/// [`ServiceError`].
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
        Confirmation::Answer(Answer { station: StationType::Slave, status, du, repetitions: 0 })
    }

    #[test]
    fn an_image_without_octets_is_acknowledged_and_its_length_is_checked() {
        assert_eq!(image(&answer(Status::NoReply, &[]), None), Ok(&[][..]));
        assert_eq!(image(&answer(Status::NoReply, &[]), Some(0)), Ok(&[][..]));
        assert_eq!(
            image(&answer(Status::NoReply, &[]), Some(2)),
            Err(ServiceError::Length { expected: 2, received: 0 })
        );
        assert_eq!(image(&answer(Status::DataHigh, &[1, 2]), None), Ok(&[1, 2][..]));
    }

    #[test]
    fn every_other_status_has_an_error_text() {
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
