//! A bus: a master on a port, opened in one step.

use crate::async_bus::{AsyncBus, BusError};
use crate::error::ClientError;
use crate::gauge::Gauge;
use crate::ms2::Ms2;
use profivac_dp::link::Baud;
use profivac_host::port::{self, Port};
use profivac_host::scan::{self, FoundStation};
use profivac_host::session::{BusSession, SessionError, bus_parameters};
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
/// # let mut bus = Bus::builder("sim").open_on(port)?;
/// let reading = bus.gauge(5)?.pressure()?;
/// match reading.pressure() {
///     Some(pressure) => println!("{:.3e} mbar", pressure.mbar()),
///     None => println!("no valid reading"),
/// }
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub struct Bus {
    session: BusSession,
}

impl Bus {
    /// Starts to describe a bus at `port`: a device name or `tcp://HOST:PORT`.
    #[must_use]
    pub fn builder(port: impl Into<String>) -> BusBuilder {
        BusBuilder {
            port: port.into(),
            baud: Baud::B19200,
            master: 0,
            timeout: Duration::from_secs(5),
            waits_for_ring_entry: false,
        }
    }

    /// Finds the gauge at `address` and reads it over MS2.
    ///
    /// # Errors
    /// [`ClientError::NoAnswer`], [`ClientError::Master`] or [`ClientError::UnknownDevice`].
    pub fn gauge(&mut self, address: u8) -> Result<Gauge<Ms2<'_>>, ClientError> {
        Gauge::open(&mut self.session, address)
    }

    /// The stations that answer at `addresses`. Sends FDL status and Slave_Diag only.
    ///
    /// An address without a station costs a slot time; a scan of a whole bus at 19.2 kbit/s takes a few seconds.
    ///
    /// ```
    /// # use profivac_client::Bus;
    /// # let mut bus = Bus::builder("sim").open_on(profivac_virtual::open::devices(&["bcg450@5", "hpg400@6"])?)?;
    /// let found = bus.scan(4..8)?;
    /// assert_eq!(found.iter().map(|station| station.address).collect::<Vec<_>>(), [5, 6]);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    ///
    /// # Errors
    /// [`SessionError`].
    pub fn scan(&mut self, addresses: impl IntoIterator<Item = u8>) -> Result<Vec<FoundStation>, SessionError> {
        let mut found = Vec::new();
        for address in addresses {
            found.extend(scan::probe(&mut self.session, address)?);
        }
        Ok(found)
    }

    /// The bus session, for requests that this type does not offer.
    pub const fn session(&mut self) -> &mut BusSession {
        &mut self.session
    }
}

impl From<BusSession> for Bus {
    fn from(session: BusSession) -> Self {
        Self { session }
    }
}

/// The description of a bus. Without further calls: 19.2 kbit/s, master address 0, 5 s timeout.
#[derive(Clone, Debug)]
pub struct BusBuilder {
    port: String,
    baud: Baud,
    master: u8,
    timeout: Duration,
    waits_for_ring_entry: bool,
}

impl BusBuilder {
    /// Sets the baud rate of the line.
    #[must_use]
    pub const fn baud(mut self, baud: Baud) -> Self {
        self.baud = baud;
        self
    }

    /// Sets the station address of this master. No other station of the bus may have it.
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

    /// Waits for the line as long as a token ring may take to admit this master, if that exceeds the timeout.
    #[must_use]
    pub const fn wait_for_ring_entry(mut self) -> Self {
        self.waits_for_ring_entry = true;
        self
    }

    /// The name of the port.
    #[must_use]
    pub fn port_name(&self) -> &str {
        &self.port
    }

    /// The baud rate.
    #[must_use]
    pub const fn baud_rate(&self) -> Baud {
        self.baud
    }

    /// Opens the port and makes this program a master on it.
    ///
    /// # Errors
    /// [`SessionError::Port`] names the port and what to do; [`SessionError::Parameters`] for an impossible master address.
    pub fn open(self) -> Result<Bus, SessionError> {
        let port = port::open(&self.port, self.baud)?;
        self.open_on(port)
    }

    /// Makes this program a master on a port that is open, such as `profivac_virtual::open::port("sim:FILE.toml", ..)`.
    ///
    /// # Errors
    /// [`SessionError::Parameters`] for an impossible master address.
    pub fn open_on(self, port: Box<dyn Port>) -> Result<Bus, SessionError> {
        let bus = bus_parameters(self.master, self.baud, port.delivery());
        let session = BusSession::new(port, self.baud, bus, self.timeout)?;
        Ok(Bus { session: if self.waits_for_ring_entry { session.wait_for_ring_entry() } else { session } })
    }

    /// Opens the port in a thread of its own, for asynchronous programs and for several threads.
    ///
    /// # Errors
    /// As [`open`](Self::open); [`BusError::System`] when the system has no thread or socket left.
    pub fn open_async(self) -> Result<AsyncBus, BusError> {
        AsyncBus::open(move || Ok(self.open()?.session))
    }

    /// The same on a port that is open.
    ///
    /// # Errors
    /// As [`open_async`](Self::open_async).
    pub fn open_async_on(self, port: Box<dyn Port>) -> Result<AsyncBus, BusError> {
        AsyncBus::open(move || Ok(self.open_on(port)?.session))
    }
}
