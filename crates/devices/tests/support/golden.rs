//! The tables of the devices as text, and the goldens of this folder.

use profivac_devices::model::{Configuration, Model, PlacedBlock, Scale, Telegram};
use std::fmt::Write;

#[path = "../../../../tests/support/golden.rs"]
mod files;

/// Compares `text` with the golden of this name.
#[track_caller]
pub fn check(name: &str, text: &str) {
    files::compare(&format!("crates/devices/tests/golden/{name}"), text);
}

/// The tables of a device as text.
pub fn print(model: &Model) -> String {
    let mut text = format!(
        "{} ({}), {}, ident {:04X}, after {}\n",
        model.title, model.name, model.vendor, model.ident, model.manual
    );
    text += &format!("\nConfigurations\n{:>3} {:>3}  {:>3} {:>3}  octets\n", "M>S", "S>M", "out", "in");
    model.configurations.iter().for_each(|configuration| text += &print_configuration(configuration));
    text += "\nTelegrams\n";
    for telegram in telegrams(model) {
        let fields: Vec<String> =
            telegram.layout().map(|(start, field)| format!("{start} {} ({})", field.name(), field.octets())).collect();
        writeln!(text, "{:>3}  {}", telegram.number, fields.join(", ")).unwrap();
    }
    text += "\nUser parameters\n";
    for prm in model.user_prm {
        writeln!(text, "{:<14} {:02X?}", prm.name, prm.octets).unwrap();
    }
    text += "\nUnits\n";
    for unit in model.units {
        let scale = match unit.scale {
            Scale::PerMbar(factor) => format!("{factor} per mbar"),
            Scale::Counts => "by instance".into(),
        };
        writeln!(text, "{:>5} {:04X}  {:<8}{scale}", unit.code, unit.code, unit.name).unwrap();
    }
    text += "\nRanges in mbar\n";
    for facts in model.parts {
        let limits = facts.limits;
        let [under, over, full] =
            [limits.under_pa, limits.over_pa, limits.full_scale_pa].map(|pa| format!("{:e}", pa / 100.0));
        let part = facts.part;
        writeln!(text, "{} {:?}: {under} to {over}, full scale {full}", part.instance, part.principle).unwrap();
    }
    let present = model.blocks.iter().filter(|placed| !placed.locations.is_empty());
    present.for_each(|placed| text += &print_placed(placed));
    text += "\nFaults\n";
    for (name, effect) in model.faults.names().zip(model.faults.effects) {
        writeln!(text, "{name:<14}{effect}").unwrap();
    }
    text
}

fn number(telegram: Option<&Telegram>) -> String {
    telegram.map_or("-".into(), |telegram| telegram.number.to_string())
}

fn print_configuration(configuration: &Configuration) -> String {
    let octets: Vec<String> = configuration.octets.iter().map(|octet| format!("{octet:02X}")).collect();
    format!(
        "{:>3} {:>3}  {:>3} {:>3}  {}\n",
        number(configuration.outputs),
        number(configuration.inputs),
        configuration.output_octets(),
        configuration.input_octets(),
        octets.join(" ")
    )
}

/// Every telegram once, by its number; a number may name one of each direction.
fn telegrams(model: &Model) -> Vec<&'static Telegram> {
    let mut telegrams: Vec<&Telegram> =
        model.configurations.iter().flat_map(|it| it.outputs.into_iter().chain(it.inputs)).collect();
    telegrams.sort_by_key(|telegram| telegram.number);
    telegrams.dedup();
    telegrams
}

fn print_placed(placed: &PlacedBlock) -> String {
    let block = placed.block;
    let block_type = block.block_type.map_or(String::new(), |number| format!(", type {number}"));
    let addresses: Vec<String> = placed
        .locations
        .iter()
        .map(|address| match address.instance {
            0 => format!("{} \"{}\"", address.slot, address.name),
            instance => format!("{}:{instance} \"{}\"", address.slot, address.name),
        })
        .collect();
    let mut text = format!("\n{}{block_type}\nslot {}\n", block.name, addresses.join(", "));
    for row in block.rows {
        let data_type = row.data_type.to_string();
        let [name, access] = [column(row.name, 43), column(row.access_text, 15)];
        writeln!(text, "{:>3}  {name}{data_type:<13}{access}{:<3}{}", row.index, row.storage, row.section).unwrap();
    }
    text
}

/// Padded to a width; a wider text is followed by one blank.
fn column(text: &str, width: usize) -> String {
    format!("{text:<0$}", width.max(text.len() + 1))
}
