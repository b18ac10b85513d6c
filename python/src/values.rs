//! Values of parameters as Python objects, and the tables of a device.

use crate::devices::named;
use crate::failure::Failure;
use profivac_client::names::{ParameterNames, command_name};
use profivac_client::settings::is_setting;
use profivac_client::values::Value;
use profivac_client::{ParameterReading, Pressure};
use profivac_devices::model::{Access, Codes, DataType, Model, Quantity};
use pyo3::prelude::*;
use pyo3::types::{PyBool, PyBytes};

/// Name, value, text, unit, pressure in Pa, octets.
pub type ReadingRow = (String, Py<PyAny>, String, Option<&'static str>, Option<f64>, Py<PyBytes>);

/// Name, printed name, slot, instance, index, type, access, section, choices, bounds, readable, writable, setting.
pub type ParameterRow = (
    String,
    &'static str,
    (u8, u8, u8),
    String,
    &'static str,
    String,
    Vec<String>,
    Option<(f64, f64)>,
    (bool, bool, bool),
);

/// A command and its risk.
pub type CommandRow = (String, &'static str);

/// A parameter that was read.
pub fn reading(py: Python<'_>, reading: &ParameterReading, pa: Option<f64>) -> PyResult<ReadingRow> {
    let octets = PyBytes::new(py, &reading.octets).unbind();
    Ok((reading.named.name.clone(), object(py, reading)?, reading.text.clone(), reading.unit, pa, octets))
}

/// The value: a Boolean, the name of a code, a number, text or octets.
fn object(py: Python<'_>, reading: &ParameterReading) -> PyResult<Py<PyAny>> {
    let row = reading.named.parameter.row;
    Ok(match &reading.value {
        Value::Integer(number) if row.data_type == DataType::Boolean && row.codes == Codes::Plain => {
            PyBool::new(py, *number != 0).to_owned().into_any().unbind()
        }
        Value::Integer(_) if has_words(&row.codes) => reading.text.clone().into_pyobject(py)?.into_any().unbind(),
        Value::Integer(number) => number.into_pyobject(py)?.into_any().unbind(),
        Value::Number(number) => number.into_pyobject(py)?.into_any().unbind(),
        Value::Text(text) => text.into_pyobject(py)?.into_any().unbind(),
        Value::Octets(octets) => PyBytes::new(py, octets).into_any().unbind(),
    })
}

/// Whether the manual gives words for the numbers.
const fn has_words(codes: &Codes) -> bool {
    match codes {
        Codes::Names(_)
        | Codes::Commands(_)
        | Codes::Bits(_)
        | Codes::Units
        | Codes::BitCommands(_)
        | Codes::Version => true,
        Codes::Plain | Codes::Range(..) | Codes::PerMille(..) | Codes::Quantity(_) => false,
    }
}

/// The words that a parameter accepts.
fn choices(codes: &Codes, model: &Model) -> Vec<String> {
    match codes {
        Codes::Units => model.units.iter().map(|unit| unit.name.to_owned()).collect(),
        _ => codes.codes().iter().map(|code| code.name.to_owned()).collect(),
    }
}

#[expect(clippy::cast_precision_loss, reason = "bounds of at most four octets")]
const fn bounds(codes: &Codes) -> Option<(f64, f64)> {
    match codes {
        Codes::Range(low, high) => Some((*low as f64, *high as f64)),
        Codes::PerMille(low, high) => Some((*low as f64 / 10.0, *high as f64 / 10.0)),
        Codes::Quantity(Quantity { factor, range: Some((low, high)), .. }) => {
            Some((*low as f64 * *factor, *high as f64 * *factor))
        }
        _ => None,
    }
}

/// The parameters and the commands of a model.
pub fn tables(model: &'static Model) -> (Vec<ParameterRow>, Vec<CommandRow>) {
    let names = ParameterNames::of(model);
    let parameters = names.all().iter().map(|named| {
        let (location, row) = (named.parameter.location, named.parameter.row);
        let is_readable = row.access.intersects(Access::READ);
        let is_writable = row.access.intersects(Access::WRITE);
        (
            named.name.clone(),
            row.name,
            (location.slot, location.instance, row.index),
            row.data_type.to_string(),
            row.access_text,
            format!("{}, {}", model.manual, row.section),
            choices(&row.codes, model),
            bounds(&row.codes),
            (is_readable, is_writable, is_setting(named)),
        )
    });
    let commands = names.commands().map(|(named, code)| (command_name(named, code), code.risk));
    (parameters.collect(), commands.collect())
}

/// Name, title, manual and ident number of a device by its name or its file.
#[pyfunction]
pub fn model_of(device: &str) -> PyResult<(&'static str, &'static str, &'static str, u16)> {
    let model = named(device)?;
    Ok((model.name, model.title, model.manual, model.ident))
}

/// The parameters and commands of a device by its name or its file, without a bus.
#[pyfunction]
pub fn parameters_of(device: &str) -> PyResult<(Vec<ParameterRow>, Vec<CommandRow>)> {
    Ok(tables(named(device)?))
}

/// A text such as `1e-3 mbar` in Pa.
#[pyfunction]
pub fn convert(text: &str) -> PyResult<f64> {
    Ok(text.parse::<Pressure>().map_err(Failure::usage)?.pa())
}
