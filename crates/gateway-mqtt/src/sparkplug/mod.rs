//! The edge node of Sparkplug B: the station is the edge node, a gauge is a device.
//!
//! | Module | Holds |
//! |---|---|
//! | [`edge_node`] | births, deaths, data and commands as a state machine |
//! | [`metric`] | points as metrics |
//! | [`payload`] | the payload as protocol buffers |
//! | [`backlog`] | the samples of an outage |
//! | [`memory`] | what the edge node knows after a restart |

pub mod backlog;
pub mod edge_node;
pub mod memory;
pub mod metric;
pub mod payload;

use crate::connection::{Connection, Connector, Event, MqttError};
use crate::message::Message;
use crate::retry::{Ended, Retry};
use crate::topic::{level, slug};
use backlog::{Backlog, Batch, Series};
use edge_node::{EdgeNode, Names, Phase, Reaction};
use memory::Memory;
use profivac_gateway::Snapshot;
use profivac_gateway::thread::Context;
use profivac_recorder::{DatabaseError, Micros};
use profivac_station::config::gateways::mqtt::{Broker, Sparkplug};
use std::collections::HashSet;
use std::fmt::Display;
use std::future::pending;
use std::sync::Arc;
use std::time::Duration;
use tokio::task::{JoinError, JoinHandle, spawn_blocking};
use tokio::time::{MissedTickBehavior, interval};

/// The pause after a batch: 10 000 samples a second, so that a broker need not drop any for its subscribers.
const BATCH_PAUSE: Duration = Duration::from_millis(50);

/// How often a rebirth that is wanted is looked at.
const TICK: Duration = Duration::from_millis(250);

/// The names of the edge node of a station.
#[must_use]
pub fn names(settings: &Sparkplug, station: &str) -> Names {
    Names {
        group: settings.group.clone(),
        edge_node: settings.edge_node.clone().unwrap_or_else(|| level(station)),
        primary_host: settings.primary_host.clone(),
        data: settings.data,
    }
}

/// Runs the edge node until it is told to stop.
///
/// # Errors
/// [`MqttError`] when a certificate or key cannot be read.
pub async fn serve(broker: Broker, settings: Sparkplug, mut context: Context) -> Result<(), MqttError> {
    let station = context.services.name().to_owned();
    let client_id = broker.client_id.clone().unwrap_or_else(|| format!("profivac-{}", slug(&station)));
    let (memory, problem) = Memory::read(context.services.recorder().beside("sparkplug"));
    if let Some(problem) = problem {
        context.status.error(&problem);
    }
    let mut publisher = Publisher {
        connector: Connector::new(broker)?,
        client_id: format!("{client_id}-sparkplug"),
        names: names(&settings, &station),
        longest_backlog: settings.backlog,
        memory,
        host_at: None,
    };
    let mut retry = Retry::new();
    loop {
        let ended = publisher.session(&mut context).await;
        if !retry.goes_on(ended, &mut publisher.connector, &mut context).await {
            return Ok(());
        }
    }
}

/// A batch that is being read in a thread, with the backlog that it comes from.
type PendingRead = JoinHandle<Read>;

/// A batch that was read.
type Read = (Backlog, Result<Batch, DatabaseError>);

/// How far the edge node has got.
struct Progress {
    /// The samples up to this time were handed to the socket.
    sent: Micros,
    /// The same when the last PINGREQ was sent.
    pinged: Option<Micros>,
}

/// What ends a session that was not lost.
struct Last {
    /// The NDEATH to be published.
    death: Message,
    /// The samples up to this time are delivered when the socket has taken everything; `None` if only an answered PINGREQ proves it.
    sent: Option<Micros>,
}

impl Last {
    fn of(node: &EdgeNode, progress: &Progress) -> Self {
        Self { death: node.death(Micros::now()), sent: Some(progress.sent) }
    }
}

struct Publisher {
    connector: Connector,
    client_id: String,
    names: Names,
    longest_backlog: Duration,
    memory: Memory,
    host_at: Option<u64>,
}

impl Publisher {
    /// One connection, from CONNECT to its end.
    async fn session(&mut self, context: &mut Context) -> Ended {
        let (bd_seq, kept) = self.memory.next_bd_seq();
        if let Err(error) = kept {
            context.status.error(&format!("bdSeq cannot be kept beside the database: {error}"));
        }
        let mut node = EdgeNode::new(self.names.clone(), bd_seq, self.host_at);
        let will = node.death(Micros::now());
        let connecting = self.connector.connect(self.client_id.clone(), will, self.names.subscriptions());
        let connected = tokio::select! {
            connected = connecting => connected,
            () = context.stop.stopped() => return Ended::Stopped,
        };
        let mut connection = match connected {
            Ok(connection) => connection,
            Err(error) => return Ended::Failed(error),
        };
        self.report_phase(&node, context);
        context.status.set_clients(1);
        let ended = self.publish_until_stopped(&mut node, &mut connection, context).await;
        self.host_at = node.host_at();
        match ended {
            Ok(last) => {
                // The broker publishes the will if this fails.
                connection.publish(last.death).await.ok();
                if let (true, Some(sent)) = (connection.close().await, last.sent) {
                    self.keep(sent, context);
                }
                if context.stop.is_stopped() { Ended::Stopped } else { Ended::Lost(MqttError::HostOffline) }
            }
            Err(MqttError::Closed) => Ended::Lost(connection.end().await),
            Err(error) => Ended::Lost(error),
        }
    }

    /// Where the edge node is connected, and whether it waits for its primary host.
    fn report_phase(&self, node: &EdgeNode, context: &Context) {
        let address = self.connector.address();
        match (&self.names.primary_host, node.phase()) {
            (Some(host), Phase::Subscribing | Phase::Waiting) => {
                context.status.runs(format!("{address} (waits for the primary host {host})"));
            }
            _ => context.status.runs(address),
        }
    }

    /// Publishes until the edge node is told to stop, or the primary host goes offline.
    async fn publish_until_stopped(
        &mut self,
        node: &mut EdgeNode,
        connection: &mut Connection,
        context: &mut Context,
    ) -> Result<Last, MqttError> {
        let mut snapshots = context.model.subscribe();
        let mut tick = interval(TICK);
        tick.set_missed_tick_behavior(MissedTickBehavior::Delay);
        let delivered = self.memory.delivered().unwrap_or_else(Micros::now);
        let mut progress = Progress { sent: delivered, pinged: None };
        let mut pending: Option<PendingRead> = None;
        loop {
            if node.phase() == Phase::Ready {
                self.report_phase(node, context);
                pending = self.begin(node, connection, context).await?;
                if pending.is_none() {
                    let messages = node.caught_up(Micros::now(), Micros::now());
                    connection.publish_all(messages, &context.status).await?;
                }
            }
            tokio::select! {
                () = context.stop.stopped() => return Ok(Last::of(node, &progress)),
                event = connection.event() => {
                    if let Some(death) = self.handle(event?, node, &mut progress, context) {
                        return Ok(Last { death, sent: None });
                    }
                    report_dropped(connection, context);
                }
                read = batch_of(&mut pending) => {
                    pending = self.publish_batch(node, read, connection, &mut progress, context).await?;
                }
                changed = snapshots.changed() => {
                    if changed.is_err() {
                        return Ok(Last::of(node, &progress));
                    }
                    let snapshot = Arc::clone(&snapshots.borrow_and_update());
                    let now = Micros::now();
                    let (messages, missed) = node.snapshot(&snapshot, now);
                    context.status.dropped_updates(missed);
                    connection.publish_all(messages, &context.status).await?;
                    if node.phase() == Phase::Live {
                        progress.sent = now;
                    }
                }
                _ = tick.tick() => {
                    let now = Micros::now();
                    if node.is_rebirth_due(now) {
                        let snapshot = context.model.snapshot();
                        let messages = node.births(&snapshot, &HashSet::new(), now);
                        connection.publish_all(messages, &context.status).await?;
                    }
                }
            }
        }
    }

    /// An event of the connection. Returns the NDEATH if the primary host has gone offline.
    fn handle(
        &mut self,
        event: Event,
        node: &mut EdgeNode,
        progress: &mut Progress,
        context: &Context,
    ) -> Option<Message> {
        match event {
            Event::Subscribed => node.subscribed(),
            Event::Ping => progress.pinged = Some(progress.sent),
            Event::Pong => {
                if let Some(delivered) = progress.pinged.take() {
                    self.keep(delivered, context);
                }
            }
            Event::Message { topic, payload } => match node.message(&topic, &payload, Micros::now()) {
                Reaction::None => {}
                Reaction::Refused(reason) => context.status.refused(&reason),
                Reaction::Disconnect(death) => return Some(death),
            },
        }
        None
    }

    /// Publishes the births and begins to read the backlog. Without a backlog there is nothing to read.
    async fn begin(
        &mut self,
        node: &mut EdgeNode,
        connection: &Connection,
        context: &Context,
    ) -> Result<Option<PendingRead>, MqttError> {
        let now = Micros::now();
        let snapshot = context.model.snapshot();
        let earliest = now.before(self.longest_backlog);
        let delivered = self.memory.delivered().map(|delivered| delivered.max(earliest));
        let opened = match delivered {
            // The first connection has no outage before it, and a clock that was set back gives none.
            None => None,
            Some(delivered) if delivered >= now => None,
            Some(delivered) => {
                let services = Arc::clone(&context.services);
                let series = series_of(&snapshot);
                let open = move || {
                    let mut backlog = Backlog::new(services.recorder().open_reader()?, series, delivered, now);
                    let with_samples = backlog.series()?;
                    Ok::<_, DatabaseError>((backlog, with_samples))
                };
                Some(spawn_blocking(open).await)
            }
        };
        let (backlog, with_samples) = match opened {
            Some(Ok(Ok((backlog, with_samples)))) => (Some(backlog), with_samples),
            Some(Ok(Err(error))) => {
                context.status.error(&unread(&error));
                (None, HashSet::new())
            }
            None | Some(Err(_)) => (None, HashSet::new()),
        };
        if delivered.is_none() {
            self.keep(now, context);
        }
        let messages = node.births(&snapshot, &with_samples, now);
        connection.publish_all(messages, &context.status).await?;
        Ok(backlog.map(read_next))
    }

    /// Publishes a batch and reads the next one.
    async fn publish_batch(
        &mut self,
        node: &mut EdgeNode,
        read: Result<Read, JoinError>,
        connection: &Connection,
        progress: &mut Progress,
        context: &Context,
    ) -> Result<Option<PendingRead>, MqttError> {
        let now = Micros::now();
        let (backlog, batch) = match read {
            Ok(read) => read,
            Err(error) => {
                context.status.error(&unread(&error));
                connection.publish_all(node.caught_up(now, now), &context.status).await?;
                return Ok(None);
            }
        };
        let (messages, goes_on) = match batch {
            Ok(Batch::Samples(samples)) => {
                progress.sent = samples.last().map_or(progress.sent, |(_, last)| last.at());
                (node.samples(&samples, now), true)
            }
            Ok(Batch::Wait) => (Vec::new(), true),
            Ok(Batch::CaughtUp(until)) => {
                progress.sent = until;
                (node.caught_up(until, now), false)
            }
            Err(error) => {
                context.status.error(&unread(&error));
                (node.caught_up(now, now), false)
            }
        };
        connection.publish_all(messages, &context.status).await?;
        Ok(goes_on.then(|| read_next(backlog)))
    }

    fn keep(&mut self, delivered: Micros, context: &Context) {
        if let Err(error) = self.memory.deliver(delivered) {
            context.status.error(&format!("the progress of the edge node cannot be kept beside the database: {error}"));
        }
    }
}

/// Reads the next batch in a thread for blocking work.
fn read_next(mut backlog: Backlog) -> PendingRead {
    spawn_blocking(move || {
        let batch = backlog.next(Micros::now());
        std::thread::sleep(BATCH_PAUSE);
        (backlog, batch)
    })
}

/// Counts commands that the gateway could not read in time.
fn report_dropped(connection: &Connection, context: &Context) {
    let dropped = connection.dropped();
    if dropped > 0 {
        context.status.refused(&format!("{dropped} commands came faster than they could be read"));
    }
}

/// The batch that is being read, or why its thread has ended; never without one. Cancelling it loses nothing.
async fn batch_of(reading: &mut Option<PendingRead>) -> Result<Read, JoinError> {
    match reading {
        Some(reading) => reading.await,
        None => pending().await,
    }
}

fn unread(error: &dyn Display) -> String {
    format!("the samples of the outage cannot be read and are not sent: {error}")
}

/// The series of these points, each once.
fn series_of(snapshot: &Snapshot) -> Vec<Series> {
    let mut seen = HashSet::new();
    let all = snapshot.points.iter().filter_map(Series::of);
    all.filter(|series| seen.insert(series.clone())).collect()
}
