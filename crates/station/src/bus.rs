//! The state of the lines of all segments, and their captures.

use profivac_listen::flight::CaptureFolder;
use profivac_listen::report::BusReport;
use std::collections::BTreeMap;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

/// One line.
struct Line {
    report: Arc<BusReport>,
    captures: CaptureFolder,
}

/// The lines of all segments, by the name of the segment.
#[derive(Default)]
pub struct BusStore {
    lines: Mutex<BTreeMap<String, Line>>,
    /// The captures that were asked for and not begun yet.
    requests: Mutex<BTreeMap<String, CaptureRequest>>,
}

/// A capture that was asked for.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct CaptureRequest {
    /// Why.
    pub reason: String,
    /// A user asked for it. Other captures have a shortest time between them.
    pub is_by_user: bool,
}

impl BusStore {
    /// Replaces the report of a line.
    pub fn publish(&self, segment: &str, report: BusReport, captures: &CaptureFolder) {
        let line = Line { report: Arc::new(report), captures: captures.clone() };
        self.lines().insert(segment.to_owned(), line);
    }

    /// Removes the line of a segment that has stopped.
    pub fn remove(&self, segment: &str) {
        self.lines().remove(segment);
        self.requests().remove(segment);
    }

    /// The report of a line; `None` while its segment has observed nothing.
    #[must_use]
    pub fn report(&self, segment: &str) -> Option<Arc<BusReport>> {
        self.lines().get(segment).map(|line| Arc::clone(&line.report))
    }

    /// The reports of all lines.
    #[must_use]
    pub fn reports(&self) -> BTreeMap<String, Arc<BusReport>> {
        self.lines().iter().map(|(name, line)| (name.clone(), Arc::clone(&line.report))).collect()
    }

    /// The captures of a segment.
    #[must_use]
    pub fn captures(&self, segment: &str) -> Option<CaptureFolder> {
        self.lines().get(segment).map(|line| line.captures.clone())
    }

    /// A user asks for a capture. Returns whether the segment has a line.
    pub fn request_capture(&self, segment: &str, reason: &str) -> bool {
        let is_known = self.lines().contains_key(segment);
        if is_known {
            let request = CaptureRequest { reason: reason.to_owned(), is_by_user: true };
            self.requests().insert(segment.to_owned(), request);
        }
        is_known
    }

    /// An alarm asks for a capture.
    pub fn suggest_capture(&self, segment: &str, reason: &str) {
        let request = CaptureRequest { reason: reason.to_owned(), is_by_user: false };
        self.requests().entry(segment.to_owned()).or_insert(request);
    }

    /// Takes a capture that was asked for.
    pub fn take_request(&self, segment: &str) -> Option<CaptureRequest> {
        self.requests().remove(segment)
    }

    fn lines(&self) -> MutexGuard<'_, BTreeMap<String, Line>> {
        self.lines.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn requests(&self) -> MutexGuard<'_, BTreeMap<String, CaptureRequest>> {
        self.requests.lock().unwrap_or_else(PoisonError::into_inner)
    }
}
