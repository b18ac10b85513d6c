//! Data on standard output. Whoever reads it may stop reading: that is no reason to fail.

use std::io::{self, Write};

/// Writes lines.
pub fn out(lines: &str) {
    let mut out = io::stdout().lock();
    writeln!(out, "{lines}").and_then(|()| out.flush()).ok();
}

/// Something as JSON.
pub fn json(value: &impl serde::Serialize) -> String {
    // Texts, numbers and lists always have a JSON form.
    serde_json::to_string_pretty(value).unwrap_or_default()
}
