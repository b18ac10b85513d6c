//! Every compiled device, printed as a file and read again.

use profivac_client::gsd::gsd;
use profivac_client::names::ParameterNames;
use profivac_client::st::{Dialect, st};
use profivac_device_file::{DeviceFile, show};
use profivac_devices::catalog::MODELS;
use profivac_devices::model::Model;

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

#[test]
fn loading_a_file_again_gives_the_same_model() {
    let text = "format = 1\nname = \"twice\"\ntitle = \"Twice\"\nlike = \"bcg450\"\n";
    let load = |text: &str| DeviceFile::parse(text).unwrap().model().unwrap();
    assert!(std::ptr::eq(load(text), load(text)));
    let changed = text.replace("title = \"Twice\"", "title = \"Other\"");
    assert!(!std::ptr::eq(load(text), load(&changed)));
}
