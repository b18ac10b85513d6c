//! Stations and segments for the tests of the station.
//!
//! | Module | Holds |
//! |---|---|
//! | `api` | requests to the API without a socket |
//! | `inputs` | snapshots of one segment with one gauge |
//! | `memory_station` | a station with a gauge in memory and users who send requests |
//! | `tcp_segment` | virtual devices behind a TCP port, with faults |

#![allow(clippy::unwrap_used, clippy::panic, clippy::indexing_slicing, reason = "a test")]
#![allow(dead_code, reason = "each test uses its part")]

pub mod api;
pub mod inputs;
pub mod memory_station;
pub mod tcp_segment;

use profivac_recorder::{Recorder, Settings};
use profivac_station::services::Services;
use std::path::{Path, PathBuf};
use std::sync::Arc;

pub use crate::until::{TIMEOUT, until};

/// The database of the services in `folder`.
pub fn database(folder: &Path) -> PathBuf {
    folder.join("plant.db")
}

/// The services of a station called Target hall, with a database in `folder`.
pub fn services(folder: &Path) -> Arc<Services> {
    let recorder = Recorder::start(&database(folder), Settings::default()).unwrap();
    Arc::new(Services::new("Target hall".to_owned(), database(folder), recorder))
}
