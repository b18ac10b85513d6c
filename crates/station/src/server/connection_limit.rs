//! The limit on connections: a number in all, and at most a quarter of them for one remote client, so that one client alone cannot
//! keep out the others. All clients of a proxy on this computer have a loopback address, so loopback may use all connections.

use crate::auth::rate_limit::network;
use std::collections::HashMap;
use std::net::IpAddr;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

/// One client may use the total divided by this number. free choice: enough for dozens of pages, and three other clients fit.
const SHARE: usize = 4;

/// Open connections by client.
type Open = HashMap<IpAddr, usize>;

/// The connections of a server.
pub struct ConnectionLimit {
    max: usize,
    open: Arc<Mutex<Open>>,
}

/// The right to one connection. Dropping it frees the connection.
pub struct ConnectionSlot {
    peer: IpAddr,
    open: Arc<Mutex<Open>>,
}

impl ConnectionLimit {
    /// At most `max` connections.
    pub fn new(max: usize) -> Self {
        Self { max, open: Arc::default() }
    }

    /// A slot for a connection from `peer`; `None` if the limit is reached.
    pub fn take(&self, peer: IpAddr) -> Option<ConnectionSlot> {
        let peer = network(peer);
        let mut open = locked(&self.open);
        let own = open.get(&peer).copied().unwrap_or_default();
        let max_own = if peer.is_loopback() { self.max } else { (self.max / SHARE).max(1) };
        if own >= max_own || open.values().sum::<usize>() >= self.max {
            return None;
        }
        open.insert(peer, own.saturating_add(1));
        Some(ConnectionSlot { peer, open: Arc::clone(&self.open) })
    }
}

impl Drop for ConnectionSlot {
    fn drop(&mut self) {
        let mut open = locked(&self.open);
        let left = open.get(&self.peer).map_or(0, |own| own.saturating_sub(1));
        if left == 0 {
            open.remove(&self.peer);
        } else {
            open.insert(self.peer, left);
        }
    }
}

fn locked(open: &Mutex<Open>) -> MutexGuard<'_, Open> {
    open.lock().unwrap_or_else(PoisonError::into_inner)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn one_client_alone_cannot_take_all_connections() {
        let limit = ConnectionLimit::new(16);
        let take = |peer: &str| limit.take(peer.parse().unwrap());
        let mut own: Vec<_> = (0..100).filter_map(|_| take("10.0.0.1")).collect();
        assert_eq!(own.len(), 4);
        let network: Vec<_> = (0..100).filter_map(|number| take(&format!("2001:db8::{number:x}"))).collect();
        assert_eq!(network.len(), 4, "the addresses of one IPv6 network count as one client");
        own.pop();
        assert!(take("10.0.0.1").is_some(), "a closed connection frees its slot");
        let proxy: Vec<_> = (0..100).filter_map(|_| take("127.0.0.1")).collect();
        assert_eq!(proxy.len(), 9, "loopback takes all slots that are free");
        assert!(take("10.0.0.2").is_none());
        drop((own, network, proxy));
        assert!(locked(&limit.open).is_empty(), "no client without connections is kept");
    }
}
