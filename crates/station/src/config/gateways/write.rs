//! What clients of a control system may write.

use super::modbus::Network;
use std::net::IpAddr;
use std::path::PathBuf;

/// What clients of a gateway may write.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Write {
    /// The user as whom the gateway writes.
    pub user: String,
    /// The file of the users.
    pub users: PathBuf,
    /// The computers that may write.
    pub clients: Vec<Network>,
}

impl Write {
    /// Whether a computer may write.
    #[must_use]
    pub fn permits(&self, peer: IpAddr) -> bool {
        self.clients.iter().any(|network| network.contains(peer))
    }
}
