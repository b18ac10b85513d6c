//! Vacuum gauges and controllers with a PROFIBUS interface: their tables and their behaviour.
//!
//! Nothing here knows a telegram or a bit time. A device implements [`profivac_dp::slave::Device`] for the bus and
//! [`Instrument`] for whoever gives it pressure, faults and time.
//!
//! | Module | Knows |
//! |---|---|
//! | [`model`] | rows, blocks, telegrams, units, codes: tables, no behaviour |
//! | [`store`] | nonvolatile memory as a device sees it |
//! | [`profile`] | what all block devices share |
//! | [`bcg450`], [`img400`], [`pxg55x`], [`tpg`], [`xpg400`] | one device or family: its tables beside its behaviour |
//! | [`catalog`] | all of them, by name and by Ident_Number |
//!
//! Modules depend upwards in this table only. A gauge on the bench:
//!
//! ```
//! use profivac_devices::bcg450::Bcg450;
//! use profivac_devices::profile::Setup;
//! use profivac_devices::store::RamStore;
//! use profivac_devices::Instrument;
//! use profivac_dp::slave::{Device, Relation};
//!
//! let mut gauge: Bcg450<RamStore> = Bcg450::new(RamStore::default(), Setup::new(5));
//! gauge.settle();
//! gauge.sense(0, 0.1);
//! // Device Block State Command 4, Execute; then the Process Value of the Pirani: 1e-3 mbar is below its range.
//! gauge.write(Relation::Ms2(0), 0, 15, &[4]).unwrap();
//! let mut record = [0; 240];
//! let length = gauge.read(Relation::Ms2(0), 1, 19, &mut record).unwrap();
//! assert_eq!(record[..length], 5.5e-3f32.to_be_bytes());
//! assert_eq!(gauge.report().device_state, "EXECUTING");
//! ```
//!
//! # How to add a device
//!
//! Everything about a device lies in one folder here and one under `tests`; this file gets its name.
//!
//! 1. **`src/NAME/table.rs`**, with the manual open beside it, from the first page to the last:
//!    - one `block!` for each block table, with the columns ID, identifier, name as printed, data type (`UINT8`, `VSTRING(8)`,
//!      `BY_TYPE`, ...), access exactly as printed, store class (`N V D`, `R` where a master asks for storage, `-` where nothing is stored) and section. A comment
//!      where a row departs from the print, with the number of the erratum. Commands are `-`: what is `N` and writable is
//!      stored and written again at power-up. After the section the name of its codes, where its numbers have names:
//!      those that all manuals share are in `profile::codes`, the others in `src/NAME/codes.rs`.
//!    - one `blocks!`: which block stands at which slots, with its instances (`1:2`) where a selector chooses;
//!    - a [`Telegram`](model::Telegram) for each standard telegram and a [`Configuration`](model::Configuration) for each
//!      string; a string that does not fit its telegrams does not compile;
//!    - [`Unit`](model::Unit)s with this manual's codes, user parameter strings, [`Facts`](model::Facts) of the measuring
//!      parts (limits, COUNTS), the [`Dialect`](model::Dialect) of the parameter channel;
//!    - one [`Model`](model::Model) that names them all.
//! 2. **`src/NAME/mod.rs`**: the state of the device, made of what [`profile`] has ([`Machine`](profile::Machine),
//!    [`MeasuringPart`](profile::MeasuringPart), [`Cathode`](profile::Cathode), [`SetPoint`](profile::SetPoint),
//!    [`Presentation`](profile::Presentation)) and what is its own, and what follows from what. The alias
//!    `pub type Name<S> = BlockDevice<..., S>` with its `new`.
//! 3. **`src/NAME/parameters.rs`**: [`Blocks`](profile::Blocks), an exhaustive `match` from every row to its value. Direction,
//!    length, type and state are decided by the row before that code runs, and storing happens after it.
//! 4. **`src/NAME/bench.rs`**: [`Behaviour`](profile::Behaviour), the cyclic fields and what people do to the device, with its
//!    `faults!`.
//! 5. **This file**: `pub mod NAME;`, and a word in the table above.
//! 6. **`tests/NAME/main.rs`** beside `tests/support`: `rows.rs` (a sample of good and bad values for every
//!    writable row; the rest is generated), `exchange.rs` (every configuration and user parameter string), one file per
//!    behaviour with its sections, and `property.rs`. `cargo xtask goldens` writes the tables to
//!    `tests/golden/NAME.txt`: read them against the manual once more.
#![no_std]
#![warn(clippy::indexing_slicing, clippy::arithmetic_side_effects)]

pub mod bcg450;
pub mod catalog;
pub mod img400;
pub mod model;
pub mod profile;
pub mod pxg55x;
mod simulation;
pub mod store;
pub mod tpg;
pub mod xpg400;

pub use simulation::{
    Action, BoundedVec, Drive, MeasuringRange, Part, PartReading, Principle, REPORT_CAPACITY, SimulatedDevice,
    StateReport, UnsupportedAction,
};
