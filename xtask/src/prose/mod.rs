//! One word for each thing: rejects words and forms of sentences that the project does not use, and lines that are too wide.
//!
//! The words are those of the column "Not" in `docs/glossary.md`, without those that have another meaning as well
//! ([`words::AMBIGUOUS`]); the forms are [`words::FORMS`]. Rust is read as comments, strings and identifiers; identifiers are
//! split at underscores and capitals. The sources of the dashboard and the Markdown pages are read line by line.

mod rust;
mod text;
mod width;
mod words;

use crate::root;
use anyhow::{Context, Result, bail};
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use words::{ALLOWED, Allowed, Rules};

/// A word or a form that is not used.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
struct Finding {
    /// The file, from the root of the repository.
    file: String,
    line: usize,
    /// The word or form of the rule.
    word: String,
    /// The advice.
    better: String,
}

/// Checks the tree. With `count`, prints how many findings each crate or folder has.
pub fn check(count: bool) -> Result<()> {
    let glossary = std::fs::read_to_string(root().join("docs/glossary.md")).context("docs/glossary.md")?;
    let rules = Rules::new(&glossary)?;
    let mut findings = Vec::new();
    let mut used = vec![false; ALLOWED.len()];
    for file in files(root())? {
        let name = name_of(&file);
        let (reader, width) = (reader_of(&name), width_of(&name));
        if reader.is_none() && width.is_none() {
            continue;
        }
        let text = std::fs::read_to_string(&file).with_context(|| name.clone())?;
        findings.extend(width.into_iter().flat_map(|(wide, _)| wide(&text)).map(|line| too_wide(&name, line)));
        let Some(reader) = reader else { continue };
        findings
            .extend(reader(&rules, &text).into_iter().filter_map(|found| finding(&name, found, &ALLOWED, &mut used)));
    }
    findings.sort();
    let idle = ALLOWED.iter().zip(used).filter(|(_, used)| !used).map(|(allowed, _)| allowed);
    let stale: Vec<String> =
        idle.map(|(word, path, _)| format!("'{word}' is allowed in {path} and does not occur there")).collect();
    if count {
        print_counts(&findings)
    } else {
        print(&findings, &stale)
    }
    let defects = findings.len().saturating_add(stale.len());
    if defects > 0 {
        bail!("prose: {defects} defects");
    }
    println!("prose: ok");
    Ok(())
}

/// Breaks the lines that are too wide.
pub fn wrap() -> Result<()> {
    for file in files(root())? {
        let name = name_of(&file);
        let Some((_, wrapped)) = width_of(&name) else { continue };
        let text = std::fs::read_to_string(&file).with_context(|| name.clone())?;
        let narrow = wrapped(&text);
        if narrow != text {
            std::fs::write(&file, narrow).with_context(|| name.clone())?;
            println!("{name}");
        }
    }
    Ok(())
}

/// The name of a file from the root of the repository.
fn name_of(file: &Path) -> String {
    file.strip_prefix(root()).unwrap_or(file).to_string_lossy().into_owned()
}

/// Finds the wide lines of a file, and breaks them.
type Width = (fn(&str) -> Vec<usize>, fn(&str) -> String);

/// Pages and sources in Rust, without pages that tests print: their tables and texts are those of the devices and rules.
fn width_of(name: &str) -> Option<Width> {
    const PRINTED: [&str; 3] = ["docs/devices/", "docs/conform-rules.md", "docs/pyprofibus.md"];
    match Path::new(name).extension()?.to_str()? {
        "md" if PRINTED.iter().any(|printed| name.starts_with(printed)) => None,
        "md" => Some((width::in_page, width::wrap_page)),
        "rs" => Some((width::in_rust, width::wrap_rust)),
        _ => None,
    }
}

fn too_wide(file: &str, line: usize) -> Finding {
    let better = "break it, or let `cargo xtask prose --wrap` break it".to_owned();
    Finding { file: file.to_owned(), line, word: "a line that is too wide".to_owned(), better }
}

/// A line with the rule that it breaks.
type Found = (usize, words::Match);

/// Finds the broken rules of a file.
type Reader = fn(&Rules, &str) -> Vec<Found>;

/// Rust below `crates`, `xtask`, `bench` and `ci`; the dashboard's sources; Markdown but for the specification, the changelog
/// and the glossary, which contains the words.
fn reader_of(name: &str) -> Option<Reader> {
    let extension = Path::new(name).extension()?.to_str()?;
    let is_web = name.starts_with("crates/station/web/src/");
    match extension {
        // The rules and their tests name the words.
        "rs" if name.starts_with("xtask/src/prose/") => None,
        "rs" => Some(rust::read),
        "ts" | "tsx" | "css" | "html" if is_web => Some(text::lines),
        "md" if name.starts_with("docs/spec/") || name == "CHANGELOG.md" || name == "docs/glossary.md" => None,
        "md" => Some(text::markdown),
        _ => None,
    }
}

/// Makes a finding unless the word is allowed in the file; notes the entry that allows it in `used`.
fn finding(file: &str, (line, found): Found, allowed: &[Allowed], used: &mut [bool]) -> Option<Finding> {
    let entry = allowed.iter().position(|(word, path, _)| *word == found.word && file.starts_with(path));
    if let Some(flag) = entry.and_then(|entry| used.get_mut(entry)) {
        *flag = true;
        return None;
    }
    Some(Finding { file: file.to_owned(), line, word: found.word, better: found.better })
}

fn print(findings: &[Finding], stale: &[String]) {
    for Finding { file, line, word, better } in findings {
        println!("{file}:{line}: '{word}': {better}");
    }
    stale.iter().for_each(|text| println!("xtask/src/prose/words.rs: {text}"));
}

fn print_counts(findings: &[Finding]) {
    let mut counts: BTreeMap<String, usize> = BTreeMap::new();
    for finding in findings {
        let count = counts.entry(area(&finding.file)).or_default();
        *count = count.saturating_add(1);
    }
    counts.iter().for_each(|(area, count)| println!("{count:6} {area}"));
}

/// The crate of a file, or the folder at the root.
fn area(file: &str) -> String {
    let names: Vec<&str> = file.split('/').collect();
    match names[..] {
        ["crates", name, ..] => name.to_owned(),
        [folder, _, ..] => format!("{folder}/"),
        _ => file.to_owned(),
    }
}

/// Every file below a folder, except hidden folders, build results and installed packages.
fn files(folder: &Path) -> Result<Vec<PathBuf>> {
    let mut found = Vec::new();
    for entry in std::fs::read_dir(folder).with_context(|| folder.display().to_string())? {
        let entry = entry?;
        let name = entry.file_name().to_string_lossy().into_owned();
        if entry.file_type()?.is_dir() {
            if !name.starts_with('.') && name != "target" && name != "node_modules" {
                found.extend(files(&entry.path())?);
            }
        } else {
            found.push(entry.path());
        }
    }
    found.sort();
    Ok(found)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sources_and_pages_are_read_and_the_specification_is_not() {
        for name in ["crates/wire/src/lib.rs", "crates/station/web/src/app.css", "README.md", "docs/station.md"] {
            assert!(reader_of(name).is_some(), "{name}");
        }
        for name in ["docs/spec/wire.md", "CHANGELOG.md", "docs/glossary.md", "crates/station/web/e2e/a.ts", "a.toml"] {
            assert!(reader_of(name).is_none(), "{name}");
        }
    }

    #[test]
    fn the_width_of_pages_and_sources_is_checked_and_that_of_printed_pages_is_not() {
        for name in ["crates/wire/src/lib.rs", "CHANGELOG.md", "docs/spec/profibus-wire/01-fdl.md"] {
            assert!(width_of(name).is_some(), "{name}");
        }
        for name in ["docs/devices/tpg.md", "docs/conform-rules.md", "crates/station/web/src/app.css", "test"] {
            assert!(width_of(name).is_none(), "{name}");
        }
    }

    #[test]
    fn findings_are_counted_by_crate_or_folder() {
        assert_eq!(area("crates/wire/src/lib.rs"), "wire");
        assert_eq!(area("docs/station.md"), "docs/");
        assert_eq!(area("README.md"), "README.md");
    }

    #[test]
    fn a_word_is_allowed_where_it_has_its_proper_meaning() {
        let allowed = [("gate", "crates/vacuum/", "a gate valve")];
        let found = || (1, words::Match { word: "gate".to_owned(), better: String::new() });
        let mut used = [false];
        assert_eq!(finding("crates/vacuum/src/lib.rs", found(), &allowed, &mut used), None);
        assert_eq!(used, [true]);
        assert!(finding("crates/station/src/lib.rs", found(), &allowed, &mut used).is_some());
    }
}
