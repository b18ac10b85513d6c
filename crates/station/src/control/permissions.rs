//! What something risks, who may do it, and what nobody may do from here: from the tables of the devices, in one place.
//!
//! | What | Risk | Role |
//! |---|---|---|
//! | a command without a risk in the table | harmless | operator |
//! | a command with one: degas, emission, reset, stop, ... | dangerous, in the table's words | operator |
//! | a command that leaves something behind: an adjustment, stored settings, a mode | the same | engineer |
//! | a parameter that outlives the power (store column N) | kept | engineer |
//! | a parameter that is stored on request (R) | kept on request | engineer |
//! | any other parameter | until the power goes | engineer |
//! | a value that the table has a risk for | dangerous, in the table's words | engineer |
//! | the unit and the number type | | nobody: the station reads with those it found |

use crate::auth::Role;
use profivac_devices::model::{Code, Codes, Row, Storage};
use serde::Serialize;
use utoipa::ToSchema;

/// Commands that leave something behind, by the manual's names. The tables have no column for it: what stands in the storage
/// column beside a command says nothing about it (tira56e1 has N for every command, also for `execute`).
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

/// How much something risks.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, ToSchema)]
#[serde(rename_all = "kebab-case")]
pub enum RiskClass {
    /// A command without a risk in the tables.
    Harmless,
    /// A value that is gone with the power.
    Volatile,
    /// A value that is kept when the device is told to store.
    OnRequest,
    /// A value that outlives the power.
    Kept,
    /// The tables warn of it.
    Dangerous,
}

/// What something risks.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, ToSchema)]
pub struct Risk {
    /// How much.
    pub class: RiskClass,
    /// In words: those of the table where it has some.
    pub words: String,
}

/// What it risks to write a row, or this code of it.
#[must_use]
pub fn risk(row: &Row, code: Option<&Code>) -> Risk {
    let (class, words) = match (code.map_or("", |code| code.risk), row.storage) {
        ("", _) if row.codes.is_command() => (RiskClass::Harmless, "nothing that the manual warns of"),
        ("", Storage::Nonvolatile) => (RiskClass::Kept, "stays when the power goes"),
        ("", Storage::OnRequest) => (RiskClass::OnRequest, "lost with the power unless the device is told to store it"),
        ("", Storage::Volatile | Storage::Dynamic | Storage::Unstated) => {
            (RiskClass::Volatile, "lost when the power goes")
        }
        (words, _) => (RiskClass::Dangerous, words),
    };
    Risk { class, words: words.to_owned() }
}

/// Who may write a row, or this code of it.
#[must_use]
pub fn role(row: &Row, code: Option<&Code>) -> Role {
    let lasts = code.is_some_and(|code| LASTING_COMMANDS.contains(&code.name));
    if row.codes.is_command() && !lasts { Role::Operator } else { Role::Engineer }
}

/// Why nobody may write a row from here.
#[must_use]
pub fn blocked_reason(row: &Row) -> Option<&'static str> {
    let is_presentation = row.codes == Codes::Units || row.name == "Data Type";
    is_presentation.then_some(
        "the station reads the cyclic data with the unit and the number type it found, and the device changes them only \
         without cyclic exchange: take the gauge out of the station's file, use `profivac write`, and put it back",
    )
}

#[cfg(test)]
mod tests {
    use super::*;
    use profivac_client::names::{ParameterNames, command_name};
    use profivac_devices::catalog::MODELS;

    /// Commands of a device that need an engineer.
    fn lasting(device: &str) -> Vec<String> {
        let model = MODELS.into_iter().find(|model| model.name == device).unwrap();
        let names = ParameterNames::of(model);
        let engineers =
            names.commands().filter(|(named, code)| role(named.parameter.row, Some(code)) == Role::Engineer);
        engineers.map(|(named, code)| command_name(named, code)).collect()
    }

    #[test]
    fn commands_that_leave_something_behind_need_an_engineer() {
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

    #[test]
    fn every_name_of_the_table_is_a_command_of_some_device() {
        for name in LASTING_COMMANDS {
            let has = |row: &Row| row.codes.is_command() && row.codes.codes().iter().any(|code| code.name == name);
            let rows = MODELS.iter().flat_map(|model| model.blocks).flat_map(|place| place.block.rows);
            assert!(rows.into_iter().any(has), "{name}");
        }
    }

    #[test]
    fn unit_and_number_type_are_barred_on_every_device() {
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
