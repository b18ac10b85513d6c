//! Settings of alarms, changed by an engineer in the dashboard: first in the station's file, then in the running alarms.
//!
//! ```text
//! request ─ file as the station has read it? ─ edited text ─ checked ─ file replaced ─ rules ─ audit trail, history, event
//! ```
//!
//! The edited text passes the checks of a start, and the file is replaced as a whole or not at all. A change that fails leaves file
//! and alarms as they were.

use crate::alarm::view::AlarmView;
use crate::alarm::{AlarmError, AlarmService, AlarmServiceError, SettingsChange};
use crate::config::changes::{FileChange, changes};
use crate::config::{AlarmSettings, Config, ConfigSource, DefaultAlarmSettings, SettingsError};
use crate::known_file;
use crate::recording::RecorderHandle;
use profivac_files::{keep_owner, synchronise};
use profivac_host::text_file;
use profivac_web_server::auth::Actor;
use std::fmt::Display;
use std::fs;
use std::io::{self, Write};
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use tempfile::NamedTempFile;

/// The reason why settings are not changed.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum AlarmEditError {
    /// The station runs without a file.
    #[error("this station has no file, so the settings of its alarms cannot be changed")]
    NoFile,
    /// The alarm is unknown, or the change is not on the disk.
    #[error(transparent)]
    Alarm(#[from] AlarmServiceError),
    /// The file has no such alarm, or another kind of limit.
    #[error(transparent)]
    Settings(#[from] SettingsError),
    /// The file is not the one that the station has read.
    #[error("{file} was changed since the station has read it; let the station read it (SIGHUP, systemctl reload profivac), then try again", file = .0.display())]
    FileChanged(PathBuf),
    /// The settings are not those that the user has seen.
    #[error("the settings are now {present}; look at them before you change them")]
    OtherSettings {
        /// The settings in the file.
        present: String,
    },
    /// The file with the new settings is wrong.
    #[error("{0}")]
    Invalid(String),
    /// The file cannot be read or written.
    #[error("{file} cannot be changed: {error}; nothing was changed; make the file and its folder writable for the station, or edit it by hand", file = file.display())]
    File {
        /// The file.
        file: PathBuf,
        /// The error of the operating system.
        error: io::Error,
    },
}

/// What an engineer asks for.
#[derive(Clone, Debug, PartialEq)]
pub struct AlarmEdit<T = AlarmSettings> {
    /// The settings that the engineer has seen.
    pub seen: T,
    /// The new settings.
    pub new: T,
    /// Why.
    pub reason: String,
}

/// Changes settings of alarms in the file and in the running station.
pub struct AlarmEditor {
    alarms: Arc<AlarmService>,
    recorder: Arc<RecorderHandle>,
    source: Mutex<Option<ConfigSource>>,
    /// Held while the file is read or replaced together with the rules.
    busy: Mutex<()>,
}

impl AlarmEditor {
    /// An editor without a file.
    #[must_use]
    pub const fn new(alarms: Arc<AlarmService>, recorder: Arc<RecorderHandle>) -> Self {
        Self { alarms, recorder, source: Mutex::new(None), busy: Mutex::new(()) }
    }

    /// The file whose rules apply now.
    pub fn set_source(&self, source: ConfigSource) {
        *self.source.lock().unwrap_or_else(PoisonError::into_inner) = Some(source);
    }

    /// What `new` changes in the file whose rules apply now.
    pub fn changes_to(&self, new: &ConfigSource) -> Vec<FileChange> {
        let present = self.source.lock().unwrap_or_else(PoisonError::into_inner);
        present.as_ref().map(|present| changes(present.text(), new.text())).unwrap_or_default()
    }

    /// Keeps the file as it is until the guard is dropped: the caller reads the file and applies it.
    pub fn hold(&self) -> MutexGuard<'_, ()> {
        self.busy.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn source(&self) -> Result<ConfigSource, AlarmEditError> {
        let source = self.source.lock().unwrap_or_else(PoisonError::into_inner).clone();
        source.filter(|source| source.path().exists()).ok_or(AlarmEditError::NoFile)
    }

    /// The settings of an alarm.
    ///
    /// # Errors
    /// [`AlarmEditError`] without a file, and for an alarm that the file does not have.
    pub fn settings(&self, name: &str) -> Result<AlarmSettings, AlarmEditError> {
        self.check_name(name)?;
        Ok(AlarmSettings::read(self.source()?.text(), name)?)
    }

    /// Changes the settings of an alarm. File, alarm and audit trail have the change when this returns.
    ///
    /// # Errors
    /// [`AlarmEditError`]; nothing is changed then, except after [`AlarmServiceError::NotStored`].
    pub fn change(&self, name: &str, edit: &AlarmEdit, actor: &Actor) -> Result<AlarmView, AlarmEditError> {
        let _held = self.hold();
        self.check_name(name)?;
        let read = |text: &str| AlarmSettings::read(text, name);
        let (config, before) = self.edit(edit, read, |new, text| new.write(text, name))?;
        let change = SettingsChange { before, after: edit.new.to_string(), reason: &edit.reason };
        let changed = self.alarms.change_rules(config.alarms, name, &change, actor)?;
        known_file::remember(&self.recorder, &self.source()?);
        Ok(changed)
    }

    /// The settings of all default alarms, by name, as the file has them.
    ///
    /// # Errors
    /// [`AlarmEditError`] if there is no file.
    pub fn default_settings(&self) -> Result<Vec<(&'static str, DefaultAlarmSettings)>, AlarmEditError> {
        let source = self.source()?;
        let read = |name| Ok((name, DefaultAlarmSettings::read(source.text(), name)?));
        DefaultAlarmSettings::NAMES.into_iter().map(read).collect()
    }

    /// Changes the settings of a default alarm: in the file, in the running alarms, in the audit trail.
    ///
    /// # Errors
    /// [`AlarmEditError`] says why not, or that the change may be lost.
    pub fn change_default(
        &self,
        name: &str,
        edit: &AlarmEdit<DefaultAlarmSettings>,
        actor: &Actor,
    ) -> Result<DefaultAlarmSettings, AlarmEditError> {
        let _held = self.hold();
        let read = |text: &str| DefaultAlarmSettings::read(text, name);
        let (config, before) = self.edit(edit, read, |new, text| new.write(text, name))?;
        let change = SettingsChange { before, after: edit.new.to_string(), reason: &edit.reason };
        self.alarms.change_default_rules(config.alarms, config.plant_states, name, &change, actor)?;
        let source = self.source()?;
        known_file::remember(&self.recorder, &source);
        Ok(DefaultAlarmSettings::read(source.text(), name)?)
    }

    /// Changes the file. Returns its configuration, and the settings before.
    fn edit<T: PartialEq + Display>(
        &self,
        edit: &AlarmEdit<T>,
        read: impl Fn(&str) -> Result<T, SettingsError>,
        write: impl Fn(&T, &str) -> Result<String, SettingsError>,
    ) -> Result<(Config, String), AlarmEditError> {
        let source = self.source()?;
        let file = fs::canonicalize(source.path()).map_err(|error| failed(source.path(), error))?;
        let present = read(source.text())?;
        if present != edit.seen {
            return Err(AlarmEditError::OtherSettings { present: present.to_string() });
        }
        let text = write(&edit.new, source.text())?;
        let config = source.parse(&text).ok_or(AlarmEditError::NoFile)?.map_err(AlarmEditError::Invalid)?;
        replace(&file, source.text(), &text)?;
        self.set_source(config.source.clone());
        Ok((config, present.to_string()))
    }

    fn check_name(&self, name: &str) -> Result<(), AlarmEditError> {
        let is_known = self.alarms.all().iter().any(|alarm| alarm.name == name);
        if is_known { Ok(()) } else { Err(AlarmServiceError::from(AlarmError::Unknown(name.to_owned())).into()) }
    }
}

/// Replaces the text of a file, if it is `old`. The new file has the owner and the mode of the old one.
fn replace(file: &Path, old: &str, new: &str) -> Result<(), AlarmEditError> {
    let present = text_file::read(file).map_err(|error| failed(file, error))?;
    if present != old {
        return Err(AlarmEditError::FileChanged(file.to_owned()));
    }
    write(file, new).map_err(|error| failed(file, error))
}

fn write(file: &Path, text: &str) -> io::Result<()> {
    let metadata = fs::metadata(file)?;
    // A file that is replaced needs no permission to write; its owner protects it by the mode nevertheless.
    if metadata.permissions().readonly() {
        return Err(io::Error::new(io::ErrorKind::PermissionDenied, "the file is read-only"));
    }
    let folder = file.parent().unwrap_or(Path::new("/"));
    let mut new = NamedTempFile::new_in(folder)?;
    new.write_all(text.as_bytes())?;
    keep_owner(new.as_file(), &metadata)?;
    new.as_file().sync_all()?;
    new.persist(file)?;
    synchronise(folder)
}

fn failed(file: &Path, error: io::Error) -> AlarmEditError {
    AlarmEditError::File { file: file.to_owned(), error }
}
