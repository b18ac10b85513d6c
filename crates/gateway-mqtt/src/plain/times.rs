//! The times of the parameters at the broker.
//!
//! The station reads a parameter again and again, and mostly finds the same value, which is no change to publish. Its object at the broker
//! would keep the time of the first of these readings, as if the station had stopped to read it.

use super::layout::{Layout, Topic};
use profivac_gateway::{Snapshot, Subject};
use profivac_recorder::Micros;
use std::collections::BTreeMap;
use std::time::Duration;

/// The time at the broker is older than the last reading by less than this. chosen: a parameter that changes by itself is stale after it.
pub const REFRESH_PERIOD: Duration = Duration::from_secs(60);

/// The time of each parameter at the broker, by its topic.
#[derive(Clone, Debug, Default)]
pub struct ReadTimes(BTreeMap<usize, Micros>);

impl ReadTimes {
    /// Notes that these topics of a snapshot are published.
    pub fn publish(&mut self, topics: impl IntoIterator<Item = usize>, layout: &Layout, snapshot: &Snapshot) {
        for topic in topics {
            if let Some(at) = layout.topics().get(topic).and_then(|it| read_at(it, snapshot)) {
                self.0.insert(topic, at);
            }
        }
    }

    /// The topics of the parameters whose time at the broker is too old. A clock that was set back makes it too old as well.
    pub fn due<'a>(&'a self, layout: &'a Layout, snapshot: &'a Snapshot) -> impl Iterator<Item = usize> + 'a {
        let is_due = move |(number, topic): (usize, &Topic)| {
            let at = read_at(topic, snapshot)?;
            let is_new = self.0.get(&number).is_none_or(|old| at >= old.after(REFRESH_PERIOD) || at < *old);
            is_new.then_some(number)
        };
        layout.topics().iter().enumerate().filter_map(is_due)
    }
}

/// When the parameter of this topic was read.
fn read_at(topic: &Topic, snapshot: &Snapshot) -> Option<Micros> {
    let position = topic.positions.first().filter(|_| matches!(topic.subject, Subject::Parameter { .. }))?;
    snapshot.values.get(*position)?.at
}
