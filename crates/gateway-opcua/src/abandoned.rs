//! Subscriptions that no client ends any more.
//!
//! The library never frees two things. A subscription that has expired stays until its client asks for its last notification, and a client
//! that is gone never does. And each value of a subscription that has ended, also of one that its client deletes, stays in the table that
//! says which values a change of a node goes to. Besides, a session can be closed while its subscriptions live on, so they count for no
//! session. This module counts what that can amount to; at [`MAX_WEIGHT`] the server starts again, which frees everything.

use opcua_server::{CreateMonitoredItem, SubscriptionCache, SubscriptionState};
use opcua_types::AttributeId;
use std::collections::HashMap;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

/// The most that abandoned subscriptions may amount to, in values: some 100 MiB, and 0.1 s of a processor for each change if all are of the
/// same node. free choice: what 900 clients with 100 values leave behind, or 13 sessions with as many values as they may have.
pub const MAX_WEIGHT: u64 = 100_000;

/// What a subscription without values counts.
const SUBSCRIPTION_WEIGHT: u64 = 10;

/// What an item of events counts: its queue is as much longer than that of a value.
const EVENT_WEIGHT: u64 = 500;

/// A subscription, by its session and its own number.
type Id = (u32, u32);

/// The state of a subscription, as far as it matters here.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Fate {
    /// Its session lives.
    Kept,
    /// Its session is closed or has expired. It may still expire, or move to another session.
    Abandoned,
    /// It has expired, or is deleted.
    Ended,
}

/// The items of one subscription that were made since it began, and how many of them at most exist at the same time.
#[derive(Debug, Default)]
struct Made {
    values: u64,
    events: u64,
}

impl Made {
    fn weight(&self, max_values: u64) -> u64 {
        SUBSCRIPTION_WEIGHT + self.values.min(max_values) + EVENT_WEIGHT * self.events
    }
}

/// The subscriptions that have items, and what has ended.
#[derive(Debug, Default)]
struct Subscriptions {
    made: HashMap<Id, Made>,
    /// How many subscriptions and items were seen here. The library gives numbers also to those that were not.
    seen: Numbers,
    /// The weight of those that have ended.
    ended: u64,
}

/// Numbers of subscriptions and of items.
#[derive(Debug, Default, Clone, Copy, PartialEq, Eq)]
pub struct Numbers {
    /// Subscriptions.
    pub subscriptions: u64,
    /// Items.
    pub items: u64,
}

impl Subscriptions {
    fn made(&mut self, id: Id, is_event: bool) {
        let made = self.made.entry(id).or_insert_with(|| {
            self.seen.subscriptions += 1;
            Made::default()
        });
        self.seen.items += 1;
        if is_event { made.events += 1 } else { made.values += 1 }
    }

    /// The weight of all that are abandoned or have ended. `given` are the numbers that the library has given; those that were not seen
    /// here count as abandoned: they have no items, or items of attributes for which the library does not ask the gateway, or were refused.
    fn weight(&mut self, given: Numbers, max_values: u64, fate: impl Fn(Id) -> Fate) -> u64 {
        let (mut abandoned, mut ended) = (0, 0);
        self.made.retain(|id, made| {
            let weight = made.weight(max_values);
            let fate = fate(*id);
            match fate {
                Fate::Kept => {}
                Fate::Abandoned => abandoned += weight,
                Fate::Ended => ended += weight,
            }
            fate != Fate::Ended
        });
        self.ended += ended;
        let unseen_subscriptions = given.subscriptions.saturating_sub(self.seen.subscriptions);
        let unseen_items = given.items.saturating_sub(self.seen.items);
        self.ended + abandoned + unseen_items + SUBSCRIPTION_WEIGHT * unseen_subscriptions
    }
}

/// Counts abandoned subscriptions of one server.
#[derive(Debug, Default)]
pub struct Abandoned(Mutex<Subscriptions>);

impl Abandoned {
    fn lock(&self) -> MutexGuard<'_, Subscriptions> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// A client of this session asks for these items.
    pub fn made<'a>(&self, session: u32, items: impl Iterator<Item = &'a CreateMonitoredItem>) {
        let mut subscriptions = self.lock();
        for item in items {
            let is_event = item.item_to_monitor().attribute_id == AttributeId::EventNotifier;
            subscriptions.made((session, item.handle().subscription_id), is_event);
        }
    }

    /// The weight of all that is abandoned in the server with these subscriptions, in values. `given` are the numbers that the library has
    /// given.
    pub fn weight(&self, cache: &SubscriptionCache, given: Numbers, max_values: usize) -> u64 {
        self.lock().weight(given, max_values as u64, |(session, id)| {
            let Some(session) = cache.get_session_subscriptions(session) else { return Fate::Ended };
            let session = session.lock();
            match session.get(id).map(|subscription| subscription.state()) {
                None | Some(SubscriptionState::Closed) => Fate::Ended,
                // Besides the subscriptions only the list of the living sessions holds a session, and requests that are being answered.
                Some(_) if Arc::strong_count(session.session()) == 1 => Fate::Abandoned,
                Some(_) => Fate::Kept,
            }
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The numbers of subscriptions and items that were all seen.
    fn all(subscriptions: &Subscriptions) -> Numbers {
        subscriptions.seen
    }

    #[test]
    fn a_subscription_counts_when_its_session_is_closed_and_once_when_it_ends() {
        let mut subscriptions = Subscriptions::default();
        for _ in 0..100 {
            subscriptions.made((1, 1), false);
        }
        let given = all(&subscriptions);
        let mut weight = |fate| subscriptions.weight(given, 2_000, |_| fate);
        assert_eq!(weight(Fate::Kept), 0);
        assert_eq!([weight(Fate::Abandoned), weight(Fate::Abandoned)], [110, 110]);
        assert_eq!(weight(Fate::Kept), 0, "another session has taken it");
        assert_eq!([weight(Fate::Ended), weight(Fate::Ended)], [110, 110]);
    }

    /// A client changes the values of its subscription all the time: there are never more than the limit.
    #[test]
    fn values_that_a_client_removes_itself_count_up_to_the_limit_of_a_subscription() {
        let mut subscriptions = Subscriptions::default();
        for _ in 0..1_000_000 {
            subscriptions.made((1, 1), false);
        }
        subscriptions.made((2, 2), true);
        let given = all(&subscriptions);
        assert_eq!(subscriptions.weight(given, 2_000, |_| Fate::Kept), 0);
        assert_eq!(subscriptions.weight(given, 2_000, |_| Fate::Ended), (10 + 2_000) + (10 + 500));
    }

    #[test]
    fn what_was_not_seen_counts() {
        let mut subscriptions = Subscriptions::default();
        subscriptions.made((1, 1), false);
        let given = Numbers { subscriptions: 3, items: 8 };
        assert_eq!(subscriptions.weight(given, 2_000, |_| Fate::Kept), 2 * 10 + 7);
        assert_eq!(
            subscriptions.weight(Numbers::default(), 2_000, |_| Fate::Kept),
            0,
            "counted before the number is read"
        );
    }
}
