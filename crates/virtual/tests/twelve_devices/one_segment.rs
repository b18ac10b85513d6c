//! All twelve devices in data exchange at the same time, each in its own vacuum: acyclic requests disturb no data exchange,
//! and no value comes from another device.

use crate::twelve_devices::real_time::{Bench, TIMEOUT, bus_of, conditions};
use crate::twelve_devices::rig::{BAUD, patient, rows};
use profivac_client::cyclic::CyclicSlave;
use profivac_client::ms2;
use profivac_devices::model::{Access, Model};
use profivac_dp::master::{Handle, Mode, Ms1Parameters, Ms2Parameters, Operation, SlaveParameters};
use profivac_host::session::{BusSession, add_or_restart};
use std::collections::BTreeMap;
use std::fmt::Debug;
use std::sync::mpsc::{TryRecvError, channel};
use std::time::{Duration, Instant};

/// The addresses of the master that exchanges data, and of a second one.
const EXCHANGING: u8 = 0;
const LOOKING: u8 = 1;

/// DPV1_Enable, profibus-wire 2.4.
const DPV1_ENABLE: u8 = 0x80;

/// The vacuum of each device in mbar: its reading is nearer to this than to that of any other.
fn pressure_mbar(address: u8) -> f64 {
    2e-3 * 1.2_f64.powi(i32::from(address - crate::twelve_devices::FIRST))
}

/// The serial number of a device.
fn serial(address: u8) -> String {
    format!("no. {address}")
}

/// The device specs.
pub fn named() -> Vec<String> {
    let all = crate::twelve_devices::all();
    all.into_iter().map(|(address, model)| format!("{}@{address}:serial={}", model.name, serial(address))).collect()
}

/// A master that exchanges data with all devices.
pub struct Plant {
    pub session: BusSession,
    pub bench: Bench,
    watched: Vec<CyclicSlave>,
    begun: Instant,
}

impl Plant {
    pub fn new(mut bench: Bench) -> Self {
        bench.order(|devices| {
            for device in devices {
                device.settle_in(conditions(pressure_mbar(device.switch_address())));
            }
        });
        let mut session = bench.session(bus_of(EXCHANGING, LOOKING));
        let find = |(address, _)| CyclicSlave::find(&mut session, address, EXCHANGING).unwrap();
        let watched: Vec<_> = crate::twelve_devices::all().into_iter().map(find).collect();
        for slave in &watched {
            let usual = slave.parameters(BAUD);
            let mut user_prm = usual.user_prm.to_vec();
            if let Some(status) = user_prm.first_mut() {
                *status |= slave.model.dpv1_status & DPV1_ENABLE;
            }
            let watchdog = patient(slave.address, slave.model, slave.configuration).watchdog;
            let parameters = SlaveParameters { user_prm: &user_prm, watchdog, ..usual };
            add_or_restart(session.master(), &parameters).unwrap();
        }
        session.master().set_mode(Mode::Operate);
        let mut plant = Self { session, bench, watched, begun: Instant::now() };
        plant.until("bring-up", |plant| plant.session.master().exchanging() == crate::twelve_devices::all().len());
        plant
    }

    /// Serves the line until a condition holds, and checks every value meanwhile.
    pub fn until(&mut self, what: &str, mut is_so: impl FnMut(&mut Self) -> bool) {
        while !is_so(self) {
            assert!(self.begun.elapsed() < TIMEOUT, "{what} takes too long");
            self.session.serve(&[], Duration::from_millis(20)).unwrap();
            while self.session.master().next_event().is_some() {}
            self.look();
        }
    }

    /// Every value belongs to its device.
    fn look(&mut self) {
        for slave in &self.watched {
            let Some(inputs) = self.session.master().inputs(slave.address) else { continue };
            let reading = slave.decode_inputs(inputs);
            let mbar = pressure_mbar(slave.address);
            let own =
                reading.values.iter().filter_map(|value| value.pa).any(|pa| (pa / 100.0 / mbar - 1.0).abs() < 0.05);
            assert!(own, "{} at {}: {mbar} mbar, and it shows {reading:?}", slave.model.name, slave.address);
        }
    }

    fn exchanges(&mut self) -> BTreeMap<u8, (u32, u32)> {
        let master = self.session.master();
        let counted = |address: u8| {
            let counters = master.counters(address).unwrap();
            (address, (counters.exchanges, counters.starts))
        };
        crate::twelve_devices::all().into_iter().map(|(address, _)| counted(address)).collect()
    }

    /// Every device is exchanged with at least once more, and none was restarted.
    pub fn went_on_since(&mut self, before: &BTreeMap<u8, (u32, u32)>) {
        let now = self.exchanges();
        for (address, (exchanges, starts)) in before {
            assert!(now[address].0 > *exchanges, "{address} is not exchanged with");
            assert_eq!(now[address].1, *starts, "{address} had to begin anew");
        }
    }

    /// Waits for the record of a read.
    fn record<O, E: Debug>(&mut self, what: &str, read: Handle<O>) -> Vec<u8>
    where
        O: for<'a> Operation<Outcome<'a> = Result<&'a [u8], E>>,
    {
        let mut record = None;
        self.until(what, |plant| {
            record = plant.session.master().outcome(read).map(|outcome| outcome.unwrap().to_vec());
            record.is_some()
        });
        record.unwrap()
    }
}

/// The slot and index of the serial number.
fn serial_location(model: &Model) -> Option<(u8, u8)> {
    let is_serial = |name: &str| name == "Serial Number";
    let found = rows(model).into_iter().find(|(_, row)| is_serial(row.name) && row.access.contains(Access::READ_2));
    found.filter(|_| model.features.dpv1).map(|(address, row)| (address.slot, row.index))
}

fn is_serial_of(record: &[u8], address: u8) -> bool {
    String::from_utf8_lossy(record).trim_end_matches(['\0', ' ']) == serial(address)
}

/// Reads serial numbers by MS2 over several connections at a time, and records by MS1 during data exchange.
pub fn requests_beside_the_exchange(bench: Bench) {
    let mut plant = Plant::new(bench);
    let before = plant.exchanges();
    let locations: Vec<_> = crate::twelve_devices::all()
        .into_iter()
        .filter_map(|(address, model)| Some((address, serial_location(model)?)))
        .collect();
    assert!(locations.len() >= 9, "{locations:?}");
    for few in locations.chunks(4) {
        let open =
            |(address, _): &(u8, _)| plant.session.master().ms2_open(*address, &Ms2Parameters::new(BAUD)).unwrap();
        let connections: Vec<_> = few.iter().map(open).collect();
        for connection in &connections {
            plant.until("opening", |plant| plant.session.master().outcome(*connection).map(Result::unwrap).is_some());
        }
        let read = |(connection, (_, (slot, index))): (&Handle<_>, &(u8, (u8, u8)))| {
            plant.session.master().ms2_read(*connection, *slot, *index, 240).unwrap()
        };
        let reads: Vec<_> = connections.iter().zip(few).map(read).collect();
        for ((connection, read), (address, _)) in connections.iter().zip(reads).zip(few) {
            let record = plant.record("MS2", read);
            assert!(is_serial_of(&record, *address), "{address}: {record:02X?}");
            plant.session.master().ms2_close(*connection).unwrap();
        }
        for connection in &connections {
            plant.until("closing", |plant| plant.session.master().outcome(*connection).is_some());
        }
    }
    for (address, model) in crate::twelve_devices::all().into_iter().filter(|(_, model)| model.features.ms1) {
        let readable = rows(model).into_iter().find(|(_, row)| row.access.contains(Access::READ_1));
        let (location, row) = readable.unwrap();
        let parameters = Ms1Parameters::new(BAUD);
        let handle = plant.session.master().ms1_read(address, location.slot, row.index, 240, &parameters).unwrap();
        assert!(!plant.record("MS1", handle).is_empty(), "{address}");
    }
    plant.went_on_since(&before);
}

/// A second master joins the ring, reads a record of every device with MS2, and leaves.
pub fn a_second_master_looks(bench: Bench) {
    let mut plant = Plant::new(bench);
    let name = plant.bench.name.clone();
    let (tell, told) = channel();
    let reader = std::thread::spawn(move || {
        let port = profivac_virtual::open::port(&name, BAUD).unwrap();
        let mut session = BusSession::new(port, BAUD, bus_of(LOOKING, LOOKING), TIMEOUT).unwrap();
        for (address, model) in crate::twelve_devices::all() {
            if let Some((slot, index)) = serial_location(model) {
                let record = ms2::read(&mut session, address, slot, index).unwrap();
                tell.send((address, record, session.masters().collect::<Vec<_>>())).unwrap();
            }
        }
    });
    let mut read = 0;
    let before = plant.exchanges();
    let claimed = plant.session.ring_counters().claimed;
    plant.until("reading", |_| match told.try_recv() {
        Ok((address, record, masters)) => {
            assert!(is_serial_of(&record, address), "{address}: {record:02X?}");
            assert_eq!(masters, [EXCHANGING, LOOKING], "both are in the ring");
            read += 1;
            false
        }
        Err(TryRecvError::Empty) => false,
        Err(TryRecvError::Disconnected) => true,
    });
    reader.join().unwrap();
    assert!(read >= 9, "{read}");
    plant.went_on_since(&before);
    plant.until("the ring without it", |plant| plant.session.masters().eq([EXCHANGING]));
    let before = plant.exchanges();
    plant.until("exchange after it", |plant| {
        plant.exchanges().iter().all(|(address, (exchanges, _))| *exchanges > before[address].0 + 2)
    });
    plant.went_on_since(&before);
    assert_eq!(plant.session.ring_counters().claimed, claimed, "the token did not go with it");
}
