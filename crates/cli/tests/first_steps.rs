//! Runs the tutorials docs/first-steps.md, docs/first-station.md and docs/plc.md: every command of their console blocks, in order, in an
//! empty folder, and compares the output.
//!
//! | In a block | Meaning |
//! |---|---|
//! | `$ COMMAND` | typed in a shell; the following lines are its complete output. The exit code must be 0 unless `$ echo $?` is next |
//! | `NAME$ COMMAND` | typed in another terminal, where it keeps running; the following lines appear before the next step |
//! | `NAME: LINE` | typed there for the running command; without a line: its output since then |
//! | `NAME: ^C` | Ctrl-C there: the exit code must be 0, and the following lines are the rest of its output |
//! | a block `toml NAME` | a file that the reader saves |
//! | `...` | any text within a line; as a line, any lines |

#![allow(clippy::unwrap_used, clippy::panic, reason = "a test")]

use crate::common;
use crate::common::{Folder, Program};
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

/// The mark for any text.
const ANY: &str = "...";

/// A command or a line of input, and the expected output.
#[derive(Debug, PartialEq, Eq)]
struct Step {
    line: usize,
    typed: Typed,
    expected: Vec<String>,
}

#[derive(Debug, PartialEq, Eq)]
enum Typed {
    /// A command in the shell.
    Command(String),
    /// A command in another terminal, which keeps running.
    Start(String, String),
    /// A line for the program in another terminal.
    Say(String, String),
    /// A file.
    Save(String),
}

/// The steps of a page.
fn steps(page: &str) -> Vec<Step> {
    let (mut steps, mut terminals, mut is_console) = (Vec::<Step>::new(), Vec::new(), false);
    for (line, text) in (1..).zip(page.lines()) {
        if text.starts_with("```") {
            let file = text.strip_prefix("```toml ").map(|name| Typed::Save(name.to_owned()));
            is_console = text == "```console" || file.is_some();
            steps.extend(file.map(|typed| Step { line, typed, expected: Vec::new() }));
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
    let (name, message) = text.split_once(':')?;
    let is_there = terminals.iter().any(|terminal| terminal == name);
    is_there.then(|| Typed::Say(name.to_owned(), message.trim().to_owned()))
}

/// Whether a line matches the page.
fn is_text(expected: &str, text: &str) -> bool {
    match expected.split_once(ANY) {
        None => expected == text,
        Some((begin, rest)) => text.strip_prefix(begin).is_some_and(|text| {
            text.char_indices().map(|(at, _)| at).chain([text.len()]).any(|at| is_text(rest, &text[at..]))
        }),
    }
}

/// Whether lines match the page.
fn are_lines(expected: &[String], lines: &[String]) -> bool {
    match (expected.split_first(), lines.split_first()) {
        (None, first) => first.is_none(),
        (Some((first, rest)), None) => first == ANY && are_lines(rest, lines),
        (Some((first, rest)), Some((_, later))) if first == ANY => are_lines(rest, lines) || are_lines(expected, later),
        (Some((first, rest)), Some((line, later))) => is_text(first, line) && are_lines(rest, later),
    }
}

/// The environment of a user: a folder, a home with the sources, and programs in other terminals.
struct Workplace {
    folder: Folder,
    programs: BTreeMap<String, Program>,
    /// The exit code of the last command.
    code: i32,
}

fn sources() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../..").canonicalize().unwrap()
}

impl Workplace {
    fn new() -> Self {
        let folder = Folder::new();
        for name in ["home", "work"] {
            std::fs::create_dir(folder.path(name)).unwrap();
        }
        std::os::unix::fs::symlink(sources(), folder.path("home/profivac")).unwrap();
        Self { folder, programs: BTreeMap::new(), code: 0 }
    }

    /// Runs a command in a shell. Standard output and standard error share one terminal.
    fn shell(&self, command: &str) -> Command {
        let program = Path::new(env!("CARGO_BIN_EXE_profivac")).parent().unwrap();
        let path = format!("{}:{}", program.display(), std::env::var("PATH").unwrap());
        let mut shell = Command::new("sh");
        shell.args(["-c", &format!("{command} 2>&1")]).current_dir(self.folder.path("work"));
        shell.env("PATH", path).env("HOME", self.folder.path("home")).stdin(Stdio::null());
        shell
    }

    /// Runs one step and returns its output.
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
                let output = until(&program, &step.expected);
                self.programs.insert(name.clone(), program);
                output
            }
            Typed::Save(name) => {
                std::fs::write(self.folder.path("work").join(name), step.expected.join("\n")).unwrap();
                step.expected.clone()
            }
            Typed::Say(name, message) if message == "^C" => {
                let mut program = self.programs.remove(name).unwrap();
                program.interrupt();
                let output = std::iter::from_fn(|| program.next_line()).collect();
                assert_eq!(program.exit_code(), 0, "line {}", step.line);
                output
            }
            Typed::Say(name, message) => {
                let program = self.programs.get_mut(name).unwrap();
                if !message.is_empty() {
                    program.say(message);
                }
                until(program, &step.expected)
            }
        }
    }
}

/// The output of a running program, read until it matches.
fn until(program: &Program, expected: &[String]) -> Vec<String> {
    let mut output = Vec::new();
    while !are_lines(expected, &output) {
        match program.next_line() {
            Some(line) => output.push(line),
            None => return output,
        }
    }
    output
}

#[test]
fn every_step_prints_what_the_page_shows() {
    follow("docs/first-steps.md");
}

#[test]
fn every_step_to_a_station_prints_what_the_page_shows() {
    follow("docs/first-station.md");
}

#[test]
fn every_step_to_a_plc_prints_what_the_page_shows() {
    follow("docs/plc.md");
}

/// A page with free TCP ports in place of its own, which another program on this computer may have.
fn with_free_ports(page: &str) -> String {
    const HOST: &str = "127.0.0.1:";
    let mut parts = page.split(HOST);
    let mut text = parts.next().unwrap_or_default().to_owned();
    let mut ports = BTreeMap::new();
    // Held until each port of the page has another one.
    let mut held = Vec::new();
    for part in parts {
        let end = part.find(|character: char| !character.is_ascii_digit()).unwrap_or(part.len());
        let (port, rest) = part.split_at(end);
        let free = ports.entry(port).or_insert_with(|| {
            let listener = std::net::TcpListener::bind((HOST.trim_end_matches(':'), 0)).unwrap();
            let free = listener.local_addr().unwrap().port();
            held.push(listener);
            free
        });
        text += &format!("{HOST}{free}{rest}");
    }
    text
}

/// Runs all steps of a page.
fn follow(name: &str) {
    let page = with_free_ports(&std::fs::read_to_string(sources().join(name)).unwrap());
    let mut workplace = Workplace::new();
    for step in steps(&page) {
        let output = workplace.follow(&step);
        let Step { line, typed, expected } = &step;
        assert!(
            are_lines(expected, &output),
            "{name}:{line}: {typed:?}\nexpected:\n{}\ncame:\n{}\n",
            expected.join("\n"),
            output.join("\n")
        );
    }
    assert_eq!(workplace.code, 0, "the last command failed");
}

/// Commands that the page leaves to pages of their own.
const LATER: [&str; 11] =
    ["archive", "backup", "device", "doctor", "export", "field-test", "identify", "names", "report", "st", "user"];

#[test]
fn the_page_uses_every_command_except_those_with_pages_of_their_own() {
    let page = std::fs::read_to_string(sources().join("docs/first-steps.md")).unwrap();
    let used: Vec<String> = steps(&page)
        .into_iter()
        .filter_map(|step| match step.typed {
            Typed::Command(command) | Typed::Start(_, command) => Some(command),
            Typed::Say(..) | Typed::Save(_) => None,
        })
        .collect();
    for command in common::commands() {
        let begin = format!("profivac {command} ");
        let is_used = used.iter().any(|it| it.starts_with(&begin));
        assert_eq!(is_used, !LATER.contains(&command.as_str()), "{command}");
    }
    assert!(used.iter().any(|command| command.starts_with("tshark ")));
}

#[test]
fn the_steps_of_a_page_are_parsed() {
    let page = "text\n```sh\n$ no\n```\n```toml f.toml\na = 1\n```\n```console\n$ a b\nc: d\nx$ e\nready\nx: ^C\nx:\n```\n$ no";
    let step = |line, typed, expected: &[&str]| Step {
        line,
        typed,
        expected: expected.iter().map(|&line| line.to_owned()).collect(),
    };
    let say = |message: &str| Typed::Say("x".to_owned(), message.to_owned());
    let expected = [
        step(5, Typed::Save("f.toml".to_owned()), &["a = 1"]),
        step(9, Typed::Command("a b".to_owned()), &["c: d"]),
        step(11, Typed::Start("x".to_owned(), "e".to_owned()), &["ready"]),
        step(13, say("^C"), &[]),
        step(14, say(""), &[]),
    ];
    assert_eq!(steps(page), expected);
}

#[test]
fn the_same_port_of_a_page_is_the_same_free_port() {
    let text = with_free_ports("a 127.0.0.1:1/x 127.0.0.1:22 127.0.0.1:1");
    let ports: Vec<&str> = text.split("127.0.0.1:").map(|part| part.trim_end().trim_end_matches("/x")).collect();
    assert_eq!(ports[0], "a");
    assert_eq!(ports[1], ports[3]);
    assert_ne!(ports[1], ports[2]);
    assert!(text.contains("/x 127.0.0.1:"), "{text}");
}

#[test]
fn only_dots_match_any_text() {
    let are = |expected: &str, output: &str| {
        let lines = |text: &str| text.lines().map(str::to_owned).collect::<Vec<_>>();
        are_lines(&lines(expected), &lines(output))
    };
    for (expected, output) in
        [("a\nb", "a\nb"), ("a ... c", "a b c"), ("...\nb\n...", "b"), ("a\n...\nd", "a\nb\nc\nd")]
    {
        assert!(are(expected, output), "{expected:?} {output:?}");
    }
    for (expected, output) in [("a", "a\nb"), ("a\nb", "a"), ("a ... c", "a b d"), ("...\nb", "b\nc"), ("", "a")] {
        assert!(!are(expected, output), "{expected:?} {output:?}");
    }
}
