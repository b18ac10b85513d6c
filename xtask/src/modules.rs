//! The modules of a crate and the modules that each of them uses.
//!
//! The source is read as tokens, so comments do not count and the bodies of macros do. A module uses what its `use`
//! declarations and its paths with `crate`, `self` or `super` name. A name that a module re-exports counts as a use of the
//! module that is written and of the module that defines the name, so a parent that re-exports its children does not hide
//! that one child uses another. Code under `#[cfg(test)]` may use anything and is left out.

use crate::files;
use anyhow::{Context, Result};
use proc_macro2::{Delimiter, TokenStream, TokenTree};
use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;

/// The names from the root of the crate to a module; the root has none.
pub type ModulePath = Vec<String>;

/// A module uses another one.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct Arrow {
    /// The module with the path.
    pub from: ModulePath,
    /// The module that the path names, or that defines the item that the path names.
    pub to: ModulePath,
}

/// One module, without its children.
#[derive(Debug, Default)]
struct Module {
    /// Every path as written that can name another module of the crate.
    paths: BTreeSet<Vec<String>>,
    /// The names that `use` brings in, with their paths.
    imports: BTreeMap<String, Vec<String>>,
    /// The paths of `use path::*`.
    globs: Vec<Vec<String>>,
    /// The names that the module defines itself.
    items: BTreeSet<String>,
    /// The children that exist for tests only.
    test_children: BTreeSet<String>,
}

/// All modules of a crate.
#[derive(Debug, Default)]
pub struct Modules(BTreeMap<ModulePath, Module>);

/// Re-exports are followed through this many modules.
const MOST_HOPS: u8 = 16;

impl Modules {
    /// Reads every Rust file below the `src` folder of a crate.
    pub fn read(source: &Path) -> Result<Self> {
        let mut modules = Self::default();
        for (file, text) in files(source, "rs")? {
            let tokens = text.parse().ok().with_context(|| format!("{} is not Rust", file.display()))?;
            modules.add(path_of(source, &file), tokens);
        }
        modules.remove_tests();
        Ok(modules)
    }

    fn add(&mut self, path: ModulePath, tokens: TokenStream) {
        let mut scan = Scan::default();
        scan.stream(tokens);
        for (name, body) in scan.inline {
            self.add([path.as_slice(), &[name]].concat(), body);
        }
        // `main.rs` and `lib.rs` share the root.
        let module = self.0.entry(path).or_default();
        module.paths.extend(scan.module.paths);
        module.imports.extend(scan.module.imports);
        module.globs.extend(scan.module.globs);
        module.items.extend(scan.module.items);
        module.test_children.extend(scan.module.test_children);
    }

    fn remove_tests(&mut self) {
        let below = |(path, module): (&ModulePath, &Module)| -> Vec<ModulePath> {
            module.test_children.iter().map(|name| [path.as_slice(), std::slice::from_ref(name)].concat()).collect()
        };
        let tests: Vec<ModulePath> = self.0.iter().flat_map(below).collect();
        self.0.retain(|path, _| !tests.iter().any(|test| path.starts_with(test)));
    }

    /// The paths of all modules, the root included.
    pub fn paths(&self) -> impl Iterator<Item = &ModulePath> {
        self.0.keys()
    }

    /// Every use of one module by another.
    pub fn arrows(&self) -> BTreeSet<Arrow> {
        let mut arrows = BTreeSet::new();
        for (from, module) in &self.0 {
            for to in module.paths.iter().flat_map(|path| self.used_by(from, path)).filter(|to| to != from) {
                arrows.insert(Arrow { from: from.clone(), to });
            }
        }
        arrows
    }

    /// The module that `path` names as it is written in `from`, and the one that defines its name.
    fn used_by(&self, from: &[String], path: &[String]) -> Vec<ModulePath> {
        let Some((start, rest)) = self.begin(from, path, MOST_HOPS) else { return Vec::new() };
        let written = self.descend(start.clone(), rest);
        let defining = self.define(start, rest, MOST_HOPS);
        [Some(written), defining].into_iter().flatten().collect()
    }

    /// The module in which the lookup of `path` begins, and the names to look up there. Names of other crates give nothing.
    fn begin<'a>(&self, from: &[String], path: &'a [String], hops: u8) -> Option<(ModulePath, &'a [String])> {
        let (first, rest) = path.split_first()?;
        match first.as_str() {
            "crate" => Some((Vec::new(), rest)),
            "self" => self.climb(from.to_vec(), rest),
            "super" => self.climb(from.to_vec(), path),
            name if self.has(from, name) => Some((from.to_vec(), path)),
            name => {
                let import = self.0.get(from)?.imports.get(name).filter(|import| *import != path)?;
                let (start, names) = self.begin(from, import, hops.checked_sub(1)?)?;
                let module = self.module_at(start, names)?;
                Some((module, rest))
            }
        }
    }

    /// Follows each leading `super` to the parent.
    fn climb<'a>(&self, mut module: ModulePath, mut path: &'a [String]) -> Option<(ModulePath, &'a [String])> {
        while let Some((_, rest)) = path.split_first().filter(|(first, _)| *first == "super") {
            module.pop()?;
            path = rest;
        }
        Some((module, path))
    }

    fn has(&self, parent: &[String], child: &str) -> bool {
        self.0.keys().any(|path| path.starts_with(parent) && path.get(parent.len()).is_some_and(|name| name == child))
    }

    /// The module with the path `names`, if all of them are modules.
    fn module_at(&self, mut module: ModulePath, names: &[String]) -> Option<ModulePath> {
        module.extend_from_slice(names);
        self.0.contains_key(&module).then_some(module)
    }

    /// The deepest module of the path `names`.
    fn descend(&self, mut module: ModulePath, names: &[String]) -> ModulePath {
        for name in names {
            if !self.has(&module, name) {
                break;
            }
            module.push(name.clone());
        }
        module
    }

    /// The module that defines the item `names` of `module`, through re-exports.
    fn define(&self, module: ModulePath, names: &[String], hops: u8) -> Option<ModulePath> {
        let hops = hops.checked_sub(1)?;
        let Some((first, rest)) = names.split_first() else { return Some(module) };
        if self.has(&module, first) {
            return self.define([module.as_slice(), std::slice::from_ref(first)].concat(), rest, hops);
        }
        let here = self.0.get(&module)?;
        if here.items.contains(first) {
            return Some(module);
        }
        if let Some(import) = here.imports.get(first) {
            let (start, names) = self.begin(&module, import, hops)?;
            return self.define(start, &[names, rest].concat(), hops);
        }
        let globs = here.globs.iter().filter_map(|glob| self.begin(&module, glob, hops));
        let targets: Vec<ModulePath> = globs.map(|(start, names)| self.descend(start, names)).collect();
        let through =
            targets.into_iter().find(|target| self.0.get(target).is_some_and(|target| target.items.contains(first)));
        // No source defines a name that a macro generates: it belongs to the module in which it is looked up.
        Some(through.unwrap_or(module))
    }
}

/// The module a file holds: `src/link/time.rs` is `["link", "time"]`, `src/link/mod.rs` is `["link"]`, the root is empty.
fn path_of(source: &Path, file: &Path) -> ModulePath {
    let inside = file.strip_prefix(source).unwrap_or(file).with_extension("");
    let names = inside.iter().map(|name| name.to_string_lossy().into_owned());
    names.filter(|name| !matches!(name.as_str(), "lib" | "main" | "mod")).collect()
}

/// Collects the paths and names of one module.
#[derive(Default)]
struct Scan {
    module: Module,
    /// `mod name { ... }`.
    inline: Vec<(String, TokenStream)>,
}

impl Scan {
    fn stream(&mut self, tokens: TokenStream) {
        let trees: Vec<TokenTree> = tokens.into_iter().collect();
        let mut rest = trees.as_slice();
        while !rest.is_empty() {
            let used = self.item(rest).max(1);
            rest = rest.get(used..).unwrap_or_default();
        }
    }

    /// Reads the item at the beginning of `trees`, and returns the number of trees it has.
    fn item(&mut self, trees: &[TokenTree]) -> usize {
        match trees {
            [TokenTree::Punct(hash), TokenTree::Group(attribute), rest @ ..]
                if hash.as_char() == '#' && is_for_tests(attribute.stream()) =>
            {
                self.test_item(rest).saturating_add(2)
            }
            // A visibility is no use of the module that it names.
            [TokenTree::Ident(word), TokenTree::Group(group), ..]
                if *word == "pub" && group.delimiter() == Delimiter::Parenthesis =>
            {
                2
            }
            [TokenTree::Ident(word), TokenTree::Ident(name), TokenTree::Group(body), ..]
                if *word == "mod" && body.delimiter() == Delimiter::Brace =>
            {
                self.inline.push((name.to_string(), body.stream()));
                3
            }
            [TokenTree::Ident(word), rest @ ..] if *word == "use" => self.use_declaration(rest).saturating_add(1),
            [TokenTree::Ident(word), rest @ ..] if *word == "crate" || *word == "self" || *word == "super" => {
                let (names, used) = path(word.to_string(), rest);
                if names.len() > 1 {
                    self.module.paths.insert(names);
                }
                used.saturating_add(1)
            }
            [TokenTree::Ident(word), TokenTree::Ident(name), ..] if defines(&word.to_string()) => {
                self.module.items.insert(name.to_string());
                1
            }
            [TokenTree::Group(group), ..] => {
                self.stream(group.stream());
                1
            }
            _ => 1,
        }
    }

    /// Leaves out an item for tests: everything up to its `;` or its body.
    fn test_item(&mut self, trees: &[TokenTree]) -> usize {
        let ends = |tree: &TokenTree| match tree {
            TokenTree::Punct(punct) => punct.as_char() == ';',
            TokenTree::Group(group) => group.delimiter() == Delimiter::Brace,
            TokenTree::Ident(_) | TokenTree::Literal(_) => false,
        };
        let length = trees.iter().position(ends).map_or(trees.len(), |last| last.saturating_add(1));
        for pair in trees.get(..length).unwrap_or_default().windows(2) {
            if let [TokenTree::Ident(word), TokenTree::Ident(name)] = pair
                && *word == "mod"
            {
                self.module.test_children.insert(name.to_string());
            }
        }
        length
    }

    fn use_declaration(&mut self, trees: &[TokenTree]) -> usize {
        let is_end = |tree: &TokenTree| matches!(tree, TokenTree::Punct(punct) if punct.as_char() == ';');
        let length = trees.iter().position(is_end).unwrap_or(trees.len());
        // `impl Trait + use<'a>` imports nothing.
        if !matches!(trees.first(), Some(TokenTree::Punct(punct)) if punct.as_char() == '<') {
            self.use_tree(&[], trees.get(..length).unwrap_or_default());
        }
        length
    }

    /// Reads `a::b`, `a::b as c`, `a::*` or `a::{...}` after `prefix`.
    fn use_tree(&mut self, prefix: &[String], trees: &[TokenTree]) {
        let mut names = prefix.to_vec();
        for (position, tree) in trees.iter().enumerate() {
            match tree {
                TokenTree::Ident(word) if *word == "as" => {
                    let alias = trees.get(position.saturating_add(1)).map(ToString::to_string);
                    return self.import(names, alias);
                }
                TokenTree::Ident(word) => names.push(word.to_string()),
                TokenTree::Punct(punct) if punct.as_char() == '*' => {
                    self.module.paths.insert(names.clone());
                    return self.module.globs.push(names);
                }
                TokenTree::Group(group) => {
                    let trees: Vec<TokenTree> = group.stream().into_iter().collect();
                    let is_comma = |tree: &TokenTree| matches!(tree, TokenTree::Punct(punct) if punct.as_char() == ',');
                    return trees
                        .split(is_comma)
                        .filter(|one| !one.is_empty())
                        .for_each(|one| self.use_tree(&names, one));
                }
                TokenTree::Punct(_) | TokenTree::Literal(_) => {}
            }
        }
        self.import(names, None);
    }

    fn import(&mut self, mut names: Vec<String>, alias: Option<String>) {
        // `a::{self}` is `a`.
        if names.len() > 1 && names.last().is_some_and(|last| last == "self") {
            names.pop();
        }
        if let Some(name) = alias.or_else(|| names.last().cloned()) {
            self.module.imports.insert(name, names.clone());
        }
        self.module.paths.insert(names);
    }
}

/// Whether a word begins the definition of a name.
fn defines(word: &str) -> bool {
    matches!(word, "fn" | "struct" | "enum" | "trait" | "type" | "const" | "static" | "union" | "mod")
}

/// Whether an attribute contains `cfg(test)` or `cfg(all(test, ...))`.
fn is_for_tests(attribute: TokenStream) -> bool {
    let text: String = attribute.to_string().chars().filter(|char| !char.is_whitespace()).collect();
    text == "cfg(test)" || text.starts_with("cfg(all(test,")
}

/// The names of `first::a::b`, and how many trees follow `first`.
fn path(first: String, mut rest: &[TokenTree]) -> (Vec<String>, usize) {
    let (mut names, mut used) = (vec![first], 0usize);
    while let [TokenTree::Punct(one), TokenTree::Punct(two), TokenTree::Ident(name), after @ ..] = rest {
        if (one.as_char(), two.as_char()) != (':', ':') {
            break;
        }
        names.push(name.to_string());
        used = used.saturating_add(3);
        rest = after;
    }
    (names, used)
}

#[cfg(test)]
pub mod tests {
    use super::*;

    /// A crate made of the given modules: a path such as `link::time`, and the source.
    pub fn made_up(sources: &[(&str, &str)]) -> Modules {
        let mut modules = Modules::default();
        for (path, source) in [("", "")].iter().chain(sources) {
            let path: ModulePath = path.split("::").filter(|name| !name.is_empty()).map(str::to_owned).collect();
            modules.add(path, source.parse().unwrap());
        }
        modules.remove_tests();
        modules
    }

    /// The modules that `from` uses.
    fn used(modules: &Modules, from: &str) -> Vec<String> {
        let arrows = modules.arrows().into_iter().filter(|arrow| arrow.from.join("::") == from);
        arrows.map(|arrow| arrow.to.join("::")).collect()
    }

    fn used_in(depth_two: &str) -> Vec<String> {
        let others = [("", ""), ("link", ""), ("link::time", ""), ("slave", ""), ("slave::prm", ""), ("master", "")];
        let mut sources = others.to_vec();
        sources.push(("master::ms1", depth_two));
        used(&made_up(&sources), "master::ms1")
    }

    #[test]
    fn paths_are_found_in_code_types_and_macros() {
        assert_eq!(used_in("use crate::slave::Slave;"), ["slave"]);
        assert_eq!(
            used_in("use crate::{link::{Baud, time::Time}, slave::prm::{self}};"),
            ["link", "link::time", "slave::prm"]
        );
        assert_eq!(used_in("fn f() { let x: Vec<crate::slave::State> = g(&[crate::link::X]); }"), ["link", "slave"]);
        assert_eq!(used_in("rows! { 1 [crate::link::time::Row] }"), ["link::time"]);
    }

    #[test]
    fn self_and_super_are_followed_from_the_module_they_are_in() {
        assert_eq!(used_in("use super::super::slave::Slave;"), ["slave"]);
        assert_eq!(used_in("use super::ms2::X;"), ["master"]);
        assert_eq!(used_in("mod inner { use super::super::X; }"), Vec::<String>::new());
        let modules = made_up(&[("a", "mod inner { use super::super::b::X; }"), ("b", "")]);
        assert_eq!(used(&modules, "a::inner"), ["b"]);
        let modules = made_up(&[("a", "use self::b::X; use c::Y;"), ("a::b", ""), ("a::c", "")]);
        assert_eq!(used(&modules, "a"), ["a::b", "a::c"]);
    }

    #[test]
    fn a_re_export_leads_to_the_module_that_defines_the_name() {
        let modules = made_up(&[
            ("a", "pub use b::{One as Uno}; pub use c::*; mod b; mod c;"),
            ("a::b", "pub struct One; use super::Two;"),
            ("a::c", "pub enum Two {}"),
            ("d", "use crate::a::Uno; use crate::a; fn f() { a::x() }"),
        ]);
        assert_eq!(used(&modules, "a::b"), ["a", "a::c"]);
        assert_eq!(used(&modules, "d"), ["a", "a::b"]);
    }

    #[test]
    fn tests_comments_and_visibilities_do_not_count() {
        assert!(used_in("// crate::slave\n/// [`crate::slave`]\nfn f() { slave::x(); }").is_empty());
        assert!(used_in("#[cfg(test)] mod tests { use crate::slave::X; }").is_empty());
        assert!(
            used_in("#[cfg(test)] use crate::slave::X; #[cfg(all(test, unix))] fn f() { crate::slave::x() }")
                .is_empty()
        );
        assert!(used_in("pub(in crate::slave) fn f() -> impl Sized + use<> { self.x }").is_empty());
        let modules = made_up(&[("a", "#[cfg(test)] mod tests;"), ("a::tests", "use crate::b::X;"), ("b", "")]);
        assert!(modules.arrows().is_empty());
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
