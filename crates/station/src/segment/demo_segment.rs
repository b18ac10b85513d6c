//! A segment in memory: the gauges of a demonstration are sampled, recorded and controlled like real ones.

use super::bus_map::{milliseconds, own_master};
use super::gauge_session::GaugeSession;
use super::inbox::Inbox;
use super::services::SegmentServices;
use crate::config;
use crate::control::error::Unavailable;
use crate::snapshot::SegmentSnapshot;
use crate::view::{Segment, SegmentState};
use profivac_client::cyclic::CyclicSlave;
use profivac_client::ms2::Ms2;
use profivac_vacuum::Gas;
use profivac_virtual::memory_segment::MemorySegment;
use std::time::{Duration, Instant};

/// The time between two samples, and between two snapshots.
const POLL: Duration = Duration::from_millis(100);

/// A segment in memory that the station shows.
pub struct DemoSegment {
    name: String,
    master: u8,
    services: SegmentServices,
    gauges: Vec<GaugeSession>,
    inbox: Inbox,
    publish_at: Instant,
}

impl DemoSegment {
    /// Shows the gauges of `segment` as the segment `name`. `names` gives the name and the device of the gauge at an address.
    #[must_use]
    pub fn new(
        services: SegmentServices,
        name: &str,
        segment: &MemorySegment,
        master: u8,
        names: impl Fn(u8) -> (String, String),
    ) -> Self {
        let inbox = Inbox::new(services.control.requests().accept(name));
        let gauges = segment.slaves().iter().map(|slave| {
            let (name, device) = names(slave.address);
            let config =
                config::Gauge { name, address: slave.address, device, poll: POLL, gas: Gas::N2, levels: Vec::new() };
            GaugeSession::with_slave(config, *slave)
        });
        let gauges = gauges.collect();
        Self { name: name.to_owned(), master, services, gauges, inbox, publish_at: Instant::now() }
    }

    /// Samples and publishes the gauges, and answers one request, or a part of one, if there is one. While it answers, time passes on the bus.
    pub fn run_once(&mut self, segment: &mut MemorySegment) {
        self.sample(segment);
        if Instant::now() >= self.publish_at {
            self.publish_at = Instant::now() + POLL;
            self.publish(segment);
        }
        let slave = |name: &str| slave(&self.gauges, name);
        // A segment in memory has no port to lose.
        self.inbox.answer_next(&self.services, slave, |address| Ms2::new(segment, address), Instant::now).ok();
    }

    fn sample(&mut self, segment: &mut MemorySegment) {
        let (slaves, baud) = (segment.slaves().to_vec(), segment.baud());
        let Some(master) = segment.master_mut() else { return };
        for (gauge, slave) in self.gauges.iter_mut().zip(slaves) {
            if gauge.takes_search_turn() {
                // The gauge was switched off for a while; in memory it is the same device again.
                gauge.search_finished(&self.services.recorder, master, baud, Ok(slave));
            }
            gauge.sample(&self.services.recorder, master);
        }
    }

    fn publish(&self, segment: &MemorySegment) {
        let own = own_master(self.master);
        let mut stations: Vec<_> = self.gauges.iter().map(GaugeSession::bus_station).chain([own]).collect();
        stations.sort_by_key(|station| station.address);
        let baud = segment.baud();
        let segment = Segment {
            name: self.name.clone(),
            port: "in memory".to_owned(),
            baud: baud.bits_per_second(),
            master: self.master,
            state: SegmentState::Running,
            problem: None,
            cycle_ms: segment.master().and_then(|master| milliseconds(master.cycle_tbit(), baud)),
            damaged_telegrams: 0,
            stations,
        };
        let gauges = self.gauges.iter().map(|gauge| gauge.view(&self.name)).collect();
        self.services.snapshots.publish(SegmentSnapshot { segment, gauges });
    }
}

fn slave(gauges: &[GaugeSession], name: &str) -> Result<CyclicSlave, Unavailable> {
    let gauge = gauges.iter().find(|gauge| gauge.config.name == name);
    let gauge = gauge.ok_or_else(|| Unavailable::UnknownGauge(name.to_owned()))?;
    gauge.slave.ok_or_else(|| Unavailable::NoAnswer(name.to_owned()))
}
