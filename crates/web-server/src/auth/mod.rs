//! Authentication: users and roles, passwords, sessions, rate limits.
//!
//! | Role | Permissions |
//! |---|---|
//! | viewer | read everything |
//! | operator | as viewer; acknowledge alarms, execute commands of a gauge, make notes |
//! | engineer | as operator; write parameters, take alarms out of service, take over control authority |
//!
//! | Module | Holds |
//! |---|---|
//! | [`access`] | whether users log in |
//! | [`actor`] | the user of a request with the network address |
//! | [`connections`] | permits for connections and live streams |
//! | [`file_permissions`] | files that only their owner may read |
//! | [`openid`] | login by OpenID Connect |
//! | [`password`] | rules for passwords, and their hashes |
//! | [`rate_limit`] | limits on requests and logins |
//! | [`secret`] | random numbers for sessions and tokens |
//! | [`session_file`] | the file of the sessions, which survive a restart |
//! | [`sessions`] | sessions in memory |
//! | [`users`] | the users' file |
//!
//! [`crate::authenticator`] combines these parts.

pub mod access;
pub mod actor;
mod common_passwords;
pub mod connections;
pub mod file_permissions;
pub mod openid;
pub mod password;
pub mod rate_limit;
pub mod secret;
pub mod session_file;
pub mod sessions;
pub mod users;

pub use access::Access;
pub use actor::Actor;
pub use profivac_model::Role;

use std::sync::Arc;

/// The user of a request.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct User {
    /// The name of the account.
    pub name: Arc<str>,
    /// The role.
    pub role: Role,
}

/// A user lacks the role for an action.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{action} needs the role {needed}, {} has {}", user.name, user.role)]
pub struct Forbidden {
    /// The action, as the beginning of a sentence: `writing a parameter`.
    pub action: String,
    /// The lowest role that may do it.
    pub needed: Role,
    /// The user.
    pub user: User,
}

impl User {
    /// The user of a request without a session.
    #[must_use]
    pub fn anonymous() -> Self {
        Self { name: Arc::from("anonymous"), role: Role::Viewer }
    }

    /// Checks that the user has the role `needed` or a higher one.
    ///
    /// # Errors
    /// [`Forbidden`] names `action` and the role that it needs.
    pub fn require(&self, needed: Role, action: &str) -> Result<(), Forbidden> {
        if self.role >= needed {
            return Ok(());
        }
        Err(Forbidden { action: action.to_owned(), needed, user: self.clone() })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_role_has_the_permissions_of_all_lower_roles() {
        for (rank, role) in Role::ALL.into_iter().enumerate() {
            let user = User { name: Arc::from("ada"), role };
            for (needed_rank, needed) in Role::ALL.into_iter().enumerate() {
                assert_eq!(user.require(needed, "it").is_ok(), rank >= needed_rank, "{role} for {needed}");
            }
        }
        let refused = User::anonymous().require(Role::Engineer, "writing a parameter").unwrap_err();
        assert_eq!(refused.to_string(), "writing a parameter needs the role engineer, anonymous has viewer");
    }
}
