//! The built dashboard, embedded in the program, each file also compressed.

use axum::http::header::{ACCEPT_ENCODING, CACHE_CONTROL, CONTENT_ENCODING, CONTENT_TYPE, VARY};
use axum::http::{HeaderMap, HeaderValue, StatusCode, Uri};
use axum::response::{IntoResponse, Response};
use include_dir::{Dir, include_dir};

static DASHBOARD: Dir<'_> = include_dir!("$OUT_DIR/web/dist");

/// The page of a station, which is the answer to every path without a file.
const PAGE: &str = "index.html";

/// The page of an archive.
const ARCHIVE_PAGE: &str = "archive.html";

/// Names in this folder contain a hash of the contents, so browsers may cache them for ever.
const HASHED: &str = "assets/";

/// The codings of the compressed files, and what their names end with. The first one that a client accepts is sent.
const CODINGS: [(&str, &str); 2] = [("br", ".br"), ("gzip", ".gz")];

/// A file of the dashboard; the page of a station if there is no such file.
pub async fn file(uri: Uri, headers: HeaderMap) -> Response {
    file_or(&uri, PAGE, &headers)
}

/// A file of the dashboard; the page of an archive if there is no such file.
pub async fn archive_file(uri: Uri, headers: HeaderMap) -> Response {
    file_or(&uri, ARCHIVE_PAGE, &headers)
}

fn file_or(uri: &Uri, page: &'static str, headers: &HeaderMap) -> Response {
    let name = uri.path().trim_start_matches('/');
    // The page of the other program is no file of this one, and a compressed file is no file by its own name.
    let is_hidden = name.ends_with(".html") || CODINGS.iter().any(|(_, ending)| name.ends_with(ending));
    let file = DASHBOARD.get_file(name).filter(|_| !is_hidden);
    if file.is_none() && name.starts_with(HASHED) {
        return StatusCode::NOT_FOUND.into_response();
    }
    let (name, cache_control) = match file {
        Some(_) if name.starts_with(HASHED) => (name, "public, max-age=31536000, immutable"),
        Some(_) => (name, "no-cache"),
        None => (page, "no-cache"),
    };
    let accepted = CODINGS.into_iter().filter(|(coding, _)| accepts(headers, coding));
    let mut compressed =
        accepted.filter_map(|(coding, ending)| Some((coding, DASHBOARD.get_file(format!("{name}{ending}"))?)));
    let (coding, file) = match compressed.next() {
        Some((coding, file)) => (Some(coding), Some(file)),
        None => (None, DASHBOARD.get_file(name)),
    };
    let contents = file.map_or(&[][..], |file| file.contents());
    let always = [(CONTENT_TYPE, content_type(name)), (CACHE_CONTROL, cache_control), (VARY, "accept-encoding")];
    let mut response = (always, contents).into_response();
    if let Some(coding) = coding {
        response.headers_mut().insert(CONTENT_ENCODING, HeaderValue::from_static(coding));
    }
    response
}

/// Whether Accept-Encoding names the coding without refusing it (RFC 9110 12.5.3).
fn accepts(headers: &HeaderMap, coding: &str) -> bool {
    let values = headers.get_all(ACCEPT_ENCODING).iter().filter_map(|value| value.to_str().ok());
    let mut named = values.flat_map(|value| value.split(','));
    named.any(|named| {
        let (name, weight) = named.split_once(';').unwrap_or((named, ""));
        let weight = weight.trim().strip_prefix("q=").map_or(Ok(1.0), str::parse::<f32>);
        name.trim().eq_ignore_ascii_case(coding) && weight.is_ok_and(|weight| weight > 0.0)
    })
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
    use axum::body::HttpBody;
    use axum::http::HeaderName;
    use flate2::read::GzDecoder;
    use std::io::Read;

    /// The script of the page of a station.
    fn script() -> String {
        let page = DASHBOARD.get_file(PAGE).and_then(|file| file.contents_utf8()).unwrap();
        page.split('"').find(|part| part.ends_with(".js")).unwrap().to_owned()
    }

    fn answer(path: &str, accepted: &'static str) -> Response {
        let headers = HeaderMap::from_iter([(ACCEPT_ENCODING, HeaderValue::from_static(accepted))]);
        file_or(&path.parse().unwrap(), PAGE, &headers)
    }

    #[test]
    fn a_file_is_compressed_as_the_client_accepts_it_and_kept_for_a_year() {
        let script = script();
        let length = |response: &Response| response.body().size_hint().exact().unwrap();
        let plain = answer(&script, "identity");
        for (accepted, coding) in [
            ("gzip, deflate, br, zstd", Some("br")),
            ("gzip, deflate", Some("gzip")),
            ("br;q=0, GZIP;q=0.5", Some("gzip")),
            ("deflate", None),
            ("", None),
        ] {
            let response = answer(&script, accepted);
            let header =
                |name: HeaderName| response.headers().get(name).map(|value: &HeaderValue| value.to_str().unwrap());
            assert_eq!(header(CONTENT_ENCODING), coding, "{accepted}");
            assert_eq!(header(CACHE_CONTROL), Some("public, max-age=31536000, immutable"));
            assert_eq!(header(CONTENT_TYPE), Some("text/javascript; charset=utf-8"));
            assert_eq!(header(VARY), Some("accept-encoding"));
            let is_smaller = 2 * length(&response) < length(&plain);
            assert_eq!(is_smaller, coding.is_some(), "{accepted}: {}", length(&response));
        }
        let page = answer("/trends", "br");
        assert_eq!(page.headers().get(CONTENT_ENCODING).unwrap(), "br");
        assert_eq!(page.headers().get(CACHE_CONTROL).unwrap(), "no-cache");
    }

    #[test]
    fn a_compressed_file_has_the_contents_of_the_file_and_no_address_of_its_own() {
        let script = script();
        let name = script.trim_start_matches('/');
        let compressed = DASHBOARD.get_file(format!("{name}.gz")).unwrap();
        let mut contents = Vec::new();
        GzDecoder::new(compressed.contents()).read_to_end(&mut contents).unwrap();
        assert_eq!(contents, DASHBOARD.get_file(name).unwrap().contents());
        for ending in [".gz", ".br"] {
            assert_eq!(answer(&format!("{script}{ending}"), "br").status(), StatusCode::NOT_FOUND);
        }
    }

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
