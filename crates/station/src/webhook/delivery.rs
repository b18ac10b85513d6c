//! The thread that delivers the letters to one webhook.

use super::client::Client;
use crate::config::{Secret, Webhook, ca_certificates};
use crate::services::Services;
use profivac_recorder::alarms::{AlarmBatch, Notification};
use profivac_recorder::{DatabaseError, EventKind, Micros};
use std::collections::BTreeSet;
use std::sync::Arc;
use std::thread::JoinHandle;
use std::time::Duration;
use tokio::runtime::Builder;
use tokio::sync::oneshot;
use tokio::time::{sleep, timeout};

/// How patient a courier is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct DeliverySettings {
    /// How often it looks for new letters.
    pub poll_interval: Duration,
    /// How long an answer may take, from the first packet on.
    pub answer_timeout: Duration,
    /// The pause after the first failure; each further one is twice as long.
    pub first_pause: Duration,
    /// The longest pause.
    pub longest_pause: Duration,
    /// A letter that is older is given up.
    pub max_age: Duration,
    /// Of more letters the oldest are given up.
    pub max_queued: usize,
}

impl Default for DeliverySettings {
    /// free choice: told within a second where all is well, quick after an interruption, no burden on who is in trouble, and nothing
    /// that is told a day later is news.
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

/// These answers say that the letter itself is not understood: it will not be the next time.
const PERMANENT_REFUSALS: [u16; 3] = [400, 413, 422];

/// Somebody who delivers. Ends when this is dropped.
pub struct DeliveryThread {
    webhook: Webhook,
    plant: Arc<Services>,
    stop: Option<oneshot::Sender<()>>,
    thread: Option<JoinHandle<()>>,
}

impl DeliveryThread {
    /// Begins to deliver.
    ///
    /// # Errors
    /// When the system gives no thread.
    pub fn start(webhook: Webhook, plant: Arc<Services>, patience: DeliverySettings) -> std::io::Result<Self> {
        let runtime = Builder::new_current_thread().enable_io().enable_time().build()?;
        let (stop, stopped) = oneshot::channel::<()>();
        let round = Delivery { webhook: webhook.clone(), plant: Arc::clone(&plant), patience, gone: BTreeSet::new() };
        plant.webhooks().begin(&webhook.name, webhook.origin());
        let thread = std::thread::Builder::new().name("webhook".to_owned()).spawn(move || {
            runtime.block_on(async {
                tokio::select! {
                    () = round.run() => {}
                    _ = stopped => {}
                }
            });
            // A name that is being looked up is not waited for.
            runtime.shutdown_background();
        })?;
        Ok(Self { webhook, plant, stop: Some(stop), thread: Some(thread) })
    }

    /// To whom.
    #[must_use]
    pub const fn webhook(&self) -> &Webhook {
        &self.webhook
    }

    /// Whether its thread has ended, which only a defect can bring about.
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
        self.plant.webhooks().end(&self.webhook.name);
    }
}

struct Delivery {
    webhook: Webhook,
    plant: Arc<Services>,
    patience: DeliverySettings,
    /// Letters that nobody waits for any more and whose deletion may not be on the disk yet. With their times: a record that was
    /// deleted is begun again, and counts from one again.
    gone: BTreeSet<(i64, Micros)>,
}

impl Delivery {
    /// For ever.
    async fn run(mut self) {
        let client = match self.client() {
            Ok(client) => client,
            Err(problem) => return self.fails(&problem),
        };
        let mut pause = self.patience.first_pause;
        loop {
            match self.next() {
                Ok(Some(letter)) => match self.deliver(&client, &letter).await {
                    Ok(()) => pause = self.patience.first_pause,
                    Err(problem) => {
                        self.fails(&problem);
                        sleep(pause).await;
                        pause = pause.saturating_mul(2).min(self.patience.longest_pause);
                    }
                },
                Ok(None) => sleep(self.patience.poll_interval).await,
                Err(error) => {
                    self.fails(&error.to_string());
                    sleep(self.patience.poll_interval).await;
                }
            }
        }
    }

    fn client(&self) -> Result<Client, String> {
        let trusted = self
            .webhook
            .ca_file
            .as_deref()
            .map(ca_certificates)
            .transpose()
            .map_err(|error| error.to_string())?
            .unwrap_or_default();
        Client::new(self.webhook.url.clone(), self.webhook.token.as_ref().map(Secret::reveal), trusted)
    }

    /// The next letter, once those were given up that are too old or too many.
    fn next(&mut self) -> Result<Option<Notification>, DatabaseError> {
        let reader = self.plant.open_reader()?;
        let there: BTreeSet<_> = reader.queued_notifications(&self.webhook.name)?.into_iter().collect();
        self.gone.retain(|letter| there.contains(letter));
        let mut waiting: Vec<_> = there.difference(&self.gone).copied().collect();
        let rest = waiting.split_off(waiting.len().saturating_sub(self.patience.max_queued));
        self.give_up(&waiting, "there are too many");
        let oldest = Micros::now().before(self.patience.max_age);
        let (old, rest): (Vec<_>, Vec<_>) = rest.into_iter().partition(|(_, at)| *at < oldest);
        self.give_up(&old, "it is too old");
        rest.first().map_or(Ok(None), |(id, _)| reader.notification(*id))
    }

    async fn deliver(&mut self, client: &Client, letter: &Notification) -> Result<(), String> {
        let answer = timeout(self.patience.answer_timeout, client.post(numbered(letter))).await;
        let status = answer.map_err(|_| format!("no answer in {} s", self.patience.answer_timeout.as_secs_f64()))??;
        match status {
            200..=299 => {
                self.done(&[(letter.id, letter.at)]);
                if self.plant.webhooks().delivered(&self.webhook.name) {
                    self.remark("takes letters again");
                }
                Ok(())
            }
            status if PERMANENT_REFUSALS.contains(&status) => {
                self.give_up(&[(letter.id, letter.at)], &format!("the answer is {status}"));
                Ok(())
            }
            status => Err(format!("the answer is {status}")),
        }
    }

    fn fails(&self, problem: &str) {
        if self.plant.webhooks().failed(&self.webhook.name, problem) {
            self.remark(&format!("takes no letters: {problem}; it is tried again"));
        }
    }

    fn give_up(&mut self, letters: &[(i64, Micros)], why: &str) {
        if !letters.is_empty() {
            self.done(letters);
            self.plant.webhooks().gave_up(&self.webhook.name, letters.len());
            self.remark(&format!("was not told of {} letters: {why}", letters.len()));
        }
    }

    /// Nobody waits for these any more. A deletion that finds no room is made up for when the station begins again: the letter is then
    /// told once more.
    fn done(&mut self, letters: &[(i64, Micros)]) {
        self.gone.extend(letters);
        let gone = letters.iter().map(|(id, _)| *id).collect();
        let _room = self
            .plant
            .recorder()
            .record_alarms(AlarmBatch { finished_notifications: gone, ..AlarmBatch::default() }, Vec::new());
    }

    fn remark(&self, what: &str) {
        self.plant.record_event(None, EventKind::Alarm, format!("webhook {:?} {what}", self.webhook.name));
    }
}

/// The letter with its number, by which whoever gets it twice knows it again.
fn numbered(letter: &Notification) -> String {
    let id = format!("{}-{}", letter.at.0, letter.id);
    // What we have written ourselves is an object.
    match serde_json::from_str(&letter.body) {
        Ok(serde_json::Value::Object(mut body)) => {
            body.insert("id".to_owned(), id.into());
            serde_json::Value::Object(body).to_string()
        }
        _ => letter.body.clone(),
    }
}
