//! The documents that may be cited, and their sections.
//!
//! The tables of `docs/spec/README.md` with the heading "Cited as" list their names. A section is
//! an anchor: `<a id="2.4"></a>`. Of a document without a link in its row, only the name is known.

use crate::Source;
use std::collections::BTreeSet;

/// A document, by all its names.
#[derive(Debug)]
pub struct Document {
    pub names: Vec<String>,
    /// The sections in the order of the document. Empty if only the name is known.
    pub sections: Vec<Section>,
}

/// A section of a document.
#[derive(Debug)]
pub struct Section {
    /// `2.4`, or `A` for an appendix.
    pub id: String,
    /// The numbers of its lists and of its tables that number their rows.
    pub points: BTreeSet<u32>,
}

/// Reads the tables of the README in `folder`, and the documents that they link to from `sources`.
pub fn read(folder: &str, sources: &[Source]) -> Vec<Document> {
    let readme = sources.iter().find(|source| source.path == format!("{folder}/README.md"));
    let rows = readme.map(|readme| rows(&readme.text)).unwrap_or_default();
    let document = |(names, link): (Vec<String>, Option<String>)| {
        let pages = link.iter().flat_map(|link| pages(&format!("{folder}/{link}"), sources));
        Document { names, sections: pages.flat_map(|page| sections(&page.text)).collect() }
    };
    rows.into_iter().map(document).collect()
}

/// The names and the link of each row of the tables with the heading "Cited as".
fn rows(readme: &str) -> Vec<(Vec<String>, Option<String>)> {
    let mut inside = false;
    let mut found = Vec::new();
    for line in readme.lines() {
        inside = line.starts_with("| Cited as |") || inside && line.starts_with('|');
        let cell = line.split('|').nth(1).unwrap_or("");
        let names: Vec<String> = cell.split('`').skip(1).step_by(2).map(str::to_owned).collect();
        if inside && !names.is_empty() {
            let link = line.split_once("](").and_then(|(_, rest)| rest.split_once(')'));
            found.push((names, link.map(|(link, _)| link.to_owned())));
        }
    }
    found
}

/// The files of a document: the linked file; or, if that is a README, all files beside it in the order of their names.
fn pages<'s>(path: &str, sources: &'s [Source]) -> Vec<&'s Source> {
    let within = path.strip_suffix("README.md");
    let belongs = |page: &str| within.map_or(page == path, |folder| page.starts_with(folder));
    let mut pages: Vec<&Source> = sources.iter().filter(|source| belongs(&source.path)).collect();
    pages.sort_by_key(|source| &source.path);
    pages
}

/// The sections of a file, with the points of their lists and tables.
fn sections(markdown: &str) -> Vec<Section> {
    let mut sections: Vec<Section> = Vec::new();
    let mut numbered = false;
    for line in markdown.lines() {
        let anchor = line.split_once("<a id=\"").and_then(|(_, rest)| rest.split_once('"'));
        if let Some((id, _)) = anchor.filter(|(id, _)| is_section(id)) {
            sections.push(Section { id: id.to_owned(), points: BTreeSet::new() });
        }
        numbered = line.starts_with("| # |") || numbered && line.starts_with('|');
        if let Some(section) = sections.last_mut() {
            section.points.extend(point(line, numbered));
        }
    }
    sections
}

/// Whether an anchor is a section: `2.4`, or one capital letter.
fn is_section(id: &str) -> bool {
    let numbers = id.split('.').all(|part| !part.is_empty() && part.bytes().all(|byte| byte.is_ascii_digit()));
    numbers || id.len() == 1 && id.bytes().all(|byte| byte.is_ascii_uppercase())
}

/// The number of an entry of a list (`36. text`) or of a table that numbers its rows (`| 36 | text`).
fn point(line: &str, numbered: bool) -> Option<u32> {
    if !numbered {
        return line.split_once(". ")?.0.parse().ok();
    }
    let cell = line.split('|').nth(1)?.trim();
    cell.rsplit_once('>').map_or(cell, |(_, number)| number).parse().ok()
}
