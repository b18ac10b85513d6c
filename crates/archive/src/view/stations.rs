//! Requests to the stations, over NATS.

use crate::nats::{NatsError, connect};
use crate::request::{Reply, Request, subject};
use async_nats::{Client, RequestErrorKind};
use profivac_station::api::Problem;
use profivac_station::config::gateways::archive::Nats;
use std::sync::Arc;
use tokio::sync::OnceCell;

/// Why a station has not answered.
#[derive(Debug, thiserror::Error)]
pub enum AskError {
    /// The archive has no servers of NATS.
    #[error("stations are asked over NATS, and the file of the archive has no [nats]")]
    NoNats,
    /// The servers cannot be used.
    #[error(transparent)]
    Nats(#[from] NatsError),
    /// No station listens.
    #[error("{0} does not listen: it is not connected, or its file has no requests in [archive]")]
    NoStation(String),
    /// The answer did not come.
    #[error("{0} does not answer: {1}; try again")]
    NoAnswer(String, String),
    /// The station refuses.
    #[error("{0} refuses: {1}")]
    Refused(String, String),
}

impl From<AskError> for Problem {
    fn from(error: AskError) -> Self {
        let detail = error.to_string();
        match error {
            AskError::NoNats => Self::not_implemented(detail),
            AskError::Refused(..) => Self::conflict(detail),
            AskError::Nats(_) | AskError::NoStation(_) | AskError::NoAnswer(..) => Self::unavailable(detail),
        }
    }
}

/// The stations behind the servers of NATS. The connection is made with the first request.
#[derive(Clone)]
pub struct Stations {
    nats: Option<Nats>,
    client: Arc<OnceCell<Client>>,
}

impl Stations {
    /// The stations that send to these servers.
    pub fn of(nats: Option<Nats>) -> Self {
        Self { nats, client: Arc::default() }
    }

    /// Asks a station.
    ///
    /// # Errors
    /// [`AskError`].
    pub async fn ask(&self, plant: &str, station: &str, request: &Request) -> Result<Reply, AskError> {
        let nats = self.nats.as_ref().ok_or(AskError::NoNats)?;
        let connected = async { Ok::<_, NatsError>(connect(nats, "profivac view").await?.client()) };
        let client = self.client.get_or_try_init(|| connected).await?;
        let unreadable = |error: &dyn std::fmt::Display| AskError::NoAnswer(station.to_owned(), error.to_string());
        let payload = serde_json::to_vec(request).map_err(|error| unreadable(&error))?;
        let answer =
            client.request(subject(plant, station), payload.into()).await.map_err(|error| match error.kind() {
                RequestErrorKind::NoResponders => AskError::NoStation(station.to_owned()),
                _ => unreadable(&error),
            })?;
        match serde_json::from_slice(&answer.payload).map_err(|error| unreadable(&error))? {
            Reply::Refused(reason) => Err(AskError::Refused(station.to_owned(), reason)),
            reply => Ok(reply),
        }
    }
}
