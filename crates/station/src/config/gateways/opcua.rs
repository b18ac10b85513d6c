//! The settings of the gateway for OPC UA.

use serde::Deserialize;
use std::net::SocketAddr;
use std::path::PathBuf;

/// A security policy of OPC 10000-7. Messages are always signed and encrypted. Policies with SHA-1 signatures are not offered.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize)]
pub enum Policy {
    /// `Basic256Sha256`.
    Basic256Sha256,
    /// `Aes128_Sha256_RsaOaep`.
    #[serde(rename = "Aes128_Sha256_RsaOaep")]
    Aes128Sha256RsaOaep,
    /// `Aes256_Sha256_RsaPss`.
    #[serde(rename = "Aes256_Sha256_RsaPss")]
    Aes256Sha256RsaPss,
}

impl Policy {
    /// All policies, which is the default.
    pub const ALL: [Self; 3] = [Self::Basic256Sha256, Self::Aes128Sha256RsaOaep, Self::Aes256Sha256RsaPss];
}

/// The settings of the OPC UA gateway.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Settings {
    /// Where it listens.
    pub listen: SocketAddr,
    /// The name or address of this computer in the URLs of its endpoints.
    pub host: String,
    /// Whether programs of this computer read without encryption and login.
    pub is_anonymous: bool,
    /// The policies of the endpoints with encryption and login.
    pub policies: Vec<Policy>,
    /// The folder of the certificates.
    pub certificates: PathBuf,
    /// The file of the users who may log in.
    pub users: PathBuf,
    /// Whether users who log in write parameters.
    pub write: bool,
}
