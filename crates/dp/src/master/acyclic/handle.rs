//! Handles: names of acyclic requests and connections that are valid once.

use core::fmt;
use core::hash::{Hash, Hasher};
use core::marker::PhantomData;

/// The service of an acyclic request.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Service {
    /// Class 1: one request to a slave in data exchange.
    Ms1,
    /// Class 2: one connection.
    Ms2,
    /// The parameter channel: one task.
    Pkw,
}

impl fmt::Display for Service {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Ms1 => "MS1",
            Self::Ms2 => "MS2",
            Self::Pkw => "parameter channel",
        })
    }
}

/// A slot of a pool, and which of its successive contents is meant.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub(in crate::master) struct Key {
    pub(in crate::master) slot: u8,
    pub(in crate::master) serial: u32,
}

/// Identifies an MS1 request, an MS2 connection or a task of the parameter channel in events.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct AcyclicId {
    service: Service,
    key: Key,
}

impl AcyclicId {
    pub(in crate::master) const fn new(service: Service, key: Key) -> Self {
        Self { service, key }
    }

    /// The service.
    #[must_use]
    pub const fn service(self) -> Service {
        self.service
    }
}

/// Names an acyclic request or connection; `O` is the operation and determines the type of the outcome.
///
/// A handle whose last outcome was taken names nothing else, until the same slot or connection has had 2^32 more requests.
///
/// ```no_run
/// use profivac_dp::link::active::{Active, BusParameters};
/// use profivac_dp::link::{Baud, BitTime};
/// use profivac_dp::master::{Master, Ms2Parameters, Settings};
///
/// # fn drive(_: &mut Active<Master<0, 0>>) {}
/// let mut station = Master::<0, 0>::on(BusParameters::new(2, Baud::B19200).check()?, Settings::new(Baud::B19200), BitTime(0));
/// let connection = station.user.ms2_open(5, &Ms2Parameters::new(Baud::B19200))?;
/// let opened = loop {
///     drive(&mut station); // telegrams and time
///     if let Some(outcome) = station.user.outcome(connection) {
///         break outcome?;
///     }
/// };
/// println!("the connection uses SAP {}", opened.server_sap);
///
/// let read = station.user.ms2_read(connection, 1, 19, 240)?;
/// loop {
///     drive(&mut station);
///     if let Some(record) = station.user.outcome(read) {
///         println!("{:02X?}", record?);
///         break;
///     }
/// }
/// station.user.ms2_close(connection)?;
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub struct Handle<O> {
    pub(in crate::master) key: Key,
    /// The number of the request on its MS2 connection; 0 for everything else.
    pub(in crate::master) request: u32,
    operation: PhantomData<fn() -> O>,
}

impl<O> Handle<O> {
    pub(in crate::master) const fn new(key: Key, request: u32) -> Self {
        Self { key, request, operation: PhantomData }
    }
}

impl<O> Clone for Handle<O> {
    fn clone(&self) -> Self {
        *self
    }
}

impl<O> Copy for Handle<O> {}

impl<O> fmt::Debug for Handle<O> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Key { slot, serial } = self.key;
        write!(f, "Handle({slot}, {serial}, {})", self.request)
    }
}

impl<O> PartialEq for Handle<O> {
    fn eq(&self, other: &Self) -> bool {
        (self.key, self.request) == (other.key, other.request)
    }
}

impl<O> Eq for Handle<O> {}

impl<O> Hash for Handle<O> {
    fn hash<H: Hasher>(&self, state: &mut H) {
        (self.key, self.request).hash(state);
    }
}
