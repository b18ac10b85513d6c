//! Requests to the stations, over NATS, or over HTTPS to those that poll this archive.

use crate::pending::{Pending, PendingError};
use async_nats::{Client, RequestErrorKind};
use profivac_archive_protocol::nats::{NatsError, connect};
use profivac_archive_protocol::request::{MAX_PIXELS, Reply, Request, subject};
use profivac_recorder::Trend;
use profivac_web_server::problem::Problem;
use profivac_web_server::tables::archive::Nats;
use std::collections::HashMap;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use tokio::sync::OnceCell;

/// Requests of a kind to one station at the same time: a station that is silent delays no request to another one, and trends of many delay
/// no acknowledgement. The station itself takes five trends. chosen.
const MAX_REQUESTS: usize = 4;

/// The most characters of the reason of a refusal.
const MAX_REASON: usize = 500;

/// Why a station has not answered.
#[derive(Debug, thiserror::Error)]
pub enum AskError {
    /// The archive has neither servers of NATS nor this station in its file.
    #[error(
        "{0} cannot be asked: the file of the archive has neither [nats] nor a [[station]] with its plant and name"
    )]
    NoWay(String),
    /// The servers cannot be used.
    #[error(transparent)]
    Nats(#[from] NatsError),
    /// As many requests as possible wait for their answers.
    #[error("too many requests wait for {0}; try again")]
    Busy(String),
    /// The station reads trends for others.
    #[error("{0} reads trends for others; try again")]
    StationBusy(String),
    /// No station listens.
    #[error("{0} does not listen: it does not run, or is not connected to the servers of NATS")]
    NoStation(String),
    /// The station does not poll this archive.
    #[error(
        "{0} is not connected to this archive: it does not run, its file has no requests in [archive], or request-urls in its file does not \
         name this archive"
    )]
    NotConnected(String),
    /// The answer did not come.
    #[error("{0} does not answer: {1}; try again")]
    NoAnswer(String, String),
    /// The reply does not fit the request.
    #[error("unexpected reply from {0}, expected {1}: it probably runs another version")]
    Misunderstood(String, &'static str),
    /// The station refuses.
    #[error("{0} refuses: {1}")]
    Refused(String, String),
}

impl From<AskError> for Problem {
    fn from(error: AskError) -> Self {
        let detail = error.to_string();
        match error {
            AskError::NoWay(_) => Self::not_implemented(detail),
            AskError::Refused(..) => Self::conflict(detail),
            AskError::Busy(_)
            | AskError::NotConnected(_)
            | AskError::StationBusy(_)
            | AskError::Nats(_)
            | AskError::NoStation(_)
            | AskError::NoAnswer(..)
            | AskError::Misunderstood(..) => Self::unavailable(detail),
        }
    }
}

/// The kinds of requests, which do not delay each other.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
enum Kind {
    Trend,
    Acknowledgement,
}

/// The number of requests that wait, for each kind and station that has some. Clones share them.
#[derive(Clone, Default)]
struct Asked(Arc<Mutex<HashMap<(Kind, String), usize>>>);

/// One request that waits.
struct Permit {
    asked: Asked,
    key: (Kind, String),
}

impl Asked {
    fn lock(&self) -> MutexGuard<'_, HashMap<(Kind, String), usize>> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn take(&self, kind: Kind, station: &str) -> Result<Permit, AskError> {
        let key = (kind, station.to_owned());
        let mut asked = self.lock();
        let count = asked.get(&key).copied().unwrap_or(0);
        if count >= MAX_REQUESTS {
            return Err(AskError::Busy(station.to_owned()));
        }
        asked.insert(key.clone(), count.saturating_add(1));
        drop(asked);
        Ok(Permit { asked: self.clone(), key })
    }
}

impl Drop for Permit {
    fn drop(&mut self) {
        let mut asked = self.asked.lock();
        match asked.get(&self.key).copied() {
            Some(count) if count > 1 => drop(asked.insert(self.key.clone(), count - 1)),
            _ => drop(asked.remove(&self.key)),
        }
    }
}

/// The stations behind the servers of NATS, and those that poll. The connection to the servers is made with the first request.
#[derive(Clone)]
pub struct Stations {
    nats: Option<Nats>,
    client: Arc<OnceCell<Client>>,
    pending: Pending,
    asked: Asked,
}

impl Stations {
    /// The stations that send to these servers, and those that poll for the requests of `pending`.
    pub fn of(nats: Option<Nats>, pending: Pending) -> Self {
        Self { nats, client: Arc::default(), pending, asked: Asked::default() }
    }

    /// The trend of the database of a station.
    ///
    /// # Errors
    /// [`AskError`].
    pub async fn trend(&self, plant: &str, station: &str, request: &Request) -> Result<Trend, AskError> {
        let _permit = self.asked.take(Kind::Trend, station)?;
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
        let _permit = self.asked.take(Kind::Acknowledgement, station)?;
        match self.ask(plant, station, request).await? {
            Reply::Done => Ok(()),
            _ => Err(AskError::Misunderstood(station.to_owned(), "an acknowledgement")),
        }
    }

    async fn ask(&self, plant: &str, station: &str, request: &Request) -> Result<Reply, AskError> {
        let unreadable = |error: serde_json::Error| AskError::NoAnswer(station.to_owned(), error.to_string());
        let payload = serde_json::to_vec(request).map_err(unreadable)?;
        let answer = match self.pending.ask(plant, station, payload.clone()).await {
            Ok(answer) => answer,
            Err(error @ (PendingError::Unknown | PendingError::NotConnected)) => match &self.nats {
                Some(nats) => self.ask_nats(nats, plant, station, payload).await?,
                None if error == PendingError::Unknown => return Err(AskError::NoWay(station.to_owned())),
                None => return Err(AskError::NotConnected(station.to_owned())),
            },
            Err(PendingError::Busy) => return Err(AskError::Busy(station.to_owned())),
            Err(error) => return Err(AskError::NoAnswer(station.to_owned(), error.to_string())),
        };
        match serde_json::from_slice(&answer).map_err(unreadable)? {
            Reply::Busy => Err(AskError::StationBusy(station.to_owned())),
            Reply::Refused(reason) => {
                Err(AskError::Refused(station.to_owned(), reason.chars().take(MAX_REASON).collect()))
            }
            reply => Ok(reply),
        }
    }

    async fn ask_nats(&self, nats: &Nats, plant: &str, station: &str, payload: Vec<u8>) -> Result<Vec<u8>, AskError> {
        let connected = async { Ok::<_, NatsError>(connect(nats, "profivac view").await?.client()) };
        let client = self.client.get_or_try_init(|| connected).await?;
        let answer = client.request(subject(plant, station), payload.into()).await;
        let answer = answer.map_err(|error| match error.kind() {
            RequestErrorKind::NoResponders => AskError::NoStation(station.to_owned()),
            _ => AskError::NoAnswer(station.to_owned(), error.to_string()),
        })?;
        Ok(answer.payload.to_vec())
    }
}

/// Whether the lists of a trend belong together.
fn is_whole(trend: &Trend) -> bool {
    let length = trend.start_ms.len();
    let lengths = [trend.low.len(), trend.high.len(), trend.mean.len(), trend.qualities.len()];
    // A station of version 0.1 sends no last pressures.
    let has_last = trend.last.is_empty() || trend.last.len() == length;
    length <= MAX_PIXELS as usize && has_last && lengths.iter().all(|other| *other == length)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn requests_to_a_silent_station_keep_out_none_to_another_one() {
        let asked = Asked::default();
        let mut silent: Vec<_> = (0..MAX_REQUESTS).map(|_| asked.take(Kind::Trend, "silent").unwrap()).collect();
        assert!(matches!(asked.take(Kind::Trend, "silent"), Err(AskError::Busy(station)) if station == "silent"));
        assert!(asked.take(Kind::Acknowledgement, "silent").is_ok(), "an acknowledgement waits for trends");
        assert!(asked.take(Kind::Trend, "hall-1").is_ok(), "another station is blocked");
        silent.pop();
        silent.push(asked.take(Kind::Trend, "silent").unwrap());
        drop(silent);
        assert!(asked.lock().is_empty(), "stations without requests are kept");
    }

    #[test]
    fn a_trend_of_lists_that_do_not_belong_together_is_no_answer() {
        let trend = |length: usize| Trend {
            series: "chamber".to_owned(),
            start_ms: vec![0; length],
            low: vec![None; length],
            high: vec![None; length],
            mean: vec![None; length],
            last: vec![None; length],
            qualities: vec![0; length],
        };
        assert!(is_whole(&trend(0)) && is_whole(&trend(MAX_PIXELS as usize)));
        assert!(!is_whole(&trend(MAX_PIXELS as usize + 1)));
        assert!(!is_whole(&Trend { mean: Vec::new(), ..trend(2) }));
        assert!(!is_whole(&Trend { last: vec![None], ..trend(2) }));
        assert!(is_whole(&Trend { last: Vec::new(), ..trend(2) }), "a station of version 0.1");
    }
}
