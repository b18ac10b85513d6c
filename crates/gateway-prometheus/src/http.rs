//! The server: `/metrics` over HTTP, with TLS and a bearer token beyond loopback.

use crate::metrics::{Layout, Others};
use axum::Router;
use axum::body::Bytes;
use profivac_gateway::Snapshot;
use profivac_gateway::thread::Context;
use profivac_station::config::gateways::prometheus::Settings;
use profivac_station::gateway_status::GatewayStatus;
use profivac_web_server::exposition::Format;
use profivac_web_server::scrape::{self, Source};
use profivac_web_server::server::{Connections, Keys, Limits, TlsError};
use std::net::SocketAddr;
use std::sync::{Arc, Mutex, PoisonError};
use std::time::Duration;
use tokio::net::TcpListener;
use tokio::time::{MissedTickBehavior, interval};

/// Connections at the same time. chosen: some dozen servers, each with one or two connections.
const MAX_CONNECTIONS: usize = 128;

/// The longest time for the head of a request and for a TLS handshake, and that a client may not read its answer.
const CLIENT_TIMEOUT: Duration = Duration::from_secs(10);

/// The time between two readings of certificate and key.
const KEYS_PERIOD: Duration = Duration::from_secs(60);

/// The reason why the gateway does not serve.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum PrometheusError {
    /// The address cannot be used.
    #[error("cannot listen on {address}: {error}")]
    Listen {
        /// The address.
        address: SocketAddr,
        /// The error of the operating system.
        error: std::io::Error,
    },
    /// Certificate or key cannot be used.
    #[error(transparent)]
    Tls(#[from] TlsError),
}

/// Serves until the gateway is to end.
pub async fn serve(settings: Settings, context: Context) -> Result<(), PrometheusError> {
    let router = router(&settings, context.clone());
    let Settings { listen: address, tls, .. } = settings;
    let keys = tls.map(Keys::read).transpose()?.map(Arc::new);
    let listener = TcpListener::bind(address).await.map_err(|error| PrometheusError::Listen { address, error })?;
    context.status.runs(listener.local_addr().unwrap_or(address).to_string());
    let mut stop = context.stop.clone();
    let status = Arc::clone(&context.status);
    let connections = Connections {
        observer: Some(Arc::<GatewayStatus>::clone(&status)),
        keys: keys.clone(),
        limits: Limits {
            connections: MAX_CONNECTIONS,
            head: CLIENT_TIMEOUT,
            stalled: CLIENT_TIMEOUT,
            ..Limits::default()
        },
        router,
    };
    tokio::select! {
        () = connections.serve(&listener) => {}
        () = renew(keys, &status) => {}
        () = stop.stopped() => {}
    }
    Ok(())
}

/// Reads certificate and key again and again, because certificates are renewed while the station runs. Never returns.
async fn renew(keys: Option<Arc<Keys>>, status: &GatewayStatus) {
    let Some(keys) = keys else { return std::future::pending().await };
    let mut ticks = interval(KEYS_PERIOD);
    ticks.set_missed_tick_behavior(MissedTickBehavior::Delay);
    loop {
        ticks.tick().await;
        if let Err(error) = keys.renew() {
            status.error(&format!("{error}; the gateway keeps the present certificate"));
        }
    }
}

/// What answers the requests of the connections.
pub fn router(settings: &Settings, context: Context) -> Router {
    let scrapes = Scrapes { latest: Mutex::default(), context };
    scrape::router(settings.listen, settings.token.clone(), Arc::new(scrapes))
}

/// What all scrapes share.
struct Scrapes {
    context: Context,
    latest: Mutex<Latest>,
}

/// The texts of the latest snapshot that was asked for: all scrapes of a snapshot get the same.
#[derive(Default)]
struct Latest {
    snapshot: Arc<Snapshot>,
    layout: Option<Layout>,
    texts: [Option<Bytes>; 2],
}

impl Source for Scrapes {
    /// The text of the present snapshot.
    fn text(&self, format: Format) -> Bytes {
        let snapshot = self.context.model.snapshot();
        let mut latest = self.latest.lock().unwrap_or_else(PoisonError::into_inner);
        if !Arc::ptr_eq(&latest.snapshot, &snapshot) {
            latest.snapshot = snapshot;
            latest.texts = [None, None];
        }
        let Latest { snapshot, layout, texts: [open_metrics, prometheus] } = &mut *latest;
        let text = match format {
            Format::OpenMetrics => open_metrics,
            Format::Prometheus => prometheus,
        };
        let make = || {
            let fitting = layout.take().filter(|layout| layout.fits(snapshot));
            let layout = layout.insert(fitting.unwrap_or_else(|| Layout::of(&snapshot.points)));
            Bytes::from(layout.text(snapshot, &self.others(), format))
        };
        let text = text.get_or_insert_with(make).clone();
        drop(latest);
        self.context.status.sent(1);
        text
    }

    fn refused(&self, reason: &'static str) {
        self.context.status.refused(reason);
    }
}

impl Scrapes {
    fn others(&self) -> Others {
        let services = &self.context.services;
        Others {
            station: services.name().to_owned(),
            recorder: services.station().recorder,
            buses: services.snapshots().buses().reports(),
            gateways: services.gateways().views(),
        }
    }
}
