//! Identifies the device at an address: by its Ident_Number, and where several models share it, by its Device
//! Configuration.

use super::error::ClientError;
use super::records::{Records, read_value};
use super::values::Value;
use profivac_devices::catalog::MODELS;
use profivac_devices::model::Model;
use profivac_devices::pxg55x::table::VARIANTS;
use profivac_host::scan::{SlaveStatus, probe};
use profivac_host::session::BusSession;
use profivac_wire::control::StationType;
use std::time::Instant;

/// Slot and index of Device Configuration. tira56e1 7.1.9
const DEVICE_CONFIGURATION: (u8, u8) = (0, 24);

/// Waits for the slave at `address`, at most for the timeout of the session.
///
/// # Errors
/// [`ClientError::NoAnswer`] or [`ClientError::Master`].
pub fn wait_for_slave(session: &mut BusSession, address: u8) -> Result<SlaveStatus, ClientError> {
    let begun = Instant::now();
    loop {
        match probe(session, address)? {
            Some(station) if station.station_type != StationType::Slave => return Err(ClientError::Master(address)),
            station => {
                if let Some(slave) = station.and_then(|station| station.slave) {
                    return Ok(slave);
                }
            }
        }
        if begun.elapsed() >= session.timeout() {
            return Err(ClientError::NoAnswer(address));
        }
    }
}

/// The model with this Ident_Number; of several, the one whose Device Configuration is most similar.
///
/// # Errors
/// [`ClientError::UnknownDevice`].
pub fn model(ident: u16, address: u8, records: &mut impl Records) -> Result<&'static Model, ClientError> {
    let mut models = MODELS.into_iter().filter(|model| model.ident == ident);
    let first = models.next().ok_or(ClientError::UnknownDevice { address, ident })?;
    let variants: Vec<_> = VARIANTS.iter().filter(|variant| variant.model.ident == ident).collect();
    if variants.is_empty() {
        return Ok(first);
    }
    let (slot, index) = DEVICE_CONFIGURATION;
    // Without a readable configuration the first model is assumed: the tables differ only in the fitted parts.
    let data_type = first.blocks.iter().find_map(|placed| {
        placed.locations.iter().find(|location| location.slot == slot)?;
        Some(placed.block.row(index)?.data_type)
    });
    let Some(data_type) = data_type else { return Ok(first) };
    let Ok(Value::Text(text)) = read_value(records, DEVICE_CONFIGURATION, data_type) else { return Ok(first) };
    let best = variants.into_iter().max_by_key(|variant| similarity(&text, variant.configuration));
    Ok(best.map_or(first, |variant| &variant.model))
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
