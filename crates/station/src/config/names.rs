//! Names in the file: each stands once, in one line.

use super::SpannedMessage;
use std::collections::HashSet;
use toml::Spanned;

/// No name may stand twice, and none be empty or hold what a terminal takes for a command.
pub fn unique<'a>(what: &str, names: impl Iterator<Item = &'a Spanned<String>>) -> Result<(), SpannedMessage> {
    let mut seen = HashSet::new();
    for name in names {
        if name.get_ref().trim().is_empty() {
            let article = if what.starts_with('a') { "an" } else { "a" };
            return Err((name.span(), format!("expected the name of {article} {what}, got nothing")));
        }
        if name.get_ref().contains(char::is_control) {
            let sentence = format!("expected a name without control characters, got {:?}", name.get_ref());
            return Err((name.span(), sentence));
        }
        if !seen.insert(name.get_ref()) {
            return Err((name.span(), format!("the {what} {:?} stands twice", name.get_ref())));
        }
    }
    Ok(())
}
