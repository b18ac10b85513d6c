//! Texts that tests compare with files of the repository. `cargo xtask goldens` writes the files; the difference is part of a review.

#![allow(clippy::expect_used, reason = "a test")]

use std::{env, fs, path::Path};

/// Compares `text` with the file at `path` from the root of the repository, or writes the file if `PROFIVAC_BLESS` is 1.
#[track_caller]
pub fn compare(path: &str, text: &str) {
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..").join(path);
    if env::var("PROFIVAC_BLESS").is_ok_and(|bless| bless == "1") {
        fs::create_dir_all(file.parent().expect("a folder")).expect("the folder of a golden");
        fs::write(&file, text).expect("a golden");
    }
    let golden = fs::read_to_string(&file).unwrap_or_default();
    for (number, (expected, now)) in (1..).zip(golden.lines().zip(text.lines())) {
        assert_eq!(now, expected, "{path}, line {number}: `cargo xtask goldens` writes it again");
    }
    let lines = [text, &golden].map(|text| text.lines().count());
    assert!(golden == text, "{path}: {} lines in place of {}, or other line ends", lines[0], lines[1]);
}
