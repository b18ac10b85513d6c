//! A program of several test files runs those that its `main.rs` names.

#![allow(clippy::expect_used, reason = "a test")]

use std::{fs, path::Path};

#[test]
fn main_names_every_file() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests");
    let main = fs::read_to_string(folder.join("main.rs")).expect("main.rs");
    for entry in fs::read_dir(folder).expect("the tests") {
        let path = entry.expect("a file").path();
        let name = path.file_stem().and_then(|stem| stem.to_str()).unwrap_or_default();
        let is_module = path.extension().is_some_and(|extension| extension == "rs") && name != "main";
        assert!(!is_module || main.contains(&format!("\nmod {name};\n")), "main.rs does not name {}", path.display());
    }
}
