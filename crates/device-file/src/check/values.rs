//! The values of the cyclic data that are no pressures.

use super::blocks::{Tables, quantity};
use super::{limited, only_once};
use crate::device::{OwnedValue, RowCodes, TelegramFields};
use crate::error::{Located, problem};
use crate::toml_file::{DeviceToml, ValueToml};
use crate::words::data_type;
use profivac_devices::model::{DataType, Field};
use std::collections::BTreeSet;
use toml::Spanned;

/// The most characters of a name, and of a unit. chosen: as for points of slaves in a station.
const MAX_NAME: usize = 32;
const MAX_UNIT: usize = 16;

pub(super) fn values(
    file: &DeviceToml,
    tables: &Tables<'_>,
    outputs: &TelegramFields,
    inputs: &TelegramFields,
) -> Result<Vec<OwnedValue>, Located> {
    let Some(list) = &file.values else { return Ok(Vec::new()) };
    limited(list.span(), list.get_ref().len(), "values")?;
    let mut seen = BTreeSet::new();
    let value = |entry: &Spanned<ValueToml>| {
        let toml = entry.get_ref();
        let name = name(&toml.name)?;
        let (is_output, number) = match (&toml.inputs, &toml.outputs) {
            (Some(number), None) => (false, number),
            (None, Some(number)) => (true, number),
            _ => return problem(entry.span(), "expected either inputs or outputs, with the number of the telegram"),
        };
        let telegram = *number.get_ref();
        only_once(&mut seen, (is_output, telegram, name.clone()), toml.name.span(), &format!("the value {name:?}"))?;
        let telegrams = if is_output { outputs } else { inputs };
        let Some(fields) = telegrams.get(&telegram) else {
            let known: Vec<_> = telegrams.keys().map(u8::to_string).collect();
            return problem(
                number.span(),
                format!("expected a telegram, one of: {}; found {telegram}", known.join(", ")),
            );
        };
        let data_type = number_type(&toml.data_type)?;
        let length = octets_of(data_type);
        if !is_free(fields, toml.octet.into(), length) {
            let last = usize::from(toml.octet).saturating_add(length).saturating_sub(1);
            return problem(
                entry.span(),
                format!(
                    "the octets {} to {last} of telegram {telegram} are not within a field \"ignored\"; correct octet, type or the fields",
                    toml.octet
                ),
            );
        }
        let quantity = quantity(toml.unit.as_ref(), toml.factor.as_ref(), None, data_type)?;
        if let Some(unit) = toml.unit.as_ref().filter(|unit| unit.get_ref().chars().count() > MAX_UNIT) {
            return problem(unit.span(), format!("expected a unit of at most {MAX_UNIT} characters"));
        }
        let codes = match (&toml.codes, &quantity) {
            (None, None) => RowCodes::Plain,
            (None, Some(_)) => RowCodes::Quantity,
            (Some(name), None) if data_type != DataType::Float => RowCodes::Table(tables.of_names(name)?),
            (Some(name), _) => {
                return problem(name.span(), "a float and a number in a unit have no codes; delete them");
            }
        };
        let bit = bit(toml, data_type)?;
        Ok(OwnedValue { name, is_output, telegram, octet: toml.octet, bit, data_type, codes, quantity })
    };
    list.get_ref().iter().map(value).collect()
}

/// A name that gateways use as it is.
fn name(name: &Spanned<String>) -> Result<String, Located> {
    let text = name.get_ref();
    let is_word = text.starts_with(|first: char| first.is_ascii_lowercase())
        && text.chars().all(|letter| letter.is_ascii_lowercase() || letter.is_ascii_digit() || letter == '-');
    if is_word && text.len() <= MAX_NAME {
        return Ok(text.clone());
    }
    problem(
        name.span(),
        format!("expected a name of at most {MAX_NAME} small letters, digits and hyphens, found {text:?}"),
    )
}

fn number_type(text: &Spanned<String>) -> Result<DataType, Located> {
    let known = data_type(text)?;
    if known.is_integer() || known == DataType::Float {
        return Ok(known);
    }
    let expected = "BOOLEAN, INT8, UINT8, INT16, UINT16, INT32, UINT32, FLOAT";
    problem(text.span(), format!("expected the type of a value, one of: {expected}; found {:?}", text.get_ref()))
}

/// The number of octets of a number.
const fn octets_of(data_type: DataType) -> usize {
    match data_type {
        DataType::Int16 | DataType::Uint16 => 2,
        DataType::Int32 | DataType::Uint32 | DataType::Float => 4,
        _ => 1,
    }
}

/// Whether the octets are within a field that has no meaning of its own.
fn is_free(fields: &[Field], octet: usize, length: usize) -> bool {
    let mut start = 0_usize;
    for field in fields {
        let end = start.saturating_add(field.octets());
        if matches!(field, Field::Ignored(_)) && start <= octet && octet.saturating_add(length) <= end {
            return true;
        }
        start = end;
    }
    false
}

fn bit(toml: &ValueToml, data_type: DataType) -> Result<u8, Located> {
    match &toml.bit {
        None => Ok(0),
        Some(bit) if data_type != DataType::Boolean => problem(bit.span(), "bit is for a BOOLEAN; delete it"),
        Some(bit) if *bit.get_ref() > 7 => problem(bit.span(), "expected a bit from 0 (the lowest) to 7"),
        Some(bit) => Ok(*bit.get_ref()),
    }
}
