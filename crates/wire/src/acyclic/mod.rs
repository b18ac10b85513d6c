//! The PDUs of DP-V1, carried in the data units of MS1 and MS2. profibus-wire 4.1.
//!
//! [`Request`] is everything a master sends and [`Response`] everything a slave returns. An empty data unit is neither: it is
//! the poll that fetches a response.
//!
//! | Module | Holds | Reference |
//! |---|---|---|
//! | [`record`] | Read, Write, Data_Transport, Alarm_Ack | profibus-wire 4.1.1 |
//! | [`error`] | negative responses and their codes | profibus-wire 4.1.2, 4.1.3 |
//! | [`initiate`] | Initiate and the answer of the resource manager | profibus-wire 4.6 |
//! | [`abort`] | Abort and its reasons | profibus-wire 4.8 |
//! | [`call`] | Call and I&M0 behind index 255 | profibus-wire 5 |

pub mod abort;
pub mod call;
pub mod error;
pub mod initiate;
mod pdu;
pub mod record;

#[cfg(test)]
mod tests;

pub use abort::{Abort, AbortReason};
pub use call::{Call, Im0};
pub use error::{ErrorCode, ErrorDecode, Negative};
pub use initiate::{Initiate, InitiateRes, ResourceManager};
pub use pdu::{Function, PduError, Request, Response};
pub use record::{Access, AlarmAck, Transfer};
