//! A segment in memory: the gauges of a demonstration are sampled, recorded and controlled like real ones.

use super::bus_map::{milliseconds, own_master};
use super::gauge_session::GaugeSession;
use super::requests;
use super::services::SegmentServices;
use crate::config;
use crate::control::error::Unavailable;
use crate::control::requests::SegmentRequest;
use crate::snapshot::SegmentSnapshot;
use crate::view::{Segment, SegmentState};
use profivac_client::cyclic::CyclicSlave;
use profivac_client::records::{RecordError, Records};
use profivac_devices::model::AccessPath;
use profivac_dp::link::Baud;
use profivac_dp::master::ms2::{self, Connect};
use profivac_dp::master::{ConnectionEnd, Handle, Ms2Parameters, Operation, SubmitError};
use profivac_host::session::BusMaster;
use profivac_vacuum::Gas;
use profivac_virtual::memory_segment::MemorySegment;
use std::sync::mpsc::Receiver;
use std::time::{Duration, Instant};

/// The time between two samples, and between two snapshots.
const POLL: Duration = Duration::from_millis(100);

/// The longest wait for the answer of a gauge in memory, in seconds of its bus.
const TIMEOUT_S: f64 = 10.0;

/// A segment in memory that the station shows.
pub struct DemoSegment {
    name: String,
    master: u8,
    services: SegmentServices,
    gauges: Vec<GaugeSession>,
    requests: Receiver<SegmentRequest>,
    publish_at: Instant,
}

impl DemoSegment {
    /// Shows the gauges of `scene` as the segment `name`. `names` gives the name and the device of the gauge at an address.
    #[must_use]
    pub fn new(
        services: SegmentServices,
        name: &str,
        scene: &MemorySegment,
        master: u8,
        names: impl Fn(u8) -> (String, String),
    ) -> Self {
        let requests = services.control.requests().accept(name);
        let gauges = scene.slaves().iter().map(|slave| {
            let (name, device) = names(slave.address);
            let config =
                config::Gauge { name, address: slave.address, device, poll: POLL, gas: Gas::N2, levels: Vec::new() };
            GaugeSession::with_slave(config, *slave)
        });
        let gauges = gauges.collect();
        Self { name: name.to_owned(), master, services, gauges, requests, publish_at: Instant::now() }
    }

    /// Samples and publishes the gauges, and answers one request if there is one. While it answers, time passes on the bus.
    pub fn run_once(&mut self, scene: &mut MemorySegment) {
        self.sample(scene);
        if Instant::now() >= self.publish_at {
            self.publish_at = Instant::now() + POLL;
            self.publish(scene);
        }
        if let Ok(request) = self.requests.try_recv() {
            let slave = |name: &str| self.slave(name);
            // A segment in memory has no port to lose.
            requests::answer(&self.services, request, slave, |address| SceneRecords {
                scene,
                address,
                connection: None,
            })
            .ok();
        }
    }

    fn sample(&mut self, scene: &mut MemorySegment) {
        let (slaves, baud) = (scene.slaves().to_vec(), scene.baud());
        let Some(master) = scene.master_mut() else { return };
        for (gauge, slave) in self.gauges.iter_mut().zip(slaves) {
            if gauge.takes_search_turn() {
                // The gauge was switched off for a while; in memory it is the same device again.
                gauge.search_finished(&self.services.recorder, master, baud, Ok(slave));
            }
            gauge.sample(&self.services.recorder, master);
        }
    }

    fn slave(&self, name: &str) -> Result<CyclicSlave, Unavailable> {
        let gauge = self.gauges.iter().find(|gauge| gauge.config.name == name);
        let gauge = gauge.ok_or_else(|| Unavailable::UnknownGauge(name.to_owned()))?;
        gauge.slave.ok_or_else(|| Unavailable::NoAnswer(name.to_owned()))
    }

    fn publish(&self, scene: &MemorySegment) {
        let own = own_master(self.master);
        let mut stations: Vec<_> = self.gauges.iter().map(GaugeSession::bus_station).chain([own]).collect();
        stations.sort_by_key(|station| station.address);
        let baud = scene.baud();
        let segment = Segment {
            name: self.name.clone(),
            port: "in memory".to_owned(),
            baud: baud.bits_per_second(),
            master: self.master,
            state: SegmentState::Running,
            problem: None,
            cycle_ms: scene.master().and_then(|master| milliseconds(master.cycle_tbit(), baud)),
            damaged_telegrams: 0,
            stations,
        };
        let gauges = self.gauges.iter().map(|gauge| gauge.view(&self.name)).collect();
        self.services.snapshots.publish(SegmentSnapshot { segment, gauges });
    }
}

/// Reads and writes records of a gauge in memory, over MS2.
struct SceneRecords<'a> {
    scene: &'a mut MemorySegment,
    address: u8,
    connection: Option<Handle<Connect>>,
}

impl SceneRecords<'_> {
    fn connection(&mut self) -> Result<Handle<Connect>, RecordError> {
        if let Some(connection) = self.connection {
            return Ok(connection);
        }
        let parameters = Ms2Parameters::new(self.baud());
        let address = self.address;
        let connection = self.ask(|master| master.ms2_open(address, &parameters))?;
        self.outcome(connection, |opened| opened)?.map_err(lost)?;
        self.connection = Some(connection);
        Ok(connection)
    }

    const fn baud(&self) -> Baud {
        self.scene.baud()
    }

    fn ask<T>(&mut self, request: impl FnOnce(&mut BusMaster) -> Result<T, SubmitError>) -> Result<T, RecordError> {
        let master =
            self.scene.master_mut().ok_or_else(|| RecordError::Interrupted("there is no master".to_owned()))?;
        request(master).map_err(|error| RecordError::Interrupted(error.to_string()))
    }

    /// Lets time pass on the bus until a request has an outcome.
    fn outcome<O: Operation, T>(
        &mut self,
        handle: Handle<O>,
        take: impl Fn(O::Outcome<'_>) -> T,
    ) -> Result<T, RecordError> {
        let end = self.scene.seconds() + TIMEOUT_S;
        while self.scene.seconds() < end {
            let outcome = self.scene.master_mut().and_then(|master| master.outcome(handle).map(&take));
            if let Some(outcome) = outcome {
                return Ok(outcome);
            }
            self.scene.run_until(self.scene.seconds() + 1e-3);
        }
        Err(RecordError::Interrupted("no answer".to_owned()))
    }
}

impl SceneRecords<'_> {
    /// The error of a request. A connection that has ended is opened again by the next request.
    fn failed(&mut self, error: ms2::RequestError) -> RecordError {
        match error {
            ms2::RequestError::Refused(negative) => RecordError::Refused(negative.into()),
            ms2::RequestError::Ended(end) => {
                self.connection = None;
                lost(end)
            }
        }
    }
}

impl Records for SceneRecords<'_> {
    fn via(&self) -> AccessPath {
        AccessPath::Class2
    }

    fn read(&mut self, slot: u8, index: u8) -> Result<Vec<u8>, RecordError> {
        let connection = self.connection()?;
        let read = self.ask(|master| master.ms2_read(connection, slot, index, 240))?;
        let record = self.outcome(read, |record| record.map(<[u8]>::to_vec))?;
        record.map_err(|error| self.failed(error))
    }

    fn write(&mut self, slot: u8, index: u8, octets: &[u8]) -> Result<(), RecordError> {
        let connection = self.connection()?;
        let write = self.ask(|master| master.ms2_write(connection, slot, index, octets))?;
        let written = self.outcome(write, |written| written)?;
        written.map_err(|error| self.failed(error))
    }
}

impl Drop for SceneRecords<'_> {
    /// Closes the connection: a slave has few of them.
    fn drop(&mut self) {
        if let Some(connection) = self.connection.take() {
            self.ask(|master| master.ms2_close(connection)).ok();
            self.outcome(connection, drop).ok();
        }
    }
}

fn lost(end: ConnectionEnd) -> RecordError {
    RecordError::Interrupted(end.to_string())
}
