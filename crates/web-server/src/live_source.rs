//! A live stream: a state, then its changes, as server-sent events.
//!
//! A client gets the whole state first and then merge patches. A client that is slow gets fewer and larger patches: the server keeps only
//! the state that it has, and no queue.

use crate::compression::compressed;
use crate::merge_patch::merge_patch;
use crate::middleware::RequestContext;
use axum::http::{Extensions, HeaderMap};
use axum::response::sse::{Event, KeepAlive, Sse};
use axum::response::{IntoResponse, Response};
use serde_json::Value;
use std::convert::Infallible;
use std::sync::{Arc, Mutex, PoisonError};
use std::time::{Duration, Instant};
use tokio::time::MissedTickBehavior;
use tokio_stream::StreamExt;
use tokio_stream::wrappers::IntervalStream;

/// The state that clients have, as JSON.
type StateJson = Arc<Value>;

/// The latest state, and how it differs from the one before.
struct Latest {
    made: Instant,
    state: StateJson,
    before: Option<StateJson>,
    /// The patch from `before` to `state`, as text.
    patch: Arc<str>,
}

/// The latest state of a live stream, shared by all clients.
pub struct LiveSource {
    state: Box<dyn Fn() -> Value + Send + Sync>,
    period: Duration,
    latest: Mutex<Option<Latest>>,
}

/// The name and the data of an event.
type NamedEvent = (&'static str, Arc<str>);

impl LiveSource {
    /// A source with an event in each period. `state` gives the present state as a JSON object.
    pub fn of(period: Duration, state: impl Fn() -> Value + Send + Sync + 'static) -> Self {
        Self { state: Box::new(state), period, latest: Mutex::new(None) }
    }

    /// The age up to which clients share a state: shorter than a period, so that a client whose tick comes a little early never gets
    /// the state that it has.
    fn shared(&self) -> Duration {
        self.period * 4 / 5
    }

    /// The event that brings a client with the state `has` to the state at `now`.
    pub fn event(&self, has: &mut Option<StateJson>, now: Instant) -> NamedEvent {
        let mut latest = self.latest.lock().unwrap_or_else(PoisonError::into_inner);
        let present = match latest.take() {
            Some(present) if now < present.made + self.shared() => present,
            old => self.next(old.map(|old| old.state), now),
        };
        let (state, before, patch) = (Arc::clone(&present.state), present.before.clone(), Arc::clone(&present.patch));
        *latest = Some(present);
        drop(latest);
        match has.replace(Arc::clone(&state)) {
            None => ("snapshot", state.to_string().into()),
            Some(has) if before.is_some_and(|before| Arc::ptr_eq(&before, &has)) => ("change", patch),
            Some(has) => ("change", patch_text(&has, &state)),
        }
    }

    fn next(&self, before: Option<StateJson>, now: Instant) -> Latest {
        let state = Arc::new((self.state)());
        let patch = before.as_ref().map_or_else(|| Arc::from(""), |before| patch_text(before, &state));
        Latest { made: now, state, before, patch }
    }
}

fn patch_text(old: &Value, new: &Value) -> Arc<str> {
    merge_patch(old, new).map_or_else(|| Arc::from("{}"), |patch| patch.to_string().into())
}

/// The answer with the events of `source`. It ends with the session of its client.
pub fn stream(source: Arc<LiveSource>, headers: &HeaderMap, extensions: &Extensions) -> Response {
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
