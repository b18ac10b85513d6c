//! The book of `docs/`: every page is in `docs/SUMMARY.md` once, and each of the four paths has its four kinds of pages.
//!
//! `ci/book` builds the book.

use crate::{root, verdict};
use anyhow::{Context, Result};
use std::collections::BTreeMap;
use std::path::Path;

/// The list of the pages.
const SUMMARY: &str = "docs/SUMMARY.md";
/// The folder with the pages of the paths.
const PATHS: &str = "docs/paths/";
/// The headings of such a page, in this order.
const KINDS: [&str; 4] = ["Tutorial", "How-to", "Reference", "Explanation"];

/// Checks the list and the paths.
pub fn check() -> Result<()> {
    let mut pages = BTreeMap::new();
    collect(&root().join("docs"), &mut pages)?;
    let summary = pages.remove(SUMMARY).with_context(|| format!("{SUMMARY} is missing"))?;
    verdict("pages", &defects(&summary, &pages))
}

/// Reads the Markdown files of a folder and of those in it, by their names from the root of the repository.
fn collect(folder: &Path, pages: &mut BTreeMap<String, String>) -> Result<()> {
    for entry in std::fs::read_dir(folder).with_context(|| folder.display().to_string())? {
        let path = entry?.path();
        if path.is_dir() {
            collect(&path, pages)?;
        } else if path.extension().is_some_and(|extension| extension == "md") {
            let name = path.strip_prefix(root()).unwrap_or(&path).to_string_lossy().replace('\\', "/");
            pages.insert(name, std::fs::read_to_string(&path).with_context(|| path.display().to_string())?);
        }
    }
    Ok(())
}

/// The defects of the list and of the pages of the paths.
fn defects(summary: &str, pages: &BTreeMap<String, String>) -> Vec<String> {
    let mut count: BTreeMap<&str, usize> = pages.keys().map(|page| (page.as_str(), 0)).collect();
    let listed: Vec<String> = listed(summary).collect();
    for page in &listed {
        if let Some(count) = count.get_mut(page.as_str()) {
            *count += 1;
        }
    }
    let wrong = count.iter().filter_map(|(page, count)| match count {
        0 => Some(format!("{page} is not in {SUMMARY}: add a line for it")),
        1 => None,
        count => Some(format!("{page} is in {SUMMARY} {count} times: keep one line")),
    });
    let of_paths = pages.iter().filter(|(name, _)| name.starts_with(PATHS));
    wrong.chain(of_paths.filter_map(|(name, text)| path_defect(name, text))).collect()
}

/// The pages of the list that are in `docs`, from the root of the repository.
fn listed(summary: &str) -> impl Iterator<Item = String> {
    let links = summary.split("](").skip(1).filter_map(|rest| rest.split_once(')'));
    links.map(|(target, _)| target).filter(|target| !target.starts_with("../")).map(|target| format!("docs/{target}"))
}

/// The defect of the page of a path, if it has one.
fn path_defect(name: &str, text: &str) -> Option<String> {
    let (kinds, links): (Vec<&str>, Vec<bool>) =
        text.split("\n## ").skip(1).map(|part| (part.lines().next().unwrap_or("").trim(), part.contains("]("))).unzip();
    if kinds != KINDS {
        return Some(format!("{name} needs the headings {}; it has {}", KINDS.join(", "), kinds.join(", ")));
    }
    let (kind, _) = kinds.iter().zip(links).find(|(_, has_link)| !has_link)?;
    Some(format!("{name}: {kind} has no link"))
}

#[cfg(test)]
mod tests {
    use super::*;

    const PATH: &str = "# A\n\n## Tutorial\n[a](../a.md)\n\n## How-to\n[a](../a.md)\n\n## Reference\n[a](../a.md)\n\n\
                        ## Explanation\n[a](../a.md)\n";

    fn found(summary: &str, path: &str) -> Vec<String> {
        let pages = [("docs/a.md", "# A\n"), ("docs/paths/b.md", path)];
        defects(summary, &pages.map(|(name, text)| (name.to_owned(), text.to_owned())).into())
    }

    #[test]
    fn a_page_is_listed_once() {
        assert_eq!(found("- [a](a.md)\n  - [b](paths/b.md)\n[c](../README.md)\n", PATH), Vec::<String>::new());
        assert_eq!(found("- [b](paths/b.md)\n", PATH), ["docs/a.md is not in docs/SUMMARY.md: add a line for it"]);
        assert_eq!(
            found("- [a](a.md)\n- [a](a.md)\n- [b](paths/b.md)\n", PATH),
            ["docs/a.md is in docs/SUMMARY.md 2 times: keep one line"]
        );
    }

    #[test]
    fn a_path_has_four_kinds_of_pages() {
        let summary = "- [a](a.md)\n- [b](paths/b.md)\n";
        let without = PATH.replace("## How-to\n[a](../a.md)", "## How-to\nnothing");
        assert_eq!(found(summary, &without), ["docs/paths/b.md: How-to has no link"]);
        assert_eq!(
            found(summary, "# A\n\n## Tutorial\n[a](../a.md)\n"),
            ["docs/paths/b.md needs the headings Tutorial, How-to, Reference, Explanation; it has Tutorial"]
        );
    }
}
