//! Devices that are like another one.

use profivac_client::names::ParameterNames;
use profivac_device_file::DeviceFile;
use profivac_devices::catalog::model_named;
use profivac_devices::model::{Codes, Model, Precondition, Role};

const HEAD: &str = "format = 1\nname = \"mine\"\ntitle = \"Mine\"\nlike = \"bcg450\"\n";

fn model(changes: &str) -> &'static Model {
    DeviceFile::parse(&format!("{HEAD}{changes}")).unwrap_or_else(|error| panic!("{error}")).model().unwrap()
}

fn said(changes: &str) -> String {
    DeviceFile::parse(&format!("{HEAD}{changes}")).map(|_| "read".to_owned()).unwrap_or_else(|error| error.to_string())
}

#[test]
fn rows_are_replaced_added_and_left_out_and_all_others_stay() {
    let model = model(
        r#"
[[block]]
name = "Device Block"
without = [207]
parameters = [
  { index = 19, name = "Manufacturer", type = "VSTRING(10)", access = "1/2_R", store = "N", section = "9" },
  { index = 200, name = "Filament", type = "UINT8", access = "1/2_R/W", store = "N", section = "9", codes = "filament" },
]
[[block]]
name = "Diaphragm Gauge Transducer Block"
at = []
[codes.filament]
names = [{ code = 1, name = "first" }, { code = 2, name = "second" }]
"#,
    );
    let block = model.blocks[0].block;
    let names: Vec<_> = block.rows.iter().map(|row| (row.index, row.name)).collect();
    assert!(names.windows(2).all(|pair| pair[0].0 < pair[1].0), "{names:?}");
    assert!(names.contains(&(19, "Manufacturer")) && names.contains(&(200, "Filament")));
    assert!(!names.iter().any(|(index, _)| *index == 207));
    assert!(names.contains(&(18, "Standard Revision Level")), "inherited");
    assert!(block.row(200).is_some_and(|row| row.codes.codes().len() == 2));
    let diaphragm = model.blocks.iter().find(|placed| placed.block.name.starts_with("Diaphragm")).unwrap();
    assert!(diaphragm.locations.is_empty());
}

#[test]
fn a_list_replaces_the_inherited_one() {
    let model = model(
        r#"
ident = 0x0B00
configurations = [{ inputs = 5, octets = "44 86 05 05 05 08" }]
units = [{ code = 1308, name = "mbar", alias = "hPa", per-mbar = 1.0 }]
"#,
    );
    assert_eq!((model.ident, model.configurations.len(), model.units.len()), (0x0B00, 1, 1));
    assert_eq!(model.default_configuration.octets, [0x44, 0x86, 5, 5, 5, 8]);
    assert_eq!((model.vendor, model.user_prm.len()), ("INFICON AG", 5));
}

#[test]
fn what_does_not_fit_the_inherited_tables_is_named_at_like() {
    let found = said("[inputs]\n4 = [\"exception-status\"]\n");
    assert!(found.starts_with("device file:4:8: line "), "{found}");
    assert!(
        found.contains(" of `profivac device show bcg450` does not fit this file: the octets do not announce"),
        "{found}"
    );
    let found = said("[[block]]\nname = \"Device Block\"\nwithout = [3]\n");
    assert_eq!(found, "device file:7:12: the inherited block has no index 3; delete it here");
    let found = said("[[block]]\nname = \"Devize Block\"\nwithout = [207]\n");
    assert!(found.contains("did you mean \"Device Block\"?"), "{found}");
}

/// The commands of the hot cathode, with one change.
fn commands(degas: &str) -> String {
    format!(
        "[codes.hot-cathode-block-state-command]\ncommands = [\n  {{ code = 0, name = \"inactive\" }},\n  {degas},\n]\n\
         [codes.emission-status]\nnames = [{{ code = 0, name = \"off\", risk = \"no value\" }}]\n"
    )
}

#[test]
fn an_inherited_command_keeps_its_conditions_and_its_risk() {
    let whole = "{ code = 0x0101, name = \"degas-on\", needs = [\"executing\", \"emission-on\", \"degas-off\", \"pressure below 1e-6 mbar\"], \
                 risk = \"gas\" }";
    let model = model(&commands(whole));
    let row = model.blocks.iter().flat_map(|placed| placed.block.rows).find(|row| row.index == 14).unwrap();
    let Codes::Commands(codes) = row.codes else { panic!("commands") };
    assert_eq!(
        codes[1].preconditions[3],
        Precondition::PressureBelow(None, 1e-6 * 100.0),
        "another limit of the same condition"
    );
    for (old, new, lost) in [
        ("\"emission-on\", ", "", "the condition \"emission-on\""),
        (", \"pressure below 1e-6 mbar\"", "", "the condition \"pressure below "),
        (", risk = \"gas\"", "", "a risk"),
    ] {
        assert_eq!(whole.matches(old).count(), 1);
        let found = said(&commands(&whole.replace(old, new)));
        let expected = format!("\"degas-on\" of index 14, \"Hot Cathode Block State Command\", needs {lost}");
        assert!(found.contains(&expected), "{found}");
    }
    let plain = r#"
[[block]]
name = "Hot Cathode Ion Gauge Transducer Block"
parameters = [{ index = 14, name = "Command", type = "RECORD(2)", access = "1_W 2_W" }]
"#;
    let found = said(plain);
    assert!(
        found.starts_with("device file:8:15: ") && found.contains("needs a table of codes with its conditions"),
        "{found}"
    );
    // Another instance, one that is missing, a table without codes, and the block at another place are ways to lose a condition as well.
    let looser = whole.replace("pressure below 1e-6 mbar", "pressure below 1e-5 mbar");
    assert!(said(&commands(&looser)).contains("or a stricter limit, in bcg450"), "{}", said(&commands(&looser)));
    let other = whole.replace("pressure below", "pressure of instance 1 below");
    assert!(said(&commands(&other)).contains("needs the condition \"pressure below "), "{}", said(&commands(&other)));
    let missing = whole
        .replace("pressure below 1e-6 mbar\"", "pressure below 1e-6 mbar\", \"pressure of instance 99 below 1 mbar\"");
    assert!(
        said(&commands(&missing)).contains("needs the process-value at slot 1, instance 99"),
        "{}",
        said(&commands(&missing))
    );
    let bits = "[codes.hot-cathode-block-state-command]\nbits = [{ bit = 0, name = \"degas\" }]\n";
    assert!(said(bits).contains("needs a table of codes with its conditions"), "{}", said(bits));
    let few = whole.replace("\"emission-on\", ", "").replace(", \"pressure below 1e-6 mbar\"", "");
    let moved = format!(
        "{}[[block]]\nname = \"Hot Cathode Ion Gauge Transducer Block\"\nat = [{{ slot = 9, name = \"BA\" }}]\n",
        commands(&few)
    );
    assert!(said(&moved).contains("needs the condition \"emission-on\""), "{}", said(&moved));
    let names = commands(whole).replace("\ncommands = [", "\nnames = [");
    assert!(said(&names).contains("needs commands in place of names"));
    let bits = commands(whole).replace("\ncommands = [", "\nbit-commands = [");
    assert!(said(&bits).contains("needs commands in place of bit-commands"), "{}", said(&bits));
}

/// A condition about another parameter, or about one that nobody reads, says nothing.
#[test]
fn an_inherited_condition_is_about_the_parameter_of_the_parent() {
    let in_block = |block: &str, row: &str| format!("[[block]]\nname = {block:?}\nparameters = [{row}]\n");
    let cathode = |row: &str| said(&in_block("Hot Cathode Ion Gauge Transducer Block", row));
    let status =
        r#"{ index = 105, name = "Emission Status", type = "UINT8", access = "1/2_R/W", codes = "emission-status" }"#;
    assert_eq!(cathode(status), "read");
    for (old, new, expected) in [
        ("UINT8", "FLOAT", "needs the emission-status at slot 1, instance 2, a whole number that a master reads"),
        ("1/2_R/W", "1/2_W", "needs the emission-status at slot 1, instance 2, a whole number that a master reads"),
        (
            "\"1/2_R/W\"",
            "\"2_R\"",
            "needs the emission-status at slot 1, instance 2, a whole number that a master reads",
        ),
        ("index = 105, ", "index = 111, role = \"emission-status\", ", "read"),
        ("index = 105, ", "index = 99, role = \"emission-status\", ", "with index 105 and access"),
    ] {
        let found = cathode(&status.replace(old, new));
        assert!(found.contains(expected), "{new}: {found}");
    }
    let state =
        in_block("Device Block", r#"{ index = 25, name = "Device State", type = "VSTRING(1)", access = "1/2_R" }"#);
    assert!(
        said(&state).contains("needs the Device State at index 25 at slot 0, instance 0, a whole number"),
        "{}",
        said(&state)
    );
}

/// A gauge from its manual, with the telegrams of another one: its file has the differences only.
#[test]
fn a_gauge_with_the_telegrams_of_another_is_a_short_file() {
    let text = include_str!("../../../docs/devices/files/bpg402.toml");
    assert!(text.lines().count() < 150);
    let bpg402 = DeviceFile::parse(text).unwrap_or_else(|error| panic!("{error}")).model().unwrap();
    let bcg450 = model_named("bcg450").unwrap();
    assert_eq!(format!("{:?}", bpg402.configurations), format!("{:?}", bcg450.configurations));
    let names = ParameterNames::of(bpg402);
    let all: Vec<_> = names.all().iter().map(|named| (named.parameter.numbers(), named.name.as_str())).collect();
    for (numbers, name) in [
        ("0/27", "device.exception-detail-alarm"),
        ("1:2/108", "ba.active-filament"),
        ("1:2/14", "ba.hot-cathode-block-state-command"),
        ("1:3/19", "setpoint-a.process-value"),
    ] {
        assert!(all.contains(&(numbers.to_owned(), name)), "{name} is not in {all:?}");
    }
    for absent in ["0/206", "1:3/201", "1:4/14", "1:5/19"] {
        assert!(!all.iter().any(|(numbers, _)| numbers == absent), "{absent}");
    }
    assert!(names.commands().any(|(_, code)| code.name == "degas-on" && code.preconditions.len() == 4));
}

/// A file may have other parameters with codes of units, before that of the pressures too.
#[test]
fn the_unit_is_the_parameter_with_that_name_or_role() {
    let display = r#"{ index = 200, name = "Display Unit", type = "UINT16", access = "1/2_R/W", codes = "units" }"#;
    let block = |rows: &str| format!("[[block]]\nname = \"Device Block\"\nparameters = [{rows}]\n");
    let units = |model: &'static Model| {
        let rows = model.blocks.iter().flat_map(|placed| placed.block.rows);
        rows.filter(|row| row.role == Some(Role::Unit)).map(|row| (row.index, row.name)).collect::<Vec<_>>()
    };
    assert_eq!(units(model(&block(display))), [(22, "Data Units"); 2]);
    // A manual with another name and no role: each row with the codes is the unit.
    let text =
        profivac_device_file::show(model_named("bcg450").unwrap()).replace("name = \"bcg450\"", "name = \"other\"");
    let renamed = DeviceFile::parse(&text.replace("\"Data Units\"", "\"Unit of pressure\"")).unwrap().model().unwrap();
    assert_eq!(units(renamed), [(22, "Unit of pressure"); 2]);
}
