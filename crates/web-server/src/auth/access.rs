//! Whether users log in.

use super::{Role, User};
use std::path::PathBuf;
use std::sync::Arc;

/// How requests get a user.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Access {
    /// Every request has this user. Permitted on loopback without a proxy only.
    Anonymous(User),
    /// Users of this file log in.
    Users(PathBuf),
    /// Every request has an anonymous viewer until this file has users; from then on they log in. Permitted on loopback without a proxy
    /// only.
    UsersWhenPresent(PathBuf),
}

impl Access {
    /// Every request has a user of this name and role.
    #[must_use]
    pub fn anonymous(name: &str, role: Role) -> Self {
        Self::Anonymous(User { name: Arc::from(name), role })
    }

    /// Every request has an anonymous viewer.
    #[must_use]
    pub fn anonymous_viewer() -> Self {
        Self::Anonymous(User::anonymous())
    }
}
