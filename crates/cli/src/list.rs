//! `profivac list`: lists the parameters of a gauge.

use crate::device_files::named;
use crate::failure::Failure;
use crate::gauge::OptionalGaugeOptions;
use crate::output::{json, out};
use clap::Args;
use profivac_client::names::{NamedParameter, ParameterNames};
use profivac_client::values::format_number;
use profivac_devices::catalog::is_built_in;
use profivac_devices::model::{Codes, Model, Quantity};
use serde::Serialize;

/// List the parameters of a gauge: its block tree with names, numbers, types, access, sections of the manual and codes.
///
/// With --port and --address the command asks a gauge for its model; with --device it needs no bus. TARGET selects the names and
/// commands that contain it, an index like 19, or numbers like 1/19.
///
/// Access is as printed in the manual: 1_R read by a class 1 master, 2_W written by class 2, 0_XI in the cyclic data. Store classes:
/// N survives power loss, V is lost, R is stored on request, D follows from others. BY_TYPE is a pressure: an integer or a float,
/// depending on the data type of the gauge. Commands of a device file are marked: their conditions and risks are as good as the file.
#[derive(Args, Debug)]
#[command(after_help = EXAMPLES)]
pub struct Arguments {
    #[command(flatten)]
    options: OptionalGaugeOptions,
    /// A device by its name, for instance bcg450, or a device file; needs no bus
    #[arg(long, value_name = "DEVICE|FILE.toml")]
    device: Option<String>,
    /// Print JSON
    #[arg(long)]
    json: bool,
    /// Show only names and commands that contain this text, or these numbers
    #[arg(value_name = "TARGET")]
    target: Option<String>,
}

const EXAMPLES: &str = "\
Examples:
  profivac list --port /dev/ttyUSB0 --address 5
  profivac list --port /tmp/line --address 5 trip-point
  profivac list --device bcg450 command         # the commands it has
  profivac list --device BCG450-SP 1/19         # every instance of these numbers
  profivac list --device bcg450 --json
  profivac list --device my-gauge.toml";

/// A parameter in the JSON output.
#[derive(Debug, Serialize)]
struct Row<'a> {
    name: &'a str,
    slot: u8,
    instance: u8,
    index: u8,
    #[serde(rename = "place")]
    location: &'static str,
    block: &'static str,
    /// The name as printed in the manual.
    printed: &'static str,
    #[serde(rename = "type")]
    data_type: String,
    access: &'static str,
    storage: String,
    manual: &'static str,
    section: &'static str,
    /// The unit of a number that is no pressure.
    #[serde(skip_serializing_if = "Option::is_none")]
    unit: Option<&'static str>,
    codes: Vec<Code>,
}

#[derive(Debug, Serialize)]
struct Code {
    number: u16,
    name: &'static str,
    #[serde(skip_serializing_if = "str::is_empty")]
    risk: &'static str,
    /// A command of a device file: its conditions and its risk are as good as the file.
    #[serde(skip_serializing_if = "std::ops::Not::not")]
    from_device_file: bool,
}

impl Code {
    /// A code without a mark.
    const fn plain(number: u16, name: &'static str, risk: &'static str) -> Self {
        Self { number, name, risk, from_device_file: false }
    }
}

/// Prints the list.
pub fn run(arguments: &Arguments) -> Result<(), Failure> {
    let (model, origin) = match (&arguments.options.gauge, &arguments.device) {
        (_, Some(device)) => {
            arguments.options.device_files.read()?;
            (named(device)?, String::new())
        }
        (Some(options), None) => {
            (options.with_gauge(|gauge| Ok(gauge.model()))?, format!(" at address {}", options.address))
        }
        (None, None) => {
            return Err(Failure::usage("expected --port and --address of a gauge, or --device with a name"));
        }
    };
    let names = ParameterNames::of(model);
    let parameters: Vec<_> =
        names.all().iter().filter(|named| matches_target(named, arguments.target.as_deref())).collect();
    if let (true, Some(target)) = (parameters.is_empty(), &arguments.target) {
        names.find(model.name, target).map_err(profivac_client::ClientError::from)?;
        return Err(Failure::usage(format!("{} has no parameter with {target:?} in its name", model.name)));
    }
    if arguments.json {
        out(&json(&parameters.iter().map(|named| row(named, model)).collect::<Vec<_>>()));
    } else {
        let file = if is_built_in(model) { "" } else { ", from a device file" };
        let heading = format!("{} ({}, {}{file}{origin})", model.name, model.title, model.manual);
        out(&tree(&heading, &parameters, |named| facts(named, model)));
    }
    Ok(())
}

/// Whether the search for `target` shows the parameter; without a target all are shown.
pub fn matches_target(named: &NamedParameter, target: Option<&str>) -> bool {
    target.is_none_or(|target| named.is_found_by(target))
}

/// A heading, a line for each location and block, and one for each parameter with the text of `facts`.
pub fn tree(heading: &str, parameters: &[&NamedParameter], mut facts: impl FnMut(&NamedParameter) -> String) -> String {
    let width = parameters.iter().map(|named| named.name.len()).max().unwrap_or_default();
    let mut text = heading.to_owned();
    let mut last = None;
    for named in parameters {
        let parameter = named.parameter;
        let location = (parameter.location.slot, parameter.location.instance, parameter.block.name);
        if last.replace(location) != Some(location) {
            let (slot, instance, block) = location;
            let instance = if instance > 0 { format!(", instance {instance}") } else { String::new() };
            text.push_str(&format!("\n\nslot {slot}{instance}: {} - {block}", parameter.location.name));
        }
        text.push_str(format!("\n  {:<8} {:<width$}  {}", parameter.numbers(), named.name, facts(named)).trim_end());
    }
    text
}

/// Type, access, store class, section, codes.
fn facts(named: &NamedParameter, model: &Model) -> String {
    let row = named.parameter.row;
    let data_type = row.data_type.to_string();
    format!("{data_type:<12} {:<18} {}  {:<9} {}", row.access_text, row.storage, row.section, code_names(named, model))
}

/// The codes of a parameter, as text.
fn code_names(named: &NamedParameter, model: &Model) -> String {
    let codes = &named.parameter.row.codes;
    let list =
        || codes.codes().iter().map(|code| format!("{} {}", code.number, code.name)).collect::<Vec<_>>().join(", ");
    match codes {
        Codes::Plain => String::new(),
        Codes::Version => "version: six digits and a letter".to_owned(),
        Codes::Range(low, high) => format!("{low} to {high}"),
        Codes::PerMille(low, high) => {
            let [low, high] = [*low, *high].map(|number| number as f64 / 10.0);
            format!("{low} % to {high} %")
        }
        Codes::Quantity(quantity) => numbers(*quantity),
        Codes::Names(_) => list(),
        Codes::Commands(codes) | Codes::BitCommands(codes) => {
            let of = if is_built_in(model) { "" } else { " of a device file" };
            format!("commands{of}: {}", codes.iter().map(|code| code.name).collect::<Vec<_>>().join(", "))
        }
        Codes::Bits(bits) => {
            format!("bits: {}", bits.iter().map(|(bit, name)| format!("{bit} {name}")).collect::<Vec<_>>().join(", "))
        }
        Codes::Units => {
            model.units.iter().map(|unit| format!("{} {}", unit.code, unit.name)).collect::<Vec<_>>().join(", ")
        }
    }
}

/// The limits, or the unit, of a number in a unit; then its steps, which the octets of the record count.
fn numbers(quantity: Quantity) -> String {
    let Quantity { unit, factor, range } = quantity;
    let numbers = match range {
        Some(limits) => {
            let [low, high] = <[i64; 2]>::from(limits).map(|number| format_number(number as f64 * factor));
            format!("{low} {unit} to {high} {unit}")
        }
        None => format!("in {unit}"),
    };
    if factor.total_cmp(&1.0).is_eq() { numbers } else { format!("{numbers}, in steps of {factor} {unit}") }
}

fn row<'a>(named: &'a NamedParameter, model: &'static Model) -> Row<'a> {
    let parameter = named.parameter;
    let row = parameter.row;
    let codes = match row.codes {
        Codes::Units => model.units.iter().map(|unit| Code::plain(unit.code, unit.name, "")).collect(),
        _ => row
            .codes
            .codes()
            .iter()
            .map(|code| Code {
                from_device_file: row.codes.is_command() && !is_built_in(model),
                ..Code::plain(code.number, code.name, code.risk)
            })
            .collect(),
    };
    Row {
        name: &named.name,
        slot: parameter.location.slot,
        instance: parameter.location.instance,
        index: row.index,
        location: parameter.location.name,
        block: parameter.block.name,
        printed: row.name,
        data_type: row.data_type.to_string(),
        access: row.access_text,
        storage: row.storage.to_string(),
        manual: model.manual,
        section: row.section,
        unit: match row.codes {
            Codes::Quantity(quantity) => Some(quantity.unit),
            _ => None,
        },
        codes,
    }
}
