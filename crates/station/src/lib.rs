//! The station software: it watches the gauges of all segments, records them, raises alarms, and serves a dashboard.

// The types and handlers keep the attributes of the description, which expand to nothing then (docs/decisions, 426).
#[cfg(not(feature = "openapi"))]
extern crate profivac_no_openapi as utoipa;

pub mod alarm;
pub mod alarm_editor;
pub mod api;
pub mod bus;
pub mod comparison;
pub mod config;
pub mod control;
pub mod database_check;
pub mod directory;
pub mod drawing;
pub mod gateway_status;
pub mod identification;
pub mod known_file;
pub mod plant;
pub mod pumpdown;
pub mod recording;
pub mod report;
mod restarts;
pub mod segment;
pub mod server;
pub mod services;
pub mod snapshot;
pub mod station;
pub mod view;
pub mod webhook;
