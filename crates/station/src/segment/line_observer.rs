//! What a segment hears on its line: live list, statistics, flight recorder. The same for a segment of the station's master and for one
//! on which the station only listens.

use super::moment::Moment;
use super::services::SegmentServices;
use crate::bus::CaptureRequest;
use crate::config;
use profivac_dp::link::{Baud, BitTime};
use profivac_explain::gsd::Files;
use profivac_listen::event::{Event, EventKind as BusEvent};
use profivac_listen::flight::{Capture, CaptureFolder, FlightLimits, FlightRecorder};
use profivac_listen::gauge::Declared;
use profivac_listen::report::BusReport;
use profivac_listen::{Chunk, Divider, Observer, TimeSource};
use profivac_recorder::{EventKind, Micros};
use std::path::Path;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

/// The time between two reports.
const REPORT_INTERVAL: Duration = Duration::from_secs(1);

/// The shortest time between two captures. chosen: a fault that lasts makes one capture each minute, within the limit of files.
const CAPTURE_INTERVAL: Duration = Duration::from_mins(1);

/// The line of a segment.
pub struct LineObserver {
    segment: String,
    divider: Divider,
    observer: Observer,
    flight: FlightRecorder,
    captures: CaptureFolder,
    pieces: Vec<profivac_listen::Piece>,
    /// The number of the last event that was handled.
    handled: u64,
    /// Events also become events of the station.
    records_events: bool,
    allowance: EventAllowance,
    report_at: Instant,
    capture_at: Instant,
    /// The number of the next capture.
    number: u64,
    /// A capture is being written.
    is_storing: Arc<AtomicBool>,
}

impl LineObserver {
    /// An observer of the line of `segment`, which has these gauges now. Its other slaves have the words of their GSD files.
    pub fn new(segment: &config::Segment, gauges: &[config::Gauge], baud: Baud, captures: &Path, now: Moment) -> Self {
        let files =
            Files::new(segment.slaves.iter().map(|slave| Arc::clone(slave.gsd.file()))).with_devices(segment.devices);
        let mut line = Self {
            observer: Observer::new(baud, TimeSource::Platform).with_gsd(files),
            records_events: segment.listen_only,
            ..Self::of_line(&segment.name, baud, TimeSource::Platform, captures, now)
        };
        line.declare(gauges);
        line
    }

    /// An observer of a line with this name and without declared gauges. Its events do not become events of the station.
    pub fn of_line(name: &str, baud: Baud, times: TimeSource, captures: &Path, now: Moment) -> Self {
        let limits = FlightLimits::default();
        let now = now.at;
        Self {
            segment: name.to_owned(),
            divider: Divider::new(baud, times),
            observer: Observer::new(baud, times),
            flight: FlightRecorder::new(baud, limits.clone()),
            captures: CaptureFolder::new(captures.join(folder_name(name)), limits),
            pieces: Vec::new(),
            handled: 0,
            records_events: false,
            report_at: now,
            capture_at: now,
            allowance: EventAllowance::new(now),
            number: 0,
            is_storing: Arc::default(),
        }
    }

    /// The gauges of the station's file.
    pub fn declare(&mut self, gauges: &[config::Gauge]) {
        for gauge in gauges {
            let declared = Declared { model: gauge.device, configuration: gauge.configuration, unit: gauge.unit };
            self.observer.declare(gauge.address, declared);
        }
    }

    /// The state of the line.
    pub const fn observer(&self) -> &Observer {
        &self.observer
    }

    /// Octets of the line.
    pub fn hear(&mut self, chunk: &Chunk) {
        self.divider.push(chunk, &mut self.pieces);
        self.observe();
    }

    /// The line has been silent for so long that no telegram continues.
    pub fn silence(&mut self) {
        self.divider.end(&mut self.pieces);
        self.observe();
    }

    fn observe(&mut self) {
        for piece in self.pieces.drain(..) {
            self.observer.piece(&piece);
            self.flight.add(&piece);
        }
    }

    /// Handles new events at this bit time, which is `now` on the clocks of the station, and publishes the report.
    pub fn work(&mut self, services: &SegmentServices, bus_time: BitTime, now: Moment) {
        self.observer.advance(bus_time);
        let events: Vec<Event> = self.observer.events_since(self.handled).cloned().collect();
        for event in &events {
            self.handled = event.number;
            if is_trigger(event.kind()) {
                self.trigger(bus_time, now, &event.to_string());
            }
            if self.records_events && self.allowance.take(now.at) {
                let text = format!("segment {}: {event}", self.segment);
                services.recorder.event_at(now.wall, None, EventKind::Bus, text);
            }
        }
        match services.snapshots.buses().take_request(&self.segment) {
            Some(CaptureRequest { reason, is_by_user: true }) => self.flight.trigger(bus_time, &reason),
            Some(CaptureRequest { reason, is_by_user: false }) => self.trigger(bus_time, now, &reason),
            None => {}
        }
        if let Some(omitted) = self.allowance.take_omitted(now.at) {
            let text = format!(
                "segment {}: {omitted} further events of the bus within a minute are not recorded; its page has the last ones",
                self.segment
            );
            services.recorder.event_at(now.wall, None, EventKind::Bus, text);
        }
        if let Some(capture) = self.flight.take_capture(bus_time) {
            self.store(services, capture, now);
        }
        if now.at >= self.report_at {
            self.report_at = now.at + REPORT_INTERVAL;
            let recorder_octets = self.flight.memory_octets() as u64;
            let report = BusReport { recorder_octets, ..BusReport::of(&self.observer) };
            services.snapshots.buses().publish(&self.segment, report, &self.captures);
        }
    }

    fn trigger(&mut self, bus_time: BitTime, now: Moment, reason: &str) {
        if now.at >= self.capture_at {
            self.capture_at = now.at + CAPTURE_INTERVAL;
            self.flight.trigger(bus_time, reason);
        }
    }

    /// Writes a capture in a thread of its own: a bus thread never waits for the disk. While a disk hangs no second capture waits in
    /// memory.
    fn store(&mut self, services: &SegmentServices, capture: Capture, now: Moment) {
        let (captures, recorder, segment) =
            (self.captures.clone(), Arc::clone(&services.recorder), self.segment.clone());
        if self.is_storing.swap(true, Ordering::AcqRel) {
            let text = format!(
                "segment {segment}: a capture ({}) is lost: the disk has not taken the one before",
                capture.reason
            );
            recorder.event_at(now.wall, None, EventKind::Bus, text);
            return;
        }
        let name = format!("{}-{}", now.wall.0 / Micros::SECOND, self.number);
        self.number = self.number.wrapping_add(1);
        let is_storing = Arc::clone(&self.is_storing);
        let store = move || {
            let text = match captures.store(&name, &capture.file()) {
                Ok(stored) => format!("segment {segment}: capture {} ({})", stored.name, capture.reason),
                Err(error) => {
                    format!("segment {segment}: the capture {name} ({}) cannot be written: {error}", capture.reason)
                }
            };
            is_storing.store(false, Ordering::Release);
            recorder.event_now(None, EventKind::Bus, text);
        };
        let thread = std::thread::Builder::new().name("capture".to_owned()).spawn(store);
        if let Err(error) = thread {
            self.is_storing.store(false, Ordering::Release);
            let text = format!("segment {}: the system gives no thread for a capture: {error}", self.segment);
            services.recorder.event_at(now.wall, None, EventKind::Bus, text);
        }
    }
}

/// The number of events of a line that are recorded in a minute. chosen: a ring of 30 stations starts with fewer, and a master that
/// writes a parameter in every cycle does not fill the database.
const EVENTS_PER_MINUTE: u32 = 120;

/// How many events of a line may be recorded: telegrams of others cause them, as many as they like.
struct EventAllowance {
    began: Instant,
    count: u32,
    omitted: u64,
}

impl EventAllowance {
    const MINUTE: Duration = Duration::from_mins(1);

    const fn new(now: Instant) -> Self {
        Self { began: now, count: 0, omitted: 0 }
    }

    /// Whether one more event is recorded.
    fn take(&mut self, now: Instant) -> bool {
        if self.omitted == 0 && now.saturating_duration_since(self.began) >= Self::MINUTE {
            *self = Self::new(now);
        }
        let is_allowed = self.count < EVENTS_PER_MINUTE;
        if is_allowed {
            self.count = self.count.saturating_add(1);
        } else {
            self.omitted = self.omitted.saturating_add(1);
        }
        is_allowed
    }

    /// The number of events of the past minute that were not recorded, at its end.
    fn take_omitted(&mut self, now: Instant) -> Option<u64> {
        let is_over = self.omitted > 0 && now.saturating_duration_since(self.began) >= Self::MINUTE;
        is_over.then(|| std::mem::replace(self, Self::new(now)).omitted)
    }
}

/// Whether an event triggers a capture: a lost station, a burst of damaged telegrams, a diagnosis.
const fn is_trigger(kind: BusEvent) -> bool {
    match kind {
        BusEvent::Lost | BusEvent::Burst | BusEvent::Diagnosis => true,
        BusEvent::Returned
        | BusEvent::Configuration
        | BusEvent::Owner
        | BusEvent::Refused
        | BusEvent::Parameter
        | BusEvent::Ring => false,
    }
}

/// The name of a segment as that of a folder.
fn folder_name(segment: &str) -> String {
    segment.chars().map(|it| if it.is_alphanumeric() || matches!(it, '-' | '_') { it } else { '_' }).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn events_beyond_those_of_a_minute_are_counted_and_not_recorded() {
        let began = Instant::now();
        let mut allowance = EventAllowance::new(began);
        let recorded = (0..10_000).filter(|_| allowance.take(began)).count();
        assert_eq!((recorded, allowance.take_omitted(began)), (EVENTS_PER_MINUTE as usize, None));
        let next = began + EventAllowance::MINUTE;
        assert_eq!(allowance.take_omitted(next), Some(10_000 - u64::from(EVENTS_PER_MINUTE)));
        assert!(allowance.take(next), "the next minute has its own");
        assert_eq!(allowance.take_omitted(next + EventAllowance::MINUTE), None);
    }
}
