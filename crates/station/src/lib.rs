//! The station: what a vacuum group leaves running for years.
//!
//! | Module | Holds |
//! |---|---|
//! | [`api`] | what can be asked over HTTP |
//! | [`plant`] | what all threads share |
//! | [`recorder`] | what was measured and what happened, in a file that survives a power cut |
//! | [`rise`] | leaks told from outgassing |
//! | [`view`] | what can be seen |
//! | [`web`] | the dashboard |

pub mod api;
pub mod plant;
pub mod recorder;
pub mod rise;
pub mod view;
pub mod web;
