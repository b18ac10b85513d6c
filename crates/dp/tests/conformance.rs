//! The tests that `docs/conformance.md` names as proofs exist, and the telegrams that the reference prints are valid.

use profivac_wire::Telegram;
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

/// Two upper-case hexadecimal digits.
fn octet(word: &str) -> Option<u8> {
    let is_octet = word.len() == 2 && word.bytes().all(|digit| matches!(digit, b'0'..=b'9' | b'A'..=b'F'));
    is_octet.then(|| u8::from_str_radix(word, 16).ok()).flatten()
}

/// Length octets, check octet and end delimiter, as the page of the reference promises.
#[test]
fn every_telegram_that_the_reference_prints_is_valid() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../docs/spec/profibus-wire");
    let mut telegrams = 0;
    for file in std::fs::read_dir(folder).expect("the reference") {
        let page = std::fs::read_to_string(file.expect("a page").path()).expect("a text");
        for line in page.lines() {
            let words: Vec<Option<u8>> = line.split([' ', '`', '|']).map(octet).collect();
            for octets in words.split(Option::is_none) {
                let octets: Vec<u8> = octets.iter().copied().flatten().collect();
                if let [0x68, _, _, 0x68, ..] | [0x10, _, _, _, _, _] | [0xA2, _, _, _, _, ..] = octets[..] {
                    assert!(Telegram::parse(&octets).is_ok(), "{line}");
                    telegrams += 1;
                }
            }
        }
    }
    assert!(telegrams >= 87, "only {telegrams} telegrams");
}
