//! Guards and buses that are dropped in different orders, and after an error: the gauge is as before.

#![allow(clippy::unwrap_used, clippy::panic, reason = "a test")]

use pollster::block_on;
use profivac_client::class1::Class1Session;
use profivac_client::cyclic::CyclicSlave;
use profivac_client::records::RecordError;
use profivac_client::{Bus, ms2};
use profivac_devices::model::AccessPath;
use profivac_dp::master::services;
use profivac_host::session::{Reply, SessionError};
use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};

/// A parameter of an instance that slot 1 does not show at the beginning.
const OTHER_INSTANCE: &str = "ba.overrange";

fn bus() -> Bus {
    Bus::on(profivac_virtual::open::devices(&["bcg450@5"]).unwrap()).open().unwrap()
}

/// A cancellation ends the waits of the program, not the restoration of what the program has changed.
#[test]
fn a_gauge_that_is_dropped_after_a_cancellation_restores_the_selector() {
    let mut bus = bus();
    for allowed in 0..1000 {
        let waits = Arc::new(AtomicUsize::new(0));
        let counted = Arc::clone(&waits);
        let cancel = move || counted.fetch_add(1, Ordering::SeqCst) >= allowed;
        bus.session().set_cancellation(Some(Box::new(cancel)));
        let ended = bus.gauge(5).and_then(|mut gauge| gauge.read(OTHER_INSTANCE));
        bus.session().set_cancellation(None);
        assert_eq!(ms2::read(bus.session(), 5, 1, 46).unwrap(), [1], "cancelled after {allowed} waits: {ended:?}");
        if waits.load(Ordering::SeqCst) <= allowed {
            ended.unwrap();
            return;
        }
    }
    panic!("a reading takes fewer waits");
}

#[test]
fn an_async_gauge_restores_the_selector_whether_its_bus_is_dropped_before_or_after_it() {
    for bus_first in [true, false] {
        let bus = bus_async();
        let (gauge, watching) = (bus.gauge(5), bus.clone());
        block_on(gauge.read(OTHER_INSTANCE)).unwrap();
        if bus_first {
            drop(bus);
            drop(gauge);
        } else {
            drop(gauge);
            drop(bus);
        }
        let selector = watching.submit(|session| ms2::read(session, 5, 1, 46).unwrap()).wait().unwrap();
        assert_eq!(selector, [1], "bus first: {bus_first}");
    }
}

fn bus_async() -> profivac_client::AsyncBus {
    Bus::on(profivac_virtual::open::devices(&["bcg450@5"]).unwrap()).open_async().unwrap()
}

/// An owner of 255 is none: profibus-wire 2.4.
#[test]
fn a_class_1_session_that_is_cancelled_at_any_moment_releases_the_slave() {
    let mut bus = bus();
    let slave = CyclicSlave::find(bus.session(), 5, 0).unwrap();
    for allowed in 0.. {
        let waits = AtomicUsize::new(0);
        let cancel = move || waits.fetch_add(1, Ordering::SeqCst) >= allowed;
        bus.session().set_cancellation(Some(Box::new(cancel)));
        let opened = Class1Session::open(bus.session(), &slave, AccessPath::Class1).map(drop);
        bus.session().set_cancellation(None);
        let owner = owner(&mut bus);
        assert_eq!(owner, Some(255), "cancelled after {allowed} waits: {opened:?}");
        match opened {
            Err(RecordError::Session(SessionError::Interrupted) | RecordError::NotSent(SessionError::Interrupted)) => {}
            opened => return opened.unwrap(),
        }
    }
}

/// Octet 4 of Slave_Diag.
fn owner(bus: &mut Bus) -> Option<u8> {
    let Reply::Answer { du, .. } = bus.session().request(&services::slave_diag(5)).unwrap() else {
        panic!("no answer")
    };
    du.get(3).copied()
}
