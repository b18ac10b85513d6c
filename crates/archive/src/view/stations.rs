//! Requests to the stations, over NATS.

use crate::nats::{NatsError, connect};
use crate::request::{MAX_PIXELS, Reply, Request, subject};
use async_nats::{Client, RequestErrorKind};
use profivac_station::api::Problem;
use profivac_station::config::gateways::archive::Nats;
use profivac_station::view::Trend;
use std::sync::Arc;
use tokio::sync::{OnceCell, Semaphore};

/// Requests of a kind at the same time, so that users cannot fill the queue of a station, and trends of many cannot delay an
/// acknowledgement. free choice.
const MAX_REQUESTS: usize = 8;

/// The most characters of the reason of a refusal.
const MAX_REASON: usize = 500;

/// Why a station has not answered.
#[derive(Debug, thiserror::Error)]
pub enum AskError {
    /// The archive has no servers of NATS.
    #[error("stations are asked over NATS, and the file of the archive has no [nats]")]
    NoNats,
    /// The servers cannot be used.
    #[error(transparent)]
    Nats(#[from] NatsError),
    /// As many requests as possible wait for their answers.
    #[error("too many requests wait for stations; try again")]
    Busy,
    /// The station reads trends for others.
    #[error("{0} reads trends for others; try again")]
    StationBusy(String),
    /// No station listens.
    #[error("{0} does not listen: it is not connected, or its file has no requests in [archive]")]
    NoStation(String),
    /// The answer did not come.
    #[error("{0} does not answer: {1}; try again")]
    NoAnswer(String, String),
    /// The answer is that to another request.
    #[error("{0} answers with something else than {1}: its program is another version")]
    Misunderstood(String, &'static str),
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
            AskError::Busy
            | AskError::StationBusy(_)
            | AskError::Nats(_)
            | AskError::NoStation(_)
            | AskError::NoAnswer(..)
            | AskError::Misunderstood(..) => Self::unavailable(detail),
        }
    }
}

/// The stations behind the servers of NATS. The connection is made with the first request.
#[derive(Clone)]
pub struct Stations {
    nats: Option<Nats>,
    client: Arc<OnceCell<Client>>,
    trends: Arc<Semaphore>,
    acknowledgements: Arc<Semaphore>,
}

impl Stations {
    /// The stations that send to these servers.
    pub fn of(nats: Option<Nats>) -> Self {
        let permits = || Arc::new(Semaphore::new(MAX_REQUESTS));
        Self { nats, client: Arc::default(), trends: permits(), acknowledgements: permits() }
    }

    /// The trend of the database of a station.
    ///
    /// # Errors
    /// [`AskError`].
    pub async fn trend(&self, plant: &str, station: &str, request: &Request) -> Result<Trend, AskError> {
        let _permit = self.trends.try_acquire().map_err(|_| AskError::Busy)?;
        match self.ask(plant, station, request).await? {
            Reply::Trend(trend) if is_whole(&trend) => Ok(trend),
            _ => Err(AskError::Misunderstood(station.to_owned(), "a trend")),
        }
    }

    /// Acknowledges an alarm at its station.
    ///
    /// # Errors
    /// [`AskError`].
    pub async fn acknowledge(&self, plant: &str, station: &str, request: &Request) -> Result<(), AskError> {
        let _permit = self.acknowledgements.try_acquire().map_err(|_| AskError::Busy)?;
        match self.ask(plant, station, request).await? {
            Reply::Done => Ok(()),
            _ => Err(AskError::Misunderstood(station.to_owned(), "an acknowledgement")),
        }
    }

    async fn ask(&self, plant: &str, station: &str, request: &Request) -> Result<Reply, AskError> {
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
            Reply::Busy => Err(AskError::StationBusy(station.to_owned())),
            Reply::Refused(reason) => {
                Err(AskError::Refused(station.to_owned(), reason.chars().take(MAX_REASON).collect()))
            }
            reply => Ok(reply),
        }
    }
}

/// Whether the lists of a trend belong together.
fn is_whole(trend: &Trend) -> bool {
    let lengths = [trend.low.len(), trend.high.len(), trend.mean.len(), trend.qualities.len()];
    trend.start_ms.len() <= MAX_PIXELS as usize && lengths.iter().all(|length| *length == trend.start_ms.len())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_trend_of_lists_that_do_not_belong_together_is_no_answer() {
        let trend = |length: usize| Trend {
            series: "chamber".to_owned(),
            start_ms: vec![0; length],
            low: vec![None; length],
            high: vec![None; length],
            mean: vec![None; length],
            qualities: vec![0; length],
        };
        assert!(is_whole(&trend(0)) && is_whole(&trend(MAX_PIXELS as usize)));
        assert!(!is_whole(&trend(MAX_PIXELS as usize + 1)));
        assert!(!is_whole(&Trend { mean: Vec::new(), ..trend(2) }));
    }
}
