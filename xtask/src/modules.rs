//! Which modules of a crate mention which others.
//!
//! The source is read as tokens, so comments do not count and the bodies of macros do. A path that begins with `crate` or
//! climbs to the root by `super` names a module of the crate with its next word. Names that are no module (what the root
//! defines or re-exports) are left alone.

use anyhow::{Context, Result};
use proc_macro2::{Delimiter, TokenStream, TokenTree};
use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

/// A module of the crate mentions another one.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct Arrow {
    /// The module at the root of the crate that the file belongs to.
    pub from: String,
    /// The module at the root of the crate that is mentioned.
    pub to: String,
    /// The file.
    pub file: PathBuf,
}

/// All arrows between modules at the root of the crate with this `src` folder.
pub fn uses(source: &Path) -> Result<BTreeSet<Arrow>> {
    let files = files(source)?;
    let module = |file: &PathBuf| path_of(source, file).first().cloned();
    let modules: BTreeSet<String> = files.iter().filter_map(module).collect();
    let mut arrows = BTreeSet::new();
    for file in &files {
        let path = path_of(source, file);
        let Some(from) = path.first() else { continue };
        let text = std::fs::read_to_string(file)?;
        let tokens: TokenStream = text.parse().ok().with_context(|| format!("{} is no Rust", file.display()))?;
        let mentioned = at_root(tokens, path.len());
        let others = mentioned.into_iter().filter(|name| name != from && modules.contains(name));
        arrows.extend(others.map(|to| Arrow { from: from.clone(), to, file: file.clone() }));
    }
    Ok(arrows)
}

/// Every Rust file below a folder.
fn files(folder: &Path) -> Result<Vec<PathBuf>> {
    let mut found = Vec::new();
    for entry in std::fs::read_dir(folder).with_context(|| folder.display().to_string())? {
        let path = entry?.path();
        if path.is_dir() {
            found.extend(files(&path)?);
        } else if path.extension().is_some_and(|extension| extension == "rs") {
            found.push(path);
        }
    }
    Ok(found)
}

/// The module a file holds: `src/link/time.rs` is `["link", "time"]`, `src/link/mod.rs` is `["link"]`, the root is empty.
fn path_of(source: &Path, file: &Path) -> Vec<String> {
    let inside = file.strip_prefix(source).unwrap_or(file).with_extension("");
    let names = inside.iter().map(|name| name.to_string_lossy().into_owned());
    names.filter(|name| !matches!(name.as_str(), "lib" | "main" | "mod")).collect()
}

/// The words that follow the crate's root in all paths of a module that is `depth` below the root.
fn at_root(tokens: TokenStream, depth: usize) -> BTreeSet<String> {
    let trees: Vec<TokenTree> = tokens.into_iter().collect();
    let mut found = BTreeSet::new();
    for (position, tree) in trees.iter().enumerate() {
        let after = trees.get(position.saturating_add(1)..).unwrap_or_default();
        match tree {
            TokenTree::Ident(word) if *word == "crate" => found.extend(heads(after)),
            TokenTree::Ident(word) if *word == "super" => found.extend(climb(after, depth)),
            TokenTree::Group(group) => {
                let inline = is_inline_module(&trees, position);
                found.extend(at_root(group.stream(), depth.saturating_add(usize::from(inline))));
            }
            _ => {}
        }
    }
    found
}

/// Whether the group at `position` is the body of `mod name { ... }`.
fn is_inline_module(trees: &[TokenTree], position: usize) -> bool {
    let before = position.checked_sub(2).and_then(|start| trees.get(start..=position));
    matches!(before, Some([TokenTree::Ident(word), TokenTree::Ident(_), TokenTree::Group(group)])
        if *word == "mod" && group.delimiter() == Delimiter::Brace)
}

/// What follows `super` where `depth` of them lead to the root.
fn climb(after: &[TokenTree], depth: usize) -> BTreeSet<String> {
    match (depth, after) {
        (1, _) => heads(after),
        (_, [TokenTree::Punct(_), TokenTree::Punct(_), TokenTree::Ident(word), rest @ ..]) if *word == "super" => {
            climb(rest, depth.saturating_sub(1))
        }
        _ => BTreeSet::new(),
    }
}

/// The first words of `::name...` or `::{name..., name...}`.
fn heads(after: &[TokenTree]) -> BTreeSet<String> {
    match after {
        [TokenTree::Punct(first), TokenTree::Punct(second), next, ..]
            if (first.as_char(), second.as_char()) == (':', ':') =>
        {
            match next {
                TokenTree::Ident(word) => BTreeSet::from([word.to_string()]),
                TokenTree::Group(group) => items(group.stream()),
                _ => BTreeSet::new(),
            }
        }
        _ => BTreeSet::new(),
    }
}

/// The first word of each item in the braces of a `use`.
fn items(tokens: TokenStream) -> BTreeSet<String> {
    let trees: Vec<TokenTree> = tokens.into_iter().collect();
    let comma = |tree: &TokenTree| matches!(tree, TokenTree::Punct(punct) if punct.as_char() == ',');
    trees.split(comma).filter_map(|item| item.first()).map(ToString::to_string).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn found(depth: usize, source: &str) -> Vec<String> {
        at_root(source.parse().unwrap(), depth).into_iter().collect()
    }

    #[test]
    fn paths_from_the_root_are_found_wherever_they_stand() {
        assert_eq!(found(1, "use crate::slave::Slave;"), ["slave"]);
        assert_eq!(found(1, "use crate::{link::{Baud, Reply}, slave};"), ["link", "slave"]);
        assert_eq!(
            found(1, "fn f() { let x: Vec<crate::slave::State> = g(&[crate::master::X]); }"),
            ["master", "slave"]
        );
        assert_eq!(found(1, "rows! { 1 [crate::profile::Row] }"), ["profile"]);
    }

    #[test]
    fn super_counts_only_where_it_reaches_the_root() {
        assert_eq!(found(1, "use super::slave::Slave;"), ["slave"]);
        assert!(found(2, "use super::slave::Slave;").is_empty());
        assert_eq!(found(2, "use super::super::slave::Slave;"), ["slave"]);
        assert!(found(1, "mod tests { use super::slave; }").is_empty());
        assert_eq!(found(1, "mod tests { use super::super::slave; }"), ["slave"]);
    }

    #[test]
    fn comments_and_words_that_only_look_alike_do_not_count() {
        assert!(found(1, "// crate::slave\n/// [`crate::slave`]\nfn f() { slave::x(); }").is_empty());
    }

    #[test]
    fn a_file_is_the_module_its_path_says() {
        let path = |file| path_of(Path::new("src"), Path::new(file));
        assert_eq!(path("src/link/time.rs"), ["link", "time"]);
        assert_eq!(path("src/link/mod.rs"), ["link"]);
        assert_eq!(path("src/link.rs"), ["link"]);
        assert!(path("src/lib.rs").is_empty());
    }
}
