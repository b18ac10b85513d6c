//! What stations and archives exchange: batches on subjects of JetStream, requests of users and their replies.
//!
//! | Module | Holds |
//! |---|---|
//! | [`nats`] | connections to the servers, names of subjects and messages |
//! | [`request`] | what users of an archive ask a station for, and its answers |
//!
//! The batches themselves are in `profivac_recorder::batch`.

pub mod nats;
pub mod request;
