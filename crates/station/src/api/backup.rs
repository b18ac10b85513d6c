//! Copies of the database for the browser: one at a time, deleted when it is no longer needed.
//!
//! A copy has no name in the file system: its file is deleted while it is open. Its room on the disk is free again when the copy ends, also
//! when the station is killed.

use super::database::DatabaseReaders;
use crate::services::Services;
use crate::view::unix_ms;
use axum::Json;
use axum::extract::{Path, State};
use axum::http::header::{CONTENT_DISPOSITION, CONTENT_LENGTH, CONTENT_TYPE};
use axum::response::IntoResponse;
use jiff::Timestamp;
use profivac_recorder::backup::Existing;
use profivac_recorder::{AuditAction, AuditEntry, Micros};
use profivac_web_server::auth::secret::RandomSecret;
use profivac_web_server::auth::{Actor, Role};
use profivac_web_server::problem::{Problem, task_failed};
use serde::Serialize;
use std::fs::{self, File};
use std::io;
use std::path::PathBuf;
use std::sync::{Arc, Mutex, PoisonError};
use std::time::Duration;
use tokio::sync::{OwnedSemaphorePermit, Semaphore};
use utoipa::ToSchema;

/// The extension of a copy while it is made, beside the database.
const EXTENSION: &str = "download";

/// The time in which the download of a copy begins. chosen
const KEPT: Duration = Duration::from_secs(15 * 60);

/// Octets of the copy in the memory for each download.
const CHUNK: usize = 256 << 10;

/// A copy of the database that is ready to be downloaded.
#[derive(Debug, Serialize, ToSchema)]
pub struct BackupView {
    /// The name of the copy in the path of its download.
    id: String,
    /// The size of the copy.
    octets: u64,
    /// When the copy was made, in milliseconds since 1970.
    made_ms: i64,
    /// Until when a download begins, in milliseconds since 1970. A later copy ends this one.
    kept_until_ms: i64,
}

/// A copy. Its permit is free when the last download of it has ended.
struct Copy {
    id: RandomSecret,
    file: File,
    octets: u64,
    made: Micros,
    _permit: OwnedSemaphorePermit,
}

/// The copies of a station: none or one.
#[derive(Clone)]
pub struct Backups {
    permit: Arc<Semaphore>,
    ready: Arc<Mutex<Option<Arc<Copy>>>>,
    kept: Duration,
}

impl Backups {
    /// No copy. Deletes what a killed station has left of one.
    pub fn new(services: &Services) -> Self {
        let left = services.recorder().beside(EXTENSION);
        for file in [left.with_extension(format!("{EXTENSION}.part")), left] {
            let _gone = fs::remove_file(file);
        }
        Self { permit: Arc::new(Semaphore::new(1)), ready: Arc::default(), kept: KEPT }
    }

    /// The permit for the next copy. A copy that is not being downloaded is deleted for it.
    fn begin(&self) -> Result<OwnedSemaphorePermit, Problem> {
        drop(self.ready().take_if(|copy| Arc::strong_count(copy) == 1));
        Arc::clone(&self.permit).try_acquire_owned().map_err(|_| {
            Problem::conflict("another copy of the database is being made or downloaded; try again after its end")
        })
    }

    /// Keeps a copy for its download, until the time that `sleep` gets has passed.
    fn keep<Passed: Future<Output = ()> + Send + 'static>(
        &self,
        copy: Copy,
        sleep: impl FnOnce(Duration) -> Passed,
    ) -> BackupView {
        let made = copy.made;
        let view = BackupView {
            id: copy.id.reveal().to_owned(),
            octets: copy.octets,
            made_ms: unix_ms(made),
            kept_until_ms: unix_ms(made.after(self.kept)),
        };
        let (backups, id) = (self.clone(), copy.id.clone());
        *self.ready() = Some(Arc::new(copy));
        let passed = sleep(self.kept);
        tokio::spawn(async move {
            passed.await;
            backups.ready().take_if(|copy| copy.id == id);
        });
        view
    }

    fn find(&self, id: &str) -> Option<Arc<Copy>> {
        self.ready().as_ref().filter(|copy| copy.id.matches(id.as_bytes())).cloned()
    }

    fn ready(&self) -> std::sync::MutexGuard<'_, Option<Arc<Copy>>> {
        self.ready.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

/// The octets of a copy in pieces.
struct Pieces {
    copy: Arc<Copy>,
    at: u64,
}

impl Iterator for Pieces {
    type Item = io::Result<Vec<u8>>;

    fn next(&mut self) -> Option<Self::Item> {
        let left = self.copy.octets.saturating_sub(self.at);
        let length = usize::try_from(left).unwrap_or(CHUNK).min(CHUNK);
        if length == 0 {
            return None;
        }
        let mut octets = vec![0; length];
        let read = profivac_files::read_exact_at(&self.copy.file, &mut octets, self.at);
        self.at = self.at.saturating_add(length as u64);
        Some(read.map(|()| octets))
    }
}

/// Make a copy of the database
///
/// The copy is one state of the database: samples, events, alarms and the audit trail. It is checked before the answer. The audit trail
/// has the user. At most one copy exists: a copy that is not being downloaded ends with the next one.
#[utoipa::path(
    post,
    path = "/api/backup",
    responses(
        (status = 200, body = BackupView),
        (status = 403, body = Problem, description = "The role engineer is needed"),
        (status = 409, body = Problem, description = "Another copy is being made or downloaded"),
        (status = 503, body = Problem, description = "The database cannot be read, or the disk has no room for the copy")
    )
)]
pub async fn backup(
    State(services): State<Arc<Services>>,
    State(backups): State<Backups>,
    actor: Actor,
) -> Result<Json<BackupView>, Problem> {
    services.control().refusals().require(&actor, Role::Engineer, "copying the database")?;
    let permit = backups.begin()?;
    let copied = tokio::task::spawn_blocking(move || audited_copy(&services, &actor, permit));
    let copy = copied.await.map_err(|error| task_failed(&error))??;
    Ok(Json(backups.keep(copy, tokio::time::sleep)))
}

/// Writes to the audit trail who makes a copy, makes it, and writes the outcome.
fn audited_copy(services: &Services, actor: &Actor, permit: OwnedSemaphorePermit) -> Result<Copy, Problem> {
    let unavailable = |error: &dyn std::fmt::Display| Problem::unavailable(error.to_string());
    let recorder = services.recorder();
    let begun = actor.audit_entry(AuditAction::Backup);
    let number = recorder.audit_before_sending(begun.clone()).map_err(|error| unavailable(&error))?;
    let copied = copy(services, permit);
    let sentence = match &copied {
        Ok(copy) => format!("done: {} octets", copy.octets),
        Err(problem) => format!("not done: {problem}"),
    };
    let (action, outcome) = (AuditAction::Outcome.into(), Some(sentence));
    // The recorder keeps the row until it is on the disk.
    let _kept = recorder.audit(AuditEntry { at: Micros::now(), action, refers_to: Some(number), outcome, ..begun });
    copied
}

/// Copies the database beside it, and deletes the name of the copy.
fn copy(services: &Services, permit: OwnedSemaphorePermit) -> Result<Copy, Problem> {
    let to: PathBuf = services.recorder().beside(EXTENSION);
    let unavailable = |error: &dyn std::fmt::Display| Problem::unavailable(error.to_string());
    let id = RandomSecret::new().map_err(|error| unavailable(&error))?;
    let reader = services.recorder().open_reader()?;
    let made = Micros::now();
    reader.backup(&to, Existing::Replace, |_, _| ()).map_err(|error| unavailable(&error))?;
    let opened = File::open(&to);
    let _gone = fs::remove_file(&to);
    let (file, octets) =
        opened.and_then(|file| file.metadata().map(|data| (file, data.len()))).map_err(|error| unavailable(&error))?;
    Ok(Copy { id, file, octets, made, _permit: permit })
}

/// Download a copy of the database
///
/// The copy is one SQLite file that `profivac report`, `export` and a station open.
#[utoipa::path(
    get,
    path = "/api/backup/{id}",
    params(("id" = String, Path, description = "The name of the copy", example = "0")),
    responses(
        (status = 200, content_type = "application/vnd.sqlite3", body = String),
        (status = 403, body = Problem, description = "The role engineer is needed"),
        (status = 404, body = Problem, description = "There is no such copy, or no longer")
    )
)]
pub async fn download(
    State(services): State<Arc<Services>>,
    State(readers): State<DatabaseReaders>,
    State(backups): State<Backups>,
    actor: Actor,
    Path(id): Path<String>,
) -> Result<impl IntoResponse, Problem> {
    services.control().refusals().require(&actor, Role::Engineer, "copying the database")?;
    let copy =
        backups.find(&id).ok_or_else(|| Problem::not_found("there is no such copy, or no longer; make another one"))?;
    let name = Timestamp::from_microsecond(copy.made.0)
        .map_or_else(|_| "backup.db".to_owned(), |made| made.strftime("backup-%Y-%m-%d-%H%M%S.db").to_string());
    let headers = [
        (CONTENT_TYPE, "application/vnd.sqlite3".to_owned()),
        (CONTENT_LENGTH, copy.octets.to_string()),
        (CONTENT_DISPOSITION, format!("attachment; filename=\"{name}\"")),
    ];
    Ok((headers, readers.stream_export(Pieces { copy, at: 0 })))
}

#[cfg(test)]
mod tests {
    use super::*;
    use tokio::sync::oneshot;

    fn copy(permit: OwnedSemaphorePermit) -> Copy {
        let (id, file) = (RandomSecret::new().unwrap(), tempfile::tempfile().unwrap());
        Copy { id, file, octets: 0, made: Micros::now(), _permit: permit }
    }

    #[tokio::test]
    async fn a_copy_ends_after_a_quarter_of_an_hour_and_a_download_goes_on() {
        let backups = Backups { permit: Arc::new(Semaphore::new(1)), ready: Arc::default(), kept: KEPT };
        for is_being_downloaded in [false, true] {
            let (pass, passed) = oneshot::channel::<()>();
            let mut asked = None;
            let view = backups.keep(copy(backups.begin().unwrap()), |time| {
                asked = Some(time);
                async move { passed.await.unwrap() }
            });
            assert_eq!(asked, Some(Duration::from_secs(900)));
            assert_eq!(view.kept_until_ms - view.made_ms, 900_000);
            let download = backups.find(&view.id).filter(|_| is_being_downloaded);
            assert!(backups.find(&view.id).is_some());
            pass.send(()).unwrap();
            // The task of `keep` runs when this one yields.
            for _ in 0..100 {
                tokio::task::yield_now().await;
            }
            assert!(backups.find(&view.id).is_none());
            assert_eq!(backups.begin().is_err(), is_being_downloaded);
            drop(download);
            assert!(backups.begin().is_ok(), "the room of the copy is free");
        }
    }
}
