//! HTTP/2 (RFC 9113), where the server uses TLS: all windows of a browser share one connection, so that open live streams do not keep
//! requests waiting, as six connections of HTTP/1.1 do.
//!
//! | Limit | Kept by |
//! |---|---|
//! | size of a head, number of requests at the same time, requests that the client cancels | hyper and h2, with the numbers below |
//! | time without a request: handshake, unfinished heads, no windows open | [`Requests::are_idle_for`] |
//! | time of a body | the middleware, as with HTTP/1.1 |
//! | time of an answer that the client does not read | [`Requests::have_stalled`]; a connection that takes no octet at all: `StallTimeout` |
//! | connections | their permits, as with HTTP/1.1 |

use super::heads::MAX_HEAD;
use crate::auth::connections::Permit;
use crate::middleware::Peer;
use axum::Router;
use axum::body::{Body, Bytes};
use axum::extract::Request;
use hyper::body::{Body as HttpBody, Frame, Incoming, SizeHint};
use hyper::server::conn::http2;
use hyper::service::service_fn;
use hyper_util::rt::{TokioExecutor, TokioIo, TokioTimer};
use std::collections::BTreeMap;
use std::convert::Infallible;
use std::net::IpAddr;
use std::pin::{Pin, pin};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::task::{Context, Poll, ready};
use std::time::{Duration, Instant};
use tokio::io::{AsyncRead, AsyncWrite};
use tokio::time::sleep;
use tower::ServiceExt;

/// What a client and this server agree on in the TLS handshake.
pub const PROTOCOL: &[u8] = b"h2";

/// The most requests of one connection at the same time, live streams included. chosen: RFC 9113 6.5.2 advises no fewer than 100.
const MAX_REQUESTS: u32 = 100;

/// The longest head, as RFC 9113 6.5.2 counts it: names, values and 32 octets for each header.
const MAX_HEADERS: u32 = MAX_HEAD as u32;

/// The most requests that a client has cancelled and that the server has not seen yet, before the connection ends (CVE-2023-44487).
const MAX_CANCELLED: usize = 20;

/// The most requests that break the protocol, before the connection ends. chosen.
const MAX_MALFORMED: usize = 128;

/// The octets of bodies that a client may send before the server has read them: of one request, and of the connection. A body for the API has
/// 64 KiB at most.
const REQUEST_WINDOW: u32 = 64 << 10;
const CONNECTION_WINDOW: u32 = 1 << 20;

/// The octets of one answer that wait in memory for the client.
const SEND_BUFFER: usize = 64 << 10;

/// An answer is handed out in pieces of this size at most, so that little of an answer that is not read waits in memory.
const PIECE: usize = 16 << 10;

/// The longest time between two checks of a connection.
const CHECK_PERIOD: Duration = Duration::from_secs(1);

/// The times of the limits of a server.
#[derive(Clone, Copy)]
pub struct Times {
    /// The longest time without a request, and for the answer to a ping.
    pub head: Duration,
    /// A connection ends when its client does not read for this time. A silent client gets a ping as often.
    pub stalled: Duration,
}

/// Serves one connection with `router` until it ends.
pub async fn serve(
    stream: impl AsyncRead + AsyncWrite + Unpin,
    router: &Router,
    peer: IpAddr,
    permit: &Arc<Permit>,
    Times { head, stalled }: Times,
) {
    let requests = Requests::new();
    let service = service_fn(|mut request: Request<Incoming>| {
        let running = requests.begin();
        request.extensions_mut().insert(Peer(peer));
        request.extensions_mut().insert(Arc::clone(permit));
        let router = router.clone();
        async move {
            let response = router.oneshot(request).await?;
            Ok::<_, Infallible>(response.map(|body| Answer { body, rest: Bytes::new(), has_begun: false, running }))
        }
    });
    let mut protocol = http2::Builder::new(TokioExecutor::new());
    protocol
        .timer(TokioTimer::new())
        .max_concurrent_streams(MAX_REQUESTS)
        .max_header_list_size(MAX_HEADERS)
        .max_pending_accept_reset_streams(MAX_CANCELLED)
        .max_local_error_reset_streams(MAX_MALFORMED)
        .initial_stream_window_size(REQUEST_WINDOW)
        .initial_connection_window_size(CONNECTION_WINDOW)
        .max_send_buf_size(SEND_BUFFER)
        // A client that has gone without a word ends its live streams too.
        .keep_alive_interval(stalled)
        .keep_alive_timeout(head);
    let mut connection = pin!(protocol.serve_connection(TokioIo::new(stream), service));
    let period = head.min(stalled).min(CHECK_PERIOD);
    let mut is_ending = false;
    loop {
        tokio::select! {
            // A client may disconnect at any time, which is no error.
            _ = connection.as_mut() => return,
            () = sleep(period) => {}
        }
        let is_idle = requests.are_idle_for(head);
        if requests.have_stalled(stalled) || (is_idle && is_ending) {
            return;
        }
        if is_idle {
            // The client learns which of its requests were not executed, and has the same time to end the connection.
            is_ending = true;
            requests.restart_idle_time();
            connection.as_mut().graceful_shutdown();
        }
    }
}

/// The requests of one connection whose answers have not ended.
#[derive(Clone)]
struct Requests(Arc<Mutex<State>>);

struct State {
    next: u64,
    running: usize,
    /// When `running` became zero, or the connection began.
    idle_since: Instant,
    /// Since when a piece of an answer waits for the client, by the number of the request.
    waiting: BTreeMap<u64, Instant>,
}

impl Requests {
    fn new() -> Self {
        let idle_since = Instant::now();
        Self(Arc::new(Mutex::new(State { next: 0, running: 0, idle_since, waiting: BTreeMap::new() })))
    }

    fn begin(&self) -> Running {
        let mut state = self.lock();
        let number = state.next;
        state.next = number.wrapping_add(1);
        state.running = state.running.saturating_add(1);
        Running { number, requests: self.clone() }
    }

    /// Whether there was no request for this time.
    fn are_idle_for(&self, time: Duration) -> bool {
        let state = self.lock();
        state.running == 0 && state.idle_since.elapsed() >= time
    }

    fn restart_idle_time(&self) {
        self.lock().idle_since = Instant::now();
    }

    /// Whether a piece of an answer waits for the client for this time.
    fn have_stalled(&self, time: Duration) -> bool {
        self.lock().waiting.values().any(|since| since.elapsed() >= time)
    }

    fn lock(&self) -> MutexGuard<'_, State> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

/// A request until its answer has ended or the client has cancelled it.
struct Running {
    number: u64,
    requests: Requests,
}

impl Running {
    fn piece_waits(&self) {
        self.requests.lock().waiting.insert(self.number, Instant::now());
    }

    fn piece_is_taken(&self) {
        self.requests.lock().waiting.remove(&self.number);
    }
}

impl Drop for Running {
    fn drop(&mut self) {
        let mut state = self.requests.lock();
        state.waiting.remove(&self.number);
        state.running = state.running.saturating_sub(1);
        state.idle_since = Instant::now();
    }
}

/// The body of an answer. hyper asks for the next piece when the client has permitted it to send the one before.
struct Answer {
    body: Body,
    /// What the body has given and hyper has not got.
    rest: Bytes,
    has_begun: bool,
    running: Running,
}

impl HttpBody for Answer {
    type Data = Bytes;
    type Error = axum::Error;

    fn poll_frame(self: Pin<&mut Self>, context: &mut Context<'_>) -> Poll<Option<Result<Frame<Bytes>, axum::Error>>> {
        let Self { body, rest, has_begun, running } = self.get_mut();
        *has_begun = true;
        running.piece_is_taken();
        if rest.is_empty() {
            match ready!(Pin::new(body).poll_frame(context)) {
                Some(Ok(frame)) => match frame.into_data() {
                    Ok(data) => *rest = data,
                    Err(trailers) => return Poll::Ready(Some(Ok(trailers))),
                },
                end => return Poll::Ready(end),
            }
        }
        running.piece_waits();
        let piece = rest.split_to(rest.len().min(PIECE));
        Poll::Ready(Some(Ok(Frame::data(piece))))
    }

    /// The end is told only by the next poll, after the last piece: until then the piece may wait for the client.
    fn is_end_stream(&self) -> bool {
        !self.has_begun && self.body.is_end_stream()
    }

    fn size_hint(&self) -> SizeHint {
        if self.has_begun { SizeHint::default() } else { self.body.size_hint() }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_connection_is_idle_without_requests_and_stalled_while_a_piece_waits() {
        let requests = Requests::new();
        let hour = Duration::from_secs(3600);
        assert!(requests.are_idle_for(Duration::ZERO) && !requests.are_idle_for(hour));
        let (one, other) = (requests.begin(), requests.begin());
        assert!(!requests.are_idle_for(Duration::ZERO) && !requests.have_stalled(Duration::ZERO));
        one.piece_waits();
        other.piece_waits();
        one.piece_is_taken();
        assert!(requests.have_stalled(Duration::ZERO) && !requests.have_stalled(hour));
        drop(other);
        assert!(!requests.have_stalled(Duration::ZERO), "a cancelled request waits for nothing");
        drop(one);
        assert!(requests.are_idle_for(Duration::ZERO));
    }

    #[test]
    fn an_answer_comes_in_pieces_and_waits_until_the_last_one_is_taken() {
        let requests = Requests::new();
        let octets: Vec<u8> = (0..PIECE * 2 + 5).map(|number| (number % 251) as u8).collect();
        let body = Body::from(octets.clone());
        let mut answer = Answer { body, rest: Bytes::new(), has_begun: false, running: requests.begin() };
        assert_eq!(answer.size_hint().exact(), Some(octets.len() as u64));
        let mut context = Context::from_waker(std::task::Waker::noop());
        let mut lengths = Vec::new();
        let mut all = Vec::new();
        while let Poll::Ready(Some(Ok(frame))) = Pin::new(&mut answer).poll_frame(&mut context) {
            let piece = frame.into_data().unwrap();
            assert!(!answer.is_end_stream() && requests.have_stalled(Duration::ZERO));
            lengths.push(piece.len());
            all.extend(piece);
        }
        assert_eq!((lengths, all), (vec![PIECE, PIECE, 5], octets));
        assert!(!requests.have_stalled(Duration::ZERO));
        let empty = Answer { body: Body::empty(), rest: Bytes::new(), has_begun: false, running: requests.begin() };
        assert!(empty.is_end_stream());
    }
}
