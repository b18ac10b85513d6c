//! One POST over HTTP or HTTPS.

use axum::body::Body;
use hyper::header::{AUTHORIZATION, CONTENT_TYPE, HeaderValue};
use hyper::http::header::InvalidHeaderValue;
use hyper::{Method, Request, Uri};
use profivac_web_server::client_tls::trusting;
use profivac_web_server::http_client::{AnswerBody, RequestError, host_of, port_of, send};
use std::sync::Arc;
use tokio::net::TcpStream;
use tokio_rustls::TlsConnector;
use tokio_rustls::rustls;
use tokio_rustls::rustls::pki_types::CertificateDer;

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
    /// [`RequestError`] says why there is no answer.
    pub async fn post(&self, body: String) -> Result<u16, RequestError> {
        let connected = TcpStream::connect((host_of(&self.url), port_of(&self.url))).await;
        let stream = connected.map_err(RequestError::Connect)?;
        let request = self.request(body).map_err(RequestError::Request)?;
        Ok(send(&self.connector, stream, &self.url, request, AnswerBody::Ignored).await?.status)
    }

    fn request(&self, body: String) -> Result<Request<Body>, hyper::http::Error> {
        let mut request = Request::builder().method(Method::POST).header(CONTENT_TYPE, "application/json");
        if let Some(token) = &self.token {
            request = request.header(AUTHORIZATION, token);
        }
        request.body(Body::from(body))
    }
}
