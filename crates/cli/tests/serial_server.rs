//! ser2net as the server of a line: raw octets, telnet, and telnet with control of the port (RFC 2217), with the file of docs/adapters.md.

#![allow(clippy::unwrap_used, clippy::panic, reason = "a test")]

use crate::common::{Folder, Program, run};
use std::net::{TcpListener, TcpStream};
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

/// The longest wait for ser2net. A test that waits longer has failed.
const TIMEOUT: Duration = Duration::from_secs(60);

/// A slot time of 200 ms, in bit times, so that a loaded computer misses no answer.
const PATIENTLY: &str = "--slot-time=4000";

/// The TCP ports of a server.
#[derive(Clone, Copy)]
struct Ports {
    raw: u16,
    telnet: u16,
    control: u16,
    /// Nothing is behind it: it shows that the others listen.
    last: u16,
}

impl Ports {
    fn free() -> Self {
        let [raw, telnet, control, last] = [(); 4].map(|()| free());
        Self { raw, telnet, control, last }
    }

    /// The names of the ports for profivac, one of each protocol.
    fn names(self) -> [String; 3] {
        [("tcp", self.raw), ("telnet", self.telnet), ("rfc2217", self.control)]
            .map(|(scheme, port)| format!("{scheme}://127.0.0.1:{port}"))
    }
}

/// ser2net in front of a pty.
struct Server {
    process: Child,
    ports: Ports,
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

/// The file of ser2net in docs/adapters.md, for the pty `line` and these ports.
fn documented(line: &str, ports: Ports) -> String {
    let page = std::fs::read_to_string("../../docs/adapters.md").unwrap();
    let (_, rest) = page.split_once("```yaml\n").unwrap();
    let (file, _) = rest.split_once("```").unwrap();
    for (name, count) in [("/dev/ttyUSB0", 2), ("tcp,4000", 1), ("tcp,4001", 1)] {
        assert_eq!(file.matches(name).count(), count, "{name} in {file}");
    }
    let listens = |port: u16| format!("tcp,127.0.0.1,{port}");
    file.replace("/dev/ttyUSB0", line)
        .replace("tcp,4000", &listens(ports.raw))
        .replace("tcp,4001", &listens(ports.control))
}

/// Starts ser2net for the pty `line`.
fn serve(folder: &Folder, line: &str, ports: Ports) -> Server {
    let connection = |name: &str, accepter: &str, port: u16, device: &str| {
        format!(
            "connection: &{name}\n  accepter: {accepter}tcp,127.0.0.1,{port}\n  connector: serialdev,{device},19200e81,local\n"
        )
    };
    let file = [
        documented(line, ports),
        connection("telnet", "telnet,", ports.telnet, line),
        connection("last", "", ports.last, &folder.name("nothing")),
    ];
    let path = folder.name("ser2net.yaml");
    std::fs::write(&path, file.concat()).unwrap();
    let mut command = Command::new("ser2net");
    command.args(["-n", "-c", &path]).stdout(Stdio::null()).stderr(Stdio::null());
    let process = command.spawn().unwrap_or_else(|error| panic!("ser2net ({error}): ./test installs it"));
    let server = Server { process, ports };
    let begun = Instant::now();
    while TcpStream::connect(("127.0.0.1", ports.last)).is_err() {
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
    let server = serve(&folder, &line, Ports::free());
    // ser2net gives no control at its telnet port, and octets pass all the same.
    let without_control = format!("rfc2217://127.0.0.1:{}", server.ports.telnet);
    for port in server.ports.names().into_iter().chain([without_control]) {
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
    let server = serve(&folder, &line, Ports::free());
    let control = server.ports.control;
    let (_, output, errors) = on(&format!("tcp://127.0.0.1:{control}"), &["scan", "--hsa", "6"]);
    let expected = format!("speaks telnet, which changes octets of the line: use telnet://127.0.0.1:{control}");
    assert!(errors.contains(&expected), "{output}{errors}");
}

/// Reads rows of a monitor until one contains `text`.
fn shows(monitor: &Program, text: &str) {
    let shown = (0..200).any(|_| monitor.line().contains(text));
    assert!(shown, "{text} is not shown");
}

#[test]
fn monitor_survives_a_restart_of_ser2net_over_each_protocol() {
    let ports = Ports::free();
    for port in ports.names() {
        let folder = Folder::new();
        let line = folder.name("line");
        let mut simulate = Program::start(&["simulate", "--pty", &line, "--pressure", "1e-3 mbar", "bcg450@5"]);
        simulate.ready();
        let server = serve(&folder, &line, ports);
        let monitor = Program::start(&["monitor", "--port", &port, "--own", "--csv", PATIENTLY, "5"]);
        shows(&monitor, ",5,bcg450,1e-3,mbar,1e-3,2,DATA,");
        drop(server);
        monitor.wait_for_complaint(&format!("lost {port}"));
        shows(&monitor, ",OFFLINE,");
        assert_eq!(simulate.tell("pressure 3e-7 mbar"), "ok");
        let _server = serve(&folder, &line, ports);
        monitor.wait_for_complaint(&format!("{port} is open again"));
        shows(&monitor, ",5,bcg450,3e-7,mbar,3e-7,2,DATA,");
    }
}

/// The findings of `doctor` about a port, and its exit code.
fn doctor(port: &str) -> (Option<i32>, String) {
    // Long enough for a master that a loaded computer delays.
    let output = run(&["doctor", port, "--for", "5"]);
    (output.status.code(), String::from_utf8(output.stdout).unwrap())
}

#[test]
fn doctor_examines_a_line_behind_ser2net_over_each_protocol() {
    let folder = Folder::new();
    let [slave, master, server] = ["slave", "master", "server"].map(|name| folder.name(name));
    let hub = Program::start(&["hub", "--pty", &slave, "--pty", &master, "--pty", &server]);
    hub.ready();
    let simulate = Program::start(&["simulate", "--serial", &slave, "bcg450@5"]);
    simulate.ready();
    let server = serve(&folder, &server, Ports::free());
    let silent = doctor(&server.ports.names()[0]);
    assert!(silent.0 == Some(0) && silent.1.contains("the line is silent: no master sends"), "{silent:?}");
    let monitor = Program::start(&["monitor", "--port", &master, "--own", "--csv", PATIENTLY, "5"]);
    shows(&monitor, ",DATA,");
    for port in server.ports.names() {
        let (code, found) = doctor(&port);
        assert!(found.contains(" telegrams at ") && found.contains("masters: 0"), "{port}: {found}");
        assert_eq!(code, Some(0), "{port}: {found}");
    }
    let (code, found) = doctor(&format!("tcp://127.0.0.1:{}", server.ports.control));
    assert!(found.contains("speaks telnet") && !found.contains("exchange the wires"), "{found}");
    assert_eq!(code, Some(3), "{found}");
}
