//! The thread that delivers the notifications of one webhook or e-mail.

use super::client::{Client, ClientSetupError};
use super::email::{MailError, Mailer};
use super::receiver::Receiver;
use super::status::DeliveryStatus;
use crate::recording::RecorderHandle;
use profivac_recorder::alarms::{AlarmBatch, Notification};
use profivac_recorder::{DatabaseError, EventKind, Micros};
use profivac_web_server::http_client::RequestError;
use profivac_web_server::tables::{CertificateError, Secret, ca_certificates};
use std::collections::BTreeSet;
use std::fmt::Display;
use std::sync::Arc;
use std::thread::JoinHandle;
use std::time::Duration;
use tokio::runtime::Builder;
use tokio::sync::oneshot;
use tokio::time::{sleep, timeout};

/// Timeouts and limits of a delivery.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct DeliverySettings {
    /// The time between two looks into an empty queue.
    pub poll_interval: Duration,
    /// The longest wait for an answer, from the first packet on.
    pub answer_timeout: Duration,
    /// The pause after the first failure; each further pause is twice as long.
    pub first_pause: Duration,
    /// The longest pause.
    pub longest_pause: Duration,
    /// An older notification is given up. Its age counts recorded time: a clock that is set makes no notification old.
    pub max_age: Duration,
    /// When more notifications wait, the oldest are given up.
    pub max_queued: usize,
}

impl Default for DeliverySettings {
    /// chosen: delivered within a second, resumed soon after an interruption, no load on a failing server, and a
    /// notification of yesterday is no news.
    fn default() -> Self {
        Self {
            poll_interval: Duration::from_millis(500),
            answer_timeout: Duration::from_secs(10),
            first_pause: Duration::from_secs(1),
            longest_pause: Duration::from_secs(300),
            max_age: Duration::from_secs(86_400),
            max_queued: 10_000,
        }
    }
}

/// With these statuses the server refuses the notification itself, and would refuse it again.
const PERMANENT_REFUSALS: [u16; 3] = [400, 413, 422];

/// An e-mail may take this many times the answer timeout of a webhook. chosen: a minute.
const MAIL_TIMEOUT_FACTOR: u32 = 6;

/// The reason why a notification was not delivered.
#[derive(Debug, thiserror::Error)]
enum DeliveryError {
    /// The file with further certificates.
    #[error(transparent)]
    Certificates(#[from] CertificateError),
    /// The client.
    #[error(transparent)]
    Setup(#[from] ClientSetupError),
    /// No answer.
    #[error(transparent)]
    Post(#[from] RequestError),
    /// No answer in time.
    #[error("no answer in {} s", .0.as_secs_f64())]
    Timeout(Duration),
    /// An answer other than success.
    #[error("the answer is {0}")]
    Status(u16),
    /// The mail server.
    #[error(transparent)]
    Mail(#[from] MailError),
}

impl DeliveryError {
    /// Whether the server refuses the notification itself, and would refuse it again.
    fn is_about_notification(&self) -> bool {
        match self {
            Self::Status(status) => PERMANENT_REFUSALS.contains(status),
            Self::Mail(error) => error.is_about_message(),
            Self::Certificates(_) | Self::Setup(_) | Self::Post(_) | Self::Timeout(_) => false,
        }
    }
}

/// A client of one receiver.
enum Sender {
    Http(Box<Client>),
    Mail(Box<Mailer>),
}

impl Sender {
    async fn send(&self, notification: &Notification) -> Result<(), DeliveryError> {
        match self {
            Self::Http(client) => match client.post(with_id(notification)).await? {
                200..=299 => Ok(()),
                status => Err(DeliveryError::Status(status)),
            },
            Self::Mail(mailer) => Ok(mailer.send(notification).await?),
        }
    }
}

/// A running delivery. Ends when it is dropped.
pub struct DeliveryThread {
    receiver: Receiver,
    status: Arc<DeliveryStatus>,
    stop: Option<oneshot::Sender<()>>,
    thread: Option<JoinHandle<()>>,
}

impl DeliveryThread {
    /// Starts to deliver.
    ///
    /// # Errors
    /// When the system gives no thread.
    pub fn start(
        receiver: impl Into<Receiver>,
        recorder: Arc<RecorderHandle>,
        status: Arc<DeliveryStatus>,
        settings: DeliverySettings,
    ) -> std::io::Result<Self> {
        let receiver = receiver.into();
        let runtime = Builder::new_current_thread().enable_io().enable_time().build()?;
        let (stop, stopped) = oneshot::channel::<()>();
        status.add(receiver.name(), receiver.kind(), receiver.origin());
        let delivery = Delivery {
            receiver: receiver.clone(),
            recorder,
            status: Arc::clone(&status),
            settings,
            finished: BTreeSet::new(),
        };
        let thread = std::thread::Builder::new().name("webhook".to_owned()).spawn(move || {
            runtime.block_on(async {
                tokio::select! {
                    () = delivery.run() => {}
                    _ = stopped => {}
                }
            });
            // Does not wait for a name that is being resolved.
            runtime.shutdown_background();
        })?;
        Ok(Self { receiver, status, stop: Some(stop), thread: Some(thread) })
    }

    /// The webhook or e-mail.
    #[must_use]
    pub const fn receiver(&self) -> &Receiver {
        &self.receiver
    }

    /// Whether the thread has ended, which only a defect can cause.
    #[must_use]
    pub fn has_ended(&self) -> bool {
        self.thread.as_ref().is_none_or(JoinHandle::is_finished)
    }
}

impl Drop for DeliveryThread {
    fn drop(&mut self) {
        self.stop = None;
        if let Some(thread) = self.thread.take() {
            thread.join().ok();
        }
        self.status.remove(self.receiver.name());
    }
}

/// The state of the thread.
struct Delivery {
    receiver: Receiver,
    recorder: Arc<RecorderHandle>,
    status: Arc<DeliveryStatus>,
    settings: DeliverySettings,
    /// Finished notifications whose deletion may not be on the disk yet, by number and time: a database that was deleted and
    /// created again counts from one.
    finished: BTreeSet<(i64, Micros)>,
}

impl Delivery {
    /// Delivers without end.
    async fn run(mut self) {
        let mut pause = self.settings.first_pause;
        let client = loop {
            match self.client() {
                Ok(client) => break client,
                Err(error) => self.pause_after(&error, &mut pause).await,
            }
        };
        pause = self.settings.first_pause;
        loop {
            match self.next() {
                Ok(Some(notification)) => match self.deliver(&client, &notification).await {
                    Ok(()) => pause = self.settings.first_pause,
                    Err(error) => self.pause_after(&error, &mut pause).await,
                },
                Ok(None) => sleep(self.settings.poll_interval).await,
                Err(error) => {
                    self.report_failure(&error);
                    sleep(self.settings.poll_interval).await;
                }
            }
        }
    }

    /// Reports a failure and waits; the next pause is twice as long.
    async fn pause_after(&self, error: &DeliveryError, pause: &mut Duration) {
        self.report_failure(error);
        sleep(*pause).await;
        *pause = pause.saturating_mul(2).min(self.settings.longest_pause);
    }

    /// The client with the certificates that the file holds now.
    fn client(&self) -> Result<Sender, DeliveryError> {
        let trusted = self.receiver.ca_file().map(ca_certificates).transpose()?.unwrap_or_default();
        Ok(match &self.receiver {
            Receiver::Webhook(webhook) => {
                let token = webhook.token.as_ref().map(Secret::reveal);
                Sender::Http(Box::new(Client::new(webhook.url.clone(), token, trusted)?))
            }
            Receiver::Email(email) => {
                Sender::Mail(Box::new(Mailer::new(email.clone(), trusted, self.answer_timeout())?))
            }
        })
    }

    /// The longest wait. A mail server may greet late on purpose, and answers each line of a dialogue.
    fn answer_timeout(&self) -> Duration {
        let factor = if matches!(self.receiver, Receiver::Email(_)) { MAIL_TIMEOUT_FACTOR } else { 1 };
        self.settings.answer_timeout.saturating_mul(factor)
    }

    /// The next notification. Gives up those that are too old or too many.
    fn next(&mut self) -> Result<Option<Notification>, DatabaseError> {
        let reader = self.recorder.open_reader()?;
        let queued: BTreeSet<_> = reader.queued_notifications(self.receiver.name())?.into_iter().collect();
        self.finished.retain(|notification| queued.contains(notification));
        let mut waiting: Vec<_> = queued.difference(&self.finished).copied().collect();
        let rest = waiting.split_off(waiting.len().saturating_sub(self.settings.max_queued));
        self.give_up(&waiting, "too many wait");
        let expired = reader.expired(self.settings.max_age, Micros::now())?;
        let (old, rest): (Vec<_>, Vec<_>) = rest.into_iter().partition(|(_, at)| expired.contains(*at));
        self.give_up(&old, "too old");
        rest.first().map_or(Ok(None), |(id, _)| reader.notification(*id))
    }

    async fn deliver(&mut self, client: &Sender, notification: &Notification) -> Result<(), DeliveryError> {
        let answer_timeout = self.answer_timeout();
        let answer = timeout(answer_timeout, client.send(notification)).await;
        match answer.unwrap_or(Err(DeliveryError::Timeout(answer_timeout))) {
            Ok(()) => {
                self.finish(&[(notification.id, notification.at)]);
                if self.status.delivered(self.receiver.name()) {
                    self.record_event("accepts notifications again");
                }
                Ok(())
            }
            Err(error) if error.is_about_notification() => {
                self.give_up(&[(notification.id, notification.at)], &error.to_string());
                Ok(())
            }
            Err(error) => Err(error),
        }
    }

    fn report_failure(&self, error: &dyn Display) {
        let problem = error.to_string();
        if self.status.failed(self.receiver.name(), &problem) {
            self.record_event(&format!("accepts no notifications: {problem}; the station tries again"));
        }
    }

    fn give_up(&mut self, notifications: &[(i64, Micros)], reason: &str) {
        if !notifications.is_empty() {
            self.finish(notifications);
            self.status.gave_up(self.receiver.name(), notifications.len());
            let plural = if notifications.len() == 1 { "" } else { "s" };
            self.record_event(&format!("did not get {} notification{plural}: {reason}", notifications.len()));
        }
    }

    /// Deletes notifications. A deletion for which the recorder has no room happens after the next start: the notification is
    /// then delivered twice.
    fn finish(&mut self, notifications: &[(i64, Micros)]) {
        self.finished.extend(notifications);
        let finished_notifications = notifications.iter().map(|(id, _)| *id).collect();
        let batch = AlarmBatch { finished_notifications, ..AlarmBatch::default() };
        let _queued = self.recorder.record_alarms(batch, Vec::new());
    }

    fn record_event(&self, sentence: &str) {
        let text = format!("{} {:?} {sentence}", self.receiver.kind().word(), self.receiver.name());
        self.recorder.event_now(None, EventKind::Alarm, text);
    }
}

/// The body of a notification with its id, by which the server recognises a repeated delivery.
fn with_id(notification: &Notification) -> String {
    let id = format!("{}-{}", notification.at.0, notification.id);
    // The station has written the body, so it is an object.
    match serde_json::from_str(&notification.body) {
        Ok(serde_json::Value::Object(mut body)) => {
            body.insert("id".to_owned(), id.into());
            serde_json::Value::Object(body).to_string()
        }
        _ => notification.body.clone(),
    }
}
