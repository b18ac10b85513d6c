//! PV Access, after the protocol specification in the documentation of EPICS (pvAccess and Normative Types).
//!
//! | Module | Holds |
//! |---|---|
//! | [`wire`] | numbers, texts and sizes as octets; messages |
//! | [`normative`] | `NTScalar`, `NTEnum`, `NTTable`: descriptions and values |
//! | [`source`] | the values behind the names |
//! | [`circuit`] | the conversation with one client over TCP |
//! | [`search`] | answers to searches, and beacons, over UDP |

pub mod circuit;
pub mod normative;
pub mod search;
pub mod source;
pub mod wire;
