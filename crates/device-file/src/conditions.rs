//! The conditions of commands in a file: the device has what they need, and a device that is like another one keeps them.

use super::device::{CodeList, Device, OwnedBlock, OwnedCode, OwnedLocation, OwnedRow, RowCodes};
use super::error::{Located, problem};
use super::words::condition_words;
use profivac_devices::model::{Access, AccessPath, DataType, Direction, Precondition, Role};
use std::mem::discriminant;
use toml::Spanned;

/// The index of Device State in slot 0.
const DEVICE_STATE_INDEX: u8 = 25;

/// A parameter that a client reads to check a condition.
struct Subject {
    slot: u8,
    instance: u8,
    kind: Kind,
}

#[derive(Clone, Copy)]
enum Kind {
    DeviceState,
    Status(Role, &'static str),
    Pressure(Role, &'static str),
}

impl Subject {
    /// The row that the client reads: the first of its kind.
    fn row<'a>(&self, device: &'a Device) -> Option<&'a OwnedRow> {
        let is_wanted = |row: &&OwnedRow| match self.kind {
            Kind::DeviceState => row.index == DEVICE_STATE_INDEX,
            Kind::Status(role, _) | Kind::Pressure(role, _) => row.role == Some(role),
        };
        let at = (self.slot, self.instance);
        let blocks = device.blocks.iter().filter(|block| block.locations.iter().any(|it| (it.slot, it.instance) == at));
        blocks.flat_map(|block| &block.rows).find(is_wanted)
    }

    /// Whether a client understands the value of this row, and reads it over every service over which it can write the command.
    fn is_checked_by(&self, row: &OwnedRow, command: &OwnedRow, device: &Device) -> bool {
        let is_number =
            || row.data_type.is_integer() && !matches!(row.codes, RowCodes::Quantity | RowCodes::PerMille(..));
        let has_type = match self.kind {
            Kind::DeviceState | Kind::Status(..) => is_number(),
            Kind::Pressure(..) => row.data_type == DataType::ByType,
        };
        let paths: &[AccessPath] = match (device.features.dpv1, device.features.ms1) {
            (true, true) => &[AccessPath::Class1, AccessPath::Class2],
            (true, false) => &[AccessPath::Class2],
            (false, _) => &[AccessPath::ParameterChannel],
        };
        let is_read = |path: &AccessPath| {
            !command.access.allows(*path, Direction::Write) || row.access.allows(*path, Direction::Read)
        };
        has_type && paths.iter().all(is_read)
    }

    fn words(&self) -> String {
        let name = match self.kind {
            Kind::DeviceState => "Device State at index 25",
            Kind::Status(_, name) | Kind::Pressure(_, name) => name,
        };
        let value = if matches!(self.kind, Kind::Pressure(..)) { "a BY_TYPE" } else { "a whole number" };
        format!("the {name} at slot {}, instance {}, {value} that a master reads", self.slot, self.instance)
    }
}

/// The parameters that a condition of a code at this location is about.
fn subjects(location: &OwnedLocation, condition: Precondition) -> Vec<Subject> {
    let own = location.instance;
    let at = |instance: u8, kind: Kind| Subject { slot: location.slot, instance, kind };
    let value = Kind::Pressure(Role::ProcessValue, "process-value");
    match condition {
        Precondition::Executing => vec![Subject { slot: 0, instance: 0, kind: Kind::DeviceState }],
        Precondition::EmissionOn => vec![at(own, Kind::Status(Role::EmissionStatus, "emission-status"))],
        Precondition::DegasOff => vec![at(own, Kind::Status(Role::DegasStatus, "degas-status"))],
        Precondition::PressureBelow(instance, _) | Precondition::PressureAbove(instance, _) => {
            vec![at(instance.unwrap_or(own), value)]
        }
        Precondition::BelowPartOfFullScale(_) => {
            vec![at(own, value), at(own, Kind::Pressure(Role::FullScale, "full-scale"))]
        }
    }
}

/// What a condition of a code needs must be in the device: the program does not check a condition about a parameter that is missing.
pub fn check_parameters(device: &Device) -> Result<(), Located> {
    for block in &device.blocks {
        for row in &block.rows {
            let codes = device.table(row.codes).map_or(&[][..], |table| table.codes().0);
            for (code, condition) in codes.iter().flat_map(|code| code.preconditions.iter().map(move |it| (code, *it)))
            {
                let mut all = block.locations.iter().flat_map(|location| subjects(location, condition));
                let is_lacking =
                    |subject: &Subject| subject.row(device).is_none_or(|it| !subject.is_checked_by(it, row, device));
                if let Some(lacking) = all.find(is_lacking) {
                    return problem(
                        row.span.clone(),
                        format!(
                            "the condition {:?} of {:?} needs {}, which the device does not have: correct the condition, or \
                             give the parameter its role",
                            condition_words(condition),
                            code.name,
                            lacking.words()
                        ),
                    );
                }
            }
        }
    }
    Ok(())
}

/// Whether every code that `parent` writes only under conditions, or with a warning, has them in `device` as well.
pub fn check_inherited(device: &Device, parent: &Device, like: &Spanned<String>) -> Result<(), Located> {
    for block in &parent.blocks {
        for row in &block.rows {
            let Some(table) = parent.table(row.codes) else { continue };
            let guarded = table.codes().0.iter().filter(|code| !code.preconditions.is_empty() || !code.risk.is_empty());
            for code in guarded {
                // An inherited block that has another place is the same block.
                let is_same = |own: &&OwnedBlock| {
                    own.name == block.name
                        || own.locations.iter().any(|at| block.locations.iter().any(|it| it.is_at(at)))
                };
                let mut same = device.blocks.iter().filter(is_same);
                let lost = same.find_map(|own| {
                    let own_row = own.rows.iter().find(|own_row| own_row.index == row.index)?;
                    let places = || own.locations.iter().zip(block.locations.iter().cycle());
                    let lost = lost_condition(device, own_row, code, table)
                        .or_else(|| places().find_map(|(own, at)| moved_subject((device, own), (parent, at), code)));
                    lost.map(|what| (own_row, what))
                });
                if let Some((own_row, what)) = lost {
                    return problem(
                        own_row.span.clone(),
                        format!(
                            "{:?} of index {}, {:?}, needs {what} in {}; a device that is like it keeps this: add it",
                            code.name,
                            row.index,
                            row.name,
                            like.get_ref()
                        ),
                    );
                }
            }
        }
    }
    Ok(())
}

/// Whether a condition of a file asks for at least what an inherited one asks for: the same, with a limit that is as strict or stricter.
fn is_as_strict(own: &Precondition, inherited: &Precondition) -> bool {
    match (own, inherited) {
        (Precondition::PressureBelow(own, limit), Precondition::PressureBelow(instance, most)) => {
            own == instance && limit <= most
        }
        (Precondition::PressureAbove(own, limit), Precondition::PressureAbove(instance, least)) => {
            own == instance && limit >= least
        }
        (Precondition::BelowPartOfFullScale(part), Precondition::BelowPartOfFullScale(most)) => part <= most,
        (own, inherited) => own == inherited,
    }
}

/// What the row lacks of the conditions and the risk of an inherited code.
fn lost_condition(device: &Device, row: &OwnedRow, inherited: &OwnedCode, table: &CodeList) -> Option<String> {
    let without = || Some("a table of codes with its conditions".to_owned());
    let Some(own_table) = device.table(row.codes) else { return without() };
    if matches!(own_table, CodeList::Bits(_)) {
        return without();
    }
    // A number that is not in the table cannot be written by name.
    let own = own_table.codes().0.iter().find(|code| code.number == inherited.number)?;
    let is_kept = |condition: &Precondition| own.preconditions.iter().any(|own| is_as_strict(own, condition));
    match inherited.preconditions.iter().find(|condition| !is_kept(condition)) {
        Some(condition) => Some(format!("the condition {:?}, or a stricter limit,", condition_words(*condition))),
        None if own.risk.is_empty() && !inherited.risk.is_empty() => Some("a risk".to_owned()),
        None if table.codes().1 && discriminant(own_table) != discriminant(table) => {
            Some(format!("{} in place of {}", table.key(), own_table.key()))
        }
        None => None,
    }
}

/// A parameter that the parent reads for a condition of the code, and that the device has at another index or does not read: with another
/// parameter in its place the condition would say nothing.
fn moved_subject(
    (device, own): (&Device, &OwnedLocation),
    (parent, at): (&Device, &OwnedLocation),
    code: &OwnedCode,
) -> Option<String> {
    let mut pairs = code.preconditions.iter().flat_map(|it| subjects(at, *it).into_iter().zip(subjects(own, *it)));
    pairs.find_map(|(inherited, subject)| {
        let (before, now) = (inherited.row(parent)?, subject.row(device)?);
        let keeps_access = now.access.contains(before.access.intersection(Access::READ));
        (before.index != now.index || !keeps_access)
            .then(|| format!("{}, with index {} and access {:?} as", subject.words(), before.index, before.access_text))
    })
}
