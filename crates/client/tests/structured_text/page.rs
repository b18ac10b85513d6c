//! The table of devices in docs/plc.md.

use profivac_client::gsd::{files, gsd};
use profivac_client::st::{Dialect, st};
use profivac_devices::catalog::MODELS;
use profivac_devices::model::{Configuration, Field, Model, NumberType};

const PAGE: &str = include_str!("../../../../docs/plc.md");

/// The configuration with the longest inputs and, among them, the shortest outputs.
fn longest(model: &Model, wanted: impl Fn(&Configuration) -> bool) -> Option<usize> {
    let all = model.configurations.iter().enumerate().filter(|(_, one)| wanted(one));
    let is_float = |one: &Configuration| one.number() == Some(NumberType::Float) || one.number().is_none();
    let key = |one: &Configuration| (is_float(one), one.input_octets(), usize::MAX - one.output_octets());
    all.max_by_key(|(_, one)| key(one)).map(|(number, _)| number)
}

fn has_channel(configuration: &Configuration) -> bool {
    configuration.outputs.is_some_and(|telegram| telegram.fields.contains(&Field::ParameterChannel))
}

/// Two cells: the module, and its octets in and out.
fn module(model: &Model, number: Option<usize>) -> String {
    let Some(number) = number else { return "- | -".to_owned() };
    let text = gsd(model);
    let names: Vec<_> = text.lines().filter_map(|line| line.strip_prefix("Module=\"")?.split('"').next()).collect();
    let configuration = &model.configurations[number];
    format!("`{}` | {} / {}", names[number], configuration.input_octets(), configuration.output_octets())
}

fn row(model: &Model) -> String {
    let prm =
        model.user_prm.iter().find(|prm| model.unit_named("mbar").is_some_and(|unit| unit.code == prm.unit_code()));
    let prm = prm.map_or("none".to_owned(), |prm| {
        let octets: Vec<_> = prm.octets.iter().map(|octet| format!("{octet:02X}")).collect();
        format!("`{}`", octets.join(" "))
    });
    let (file, _) = &files(model)[0];
    let alone = module(model, longest(model, |one| one.output_octets() == 0));
    let channel = module(model, longest(model, has_channel));
    format!("| {} | `{file}` | 0x{:04X} | {alone} | {channel} | {prm} |", model.title, model.ident)
}

#[test]
fn the_page_has_the_values_of_every_device() {
    let rows: Vec<_> = MODELS.into_iter().map(row).collect();
    assert!(PAGE.contains(&rows.join("\n")), "docs/plc.md should contain:\n{}", rows.join("\n"));
}

#[test]
fn the_page_names_the_inputs_and_outputs_of_the_blocks() {
    let names: Vec<_> = PAGE
        .lines()
        .filter(|line| line.starts_with("| `"))
        .flat_map(|line| {
            let cell = line.split('|').nth(1).unwrap_or_default();
            cell.split('`').skip(1).step_by(2).map(str::to_owned).collect::<Vec<_>>()
        })
        .collect();
    let text: String = MODELS.into_iter().map(|model| st(model, Dialect::Standard)).collect();
    assert!(names.len() > 10, "{names:?}");
    for name in names {
        assert!(text.contains(&format!("{name} : ")), "{name}");
    }
}
