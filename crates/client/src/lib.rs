//! Gauges by name: for the bus tool, and for programs of one's own.
//!
//! | Module | Holds |
//! |---|---|
//! | [`names`] | parameters by the manual's words or its numbers |
//! | [`values`] | values in words and units, and their octets |
//! | [`class1`] | MS1 and the parameter channel of a slave that this master owns |
//! | [`records`] | the ways to the records of a slave, and what it answers |
//! | [`address`] | a new station address |
//! | [`bus`] | the same from many threads, and async in any runtime |
//! | [`identify`] | which device stands at an address |
//! | [`settings`] | what is kept, in a file, compared, and written to a replacement |
//! | `gauge` | [`Gauge`]: read, write, command |
//! | [`conditions`] | what must be the case before a command, and what is |
//! | `access` | which way and direction a table allows |
//! | `error` | [`ClientError`]: one sentence with address, parameter, reason and advice |

mod access;
pub mod address;
pub mod bus;
pub mod class1;
pub mod conditions;
pub mod cyclic;
mod error;
mod gauge;
pub mod gsd;
pub mod identify;
pub mod ms2;
pub mod names;
pub mod pressure;
pub mod records;
pub mod settings;
pub mod values;

pub use conditions::Condition;
pub use error::{ClientError, ErrorKind, Location, Operation};
pub use gauge::{Gauge, ParameterReading, PreparedWrite, PressureReading, WriteResult};
