//! ser2net as the server of a line: raw octets, telnet, and telnet with control of the port (RFC 2217).

#![allow(clippy::unwrap_used, clippy::panic, reason = "a test")]

use crate::common::{Folder, Program, run};
use std::net::{TcpListener, TcpStream};
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

/// The longest wait for ser2net. A test that waits longer has failed.
const TIMEOUT: Duration = Duration::from_secs(60);

/// A slot time of 200 ms, in bit times, so that a loaded computer misses no answer.
const PATIENTLY: &str = "--slot-time=4000";

/// ser2net in front of a pty.
struct Server {
    process: Child,
    raw: u16,
    telnet: u16,
    control: u16,
}

impl Drop for Server {
    fn drop(&mut self) {
        self.process.kill().ok();
        self.process.wait().ok();
    }
}

/// A port that is free now.
fn free() -> u16 {
    TcpListener::bind("127.0.0.1:0").unwrap().local_addr().unwrap().port()
}

/// Starts ser2net for the pty `line`.
fn serve(folder: &Folder, line: &str) -> Server {
    let [raw, telnet, control, last] = [(); 4].map(|()| free());
    let connection = |name: &str, accepter: &str, port: u16, device: &str| {
        format!(
            "connection: &{name}\n  accepter: {accepter}tcp,127.0.0.1,{port}\n  connector: serialdev,{device},19200e81,local\n"
        )
    };
    let file = [
        connection("raw", "", raw, line),
        connection("telnet", "telnet,", telnet, line),
        connection("control", "telnet(rfc2217),", control, line),
        // The last one shows that the others listen; nothing is behind it.
        connection("last", "", last, &folder.name("nothing")),
    ];
    let path = folder.name("ser2net.yaml");
    std::fs::write(&path, file.concat()).unwrap();
    let mut command = Command::new("ser2net");
    command.args(["-n", "-c", &path]).stdout(Stdio::null()).stderr(Stdio::null());
    let process = command.spawn().unwrap_or_else(|error| panic!("ser2net ({error}): ./test installs it"));
    let server = Server { process, raw, telnet, control };
    let begun = Instant::now();
    while TcpStream::connect(("127.0.0.1", last)).is_err() {
        assert!(begun.elapsed() < TIMEOUT, "ser2net does not listen");
        std::thread::yield_now();
    }
    server
}

/// A command on the port, with its exit code and output.
fn on(port: &str, command: &[&str]) -> (Option<i32>, String, String) {
    let (name, rest) = command.split_first().unwrap();
    let output = run(&[&[*name, "--port", port, PATIENTLY], rest].concat());
    let text = |octets| String::from_utf8(octets).unwrap();
    (output.status.code(), text(output.stdout), text(output.stderr))
}

#[test]
fn a_gauge_behind_ser2net_is_found_and_read_over_each_protocol() {
    let folder = Folder::new();
    let line = folder.name("line");
    let simulate = Program::start(&["simulate", "--pty", &line, "bcg450@5"]);
    simulate.ready();
    let server = serve(&folder, &line);
    for port in [
        format!("tcp://127.0.0.1:{}", server.raw),
        format!("telnet://127.0.0.1:{}", server.telnet),
        format!("rfc2217://127.0.0.1:{}", server.control),
        // ser2net gives no control here, and octets pass all the same.
        format!("rfc2217://127.0.0.1:{}", server.telnet),
    ] {
        // Twice: the second command meets a server whose client has just gone.
        for _ in 0..2 {
            let (code, output, errors) = on(&port, &["scan", "--hsa", "6"]);
            assert!(code == Some(0) && output.contains("bcg450"), "{port}: {output}{errors}");
        }
        let (code, output, errors) = on(&port, &["read", "--address", "5", "pirani.process-value"]);
        assert!(code == Some(0) && output.contains("mbar"), "{port}: {output}{errors}");
    }
}

#[test]
fn a_telnet_server_at_a_raw_port_is_named() {
    let folder = Folder::new();
    let line = folder.name("line");
    let simulate = Program::start(&["simulate", "--pty", &line, "bcg450@5"]);
    simulate.ready();
    let server = serve(&folder, &line);
    let (_, output, errors) = on(&format!("tcp://127.0.0.1:{}", server.control), &["scan", "--hsa", "6"]);
    let expected =
        format!("speaks telnet, which changes octets of the line: use telnet://127.0.0.1:{}", server.control);
    assert!(errors.contains(&expected), "{output}{errors}");
}
