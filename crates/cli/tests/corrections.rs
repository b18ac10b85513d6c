//! The tests that `docs/corrections.md` names exist.

use std::fs;
use std::path::Path;

#[test]
fn every_test_of_the_list_of_corrections_exists() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..");
    let page = fs::read_to_string(root.join("docs/corrections.md")).unwrap();
    let named: Vec<_> = page.split('`').filter_map(|quoted| quoted.split_once("::")).collect();
    let named: Vec<_> = named.into_iter().filter(|(file, _)| file.contains('/')).collect();
    assert!(named.len() > 100, "only {} tests", named.len());
    for (file, name) in named {
        let source = fs::read_to_string(root.join("crates").join(file)).unwrap_or_default();
        let exists = source.contains(&format!("fn {name}(")) || source.contains(&format!("test('{name}'"));
        assert!(exists, "there is no test {name:?} in crates/{file}");
    }
}
