//! Alarms after ISA-18.2 (IEC 62682): what is watched, where it stands, who knows.
//!
//! ```text
//! plant ─ Sight ─ Judge ─ holds? ─ delays ─ State ─ Change ─┬─ the record: where it stands, its history, an event
//!                                    people ───────────────┘└─ letters to webhooks
//! ```
//!
//! | Module | Holds |
//! |---|---|
//! | [`state`] | the table of states |
//! | [`rule`] | what is watched, and when it is an alarm |
//! | [`judge`] | whether a condition holds |
//! | [`book`] | all alarms, pure: time and sight come in, changes go out |
//! | [`paper`] | what is written of them: rows, events, letters |
//! | [`desk`] | the alarms of a running station, shared by its threads |
//! | [`watcher`] | the thread that looks |
//! | [`view`] | alarms as the API has them |

pub mod book;
pub mod desk;
pub mod judge;
pub mod paper;
pub mod rule;
pub mod state;
pub mod view;
pub mod watcher;

pub use book::{Book, By, Change, Life, Now, Out, Refusal, What};
pub use desk::{Alarms, NotDone};
pub use judge::Sight;
pub use paper::Addressee;
pub use rule::{Condition, Priority, Rule, Subject};
pub use state::State;
pub use watcher::Watcher;
