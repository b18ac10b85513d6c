//! Pump-downs of a database beside the usual ones.
//!
//! | Module | Holds |
//! |---|---|
//! | [`recorded`] | the pump-downs of a series, from the database |
//! | [`words`] | a deviation as a sentence |
//! | [`view`] | what the API shows |
//! | [`summary`] | the figures of a report |
//! | [`watch`] | the thread that reports deviations as events |

pub mod recorded;
pub mod summary;
pub mod view;
pub mod watch;
pub mod words;
