//! The settings of a class 1 master, and the parameters of each slave.

use crate::link::Baud;
use core::fmt;
use profivac_wire::cfg::CfgError;

/// The settings for all slaves of a master.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Settings {
    /// The least time from the start of a cycle to the start of the next, in bit times.
    pub min_cycle_tbit: u64,
    /// The master repeats Global_Control after this number of cycles.
    pub control_cycles: u32,
    /// The number of message cycles in a row that fail until the slave counts as lost.
    pub miss_limit: u8,
    /// The pause after the second failure in a row, in bit times. It doubles after each further failure.
    pub pause_min_tbit: u64,
    /// The longest pause, in bit times.
    pub pause_max_tbit: u64,
    /// The time in which a slave must become ready after Chk_Cfg, in bit times.
    pub ready_tbit: u64,
    /// Error_Action: when a slave leaves data exchange in [`Mode::Operate`](super::Mode::Operate), the master goes to
    /// [`Mode::Clear`](super::Mode::Clear) and stays there until the user changes the mode.
    pub auto_clear: bool,
}

impl Settings {
    /// Settings for a transmission rate.
    ///
    /// chosen, all of them: the reference gives none (profibus-wire 3.10 and 10, point 35).
    #[must_use]
    pub const fn new(baud: Baud) -> Self {
        Self {
            min_cycle_tbit: 0,
            control_cycles: 50,
            miss_limit: 3,
            pause_min_tbit: baud.tbit_of_ms(10),
            pause_max_tbit: baud.tbit_of_ms(250),
            ready_tbit: baud.tbit_of_ms(10_000),
            auto_clear: false,
        }
    }
}

/// The parameters of one slave.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct SlaveParameters<'a> {
    /// Station address, 0 to 125.
    pub address: u8,
    /// Ident_Number.
    pub ident: u16,
    /// The configuration identifiers of Chk_Cfg.
    pub cfg: &'a [u8],
    /// User_Prm_Data, on a DP-V1 slave beginning with the three DPV1_Status octets.
    pub user_prm: &'a [u8],
    /// WD_Fact_1 and WD_Fact_2, see [`watchdog_factors`]. `None` leaves the watchdog of the slave off.
    pub watchdog: Option<[u8; 2]>,
    /// min T_SDR in bit times; 0 keeps the value of the slave.
    pub min_tsdr: u8,
    /// Min_Slave_Interval in bit times: the least time between two cyclic requests to the slave. 0 is no limit. The GSD file
    /// has it in units of 100 us, see [`Baud::tbit_of_us`].
    pub min_interval_tbit: u64,
    /// Group_Ident, one bit per group.
    pub group: u8,
    /// Requires Sync (Sync_Req).
    pub sync: bool,
    /// Requires Freeze (Freeze_Req).
    pub freeze: bool,
    /// In Clear the master sends outputs of length zero instead of zeros. `user_prm` must say the same (Fail_Safe).
    pub fail_safe: bool,
    /// DPV1_Slave of the GSD file: device-related diagnosis consists of alarms and status messages.
    pub dpv1: bool,
    /// Diag_Update_Delay of the GSD file: the number of diagnoses after Set_Prm that may still have Prm_Req set.
    pub diag_update_delay: u8,
}

impl<'a> SlaveParameters<'a> {
    /// A slave with a watchdog of one second and min T_SDR 11; everything else is off.
    #[must_use]
    pub const fn new(address: u8, ident: u16, cfg: &'a [u8]) -> Self {
        Self {
            address,
            ident,
            cfg,
            user_prm: &[],
            watchdog: Some([10, 10]),
            min_tsdr: 11,
            min_interval_tbit: 0,
            group: 0,
            sync: false,
            freeze: false,
            fail_safe: false,
            dpv1: false,
            diag_update_delay: 0,
        }
    }
}

/// WD_Fact_1 and WD_Fact_2 of the shortest watchdog of at least `ms` milliseconds, in units of `base_ms` (10, or 1 with
/// WD_Base_1ms). `None` for more than 255 x 255 units. profibus-wire 2.4.
///
/// ```
/// use profivac_dp::master::watchdog_factors;
///
/// assert_eq!(watchdog_factors(300, 10), Some([1, 30]));
/// ```
#[must_use]
pub const fn watchdog_factors(ms: u32, base_ms: u32) -> Option<[u8; 2]> {
    if base_ms == 0 || ms > base_ms.saturating_mul(255 * 255) {
        return None;
    }
    let units = at_least_one(ms.div_ceil(base_ms));
    let first = at_least_one(units.div_ceil(255));
    let second = units.div_ceil(first);
    Some([first as u8, second as u8])
}

const fn at_least_one(factor: u32) -> u32 {
    if factor == 0 { 1 } else { factor }
}

/// The reason why the master did not change its list of slaves.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub enum SlaveListError {
    /// The list is full.
    Full {
        /// The number of slaves that the list has room for.
        capacity: usize,
    },
    /// The address is above 125, or the master's own.
    Address(u8),
    /// The list has a slave with this address already.
    Taken(u8),
    /// The list has no slave with this address.
    Unknown(u8),
    /// The configuration is invalid.
    Cfg(CfgError),
    /// Configuration, user parameters, inputs or outputs are too long.
    TooLong {
        /// The data that are too long.
        data: SlaveData,
        /// The length in octets.
        octets: usize,
        /// The most octets possible.
        room: usize,
    },
    /// A watchdog factor is 0.
    Watchdog,
}

impl fmt::Display for SlaveListError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Full { capacity } => write!(f, "the master has room for {capacity} slaves"),
            Self::Address(address) => write!(f, "no slave of this master can have the address {address}"),
            Self::Taken(address) => write!(f, "there is a slave with the address {address} already"),
            Self::Unknown(address) => write!(f, "there is no slave with the address {address}"),
            Self::Cfg(defect) => write!(f, "the configuration is wrong: {defect}"),
            Self::TooLong { data, octets, room } => write!(f, "{data}: {octets} octets, and there is room for {room}"),
            Self::Watchdog => f.write_str("a watchdog factor must be 1 to 255, not 0"),
        }
    }
}

/// The data of a slave that a master has buffers for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum SlaveData {
    /// The input image.
    Inputs,
    /// The output image.
    Outputs,
    /// The configuration identifiers.
    Configuration,
    /// The user parameters.
    UserParameters,
}

impl fmt::Display for SlaveData {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Inputs => "inputs",
            Self::Outputs => "outputs",
            Self::Configuration => "configuration",
            Self::UserParameters => "user parameters",
        })
    }
}

impl core::error::Error for SlaveListError {}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn watchdog_factors_are_the_shortest_that_suffice() {
        for (ms, base, factors) in [
            (0, 10, Some([1, 1])),
            (300, 10, Some([1, 30])),
            (1000, 10, Some([1, 100])),
            (2551, 10, Some([2, 128])),
            (7, 1, Some([1, 7])),
            (650_250, 10, Some([255, 255])),
            (650_251, 10, None),
            (1, 0, None),
        ] {
            assert_eq!(watchdog_factors(ms, base), factors, "{ms} ms");
        }
        for ms in (0..650_000).step_by(37) {
            let [first, second] = watchdog_factors(ms, 10).unwrap();
            assert!(u32::from(first) * u32::from(second) * 10 >= ms);
        }
    }
}
