//! A gateway on a thread of its own, with a runtime of its own: a gateway that is slow or fails affects nothing else.

use crate::model::ReadModel;
use profivac_station::gateway_status::GatewayStatus;
use profivac_station::services::Services;
use std::fmt::Display;
use std::future::Future;
use std::sync::Arc;
use std::thread::JoinHandle;
use std::time::Duration;
use tokio::runtime::Builder;
use tokio::sync::watch;
use tokio::time::{sleep, timeout};

/// The pause before a gateway that has ended is started again.
const PAUSE: Duration = Duration::from_secs(10);

/// The longest time that a gateway gets to end its connections.
const STOP_TIMEOUT: Duration = Duration::from_secs(2);

/// What a gateway works with.
#[derive(Clone)]
pub struct Context {
    /// The points of the station.
    pub model: Arc<ReadModel>,
    /// The station itself: its database, its alarms, its control.
    pub services: Arc<Services>,
    /// Where the gateway reports clients, errors and dropped updates.
    pub status: Arc<GatewayStatus>,
    /// Tells the gateway to end.
    pub stop: StopSignal,
}

impl Context {
    /// The context of a gateway of this name, and what tells the gateway to end.
    #[must_use]
    pub fn new(name: &'static str, model: Arc<ReadModel>, services: Arc<Services>) -> (Self, watch::Sender<bool>) {
        let (stop, stopped) = watch::channel(false);
        let status = services.gateways().add(name);
        (Self { model, services, status, stop: StopSignal(stopped) }, stop)
    }
}

/// Tells a gateway to end.
#[derive(Clone)]
pub struct StopSignal(watch::Receiver<bool>);

impl StopSignal {
    /// Returns when the gateway is to end.
    pub async fn stopped(&mut self) {
        // A sender that is gone means the same.
        self.0.wait_for(|is_stopped| *is_stopped).await.ok();
    }

    /// Whether the gateway is to end.
    #[must_use]
    pub fn is_stopped(&self) -> bool {
        *self.0.borrow()
    }
}

/// A running gateway. Dropping it ends the gateway.
pub struct GatewayThread {
    name: &'static str,
    services: Arc<Services>,
    stop: watch::Sender<bool>,
    thread: Option<JoinHandle<()>>,
}

impl GatewayThread {
    /// Starts a gateway. `serve` runs until it is told to stop; when it ends with an error or panics, the status says so, and it is
    /// called again 10 s later.
    ///
    /// # Errors
    /// When the system gives no thread or no runtime.
    pub fn start<S, F, E>(
        name: &'static str,
        model: Arc<ReadModel>,
        services: Arc<Services>,
        serve: S,
    ) -> std::io::Result<Self>
    where
        S: Fn(Context) -> F + Send + 'static,
        F: Future<Output = Result<(), E>> + Send + 'static,
        E: Display + Send + 'static,
    {
        let (context, stop) = Context::new(name, model, Arc::clone(&services));
        let runtime =
            Builder::new_multi_thread().worker_threads(1).enable_io().enable_time().thread_name(name).build()?;
        let thread = std::thread::Builder::new().name(name.to_owned()).spawn(move || {
            runtime.block_on(run(context, serve));
            runtime.shutdown_background();
        })?;
        Ok(Self { name, services, stop, thread: Some(thread) })
    }
}

impl Drop for GatewayThread {
    fn drop(&mut self) {
        self.stop.send_replace(true);
        if let Some(thread) = self.thread.take() {
            thread.join().ok();
        }
        self.services.gateways().remove(self.name);
    }
}

/// Calls `serve` until the gateway is to end.
async fn run<S, F, E>(context: Context, serve: S)
where
    S: Fn(Context) -> F,
    F: Future<Output = Result<(), E>> + Send + 'static,
    E: Display + Send + 'static,
{
    let mut stop = context.stop.clone();
    loop {
        let mut serving = tokio::spawn(serve(context.clone()));
        let ended = tokio::select! {
            ended = &mut serving => ended,
            () = stop.stopped() => {
                if timeout(STOP_TIMEOUT, &mut serving).await.is_err() {
                    serving.abort();
                }
                return;
            }
            // Without new snapshots the gateway would serve the last one for ever as present.
            () = context.model.ended() => {
                serving.abort();
                context.status.fails("the read model has failed unexpectedly: restart the station, and report the defect");
                return stop.stopped().await;
            }
        };
        match ended {
            Ok(Ok(())) => {}
            Ok(Err(error)) => context.status.fails(&error.to_string()),
            Err(_) => context.status.fails("the gateway has failed unexpectedly and is started again"),
        }
        tokio::select! {
            () = sleep(PAUSE) => {}
            () = stop.stopped() => return,
        }
    }
}
