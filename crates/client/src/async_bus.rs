//! A bus in a thread of its own, for asynchronous programs and for several threads.
//!
//! A [`Pending`] result can be awaited in any runtime or waited for without one. Between two requests the thread serves the
//! line: a master in a token ring must pass the token on.

use crate::cyclic::ChannelValue;
use crate::error::ClientError;
use crate::gauge::{Gauge, HeldSelector, ParameterReading, WriteResult};
use crate::ms2::Ms2;
use crate::records::RecordError;
use oneshot::AsyncReceiver;
use profivac_devices::catalog::KnownDevices;
use profivac_devices::model::{Location, Model, TypedParameter};
use profivac_devices::profile::DeviceState;
use profivac_host::readiness::{self, WakeSource};
use profivac_host::session::BusSession;
use std::future::Future;
use std::pin::Pin;
use std::sync::mpsc::{Receiver, Sender, TryRecvError, channel};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::task::{Context, Poll};
use std::thread;
use std::time::Duration;

/// The longest wait of the thread without a request.
const IDLE_WAIT: Duration = Duration::from_secs(1);

/// A request to the thread.
type Job = Box<dyn FnOnce(&mut BusSession) + Send>;

/// A bus in a thread. The thread ends with the last handle, or when the port is lost.
///
/// ```
/// use profivac_client::Bus;
/// # let port = profivac_virtual::open::devices(&["bcg450@5"])?;
///
/// # /*
/// let bus = Bus::builder("/dev/ttyUSB0").open_async()?;
/// # */
/// # let bus = Bus::on(port).open_async()?;
/// # pollster::block_on(async {
/// let state = bus.gauge(5).read("device.device-state").await?;
/// println!("{}", state.text);
/// # Ok::<(), profivac_client::ClientError>(())
/// # })?;
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone)]
pub struct AsyncBus {
    jobs: Sender<Job>,
    wake: readiness::Waker,
    devices: KnownDevices,
}

/// A gauge on an [`AsyncBus`]. Its clones are the same gauge.
///
/// Where several instances share a slot, the Channel Instance Selector stays at the instance that was read last, so watching a
/// gauge does not write this nonvolatile parameter for each reading. Await [`restore_selector`](Self::restore_selector) at the end.
/// Dropping the last clone only submits the restoration and does not wait: a program that ends at once leaves the selector moved. To wait
/// for all that was submitted, wait for a request of your own: `bus.submit(|_| ())`.
///
/// ```
/// # use profivac_client::Bus;
/// # let bus = Bus::on(profivac_virtual::open::devices(&["bcg450@5:unit=mbar"])?).open_async()?;
/// # let example = async {
/// let gauge = bus.gauge(5);
/// gauge.command("execute").await?;
/// let reading = gauge.pressure().await?;
/// println!("{:?} mbar", reading.pressure().map(|pressure| pressure.mbar()));
///
/// gauge.write("pirani.safe-value", "12.5 Pascal").await?;
/// assert_eq!(gauge.read("pirani.safe-value").await?.text, "0.125 mbar");
///
/// // Several requests that no other request interrupts.
/// let title = gauge.with(|gauge| gauge.read("device.device-state").map(|_| gauge.model().title)).await?;
/// assert_eq!(title, "BCG450-SP");
/// gauge.restore_selector().await?;
/// # Ok::<(), profivac_client::ClientError>(())
/// # };
/// # pollster::block_on(example)?;
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone)]
pub struct AsyncGauge(Arc<Watcher>);

/// The address of a gauge, the selector as the last request left it, and the model while the connection is kept.
struct Watcher {
    bus: AsyncBus,
    address: u8,
    held: Mutex<Option<HeldSelector>>,
    kept: Mutex<KeptModel>,
}

/// Whether the connection is kept, and the model behind it.
#[derive(Clone, Copy)]
enum KeptModel {
    /// The connection is closed after each request.
    No,
    /// It is kept. The model is known after the first request.
    Yes(Option<&'static Model>),
}

impl Watcher {
    /// A panic cannot leave the selector half changed, so a poisoned lock is usable.
    fn held(&self) -> MutexGuard<'_, Option<HeldSelector>> {
        self.held.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// As [`held`](Self::held).
    fn kept(&self) -> MutexGuard<'_, KeptModel> {
        self.kept.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Keeps the connection from now on, or closes it.
    fn keep_connection(&self, idle: Option<Duration>) -> Pending<()> {
        *self.kept() = idle.map_or(KeptModel::No, |_| KeptModel::Yes(None));
        let address = self.address;
        self.bus.submit(move |session| session.set_connection_kept(address, idle))
    }

    /// Restores the selector if a request has moved it.
    fn restore(&self) -> Option<Pending<Result<(), RecordError>>> {
        let held = self.held().take()?;
        let address = self.address;
        Some(self.bus.submit(move |session| held.restore(Ms2::new(session, address))))
    }
}

impl Drop for Watcher {
    /// Submits what is to be done and does not wait for it: a task that waits here would stop the other tasks of its thread.
    fn drop(&mut self) {
        drop(self.restore());
        let keeps = !matches!(*self.kept(), KeptModel::No);
        drop(keeps.then(|| self.keep_connection(None)));
    }
}

impl AsyncBus {
    /// Opens a bus session in a thread of its own, and waits until it is open.
    ///
    /// ```
    /// use profivac_client::{AsyncBus, ClientError};
    /// use profivac_dp::link::Baud;
    /// use profivac_host::session::{BusSession, bus_parameters};
    /// use std::time::Duration;
    ///
    /// # let port = profivac_virtual::open::devices(&["bcg450@5"])?;
    /// let bus = AsyncBus::open(move || {
    ///     let baud = Baud::B19200;
    ///     let bus = bus_parameters(1, baud, port.delivery());
    ///     Ok(BusSession::new(port, baud, bus, Duration::from_secs(5))?)
    /// })?;
    /// let slaves = bus.submit(|session| profivac_host::scan::probe(session, 5).map(|station| station.is_some()));
    /// assert!(slaves.wait()?.map_err(ClientError::from)?);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    ///
    /// # Errors
    /// The error of `open`, or [`ClientError::System`].
    pub fn open(open: impl FnOnce() -> Result<BusSession, ClientError> + Send + 'static) -> Result<Self, ClientError> {
        let (jobs, work) = channel();
        let (wake, source) = readiness::waker()?;
        let (result, opened) = oneshot::channel();
        let thread = move || match open() {
            Ok(session) => {
                result.send(Ok(())).ok();
                serve(session, &work, source);
            }
            Err(error) => drop(result.send(Err(error))),
        };
        thread::Builder::new().name("bus".to_owned()).spawn(thread)?;
        opened.recv().map_err(|_| ClientError::Closed)??;
        Ok(Self { jobs, wake, devices: KnownDevices::BUILT_IN })
    }

    /// The same bus, which knows also the devices that files describe.
    #[must_use]
    pub const fn with_devices(mut self, devices: KnownDevices) -> Self {
        self.devices = devices;
        self
    }

    /// Runs `work` in the thread of the bus, for requests that [`AsyncGauge`] does not offer. An example is at
    /// [`open`](Self::open).
    pub fn submit<T: Send + 'static>(&self, work: impl FnOnce(&mut BusSession) -> T + Send + 'static) -> Pending<T> {
        let (sender, result) = oneshot::channel();
        // If the thread has ended, the job is dropped with its sender, and the result is `ClientError::Closed`. A result that nothing
        // waits for is dropped.
        self.jobs.send(Box::new(move |session| drop(sender.send(work(session))))).ok();
        self.wake.wake();
        Pending(result.into_future())
    }

    /// The gauge at `address`. Sends nothing yet. To watch a gauge, keep the [`AsyncGauge`].
    #[must_use]
    pub fn gauge(&self, address: u8) -> AsyncGauge {
        AsyncGauge(Arc::new(Watcher {
            bus: self.clone(),
            address,
            held: Mutex::new(None),
            kept: Mutex::new(KeptModel::No),
        }))
    }
}

/// Serves the line and runs the jobs until the last handle is dropped or the port is lost.
fn serve(mut session: BusSession, work: &Receiver<Job>, mut wake: WakeSource) {
    loop {
        loop {
            match work.try_recv() {
                Ok(job) => job(&mut session),
                Err(TryRecvError::Empty) => break,
                Err(TryRecvError::Disconnected) => return session.close_kept_connections(),
            }
        }
        let wait = session.close_idle_connections().map_or(IDLE_WAIT, |next| next.min(IDLE_WAIT));
        let Ok(readable) = session.serve(&[wake.readiness()], wait) else { return };
        if readable.first() == Some(&true) && !wake.clear() {
            return session.close_kept_connections();
        }
    }
}

impl AsyncGauge {
    /// Runs several requests with one [`Gauge`].
    ///
    /// If the future is dropped, the requests still run to their end.
    ///
    /// # Errors
    /// The error of `work`, or [`ClientError::Closed`].
    pub async fn with<T: Send + 'static>(
        &self,
        work: impl FnOnce(&mut Gauge<Ms2<'_>>) -> Result<T, ClientError> + Send + 'static,
    ) -> Result<T, ClientError> {
        let watcher = Arc::clone(&self.0);
        self.0.bus.submit(move |session| request(session, &watcher, work)).await?
    }

    /// The bus of the gauge.
    #[must_use]
    pub fn bus(&self) -> &AsyncBus {
        &self.0.bus
    }

    /// Moves the Channel Instance Selector back, if a request has moved it.
    ///
    /// # Errors
    /// The selector cannot be written. If the line is the reason, the next gauge at this address restores it.
    pub async fn restore_selector(&self) -> Result<(), ClientError> {
        self.with(|gauge| gauge.restore_selector()).await
    }

    /// Keeps the MS2 connection open between requests, until no request has come for `idle`, and does not ask for the identity of the
    /// gauge again while it is open: several times as many requests per second. `None` closes it after each request again, and now.
    /// Dropping the last clone submits the same.
    ///
    /// A slave has few connections, and other class 2 masters need one: a kept connection takes one of them all the time. It carries an
    /// Idle telegram every 5 s. If the gauge was switched off meanwhile, the first request fails, and the next one opens another connection
    /// and identifies the gauge again.
    ///
    /// ```
    /// # use profivac_client::Bus;
    /// use std::time::Duration;
    ///
    /// # let bus = Bus::on(profivac_virtual::open::devices(&["bcg450@5"])?).open_async()?;
    /// let gauge = bus.gauge(5);
    /// gauge.keep_connection(Some(Duration::from_secs(60))).wait()?;
    /// bus.submit(|session| profivac_client::ms2::read(session, 5, 0, 25)).wait()??;
    /// assert!(bus.submit(|session| session.has_kept_connection(5)).wait()?);
    /// gauge.keep_connection(None).wait()?;
    /// assert!(!bus.submit(|session| session.has_kept_connection(5)).wait()?);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn keep_connection(&self, idle: Option<Duration>) -> Pending<()> {
        self.0.keep_connection(idle)
    }

    /// See [`Gauge::pressure`].
    ///
    /// # Errors
    /// As [`with`](Self::with).
    pub async fn pressure(&self) -> Result<ChannelValue, ClientError> {
        self.with(|gauge| gauge.pressure()).await
    }

    /// See [`Gauge::read`].
    ///
    /// # Errors
    /// As [`with`](Self::with).
    pub async fn read(&self, name: &str) -> Result<ParameterReading, ClientError> {
        let name = name.to_owned();
        self.with(move |gauge| gauge.read(&name)).await
    }

    /// See [`Gauge::get`].
    ///
    /// ```
    /// # use profivac_client::Bus;
    /// use profivac_devices::bcg450::table::{PIRANI, analog_input};
    /// use profivac_devices::model::Pascal;
    /// use profivac_devices::profile::DeviceState;
    ///
    /// # let bus = Bus::on(profivac_virtual::open::devices(&["bcg450@5"])?).open_async()?;
    /// # let example = async {
    /// let gauge = bus.gauge(5);
    /// assert_eq!(gauge.device_state().await?, DeviceState::Idle);
    /// gauge.set(&PIRANI, analog_input::SafeValue, Pascal(12.5)).await?;
    /// assert_eq!(gauge.get(&PIRANI, analog_input::SafeValue).await?, Pascal(12.5));
    /// # Ok::<(), profivac_client::ClientError>(())
    /// # };
    /// # pollster::block_on(example)?;
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    ///
    /// # Errors
    /// As [`with`](Self::with).
    pub async fn get<P: TypedParameter + Send + 'static>(
        &self,
        location: &'static Location,
        parameter: P,
    ) -> Result<P::Value, ClientError>
    where
        P::Value: Send + 'static,
    {
        self.with(move |gauge| gauge.get(location, parameter)).await
    }

    /// See [`Gauge::set`].
    ///
    /// # Errors
    /// As [`with`](Self::with).
    pub async fn set<P: TypedParameter + Send + 'static>(
        &self,
        location: &'static Location,
        parameter: P,
        value: P::Value,
    ) -> Result<WriteResult, ClientError>
    where
        P::Value: Send + 'static,
    {
        self.with(move |gauge| gauge.set(location, parameter, value)).await
    }

    /// See [`Gauge::device_state`].
    ///
    /// # Errors
    /// As [`with`](Self::with).
    pub async fn device_state(&self) -> Result<DeviceState, ClientError> {
        self.with(|gauge| gauge.device_state()).await
    }

    /// See [`Gauge::write`].
    ///
    /// # Errors
    /// As [`with`](Self::with).
    pub async fn write(&self, name: &str, value: &str) -> Result<WriteResult, ClientError> {
        let (name, value) = (name.to_owned(), value.to_owned());
        self.with(move |gauge| gauge.write(&name, &value)).await
    }

    /// See [`Gauge::command`].
    ///
    /// # Errors
    /// As [`with`](Self::with).
    pub async fn command(&self, name: &str) -> Result<WriteResult, ClientError> {
        let name = name.to_owned();
        self.with(move |gauge| gauge.command(&name)).await
    }
}

/// Runs `work` with the gauge of a watcher, and leaves the selector where it is for the next request.
fn request<T>(
    session: &mut BusSession,
    watcher: &Watcher,
    work: impl FnOnce(&mut Gauge<Ms2<'_>>) -> Result<T, ClientError>,
) -> Result<T, ClientError> {
    let (address, kept) = (watcher.address, *watcher.kept());
    let mut gauge = match kept {
        // The same gauge is behind the same connection.
        KeptModel::Yes(Some(model)) if session.has_kept_connection(address) => {
            Gauge::with_model(Ms2::new(session, address).without_reopening(), address, model)
        }
        KeptModel::Yes(_) | KeptModel::No => Gauge::open_among(watcher.bus.devices, session, address)?,
    };
    if let KeptModel::Yes(model) = &mut *watcher.kept() {
        *model = Some(gauge.model());
    }
    // Requests of one watcher run one after the other in this thread.
    if let Some(held) = watcher.held().take() {
        gauge.resume_selector(held);
    }
    let result = work(&mut gauge);
    *watcher.held() = gauge.hold_selector();
    result
}

/// The result of a request that runs in the thread of the bus.
///
/// ```
/// use profivac_client::Bus;
///
/// let bus = Bus::on(profivac_virtual::open::devices(&["bcg450@5"])?).open_async()?;
/// let found = bus.submit(|session| profivac_host::scan::probe(session, 5));
/// // Other work, while the thread of the bus waits for the answer.
/// assert!(found.wait()??.is_some());
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[must_use = "the error of the request is in it"]
pub struct Pending<T>(AsyncReceiver<T>);

impl<T> Pending<T> {
    /// Blocks until the result is there.
    ///
    /// # Errors
    /// [`ClientError::Closed`] when the thread has ended.
    pub fn wait(self) -> Result<T, ClientError> {
        pollster::block_on(self)
    }
}

impl<T> Future for Pending<T> {
    type Output = Result<T, ClientError>;

    fn poll(mut self: Pin<&mut Self>, context: &mut Context<'_>) -> Poll<Self::Output> {
        Pin::new(&mut self.0).poll(context).map_err(|_| ClientError::Closed)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use profivac_host::session::SessionError;

    #[test]
    fn opening_reports_the_error_of_the_session() {
        let opened = AsyncBus::open(|| Err(SessionError::NeverIdle.into()));
        assert_eq!(opened.err().unwrap().to_string(), "the line is never idle");
    }
}
