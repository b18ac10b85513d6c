//! One POST over HTTP or HTTPS. Redirects are not followed: a letter with a token goes where the file says and nowhere else.

use axum::body::Body;
use hyper::client::conn::http1;
use hyper::header::{AUTHORIZATION, CONTENT_TYPE, HOST, HeaderValue, USER_AGENT};
use hyper::{Method, Request, Uri};
use hyper_util::rt::TokioIo;
use std::sync::Arc;
use tokio::io::{AsyncRead, AsyncWrite};
use tokio::net::TcpStream;
use tokio_rustls::TlsConnector;
use tokio_rustls::rustls::pki_types::{CertificateDer, ServerName};
use tokio_rustls::rustls::{ClientConfig, RootCertStore, crypto};

/// Somebody who is posted to.
pub struct Client {
    url: Uri,
    token: Option<HeaderValue>,
    connector: TlsConnector,
}

impl Client {
    /// Posts to `url` with a token, and trusts whom the system trusts, and these.
    ///
    /// # Errors
    /// A sentence that says what cannot be.
    pub fn new(url: Uri, token: Option<&str>, trusted: Vec<CertificateDer<'static>>) -> Result<Self, String> {
        let mut roots = RootCertStore::empty();
        let system = rustls_native_certs::load_native_certs().certs;
        roots.add_parsable_certificates(system.into_iter().chain(trusted));
        let provider = Arc::new(crypto::ring::default_provider());
        let config = ClientConfig::builder_with_provider(provider).with_safe_default_protocol_versions();
        let config = config.map_err(|error| error.to_string())?.with_root_certificates(roots).with_no_client_auth();
        let bearer = token.map(|token| HeaderValue::from_str(&format!("Bearer {token}"))).transpose();
        let mut token = bearer.map_err(|_| "expected a token of visible ASCII".to_owned())?;
        if let Some(token) = &mut token {
            token.set_sensitive(true);
        }
        Ok(Self { url, token, connector: TlsConnector::from(Arc::new(config)) })
    }

    /// Posts, and gives the status of the answer. What follows the head of the answer is not read.
    ///
    /// # Errors
    /// A sentence that says why there is no answer.
    pub async fn post(&self, body: String) -> Result<u16, String> {
        let host = self.url.host().unwrap_or_default();
        let host = host.trim_start_matches('[').trim_end_matches(']');
        let is_secure = self.url.scheme_str() == Some("https");
        let port = self.url.port_u16().unwrap_or(if is_secure { 443 } else { 80 });
        let stream =
            TcpStream::connect((host, port)).await.map_err(|error| format!("it cannot be reached: {error}"))?;
        if !is_secure {
            return self.over(stream, body).await;
        }
        let name = ServerName::try_from(host.to_owned()).map_err(|error| format!("{host} is no host: {error}"))?;
        let stream = self.connector.connect(name, stream).await;
        self.over(stream.map_err(|error| format!("there is no secure connection: {error}"))?, body).await
    }

    async fn over(&self, stream: impl AsyncRead + AsyncWrite + Unpin, body: String) -> Result<u16, String> {
        let failed = |error: hyper::Error| format!("it does not answer: {error}");
        let request = self.request(body)?;
        let (mut sender, connection) = http1::handshake(TokioIo::new(stream)).await.map_err(failed)?;
        let answer = sender.send_request(request);
        tokio::pin!(answer);
        let answer = tokio::select! {
            answer = &mut answer => answer,
            // The answer may have come with the end.
            ended = connection => match ended {
                Ok(()) => answer.await,
                Err(error) => Err(error),
            },
        };
        Ok(answer.map_err(failed)?.status().as_u16())
    }

    fn request(&self, body: String) -> Result<Request<Body>, String> {
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
        request.body(Body::from(body)).map_err(|error| format!("there is no such request: {error}"))
    }
}
