//! Checks that every citation leads to a section.
//!
//! `docs/spec/README.md` lists the documents and the forms of a citation. All tracked files are read: comments, strings
//! and Markdown. Three forms do not name their document, because the folder gives it: numbers in brackets and sections
//! of three parts in the comments of a device, and the section in a row of its tables. Links between Markdown files are
//! checked too.

mod grammar;
mod library;
mod links;
mod nameless;
mod text;

use crate::root;
use anyhow::{Context, Result, bail};
use grammar::Place;
use library::{Document, Library};
use std::collections::{BTreeMap, BTreeSet};
use std::process::Command;
use text::{Passage, Source};

/// The folder of the documents.
const FOLDER: &str = "docs/spec";

/// The folder of this check: its tests cite documents that do not exist.
const OWN: &str = "xtask/src/citations/";

/// The page whose tables have sections of the wire reference in their first column.
const CONFORMANCE: &str = "docs/conformance.md";

/// The folders of devices, with the manual and the errata that a citation without a name means there.
const DEVICES: [(&str, &str, &str); 5] = [
    ("bcg450", "tira41d1", "errata-bpg-bcg-tpg"),
    ("img400", "BG 5530", "errata-pxg55x-img400"),
    ("pxg55x", "tira56e1", "errata-pxg55x-img400"),
    ("tpg", "i9973ber/a", "errata-bpg-bcg-tpg"),
    ("xpg400", "tira36e1", "errata-bpg-bcg-tpg"),
];

/// Checks all citations and links.
pub fn check() -> Result<()> {
    let findings = findings()?;
    for defect in &findings.defects {
        println!("citations: {defect}");
    }
    if !findings.defects.is_empty() {
        bail!("citations: {} defects", findings.defects.len());
    }
    let (uncited, all) = findings.uncited();
    println!("citations: ok, {}; no test cites {} of {all} sections", findings.totals(), uncited.len());
    Ok(())
}

/// Lists the sections that no test cites.
pub fn uncited() -> Result<()> {
    let findings = findings()?;
    let (uncited, all) = findings.uncited();
    for section in &uncited {
        println!("{section}");
    }
    println!("no test cites {} of {all} sections", uncited.len());
    Ok(())
}

/// Reads all tracked files.
fn findings() -> Result<Findings> {
    let tracked = Command::new("git").args(["ls-files", "-z"]).current_dir(root()).output().context("git ls-files")?;
    let files: BTreeSet<String> = String::from_utf8_lossy(&tracked.stdout)
        .split('\0')
        .filter(|path| !path.is_empty())
        .map(str::to_owned)
        .collect();
    let read =
        |path: &String| Some(Source { path: path.clone(), text: std::fs::read_to_string(root().join(path)).ok()? });
    let sources: Vec<Source> = files.iter().filter(|path| !path.starts_with(OWN)).filter_map(read).collect();
    Ok(examine(&sources, &files))
}

/// The result of the check.
#[derive(Debug, Default)]
struct Findings {
    /// Citations and links without a target.
    defects: Vec<String>,
    /// The number of citations of each form.
    forms: BTreeMap<&'static str, usize>,
    /// The sections of the specification, and whether a test cites them.
    sections: Vec<(String, bool)>,
}

impl Findings {
    fn count(&mut self, form: &'static str, number: usize) {
        *self.forms.entry(form).or_default() += number;
    }

    /// The number of citations of each form, as text.
    fn totals(&self) -> String {
        self.forms.iter().map(|(form, count)| format!("{count} {form}")).collect::<Vec<_>>().join(", ")
    }

    /// The sections that no test cites, and the number of all.
    fn uncited(&self) -> (Vec<&str>, usize) {
        let uncited = self.sections.iter().filter(|(_, cited)| !cited).map(|(section, _)| section.as_str());
        (uncited.collect(), self.sections.len())
    }
}

/// Examines all files.
fn examine(sources: &[Source], files: &BTreeSet<String>) -> Findings {
    let library = Library::read(FOLDER, sources);
    let mut examination = Examination { library: &library, findings: Findings::default(), cited: BTreeSet::new() };
    for source in sources {
        let device = device(&source.path);
        if source.path == CONFORMANCE {
            examination.conformance(source);
        }
        for passage in source.passages() {
            examination.passage(source, &passage, device);
        }
    }
    let Examination { mut findings, cited, .. } = examination;
    let (broken, links) = links::check(sources, files);
    findings.count("links", links);
    findings
        .defects
        .extend(broken.into_iter().map(|broken| format!("{}:{}: {}", broken.path, broken.line, broken.what)));
    findings.sections = sections(&library, &cited);
    if findings.sections.is_empty() {
        findings.defects.push(format!("{FOLDER}/README.md names no document with sections"));
    }
    findings
}

/// The sections of the specification that have text, and whether they are cited.
fn sections(library: &Library, cited: &BTreeSet<(String, String)>) -> Vec<(String, bool)> {
    let ours = library.documents().filter(|document| document.ours);
    let sections = ours.flat_map(|document| document.sections.iter().map(move |section| (document.name(), section)));
    let speaking = sections.filter(|(_, section)| section.has_text);
    let entry = |(document, section): (&str, &library::Section)| {
        let title = section.title.trim_start_matches(&section.id).trim_start_matches(['.', ' ']);
        let name = format!("{document} {} {title}", section.id);
        (name.trim_end().to_owned(), cited.contains(&(document.to_owned(), section.id.clone())))
    };
    speaking.map(entry).collect()
}

/// The device that a file is about, by its folder or its name.
fn device(path: &str) -> Option<(&'static str, &'static str)> {
    let inside = ["crates/devices/src/", "crates/devices/tests/"].iter().find_map(|folder| path.strip_prefix(folder));
    let page = path.strip_prefix("docs/devices/review-").and_then(|page| page.strip_suffix(".md"));
    let name = inside.and_then(|path| path.split_once('/')).map(|(folder, _)| folder).or(page)?;
    DEVICES.iter().find(|(folder, ..)| *folder == name).map(|(_, manual, errata)| (*manual, *errata))
}

/// The state of an examination.
struct Examination<'l> {
    library: &'l Library,
    findings: Findings,
    /// Documents and sections that tests cite.
    cited: BTreeSet<(String, String)>,
}

/// The place of a citation.
struct Spot<'p> {
    path: &'p str,
    line: usize,
    test: bool,
}

impl Examination<'_> {
    fn passage(&mut self, source: &Source, passage: &Passage, device: Option<(&str, &str)>) {
        let spot = |at| Spot { path: &source.path, line: passage.line(at), test: passage.test };
        let mut rest = passage.text.clone();
        for citation in grammar::citations(&passage.text, self.library) {
            match citation.document {
                Ok(document) => self.places(&spot(citation.at), document, &citation.places, form(document)),
                Err(name) => self.defect(&spot(citation.at), &format!("{FOLDER}/README.md knows no {name}")),
            }
            blank(&mut rest, citation.at, citation.end);
        }
        for at in nameless::points(&rest) {
            self.defect(&spot(at), "a point of a section without the name of its document");
        }
        let Some((manual, errata)) = device else {
            if let Some(section) = nameless::first(&rest).filter(|_| passage.prose && source.is_rust()) {
                self.defect(&spot(0), &format!("section {section} without the name of its document"));
            }
            return;
        };
        if passage.prose {
            for (at, place) in nameless::bracketed(&rest) {
                self.listed(&spot(at), errata, vec![place], "errata in brackets");
            }
            for (at, section) in nameless::bare(&rest) {
                self.listed(&spot(at), manual, vec![Place::Section(section)], "sections without a name");
            }
        } else if let Some((at, section)) = nameless::row(&passage.text) {
            self.listed(&spot(at), manual, vec![Place::Section(section)], "rows of tables");
        }
    }

    /// Checks places of a document whose name is not beside them.
    fn listed(&mut self, spot: &Spot, name: &str, places: Vec<Place>, form: &'static str) {
        if let Some(document) = self.library.named(name) {
            self.places(spot, document, &places, form);
        }
    }

    fn places(&mut self, spot: &Spot, document: &Document, places: &[Place], form: &'static str) {
        if !places.is_empty() {
            self.findings.count(form, places.len());
        }
        if document.sections.is_empty() {
            return;
        }
        for place in places {
            match resolve(document, place) {
                Ok(sections) if spot.test => {
                    let name = document.name().to_owned();
                    self.cited.extend(sections.into_iter().map(|section| (name.clone(), section)));
                }
                Ok(_) => {}
                Err(missing) => self.defect(spot, &format!("{} has no {missing}", document.name())),
            }
        }
    }

    fn defect(&mut self, spot: &Spot, what: &str) {
        self.findings.defects.push(format!("{}:{}: {what}", spot.path, spot.line));
    }

    /// The first columns of the tables of [`CONFORMANCE`]: `3.2, 8 to 11` are transitions of a section, and a column of
    /// points has those of section 10.
    fn conformance(&mut self, source: &Source) {
        let mut heading = "";
        for (line, row) in (1..).zip(source.text.lines()) {
            let cell = row.strip_prefix("| ").and_then(|row| row.split_once(" |")).map_or("", |(cell, _)| cell);
            if !cell.starts_with(|char: char| char.is_ascii_digit()) {
                heading = if cell.is_empty() && row.starts_with('|') { heading } else { cell };
                continue;
            }
            let places = match heading {
                "Section" => grammar::list(&cell.replacen("3.2, ", "3.2, transitions ", 1), 0).0,
                "Point" => grammar::list(&format!("10, points {cell}"), 0).0,
                _ => continue,
            };
            self.listed(&Spot { path: &source.path, line, test: false }, "profibus-wire", places, "sections in tables");
        }
    }
}

/// The form under which citations of a document are counted.
fn form(document: &Document) -> &'static str {
    match (document.ours, document.sections.is_empty(), document.name().starts_with("errata-")) {
        (true, _, true) => "errata",
        (true, _, false) => "sections of the reference",
        (false, false, _) => "sections of manuals",
        (false, true, _) => "sections of manuals that are not listed",
    }
}

/// The sections that a place names, or the name of a part that does not exist in the document.
fn resolve(document: &Document, place: &Place) -> Result<Vec<String>, String> {
    let find = |id: &str| document.section(id).ok_or_else(|| id.to_owned());
    match place {
        Place::Section(id) => find(id).map(|(_, section)| vec![section.id.clone()]),
        Place::Range(from, to) => {
            let ((first, _), (last, _)) = (find(from)?, find(to)?);
            let between = document.sections.get(first..=last).filter(|between| between.len() > 1);
            let between = between.ok_or_else(|| format!("range from {from} to {to}"))?;
            Ok(between.iter().map(|section| section.id.clone()).collect())
        }
        Place::Point(None, number) => Err(format!("point {number} outside a section")),
        Place::Point(Some(id), number) => {
            let section = find(id)?.1;
            let missing = || format!("point {number} in {id}");
            section.points.contains(number).then(|| vec![id.clone()]).ok_or_else(missing)
        }
    }
}

/// Replaces a part of a text by blanks, so that it is not read again.
fn blank(text: &mut String, from: usize, to: usize) {
    if text.get(from..to).is_some() {
        text.replace_range(from..to, &" ".repeat(to - from));
    }
}

#[cfg(test)]
mod tests {
    use super::library::tests::made_up;
    use super::*;

    /// The defects of the documents of a test with one more file.
    fn defects(path: &str, text: &str) -> Vec<String> {
        let (mut sources, files) = (made_up(), BTreeSet::new());
        sources.push(Source { path: path.to_owned(), text: text.to_owned() });
        let files: BTreeSet<String> = sources.iter().map(|source| source.path.clone()).chain(files).collect();
        examine(&sources, &files).defects
    }

    /// The one defect of a comment in a Rust file.
    fn defect(text: &str) -> String {
        let mut found = defects("src/a.rs", text);
        assert_eq!(found.len(), 1, "{text}: {found:?}");
        found.remove(0)
    }

    #[test]
    fn what_is_there_is_no_defect() {
        let text = "/// bus-wire 1.1 and 1.2, point 2; bus-wire 2, point 7. errata-one 1 to\n/// 3. tira01e1 3.2.1, Appendix A. BG 12 9.9.9.\n";
        assert_eq!(defects("src/a.rs", text), Vec::<String>::new());
    }

    #[test]
    fn each_form_is_red_when_it_leads_nowhere() {
        assert_eq!(defect("// bus-wire 1.3"), "src/a.rs:1: bus-wire has no 1.3");
        assert_eq!(defect("// bus-wire 1.1, 1.3 and 1.2"), "src/a.rs:1: bus-wire has no 1.3");
        assert_eq!(defect("// bus-wire 1.1 to 1.3"), "src/a.rs:1: bus-wire has no 1.3");
        assert_eq!(defect("// bus-wire 1.2 to 1.1"), "src/a.rs:1: bus-wire has no range from 1.2 to 1.1");
        assert_eq!(defect("// bus-wire 1.2, point 3"), "src/a.rs:1: bus-wire has no point 3 in 1.2");
        assert_eq!(defect("// bus-wire 2, point 9"), "src/a.rs:1: bus-wire has no point 9 in 2");
        assert_eq!(defect("// errata-one 4"), "src/a.rs:1: errata-one has no 4");
        assert_eq!(defect("// tira01e1 3.2.2"), "src/a.rs:1: tira01e1 has no 3.2.2");
        assert_eq!(defect("// tira01e1 App. B"), "src/a.rs:1: tira01e1 has no B");
        assert_eq!(defect("// errata-two 1"), "src/a.rs:1: docs/spec/README.md knows no errata-two");
        assert_eq!(
            defect("// section 2, point 7"),
            "src/a.rs:1: a point of a section without the name of its document"
        );
        assert_eq!(defect("/// 1.1: a rule"), "src/a.rs:1: section 1.1 without the name of its document");
        assert_eq!(defect("// (1.2, rule 2)"), "src/a.rs:1: a point of a section without the name of its document");
        assert_eq!(
            defect("// point 7 of section 2"),
            "src/a.rs:1: a point of a section without the name of its document"
        );
    }

    #[test]
    fn a_citation_over_two_lines_is_found_at_its_name() {
        assert_eq!(defect("x\n    /// text bus-wire\n    /// 1.3"), "src/a.rs:2: bus-wire has no 1.3");
        assert_eq!(defect("a: \"errata-one 1 to 2, \\\n   4\""), "src/a.rs:1: errata-one has no 4");
    }

    #[test]
    fn other_files_and_links_are_read() {
        assert_eq!(defects("a.md", "bus-wire 1.3 [x](none.md)\n").len(), 2);
        assert_eq!(defects("a.lua", "-- bus-wire 1.3\n").len(), 1);
        assert_eq!(defects("docs/spec/bus-wire/1.md", "[3](2.md#3)\n").len(), 1);
    }

    #[test]
    fn a_device_is_known_by_its_folder() {
        assert_eq!(device("crates/devices/src/bcg450/table.rs"), Some(("tira41d1", "errata-bpg-bcg-tpg")));
        assert_eq!(device("crates/devices/tests/img400/rows.rs"), Some(("BG 5530", "errata-pxg55x-img400")));
        assert_eq!(device("docs/devices/review-tpg.md"), Some(("i9973ber/a", "errata-bpg-bcg-tpg")));
        assert_eq!(device("crates/devices/src/model/block.rs"), None);
    }

    #[test]
    fn the_tables_of_the_page_about_conformance_have_sections_and_points() {
        let text = "| Section | What |\n|---|---|\n| 1.1 | a |\n| 3.2, 1 to 2 | b |\n| 1.9 | c |\n\n\
                    | Point | What |\n|---|---|\n| 7, 8 | d |\n\n| What | Here |\n|---|---|\n| 9 | e |\n";
        let page = Source { path: CONFORMANCE.to_owned(), text: text.to_owned() };
        let wire = "<a id=\"1.1\"></a>\n<a id=\"3.2\"></a>\n1. one\n3. three\n<a id=\"10\"></a>\n7. seven\n";
        let sources = [
            Source {
                path: "docs/spec/README.md".to_owned(),
                text: "| Cited as |\n|---|\n| `profibus-wire` | [w](w.md) |\n".to_owned(),
            },
            Source { path: "docs/spec/w.md".to_owned(), text: wire.to_owned() },
            page,
        ];
        let files = sources.iter().map(|source| source.path.clone()).collect();
        let at = |line: u32, what: &str| format!("{CONFORMANCE}:{line}: profibus-wire has no {what}");
        assert_eq!(examine(&sources, &files).defects, [at(4, "point 2 in 3.2"), at(5, "1.9"), at(9, "point 8 in 10")]);
    }

    #[test]
    fn rows_brackets_and_bare_sections_of_a_device_are_red_when_they_lead_nowhere() {
        let examine = |text: &str| {
            let file = Source { path: "crates/devices/src/xpg400/table.rs".to_owned(), text: text.to_owned() };
            let all: Vec<Source> = real_names().into_iter().chain([file]).collect();
            let files = all.iter().map(|source| source.path.clone()).collect();
            super::examine(&all, &files).defects
        };
        assert_eq!(examine("17 A \"a\" UINT8 [1_R] N \"3.1.1\"; // (1), 3.1.1"), Vec::<String>::new());
        assert_eq!(examine("17 A \"a\" UINT8 [1_R] N \"3.1.2\";").len(), 1);
        assert_eq!(examine("// (2)").len(), 1);
        assert_eq!(examine("// see 3.1.2").len(), 1);
    }

    /// Documents with the names that [`DEVICES`] has.
    fn real_names() -> Vec<Source> {
        let file = |path: &str, text: &str| Source { path: path.to_owned(), text: text.to_owned() };
        vec![
            file(
                "docs/spec/README.md",
                "| Cited as |\n|---|\n| `errata-bpg-bcg-tpg` | [e](e.md) |\n| `tira36e1` | [m](manuals/m.md) |\n",
            ),
            file("docs/spec/e.md", "<a id=\"1\"></a>\n# 1\n\nText.\n"),
            file("docs/spec/manuals/m.md", "<a id=\"3.1.1\"></a>\n"),
        ]
    }

    #[test]
    fn sections_that_no_test_cites_are_listed() {
        let mut sources = made_up();
        let file = |path: &str, text: &str| Source { path: path.to_owned(), text: text.to_owned() };
        sources.push(file("src/a.rs", "// bus-wire 1.1\n#[cfg(test)]\nmod tests {\n    // errata-one 1 to 2\n}\n"));
        sources.push(file("tests/b.rs", "//! bus-wire 1.2, point 1.\n"));
        let findings = examine(&sources, &BTreeSet::new());
        let (uncited, all) = findings.uncited();
        assert_eq!(uncited, ["bus-wire 1.1 Frames", "bus-wire 1.2.1 More", "bus-wire 2 Doubt", "errata-one 3 C"]);
        assert_eq!(all, 7);
    }
}
