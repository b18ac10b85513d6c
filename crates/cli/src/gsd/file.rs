//! `profivac gsd check` and `gsd show`: GSD files of any slave.

use crate::failure::Failure;
use crate::output::{json, notice, out};
use clap::{Args, Subcommand};
use profivac_gsd::{
    Configuration, Device, Diagnosis, GsdFile, Module, Parameter, PrmArea, PrmContent, Severity, UnitDiag,
};
use serde::Serialize;
use std::path::{Path, PathBuf};

#[derive(Subcommand, Debug)]
pub enum FileCommand {
    Check(CheckArguments),
    Show(ShowArguments),
}

/// Check GSD files: what is wrong in which line, what to do about it, and which open tools do not read it
///
/// profivac reads every file, also one with faults. Exit code 2 if a line is wrong, 0 if there are remarks only.
#[derive(Args, Debug)]
pub struct CheckArguments {
    /// GSD files of any slave
    #[arg(value_name = "FILE", required = true)]
    files: Vec<PathBuf>,
}

/// Show the modules, parameters and diagnosis texts of a GSD file
#[derive(Args, Debug)]
pub struct ShowArguments {
    /// A GSD file of any slave
    #[arg(value_name = "FILE")]
    file: PathBuf,
    /// Print JSON
    #[arg(long)]
    json: bool,
}

/// Runs the command.
pub fn run(command: &FileCommand) -> Result<(), Failure> {
    match command {
        FileCommand::Check(arguments) => check(&arguments.files),
        FileCommand::Show(arguments) => show(arguments),
    }
}

fn read(path: &Path) -> Result<GsdFile, Failure> {
    let octets = std::fs::read(path);
    let octets = octets
        .map_err(|error| Failure::usage(format!("{} cannot be read: {error}; check the path", path.display())))?;
    Ok(GsdFile::read(&octets))
}

fn check(paths: &[PathBuf]) -> Result<(), Failure> {
    let mut wrong = 0_usize;
    for path in paths {
        let file = match read(path) {
            Ok(file) => file,
            Err(failure) => {
                notice(&visible(&failure.to_string()));
                wrong = wrong.saturating_add(1);
                continue;
            }
        };
        let faults = file.faults().count();
        let remarks = file.problems().len().saturating_sub(faults);
        let name = path.display();
        out(&visible(&format!(
            "{name}: {}, {} modules, {faults} faults, {remarks} remarks",
            file.encoding(),
            file.device().modules.len()
        )));
        for problem in file.problems() {
            let kind = if problem.severity() == Severity::Fault { "fault" } else { "remark" };
            out(&visible(&format!("  {kind}, {problem}")));
        }
        wrong = wrong.saturating_add(usize::from(faults > 0));
    }
    let all = paths.len();
    if wrong == 0 {
        Ok(())
    } else {
        Err(Failure::usage(format!(
            "{wrong} of {all} GSD files have faults or cannot be read; the lines above say where"
        )))
    }
}

/// A line without control characters, which a file can contain and a terminal would obey.
fn visible(line: &str) -> String {
    let mut visible = String::with_capacity(line.len());
    for one in line.chars() {
        if one.is_control() {
            visible.extend(one.escape_default());
        } else {
            visible.push(one);
        }
    }
    visible
}

fn show(arguments: &ShowArguments) -> Result<(), Failure> {
    let file = read(&arguments.file)?;
    let shown = Shown::of(&file);
    out(&if arguments.json { json(&shown) } else { shown.text() });
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
    parameters: Vec<ShownParameter>,
    modules: Vec<ShownModule>,
    slots: Vec<ShownSlot>,
    preset: Option<ShownConfiguration>,
    diagnosis: Vec<ShownText>,
}

#[derive(Serialize)]
struct ShownModule {
    number: u32,
    name: String,
    config: String,
    preset: bool,
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
            parameters: parameters(device, &device.prm),
            modules: device.modules.iter().map(|one| module(device, one)).collect(),
            slots: device.slots.values().map(slot).collect(),
            preset: Configuration::preset(device).ok().map(|preset| configuration(&preset)),
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
        if !self.diagnosis.is_empty() {
            lines.push("diagnosis".to_owned());
            lines.extend(self.diagnosis.iter().map(|one| one.line("  ")));
        }
        lines.iter().map(|line| visible(line)).collect::<Vec<_>>().join("\n")
    }
}

impl ShownModule {
    fn add_lines(&self, lines: &mut Vec<String>) {
        let Self { number, name, config, preset, parameters, diagnosis } = self;
        lines.push(format!("{number:>5}  {name}: {config}{}", if *preset { ", preset" } else { "" }));
        lines.extend(parameters.iter().map(|one| one.line("         ")));
        lines.extend(diagnosis.iter().map(|one| one.line("         ")));
    }
}

impl ShownParameter {
    fn line(&self, indent: &str) -> String {
        let Self { offset, name, r#type, default, text, possible, changeable } = self;
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
        parameters: parameters(device, &module.prm),
        diagnosis: diagnosis(&module.diagnosis),
    }
}

fn parameters(device: &Device, area: &PrmArea) -> Vec<ShownParameter> {
    let shown = |offset: u8, parameter: &Parameter| ShownParameter {
        offset,
        name: parameter.name.clone(),
        r#type: parameter.kind.to_string(),
        default: parameter.default,
        text: device.text_of(parameter, parameter.default).map(str::to_owned),
        possible: device.values_of(parameter),
        changeable: parameter.changeable,
    };
    let referred = |item: &profivac_gsd::PrmItem| match item.content {
        PrmContent::Ref(number) => device.parameters.get(&number).map(|parameter| shown(item.offset, parameter)),
        PrmContent::Const(_) => None,
    };
    area.items.iter().filter_map(referred).collect()
}

fn configuration(preset: &Configuration<'_>) -> ShownConfiguration {
    ShownConfiguration {
        modules: preset.modules().iter().map(|plugged| plugged.module.number).collect(),
        chk_cfg: hex(&preset.chk_cfg()),
        user_prm: preset.user_prm().ok().map(|octets| hex(&octets)),
        warnings: preset.warnings().iter().map(ToString::to_string).collect(),
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

fn hex(octets: &[u8]) -> String {
    octets.iter().map(|octet| format!("{octet:02X}")).collect::<Vec<_>>().join(" ")
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

    #[test]
    fn check_goes_on_after_a_file_that_cannot_be_read() {
        let missing = ["missing-1.gsd", "missing-2.gsd"].map(PathBuf::from);
        let failure = check(&missing).err().map(|failure| failure.to_string()).unwrap_or_default();
        assert!(failure.starts_with("2 of 2 GSD files have faults or cannot be read"), "{failure}");
    }

    #[test]
    fn control_characters_of_a_file_are_shown_escaped() {
        let file = GsdFile::read(b"#Profibus_DP\nVendor_Name=\"\x1b[2Jx\"\n");
        let text = Shown::of(&file).text();
        assert!(text.lines().any(|line| line == "vendor    \\u{1b}[2Jx"), "{text}");
    }

    #[test]
    fn json_has_the_same_contents() {
        let value = serde_json::to_value(Shown::of(&GsdFile::read(FILE))).unwrap_or_default();
        assert_eq!(value.pointer("/ident").and_then(serde_json::Value::as_u64), Some(0x12AB));
        assert_eq!(value.pointer("/modules/0/config").and_then(serde_json::Value::as_str), Some("20 10"));
        assert_eq!(value.pointer("/preset/user_prm").and_then(serde_json::Value::as_str), Some("04"));
    }
}
