//! The station behind the web server: its API, and what it does about users and connections.

use crate::api::router;
use crate::gateway_status::GatewayStatus;
use crate::services::Services;
use profivac_recorder::EventKind;
use profivac_web_server::auth::User;
use profivac_web_server::authenticator::{AccessObserver, ReleaseReason};
use profivac_web_server::server::{ConnectionObserver, Server, ServerError, Setup};
use std::sync::Arc;

/// Starts the server of a station.
///
/// # Errors
/// [`ServerError`].
pub fn start(services: Arc<Services>, setup: Setup) -> Result<Server, ServerError> {
    Server::start(router(Arc::clone(&services)), services, setup)
}

/// The event log of the station, and control authority: a user without a session holds none.
impl AccessObserver for Services {
    fn record(&self, sentence: &str) {
        self.recorder().event_now(None, EventKind::Access, sentence);
    }

    fn sessions_changed(&self, ended: &dyn Fn(&User) -> Option<ReleaseReason>) {
        let Some(holder) = self.control().holder() else { return };
        if let Some(reason) = ended(&holder) {
            self.control().release_user(&holder.name, reason);
        }
    }
}

impl ConnectionObserver for GatewayStatus {
    fn connected(&self) {
        self.client_connected();
    }

    fn disconnected(&self) {
        self.client_disconnected();
    }

    fn refused(&self, reason: &str) {
        Self::refused(self, reason);
    }
}
