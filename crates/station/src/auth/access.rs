//! Whether people log in here, and where we may listen then.

use super::{Role, User};
use std::path::PathBuf;
use std::sync::Arc;

/// Who is let in.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Access {
    /// Everybody who reaches the socket is this person: only where nobody but this computer reaches it.
    Anonymous(User),
    /// Those in this file, once they have logged in.
    Users(PathBuf),
}

impl Access {
    /// Everybody under this name, with this role.
    #[must_use]
    pub fn anonymous(name: &str, role: Role) -> Self {
        Self::Anonymous(User { name: Arc::from(name), role })
    }

    /// Nobody logs in, and everybody may look.
    #[must_use]
    pub fn anonymous_viewer() -> Self {
        Self::Anonymous(User::anonymous())
    }
}
