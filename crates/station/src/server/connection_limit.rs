//! Places for connections: so many in all, and of each computer elsewhere not more than a quarter of them, so that one alone keeps
//! nobody out. All who come through a proxy on this computer have its address: loopback may have all.

use crate::auth::rate_limit::network;
use std::collections::HashMap;
use std::net::IpAddr;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

/// One computer may have this part of all places. free choice: dozens of windows, and three others find room beside it.
const SHARE: usize = 4;

/// Who has how many.
type Taken = HashMap<IpAddr, usize>;

/// All places.
pub struct ConnectionLimit {
    most: usize,
    taken: Arc<Mutex<Taken>>,
}

/// A place that somebody has until this is dropped.
pub struct ConnectionSlot {
    peer: IpAddr,
    taken: Arc<Mutex<Taken>>,
}

impl ConnectionLimit {
    /// So many.
    pub fn new(most: usize) -> Self {
        Self { most, taken: Arc::default() }
    }

    /// A place for this one, if there is one.
    pub fn take(&self, peer: IpAddr) -> Option<ConnectionSlot> {
        let peer = network(peer);
        let mut taken = locked(&self.taken);
        let own = taken.get(&peer).copied().unwrap_or_default();
        let most = if peer.is_loopback() { self.most } else { (self.most / SHARE).max(1) };
        if own >= most || taken.values().sum::<usize>() >= self.most {
            return None;
        }
        taken.insert(peer, own.saturating_add(1));
        Some(ConnectionSlot { peer, taken: Arc::clone(&self.taken) })
    }
}

impl Drop for ConnectionSlot {
    fn drop(&mut self) {
        let mut taken = locked(&self.taken);
        let left = taken.get(&self.peer).map_or(0, |own| own.saturating_sub(1));
        if left == 0 {
            taken.remove(&self.peer);
        } else {
            taken.insert(self.peer, left);
        }
    }
}

fn locked(taken: &Mutex<Taken>) -> MutexGuard<'_, Taken> {
    taken.lock().unwrap_or_else(PoisonError::into_inner)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn one_computer_alone_keeps_nobody_out() {
        let places = ConnectionLimit::new(16);
        let take = |peer: &str| places.take(peer.parse().unwrap());
        let mut own: Vec<_> = (0..100).filter_map(|_| take("10.0.0.1")).collect();
        assert_eq!(own.len(), 4);
        let house: Vec<_> = (0..100).filter_map(|number| take(&format!("2001:db8::{number:x}"))).collect();
        assert_eq!(house.len(), 4, "a house full of addresses is one");
        own.pop();
        assert!(take("10.0.0.1").is_some(), "a place that is left is free");
        let proxy: Vec<_> = (0..100).filter_map(|_| take("127.0.0.1")).collect();
        assert_eq!(proxy.len(), 9, "all that are free");
        assert!(take("10.0.0.2").is_none());
        drop((own, house, proxy));
        assert!(locked(&places.taken).is_empty(), "nobody is remembered");
    }
}
