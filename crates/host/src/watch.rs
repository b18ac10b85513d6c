//! A slave to be watched: what it is, how its inputs are laid out, and what they say.

use crate::instrument::DEVICES;
use crate::live::look;
use crate::ms2::{self, Ms2Error};
use crate::tool::{Reply, Tool, ToolError};
use profivac_devices::model::{Configuration, Direction, Facts, Field, Format, Model, NumberType, Unit, UserPrm, Via};
use profivac_devices::profile::{ExceptionStatus, StatusExtension};
use profivac_dp::master::{SlaveParameters, services};

/// Why a slave cannot be watched.
#[derive(Debug, thiserror::Error)]
pub enum WatchError {
    /// Nothing could be asked.
    #[error(transparent)]
    Tool(#[from] ToolError),
    /// Nobody is there, or it is no slave.
    #[error("nobody answers at address {0}")]
    Nobody(u8),
    /// Another master owns it.
    #[error("the slave at address {address} belongs to master {master}")]
    Owned {
        /// Its address.
        address: u8,
        /// Whose it is.
        master: u8,
    },
    /// No device with this ident number is known.
    #[error("the slave at address {address} has the ident number 0x{ident:04X}, which no known device has")]
    Unknown {
        /// Its address.
        address: u8,
        /// Ident_Number.
        ident: u16,
    },
    /// The unit it shows could not be read, so it could not be kept.
    #[error("the unit of the slave at address {address} cannot be read: {error}")]
    Unit {
        /// Its address.
        address: u8,
        /// Why.
        error: Ms2Error,
    },
}

/// What is known of a slave before it is taken.
#[derive(Clone, Copy, Debug)]
pub struct Watched {
    /// Its address.
    pub address: u8,
    /// What it is.
    pub model: &'static Model,
    /// How data are exchanged.
    pub configuration: &'static Configuration,
    /// The unit it shows.
    pub unit: &'static Unit,
}

impl Watched {
    /// Looks at the slave at `address` on behalf of `master`, without changing anything.
    ///
    /// # Errors
    /// [`WatchError`], also when another master owns it.
    pub fn find(tool: &mut Tool, address: u8, master: u8) -> Result<Self, WatchError> {
        let slave = look(tool, address)?.and_then(|seen| seen.slave).ok_or(WatchError::Nobody(address))?;
        if let Some(owner) = slave.owner.filter(|owner| *owner != master) {
            return Err(WatchError::Owned { address, master: owner });
        }
        let known = DEVICES.iter().map(|entry| entry.model).find(|model| model.ident == slave.ident);
        let model = known.ok_or(WatchError::Unknown { address, ident: slave.ident })?;
        let configuration = present_configuration(tool, address, model)?;
        let unit = present_unit(tool, address, model)?;
        Ok(Self { address, model, configuration, unit })
    }

    /// The parameters that leave the slave as it is.
    #[must_use]
    pub fn parameters(&self) -> SlaveParameters<'static> {
        let prm = self.model.user_prm.iter().find(|prm| prm.code() == self.unit.code);
        SlaveParameters {
            user_prm: prm.map_or(&[], |prm: &UserPrm| prm.octets),
            ..SlaveParameters::new(self.address, self.model.ident, self.configuration.octets)
        }
    }

    /// What its inputs say.
    #[must_use]
    pub fn reading(&self, inputs: &[u8]) -> Reading {
        let mut reading = Reading::default();
        let mut value = None;
        for (start, field) in self.configuration.inputs.into_iter().flat_map(|telegram| telegram.layout()) {
            let octets = inputs.get(start..).and_then(|rest| rest.get(..field.octets())).unwrap_or_default();
            match (field, octets) {
                (Field::ExceptionStatus, [octet]) => reading.exception = ExceptionStatus::from_bits_retain(*octet),
                (Field::StatusExtension, [octet]) => reading.status = StatusExtension::from_bits_retain(*octet),
                (Field::PvSelector, [octet]) => reading.instance = *octet,
                (Field::ProcessValue(number), octets) => value = Some((number, octets)),
                _ => {}
            }
        }
        reading.pa = value
            .filter(|_| !reading.status.contains(StatusExtension::INVALID))
            .and_then(|(number, octets)| self.decode(number, octets, reading.instance));
        reading
    }

    fn decode(&self, number: NumberType, octets: &[u8], instance: u8) -> Option<f64> {
        let facts: &Facts = self.model.ranges.iter().find(|facts| facts.part.instance == instance)?;
        Format { unit: self.unit, number, counts: facts.counts, highest: u16::MAX }.decode(octets)
    }
}

/// What inputs say.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Reading {
    /// The pressure in Pa; nothing unless it is valid.
    pub pa: Option<f64>,
    /// The instance it is from, 0 if the inputs do not tell.
    pub instance: u8,
    /// Where it lies.
    pub status: StatusExtension,
    /// Exception Status.
    pub exception: ExceptionStatus,
}

impl Default for Reading {
    fn default() -> Self {
        Self { pa: None, instance: 0, status: StatusExtension::empty(), exception: ExceptionStatus::empty() }
    }
}

/// Bits of Exception Status and of the status extension, in words.
const EXCEPTIONS: [(ExceptionStatus, &str); 6] = [
    (ExceptionStatus::ALARM_COMMON, "common alarm"),
    (ExceptionStatus::ALARM_DEVICE, "device alarm"),
    (ExceptionStatus::ALARM_MANUFACTURER, "manufacturer alarm"),
    (ExceptionStatus::WARNING_COMMON, "common warning"),
    (ExceptionStatus::WARNING_DEVICE, "device warning"),
    (ExceptionStatus::WARNING_MANUFACTURER, "manufacturer warning"),
];

const STATUSES: [(StatusExtension, &str); 3] = [
    (StatusExtension::INVALID, "invalid"),
    (StatusExtension::OVER, "overrange"),
    (StatusExtension::UNDER, "underrange"),
];

impl Reading {
    /// What is not as it should be, in words.
    #[must_use]
    pub fn remarks(&self) -> Vec<&'static str> {
        let statuses = STATUSES.into_iter().filter(|(bit, _)| self.status.contains(*bit)).map(|(_, word)| word);
        let exceptions = EXCEPTIONS.into_iter().filter(|(bit, _)| self.exception.contains(*bit)).map(|(_, word)| word);
        statuses.chain(exceptions).collect()
    }
}

/// The configuration the slave has, or its usual one if that has no process value.
fn present_configuration(
    tool: &mut Tool,
    address: u8,
    model: &'static Model,
) -> Result<&'static Configuration, WatchError> {
    let reply = tool.ask(&services::get_cfg(address))?;
    let present = match &reply {
        Reply::Answer { du, .. } => model.configuration(du),
        Reply::Nothing(_) => None,
    };
    Ok(present.filter(|configuration| configuration.number().is_some()).unwrap_or(model.default_configuration))
}

/// Data Units, as a class 2 master reads it.
fn present_unit(tool: &mut Tool, address: u8, model: &'static Model) -> Result<&'static Unit, WatchError> {
    let unreadable = |error| WatchError::Unit { address, error };
    let (slot, index) = data_units(model).ok_or_else(|| unreadable(Ms2Error::Other))?;
    let record = ms2::read(tool, address, slot, index).map_err(unreadable)?;
    let code = record.try_into().map(u16::from_be_bytes).map_err(|_| unreadable(Ms2Error::Other))?;
    model.unit(code).ok_or_else(|| unreadable(Ms2Error::Other))
}

/// Where Data Units is: its first slot, and its index.
fn data_units(model: &Model) -> Option<(u8, u8)> {
    model.places.iter().find_map(|place| {
        let row = place.block.rows.iter().find(|row| row.name == "Data Units")?;
        let address = place.addresses.first().filter(|_| row.access.allows(Via::Class2, Direction::Read))?;
        Some((address.slot, row.id))
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use profivac_devices::bcg450::table::MODEL;

    fn watched(configuration: usize, unit: &str) -> Watched {
        let unit = MODEL.unit_named(unit).unwrap();
        Watched { address: 5, model: &MODEL, configuration: &MODEL.configurations[configuration], unit }
    }

    #[test]
    fn data_units_is_where_the_manual_has_it() {
        assert_eq!(data_units(&MODEL), Some((1, 22)));
    }

    #[test]
    fn inputs_are_read_in_every_layout_and_unit() {
        let float = |value: f32| value.to_be_bytes().to_vec();
        for (configuration, unit, value, pa) in [
            (1, "mbar", float(1e-3), 0.1),
            (1, "Torr", float(1.0), 133.322),
            (5, "Pascal", float(2.5), 2.5),
            (0, "Micron", vec![0x03, 0xE8], 133.322),
            // COUNTS: 10^(25000/2000 - 12.5) mbar
            (4, "COUNTS", 25_000_u16.to_be_bytes().to_vec(), 100.0),
        ] {
            let channel = if configuration > 3 { vec![0; 8] } else { Vec::new() };
            let inputs = [channel, vec![0x80, 0x00, 0x02], value].concat();
            let reading = watched(configuration, unit).reading(&inputs);
            let error = (reading.pa.unwrap() / pa - 1.0).abs();
            assert!(error < 1e-5, "{configuration} {unit}: {:?}", reading.pa);
            assert_eq!((reading.instance, reading.remarks()), (2, vec![]));
        }
    }

    #[test]
    fn what_is_not_valid_has_no_pressure_but_reasons() {
        let inputs = [0xA2, 0x03, 0x02, 0x44, 0x7A, 0x00, 0x00];
        let reading = watched(1, "mbar").reading(&inputs);
        assert_eq!(reading.pa, None);
        assert_eq!(reading.remarks(), ["invalid", "overrange", "device alarm", "device warning"]);
        assert_eq!(watched(1, "mbar").reading(&[]).pa, None);
    }

    #[test]
    fn the_parameters_keep_the_unit_and_the_configuration() {
        for (prm, unit) in MODEL.user_prm.iter().zip(MODEL.units) {
            let watched = watched(1, unit.name);
            let parameters = watched.parameters();
            assert_eq!((parameters.user_prm, parameters.cfg), (prm.octets, MODEL.configurations[1].octets));
        }
    }
}
