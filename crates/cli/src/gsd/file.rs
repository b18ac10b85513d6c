//! `profivac gsd check` and `gsd show`: GSD files of any slave.

use super::check::{CheckArguments, check};
use super::chosen::Chosen;
use super::read;
use crate::failure::Failure;
use crate::gsd_slaves;
use crate::output::{json, out, visible};
use clap::{Args, Subcommand};
use profivac_client::values::hex;
use profivac_gsd::{Configuration, Device, Diagnosis, GsdFile, Module, Parameter, PrmArea, PrmContent, UnitDiag};
use profivac_gsd_slave::{Change, GsdSlave};
use serde::Serialize;
use std::path::PathBuf;
use std::sync::Arc;

#[derive(Subcommand, Debug)]
pub enum FileCommand {
    Check(CheckArguments),
    Show(ShowArguments),
}

/// Show the modules, parameters and diagnosis texts of a GSD file, or the octets of chosen modules
#[derive(Args, Debug)]
#[command(after_help = SHOW_EXAMPLES)]
pub struct ShowArguments {
    /// A GSD file of any slave
    #[arg(value_name = "FILE")]
    file: PathBuf,
    /// Show the octets of Chk_Cfg and Set_Prm for these modules: numbers of the file in slot order (3+7), or a TOML file with names and
    /// parameters
    #[arg(long, value_name = "NUMBERS|FILE")]
    modules: Option<String>,
    /// Change a parameter: its name and value in the file; default with --set alone: the modules that the file presets
    #[arg(long, value_name = "NAME=VALUE")]
    set: Vec<Change>,
    /// Print JSON
    #[arg(long)]
    json: bool,
}

const SHOW_EXAMPLES: &str = "\
Examples:
  profivac gsd show VALVE.GSD
  profivac gsd show VALVE.GSD --modules 3+7 --set 'State without bus=closed'";

/// Runs the command.
pub fn run(command: &FileCommand) -> Result<(), Failure> {
    match command {
        FileCommand::Check(arguments) => check(arguments),
        FileCommand::Show(arguments) => show(arguments),
    }
}

fn visible_lines(lines: &[String]) -> String {
    lines.iter().map(|line| visible(line)).collect::<Vec<_>>().join("\n")
}

fn show(arguments: &ShowArguments) -> Result<(), Failure> {
    let file = read(&arguments.file)?;
    if arguments.modules.is_some() || !arguments.set.is_empty() {
        return show_chosen(arguments, file);
    }
    let shown = Shown::of(&file);
    out(&if arguments.json { json(&shown) } else { shown.text() });
    Ok(())
}

fn show_chosen(arguments: &ShowArguments, file: GsdFile) -> Result<(), Failure> {
    let mut selection = arguments.modules.as_deref().map(gsd_slaves::selection).transpose()?.unwrap_or_default();
    selection.changes.extend(arguments.set.iter().cloned());
    let slave = GsdSlave::new(Arc::new(file), &selection)
        .map_err(|error| Failure::usage(format!("{}: {error}", arguments.file.display())))?;
    let chosen = Chosen::of(&slave);
    out(&if arguments.json { json(&chosen) } else { visible_lines(&chosen.lines()) });
    Ok(())
}

/// The contents of a file.
#[derive(Serialize)]
struct Shown {
    vendor: Option<String>,
    model: Option<String>,
    ident: Option<u32>,
    gsd_revision: Option<u32>,
    encoding: &'static str,
    modular: bool,
    max_modules: usize,
    problems: usize,
    /// The user parameters of the station with their defaults; none if there are none.
    user_prm: Option<String>,
    parameters: Vec<ShownParameter>,
    modules: Vec<ShownModule>,
    slots: Vec<ShownSlot>,
    preset: Option<ShownConfiguration>,
    /// Why the modules that are plugged at first have no octets.
    preset_problem: Option<String>,
    diagnosis: Vec<ShownText>,
}

#[derive(Serialize)]
struct ShownModule {
    number: u32,
    name: String,
    config: String,
    preset: bool,
    /// The user parameters that the module adds, with their defaults; none if it adds none.
    user_prm: Option<String>,
    parameters: Vec<ShownParameter>,
    diagnosis: Vec<ShownText>,
}

#[derive(Serialize)]
struct ShownParameter {
    offset: u8,
    name: String,
    r#type: String,
    default: i64,
    text: Option<String>,
    possible: String,
    changeable: bool,
    /// The value is the number of the slot, and `default` is not sent.
    is_slot_number: bool,
}

#[derive(Serialize)]
struct ShownSlot {
    number: u32,
    name: String,
    default: u32,
    allowed: Vec<(u32, u32)>,
}

/// The octets of the modules that are plugged at first.
#[derive(Serialize)]
struct ShownConfiguration {
    modules: Vec<u32>,
    chk_cfg: String,
    user_prm: Option<String>,
    /// What the octets lack.
    warnings: Vec<String>,
}

#[derive(Serialize)]
struct ShownText {
    place: String,
    text: String,
    help: Option<String>,
}

impl Shown {
    fn of(file: &GsdFile) -> Self {
        let device = file.device();
        let general = &device.general;
        let (preset, preset_problem) = match Configuration::preset(device) {
            Ok(preset) => (Some(configuration(&preset)), None),
            Err(error) => (None, Some(error.to_string())),
        };
        let slot = |slot: &profivac_gsd::Slot| ShownSlot {
            number: slot.number,
            name: slot.name.clone(),
            default: slot.default,
            allowed: slot.allowed.clone(),
        };
        Self {
            vendor: general.vendor_name.clone(),
            model: general.model_name.clone(),
            ident: general.ident_number,
            gsd_revision: general.gsd_revision,
            encoding: file.encoding().name(),
            modular: device.is_modular(),
            max_modules: device.max_modules(),
            problems: file.problems().len(),
            user_prm: octets(&device.default_user_prm()),
            parameters: parameters(device, &device.prm, |_| false),
            modules: device.modules.iter().map(|one| module(device, one)).collect(),
            slots: device.slots.values().map(slot).collect(),
            preset,
            preset_problem,
            diagnosis: diagnosis(&device.diagnosis),
        }
    }

    fn text(&self) -> String {
        let or_none = |text: &Option<String>| text.clone().unwrap_or_else(|| "-".to_owned());
        let number = |number: Option<u32>| number.map_or_else(|| "-".to_owned(), |number| number.to_string());
        let ident = self.ident.map_or_else(|| "-".to_owned(), |ident| format!("0x{ident:04X}"));
        let mut lines = vec![
            format!("vendor    {}", or_none(&self.vendor)),
            format!("model     {}", or_none(&self.model)),
            format!("ident     {ident}"),
            format!("revision  {} of the format, {}", number(self.gsd_revision), self.encoding),
            format!(
                "problems  {}{}",
                self.problems,
                if self.problems == 0 { "" } else { ", see `profivac gsd check`" }
            ),
            format!(
                "station   {}",
                if self.modular { format!("at most {} modules", self.max_modules) } else { "one module".to_owned() }
            ),
        ];
        lines.extend(self.user_prm.iter().map(|octets| format!("user parameters  {octets}")));
        lines.extend(self.parameters.iter().map(|one| one.line("  ")));
        lines.push("modules".to_owned());
        self.modules.iter().for_each(|module| module.add_lines(&mut lines));
        if !self.slots.is_empty() {
            lines.push("slots".to_owned());
            lines.extend(self.slots.iter().map(ShownSlot::line));
        }
        if let Some(ShownConfiguration { modules, chk_cfg, user_prm, warnings }) = &self.preset {
            lines.push(format!(
                "at first  modules {modules:?}, Chk_Cfg {chk_cfg}, user parameters {}",
                or_none(user_prm)
            ));
            lines.extend(warnings.iter().map(|warning| format!("warning   {warning}")));
        }
        lines.extend(self.preset_problem.iter().map(|problem| format!("at first  no octets: {problem}")));
        if !self.diagnosis.is_empty() {
            lines.push("diagnosis".to_owned());
            lines.extend(self.diagnosis.iter().map(|one| one.line("  ")));
        }
        visible_lines(&lines)
    }
}

impl ShownModule {
    fn add_lines(&self, lines: &mut Vec<String>) {
        let Self { number, name, config, preset, user_prm, parameters, diagnosis } = self;
        lines.push(format!("{number:>5}  {name}: {config}{}", if *preset { ", preset" } else { "" }));
        lines.extend(user_prm.iter().map(|octets| format!("         user parameters {octets}")));
        lines.extend(parameters.iter().map(|one| one.line("         ")));
        lines.extend(diagnosis.iter().map(|one| one.line("         ")));
    }
}

impl ShownParameter {
    fn line(&self, indent: &str) -> String {
        let Self { offset, name, r#type, default, text, possible, changeable, is_slot_number } = self;
        if *is_slot_number {
            return format!("{indent}octet {offset}, {type}: {name}, the number of the slot; possible {possible}");
        }
        let default = text.as_ref().map_or_else(|| default.to_string(), |text| format!("{default} ({text})"));
        let fixed = if *changeable { "" } else { ", fixed" };
        format!("{indent}octet {offset}, {type}: {name} = {default}; possible {possible}{fixed}")
    }
}

impl ShownSlot {
    fn line(&self) -> String {
        let interval =
            |(low, high): &(u32, u32)| if low == high { low.to_string() } else { format!("{low} to {high}") };
        let allowed: Vec<_> = self.allowed.iter().map(interval).collect();
        format!("{:>5}  {}: module {}; possible {}", self.number, self.name, self.default, allowed.join(", "))
    }
}

impl ShownText {
    fn line(&self, indent: &str) -> String {
        let help = self.help.as_ref().map_or_else(String::new, |help| format!(" ({help})"));
        format!("{indent}{}: {}{help}", self.place, self.text)
    }
}

fn module(device: &Device, module: &Module) -> ShownModule {
    ShownModule {
        number: module.number,
        name: module.name.clone(),
        config: hex(&module.config),
        preset: module.preset,
        user_prm: octets(&device.default_module_prm(module)),
        parameters: parameters(device, &module.prm, Parameter::is_slot_number),
        diagnosis: diagnosis(&module.diagnosis),
    }
}

/// The parameters of an area; `is_slot_number` tells those whose value is the number of the slot, which only modules have.
fn parameters(device: &Device, area: &PrmArea, is_slot_number: impl Fn(&Parameter) -> bool) -> Vec<ShownParameter> {
    let shown = |offset: u8, parameter: &Parameter| ShownParameter {
        offset,
        name: parameter.name.clone(),
        r#type: parameter.kind.to_string(),
        default: parameter.default,
        text: device.text_of(parameter, parameter.default).map(str::to_owned),
        possible: device.values_of(parameter),
        changeable: parameter.changeable,
        is_slot_number: is_slot_number(parameter),
    };
    let referred = |item: &profivac_gsd::PrmItem| match item.content {
        PrmContent::Ref(number) => device.parameters.get(&number).map(|parameter| shown(item.offset, parameter)),
        PrmContent::Const(_) => None,
    };
    area.items.iter().filter_map(referred).collect()
}

fn configuration(preset: &Configuration<'_>) -> ShownConfiguration {
    let user_prm = preset.user_prm();
    let missing = user_prm.as_ref().err().map(|error| format!("no user parameters: {error}"));
    ShownConfiguration {
        modules: preset.modules().iter().map(|plugged| plugged.module.number).collect(),
        chk_cfg: hex(&preset.chk_cfg()),
        warnings: preset.warnings().iter().map(ToString::to_string).chain(missing).collect(),
        user_prm: user_prm.ok().map(|octets| hex(&octets)),
    }
}

fn diagnosis(diagnosis: &Diagnosis) -> Vec<ShownText> {
    let mut texts = unit("", &diagnosis.unit);
    for (kind, typed) in &diagnosis.types {
        texts.extend(unit(&format!("type {kind}, "), typed));
    }
    let channel = |(error, words): (&u8, &profivac_gsd::Words)| text(format!("channel error {error}"), words);
    texts.extend(diagnosis.channels.iter().map(channel));
    texts
}

fn unit(prefix: &str, unit: &UnitDiag) -> Vec<ShownText> {
    let mut texts: Vec<_> = unit.bits.iter().map(|(bit, words)| text(format!("{prefix}bit {bit}"), words)).collect();
    texts.extend(unit.inverted.iter().map(|(bit, words)| text(format!("{prefix}bit {bit} not set"), words)));
    for area in &unit.areas {
        let place = |value| format!("{prefix}bits {} to {} = {value}", area.first, area.last);
        texts.extend(area.values.iter().map(|(value, words)| text(place(value), words)));
    }
    texts
}

fn text(place: String, words: &profivac_gsd::Words) -> ShownText {
    ShownText { place, text: words.text.clone(), help: words.help.clone() }
}

/// Octets as text, nothing for none.
fn octets(octets: &[u8]) -> Option<String> {
    (!octets.is_empty()).then(|| hex(octets))
}

#[cfg(test)]
mod tests {
    use super::*;

    const FILE: &[u8] = b"#Profibus_DP
Vendor_Name = \"Vendor\"
Ident_Number = 0x12AB
PrmText = 1
Text(1) = \"closes\"
EndPrmText
ExtUserPrmData = 1 \"Valve\"
Bit(2) 1 0-1
Prm_Text_Ref = 1
EndExtUserPrmData
Ext_User_Prm_Data_Ref(0) = 1
Unit_Diag_!Bit(3) = \"no air\"
Module = \"valve\" 0x20,0x10
EndModule
";

    #[test]
    fn a_shown_file_has_modules_parameters_and_diagnosis() {
        let text = Shown::of(&GsdFile::read(FILE)).text();
        for line in [
            "ident     0x12AB",
            "  octet 0, Bit(2): Valve = 1 (closes); possible 1 (closes)",
            "    1  valve: 20 10",
            "at first  modules [1], Chk_Cfg 20 10, user parameters 04",
            "  bit 3 not set: no air",
        ] {
            assert!(text.lines().any(|shown| shown == line), "{line} is missing in\n{text}");
        }
    }

    #[test]
    fn the_octets_at_first_have_a_warning_if_parameters_for_safety_are_missing() {
        let file = GsdFile::read(b"#Profibus_DP\nModule=\"safe\" 0x10\nF_Ext_User_Prm_Data_Const(0)=5\nEndModule\n");
        let text = Shown::of(&file).text();
        assert!(
            text.lines().any(|line| line.starts_with("warning   slot 1: 1 (safe) has parameters for PROFIsafe")),
            "{text}"
        );
        assert!(!Shown::of(&GsdFile::read(FILE)).text().contains("warning"));
    }

    /// One module with the parameter of its slot, plugged at first.
    const SLOT: &[u8] = b"#Profibus_DP
ExtUserPrmData = 1 \"[SlotNumber]\"
Unsigned8 1 1-8
EndExtUserPrmData
Modular_Station = 1
Max_Module = 2
Module = \"input\" 0x10
Preset = 1
Ext_Module_Prm_Data_Len = 1
Ext_User_Prm_Data_Ref(0) = 1
EndModule
";

    #[test]
    fn the_number_of_the_slot_is_not_shown_as_a_default() {
        let text = Shown::of(&GsdFile::read(SLOT)).text();
        assert!(text.contains("octet 0, Unsigned8: [SlotNumber], the number of the slot; possible 1 to 8"), "{text}");
    }

    #[test]
    fn octets_that_cannot_be_made_have_a_reason() {
        let too_long = String::from_utf8_lossy(SLOT).replace("1-8", "2-8");
        let text = Shown::of(&GsdFile::read(too_long.as_bytes())).text();
        assert!(text.lines().any(|line| line.starts_with("at first  no octets: ")), "{text}");
    }

    #[test]
    fn control_characters_of_a_file_are_shown_escaped() {
        let file = GsdFile::read(b"#Profibus_DP\nVendor_Name=\"\x1b[2Jx\"\n");
        let text = Shown::of(&file).text();
        assert!(text.lines().any(|line| line == "vendor    \\u{1b}[2Jx"), "{text}");
    }

    #[test]
    fn the_station_and_each_module_have_their_default_octets() {
        let file = GsdFile::read(
            b"#Profibus_DP
ExtUserPrmData = 1 \"Filter\"
Unsigned8 7 0-9
EndExtUserPrmData
Ext_User_Prm_Data_Const(0) = 0x80,0x00
Ext_User_Prm_Data_Ref(1) = 1
Module = \"input\" 0x10
Ext_Module_Prm_Data_Len = 2
Ext_User_Prm_Data_Ref(0) = 1
EndModule
Module = \"output\" 0x20
EndModule
",
        );
        let value = serde_json::to_value(Shown::of(&file)).unwrap();
        let at = |pointer: &str| value.pointer(pointer).cloned();
        assert_eq!(at("/user_prm"), Some("80 07".into()));
        assert_eq!(at("/modules/0/user_prm"), Some("07 00".into()));
        assert_eq!(at("/modules/1/user_prm"), Some(serde_json::Value::Null));
    }

    #[test]
    fn json_has_the_same_contents() {
        let value = serde_json::to_value(Shown::of(&GsdFile::read(FILE))).unwrap_or_default();
        assert_eq!(value.pointer("/ident").and_then(serde_json::Value::as_u64), Some(0x12AB));
        assert_eq!(value.pointer("/modules/0/config").and_then(serde_json::Value::as_str), Some("20 10"));
        assert_eq!(value.pointer("/preset/user_prm").and_then(serde_json::Value::as_str), Some("04"));
    }
}
