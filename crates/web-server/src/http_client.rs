//! One HTTP or HTTPS request to a server of others. Redirects are not followed: what is sent goes to this URL and nowhere else.

use axum::body::{Body, Bytes, to_bytes};
use hyper::client::conn::http1;
use hyper::header::{HOST, HeaderValue, USER_AGENT};
use hyper::{Request, Uri};
use hyper_util::rt::TokioIo;
use tokio::io::{AsyncRead, AsyncWrite};
use tokio::net::TcpStream;
use tokio_rustls::TlsConnector;
use tokio_rustls::rustls::pki_types::{InvalidDnsNameError, ServerName};

/// The reason why a request got no answer.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum RequestError {
    /// No TCP connection.
    #[error("it cannot be reached: {0}")]
    Connect(std::io::Error),
    /// The host of the URL is no host name.
    #[error("{host} is no host name: {error}")]
    HostName {
        /// The host.
        host: String,
        /// The reason.
        error: InvalidDnsNameError,
    },
    /// No TLS connection.
    #[error("there is no secure connection: {0}")]
    Tls(std::io::Error),
    /// The URL makes no HTTP request.
    #[error("the request cannot be made: {0}")]
    Request(hyper::http::Error),
    /// The connection ended before the answer.
    #[error("it does not answer: {0}")]
    Answer(hyper::Error),
    /// The body of the answer is too long, or ends early.
    #[error("its answer cannot be read (at most {max} octets): {error}")]
    Body {
        /// The most octets.
        max: usize,
        /// The reason.
        error: axum::Error,
    },
}

/// How much of the body of an answer is read.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum AnswerBody {
    /// Nothing.
    Ignored,
    /// All of it; more octets than this are an error.
    UpTo(usize),
}

/// An answer.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Answer {
    /// The HTTP status.
    pub status: u16,
    /// The body, empty if it was ignored.
    pub body: Bytes,
}

/// The host of a URL, an IPv6 address without its brackets.
#[must_use]
pub fn host_of(url: &Uri) -> &str {
    url.host().unwrap_or_default().trim_start_matches('[').trim_end_matches(']')
}

/// The port of a URL.
#[must_use]
pub fn port_of(url: &Uri) -> u16 {
    url.port_u16().unwrap_or(if is_secure(url) { 443 } else { 80 })
}

fn is_secure(url: &Uri) -> bool {
    url.scheme_str() == Some("https")
}

/// Sends `request` over a connection to the host of `url`, with the path, the host and the user agent that it needs.
///
/// # Errors
/// [`RequestError`].
pub async fn send(
    connector: &TlsConnector,
    stream: TcpStream,
    url: &Uri,
    request: Request<Body>,
    body: AnswerBody,
) -> Result<Answer, RequestError> {
    let request = addressed(request, url)?;
    if !is_secure(url) {
        return exchange(stream, request, body).await;
    }
    let host = host_of(url);
    let name = ServerName::try_from(host.to_owned());
    let name = name.map_err(|error| RequestError::HostName { host: host.to_owned(), error })?;
    let stream = connector.connect(name, stream).await.map_err(RequestError::Tls)?;
    exchange(stream, request, body).await
}

fn addressed(mut request: Request<Body>, url: &Uri) -> Result<Request<Body>, RequestError> {
    let failed = |error: hyper::http::Error| RequestError::Request(error);
    let path = url.path_and_query().map_or("/", |path| path.as_str());
    *request.uri_mut() = path.parse().map_err(|error| failed(hyper::http::Error::from(error)))?;
    let host = url.authority().map_or("", |authority| authority.as_str());
    let host = HeaderValue::from_str(host).map_err(|error| failed(error.into()))?;
    request.headers_mut().insert(HOST, host);
    let agent = HeaderValue::from_static(concat!("profivac/", env!("CARGO_PKG_VERSION")));
    request.headers_mut().insert(USER_AGENT, agent);
    Ok(request)
}

async fn exchange(
    stream: impl AsyncRead + AsyncWrite + Unpin,
    request: Request<Body>,
    body: AnswerBody,
) -> Result<Answer, RequestError> {
    let (mut sender, connection) = http1::handshake(TokioIo::new(stream)).await.map_err(RequestError::Answer)?;
    let answer = async {
        let (head, rest) = sender.send_request(request).await.map_err(RequestError::Answer)?.into_parts();
        let body = match body {
            AnswerBody::Ignored => Bytes::new(),
            AnswerBody::UpTo(max) => {
                to_bytes(Body::new(rest), max).await.map_err(|error| RequestError::Body { max, error })?
            }
        };
        Ok(Answer { status: head.status.as_u16(), body })
    };
    tokio::pin!(answer);
    tokio::select! {
        answer = &mut answer => answer,
        // The answer may have arrived together with the end of the connection.
        ended = connection => match ended {
            Ok(()) => answer.await,
            Err(error) => Err(RequestError::Answer(error)),
        },
    }
}
