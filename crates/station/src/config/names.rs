//! Rules for names in the configuration file.

use super::error::{ConfigProblem, Located, NamedItem};
use std::collections::HashSet;
use toml::Spanned;

/// Checks that every name is filled in, contains no control characters and is unique.
pub fn unique<'a>(item: NamedItem, names: impl Iterator<Item = &'a Spanned<String>>) -> Result<(), Located> {
    let mut seen = HashSet::new();
    for name in names {
        let text = name.get_ref();
        let problem = if text.trim().is_empty() {
            ConfigProblem::EmptyName(item)
        } else if text.contains(char::is_control) {
            ConfigProblem::ControlCharacters(text.clone())
        } else if !seen.insert(text) {
            ConfigProblem::Duplicate { item, name: text.clone() }
        } else {
            continue;
        };
        return Err(Located::new(name.span(), problem));
    }
    Ok(())
}
