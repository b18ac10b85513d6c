//! MS2 connections that stay open between two clients of a slave.
//!
//! A client that ends leaves its connection to the session, and the next one at the same address takes it. The master sends Idle on it
//! meanwhile. A slave has few connections, so one that no client has used for a while is closed.

use super::BusSession;
use profivac_dp::master::Handle;
use profivac_dp::master::ms2::Connect;
use std::time::{Duration, Instant};

/// The connections to one slave.
#[derive(Debug)]
pub(super) struct KeptConnection {
    /// How long it stays open without a client.
    idle: Duration,
    /// The connection, and when it is closed.
    open: Option<(Handle<Connect>, Instant)>,
}

impl BusSession {
    /// From now on, the connection to the slave at `address` stays open between two clients, for at most `idle`; with `None` it is
    /// closed with its client, and now. [`close_idle_connections`](Self::close_idle_connections) must then be called again and again.
    pub fn set_connection_kept(&mut self, address: u8, idle: Option<Duration>) {
        match (idle, self.kept.get_mut(&address)) {
            (Some(idle), Some(kept)) => kept.idle = idle,
            (Some(idle), None) => {
                self.kept.insert(address, KeptConnection { idle, open: None });
            }
            (None, _) => {
                if let Some(KeptConnection { open: Some((connection, _)), .. }) = self.kept.remove(&address) {
                    self.close_connection(connection);
                }
            }
        }
    }

    /// Whether a connection to the slave at `address` is open and waits for a client.
    pub fn has_kept_connection(&mut self, address: u8) -> bool {
        let Some(connection) = self.take_connection(address) else { return false };
        if self.master().is_over(connection) {
            // Its end is taken, so that the master forgets it.
            self.master().outcome(connection);
            return false;
        }
        self.leave_connection(address, connection)
    }

    /// Takes the connection that a client has left, if it has not been closed since. It may have ended.
    pub fn take_connection(&mut self, address: u8) -> Option<Handle<Connect>> {
        self.kept.get_mut(&address)?.open.take().map(|(connection, _)| connection)
    }

    /// Leaves the open connection of a client that ends to the next one. Returns false if it is not kept: the client closes it.
    pub fn leave_connection(&mut self, address: u8, connection: Handle<Connect>) -> bool {
        let Some(kept) = self.kept.get_mut(&address) else { return false };
        let Some(end) = Instant::now().checked_add(kept.idle) else { return false };
        kept.open = Some((connection, end));
        true
    }

    /// Closes the connections that have waited long enough. Returns the time until the next one has.
    pub fn close_idle_connections(&mut self) -> Option<Duration> {
        let now = Instant::now();
        let is_due = |kept: &&mut KeptConnection| kept.open.is_some_and(|(_, end)| end <= now);
        let due = self.kept.values_mut().filter(is_due).filter_map(|kept| kept.open.take());
        let due: Vec<_> = due.map(|(connection, _)| connection).collect();
        due.into_iter().for_each(|connection| self.close_connection(connection));
        let ends = self.kept.values().filter_map(|kept| kept.open.map(|(_, end)| end));
        ends.min().map(|end| end.saturating_duration_since(Instant::now()))
    }

    /// Closes all kept connections and keeps none from now on.
    pub fn close_kept_connections(&mut self) {
        let kept = std::mem::take(&mut self.kept);
        for (connection, _) in kept.into_values().filter_map(|kept| kept.open) {
            self.close_connection(connection);
        }
    }

    /// A connection that cannot be closed has ended, or the slave closes it for lack of traffic.
    fn close_connection(&mut self, connection: Handle<Connect>) {
        if self.master().ms2_close(connection).is_ok() {
            self.set_restoring(true);
            self.wait_for_outcome(connection, drop).ok();
            self.set_restoring(false);
        }
    }
}
