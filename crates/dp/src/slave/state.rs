//! The state of a DP slave. profibus-wire 3.1 and 3.2.

use crate::link::BitTime;
use core::fmt;
use profivac_wire::cfg::Lengths;

/// Where a slave stands between power-up and data exchange. Every telegram asks several times which it is, so that it has an
/// octet of its own (`repr`) instead of a value that the watchdog cannot have.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u8)]
pub enum SlaveState {
    /// Waiting for Set_Prm. Whatever was wrong before is remembered for the diagnosis.
    WaitPrm(Fault),
    /// Parameterised, waiting for Chk_Cfg.
    WaitCfg(Owner),
    /// Exchanging data.
    DataExch(Owner, ExchangeState),
}

/// Why a slave fell back to WAIT-PRM, as far as the diagnosis tells it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Fault {
    /// Power-up, unlock, watchdog, wrong output length: only Prm_Req.
    None,
    /// Prm_Fault.
    Prm,
    /// Cfg_Fault.
    Cfg,
}

/// The master that parameterised the slave, and what it asked for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Owner {
    /// Diag_Master_Add.
    pub master: u8,
    /// Group_Ident.
    pub group: u8,
    /// The response watchdog, if it runs.
    pub watchdog: Option<Watchdog>,
    /// DPV1_Enable.
    pub dpv1: bool,
    /// Fail_Safe: outputs of length zero mean Clear.
    pub fail_safe: bool,
    /// Something was asked for that the slave does not have.
    pub not_supported: bool,
}

/// The response watchdog. profibus-wire 3.6.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Watchdog {
    /// T_WD in bit times.
    pub period_tbit: u64,
    /// When it expires unless the master is heard.
    pub deadline: BitTime,
}

/// What is true only while data are exchanged.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ExchangeState {
    /// How many octets go each way.
    pub lengths: Lengths,
    /// Outputs are held until the next Sync.
    pub sync: bool,
    /// The image of the inputs is frozen.
    pub freeze: bool,
    /// A diagnosis waits to be fetched: answers are high priority.
    pub diag_flag: bool,
}

impl SlaveState {
    /// The state after power-up.
    pub const POWER_UP: Self = Self::WaitPrm(Fault::None);

    /// The master the slave is locked to.
    #[must_use]
    pub const fn owner(&self) -> Option<&Owner> {
        match self {
            Self::WaitPrm(_) => None,
            Self::WaitCfg(owner) | Self::DataExch(owner, _) => Some(owner),
        }
    }

    pub(super) const fn owner_mut(&mut self) -> Option<&mut Owner> {
        match self {
            Self::WaitPrm(_) => None,
            Self::WaitCfg(owner) | Self::DataExch(owner, _) => Some(owner),
        }
    }

    /// Whether the slave is locked to another master than `sa`.
    #[must_use]
    pub fn is_locked_against(&self, sa: u8) -> bool {
        self.owner().is_some_and(|owner| owner.master != sa)
    }
}

impl fmt::Display for SlaveState {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::WaitPrm(_) => "WAIT-PRM",
            Self::WaitCfg(_) => "WAIT-CFG",
            Self::DataExch(..) => "DATA-EXCH",
        })
    }
}
