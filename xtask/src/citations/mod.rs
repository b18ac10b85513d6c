//! Checks that every citation leads to a section.
//!
//! `docs/spec/README.md` lists the documents and the forms of a citation. All tracked files are read. A citation that does not
//! name its document, such as the section in a row of a device's table, is not checked.

mod grammar;
mod library;

use crate::{Source, tracked, verdict};
use anyhow::Result;
use grammar::Place;
use library::Document;

/// The folder of the documents.
const FOLDER: &str = "docs/spec";

/// The folder of this check: its tests cite documents that do not exist.
const OWN: &str = "xtask/src/citations/";

/// Checks all tracked files.
pub fn check() -> Result<()> {
    let mut sources = tracked()?;
    sources.retain(|source| !source.path.starts_with(OWN));
    let (count, defects) = examine(&sources);
    verdict(&format!("citations ({count})"), &defects)
}

/// The number of places that are cited, and the defects.
fn examine(sources: &[Source]) -> (usize, Vec<String>) {
    let library = library::read(FOLDER, sources);
    let (mut count, mut defects) = (0, Vec::new());
    if library.iter().all(|document| document.sections.is_empty()) {
        defects.push(format!("{FOLDER}/README.md names no document with sections"));
    }
    for Source { path, text } in sources {
        let (text, lines) = joined(text);
        for citation in grammar::citations(&text, &library) {
            count += citation.places.len();
            let wrong = match &citation.document {
                Ok(document) => citation.places.iter().filter_map(|place| missing(document, place)).collect(),
                Err(name) => vec![format!("{FOLDER}/README.md knows no {name}")],
            };
            let line = lines.partition_point(|begin| *begin <= citation.at);
            defects.extend(wrong.into_iter().map(|what| format!("{path}:{line}: {what}")));
        }
    }
    (count, defects)
}

/// The lines of a file without indentation, comment marks and backticks, joined by blanks; and where each begins. An empty
/// line gives a second blank, which ends a list.
fn joined(text: &str) -> (String, Vec<usize>) {
    const MARKS: [&str; 8] = ["//!", "///", "//", "--", "/*", "<!--", "#", "* "];
    let (mut joined, mut begins) = (String::with_capacity(text.len()), Vec::new());
    for line in text.lines() {
        let line = line.trim();
        let line = MARKS.iter().find_map(|mark| line.strip_prefix(mark)).unwrap_or(line);
        begins.push(joined.len());
        // A string goes on behind a backslash.
        joined.extend(line.trim_end_matches('\\').trim().chars().filter(|char| *char != '`'));
        joined.push(' ');
    }
    (joined, begins)
}

/// The defect of a place that does not exist in the document.
fn missing(document: &Document, place: &Place) -> Option<String> {
    if document.sections.is_empty() {
        return None;
    }
    let find = |id: &str| document.sections.iter().position(|section| section.id == id).ok_or_else(|| id.to_owned());
    let has_point = |id, number| find(id).is_ok_and(|at| document.sections[at].points.contains(number));
    let missing = match place {
        Place::Section(id) => find(id).err(),
        Place::Range(from, to) => match (find(from), find(to)) {
            (Ok(first), Ok(last)) => (first >= last).then(|| format!("range from {from} to {to}")),
            (Err(id), _) | (_, Err(id)) => Some(id),
        },
        Place::Point(id, number) => (!has_point(id, number)).then(|| format!("point {number} in '{id}'")),
    };
    let name = document.names.first().map_or("", String::as_str);
    missing.map(|missing| format!("{name} has no {missing}"))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn file(path: &str, text: &str) -> Source {
        Source { path: path.to_owned(), text: text.to_owned() }
    }

    /// A specification with a document in two files, a list of errata and two manuals.
    fn made_up() -> Vec<Source> {
        vec![
            file(
                "docs/spec/README.md",
                "| Form |\n|---|\n| `bus-wire 1.1` |\n\n| Cited as | Document |\n|---|---|\n\
                 | `bus-wire` | [The wire](bus-wire/README.md) |\n| `errata-one` | [Errata](errata-one.md) |\n\
                 | `tira01e1`, `tira01e1-a` | [one](manuals/one.md) |\n| `BG 12` | |\n",
            ),
            file("docs/spec/bus-wire/README.md", "# The wire\n"),
            file(
                "docs/spec/bus-wire/1.md",
                "<a id=\"1.1\"></a>\n## 1.1 Frames\n<a id=\"1.2\"></a>\n## 1.2 Rules\n\n1. one\n2. two\n",
            ),
            file(
                "docs/spec/bus-wire/2.md",
                "<a id=\"2\"></a>\n# 2 Doubt\n\n| # |\n|---|\n| <a id=\"p7\"></a>7 |\n\n| Byte |\n|---|\n| 9 |\n",
            ),
            file("docs/spec/errata-one.md", "<a id=\"1\"></a>\n### 1. A\n<a id=\"2\"></a>\n<a id=\"3\"></a>\n"),
            file("docs/spec/manuals/one.md", "| <a id=\"3.2.1\"></a>3.2.1 |\n| <a id=\"A\"></a>App. A |\n"),
        ]
    }

    /// The documents of [`made_up`].
    pub fn library() -> Vec<Document> {
        library::read(FOLDER, &made_up())
    }

    /// The defects of the documents of a test with one more file.
    fn defects(path: &str, text: &str) -> Vec<String> {
        let mut sources = made_up();
        sources.push(file(path, text));
        examine(&sources).1
    }

    #[test]
    fn a_place_that_exists_is_no_defect() {
        let text = "/// bus-wire 1.1 and 1.2, point 2; bus-wire 2, point 7. errata-one 1 to\n/// 3. tira01e1-a 3.2.1, Appendix A. BG 12 9.9.9.\n\n4";
        assert_eq!(defects("src/a.rs", text), [""; 0]);
        assert_eq!(examine(&made_up()).0, 1);
    }

    #[test]
    fn a_citation_that_leads_nowhere_is_a_defect() {
        for (text, expected) in [
            ("// bus-wire 1.3", "bus-wire has no 1.3"),
            ("// bus-wire 1.1, 1.3 and 1.2", "bus-wire has no 1.3"),
            ("// bus-wire 1.1 to 1.3", "bus-wire has no 1.3"),
            ("// bus-wire 1.2 to 1.1", "bus-wire has no range from 1.2 to 1.1"),
            ("// bus-wire 1.2, point 3", "bus-wire has no point 3 in '1.2'"),
            ("// bus-wire 2, point 9", "bus-wire has no point 9 in '2'"),
            ("// bus-wire point 9", "bus-wire has no point 9 in ''"),
            ("/// text errata-one\n    /// 4", "errata-one has no 4"),
            ("a: \"errata-one 1 to 2, \\\n   4\"", "errata-one has no 4"),
            ("// tira01e1 3.2.2", "tira01e1 has no 3.2.2"),
            ("// tira01e1 App. B", "tira01e1 has no B"),
            ("// errata-two 1", "docs/spec/README.md knows no errata-two"),
        ] {
            for path in ["src/a.rs", "a.md", "a.lua"] {
                assert_eq!(defects(path, &format!("\n{text}")), [format!("{path}:2: {expected}")]);
            }
        }
    }

    #[test]
    fn a_specification_without_sections_is_a_defect() {
        assert_eq!(examine(&[]).1, ["docs/spec/README.md names no document with sections"]);
    }
}
