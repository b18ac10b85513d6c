//! The parts of a station that its threads share, each with a type of its own.
//!
//! ```text
//! segments ── snapshots ──▶ alarms, control, API
//!     ▲ └──── recorder ◀── alarms, control, deliveries, API
//!     └────── control (requests) ◀── API
//! ```

use crate::alarm::AlarmService;
use crate::alarm_editor::AlarmEditor;
use crate::control::ControlService;
use crate::directory::DirectoryStore;
use crate::gateway_status::GatewayStatuses;
use crate::plant::PlantStore;
use crate::recording::RecorderHandle;
use crate::segment::SegmentServices;
use crate::snapshot::SnapshotStore;
use crate::view::{RecorderView, Station, unix_ms};
use crate::webhook::DeliveryStatus;
use profivac_recorder::{Micros, Recorder};
use std::path::PathBuf;
use std::sync::Arc;

/// The shared parts of a station.
pub struct Services {
    name: String,
    started: Micros,
    recorder: Arc<RecorderHandle>,
    snapshots: Arc<SnapshotStore>,
    control: Arc<ControlService>,
    alarms: Arc<AlarmService>,
    alarm_editor: AlarmEditor,
    webhooks: Arc<DeliveryStatus>,
    gateways: Arc<GatewayStatuses>,
    plant: PlantStore,
    directory: DirectoryStore,
}

impl Services {
    /// The services of a station whose recorder writes to `database`.
    #[must_use]
    pub fn new(name: String, database: PathBuf, recorder: Recorder) -> Self {
        let recorder = Arc::new(RecorderHandle::new(recorder, database));
        let snapshots = Arc::new(SnapshotStore::default());
        let control = Arc::new(ControlService::new(Arc::clone(&recorder), Arc::clone(&snapshots)));
        let alarms = Arc::new(AlarmService::new(name.clone(), Arc::clone(&recorder)));
        let alarm_editor = AlarmEditor::new(Arc::clone(&alarms), Arc::clone(&recorder));
        let webhooks = Arc::new(DeliveryStatus::default());
        let gateways = Arc::new(GatewayStatuses::default());
        let plant = PlantStore::default();
        let directory = DirectoryStore::default();
        Self {
            name,
            started: Micros::now(),
            recorder,
            snapshots,
            control,
            alarms,
            alarm_editor,
            webhooks,
            gateways,
            plant,
            directory,
        }
    }

    /// The name of the station.
    #[must_use]
    pub fn name(&self) -> &str {
        &self.name
    }

    /// The recorder.
    #[must_use]
    pub const fn recorder(&self) -> &Arc<RecorderHandle> {
        &self.recorder
    }

    /// The latest snapshots of all segments.
    #[must_use]
    pub const fn snapshots(&self) -> &Arc<SnapshotStore> {
        &self.snapshots
    }

    /// Control of gauges.
    #[must_use]
    pub const fn control(&self) -> &Arc<ControlService> {
        &self.control
    }

    /// The alarms.
    #[must_use]
    pub const fn alarms(&self) -> &Arc<AlarmService> {
        &self.alarms
    }

    /// The editor of the settings of alarms.
    #[must_use]
    pub const fn alarm_editor(&self) -> &AlarmEditor {
        &self.alarm_editor
    }

    /// The delivery status of all webhooks.
    #[must_use]
    pub const fn webhooks(&self) -> &Arc<DeliveryStatus> {
        &self.webhooks
    }

    /// The states of all gateways to control systems.
    #[must_use]
    pub const fn gateways(&self) -> &Arc<GatewayStatuses> {
        &self.gateways
    }

    /// The plant and the states of its parts.
    #[must_use]
    pub const fn plant(&self) -> &PlantStore {
        &self.plant
    }

    /// The labels of the gauges, and the views.
    #[must_use]
    pub const fn directory(&self) -> &DirectoryStore {
        &self.directory
    }

    /// The parts that a segment needs.
    #[must_use]
    pub fn for_segments(&self) -> SegmentServices {
        SegmentServices {
            recorder: Arc::clone(&self.recorder),
            snapshots: Arc::clone(&self.snapshots),
            control: Arc::clone(&self.control),
        }
    }

    /// The station as the API shows it.
    #[must_use]
    pub fn station(&self) -> Station {
        let health = self.recorder.health();
        let recorder = RecorderView {
            last_write_ms: health.last_write.map(unix_ms),
            error: health.error,
            lost_samples: health.lost_samples,
            lost_events: health.lost_events,
            last_check_ms: self.recorder.last_check().map(|check| unix_ms(check.at)),
            damage: self.recorder.damage(),
        };
        Station {
            name: self.name.clone(),
            version: env!("CARGO_PKG_VERSION"),
            started_ms: unix_ms(self.started),
            now_ms: unix_ms(Micros::now()),
            recorder,
            stopped_parts: self.gateways.stopped(),
            archive_problem: self.gateways.archive_problem(),
        }
    }
}
