//! The state of a DP slave. profibus-wire 3.1 and 3.2.

use crate::link::BitTime;
use core::fmt;
use profivac_wire::cfg::Lengths;

/// The state of a slave between power-up and data exchange.
///
/// Every telegram reads the discriminant several times, so it has an octet of its own (`repr`) and is not encoded in an
/// impossible value of the watchdog.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[repr(u8)]
pub enum SlaveState {
    /// Waits for Set_Prm. The fault is kept for the diagnosis.
    WaitPrm(Fault),
    /// Parameterised, waits for Chk_Cfg.
    WaitCfg(Owner),
    /// Exchanges data.
    DataExch(Owner, ExchangeState),
}

/// The reason why a slave returned to WAIT-PRM, as far as the diagnosis distinguishes it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Fault {
    /// Power-up, unlock, watchdog, wrong output length: only Prm_Req.
    None,
    /// Prm_Fault.
    Prm,
    /// Cfg_Fault.
    Cfg,
}

/// The master that parameterised the slave, and its parameters.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
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
    /// The master requested a feature that the slave does not have.
    pub not_supported: bool,
}

/// The response watchdog. profibus-wire 3.6.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub struct Watchdog {
    /// T_WD in bit times.
    pub period_tbit: u64,
    /// When it expires unless a request of the owner restarts it.
    pub deadline: BitTime,
}

/// The part of the state that exists only during data exchange.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub struct ExchangeState {
    /// The lengths of inputs and outputs.
    pub lengths: Lengths,
    /// Sync: outputs are held until the next Sync.
    pub sync: bool,
    /// Freeze: the image of the inputs is frozen.
    pub freeze: bool,
    /// The owner has not fetched a diagnosis yet: answers have high priority.
    pub diag_flag: bool,
}

impl SlaveState {
    /// The state after power-up.
    pub const POWER_UP: Self = Self::WaitPrm(Fault::None);

    /// Whether the slave exchanges data.
    #[must_use]
    pub const fn is_exchanging(&self) -> bool {
        matches!(self, Self::DataExch(..))
    }

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
