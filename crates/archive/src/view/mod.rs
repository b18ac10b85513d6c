//! One view of all stations: an API and a page, from the database of the archive.
//!
//! | Module | Holds |
//! |---|---|
//! | `state` | what the live stream shows: stations, latest readings, active alarms |
//! | `watch` | the state, read from the database again and again, with what passes through JetStream |
//! | `passing` | readings of the batches that pass through JetStream |
//! | `pool` | connections to the database for requests |
//! | `history` | trends and events |
//! | `stations` | requests to the stations: acknowledgements, trends from their own databases |
//! | `visibility` | the plants that a user does not see |
//! | `api` | the paths |
//!
//! The view reads, and passes acknowledgements on to the station, which decides. Control, and the settings of alarms, stay there.

mod api;
mod history;
mod passing;
mod pool;
mod state;
mod stations;
mod visibility;
mod watch;

pub use api::description;
pub use watch::Watch;

use crate::config::{Config, View};
use crate::pending::Pending;
use profivac_web_server::auth::{Access, User};
use profivac_web_server::authenticator::AccessObserver;
use profivac_web_server::authenticator::ReleaseReason;
use profivac_web_server::server::{Server, ServerError, Setup};
use std::sync::Arc;

/// Prints what happens to the users: an archive has no event log.
struct Log<F>(F);

impl<F: Fn(&str) + Send + Sync> AccessObserver for Log<F> {
    fn record(&self, sentence: &str) {
        (self.0)(sentence);
    }

    fn sessions_changed(&self, _ended: &dyn Fn(&User) -> Option<ReleaseReason>) {}
}

/// Starts the server of the view. It shows the states of `watch`, passes requests to the stations that poll through `pending`, and logins,
/// logouts and refusals to `log`.
///
/// # Errors
/// [`ServerError`].
pub fn start(
    config: &Config,
    view: &View,
    watch: &Watch,
    pending: Pending,
    log: impl Fn(&str) + Send + Sync + 'static,
) -> Result<Server, ServerError> {
    let log = Arc::new(Log(log));
    Server::start(api::router(config, watch, pending, log.clone()), log, setup(view))
}

/// Checks the files that `[view]` names, without listening.
///
/// # Errors
/// [`ServerError`].
pub fn check(view: &View) -> Result<(), ServerError> {
    Server::check(&setup(view))
}

fn setup(view: &View) -> Setup {
    let access = view.users.clone().map_or_else(Access::anonymous_viewer, Access::Users);
    let View { hosts, tls, openid, .. } = view.clone();
    Setup { hosts, tls, openid, ..Setup::new(view.listen, access) }
}
