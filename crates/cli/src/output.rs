//! Data on standard output. Whoever reads it may stop reading: that is no reason to fail.

use std::io::{self, Write};

/// Writes lines.
pub fn out(lines: &str) {
    let mut out = io::stdout().lock();
    writeln!(out, "{lines}").and_then(|()| out.flush()).ok();
}
