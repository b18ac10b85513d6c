//! The book of `docs/`: every page is in `docs/SUMMARY.md` once. Of `docs/decisions/` only its README, which links to the others.
//!
//! `ci/book.py` builds the book.

use crate::{files, root, verdict};
use anyhow::{Context, Result};

/// The list of the pages.
const SUMMARY: &str = "docs/SUMMARY.md";

/// Checks the list.
pub fn check() -> Result<()> {
    let pages = files(&root().join("docs"), "md")?.into_iter().map(|(path, _)| path);
    let names = pages.filter_map(|path| Some(path.strip_prefix(root()).ok()?.to_string_lossy().into_owned()));
    let summary = std::fs::read_to_string(root().join(SUMMARY)).context(SUMMARY)?;
    verdict("pages", &defects(&summary, names))
}

/// The defects of the list.
fn defects(summary: &str, pages: impl Iterator<Item = String>) -> Vec<String> {
    let listed: Vec<String> = listed(summary).collect();
    let is_optional = |page: &str| page.starts_with("docs/decisions/") && !page.ends_with("/README.md");
    let wrong = pages.filter_map(|page| match listed.iter().filter(|listed| **listed == page).count() {
        0 if page != SUMMARY && !is_optional(&page) => Some(format!("{page} is not in {SUMMARY}: add a line for it")),
        0 | 1 => None,
        count => Some(format!("{page} is in {SUMMARY} {count} times: keep one line")),
    });
    wrong.collect()
}

/// The pages of the list that are in `docs`, from the root of the repository.
fn listed(summary: &str) -> impl Iterator<Item = String> {
    let links = summary.split("](").skip(1).filter_map(|rest| rest.split_once(')'));
    links.map(|(target, _)| target).filter(|target| !target.starts_with("../")).map(|target| format!("docs/{target}"))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn found(summary: &str) -> Vec<String> {
        let pages = ["docs/a.md", "docs/paths/b.md", "docs/decisions/1-c.md", "docs/decisions/README.md"];
        defects(summary, pages.map(str::to_owned).into_iter())
    }

    #[test]
    fn a_page_is_listed_once() {
        let rest = "  - [b](paths/b.md)\n[c](../README.md)\n[d](decisions/README.md)\n";
        assert_eq!(found(&format!("- [a](a.md)\n{rest}")), [""; 0]);
        assert_eq!(found(rest), ["docs/a.md is not in docs/SUMMARY.md: add a line for it"]);
        assert_eq!(
            found(&format!("- [a](a.md)\n- [a](a.md)\n{rest}")),
            ["docs/a.md is in docs/SUMMARY.md 2 times: keep one line"]
        );
    }
}
