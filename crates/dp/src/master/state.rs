//! The states of a slave in its master, their requests, and the counters. profibus-wire 3.10.

use crate::link::BitTime;
use core::fmt;

/// The state of a slave on the way to data exchange. The states are those of the standard, so that a match may list them all.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum HandlerState {
    /// No answer yet: the master sends FDL status until one comes.
    Offline,
    /// Slave_Diag: checks that the slave is free and has the expected Ident_Number.
    Diag1,
    /// Set_Prm.
    Prm,
    /// Chk_Cfg.
    Cfg,
    /// Slave_Diag, until the slave is ready.
    Diag2 {
        /// The beginning of this state.
        since: BitTime,
        /// The number of diagnoses with Prm_Req since.
        prm_reqs: u8,
    },
    /// Data_Exchange.
    Data {
        /// The slave has announced a diagnosis: the master fetches it before the next exchange.
        diag: bool,
    },
    /// Set_Prm with Unlock_Req: the master releases the slave.
    Release,
    /// Out of the cycle.
    Inactive,
}

impl HandlerState {
    /// Whether the slave exchanges data with this master.
    #[must_use]
    pub const fn is_exchanging(self) -> bool {
        matches!(self, Self::Data { .. })
    }

    /// The request of this state, regardless of pauses.
    pub(super) const fn request(self) -> Option<CyclicRequest> {
        match self {
            Self::Offline => Some(CyclicRequest::FdlStatus),
            Self::Diag1 | Self::Diag2 { .. } | Self::Data { diag: true } => Some(CyclicRequest::SlaveDiag),
            Self::Prm => Some(CyclicRequest::SetPrm),
            Self::Cfg => Some(CyclicRequest::ChkCfg),
            Self::Data { diag: false } => Some(CyclicRequest::DataExch),
            Self::Release => Some(CyclicRequest::Unlock),
            Self::Inactive => None,
        }
    }
}

impl fmt::Display for HandlerState {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Offline => "OFFLINE",
            Self::Diag1 => "DIAG1",
            Self::Prm => "PRM",
            Self::Cfg => "CFG",
            Self::Diag2 { .. } => "DIAG2",
            Self::Data { .. } => "DATA",
            Self::Release => "RELEASE",
            Self::Inactive => "INACTIVE",
        })
    }
}

/// A request of the cycle.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum CyclicRequest {
    FdlStatus,
    SlaveDiag,
    SetPrm,
    ChkCfg,
    DataExch,
    Unlock,
}

/// Counters since the slave was added.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub struct Counters {
    /// Valid answers to Data_Exchange.
    pub exchanges: u32,
    /// Message cycles without a valid answer, after all repetitions. FDL status to an absent slave does not count.
    pub lost: u32,
    /// Repetitions of requests.
    pub repetitions: u32,
    /// Answers without a request: late ones, or those of a second station with the same address.
    pub strays: u32,
    /// Diagnoses fetched.
    pub diagnoses: u32,
    /// How often the slave entered data exchange.
    pub starts: u32,
}
