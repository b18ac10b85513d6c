//! The PDUs of DP-V1 in the data units of MS1 and MS2. profibus-wire 4.1.
//!
//! A master sends a [`Request`], a slave returns a [`Response`]. An empty data unit is neither: with it a master polls for
//! the response.
//!
//! | Module | Holds | Reference |
//! |---|---|---|
//! | [`record`] | Read, Write, Data_Transport, Alarm_Ack | profibus-wire 4.1.1 |
//! | [`error`] | negative responses and their codes | profibus-wire 4.1.2, 4.1.3 |
//! | [`initiate`] | Initiate and the answer of the resource manager | profibus-wire 4.6 |
//! | [`abort`] | Abort and its reasons | profibus-wire 4.8 |
//! | [`call`] | Call on index 255 and the record I&M0 | profibus-wire 5 |
//!
//! A slave refuses a write, and acknowledges an alarm:
//!
//! ```
//! use profivac_wire::acyclic::{AlarmAck, ErrorCode, ErrorDecode, Function, Negative, Request, Response};
//!
//! let refusal = Response::Negative(Negative::new(Function::Write, ErrorCode::ACCESS_DENIED));
//! assert_eq!(refusal.function(), Function::Write);
//! let mut out = [0; 4];
//! assert_eq!(refusal.emit(&mut out)?, 4);
//! assert_eq!(out, [0xDF, 0x80, 0xB6, 0]);
//!
//! let Ok(Response::Negative(negative)) = Response::parse(&out) else { panic!("expected a refusal") };
//! assert_eq!(negative.decode, ErrorDecode::DpV1);
//! let code = negative.code_1;
//! assert_eq!((code.class(), code.code(), code.name()), (11, 6, "access denied"));
//!
//! let ack = AlarmAck { slot: 3, alarm_type: 2, specifier: 0x08 };
//! assert_eq!(Request::AlarmAck(ack).function(), Function::AlarmAck);
//! # Ok::<(), profivac_wire::TooLong>(())
//! ```

pub mod abort;
pub mod call;
pub mod error;
mod function;
pub mod initiate;
mod pdu;
pub mod record;

#[cfg(test)]
mod tests;

pub use abort::{Abort, AbortReason};
pub use call::{Call, Im0};
pub use error::{ErrorCode, ErrorDecode, Negative};
pub use function::{Function, PduError};
pub use initiate::{Initiate, InitiateRes, ResourceManager};
pub use pdu::{Request, Response};
pub use record::{Access, AlarmAck, Transfer};
