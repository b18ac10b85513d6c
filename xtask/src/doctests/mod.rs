//! Checks that every public function, method and type of the client and of `wire` has an example that compiles.
//!
//! An item has an example in its own documentation, or another example shows it:
//!
//! | Item | Is shown by an example of |
//! |---|---|
//! | method | its type, another method of the type, or a module around the type, that calls or implements it |
//! | function | a module around it, or another item of its module, that calls it |
//! | type | any item, that names it; or a function that returns it and has an example |
//!
//! Lines that begin with `# ` do not count: the reader does not see them. Some items need no example: a method that returns a field; a
//! method of a trait that has a default; an error (a type that derives `Error`) and the types of its data, because a program meets them and
//! does not make them. The methods of these types do need one.

mod items;

use crate::{root, verdict};
use anyhow::Result;
use items::{Item, Kind, Library};
use std::collections::BTreeSet;

/// The crates that programs use first.
const CRATES: [&str; 2] = ["client", "wire"];

/// Prints the items without an example, or their number.
pub fn check() -> Result<()> {
    let mut defects = Vec::new();
    for name in CRATES {
        let folder = root().join("crates").join(name);
        let readme = std::fs::read_to_string(folder.join("README.md"))?;
        let library = Library::read(&folder.join("src"), &readme)?;
        defects.extend(without_example(&library).iter().map(|item| format!("{name}: {item} has no example")));
        println!("doctests: {} public functions, methods and types of {name}", library.items.len());
    }
    verdict("doctests", &defects)
}

/// The names of the items without an example.
fn without_example(library: &Library) -> Vec<String> {
    let errors = errors_and_their_data(library);
    let shown = |item: &&Item| match item.kind {
        Kind::Function => is_called(library, item),
        Kind::Type => errors.contains(&item.name) || is_named(library, item),
    };
    let missing = library.items.iter().filter(|item| !item.exempt && item.example.is_empty() && !shown(item));
    missing.map(name).collect()
}

/// The errors, and every type that the body of one names.
fn errors_and_their_data(library: &Library) -> BTreeSet<String> {
    let types = || library.items.iter().filter(|item| item.kind == Kind::Type);
    let mut found: BTreeSet<String> = types().filter(|item| item.exempt).map(|item| item.name.clone()).collect();
    loop {
        let data: Vec<&String> =
            types().filter(|item| found.contains(&item.name)).flat_map(|item| &item.names).collect();
        let more: Vec<String> = types()
            .map(|item| &item.name)
            .filter(|name| data.contains(name) && !found.contains(*name))
            .cloned()
            .collect();
        if more.is_empty() {
            return found;
        }
        found.extend(more);
    }
}

/// Whether an example of its type or module calls the function.
fn is_called(library: &Library, function: &Item) -> bool {
    let Some(owner) = &function.owner else {
        let beside =
            library.items.iter().filter(|item| item.module == function.module).map(|item| item.example.as_str());
        return beside
            .chain(text_of(library, &function.module))
            .any(|example| calls(example, &["", "::"], &function.name));
    };
    let path = format!("{owner}::");
    let is_of_owner =
        |item: &&Item| item.owner.as_ref() == Some(owner) || (item.kind == Kind::Type && item.name == *owner);
    let modules = library.items.iter().filter(|item| item.kind == Kind::Type && item.name == *owner);
    let texts = modules.flat_map(|item| text_of(library, &item.module));
    let examples = library.items.iter().filter(is_of_owner).map(|item| item.example.as_str());
    examples.chain(texts).any(|example| calls(example, &[".", "fn ", &path], &function.name))
}

/// Whether an example names the type, or a function with an example returns it.
fn is_named(library: &Library, named: &Item) -> bool {
    let examples =
        library.items.iter().map(|item| &item.example).chain(library.modules.iter().map(|(_, example)| example));
    let returns = |item: &&Item| item.kind == Kind::Function && item.names.contains(&named.name);
    examples.into_iter().any(|example| word(example, &named.name).next().is_some())
        || library.items.iter().filter(returns).any(|item| !item.example.is_empty() || is_called(library, item))
}

/// The examples of a module and of those around it, without the root.
fn text_of<'a>(library: &'a Library, module: &'a [String]) -> impl Iterator<Item = &'a str> {
    let around = library.modules.iter().filter(move |(path, _)| !path.is_empty() && module.starts_with(path));
    around.map(|(_, example)| example.as_str())
}

/// Whether `name` is in the example behind one of `before`, as a call or as a path such as `map(Type::name)`.
fn calls(example: &str, before: &[&str], name: &str) -> bool {
    word(example, name).any(|(left, right)| {
        let called = right.starts_with(['(', ':', '<']) || left.ends_with("::");
        called && before.iter().any(|sign| left.ends_with(sign))
    })
}

/// The text on both sides of each place where `name` is a whole word.
fn word<'a>(text: &'a str, name: &'a str) -> impl Iterator<Item = (&'a str, &'a str)> {
    let is_part = |char: char| char.is_alphanumeric() || char == '_';
    let sides = text.match_indices(name).filter_map(move |(at, _)| {
        let (left, right) = text.split_at_checked(at)?;
        Some((left, right.strip_prefix(name)?))
    });
    sides.filter(move |(left, right)| !left.ends_with(is_part) && !right.starts_with(is_part))
}

/// The name of an item in a message: `gauge::Gauge::read`.
fn name(item: &Item) -> String {
    let parts = item.module.iter().chain(&item.owner).chain([&item.name]);
    parts.map(String::as_str).collect::<Vec<_>>().join("::")
}

#[cfg(test)]
mod tests {
    use super::*;

    fn missing(source: &str) -> Vec<String> {
        without_example(&Library::made_up(&[("", source)]))
    }

    #[test]
    fn an_item_without_any_example_is_listed() {
        assert_eq!(missing("pub fn f() {} pub struct A; impl A { pub fn m(&self) {} }"), ["f", "A", "A::m"]);
        assert!(missing("/// ```\n/// f();\n/// ```\npub fn f() {}").is_empty());
        assert_eq!(missing("/// ```text\n/// f();\n/// ```\npub fn f() {}"), ["f"]);
    }

    #[test]
    fn a_method_is_shown_by_an_example_of_its_type_that_calls_it() {
        let source = |line: &str| {
            format!(
                "/// ```\n/// {line}\n/// ```\npub struct A; impl A {{ pub fn m(&self) {{}} }} pub struct B; impl B {{ pub fn m(&self) {{}} }}"
            )
        };
        assert_eq!(missing(&source("a.m(); let b: B;")), ["B::m"]);
        assert_eq!(missing(&source("list.map(A::m); let b: B;")), ["B::m"]);
        assert_eq!(missing(&source("# a.m(); let b: B;")), ["A", "A::m", "B", "B::m"]);
        assert_eq!(missing(&source("a.more(); let b: B;")), ["A::m", "B::m"]);
        assert_eq!(missing(&source("Other::m(); let b: B;")), ["A::m", "B::m"]);
    }

    #[test]
    fn a_type_is_shown_where_it_is_named_or_returned() {
        assert!(missing("/// ```\n/// f();\n/// ```\npub fn f() -> Result<A, u8> {} pub struct A;").is_empty());
        let module = ("a", "//! ```\n//! f(A);\n//! ```\npub fn f() {} pub struct A;");
        assert!(without_example(&Library::made_up(&[("", "pub mod a;"), module])).is_empty());
    }

    #[test]
    fn errors_and_their_data_need_no_example_but_their_methods_do() {
        let source = "#[derive(Error)] pub enum E { One(Reason) } pub enum Reason { Two(Code) } pub struct Code;
            impl E { pub fn advice(&self) -> u8 { 1 } pub fn code(&self) -> u8 { self.code } }";
        assert_eq!(missing(source), ["E::advice"]);
    }
}
