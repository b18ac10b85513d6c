//! Compares the settings of a file with a gauge and writes them.

use super::Setting;
use crate::error::ClientError;
use crate::gauge::{Gauge, ParameterReading, PreparedWrite};
use crate::names::NamedParameter;
use crate::records::ErrorKind;
use crate::records::Records;
use profivac_devices::model::DataType;

/// A setting whose value differs from the file.
#[derive(Debug)]
pub struct Difference {
    /// The write that would apply the value of the file.
    pub write: PreparedWrite,
    /// The present value.
    pub current: ParameterReading,
}

/// The result of restoring one setting.
#[derive(Debug)]
pub enum RestoreOutcome {
    /// The value of the file was written and read back.
    Written {
        /// The parameter.
        name: String,
        /// The value before.
        before: String,
        /// The value now.
        after: String,
    },
    /// The value was not applied.
    Refused(ClientError),
}

/// Compares a setting with the gauge. `None` if the values are equal.
///
/// # Errors
/// [`ClientError`] if the parameter cannot be read or does not accept the value.
pub fn compare<R: Records>(
    gauge: &mut Gauge<R>,
    named: &NamedParameter,
    setting: &Setting,
) -> Result<Option<Difference>, ClientError> {
    // A file may contain what the gauge had; `Difference::write` says whether the value is outside the measuring range.
    let write = gauge.prepare_forced(named, &setting.value)?;
    let current = match &write.before {
        Some(before) => before.clone(),
        None => gauge.read_parameter(named)?,
    };
    Ok((!is_same(named, &write.octets, &current.octets)).then_some(Difference { write, current }))
}

/// Whether two values are equal. A pressure converted between units may differ in the last digit.
fn is_same(named: &NamedParameter, a: &[u8], b: &[u8]) -> bool {
    let number = |octets: &[u8]| octets.try_into().ok().map(f32::from_be_bytes);
    match (named.parameter.row.data_type, number(a), number(b)) {
        (DataType::ByType | DataType::Float, Some(a), Some(b)) => (a - b).abs() <= 1e-6 * a.abs().max(b.abs()),
        _ => a == b,
    }
}

/// Writes the value of the file and reads it back.
///
/// # Errors
/// [`ClientError`] of the line. A refusal and [`ClientError::NotKept`] are part of the result.
pub fn restore<R: Records>(gauge: &mut Gauge<R>, difference: Difference) -> Result<RestoreOutcome, ClientError> {
    let (octets, text, named) =
        (difference.write.octets.clone(), difference.write.text.clone(), difference.write.named.clone());
    match gauge.execute(difference.write) {
        Ok(written) => {
            let after = written.after.as_ref().map_or_else(|| text.clone(), |after| after.text.clone());
            let is_kept = written.after.as_ref().is_none_or(|after| is_same(&named, &octets, &after.octets));
            if is_kept {
                return Ok(RestoreOutcome::Written { name: named.name, before: difference.current.text, after });
            }
            let location = gauge.context(&named);
            Ok(RestoreOutcome::Refused(ClientError::NotKept { location, written: text, found: after }))
        }
        Err(error) if error.kind() == ErrorKind::Line => Err(error),
        Err(error) => Ok(RestoreOutcome::Refused(error)),
    }
}
