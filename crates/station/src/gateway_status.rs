//! The state of the gateways to control systems, for the API: clients, errors, dropped updates.

use crate::view::{StoppedPart, unix_ms};
use profivac_recorder::Micros;
use serde::Serialize;
use std::collections::{BTreeMap, BTreeSet};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use utoipa::ToSchema;

/// The state of a gateway.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, ToSchema)]
pub struct GatewayView {
    /// Its name: `archive`, `epics`, `opcua`, `mqtt`, `sparkplug`, `modbus`, `prometheus`.
    pub name: String,
    /// Whether it serves its clients, or is connected to its broker.
    pub is_running: bool,
    /// Where it listens, or the broker to which it connects.
    pub address: Option<String>,
    /// Why it does not run; it tries again.
    pub problem: Option<String>,
    /// Connected clients; for a broker 1 while it is connected.
    pub clients: u64,
    /// Values and answers that were sent since the station started.
    pub sent: u64,
    /// Updates that a slow client did not get because a newer one of the same value replaced them.
    pub dropped_updates: u64,
    /// Requests and connections that were refused or could not be understood.
    pub refused: u64,
    /// The last error, in a sentence.
    pub last_error: Option<String>,
    /// When it occurred, in milliseconds since 1970.
    pub last_error_ms: Option<i64>,
}

/// The state of one gateway, which the gateway writes.
#[derive(Debug)]
pub struct GatewayStatus {
    view: Mutex<GatewayView>,
}

impl GatewayStatus {
    fn new(name: &str) -> Self {
        let view = GatewayView {
            name: name.to_owned(),
            is_running: false,
            address: None,
            problem: None,
            clients: 0,
            sent: 0,
            dropped_updates: 0,
            refused: 0,
            last_error: None,
            last_error_ms: None,
        };
        Self { view: Mutex::new(view) }
    }

    /// The gateway serves its clients at `address`, or is connected to the broker there.
    pub fn runs(&self, address: String) {
        let mut view = self.lock();
        view.is_running = true;
        view.address = Some(address);
        view.problem = None;
    }

    /// The gateway does not run; it tries again.
    pub fn fails(&self, problem: &str) {
        let mut view = self.lock();
        view.is_running = false;
        view.clients = 0;
        view.problem = Some(problem.to_owned());
        note_error(&mut view, problem);
    }

    /// An error that does not end the gateway.
    pub fn error(&self, error: &str) {
        note_error(&mut self.lock(), error);
    }

    /// A client has connected.
    pub fn client_connected(&self) {
        let mut view = self.lock();
        view.clients = view.clients.saturating_add(1);
    }

    /// A client has disconnected.
    pub fn client_disconnected(&self) {
        let mut view = self.lock();
        view.clients = view.clients.saturating_sub(1);
    }

    /// Sets the number of clients, where a library counts them.
    pub fn set_clients(&self, clients: u64) {
        self.lock().clients = clients;
    }

    /// `count` more values or answers were sent.
    pub fn sent(&self, count: u64) {
        let mut view = self.lock();
        view.sent = view.sent.saturating_add(count);
    }

    /// `count` more updates were replaced by newer ones before a client took them.
    pub fn dropped_updates(&self, count: u64) {
        let mut view = self.lock();
        view.dropped_updates = view.dropped_updates.saturating_add(count);
    }

    /// A request or a connection was refused, with a sentence why.
    pub fn refused(&self, reason: &str) {
        let mut view = self.lock();
        view.refused = view.refused.saturating_add(1);
        note_error(&mut view, reason);
    }

    /// The present state.
    #[must_use]
    pub fn view(&self) -> GatewayView {
        self.lock().clone()
    }

    fn lock(&self) -> MutexGuard<'_, GatewayView> {
        self.view.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

fn note_error(view: &mut GatewayView, error: &str) {
    view.last_error = Some(error.to_owned());
    view.last_error_ms = Some(unix_ms(Micros::now()));
}

/// The states of all gateways, by name.
#[derive(Debug, Default)]
pub struct GatewayStatuses {
    gateways: Mutex<BTreeMap<String, Arc<GatewayStatus>>>,
}

impl GatewayStatuses {
    /// Adds a gateway that does not run yet. A former gateway of that name is forgotten.
    #[must_use]
    pub fn add(&self, name: &str) -> Arc<GatewayStatus> {
        let status = Arc::new(GatewayStatus::new(name));
        self.lock().insert(name.to_owned(), Arc::clone(&status));
        status
    }

    /// Removes a gateway that has stopped.
    pub fn remove(&self, name: &str) {
        self.lock().remove(name);
    }

    /// The states of all gateways, by name.
    #[must_use]
    pub fn views(&self) -> Vec<GatewayView> {
        self.lock().values().map(|status| status.view()).collect()
    }

    /// The gateways that cannot run, by name.
    #[must_use]
    pub fn stopped(&self) -> Vec<StoppedPart> {
        let stopped = |view: GatewayView| view.problem.map(|problem| StoppedPart { name: view.name, problem });
        self.views().into_iter().filter_map(stopped).collect()
    }

    fn lock(&self) -> MutexGuard<'_, BTreeMap<String, Arc<GatewayStatus>>> {
        self.gateways.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

/// Finds the parts that have stopped or run again since the last look, so that each change is reported once.
#[derive(Debug, Default)]
pub struct StopReports {
    reported: BTreeSet<String>,
}

impl StopReports {
    /// A sentence for each part that has stopped since the last look, and for each one whose problem is over.
    pub fn changes(&mut self, stopped: &[StoppedPart]) -> Vec<String> {
        let present = stopped.iter().map(|part| part.name.clone()).collect();
        let before = std::mem::replace(&mut self.reported, present);
        // A broker with a standby gives another reason at each attempt: only the first one is reported.
        let begun = stopped.iter().filter(|part| !before.contains(&part.name));
        let begun = begun.map(|part| format!("{} does not run: {}; the station tries again", part.name, part.problem));
        let over = before.difference(&self.reported).map(|name| format!("{name}: the problem is over"));
        begun.chain(over).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_part_that_stops_is_reported_once_and_once_more_when_it_runs_again() {
        let statuses = GatewayStatuses::default();
        let mut reports = StopReports::default();
        let (modbus, epics) = (statuses.add("modbus"), statuses.add("epics"));
        assert!(reports.changes(&statuses.stopped()).is_empty(), "a part that starts has not failed");
        modbus.fails("cannot listen on 127.0.0.1:502: address in use");
        epics.runs("ca 127.0.0.1:5064".to_owned());
        let first = reports.changes(&statuses.stopped());
        let expected =
            "modbus does not run: cannot listen on 127.0.0.1:502: address in use; the station tries again".to_owned();
        assert_eq!(first, [expected]);
        modbus.fails("cannot listen on 127.0.0.1:502: address in use");
        assert!(reports.changes(&statuses.stopped()).is_empty(), "it was reported");
        modbus.runs("127.0.0.1:502".to_owned());
        assert_eq!(reports.changes(&statuses.stopped()), ["modbus: the problem is over"]);
        assert!(statuses.stopped().is_empty());
    }

    #[test]
    fn a_gateway_reports_its_clients_errors_and_dropped_updates() {
        let statuses = GatewayStatuses::default();
        let status = statuses.add("modbus");
        status.runs("127.0.0.1:1502".to_owned());
        status.client_connected();
        status.client_connected();
        status.client_disconnected();
        status.dropped_updates(3);
        status.refused("a write");
        let [view] = &statuses.views()[..] else { panic!("one gateway") };
        assert_eq!((view.is_running, view.clients, view.dropped_updates, view.refused), (true, 1, 3, 1));
        assert_eq!((view.last_error.as_deref(), view.problem.as_deref()), (Some("a write"), None));
        status.fails("the port is in use");
        let view = status.view();
        assert_eq!((view.is_running, view.clients), (false, 0));
        assert_eq!(view.problem.as_deref(), Some("the port is in use"));
        statuses.remove("modbus");
        assert!(statuses.views().is_empty());
    }
}
