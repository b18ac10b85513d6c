//! `init` and `run`: from a bus to a station with a dashboard.

#![allow(clippy::unwrap_used, clippy::panic, reason = "a test")]

use crate::common::{Folder, Program, get, run, run_with, until};
use crate::until::pause;
use profivac_recorder::{Micros, Reader};
use std::fs;
use std::io::{Read, Write};
use std::net::{TcpListener, TcpStream};
use std::os::unix::fs::PermissionsExt;
use std::path::Path;
use std::time::{Duration, Instant};

const TIMEOUT: Duration = Duration::from_secs(60);

/// A folder with the file of a segment in memory.
fn memory_segment() -> (Folder, String) {
    let folder = Folder::new();
    let file = folder.name("memory.toml");
    fs::write(&file, "devices = [\"bcg450@5\", \"psg550@6\"]\nbaud = 187500\n").unwrap();
    (folder, format!("sim:{file}"))
}

/// Writes a file that only its owner may read, so that no notice appears.
fn private(file: &str, text: &str) {
    use std::os::unix::fs::OpenOptionsExt;
    let mut file = fs::OpenOptions::new().write(true).create_new(true).mode(0o600).open(file).unwrap();
    file.write_all(text.as_bytes()).unwrap();
}

#[test]
fn a_bus_becomes_a_station_with_a_dashboard() {
    let (folder, port) = memory_segment();
    let file = folder.name("plant.toml");
    let made = run(&["init", "--port", &port, "--baud", "187500", "--hsa", "8", "--out", &file]);
    assert!(made.status.success(), "{}", String::from_utf8_lossy(&made.stderr));
    assert_eq!(fs::metadata(&file).unwrap().permissions().mode() & 0o777, 0o600);
    let checked = run(&["run", &file, "--check", "--listen", "127.0.0.1:0"]);
    assert_eq!(String::from_utf8_lossy(&checked.stdout), format!("{file}: 1 segment, 2 gauges\n"));
    let mut station = Program::start(&["run", &file, "--listen", "127.0.0.1:0"]);
    let ready = station.ready();
    let address = ready.strip_prefix("http://").unwrap();
    let gauges = until(address, "/api/gauges", "\"data-exchange\"");
    assert!(gauges.contains("\"bcg450 5\""), "{gauges}");
    assert!(get(address, "/").contains("<div id=\"app\">"));
    // A changed file, and one with an error.
    let text = fs::read_to_string(&file).unwrap();
    fs::write(&file, text.replace("bcg450 5", "Chamber")).unwrap();
    station.hang_up();
    until(address, "/api/gauges", "\"Chamber\"");
    fs::write(&file, "nonsense").unwrap();
    station.hang_up();
    assert!(station.complaint().contains("the station keeps the present configuration"));
    // A service has no terminal: the events say it too.
    let events = until(address, "/api/events?from=0&to=4102444800000", "the station keeps the present configuration");
    assert!(events.contains("the changed file was not taken: ") && events.contains("plant.toml:1:"), "{events}");
    assert!(get(address, "/api/gauges").contains("\"Chamber\""));
    station.terminate();
    assert_eq!(station.exit_code(), 0);
    assert!(fs::metadata(folder.name("plant.db")).unwrap().len() > 0);
}

#[test]
fn errors_of_a_file_are_reported_before_anything_starts() {
    let folder = Folder::new();
    let file = folder.name("plant.toml");
    fs::write(&file, "[[segment]]\nname = \"a\"\nport = \"/dev/null\"\nbaud = 1\n").unwrap();
    let ended = run(&["run", &file]);
    assert_eq!(ended.status.code(), Some(2));
    let complaint = String::from_utf8_lossy(&ended.stderr).into_owned();
    assert!(complaint.starts_with(&format!("profivac: {file}:4:8: expected a PROFIBUS rate, one of ")), "{complaint}");
    let missing = run(&["run", &folder.name("missing.toml")]);
    assert_eq!(missing.status.code(), Some(2));
}

#[test]
fn check_reads_the_files_of_memory_segments() {
    let (folder, port) = memory_segment();
    let file = folder.name("plant.toml");
    fs::write(&file, format!("[[segment]]\nname = \"a\"\nport = {port:?}\n")).unwrap();
    let ended = run(&["run", &file, "--check", "--listen", "127.0.0.1:0"]);
    assert_eq!((ended.status.code(), ended.stdout.is_empty()), (Some(0), false));
    let hint = String::from_utf8_lossy(&ended.stderr).into_owned();
    assert!(hint.contains("the segment \"a\" has no [[segment.gauge]]"), "{hint}");
    fs::write(folder.name("memory.toml"), "devices = [\"bcg451@5\"]\n").unwrap();
    let ended = run(&["run", &file, "--check", "--listen", "127.0.0.1:0"]);
    assert_eq!(ended.status.code(), Some(2));
    let complaint = String::from_utf8_lossy(&ended.stderr).into_owned();
    assert!(complaint.contains("memory.toml:1:12: unknown device \"bcg451\""), "{complaint}");
}

#[test]
fn a_change_that_needs_a_restart_is_reported_and_a_dead_port_does_not_delay_the_end() {
    let folder = Folder::new();
    let file = folder.name("plant.toml");
    // A listener with a full backlog neither accepts nor refuses connections.
    let full = TcpListener::bind("127.0.0.1:0").unwrap();
    rustix::net::listen(&full, 0).unwrap();
    let address = full.local_addr().unwrap();
    let _first = TcpStream::connect(address).unwrap();
    let text = format!("[[segment]]\nname = \"a\"\nport = \"tcp://{address}\"\n");
    private(&file, &text);
    let mut station = Program::start(&["run", &file, "--listen", "127.0.0.1:0"]);
    assert!(station.complaint().contains("has no [[segment.gauge]]"));
    let url = station.ready();
    fs::write(&file, format!("[station]\ndatabase = \"other.db\"\n{text}")).unwrap();
    station.hang_up();
    let complaint = station.complaint();
    assert!(complaint.contains("until the station is restarted, then it becomes "), "{complaint}");
    let address = url.strip_prefix("http://").unwrap();
    until(address, "/api/events?from=0&to=4102444800000", "until the station is restarted, then it becomes ");
    let second = run(&["run", &file, "--listen", "127.0.0.1:0", "--check"]);
    assert_eq!(second.status.code(), Some(0), "another database");
    fs::write(&file, &text).unwrap();
    let second = run(&["run", &file, "--listen", "127.0.0.1:0"]);
    assert_eq!(second.status.code(), Some(2));
    let complaint = String::from_utf8_lossy(&second.stderr).into_owned();
    assert!(complaint.contains("plant.db is in use by another station"), "{complaint}");
    station.terminate();
    assert_eq!(station.exit_code(), 0);
}

#[test]
fn other_computers_reach_a_station_only_with_tls_and_users() {
    let (folder, port) = memory_segment();
    let file = folder.name("plant.toml");
    fs::write(&file, format!("[[segment]]\nname = \"a\"\nport = {port:?}\n")).unwrap();
    // --check reports the same errors.
    for arguments in [&["run", &file, "--listen", "0.0.0.0:0"][..], &["run", &file, "--listen", "0.0.0.0:0", "--check"]]
    {
        let ended = run(arguments);
        assert_eq!(ended.status.code(), Some(2), "{arguments:?}");
        let complaint = String::from_utf8_lossy(&ended.stderr).into_owned();
        assert_eq!(
            complaint.lines().last().unwrap_or_default(),
            "profivac: listening beyond loopback on 0.0.0.0:0 needs TLS: add [tls] with certificate and key to \
             the station's file"
        );
    }
}

#[test]
fn check_finds_a_missing_certificate() {
    let (folder, port) = memory_segment();
    let file = folder.name("plant.toml");
    let text = format!("[tls]\ncertificate = \"a.pem\"\nkey = \"a.key\"\n[[segment]]\nname = \"a\"\nport = {port:?}\n");
    fs::write(&file, text).unwrap();
    fs::set_permissions(&file, fs::Permissions::from_mode(0o600)).unwrap();
    let ended = run(&["run", &file, "--check", "--listen", "127.0.0.1:0"]);
    assert_eq!(ended.status.code(), Some(2));
    let complaint = String::from_utf8_lossy(&ended.stderr).into_owned();
    assert!(
        complaint.contains("plant.toml:3:7: key in [tls]: ") && complaint.contains("a.key: No such file"),
        "{complaint}"
    );
}

/// Status and body of the answer to a POST with JSON.
fn post(address: &str, path: &str, headers: &str, body: &str) -> String {
    let mut stream = TcpStream::connect(address).unwrap();
    let length = body.len();
    write!(
        stream,
        "POST {path} HTTP/1.1\r\nHost: {address}\r\nConnection: close\r\nContent-Type: application/json\r\n\
         Content-Length: {length}\r\n{headers}\r\n{body}"
    )
    .unwrap();
    let mut answer = String::new();
    stream.read_to_string(&mut answer).unwrap();
    answer
}

#[test]
fn users_of_the_command_log_in_and_a_running_station_logs_removed_users_out() {
    let (folder, port) = memory_segment();
    let file = folder.name("plant.toml");
    private(&file, &format!("[[segment]]\nname = \"a\"\nport = {port:?}\n"));
    let password = "tin whisker plateau";
    let added = run_with(&["user", "add", "ada", "--role", "engineer", &file, "--password-stdin"], password);
    assert!(added.status.success(), "{}", String::from_utf8_lossy(&added.stderr));
    let mut station = Program::start(&["run", &file, "--listen", "127.0.0.1:0"]);
    let ready = station.ready();
    let address = ready.strip_prefix("http://").unwrap();
    assert!(get(address, "/api/gauges").starts_with("HTTP/1.1 401"));
    let login =
        |password: &str| post(address, "/api/login", "", &format!("{{\"name\":\"ada\",\"password\":{password:?}}}"));
    assert!(login("wrong").starts_with("HTTP/1.1 401"));
    assert!(login(password).starts_with("HTTP/1.1 200"));
    assert!(run(&["user", "remove", "ada", &file]).status.success());
    let end = Instant::now() + TIMEOUT;
    while !login(password).starts_with("HTTP/1.1 401") {
        assert!(Instant::now() < end, "a removed user still logs in");
        pause();
    }
    station.terminate();
    assert_eq!(station.exit_code(), 0);
    let database = fs::read(folder.name("plant.db")).unwrap();
    assert!(!database.windows(password.len()).any(|octets| octets == password.as_bytes()), "it has no password");
}

/// The status line of the answer to a request with this session.
fn status(address: &str, session: &str) -> String {
    let (mut stream, port) = (TcpStream::connect(address).unwrap(), address.rsplit(':').next().unwrap());
    write!(
        stream,
        "GET /api/gauges HTTP/1.1\r\nHost: {address}\r\nConnection: close\r\nCookie: profivac-{port}={session}\r\n\r\n"
    )
    .unwrap();
    let mut answer = String::new();
    stream.read_to_string(&mut answer).unwrap();
    answer.lines().next().unwrap().to_owned()
}

#[test]
fn a_login_outlasts_the_end_of_the_program_and_its_next_start() {
    let (folder, port) = memory_segment();
    let file = folder.name("plant.toml");
    private(&file, &format!("[[segment]]\nname = \"a\"\nport = {port:?}\n"));
    let password = "tin whisker plateau";
    let added = run_with(&["user", "wall", "screen", &file, "--password-stdin"], password);
    assert!(added.status.success(), "{}", String::from_utf8_lossy(&added.stderr));
    let mut station = Program::start(&["run", &file, "--listen", "127.0.0.1:0"]);
    let ready = station.ready();
    let address = ready.strip_prefix("http://").unwrap();
    let login = format!("{{\"name\":\"screen\",\"password\":{password:?}}}");
    let answer = post(address, "/api/login", "", &login);
    let cookie = answer.lines().find_map(|line| line.strip_prefix("set-cookie: ")).unwrap();
    let session = cookie.split(['=', ';']).nth(1).unwrap();
    assert_eq!(status(address, session), "HTTP/1.1 200 OK");
    station.terminate();
    assert_eq!(station.exit_code(), 0);
    let station = Program::start(&["run", &file, "--listen", "127.0.0.1:0"]);
    let ready = station.ready();
    let address = ready.strip_prefix("http://").unwrap();
    assert_eq!(status(address, session), "HTTP/1.1 200 OK");
    assert_eq!(status(address, &"0".repeat(64)), "HTTP/1.1 401 Unauthorized");
}

#[test]
fn a_file_that_names_secrets_must_be_private() {
    let (folder, port) = memory_segment();
    let file = folder.name("plant.toml");
    let segment = format!("[[segment]]\nname = \"a\"\nport = {port:?}\n");
    private(&file, &segment);
    fs::set_permissions(&file, fs::Permissions::from_mode(0o644)).unwrap();
    let ended = run(&["run", &file, "--check", "--listen", "127.0.0.1:0"]);
    assert_eq!(ended.status.code(), Some(0));
    let notice = format!("other users can read {file}; run chmod 600 {file}\n");
    assert!(String::from_utf8_lossy(&ended.stderr).ends_with(&notice), "{ended:?}");
    for more in [
        "[tls]\ncertificate = \"a.pem\"\nkey = \"a.key\"\n",
        "[[webhook]]\nurl = \"https://alarms.example/\"\ntoken = \"abc\"\n",
        "[station]\nusers = \"people.toml\"\n",
    ] {
        fs::write(&file, format!("{more}{segment}")).unwrap();
        let ended = run(&["run", &file, "--check", "--listen", "127.0.0.1:0"]);
        let complaint = String::from_utf8_lossy(&ended.stderr).into_owned();
        assert_eq!(ended.status.code(), Some(2), "{complaint}");
        assert!(complaint.ends_with(&format!("(mode 644): chmod 600 {file}\n")), "{complaint}");
    }
    fs::set_permissions(&file, fs::Permissions::from_mode(0o600)).unwrap();
    let ended = run(&["run", &file]);
    let complaint = String::from_utf8_lossy(&ended.stderr).into_owned();
    assert_eq!(ended.status.code(), Some(2), "{complaint}");
    assert!(
        complaint.contains("people.toml does not exist: `profivac user add NAME --role engineer FILE.toml` creates it"),
        "{complaint}"
    );
}

#[test]
fn a_token_file_must_be_private_and_a_readable_database_causes_a_notice() {
    let (folder, port) = memory_segment();
    let (file, token, record) = (folder.name("plant.toml"), folder.name("a.token"), folder.name("plant.db"));
    let hook = "[[webhook]]\nurl = \"https://alarms.example/\"\ntoken-file = \"a.token\"\n";
    private(&file, &format!("{hook}[[segment]]\nname = \"a\"\nport = {port:?}\n"));
    for open in [&token, &record] {
        private(open, "abc");
        fs::set_permissions(open, fs::Permissions::from_mode(0o644)).unwrap();
    }
    let ended = run(&["run", &file, "--check", "--listen", "127.0.0.1:0"]);
    let complaint = String::from_utf8_lossy(&ended.stderr).into_owned();
    assert_eq!(ended.status.code(), Some(2), "{complaint}");
    let wanted = format!("{file}:3:14: {token} holds secrets and is open to others (mode 644): chmod 600 {token}\n");
    assert!(complaint.ends_with(&wanted), "{complaint}");
    fs::set_permissions(&token, fs::Permissions::from_mode(0o600)).unwrap();
    let ended = run(&["run", &file, "--check", "--listen", "127.0.0.1:0"]);
    let complaint = String::from_utf8_lossy(&ended.stderr).into_owned();
    assert_eq!(ended.status.code(), Some(0), "{complaint}");
    assert!(
        complaint.ends_with(&format!("other users can read the database {record}; run chmod 600 {record}\n")),
        "{complaint}"
    );
}

#[test]
fn init_reads_the_model_of_a_device_whose_ident_number_others_share() {
    let folder = Folder::new();
    let memory = folder.name("memory.toml");
    fs::write(&memory, "devices = [\"psg552@6\", \"pcg554@7\"]\nbaud = 187500\n").unwrap();
    let made = run(&["init", "--port", &format!("sim:{memory}"), "--baud", "187500", "--hsa", "8"]);
    let text = String::from_utf8_lossy(&made.stdout).into_owned();
    for (name, device, address) in [("psg552 6", "psg552", 6), ("pcg554 7", "pcg554", 7)] {
        let gauge = format!("name = \"{name}\"\naddress = {address}\ndevice = \"{device}\"\n");
        assert!(text.contains(&gauge), "{text}");
    }
}

#[test]
fn init_never_overwrites_a_file() {
    let (folder, port) = memory_segment();
    let file = folder.name("plant.toml");
    fs::write(&file, "mine").unwrap();
    let ended = run(&["init", "--port", &port, "--baud", "187500", "--hsa", "6", "--out", &file]);
    assert_eq!(ended.status.code(), Some(2));
    let complaint = String::from_utf8_lossy(&ended.stderr).into_owned();
    assert!(complaint.contains("plant.toml exists already"), "{complaint}");
    assert_eq!(fs::read_to_string(&file).unwrap(), "mine");
}

#[test]
fn the_dashboard_of_the_demonstration_shows_all_devices() {
    let demo = Program::start(&["demo", "--headless", "--listen", "127.0.0.1:0", "--speed", "5"]);
    let stderr = demo.complaint();
    let address = stderr.strip_prefix("profivac: the dashboard is at http://").unwrap_or_else(|| panic!("{stderr}"));
    let end = Instant::now() + TIMEOUT;
    loop {
        let gauges = get(address, "/api/gauges");
        let measuring = gauges.matches("\"data-exchange\"").count() + gauges.matches("\"fault\"").count();
        if measuring == 12 {
            break;
        }
        assert!(Instant::now() < end, "{gauges}");
        pause();
    }
    let blocks = get(address, "/api/gauges/bcg450%205/blocks");
    assert!(blocks.starts_with("HTTP/1.1 200") && blocks.contains("\"Safe Value\""), "{blocks}");
    assert!(get(address, "/").contains("<div id=\"app\">"));
}

/// A segment in memory with one gauge, as the file of a station has it.
fn one_gauge(port: &str) -> String {
    format!(
        "[[segment]]\nname = \"a\"\nport = {port:?}\n[[segment.gauge]]\nname = \"chamber\"\naddress = 5\ndevice = \"bcg450\"\n"
    )
}

/// A station with a gateway for Prometheus on an address that a listener of this test has.
fn taken_address() -> (Folder, String, TcpListener) {
    let (folder, port) = memory_segment();
    let file = folder.name("plant.toml");
    let listener = TcpListener::bind("127.0.0.1:0").unwrap();
    let address = listener.local_addr().unwrap();
    private(&file, &format!("{}[prometheus]\nlisten = \"{address}\"\n", one_gauge(&port)));
    (folder, file, listener)
}

#[test]
fn a_gateway_whose_address_is_taken_is_a_notice_and_an_event_and_the_station_goes_on() {
    let (_folder, file, listener) = taken_address();
    let mut station = Program::start(&["run", &file, "--listen", "127.0.0.1:0"]);
    station.ready();
    let expected = format!("prometheus does not run: cannot listen on {}", listener.local_addr().unwrap());
    let complaint = station.complaint();
    assert!(complaint.contains(&expected) && complaint.contains("tries again"), "{complaint}");
    station.interrupt();
    assert_eq!(station.exit_code(), 0);
    let reader = Reader::open(&Path::new(&file).with_extension("db")).unwrap();
    let events = reader.events(Micros(0), Micros(i64::MAX), 100).unwrap();
    assert!(events.iter().any(|event| event.text.contains(&expected)), "{events:?}");
}

#[test]
fn a_dashboard_whose_address_is_taken_is_a_notice() {
    let (folder, port) = memory_segment();
    let file = folder.name("plant.toml");
    private(&file, &one_gauge(&port));
    let listener = TcpListener::bind("127.0.0.1:0").unwrap();
    let listen = listener.local_addr().unwrap().to_string();
    let station = Program::start(&["run", &file, "--listen", &listen]);
    let complaint = station.complaint();
    assert!(complaint.contains(&format!("the dashboard does not run: cannot listen on {listen}")), "{complaint}");
}

#[test]
fn the_check_finds_two_parts_with_one_address_also_while_a_station_runs() {
    let (_folder, file, listener) = taken_address();
    let address = listener.local_addr().unwrap().to_string();
    let station = Program::start(&["run", &file, "--listen", "127.0.0.1:0"]);
    station.ready();
    let checked = run(&["run", &file, "--check", "--listen", &address]);
    let complaint = String::from_utf8_lossy(&checked.stderr).into_owned();
    let expected =
        format!("the dashboard listens on {address} and [prometheus] on {address}; give one of them another port");
    assert!(checked.status.code() == Some(2) && complaint.contains(&expected), "{complaint}");
}

#[test]
fn the_check_tries_the_addresses_unless_a_station_runs_on_the_database() {
    let (_folder, file, listener) = taken_address();
    let check = || run(&["run", &file, "--check", "--listen", "127.0.0.1:0"]);
    let checked = check();
    let complaint = String::from_utf8_lossy(&checked.stderr).into_owned();
    let expected = format!("[prometheus] cannot listen on {}", listener.local_addr().unwrap());
    assert!(checked.status.code() == Some(3) && complaint.contains(&expected), "{complaint}");
    let station = Program::start(&["run", &file, "--listen", "127.0.0.1:0"]);
    station.ready();
    assert_eq!(check().status.code(), Some(0), "the station itself may have the addresses");
}

#[test]
fn a_limit_and_a_gauge_that_change_in_the_file_are_events_and_rows_of_the_audit_trail() {
    let (folder, port) = memory_segment();
    let file = folder.name("plant.toml");
    let text =
        format!("{}[[alarm]]\nname = \"too high\"\ngauge = \"chamber\"\nabove = \"1e-3 mbar\"\n", one_gauge(&port));
    fs::write(&file, &text).unwrap();
    let station = Program::start(&["run", &file, "--listen", "127.0.0.1:0"]);
    let url = station.ready();
    let address = url.strip_prefix("http://").unwrap();
    fs::write(&file, text.replace("1e-3 mbar", "2e-3 mbar").replace("address = 5\n", "address = 5\npoll = \"1 s\"\n"))
        .unwrap();
    station.hang_up();
    let events = until(address, "/api/events?from=0&to=4102444800000", "the file changes segment");
    assert!(events.contains("the file changes alarm \\\"too high\\\" above"), "{events}");
    let audit = until(address, "/api/audit?from=0&to=4102444800000", "\"target\":\"segment \\\"a\\\" gauge");
    let row =
        "\"target\":\"alarm \\\"too high\\\" above\",\"before\":\"\\\"1e-3 mbar\\\"\",\"after\":\"\\\"2e-3 mbar\\\"\"";
    assert!(audit.contains(row) && audit.contains("\"user\":\"file\""), "{audit}");
}

/// A gauge of a device file is a gauge of the station: found, read and recorded with the tables of the file, which stay until the restart.
#[test]
fn a_station_runs_a_gauge_of_a_device_file() {
    let folder = Folder::new();
    let (file, device) = (folder.name("plant.toml"), folder.name("bpg402.toml"));
    let described = include_str!("../../../docs/devices/files/bpg402.toml");
    fs::write(&device, described).unwrap();
    fs::write(folder.name("line.toml"), "devices = [\"bpg402.toml@7\"]\npressure = \"5e-6 mbar\"\n").unwrap();
    let gauge = "[[segment.gauge]]\nname = \"chamber\"\naddress = 7\ndevice = \"bpg402.toml\"\n";
    private(&file, &format!("[[segment]]\nname = \"hall\"\nport = \"sim:line.toml\"\n{gauge}"));
    let mut station = Program::start(&["run", &file, "--listen", "127.0.0.1:0"]);
    let ready = station.ready();
    let address = ready.strip_prefix("http://").unwrap();
    let gauges = until(address, "/api/gauges", "\"quality\":\"valid\"");
    assert!(gauges.contains("\"device\":\"bpg402\""), "{gauges}");
    let commands = get(address, "/api/gauges/chamber/commands");
    assert!(commands.contains("\"device.reset\""), "{commands}");
    fs::write(&device, described.replace("0xFFF0", "0xFFF1")).unwrap();
    station.hang_up();
    let complaint = station.complaint();
    assert!(complaint.contains("the device file of bpg402 has changed"), "{complaint}");
    until(address, "/api/events?from=0&to=4102444800000", "the device file of bpg402 has changed");
    assert!(get(address, "/api/gauges").contains("\"data-exchange\""), "the gauge goes on");
    station.terminate();
    assert_eq!(station.exit_code(), 0);
}
