//! Rules for names in the configuration file.

use super::error::{ConfigProblem, Located, NamedItem};
use profivac_web_server::visible_text::{MAX_NAME, TextProblem, check_line, check_name};
use std::collections::HashSet;
use std::path::Path;
use toml::Spanned;

/// Checks that every name is filled in, visible, no path and unique. A port may be a path.
pub fn unique<'a>(item: NamedItem, names: impl Iterator<Item = &'a Spanned<String>>) -> Result<(), Located> {
    let mut seen = HashSet::new();
    for name in names {
        let text = name.get_ref();
        check(item, name)?;
        if !seen.insert(text) {
            return Err(Located::new(name.span(), ConfigProblem::Duplicate { item, name: text.clone() }));
        }
    }
    Ok(())
}

/// Checks one name. A port may have any length.
pub fn check(item: NamedItem, name: &Spanned<String>) -> Result<(), Located> {
    let text = name.get_ref();
    let checked = if item == NamedItem::Port { check_line(text) } else { check_name(text) };
    checked.map_err(|problem| {
        let problem = match problem {
            TextProblem::Empty => ConfigProblem::EmptyName(item),
            problem => ConfigProblem::Text(problem),
        };
        Located::new(name.span(), problem)
    })?;
    let found = text.chars().count();
    if item != NamedItem::Port && found > MAX_NAME {
        return Err(Located::new(name.span(), ConfigProblem::LongText { item, most: MAX_NAME, found }));
    }
    Ok(())
}

/// Checks a text of at most `most` characters.
pub fn check_length(item: NamedItem, text: &Spanned<String>, most: usize) -> Result<(), Located> {
    check(item, text)?;
    let found = text.get_ref().chars().count();
    if found > most {
        return Err(Located::new(text.span(), ConfigProblem::LongText { item, most, found }));
    }
    Ok(())
}

/// The name of the file at `path` without its extension.
pub fn stem(path: &Path) -> String {
    path.file_stem().map_or_else(|| "station".to_owned(), |stem| stem.to_string_lossy().into_owned())
}
