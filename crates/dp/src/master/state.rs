//! Where a slave stands, what it is asked there, and what was counted. profibus-wire 3.10.

use crate::link::BitTime;
use core::fmt;

/// Where a slave stands on the way to data exchange.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum HandlerState {
    /// Nobody has answered yet: FDL status, until somebody does.
    Offline,
    /// Slave_Diag: is the slave free, and is it the right one?
    Diag1,
    /// Set_Prm.
    Prm,
    /// Chk_Cfg.
    Cfg,
    /// Slave_Diag, until the slave is ready.
    Diag2 {
        /// Since when.
        since: BitTime,
        /// How often it has asked for parameters since.
        prm_reqs: u8,
    },
    /// Data_Exchange.
    Data {
        /// The slave has announced a diagnosis: it is fetched before the next exchange.
        diag: bool,
    },
    /// Set_Prm with Unlock_Req: the slave is given back.
    Release,
    /// Out of the cycle.
    Inactive,
}

impl HandlerState {
    /// What is asked in this state; whether now is the time for it is another question.
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

/// What a slave is asked.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum CyclicRequest {
    FdlStatus,
    SlaveDiag,
    SetPrm,
    ChkCfg,
    DataExch,
    Unlock,
}

/// What was counted since the slave was added.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Counters {
    /// Valid answers to Data_Exchange.
    pub exchanges: u32,
    /// Message cycles without a valid answer, after all repetitions. FDL status while nobody is there does not count.
    pub lost: u32,
    /// Requests that had to be repeated.
    pub retries: u32,
    /// Answers to nothing: late ones, or those of a second station with the same address.
    pub strays: u32,
    /// Diagnoses fetched.
    pub diagnoses: u32,
    /// How often the slave came into data exchange.
    pub starts: u32,
}
