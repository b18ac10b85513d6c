//! Files and folders of device files as one value.

use profivac_device_file::known_devices;
use std::path::PathBuf;

fn written(folder: &tempfile::TempDir, name: &str, device: &str) -> PathBuf {
    let path = folder.path().join(name);
    let text = format!("format = 1\nname = \"{device}\"\ntitle = \"{device}\"\nlike = \"bcg450\"\nident = 0x1234\n");
    std::fs::write(&path, text).unwrap();
    path
}

#[test]
fn a_folder_has_its_device_files_and_nothing_else() {
    let folder = tempfile::tempdir().unwrap();
    let one = written(&folder, "one.toml", "one");
    written(&folder, "two.TOML", "two");
    std::fs::write(folder.path().join("notes.txt"), "not a device").unwrap();
    std::fs::create_dir(folder.path().join("old.toml")).unwrap();
    // A file that is reached in two ways is one device.
    let paths = [folder.path().to_owned(), one];
    let devices = known_devices(&paths).unwrap();
    assert_eq!(devices.described().iter().map(|model| model.name).collect::<Vec<_>>(), ["one", "two"]);
    assert!(devices.names_with_ident(0x1234).eq(["one", "two"]) && devices.named("bcg450").is_some());
    assert_eq!(devices, known_devices(&paths).unwrap(), "the same files are the same devices");
    assert!(std::ptr::eq(devices.described(), known_devices(&paths).unwrap().described()));
}

#[test]
fn two_files_with_one_name_and_a_wrong_file_are_refused_with_their_places() {
    let folder = tempfile::tempdir().unwrap();
    let one = written(&folder, "one.toml", "same");
    let two = folder.path().join("two.toml");
    std::fs::write(&two, "format = 1\nname = \"same\"\ntitle = \"Same\"\nlike = \"img400\"\n").unwrap();
    let said = known_devices(&[one.clone(), two.clone()]).unwrap_err().to_string();
    assert_eq!(said, format!("{}: {} has the name \"same\" too; rename one", two.display(), one.display()));
    std::fs::write(&two, "format = 1\nname = 7\n").unwrap();
    let said = known_devices(&[folder.path().to_owned()]).unwrap_err().to_string();
    assert!(said.starts_with(&format!("{}:2:", two.display())), "{said}");
    let absent = folder.path().join("absent.toml");
    let said = known_devices(std::slice::from_ref(&absent)).unwrap_err().to_string();
    assert!(said.starts_with(&format!("{}: the file cannot be read", absent.display())), "{said}");
}

/// A file in the middle that leaves out the command does not free the next one from its conditions.
#[test]
fn a_condition_is_kept_through_a_file_that_leaves_out_its_command() {
    let folder = tempfile::tempdir().unwrap();
    let [middle, last] = ["middle.toml", "last.toml"].map(|name| folder.path().join(name));
    let block = "[[block]]\nname = \"Hot Cathode Ion Gauge Transducer Block\"\n";
    let head = |name: &str, like: &str| format!("format = 1\nname = {name:?}\ntitle = {name:?}\nlike = {like:?}\n");
    std::fs::write(&middle, format!("{}{block}without = [14]\n", head("middle", "bcg450"))).unwrap();
    let command = "[codes.own]\ncommands = [{ code = 0x0101, name = \"degas-on\" }]\n";
    let row = "parameters = [{ index = 14, name = \"Command\", type = \"RECORD(2)\", access = \"1/2_W\", codes = \"own\" }]\n";
    std::fs::write(&last, format!("{}{command}{block}{row}", head("last", "middle.toml"))).unwrap();
    known_devices(&[middle]).unwrap();
    let said = known_devices(&[last]).unwrap_err().to_string();
    assert!(said.contains("needs the condition"), "{said}");
}
