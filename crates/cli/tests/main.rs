//! The tests of this crate in one program: linked once, and what they share is compiled once.

#[path = "../../../tests/support/adapter_page.rs"]
mod adapter_page;
#[path = "../../../tests/support/every_file.rs"]
mod every_file;
#[path = "../../../tests/support/golden.rs"]
mod golden;
#[path = "../../../tests/support/until.rs"]
mod until;

mod adapter_models;
mod awaiting;
mod command_line;
mod common;
mod conform;
mod corrections;
mod decode;
mod demo;
mod device;
mod disturbed;
mod doctor;
mod epics_names;
mod examples;
mod export;
mod field_test;
mod first_steps;
mod gauge_commands;
mod gsd;
mod gsd_slaves;
mod gsd_traffic;
mod hub;
mod identify;
mod lines;
mod monitor;
mod names;
mod nonvolatile;
mod peers;
mod ports;
mod report;
mod scan;
mod scenario;
mod serial_libraries;
mod serial_server;
mod shown_commands;
mod simulated_slaves;
mod sniff;
mod station;
mod telegrams;
mod unknown_slave;
mod upgrade;
mod user;
mod user_errors;
mod wireshark;
