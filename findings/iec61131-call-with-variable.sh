#!/usr/bin/env bash
# iec61131 0.7.0 (a parser of structured text in Rust): a function call whose argument is a variable is a syntax error.
#
# Expected (the non-formal call of IEC 61131-3): `Y := ABS(X);` is a call with one argument, as `Y := ABS(1);` is.
#
# Seen: an argument that begins with a name is taken for the name of a parameter, and anything but `:=` behind it is refused with "Invalid
# argument syntax": ABS(X), MAX(1, X), ABS(X + 1), BYTE_TO_INT(A[0]). Read without an error: ABS(1), ABS(IN := X), ABS((X)).
#
# Why it matters: nearly every program converts a variable with such a call, so a check of structured text with this crate reports errors in
# correct files. Formal arguments, IN := X, are read, but several PLCs know no names for the parameters of conversions. So the function blocks
# that profivac writes have parentheses around each such argument.
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
cd "$folder"
mkdir src
cat >Cargo.toml <<'TOML'
[package]
name = "calls"
version = "0.0.0"
edition = "2021"

[dependencies]
iec61131 = "=0.7.0"
TOML
cat >src/main.rs <<'RUST'
use iec61131::Parser;

const VARIABLES: &str = "VAR X : INT; Y : INT; A : ARRAY[0..3] OF BYTE; END_VAR";

fn main() {
    let cases = [
        ("ABS(1)", true),
        ("ABS(IN := X)", true),
        ("ABS((X))", true),
        ("ABS(X)", false),
        ("ABS(X + 1)", false),
        ("MAX(1, X)", false),
        ("BYTE_TO_INT(A[0])", false),
    ];
    for (call, seen) in cases {
        let result = Parser::new(&format!("PROGRAM P\n{VARIABLES}\nY := {call};\nEND_PROGRAM\n")).parse();
        println!("{call}: {}", result.as_ref().map_or_else(|error| format!("{error:?}"), |_| "read".to_owned()));
        if result.is_ok() != seen {
            eprintln!("iec61131 changed: {call} was {}", if seen { "read" } else { "refused" });
            std::process::exit(1);
        }
    }
}
RUST
cargo run --quiet
