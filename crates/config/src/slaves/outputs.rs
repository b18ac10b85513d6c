//! `outputs` of `[[segment.slave]]`.

use super::at;
use super::points::PointToml;
use crate::error::{Located, NamedItem};
use crate::names::unique;
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
/// valve. The `named` values replace bits of `outputs`; without `outputs` they must cover all octets.
pub fn outputs(
    gsd: &GsdSlave,
    is_owned: bool,
    given: Option<&Spanned<OutputsToml>>,
    named: &[PointToml],
    place: Range<usize>,
) -> Result<Vec<u8>, Located> {
    let length = usize::from(gsd.lengths().outputs);
    if let Some(first) = named.first() {
        if !is_owned {
            return Err(at(first.name().span(), SlaveProblem::OutputsWithoutOwn));
        }
        let base = given.map(|_| outputs(gsd, is_owned, given, &[], place.clone())).transpose()?;
        return by_name(gsd, named, base, place);
    }
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

/// The named outputs, over those in octets. Without octets each bit needs a name.
fn by_name(
    gsd: &GsdSlave,
    named: &[PointToml],
    base: Option<Vec<u8>>,
    place: Range<usize>,
) -> Result<Vec<u8>, Located> {
    unique(NamedItem::Point, named.iter().map(PointToml::name))?;
    let has_base = base.is_some();
    let mut octets = base.unwrap_or_else(|| vec![0; gsd.lengths().outputs.into()]);
    let mut taken = vec![0_u8; octets.len()];
    for output in named {
        let (point, raw) = output.output(gsd)?;
        for (octet, mask) in point.bits() {
            let Some(taken) = taken.get_mut(octet) else { continue };
            if *taken & mask != 0 {
                let output_name = output.name().get_ref().clone();
                return Err(at(output.name().span(), SlaveProblem::OutputTwice { output: output_name }));
            }
            *taken |= mask;
        }
        point.put_raw(raw, &mut octets);
    }
    let free = taken.iter().enumerate().filter(|(_, taken)| **taken != u8::MAX && !has_base);
    let missing: Vec<_> = free.filter_map(|(octet, taken)| free_bits(gsd, octet, *taken)).collect();
    if missing.is_empty() {
        return Ok(octets);
    }
    Err(at(place, SlaveProblem::OutputsWithoutValue { missing: missing.join(", ") }))
}

/// `slot 2 4DO octet 0`, or `slot 2 4DO octet 0 bits 4, 5, 6, 7`.
fn free_bits(gsd: &GsdSlave, octet: usize, taken: u8) -> Option<String> {
    let name = gsd.layout().name_of(Direction::Output, octet)?;
    let bits: Vec<_> = (0..8).filter(|bit| taken >> bit & 1 == 0).map(|bit: u8| bit.to_string()).collect();
    Some(if taken == 0 { name } else { format!("{name} bits {}", bits.join(", ")) })
}

fn described(data: ModuleData<'_>) -> String {
    format!("{} ({} {})", data.name(), data.octets, if data.octets == 1 { "octet" } else { "octets" })
}

fn modules(gsd: &GsdSlave) -> String {
    let all: Vec<String> = gsd.layout().outputs().map(described).collect();
    if all.is_empty() { "none".to_owned() } else { all.join(", ") }
}
