//! Checks that the names in the walks of `ARCHITECTURE.md` exist.
//!
//! Below the heading `## Walks` every step is an item of a numbered list that begins with a file and one or more names in backticks:
//!
//! ```text
//! 1. `crates/wire/src/telegram.rs` `parse`, `emit`: octets to a telegram and back
//! ```
//!
//! A name is a function, method, type, trait, constant or macro that this file defines. `Type::name` demands both.

use crate::{root, verdict};
use anyhow::{Context, Result};

/// The heading above the walks.
const HEADING: &str = "## Walks";

/// A step of a walk.
#[derive(Debug, PartialEq, Eq)]
struct Step<'t> {
    line: usize,
    file: &'t str,
    names: Vec<&'t str>,
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
fn missing(step: &Step<'_>) -> Vec<String> {
    let place = format!("ARCHITECTURE.md:{}: {}", step.line, step.file);
    match std::fs::read_to_string(root().join(step.file)) {
        Ok(source) => undefined(&source, &step.names)
            .into_iter()
            .map(|name| format!("{place} defines no {name}; update the walk"))
            .collect(),
        Err(error) => vec![format!("{place} cannot be read: {error}; update the walk")],
    }
}

/// The steps of all walks, or the first line of a numbered list that is not a step.
fn steps(text: &str) -> Result<Vec<Step<'_>>, String> {
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
fn step(line: usize, item: &str) -> Option<Step<'_>> {
    let head = item.split_once(": ").map_or(item, |(head, _)| head);
    let mut quoted = head.split('`').skip(1).step_by(2);
    let file = quoted.next().filter(|file| file.ends_with(".rs"))?;
    let names: Vec<&str> = quoted.collect();
    (!names.is_empty()).then_some(Step { line, file, names })
}

/// Keywords that define the name after them.
const KEYWORDS: [&str; 9] = ["fn", "struct", "enum", "trait", "type", "const", "static", "mod", "macro_rules!"];

/// The names that a source does not define.
fn undefined<'n>(source: &str, names: &[&'n str]) -> Vec<&'n str> {
    let words: Vec<&str> = source.split([' ', '\n', '(', '<', ':', '{', ';']).filter(|word| !word.is_empty()).collect();
    let defined = |name| words.windows(2).any(|pair| pair[1] == name && KEYWORDS.contains(&pair[0]));
    names.iter().copied().filter(|name| !name.split("::").all(defined)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_name_that_is_only_used_is_missing() {
        let source = "
            pub struct Telegram<'a>(&'a [u8]);
            impl<'a> Telegram<'a> { pub const fn parse(octets: &[u8]) -> Self { helper() } }
            const LIMIT: u8 = 1;
            macro_rules! table { () => {} }
            fn takes(_: impl Used, _: u8) { other!(x) }
        ";
        let defined = ["parse", "Telegram::parse", "Telegram", "LIMIT", "table", "takes"];
        assert_eq!(undefined(source, &defined), [""; 0]);
        let missing = ["helper", "Telegram::emit", "octets", "Used", "x", "other", "pars"];
        assert_eq!(undefined(source, &missing), missing);
    }

    #[test]
    fn a_numbered_item_is_a_step_and_other_lines_are_not() {
        let text = "1. `before.rs` `ignored`\n## Walks\ntext `a`\n\n1. `crates/a.rs` `b`, `C::d`: what `e` does\n12. `f.rs` `g`\n## Next\n1. `after.rs` `x`";
        let expected = [
            Step { line: 5, file: "crates/a.rs", names: vec!["b", "C::d"] },
            Step { line: 6, file: "f.rs", names: vec!["g"] },
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
        let step = Step { line: 1, file: "crates/none.rs", names: vec!["x"] };
        assert!(missing(&step)[0].contains("cannot be read"), "{:?}", missing(&step));
    }
}
