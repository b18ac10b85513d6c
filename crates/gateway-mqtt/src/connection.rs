//! One connection to a broker, from CONNECT to its end. What it has not sent when it ends is gone: the next connection begins with the
//! present state, so nothing old is sent late.

use crate::message::{Delivery, Message};
use profivac_station::config::gateways::mqtt::{Broker, Tls};
use profivac_station::gateway_status::GatewayStatus;
use profivac_web_server::client_tls::trusting;
use profivac_web_server::tables::ca_certificates;
use rumqttc::tokio_rustls::rustls::pki_types::PrivateKeyDer;
use rumqttc::tokio_rustls::rustls::pki_types::pem::{self, PemObject};
use rumqttc::tokio_rustls::rustls::{self, ClientConfig};
use rumqttc::{
    AsyncClient, ConnectReturnCode, ConnectionError, EventLoop, Incoming, LastWill, MqttOptions, Outgoing, QoS,
    StateError, SubscribeFilter, SubscribeReasonCode, TlsConfiguration, TlsError, Transport,
};
use std::path::PathBuf;
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::Duration;
use tokio::sync::mpsc;
use tokio::task::JoinHandle;
use tokio::time::timeout;

/// The keep-alive time. A broker that is silent for two of them is gone. chosen: an outage is noticed within 20 s.
const KEEP_ALIVE: Duration = Duration::from_secs(10);

/// The messages between the gateway and the socket. Short, because they are older than the newest value.
const QUEUE: usize = 8;

/// The events that wait for the gateway; further messages of others are dropped.
const EVENTS: usize = 64;

/// The places among them for what belongs to the connection itself: SUBACK, PINGREQ, PINGRESP.
const RESERVED: usize = 8;

/// The largest message that is sent: a birth of ten thousand points has two megabytes.
const MAX_SENT: usize = 64 << 20;

/// The largest message that is accepted. A larger one ends the connection.
const MAX_RECEIVED: usize = 16 << 20;

/// The longest time for the last messages before the connection is closed.
const CLOSE_TIMEOUT: Duration = Duration::from_secs(1);

/// The reason why there is no connection.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum MqttError {
    /// The broker refuses user and password.
    #[error("the broker refuses the login of {user:?}: check user and password in the file that credentials names")]
    Login {
        /// The user.
        user: String,
    },
    /// The broker wants a user, and the file has none.
    #[error("the broker wants a login: add credentials to [mqtt]")]
    NoLogin,
    /// The broker speaks another version of MQTT.
    #[error("the broker refuses the connection: it does not speak MQTT 3.1.1")]
    Version,
    /// The broker does not accept the client identifier.
    #[error("the broker refuses the connection: it does not accept the client identifier; set client-id")]
    ClientId,
    /// The broker has no service at the moment.
    #[error("the broker refuses the connection: its service is unavailable")]
    Unavailable,
    /// The broker cannot be reached.
    #[error("the broker cannot be reached: {0}")]
    Unreachable(std::io::Error),
    /// The broker accepts a TCP connection and says nothing, or takes no more data.
    #[error("the broker does not answer")]
    Silent,
    /// No secure connection.
    #[error("there is no secure connection to the broker: {0}")]
    Tls(TlsError),
    /// The broker has closed the connection.
    #[error(
        "the broker has closed the connection; it also does so when another client connects with the same client-id"
    )]
    Closed,
    /// The broker does not permit a subscription.
    #[error("the broker does not permit to subscribe to {0}: change its access list")]
    Subscription(String),
    /// The primary host of Sparkplug is offline.
    #[error("the primary host is offline")]
    HostOffline,
    /// The broker breaks the protocol.
    #[error("the connection to the broker has failed: {0}")]
    Protocol(Box<ConnectionError>),
    /// The certificates of the system or of the file cannot be used.
    #[error(transparent)]
    Rustls(#[from] rustls::Error),
    /// A file with certificates cannot be read any more.
    #[error(transparent)]
    Certificates(#[from] profivac_web_server::tables::CertificateError),
    /// The file with the key cannot be read any more.
    #[error("{file} holds no private key: {error}", file = file.display())]
    Key {
        /// The file.
        file: PathBuf,
        /// The error of the parser.
        error: pem::Error,
    },
}

/// How to connect: the brokers and the certificates that the file names.
#[derive(Clone)]
pub struct Connector {
    broker: Broker,
    /// The position of the broker that is used now.
    position: usize,
    tls: Option<Arc<ClientConfig>>,
}

impl Connector {
    /// Reads the certificates.
    ///
    /// # Errors
    /// [`MqttError`] when a certificate or key cannot be read.
    pub fn new(broker: Broker) -> Result<Self, MqttError> {
        let tls = broker.tls.as_ref().map(client_config).transpose()?;
        Ok(Self { broker, position: 0, tls })
    }

    /// Host and port of the present broker.
    fn host_and_port(&self) -> (&str, u16) {
        self.broker.addresses().nth(self.position).unwrap_or((&self.broker.host, self.broker.port))
    }

    /// Goes on to the next broker. False when it is the first one again: all were tried.
    pub fn advance(&mut self) -> bool {
        self.position = self.position.saturating_add(1) % self.broker.addresses().count();
        self.position != 0
    }

    /// Host and port of the present broker, as a URL.
    #[must_use]
    pub fn address(&self) -> String {
        let (host, port) = self.host_and_port();
        let scheme = if self.broker.tls.is_some() { "mqtts" } else { "mqtt" };
        let host = if host.contains(':') { format!("[{host}]") } else { host.to_owned() };
        format!("{scheme}://{host}:{port}")
    }

    /// Connects with this will and subscribes.
    ///
    /// # Errors
    /// [`MqttError`] says why there is no connection.
    pub async fn connect(
        &self,
        client_id: String,
        will: Message,
        subscriptions: Vec<String>,
    ) -> Result<Connection, MqttError> {
        // An IPv6 address has no brackets here: the library compares it with the certificate, too.
        let (host, port) = self.host_and_port();
        let mut options = MqttOptions::new(client_id, host, port);
        options.set_keep_alive(KEEP_ALIVE).set_clean_session(true).set_max_packet_size(MAX_RECEIVED, MAX_SENT);
        options.set_last_will(LastWill::new(will.topic, will.payload, qos(will.delivery), will.is_retained));
        if let Some(credentials) = &self.broker.credentials {
            options.set_credentials(&credentials.user, credentials.password.reveal());
        }
        if let Some(tls) = &self.tls {
            options.set_transport(Transport::tls_with_config(TlsConfiguration::Rustls(Arc::clone(tls))));
        }
        let (client, mut events) = AsyncClient::new(options, QUEUE);
        // The first event is CONNACK, or an error.
        events.poll().await.map_err(|error| self.explain(error))?;
        if !subscriptions.is_empty() {
            let filters = subscriptions.iter().map(|topic| SubscribeFilter::new(topic.clone(), QoS::AtLeastOnce));
            client.subscribe_many(filters).await.map_err(|_| MqttError::Closed)?;
        }
        let (sender, receiver) = mpsc::channel(EVENTS);
        let dropped = Arc::new(AtomicU64::new(0));
        let task = tokio::spawn(receive(events, sender, Arc::clone(&dropped)));
        Ok(Connection { connector: self.clone(), client, events: receiver, task, subscriptions, dropped })
    }

    fn explain(&self, error: ConnectionError) -> MqttError {
        match error {
            ConnectionError::ConnectionRefused(code) => self.refused(code),
            ConnectionError::Io(error) | ConnectionError::MqttState(StateError::Io(error)) => closed(error),
            ConnectionError::Tls(TlsError::Io(error)) if error.get_ref().is_none() => closed(error),
            ConnectionError::Tls(error) => MqttError::Tls(error),
            ConnectionError::NetworkTimeout
            | ConnectionError::FlushTimeout
            | ConnectionError::MqttState(StateError::AwaitPingResp) => MqttError::Silent,
            ConnectionError::MqttState(StateError::ConnectionAborted) | ConnectionError::RequestsDone => {
                MqttError::Closed
            }
            other => MqttError::Protocol(Box::new(other)),
        }
    }

    fn refused(&self, code: ConnectReturnCode) -> MqttError {
        match (code, &self.broker.credentials) {
            (ConnectReturnCode::BadUserNamePassword | ConnectReturnCode::NotAuthorized, Some(credentials)) => {
                MqttError::Login { user: credentials.user.clone() }
            }
            (ConnectReturnCode::BadUserNamePassword | ConnectReturnCode::NotAuthorized, None) => MqttError::NoLogin,
            (ConnectReturnCode::RefusedProtocolVersion, _) => MqttError::Version,
            (ConnectReturnCode::BadClientId, _) => MqttError::ClientId,
            (ConnectReturnCode::ServiceUnavailable | ConnectReturnCode::Success, _) => MqttError::Unavailable,
        }
    }
}

/// A connection that was there and ended, or one that never was.
fn closed(error: std::io::Error) -> MqttError {
    match error.kind() {
        std::io::ErrorKind::ConnectionAborted
        | std::io::ErrorKind::ConnectionReset
        | std::io::ErrorKind::BrokenPipe
        | std::io::ErrorKind::UnexpectedEof => MqttError::Closed,
        _ => MqttError::Unreachable(error),
    }
}

fn client_config(tls: &Tls) -> Result<Arc<ClientConfig>, MqttError> {
    let config = trusting(tls.ca_file.as_deref().map(ca_certificates).transpose()?.unwrap_or_default())?;
    Ok(Arc::new(match &tls.client {
        None => config.with_no_client_auth(),
        Some((certificate, key)) => {
            let private =
                PrivateKeyDer::from_pem_file(key).map_err(|error| MqttError::Key { file: key.clone(), error })?;
            config.with_client_auth_cert(ca_certificates(certificate)?, private)?
        }
    }))
}

const fn qos(delivery: Delivery) -> QoS {
    match delivery {
        Delivery::AtMostOnce => QoS::AtMostOnce,
        Delivery::AtLeastOnce => QoS::AtLeastOnce,
    }
}

/// An event of a connection.
#[derive(Debug)]
pub enum Event {
    /// The broker has accepted all subscriptions.
    Subscribed,
    /// A message of a subscription.
    Message {
        /// The topic.
        topic: String,
        /// The content.
        payload: Vec<u8>,
    },
    /// A PINGREQ was sent behind all messages before it.
    Ping,
    /// The broker has answered it, so it has got all messages before it.
    Pong,
}

/// What the task of a connection reports.
enum Report {
    Event(Event),
    Refused(usize),
    Ended(ConnectionError),
}

/// A connection to a broker.
pub struct Connection {
    connector: Connector,
    client: AsyncClient,
    events: mpsc::Receiver<Report>,
    task: JoinHandle<bool>,
    subscriptions: Vec<String>,
    dropped: Arc<AtomicU64>,
}

impl Connection {
    /// Hands a message to the socket; waits while it takes none.
    ///
    /// # Errors
    /// [`MqttError::Closed`] when the connection has ended; [`Self::event`] has the reason.
    pub async fn publish(&self, message: Message) -> Result<(), MqttError> {
        let Message { topic, payload, delivery, is_retained } = message;
        self.client.publish(topic, qos(delivery), is_retained, payload).await.map_err(|_| MqttError::Closed)
    }

    /// Publishes messages one after the other and counts them.
    ///
    /// # Errors
    /// As [`Self::publish`]; then none of the messages is counted.
    pub async fn publish_all(&self, messages: Vec<Message>, status: &GatewayStatus) -> Result<(), MqttError> {
        let count = messages.len();
        for message in messages {
            self.publish(message).await?;
        }
        status.sent(count as u64);
        Ok(())
    }

    /// The next event. Cancelling it loses nothing.
    ///
    /// # Errors
    /// The reason why the connection has ended.
    pub async fn event(&mut self) -> Result<Event, MqttError> {
        match self.events.recv().await {
            Some(Report::Event(event)) => Ok(event),
            Some(Report::Refused(index)) => {
                Err(MqttError::Subscription(self.subscriptions.get(index).cloned().unwrap_or_default()))
            }
            Some(Report::Ended(error)) => Err(self.connector.explain(error)),
            None => Err(MqttError::Closed),
        }
    }

    /// The reason why publishing has failed.
    pub async fn end(&mut self) -> MqttError {
        loop {
            if let Err(error) = self.event().await {
                return error;
            }
        }
    }

    /// The messages of others that were dropped because the gateway was busy, since the last call.
    pub fn dropped(&self) -> u64 {
        self.dropped.swap(0, Ordering::Relaxed)
    }

    /// Sends what waits, and DISCONNECT, so that the broker discards the will. Returns whether the socket has taken all of it.
    pub async fn close(mut self) -> bool {
        timeout(CLOSE_TIMEOUT, self.client.disconnect()).await.is_ok_and(|sent| sent.is_ok())
            && timeout(CLOSE_TIMEOUT, &mut self.task).await.is_ok_and(|ended| ended.is_ok_and(|sent| sent))
    }
}

impl Drop for Connection {
    fn drop(&mut self) {
        self.task.abort();
    }
}

/// Serves the connection until it ends, and returns whether DISCONNECT was sent. It never waits for the gateway: otherwise both could
/// wait for each other. What belongs to the connection itself has places that messages of others cannot take.
async fn receive(mut events: EventLoop, sender: mpsc::Sender<Report>, dropped: Arc<AtomicU64>) -> bool {
    loop {
        let report = match events.poll().await {
            Ok(rumqttc::Event::Incoming(Incoming::Publish(publish))) => {
                Report::Event(Event::Message { topic: publish.topic, payload: publish.payload.to_vec() })
            }
            Ok(rumqttc::Event::Incoming(Incoming::SubAck(answer))) => {
                let refused = answer.return_codes.iter().position(|code| *code == SubscribeReasonCode::Failure);
                refused.map_or(Report::Event(Event::Subscribed), Report::Refused)
            }
            Ok(rumqttc::Event::Outgoing(Outgoing::PingReq)) => Report::Event(Event::Ping),
            Ok(rumqttc::Event::Incoming(Incoming::PingResp)) => Report::Event(Event::Pong),
            Ok(rumqttc::Event::Outgoing(Outgoing::Disconnect)) => return true,
            Ok(_) => continue,
            Err(error) => {
                // The gateway may be publishing, which fails as soon as the queue of messages is gone; then it fetches the reason.
                drop(events);
                sender.send(Report::Ended(error)).await.ok();
                return false;
            }
        };
        offer(&sender, report, &dropped);
    }
}

/// Queues a report, or drops and counts it.
fn offer(sender: &mpsc::Sender<Report>, report: Report, dropped: &AtomicU64) {
    let is_message = matches!(report, Report::Event(Event::Message { .. }));
    if is_message && sender.capacity() <= RESERVED || sender.try_send(report).is_err() {
        dropped.fetch_add(1, Ordering::Relaxed);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::io::Write;
    use std::net::{Shutdown, TcpListener};

    /// Accepts one client, answers a subscription a thousand times without a question, and then ends.
    fn confusing_broker() -> Broker {
        let listener = TcpListener::bind(("127.0.0.1", 0)).unwrap();
        let port = listener.local_addr().unwrap().port();
        std::thread::spawn(move || {
            let (mut client, _) = listener.accept().unwrap();
            client.write_all(&[0x20, 2, 0, 0]).unwrap();
            client.write_all(&[0x90, 3, 0xFF, 0xFF, 0x80].repeat(1000)).unwrap();
            client.shutdown(Shutdown::Write).unwrap();
            // An unread octet would reset the connection before the client has read everything.
            std::io::copy(&mut client, &mut std::io::sink()).ok();
        });
        Broker { host: "127.0.0.1".into(), port, tls: None, credentials: None, client_id: None, standby: Vec::new() }
    }

    #[tokio::test]
    async fn publishing_fails_when_the_broker_is_gone_and_its_answers_still_wait() {
        let message = || Message {
            topic: "topic".to_owned(),
            payload: Vec::new(),
            delivery: Delivery::AtMostOnce,
            is_retained: false,
        };
        let connector = Connector::new(confusing_broker()).unwrap();
        let mut connection = connector.connect("client".to_owned(), message(), Vec::new()).await.unwrap();
        let ended = timeout(Duration::from_secs(60), async { while connection.publish(message()).await.is_ok() {} });
        ended.await.expect("the gateway waits for a connection that has ended");
        assert!(matches!(connection.end().await, MqttError::Subscription(_)));
    }

    #[tokio::test]
    async fn messages_of_others_leave_room_for_the_answers_of_the_broker() {
        let (sender, mut reports) = mpsc::channel(EVENTS);
        let dropped = AtomicU64::new(0);
        let message = || Report::Event(Event::Message { topic: "other".to_owned(), payload: Vec::new() });
        (0..2 * EVENTS).for_each(|_| offer(&sender, message(), &dropped));
        assert_eq!(dropped.load(Ordering::Relaxed), (EVENTS + RESERVED) as u64);
        offer(&sender, Report::Event(Event::Subscribed), &dropped);
        offer(&sender, Report::Event(Event::Pong), &dropped);
        drop(sender);
        let mut last = Vec::new();
        while let Some(report) = reports.recv().await {
            last.push(report);
        }
        assert!(matches!(
            last.as_slice(),
            [.., Report::Event(Event::Subscribed), Report::Event(Event::Pong)] if last.len() == EVENTS - RESERVED + 2
        ));
    }
}
