//! A gauge: its pressure, its parameters by name, its commands.
//!
//! | Module | Holds |
//! |---|---|
//! | `read` | parameters by name |
//! | `write` | writes and commands, checked before they are sent |
//! | [`conditions`] | the conditions of a command |
//! | `defects` | what is broken, in the words of the manual |
//! | `typed` | parameters as Rust types |
//! | `pressure` | the pressure and its validity |
//! | `selector` | the instance that a slot shows |

pub mod conditions;
mod defects;
mod pressure;
mod read;
mod selector;
mod typed;
mod write;

pub use defects::Defects;
pub use read::ParameterReading;
pub(crate) use selector::HeldSelector;
pub use write::{PreparedWrite, WriteResult};

use crate::error::{AccessReason, ClientError, ParameterContext};
use crate::identify;
use crate::ms2::Ms2;
use crate::names::{NamedParameter, ParameterNames, Target, TargetError};
use crate::records::{Records, Unavailable};
use profivac_devices::catalog::KnownDevices;
use profivac_devices::model::{Model, Unit};
use profivac_host::session::BusSession;
use selector::SelectorState;
use std::sync::Arc;

/// A gauge behind a service `R`.
///
/// | | in the words of the manual | as Rust types |
/// |---|---|---|
/// | read | [`read`](Self::read) | [`get`](Self::get) |
/// | write | [`write`](Self::write) | [`set`](Self::set) |
///
/// Where several instances share a slot, a request for one of them moves the Channel Instance Selector, which the manuals list
/// as nonvolatile. The gauge moves it only if the slot shows another instance, leaves it there for the next request, and dropping
/// the gauge moves it back, also when an error or a panic ends the work. So watching a gauge for hours writes the selector once
/// for each change of the instance, and once at the end: keep the gauge, do not open it again for each reading. If the line is
/// lost at the end, the bus session keeps the original instance, and the next gauge at the same address restores it before its
/// first request. [`restore_selector`](Self::restore_selector) does the same earlier and reports errors.
///
/// ```
/// # use profivac_client::Bus;
/// # let mut bus = Bus::on(profivac_virtual::open::devices(&["bcg450@5:unit=mbar"])?).open()?;
/// let mut gauge = bus.gauge(5)?;
/// println!("{} measures {}", gauge.model().title, gauge.read("pirani.process-value")?.text);
/// gauge.write("pirani.safe-value", "12.5 Pascal")?;
/// assert_eq!(gauge.read("pirani.safe-value")?.text, "0.125 mbar");
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub struct Gauge<R: Records> {
    records: R,
    address: u8,
    model: &'static Model,
    names: Arc<ParameterNames>,
    unit: KnownUnit,
    selector_state: Option<SelectorState>,
    selector_moved: bool,
}

/// The unit of the pressures.
#[derive(Clone, Copy, Debug)]
enum KnownUnit {
    /// The caller owns the slave, so no other master changes it.
    Given(&'static Unit),
    /// As this gauge has read it last. Its owner or another master may change it at any time.
    Read(Option<&'static Unit>),
}

impl<'a> Gauge<Ms2<'a>> {
    /// Identifies the gauge at `address`, 0 to 126. Its parameters are then read and written over MS2. Needs no parameterisation and
    /// changes nothing.
    ///
    /// ```
    /// use profivac_client::{Bus, Gauge};
    ///
    /// # let mut bus = Bus::on(profivac_virtual::open::devices(&["bcg450@5"])?).open()?;
    /// let mut gauge = Gauge::open(bus.session(), 5)?;
    /// assert_eq!(gauge.read("device.device-state")?.text, "IDLE");
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    ///
    /// # Errors
    /// [`ClientError::NoAnswer`], [`ClientError::Master`] or [`ClientError::UnknownDevice`]; [`ClientError::Session`] if the port
    /// failed.
    pub fn open(session: &'a mut BusSession, address: u8) -> Result<Self, ClientError> {
        Self::open_among(KnownDevices::BUILT_IN, session, address)
    }

    /// As [`open`](Self::open), with devices that files describe.
    ///
    /// # Errors
    /// As [`open`](Self::open).
    pub fn open_among(devices: KnownDevices, session: &'a mut BusSession, address: u8) -> Result<Self, ClientError> {
        let status = identify::wait_for_slave(session, address)?;
        Self::new(devices, Ms2::new(session, address), address, status.ident)
    }
}

impl<R: Records> Gauge<R> {
    /// The gauge with this Ident_Number among `devices`, behind `records`.
    ///
    /// ```
    /// # use profivac_client::{Bus, Gauge, ms2::Ms2};
    /// # let mut bus = Bus::on(profivac_virtual::open::devices(&["bcg450@5"])?).open()?;
    /// use profivac_devices::catalog::KnownDevices;
    /// let mut gauge = Gauge::new(KnownDevices::BUILT_IN, Ms2::new(bus.session(), 5), 5, 0x08E6)?;
    /// assert_eq!(gauge.read("device.device-state")?.text, "IDLE");
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    ///
    /// # Errors
    /// [`ClientError::UnknownDevice`].
    pub fn new(devices: KnownDevices, mut records: R, address: u8, ident: u16) -> Result<Self, ClientError> {
        let model = identify::model(devices, ident, address, &mut records)?;
        Ok(Self::with_model(records, address, model))
    }

    /// A gauge whose model is known.
    ///
    /// ```
    /// use profivac_client::{Bus, Gauge, ms2::Ms2};
    /// use profivac_devices::catalog::model_named;
    ///
    /// # let mut bus = Bus::on(profivac_virtual::open::devices(&["bcg450@5:unit=torr"])?).open()?;
    /// let model = model_named("bcg450").ok_or("no such model")?;
    /// let torr = model.unit_named("Torr").ok_or("no such unit")?;
    /// let mut gauge = Gauge::with_model(Ms2::new(bus.session(), 5), 5, model).with_unit(torr);
    /// assert_eq!(gauge.read("pirani.safe-value")?.text, "0 Torr");
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn with_model(records: R, address: u8, model: &'static Model) -> Self {
        let names = Arc::new(ParameterNames::of(model));
        Self {
            records,
            address,
            model,
            names,
            unit: KnownUnit::Read(None),
            selector_state: None,
            selector_moved: false,
        }
    }

    /// The same gauge with the unit that its owner keeps, which is then not read.
    #[must_use]
    pub fn with_unit(mut self, unit: &'static Unit) -> Self {
        self.unit = KnownUnit::Given(unit);
        self
    }

    /// The tables of the device.
    #[must_use]
    pub const fn model(&self) -> &'static Model {
        self.model
    }

    /// The address of the slave.
    #[must_use]
    pub const fn address(&self) -> u8 {
        self.address
    }

    /// The parameters of the device.
    #[must_use]
    pub fn names(&self) -> Arc<ParameterNames> {
        Arc::clone(&self.names)
    }

    /// The service behind the gauge.
    pub const fn records(&mut self) -> &mut R {
        &mut self.records
    }

    /// Finds the parameter that `text` names. Slot and index without an instance select the instance that the slot shows, not
    /// counting a move of this gauge.
    ///
    /// ```
    /// # use profivac_client::Bus;
    /// # let mut bus = Bus::on(profivac_virtual::open::devices(&["bcg450@5"])?).open()?;
    /// let mut gauge = bus.gauge(5)?;
    /// assert_eq!(gauge.find("degas status")?.name, "ba.degas-status");
    /// assert_eq!(gauge.find("1:2/109")?.name, "ba.degas-status");
    /// assert_eq!(gauge.find("1/19")?.name, "pirani.process-value");
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    ///
    /// # Errors
    /// [`ClientError::Target`], and the errors of reading the selector.
    pub fn find(&mut self, text: &str) -> Result<NamedParameter, ClientError> {
        let names = self.names();
        let target = names.find(self.model.name, text)?;
        self.located(text, target)
    }

    /// As [`find`](Self::find), for a write: takes no abbreviation of a name.
    ///
    /// ```
    /// # use profivac_client::Bus;
    /// # let mut bus = Bus::on(profivac_virtual::open::devices(&["bcg450@5"])?).open()?;
    /// let mut gauge = bus.gauge(5)?;
    /// assert!(gauge.find("pirani.safe-s").is_ok());
    /// assert!(gauge.find_whole("pirani.safe-s").is_err());
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    ///
    /// # Errors
    /// As [`find`](Self::find).
    pub fn find_whole(&mut self, text: &str) -> Result<NamedParameter, ClientError> {
        let names = self.names();
        let target = names.find_whole(self.model.name, text)?;
        self.located(text, target)
    }

    /// The parameter of a target; slot and index without an instance are those that the slot shows.
    fn located(&mut self, text: &str, target: Target<'_>) -> Result<NamedParameter, ClientError> {
        match target {
            Target::Parameter(named) => Ok(named.clone()),
            Target::Raw { .. } => Err(self.unknown_parameter(text)),
            Target::CurrentInstance { slot, index } => {
                let instance = self.shown_instance(slot)?;
                self.names().at(slot, instance, index).cloned().ok_or_else(|| ClientError::Access {
                    location: self.raw_context(slot, index),
                    reason: AccessReason::NotInInstance { slot, instance, index },
                })
            }
        }
    }

    pub(crate) const fn unavailable(&self, reason: Unavailable) -> ClientError {
        ClientError::Unavailable { device: self.model.name, address: self.address, reason }
    }

    fn unknown_parameter(&self, text: &str) -> ClientError {
        TargetError::Unknown { device: self.model.name, text: text.to_owned(), alike: Vec::new() }.into()
    }

    /// The context of an error about a parameter.
    pub(super) fn context(&self, named: &NamedParameter) -> ParameterContext {
        let location = named.parameter.location;
        ParameterContext {
            device: self.model.name,
            address: self.address,
            name: Some(named.name.clone()),
            slot: location.slot,
            instance: location.instance,
            index: named.parameter.row.index,
        }
    }

    fn raw_context(&self, slot: u8, index: u8) -> ParameterContext {
        ParameterContext { device: self.model.name, address: self.address, name: None, slot, instance: 0, index }
    }
}
