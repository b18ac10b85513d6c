//! Connecting again and again until the gateway is told to stop.

use crate::connection::{Connector, MqttError};
use profivac_gateway::thread::Context;
use std::time::Duration;
use tokio::time::{Instant, sleep};

/// The pauses between two attempts.
const FIRST_PAUSE: Duration = Duration::from_secs(1);
const LONGEST_PAUSE: Duration = Duration::from_secs(30);

/// A session that lasted this long worked, so the next pause is the first one again. Two gateways with one client-id end each other's
/// sessions at once, and may not do so every second for ever.
const WORKING_SESSION: Duration = Duration::from_secs(30);

/// How a session has ended.
pub enum Ended {
    /// The gateway was told to stop.
    Stopped,
    /// A session that worked has ended.
    Lost(MqttError),
    /// There was no session.
    Failed(MqttError),
}

/// The pauses between the sessions with a broker.
pub struct Retry {
    pause: Duration,
    /// When the present session was begun.
    begun: Instant,
}

impl Retry {
    pub fn new() -> Self {
        Self { pause: FIRST_PAUSE, begun: Instant::now() }
    }

    /// Reports the end of a session, goes on to the next broker, and waits once all of them have failed. False when there is no next
    /// session.
    pub async fn goes_on(&mut self, ended: Ended, connector: &mut Connector, context: &mut Context) -> bool {
        let error = match ended {
            Ended::Stopped => return false,
            Ended::Lost(error) => {
                if self.begun.elapsed() >= WORKING_SESSION {
                    self.pause = FIRST_PAUSE;
                }
                error
            }
            Ended::Failed(error) => error,
        };
        context.status.fails(&format!("{}: {error}", connector.address()));
        if connector.advance() {
            self.begun = Instant::now();
            return !context.stop.is_stopped();
        }
        tokio::select! {
            () = sleep(self.pause) => {}
            () = context.stop.stopped() => return false,
        }
        self.pause = self.pause.saturating_mul(2).min(LONGEST_PAUSE);
        self.begun = Instant::now();
        true
    }
}
