//! Whether people log in here, and where we may listen then.

use super::{Person, Role};
use std::path::PathBuf;
use std::sync::Arc;

/// Who is let in.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Access {
    /// Everybody who reaches the socket is this person: only where nobody but this computer reaches it.
    Everybody(Person),
    /// Those in this file, once they have logged in.
    Users(PathBuf),
}

impl Access {
    /// Everybody under this name, with this role.
    #[must_use]
    pub fn everybody(name: &str, role: Role) -> Self {
        Self::Everybody(Person { name: Arc::from(name), role })
    }

    /// Nobody logs in, and everybody may look.
    #[must_use]
    pub fn look() -> Self {
        Self::Everybody(Person::anybody())
    }
}
