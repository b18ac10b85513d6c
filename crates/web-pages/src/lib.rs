//! The built dashboard, embedded in the program.

use axum::http::header::{CACHE_CONTROL, CONTENT_TYPE};
use axum::http::{StatusCode, Uri};
use axum::response::{IntoResponse, Response};
use include_dir::{Dir, include_dir};

static DASHBOARD: Dir<'_> = include_dir!("$OUT_DIR/web/dist");

/// The page of a station, which is the answer to every path without a file.
const PAGE: &str = "index.html";

/// The page of an archive.
const ARCHIVE_PAGE: &str = "archive.html";

/// Names in this folder contain a hash of the contents, so browsers may cache them for ever.
const HASHED: &str = "assets/";

/// A file of the dashboard; the page of a station if there is no such file.
pub async fn file(uri: Uri) -> Response {
    file_or(&uri, PAGE)
}

/// A file of the dashboard; the page of an archive if there is no such file.
pub async fn archive_file(uri: Uri) -> Response {
    file_or(&uri, ARCHIVE_PAGE)
}

fn file_or(uri: &Uri, page: &'static str) -> Response {
    let name = uri.path().trim_start_matches('/');
    // The page of the other program is no file of this one.
    let file = DASHBOARD.get_file(name).filter(|_| !name.ends_with(".html"));
    if file.is_none() && name.starts_with(HASHED) {
        return StatusCode::NOT_FOUND.into_response();
    }
    let (name, cache_control) = match file {
        Some(_) if name.starts_with(HASHED) => (name, "public, max-age=31536000, immutable"),
        Some(_) => (name, "no-cache"),
        None => (page, "no-cache"),
    };
    let contents = DASHBOARD.get_file(name).map_or(&[][..], |file| file.contents());
    ([(CONTENT_TYPE, content_type(name)), (CACHE_CONTROL, cache_control)], contents).into_response()
}

fn content_type(name: &str) -> &'static str {
    match name.rsplit('.').next() {
        Some("html") => "text/html; charset=utf-8",
        Some("js") => "text/javascript; charset=utf-8",
        Some("css") => "text/css; charset=utf-8",
        Some("svg") => "image/svg+xml",
        Some("json" | "webmanifest") => "application/json",
        _ => "application/octet-stream",
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_page_and_its_script_are_embedded() {
        let page = DASHBOARD.get_file(PAGE).and_then(|file| file.contents_utf8()).unwrap();
        assert!(page.contains("<div id=\"app\">"), "{page}");
        let assets: Vec<_> =
            DASHBOARD.get_dir("assets").unwrap().files().map(|file| file.path().to_str().unwrap()).collect();
        assert!(
            assets.iter().any(|name| content_type(name).starts_with("text/javascript") && page.contains(name)),
            "{assets:?}"
        );
    }
}
