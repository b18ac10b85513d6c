//! Login by OpenID Connect: the authorization code flow with PKCE, beside the users' file.
//!
//! | Module | Holds |
//! |---|---|
//! | [`settings`] | the settings of a provider |
//! | [`provider`] | the steps of a login |
//! | [`pending`] | logins that wait for the browser to return |
//! | [`metadata`] | what a provider says about itself |
//! | [`keys`] | its keys, and the check of signatures |
//! | [`token`] | the ID token |
//! | [`identity`] | the user in its claims |

pub mod identity;
pub mod keys;
pub mod metadata;
pub mod pending;
pub mod provider;
pub mod settings;
pub mod token;

pub use identity::{Identity, is_openid};
pub use provider::{BegunLogin, OpenIdError, OpenIdProvider, ReturnedLogin};
pub use settings::{ClientSecret, OpenIdSettings};
