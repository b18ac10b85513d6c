//! The server of the metrics, and the look at the stream.

use super::{Metrics, StreamFigures};
use crate::config::Prometheus;
use async_nats::jetstream::Context;
use axum::body::Bytes;
use profivac_archive_protocol::nats::{STREAM, connect};
use profivac_recorder::Micros;
use profivac_web_server::exposition::Format;
use profivac_web_server::scrape::{self, Source};
use profivac_web_server::server::{Connections, Keys, Limits, ServerError};
use profivac_web_server::tables::archive::Nats;
use std::net::SocketAddr;
use std::sync::Arc;
use std::time::Duration;
use tokio::net::TcpListener;
use tokio::time::sleep;

/// Connections at the same time. chosen: some dozen servers, each with one or two connections.
const MAX_CONNECTIONS: usize = 128;

/// The longest time for the head of a request and for a TLS handshake, and that a client may not read its answer.
const CLIENT_TIMEOUT: Duration = Duration::from_secs(10);

/// The time between two readings of certificate and key.
const KEYS_PERIOD: Duration = Duration::from_secs(60);

/// The time between two looks at the stream. chosen: a usual interval of scrapes.
const STREAM_PERIOD: Duration = Duration::from_secs(15);

impl Source for Metrics {
    fn text(&self, format: Format) -> Bytes {
        Self::text(self, format).into()
    }
}

/// Checks certificate and key of `[prometheus.tls]`, without listening.
///
/// # Errors
/// [`ServerError`].
pub fn check(settings: &Prometheus) -> Result<(), ServerError> {
    settings.tls.clone().map(Keys::read).transpose()?;
    Ok(())
}

/// A server that has its address and does not serve yet.
pub struct Server {
    listener: TcpListener,
    address: SocketAddr,
    connections: Connections,
}

impl Server {
    /// Takes the address, and reads certificate and key.
    ///
    /// # Errors
    /// [`ServerError`].
    pub async fn bind(settings: &Prometheus, metrics: &Metrics) -> Result<Self, ServerError> {
        let keys = settings.tls.clone().map(Keys::read).transpose()?.map(Arc::new);
        let failed = |error| ServerError::Listen { address: settings.listen, error };
        let listener = TcpListener::bind(settings.listen).await.map_err(failed)?;
        let address = listener.local_addr().map_err(failed)?;
        let router = scrape::router(settings.listen, settings.token.clone(), Arc::new(metrics.clone()));
        let limits =
            Limits { connections: MAX_CONNECTIONS, head: CLIENT_TIMEOUT, stalled: CLIENT_TIMEOUT, ..Limits::default() };
        Ok(Self { listener, address, connections: Connections { router, keys, limits, observer: None } })
    }

    /// The address of the metrics as a URL, with the port that the system has chosen.
    #[must_use]
    pub fn url(&self) -> String {
        format!("{}://{}/metrics", if self.connections.keys.is_some() { "https" } else { "http" }, self.address)
    }

    /// Serves. Never returns.
    pub async fn run(self) {
        let Self { listener, connections, .. } = self;
        let keys = connections.keys.clone();
        let renew = async {
            loop {
                sleep(KEYS_PERIOD).await;
                // One that cannot be read leaves the former one in use.
                keys.as_deref().map(Keys::renew);
            }
        };
        tokio::join!(connections.serve(&listener), renew);
    }
}

/// Looks at the stream again and again, while the database is down too: then the stream fills. Never returns.
pub async fn stream(nats: &Nats, metrics: &Metrics) {
    loop {
        let Ok(jetstream) = connect(nats, "profivac archive metrics").await else {
            sleep(STREAM_PERIOD).await;
            continue;
        };
        while let Some(found) = look(&jetstream).await {
            metrics.waiting(Some(found));
            sleep(STREAM_PERIOD).await;
        }
        metrics.waiting(None);
        sleep(STREAM_PERIOD).await;
    }
}

/// What waits in the stream; `None` when the servers do not say.
async fn look(jetstream: &Context) -> Option<StreamFigures> {
    let stream = jetstream.get_stream(STREAM).await.ok()?;
    let info = stream.cached_info();
    let (state, limit) = (&info.state, info.config.max_bytes);
    let oldest = i64::try_from(state.first_timestamp.unix_timestamp_nanos() / 1_000).ok().map(Micros);
    let oldest = oldest.filter(|_| state.messages > 0);
    Some(StreamFigures { batches: state.messages, octets: state.bytes, limit, oldest })
}

#[cfg(test)]
mod tests {
    use super::*;
    use profivac_web_server::server::TlsFiles;

    #[test]
    fn an_absent_certificate_is_found_without_listening() {
        let tls = Some(TlsFiles { certificate: "absent.pem".into(), key: "absent.key".into() });
        let settings = Prometheus { listen: ([127, 0, 0, 1], 0).into(), token: None, tls };
        let error = check(&settings).unwrap_err().to_string();
        assert!(error.contains("absent.key"), "{error}");
        assert!(check(&Prometheus { tls: None, ..settings }).is_ok());
    }
}
