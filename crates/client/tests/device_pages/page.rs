//! One page: the tables of a model as Markdown.

use crate::device_pages::{Page, words};
use profivac_client::cyclic::unranged_instances;
use profivac_devices::model::{ChannelRules, Configuration, Model, PlacedBlock, Row, Telegram};
use profivac_dp::slave::Dpv1Error as Negative;

/// The first line of every page.
pub const HEADER: &str = "<!-- Generated from the manual's tables by `cargo xtask goldens`. Do not edit. -->\n";

pub fn print(page: &Page) -> String {
    let titles: Vec<_> = page.models.iter().map(|model| model.title).collect();
    let mut text = format!("{HEADER}\n# {}\n\n", titles.join(", "));
    if titles.len() > 1 {
        text += "One page for all of them: everything below this table is the same for each.\n\n";
    }
    text += &models(page.models);
    if !page.note.is_empty() {
        text += &format!("\n{}\n", page.note);
    }
    let source = format!("crates/devices/src/{}/table.rs", page.source);
    text += &format!("\nTables: [{source}](../../{source}), with a comment where a row departs from the print. ");
    text += "[How to read this page](README.md#how-to-read-a-page).\n";
    page.models.iter().take(1).for_each(|model| text += &tables(model));
    text + &errata(page)
}

/// The errata that apply, and where their reliability is described.
fn errata(page: &Page) -> String {
    let review = format!("review-{}.md", page.source);
    let entries = page.models.first().map_or("", |model| model.errata);
    format!(
        "\n## Errata and open points\n\nThese entries concern the manual: {entries}. A comment names the entry where a row or a rule \
         follows it.\n\nOpen points, with how sure each choice is: [{review}]({review}#chosen-values).\n"
    )
}

/// The differences between the models of a page.
fn models(models: &[&Model]) -> String {
    let line = |model: &&Model| {
        let ident = format!("{:04X}h", model.ident);
        let name = format!("`{}`", model.name);
        let texts = [model.title, model.vendor, model.manual, model.gsd.hardware, model.gsd.software];
        [name, ident].into_iter().chain(texts.map(str::to_owned)).collect()
    };
    let head = ["Name", "Ident number", "Device", "Vendor", "Manual", "Hardware release", "Software release"];
    table(&head, models.iter().map(line))
}

/// The parts that do not depend on the name.
pub fn tables(model: &Model) -> String {
    let sections = [
        ("Services", services(model)),
        ("Configurations", configurations(model)),
        ("Telegrams from the master", telegrams(model.configurations.iter().filter_map(|it| it.outputs))),
        ("Telegrams from the device", telegrams(model.configurations.iter().filter_map(|it| it.inputs))),
        ("User parameters", user_prm(model)),
        ("Units", units(model)),
        ("Measuring parts", ranges(model)),
        ("Blocks", model.blocks.iter().filter(|placed| !placed.locations.is_empty()).map(block).collect()),
        ("Parameter channel", channel(model.channel_rules)),
        ("Refusals", refusals(model)),
        ("Faults", faults(model)),
    ];
    sections.map(|(title, text)| format!("\n## {title}\n\n{}\n", text.trim_end())).concat()
}

/// A Markdown table.
pub fn table(head: &[&str], lines: impl IntoIterator<Item = Vec<String>>) -> String {
    let line = |cells: &[String]| format!("| {} |\n", cells.join(" | "));
    let head: Vec<_> = head.iter().map(|&cell| cell.to_owned()).collect();
    let rule = "|---".repeat(head.len());
    let lines: String = lines.into_iter().map(|cells| line(&cells)).collect();
    format!("{}{rule}|\n{lines}", line(&head))
}

fn hex(octets: &[u8]) -> String {
    let octets: Vec<_> = octets.iter().map(|octet| format!("{octet:02X}")).collect();
    if octets.is_empty() { "none".to_owned() } else { format!("`{}`", octets.join(" ")) }
}

fn services(model: &Model) -> String {
    let features = model.features;
    let all = [
        ("Sync", features.sync),
        ("Freeze", features.freeze),
        ("Set_Slave_Add", model.gsd.set_slave_add),
        ("DP-V1, class 1 (MS1)", features.dpv1 && features.ms1),
        ("DP-V1, class 2 (MS2)", features.dpv1),
    ];
    let lines = all.map(|(name, has)| vec![name.to_owned(), if has { "yes" } else { "no" }.to_owned()]);
    let diagnosis = vec!["Longest diagnosis".to_owned(), format!("{} octets", model.gsd.max_diag_octets)];
    table(&["Service", "Supported"], lines.into_iter().chain([diagnosis]))
}

fn configurations(model: &Model) -> String {
    let number = |telegram: Option<&Telegram>| telegram.map_or("-".to_owned(), |it| format!("T{}", it.number));
    let line = |(count, it): (usize, &Configuration)| {
        let default = if it == model.default_configuration { "yes" } else { "" };
        vec![
            count.to_string(),
            number(it.outputs),
            it.output_octets().to_string(),
            number(it.inputs),
            it.input_octets().to_string(),
            hex(it.octets),
            default.to_owned(),
        ]
    };
    let head = ["No.", "From master", "Octets", "From device", "Octets", "Configuration data", "Default"];
    table(&head, (1..).zip(model.configurations).map(line))
}

/// Every telegram of one direction once, by its number.
fn telegrams(all: impl Iterator<Item = &'static Telegram>) -> String {
    let mut telegrams: Vec<_> = all.collect();
    telegrams.sort_by_key(|telegram| telegram.number);
    telegrams.dedup();
    let line = |telegram: &Telegram| {
        let fields: Vec<_> = telegram.layout().map(|(start, field)| words::placed(start, field)).collect();
        vec![format!("T{}", telegram.number), telegram.octets().to_string(), fields.join(", ")]
    };
    if telegrams.is_empty() {
        return "None.".to_owned();
    }
    table(&["Telegram", "Octets", "Octet and field"], telegrams.into_iter().map(line))
}

fn user_prm(model: &Model) -> String {
    let lines = model.user_prm.iter().map(|prm| vec![prm.name.to_owned(), hex(prm.octets)]);
    let text = table(&["Selects", "Octets"], lines);
    match model.free_bits() {
        [0, 0] => text,
        [first, second] => {
            format!(
                "{text}\nThe device also accepts the bits `{first:02X}` in the first octet and `{second:02X}` in the second.\n"
            )
        }
    }
}

fn units(model: &Model) -> String {
    let line = |unit: &profivac_devices::model::Unit| {
        vec![
            format!("{:04X}h", unit.code),
            unit.code.to_string(),
            unit.name.to_owned(),
            format!("`{}`", unit.alias),
            words::scale(unit.scale),
        ]
    };
    table(&["Code", "Decimal", "Unit", "Also called", "1 mbar is"], model.units.iter().map(line))
}

fn ranges(model: &Model) -> String {
    if model.parts.is_empty() {
        return "The manual gives no ranges: they are those of the gauges.".to_owned();
    }
    let lines = model.parts.iter().map(|facts| {
        let limits = facts.limits;
        let mbar = [limits.under_pa, limits.over_pa, limits.full_scale_pa].map(|pa| format!("{:e}", pa / 100.0));
        let part = [facts.part.instance.to_string(), words::principle(facts.part.principle).to_owned()];
        let rest = [words::shows(facts.clipping).to_owned(), words::counts(facts.counts)];
        part.into_iter().chain(mbar).chain(rest).collect()
    });
    let head = ["Instance", "Principle", "Underrange", "Overrange", "Full scale", "Shows", "COUNTS"];
    let table = table(&head, lines);
    if unranged_instances(model).is_empty() {
        return format!("Pressures in mbar.\n\n{table}");
    }
    format!(
        "Pressures in mbar. The manual gives no ranges: these are chosen for the virtual device. Of a real one, the ends of a \
         range are those that it reports as Underrange and Overrange.\n\n{table}"
    )
}

fn block(placed: &PlacedBlock) -> String {
    let block_type = placed.block.block_type.map_or(String::new(), |number| format!(", block type {number}"));
    let head = ["ID", "Name", "Type", "Octets", "Access", "Store", "Section"];
    let rows = table(&head, placed.block.rows.iter().map(row));
    let addresses = table(&["Slot", "Instance", "Of"], placed.locations.iter().map(words::address));
    format!("### {}{block_type}\n\n{addresses}\n{rows}\n", placed.block.name)
}

fn row(row: &Row) -> Vec<String> {
    vec![
        row.index.to_string(),
        row.name.to_owned(),
        row.data_type.to_string(),
        words::length(row.data_type),
        format!("`{}`", row.access_text),
        row.storage.to_string(),
        row.section.to_owned(),
    ]
}

fn channel(dialect: &ChannelRules) -> String {
    let lines = dialect.tasks.iter().map(|(ak, it)| vec![ak.to_string(), words::instruction(*it)]);
    let rest = if dialect.needs_idle_between {
        "A new instruction is started only after AK 0."
    } else {
        "A new instruction is started at once, without AK 0 before it."
    };
    format!("{}\n{rest}\n", table(&["AK", "Instruction"], lines))
}

/// In the order of the checks. The codes of DP-V1 only for a device with DP-V1.
fn refusals(model: &Model) -> String {
    let lines = words::REFUSALS.map(|refusal| {
        let channel = [words::refusal(refusal).to_owned(), model.channel_rules.error_code(refusal).to_string()];
        let Negative { code_1, code_2 } = Negative::from(refusal);
        let dpv1 = match words::is_of_channel_only(refusal) {
            true => ["-".to_owned(), "-".to_owned()],
            false => [format!("{:02X}h", code_1.0), code_2.to_string()],
        };
        channel.into_iter().chain(dpv1.into_iter().filter(|_| model.features.dpv1)).collect()
    });
    let head = ["Reason", "Parameter channel", "Error_Code_1", "Error_Code_2"];
    table(if model.features.dpv1 { &head } else { &head[..2] }, lines)
}

fn faults(model: &Model) -> String {
    let all = model.faults.names().zip(model.faults.effects);
    table(&["Fault", "What it does"], all.map(|(name, effect)| vec![format!("`{name}`"), (*effect).to_owned()]))
}
