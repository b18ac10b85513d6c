//! Files that users write: settings of gauges, device files, scenarios, segments in memory, captures, traces.
//!
//! A wrong file is refused with a message; what is accepted is the same when it is written and read again, where the program writes it.

use profivac_client::settings::SettingsFile;
use profivac_device_file::{DeviceFile, show};
use profivac_dp::link::Baud;
use profivac_sim::Trace;
use profivac_sim::trace::pcapng;
use profivac_virtual::device_spec::DeviceSpec;
use profivac_virtual::scenario::Scenario;
use profivac_virtual::segment_file::SegmentFile;
use std::hash::{DefaultHasher, Hash, Hasher};
use std::path::Path;
use std::sync::atomic::{AtomicU32, Ordering};

/// A text of the file, or none.
fn text(octets: &[u8]) -> &str {
    std::str::from_utf8(octets).unwrap_or_default()
}

/// A message is a text without control characters, and not empty.
fn is_message(message: &str) {
    assert!(!message.is_empty(), "a refusal without a message");
}

/// A scenario, also as a segment in memory.
pub fn scenario(octets: &[u8]) {
    if let Err(error) = Scenario::parse(text(octets), "fuzz.toml") {
        is_message(&error.to_string());
    }
}

/// A segment in memory. Files of nonvolatile memory are not opened, as the folder does not exist.
pub fn segment(octets: &[u8]) {
    if let Err(error) = SegmentFile::parse(text(octets), Path::new("/nonexistent/fuzz.toml")) {
        is_message(&error.to_string());
    }
}

/// The settings of a gauge. Each has a place in the file.
pub fn settings(octets: &[u8]) {
    let text = text(octets);
    match SettingsFile::parse(text) {
        Ok(file) => {
            let lines = text.lines().count();
            let is_in_the_file = |at: (usize, usize)| (1..=lines).contains(&at.0) && at.1 >= 1;
            assert!(file.settings.iter().all(|setting| is_in_the_file(setting.at)), "{file:?}");
        }
        Err(error) => is_message(&error.to_string()),
    }
}

/// The devices that this process has shown.
static SHOWN: AtomicU32 = AtomicU32::new(0);

/// Whether the device of a file is shown. A process keeps a limited number of models: after 128 devices, eight more halve the share of the
/// files whose device is shown, so that a run of an hour still shows new ones.
fn is_shown(text: &str) -> bool {
    let mut hasher = DefaultHasher::new();
    text.hash(&mut hasher);
    let halvings = SHOWN.load(Ordering::Relaxed).saturating_sub(128) / 8;
    let is_shown = hasher.finish().trailing_zeros() >= halvings;
    if is_shown {
        SHOWN.fetch_add(1, Ordering::Relaxed);
    }
    is_shown
}

/// A device file: an error has its place, and a device that is read can be shown and read again.
pub fn device_file(octets: &[u8]) {
    let text = text(octets);
    match DeviceFile::parse(text) {
        Ok(file) if is_shown(text) => {
            if let Ok(model) = file.model() {
                let shown = show(model);
                let again = DeviceFile::parse(&shown);
                assert!(again.is_ok(), "{}\n{shown}", again.err().map(|error| error.to_string()).unwrap_or_default());
            }
        }
        Ok(_) => {}
        Err(error) => {
            is_message(&error.text);
            let lines = text.matches('\n').count() + 1;
            assert!(error.position.is_some_and(|(line, column)| (1..=lines).contains(&line) && column >= 1), "{error}");
        }
    }
}

/// A device as a command line writes it.
pub fn device_spec(octets: &[u8]) {
    match text(octets).parse::<DeviceSpec>() {
        Ok(spec) => {
            let built = spec.build(profivac_virtual::nonvolatile::NonvolatileMemory::volatile(), Baud::B19200);
            if let Err(error) = built {
                is_message(&error.to_string());
            }
        }
        Err(error) => is_message(&error.to_string()),
    }
}

/// A capture file: what is read is written again and read with the same result.
pub fn capture(octets: &[u8]) {
    if let Ok(trace) = pcapng::read(octets, Baud::B500000) {
        let again = pcapng::write(&trace, pcapng::USER0);
        let again = pcapng::read(&again, Baud::B500000).expect("a file that this program has written");
        assert_eq!(again.entries.len(), trace.entries.len());
    }
}

/// A trace: what is read is written again and read with the same result.
pub fn trace(octets: &[u8]) {
    if let Ok(trace) = text(octets).parse::<Trace>() {
        let again = trace.to_string();
        assert_eq!(again.parse::<Trace>().map(|again| again.to_string()), Ok(again));
    }
}
