//! Interruptions of a write: the line is unplugged, the device is switched off, another master writes, the address changes.
//! Each ends soon and with a clear error.

use crate::twelve_devices::FIRST;
use crate::twelve_devices::real_time::{Bench, TIMEOUT, bus_of, conditions};
use crate::twelve_devices::rig::{BAUD, patient};
use profivac_client::address::{self, AddressError};
use profivac_client::class1::Class1Session;
use profivac_client::cyclic::CyclicSlave;
use profivac_client::ms2::{Ms2, Ms2Error};
use profivac_client::records::Records;
use profivac_client::{ClientError, Gauge};
use profivac_devices::model::AccessPath;
use profivac_dp::link::active::BusParameters;
use profivac_dp::master::{Mode, SlaveParameters};
use profivac_host::port::{Character, Port, PortError};
use profivac_host::readiness::Readiness;
use profivac_host::session::{BusSession, SessionError};
use profivac_virtual::open;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Arc, Mutex};
use std::time::Instant;

/// Low Trip Enable of the first trip point, tira56e1 11.2.
const SLOT: u8 = 2;
const INDEX: u8 = 20;
const TARGET: &str = "2/20";

/// More telegrams than a single write needs.
const MOMENTS: usize = 8;

/// SD4
const TOKEN: u8 = 0xDC;

fn gauges(count: usize) -> Vec<String> {
    (FIRST..).take(count).map(|address| format!("pcg550@{address}")).collect()
}

/// After this many telegrams, the interruption happens instead of the next one.
#[derive(Clone)]
struct Fate(Arc<AtomicUsize>);

const NEVER: usize = usize::MAX;

impl Fate {
    fn new() -> Self {
        Self(Arc::new(AtomicUsize::new(NEVER)))
    }

    fn after(&self, telegrams: usize) {
        self.0.store(telegrams, Ordering::SeqCst);
    }

    fn has_come(&self) -> bool {
        match self.0.load(Ordering::SeqCst) {
            0 => true,
            NEVER => false,
            left => {
                self.0.store(left - 1, Ordering::SeqCst);
                false
            }
        }
    }
}

type Happens = Box<dyn FnMut() -> Result<(), PortError> + Send>;

/// A port with an interruption.
struct Fateful {
    port: Box<dyn Port>,
    fate: Fate,
    happens: Happens,
}

impl Port for Fateful {
    fn name(&self) -> &str {
        self.port.name()
    }

    fn readiness(&self) -> Vec<Readiness<'_>> {
        self.port.readiness()
    }

    fn receive(&mut self, heard: &mut Vec<Character>) -> Result<(), PortError> {
        self.port.receive(heard)
    }

    fn send(&mut self, octets: &[u8]) -> Result<(), PortError> {
        // Tokens circulate in between, as many as fit.
        if octets.first() != Some(&TOKEN) && self.fate.has_come() {
            (self.happens)()?;
        }
        self.port.send(octets)
    }
}

/// A session on a port with an interruption.
fn fateful(name: &str, bus: BusParameters, fate: &Fate, happens: Happens) -> BusSession {
    let port = open::port(name, BAUD).unwrap();
    BusSession::new(Box::new(Fateful { port, fate: fate.clone(), happens }), BAUD, bus, TIMEOUT).unwrap()
}

/// Interrupts the line at every telegram of a write: the error names the lost port, at once.
#[test]
fn a_line_that_is_cut_during_a_write_is_reported_as_lost() {
    let bench = Bench::on_tcp(&gauges(MOMENTS));
    // Each round begins with T_TO, which is short with a short slot time.
    let bus = BusParameters { slot_tbit: bus_of(0, 0).slot_tbit / 8, ..bus_of(0, 0) };
    for (moment, address) in (0..MOMENTS).zip(FIRST..) {
        let (fate, name) = (Fate::new(), bench.name.clone());
        let cut = Box::new(move || Err(PortError::Lost(name.clone())));
        let mut session = fateful(&bench.name, bus, &fate, cut);
        let mut records = Ms2::new(&mut session, address);
        assert_eq!(records.read(SLOT, INDEX).unwrap(), [1]);
        fate.after(moment);
        let begun = Instant::now();
        let written = records.write(SLOT, INDEX, &[0]);
        assert!(begun.elapsed() < TIMEOUT, "{moment}");
        match written {
            Err(
                Ms2Error::Session(SessionError::Port(lost @ PortError::Lost(_)))
                | Ms2Error::NotSent(SessionError::Port(lost @ PortError::Lost(_))),
            ) => {
                assert!(lost.to_string().contains("unplugged"), "{lost}");
            }
            Ok(()) => {
                assert!(moment > 1, "a request and a poll at least");
                return;
            }
            Err(error) => panic!("{moment}: {error}"),
        }
    }
    panic!("it never came to an end");
}

/// The device is switched off between request and response, so the error says that the outcome of the
/// write is not known.
#[test]
fn a_device_that_is_switched_off_during_a_write_leaves_the_outcome_unknown() {
    let bench = Arc::new(Mutex::new(Bench::on_a_pty(&gauges(1))));
    let (fate, benched) = (Fate::new(), Arc::clone(&bench));
    let off = Box::new(move || {
        benched.lock().unwrap().order(|devices| devices[0].set_power(false));
        Ok(())
    });
    let name = bench.lock().unwrap().name.clone();
    let mut session = fateful(&name, bus_of(0, 0), &fate, off);
    let mut gauge = Gauge::open(&mut session, FIRST).unwrap();
    let named = gauge.find(TARGET).unwrap();
    let order = gauge.prepare(&named, "off").unwrap();
    // The request is sent; its response is never polled.
    fate.after(1);
    let lost = gauge.execute(order).unwrap_err();
    assert!(matches!(lost, ClientError::Interrupted { .. }), "{lost}");
    assert!(lost.to_string().contains("it may have been written, read it"), "{lost}");
    drop(gauge);
    bench.lock().unwrap().order(|devices| devices[0].set_power(true));
    fate.after(NEVER);
    let is = Ms2::new(&mut session, FIRST).read(SLOT, INDEX).unwrap();
    assert!([[0], [1]].iter().any(|value| is == value), "{is:?}");
}

/// Two sessions write one parameter repeatedly: every write is accepted, and in the end the parameter has one of the two
/// values.
#[test]
fn two_sessions_that_write_the_same_parameter_are_both_served() {
    let bench = Bench::on_tcp(&gauges(1));
    let write = |master: u8| {
        let name = bench.name.clone();
        std::thread::spawn(move || {
            let port = open::port(&name, BAUD).unwrap();
            let mut session = BusSession::new(port, BAUD, bus_of(master, 1), TIMEOUT).unwrap();
            let mut records = Ms2::new(&mut session, FIRST);
            for _ in 0..20 {
                records.write(SLOT, INDEX, &[master]).unwrap();
                let read = records.read(SLOT, INDEX).unwrap();
                assert!([[0], [1]].iter().any(|value| read == value), "{read:?}");
            }
        })
    };
    let sessions = [write(0), write(1)];
    sessions.into_iter().for_each(|session| session.join().unwrap());
}

/// A slave in data exchange keeps its address and continues.
#[test]
fn a_slave_in_data_exchange_keeps_its_address() {
    let mut bench = Bench::on_tcp(&gauges(1));
    bench.order(|devices| devices[0].settle_in(conditions(1e-2)));
    let mut session = bench.session(bus_of(0, 0));
    let watched = CyclicSlave::find(&mut session, FIRST, 0).unwrap();
    let watchdog = patient(FIRST, watched.model, watched.configuration).watchdog;
    session.master().add(&SlaveParameters { watchdog, ..watched.parameters(BAUD) }).unwrap();
    session.master().set_mode(Mode::Operate);
    let begun = Instant::now();
    let exchanges = |session: &mut BusSession| session.master().counters(FIRST).unwrap().exchanges;
    while exchanges(&mut session) == 0 {
        assert!(begun.elapsed() < TIMEOUT, "no data");
        session.serve(&[], TIMEOUT).unwrap();
    }
    let owned = address::check(&mut session, FIRST, FIRST + 1).unwrap_err();
    assert!(matches!(owned, AddressError::OwnedByOther { address: FIRST, master: 0 }), "{owned}");
    let before = exchanges(&mut session);
    let refused = address::change(&mut session, FIRST, FIRST + 1, watched.model.ident, false).unwrap_err();
    assert!(matches!(refused, AddressError::ServiceClosed(FIRST, _) | AddressError::NotChanged(FIRST)), "{refused}");
    while exchanges(&mut session) < before + 3 {
        assert!(begun.elapsed() < TIMEOUT, "no more data");
        session.serve(&[], TIMEOUT).unwrap();
    }
    assert_eq!(session.master().counters(FIRST).unwrap().starts, 1);
}

/// The service changes within one session: each service has a configuration of its own.
#[test]
fn a_session_changes_the_service_of_a_slave_that_it_owns() {
    let bench = Bench::on_tcp(&gauges(1));
    let mut session = bench.session(bus_of(0, 0));
    let watched = CyclicSlave::find(&mut session, FIRST, 0).unwrap();
    for via in [AccessPath::Class1, AccessPath::ParameterChannel, AccessPath::Class1] {
        let mut owned = Class1Session::open(&mut session, &watched, via).unwrap();
        assert_eq!(owned.read(SLOT, INDEX).unwrap(), [1], "{via:?}");
    }
}
