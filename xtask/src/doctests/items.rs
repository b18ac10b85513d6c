//! The public functions, methods and types of a crate with their examples, from its source.
//!
//! The source is read as tokens. An item is public if a path of public modules and `pub use` leads to it. Code under `#[cfg(test)]`
//! is left out. The crate must not have two types of one name.

use crate::modules::{files, is_for_tests, path_of};
use anyhow::{Context, Result};
use proc_macro2::{Delimiter, Group, Spacing, TokenStream, TokenTree};
use std::collections::BTreeSet;
use std::path::Path;

/// What an item is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// A struct, enum, trait or alias.
    Type,
    /// A function outside of a type, or a method or associated function of `owner`.
    Function,
}

/// A public item, or a module with its own text.
#[derive(Clone, Debug)]
pub struct Item {
    /// The module that defines it.
    pub module: Vec<String>,
    /// The type or trait of a method.
    pub owner: Option<String>,
    pub name: String,
    pub kind: Kind,
    /// The lines of its examples that a reader sees; empty without an example.
    pub example: String,
    /// The names after `->`, or in the body of a type.
    pub names: BTreeSet<String>,
    /// A method that returns a field, a method of a trait with a default, or a type that derives `Error`.
    pub exempt: bool,
}

/// The public items of a crate, and the examples of its modules.
#[derive(Debug, Default)]
pub struct Library {
    pub items: Vec<Item>,
    /// Path of a module and the examples of its text.
    pub modules: Vec<(Vec<String>, String)>,
}

/// A module as written.
#[derive(Default)]
struct Module {
    path: Vec<String>,
    text: String,
    items: Vec<(Item, bool)>,
    /// The children that are `pub`.
    children: Vec<String>,
    /// The paths of `pub use`; `*` is the last name of a glob.
    exports: Vec<Vec<String>>,
}

impl Library {
    /// Reads every file below the `src` folder of a crate; `readme` is the text of the root.
    pub fn read(source: &Path, readme: &str) -> Result<Self> {
        let mut modules = Vec::new();
        for file in files(source)? {
            let text = std::fs::read_to_string(&file)?;
            modules.push(module(path_of(source, &file), &text).with_context(|| file.display().to_string())?);
        }
        let mut library = Self::of(modules);
        library.modules.push((Vec::new(), examples(readme)));
        Ok(library)
    }

    fn of(modules: Vec<Module>) -> Self {
        let open = open_modules(&modules);
        let exported: BTreeSet<Vec<String>> =
            modules.iter().filter(|module| open.contains(&module.path)).flat_map(exported).collect();
        let is_public = |module: &[String], name: &str| {
            open.contains(module)
                || exported.iter().any(|path| {
                    path.split_last().is_some_and(|(last, parent)| parent == module && (last == name || last == "*"))
                })
        };
        let mut library = Self::default();
        let mut types = BTreeSet::new();
        for (item, public) in modules.iter().flat_map(|module| &module.items) {
            if *public && item.kind == Kind::Type && is_public(&item.module, &item.name) {
                types.insert(item.name.clone());
            }
        }
        for module in modules {
            let kept = module.items.into_iter().filter(|(item, public)| match &item.owner {
                Some(owner) => *public && types.contains(owner),
                None => *public && is_public(&item.module, &item.name),
            });
            library.items.extend(kept.map(|(item, _)| item));
            library.modules.push((module.path, examples(&module.text)));
        }
        library
    }

    /// A library of the given modules, such as `("gauge::read", "pub fn read() {}")`.
    #[cfg(test)]
    pub fn made_up(sources: &[(&str, &str)]) -> Self {
        let path = |text: &str| text.split("::").filter(|name| !name.is_empty()).map(str::to_owned).collect();
        Self::of(sources.iter().map(|(name, source)| module(path(name), source).unwrap()).collect())
    }
}

/// The modules that a path of public modules or a `pub use` of a module leads to.
fn open_modules(modules: &[Module]) -> BTreeSet<Vec<String>> {
    let mut open = BTreeSet::from([Vec::new()]);
    loop {
        let before = open.len();
        for module in modules.iter().filter(|module| open.contains(&module.path)).collect::<Vec<_>>() {
            let children =
                module.children.iter().map(|child| [module.path.as_slice(), std::slice::from_ref(child)].concat());
            let named = exported(module).into_iter().filter(|path| modules.iter().any(|known| known.path == *path));
            open.extend(children.chain(named));
        }
        if open.len() == before {
            return open;
        }
    }
}

/// The paths that a module exports, from the root of the crate.
fn exported(module: &Module) -> Vec<Vec<String>> {
    let absolute = |path: &Vec<String>| match path.split_first() {
        Some((first, rest)) if first == "crate" => rest.to_vec(),
        Some((first, rest)) if first == "self" => [module.path.as_slice(), rest].concat(),
        _ => [module.path.as_slice(), path.as_slice()].concat(),
    };
    module.exports.iter().map(absolute).collect()
}

fn module(path: Vec<String>, source: &str) -> Result<Module> {
    let tokens: TokenStream = source.parse().ok().context("not Rust")?;
    let mut module = Module { path, ..Module::default() };
    for written in Written::split(tokens) {
        match &written {
            Written::Text(line) => module.text.push_str(line),
            Written::Item(parts) => add(&mut module, parts, None),
        }
    }
    Ok(module)
}

/// Adds an item of a module, or of the body of `owner`.
fn add(module: &mut Module, parts: &Parts, owner: Option<(&str, bool)>) {
    if parts.is_for_tests {
        return;
    }
    let Some((word, rest)) = parts.keyword() else { return };
    let name = rest.first().map(ToString::to_string).unwrap_or_default();
    match word.as_str() {
        "mod" if parts.public => module.children.push(name),
        "use" if parts.public => use_paths(&parts.all_after_use(), &[], &mut module.exports),
        "struct" | "enum" | "trait" | "type" | "union" => {
            let mut names = BTreeSet::new();
            words(rest.iter().cloned().chain(parts.body.clone().map(TokenTree::from)).collect(), &mut names);
            let exempt = parts.derives_error;
            module.items.push((parts.item(&module.path, None, &name, Kind::Type, names, exempt), parts.public));
            if word == "trait" {
                methods(module, parts, (&name, true));
            }
        }
        "impl" => {
            if let Some(owner) = implementor(rest) {
                methods(module, parts, (&owner, false));
            }
        }
        "fn" => {
            let returned = rest.iter().skip_while(|tree| !is_punct(tree, '>')).cloned();
            let mut names = BTreeSet::new();
            words(returned.collect(), &mut names);
            let has_default = owner.is_some_and(|(_, of_trait)| of_trait) && parts.body.is_some();
            let exempt = owner.is_some() && (has_default || returns_a_field(parts.body.as_ref()));
            let public = parts.public || owner.is_some_and(|(_, of_trait)| of_trait);
            let owner = owner.map(|(owner, _)| owner.to_owned());
            module.items.push((parts.item(&module.path, owner, &name, Kind::Function, names, exempt), public));
        }
        _ => {}
    }
}

fn methods(module: &mut Module, parts: &Parts, owner: (&str, bool)) {
    let Some(body) = &parts.body else { return };
    for written in Written::split(body.stream()) {
        if let Written::Item(method) = written {
            add(module, &method, Some(owner));
        }
    }
}

/// An item in its parts, or a line of the text of the module.
enum Written {
    Text(String),
    Item(Parts),
}

/// An item as written: its text, the tokens up to its body, and the body.
#[derive(Default)]
struct Parts {
    text: String,
    public: bool,
    is_for_tests: bool,
    derives_error: bool,
    head: Vec<TokenTree>,
    body: Option<Group>,
}

impl Written {
    fn split(tokens: TokenStream) -> Vec<Self> {
        let mut written = Vec::new();
        let mut parts = Parts::default();
        let mut trees = tokens.into_iter().peekable();
        while let Some(tree) = trees.next() {
            match &tree {
                TokenTree::Punct(hash) if hash.as_char() == '#' && parts.head.is_empty() => {
                    let inner = trees.next_if(|tree| is_punct(tree, '!')).is_some();
                    let Some(TokenTree::Group(attribute)) = trees.next() else { continue };
                    match doc(&attribute) {
                        Some(line) if inner => written.push(Self::Text(line)),
                        Some(line) => parts.text.push_str(&line),
                        None if inner => {}
                        None => parts.attribute(&attribute),
                    }
                }
                TokenTree::Ident(word) if *word == "pub" && parts.head.is_empty() => {
                    let restricted = |tree: &TokenTree| matches!(tree, TokenTree::Group(_));
                    parts.public = trees.next_if(restricted).is_none();
                }
                TokenTree::Group(body) if body.delimiter() == Delimiter::Brace => {
                    parts.body = Some(body.clone());
                    written.push(Self::Item(std::mem::take(&mut parts)));
                }
                _ if is_punct(&tree, ';') => written.push(Self::Item(std::mem::take(&mut parts))),
                _ => parts.head.push(tree),
            }
        }
        written
    }
}

impl Parts {
    fn attribute(&mut self, attribute: &Group) {
        self.is_for_tests |= is_for_tests(attribute.stream());
        let mut names = BTreeSet::new();
        words(attribute.stream(), &mut names);
        self.derives_error |= names.contains("derive") && names.contains("Error");
    }

    /// The word that tells the kind of the item, and the tokens after it.
    fn keyword(&self) -> Option<(String, &[TokenTree])> {
        let mut rest = self.head.as_slice();
        while let [first, after @ ..] = rest {
            let word = first.to_string();
            let qualifies = matches!(word.as_str(), "const" | "async" | "unsafe" | "extern" | "default");
            if !qualifies {
                return Some((word, after));
            }
            rest = after;
        }
        None
    }

    fn all_after_use(&self) -> Vec<TokenTree> {
        self.head.iter().skip(1).cloned().chain(self.body.clone().map(TokenTree::from)).collect()
    }

    fn item(
        &self,
        module: &[String],
        owner: Option<String>,
        name: &str,
        kind: Kind,
        names: BTreeSet<String>,
        exempt: bool,
    ) -> Item {
        let example = examples(&self.text);
        Item { module: module.to_vec(), owner, name: name.to_owned(), kind, example, names, exempt }
    }
}

/// The type of `impl<..> Type<..>`; nothing for the implementation of a trait.
fn implementor(header: &[TokenTree]) -> Option<String> {
    let mut depth = 0usize;
    let mut arrow = false;
    let mut name = None;
    for tree in header {
        match tree {
            TokenTree::Punct(punct) => {
                match punct.as_char() {
                    '<' => depth = depth.saturating_add(1),
                    '>' if !arrow => depth = depth.saturating_sub(1),
                    _ => {}
                }
                arrow = punct.as_char() == '-' && punct.spacing() == Spacing::Joint;
            }
            TokenTree::Ident(word) if depth == 0 => match word.to_string().as_str() {
                "for" => return None,
                "where" => break,
                word => name = Some(word.to_owned()),
            },
            _ => {}
        }
    }
    name
}

/// Whether a body is `self.field`, `&self.field` or `&mut self.field`.
fn returns_a_field(body: Option<&Group>) -> bool {
    let Some(body) = body else { return false };
    let mut words = body.stream().into_iter().filter(|tree| !is_punct(tree, '&')).map(|tree| tree.to_string());
    let first = words.next();
    let first = if first.as_deref() == Some("mut") { words.next() } else { first };
    let rest: Vec<String> = words.collect();
    let is_name = |word: &String| word.chars().all(|char| char.is_alphanumeric() || char == '_');
    first.as_deref() == Some("self")
        && !rest.is_empty()
        && rest.chunks(2).all(|pair| matches!(pair, [dot, field] if dot == "." && is_name(field)))
}

/// The paths of a `use` declaration; a rename does not matter here.
fn use_paths(trees: &[TokenTree], prefix: &[String], paths: &mut Vec<Vec<String>>) {
    let mut path = prefix.to_vec();
    for tree in trees {
        match tree {
            TokenTree::Ident(word) if *word == "as" => break,
            TokenTree::Ident(word) => path.push(word.to_string()),
            TokenTree::Punct(punct) if punct.as_char() == '*' => path.push("*".to_owned()),
            TokenTree::Group(group) => {
                let trees: Vec<TokenTree> = group.stream().into_iter().collect();
                return trees.split(|tree| is_punct(tree, ',')).for_each(|one| use_paths(one, &path, paths));
            }
            TokenTree::Punct(_) | TokenTree::Literal(_) => {}
        }
    }
    // `a::{self}` is `a`.
    if path.len() > 1 && path.last().is_some_and(|last| last == "self") {
        path.pop();
    }
    if path.len() > prefix.len() || path.len() > 1 {
        paths.push(path);
    }
}

/// The line of `doc = "..."`, with its end.
fn doc(attribute: &Group) -> Option<String> {
    let mut trees = attribute.stream().into_iter();
    let is_doc = matches!(trees.next(), Some(TokenTree::Ident(word)) if word == "doc");
    let line = trees.nth(1).filter(|_| is_doc)?.to_string();
    Some(line.trim_matches('"').trim_start().to_owned() + "\n")
}

/// The lines of the examples in a text that a reader sees: those of blocks that rustdoc compiles, without `# `.
fn examples(text: &str) -> String {
    let mut shown = String::new();
    let mut block: Option<bool> = None;
    for line in text.lines().map(str::trim) {
        match (line.strip_prefix("```"), block) {
            (Some(marks), None) => block = Some(is_compiled(marks)),
            (Some(_), Some(_)) => block = None,
            (None, Some(true)) if line != "#" && !line.starts_with("# ") => {
                shown.push_str(line);
                shown.push('\n');
            }
            (None, _) => {}
        }
    }
    shown
}

fn is_compiled(marks: &str) -> bool {
    let compiled = ["", "rust", "no_run", "should_panic", "compile_fail"];
    marks.split(',').all(|mark| compiled.contains(&mark.trim()))
}

/// The identifiers in tokens, at any depth.
pub fn words(tokens: TokenStream, found: &mut BTreeSet<String>) {
    for tree in tokens {
        match tree {
            TokenTree::Ident(word) => drop(found.insert(word.to_string())),
            TokenTree::Group(group) => words(group.stream(), found),
            TokenTree::Punct(_) | TokenTree::Literal(_) => {}
        }
    }
}

fn is_punct(tree: &TokenTree, wanted: char) -> bool {
    matches!(tree, TokenTree::Punct(punct) if punct.as_char() == wanted)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn names(sources: &[(&str, &str)]) -> Vec<String> {
        let name = |item: Item| item.owner.map_or_else(String::new, |owner| owner + "::") + &item.name;
        Library::made_up(sources).items.into_iter().map(name).collect()
    }

    #[test]
    fn items_are_public_through_modules_and_exports() {
        let root = ("", "pub mod open; mod shut; pub use shut::{Named, inner}; pub use shut::deep::*; fn own() {}");
        let open =
            ("open", "pub struct A; pub(crate) struct B; #[cfg(test)] mod tests { pub fn x() {} } pub fn f() {}");
        let shut = ("shut", "pub enum Named {} pub enum Hidden {} pub mod inner; pub mod deep;");
        let below = [("shut::inner", "pub type T = u8;"), ("shut::deep", "pub trait U { fn m(); }")];
        assert_eq!(names(&[root, open, shut, below[0], below[1]]), ["A", "f", "Named", "T", "U", "U::m"]);
    }

    #[test]
    fn methods_belong_to_the_type_that_they_are_implemented_for() {
        let source = "pub struct A<T>(T); struct B;
            impl<T: Fn() -> u8> A<T> where T: Copy { pub const fn a(&self) {} fn private(&self) {} pub(crate) fn c() {} }
            impl B { pub fn b() {} }
            impl Iterator for A<u8> { fn next() {} }";
        assert_eq!(names(&[("", source)]), ["A", "A::a"]);
    }

    #[test]
    fn methods_that_return_a_field_and_errors_are_exempt() {
        let source = "pub struct A; #[derive(Debug, thiserror::Error)] pub enum E {}
            impl A { pub fn a(&self) -> &u8 { &self.a } pub fn b(&mut self) -> &mut u8 { &mut self.a.b }
            pub fn c(&self) -> u8 { self.a.get() } pub fn d(&self) -> u8 { f(self.a) } }";
        let exempt: Vec<bool> = Library::made_up(&[("", source)]).items.iter().map(|item| item.exempt).collect();
        assert_eq!(exempt, [false, true, true, true, false, false]);
    }

    #[test]
    fn only_the_visible_lines_of_compiled_blocks_are_examples() {
        let text = "Text.\n```\nuse a;\n# hidden();\nb();\n```\n```text\nno\n```\n```rust,no_run\nc();\n```\n";
        assert_eq!(examples(text), "use a;\nb();\nc();\n");
    }
}
