//! Names in the file: each stands once.

use super::Complaint;
use std::collections::HashSet;
use toml::Spanned;

/// No name may stand twice, and none be empty.
pub fn unique<'a>(what: &str, names: impl Iterator<Item = &'a Spanned<String>>) -> Result<(), Complaint> {
    let mut seen = HashSet::new();
    for name in names {
        if name.get_ref().trim().is_empty() {
            let article = if what.starts_with('a') { "an" } else { "a" };
            return Err((name.span(), format!("expected the name of {article} {what}, got nothing")));
        }
        if !seen.insert(name.get_ref()) {
            return Err((name.span(), format!("the {what} {:?} stands twice", name.get_ref())));
        }
    }
    Ok(())
}
