//! The station: what a vacuum group leaves running for years.
//!
//! | Module | Holds |
//! |---|---|
//! | [`recorder`] | what was measured and what happened, in a file that survives a power cut |
//! | [`rise`] | leaks told from outgassing |

pub mod recorder;
pub mod rise;
