//! One POST over HTTP or HTTPS. Redirects are not followed: a notification with a token goes to the configured URL and nowhere else.

use crate::client_tls::trusting;
use axum::body::Body;
use hyper::client::conn::http1;
use hyper::header::{AUTHORIZATION, CONTENT_TYPE, HOST, HeaderValue, USER_AGENT};
use hyper::http::header::InvalidHeaderValue;
use hyper::{Method, Request, Uri};
use hyper_util::rt::TokioIo;
use std::sync::Arc;
use tokio::io::{AsyncRead, AsyncWrite};
use tokio::net::TcpStream;
use tokio_rustls::TlsConnector;
use tokio_rustls::rustls;
use tokio_rustls::rustls::pki_types::{CertificateDer, InvalidDnsNameError, ServerName};

/// The reason why a client cannot be made.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum ClientSetupError {
    /// The token is no header value.
    #[error("expected a token of visible ASCII")]
    Token(#[source] InvalidHeaderValue),
    /// The TLS library offers no protocol version.
    #[error(transparent)]
    Tls(#[from] rustls::Error),
}

/// The reason why a POST got no answer.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum PostError {
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
}

/// An HTTP client for one URL.
pub struct Client {
    url: Uri,
    token: Option<HeaderValue>,
    connector: TlsConnector,
}

impl Client {
    /// A client that posts to `url` with a token. It trusts the certificates of the system and those in `trusted`.
    ///
    /// # Errors
    /// [`ClientSetupError`] when the token is no header value.
    pub fn new(url: Uri, token: Option<&str>, trusted: Vec<CertificateDer<'static>>) -> Result<Self, ClientSetupError> {
        let config = trusting(trusted)?.with_no_client_auth();
        let bearer = token.map(|token| HeaderValue::from_str(&format!("Bearer {token}"))).transpose();
        let mut token = bearer.map_err(ClientSetupError::Token)?;
        if let Some(token) = &mut token {
            token.set_sensitive(true);
        }
        Ok(Self { url, token, connector: TlsConnector::from(Arc::new(config)) })
    }

    /// Posts a body and returns the status of the answer. The body of the answer is not read.
    ///
    /// # Errors
    /// [`PostError`] says why there is no answer.
    pub async fn post(&self, body: String) -> Result<u16, PostError> {
        let host = self.url.host().unwrap_or_default();
        let host = host.trim_start_matches('[').trim_end_matches(']');
        let is_secure = self.url.scheme_str() == Some("https");
        let port = self.url.port_u16().unwrap_or(if is_secure { 443 } else { 80 });
        let stream = TcpStream::connect((host, port)).await.map_err(PostError::Connect)?;
        if !is_secure {
            return self.exchange(stream, body).await;
        }
        let name = ServerName::try_from(host.to_owned());
        let name = name.map_err(|error| PostError::HostName { host: host.to_owned(), error })?;
        let stream = self.connector.connect(name, stream).await.map_err(PostError::Tls)?;
        self.exchange(stream, body).await
    }

    async fn exchange(&self, stream: impl AsyncRead + AsyncWrite + Unpin, body: String) -> Result<u16, PostError> {
        let request = self.request(body).map_err(PostError::Request)?;
        let (mut sender, connection) = http1::handshake(TokioIo::new(stream)).await.map_err(PostError::Answer)?;
        let answer = sender.send_request(request);
        tokio::pin!(answer);
        let answer = tokio::select! {
            answer = &mut answer => answer,
            // The answer may have arrived together with the end of the connection.
            ended = connection => match ended {
                Ok(()) => answer.await,
                Err(error) => Err(error),
            },
        };
        Ok(answer.map_err(PostError::Answer)?.status().as_u16())
    }

    fn request(&self, body: String) -> Result<Request<Body>, hyper::http::Error> {
        let path = self.url.path_and_query().map_or("/", |path| path.as_str());
        let host = self.url.authority().map_or("", |authority| authority.as_str());
        let mut request = Request::builder()
            .method(Method::POST)
            .uri(path)
            .header(HOST, host)
            .header(USER_AGENT, concat!("profivac/", env!("CARGO_PKG_VERSION")))
            .header(CONTENT_TYPE, "application/json");
        if let Some(token) = &self.token {
            request = request.header(AUTHORIZATION, token);
        }
        request.body(Body::from(body))
    }
}
