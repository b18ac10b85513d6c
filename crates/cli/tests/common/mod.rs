//! The program as a child process, and the octets of a line. Every wait has a deadline, and no test sleeps.

#![allow(clippy::unwrap_used, clippy::panic, reason = "helpers of tests")]
#![allow(dead_code, reason = "every test file uses its own part")]

pub mod slave_line;

use crate::until::pause;
use rustix::event::{PollFd, PollFlags, Timespec, poll};
use std::fs::{File, OpenOptions};
use std::io::{BufRead, BufReader, Read, Write};
use std::net::TcpStream;
use std::os::fd::AsFd;
use std::os::unix::fs::OpenOptionsExt;
use std::path::{Path, PathBuf};
use std::process::{Child, ChildStdin, Command, Output, Stdio};
use std::sync::mpsc::{Receiver, RecvTimeoutError, channel};
use std::time::Duration;
use tempfile::TempDir;

/// The deadline of a wait, long enough for a loaded computer.
const DEADLINE: Duration = Duration::from_secs(600);

/// The deadline of a wait for an operation that has no bound on a loaded computer. It only ends a test that hangs.
const HANG: Duration = Duration::from_secs(1800);

/// The time after which a master repeats a request without answer.
const SLOT_TIME: Duration = Duration::from_millis(200);

/// The answer to a GET of `path`.
pub fn get(address: &str, path: &str) -> String {
    let mut stream = TcpStream::connect(address).unwrap();
    write!(stream, "GET {path} HTTP/1.1\r\nHost: {address}\r\nConnection: close\r\n\r\n").unwrap();
    let mut answer = String::new();
    stream.read_to_string(&mut answer).unwrap();
    answer
}

/// Repeats a GET until the answer contains `wanted`.
pub fn until(address: &str, path: &str, wanted: &str) -> String {
    let end = std::time::Instant::now() + DEADLINE;
    loop {
        let answer = get(address, path);
        if answer.contains(wanted) {
            return answer;
        }
        assert!(std::time::Instant::now() < end, "{path} never has {wanted}: {answer}");
        pause();
    }
}

/// A separate folder for every test.
pub struct Folder(TempDir);

impl Folder {
    pub fn new() -> Self {
        Self(tempfile::tempdir().unwrap())
    }

    pub fn path(&self, name: &str) -> PathBuf {
        self.0.path().join(name)
    }

    /// The path as text, for a command line.
    pub fn name(&self, name: &str) -> String {
        self.path(name).to_str().unwrap().to_owned()
    }
}

/// Takes CAP_SYS_ADMIN from this thread and from the programs that it starts, if they would have it.
pub fn become_an_ordinary_user() {
    use rustix::thread::{CapabilitySet, capabilities, remove_capability_from_bounding_set, set_capabilities};
    let mut sets = capabilities(None).unwrap();
    if sets.effective.contains(CapabilitySet::SYS_ADMIN) {
        remove_capability_from_bounding_set(CapabilitySet::SYS_ADMIN).unwrap();
        sets.effective -= CapabilitySet::SYS_ADMIN;
        sets.permitted -= CapabilitySet::SYS_ADMIN;
        set_capabilities(None, sets).unwrap();
    }
}

fn command(arguments: &[&str]) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_profivac"));
    command.args(arguments);
    command
}

/// Runs a command that ends by itself.
pub fn run(arguments: &[&str]) -> Output {
    command(arguments).stdin(Stdio::null()).output().unwrap()
}

/// The commands that the help of the program lists, without `help` itself.
pub fn commands() -> Vec<String> {
    listed_commands(&String::from_utf8(run(&["--help"]).stdout).unwrap())
}

/// The commands that a help text lists, without `help` itself.
pub fn listed_commands(help: &str) -> Vec<String> {
    let listed = help.lines().skip_while(|line| *line != "Commands:").skip(1).take_while(|line| !line.is_empty());
    let names = listed.map(|line| line.split_whitespace().next().unwrap().to_owned());
    names.filter(|name| name != "help").collect()
}

/// Runs a command with this text on its standard input.
pub fn run_with(arguments: &[&str], input: &str) -> Output {
    let mut command = command(arguments);
    let mut child = command.stdin(Stdio::piped()).stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
    // A program that ends early does not read it.
    let _taken = child.stdin.take().unwrap().write_all(input.as_bytes());
    child.wait_with_output().unwrap()
}

/// Runs a command whose standard input and standard error are a terminal on which `typed` is entered after `prompt`.
/// Returns the exit code, standard output, and what the terminal shows.
pub fn run_on_terminal(arguments: &[&str], prompt: &str, typed: &str) -> (i32, String, String) {
    let (code, out, shown, _) =
        on_terminal(arguments, prompt, |_, terminal| terminal.write_all(typed.as_bytes()).unwrap());
    (code, out, shown)
}

/// The same for several prompts: returns everything that the terminal has shown.
pub fn all_shown_on_terminal(arguments: &[&str], prompt: &str, typed: &str) -> (i32, String) {
    let (code, _, shown, rest) =
        on_terminal(arguments, prompt, |_, terminal| terminal.write_all(typed.as_bytes()).unwrap());
    (code, shown + &rest)
}

/// The same, with Ctrl-C in place of an answer. Returns the exit code, standard output, and what the terminal shows after the prompt.
pub fn interrupted_on_terminal(arguments: &[&str], prompt: &str) -> (i32, String, String) {
    let (code, out, _, said) = on_terminal(arguments, prompt, |child, _| {
        let id = rustix::process::Pid::from_child(child);
        rustix::process::kill_process(id, rustix::process::Signal::INT).unwrap();
    });
    (code, out, said)
}

/// The same, with any response to the prompt. Returns the exit code, standard output, and what the terminal shows until the prompt and
/// after it.
pub fn on_terminal(
    arguments: &[&str],
    prompt: &str,
    respond: impl FnOnce(&Child, &mut File),
) -> (i32, String, String, String) {
    use rustix::pty::{OpenptFlags, grantpt, openpt, ptsname, unlockpt};
    let ours = openpt(OpenptFlags::RDWR | OpenptFlags::NOCTTY).unwrap();
    grantpt(&ours).unwrap();
    unlockpt(&ours).unwrap();
    let name = ptsname(&ours, Vec::new()).unwrap();
    let flags = rustix::fs::OFlags::NOCTTY.bits() as i32;
    let open = || OpenOptions::new().read(true).write(true).custom_flags(flags).open(name.to_str().unwrap()).unwrap();
    let child = command(arguments).stdin(open()).stderr(open()).stdout(Stdio::piped()).spawn().unwrap();
    let mut terminal = File::from(ours);
    let (mut shown, mut octet) = (String::new(), [0]);
    while !shown.ends_with(prompt) && terminal.read_exact(&mut octet).is_ok() {
        shown.push(char::from(octet[0]));
    }
    respond(&child, &mut terminal);
    let output = child.wait_with_output().unwrap();
    let out = String::from_utf8(output.stdout).unwrap();
    // The rest of the output; reading ends with an error because the other end is closed.
    let mut rest = Vec::new();
    let _ended = terminal.read_to_end(&mut rest);
    (output.status.code().unwrap(), out, shown, String::from_utf8_lossy(&rest).into_owned())
}

/// A command that serves.
pub struct Program {
    child: Child,
    stdin: Option<ChildStdin>,
    stdout: Receiver<String>,
    stderr: Receiver<String>,
}

impl Program {
    pub fn start(arguments: &[&str]) -> Self {
        Self::of(&mut command(arguments))
    }

    /// Starts any command.
    pub fn of(command: &mut Command) -> Self {
        let mut child = command.stdin(Stdio::piped()).stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
        let stdin = child.stdin.take();
        let stdout = lines(child.stdout.take().unwrap());
        let stderr = lines(child.stderr.take().unwrap());
        Self { child, stdin, stdout, stderr }
    }

    /// Waits for the `ready` line and returns the text after the word.
    pub fn ready(&self) -> String {
        let line = self.stdout.recv_timeout(DEADLINE).unwrap_or_else(|_| panic!("not ready: {}", self.complaint()));
        line.strip_prefix("ready ").unwrap_or_else(|| panic!("{line:?} instead of ready")).to_owned()
    }

    /// The next line on standard output.
    pub fn line(&self) -> String {
        self.stdout.recv_timeout(DEADLINE).unwrap_or_else(|_| panic!("no line: {}", self.complaint()))
    }

    /// All that is left on standard output until the program ends.
    pub fn rest(&self) -> String {
        std::iter::from_fn(|| self.next_line()).collect()
    }

    /// The next line on standard output, `None` if it has ended.
    pub fn next_line(&self) -> Option<String> {
        match self.stdout.recv_timeout(DEADLINE) {
            Ok(line) => Some(line),
            Err(RecvTimeoutError::Disconnected) => None,
            Err(RecvTimeoutError::Timeout) => panic!("no line: {}", self.complaint()),
        }
    }

    /// Sends a line without waiting for an answer.
    pub fn say(&mut self, line: &str) {
        writeln!(self.stdin.as_mut().unwrap(), "{line}").unwrap();
    }

    /// Sends a line and returns the answer.
    pub fn tell(&mut self, line: &str) -> String {
        self.say(line);
        self.stdout.recv_timeout(DEADLINE).unwrap_or_else(|_| panic!("no answer to {line:?}"))
    }

    /// The state of a device.
    pub fn state(&mut self, address: u8) -> serde_json::Value {
        let answer = self.tell(&format!("state {address}"));
        serde_json::from_str(answer.strip_prefix("ok ").unwrap_or_else(|| panic!("{answer}"))).unwrap()
    }

    /// Standard input ends.
    pub fn end_of_file(&mut self) {
        self.stdin = None;
    }

    pub fn terminate(&self) {
        let id = rustix::process::Pid::from_child(&self.child);
        rustix::process::kill_process(id, rustix::process::Signal::TERM).unwrap();
    }

    /// Sends SIGHUP: the program reads its file again.
    pub fn hang_up(&self) {
        let id = rustix::process::Pid::from_child(&self.child);
        rustix::process::kill_process(id, rustix::process::Signal::HUP).unwrap();
    }

    /// Ctrl-C.
    pub fn interrupt(&self) {
        let id = rustix::process::Pid::from_child(&self.child);
        rustix::process::kill_process(id, rustix::process::Signal::INT).unwrap();
    }

    /// Stops the program in the middle of its work: it answers nothing, and its port stays open.
    pub fn stop(&self) {
        let id = rustix::process::Pid::from_child(&self.child);
        rustix::process::kill_process(id, rustix::process::Signal::STOP).unwrap();
    }

    pub fn kill(&mut self) {
        self.child.kill().unwrap();
        self.child.wait().unwrap();
    }

    /// The next line on standard error.
    pub fn complaint(&self) -> String {
        self.stderr.recv_timeout(DEADLINE).unwrap_or_else(|_| "nothing on standard error".to_owned())
    }

    /// Waits for a line on standard error that contains `words`, however long the work before it takes.
    pub fn wait_for_complaint(&self, words: &str) {
        let mut seen = Vec::new();
        loop {
            match self.stderr.recv_timeout(HANG) {
                Ok(line) if line.contains(words) => return,
                Ok(line) => seen.push(line),
                Err(reason) => panic!("no {words:?} on standard error: {reason}, after {seen:#?}"),
            }
        }
    }

    /// Whether the program has ended.
    pub fn has_ended(&mut self) -> bool {
        self.child.try_wait().unwrap().is_some()
    }

    /// Waits until the program has ended by itself. Its output ends at the same time.
    pub fn exit_code(&mut self) -> i32 {
        while self.stdout.recv_timeout(DEADLINE).is_ok() {}
        self.child.wait().unwrap().code().unwrap()
    }
}

impl Drop for Program {
    fn drop(&mut self) {
        self.child.kill().ok();
        self.child.wait().ok();
    }
}

/// The lines of a stream, as soon as they arrive.
fn lines(stream: impl Read + Send + 'static) -> Receiver<String> {
    let (sender, receiver) = channel();
    std::thread::spawn(move || {
        for line in BufReader::new(stream).lines().map_while(Result::ok) {
            if sender.send(line).is_err() {
                return;
            }
        }
    });
    receiver
}

/// The master's end of a line.
pub struct End(Stream);

enum Stream {
    Pty(File),
    Tcp(TcpStream),
}

impl End {
    /// The pty a program serves, as any program would open it.
    pub fn pty(path: &Path) -> Self {
        Self::open_pty(path).unwrap()
    }

    fn open_pty(path: &Path) -> std::io::Result<Self> {
        let flags = rustix::fs::OFlags::NOCTTY.bits() as i32;
        OpenOptions::new().read(true).write(true).custom_flags(flags).open(path).map(|file| Self(Stream::Pty(file)))
    }

    /// Locks the pty, as most libraries for serial ports do. The kernel keeps the lock when the program is killed.
    pub fn lock(&self) {
        if let Stream::Pty(file) = &self.0 {
            rustix::termios::ioctl_tiocexcl(file).unwrap();
        }
    }

    /// The pty as soon as its program, which must not end, has removed the lock of a former one. No other error may occur until then.
    pub fn pty_of(program: &mut Program, path: &Path) -> Self {
        let end = std::time::Instant::now() + DEADLINE;
        loop {
            match Self::open_pty(path) {
                Ok(opened) => return opened,
                Err(error) => {
                    assert!(!program.has_ended(), "the program has ended: {}", program.complaint());
                    assert_eq!(error.kind(), std::io::ErrorKind::ResourceBusy, "{error}");
                    assert!(std::time::Instant::now() < end, "{error}");
                }
            }
            std::thread::yield_now();
        }
    }

    pub fn tcp(address: &str) -> Self {
        let stream = TcpStream::connect(address).unwrap();
        stream.set_nodelay(true).unwrap();
        Self(Stream::Tcp(stream))
    }

    /// Sends octets written as hexadecimal digits.
    pub fn send(&mut self, hex: &str) {
        let octets = octets(hex);
        match &mut self.0 {
            Stream::Pty(file) => file.write_all(&octets).unwrap(),
            Stream::Tcp(stream) => stream.write_all(&octets).unwrap(),
        }
    }

    /// Waits for exactly these octets.
    pub fn expect(&mut self, hex: &str) {
        let expected = octets(hex);
        let mut received = Vec::new();
        while received.len() < expected.len() {
            let more = self.receive();
            assert!(!more.is_empty(), "{} received instead of {hex}", text(&received));
            received.extend(more);
        }
        assert_eq!(text(&received), text(&expected));
    }

    /// A request and the data unit of its answer, an SD2 without access points and with this number of octets.
    pub fn exchange(&mut self, request: &str, octets: usize) -> Vec<u8> {
        self.send(request);
        let mut received = Vec::new();
        while received.len() < octets + 9 {
            let more = self.receive();
            assert!(!more.is_empty(), "{} received in answer to {request}", text(&received));
            received.extend(more);
        }
        assert_eq!((received[0], usize::from(received[1])), (0x68, octets + 3), "{}", text(&received));
        received[7..7 + octets].to_vec()
    }

    /// A request that is repeated until it is answered, as a master does on a disturbed line.
    pub fn insist(&mut self, request: &str, answer: &str) {
        let expected = octets(answer);
        let mut received = Vec::new();
        while received.len() < expected.len() {
            self.send(request);
            received.extend(self.receive_within(SLOT_TIME));
        }
        assert_eq!(text(&received), text(&expected));
    }

    /// The next octets, none if none arrive.
    pub fn receive(&mut self) -> Vec<u8> {
        self.receive_within(DEADLINE)
    }

    pub fn receive_within(&mut self, timeout: Duration) -> Vec<u8> {
        let mut buffer = [0; 512];
        let fd = match &self.0 {
            Stream::Pty(file) => file.as_fd(),
            Stream::Tcp(stream) => stream.as_fd(),
        };
        let deadline = Timespec::try_from(timeout).unwrap();
        if poll(&mut [PollFd::from_borrowed_fd(fd, PollFlags::IN)], Some(&deadline)).unwrap() == 0 {
            return Vec::new();
        }
        let length = match &mut self.0 {
            Stream::Pty(file) => file.read(&mut buffer).unwrap(),
            Stream::Tcp(stream) => stream.read(&mut buffer).unwrap(),
        };
        buffer[..length].to_vec()
    }

    /// A request and its answer.
    pub fn ask(&mut self, request: &str, answer: &str) {
        self.send(request);
        self.expect(answer);
    }
}

pub fn octets(hex: &str) -> Vec<u8> {
    hex.split_whitespace().map(|octet| u8::from_str_radix(octet, 16).unwrap()).collect()
}

/// Octets as hexadecimal digits.
pub fn text(octets: &[u8]) -> String {
    octets.iter().map(|octet| format!("{octet:02X}")).collect::<Vec<_>>().join(" ")
}

/// An SD2 with service access points, from master 2.
pub fn sd2(da: u8, dsap: u8, fc: u8, du: &str) -> String {
    let body = [vec![da | 0x80, 0x82, fc, dsap, 62], octets(du)].concat();
    let length = body.len() as u8;
    let sum = body.iter().fold(0_u8, |sum, octet| sum.wrapping_add(*octet));
    text(&[vec![0x68, length, length, 0x68], body, vec![sum, 0x16]].concat())
}

/// An SD1 from master 2.
pub fn sd1(da: u8, fc: u8) -> String {
    text(&[0x10, da, 2, fc, da.wrapping_add(2).wrapping_add(fc), 0x16])
}
