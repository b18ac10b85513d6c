//! A segment in memory on the dashboard: what a demonstration shows is measured, recorded and asked like anything else.

use super::gauge_session::GaugeSession;
use super::requests;
use crate::config;
use crate::services::{SegmentRequest, SegmentSnapshot, Services};
use crate::view::{BusStation, BusStationState, Segment, SegmentState};
use profivac_client::cyclic::CyclicSlave;
use profivac_client::ms2::Ms2;
use profivac_vacuum::Gas;
use profivac_virtual::memory_segment::MemorySegment;
use std::sync::Arc;
use std::sync::mpsc::Receiver;
use std::time::{Duration, Instant};

/// How often pressures are taken, and shown.
const POLL: Duration = Duration::from_millis(100);

/// A scene that is shown.
pub struct DemoSegment {
    name: String,
    master: u8,
    plant: Arc<Services>,
    members: Vec<GaugeSession>,
    questions: Receiver<SegmentRequest>,
    show_at: Instant,
}

impl DemoSegment {
    /// Shows the gauges of `scene` under the name of a segment. `names` says what a gauge at an address is called, and its device.
    #[must_use]
    pub fn new(
        plant: Arc<Services>,
        name: &str,
        scene: &MemorySegment,
        master: u8,
        names: impl Fn(u8) -> (String, String),
    ) -> Self {
        let questions = plant.accept_requests(name);
        let members = scene.slaves().iter().map(|watched| {
            let (name, device) = names(watched.address);
            let config =
                config::Gauge { name, address: watched.address, device, poll: POLL, gas: Gas::N2, levels: Vec::new() };
            GaugeSession::known(config, *watched)
        });
        let members = members.collect();
        Self { name: name.to_owned(), master, plant, members, questions, show_at: Instant::now() }
    }

    /// Takes what is new, shows it, and answers a question if there is one: while it does, time of the line passes.
    pub fn run_once(&mut self, scene: &mut MemorySegment) {
        self.sample(scene);
        if Instant::now() >= self.show_at {
            self.show_at = Instant::now() + POLL;
            self.show(scene);
        }
        if let Ok(question) = self.questions.try_recv() {
            let watched = |name: &str| self.watched(name);
            // There is no port that could be lost.
            requests::handle(&self.plant, question, watched, |address| Ms2::new(scene, address)).ok();
        }
    }

    fn sample(&mut self, scene: &mut MemorySegment) {
        let (all, baud) = (scene.slaves().to_vec(), scene.baud());
        let Some(master) = scene.master_mut() else { return };
        for (member, watched) in self.members.iter_mut().zip(all) {
            if member.takes_search_turn() {
                // It was without power for long; in a scene it is the same gauge again.
                member.search_finished(&self.plant, master, baud, Ok(watched));
            }
            member.sample(&self.plant, master);
        }
    }

    fn watched(&self, name: &str) -> Result<CyclicSlave, String> {
        let member = self.members.iter().find(|member| member.config.name == name);
        let member = member.ok_or_else(|| format!("there is no gauge {name:?}"))?;
        member.watched.ok_or_else(|| format!("{name} does not answer"))
    }

    fn show(&self, scene: &MemorySegment) {
        let own = BusStation {
            address: self.master,
            standing: BusStationState::Ourselves,
            name: None,
            device: None,
            ident: None,
            words: "our master".to_owned(),
        };
        let mut stations: Vec<_> = self.members.iter().map(GaugeSession::bus_station).chain([own]).collect();
        stations.sort_by_key(|station| station.address);
        let baud = scene.baud();
        let segment = Segment {
            name: self.name.clone(),
            port: "in memory".to_owned(),
            baud: baud.bits_per_second(),
            master: self.master,
            state: SegmentState::Running,
            trouble: None,
            cycle_ms: scene.master().and_then(|master| super::milliseconds(master.cycle_tbit(), baud)),
            damaged: 0,
            stations,
        };
        let gauges = self.members.iter().map(|member| member.gauge(&self.name)).collect();
        self.plant.publish(SegmentSnapshot { segment, gauges });
    }
}
