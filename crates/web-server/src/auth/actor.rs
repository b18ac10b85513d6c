//! The user of a request with the network address, as the audit trail names them.

use super::User;
use profivac_recorder::{AuditAction, AuditEntry, Micros};
use std::net::IpAddr;

/// A user with the network address of the request.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Actor {
    /// The user.
    pub user: User,
    /// The network address, if it is known.
    pub peer: Option<IpAddr>,
}

impl Actor {
    /// A row of the audit trail about something that this user did, without a subject.
    #[must_use]
    pub fn audit_entry(&self, action: AuditAction) -> AuditEntry {
        AuditEntry {
            id: 0,
            at: Micros::now(),
            action: action.into(),
            refers_to: None,
            user: self.user.name.to_string(),
            role: self.user.role.into(),
            peer: self.peer.map(|peer| peer.to_string()),
            gauge: None,
            segment: None,
            address: None,
            target: None,
            before: None,
            after: None,
            outcome: None,
            command_id: None,
        }
    }
}
