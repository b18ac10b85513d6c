//! The command lines that help texts and pages of the documentation show, run in a shell. docs/first-steps.md, docs/first-station.md and
//! docs/plc.md, whose commands follow each other, are run by `first_steps`.
//!
//! A command line runs in a folder of its own with the files that the examples name, with gauges and a slave on a line in place of the port,
//! and with a short time in place of a long one. What the program would ask on a terminal is agreed to as a script agrees. The exit code is 0
//! unless [`REFUSED`] has the line.

#![allow(clippy::unwrap_used, clippy::panic, reason = "a test")]

use crate::common::{self, Folder, Program, run};
use profivac_recorder::{Deadband, Micros, Quality, Recorder, Retention, Sample, Settings};
use std::collections::BTreeSet;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Output, Stdio};
use std::sync::{Arc, OnceLock};
use std::time::Duration;

/// The ports of examples.
const PORTS: [&str; 4] = ["/dev/ttyUSB0", "/tmp/line", "tcp://127.0.0.1:4000", "tcp://127.0.0.1:4500"];

/// The commands that end by a signal, unless this word is in the line.
const LASTING: [(&str, &str); 6] = [
    ("demo", "--for"),
    ("simulate", "--show"),
    ("hub", "--for"),
    ("monitor", "--for"),
    ("run", "--check"),
    ("sniff", "--for"),
];

/// The commands that ask on a terminal, a part of the line with which they do, and the option with which a script agrees.
const AGREED: [(&str, &str, &str); 2] = [("address", "--lock", "--yes"), ("write", "--octets", "--yes")];

/// Command lines that end with an error here, with a part of its text. Everything else ends with 0.
const REFUSED: [(&str, &str); 3] = [
    // The station of this test has no TLS.
    ("--listen 0.0.0.0:8443", "needs TLS"),
    // A pty has no rate to find.
    ("--baud auto", "no t"),
    // No gas was let in in the record of this test.
    ("--dose-at", "expected the dose"),
];

/// The files of the examples. A station, and a database with a pump-down that began yesterday.
const STATION: &str = "
[station]
name = 'hall'
database = 'plant.db'
listen = '127.0.0.1:0'
[[segment]]
name = 'hall'
port = 'sim:segment.toml'
[[segment.gauge]]
name = 'chamber'
address = 5
device = 'bcg450'
";

const SEGMENT: &str = "devices = ['bcg450@5']\n";

/// A telegram with its answer, as a text.
const LOG: &str = "TX 68 05 05 68 85 82 6D 3C 3E EE 16\nRX 68 0B 0B 68 82 85 08 3E 3C 02 05 00 FF 08 E6 7D 16\n";

/// A command line, and where it stands.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
struct Shown {
    line: String,
    place: String,
}

impl Shown {
    /// The command of the program.
    fn command(&self) -> &str {
        self.line.split_whitespace().nth(1).unwrap_or_default()
    }
}

fn sources() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../..").canonicalize().unwrap()
}

/// The command lines of the help texts.
fn of_the_help() -> Vec<Shown> {
    let of = |arguments: &[&str], place: &str| {
        let help = String::from_utf8(run(arguments).stdout).unwrap();
        let lines = help.lines().filter_map(|line| line.strip_prefix("  profivac "));
        lines.map(|line| Shown { line: format!("profivac {line}"), place: place.to_owned() }).collect::<Vec<_>>()
    };
    let commands = common::commands();
    commands.iter().flat_map(|name| of(&[name, "--help"], name)).chain(of(&["--help"], "profivac")).collect()
}

/// The command lines in the code blocks of the documentation.
fn of_the_pages() -> Vec<Shown> {
    const ELSEWHERE: [&str; 5] = ["first-steps.md", "first-station.md", "plc.md", "corrections.md", "CHANGELOG.md"];
    let mut shown = Vec::new();
    for folder in ["docs", "docs/paths", "docs/devices", "firmware", "contrib/archive", "."] {
        for file in fs::read_dir(sources().join(folder)).unwrap() {
            let path = file.unwrap().path();
            let name = path.file_name().unwrap().to_str().unwrap().to_owned();
            if !name.ends_with(".md") || ELSEWHERE.contains(&name.as_str()) {
                continue;
            }
            let page = fs::read_to_string(&path).unwrap();
            let blocks: Vec<&str> = page.split("\n```").skip(1).step_by(2).collect();
            for line in blocks.join("\n").replace("\\\n", " ").lines() {
                let line = line.split_once("$ ").map_or(line, |(_, line)| line).trim();
                let line = line.strip_prefix("sudo -u profivac ").unwrap_or(line);
                if line.starts_with("profivac ") && !line.contains("...") {
                    shown.push(Shown { line: line.to_owned(), place: format!("{folder}/{name}") });
                }
            }
        }
    }
    shown
}

/// Every command line once. `a && b` are two.
fn all() -> Vec<Shown> {
    let mut seen = BTreeSet::new();
    let every = of_the_help().into_iter().chain(of_the_pages());
    let each = every.flat_map(|shown| {
        let parts: Vec<Shown> =
            shown.line.split(" && ").map(|line| Shown { line: line.trim().to_owned(), ..shown.clone() }).collect();
        parts
    });
    each.filter(|shown| seen.insert(shown.line.split(" #").next().unwrap_or_default().trim().to_owned())).collect()
}

/// A folder with the files of the examples, and what else runs meanwhile.
struct Workplace {
    folder: Folder,
    programs: Vec<Program>,
}

impl Workplace {
    fn new() -> Self {
        let folder = Folder::new();
        for name in ["gsd_files", "gsd", "home/.zfunc", "home/.config/fish/completions", "backup", "tmp", "new"] {
            fs::create_dir_all(folder.path(name)).unwrap();
        }
        fs::create_dir_all(folder.path("home/.local/share/bash-completion/completions")).unwrap();
        let gsd = sources().join("tests/support/gsd");
        for (from, to) in [
            ("valves.gsd", "valves.gsd"),
            ("valves.gsd", "gsd_files/valves.gsd"),
            ("pressure.gsd", "gsd_files/pressure.gsd"),
            ("valves.gsd", "gsd/valves.gsd"),
            ("valves.gsd", "VALVES.GSD"),
            ("valves.gsd", "VALVE.GSD"),
            ("encoder.gsd", "PUMP.GSD"),
        ] {
            fs::copy(gsd.join(from), folder.path(to)).unwrap();
        }
        for (name, text) in [
            ("plant.toml", STATION),
            ("segment.toml", SEGMENT),
            ("valves.toml", "[modules]\n1 = 3\n2 = 7\n3 = 3\n"),
            ("log.txt", LOG),
            ("password.txt", "correct horse battery staple\n"),
            ("pressures.csv", "time,5\n"),
        ] {
            fs::write(folder.path(name), text).unwrap();
        }
        let only_mine = std::os::unix::fs::PermissionsExt::from_mode(0o600);
        fs::set_permissions(folder.path("plant.toml"), only_mine).unwrap();
        fs::write(
            folder.path("line.bin"),
            common::octets(&LOG.replace("TX ", "").replace("RX ", "").replace('\n', " ")),
        )
        .unwrap();
        fs::copy(recorded(), folder.path("plant.db")).unwrap();
        Self { folder, programs: Vec::new() }
    }

    fn start(&mut self, arguments: &[&str]) {
        let program = Program::of(self.shell(&format!("exec profivac {}", arguments.join(" "))).stdout(Stdio::piped()));
        program.ready();
        self.programs.push(program);
    }

    /// A command in a shell of an ordinary user.
    fn shell(&self, command: &str) -> Command {
        let program = Path::new(env!("CARGO_BIN_EXE_profivac")).parent().unwrap();
        let path = format!("{}:{}", program.display(), std::env::var("PATH").unwrap());
        let mut shell = Command::new("sh");
        shell.args(["-c", command]).current_dir(self.folder.path(""));
        shell.env("PATH", path).env("HOME", self.folder.path("home")).env("TZ", "UTC");
        shell
    }

    /// Makes a file with the program that the documentation names for it.
    fn make(&self, command: &str) {
        let output = self.shell(command).stdin(Stdio::null()).output().unwrap();
        assert!(output.status.success(), "{command}: {}", text(&output));
    }

    /// Serves the line, if the command has a port, and makes the files that the command reads.
    fn prepare(&mut self, line: &str) {
        if line.contains("PORT") {
            let gauges = match line {
                _ if line.contains("--from 126") => "bcg450@126",
                _ if line.contains("trip-point") => "pcg550@5",
                _ => "bcg450@5 bcg450@6 psg550@7",
            };
            let slave = match line {
                _ if line.contains("valves.toml") => "valves.gsd@9:modules=3+7+3",
                _ if line.contains("9") => "valves.gsd@9:modules=3+7",
                _ => "",
            };
            self.start(&["simulate --pty line --pressure '5e-6 mbar'", gauges, slave]);
            if line.contains("--octets") {
                let slave = self.programs.last_mut().unwrap();
                for record in ["record 9 1 19 01 02", "record 9 1 24 00 00"] {
                    assert_eq!(slave.tell(record), "ok");
                }
            }
        }
        if line.contains("profivac names") {
            self.make("printf '[prometheus]\n[modbus]\n[epics]\n[opcua]\n' >> plant.toml");
        }
        if line.contains("degas on") {
            self.make("profivac write --port line --address 5 --slot-time 4000 execute");
        }
        if line.contains("--out plant.toml") {
            fs::remove_file(self.folder.path("plant.toml")).unwrap();
        }
        if line.contains("report backup/plant-monday.db") {
            self.make("cp plant.db backup/plant-monday.db");
        }
        if line.contains("gauge.toml") && !line.contains("--out gauge.toml") {
            self.make("profivac dump --port line --address 5 --slot-time 4000 --out gauge.toml");
        }
        if line.contains("capture.pcapng") {
            self.make("profivac decode log.txt --out capture.pcapng");
        }
        if line.contains("my-plant.toml") {
            self.make("profivac simulate --scenario pump-down --show > my-plant.toml");
        }
        if line.contains("simulate --serial") {
            self.start(&["hub --pty tmp/a --pty tmp/b --pty tmp/c"]);
        }
        if ["user role", "user password", "user remove"].iter().any(|command| line.contains(command)) {
            self.make("profivac user add ada --role viewer plant.toml --password-stdin < password.txt");
        }
        if line.contains("pressures.csv") && line.contains("identify") {
            self.make("profivac export plant.toml | sed 's/chamber/5/' > pressures.csv");
        }
    }
}

/// A database with the pump-downs of the examples: yesterday at 14:00 and two hours ago, each for two hours with two samples a minute.
fn recorded() -> &'static Path {
    static DATABASE: OnceLock<(Folder, PathBuf)> = OnceLock::new();
    let (_, path) = DATABASE.get_or_init(|| {
        let folder = Folder::new();
        let path = folder.path("plant.db");
        let retention = Retention { samples: None, ..Retention::default() };
        let settings =
            Settings { deadband: Deadband::default(), full_rate_window: Duration::ZERO, retention, outbox: None };
        let recorder = Recorder::start(&path, settings).unwrap();
        let gauge: Arc<str> = Arc::from("chamber");
        let now = Micros::now();
        for begin in [yesterday(now, 8), yesterday(now, 14), now.before(Duration::from_secs(7_000))] {
            for step in 0..230_u32 {
                let t = f64::from(step) * 30.0 - 120.0;
                let pa = 101_325.0 * (-t.max(0.0) / 60.0).exp() + 1e-5 + 0.1 / t.max(1.0);
                let at = begin.after(Duration::from_secs(u64::from(step) * 30));
                recorder.push(&gauge, Sample::new(at, Some(pa), Quality::Valid));
            }
        }
        recorder.finish().unwrap();
        (folder, path)
    });
    path
}

/// This hour of yesterday, UTC.
fn yesterday(now: Micros, hour: u64) -> Micros {
    let day = 86_400 * Micros::SECOND;
    Micros(now.0.div_euclid(day) * day - day).after(Duration::from_secs(hour * 3_600))
}

/// The date of yesterday, as in `2026-11-21`.
fn date_of_yesterday() -> String {
    let at = jiff::Timestamp::from_microsecond(yesterday(Micros::now(), 0).0).unwrap();
    at.to_zoned(jiff::tz::TimeZone::UTC).date().to_string()
}

/// The line with the names of this workplace: `PORT` for its port.
fn adapted(line: &str) -> String {
    let line = line.split(" #").next().unwrap_or_default().split(" || ").next().unwrap_or_default();
    let mut line = line.replace("$baud", "19200").replace("2026-11-21", &date_of_yesterday());
    let begins = |command: &str| line.starts_with(&format!("profivac {command} "));
    let serves = begins("simulate") || begins("hub");
    if serves {
        line = line.replace("/dev/ttyUSB0", "LINE");
        // A path of a pty that exists belongs to somebody.
        line = line.replace("--pty /tmp/", "--pty new/").replace("--serial /tmp/", "--serial tmp/");
    } else {
        for port in PORTS {
            line = line.replace(port, "PORT");
        }
    }
    for (from, to) in
        [("/tmp/", "tmp/"), ("/backup/", "backup/"), ("/etc/profivac/", ""), ("127.0.0.1:9090", "127.0.0.1:0")]
    {
        line = line.replace(from, to);
    }
    line = with_number(&line, "--for", "1");
    for (command, part, option) in AGREED {
        let asks = line.starts_with(&format!("profivac {command} ")) && line.contains(part);
        if asks && !line.contains(option) {
            line = line.replacen(command, &format!("{command} {option}"), 1);
        }
    }
    for (command, option) in [
        ("demo", "--listen 127.0.0.1:0"),
        ("scan", "--hsa 10"),
        ("init", "--hsa 10"),
        ("user add", "--password-stdin"),
        ("user password", "--password-stdin"),
    ] {
        let (name, _) = option.split_once(' ').unwrap_or((option, ""));
        let is_of = line.starts_with(&format!("profivac {command}"));
        if is_of && !line.contains(name) {
            line = line.replacen(command, &format!("{command} {option}"), 1);
        }
    }
    if line.contains("--password-stdin") && !line.contains('<') {
        line += " < password.txt";
    }
    // A loaded computer delays the answers.
    let is_master = !["doctor", "sniff", "--listen-only"].iter().any(|word| line.contains(word));
    if is_master { line.replacen("--port PORT", "--port PORT --slot-time 4000", 1) } else { line }
}

/// The line with this value of an option that has a number.
fn with_number(line: &str, option: &str, value: &str) -> String {
    let mut words: Vec<&str> = line.split(' ').collect();
    let at = words.iter().position(|word| *word == option).map(|at| at + 1);
    if let Some(number) = at.and_then(|at| words.get_mut(at)).filter(|word| word.parse::<u32>().is_ok()) {
        *number = value;
    }
    words.join(" ")
}

fn text(output: &Output) -> String {
    [&output.stdout, &output.stderr].map(|octets| String::from_utf8_lossy(octets).into_owned()).concat()
}

/// Runs a command line as a user would; one that lasts is ended by Ctrl-C after its first line.
fn follow(shown: &Shown) {
    let Shown { line, place } = shown;
    let mut workplace = Workplace::new();
    let adapted = adapted(line);
    workplace.prepare(&adapted);
    let typed = adapted.replace("PORT", "line").replace("LINE", "tmp/c");
    let command = shown.command();
    let lasts = LASTING.iter().any(|(name, unless)| *name == command && !typed.contains(unless));
    let refused = REFUSED.iter().find(|(part, _)| line.contains(part));
    if lasts && refused.is_none() {
        let mut program = Program::of(&mut workplace.shell(&format!("exec {typed}")));
        // `sniff` hears nothing on this line. The first line of `demo` is the head of a table.
        let first = match command {
            "sniff" => program.complaint(),
            "demo" => program.line() + &program.line(),
            _ => program.line(),
        };
        program.interrupt();
        assert_eq!(program.exit_code(), 0, "{place}: {typed}: {first}\n{}", program.complaint());
        return;
    }
    let output = workplace.shell(&typed).stdin(Stdio::null()).output().unwrap();
    match refused {
        None => assert!(output.status.success(), "{place}: {typed}: {:?}\n{}", output.status.code(), text(&output)),
        Some((_, part)) => {
            assert!(!output.status.success() && text(&output).contains(part), "{place}: {typed}\n{}", text(&output));
        }
    }
}

/// The groups of commands that run side by side.
const GROUPS: [&[&str]; 5] = [
    &["demo", "run", "user", "names"],
    &["simulate", "hub", "st", "gsd", "completions", "decode"],
    &["scan", "list", "read", "write", "dump", "diff", "restore", "address"],
    &["sniff", "doctor"],
    &["report", "export", "backup", "identify"],
];

/// Commands whose work takes long or needs other servers. Tests with their names run them, `contrib/archive/example.py` runs `archive`.
const ELSEWHERE: [&str; 5] = ["monitor", "init", "conform", "field-test", "archive"];

fn follow_group(number: usize) {
    let shown = all();
    let mut failed = Vec::new();
    for shown in shown.iter().filter(|shown| GROUPS[number].contains(&shown.command())) {
        if let Err(reason) = std::panic::catch_unwind(|| follow(shown)) {
            let reason = reason.downcast_ref::<String>().cloned().unwrap_or_default();
            failed.push(reason);
        }
    }
    assert!(failed.is_empty(), "{}", failed.join("\n\n"));
}

#[test]
fn shown_commands_of_a_station_run() {
    follow_group(0);
}

#[test]
fn shown_commands_without_a_bus_run() {
    follow_group(1);
}

#[test]
fn shown_commands_for_parameters_run() {
    follow_group(2);
}

#[test]
fn shown_commands_that_listen_run() {
    follow_group(3);
}

#[test]
fn shown_commands_for_a_record_run() {
    follow_group(4);
}

#[test]
fn every_shown_command_is_in_one_group() {
    for shown in all() {
        let groups = GROUPS.iter().filter(|group| group.contains(&shown.command())).count();
        let expected = usize::from(!ELSEWHERE.contains(&shown.command()));
        assert_eq!(groups, expected, "{}: {}", shown.place, shown.line);
    }
}
