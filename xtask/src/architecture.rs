//! Checks that the names in the walks of `ARCHITECTURE.md` exist.
//!
//! Below the heading `## Walks` every step is an item of a numbered list that begins with a file and one or more names in backticks:
//!
//! ```text
//! 1. `crates/wire/src/telegram.rs` `parse`, `emit`: octets to a telegram and back
//! ```
//!
//! A name is a function, method, type, trait, constant, variant or macro that this file defines. `Type::name` demands both.

use crate::{root, verdict};
use anyhow::{Context, Result};
use proc_macro2::{TokenStream, TokenTree};
use std::collections::BTreeSet;

/// The heading above the walks.
const HEADING: &str = "## Walks";

/// A step of a walk.
#[derive(Debug, PartialEq, Eq)]
struct Step {
    line: usize,
    file: String,
    names: Vec<String>,
}

/// Checks every step.
pub fn check() -> Result<()> {
    let text = std::fs::read_to_string(root().join("ARCHITECTURE.md")).context("ARCHITECTURE.md")?;
    let mut defects = Vec::new();
    match steps(&text) {
        Ok(steps) if steps.is_empty() => defects.push(format!("ARCHITECTURE.md has no steps below {HEADING:?}")),
        Ok(steps) => defects.extend(steps.iter().flat_map(missing)),
        Err(defect) => defects.push(defect),
    }
    verdict("architecture", &defects)
}

/// The defect of a step: its file is missing or does not define a name.
fn missing(step: &Step) -> Vec<String> {
    let place = format!("ARCHITECTURE.md:{}: {}", step.line, step.file);
    match std::fs::read_to_string(root().join(&step.file)) {
        Ok(source) => undefined(&source, &step.names)
            .into_iter()
            .map(|name| format!("{place} defines no {name}; update the walk"))
            .collect(),
        Err(error) => vec![format!("{place} cannot be read: {error}; update the walk")],
    }
}

/// The steps of all walks, or the first line of a numbered list that is not a step.
fn steps(text: &str) -> Result<Vec<Step>, String> {
    let below = (1..).zip(text.lines()).skip_while(|(_, line)| *line != HEADING).skip(1);
    let walks = below.take_while(|(_, line)| !line.starts_with("## "));
    let mut steps = Vec::new();
    for (number, line) in walks {
        let digits = line.bytes().take_while(u8::is_ascii_digit).count();
        let Some(item) = line.get(digits..).and_then(|rest| rest.strip_prefix(". ")).filter(|_| digits > 0) else {
            continue;
        };
        steps.push(
            step(number, item).ok_or(format!("ARCHITECTURE.md:{number}: expected `FILE` `NAME`, found {line:?}"))?,
        );
    }
    Ok(steps)
}

/// `` `file` `name`, `name`: text ``
fn step(line: usize, item: &str) -> Option<Step> {
    let head = item.split_once(": ").map_or(item, |(head, _)| head);
    let mut quoted = head.split('`').skip(1).step_by(2).map(str::to_owned);
    let file = quoted.next().filter(|file| file.ends_with(".rs"))?;
    let names: Vec<String> = quoted.collect();
    (!names.is_empty()).then_some(Step { line, file, names })
}

/// The names that a source does not define.
fn undefined(source: &str, names: &[String]) -> Vec<String> {
    let Ok(tokens) = source.parse::<TokenStream>() else { return vec!["Rust that can be parsed".to_owned()] };
    let mut defined = BTreeSet::new();
    collect(tokens, &mut defined);
    let is_defined = |name: &str| name.split("::").all(|part| defined.contains(part));
    names.iter().filter(|name| !is_defined(name)).cloned().collect()
}

/// Keywords that define the name after them.
const KEYWORDS: [&str; 9] = ["fn", "struct", "enum", "trait", "type", "const", "static", "mod", "impl"];

/// Collects the names that a token stream defines: the names after keywords, and the variants of enums.
fn collect(tokens: TokenStream, defined: &mut BTreeSet<String>) {
    let (mut after, mut in_enum) = (false, false);
    for token in tokens {
        match token {
            TokenTree::Ident(ident) => {
                let word = ident.to_string();
                if after {
                    defined.insert(word.clone());
                }
                in_enum |= word == "enum";
                after = KEYWORDS.contains(&word.as_str());
            }
            TokenTree::Group(group) => {
                if in_enum && group.delimiter() == proc_macro2::Delimiter::Brace {
                    variants(group.stream(), defined);
                    in_enum = false;
                }
                collect(group.stream(), defined);
                after = false;
            }
            TokenTree::Punct(_) | TokenTree::Literal(_) => after = false,
        }
    }
}

/// The names at the beginning of a list with commas.
fn variants(tokens: TokenStream, defined: &mut BTreeSet<String>) {
    let mut is_first = true;
    for token in tokens {
        match token {
            TokenTree::Ident(ident) if is_first => {
                defined.insert(ident.to_string());
                is_first = false;
            }
            TokenTree::Punct(punct) if punct.as_char() == ',' => is_first = true,
            _ => {}
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const SOURCE: &str = "
        pub struct Telegram<'a>(&'a [u8]);
        impl<'a> Telegram<'a> { pub const fn parse(octets: &[u8]) -> Self { helper() } }
        enum Reply { Low(usize), #[doc(hidden)] High { at: u8 }, None }
        const LIMIT: u8 = 1;
    ";

    fn undefined_of(names: &[&str]) -> Vec<String> {
        undefined(SOURCE, &names.iter().map(|name| (*name).to_owned()).collect::<Vec<_>>())
    }

    #[test]
    fn a_defined_name_is_found() {
        assert_eq!(undefined_of(&["parse", "Telegram::parse", "Telegram", "Reply::Low", "High", "LIMIT"]), [""; 0]);
    }

    #[test]
    fn a_name_that_is_only_used_is_missing() {
        assert_eq!(
            undefined_of(&["helper", "parse", "Telegram::emit", "octets"]),
            ["helper", "Telegram::emit", "octets"]
        );
    }

    #[test]
    fn a_numbered_item_is_a_step_and_other_lines_are_not() {
        let text = "1. `before.rs` `ignored`\n## Walks\ntext `a`\n\n1. `crates/a.rs` `b`, `C::d`: what `e` does\n12. `f.rs` `g`\n## Next\n1. `after.rs` `x`";
        let expected = [
            Step { line: 5, file: "crates/a.rs".to_owned(), names: vec!["b".to_owned(), "C::d".to_owned()] },
            Step { line: 6, file: "f.rs".to_owned(), names: vec!["g".to_owned()] },
        ];
        assert_eq!(steps(text).unwrap(), expected);
    }

    #[test]
    fn a_numbered_item_without_file_and_name_is_a_defect() {
        for item in ["1. `crates/a.rs`: no name", "1. no file", "1. `name` `crates/a.rs`"] {
            assert!(steps(&format!("## Walks\n{item}")).is_err(), "{item}");
        }
    }

    #[test]
    fn a_file_that_does_not_exist_is_a_defect() {
        let step = Step { line: 1, file: "crates/none.rs".to_owned(), names: vec!["x".to_owned()] };
        assert!(missing(&step)[0].contains("cannot be read"), "{:?}", missing(&step));
    }
}
