//! One pyprofibus for many slaves, one after the other: `pyprofibus_rows.py` answers line for line.

use crate::common::text;
use crate::peers::pyprofibus_master::{program, python};
use crate::peers::slave::Slave;
use serde_json::{Value, json};
use std::io::{BufRead, BufReader, Lines, Write};
use std::path::Path;
use std::process::{Child, ChildStdin, ChildStdout, Command, Stdio};

/// The process. It ends when this is dropped.
pub struct Rows {
    child: Child,
    to: ChildStdin,
    from: Lines<BufReader<ChildStdout>>,
}

/// The progress of the master with a slave.
#[derive(Debug, PartialEq, Eq)]
pub struct Outcome {
    /// The master's state for it.
    pub state: String,
    /// The number of input octets of the last exchange, if there was one.
    pub inputs: Option<u64>,
}

impl Rows {
    /// A master on this pty.
    pub fn start(line: &Path) -> Self {
        let mut child = Command::new(python())
            .arg(program("pyprofibus_rows.py"))
            .arg(line)
            .stdin(Stdio::piped())
            .stdout(Stdio::piped())
            .spawn()
            .unwrap();
        let (to, from) = (child.stdin.take().unwrap(), child.stdout.take().unwrap());
        Self { child, to, from: BufReader::new(from).lines() }
    }

    /// Selects a slave and brings it to data exchange, or to the last state that the master reaches.
    pub fn bring_up(&mut self, slave: &Slave) -> Outcome {
        let Slave { address, ident, outputs, inputs, .. } = slave;
        let (cfg, user_prm) = (text(&slave.cfg), text(&slave.user_prm));
        let order = json!({
            "address": address, "ident": ident, "cfg": cfg, "user_prm": user_prm, "outputs": outputs, "inputs": inputs
        });
        writeln!(self.to, "{order}").unwrap();
        let answer = self.answer();
        Outcome { state: answer["state"].as_str().unwrap().to_owned(), inputs: answer["inputs"].as_u64() }
    }

    /// The next line of the program. The output of pyprofibus itself, often thousands of equal lines, is shown once with a
    /// failing test.
    fn answer(&mut self) -> Value {
        let mut repeated = String::new();
        for line in self.from.by_ref().map_while(Result::ok) {
            match serde_json::from_str(&line) {
                Ok(answer) => return answer,
                Err(_) if line == repeated => {}
                Err(_) => {
                    println!("{line}");
                    repeated = line;
                }
            }
        }
        panic!("pyprofibus has ended")
    }
}

impl Drop for Rows {
    fn drop(&mut self) {
        self.child.kill().ok();
        self.child.wait().ok();
    }
}
