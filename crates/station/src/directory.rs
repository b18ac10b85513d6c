//! What the station's file says about its gauges beside the bus: groups, tags, locations, calibrations; and the views of all users.
//!
//! The directory changes only with the station's file, and `/api/directory` has it. The live stream has its revision, so that hundreds of
//! labels do not travel with every connection.

use profivac_recorder::{DescribedPoint, Point};
use serde::Serialize;
use std::collections::BTreeMap;
use std::sync::{Arc, PoisonError, RwLock, RwLockReadGuard};
use utoipa::ToSchema;

/// The labels of a gauge.
#[derive(Clone, Debug, Default, PartialEq, Eq, Hash, Serialize, ToSchema)]
pub struct GaugeLabels {
    /// The group that it belongs to.
    pub group: Option<String>,
    /// Its tags, in the order of the file.
    pub tags: Vec<String>,
    /// The place where it is mounted.
    pub location: Option<String>,
    /// The day of its last calibration, as `2026-05-01`.
    pub calibrated: Option<String>,
    /// The last day on which the calibration is valid, as `2027-05-01`; `null` without an interval.
    pub calibration_due: Option<String>,
}

/// The state of a gauge that a view chooses.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, ToSchema)]
#[serde(rename_all = "kebab-case")]
pub enum ViewState {
    /// An active alarm, no data, or no data exchange.
    Problems,
    /// An active alarm.
    Alarms,
    /// A fault of the gauge or of a reading.
    Fault,
    /// Stale readings, or none.
    NoData,
    /// A calibration that is no longer valid.
    CalibrationOverdue,
}

impl ViewState {
    /// All states.
    pub const ALL: [Self; 5] = [Self::Problems, Self::Alarms, Self::Fault, Self::NoData, Self::CalibrationOverdue];

    /// The word of the station's file and of the API.
    #[must_use]
    pub const fn word(self) -> &'static str {
        match self {
            Self::Problems => "problems",
            Self::Alarms => "alarms",
            Self::Fault => "fault",
            Self::NoData => "no-data",
            Self::CalibrationOverdue => "calibration-overdue",
        }
    }
}

/// A view of all users: a filter of the overview, or a group of trends.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, ToSchema)]
pub struct SavedView {
    /// Its name.
    pub name: String,
    /// Words that are searched in name, segment, device and labels.
    pub search: Option<String>,
    /// The group.
    pub group: Option<String>,
    /// The tag.
    pub tag: Option<String>,
    /// The location.
    pub location: Option<String>,
    /// The state.
    pub state: Option<ViewState>,
    /// The series of the trends: gauges, or channels of a controller. Empty for a filter.
    pub series: Vec<String>,
}

/// The directory of the station.
#[derive(Clone, Debug, Default, PartialEq, Serialize, ToSchema)]
pub struct Directory {
    /// The labels of the gauges, by name. A gauge without labels is not listed.
    pub gauges: BTreeMap<String, GaugeLabels>,
    /// The views of all users, in the order of the file.
    pub views: Vec<SavedView>,
    /// The points of the slaves, in the order of the file. `/api/points` lists the recorded ones with these texts.
    #[serde(skip)]
    pub points: Vec<DescribedPoint>,
}

impl Directory {
    /// The point `name` of a slave.
    #[must_use]
    pub fn point(&self, slave: &str, name: &str) -> Option<&DescribedPoint> {
        self.points.iter().find(|it| it.point.slave == slave && it.point.name == name)
    }

    /// A recorded point with its texts. The codes of another unit or kind may have meant something else.
    #[must_use]
    pub fn described(&self, point: Point) -> DescribedPoint {
        let texts = self.point(&point.slave, &point.name).filter(|known| known.point == point);
        DescribedPoint { texts: texts.map(|known| known.texts.clone()).unwrap_or_default(), point }
    }
}

/// The directory, shared by the threads of a station.
#[derive(Default)]
pub struct DirectoryStore(RwLock<Stored>);

#[derive(Default)]
struct Stored {
    directory: Arc<Directory>,
    revision: u64,
}

impl DirectoryStore {
    /// Replaces the directory. Another directory has another revision.
    pub fn set(&self, directory: Directory) {
        let mut stored = self.0.write().unwrap_or_else(PoisonError::into_inner);
        if *stored.directory != directory {
            stored.directory = Arc::new(directory);
            stored.revision = stored.revision.wrapping_add(1);
        }
    }

    /// The directory.
    #[must_use]
    pub fn view(&self) -> Arc<Directory> {
        Arc::clone(&self.read().directory)
    }

    /// The labels of a gauge; empty if the file has none for it.
    #[must_use]
    pub fn labels(&self, gauge: &str) -> GaugeLabels {
        self.read().directory.gauges.get(gauge).cloned().unwrap_or_default()
    }

    /// Changes when the directory changes.
    #[must_use]
    pub fn revision(&self) -> u64 {
        self.read().revision
    }

    fn read(&self) -> RwLockReadGuard<'_, Stored> {
        self.0.read().unwrap_or_else(PoisonError::into_inner)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn another_directory_has_another_revision_and_the_same_one_has_not() {
        let store = DirectoryStore::default();
        let labels = GaugeLabels { group: Some("target".to_owned()), ..GaugeLabels::default() };
        let directory =
            Directory { gauges: BTreeMap::from([("chamber".to_owned(), labels.clone())]), ..Directory::default() };
        store.set(directory.clone());
        let revision = store.revision();
        store.set(directory.clone());
        assert_eq!((store.revision(), store.view()), (revision, Arc::new(directory)));
        assert_eq!((store.labels("chamber"), store.labels("lock")), (labels, GaugeLabels::default()));
        store.set(Directory::default());
        assert_ne!(store.revision(), revision);
    }
}
