//! `profivac read`: parameters of a gauge.

use crate::failure::Failure;
use crate::gauge::{AnyGauge, At};
use crate::output::{json, out};
use clap::Args;
use profivac_host::client::names::Target;
use profivac_host::client::values::{Value, hex};
use profivac_host::client::{ClientError, Reading};
use serde::Serialize;

/// Read parameters of a gauge by the manual's words or its numbers.
///
/// TARGET is a name like pirani.process-value, a slot and an index like 1/19, or those of instance 2 like 1:2/19. `profivac
/// list` shows all. Reading claims nothing and changes nothing: where several instances share a slot, the Channel Instance
/// Selector is moved to the one that is asked for and put back.
#[derive(Args, Debug)]
#[command(after_help = EXAMPLES)]
pub struct Arguments {
    #[command(flatten)]
    at: At,
    /// Print JSON
    #[arg(long)]
    json: bool,
    /// What to read
    #[arg(value_name = "TARGET", required = true)]
    targets: Vec<String>,
}

const EXAMPLES: &str = "\
Examples:
  profivac read --port /dev/ttyUSB0 --address 5 pirani.process-value
  profivac read --port /tmp/line --address 5 device.device-state trip-point.1/high-trip-point
  profivac read --port /tmp/line --address 5 --json 1:2/19";

/// What JSON says about a parameter.
#[derive(Debug, Serialize)]
pub struct Row {
    pub name: Option<String>,
    pub slot: u8,
    pub instance: u8,
    pub index: u8,
    /// A number, a text, or octets as hexadecimal digits.
    pub value: serde_json::Value,
    pub text: String,
    pub unit: Option<&'static str>,
    pub octets: String,
}

impl Row {
    pub fn of(reading: &Reading) -> Self {
        let parameter = reading.named.parameter;
        Self {
            name: Some(reading.named.name.clone()),
            slot: parameter.place.slot,
            instance: parameter.place.instance,
            index: parameter.row.id,
            value: value(&reading.value),
            text: reading.text.clone(),
            unit: reading.unit,
            octets: hex(&reading.octets),
        }
    }
}

fn value(value: &Value) -> serde_json::Value {
    match value {
        Value::Integer(number) => (*number).into(),
        // As the float of 32 bits it is, not with the digits it does not have.
        #[expect(clippy::cast_possible_truncation, reason = "it came as a float of 32 bits")]
        Value::Number(number) => {
            (*number as f32).to_string().parse::<f64>().map_or(serde_json::Value::Null, Into::into)
        }
        Value::Text(text) => text.clone().into(),
        Value::Octets(octets) => hex(octets).into(),
    }
}

/// Reads one after the other.
pub fn run(arguments: &Arguments) -> Result<(), Failure> {
    arguments.at.with(|gauge| {
        for target in &arguments.targets {
            show(gauge, target, arguments.json)?;
        }
        Ok(())
    })
}

fn show(gauge: &mut AnyGauge<'_>, target: &str, as_json: bool) -> Result<(), Failure> {
    let names = gauge.names();
    let row = match names.find(gauge.model().name, target).map_err(ClientError::from)? {
        Target::Raw { slot, index } => raw(slot, index, &gauge.read_raw(slot, index)?),
        Target::Named(_) | Target::Shown { .. } => Row::of(&gauge.parameter(target)?),
    };
    let name = row.name.clone().unwrap_or_else(|| target.to_owned());
    out(&if as_json { json(&row) } else { format!("{name} = {}", row.text) });
    Ok(())
}

/// A record of which nothing is known.
fn raw(slot: u8, index: u8, octets: &[u8]) -> Row {
    let octets = hex(octets);
    let (value, text) = (octets.clone().into(), octets.clone());
    Row { name: None, slot, instance: 0, index, value, text, unit: None, octets }
}
