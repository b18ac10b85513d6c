//! The services of the station that a segment uses.

use crate::control::ControlService;
use crate::recording::RecorderHandle;
use crate::snapshot::SnapshotStore;
use std::sync::Arc;

/// The services of the station that a segment uses.
#[derive(Clone)]
pub struct SegmentServices {
    /// Takes samples and events.
    pub recorder: Arc<RecorderHandle>,
    /// Takes snapshots.
    pub snapshots: Arc<SnapshotStore>,
    /// Gives requests.
    pub control: Arc<ControlService>,
}
