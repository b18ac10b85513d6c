//! Attacks on a real server on loopback. docs/security.md names the test for each item.

#![allow(clippy::unwrap_used, clippy::panic, reason = "a test")]

mod control;
mod http2;
mod list;
mod login;
mod openid;
mod requests;
mod restart;
mod sessions;
mod test_provider;
mod test_station;
mod tls;
