//! Compression of a stream: each chunk is flushed, so that the client has every event at once. Compression of a whole answer.

use axum::body::{Body, Bytes};
use axum::http::header::{ACCEPT_ENCODING, CONTENT_ENCODING, CONTENT_TYPE, VARY};
use axum::http::{HeaderMap, HeaderValue};
use axum::response::Response;
use flate2::Compression;
use flate2::write::GzEncoder;
use std::io::Write;
use tokio_stream::StreamExt;

/// Compresses the body of a response if the client accepts gzip.
pub fn compressed(response: Response, request: &HeaderMap) -> Response {
    if !accepts_gzip(request) {
        return response;
    }
    let (mut parts, body) = response.into_parts();
    parts.headers.insert(CONTENT_ENCODING, HeaderValue::from_static("gzip"));
    parts.headers.insert(VARY, HeaderValue::from_static("accept-encoding"));
    let mut encoder = ChunkEncoder::new();
    let chunks = body.into_data_stream().map(move |chunk| chunk.map(|chunk| encoder.encode(&chunk)));
    Response::from_parts(parts, Body::from_stream(chunks))
}

/// A complete body in JSON, compressed if the client accepts gzip.
pub fn compressed_json(body: Vec<u8>, request: &HeaderMap) -> Response {
    let mut response = Response::new(Body::empty());
    response.headers_mut().insert(CONTENT_TYPE, HeaderValue::from_static("application/json"));
    response.headers_mut().insert(VARY, HeaderValue::from_static("accept-encoding"));
    let compress = || {
        let mut encoder = GzEncoder::new(Vec::new(), Compression::default());
        // Writing into memory does not fail.
        encoder.write_all(&body).and_then(|()| encoder.finish())
    };
    match accepts_gzip(request).then(compress) {
        Some(Ok(compressed)) => {
            response.headers_mut().insert(CONTENT_ENCODING, HeaderValue::from_static("gzip"));
            *response.body_mut() = Body::from(compressed);
        }
        _ => *response.body_mut() = Body::from(body),
    }
    response
}

/// Whether Accept-Encoding names gzip without refusing it (RFC 9110 12.5.3).
fn accepts_gzip(request: &HeaderMap) -> bool {
    let values = request.get_all(ACCEPT_ENCODING).iter().filter_map(|value| value.to_str().ok());
    let mut codings = values.flat_map(|value| value.split(','));
    codings.any(|coding| {
        let (name, weight) = coding.split_once(';').unwrap_or((coding, ""));
        let weight = weight.trim().strip_prefix("q=").map_or(Ok(1.0), str::parse::<f32>);
        name.trim().eq_ignore_ascii_case("gzip") && weight.is_ok_and(|weight| weight > 0.0)
    })
}

/// One gzip stream; each chunk can be decoded as soon as it arrives.
struct ChunkEncoder(GzEncoder<Vec<u8>>);

impl ChunkEncoder {
    fn new() -> Self {
        Self(GzEncoder::new(Vec::new(), Compression::default()))
    }

    fn encode(&mut self, chunk: &[u8]) -> Bytes {
        // Writing into memory does not fail.
        self.0.write_all(chunk).and_then(|()| self.0.flush()).unwrap_or_default();
        std::mem::take(self.0.get_mut()).into()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use flate2::write::GzDecoder;
    use std::io::Read;

    #[test]
    fn a_whole_answer_is_a_complete_stream_or_plain() {
        let octets = |response: Response| {
            let runtime = tokio::runtime::Builder::new_current_thread().build().unwrap();
            runtime.block_on(axum::body::to_bytes(response.into_body(), usize::MAX)).unwrap().to_vec()
        };
        let plain = compressed_json(b"{}".to_vec(), &HeaderMap::new());
        assert!(!plain.headers().contains_key(CONTENT_ENCODING));
        assert_eq!(octets(plain), b"{}");
        let gzip = HeaderMap::from_iter([(ACCEPT_ENCODING, HeaderValue::from_static("gzip"))]);
        let answer = compressed_json(b"{}".to_vec(), &gzip);
        assert_eq!(answer.headers().get(CONTENT_ENCODING).unwrap(), "gzip");
        let mut text = Vec::new();
        // Reading to the end checks the trailer.
        flate2::read::GzDecoder::new(octets(answer).as_slice()).read_to_end(&mut text).unwrap();
        assert_eq!(text, b"{}");
    }

    #[test]
    fn each_chunk_can_be_decoded_at_once() {
        let (mut encoder, mut decoder) = (ChunkEncoder::new(), GzDecoder::new(Vec::new()));
        for chunk in ["event: snapshot\n\n", "event: change\n\n"] {
            decoder.write_all(&encoder.encode(chunk.as_bytes())).unwrap();
            decoder.flush().unwrap();
            assert_eq!(std::mem::take(decoder.get_mut()), chunk.as_bytes());
        }
    }

    #[test]
    fn only_a_client_that_accepts_gzip_gets_it() {
        let accepts = |value: &'static str| {
            accepts_gzip(&HeaderMap::from_iter([(ACCEPT_ENCODING, HeaderValue::from_static(value))]))
        };
        assert!(accepts("gzip, deflate, br") && accepts("br;q=1.0, GZIP;q=0.5"));
        assert!(!accepts("identity") && !accepts("gzip;q=0") && !accepts("") && !accepts_gzip(&HeaderMap::new()));
    }
}
