//! Links of Markdown files to each other.

use super::text::Source;
use std::collections::{BTreeMap, BTreeSet};

/// A link without a target.
#[derive(Debug, PartialEq, Eq)]
pub struct Broken {
    /// The file with the link.
    pub path: String,
    /// The line, from 1.
    pub line: usize,
    /// The defect, as a sentence.
    pub what: String,
}

/// Checks every relative link in the Markdown files of `sources`; `files` are all files that may be linked. Returns the
/// broken links and the number of all.
pub fn check(sources: &[Source], files: &BTreeSet<String>) -> (Vec<Broken>, usize) {
    let pages = sources.iter().filter(|source| source.is_markdown());
    let anchors: BTreeMap<&str, BTreeSet<String>> =
        pages.clone().map(|page| (page.path.as_str(), anchors(&page.text))).collect();
    let mut count = 0;
    let mut broken = Vec::new();
    for page in pages {
        for (line, target) in links(&page.text) {
            count += 1;
            let wrong = wrong(&page.path, &target, files, &anchors);
            broken.extend(wrong.map(|what| Broken { path: page.path.clone(), line, what }));
        }
    }
    (broken, count)
}

/// The defect of a link, if it has one.
fn wrong(
    from: &str,
    target: &str,
    files: &BTreeSet<String>,
    anchors: &BTreeMap<&str, BTreeSet<String>>,
) -> Option<String> {
    let (path, anchor) = target.split_once('#').map_or((target, None), |(path, anchor)| (path, Some(anchor)));
    let path = if path.is_empty() { Some(from.to_owned()) } else { resolve(from, path) };
    let folder = |path: &str| path.is_empty() || files.iter().any(|file| file.starts_with(&format!("{path}/")));
    let Some(path) = path.filter(|path| files.contains(path) || folder(path)) else {
        return Some(format!("the link {target} leads to no file"));
    };
    let known = anchors.get(path.as_str())?;
    let missing = anchor.filter(|anchor| !known.contains(*anchor))?;
    Some(format!("the link {target} leads to no anchor: {path} has no {missing}"))
}

/// A path from the root of the repository. `None` if it leaves the repository.
fn resolve(from: &str, path: &str) -> Option<String> {
    let mut parts: Vec<&str> = from.split('/').collect();
    parts.pop();
    for part in path.split('/') {
        match part {
            "." | "" => {}
            ".." => drop(parts.pop()?),
            part => parts.push(part),
        }
    }
    Some(parts.join("/"))
}

/// The lines outside fences, with their numbers.
fn outside_fences(markdown: &str) -> impl Iterator<Item = (usize, &str)> {
    let mut fenced = false;
    (1..).zip(markdown.lines()).filter(move |(_, line)| {
        let fence = line.trim_start().starts_with("```");
        fenced ^= fence;
        !fenced && !fence
    })
}

/// The relative targets of the links and pictures of a file, with their lines.
fn links(markdown: &str) -> Vec<(usize, String)> {
    let mut found = Vec::new();
    for (number, line) in outside_fences(markdown) {
        // Text between backticks is code.
        let line: String = line.split('`').step_by(2).collect();
        let definition = line.strip_prefix('[').and_then(|rest| rest.split_once("]: ")).map(|(_, target)| target);
        let inline = line.split("](").skip(1).filter_map(|rest| rest.split_once(')')).map(|(target, _)| target);
        let targets = definition.into_iter().chain(inline).map(|target| target.split(' ').next().unwrap_or(""));
        found.extend(targets.filter(|target| !is_elsewhere(target)).map(|target| (number, target.to_owned())));
    }
    found
}

/// Whether a link leaves the repository.
fn is_elsewhere(target: &str) -> bool {
    target.contains("://") || target.starts_with("mailto:")
}

/// The anchors of a file: written anchors, and those that a forge generates from headings.
fn anchors(markdown: &str) -> BTreeSet<String> {
    let mut found: BTreeSet<String> = BTreeSet::new();
    let mut headings: BTreeMap<String, u32> = BTreeMap::new();
    for (_, line) in outside_fences(markdown) {
        let written = line.split("<a id=\"").skip(1).filter_map(|rest| rest.split_once('"'));
        found.extend(written.map(|(id, _)| id.to_owned()));
        let heading = line.trim_start_matches('#');
        if heading.len() < line.len() && heading.starts_with(' ') {
            let slug = slug(heading.trim());
            let seen = headings.entry(slug.clone()).or_default();
            found.insert(if *seen == 0 { slug } else { format!("{slug}-{seen}") });
            *seen += 1;
        }
    }
    found
}

/// The anchor that a forge generates from a heading.
fn slug(heading: &str) -> String {
    let kept = heading.chars().filter(|char| char.is_alphanumeric() || matches!(char, ' ' | '-' | '_'));
    kept.flat_map(char::to_lowercase).map(|char| if char == ' ' { '-' } else { char }).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn broken(links: &str) -> Vec<String> {
        let file = |path: &str, text: &str| Source { path: path.to_owned(), text: text.to_owned() };
        let sources = [
            file("docs/a.md", links),
            file("docs/b.md", "# One `two`: three\n\n## Same\n\n## Same\n\n<a id=\"2.4\"></a>\n```\n# none\n```\n"),
        ];
        let files = ["docs/a.md", "docs/b.md", "src/lib.rs"].map(str::to_owned).into();
        check(&sources, &files).0.into_iter().map(|broken| broken.what).collect()
    }

    #[test]
    fn links_to_files_folders_and_anchors_hold() {
        let links = "[a](b.md) [b](b.md#2.4) [c](../src/lib.rs) [d](../src) [e](b.md#one-two-three) [f](b.md#same-1)\n\
                     [g](https://example.org/x) [h](#top) ![i](b.md \"title\")\n# Top\n\n[j]: b.md#same\n";
        assert_eq!(broken(links), Vec::<String>::new());
    }

    #[test]
    fn a_file_and_an_anchor_that_are_not_there_are_found() {
        assert_eq!(broken("[a](c.md)").len(), 1);
        assert_eq!(broken("[a](../../x.md)").len(), 1);
        assert_eq!(broken("[a](b.md#2.5)").len(), 1);
        assert_eq!(broken("[a](b.md#none)").len(), 1, "a heading between fences is none");
        assert_eq!(broken("[a](#none)").len(), 1);
        assert_eq!(broken("[j]: c.md").len(), 1);
    }

    #[test]
    fn code_has_no_links() {
        assert_eq!(broken("`[a](c.md)`\n```\n[a](c.md)\n```\n"), Vec::<String>::new());
    }
}
