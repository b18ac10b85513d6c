//! Golden files of the tests.

/// Compares with a golden file, or writes it if `PROFIVAC_BLESS` is 1.
pub fn golden(path: &str, text: &str) {
    let path = format!("{}/{path}", env!("CARGO_MANIFEST_DIR"));
    if std::env::var("PROFIVAC_BLESS").is_ok_and(|bless| bless == "1") {
        std::fs::write(&path, text).unwrap();
    }
    let expected = std::fs::read_to_string(&path).unwrap();
    assert!(expected == text, "{path} differs; `cargo xtask goldens` writes it again:\n{text}");
}
