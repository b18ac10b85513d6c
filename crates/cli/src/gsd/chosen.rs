//! `gsd show --modules`: the octets of Set_Prm and Chk_Cfg for chosen modules and parameters, and what each octet of the data is.

use profivac_client::values::hex;
use profivac_gsd::{Configuration, Place};
use profivac_gsd_slave::{Direction, GsdSlave, ModuleData};
use serde::Serialize;

/// A slave with chosen modules, as it is printed.
#[derive(Serialize)]
pub struct Chosen {
    chk_cfg: String,
    /// The user parameters, from octet 7 of Set_Prm on.
    user_prm: String,
    modules: Vec<ChosenModule>,
    parameters: Vec<ChosenParameter>,
    inputs: Vec<Octets>,
    outputs: Vec<Octets>,
    /// What the octets lack.
    warnings: Vec<String>,
}

#[derive(Serialize)]
struct ChosenModule {
    slot: u32,
    number: u32,
    name: String,
    config: String,
    /// Its identifiers within Chk_Cfg, counted from 0 as diagnosis counts them.
    identifiers: Vec<usize>,
}

#[derive(Serialize)]
struct ChosenParameter {
    /// The slot; none for the station.
    slot: Option<u32>,
    /// The first octet within the parameters of this place.
    offset: u8,
    name: String,
    value: i64,
    text: Option<String>,
}

/// Octets of a module in the inputs or outputs of the slave.
#[derive(Serialize)]
struct Octets {
    first: usize,
    octets: usize,
    slot: u32,
    module: String,
}

impl Chosen {
    pub fn of(slave: &GsdSlave) -> Self {
        let modules = slave.layout().modules.iter().map(|module| ChosenModule {
            slot: module.slot,
            number: module.number,
            name: module.name.clone(),
            config: hex(&module.config),
            identifiers: module.identifiers.clone().collect(),
        });
        let octets = |direction| slave.layout().data(direction).map(|data| Octets::of(&data)).collect();
        Self {
            chk_cfg: hex(slave.chk_cfg()),
            user_prm: hex(slave.user_prm()),
            modules: modules.collect(),
            parameters: parameters(&slave.configuration(), slave),
            inputs: octets(Direction::Input),
            outputs: octets(Direction::Output),
            warnings: slave.warnings().iter().map(ToString::to_string).collect(),
        }
    }

    /// The lines for people.
    pub fn lines(&self) -> Vec<String> {
        let mut lines = vec![
            format!("Chk_Cfg          {}", self.chk_cfg),
            format!("user parameters  {}", if self.user_prm.is_empty() { "-" } else { &self.user_prm }),
            "modules".to_owned(),
        ];
        lines.extend(self.modules.iter().map(ChosenModule::line));
        if !self.parameters.is_empty() {
            lines.push("parameters".to_owned());
            lines.extend(self.parameters.iter().map(ChosenParameter::line));
        }
        for (name, areas) in [("inputs", &self.inputs), ("outputs", &self.outputs)] {
            if !areas.is_empty() {
                lines.push(name.to_owned());
                lines.extend(areas.iter().map(Octets::line));
            }
        }
        lines.extend(self.warnings.iter().map(|warning| format!("warning  {warning}")));
        lines
    }
}

fn parameters(configuration: &Configuration<'_>, slave: &GsdSlave) -> Vec<ChosenParameter> {
    let shown = |placed: &profivac_gsd::PlacedParameter<'_>| ChosenParameter {
        slot: match placed.place {
            Place::Station => None,
            Place::Slot(slot) => Some(slot),
        },
        offset: placed.offset,
        name: placed.parameter.name.clone(),
        value: placed.value,
        text: slave.device().text_of(placed.parameter, placed.value).map(|text| text.trim().to_owned()),
    };
    configuration.parameters().iter().map(shown).collect()
}

impl ChosenModule {
    fn line(&self) -> String {
        let Self { slot, number, name, config, identifiers } = self;
        let identifiers = match (identifiers.first(), identifiers.last()) {
            (Some(first), Some(last)) if first == last => format!("identifier {first} of the diagnosis"),
            (Some(first), Some(last)) => format!("identifiers {first} to {last} of the diagnosis"),
            _ => "without an identifier".to_owned(),
        };
        format!("  slot {slot}: module {number}, {name}: {config}, {identifiers}")
    }
}

impl ChosenParameter {
    fn line(&self) -> String {
        let Self { slot, offset, name, value, text } = self;
        let place = slot.map_or_else(|| "station".to_owned(), |slot| format!("slot {slot}"));
        let value = text.as_ref().map_or_else(|| value.to_string(), |text| format!("{text} ({value})"));
        format!("  {place}, octet {offset}: {name} = {value}")
    }
}

impl Octets {
    fn of(data: &ModuleData<'_>) -> Self {
        Self { first: data.start, octets: data.octets, slot: data.module.slot, module: data.module.name.clone() }
    }

    fn line(&self) -> String {
        let Self { first, octets, slot, module } = self;
        let range = match octets {
            1 => format!("octet {first}"),
            _ => format!("octets {first} to {}", first.saturating_add(*octets).saturating_sub(1)),
        };
        format!("  {range}: slot {slot} {module}")
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "a test")]

    use super::*;
    use profivac_gsd::GsdFile;
    use profivac_gsd_slave::Selection;
    use std::sync::Arc;

    const FILE: &[u8] = b"#Profibus_DP
Ident_Number = 0x12AB
PrmText = 1
Text(0) = \"opens\"
Text(1) = \"closes\"
EndPrmText
ExtUserPrmData = 1 \"Valve without bus\"
Bit(2) 0 0-1
Prm_Text_Ref = 1
EndExtUserPrmData
Modular_Station = 1
Max_Module = 3
Module = \"2 words in\" 0x51
3
EndModule
Module = \"valve\" 0x10,0x20
7
Ext_Module_Prm_Data_Len = 1
Ext_User_Prm_Data_Ref(0) = 1
EndModule
";

    fn chosen(modules: &str, set: &[&str]) -> Chosen {
        let changes = set.iter().map(|text| text.parse().unwrap()).collect();
        let selection = Selection { modules: modules.parse().unwrap(), changes };
        Chosen::of(&GsdSlave::new(Arc::new(GsdFile::read(FILE)), &selection).unwrap())
    }

    #[test]
    fn chosen_modules_have_their_octets_parameters_and_places() {
        assert_eq!(
            chosen("3+7", &["Valve without bus=closes"]).lines(),
            [
                "Chk_Cfg          51 10 20",
                "user parameters  04",
                "modules",
                "  slot 1: module 3, 2 words in: 51, identifier 0 of the diagnosis",
                "  slot 2: module 7, valve: 10 20, identifiers 1 to 2 of the diagnosis",
                "parameters",
                "  slot 2, octet 0: Valve without bus = closes (1)",
                "inputs",
                "  octets 0 to 3: slot 1 2 words in",
                "  octet 4: slot 2 valve",
                "outputs",
                "  octet 0: slot 2 valve",
            ]
        );
    }

    #[test]
    fn a_slave_without_parameters_and_outputs_has_no_empty_tables() {
        assert_eq!(
            chosen("3", &[]).lines(),
            [
                "Chk_Cfg          51",
                "user parameters  -",
                "modules",
                "  slot 1: module 3, 2 words in: 51, identifier 0 of the diagnosis",
                "inputs",
                "  octets 0 to 3: slot 1 2 words in",
            ]
        );
    }
}
