//! Connecting again and again until the gateway is told to stop.

use crate::connection::{Connector, MqttError};
use profivac_gateway::thread::Context;
use std::time::Duration;
use tokio::time::sleep;

/// The pauses between two attempts.
const FIRST_PAUSE: Duration = Duration::from_secs(1);
const LONGEST_PAUSE: Duration = Duration::from_secs(30);

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
}

impl Retry {
    pub const fn new() -> Self {
        Self { pause: FIRST_PAUSE }
    }

    /// Reports the end of a session, goes on to the next broker, and waits once all of them have failed. False when there is no next
    /// session.
    pub async fn goes_on(&mut self, ended: Ended, connector: &mut Connector, context: &mut Context) -> bool {
        let error = match ended {
            Ended::Stopped => return false,
            Ended::Lost(error) => {
                self.pause = FIRST_PAUSE;
                error
            }
            Ended::Failed(error) => error,
        };
        context.status.fails(&format!("{}: {error}", connector.address()));
        if connector.advance() {
            return !context.stop.is_stopped();
        }
        tokio::select! {
            () = sleep(self.pause) => {}
            () = context.stop.stopped() => return false,
        }
        self.pause = self.pause.saturating_mul(2).min(LONGEST_PAUSE);
        true
    }
}
