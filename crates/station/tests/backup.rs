//! Copies of the database over HTTP: who makes them, what they hold, that there is one at a time, and what is left of them.

#![allow(clippy::unwrap_used, clippy::panic, clippy::indexing_slicing, reason = "a test")]

use crate::support;
use axum::Router;
use axum::body::{Body, to_bytes};
use axum::http::{Request, Response};
use profivac_recorder::{EventKind, Micros, Quality, Reader, Sample};
use profivac_station::api::router;
use profivac_station::services::Services;
use profivac_web_server::auth::{Role, User};
use profivac_web_server::middleware::Peer;
use serde_json::Value;
use std::fs;
use std::path::Path;
use std::sync::Arc;
use tempfile::TempDir;
use tokio_stream::StreamExt;
use tower::ServiceExt;

/// 2026-01-01.
const NEW_YEAR: i64 = 1_767_225_600 * Micros::SECOND;

struct Station {
    folder: TempDir,
    services: Arc<Services>,
    router: Router,
}

impl Station {
    /// A station with ten samples, each beyond the deadband.
    fn new() -> Self {
        let folder = tempfile::tempdir().unwrap();
        let services = support::services(folder.path());
        for second in 0..10 {
            let at = Micros(NEW_YEAR + second * Micros::SECOND);
            services
                .recorder()
                .push(&Arc::from("chamber"), Sample::new(at, Some(1e-4 * (1.0 + second as f64)), Quality::Valid));
        }
        assert!(services.recorder().flush());
        let router = router(Arc::clone(&services));
        Self { folder, services, router }
    }

    async fn send(&self, method: &str, path: &str, role: Role) -> Response<Body> {
        let mut request = Request::builder().method(method).uri(path).body(Body::empty()).unwrap();
        request.extensions_mut().insert(User { name: Arc::from("Ada"), role });
        request.extensions_mut().insert(Peer([10, 0, 0, 7].into()));
        self.router.clone().oneshot(request).await.unwrap()
    }

    /// Makes a copy as an engineer. Returns the path of its download.
    async fn copy(&self) -> String {
        let (status, answer) = json(self.send("POST", "/api/backup", Role::Engineer).await).await;
        assert_eq!(status, 200, "{answer}");
        format!("/api/backup/{}", answer["id"].as_str().unwrap())
    }

    /// The files beside the database whose names have this part.
    fn left(&self) -> Vec<String> {
        let names =
            fs::read_dir(self.folder.path()).unwrap().map(|file| file.unwrap().file_name().into_string().unwrap());
        names.filter(|name| name.contains("download")).collect()
    }
}

async fn octets(response: Response<Body>) -> Vec<u8> {
    to_bytes(response.into_body(), usize::MAX).await.unwrap().to_vec()
}

async fn json(response: Response<Body>) -> (u16, Value) {
    let status = response.status().as_u16();
    (status, serde_json::from_slice(&octets(response).await).unwrap())
}

#[tokio::test]
async fn an_engineer_downloads_a_copy_with_the_samples_and_the_row_of_the_audit_trail_about_it() {
    let station = Station::new();
    let path = station.copy().await;
    assert_eq!(station.left(), Vec::<String>::new(), "the copy has no name in the folder");
    let response = station.send("GET", &path, Role::Engineer).await;
    let header = |name: &str| response.headers()[name].to_str().unwrap().to_owned();
    assert!(header("content-disposition").starts_with("attachment; filename=\"backup-2"), "{response:?}");
    let length = header("content-length");
    let copy = octets(response).await;
    assert_eq!(copy.len().to_string(), length);
    let file = station.folder.path().join("copy.db");
    fs::write(&file, &copy).unwrap();
    let reader = Reader::open(&file).unwrap();
    assert_eq!(reader.samples("chamber", Micros(0), Micros(i64::MAX)).unwrap().len(), 10);
    let rows = |reader: &Reader| {
        let query = profivac_recorder::audit::AuditQuery {
            from: Micros(0),
            to: Micros(i64::MAX),
            gauge: None,
            user: None,
            limit: 10,
        };
        let rows = reader.audit(&query).unwrap();
        rows.into_iter().rev().map(|row| (row.action.as_str().to_owned(), row.user, row.outcome)).collect::<Vec<_>>()
    };
    let begun = ("backup".to_owned(), "Ada".to_owned(), None);
    assert_eq!(rows(&reader), std::slice::from_ref(&begun));
    assert!(station.services.recorder().flush());
    let outcome = ("outcome".to_owned(), "Ada".to_owned(), Some(format!("done: {length} octets")));
    assert_eq!(rows(&station.services.recorder().open_reader().unwrap()), [begun, outcome]);
}

#[tokio::test]
async fn a_copy_needs_the_role_engineer() {
    let station = Station::new();
    let path = station.copy().await;
    for role in [Role::Viewer, Role::Operator] {
        for (method, path) in [("POST", "/api/backup"), ("GET", path.as_str())] {
            let (status, answer) = json(station.send(method, path, role).await).await;
            assert_eq!(status, 403, "{method} {path}: {answer}");
        }
    }
    let (status, answer) = json(station.send("GET", "/api/backup/0", Role::Engineer).await).await;
    assert_eq!((status, answer["detail"].as_str().unwrap().contains("no such copy")), (404, true));
}

#[tokio::test]
async fn no_second_copy_is_made_while_one_is_downloaded_and_the_next_one_ends_the_one_before() {
    let station = Station::new();
    // More than the station reads ahead of its client.
    for _ in 0..1500 {
        station.services.recorder().event_now_and_wait(None, EventKind::Note, "x".repeat(2000));
    }
    let first = station.copy().await;
    let mut download = station.send("GET", &first, Role::Engineer).await.into_body().into_data_stream();
    assert!(download.next().await.is_some());
    let (status, answer) = json(station.send("POST", "/api/backup", Role::Engineer).await).await;
    assert_eq!((status, answer["title"].as_str()), (409, Some("Conflict")), "{answer}");
    while download.next().await.is_some() {}
    drop(download);
    // The task that reads the copy ends after the last chunk is taken.
    let second = loop {
        let (status, answer) = json(station.send("POST", "/api/backup", Role::Engineer).await).await;
        if status == 200 {
            break format!("/api/backup/{}", answer["id"].as_str().unwrap());
        }
        tokio::task::yield_now().await;
    };
    assert_eq!(station.send("GET", &first, Role::Engineer).await.status(), 404);
    assert_eq!(station.send("GET", &second, Role::Engineer).await.status(), 200);
}

#[tokio::test]
async fn what_a_killed_station_has_left_of_a_copy_is_deleted_at_the_start() {
    let folder = tempfile::tempdir().unwrap();
    let services = support::services(folder.path());
    let left = [services.recorder().beside("download"), services.recorder().beside("download.part")];
    for file in &left {
        fs::write(file, "a part of a copy").unwrap();
    }
    let _router = router(services);
    assert!(!left.iter().any(|file: &std::path::PathBuf| Path::exists(file)));
}
