//! The events of a slave: changes of its points, of its diagnosis, loss and return.

use super::SegmentSlave;
use crate::recording::RecorderHandle;
use crate::segment::moment::Moment;
use profivac_recorder::{EventKind, Quality};
use std::time::Duration;

/// The shortest time between two events of a point. chosen: a bit that toggles with each sample must not fill the list of events.
const TOLD_INTERVAL: Duration = Duration::from_secs(10);

impl SegmentSlave {
    /// Records an event for each point with texts that has another one: the state of a pump, the limit switch of a valve.
    pub(super) fn tell_changes(&mut self, recorder: &RecorderHandle, now: Moment) {
        let points = self.config.points.iter().zip(self.points.iter()).zip(&mut self.told);
        for ((settings, point), told) in points {
            if !settings.has_texts() || point.quality != Quality::Valid {
                continue;
            }
            let text = point.text_without_remark();
            let is_known = told
                .as_ref()
                .is_some_and(|(told, at)| told == text || now.at.saturating_duration_since(*at) < TOLD_INTERVAL);
            if is_known {
                continue;
            }
            if told.replace((text.to_owned(), now.at)).is_some() {
                let text = format!("{}: {} is {text}", self.config.name, point.target);
                recorder.event_at(now.wall, Some(&self.config.name), EventKind::Gauge, text);
            }
        }
    }

    /// Records an event if the diagnosis has other texts than the last event.
    pub(super) fn tell_diagnosis(&mut self, recorder: &RecorderHandle, now: Moment) {
        if self.told_reports == self.reports {
            return;
        }
        let Some(remark) = self.diagnosis_events.take(now.at) else { return };
        let sentence = if self.reports.is_empty() { "no diagnosis".to_owned() } else { self.reports.join("; ") };
        let text = format!("{}: {sentence}{remark}", self.config.name);
        recorder.event_at(now.wall, Some(&self.config.name), EventKind::Gauge, text);
        self.told_reports.clone_from(&self.reports);
    }

    /// Sets the problem, and records an event if it is another one than before and the minute has room for it.
    pub(super) fn note_problem(&mut self, recorder: &RecorderHandle, problem: Option<String>, now: Moment) {
        if self.problem != problem || (problem.is_none() && !self.has_values()) {
            self.problem = problem;
            self.problem_events.changed();
        }
        if !self.problem_events.has_changed() {
            return;
        }
        let Some(remark) = self.problem_events.take(now.at) else { return };
        let sentence = self.problem.as_deref().unwrap_or("in data exchange");
        let text = format!("{}: {sentence}{remark}", self.config.name);
        recorder.event_at(now.wall, Some(&self.config.name), EventKind::Bus, text);
    }
}
