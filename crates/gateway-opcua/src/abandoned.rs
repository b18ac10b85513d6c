//! What subscriptions leave in the memory that no client ends any more.
//!
//! The library does not free all of a subscription. One that has expired stays, with its table of values and with its session, until its
//! client asks for its last notification, and a client that is gone never does. Each value of a subscription that has ended, also of one
//! that its client deletes, stays in the table that says which values a change of a node goes to. And a session can be closed while its
//! subscriptions live on, so that they count for no session. And a client that reads the first values of a history leaves a continuation
//! point in its session. This module estimates the octets of all that; at [`MAX_OCTETS`] the server starts again, which frees everything.

use crate::history::Query;
use opcua_server::{CreateMonitoredItem, Subscription, SubscriptionCache, SubscriptionState};
use opcua_types::AttributeId;
use std::collections::HashMap;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

/// The queue of a value that is not an event.
pub const VALUE_QUEUE: usize = 4;

/// The most items of events of a session: each has a long queue.
pub const MAX_EVENT_ITEMS: usize = 2;

/// The most that may be left. chosen: 1,000 clients that disappear without a word, or a million values of subscriptions that are
/// deleted.
pub const MAX_OCTETS: u64 = 256 << 20;

/// A session that is left behind. A usual one takes some 10 KiB; one with the longest texts takes 4 MiB, of which the library does not tell
/// all, so that this is between both.
const SESSION_OCTETS: u64 = 256 << 10;

/// A value in the table of an expired subscription, and of one whose session is closed.
const VALUE_OCTETS: u64 = 1 << 10;

/// An item of events in a subscription that lives: its queue.
const EVENT_ITEM_OCTETS: u64 = 512 << 10;

/// A value of a deleted subscription.
const DELETED_VALUE_OCTETS: u64 = 256;

/// A place in the queue of a value.
const QUEUED_OCTETS: u64 = 128;

/// A link from an item to one that it triggers. It takes 12 octets, and it is followed with each change.
const LINK_OCTETS: u64 = 64;

/// A continuation point: its identifier of six octets, the query, and its place in the table of the session.
const POINT_OCTETS: u64 = 160;

/// The present state of a subscription.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Fate {
    /// Its session lives. It has this many octets beyond those of a usual subscription.
    Kept(u64),
    /// Its session is closed or has expired.
    Abandoned,
    /// It has expired.
    Expired,
    /// Its client has deleted it, or moved it to another session.
    Deleted,
}

/// The items of one subscription that were made since it began.
#[derive(Debug, Default)]
struct Made {
    session: u32,
    values: u64,
    events: u64,
}

impl Made {
    /// What the subscription leaves, when it never had more than `max_values` at the same time.
    fn octets(&self, max_values: u64, fate: Fate) -> u64 {
        let values = self.values.min(max_values);
        match fate {
            Fate::Kept(octets) => octets,
            Fate::Abandoned => {
                SESSION_OCTETS + values * VALUE_OCTETS + self.events.min(MAX_EVENT_ITEMS as u64) * EVENT_ITEM_OCTETS
            }
            Fate::Expired => SESSION_OCTETS + values * VALUE_OCTETS,
            Fate::Deleted => values * DELETED_VALUE_OCTETS,
        }
    }
}

/// The subscriptions with items, by number, and what the others have left.
#[derive(Debug, Default)]
struct Subscriptions {
    made: HashMap<u32, Made>,
    /// How many subscriptions have had items.
    seen: u64,
    /// What those that have ended have left.
    ended: u64,
}

impl Subscriptions {
    fn made(&mut self, session: u32, subscription: u32, is_event: bool) {
        let made = self.made.entry(subscription).or_insert_with(|| {
            self.seen += 1;
            Made::default()
        });
        made.session = session;
        if is_event { made.events += 1 } else { made.values += 1 }
    }

    /// The octets that all have left. The library has numbered `numbered` subscriptions; one without items may have left its session.
    fn octets(&mut self, numbered: u64, max_values: u64, fate: impl Fn(u32, u32) -> Fate) -> u64 {
        let (mut present, mut ended) = (0, 0);
        self.made.retain(|id, made| {
            let fate = fate(made.session, *id);
            let octets = made.octets(max_values, fate);
            let has_ended = matches!(fate, Fate::Expired | Fate::Deleted);
            if has_ended {
                ended += octets
            } else {
                present += octets
            }
            !has_ended
        });
        self.ended += ended;
        self.ended + present + numbered.saturating_sub(self.seen) * SESSION_OCTETS
    }
}

/// The rest of a history that its client may ask for. It counts until the client asks, or until its session ends.
#[derive(Debug)]
pub struct Rest {
    /// The query of the rest.
    pub query: Query,
    count: Arc<AtomicU64>,
}

impl Drop for Rest {
    fn drop(&mut self) {
        self.count.fetch_sub(1, Ordering::Relaxed);
    }
}

/// Estimates what the clients of one server leave.
#[derive(Debug, Default)]
pub struct Abandoned {
    subscriptions: Mutex<Subscriptions>,
    rests: Arc<AtomicU64>,
}

impl Abandoned {
    fn lock(&self) -> MutexGuard<'_, Subscriptions> {
        self.subscriptions.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// A client may ask for the rest of a history.
    #[must_use]
    pub fn rest(&self, query: Query) -> Rest {
        self.rests.fetch_add(1, Ordering::Relaxed);
        Rest { query, count: Arc::clone(&self.rests) }
    }

    /// The octets of the histories whose rest no client has asked for.
    fn rest_octets(&self) -> u64 {
        self.rests.load(Ordering::Relaxed).saturating_mul(POINT_OCTETS)
    }

    /// A client of this session has asked for these items. Those that were refused leave nothing.
    pub fn made<'a>(&self, session: u32, items: impl Iterator<Item = &'a CreateMonitoredItem>) {
        let mut subscriptions = self.lock();
        for item in items.filter(|item| item.status_code().is_good()) {
            let is_event = item.item_to_monitor().attribute_id == AttributeId::EventNotifier;
            subscriptions.made(session, item.handle().subscription_id, is_event);
        }
    }

    /// The octets that are left in the server with these subscriptions. It has numbered `numbered` of them since its start.
    pub fn octets(&self, cache: &SubscriptionCache, numbered: u64, max_values: usize) -> u64 {
        let octets = self.lock().octets(numbered, max_values as u64, |session, id| {
            let Some(session) = cache.get_session_subscriptions(session) else { return Fate::Deleted };
            let session = session.lock();
            match session.get(id) {
                None => Fate::Deleted,
                Some(found) if found.state() == SubscriptionState::Closed => Fate::Expired,
                // Besides the subscriptions only the list of the living sessions holds a session, and requests that are being answered.
                Some(_) if Arc::strong_count(session.session()) == 1 => Fate::Abandoned,
                Some(found) => Fate::Kept(unusual_octets(found)),
            }
        });
        octets.saturating_add(self.rest_octets())
    }
}

/// What a living subscription has beyond a usual one: a client makes queues longer and links items after they are made, when the library
/// does not ask the gateway.
fn unusual_octets(subscription: &Subscription) -> u64 {
    let octets = subscription.items().map(|item| {
        let is_event = item.item_to_monitor().attribute_id == AttributeId::EventNotifier;
        let places = if is_event { 0 } else { item.queue_size().saturating_sub(VALUE_QUEUE) };
        places as u64 * QUEUED_OCTETS + item.triggered_items().len() as u64 * LINK_OCTETS
    });
    octets.sum()
}

#[cfg(test)]
mod tests {
    use super::*;
    use profivac_recorder::Micros;

    fn with_values(count: u64) -> Subscriptions {
        let mut subscriptions = Subscriptions::default();
        for _ in 0..count {
            subscriptions.made(1, 1, false);
        }
        subscriptions
    }

    #[test]
    fn a_subscription_counts_while_its_session_is_closed_and_once_when_it_ends() {
        let mut subscriptions = with_values(100);
        let mut octets = |fate| subscriptions.octets(1, 2_000, |_, _| fate);
        assert_eq!(octets(Fate::Kept(0)), 0);
        assert_eq!([octets(Fate::Abandoned), octets(Fate::Abandoned)], [(256 + 100) << 10; 2]);
        assert_eq!([octets(Fate::Expired), octets(Fate::Expired)], [(256 + 100) << 10; 2]);
    }

    /// A client that deletes its subscription leaves little, and no session.
    #[test]
    fn a_deleted_subscription_leaves_its_values() {
        assert_eq!(with_values(100).octets(1, 2_000, |_, _| Fate::Deleted), 100 * 256);
    }

    /// A client changes the values of its subscription all the time: there are never more than the limit.
    #[test]
    fn values_that_a_client_removes_itself_count_up_to_the_limit_of_a_subscription() {
        let mut subscriptions = with_values(1_000_000);
        assert_eq!(subscriptions.octets(1, 2_000, |_, _| Fate::Kept(0)), 0);
        assert_eq!(subscriptions.octets(1, 2_000, |_, _| Fate::Deleted), 2_000 * 256);
    }

    #[test]
    fn the_rest_of_a_history_counts_until_its_client_asks_for_it() {
        let abandoned = Abandoned::default();
        let query = Query::Forward(Micros(1), Micros(2));
        let mut rests: Vec<Rest> = (0..1_000).map(|_| abandoned.rest(query)).collect();
        assert_eq!(abandoned.rest_octets(), 1_000 * POINT_OCTETS);
        rests.truncate(1);
        assert_eq!((rests[0].query, abandoned.rest_octets()), (query, POINT_OCTETS));
        drop(rests);
        assert_eq!(abandoned.rest_octets(), 0);
    }

    #[test]
    fn items_of_events_count_while_they_live() {
        let mut subscriptions = Subscriptions::default();
        for _ in 0..200 {
            subscriptions.made(1, 1, true);
        }
        assert_eq!(subscriptions.octets(1, 2_000, |_, _| Fate::Abandoned), (256 + 2 * 512) << 10);
        assert_eq!(subscriptions.octets(1, 2_000, |_, _| Fate::Expired), 256 << 10);
    }

    #[test]
    fn subscriptions_without_items_may_have_left_their_sessions() {
        let mut subscriptions = with_values(1);
        assert_eq!(subscriptions.octets(3, 2_000, |_, _| Fate::Kept(7)), 7 + 2 * (256 << 10));
        assert_eq!(subscriptions.octets(0, 2_000, |_, _| Fate::Kept(0)), 0, "counted before the number is read");
    }
}
