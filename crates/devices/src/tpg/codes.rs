//! The code tables of the manual of IF300P and IF301P. Numbers in brackets are those of errata-bpg-bcg-tpg.

use super::CHANNELS;
use crate::model::Codes;
use crate::model::code_table::{CodeTable, code_range, codes};

/// Program version. 3.2.3.2 (131).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ProgramVersion {}

impl CodeTable for ProgramVersion {
    type Value = i32;

    const CODES: Codes = Codes::Version;
}

code_range! {
    /// Authorized access code. 3.2.3.2 (132).
    pub AccessCode: u16 = 0, 9999
}

codes! {
    /// Pressure under-range control: what a relay does while its channel is below the range. 3.2.3.2.
    pub UnderrangeControl: Names;
    0 RelayRemainsOn           "relay-remains-on";
    1 RelayWaitsForValidValue  "relay-waits-for-valid-value";
}

codes! {
    /// Volatility: a command that stores the settings; the readable value is lost with the power. 3.2.3.2 (143).
    pub Volatility: Commands;
    0 ReadyToStore     "ready-to-store";
    1 Store            "store", risk "stores all settings as they are now";
    2 StoreAndHotstart "store-and-hotstart", risk "stores all settings and which sensors are on";
}

codes! {
    /// Filter time constant of a channel. 3.2.4.1 (146).
    pub Filter: Names;
    1 Fast   "fast";
    2 Medium "medium";
    3 Slow   "slow";
}

impl Filter {
    /// The time constant in seconds.
    // chosen: the manual gives no times
    pub const fn seconds(self) -> f64 {
        match self {
            Self::Fast => 0.1,
            Self::Medium => 0.4,
            Self::Slow => 1.6,
        }
    }
}

codes! {
    /// Measurement status of a channel. A gauge that is not plugged in is an error too: its board is there, and "no hardware" is a
    /// channel without a board (124). 3.2.4.1.
    pub MeasurementStatus: Names;
    0 Ok         "ok";
    1 Underrange "underrange";
    2 Overrange  "overrange";
    3 Error      "error";
    4 Off        "off";
    5 NoHardware "no-hardware";
}

codes! {
    /// Threshold validation: opens a set of thresholds for changes, and closes it. 3.2.4.2.
    pub Validation: Names;
    0 OpenForChanges "open-for-changes";
    1 Valid          "valid";
}

code_range! {
    /// Threshold source: the slot of the channel that is compared. 3.2.4.2 (140).
    pub Source: u8 = 1, CHANNELS
}

codes! {
    /// Setpoint status. 3.2.4.2 (141).
    pub SetpointStatus: Names;
    0 Activated   "activated";
    1 Deactivated "deactivated";
}
