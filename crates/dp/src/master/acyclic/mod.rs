//! Types that MS1, MS2 and the parameter channel of a master share: handles, results, slots, and the transaction by which
//! MS1 and MS2 exchange a request and its response.
//!
//! This module knows none of the three services. The engines (`ms1`, `ms2`, `pkw`) use it, and the scheduler uses
//! the engines.

mod handle;
mod outcome;
mod pool;
mod response;
mod transaction;

pub(super) use handle::Key;
pub use handle::{AcyclicId, Handle, Service};
pub use outcome::{AcyclicEvent, Cause, ConnectionEnd, SubmitError};
pub(super) use pool::{Pool, Pooled};
pub(super) use response::ExpectedResponse;
pub use response::ResponseMismatch;
pub(super) use transaction::{Progress, Stage, Timeouts, Transaction};
