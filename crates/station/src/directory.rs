//! What the station's file says about its gauges beside the bus: groups, tags, locations, calibrations.
//!
//! The directory changes only with the station's file, and `/api/directory` has it. The live stream has its revision, so that hundreds of
//! labels do not travel with every connection.

use serde::Serialize;
use std::collections::BTreeMap;
use std::sync::{PoisonError, RwLock, RwLockReadGuard};
use utoipa::ToSchema;

/// The labels of a gauge.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, ToSchema)]
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

/// The directory of the station.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, ToSchema)]
pub struct Directory {
    /// The labels of the gauges, by name. A gauge without labels is not listed.
    pub gauges: BTreeMap<String, GaugeLabels>,
}

/// The directory, shared by the threads of a station.
#[derive(Default)]
pub struct DirectoryStore(RwLock<Stored>);

#[derive(Default)]
struct Stored {
    directory: Directory,
    revision: u64,
}

impl DirectoryStore {
    /// Replaces the directory. Another directory has another revision.
    pub fn set(&self, directory: Directory) {
        let mut stored = self.0.write().unwrap_or_else(PoisonError::into_inner);
        if stored.directory != directory {
            stored.directory = directory;
            stored.revision = stored.revision.wrapping_add(1);
        }
    }

    /// The directory.
    #[must_use]
    pub fn view(&self) -> Directory {
        self.read().directory.clone()
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
        let directory = Directory { gauges: BTreeMap::from([("chamber".to_owned(), labels.clone())]) };
        store.set(directory.clone());
        let revision = store.revision();
        store.set(directory.clone());
        assert_eq!((store.revision(), store.view()), (revision, directory));
        assert_eq!((store.labels("chamber"), store.labels("lock")), (labels, GaugeLabels::default()));
        store.set(Directory::default());
        assert_ne!(store.revision(), revision);
    }
}
