//! Channel Access, after the protocol specification in the documentation of EPICS base.
//!
//! | Module | Holds |
//! |---|---|
//! | [`message`] | headers, commands, codes |
//! | [`dbr`] | values with their meta data as octets |
//! | [`circuit`] | the conversation with one client over TCP |
//! | [`search`] | answers to searches, and beacons, over UDP |

pub mod circuit;
pub mod dbr;
pub mod message;
pub mod search;
