//! The heads of requests, checked before hyper reads them: at most [`MAX_HEAD`] octets, and CR LF at the end of each line.
//!
//! hyper accepts a line that ends with LF alone, as RFC 9112 2.2 permits. A proxy in front of the station may refuse such a line or see
//! no line end there, and then both do not agree where a request ends. hyper's limit of a head depends on the pieces in which it arrives.
//!
//! [`Heads`] stands between the connection and hyper:
//!
//! ```text
//! connection ─ Heads: collects a head, checks it ─ hyper: parses it ─ Framing::begin ─ service
//!                 ▲                                                      │
//!                 └────────────── length of the body ────────────────────┘
//! ```
//!
//! hyper gets a head only as a whole, and no octet of the next one. The service tells with [`Framing::begin`] which body hyper has found,
//! so Content-Length and Transfer-Encoding are interpreted once, and no octet of a body is taken for a head. A body in chunks has no
//! length that is known before; it is the last on its connection.

#[cfg(test)]
mod tests;

use crate::headers;
use crate::problem::Problem;
use axum::response::{IntoResponse, Response};
use hyper::body::Body;
use std::io::{self, Error, IoSlice};
use std::pin::Pin;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::task::{Context, Poll, ready};
use tokio::io::{AsyncRead, AsyncWrite, ReadBuf, copy, sink};

/// The longest head of a request, in octets: from the request line to the empty line after the headers, with CR and LF of each line. Empty
/// lines before the request line count too.
pub const MAX_HEAD: usize = 32 << 10;

/// The octets of one reading from the connection.
const CHUNK: usize = 4096;

/// The head that hyper reads in place of a refused one. The service answers it with the refusal, after the answers to earlier requests.
const STAND_IN: &[u8] = b"GET / HTTP/1.1\r\n\r\n";

/// Why a head is refused.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Refusal {
    /// A line ends with LF alone.
    BareLf,
    /// The head is longer than [`MAX_HEAD`].
    TooLong,
    /// hyper has found a request where this module sees none.
    Misplaced,
}

impl IntoResponse for Refusal {
    fn into_response(self) -> Response {
        let problem = match self {
            Self::BareLf => {
                Problem::bad_request("expected CR LF at the end of each line of the request's head, found LF alone")
            }
            Self::TooLong => Problem::head_too_large(MAX_HEAD),
            Self::Misplaced => Problem::bad_request("expected a request where the body of the one before ends"),
        };
        let mut response = problem.into_response();
        headers::add_to(response.headers_mut(), true);
        response
    }
}

/// The check of one head.
#[derive(Debug, Default)]
struct Head {
    /// Where the present line begins.
    line: usize,
    /// How many octets were checked.
    checked: usize,
    /// Whether the request line has come: empty lines before it do not end the head (RFC 9112 2.2).
    has_begun: bool,
}

impl Head {
    /// The length of the head at the beginning of `octets`, or `None` if more octets decide. `octets` grows from call to call. The result
    /// depends on the octets, and not on the pieces in which they arrive.
    fn check(&mut self, octets: &[u8]) -> Option<Result<usize, Refusal>> {
        let within = octets.get(..MAX_HEAD).unwrap_or(octets);
        while let Some(distance) = within[self.checked..].iter().position(|octet| *octet == b'\n') {
            let end = self.checked + distance;
            let Some(line) = within[self.line..end].strip_suffix(b"\r") else { return Some(Err(Refusal::BareLf)) };
            (self.line, self.checked) = (end + 1, end + 1);
            if line.is_empty() && self.has_begun {
                return Some(Ok(end + 1));
            }
            self.has_begun |= !line.is_empty();
        }
        self.checked = within.len();
        (octets.len() > MAX_HEAD).then_some(Err(Refusal::TooLong))
    }
}

/// What follows on a connection.
#[derive(Debug)]
struct Next {
    /// The octets that hyper may read now.
    left: u64,
    /// What comes behind them.
    then: Then,
}

#[derive(Debug)]
enum Then {
    /// A head.
    Head(Head),
    /// hyper has a whole head and must begin its request before it reads more. If the head is refused: why.
    Request(Option<Refusal>),
    /// Nothing: the connection ends.
    End,
}

/// Whether the connection can have another request.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Reuse {
    /// The body has a length.
    Possible,
    /// The body has chunks. Its answer must end the connection.
    Impossible,
}

/// Tells the [`Heads`] of a connection what hyper has found.
#[derive(Clone, Debug)]
pub struct Framing(Arc<Mutex<Next>>);

impl Framing {
    /// Begins a request with this body. Must be called before hyper reads on: when it calls the service.
    ///
    /// # Errors
    /// [`Refusal`]: the request is not to be executed, its answer is the refusal and must end the connection.
    pub fn begin(&self, body: &impl Body) -> Result<Reuse, Refusal> {
        let mut next = self.lock();
        let (left, then, begun) = match (&*next, body.size_hint().exact()) {
            (Next { left: 0, then: Then::Request(None) }, Some(length)) => {
                (length, Then::Head(Head::default()), Ok(Reuse::Possible))
            }
            (Next { left: 0, then: Then::Request(None) }, None) => (u64::MAX, Then::End, Ok(Reuse::Impossible)),
            (Next { left: 0, then: Then::Request(Some(refusal)) }, _) => (0, Then::End, Err(*refusal)),
            _ => (0, Then::End, Err(Refusal::Misplaced)),
        };
        *next = Next { left, then };
        begun
    }

    fn lock(&self) -> MutexGuard<'_, Next> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

/// A connection from which hyper reads only heads that were checked, and their bodies.
pub struct Heads<S> {
    stream: S,
    /// What has arrived and hyper has not read: at most a head and a [`CHUNK`].
    arrived: Vec<u8>,
    framing: Framing,
}

impl<S> Heads<S> {
    /// A connection whose first octets are a head.
    pub fn new(stream: S) -> Self {
        let next = Next { left: 0, then: Then::Head(Head::default()) };
        Self { stream, arrived: Vec::new(), framing: Framing(Arc::new(Mutex::new(next))) }
    }

    /// For the service that hyper calls.
    pub fn framing(&self) -> Framing {
        self.framing.clone()
    }
}

impl<S: AsyncRead + Unpin> Heads<S> {
    /// Reads and drops what the client still sends after its last answer, until it ends the connection. A connection that is closed with
    /// unread octets is reset, and the client may lose the answer (RFC 9112 9.6).
    pub async fn drain(&mut self) -> io::Result<()> {
        let has_ended_with_a_request = matches!(&*self.framing.lock(), Next { left: 0, then: Then::Head(_) });
        if !has_ended_with_a_request {
            copy(&mut self.stream, &mut sink()).await?;
        }
        Ok(())
    }
}

/// Reads from the connection. 0 octets are its end.
fn fill<S: AsyncRead + Unpin>(
    stream: &mut S,
    arrived: &mut Vec<u8>,
    context: &mut Context<'_>,
) -> Poll<io::Result<usize>> {
    let mut octets = [0; CHUNK];
    let mut chunk = ReadBuf::new(&mut octets);
    ready!(Pin::new(stream).poll_read(context, &mut chunk))?;
    arrived.extend_from_slice(chunk.filled());
    Poll::Ready(Ok(chunk.filled().len()))
}

impl<S: AsyncRead + Unpin> AsyncRead for Heads<S> {
    fn poll_read(self: Pin<&mut Self>, context: &mut Context<'_>, into: &mut ReadBuf<'_>) -> Poll<io::Result<()>> {
        let Self { stream, arrived, framing } = self.get_mut();
        let mut next = framing.lock();
        while next.left == 0 {
            let checked = match &mut next.then {
                Then::Head(head) => head.check(arrived),
                Then::Request(_) => return Poll::Ready(Err(Error::other("the head of a request has no end"))),
                // hyper reads to learn whether the client is still there, while it sends the last answer.
                Then::End => return Poll::Pending,
            };
            *next = match checked {
                Some(Ok(length)) => Next { left: length as u64, then: Then::Request(None) },
                Some(Err(refusal)) => {
                    *arrived = STAND_IN.to_vec();
                    Next { left: STAND_IN.len() as u64, then: Then::Request(Some(refusal)) }
                }
                None if ready!(fill(stream, arrived, context))? == 0 => return Poll::Ready(Ok(())),
                None => continue,
            };
        }
        if arrived.is_empty() && ready!(fill(stream, arrived, context))? == 0 {
            return Poll::Ready(Ok(()));
        }
        let left = usize::try_from(next.left).unwrap_or(usize::MAX);
        let count = left.min(arrived.len()).min(into.remaining());
        into.put_slice(&arrived[..count]);
        next.left -= count as u64;
        arrived.drain(..count);
        if arrived.is_empty() {
            // A live stream reads nothing for hours.
            *arrived = Vec::new();
        }
        Poll::Ready(Ok(()))
    }
}

impl<S: AsyncWrite + Unpin> AsyncWrite for Heads<S> {
    fn poll_write(mut self: Pin<&mut Self>, context: &mut Context<'_>, octets: &[u8]) -> Poll<io::Result<usize>> {
        Pin::new(&mut self.stream).poll_write(context, octets)
    }

    fn poll_write_vectored(
        mut self: Pin<&mut Self>,
        context: &mut Context<'_>,
        slices: &[IoSlice<'_>],
    ) -> Poll<io::Result<usize>> {
        Pin::new(&mut self.stream).poll_write_vectored(context, slices)
    }

    fn is_write_vectored(&self) -> bool {
        self.stream.is_write_vectored()
    }

    fn poll_flush(mut self: Pin<&mut Self>, context: &mut Context<'_>) -> Poll<io::Result<()>> {
        Pin::new(&mut self.stream).poll_flush(context)
    }

    fn poll_shutdown(mut self: Pin<&mut Self>, context: &mut Context<'_>) -> Poll<io::Result<()>> {
        Pin::new(&mut self.stream).poll_shutdown(context)
    }
}
