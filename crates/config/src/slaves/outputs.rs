//! `outputs` of `[[segment.slave]]`.

use super::at;
use crate::error::Located;
use crate::slave_problem::SlaveProblem;
use crate::values::hex;
use profivac_gsd_slave::{Direction, GsdSlave, ModuleData};
use serde::Deserialize;
use std::collections::BTreeMap;
use std::ops::Range;
use toml::Spanned;

/// `outputs`: all octets, or the octets of each module.
#[derive(Debug, Deserialize)]
#[serde(untagged)]
pub enum OutputsToml {
    /// All octets in hexadecimal.
    All(String),
    /// The octets of each module with outputs, by its slot.
    Slots(BTreeMap<String, String>),
}

/// The outputs of a slave. Only one that the station owns has outputs, and its file must name each octet: zeros can stop a pump or close a
/// valve.
pub fn outputs(
    gsd: &GsdSlave,
    is_owned: bool,
    given: Option<&Spanned<OutputsToml>>,
    place: Range<usize>,
) -> Result<Vec<u8>, Located> {
    let length = usize::from(gsd.lengths().outputs);
    let Some(given) = given else {
        return if is_owned && length > 0 {
            Err(at(place, SlaveProblem::OutputsNeeded { modules: modules(gsd), octets: length }))
        } else {
            Ok(Vec::new())
        };
    };
    let checked = match given.get_ref() {
        _ if !is_owned => Err(SlaveProblem::OutputsWithoutOwn),
        OutputsToml::All(text) => octets(text, &modules(gsd), length),
        OutputsToml::Slots(slots) => by_slot(gsd, slots),
    };
    checked.map_err(|problem| at(given.span(), problem))
}

/// The octets in `text`, which must be `expected` ones.
fn octets(text: &str, of: &str, expected: usize) -> Result<Vec<u8>, SlaveProblem> {
    let octets = hex(text).ok_or_else(|| SlaveProblem::OutputOctets(text.to_owned()))?;
    if octets.len() == expected {
        return Ok(octets);
    }
    Err(SlaveProblem::OutputLength { of: of.to_owned(), expected, found: octets.len() })
}

fn by_slot(gsd: &GsdSlave, slots: &BTreeMap<String, String>) -> Result<Vec<u8>, SlaveProblem> {
    let has_outputs = |slot: &String| gsd.layout().outputs().any(|data| data.module.slot.to_string() == *slot);
    if let Some(slot) = slots.keys().find(|slot| !has_outputs(slot)) {
        return Err(SlaveProblem::OutputSlot { slot: slot.clone(), possible: modules(gsd) });
    }
    let of_module = |data: ModuleData<'_>| {
        let label = described(data);
        let text = slots.get(&data.module.slot.to_string());
        text.ok_or_else(|| SlaveProblem::OutputMissing(label.clone()))
            .and_then(|text| octets(text, &label, data.octets))
    };
    let all: Vec<Vec<u8>> = gsd.layout().data(Direction::Output).map(of_module).collect::<Result<_, _>>()?;
    Ok(all.concat())
}

fn described(data: ModuleData<'_>) -> String {
    format!("{} ({} {})", data.name(), data.octets, if data.octets == 1 { "octet" } else { "octets" })
}

fn modules(gsd: &GsdSlave) -> String {
    let all: Vec<String> = gsd.layout().outputs().map(described).collect();
    if all.is_empty() { "none".to_owned() } else { all.join(", ") }
}
