//! Targets for coverage-guided fuzzing: each takes any octets, and panics if the program does something that it must never do.
//!
//! `ci/fuzz.py` runs them under libFuzzer; `tests/replay.rs` runs each over its corpus in `corpus/`, without other tools. The octets
//! of a target are choices ([`script::Script`]) where their structure matters, and a file or a telegram where it does not.
#![allow(
    clippy::unwrap_used,
    clippy::expect_used,
    clippy::panic,
    reason = "a target panics when the program does something wrong"
)]

#[cfg(feature = "station")]
pub mod api;
#[cfg(feature = "recorder")]
pub mod batch;
pub mod decode;
pub mod files;
#[cfg(feature = "station")]
pub mod gateways;
pub mod gsd;
pub mod master;
#[cfg(feature = "opcua")]
pub mod opcua;
#[cfg(feature = "station")]
pub mod plant;
#[cfg(feature = "station")]
pub mod prometheus;
pub mod receiver;
pub mod ring;
pub mod script;
pub mod slave;
