//! Data on standard output, remarks on standard error. Whoever reads them may stop reading: that is no reason to fail.

use profivac_host::port::Remark;
use std::fmt::Display;
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

/// Says what somebody should know although the command goes on.
pub fn remark(said: &impl Display) {
    writeln!(io::stderr().lock(), "profivac: {said}").ok();
}

/// Says all that there is to remark.
pub fn remarks(mut next: impl FnMut() -> Option<Remark>) {
    while let Some(said) = next() {
        remark(&said);
    }
}
