//! A record that was read, as `read`, `write` and `dump` print it.

use profivac_client::ParameterReading;
use profivac_client::values::{Value, hex};
use serde::Serialize;

/// A parameter in the JSON output.
#[derive(Debug, Serialize)]
pub struct RecordRow {
    pub name: Option<String>,
    pub slot: u8,
    pub instance: u8,
    pub index: u8,
    /// A number, a string, or octets as hexadecimal digits.
    pub value: serde_json::Value,
    pub text: String,
    pub unit: Option<&'static str>,
    pub octets: String,
    /// Of a Process Value: whether the gauge reports it as valid.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub valid: Option<bool>,
    /// Of a Process Value that is not valid: why.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub reason: Option<String>,
}

impl RecordRow {
    pub fn of(reading: &ParameterReading) -> Self {
        let parameter = reading.named.parameter;
        Self {
            name: Some(reading.named.name.clone()),
            slot: parameter.location.slot,
            instance: parameter.location.instance,
            index: parameter.row.index,
            value: value(&reading.value),
            text: reading.text.clone(),
            unit: reading.unit,
            octets: hex(&reading.octets),
            valid: None,
            reason: None,
        }
    }

    /// The row of a record without a name.
    pub fn raw(slot: u8, index: u8, octets: &[u8]) -> Self {
        let octets = hex(octets);
        let (value, text) = (octets.clone().into(), octets.clone());
        Self { name: None, slot, instance: 0, index, value, text, unit: None, octets, valid: None, reason: None }
    }

    /// The value, and on the same line why it is no pressure: a script may read standard output alone.
    pub fn value_text(&self) -> String {
        let reason = self.reason.as_ref().map(|reason| format!("  (not valid: {reason})"));
        self.text.clone() + &reason.unwrap_or_default()
    }
}

fn value(value: &Value) -> serde_json::Value {
    match value {
        Value::Integer(number) => (*number).into(),
        // Printed with the digits of a 32-bit float.
        #[expect(clippy::cast_possible_truncation, reason = "the value was a 32-bit float")]
        Value::Number(number) => {
            (*number as f32).to_string().parse::<f64>().map_or(serde_json::Value::Null, Into::into)
        }
        Value::Text(text) => text.clone().into(),
        Value::Octets(octets) => hex(octets).into(),
    }
}
