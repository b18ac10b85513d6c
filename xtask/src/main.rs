//! `cargo xtask TASK`: checks of the repository, and its generated files.
//!
//! Each task is a module. A check prints one line if it passes, otherwise all defects.

mod architecture;
mod circles;
mod citations;
mod configuration;
mod goldens;
mod layers;
mod links;
mod modules;
mod pages;
mod purity;

use anyhow::{Context, Result, bail};
use std::path::{Path, PathBuf};
use std::process::Command;

const USAGE: &str =
    "usage: cargo xtask layers         crates use lower ranks only; no modules use each other in a circle
       cargo xtask citations      every citation names an existing section
       cargo xtask architecture   the walks in ARCHITECTURE.md name files and functions that exist
       cargo xtask pages          every page of docs/ is in docs/SUMMARY.md once; every link between pages has a target;
                                  every key of a file has its sentence
       cargo xtask configuration  print the page about the keys of the files
       cargo xtask purity         the inner crates and their dependencies need neither std nor alloc
       cargo xtask goldens        write the golden files again, for review with git diff";

fn main() -> Result<()> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    match arguments.iter().map(String::as_str).collect::<Vec<_>>()[..] {
        ["layers"] => layers::check(),
        ["citations"] => citations::check(),
        ["architecture"] => architecture::check(),
        ["pages"] => pages::check().and_then(|()| links::check()).and_then(|()| configuration::check()),
        ["configuration"] => configuration::print(),
        ["purity"] => purity::check(),
        ["goldens"] => goldens::bless(),
        _ => {
            eprintln!("{USAGE}");
            std::process::exit(2);
        }
    }
}

/// The root of the repository.
fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR")).parent().unwrap_or(Path::new("."))
}

/// A file of the repository.
struct Source {
    /// The path from the root.
    path: String,
    /// Empty if it is no text.
    text: String,
}

/// The files that git knows.
fn tracked() -> Result<Vec<Source>> {
    let names = Command::new("git").args(["ls-files", "-z"]).current_dir(root()).output().context("git ls-files")?;
    let names = String::from_utf8(names.stdout)?;
    let read = |path: &str| std::fs::read_to_string(root().join(path)).unwrap_or_default();
    let paths = names.split('\0').filter(|path| !path.is_empty());
    Ok(paths.map(|path| Source { path: path.to_owned(), text: read(path) }).collect())
}

/// The files with this extension below a folder, with their texts, in the order of their paths.
fn files(folder: &Path, extension: &str) -> Result<Vec<(PathBuf, String)>> {
    let mut found = Vec::new();
    for entry in std::fs::read_dir(folder).with_context(|| folder.display().to_string())? {
        let path = entry?.path();
        if path.is_dir() {
            found.extend(files(&path, extension)?);
        } else if path.extension().is_some_and(|other| other == extension) {
            let text = std::fs::read_to_string(&path).with_context(|| path.display().to_string())?;
            found.push((path, text));
        }
    }
    found.sort();
    Ok(found)
}

/// Prints that a check passes, or prints its defects and fails.
fn verdict(what: &str, defects: &[String]) -> Result<()> {
    if defects.is_empty() {
        println!("{what}: ok");
        return Ok(());
    }
    for defect in defects {
        println!("{what}: {defect}");
    }
    bail!("{what}: {} defects", defects.len());
}
