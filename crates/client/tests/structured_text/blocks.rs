//! The program that parses and executes function blocks, as a child process.

use std::collections::BTreeMap;
use std::io::{BufRead, BufReader, Write};
use std::path::Path;
use std::process::{Child, ChildStdin, ChildStdout, Command, Stdio};

/// Function blocks that can be called.
pub struct Blocks {
    child: Child,
    calls: ChildStdin,
    answers: BufReader<ChildStdout>,
    _file: tempfile::TempDir,
}

/// The outputs of a call, by name.
#[derive(Debug)]
pub struct Outputs(BTreeMap<String, String>);

/// Octets as hexadecimal digits.
pub fn hex(octets: &[u8]) -> String {
    octets.iter().map(|octet| format!("{octet:02X}")).collect()
}

impl Blocks {
    /// Parses the text.
    pub fn start(text: &str) -> Self {
        let root = Path::new(env!("CARGO_MANIFEST_DIR"));
        let python = root.join("../../target/venv/bin/python");
        assert!(python.exists(), "{} is missing: `./test` makes it", python.display());
        let file = tempfile::tempdir().unwrap();
        let path = file.path().join("blocks.st");
        std::fs::write(&path, text).unwrap();
        let mut child = Command::new(python)
            .arg(root.join("tests/structured_text/executor.py"))
            .arg(path)
            .stdin(Stdio::piped())
            .stdout(Stdio::piped())
            .spawn()
            .unwrap();
        let (calls, answers) = (child.stdin.take().unwrap(), BufReader::new(child.stdout.take().unwrap()));
        let mut blocks = Self { child, calls, answers, _file: file };
        assert!(blocks.answer().starts_with("ready "), "the blocks are not parsed, see above");
        blocks
    }

    fn answer(&mut self) -> String {
        let mut line = String::new();
        self.answers.read_line(&mut line).unwrap();
        line
    }

    /// Calls an instance of a block; inputs that are not set keep their value.
    pub fn call(&mut self, name: &str, instance: &str, settings: &str) -> Outputs {
        writeln!(self.calls, "{name} {instance} {settings}").unwrap();
        let answer = self.answer();
        assert!(!answer.is_empty(), "{name} with {settings} ended the program, see above");
        let pairs = answer.split_whitespace().filter_map(|pair| pair.split_once('='));
        Outputs(pairs.map(|(name, value)| (name.to_owned(), value.to_owned())).collect())
    }
}

impl Drop for Blocks {
    fn drop(&mut self) {
        self.child.kill().ok();
        self.child.wait().ok();
    }
}

impl Outputs {
    /// The elements of an output.
    pub fn numbers(&self, name: &str) -> Vec<f64> {
        let text = self.0.get(name).unwrap_or_else(|| panic!("no output {name}"));
        text.split(',').map(|one| one.parse().unwrap()).collect()
    }

    /// An output that is one number; TRUE is 1.
    pub fn number(&self, name: &str) -> f64 {
        let numbers = self.numbers(name);
        assert_eq!(numbers.len(), 1, "{name}");
        numbers[0]
    }
}
