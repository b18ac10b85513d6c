//! pyprofibus as a process: `pyprofibus_master.py` reports events, line by line.

use crate::common::text;
use crate::peers::slave::Slave;
use crate::peers::watched::{Event, Watched};
use serde_json::Value;
use std::io::{BufRead, BufReader, Write};
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::sync::mpsc::Sender;

/// The Python of the environment that contains pyprofibus.
pub fn python() -> PathBuf {
    let python = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../target/venv/bin/python");
    assert!(python.exists(), "there is no {}: ./test makes it", python.display());
    python
}

/// A program in this folder.
pub fn program(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/peers").join(name)
}

/// Brings a slave to Data_Exchange, with outputs of zeros.
pub fn start(line: &Path, slave: &Slave) -> Watched {
    start_with(line, slave, &text(&vec![0; slave.outputs]))
}

/// Brings a slave to Data_Exchange, with these outputs, in hex.
pub fn start_with(line: &Path, slave: &Slave, outputs: &str) -> Watched {
    Watched::start(|events| {
        let mut child = Command::new(python())
            .arg(program("pyprofibus_master.py"))
            .arg(line)
            .args([slave.address.to_string(), slave.ident.to_string(), text(&slave.cfg), text(&slave.user_prm)])
            .args([slave.outputs.to_string(), slave.inputs.to_string()])
            .stdin(Stdio::piped())
            .stdout(Stdio::piped())
            .spawn()
            .unwrap();
        writeln!(child.stdin.as_ref().unwrap(), "{outputs}").unwrap();
        let output = BufReader::new(child.stdout.take().unwrap());
        std::thread::spawn(move || pass_on(output, &events));
        Process(child)
    })
}

/// Ends with the test.
struct Process(Child);

impl Drop for Process {
    fn drop(&mut self) {
        self.0.kill().ok();
        self.0.wait().ok();
    }
}

/// Turns lines into events, until either side ends. The output of pyprofibus itself is ignored.
fn pass_on(output: impl BufRead, events: &Sender<Event>) {
    for line in output.lines().map_while(Result::ok) {
        let Ok(message) = serde_json::from_str::<Value>(&line) else { continue };
        let event = match (&message["state"], &message["inputs"]) {
            (Value::String(state), _) => Event::Exchanging(state == "Data_Exchange"),
            (_, Value::String(inputs)) => Event::Inputs(octets(inputs)),
            _ => panic!("{line}"),
        };
        if events.send(event).is_err() {
            return;
        }
    }
}

fn octets(hex: &str) -> Vec<u8> {
    (0..hex.len() / 2).map(|at| u8::from_str_radix(&hex[2 * at..2 * at + 2], 16).unwrap()).collect()
}
