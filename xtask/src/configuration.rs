//! The page of the book about the keys of the files: it is made from the types that read them.
//!
//! A type names its keys as serde sees them; the comment of a field is the sentence about its key.

use crate::{files, root, verdict};
use anyhow::{Context, Result};
use std::collections::BTreeMap;
use std::fmt;
use std::path::PathBuf;
use syn::{
    Attribute, Expr, ExprLit, Field, GenericArgument, Item, ItemEnum, ItemStruct, Lit, Meta, MetaNameValue,
    PathArguments, Type,
};

/// The files that users write: title, the folder of the types, the type of the whole file.
const FILES: [(&str, &str, &str); 2] = [
    ("The file of a station", "crates/config/src", "ConfigToml"),
    ("The file of an archive", "crates/archive/src", "Toml"),
];

/// The folders of the types that both files have, and of the settings of a station.
const SHARED: [&str; 2] = ["crates/web-server/src/tables", "crates/station/src/config"];

/// Types around the type of a value that do not show in the file.
const WRAPPERS: [&str; 3] = ["Option", "Spanned", "Parsed"];

/// Types of values, and what the file has for them.
const WORDS: [(&str, &[&str]); 16] = [
    ("`true` or `false`", &["bool"]),
    ("URL", &["Uri"]),
    ("address and port", &["Listen", "SocketAddr"]),
    ("address or network", &["Network"]),
    ("date", &["Value"]),
    ("duration", &["Duration", "TimeSpan"]),
    ("file", &["PathBuf"]),
    ("gas", &["Gas"]),
    ("integer", &["BaudToml", "i64", "u16", "u32", "u64", "u8", "usize"]),
    ("list or table of modules", &["Modules"]),
    ("number", &["f64"]),
    ("pressure", &["Pressure"]),
    ("text", &["Secret", "String"]),
    ("text or integer", &["PrmValue"]),
    ("text or table", &["OutputsToml"]),
    ("time of the day or `off`", &["DailyTime"]),
];

/// Prints the page.
pub fn print() -> Result<()> {
    let types = read()?;
    println!(
        "# Keys of the files\n\nThe files are TOML. A text is in quotes; so are a pressure (`\"1e-3 mbar\"`), a duration (`\"5 s\"`) and an address."
    );
    println!(
        "A file that is named is beside the file that names it, unless it begins with `/`. `--check` of `run` and of `archive` tests a file.\n"
    );
    for page in &pages(&types)? {
        println!("## {}\n", page.title);
        for table in &page.tables {
            println!("{}\n", heading(&table.places));
            println!("| Key | Value | Needed | Meaning |\n|---|---|---|---|");
            for key in &table.keys {
                let needed = if key.is_needed { "yes" } else { "no" };
                println!("| `{}` | {} | {needed} | {} |", key.name, key.shape, key.meaning.replace('|', "\\|"));
            }
            println!();
        }
    }
    Ok(())
}

/// The places of a table: the first one in the heading, and all of them with their sentences.
fn heading(places: &[(String, String)]) -> String {
    let list = places.iter().map(|(name, meaning)| format!("- `{name}`: {meaning}")).collect::<Vec<_>>().join("\n");
    match places {
        [(name, meaning)] => format!("### `{name}`\n\n{meaning}"),
        [(name, _), others @ ..] => format!("### `{name}` and {} more\n\n{list}", others.len()),
        [] => String::new(),
    }
}

/// Checks that every key has its sentence, and every value a known type.
pub fn check() -> Result<()> {
    let types = read()?;
    let pages = pages(&types)?;
    let tables = || pages.iter().flat_map(|page| &page.tables);
    let places = tables().flat_map(|table| &table.places).map(|(name, meaning)| (name.clone(), meaning));
    let keys = tables().flat_map(|table| {
        let names = table.places.iter().map(|(name, _)| name.as_str()).collect::<Vec<_>>().join(", ");
        table.keys.iter().map(move |key| (format!("{names} {}", key.name), &key.meaning))
    });
    let missing = places.chain(keys).filter(|(_, meaning)| meaning.is_empty());
    let defects: Vec<String> = missing.map(|(name, _)| format!("{name}: write a comment on its field")).collect();
    verdict("configuration", &defects)
}

/// The types of each file, then those of other folders.
fn read() -> Result<Vec<Types>> {
    let folders = FILES.iter().map(|(_, folder, _)| *folder).chain(SHARED);
    folders.map(|folder| types(&files(&root().join(folder), "rs")?)).collect()
}

fn pages(types: &[Types]) -> Result<Vec<Page<'_>>> {
    let files = FILES.iter().zip(types);
    let pages = files.map(|((title, _, whole), own)| {
        let others = types.iter().filter(|other| !std::ptr::eq(*other, own));
        let mut page = Page { title, types: std::iter::once(own).chain(others).collect(), tables: Vec::new() };
        page.add_tables(page.keys(whole)?, "")?;
        Ok(page)
    });
    pages.collect()
}

/// Structs and enums by their names.
type Types = BTreeMap<String, Item>;

/// The types of sources that serde reads.
fn types(sources: &[(PathBuf, String)]) -> Result<Types> {
    let mut types = Types::new();
    for (path, text) in sources {
        for item in syn::parse_file(text).with_context(|| path.display().to_string())?.items {
            let (Item::Struct(ItemStruct { attrs, ident, .. }) | Item::Enum(ItemEnum { attrs, ident, .. })) = &item
            else {
                continue;
            };
            if derives_deserialize(attrs) {
                types.insert(ident.to_string(), item);
            }
        }
    }
    Ok(types)
}

/// The keys of a file.
struct Page<'a> {
    title: &'static str,
    /// The types of its own folder come first.
    types: Vec<&'a Types>,
    tables: Vec<Table>,
}

/// A table of a file. Several tables with the same keys are one.
struct Table {
    /// As in the file, `[station]` or `[[segment.gauge]]`, each with its sentence.
    places: Vec<(String, String)>,
    of: String,
    keys: Vec<Key>,
}

#[derive(Clone)]
struct Key {
    name: String,
    shape: Shape,
    is_needed: bool,
    meaning: String,
}

/// What a value of the file is.
#[derive(Clone)]
enum Shape {
    Word(String),
    /// A table, or with `true` a list of tables.
    Table(String, bool),
}

impl fmt::Display for Shape {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Word(word) => formatter.write_str(word),
            Self::Table(_, true) => formatter.write_str("tables"),
            Self::Table(_, false) => formatter.write_str("table"),
        }
    }
}

impl Page<'_> {
    /// Adds the tables among these keys of the table `within`, and the tables in them.
    fn add_tables(&mut self, keys: Vec<Key>, within: &str) -> Result<()> {
        for Key { name, shape, meaning, .. } in keys {
            match shape {
                Shape::Table(of, is_list) => self.add(of, &format!("{within}{name}"), is_list, meaning)?,
                Shape::Word(_) if within.is_empty() => anyhow::bail!("{name} is no table"),
                Shape::Word(_) => {}
            }
        }
        Ok(())
    }

    /// Adds the table at `path`, whose keys are the fields of the type `of`.
    fn add(&mut self, of: String, path: &str, is_list: bool, meaning: String) -> Result<()> {
        let place = (if is_list { format!("[[{path}]]") } else { format!("[{path}]") }, meaning);
        if let Some(table) = self.tables.iter_mut().find(|table| table.of == of) {
            table.places.push(place);
            return Ok(());
        }
        let keys = self.keys(&of)?;
        self.tables.push(Table { places: vec![place], of, keys: keys.clone() });
        self.add_tables(keys, &format!("{path}."))
    }

    /// The keys of a table: the fields of a type.
    fn keys(&self, of: &str) -> Result<Vec<Key>> {
        let Some(Item::Struct(item)) = self.item(of) else { anyhow::bail!("{of} is no struct") };
        let rename = serde(&item.attrs, "rename_all");
        // A field without a key is filled while the file is checked.
        let fields = item.fields.iter().filter(|field| serde(&field.attrs, "skip").is_none());
        let keys = fields.map(|field| {
            let name = key(field, rename.as_deref());
            let shape = self.shape(&field.ty).with_context(|| format!("{of}: {name}"))?;
            let is_option = matches!(&field.ty, Type::Path(path) if path.path.segments.last().is_some_and(|it| it.ident == "Option"));
            let is_needed = !is_option && serde(&field.attrs, "default").is_none();
            Ok(Key { name, shape, is_needed, meaning: comment(&field.attrs) })
        });
        keys.collect()
    }

    fn shape(&self, kind: &Type) -> Result<Shape> {
        let (name, arguments) = match kind {
            Type::Path(path) => {
                let last = path.path.segments.last().context("a type without a name")?;
                (last.ident.to_string(), types_in(&last.arguments))
            }
            Type::Array(array) => return Ok(Shape::Word(format!("list of {}", self.word(&array.elem)?))),
            _ => anyhow::bail!("a type that is no path"),
        };
        match (name.as_str(), &arguments[..]) {
            (wrapper, [inside]) if WRAPPERS.contains(&wrapper) => self.shape(inside),
            ("Vec", [inside]) => Ok(match self.shape(inside)? {
                Shape::Table(of, _) => Shape::Table(of, true),
                Shape::Word(word) => Shape::Word(format!("list of {word}")),
            }),
            ("BTreeMap", [_, inside]) => Ok(Shape::Word(format!("table of {} by name", self.word(inside)?))),
            _ => self.named(&name),
        }
    }

    /// The value of a key that has no keys of its own.
    fn word(&self, kind: &Type) -> Result<String> {
        match self.shape(kind)? {
            Shape::Word(word) => Ok(word),
            Shape::Table(of, _) => anyhow::bail!("{of} has keys"),
        }
    }

    fn named(&self, name: &str) -> Result<Shape> {
        if let Some((word, _)) = WORDS.iter().find(|(_, types)| types.contains(&name)) {
            return Ok(Shape::Word((*word).to_owned()));
        }
        match self.item(name) {
            Some(Item::Enum(item)) => Ok(Shape::Word(choices(item))),
            Some(_) => Ok(Shape::Table(name.to_owned(), false)),
            None => anyhow::bail!("the type {name} is unknown: add a word for it in xtask/src/configuration.rs"),
        }
    }

    fn item(&self, name: &str) -> Option<&Item> {
        self.types.iter().find_map(|types| types.get(name))
    }
}

fn types_in(arguments: &PathArguments) -> Vec<&Type> {
    let PathArguments::AngleBracketed(arguments) = arguments else { return Vec::new() };
    let types = arguments.args.iter().filter_map(|argument| match argument {
        GenericArgument::Type(kind) => Some(kind),
        _ => None,
    });
    types.collect()
}

fn derives_deserialize(attributes: &[Attribute]) -> bool {
    let mut derives = attributes.iter().filter(|attribute| attribute.path().is_ident("derive"));
    derives.any(|derive| match &derive.meta {
        Meta::List(list) => list.tokens.to_string().contains("Deserialize"),
        _ => false,
    })
}

/// The value of a setting for serde; empty for a setting without a value.
fn serde(attributes: &[Attribute], wanted: &str) -> Option<String> {
    let mut found = None;
    for attribute in attributes.iter().filter(|attribute| attribute.path().is_ident("serde")) {
        let _parsed = attribute.parse_nested_meta(|meta| {
            let value = meta.value().and_then(|value| value.parse::<syn::LitStr>()).map(|text| text.value());
            if meta.path.is_ident(wanted) {
                found = Some(value.unwrap_or_default());
            }
            Ok(())
        });
    }
    found
}

/// The text of the comment, in one line.
fn comment(attributes: &[Attribute]) -> String {
    let lines = attributes.iter().filter_map(|attribute| match &attribute.meta {
        Meta::NameValue(MetaNameValue { path, value: Expr::Lit(ExprLit { lit: Lit::Str(text), .. }), .. }) => {
            path.is_ident("doc").then(|| text.value().trim().to_owned())
        }
        _ => None,
    });
    lines.collect::<Vec<_>>().join(" ")
}

/// The key of a field, as serde has it.
fn key(field: &Field, rename_all: Option<&str>) -> String {
    let name = field.ident.as_ref().map(ToString::to_string).unwrap_or_default().replace("r#", "");
    let renamed = || if rename_all.is_some() { name.replace('_', "-") } else { name };
    serde(&field.attrs, "rename").unwrap_or_else(renamed)
}

/// The words of an enum, as serde has them.
fn choices(item: &ItemEnum) -> String {
    let rename_all = serde(&item.attrs, "rename_all");
    let hyphen = if rename_all.as_deref() == Some("kebab-case") { "-" } else { "" };
    let lower = |(at, letter): (usize, char)| {
        let before = if at > 0 && letter.is_uppercase() { hyphen } else { "" };
        format!("{before}{}", letter.to_lowercase())
    };
    let words = item.variants.iter().map(|variant| {
        let name = variant.ident.to_string();
        let renamed = || if rename_all.is_some() { name.char_indices().map(lower).collect() } else { name };
        format!("`{}`", serde(&variant.attrs, "rename").unwrap_or_else(renamed))
    });
    words.collect::<Vec<_>>().join(", ")
}

#[cfg(test)]
mod tests {
    use super::*;

    fn tables(text: &str) -> Result<Vec<Table>> {
        let types = types(&[(PathBuf::new(), text.to_owned())])?;
        let mut page = Page { title: "File", types: vec![&types], tables: Vec::new() };
        page.add_tables(page.keys("Whole")?, "")?;
        Ok(page.tables)
    }

    #[test]
    fn keys_have_the_names_and_the_values_that_serde_reads() {
        let text = "
            #[derive(Deserialize)] struct Whole { /// The hall.
                one_hall: Option<Hall>, #[serde(default)] pipes: Vec<Pipe> }
            #[derive(Debug, Deserialize)] #[serde(deny_unknown_fields, rename_all = \"kebab-case\")]
            struct Hall { /// How wide.
                the_width: Option<Spanned<u8>>, pub r#type: Kind, #[serde(rename = \"x\")] inner: Inner }
            #[derive(Deserialize)] struct Inner { files: Vec<Parsed<PathBuf>> }
            #[derive(Deserialize)] struct Pipe { #[serde(default)] by_name: BTreeMap<String, f64> }
            #[derive(Deserialize)] #[serde(rename_all = \"kebab-case\")] enum Kind { WideOpen, Shut }
        ";
        let lines: Vec<String> = tables(text)
            .unwrap()
            .iter()
            .flat_map(|table| table.keys.iter().map(|key| (&table.places[0], key)))
            .map(|((place, about), key)| {
                format!("{place}({about}) {}: {} {} {}", key.name, key.shape, key.is_needed, key.meaning)
            })
            .collect();
        assert_eq!(
            lines,
            [
                "[one_hall](The hall.) the-width: integer false How wide.",
                "[one_hall](The hall.) type: `wide-open`, `shut` true ",
                "[one_hall](The hall.) x: table true ",
                "[one_hall.x]() files: list of file true ",
                "[[pipes]]() by_name: table of number by name false ",
            ]
        );
    }

    #[test]
    fn an_unknown_type_is_an_error_that_names_its_key() {
        let text =
            "#[derive(Deserialize)] struct Whole { hall: Hall }  #[derive(Deserialize)] struct Hall { width: Width }";
        let Err(error) = tables(text) else { panic!("it is no error") };
        assert!(format!("{error:#}").starts_with("Hall: width: the type Width is unknown"), "{error:#}");
    }
}
