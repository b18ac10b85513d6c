//! The client of an archive without NATS: one batch, one POST, and its answer after the commit; polls for requests of users, and replies.

use axum::body::{Body, Bytes, to_bytes};
use hyper::client::conn::http1::{self, SendRequest};
use hyper::header::{AUTHORIZATION, CONTENT_TYPE, HOST, HeaderValue, USER_AGENT};
use hyper::{Method, Request, Response, StatusCode, Uri, body};
use hyper_util::rt::TokioIo;
use profivac_archive_protocol::request::{MAX_OCTETS as MAX_REQUEST, REQUEST_HEADER, STATUS_HEADER, Status};
use profivac_recorder::outbox::Waiting;
use profivac_station::config::gateways::archive::Https;
use profivac_web_server::auth::secret::RandomSecret;
use profivac_web_server::client_tls::{fault, is_of_another_name, trusting};
use profivac_web_server::tables::ca_certificates;
use std::sync::Arc;
use std::time::Duration;
use thiserror::Error;
use tokio::io::{AsyncRead, AsyncWrite};
use tokio::net::TcpStream;
use tokio::time::timeout;
use tokio_rustls::TlsConnector;
use tokio_rustls::rustls::pki_types::ServerName;

/// The longest wait for a connection.
const CONNECT_TIMEOUT: Duration = Duration::from_secs(20);

/// The longest wait for the answer: longer than the archive waits for its database.
const ANSWER_TIMEOUT: Duration = Duration::from_secs(120);

/// The longest wait for a request of a user: longer than the archive waits for one.
const REQUEST_TIMEOUT: Duration = Duration::from_secs(40);

/// The longest reason of a refusal that is shown.
const LONGEST_REASON: usize = 400;

/// Why the archive did not take a batch or a reply, or gave no request.
#[derive(Debug, Error)]
#[error("{archive}: {reason}")]
pub struct PostError {
    /// Scheme and host of the archive.
    pub archive: String,
    /// What failed.
    pub reason: String,
}

/// The path of a batch.
pub fn path(plant: &str, station: &str, epoch: i64, number: i64) -> String {
    format!("/v1/{plant}/{station}/{epoch}/{number}")
}

/// The path of the requests to a station.
fn requests_path(plant: &str, station: &str) -> String {
    format!("/v1/{plant}/{station}/request")
}

/// A message to the archive.
struct Outgoing {
    method: Method,
    path: String,
    payload: Bytes,
    content: &'static str,
    /// The longest wait for the answer.
    wait: Duration,
}

/// A client of one archive, with a connection that stays open.
pub struct Poster {
    origin: String,
    url: Uri,
    token: HeaderValue,
    connector: TlsConnector,
    connection: Option<SendRequest<Body>>,
}

impl Poster {
    /// A client of the archive at `url` that has not connected yet.
    ///
    /// # Errors
    /// [`PostError`] when the certificates cannot be read.
    pub fn new(https: &Https, url: &Uri) -> Result<Self, PostError> {
        let host = url.authority().map_or("", |authority| authority.as_str());
        let origin = format!("{}://{host}", url.scheme_str().unwrap_or_default());
        let failed = |error: &dyn std::fmt::Display| PostError { archive: origin.clone(), reason: error.to_string() };
        let trusted = https.ca_file.as_deref().map(ca_certificates).transpose().map_err(|error| failed(&error))?;
        let config = trusting(trusted.unwrap_or_default()).map_err(|error| failed(&error))?.with_no_client_auth();
        let token = HeaderValue::from_str(&format!("Bearer {}", https.token.reveal()));
        let mut token = token.map_err(|error| failed(&error))?;
        token.set_sensitive(true);
        let connector = TlsConnector::from(Arc::new(config));
        Ok(Self { origin, url: url.clone(), token, connector, connection: None })
    }

    /// Where it sends.
    pub fn origin(&self) -> &str {
        &self.origin
    }

    /// Sends a batch. `Ok` means that the archive has committed it; it may say what it has of the station.
    ///
    /// # Errors
    /// [`PostError`]; the batch may be stored nevertheless, and sending it again changes nothing.
    pub async fn post(&mut self, plant: &str, station: &str, batch: Waiting) -> Result<Option<Status>, PostError> {
        let (path, payload) = (path(plant, station, batch.epoch, batch.number), Bytes::from(batch.payload));
        let content = "application/octet-stream";
        let answer =
            self.exchange(Outgoing { method: Method::POST, path, payload, content, wait: ANSWER_TIMEOUT }).await?;
        let status = answer.headers().get(STATUS_HEADER);
        // A later archive may send a status that this program does not understand.
        let status = status.and_then(|status| serde_json::from_slice(status.as_bytes()).ok());
        self.evaluate(answer).await.map(|()| status)
    }

    /// The id and the octets of the next request to a station; `None` if there was none for some seconds.
    ///
    /// # Errors
    /// [`PostError`].
    pub async fn poll(&mut self, plant: &str, station: &str) -> Result<Option<(RandomSecret, Bytes)>, PostError> {
        let (path, payload) = (requests_path(plant, station), Bytes::new());
        let get = Outgoing { method: Method::GET, path, payload, content: "application/json", wait: REQUEST_TIMEOUT };
        let answer = self.exchange(get).await?;
        if answer.status() != StatusCode::OK {
            return self.evaluate(answer).await.map(|()| None);
        }
        let id = answer.headers().get(REQUEST_HEADER).and_then(|id| RandomSecret::parse(id.to_str().ok()?));
        let body = timeout(CONNECT_TIMEOUT, to_bytes(Body::new(answer.into_body()), MAX_REQUEST)).await;
        match (id, body) {
            (Some(id), Ok(Ok(body))) => Ok(Some((id, body))),
            _ => {
                self.connection = None;
                let expected = format!("expected a request of at most {MAX_REQUEST} octets with its id");
                Err(self.failed(format!("{expected}, found another answer: check url in [archive.https]")))
            }
        }
    }

    /// Sends the reply to a request.
    ///
    /// # Errors
    /// [`PostError`], also when no user waits for it any more.
    pub async fn reply(
        &mut self,
        plant: &str,
        station: &str,
        id: &RandomSecret,
        payload: Vec<u8>,
    ) -> Result<(), PostError> {
        let path = format!("{}/{}", requests_path(plant, station), id.reveal());
        let (payload, content) = (payload.into(), "application/json");
        let answer =
            self.exchange(Outgoing { method: Method::POST, path, payload, content, wait: REQUEST_TIMEOUT }).await?;
        self.evaluate(answer).await
    }

    /// One request and the head of its answer.
    async fn exchange(&mut self, request: Outgoing) -> Result<Response<body::Incoming>, PostError> {
        // The archive may have closed an idle connection in this moment: a new one decides.
        if let Some(connection) = self.connection.take().filter(|connection| !connection.is_closed())
            && let Ok(answer) = self.send(connection, &request).await
        {
            return Ok(answer);
        }
        let connection = timeout(CONNECT_TIMEOUT, self.connect()).await;
        let connection = connection.unwrap_or_else(|_| Err("no connection within 20 s".to_owned()));
        let connection = connection.map_err(|reason| self.failed(reason))?;
        self.send(connection, &request).await.map_err(|reason| self.failed(reason))
    }

    fn failed(&self, reason: String) -> PostError {
        PostError { archive: self.origin.clone(), reason }
    }

    async fn connect(&self) -> Result<SendRequest<Body>, String> {
        let url = &self.url;
        let host = url.host().unwrap_or_default().trim_start_matches('[').trim_end_matches(']');
        let is_secure = url.scheme_str() == Some("https");
        let port = url.port_u16().unwrap_or(if is_secure { 443 } else { 80 });
        let stream =
            TcpStream::connect((host, port)).await.map_err(|error| format!("it cannot be reached: {error}"))?;
        if !is_secure {
            return handshake(stream).await;
        }
        let name = ServerName::try_from(host.to_owned()).map_err(|error| format!("{host} is no host name: {error}"))?;
        let stream = self.connector.connect(name, stream).await;
        handshake(stream.map_err(|error| insecure(&error))?).await
    }

    /// Sends one request and keeps the connection for the next one.
    async fn send(
        &mut self,
        mut connection: SendRequest<Body>,
        outgoing: &Outgoing,
    ) -> Result<Response<body::Incoming>, String> {
        let host = self.url.authority().map_or("", |authority| authority.as_str());
        let request = Request::builder()
            .method(outgoing.method.clone())
            .uri(&outgoing.path)
            .header(HOST, host)
            .header(USER_AGENT, concat!("profivac/", env!("CARGO_PKG_VERSION")))
            .header(CONTENT_TYPE, outgoing.content)
            .header(AUTHORIZATION, self.token.clone())
            .body(Body::from(outgoing.payload.clone()))
            .map_err(|error| format!("the request cannot be made: {error}"))?;
        let answer = async {
            connection.ready().await?;
            connection.send_request(request).await
        };
        let late = |_| format!("no answer within {} s", outgoing.wait.as_secs());
        let answer = timeout(outgoing.wait, answer).await.map_err(late)?;
        let answer = answer.map_err(|error| format!("it does not answer: {error}"))?;
        self.connection = Some(connection);
        Ok(answer)
    }

    /// The meaning of an answer. The text of a refusal is that of the archive, without characters that are invisible.
    async fn evaluate(&mut self, answer: Response<body::Incoming>) -> Result<(), PostError> {
        let status = answer.status();
        if status == StatusCode::NO_CONTENT {
            return Ok(());
        }
        self.connection = None;
        let text = timeout(CONNECT_TIMEOUT, to_bytes(Body::new(answer.into_body()), LONGEST_REASON)).await;
        let text = text.ok().and_then(Result::ok).unwrap_or_default();
        let is_visible = |it: &char| it.is_ascii_graphic() || *it == ' ';
        let text: String = String::from_utf8_lossy(&text).chars().filter(is_visible).collect();
        let reason = match text.is_empty() {
            true => format!("expected the answer 204 of an archive, found {status}: check url in [archive.https]"),
            false if matches!(status, StatusCode::NOT_FOUND | StatusCode::METHOD_NOT_ALLOWED) => {
                format!("expected the answer 204 of an archive, found {status}: {text}: check url in [archive.https]")
            }
            false => format!("it refuses ({status}): {text}"),
        };
        Err(self.failed(reason))
    }
}

/// Why there is no TLS, with what to do.
fn insecure(error: &std::io::Error) -> String {
    let advice = match fault(error).is_some_and(is_of_another_name) {
        true => "write a name of the certificate into url of [archive.https]",
        false => "name a file with the certificate of its issuer in ca-file of [archive.https]",
    };
    format!("there is no secure connection: {error}; {advice}")
}

async fn handshake(stream: impl AsyncRead + AsyncWrite + Unpin + Send + 'static) -> Result<SendRequest<Body>, String> {
    let made = http1::handshake(TokioIo::new(stream)).await;
    let (sender, connection) = made.map_err(|error| format!("it does not answer: {error}"))?;
    // The connection ends when the sender is dropped.
    drop(tokio::spawn(connection));
    Ok(sender)
}

#[cfg(test)]
mod tests {
    use super::*;
    use profivac_archive::config::{self, Sender};
    use profivac_archive::https::{Job, Server};
    use profivac_archive::metrics::Metrics;
    use profivac_archive::pending::{Pending, PendingError};
    use profivac_archive_protocol::request::Missing;
    use profivac_web_server::tables::Secret;
    use std::collections::BTreeMap;
    use std::sync::{Mutex, PoisonError};

    fn secret(text: &str) -> Secret {
        toml::from_str::<BTreeMap<String, Secret>>(&format!("a = \"{text}\"")).unwrap().remove("a").unwrap()
    }

    /// Starts an archive that notes the ids of batches and commits those that are even. Returns a client with a token.
    async fn archive(ids: Arc<Mutex<Vec<String>>>, token: &str) -> (Poster, Pending) {
        let sender = Sender { plant: "hall".to_owned(), name: "hall-1".to_owned(), token: secret("right") };
        let https = config::Https { listen: "127.0.0.1:0".parse().unwrap(), tls: None, stations: vec![sender] };
        let server = Server::bind(&https, &Metrics::default()).await.unwrap();
        let pending = server.pending();
        let url: Uri = server.url().parse().unwrap();
        drop(tokio::spawn(server.serve_with(move |Job { message, committed }| {
            let number = message.payload.first().copied().unwrap_or_default();
            let is_even = number % 2 == 0;
            ids.lock().unwrap_or_else(PoisonError::into_inner).push(message.id);
            if is_even {
                // It lacks the batches before the last one of the test.
                let missing = Missing { epoch: 5, first: 5, last: 7 };
                let status = Status { epoch: 5, stored: 4, missing: vec![missing], ..Status::default() };
                committed.send((number > 7).then_some(status)).ok();
            }
        })));
        (poster(url, token), pending)
    }

    fn poster(url: Uri, token: &str) -> Poster {
        let https = Https { url: url.clone(), request_urls: Vec::new(), token: secret(token), ca_file: None };
        Poster::new(&https, &url).unwrap()
    }

    fn batch(number: i64) -> Waiting {
        Waiting { epoch: 5, number, payload: vec![u8::try_from(number).unwrap()] }
    }

    #[tokio::test]
    async fn a_batch_is_sent_with_its_numbers_until_it_is_committed() {
        let ids = Arc::<Mutex<Vec<String>>>::default();
        let (mut poster, _pending) = archive(Arc::clone(&ids), "right").await;
        assert_eq!(poster.post("hall", "hall-1", batch(2)).await.unwrap(), None);
        assert_eq!(poster.post("hall", "hall-1", batch(4)).await.unwrap(), None);
        let refused = poster.post("hall", "hall-1", batch(7)).await.unwrap_err().to_string();
        assert!(
            refused.contains("503") && refused.contains("the database of the archive does not answer"),
            "{refused}"
        );
        let missing = vec![Missing { epoch: 5, first: 5, last: 7 }];
        let status = poster.post("hall", "hall-1", batch(8)).await.unwrap();
        assert_eq!(status, Some(Status { epoch: 5, stored: 4, missing, ..Status::default() }));
        assert_eq!(*ids.lock().unwrap(), ["hall-1/5/2", "hall-1/5/4", "hall-1/5/7", "hall-1/5/8"]);
    }

    #[tokio::test]
    async fn a_refusal_says_why_and_never_shows_the_token() {
        let (mut poster, _pending) = archive(Arc::default(), "wrong").await;
        let refused = poster.post("hall", "hall-1", batch(2)).await.unwrap_err().to_string();
        assert!(refused.contains("401") && refused.contains("compare token-file at both ends"), "{refused}");
        assert!(!refused.contains("wrong"), "{refused}");
    }

    #[tokio::test]
    async fn a_request_of_a_user_reaches_the_station_that_polls_and_its_reply_comes_back() {
        let (mut poster, pending) = archive(Arc::default(), "right").await;
        let station = async {
            // The user asks when the poll waits, or before: the archive keeps the request for the next poll.
            let (id, body) = poster.poll("hall", "hall-1").await.unwrap().unwrap();
            poster.reply("hall", "hall-1", &id, [b"reply to ", &body[..]].concat()).await.unwrap();
            let again = poster.reply("hall", "hall-1", &id, b"again".to_vec()).await.unwrap_err().to_string();
            assert!(again.contains("410") && again.contains("no user waits for this reply"), "{again}");
        };
        let user = async {
            loop {
                match pending.ask("hall", "hall-1", b"one".to_vec()).await {
                    Err(PendingError::NotConnected) => tokio::task::yield_now().await,
                    answer => return answer,
                }
            }
        };
        let ((), answer) = tokio::join!(station, user);
        assert_eq!(answer, Ok(b"reply to one".to_vec()));
    }

    #[tokio::test]
    async fn a_poll_without_the_token_gets_the_reason() {
        let (mut poster, _pending) = archive(Arc::default(), "wrong").await;
        let refused = poster.poll("hall", "hall-1").await.unwrap_err().to_string();
        assert!(refused.contains("401") && refused.contains("compare token-file at both ends"), "{refused}");
    }

    #[tokio::test]
    async fn a_server_that_is_no_archive_names_the_url() {
        use tokio::io::{AsyncReadExt, AsyncWriteExt};
        let listener = tokio::net::TcpListener::bind(("127.0.0.1", 0)).await.unwrap();
        let url = format!("http://{}", listener.local_addr().unwrap()).parse().unwrap();
        let mut poster = poster(url, "right");
        let server = async {
            let (mut stream, _) = listener.accept().await.unwrap();
            stream.read_u8().await.unwrap();
            stream.write_all(b"HTTP/1.1 404 Not Found\r\ncontent-length: 7\r\n\r\nno page").await.unwrap();
            stream
        };
        let (refused, _stream) = tokio::join!(poster.post("hall", "hall-1", batch(2)), server);
        let refused = refused.unwrap_err().to_string();
        assert!(refused.ends_with("found 404 Not Found: no page: check url in [archive.https]"), "{refused}");
    }

    #[test]
    fn a_certificate_of_another_name_is_not_one_of_an_unknown_issuer() {
        use tokio_rustls::rustls::{CertificateError, Error};
        let of = |error| insecure(&std::io::Error::other(Error::InvalidCertificate(error)));
        assert!(
            of(CertificateError::NotValidForName)
                .ends_with("write a name of the certificate into url of [archive.https]")
        );
        assert!(of(CertificateError::UnknownIssuer).ends_with("in ca-file of [archive.https]"));
    }
}
