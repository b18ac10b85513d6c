//! Who asks, and what they may.
//!
//! | Role | May |
//! |---|---|
//! | viewer | look |
//! | operator | look, acknowledge alarms, carry out commands of a gauge |
//! | engineer | all of that, write parameters, take alarms out of service, take the mastership from others |
//!
//! | Module | Holds |
//! |---|---|
//! | [`access`] | whether people log in here, and where we may listen then |
//! | [`door`] | who comes in |
//! | [`password`] | what a password must be, and how it is kept |
//! | [`private`] | files that only their owner may read |
//! | [`rates`] | how often somebody may ask |
//! | [`secret`] | numbers nobody can guess |
//! | [`sessions`] | who has logged in |
//! | [`users`] | the file with names, roles and passwords |

pub mod access;
pub mod authenticator;
pub mod file_permissions;
pub mod password;
pub mod rate_limit;
pub mod secret;
pub mod sessions;
pub mod users;

pub use access::Access;

use crate::api::Problem;
use axum::extract::FromRequestParts;
use axum::http::request::Parts;
use serde::{Deserialize, Serialize};
use std::convert::Infallible;
use std::fmt;
use std::sync::Arc;
use utoipa::ToSchema;

/// What somebody may do. Who may more may all that those may who may less.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "lowercase")]
pub enum Role {
    /// Looks.
    Viewer,
    /// Runs the plant.
    Operator,
    /// Changes the plant.
    Engineer,
}

impl Role {
    /// All, from the least to the most.
    pub const ALL: [Self; 3] = [Self::Viewer, Self::Operator, Self::Engineer];

    /// As it is written.
    #[must_use]
    pub const fn word(self) -> &'static str {
        match self {
            Self::Viewer => "viewer",
            Self::Operator => "operator",
            Self::Engineer => "engineer",
        }
    }
}

impl fmt::Display for Role {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter.write_str(self.word())
    }
}

/// Somebody who asks, as the guard at the door has found out.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct User {
    /// The name they have logged in with.
    pub name: Arc<str>,
    /// What they may do.
    pub role: Role,
}

impl User {
    /// Somebody nobody has vouched for: they may look.
    #[must_use]
    pub fn anonymous() -> Self {
        Self { name: Arc::from("anybody"), role: Role::Viewer }
    }

    /// Nothing, if they have this role or one that may more.
    ///
    /// # Errors
    /// [`Problem`] 403 says which role is needed for `what`.
    pub fn require(&self, needed: Role, what: &str) -> Result<(), Problem> {
        if self.role >= needed {
            return Ok(());
        }
        let Self { name, role } = self;
        Err(Problem::forbidden(format!("{what} needs the role {needed}, {name} has {role}")))
    }
}

impl<S: Send + Sync> FromRequestParts<S> for User {
    type Rejection = Infallible;

    async fn from_request_parts(parts: &mut Parts, _: &S) -> Result<Self, Infallible> {
        Ok(parts.extensions.get::<Self>().cloned().unwrap_or_else(Self::anonymous))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn who_may_more_may_all_that_others_may() {
        for (place, role) in Role::ALL.into_iter().enumerate() {
            let person = User { name: Arc::from("Ada"), role };
            for (needed, wanted) in Role::ALL.into_iter().enumerate() {
                assert_eq!(person.require(wanted, "it").is_ok(), place >= needed, "{role} for {wanted}");
            }
        }
        let refused = User::anonymous().require(Role::Engineer, "writing a parameter").unwrap_err();
        assert_eq!(refused.to_string(), "writing a parameter needs the role engineer, anybody has viewer");
    }
}
