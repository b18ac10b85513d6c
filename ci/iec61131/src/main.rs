//! Reads files of structured text with the crate `iec61131`.
//!
//! Usage: names-of-blocks FILE...
//!
//! Prints a line for each file: the names of its function blocks. Ends with an error at the first file that the crate does not read, or that
//! has anything but function blocks with statements.

use iec61131::{Parser, PouDeclaration};
use std::error::Error;

fn main() -> Result<(), Box<dyn Error>> {
    for path in std::env::args().skip(1) {
        let text = std::fs::read_to_string(&path)?;
        let unit = Parser::new(&text).parse().map_err(|error| {
            let line = text.bytes().take(error.span.start).filter(|octet| *octet == b'\n').count() + 1;
            format!("{path}:{line}: iec61131 does not read: {}", error.message)
        })?;
        let mut names = Vec::new();
        for declaration in unit.declarations {
            match declaration {
                PouDeclaration::FunctionBlock(block) if block.body.as_ref().is_some_and(|body| !body.is_empty()) => {
                    names.push(block.name);
                }
                other => return Err(format!("{path}: no function block with statements: {other:?}").into()),
            }
        }
        println!("{}", names.join(" "));
    }
    Ok(())
}
