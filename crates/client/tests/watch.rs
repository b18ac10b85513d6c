//! Watching a gauge writes the nonvolatile Channel Instance Selector when another instance is needed, and once at the end.

#![allow(clippy::unwrap_used, clippy::panic, reason = "a test")]

use crate::changing_port::{Change, ChangingPort};
use crate::until::until;
use pollster::block_on;
use profivac_client::{Bus, ms2};
use profivac_host::port::Port;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::sync::mpsc::channel;
use std::time::Duration;

/// An MS2 write of one octet to the Channel Instance Selector of a BCG450: function, slot, index, length. profibus-wire 4.6
const WRITE_SELECTOR: [u8; 4] = [0x5F, 1, 46, 1];

/// A BCG450 that shows instance 1 of slot 1, and the number of writes of its selector.
fn port() -> (Box<dyn Port>, Arc<AtomicUsize>) {
    let writes = Arc::new(AtomicUsize::new(0));
    let port = profivac_virtual::open::devices(&["bcg450@5"]).unwrap();
    let counter = Arc::clone(&writes);
    let change: Change = Box::new(move |octets| {
        if octets.windows(WRITE_SELECTOR.len()).any(|window| window == WRITE_SELECTOR) {
            counter.fetch_add(1, Ordering::SeqCst);
        }
        Some(octets.to_vec())
    });
    (Box::new(ChangingPort { port, change }), writes)
}

const OTHER_INSTANCE: &str = "ba.overrange";

#[test]
fn an_async_gauge_writes_the_selector_once_for_many_readings_and_once_at_the_end() {
    let (port, writes) = port();
    let bus = Bus::on(port).open_async().unwrap();
    let gauge = bus.gauge(5);
    for _ in 0..10 {
        block_on(gauge.read(OTHER_INSTANCE)).unwrap();
        block_on(gauge.device_state()).unwrap();
    }
    assert_eq!(writes.load(Ordering::SeqCst), 1);
    let clone = gauge.clone();
    drop(gauge);
    assert_eq!(writes.load(Ordering::SeqCst), 1, "a clone still watches");
    drop(clone);
    assert_eq!(bus.submit(|session| ms2::read(session, 5, 1, 46).unwrap()).wait().unwrap(), [1]);
    assert_eq!(writes.load(Ordering::SeqCst), 2);
}

/// The thread of the bus does something else until the gauge is dropped.
#[test]
fn dropping_an_async_gauge_submits_the_restoration_and_waits_for_nothing() {
    let (port, writes) = port();
    let bus = Bus::on(port).open_async().unwrap();
    let gauge = bus.gauge(5);
    gauge.keep_connection(Some(Duration::from_secs(3600))).wait().unwrap();
    block_on(gauge.read(OTHER_INSTANCE)).unwrap();
    let (dropped, wait) = channel();
    let busy = bus.submit(move |_| wait.recv());
    drop(gauge);
    assert_eq!(writes.load(Ordering::SeqCst), 1);
    dropped.send(()).unwrap();
    busy.wait().unwrap().unwrap();
    assert_eq!(bus.submit(|session| ms2::read(session, 5, 1, 46).unwrap()).wait().unwrap(), [1]);
    assert_eq!(writes.load(Ordering::SeqCst), 2);
}

#[test]
fn an_async_gauge_that_reads_one_instance_writes_the_selector_twice_in_all() {
    let (port, writes) = port();
    let bus = Bus::on(port).open_async().unwrap();
    let gauge = bus.gauge(5);
    for _ in 0..10 {
        block_on(gauge.read(OTHER_INSTANCE)).unwrap();
    }
    assert_eq!(writes.load(Ordering::SeqCst), 1);
    block_on(gauge.restore_selector()).unwrap();
    assert_eq!(writes.load(Ordering::SeqCst), 2);
    drop(gauge);
    assert_eq!(writes.load(Ordering::SeqCst), 2);
}

#[test]
fn a_blocking_gauge_that_reads_one_instance_writes_the_selector_twice_in_all() {
    let (port, writes) = port();
    let mut bus = Bus::on(port).open().unwrap();
    let mut gauge = bus.gauge(5).unwrap();
    for _ in 0..10 {
        gauge.read(OTHER_INSTANCE).unwrap();
    }
    drop(gauge);
    assert_eq!(writes.load(Ordering::SeqCst), 2);
    assert_eq!(ms2::read(bus.session(), 5, 1, 46).unwrap(), [1]);
}

/// Reading the selector shows the instance of the gauge, not the one that this program needed last.
#[test]
fn the_selector_reads_as_before_the_gauge_moved_it() {
    let (port, _) = port();
    let mut bus = Bus::on(port).open().unwrap();
    let mut gauge = bus.gauge(5).unwrap();
    gauge.read(OTHER_INSTANCE).unwrap();
    assert_eq!(gauge.find("1/19").unwrap().name, "pirani.process-value");
    assert_eq!(gauge.read("1/46").unwrap().text, "1");
}

/// The bus thread itself may drop the last clone.
#[test]
fn a_gauge_that_is_dropped_in_the_thread_of_the_bus_restores_the_selector() {
    let (port, writes) = port();
    let bus = Bus::on(port).open_async().unwrap();
    let gauge = bus.gauge(5);
    block_on(gauge.read(OTHER_INSTANCE)).unwrap();
    bus.submit(move |_| drop(gauge)).wait().unwrap();
    assert_eq!(bus.submit(|session| ms2::read(session, 5, 1, 46).unwrap()).wait().unwrap(), [1]);
    assert_eq!(writes.load(Ordering::SeqCst), 2);
}

/// Initiate and Abort of MS2, after the access points of the resource manager and of the master. profibus-wire 4.6.1
const INITIATE: [u8; 3] = [49, 50, 0x57];
const ABORT: [u8; 2] = [50, 0x58];

/// The connections that a program opened and closed, and whether its telegrams are lost.
#[derive(Default)]
struct Connections {
    opened: AtomicUsize,
    closed: AtomicUsize,
    is_cut: AtomicBool,
}

impl Connections {
    fn counts(&self) -> (usize, usize) {
        (self.opened.load(Ordering::SeqCst), self.closed.load(Ordering::SeqCst))
    }
}

fn counted_port() -> (Box<dyn Port>, Arc<Connections>) {
    let connections = Arc::new(Connections::default());
    let counter = Arc::clone(&connections);
    let change: Change = Box::new(move |octets| {
        let count = |part: &[u8]| octets.windows(part.len()).filter(|window| *window == part).count();
        counter.opened.fetch_add(count(&INITIATE), Ordering::SeqCst);
        counter.closed.fetch_add(count(&ABORT), Ordering::SeqCst);
        (!counter.is_cut.load(Ordering::SeqCst)).then(|| octets.to_vec())
    });
    let port = profivac_virtual::open::devices(&["bcg450@5"]).unwrap();
    (Box::new(ChangingPort { port, change }), connections)
}

#[test]
fn a_kept_connection_serves_all_requests_and_is_closed_at_the_end() {
    let (port, connections) = counted_port();
    let bus = Bus::on(port).open_async().unwrap();
    let gauge = bus.gauge(5);
    for _ in 0..3 {
        block_on(gauge.device_state()).unwrap();
    }
    assert_eq!(connections.counts(), (3, 3), "a connection for each request");
    gauge.keep_connection(Some(Duration::from_secs(3600))).wait().unwrap();
    for _ in 0..3 {
        block_on(gauge.device_state()).unwrap();
    }
    // Moves the selector, which the end of the gauge restores over the same connection.
    block_on(gauge.read(OTHER_INSTANCE)).unwrap();
    bus.submit(|session| ms2::read(session, 5, 0, 25)).wait().unwrap().unwrap();
    assert_eq!(connections.counts(), (4, 3), "one for all, that of another client included");
    gauge.keep_connection(None).wait().unwrap();
    assert_eq!(connections.counts(), (4, 4));
    gauge.keep_connection(Some(Duration::from_secs(3600))).wait().unwrap();
    block_on(gauge.device_state()).unwrap();
    drop(gauge);
    bus.submit(|_| ()).wait().unwrap();
    assert_eq!(connections.counts(), (5, 5));
    assert_eq!(bus.submit(|session| ms2::read(session, 5, 1, 46).unwrap()).wait().unwrap(), [1]);
}

#[test]
fn a_kept_connection_is_closed_when_no_request_comes() {
    let (port, connections) = counted_port();
    let bus = Bus::on(port).open_async().unwrap();
    let gauge = bus.gauge(5);
    gauge.keep_connection(Some(Duration::from_millis(100))).wait().unwrap();
    block_on(gauge.device_state()).unwrap();
    // No request: only the thread of the bus closes it.
    let is_closed = |(opened, closed): (usize, usize)| opened == closed;
    until("the end of the connection", || is_closed(connections.counts()).then_some(()));
    let before = connections.counts().0;
    block_on(gauge.device_state()).unwrap();
    assert!(connections.counts().0 > before, "the next request opens another one");
}

#[test]
fn a_kept_connection_that_was_lost_is_opened_again_after_the_gauge_is_identified() {
    let (port, connections) = counted_port();
    let bus = Bus::on(port).timeout(Duration::from_secs(60)).open_async().unwrap();
    let gauge = bus.gauge(5);
    gauge.keep_connection(Some(Duration::from_secs(3600))).wait().unwrap();
    block_on(gauge.device_state()).unwrap();
    connections.is_cut.store(true, Ordering::SeqCst);
    block_on(gauge.device_state()).unwrap_err();
    assert!(!bus.submit(|session| session.has_kept_connection(5)).wait().unwrap());
    connections.is_cut.store(false, Ordering::SeqCst);
    let before = connections.counts().0;
    block_on(gauge.device_state()).unwrap();
    assert_eq!(connections.counts().0, before + 1);
}
