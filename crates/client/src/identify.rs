//! Identifies the device at an address: by its Ident_Number, and where several models share it, by its Device
//! Configuration.

use super::error::{ClientError, Operation, ParameterContext};
use super::records::{RecordError, Records, read_value};
use super::values::Value;
use profivac_devices::catalog::KnownDevices;
use profivac_devices::model::{DataType, Model, Role};
use profivac_devices::pxg55x::table::{VARIANTS, Variant};
use profivac_host::scan::{SlaveStatus, probe};
use profivac_host::session::BusSession;
use profivac_wire::control::StationType;

/// Waits for the slave at `address`, at most for the timeout of the session.
///
/// ```
/// # use profivac_client::{Bus, identify};
/// # let mut bus = Bus::on(profivac_virtual::open::devices(&["bcg450@5"])?).open()?;
/// let slave = identify::wait_for_slave(bus.session(), 5)?;
/// assert_eq!((slave.ident, slave.owner), (0x08E6, None));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Errors
/// [`ClientError::NoAnswer`] or [`ClientError::Master`].
pub fn wait_for_slave(session: &mut BusSession, address: u8) -> Result<SlaveStatus, ClientError> {
    let begun = session.now();
    loop {
        match probe(session, address)? {
            Some(station) if station.station_type != StationType::Slave => return Err(ClientError::Master(address)),
            station => {
                if let Some(slave) = station.and_then(|station| station.slave) {
                    return Ok(slave);
                }
            }
        }
        if session.has_passed(session.timeout(), begun) {
            return Err(ClientError::NoAnswer(address));
        }
    }
}

/// The model with this Ident_Number among `devices`; of several, the one whose Device Configuration is most similar. TPG300 and TPG500 have
/// none: they have a model for both.
///
/// ```
/// use profivac_devices::catalog::KnownDevices;
/// # use profivac_client::{Bus, identify, ms2::Ms2};
/// # let mut bus = Bus::on(profivac_virtual::open::devices(&["psg552@5"])?).open()?;
/// let slave = identify::wait_for_slave(bus.session(), 5)?;
/// let model = identify::model(KnownDevices::BUILT_IN, slave.ident, 5, &mut Ms2::new(bus.session(), 5))?;
/// assert_eq!(model.name, "psg552");
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Errors
/// [`ClientError::UnknownDevice`]; [`ClientError::SeveralDevices`] if files describe several; the error of reading Device Configuration, unless the device refuses it.
pub fn model(
    devices: KnownDevices,
    ident: u16,
    address: u8,
    records: &mut impl Records,
) -> Result<&'static Model, ClientError> {
    let first = devices.assumed_with_ident(ident).ok_or(ClientError::UnknownDevice { address, ident })?;
    let described: Vec<_> = devices.described().iter().filter(|model| model.ident == ident).collect();
    if described.len() > 1 {
        let names = described.into_iter().map(|model| model.name).collect();
        return Err(ClientError::SeveralDevices { address, ident, names });
    }
    let variants: Vec<_> = series_of(first).collect();
    if variants.is_empty() {
        return Ok(first);
    }
    let Some((location, data_type)) = device_configuration(first) else { return Ok(first) };
    let text = match read_value(records, location, data_type) {
        Ok(Value::Text(text)) => text,
        // A device that refuses its configuration is taken for the first model: the tables differ only in the fitted parts.
        Ok(_) | Err(RecordError::Refused(_) | RecordError::Malformed(_)) => return Ok(first),
        // A lost answer is no reason for a guess: another model has other ranges and other names.
        Err(error) => {
            let (slot, index) = location;
            let location = ParameterContext { device: first.name, address, name: None, slot, instance: 0, index };
            return Err(ClientError::from_record(error, Operation::Read, location, None));
        }
    };
    let best = variants.into_iter().max_by_key(|variant| similarity(&text, variant.configuration));
    Ok(best.map_or(first, |variant| &variant.model))
}

/// The built-in models of the series of `first`, which share its Ident_Number.
fn series_of(first: &'static Model) -> impl Iterator<Item = &'static Variant> {
    let is_of_series = VARIANTS.iter().any(|variant| variant.model == *first);
    VARIANTS.iter().copied().filter(move |variant| is_of_series && variant.model.ident == first.ident)
}

/// The model of a series that shares one Ident_Number, as Device Configuration reports it. `None` for an Ident_Number of one
/// device, and if Device Configuration cannot be read: [`model`] then takes the first of the series.
///
/// ```
/// use profivac_devices::catalog::KnownDevices;
/// # use profivac_client::{Bus, identify, ms2::Ms2};
/// # let mut bus = Bus::on(profivac_virtual::open::devices(&["psg552@5"])?).open()?;
/// let found = identify::reported_model(KnownDevices::BUILT_IN, 0x0C85, &mut Ms2::new(bus.session(), 5));
/// assert_eq!(found.map(|model| model.name), Some("psg552"));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[must_use]
pub fn reported_model(devices: KnownDevices, ident: u16, records: &mut impl Records) -> Option<&'static Model> {
    let first = devices.assumed_with_ident(ident)?;
    let series = || series_of(first);
    let (location, data_type) = device_configuration(&series().next()?.model)?;
    let Ok(Value::Text(text)) = read_value(records, location, data_type) else { return None };
    series().max_by_key(|variant| similarity(&text, variant.configuration)).map(|variant| &variant.model)
}

/// Slot, index and data type of Device Configuration. tira56e1 7.1.9
fn device_configuration(model: &Model) -> Option<((u8, u8), DataType)> {
    model.blocks.iter().find_map(|placed| {
        let row = placed.block.rows.iter().find(|row| row.role == Some(Role::DeviceConfiguration))?;
        Some(((placed.locations.first()?.slot, row.index), row.data_type))
    })
}

/// The number of common words minus that of the others.
fn similarity(a: &str, b: &str) -> i32 {
    let lacks = |text: &str, word: &&str| !text.split_whitespace().any(|other| other == *word);
    let only =
        |a: &str, b: &str| i32::try_from(a.split_whitespace().filter(|word| lacks(b, word)).count()).unwrap_or(0);
    -only(a, b) - only(b, a)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_device_configuration_identifies_the_model_of_a_series() {
        for variant in &VARIANTS {
            let best =
                VARIANTS.iter().max_by_key(|other| similarity(variant.configuration, other.configuration)).unwrap();
            assert_eq!(best.configuration, variant.configuration);
        }
    }
}
