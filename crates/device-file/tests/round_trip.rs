//! Every compiled device, printed as a file and read again.

use profivac_client::gsd::gsd;
use profivac_client::names::ParameterNames;
use profivac_client::st::{Dialect, st};
use profivac_device_file::{DeviceFile, show};
use profivac_devices::catalog::MODELS;
use profivac_devices::model::Model;
use std::collections::BTreeSet;

/// The device, read from its own file under another name.
pub fn again(model: &'static Model, name: &str) -> &'static Model {
    let own = format!("name = \"{}\"\n", model.name);
    let text = show(model).replacen(&own, &format!("name = \"{name}\"\n"), 1);
    DeviceFile::parse(&text).unwrap_or_else(|error| panic!("{}: {error}", model.name)).model().unwrap()
}

/// All tables as text. A float has its shortest exact form there, so that equal texts have equal bits.
fn tables(model: &Model, name: &str) -> String {
    format!("{model:#?}").replacen(&format!("name: {name:?}"), "name: \"\"", 1)
}

/// Compares all tables of two devices with different names; the error is the first line that differs.
pub fn compare(file: &Model, model: &Model) {
    let [found, expected] = [file, model].map(|model| tables(model, model.name));
    let different = found.lines().zip(expected.lines()).find(|(found, expected)| found != expected);
    assert_eq!(different, None, "{}", model.name);
    assert!(found == expected, "{}: one has more lines", model.name);
}

#[test]
fn the_tables_of_every_device_are_bit_equal_after_a_file() {
    for model in MODELS {
        let file = again(model, "again");
        compare(file, model);
    }
}

#[test]
fn what_is_made_of_the_tables_is_the_same_after_a_file() {
    for model in MODELS {
        let file = again(model, "again");
        assert_eq!(gsd(file), gsd(model), "{}", model.name);
        let blocks =
            |model: &Model| st(model, Dialect::Standard).replace(&format!("PV_{}_", model.name.to_uppercase()), "PV_");
        assert!(blocks(file) == blocks(model), "{}", model.name);
        let names = |model| format!("{:?}", ParameterNames::of(model).all());
        assert!(names(file) == names(model), "{}", model.name);
    }
}

/// A device that is like another and says nothing else has all of its tables.
#[test]
fn like_without_differences_inherits_every_table() {
    for model in MODELS {
        let text = format!("format = 1\nname = \"same\"\ntitle = {:?}\nlike = {:?}\n", model.title, model.name);
        let same = DeviceFile::parse(&text).unwrap_or_else(|error| panic!("{error}")).model().unwrap();
        compare(same, model);
    }
}

/// Names, units and tasks that no compiled device has.
#[test]
fn the_blocks_of_any_device_are_identifiers_numbers_and_statements() {
    let mut seen = BTreeSet::new();
    for name in ["a-b", "a--b", "a---b", "a-name-of-thirty-two-characters1", "a-name-of-thirty-two-characters2"] {
        let text = format!(
            "format = 1\nname = {name:?}\ntitle = \"\u{c5} *) (*\"\nlike = \"tpg500\"\nunits = [{{ code = 1, name = \"mbar\", per-mbar = 1.0 }}, \
             {{ code = 40000, name = \"x *) y\", per-mbar = 0.001 }}]\n[parameter-channel]\ntasks = [{{ ak = 1 }}]\n"
        );
        let model = DeviceFile::parse(&text).unwrap_or_else(|error| panic!("{error}")).model().unwrap();
        let text = st(model, Dialect::Standard);
        for block in text.lines().filter_map(|line| line.strip_prefix("FUNCTION_BLOCK ")) {
            let is_word = |letter: char| letter.is_ascii_uppercase() || letter.is_ascii_digit() || letter == '_';
            assert!(block.chars().all(is_word) && !block.contains("__") && block.len() <= 32, "{block}");
            assert!(seen.insert(block.to_owned()), "{block} is there twice");
        }
        assert!(text.is_ascii() && text.matches("(*").count() == text.matches("*)").count(), "{text}");
        assert!(text.contains("UNIT : DINT := -1;"), "40000 is no INT:\n{text}");
        assert!(!text.contains("CASE LENGTH OF"), "no task writes:\n{text}");
    }
}

#[test]
fn loading_a_file_again_gives_the_same_model() {
    let text = "format = 1\nname = \"twice\"\ntitle = \"Twice\"\nlike = \"bcg450\"\n";
    let load = |text: &str| DeviceFile::parse(text).unwrap().model().unwrap();
    assert!(std::ptr::eq(load(text), load(text)));
    let changed = text.replace("title = \"Twice\"", "title = \"Other\"");
    assert!(!std::ptr::eq(load(text), load(&changed)));
}
