//! Finds out how to exchange data with a slave: its model, its configuration, its unit, the gauges on its channels.

use crate::class1::Class1Session;
use crate::cyclic::{BLOCK_TYPE, CyclicSlave, ReportedChannels, open_instances, unranged_instances};
use crate::error::ClientError;
use crate::identify;
use crate::ms2::{Ms2, Ms2Error, is_silence};
use crate::records::{ErrorKind, Interruption, RecordError, read_code};
use profivac_devices::catalog::KnownDevices;
use profivac_devices::model::{
    AccessPath, Configuration, Counts, DataType, Field, HeldPressure, MeasuringRange, Model, NumberType,
    PressureFormat, Role, Unit,
};
use profivac_devices::reading::is_pressure;
use profivac_dp::master::services;
use profivac_host::session::{BusSession, Reply, SessionError};

/// The reason why a slave cannot be used for data exchange.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum CyclicError {
    /// The bus session failed.
    #[error(transparent)]
    Session(#[from] SessionError),
    /// No slave answers.
    #[error("no slave answers at address {0}")]
    NoAnswer(u8),
    /// The station is a master, no known device has its Ident_Number, or it cannot be identified.
    #[error(transparent)]
    Client(ClientError),
    /// Another master owns the slave.
    #[error("the slave at address {address} belongs to master {master}")]
    OwnedByOther {
        /// The address.
        address: u8,
        /// The owner.
        master: u8,
    },
    /// The present unit cannot be read, so it could not be preserved.
    #[error("the unit of the slave at address {address} cannot be read: {error}")]
    UnreadableUnit {
        /// The address.
        address: u8,
        /// The error of reading it.
        error: RecordError,
    },
    /// The device takes outputs that its tables name, and this master has none for it.
    #[error(
        "the slave at address {0} takes outputs, and zeros can stop a pump or close a valve: own it as [[segment.slave]] with outputs in a \
         station, or read it while another master owns it"
    )]
    NeedsOutputs(u8),
    /// The tables of the device have no units.
    #[error("the slave at address {0} has no pressures")]
    NoUnit(u8),
}

impl From<ClientError> for CyclicError {
    /// A lost port and a missing slave have one variant only.
    fn from(error: ClientError) -> Self {
        match error {
            ClientError::Session(error) => Self::Session(error),
            ClientError::NoAnswer(address) => Self::NoAnswer(address),
            error => Self::Client(error),
        }
    }
}

impl CyclicError {
    /// The class of the error.
    ///
    /// ```
    /// # use profivac_client::Bus;
    /// use profivac_client::ErrorKind;
    /// use profivac_client::cyclic::CyclicSlave;
    /// # use std::time::Duration;
    ///
    /// # let port = profivac_virtual::open::devices(&["bcg450@5"])?;
    /// # let mut bus = Bus::on(port).timeout(Duration::from_millis(200)).open()?;
    /// let absent = CyclicSlave::find(bus.session(), 9, 0).unwrap_err();
    /// assert_eq!(absent.kind(), ErrorKind::Line);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    #[must_use]
    pub const fn kind(&self) -> ErrorKind {
        match self {
            Self::Session(SessionError::Parameters(_)) => ErrorKind::Usage,
            Self::Session(_) | Self::NoAnswer(_) => ErrorKind::Line,
            Self::Client(error) => error.kind(),
            Self::UnreadableUnit { error, .. } => error.kind(),
            Self::OwnedByOther { .. } | Self::NeedsOutputs(_) | Self::NoUnit(_) => ErrorKind::Refused,
        }
    }
}

impl CyclicSlave {
    /// Finds the slave at `address` for the master at the address `master`, which may own it already. Waits at most for the timeout of
    /// the session.
    ///
    /// It changes nothing in a slave with DP-V1. A slave without it (TPG300, TPG500) reports its unit in the parameter channel only:
    /// this master parameterises it, with Set_Prm, and releases it afterwards.
    ///
    /// ```
    /// # use profivac_client::Bus;
    /// use profivac_client::cyclic::CyclicSlave;
    ///
    /// # let mut bus = Bus::on(profivac_virtual::open::devices(&["bcg450@5:unit=torr"])?).open()?;
    /// let slave = CyclicSlave::find(bus.session(), 5, 0)?;
    /// assert_eq!((slave.model.name, slave.unit.name), ("bcg450", "Torr"));
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    ///
    /// # Errors
    /// [`CyclicError`].
    pub fn find(session: &mut BusSession, address: u8, master: u8) -> Result<Self, CyclicError> {
        Self::find_among(KnownDevices::BUILT_IN, session, address, master)
    }

    /// As [`find`](Self::find), with devices that files describe.
    ///
    /// # Errors
    /// [`CyclicError`].
    pub fn find_among(
        devices: KnownDevices,
        session: &mut BusSession,
        address: u8,
        master: u8,
    ) -> Result<Self, CyclicError> {
        let slave = identify::wait_for_slave(session, address)?;
        if let Some(owner) = slave.owner.filter(|owner| *owner != master) {
            return Err(CyclicError::OwnedByOther { address, master: owner });
        }
        let model = identify::model(devices, slave.ident, address, &mut Ms2::new(session, address))?;
        let configuration = present_configuration(session, address, model)?;
        if model.values_of(configuration, true).next().is_some() {
            return Err(CyclicError::NeedsOutputs(address));
        }
        // Assumed until it is read: a device whose user parameters have no unit keeps its own.
        let unit = model.units.first().ok_or(CyclicError::NoUnit(address))?;
        let found = Self { address, model, configuration, unit, channels: ReportedChannels::default() };
        let unit = present_unit(session, &found)?;
        Ok(Self { unit, channels: read_channels(session, address, model, unit)?, ..found })
    }
}

/// The principles and ranges of the channels that the tables leave open, as far as the device reports them.
fn read_channels(
    session: &mut BusSession,
    address: u8,
    model: &'static Model,
    unit: &'static Unit,
) -> Result<ReportedChannels, SessionError> {
    let mut block_types = Vec::new();
    let mut connection = Ms2::new(session, address);
    // Each read of a gauge that is gone would take its repetitions and their pauses.
    let mut is_gone = false;
    let mut read = |slot, index| {
        if is_gone {
            return Ok(None);
        }
        match connection.read(slot, index) {
            Ok(octets) => Ok(Some(octets)),
            Err(Ms2Error::Session(error) | Ms2Error::NotSent(error)) => Err(error),
            Err(error) => {
                is_gone = is_silence(&error);
                Ok(None)
            }
        }
    };
    for instance in open_instances(model) {
        if let Some(octets) = read(instance, BLOCK_TYPE)? {
            block_types.push((instance, octets));
        }
    }
    let block_types = block_types.iter().map(|(instance, octets)| (*instance, octets.as_slice()));
    let mut channels = ReportedChannels::from_block_types(block_types);
    for instance in unranged_instances(model) {
        let mut ends = [None; 2];
        for (end, role) in ends.iter_mut().zip([Role::Underrange, Role::Overrange]) {
            let Some(end_format) = range_end(model, instance, role) else { continue };
            *end = read(instance, end_format.index)?.and_then(|octets| end_format.pa(unit, &octets));
        }
        if let [Some(lowest_pa), Some(highest_pa)] = ends {
            channels = channels.with_range(instance, MeasuringRange { lowest_pa, highest_pa });
        }
    }
    Ok(channels)
}

/// The parameter that reports an end of the range of a channel.
struct RangeEnd {
    index: u8,
    counts: Counts,
    max_integer: u16,
}

impl RangeEnd {
    /// The pressure in Pa. `None` if the octets are none.
    fn pa(&self, unit: &'static Unit, octets: &[u8]) -> Option<f64> {
        let number = if octets.len() == 2 { NumberType::Integer } else { NumberType::Float };
        let format = PressureFormat { unit, number, counts: self.counts, max_integer: self.max_integer };
        // The end of an integer is not the end of the range.
        match format.measured(octets)? {
            HeldPressure::Exact(pa) => Some(pa).filter(|pa| is_pressure(*pa)),
            HeldPressure::AtLeast(_) | HeldPressure::Below(_) => None,
        }
    }
}

/// The parameter with this role in the slot of a channel.
fn range_end(model: &Model, channel: u8, role: Role) -> Option<RangeEnd> {
    let counts = model.parts.iter().find(|spec| spec.part.instance == channel)?.counts;
    let placed = model.blocks.iter().filter(|placed| placed.locations.iter().any(|it| it.slot == channel));
    let row = placed.flat_map(|placed| placed.block.rows).find(|row| row.role == Some(role))?;
    Some(RangeEnd { index: row.index, counts, max_integer: model.max_integer })
}

/// The present configuration, or else one without outputs that declares the validity of its pressures.
fn present_configuration(
    session: &mut BusSession,
    address: u8,
    model: &'static Model,
) -> Result<&'static Configuration, CyclicError> {
    let reply = session.request(&services::get_cfg(address))?;
    let present = match &reply {
        Reply::Answer { du, .. } => model.configuration(du),
        Reply::NoAnswer(_) => None,
    };
    let without_outputs = || model.configurations.iter().filter(|configuration| configuration.outputs.is_none());
    let best =
        || without_outputs().filter(|configuration| has_validity(configuration)).max_by_key(|best| best.input_octets());
    Ok(present.filter(|present| has_validity(present)).or_else(best).unwrap_or(model.default_configuration))
}

/// Whether a configuration contains pressures with their instance and validity.
fn has_validity(configuration: &Configuration) -> bool {
    let has = |wanted| configuration.inputs.is_some_and(|telegram| telegram.fields.contains(&wanted));
    let one_of_n = has(Field::StatusExtension) && has(Field::PvSelector);
    configuration.number().is_some() && (one_of_n || has(Field::ChannelStatus) || has(Field::MeasurementStatus(1)))
}

/// The present unit, read over MS2. A device without MS2 reports it only in the parameter channel, for which this master
/// owns the slave for a moment.
fn present_unit(session: &mut BusSession, slave: &CyclicSlave) -> Result<&'static Unit, CyclicError> {
    let CyclicSlave { address, model, .. } = *slave;
    let unreadable = |error: RecordError| match error {
        RecordError::Session(error) | RecordError::NotSent(error) => CyclicError::Session(error),
        error => CyclicError::UnreadableUnit { address, error },
    };
    let unknown = || unreadable(RecordError::from(Interruption::UnknownUnit));
    let Some((location, data_type)) = unit_address(model) else {
        // A device file can describe a device with one unit, or without pressures.
        let [unit] = model.units else { return Err(unknown()) };
        return Ok(unit);
    };
    let code = if model.features.dpv1 {
        read_code(&mut Ms2::new(session, address), location, data_type)
    } else {
        let mut records = Class1Session::open(session, slave, AccessPath::ParameterChannel).map_err(unreadable)?;
        read_code(&mut records, location, data_type)
    };
    code.map_err(unreadable)?.and_then(|code| model.unit(code)).ok_or_else(unknown)
}

/// Slot, index and data type of the unit.
fn unit_address(model: &Model) -> Option<((u8, u8), DataType)> {
    model.blocks.iter().find_map(|placed| {
        let row = placed.block.rows.iter().find(|row| row.role == Some(Role::Unit))?;
        let address = placed.locations.first()?;
        Some(((address.slot, row.index), row.data_type))
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use profivac_devices::bcg450::table::MODEL;
    use profivac_devices::catalog::MODELS;

    #[test]
    fn the_unit_is_at_the_slot_and_index_of_the_manual() {
        assert_eq!(unit_address(&MODEL), Some(((1, 22), DataType::Uint16)));
    }

    /// errata-pxg55x-img400 16: the ends of an integer stand for every range that ends beyond them.
    #[test]
    fn an_end_of_the_integers_is_no_end_of_a_range() {
        let model = profivac_devices::catalog::model_named("img400").unwrap();
        let end = range_end(model, 1, Role::Overrange).unwrap();
        let pa = |octets: &[u8]| end.pa(model.unit_named("Pascal").unwrap(), octets);
        assert_eq!((pa(&[0xFF, 0xFF]), pa(&[0, 0])), (None, None));
        assert_eq!((pa(&[0xFF, 0xFE]), pa(&[0, 1])), (Some(65534.0), Some(1.0)));
        assert_eq!((pa(&65535_f32.to_be_bytes()), pa(&0_f32.to_be_bytes())), (Some(65535.0), None));
    }

    #[test]
    fn every_device_has_a_configuration_that_declares_validity_and_dpv1_devices_one_without_outputs() {
        for model in MODELS {
            let with_validity = || model.configurations.iter().filter(|configuration| has_validity(configuration));
            assert!(with_validity().count() > 0, "{}", model.name);
            let without_outputs = with_validity().any(|configuration| configuration.outputs.is_none());
            assert_eq!(without_outputs, model.features.dpv1, "{}", model.name);
        }
    }
}
