//! Control of gauges: commands and parameter writes in two steps, by one user at a time, each in the audit trail before it is sent.
//!
//! ```text
//! arm ── the gauge answers, conditions hold ── armed for 30 s ── execute ── audit entry on the disk ── the gauge answers again, nothing
//!                                                                           has changed ── sent ── outcome on the disk
//! ```
//!
//! | Module | Holds |
//! |---|---|
//! | [`permissions`] | the risk of a row, the role it needs, and what the station never does |
//! | [`operation`] | a command or a parameter write, resolved for a device |
//! | [`armed_commands`] | the commands that wait to be executed |
//! | [`authority`] | which user has control |
//! | [`error`] | why a command is not armed or not executed |
//! | `audit_entries` | the rows of the audit trail |
//! | [`refusals`] | the check of roles, and the rows about what it refuses |
//! | [`requests`] | the request queues of the segments |
//! | [`service`] | all of it, shared by the threads of the station |

pub mod armed_commands;
mod audit_entries;
pub mod authority;
pub mod error;
pub mod operation;
pub mod permissions;
pub mod refusals;
pub mod requests;
pub mod service;

pub use error::{ControlError, OperationError, SegmentRequestError};
pub use service::{AuthorityAction, ControlService, Executed};
