//! The tables that tests print into docs/adapters.md, for tests of several crates.

#![allow(clippy::unwrap_used, reason = "helpers of tests are tests")]

use std::path::Path;

/// Fails if the page has another table than `table` between the marks of `name`. With PROFIVAC_BLESS=1 writes it there.
pub fn check_table(name: &str, table: &str) {
    let (begin, end) = (format!("<!-- table of {name}: begin -->\n"), format!("<!-- table of {name}: end -->\n"));
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../docs/adapters.md");
    let page = std::fs::read_to_string(&path).unwrap();
    let (before, rest) = page.split_once(&begin).unwrap();
    let (old, after) = rest.split_once(&end).unwrap();
    if std::env::var("PROFIVAC_BLESS").is_ok_and(|bless| bless == "1") {
        std::fs::write(&path, [before, &begin, table, &end, after].concat()).unwrap();
    } else {
        assert!(old == table, "docs/adapters.md differs; PROFIVAC_BLESS=1 accepts this:\n{table}");
    }
}
