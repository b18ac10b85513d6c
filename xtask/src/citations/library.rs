//! The documents that may be cited, and their sections.
//!
//! The tables of `docs/spec/README.md` with the heading "Cited as" list their names. A section is
//! an anchor: `<a id="2.4"></a>`. Of a document without a link in its row, only the name is known.

use super::text::Source;
use std::collections::BTreeSet;

/// All documents that may be cited.
#[derive(Debug, Default)]
pub struct Library {
    documents: Vec<Document>,
}

/// A document, by all its names.
#[derive(Debug)]
pub struct Document {
    names: Vec<String>,
    /// The sections in the order of the document. Empty if only the name is known.
    pub sections: Vec<Section>,
    /// Whether this is a document of this project, not a manual of a vendor.
    pub ours: bool,
}

/// A section of a document.
#[derive(Debug, Default, PartialEq, Eq)]
pub struct Section {
    /// `2.4`, or `A` for an appendix.
    pub id: String,
    /// The heading after the anchor.
    pub title: String,
    /// The numbers of its lists and of its tables that number their rows.
    pub points: BTreeSet<u32>,
    /// Whether it has text outside its subsections.
    pub has_text: bool,
}

impl Library {
    /// Reads the tables of the README in `folder`, and the documents that they link to from `sources`.
    pub fn read(folder: &str, sources: &[Source]) -> Self {
        let readme = sources.iter().find(|source| source.path == format!("{folder}/README.md"));
        let rows = readme.map(|readme| rows(&readme.text)).unwrap_or_default();
        let documents = rows.into_iter().map(|(names, link)| {
            let pages = link.iter().flat_map(|link| pages(folder, link, sources));
            let ours = link.as_ref().is_some_and(|link| !link.starts_with("manuals/"));
            Document { names, sections: pages.flat_map(|page| sections(&page.text)).collect(), ours }
        });
        Self { documents: documents.collect() }
    }

    /// All documents.
    pub fn documents(&self) -> impl Iterator<Item = &Document> {
        self.documents.iter()
    }

    /// The document with this name.
    pub fn named(&self, name: &str) -> Option<&Document> {
        self.documents.iter().find(|document| document.names.iter().any(|known| known == name))
    }

    /// The document whose name begins `text`, and the name; the longest name wins.
    pub fn at_start_of<'t>(&self, text: &'t str) -> Option<(&Document, &'t str)> {
        let named = self.documents.iter().flat_map(|document| document.names.iter().map(move |name| (document, name)));
        let fitting = named.filter(|(_, name)| begins_with_word(text, name));
        let (document, name) = fitting.max_by_key(|(_, name)| name.len())?;
        Some((document, text.get(..name.len())?))
    }
}

impl Document {
    /// The first of its names.
    pub fn name(&self) -> &str {
        self.names.first().map_or("", String::as_str)
    }

    /// The section with this number, and its place in the document.
    pub fn section(&self, id: &str) -> Option<(usize, &Section)> {
        self.sections.iter().enumerate().find(|(_, section)| section.id == id)
    }
}

/// Whether `text` begins with `name` and the name ends there.
fn begins_with_word(text: &str, name: &str) -> bool {
    let Some(rest) = text.strip_prefix(name) else { return false };
    let mut next = rest.chars();
    match next.next() {
        Some('-') => !next.next().is_some_and(char::is_alphanumeric),
        Some(char) => !char.is_alphanumeric() && char != '_',
        None => true,
    }
}

/// The names and the link of each row of the tables with the heading "Cited as".
fn rows(readme: &str) -> Vec<(Vec<String>, Option<String>)> {
    let mut inside = false;
    let mut found = Vec::new();
    for line in readme.lines() {
        inside = line.starts_with("| Cited as |") || inside && line.starts_with('|');
        let names: Vec<String> = between(line.split('|').nth(1).unwrap_or(""), '`').map(str::to_owned).collect();
        if inside && !names.is_empty() {
            let link = line.split_once("](").and_then(|(_, rest)| rest.split_once(')'));
            found.push((names, link.map(|(link, _)| link.to_owned())));
        }
    }
    found
}

/// The texts between pairs of a sign.
fn between(text: &str, sign: char) -> impl Iterator<Item = &str> {
    text.split(sign).skip(1).step_by(2)
}

/// The files of a document: the linked file; or, if that is a README, all files beside it in the order of their names.
fn pages<'s>(folder: &str, link: &str, sources: &'s [Source]) -> Vec<&'s Source> {
    let path = format!("{folder}/{link}");
    let Some(within) = path.strip_suffix("README.md") else {
        return sources.iter().filter(|source| source.path == path).collect();
    };
    let mut pages: Vec<&Source> = sources.iter().filter(|source| source.path.starts_with(within)).collect();
    pages.sort_by_key(|source| &source.path);
    pages
}

/// The sections of a file, with the points of their lists and tables.
fn sections(markdown: &str) -> Vec<Section> {
    let mut sections: Vec<Section> = Vec::new();
    let mut numbered = false;
    for line in markdown.lines() {
        if let Some(id) = anchor(line).filter(|id| is_section(id)) {
            sections.push(Section { id: id.to_owned(), ..Section::default() });
        }
        numbered = line.starts_with("| # |") || numbered && line.starts_with('|');
        let Some(section) = sections.last_mut() else { continue };
        if section.title.is_empty() && line.starts_with('#') {
            section.title = line.trim_start_matches('#').trim().to_owned();
        } else if !line.is_empty() && !line.starts_with("<a id=") && !line.starts_with('#') {
            section.has_text = true;
        }
        section.points.extend(point(line, numbered));
    }
    sections
}

/// The id of the first anchor of a line.
fn anchor(line: &str) -> Option<&str> {
    Some(line.split_once("<a id=\"")?.1.split_once('"')?.0)
}

/// Whether an anchor is a section: `2.4`, or one capital letter.
fn is_section(id: &str) -> bool {
    let numbers = id.split('.').all(|part| !part.is_empty() && part.bytes().all(|byte| byte.is_ascii_digit()));
    numbers || id.len() == 1 && id.bytes().all(|byte| byte.is_ascii_uppercase())
}

/// The number of an entry of a list (`36. text`) or of a table that numbers its rows (`| 36 | text`).
fn point(line: &str, numbered: bool) -> Option<u32> {
    let digits = |text: &str| text.parse().ok();
    if !numbered {
        return digits(line.split_once(". ")?.0);
    }
    let cell = line.split('|').nth(1)?.trim();
    digits(cell.rsplit_once('>').map_or(cell, |(_, number)| number))
}

#[cfg(test)]
pub mod tests {
    use super::*;

    /// A specification with a document in two files, a list of errata and two manuals.
    pub fn made_up() -> Vec<Source> {
        let file = |path: &str, text: &str| Source { path: path.to_owned(), text: text.to_owned() };
        vec![
            file(
                "docs/spec/README.md",
                "| Form | Meaning |\n|---|---|\n| `bus-wire 1.1` | an example |\n\n\
                 | Cited as | Document |\n|---|---|\n| `bus-wire` | [The wire](bus-wire/README.md) |\n\
                 | `errata-one` | [Errata](errata-one.md) |\n\n\
                 | Cited as | Manual | Sections |\n|---|---|---|\n\
                 | `tira01e1`, `tira01e1-a` | One | [one](manuals/one.md) |\n| `BG 12` | Two | |\n",
            ),
            file("docs/spec/bus-wire/README.md", "# The wire\n"),
            file(
                "docs/spec/bus-wire/1.md",
                "<a id=\"1\"></a>\n# 1 Layer\n\n<a id=\"1.1\"></a>\n## 1.1 Frames\n\nText.\n\n\
                 <a id=\"1.2\"></a>\n## 1.2 Rules\n\n1. one\n2. two\n\n<a id=\"1.2.1\"></a>\n### 1.2.1 More\n\nText.\n",
            ),
            file(
                "docs/spec/bus-wire/2.md",
                "<a id=\"2\"></a>\n# 2 Doubt\n\n| # | What |\n|---|---|\n| <a id=\"p7\"></a>7 | this |\n\n| Byte |\n|---|\n| 9 |\n",
            ),
            file(
                "docs/spec/errata-one.md",
                "<a id=\"1\"></a>\n### 1. A\n\nText.\n\n<a id=\"2\"></a>\n### 2. B\n\nText.\n\n<a id=\"3\"></a>\n### 3. C\n\nText.\n",
            ),
            file("docs/spec/manuals/one.md", "| <a id=\"3.2.1\"></a>3.2.1 | Row |\n| <a id=\"A\"></a>App. A | End |\n"),
        ]
    }

    /// The documents of [`made_up`].
    pub fn library() -> Library {
        Library::read("docs/spec", &made_up())
    }

    #[test]
    fn the_readme_names_the_documents_and_links_to_their_sections() {
        let library = library();
        let names: Vec<&str> = library.documents().map(Document::name).collect();
        assert_eq!(names, ["bus-wire", "errata-one", "tira01e1", "BG 12"]);
        let wire =
            library.named("bus-wire").map(|wire| wire.sections.iter().map(|section| section.id.as_str()).collect());
        assert_eq!(wire, Some(vec!["1", "1.1", "1.2", "1.2.1", "2"]));
        assert!(library.named("tira01e1-a").is_some_and(|manual| !manual.ours && manual.section("A").is_some()));
        assert!(library.named("BG 12").is_some_and(|manual| manual.sections.is_empty()));
    }

    #[test]
    fn lists_and_numbered_tables_have_points_and_other_tables_do_not() {
        let library = library();
        let points = |id| Some(library.named("bus-wire")?.section(id)?.1.points.iter().copied().collect::<Vec<_>>());
        assert_eq!(points("1.2"), Some(vec![1, 2]));
        assert_eq!(points("2"), Some(vec![7]));
    }

    #[test]
    fn a_heading_above_subsections_has_no_text_of_its_own() {
        let library = library();
        let has_text =
            |id| library.named("bus-wire").and_then(|wire| wire.section(id)).map(|(_, section)| section.has_text);
        assert_eq!(has_text("1"), Some(false));
        assert_eq!(has_text("1.1"), Some(true));
    }

    #[test]
    fn the_longest_name_wins_and_a_longer_word_is_none() {
        let library = library();
        let name = |text| library.at_start_of(text).map(|(_, name)| name);
        assert_eq!(name("tira01e1-a 3.2.1"), Some("tira01e1-a"));
        assert_eq!(name("tira01e1 3.2.1"), Some("tira01e1"));
        assert_eq!(name("tira01e12 3.2.1"), None);
        assert_eq!(name("errata-one-more 1"), None);
    }
}
