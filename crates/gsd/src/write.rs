//! The model as the text of a file, in one form that every known tool reads. profibus-wire 7.3.

use crate::device::{Device, Module, Other};
use crate::diagnosis::{DiagArea, Diagnosis, UnitDiag, Words};
use crate::general::{Rate, Section};
use crate::parameter::{Parameter, PrmArea, PrmContent};
use crate::words::quoted;
use std::collections::BTreeMap;
use std::fmt::Display;

/// The octets of a list in one line; a longer list goes on in the next line.
const IN_A_LINE: usize = 16;

/// The text of a GSD file for a device: one keyword in a line, texts before the parameters that use them, those before the modules.
///
/// Lines that the model does not interpret follow their block as the file had them. Comments belong to the text of a
/// [`GsdFile`](crate::GsdFile) and not to the model; [`commented_text`] writes some at the top.
///
/// ```
/// use profivac_gsd::{Device, Module, text};
///
/// let mut device = Device::default();
/// device.general.ident_number = Some(0x1234);
/// device.modules.push(Module { name: "2 octets in".to_owned(), config: vec![0x11], ..Module::default() });
/// assert_eq!(
///     text(&device),
///     "#Profibus_DP\nIdent_Number            = 0x1234\nModule=\"2 octets in\" 0x11\nEndModule\n",
/// );
/// ```
#[must_use]
pub fn text(device: &Device) -> String {
    commented_text::<&str>(device, &[])
}

/// The same, with lines of comment below `#Profibus_DP`.
///
/// ```
/// use profivac_gsd::{Device, commented_text};
///
/// assert_eq!(commented_text(&Device::default(), &["made by hand"]), "#Profibus_DP\n; made by hand\n");
/// ```
#[must_use]
pub fn commented_text<C: AsRef<str>>(device: &Device, comments: &[C]) -> String {
    let mut writer = Writer::default();
    writer.line("#Profibus_DP");
    comments.iter().for_each(|comment| writer.comment(comment.as_ref()));
    writer.section(device, Section::Identity);
    writer.rates(&device.rates);
    writer.section(device, Section::Services);
    writer.texts(device);
    device.parameters.values().for_each(|parameter| writer.parameter(parameter));
    writer.user_prm(device);
    writer.diagnosis(&device.diagnosis);
    writer.others(&device.others);
    device.modules.iter().for_each(|module| writer.module(module));
    writer.slots(device);
    writer.text
}

#[derive(Default)]
struct Writer {
    text: String,
}

impl Writer {
    fn line(&mut self, line: &str) {
        self.text.push_str(line);
        self.text.push('\n');
    }

    /// A comment is one line, and a backslash at its end would continue it.
    fn comment(&mut self, comment: &str) {
        let line: String = comment.chars().map(|one| if one.is_control() { ' ' } else { one }).collect();
        self.line(format!("; {line}").trim_end_matches(['\\', ' ']));
    }

    /// A keyword of the station: the values stand below each other.
    fn station(&mut self, keyword: &str, value: impl Display) {
        self.line(&format!("{keyword:<23} = {value}"));
    }

    /// A line of a block.
    fn value(&mut self, keyword: impl Display, value: impl Display) {
        self.line(&format!("{keyword}={value}"));
    }

    fn section(&mut self, device: &Device, section: Section) {
        for (keyword, value) in device.general.section(section) {
            self.station(keyword, value);
        }
    }

    fn rates(&mut self, rates: &[Rate]) {
        for (name, supported) in rates.iter().filter_map(|rate| Some((rate.name, rate.supported?))) {
            self.station(&format!("{name}_supp"), u8::from(supported));
        }
        for (name, tsdr) in rates.iter().filter_map(|rate| Some((rate.name, rate.max_tsdr?))) {
            self.station(&format!("MaxTsdr_{name}"), tsdr);
        }
    }

    fn user_prm(&mut self, device: &Device) {
        self.section(device, Section::UserPrm);
        if let Some(octets) = &device.user_prm_data {
            self.station("User_Prm_Data", list(octets));
        }
        self.area("", &device.prm);
    }

    fn texts(&mut self, device: &Device) {
        for texts in device.texts.values() {
            self.value("PrmText", texts.number);
            for (value, text) in &texts.texts {
                self.value(format!("Text({value})"), quoted(text));
            }
            self.line("EndPrmText");
        }
    }

    fn parameter(&mut self, parameter: &Parameter) {
        self.value("ExtUserPrmData", format!("{} {}", parameter.number, quoted(&parameter.name)));
        let single = parameter.allowed.iter().all(|(low, high)| low == high);
        let interval =
            |(low, high): &(i64, i64)| if low == high && single { low.to_string() } else { format!("{low}-{high}") };
        let allowed: Vec<_> = parameter.allowed.iter().map(interval).collect();
        self.line(format!("{} {} {}", parameter.kind, parameter.default, allowed.join(",")).trim_end());
        if let Some(texts) = parameter.texts {
            self.value("Prm_Text_Ref", texts);
        }
        if !parameter.changeable {
            self.value("Changeable", 0);
        }
        if !parameter.visible {
            self.value("Visible", 0);
        }
        self.line("EndExtUserPrmData");
    }

    fn area(&mut self, prefix: &str, area: &PrmArea) {
        if let Some(length) = area.length {
            self.value(format!("{prefix}Ext_Module_Prm_Data_Len"), length);
        }
        for item in &area.items {
            match &item.content {
                PrmContent::Const(octets) => {
                    self.value(format!("{prefix}Ext_User_Prm_Data_Const({})", item.offset), list(octets))
                }
                PrmContent::Ref(number) => {
                    self.value(format!("{prefix}Ext_User_Prm_Data_Ref({})", item.offset), number)
                }
            }
        }
    }

    fn diagnosis(&mut self, diagnosis: &Diagnosis) {
        self.unit_diag("", &diagnosis.unit);
        for (kind, unit) in &diagnosis.types {
            self.value("UnitDiagType", kind);
            self.unit_diag("X_", unit);
            self.line("EndUnitDiagType");
        }
        self.words("Channel_Diag", &diagnosis.channels);
    }

    fn unit_diag(&mut self, prefix: &str, unit: &UnitDiag) {
        self.words(&format!("{prefix}Unit_Diag_Bit"), &unit.bits);
        self.words(&format!("{prefix}Unit_Diag_!Bit"), &unit.inverted);
        for DiagArea { first, last, values } in &unit.areas {
            self.value(format!("{prefix}Unit_Diag_Area"), format!("{first}-{last}"));
            self.words(&format!("{prefix}Value"), values);
            self.line(&format!("{prefix}Unit_Diag_Area_End"));
        }
    }

    fn words<N: Display>(&mut self, keyword: &str, texts: &BTreeMap<N, Words>) {
        for (number, words) in texts {
            self.value(format!("{keyword}({number})"), quoted(&words.text));
            if let Some(help) = &words.help {
                self.value(format!("{keyword}_Help({number})"), quoted(help));
            }
        }
    }

    fn others(&mut self, others: &[Other]) {
        // A line that starts with `#` would end the section, and an open text that ends with `\` would go on.
        let is_left_out = |one: char| one == '\\' || one.is_whitespace();
        let lines = others.iter().filter(|other| !other.text.starts_with('#'));
        lines.for_each(|other| self.line(other.text.trim_end_matches(is_left_out)));
    }

    fn module(&mut self, module: &Module) {
        self.line(format!("Module={} {}", quoted(&module.name), list(&module.config)).trim_end());
        if module.numbered {
            self.line(&module.number.to_string());
        }
        if module.preset {
            self.value("Preset", 1);
        }
        if let Some(info) = &module.info {
            self.value("Info_Text", quoted(info));
        }
        module.alarms.supported.iter().for_each(|alarm| self.value(format!("{}_supp", alarm.keyword()), 1));
        module.alarms.required.iter().for_each(|alarm| self.value(format!("{}_required", alarm.keyword()), 1));
        self.area("", &module.prm);
        self.area("F_", &module.safety);
        self.diagnosis(&module.diagnosis);
        self.others(&module.others);
        self.line("EndModule");
    }

    fn slots(&mut self, device: &Device) {
        if device.slots.is_empty() {
            return;
        }
        self.line("SlotDefinition");
        for slot in device.slots.values() {
            let interval =
                |(low, high): &(u32, u32)| if low == high { low.to_string() } else { format!("{low}-{high}") };
            let allowed: Vec<_> = slot.allowed.iter().map(interval).collect();
            let value = format!("{} {} {}", quoted(&slot.name), slot.default, allowed.join(","));
            self.value(format!("Slot({})", slot.number), value.trim_end());
        }
        self.line("EndSlotDefinition");
    }
}

fn list(octets: &[u8]) -> String {
    let line = |octets: &[u8]| octets.iter().map(|octet| format!("0x{octet:02X}")).collect::<Vec<_>>().join(",");
    octets.chunks(IN_A_LINE).map(line).collect::<Vec<_>>().join(",\\\n")
}
