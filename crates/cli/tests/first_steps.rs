//! A new user's first quarter of an hour, as docs/first-steps.md tells it: every command of its console blocks is run, in order,
//! in an empty folder, and what comes must be what stands there.
//!
//! | In a block | Means |
//! |---|---|
//! | `$ COMMAND` | typed in a shell; what follows is all that it prints. It must end with 0 unless `$ echo $?` comes next |
//! | `NAME$ COMMAND` | typed in a terminal of its own, where it goes on running; what follows comes from it before anything else is done |
//! | `NAME: LINE` | typed there for the running command; without a line: what has come there meanwhile |
//! | `NAME: ^C` | Ctrl-C there: it must end with 0, and what follows is all that had not been looked at |
//! | `...` | within a line any text, as a line any lines |

#![allow(clippy::unwrap_used, clippy::panic, reason = "a test")]

mod common;

use common::{Folder, Program};
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

/// What may stand for any text.
const ANY: &str = "...";

/// Something typed, and what comes.
#[derive(Debug, PartialEq, Eq)]
struct Step {
    line: usize,
    typed: Typed,
    expected: Vec<String>,
}

#[derive(Debug, PartialEq, Eq)]
enum Typed {
    /// In the shell.
    Command(String),
    /// In the shell of another terminal.
    Start(String, String),
    /// For the program in another terminal.
    Say(String, String),
}

/// The steps of a page.
fn steps(page: &str) -> Vec<Step> {
    let (mut steps, mut terminals, mut is_console) = (Vec::<Step>::new(), Vec::new(), false);
    for (line, text) in (1..).zip(page.lines()) {
        if text.starts_with("```") {
            is_console = text == "```console";
        } else if let (true, Some(typed)) = (is_console, typed(text, &terminals)) {
            if let Typed::Start(name, _) = &typed {
                terminals.push(name.clone());
            }
            steps.push(Step { line, typed, expected: Vec::new() });
        } else if is_console {
            let step = steps.last_mut().unwrap_or_else(|| panic!("line {line}: nothing was typed"));
            step.expected.push(text.to_owned());
        }
    }
    steps
}

fn typed(text: &str, terminals: &[String]) -> Option<Typed> {
    if let Some((name, command)) = text.split_once("$ ") {
        let is_name = name.bytes().all(|octet| octet.is_ascii_lowercase());
        return match name {
            "" => Some(Typed::Command(command.to_owned())),
            _ if is_name => Some(Typed::Start(name.to_owned(), command.to_owned())),
            _ => None,
        };
    }
    let (name, said) = text.split_once(':')?;
    let is_there = terminals.iter().any(|terminal| terminal == name);
    is_there.then(|| Typed::Say(name.to_owned(), said.trim().to_owned()))
}

/// Whether a text is what stands on the page.
fn is_text(expected: &str, text: &str) -> bool {
    match expected.split_once(ANY) {
        None => expected == text,
        Some((begin, rest)) => text.strip_prefix(begin).is_some_and(|text| {
            text.char_indices().map(|(at, _)| at).chain([text.len()]).any(|at| is_text(rest, &text[at..]))
        }),
    }
}

/// Whether lines are what stands on the page.
fn are_lines(expected: &[String], lines: &[String]) -> bool {
    match (expected.split_first(), lines.split_first()) {
        (None, first) => first.is_none(),
        (Some((first, rest)), None) => first == ANY && are_lines(rest, lines),
        (Some((first, rest)), Some((_, later))) if first == ANY => are_lines(rest, lines) || are_lines(expected, later),
        (Some((first, rest)), Some((line, later))) => is_text(first, line) && are_lines(rest, later),
    }
}

/// The desk of a user: a folder, a home with the sources, and programs that run in other terminals.
struct Desk {
    folder: Folder,
    programs: BTreeMap<String, Program>,
    /// How the last command ended.
    code: i32,
}

fn sources() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../..").canonicalize().unwrap()
}

impl Desk {
    fn new() -> Self {
        let folder = Folder::new();
        for name in ["home", "work"] {
            std::fs::create_dir(folder.path(name)).unwrap();
        }
        std::os::unix::fs::symlink(sources(), folder.path("home/profivac")).unwrap();
        Self { folder, programs: BTreeMap::new(), code: 0 }
    }

    /// A command as a shell takes it. What it says and what it complains about come on one terminal.
    fn shell(&self, command: &str) -> Command {
        let program = Path::new(env!("CARGO_BIN_EXE_profivac")).parent().unwrap();
        let path = format!("{}:{}", program.display(), std::env::var("PATH").unwrap());
        let mut shell = Command::new("sh");
        shell.args(["-c", &format!("{command} 2>&1")]).current_dir(self.folder.path("work"));
        shell.env("PATH", path).env("HOME", self.folder.path("home")).stdin(Stdio::null());
        shell
    }

    /// Does one step and returns what came.
    fn follow(&mut self, step: &Step) -> Vec<String> {
        match &step.typed {
            Typed::Command(command) if command == "echo $?" => vec![std::mem::take(&mut self.code).to_string()],
            Typed::Command(command) => {
                assert_eq!(self.code, 0, "before line {}: a command failed", step.line);
                let output = self.shell(command).output().unwrap();
                self.code = output.status.code().unwrap();
                String::from_utf8(output.stdout).unwrap().lines().map(str::to_owned).collect()
            }
            Typed::Start(name, command) => {
                let program = Program::of(&mut self.shell(&format!("exec {command}")));
                let came = until(&program, &step.expected);
                self.programs.insert(name.clone(), program);
                came
            }
            Typed::Say(name, said) if said == "^C" => {
                let mut program = self.programs.remove(name).unwrap();
                program.interrupt();
                let came = std::iter::from_fn(|| program.next_line()).collect();
                assert_eq!(program.exit_code(), 0, "line {}", step.line);
                came
            }
            Typed::Say(name, said) => {
                let program = self.programs.get_mut(name).unwrap();
                if !said.is_empty() {
                    program.say(said);
                }
                until(program, &step.expected)
            }
        }
    }
}

/// What a running program prints, until it is what is expected.
fn until(program: &Program, expected: &[String]) -> Vec<String> {
    let mut came = Vec::new();
    while !are_lines(expected, &came) {
        match program.next_line() {
            Some(line) => came.push(line),
            None => return came,
        }
    }
    came
}

#[test]
fn the_first_quarter_of_an_hour_is_as_it_is_told() {
    let page = std::fs::read_to_string(sources().join("docs/first-steps.md")).unwrap();
    let mut desk = Desk::new();
    for step in steps(&page) {
        let came = desk.follow(&step);
        let Step { line, typed, expected } = &step;
        assert!(
            are_lines(expected, &came),
            "docs/first-steps.md:{line}: {typed:?}\nexpected:\n{}\ncame:\n{}\n",
            expected.join("\n"),
            came.join("\n")
        );
    }
    assert_eq!(desk.code, 0, "the last command failed");
}

/// Nothing a new user needs is left out.
#[test]
fn every_command_is_met() {
    let page = std::fs::read_to_string(sources().join("docs/first-steps.md")).unwrap();
    let commands: Vec<String> = steps(&page)
        .into_iter()
        .filter_map(|step| match step.typed {
            Typed::Command(command) | Typed::Start(_, command) => Some(command),
            Typed::Say(..) => None,
        })
        .collect();
    for command in [
        "demo",
        "simulate",
        "hub",
        "scan",
        "address",
        "list",
        "read",
        "write",
        "dump",
        "diff",
        "restore",
        "monitor",
        "init",
        "run",
        "sniff",
        "decode",
        "conform",
        "gsd",
        "completions",
    ] {
        let begin = format!("profivac {command} ");
        assert!(commands.iter().any(|it| it.starts_with(&begin)), "{command}");
    }
    assert!(commands.iter().any(|command| command.starts_with("tshark ")));
}

#[test]
fn a_page_is_read_as_it_is_meant() {
    let page = "text\n```sh\n$ no\n```\n```console\n$ a b\nc: d\nx$ e\nready\nx: ^C\nx:\n```\n$ no";
    let step = |line, typed, expected: &[&str]| Step {
        line,
        typed,
        expected: expected.iter().map(|&line| line.to_owned()).collect(),
    };
    let say = |said: &str| Typed::Say("x".to_owned(), said.to_owned());
    let expected = [
        step(6, Typed::Command("a b".to_owned()), &["c: d"]),
        step(8, Typed::Start("x".to_owned(), "e".to_owned()), &["ready"]),
        step(10, say("^C"), &[]),
        step(11, say(""), &[]),
    ];
    assert_eq!(steps(page), expected);
}

#[test]
fn dots_stand_for_anything_and_nothing_else_does() {
    let are = |expected: &str, came: &str| {
        let lines = |text: &str| text.lines().map(str::to_owned).collect::<Vec<_>>();
        are_lines(&lines(expected), &lines(came))
    };
    for (expected, came) in [("a\nb", "a\nb"), ("a ... c", "a b c"), ("...\nb\n...", "b"), ("a\n...\nd", "a\nb\nc\nd")]
    {
        assert!(are(expected, came), "{expected:?} {came:?}");
    }
    for (expected, came) in [("a", "a\nb"), ("a\nb", "a"), ("a ... c", "a b d"), ("...\nb", "b\nc"), ("", "a")] {
        assert!(!are(expected, came), "{expected:?} {came:?}");
    }
}
