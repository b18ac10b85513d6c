//! Links of Markdown files to each other.

use crate::{Source, tracked, verdict};
use anyhow::Result;
use std::collections::{BTreeMap, BTreeSet};

/// Checks all tracked files.
pub fn check() -> Result<()> {
    verdict("links", &defects(&tracked()?))
}

/// The relative links in Markdown files without a target.
fn defects(sources: &[Source]) -> Vec<String> {
    let anchors = sources.iter().map(|source| (source.path.as_str(), anchors(&source.text))).collect();
    let mut defects = Vec::new();
    for Source { path, text } in sources.iter().filter(|source| source.path.ends_with(".md")) {
        for (line, target) in links(text) {
            let wrong = wrong(path, &target, &anchors);
            defects.extend(wrong.map(|what| format!("{path}:{line}: the link {target} leads to no {what}")));
        }
    }
    defects
}

/// The part of a target that does not exist among the files with their anchors.
fn wrong(from: &str, target: &str, files: &BTreeMap<&str, BTreeSet<String>>) -> Option<&'static str> {
    let (path, anchor) = target.split_once('#').map_or((target, None), |(path, anchor)| (path, Some(anchor)));
    let path = if path.is_empty() { Some(from.to_owned()) } else { resolve(from, path) };
    let Some(path) = path else { return Some("file") };
    match files.get(path.as_str()) {
        Some(anchors) => anchor.filter(|anchor| !anchors.contains(*anchor)).map(|_| "anchor"),
        None => (!files.keys().any(|file| file.starts_with(&format!("{path}/")))).then_some("file"),
    }
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
        let targets = definition.into_iter().chain(inline).filter_map(|target| target.split(' ').next());
        let here = targets.filter(|target| !target.contains("://") && !target.starts_with("mailto:"));
        found.extend(here.map(|target| (number, target.to_owned())));
    }
    found
}

/// The anchors of a file: written anchors, and those that a forge generates from headings.
fn anchors(markdown: &str) -> BTreeSet<String> {
    let mut found: BTreeSet<String> = BTreeSet::new();
    let mut headings: BTreeMap<String, u32> = BTreeMap::new();
    for (_, line) in outside_fences(markdown) {
        let written = line.split("<a id=\"").skip(1).filter_map(|rest| rest.split_once('"'));
        found.extend(written.map(|(id, _)| id.to_owned()));
        if let Some(heading) = line.strip_prefix('#').and_then(|line| line.trim_start_matches('#').strip_prefix(' ')) {
            let kept = heading.trim().chars().filter(|char| char.is_alphanumeric() || " -_".contains(*char));
            let slug: String = kept.flat_map(char::to_lowercase).collect::<String>().replace(' ', "-");
            let seen = headings.entry(slug.clone()).or_default();
            found.insert(if *seen == 0 { slug } else { format!("{slug}-{seen}") });
            *seen += 1;
        }
    }
    found
}

#[cfg(test)]
mod tests {
    use super::*;

    fn broken(links: &str) -> Vec<String> {
        let page = "# One `two`: three\n\n## Same\n\n## Same\n\n<a id=\"2.4\"></a>\n```\n# none\n```\n";
        let files = [("docs/a.md", links), ("docs/b.md", page), ("src/lib.rs", "")];
        defects(&files.map(|(path, text)| Source { path: path.to_owned(), text: text.to_owned() }))
    }

    #[test]
    fn links_to_files_folders_and_anchors_hold() {
        let links = "[a](b.md) [b](b.md#2.4) [c](../src/lib.rs) [d](../src) [`e`](b.md#one-two-three) [f](b.md#same-1)\n\
                     [g](https://example.org/x) [h](#top) ![i](b.md \"title\") `[a](c.md)`\n# Top\n\n[j]: b.md#same\n";
        assert_eq!(broken(links), [""; 0]);
    }

    #[test]
    fn a_file_and_an_anchor_that_do_not_exist_are_found() {
        for target in ["c.md", "../../x.md"] {
            assert_eq!(
                broken(&format!("[`a`]({target})")),
                [format!("docs/a.md:1: the link {target} leads to no file")]
            );
        }
        for target in ["b.md#2.5", "b.md#none", "#none"] {
            assert_eq!(
                broken(&format!("[a]({target})")),
                [format!("docs/a.md:1: the link {target} leads to no anchor")]
            );
        }
        assert_eq!(broken("[j]: c.md"), ["docs/a.md:1: the link c.md leads to no file"]);
    }
}
