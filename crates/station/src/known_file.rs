//! The station's file as the database knows it, so that a change while the station was stopped is noticed at the next start.

use crate::config::ConfigSource;
use crate::config::changes::{FileChange, KnownKeys};
use crate::recording::RecorderHandle;
use profivac_recorder::{Micros, StationState};

/// The name of the state in the database.
const FILE: &str = "file";

/// What has changed in the file since the station read it last; nothing for a new database.
#[must_use]
pub fn changes_while_stopped(recorder: &RecorderHandle, source: &ConfigSource) -> Vec<FileChange> {
    let known = has_file(source).then(|| known(recorder)).flatten();
    known.map(|known| known.changes_to(source.text())).unwrap_or_default()
}

/// Stores the keys of the file. A station without a file leaves them as they are.
pub fn remember(recorder: &RecorderHandle, source: &ConfigSource) {
    if !has_file(source) {
        return;
    }
    if let Ok(value) = serde_json::to_string(&KnownKeys::of(source.text())) {
        // Without room in the queue the next start names the changes again.
        let _queued = recorder.store_state(StationState { name: FILE, at: Micros::now(), value });
    }
}

fn has_file(source: &ConfigSource) -> bool {
    !source.path().as_os_str().is_empty()
}

/// The keys that the database has. A state that cannot be read counts as none.
fn known(recorder: &RecorderHandle) -> Option<KnownKeys> {
    let state = recorder.open_reader().and_then(|reader| reader.state(FILE)).ok()??;
    serde_json::from_str(&state.value).ok()
}
