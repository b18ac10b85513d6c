//! The station: what a vacuum group leaves running for years.
//!
//! | Module | Holds |
//! |---|---|
//! | [`act`] | commands and parameters: armed, fired, by one person at a time, and written down |
//! | [`alarm`] | what somebody must know about, and who knows |
//! | [`api`] | what can be asked over HTTP |
//! | [`config`] | the file that describes a station |
//! | [`people`] | who asks, and what they may |
//! | [`plant`] | what all threads share |
//! | [`pumpdown`] | pump-downs in what was recorded |
//! | [`recorder`] | what was measured and what happened, in a file that survives a power cut |
//! | [`report`] | a page about a pump-down |
//! | [`rise`] | leaks told from outgassing |
//! | [`segment`] | a port, a master, its gauges: a thread of their own |
//! | [`server`] | API and dashboard on a socket |
//! | [`station`] | all of it |
//! | [`view`] | what can be seen |
//! | [`web`] | the dashboard |
//! | [`webhook`] | who is told of alarms over HTTP |

pub mod alarm;
pub mod api;
pub mod auth;
pub mod config;
pub mod control;
mod host_name;
pub mod pumpdown;
pub mod report;
pub mod rise;
pub mod segment;
pub mod server;
pub mod services;
pub mod station;
pub mod suggestion;
pub mod view;
pub mod web;
pub mod webhook;
