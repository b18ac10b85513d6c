//! A live stream: a state, then its changes, as server-sent events.
//!
//! A client gets the whole state first and then the parts that have changed. A client that is slow gets fewer and larger changes: the server
//! keeps only the state that the client has, and no queue.

use crate::compression::compressed;
use crate::middleware::RequestContext;
use axum::http::{Extensions, HeaderMap};
use axum::response::sse::{Event, KeepAlive, Sse};
use axum::response::{IntoResponse, Response};
use serde::Serialize;
use serde_json::{Map, Value};
use std::collections::BTreeMap;
use std::convert::Infallible;
use std::sync::{Arc, Mutex, PoisonError};
use std::time::{Duration, Instant};
use tokio::time::MissedTickBehavior;
use tokio_stream::StreamExt;
use tokio_stream::wrappers::IntervalStream;

/// A state that a live stream sends.
pub trait LiveState: Serialize + Send + Sync + 'static {
    /// What differs from the state `before`.
    fn changes_since(&self, before: &Self) -> Changes;
}

/// The parts of a state that have changed.
#[derive(Default)]
pub struct Changes(Map<String, Value>);

impl Changes {
    /// Adds a part if it has changed, as a whole.
    #[must_use]
    pub fn part<T: PartialEq + Serialize>(mut self, name: &str, before: &T, now: &T) -> Self {
        if before != now {
            self.0.insert(name.to_owned(), json(now));
        }
        self
    }

    /// Adds the entries of a part that have changed, each as a whole; one that is gone is `null`.
    #[must_use]
    pub fn entries<T: PartialEq + Serialize>(
        mut self,
        name: &str,
        before: &BTreeMap<String, T>,
        now: &BTreeMap<String, T>,
    ) -> Self {
        let changed = now.iter().filter(|(key, entry)| before.get(*key) != Some(*entry));
        let changed = changed.map(|(key, entry)| (key.clone(), json(entry)));
        let gone = before.keys().filter(|key| !now.contains_key(*key)).map(|key| (key.clone(), Value::Null));
        let entries: Map<String, Value> = changed.chain(gone).collect();
        if !entries.is_empty() {
            self.0.insert(name.to_owned(), entries.into());
        }
        self
    }

    fn into_text(self) -> Arc<str> {
        Value::Object(self.0).to_string().into()
    }
}

/// Numbers, texts, lists and maps with texts as keys always have a JSON form.
fn json<T: Serialize>(part: &T) -> Value {
    let value = serde_json::to_value(part);
    debug_assert!(value.is_ok(), "a part of a live state has no JSON form");
    value.unwrap_or_default()
}

/// The latest state, and how it differs from the one before.
struct Latest<S> {
    made: Instant,
    state: Arc<S>,
    before: Option<Arc<S>>,
    /// The changes from `before` to `state`, as text.
    changes: Arc<str>,
}

/// The latest state of a live stream, shared by all clients.
pub struct LiveSource<S> {
    state: Box<dyn Fn() -> S + Send + Sync>,
    period: Duration,
    latest: Mutex<Option<Latest<S>>>,
}

/// The name and the data of an event.
type NamedEvent = (&'static str, Arc<str>);

impl<S: LiveState> LiveSource<S> {
    /// A source with an event in each period. `state` gives the present state.
    pub fn of(period: Duration, state: impl Fn() -> S + Send + Sync + 'static) -> Self {
        Self { state: Box::new(state), period, latest: Mutex::new(None) }
    }

    /// The age up to which clients share a state: shorter than a period, so that a client whose tick comes a little early never gets
    /// the state that it has.
    fn shared(&self) -> Duration {
        self.period * 4 / 5
    }

    /// The event that brings a client with the state `has` to the state at `now`.
    pub fn event(&self, has: &mut Option<Arc<S>>, now: Instant) -> NamedEvent {
        let mut latest = self.latest.lock().unwrap_or_else(PoisonError::into_inner);
        let present = match latest.take() {
            Some(present) if now < present.made + self.shared() => present,
            old => self.next(old.map(|old| old.state), now),
        };
        let (state, before) = (Arc::clone(&present.state), present.before.clone());
        let changes = Arc::clone(&present.changes);
        *latest = Some(present);
        drop(latest);
        match has.replace(Arc::clone(&state)) {
            None => ("snapshot", json(&*state).to_string().into()),
            Some(has) if before.is_some_and(|before| Arc::ptr_eq(&before, &has)) => ("change", changes),
            Some(has) => ("change", state.changes_since(&has).into_text()),
        }
    }

    fn next(&self, before: Option<Arc<S>>, now: Instant) -> Latest<S> {
        let state = Arc::new((self.state)());
        let changes = before.as_ref().map(|before| state.changes_since(before)).unwrap_or_default().into_text();
        Latest { made: now, state, before, changes }
    }
}

/// The answer with the events of `source`. It ends with the session of its client.
pub fn stream<S: LiveState>(source: Arc<LiveSource<S>>, headers: &HeaderMap, extensions: &Extensions) -> Response {
    let mut ticks = tokio::time::interval(source.period);
    ticks.set_missed_tick_behavior(MissedTickBehavior::Skip);
    let context = extensions.get::<RequestContext>().cloned();
    let is_allowed = move |_: &_| context.as_ref().is_none_or(RequestContext::is_still_authenticated);
    let mut has = None;
    let events = IntervalStream::new(ticks).take_while(is_allowed).map(move |_| {
        let (name, data) = source.event(&mut has, Instant::now());
        Ok::<_, Infallible>(Event::default().event(name).data(data))
    });
    compressed(Sse::new(events).keep_alive(KeepAlive::default()).into_response(), headers)
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::json;

    #[derive(Serialize)]
    struct Plant {
        now: u32,
        order: Vec<u32>,
        gauges: BTreeMap<String, (f64, String)>,
    }

    impl LiveState for Plant {
        fn changes_since(&self, before: &Self) -> Changes {
            let Self { now, order, gauges } = self;
            let changes = Changes::default().part("now", &before.now, now).part("order", &before.order, order);
            changes.entries("gauges", &before.gauges, gauges)
        }
    }

    fn plant(now: u32, gauges: &[(&str, f64)]) -> Plant {
        let gauges = gauges.iter().map(|(name, pa)| ((*name).to_owned(), (*pa, "ok".to_owned())));
        Plant { now, order: vec![1, 2], gauges: gauges.collect() }
    }

    fn changes(before: &Plant, now: &Plant) -> Value {
        serde_json::from_str(&now.changes_since(before).into_text()).unwrap()
    }

    #[test]
    fn changes_have_whole_parts_and_whole_entries_and_null_for_one_that_is_gone() {
        let before = plant(1, &[("a", 1.0), ("b", 2.0), ("same", 3.0)]);
        let now = plant(2, &[("a", 1.5), ("c", 3.0), ("same", 3.0)]);
        let expected = json!({"now": 2, "gauges": {"a": [1.5, "ok"], "b": null, "c": [3.0, "ok"]}});
        assert_eq!(changes(&before, &now), expected);
        assert_eq!(changes(&now, &now), json!({}));
    }
}
