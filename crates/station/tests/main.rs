//! The tests of this crate in one program: linked once, and what they share is compiled once.

#[path = "../../../tests/support/every_file.rs"]
mod every_file;
#[path = "../../../tests/support/foreign_bus.rs"]
mod foreign_bus;
#[path = "../../../tests/support/golden.rs"]
mod golden;
#[path = "../../../tests/support/until.rs"]
mod until;

mod acts;
mod alarm_api;
mod alarm_file;
mod alarm_kill;
mod alarm_settings;
mod alarm_station;
mod alarms;
mod api;
mod audit_power_cut;
mod backup;
mod controllers;
mod default_alarm_settings;
mod defects;
mod email;
mod fake_plant;
mod gauges;
mod listen_only;
mod login_memory;
#[cfg(feature = "openapi")]
mod openapi;
mod plant;
mod plant_states;
mod recovery;
mod report;
mod security;
mod server;
mod support;
mod webhook;
