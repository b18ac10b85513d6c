//! `profivac gsd check`: the problems of GSD files.

use super::read;
use crate::explanation::counted;
use crate::failure::Failure;
use crate::output::{notice, out, visible};
use clap::Args;
use profivac_gsd::{GsdFile, Problem, Severity};
use profivac_gsd_slave::{FolderFiles, Unread};
use std::cmp::Reverse;
use std::path::{Path, PathBuf};

/// The most files with faults that are listed, and the most without. chosen: more than a plant has; public collections have hundreds.
const MOST_FILES: usize = 100;

/// The most problems of a file that are listed. chosen: a screen; files in other capitals have hundreds.
const MOST_PROBLEMS: usize = 20;

/// Check GSD files: what is wrong in which line, what to do about it, and which open tools do not read it
///
/// profivac reads every file, also one with faults. Exit code 2 if a line is wrong, 0 if there are remarks only.
#[derive(Args, Debug)]
pub struct CheckArguments {
    /// GSD files, or folders, which are read with their subfolders: files that end in .gsd, .gse, .gsg ...
    #[arg(value_name = "FILE|FOLDER", required = true)]
    files: Vec<PathBuf>,
    /// List everything; default: at most 100 files with faults and 100 without, and 20 problems of each file, its faults first
    #[arg(long)]
    all: bool,
}

/// Checks GSD files. If the list is cut, its last line counts the files that it does not name.
pub fn check(arguments: &CheckArguments) -> Result<(), Failure> {
    let mut checked = Checked { lists_all: arguments.all, ..Checked::default() };
    for path in &arguments.files {
        match files(path) {
            Ok(found) => {
                for Unread { path, reason } in &found.unread {
                    checked.unread(&format!("{} cannot be read: {reason}", path.display()));
                }
                found.files.iter().for_each(|file| checked.file(file));
            }
            Err(failure) => checked.unread(&failure.to_string()),
        }
    }
    checked.finish()
}

/// The GSD files at a path: the file itself, or every GSD file of a folder and its folders, as --gsd reads them.
fn files(path: &Path) -> Result<FolderFiles, Failure> {
    if path.is_dir() {
        return Ok(FolderFiles::find(path)?);
    }
    let mut file = FolderFiles::default();
    file.files.push(path.to_owned());
    Ok(file)
}

/// How many files there are of a kind, and how many of them were listed.
#[derive(Default)]
struct Tally {
    all: usize,
    listed: usize,
}

impl Tally {
    /// Counts a file. Returns whether it is listed.
    const fn count(&mut self, lists_all: bool) -> bool {
        self.all = self.all.saturating_add(1);
        let is_listed = lists_all || self.listed < MOST_FILES;
        if is_listed {
            self.listed = self.listed.saturating_add(1);
        }
        is_listed
    }

    const fn left_out(&self) -> usize {
        self.all.saturating_sub(self.listed)
    }
}

/// The files that were checked. A file of a kind is listed at once, until enough of them are: a folder can have thousands.
#[derive(Default)]
struct Checked {
    lists_all: bool,
    /// Files with faults, and files and folders that cannot be read.
    wrong: Tally,
    right: Tally,
}

impl Checked {
    fn unread(&mut self, reason: &str) {
        if self.wrong.count(self.lists_all) {
            notice(&visible(reason));
        }
    }

    fn file(&mut self, path: &Path) {
        let file = match read(path) {
            Ok(file) => file,
            Err(failure) => return self.unread(&failure.to_string()),
        };
        let tally = if file.faults().next().is_none() { &mut self.right } else { &mut self.wrong };
        if tally.count(self.lists_all) {
            let most = if self.lists_all { usize::MAX } else { MOST_PROBLEMS };
            lines(path, &file, most).iter().for_each(|line| out(&visible(line)));
        }
    }

    fn finish(&self) -> Result<(), Failure> {
        let Self { wrong, right, .. } = self;
        if wrong.left_out() > 0 || right.left_out() > 0 {
            out(&format!(
                "not listed: {} with faults or not readable, {} without faults; --all lists them",
                counted(wrong.left_out() as u64, "file"),
                counted(right.left_out() as u64, "file")
            ));
        }
        if wrong.all == 0 {
            return Ok(());
        }
        Err(Failure::usage(format!(
            "{} of {} GSD files have faults or cannot be read; the lines above say where",
            wrong.all,
            wrong.all.saturating_add(right.all)
        )))
    }
}

/// A file with its problems by line. If there are more than `most`, faults come before remarks.
fn lines(path: &Path, file: &GsdFile, most: usize) -> Vec<String> {
    let (faults, problems) = (file.faults().count(), file.problems());
    let mut lines = vec![format!(
        "{}: {}, {}, {}, {}",
        path.display(),
        file.encoding(),
        counted(file.device().modules.len() as u64, "module"),
        counted(faults as u64, "fault"),
        counted(problems.len().saturating_sub(faults) as u64, "remark")
    )];
    let mut shown: Vec<_> = problems.iter().collect();
    if shown.len() > most {
        shown.sort_by_key(|problem| Reverse(problem.severity()));
        shown.truncate(most);
    }
    lines.extend(shown.into_iter().map(line));
    let left_out = problems.len().saturating_sub(most);
    if left_out > 0 {
        lines.push(format!("  and {} more; --all lists them", counted(left_out as u64, "problem")));
    }
    lines
}

fn line(problem: &Problem) -> String {
    let kind = if problem.severity() == Severity::Fault { "fault" } else { "remark" };
    format!("  {kind}, {problem}")
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "a test")]

    use super::*;

    const RIGHT: &[u8] = b"#Profibus_DP\nIdent_Number = 0x12AB\nModule = \"valve\" 0x20\nEndModule\n";

    fn checked(files: Vec<PathBuf>) -> String {
        check(&CheckArguments { files, all: false }).unwrap_err().to_string()
    }

    #[test]
    fn check_reads_the_files_of_a_folder_and_says_that_one_has_none() {
        let folder = tempfile::tempdir().unwrap();
        let write = |name: &str, octets: &[u8]| std::fs::write(folder.path().join(name), octets).unwrap();
        write("valve.txt", b"no GSD file");
        let failure = checked(vec![folder.path().to_owned()]);
        assert!(failure.starts_with("1 of 1 GSD files"), "{failure}");
        write("valve.GSE", RIGHT);
        write("valve.gsd", RIGHT);
        write("pump.gsd", b"#Profibus_DP\n");
        let failure = checked(vec![folder.path().to_owned()]);
        assert!(failure.starts_with("1 of 3 GSD files"), "{failure}");
    }

    #[test]
    fn check_goes_on_after_a_file_that_cannot_be_read() {
        let failure = checked(["missing-1.gsd", "missing-2.gsd"].map(PathBuf::from).to_vec());
        assert!(failure.starts_with("2 of 2 GSD files have faults or cannot be read"), "{failure}");
    }

    #[test]
    fn of_many_problems_the_faults_are_listed_and_the_others_counted() {
        let mut text = String::from("#Profibus_DP\nIdent_Number = 1\nModule = \"m\" 0x10\nEndModule\n");
        text += &"Unknown = 1\n".repeat(30);
        text += "MAX_MODULE = none\n";
        let file = GsdFile::read(text.as_bytes());
        let shown = lines(Path::new("m.gsd"), &file, MOST_PROBLEMS);
        let problems = file.problems().len();
        assert_eq!(shown.len(), 1 + MOST_PROBLEMS + 1);
        assert!(shown[1].starts_with("  fault, line 35: value cannot be read"), "{}", shown[1]);
        assert!(shown[2].starts_with("  remark, line 5: "), "{}", shown[2]);
        assert_eq!(shown[21], format!("  and {} problems more; --all lists them", problems - MOST_PROBLEMS));
        assert_eq!(lines(Path::new("m.gsd"), &file, usize::MAX).len(), 1 + problems);
    }
}
