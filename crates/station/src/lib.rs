//! The station software: it watches the gauges of all segments, records them, raises alarms, and serves a dashboard.
//!
//! | Module | Holds |
//! |---|---|
//! | [`pumpdown`] | pump-downs in the recorded pressures |
//! | [`identification`] | plants identified from recorded pressures |
//! | [`recording`] | the recorder as the threads share it |
//! | [`view`] | what the API shows |
//! | [`bus`] | the state of the lines of all segments, and their captures |
//! | [`plant`] | the picture of the plant, and the states of its parts |
//! | [`snapshot`] | the latest snapshot of each segment |
//! | [`alarm`] | alarms after ISA-18.2 |
//! | [`config`] | the settings of the station's file |
//! | [`alarm_editor`] | settings of alarms, changed in the file and in the running station |
//! | [`control`] | commands and parameter writes: armed, executed, in the audit trail |
//! | [`report`] | a page about a pump-down |
//! | [`gateway_status`] | the state of the gateways to control systems |
//! | [`comparison`] | pump-downs beside the usual ones |
//! | [`webhook`] | notifications about alarms over HTTP |
//! | [`segment`] | a thread for each port, with a master and its gauges |
//! | [`services`] | what the threads share |
//! | [`station`] | the running station |
//! | [`api`] | the API over HTTP |
//! | [`server`] | the station behind the web server |

// The types and handlers keep the attributes of the description, which expand to nothing then (DESIGN 426).
#[cfg(not(feature = "openapi"))]
extern crate profivac_no_openapi as utoipa;

pub mod alarm;
pub mod alarm_editor;
pub mod api;
pub mod bus;
pub mod comparison;
pub mod config;
pub mod control;
pub mod directory;
pub mod drawing;
pub mod gateway_status;
pub mod identification;
pub mod plant;
pub mod pumpdown;
pub mod recording;
pub mod report;
pub mod segment;
pub mod server;
pub mod services;
pub mod snapshot;
pub mod station;
pub mod view;
pub mod webhook;
