//! A bus: a master on a port, opened in one step.

use crate::async_bus::AsyncBus;
use crate::error::ClientError;
use crate::gauge::Gauge;
use crate::ms2::Ms2;
use profivac_devices::catalog::KnownDevices;
use profivac_dp::link::Baud;
use profivac_host::port::{self, Port};
use profivac_host::scan::{self, FoundStation};
use profivac_host::session::{BusSession, SessionError, bus_parameters};
use std::fmt;
use std::time::Duration;

/// A bus on which this program is a master. Requests block the calling thread; [`AsyncBus`] does not.
///
/// ```
/// use profivac_client::Bus;
/// # let port = profivac_virtual::open::devices(&["bcg450@5"])?;
///
/// # /*
/// let mut bus = Bus::builder("/dev/ttyUSB0").open()?;
/// # */
/// # let mut bus = Bus::on(port).open()?;
/// let reading = bus.gauge(5)?.pressure()?;
/// match reading.pressure() {
///     Some(pressure) => println!("{:.3e} mbar", pressure.mbar()),
///     None => println!("no valid reading"),
/// }
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub struct Bus {
    session: BusSession,
    devices: KnownDevices,
}

impl Bus {
    /// Starts to describe a bus at `port`: a device name or `tcp://HOST:PORT`.
    #[must_use]
    pub fn builder(port: impl Into<String>) -> BusBuilder {
        BusBuilder::new(PortSource::Name(port.into()))
    }

    /// Starts to describe a bus on a port that is open, such as `profivac_virtual::open::port("sim:FILE.toml", ..)`.
    ///
    /// ```
    /// use profivac_client::Bus;
    ///
    /// let port = profivac_virtual::open::devices(&["bcg450@5"])?;
    /// let mut bus = Bus::on(port).master(1).open()?;
    /// assert_eq!(bus.gauge(5)?.model().name, "bcg450");
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    #[must_use]
    pub fn on(port: Box<dyn Port>) -> BusBuilder {
        BusBuilder::new(PortSource::Open(port))
    }

    /// Identifies the gauge at `address`, 0 to 126. Its parameters are then read and written over MS2.
    ///
    /// # Errors
    /// [`ClientError::NoAnswer`], [`ClientError::Master`] or [`ClientError::UnknownDevice`]; [`ClientError::Session`] if the port
    /// failed.
    pub fn gauge(&mut self, address: u8) -> Result<Gauge<Ms2<'_>>, ClientError> {
        Gauge::open_among(self.devices, &mut self.session, address)
    }

    /// The stations that answer at `addresses`. Sends FDL status and Slave_Diag only.
    ///
    /// An address without a station costs a slot time; a scan of a whole bus at 19.2 kbit/s takes a few seconds.
    ///
    /// ```
    /// # use profivac_client::Bus;
    /// # let mut bus = Bus::on(profivac_virtual::open::devices(&["bcg450@5", "hpg400@6"])?).open()?;
    /// let found = bus.scan(4..8)?;
    /// assert_eq!(found.iter().map(|station| station.address).collect::<Vec<_>>(), [5, 6]);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    ///
    /// # Errors
    /// [`ClientError::Session`]: the port failed.
    pub fn scan(&mut self, addresses: impl IntoIterator<Item = u8>) -> Result<Vec<FoundStation>, ClientError> {
        let mut found = Vec::new();
        scan::probe_all(&mut self.session, addresses, &mut found)?;
        Ok(found)
    }

    /// The bus session, for requests that this type does not offer.
    pub const fn session(&mut self) -> &mut BusSession {
        &mut self.session
    }
}

impl From<BusSession> for Bus {
    fn from(session: BusSession) -> Self {
        Self { session, devices: KnownDevices::BUILT_IN }
    }
}

/// Where the port of a bus comes from.
enum PortSource {
    /// It is opened by name.
    Name(String),
    /// It is open.
    Open(Box<dyn Port>),
}

/// The description of a bus. Without further calls: 19.2 kbit/s, master address 0, 5 s timeout, and a slot time that follows from
/// the port.
///
/// ```
/// use profivac_client::Bus;
/// use profivac_dp::link::Baud;
/// use std::time::Duration;
///
/// let builder = Bus::builder("/dev/ttyUSB0").baud(Baud::B500000).master(2).timeout(Duration::from_secs(1));
/// assert_eq!(builder.port_name(), "/dev/ttyUSB0");
/// ```
pub struct BusBuilder {
    port: PortSource,
    baud: Baud,
    master: u8,
    timeout: Duration,
    slot_tbit: Option<u32>,
    waits_for_ring_entry: bool,
    devices: KnownDevices,
}

impl fmt::Debug for BusBuilder {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { baud, master, timeout, slot_tbit, waits_for_ring_entry, .. } = self;
        f.debug_struct("BusBuilder")
            .field("port", &self.port_name())
            .field("baud", baud)
            .field("master", master)
            .field("timeout", timeout)
            .field("slot_tbit", slot_tbit)
            .field("waits_for_ring_entry", waits_for_ring_entry)
            .finish()
    }
}

impl BusBuilder {
    const fn new(port: PortSource) -> Self {
        Self {
            port,
            baud: Baud::B19200,
            master: 0,
            timeout: Duration::from_secs(5),
            slot_tbit: None,
            waits_for_ring_entry: false,
            devices: KnownDevices::BUILT_IN,
        }
    }

    /// Sets the devices that the bus knows: without this call the twelve, with it also those that files describe.
    ///
    /// ```
    /// use profivac_client::Bus;
    /// use profivac_devices::catalog::KnownDevices;
    ///
    /// let line = profivac_virtual::open::devices(&["bcg450@5"])?;
    /// let mut bus = Bus::on(line).devices(KnownDevices::with(&[])).open()?;
    /// assert_eq!(bus.gauge(5)?.model().title, "BCG450-SP");
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    #[must_use]
    pub const fn devices(mut self, devices: KnownDevices) -> Self {
        self.devices = devices;
        self
    }

    /// Sets the baud rate of the line.
    #[must_use]
    pub const fn baud(mut self, baud: Baud) -> Self {
        self.baud = baud;
        self
    }

    /// Sets the station address of this master, 0 to 125. No other station of the bus may have it.
    #[must_use]
    pub const fn master(mut self, address: u8) -> Self {
        self.master = address;
        self
    }

    /// Sets how long a request waits for the line and for an answer.
    #[must_use]
    pub const fn timeout(mut self, timeout: Duration) -> Self {
        self.timeout = timeout;
        self
    }

    /// Sets the slot time in bit times: how long this master waits for the first character of an answer. All masters of a bus have
    /// the same one, at most 16,383 (profibus-wire 1.12). The session does not change it; without this call it follows from the port,
    /// and a late answer raises it.
    ///
    /// ```
    /// use profivac_client::Bus;
    ///
    /// let line = profivac_virtual::open::devices(&["bcg450@5"])?;
    /// assert_eq!(Bus::on(line).slot_time(4000).open()?.gauge(5)?.address(), 5);
    ///
    /// let line = profivac_virtual::open::devices(&["bcg450@5"])?;
    /// let error = Bus::on(line).slot_time(20).open().err().ok_or("this slot time is too short")?;
    /// assert!(error.to_string().contains("the slot time"), "{error}");
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    #[must_use]
    pub const fn slot_time(mut self, slot_tbit: u32) -> Self {
        self.slot_tbit = Some(slot_tbit);
        self
    }

    /// Waits for the line as long as a token ring may take to admit this master, if that exceeds the timeout.
    #[must_use]
    pub const fn wait_for_ring_entry(mut self) -> Self {
        self.waits_for_ring_entry = true;
        self
    }

    /// The name of the port.
    #[must_use]
    pub fn port_name(&self) -> &str {
        match &self.port {
            PortSource::Name(name) => name,
            PortSource::Open(port) => port.name(),
        }
    }

    /// The baud rate.
    #[must_use]
    pub const fn baud_rate(&self) -> Baud {
        self.baud
    }

    /// Opens the port and makes this program a master on it.
    ///
    /// ```
    /// use profivac_client::{Bus, ErrorKind};
    ///
    /// let mut bus = Bus::on(profivac_virtual::open::devices(&["bcg450@5"])?).wait_for_ring_entry().open()?;
    /// assert_eq!(bus.gauge(5)?.address(), 5);
    ///
    /// let error = Bus::builder("/dev/no-port").open().err().ok_or("there is such a port")?;
    /// assert_eq!(error.kind(), ErrorKind::Line);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    ///
    /// # Errors
    /// [`ClientError::Session`] names the port and the reason, or says that the master address or the slot time is impossible.
    pub fn open(self) -> Result<Bus, ClientError> {
        let devices = self.devices;
        Ok(Bus { session: self.open_session()?, devices })
    }

    /// Opens the port in a thread of its own, for asynchronous programs and for several threads.
    ///
    /// ```
    /// use profivac_client::Bus;
    /// use profivac_dp::link::Baud;
    ///
    /// let bus = Bus::on(profivac_virtual::open::devices(&["bcg450@5"])?).baud(Baud::B500000).open_async()?;
    /// let baud = bus.submit(|session| session.baud());
    /// assert_eq!(baud.wait()?, Baud::B500000);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    ///
    /// # Errors
    /// As [`open`](Self::open); [`ClientError::System`] when the system has no thread or socket left.
    pub fn open_async(self) -> Result<AsyncBus, ClientError> {
        let devices = self.devices;
        Ok(AsyncBus::open(move || self.open_session())?.with_devices(devices))
    }

    fn open_session(self) -> Result<BusSession, ClientError> {
        let port = match self.port {
            PortSource::Name(name) => port::open(&name, self.baud).map_err(SessionError::from)?,
            PortSource::Open(port) => port,
        };
        let mut bus = bus_parameters(self.master, self.baud, port.delivery());
        if let Some(slot_tbit) = self.slot_tbit {
            bus.slot_tbit = slot_tbit;
        }
        let mut session = BusSession::new(port, self.baud, bus, self.timeout)?;
        if self.slot_tbit.is_some() {
            session = session.with_fixed_slot_time();
        }
        Ok(if self.waits_for_ring_entry { session.wait_for_ring_entry() } else { session })
    }
}
