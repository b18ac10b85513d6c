//! The risk of writing a row, the role it needs, and what the station never writes: decided here, from the tables of the devices.
//!
//! | Operation | Risk | Role |
//! |---|---|---|
//! | a command without a risk in the table | harmless | operator |
//! | a command with a risk: degas, emission, reset, stop, ... | dangerous, as the table says | operator |
//! | a command with a lasting effect: an adjustment, stored settings, a mode | the same | engineer |
//! | a command of a device file that no built-in device has: its effect may last | the same | engineer |
//! | a nonvolatile parameter (store column N) | kept | engineer |
//! | a parameter that is stored on request (R) | kept on request | engineer |
//! | any other parameter | lost at power-off | engineer |
//! | a value with a risk in the table | dangerous, as the table says | engineer |
//! | the unit and the number type | | none: the station decodes the cyclic data with those it found |

use crate::view::{Risk, RiskClass};
use profivac_devices::catalog::MODELS;
use profivac_devices::model::{Code, Role as ParameterRole, Row, Storage};
use profivac_web_server::auth::Role;
use std::collections::HashSet;
use std::sync::LazyLock;

/// Commands with a lasting effect, by the manual's names. The tables have no column for this: the storage column of a command says
/// nothing about it (tira56e1 has N for every command, also for `execute`).
pub const LASTING_COMMANDS: [&str; 10] = [
    "atmosphere-adjust",
    "atmosphere-adjust-off",
    "automatic-mode",
    "disable-offset",
    "full-scale-adjust",
    "gain-adjust",
    "manual-mode",
    "store",
    "store-and-hotstart",
    "zero-adjust",
];

/// The commands of the built-in devices.
static KNOWN_COMMANDS: LazyLock<HashSet<&str>> = LazyLock::new(|| {
    let rows = MODELS.iter().flat_map(|model| model.blocks).flat_map(|placed| placed.block.rows);
    rows.filter(|row| row.codes.is_command()).flat_map(|row| row.codes.codes()).map(|code| code.name).collect()
});

/// The risk of writing a row, or this code of it.
#[must_use]
pub fn risk(row: &Row, code: Option<&Code>) -> Risk {
    let (class, words) = match (code.map_or("", |code| code.risk), row.storage) {
        ("", _) if row.codes.is_command() => (RiskClass::Harmless, "the manual names no risk; relays may switch"),
        ("", Storage::Nonvolatile) => (RiskClass::Persistent, "kept at power-off"),
        ("", Storage::OnRequest) => (RiskClass::StoredOnRequest, "lost at power-off unless the device stores it"),
        ("", Storage::Volatile | Storage::Dynamic | Storage::Unstated) => (RiskClass::Volatile, "lost at power-off"),
        (words, _) => (RiskClass::Dangerous, words),
    };
    Risk { class, description: words.to_owned() }
}

/// The role that is needed to write a row, or this code of it.
#[must_use]
pub fn role(row: &Row, code: Option<&Code>) -> Role {
    let lasts = code.is_some_and(|code| LASTING_COMMANDS.contains(&code.name) || !KNOWN_COMMANDS.contains(code.name));
    if row.codes.is_command() && !lasts { Role::Operator } else { Role::Engineer }
}

/// The reason why the station never writes a row.
#[must_use]
pub fn blocked_reason(row: &Row) -> Option<&'static str> {
    matches!(row.role, Some(ParameterRole::Unit | ParameterRole::NumberType)).then_some(
        "the station reads the cyclic data with the unit and the number type it found: take the gauge out of the station's \
         file, use `profivac write`, and put it back",
    )
}

#[cfg(test)]
mod tests {
    use super::*;
    use profivac_client::names::{ParameterNames, command_name};
    use profivac_devices::bcg450::table::MODEL;
    use profivac_devices::model::{Codes, code};

    /// The commands of a device that need an engineer.
    fn lasting(device: &str) -> Vec<String> {
        let model = MODELS.into_iter().find(|model| model.name == device).unwrap();
        let names = ParameterNames::of(model);
        let engineers =
            names.commands().filter(|(named, code)| role(named.parameter.row, Some(code)) == Role::Engineer);
        engineers.map(|(named, code)| command_name(named, code)).collect()
    }

    #[test]
    fn commands_with_a_lasting_effect_need_an_engineer() {
        assert_eq!(
            lasting("bcg450"),
            ["ba.manual-mode", "ba.automatic-mode", "atmosphere.atmosphere-adjust", "atmosphere.atmosphere-adjust-off"]
        );
        assert_eq!(
            lasting("pcg550"),
            ["cdg.zero-adjust", "pirani.zero-adjust", "pirani.gain-adjust", "atm.gain-adjust"]
        );
        assert_eq!(lasting("bpg400"), ["one-of-n.full-scale-adjust"]);
        assert!(lasting("tpg300").contains(&"device.store-and-hotstart".to_owned()), "{:?}", lasting("tpg300"));
    }

    /// A device file may call an adjustment as it likes.
    #[test]
    fn a_command_that_no_built_in_device_has_needs_an_engineer() {
        let row = MODEL.blocks.iter().flat_map(|placed| placed.block.rows).find(|row| row.codes.is_command()).unwrap();
        let [known, unknown] = [code(1, "degas-on"), code(1, "adjust-all")];
        assert_eq!((role(row, Some(&known)), role(row, Some(&unknown))), (Role::Operator, Role::Engineer));
    }

    #[test]
    fn every_lasting_command_is_a_command_of_a_device() {
        for name in LASTING_COMMANDS {
            let has = |row: &Row| row.codes.is_command() && row.codes.codes().iter().any(|code| code.name == name);
            let rows = MODELS.iter().flat_map(|model| model.blocks).flat_map(|placed| placed.block.rows);
            assert!(rows.into_iter().any(has), "{name}");
        }
    }

    #[test]
    fn the_unit_and_the_number_type_are_blocked_on_every_device() {
        for model in MODELS {
            let names = ParameterNames::of(model);
            for named in names.all() {
                let row = named.parameter.row;
                let is_meant = matches!(row.name, "Data Type" | "Data Unit" | "Data Units");
                assert_eq!(blocked_reason(row).is_some(), is_meant || row.codes == Codes::Units, "{named}");
            }
        }
    }
}
