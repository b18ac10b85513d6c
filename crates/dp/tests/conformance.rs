//! The tests that `docs/conformance.md` names as proofs exist.

use std::collections::BTreeSet;
use std::path::Path;

/// `crates/FILE` holds a function `NAME` for every `FILE::NAME` in backquotes.
#[test]
fn every_test_that_is_named_as_a_proof_exists() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..");
    let page = std::fs::read_to_string(root.join("docs/conformance.md")).expect("the page");
    let proofs: BTreeSet<_> = page.split('`').filter_map(|quoted| quoted.split_once(".rs::")).collect();
    assert!(proofs.len() > 100, "only {} proofs", proofs.len());
    for (file, name) in proofs {
        let source = std::fs::read_to_string(root.join("crates").join(file).with_extension("rs")).unwrap_or_default();
        let test = format!("#[test]\nfn {name}()");
        let indented = format!("#[test]\n    fn {name}()");
        assert!(source.contains(&test) || source.contains(&indented), "there is no test {name} in crates/{file}.rs");
    }
}
