//! Vacuum gauges and controllers with a PROFIBUS interface: their tables and their behaviour.
//!
//! The crate knows neither telegrams nor bit times. A device implements [`profivac_dp::slave::Device`] for the bus and
//! [`SimulatedDevice`] for the program that gives it pressure, faults and time.
//!
//! A simulated gauge:
//!
//! ```
//! use profivac_devices::SimulatedDevice;
//! use profivac_devices::bcg450::Bcg450;
//! use profivac_devices::profile::{Setup, StateCommand};
//! use profivac_devices::store::RamStore;
//! use profivac_dp::slave::{Device, Relation};
//!
//! let mut gauge: Bcg450<RamStore> = Bcg450::new(RamStore::default(), Setup::new(5));
//! gauge.settle();
//! gauge.sense(0, 0.1);
//! gauge.write(Relation::Ms2(0), 0, 15, &[StateCommand::Execute as u8])?;
//! // The Process Value of the Pirani: 1e-3 mbar is below its range.
//! let mut record = [0; 240];
//! let length = gauge.read(Relation::Ms2(0), 1, 19, &mut record)?;
//! assert_eq!(record[..length], 5.5e-3f32.to_be_bytes());
//! assert_eq!(gauge.report().device_state.name(), "EXECUTING");
//! # Ok::<(), profivac_dp::slave::Dpv1Error>(())
//! ```
//!
//! # How to read a parameter as a Rust type
//!
//! Every row of a table is a type as well: [`TypedParameter`](model::TypedParameter), which names the Rust type of the
//! value. A code table is an enum, so a client compares `DeviceState::Idle` and not a text.
//! [`Model::typed_row`](model::Model::typed_row) finds the row in the model of the device:
//!
//! ```
//! use profivac_devices::bcg450::table::{BA, DEVICE, MODEL, device_block, hot_cathode};
//! use profivac_devices::bcg450::codes::HotCathodeCommand;
//! use profivac_devices::model::{ParameterValue, TypedParameter, Value};
//! use profivac_devices::profile::DeviceState;
//!
//! let row = MODEL.typed_row::<device_block::DeviceState>(&DEVICE);
//! assert_eq!(row.map(|row| (row.index, row.name)), Some((25, "Device State")));
//! assert_eq!(DeviceState::from_value(&Value::Integer(2)), Some(DeviceState::Idle));
//!
//! let row = MODEL.typed_row::<hot_cathode::StateCommand>(&BA);
//! let command = row.map(|row| HotCathodeCommand::DegasOn.to_value(row.data_type));
//! assert_eq!(command, Some(Value::octets(&[1, 1])));
//! ```
//!
//! # How to add a device
//!
//! Everything about a device is in one folder here and one under `tests`; this file gets its name. CONTRIBUTING.md of the repository
//! lists the places outside this crate.
//!
//! 1. **`src/NAME/table.rs`**, with the manual open beside it, from the first page to the last:
//!    - one `block!` for each block table, with the columns ID, identifier, name as printed, data type (`UINT8`,
//!      `VSTRING(8)`, `BY_TYPE`, ...), access exactly as printed, store class (`N V D`, `R` where a master asks for
//!      storage, `-` where nothing is stored) and section. A comment where a row departs from the print, with the
//!      number of the erratum. Commands are `-`: a value that is `N` and writable is stored and written again at
//!      power-up. After the section the code table, if the numbers have names: a type of [`profile::codes`] or of
//!      `src/NAME/codes.rs`;
//!    - a [`Location`](model::Location) for each slot or instance, and one `blocks!` with the locations of the blocks;
//!    - a [`Telegram`](model::Telegram) for each standard telegram and a [`Configuration`](model::Configuration) for
//!      each string; a string that does not fit its telegrams does not compile;
//!    - [`Unit`](model::Unit)s with this manual's codes, user parameter strings, the
//!      [`ChannelRules`](model::ChannelRules) of the parameter channel;
//!    - one [`Model`](model::Model) that names them all.
//! 2. **`src/NAME/parts.rs`**, **`codes.rs`** and **`faults.rs`**, which `table.rs` uses: a
//!    [`PartSpec`](model::PartSpec) of each measuring part (limits, COUNTS), a `codes!` for each code table that no
//!    other manual has, and `faults!`.
//! 3. **`src/NAME/mod.rs`**: the state of the device, made of the types of [`profile`]
//!    ([`StateMachine`](profile::StateMachine), [`MeasuringPart`](profile::MeasuringPart),
//!    [`Cathode`](profile::Cathode), [`RelaySetPoint`](profile::RelaySetPoint),
//!    [`Presentation`](profile::Presentation)) and its own, and the function that updates it. The alias `pub type
//!    Name<S> = BlockDevice<..., S>` with its `new`.
//! 4. **`src/NAME/parameters.rs`**: [`ParameterAccess`](profile::ParameterAccess), an exhaustive `match` from every row
//!    to its value. Access, length, type and mode are checked before that code runs, and the value is stored after it.
//! 5. **`src/NAME/simulation.rs`**: [`Behaviour`](profile::Behaviour), the cyclic fields, sensors and front panel.
//! 6. **This file**: `pub mod NAME;`, and the name in the table above; a line in [`catalog::MODELS`].
//! 7. **`tests/NAME/main.rs`** beside `tests/support`: `rows.rs` (a sample of good and bad values for every
//!    writable row; the rest is generated), `exchange.rs` (every configuration and user parameter string), one file per
//!    behaviour with its sections, and `property.rs`. `cargo xtask goldens` writes the tables to
//!    `tests/golden/NAME.txt`: read them against the manual once more.
#![no_std]
#![warn(missing_docs, clippy::indexing_slicing, clippy::arithmetic_side_effects)]

pub mod bcg450;
pub mod catalog;
#[cfg(feature = "texts")]
pub mod described;
pub mod img400;
pub mod model;
pub mod profile;
pub mod pxg55x;
pub mod reading;
mod simulation;
pub mod store;
pub mod tpg;
pub mod xpg400;

pub use model::{MeasuringRange, Part, Principle};
pub use simulation::{
    Action, BoundedVec, Drive, FrontPanel, Led, PartReading, Potentiometer, REPORT_CAPACITY, ReportedState,
    SimulatedDevice, StateReport, Switch, SwitchName, UnsupportedAction,
};

/// The examples of the README, as doctests.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct ReadmeDoctests;
