//! The blocks, parameters and code tables of a device file.

use super::{MAX_ENTRIES, MAX_PARAMETERS, limited, only_once, remark, words};
use crate::device::{CodeList, OwnedBlock, OwnedCode, OwnedLocation, OwnedQuantity, OwnedRow, RowCodes};
use crate::error::{Located, problem};
use crate::toml_file::{BlockToml, CodeToml, CodesToml, RowToml};
use crate::words::{BEHAVIOURS, ROLES, STORAGES, access, condition, data_type, unknown, value_of};
use profivac_devices::model::{DataType, Role, Storage};
use std::collections::{BTreeMap, BTreeSet};
use std::ops::Range;
use toml::Spanned;

/// The code tables of a file, and their names.
pub(super) struct Tables<'a> {
    names: Vec<&'a str>,
    pub(super) lists: Vec<CodeList>,
}

/// The value of `codes` for the codes of `units`.
pub const UNITS: &str = "units";
/// The value of `codes` for six digits and a letter.
pub const VERSION: &str = "version";

impl<'a> Tables<'a> {
    pub(super) fn of(tables: &'a BTreeMap<String, Spanned<CodesToml>>) -> Result<Self, Located> {
        for (name, table) in tables {
            if [UNITS, VERSION].contains(&name.as_str()) {
                return problem(
                    table.span(),
                    format!("codes = {name:?} has a meaning of its own; choose another name"),
                );
            }
        }
        let lists = tables.values().map(code_list).collect::<Result<_, _>>()?;
        Ok(Self { names: tables.keys().map(String::as_str).collect(), lists })
    }

    /// The codes of a row.
    fn codes(&self, entry: &Spanned<RowToml>) -> Result<RowCodes, Located> {
        let row = entry.get_ref();
        let range = |limits: &Spanned<(i64, i64)>, codes: fn(i64, i64) -> RowCodes| {
            ordered(limits).map(|(low, high)| codes(low, high))
        };
        if row.unit.is_some() {
            return match (&row.codes, &row.per_mille) {
                (None, None) => Ok(RowCodes::Quantity),
                _ => problem(entry.span(), "a number in a unit has no codes and no per-mille; delete the others"),
            };
        }
        match (&row.codes, &row.range, &row.per_mille) {
            (None, None, None) => Ok(RowCodes::Plain),
            (None, Some(limits), None) => range(limits, RowCodes::Range),
            (None, None, Some(limits)) => range(limits, RowCodes::PerMille),
            (Some(name), None, None) => match name.get_ref().as_str() {
                UNITS => Ok(RowCodes::Units),
                VERSION => Ok(RowCodes::Version),
                text => self.names.iter().position(|known| *known == text).map(RowCodes::Table).ok_or_else(|| {
                    unknown(
                        name,
                        &format!("a table of [codes], {UNITS:?} or {VERSION:?}"),
                        self.names.iter().copied().chain([UNITS, VERSION]),
                    )
                }),
            },
            _ => problem(entry.span(), "a parameter has one of codes, range and per-mille; delete the others"),
        }
    }
}

impl Tables<'_> {
    /// The position of the table with names that a value of the cyclic data has.
    pub(super) fn of_names(&self, name: &Spanned<String>) -> Result<usize, Located> {
        let all = || self.names.iter().copied().zip(&self.lists);
        let found = all().position(|(known, list)| known == name.get_ref().as_str() && is_of_names(list));
        found.ok_or_else(|| {
            let known = all().filter(|(_, list)| is_of_names(list)).map(|(known, _)| known);
            unknown(name, "a table of [codes] with names", known)
        })
    }
}

const fn is_of_names(list: &CodeList) -> bool {
    matches!(list, CodeList::Names(_))
}

/// Two limits, the lower one first.
fn ordered(limits: &Spanned<(i64, i64)>) -> Result<(i64, i64), Located> {
    let (low, high) = *limits.get_ref();
    if low <= high { Ok((low, high)) } else { problem(limits.span(), "expected the lower limit first") }
}

/// The unit of a number that is no pressure.
pub(super) fn quantity(
    unit: Option<&Spanned<String>>,
    factor: Option<&Spanned<f64>>,
    range: Option<&Spanned<(i64, i64)>>,
    data_type: DataType,
) -> Result<Option<OwnedQuantity>, Located> {
    let Some(unit) = unit else {
        return match factor {
            None => Ok(None),
            Some(factor) => problem(factor.span(), "factor is for a number with a unit; add unit, or delete factor"),
        };
    };
    let is_number = (data_type.is_integer() && data_type != DataType::Boolean) || data_type == DataType::Float;
    if !is_number {
        return problem(unit.span(), format!("a unit is for a number; {data_type} has none, delete it"));
    }
    let factor = match factor {
        None => 1.0,
        Some(factor) if (1e-9..=1e9).contains(factor.get_ref()) => *factor.get_ref(),
        Some(factor) => return problem(factor.span(), "expected a factor from 1e-9 to 1e9"),
    };
    Ok(Some(OwnedQuantity { unit: words(unit)?, factor, range: range.map(ordered).transpose()? }))
}

fn code_list(table: &Spanned<CodesToml>) -> Result<CodeList, Located> {
    match table.get_ref() {
        CodesToml { names: Some(list), commands: None, bit_commands: None, bits: None } => {
            codes(table.span(), list).map(CodeList::Names)
        }
        CodesToml { names: None, commands: Some(list), bit_commands: None, bits: None } => {
            codes(table.span(), list).map(CodeList::Commands)
        }
        CodesToml { names: None, commands: None, bit_commands: Some(list), bits: None } => {
            codes(table.span(), list).map(CodeList::BitCommands)
        }
        CodesToml { names: None, commands: None, bit_commands: None, bits: Some(list) } => {
            limited(table.span(), list.len(), "bits")?;
            let mut seen = BTreeSet::new();
            let bits = list.iter().map(|entry| {
                let bit = entry.get_ref();
                only_once(&mut seen, bit.bit, entry.span(), &format!("the bit {}", bit.bit))?;
                if bit.bit > 31 {
                    return problem(entry.span(), format!("expected a bit from 0 to 31, found {}", bit.bit));
                }
                Ok((bit.bit, words(&bit.name)?))
            });
            bits.collect::<Result<_, _>>().map(CodeList::Bits)
        }
        _ => problem(table.span(), "a table of codes has one of the lists names, commands, bit-commands and bits"),
    }
}

fn codes(span: Range<usize>, list: &[Spanned<CodeToml>]) -> Result<Vec<OwnedCode>, Located> {
    limited(span, list.len(), "codes")?;
    let (mut numbers, mut names) = (BTreeSet::new(), BTreeSet::new());
    let code = |entry: &Spanned<CodeToml>| {
        let CodeToml { code, name, needs, risk } = entry.get_ref();
        only_once(&mut numbers, *code, entry.span(), &format!("the code {code}"))?;
        only_once(&mut names, name.get_ref().clone(), name.span(), &format!("the name {:?}", name.get_ref()))?;
        Ok(OwnedCode {
            number: *code,
            name: words(name)?,
            preconditions: needs.iter().map(condition).collect::<Result<_, _>>()?,
            risk: risk.as_ref().map_or_else(|| Ok(String::new()), remark)?,
        })
    };
    list.iter().map(code).collect()
}

pub(super) fn blocks(blocks: &[BlockToml], tables: &Tables<'_>) -> Result<Vec<OwnedBlock>, Located> {
    let (mut types, mut count) = (BTreeMap::new(), 0_usize);
    let mut all = Vec::new();
    for toml in blocks {
        let block = block(toml, tables)?;
        count = count.saturating_add(block.rows.len().saturating_mul(block.locations.len()));
        if count > MAX_PARAMETERS || all.len() >= MAX_ENTRIES {
            return problem(
                toml.name.span(),
                format!(
                    "expected at most {MAX_PARAMETERS} parameters, each location counted, in at most {MAX_ENTRIES} blocks"
                ),
            );
        }
        check_types(&block, &mut types)?;
        all.push(block);
    }
    Ok(all)
}

/// Where no parameter has the name or the role of the unit, those with the codes of the units are it.
pub(super) fn find_unit(blocks: &mut [OwnedBlock], file: &[BlockToml]) {
    let entries = file.iter().flat_map(|block| &block.parameters);
    let given: BTreeSet<_> = entries.filter(|row| row.get_ref().role.is_some()).map(|row| row.span().start).collect();
    let rows = || blocks.iter().flat_map(|block| &block.rows);
    if rows().any(|row| row.role == Some(Role::Unit)) {
        return;
    }
    for row in blocks.iter_mut().flat_map(|block| &mut block.rows) {
        if row.codes == RowCodes::Units && !given.contains(&row.span.start) {
            row.role = row.role.or(Some(Role::Unit));
        }
    }
}

/// The type of the parameter at a slot, index and instance.
type Types = BTreeMap<(u8, u8, u8), DataType>;

/// Two blocks may be at one location if the rows that both have are of the same type: the device decides which it is. An index that the
/// instances of a slot have is not in its instance 0 as well: both would be the same record.
fn check_types(block: &OwnedBlock, types: &mut Types) -> Result<(), Located> {
    for (location, row) in block.locations.iter().flat_map(|location| block.rows.iter().map(move |row| (location, row)))
    {
        let numbers = (location.slot, row.index, location.instance);
        let mut others = types.range((location.slot, row.index, 0)..=(location.slot, row.index, u8::MAX));
        let other = others.find(|((.., instance), _)| (*instance == 0) != (location.instance == 0));
        if let Some(((slot, index, instance), _)) = other {
            return problem(
                row.span.clone(),
                format!(
                    "slot {slot}, index {index} is of instance {instance} in an earlier block and of instance {} here: instance 0 is for \
                     a slot or a parameter without instances; correct at",
                    location.instance
                ),
            );
        }
        let first = *types.entry(numbers).or_insert(row.data_type);
        if first != row.data_type {
            let (slot, index, instance) = numbers;
            return problem(
                row.span.clone(),
                format!(
                    "slot {slot}, instance {instance}, index {index} is {first} in an earlier block and {} here",
                    row.data_type
                ),
            );
        }
    }
    Ok(())
}

fn block(toml: &BlockToml, tables: &Tables<'_>) -> Result<OwnedBlock, Located> {
    let mut rows = toml.parameters.iter().map(|entry| row(entry, tables)).collect::<Result<Vec<_>, _>>()?;
    // A block is searched in the order of its indices.
    rows.sort_by_key(|row| row.index);
    for pair in rows.windows(2) {
        if let [first, second] = pair
            && first.index == second.index
        {
            return problem(
                second.span.clone(),
                format!("index {} is in this block twice; delete one row", second.index),
            );
        }
    }
    let Some(list) = &toml.at else {
        return problem(
            toml.name.span(),
            "expected the locations of the block: at = [{ slot = 0, name = \"Device\" }], or at = [] if the device does not have it",
        );
    };
    let mut locations: Vec<OwnedLocation> = Vec::new();
    for entry in list.get_ref() {
        let location = entry.get_ref();
        let owned = OwnedLocation { slot: location.slot, instance: location.instance, name: words(&location.name)? };
        if locations.iter().any(|other| other.is_at(&owned)) {
            return problem(entry.span(), "the block is at this slot and instance already; delete one of both");
        }
        locations.push(owned);
    }
    let behaviour =
        toml.behaviour.as_ref().map(|name| value_of(&BEHAVIOURS, name, "a behaviour of a block")).transpose()?;
    Ok(OwnedBlock { name: words(&toml.name)?, block_type: toml.block_type, behaviour, rows, locations })
}

fn row(entry: &Spanned<RowToml>, tables: &Tables<'_>) -> Result<OwnedRow, Located> {
    let toml = entry.get_ref();
    let name = words(&toml.name)?;
    let data_type = data_type(&toml.data_type)?;
    let role = match &toml.role {
        Some(role) => value_of(&ROLES, role, "a role")?,
        None => Role::of_printed_name(&name),
    };
    Ok(OwnedRow {
        span: entry.span(),
        index: toml.index,
        data_type,
        access: access(&toml.access)?,
        access_text: words(&toml.access)?,
        storage: toml
            .store
            .as_ref()
            .map_or(Ok(Storage::Unstated), |store| value_of(&STORAGES, store, "a store class"))?,
        section: toml.section.as_ref().map_or_else(|| Ok(String::new()), words)?,
        codes: tables.codes(entry)?,
        quantity: quantity(toml.unit.as_ref(), toml.factor.as_ref(), toml.range.as_ref(), data_type)?,
        role,
        name,
    })
}
