//! The device files in `docs/devices/files`, and the page that lists them. `cargo xtask goldens` writes the page.

use crate::golden;
use crate::round_trip::{again, compare};
use profivac_client::gsd::gsd;
use profivac_client::names::ParameterNames;
use profivac_client::st::{Dialect, st};
use profivac_device_file::{DeviceFile, known_devices};
use profivac_devices::catalog::MODELS;
use profivac_devices::model::Model;
use profivac_gsd::{Fit, GsdFile};
use std::collections::BTreeSet;
use std::fs;
use std::path::{Path, PathBuf};

/// From here on a number stands for an Ident_Number that is not known.
const NO_IDENT: u16 = 0xFFF0;

/// A file of the gallery.
struct Entry {
    /// Without the folder.
    file: String,
    lines: usize,
    /// The devices that it is like.
    parents: Vec<String>,
    model: &'static Model,
}

fn folder() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../../docs/devices/files")
}

/// All files, by name.
fn gallery() -> Vec<Entry> {
    let mut paths: Vec<PathBuf> = fs::read_dir(folder()).unwrap().map(|entry| entry.unwrap().path()).collect();
    paths.sort();
    paths.iter().map(|path| entry(path)).collect()
}

fn entry(path: &Path) -> Entry {
    let read = DeviceFile::read(path).unwrap_or_else(|error| panic!("{error}"));
    Entry {
        file: path.file_name().unwrap().to_str().unwrap().to_owned(),
        lines: fs::read_to_string(path).unwrap().lines().count(),
        parents: read.parents().map(str::to_owned).collect(),
        model: read.model().unwrap(),
    }
}

#[test]
fn the_folder_has_device_files_with_names_and_ident_numbers_of_their_own() {
    let entries = gallery();
    assert!(entries.len() >= 3);
    let known = known_devices(&[folder()]).unwrap_or_else(|error| panic!("{error}"));
    assert_eq!(known.described().len(), entries.len(), "a folder of device files and nothing else");
    let mut idents: BTreeSet<u16> = MODELS.iter().map(|model| model.ident).collect();
    for Entry { file, model, .. } in &entries {
        assert_eq!(*file, format!("{}.toml", model.name), "the file has the name of its device");
        assert!(idents.insert(model.ident), "{file}: another device has the ident {:04X}", model.ident);
        assert!(!model.errata.is_empty(), "{file}: errata says what the manual does not say");
    }
}

#[test]
fn a_device_of_the_gallery_is_the_same_after_it_is_shown_and_read() {
    for Entry { model, .. } in gallery() {
        compare(again(model, "again"), model);
    }
}

#[test]
fn a_device_of_the_gallery_has_names_a_gsd_file_and_blocks() {
    for Entry { file, model, .. } in gallery() {
        let names = ParameterNames::of(model);
        let distinct: BTreeSet<&str> = names.all().iter().map(|named| named.name.as_str()).collect();
        assert_eq!(distinct.len(), names.all().len(), "{file}");
        let gsd = GsdFile::read(gsd(model).as_bytes());
        for configuration in model.configurations {
            let fit = Fit::new(gsd.device(), configuration.octets);
            assert!(fit.is_ok(), "{file}: {:02X?}", configuration.octets);
        }
        // A device without pressures has no block.
        let blocks = st(model, Dialect::Standard);
        assert_eq!(blocks.contains("END_FUNCTION_BLOCK"), !model.parts.is_empty(), "{file}");
    }
}

#[test]
fn the_page_has_every_file() {
    let entries = gallery();
    let rows = entries.iter().map(row).collect::<String>();
    let open = entries.iter().map(open_points).collect::<String>();
    golden::compare("docs/devices/gallery.md", &format!("{HEAD}{rows}{OPEN}{open}"));
}

const HEAD: &str = "\
<!-- Generated from the files in `docs/devices/files` by `cargo xtask goldens`. Do not edit. -->

# Devices in files

Devices that a file describes. [Devices described in a file](../device-files.md) explains how to use a file and how to write one,
[CONTRIBUTING](../../CONTRIBUTING.md) how to send one in.

| Name | Device | Vendor | Manual | Ident number | Like | Lines | File |
|---|---|---|---|---|---|---|---|
";

const OPEN: &str = "
## What the manuals do not say

`profivac device show FILE.toml` prints these sentences as `errata`.
";

fn row(entry: &Entry) -> String {
    let Entry { file, lines, parents, model } = entry;
    let ident = if model.ident < NO_IDENT { format!("{:04X}h", model.ident) } else { "not known".to_owned() };
    let like = parents.first().map_or_else(|| "-".to_owned(), |parent| format!("`{parent}`"));
    let Model { name, title, vendor, manual, .. } = model;
    format!("| `{name}` | {title} | {vendor} | {manual} | {ident} | {like} | {lines} | [{file}](files/{file}) |\n")
}

fn open_points(entry: &Entry) -> String {
    let Model { title, errata, .. } = entry.model;
    format!("\n### {title}\n\n{errata}.\n")
}
