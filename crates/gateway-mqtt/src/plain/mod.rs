//! Plain topics: the present state of each gauge, segment and alarm as JSON, retained, and Home Assistant's discovery.
//!
//! | Module | Holds |
//! |---|---|
//! | [`layout`] | topics and their contents |
//! | [`discovery`] | sensors for Home Assistant |
//! | [`times`] | when the time of a parameter is published again |

pub mod discovery;
pub mod layout;
pub mod times;

use crate::connection::{Connection, Connector, Event, MqttError};
use crate::message::Message;
use crate::retry::{Ended, Retry};
use crate::topic::slug;
use crate::tracker::Tracker;
use layout::Layout;
use profivac_gateway::Snapshot;
use profivac_gateway::thread::Context;
use profivac_recorder::Micros;
use profivac_station::config::gateways::mqtt::{Broker, Discovery, Plain};
use std::collections::BTreeSet;
use std::sync::Arc;
use times::ReadTimes;

/// What all topics begin with, unless the file has another prefix.
#[must_use]
pub fn default_prefix(station: &str) -> String {
    format!("profivac/{}", slug(station))
}

/// Publishes the plain topics until it is told to stop.
///
/// # Errors
/// [`MqttError`] when a certificate or key cannot be read.
pub async fn serve(broker: Broker, settings: Plain, mut context: Context) -> Result<(), MqttError> {
    let station = context.services.name().to_owned();
    let client_id = broker.client_id.clone().unwrap_or_else(|| format!("profivac-{}", slug(&station)));
    let connector = Connector::new(broker)?;
    let prefix = settings.prefix.unwrap_or_else(|| default_prefix(&station));
    let mut publisher = Publisher { connector, client_id, station, prefix, discovery: settings.discovery };
    let mut retry = Retry::new();
    loop {
        let ended = publisher.session(&mut context).await;
        if !retry.goes_on(ended, &mut publisher.connector, &mut context).await {
            return Ok(());
        }
    }
}

struct Publisher {
    connector: Connector,
    client_id: String,
    station: String,
    prefix: String,
    discovery: Option<Discovery>,
}

/// What the broker has.
struct Published {
    layout: Layout,
    tracker: Tracker,
    times: ReadTimes,
    /// The descriptions for Home Assistant.
    sensors: Vec<Message>,
}

impl Publisher {
    /// One connection, from CONNECT to its end.
    async fn session(&self, context: &mut Context) -> Ended {
        let will = layout::status(&self.prefix, false);
        // Home Assistant says there when it has started and wants all descriptions again.
        let subscriptions = self.discovery.iter().map(|it| discovery::birth_topic(&it.prefix)).collect();
        let connecting = self.connector.connect(self.client_id.clone(), will, subscriptions);
        let connected = tokio::select! {
            connected = connecting => connected,
            () = context.stop.stopped() => return Ended::Stopped,
        };
        let mut connection = match connected {
            Ok(connection) => connection,
            Err(error) => return Ended::Failed(error),
        };
        context.status.runs(self.connector.address());
        context.status.set_clients(1);
        match self.publish_until_stopped(&mut connection, context).await {
            Ok(()) => {
                connection.publish(layout::status(&self.prefix, false)).await.ok();
                connection.close().await;
                Ended::Stopped
            }
            // The connection knows why.
            Err(MqttError::Closed) => Ended::Lost(connection.end().await),
            Err(error) => Ended::Lost(error),
        }
    }

    async fn publish_until_stopped(&self, connection: &mut Connection, context: &mut Context) -> Result<(), MqttError> {
        connection.publish_all(vec![layout::status(&self.prefix, true)], &context.status).await?;
        let mut snapshots = context.model.subscribe();
        let mut published: Option<Published> = None;
        loop {
            tokio::select! {
                () = context.stop.stopped() => return Ok(()),
                event = connection.event() => {
                    if let Event::Message { payload, .. } = event?
                        && payload == b"online"
                        && let Some(Published { layout, .. }) = &published
                    {
                        let snapshot = Arc::clone(&snapshots.borrow());
                        connection.publish_all(self.sensors(layout, &snapshot), &context.status).await?;
                    }
                }
                changed = snapshots.changed() => {
                    if changed.is_err() {
                        return Ok(());
                    }
                    let snapshot = Arc::clone(&snapshots.borrow_and_update());
                    let messages = self.messages(&mut published, &snapshot, context);
                    connection.publish_all(messages, &context.status).await?;
                }
            }
        }
    }

    /// The messages for a new snapshot: everything after a change of the points, otherwise the topics that have changed.
    fn messages(&self, published: &mut Option<Published>, snapshot: &Arc<Snapshot>, context: &Context) -> Vec<Message> {
        let now = Micros::now();
        match published {
            Some(Published { layout, tracker, times, .. }) if tracker.has_points_of(snapshot) => {
                let changes = tracker.next(snapshot, now);
                context.status.dropped_updates(changes.missed);
                let changed = changes.positions.iter().filter_map(|it| layout.topic_of(*it));
                let topics: BTreeSet<usize> = changed.chain(times.due(layout, snapshot)).collect();
                times.publish(topics.iter().copied(), layout, snapshot);
                topics.into_iter().flat_map(|topic| layout.messages(topic, snapshot)).collect()
            }
            _ => {
                let layout = Layout::new(&self.prefix, &snapshot.points);
                // A gauge that is no longer in the file leaves nothing behind at the broker.
                let sensors = self.sensors(&layout, snapshot);
                let old = published.as_ref().map(|old| old.layout.obsolete(&layout)).unwrap_or_default();
                let unknown = published.as_ref().map(|old| discovery::obsolete(&old.sensors, &sensors));
                let all = (0..layout.len()).flat_map(|topic| layout.messages(topic, snapshot));
                let described = sensors.iter().cloned();
                let messages = old.into_iter().chain(unknown.unwrap_or_default()).chain(described).chain(all).collect();
                let mut times = ReadTimes::default();
                times.publish(0..layout.len(), &layout, snapshot);
                *published =
                    Some(Published { layout, tracker: Tracker::new(Arc::clone(snapshot), now), times, sensors });
                messages
            }
        }
    }

    fn sensors(&self, layout: &Layout, snapshot: &Snapshot) -> Vec<Message> {
        let Some(discovery) = &self.discovery else { return Vec::new() };
        discovery::sensors(discovery, &self.prefix, &self.station, layout, &snapshot.points, &snapshot.values)
    }
}
