//! Files for the tests: all invented.

use profivac_gsd::{Fault, GsdFile};

/// A file with these lines behind the header and the ident.
pub fn file(lines: &str) -> GsdFile {
    GsdFile::read(format!("#Profibus_DP\nIdent_Number = 0x1234\n{lines}\n").as_bytes())
}

/// The problems of the file, each with its line, without the one that the file has no modules.
pub fn problems(file: &GsdFile) -> Vec<(usize, Fault)> {
    let problems = file.problems().iter().filter(|problem| problem.fault != Fault::NoModules);
    problems.map(|problem| (problem.line, problem.fault)).collect()
}
