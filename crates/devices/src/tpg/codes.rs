//! Code tables of the manual of IF300P and IF301P. Numbers in brackets are those of errata-bpg-bcg-tpg.

use super::CHANNELS;
use super::channel::Status;
use super::table::Filter;
use crate::model::{Codes, code};
use crate::profile::codes::risky;

/// 3.2.3.2 (132)
pub const ACCESS_CODE: Codes = Codes::Range(0, 9999);

/// 3.2.3.2
pub const UNDERRANGE: Codes = Codes::Names(&[code(0, "relay-remains-on"), code(1, "relay-waits-for-valid-value")]);

/// 3.2.3.2: an order, which is lost with the power.
pub const VOLATILITY: Codes = Codes::Commands(&[
    code(0, "ready-to-store"),
    risky(1, "store", "stores all settings as they are now"),
    risky(2, "store-and-hotstart", "stores all settings and which sensors are on"),
]);

/// 3.2.4.1
pub const FILTER: Codes = Codes::Names(&[
    code(Filter::Fast as u16, "fast"),
    code(Filter::Medium as u16, "medium"),
    code(Filter::Slow as u16, "slow"),
]);

/// 3.2.4.1
pub const MEASUREMENT_STATUS: Codes = Codes::Names(&[
    code(Status::Ok as u16, "ok"),
    code(Status::Underrange as u16, "underrange"),
    code(Status::Overrange as u16, "overrange"),
    code(Status::Error as u16, "error"),
    code(Status::Off as u16, "off"),
    code(Status::NoHardware as u16, "no-hardware"),
]);

/// 3.2.4.2
pub const VALIDATION: Codes = Codes::Names(&[code(0, "open-for-changes"), code(1, "valid")]);

/// 3.2.4.2: the slot of a channel (140).
pub const SOURCE: Codes = Codes::Range(1, CHANNELS as i64);

/// 3.2.4.2 (141)
pub const SETPOINT_STATUS: Codes = Codes::Names(&[code(0, "activated"), code(1, "deactivated")]);
