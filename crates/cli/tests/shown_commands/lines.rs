//! The command lines that help texts and pages show, and the commands and options that they only name.

use crate::common::{self, run};
use std::collections::BTreeSet;
use std::fs;
use std::path::{Path, PathBuf};

/// Pages that list what was wrong or was different before.
const HISTORY: [&str; 2] = ["CHANGELOG.md", "docs/corrections.md"];

/// Pages whose console blocks `first_steps` follows in order, with their output.
const TUTORIALS: [&str; 3] = ["docs/first-steps.md", "docs/first-station.md", "docs/plc.md"];

/// Folders that are built or fetched.
const OTHERS: [&str; 3] = ["target", "node_modules", ".git"];

/// Words that stand for a file, a command, or a number that the reader chooses.
const PLACEHOLDERS: [&str; 6] = ["COMMAND", "GATEWAY", "DEV", "FILE", "FILE.toml", "FILE.pcapng"];

/// A command line, and where it stands.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Shown {
    pub line: String,
    pub place: String,
}

impl Shown {
    /// The words from the command of the program on.
    fn words(&self) -> impl Iterator<Item = &str> {
        self.line.split_whitespace().skip_while(|word| *word != "profivac").skip(1)
    }

    /// The command of the program.
    pub fn command(&self) -> &str {
        self.words().next().unwrap_or_default()
    }

    /// Whether the line is complete, so that a user can type it.
    fn is_complete(&self) -> bool {
        !self.line.contains("...") && !self.words().any(|word| PLACEHOLDERS.contains(&word))
    }

    /// Whether the line only names a command and options: `profivac sniff --statistics`, `profivac gsd check`.
    fn is_name(&self) -> bool {
        let names = |word: &str| ["check", "show"].contains(&word) && ["device", "gsd"].contains(&self.command());
        self.words().skip(1).all(|word| word.starts_with('-') || names(word))
    }
}

/// What a text shows.
#[derive(Debug, Default, PartialEq, Eq)]
pub struct Lines {
    /// Lines that a user can type.
    pub complete: Vec<Shown>,
    /// Commands with options that a sentence names, and lines with placeholders.
    pub named: Vec<Shown>,
}

impl Lines {
    /// Of all help texts and pages, each line once.
    pub fn all() -> Self {
        let mut all = Self::default();
        for (place, help) in helps() {
            let examples = help.lines().filter(|line| line.starts_with("  ") && !line.starts_with("   "));
            examples.for_each(|line| all.add_typed(line, &place));
            all.add_spans(&help, &place);
        }
        for (place, page) in pages() {
            all.add_page(&page, &place);
        }
        let mut seen = BTreeSet::new();
        for lines in [&mut all.complete, &mut all.named] {
            // Without the archive the program lacks its command.
            lines.retain(|shown| cfg!(feature = "archive") || shown.command() != "archive");
            lines.retain(|shown| seen.insert(shown.line.clone()));
        }
        all
    }

    /// The lines of a page: of its fenced blocks, and of the code within its sentences and tables.
    fn add_page(&mut self, page: &str, place: &str) {
        let mut prose = String::new();
        let mut block: Option<&str> = None;
        for line in page.replace("\\\n", " ").lines() {
            match (line.trim_start().strip_prefix("```"), block) {
                (Some(language), None) => block = Some(if language == "console" { "console" } else { "" }),
                (Some(_), Some(_)) => block = None,
                (None, Some("console")) if TUTORIALS.contains(&place) => {}
                (None, Some(_)) => {
                    self.add_typed(line, place);
                    self.add_spans(line, place);
                }
                (None, None) => prose += &format!("{line}\n"),
            }
        }
        prose.split("\n\n").for_each(|paragraph| self.add_spans(paragraph, place));
    }

    /// A line of a block, if it is a command line. `a && b` are two.
    fn add_typed(&mut self, line: &str, place: &str) {
        let Some(line) = typed(line) else { return };
        for part in line.split(" && ").filter(|part| part.contains("profivac ")) {
            self.add(part, place, false);
        }
    }

    /// The code within a text, in backticks.
    fn add_spans(&mut self, text: &str, place: &str) {
        let joined = text.split_whitespace().collect::<Vec<_>>().join(" ").replace("\\|", "|");
        for span in joined.split('`').skip(1).step_by(2).filter(|span| typed(span).is_some()) {
            self.add(span, place, true);
        }
    }

    /// A line of a block, or one within a sentence, which may only name a command.
    fn add(&mut self, line: &str, place: &str, is_in_sentence: bool) {
        let line = line.split_whitespace().collect::<Vec<_>>().join(" ");
        let shown = Shown { line, place: place.to_owned() };
        if shown.is_complete() && !(is_in_sentence && shown.is_name()) {
            self.complete.push(shown);
        } else if shown.command() != "..." {
            self.named.push(shown);
        }
    }
}

/// The command line in a line of a block: behind a prompt and `sudo`, and with a comment taken off.
fn typed(line: &str) -> Option<&str> {
    let line = line.trim();
    let line = match line.split_once("$ ") {
        Some((prompt, typed)) if prompt.bytes().all(|octet| octet.is_ascii_lowercase()) => typed,
        _ => line,
    };
    let line = line.strip_prefix("sudo -u profivac ").or_else(|| line.strip_prefix("sudo ")).unwrap_or(line);
    let line = line.split(" #").next().unwrap_or_default().trim();
    let mut words = line.split(' ').skip_while(|word| word.split_once('=').is_some_and(|(name, _)| is_variable(name)));
    let is_ours = words.next() == Some("profivac") && words.next().is_some();
    (is_ours || line.contains("| profivac ")).then_some(line)
}

fn is_variable(name: &str) -> bool {
    !name.is_empty() && name.bytes().all(|octet| octet.is_ascii_uppercase() || octet == b'_')
}

/// The help texts of the program, its commands and their commands.
fn helps() -> Vec<(String, String)> {
    let help = |arguments: &[&str]| {
        let output = run(&[arguments, &["--help"]].concat());
        (format!("profivac {} --help", arguments.join(" ")), String::from_utf8(output.stdout).unwrap())
    };
    let mut all = vec![help(&[])];
    for command in common::commands() {
        let of_command = help(&[&command]);
        let below = common::listed_commands(&of_command.1);
        all.extend(below.iter().map(|name| help(&[&command, name])));
        all.push(of_command);
    }
    all
}

/// The help text for a command line, which names its options.
pub fn help_of(shown: &Shown) -> String {
    let command: Vec<&str> = shown.words().take(1).filter(|word| !word.starts_with('-')).collect();
    let output = run(&[&["help"], &command[..]].concat());
    assert!(output.status.success(), "{}: {}: there is no such command", shown.place, shown.line);
    String::from_utf8(output.stdout).unwrap()
}

/// The options that a line names.
pub fn options(shown: &Shown) -> impl Iterator<Item = &str> {
    shown.words().filter(|word| word.starts_with('-') && word.len() > 1)
}

pub fn sources() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../..").canonicalize().unwrap()
}

/// The pages of the repository, with their paths.
fn pages() -> Vec<(String, String)> {
    let (root, mut pages) = (sources(), Vec::new());
    let mut folders = vec![root.clone()];
    while let Some(folder) = folders.pop() {
        for entry in fs::read_dir(&folder).unwrap() {
            let entry = entry.unwrap();
            let (path, name) = (entry.path(), entry.file_name().into_string().unwrap());
            let place = path.strip_prefix(&root).unwrap().to_str().unwrap().to_owned();
            if entry.file_type().unwrap().is_dir() {
                folders.extend((!OTHERS.contains(&name.as_str())).then_some(path));
            } else if name.ends_with(".md") && !HISTORY.contains(&place.as_str()) {
                pages.push((place, fs::read_to_string(&path).unwrap()));
            }
        }
    }
    pages.sort();
    pages
}

#[test]
fn command_lines_are_found_in_every_form() {
    let page = "\
A sentence names `profivac sniff` and `profivac sniff --raw`, shows `profivac read
--port P x`, a form `profivac decode FILE`, and profivac itself; `psql -U profivac -c x` is another program.

| `profivac gsd --out a\\|b` | a cell |

```console
$ profivac list a
profivac list shows this
gauges$ profivac hub b
```
   ```sh
   sudo -u profivac profivac run c      # a comment
   TZ=UTC profivac report d && profivac export \\
     e
   echo 1 | profivac decode --raw
   for i in 1 2; do
     profivac write ... x
   done
   import profivac as pv
   station ──▶ profivac archive ──▶ PostgreSQL
   next: `profivac doctor f`
   ```
";
    let lines = |place: &str| {
        let mut lines = Lines::default();
        lines.add_page(page, place);
        let text = |shown: &[Shown]| shown.iter().map(|shown| shown.line.clone()).collect::<Vec<_>>();
        (text(&lines.complete), text(&lines.named))
    };
    let console = ["profivac list a", "profivac list shows this", "profivac hub b"];
    let rest = [
        "profivac run c",
        "TZ=UTC profivac report d",
        "profivac export e",
        "echo 1 | profivac decode --raw",
        "profivac doctor f",
        "profivac read --port P x",
        "profivac gsd --out a|b",
    ];
    let named = ["profivac write ... x", "profivac sniff", "profivac sniff --raw", "profivac decode FILE"];
    assert_eq!(
        lines("docs/a.md"),
        (
            [&console[..], &rest].concat().iter().map(|line| (*line).to_owned()).collect(),
            named.map(str::to_owned).to_vec()
        )
    );
    assert_eq!(lines(TUTORIALS[0]).0, rest);
}
