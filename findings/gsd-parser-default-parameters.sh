#!/usr/bin/env bash
# gsd-parser 0.6.0 (the GSD reader of the profirust project): two ways in which the default user parameters differ from the file.
#
# Expected (GSD specification, keywords of revision 3): Ext_User_Prm_Data_Const fills the octets, and each Ext_User_Prm_Data_Ref puts the
# default of its parameter into its own bits; the other bits of the octet stay.
#
# Seen, without an error or a warning:
# - A BitArea replaces the whole octet: parameters that came before it in the same octet, and constants, become 0.
# - A Bit with the default 0 does not clear a constant 1.
#
# Why it matters: Set_Prm with these octets is refused, or the slave works with other settings than the engineering tool shows. Compare the
# default octets with those of a second reader before a device is parameterised.
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
cd "$folder"
mkdir src
cat >Cargo.toml <<'TOML'
[package]
name = "defaults"
version = "0.0.0"
edition = "2021"

[dependencies]
gsd-parser = "=0.6.0"
TOML
cat >src/main.rs <<'RUST'
use gsd_parser::{parser, PrmBuilder};
use std::path::Path;

const HEAD: &str = "#Profibus_DP\nGSD_Revision = 3\nVendor_Name = \"Example\"\nModel_Name = \"Example\"\nRevision = \"1\"\n\
    Ident_Number = 0x0001\nProtocol_Ident = 0\nStation_Type = 0\n";

fn defaults(text: &str) -> String {
    let file = parser::parse(Path::new("example.gsd"), &format!("{HEAD}{text}")).expect("a valid file");
    let octets: Vec<_> = PrmBuilder::new(&file.user_prm_data).into_bytes().iter().map(|octet| format!("{octet:02X}")).collect();
    octets.join(" ")
}

fn check(what: &str, text: &str, right: &str, seen: &str) {
    let found = defaults(text);
    println!("{what}: by the file {right:?}, read {found:?}");
    if found != seen {
        eprintln!("gsd-parser changed: {what} was {seen:?}");
        std::process::exit(1);
    }
}

fn main() {
    // Bit 0 is 1, bits 4 and 5 are 2.
    let area = "ExtUserPrmData = 1 \"Alarms\"\nBit(0) 1 0-1\nEndExtUserPrmData\n\
        ExtUserPrmData = 2 \"Filter\"\nBitArea(4-5) 2 0-3\nEndExtUserPrmData\n\
        Max_User_Prm_Data_Len = 1\nExt_User_Prm_Data_Const(0) = 0x80\nExt_User_Prm_Data_Ref(0) = 1\nExt_User_Prm_Data_Ref(0) = 2\n";
    check("a bit and an area in one octet", area, "A1", "20");
    let bit = "ExtUserPrmData = 1 \"Alarms\"\nBit(0) 0 0-1\nEndExtUserPrmData\n\
        Max_User_Prm_Data_Len = 1\nExt_User_Prm_Data_Const(0) = 0x81\nExt_User_Prm_Data_Ref(0) = 1\n";
    check("a bit whose default is 0 over a constant", bit, "80", "81");
}
RUST
cargo run --quiet
echo 'as described: default parameters are lost'
