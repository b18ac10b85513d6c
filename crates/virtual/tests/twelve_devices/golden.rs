//! Text files beside the tests. `cargo xtask goldens` writes them; the difference is part of a review.

use std::{env, fs, path::Path};

/// Compares `text` with the golden of this name.
pub fn check(name: &str, text: &str) {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/golden").join(name);
    if env::var_os("PROFIVAC_BLESS").is_some() {
        fs::write(&path, text).unwrap();
    }
    let golden = fs::read_to_string(&path).unwrap_or_default();
    for (number, (expected, now)) in (1..).zip(golden.lines().zip(text.lines())) {
        assert_eq!(expected, now, "{name}, line {number}");
    }
    assert_eq!(golden.lines().count(), text.lines().count(), "{name}: the number of lines");
}
