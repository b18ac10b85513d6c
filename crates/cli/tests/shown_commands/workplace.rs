//! The folder in which a command line runs: the files that the examples name, the stations of a line, and the line with their names.

use super::lines::sources;
use super::text;
use crate::common::{self, Folder, Program, run};
use profivac_recorder::{
    Deadband, Micros, Point, PointKind, PointSample, Quality, Recorder, Retention, Sample, Settings,
};
use rcgen::CertifiedKey;
use std::fmt::Write as _;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::sync::{Arc, OnceLock};
use std::time::Duration;

/// The ports of examples.
const PORTS: [&str; 5] = ["/dev/ttyUSB0", "COM5", "/tmp/line", "tcp://127.0.0.1:4000", "tcp://127.0.0.1:4500"];

/// The port of a command whose result depends on answers in time: a segment in memory is never late.
const MEMORY: &str = "sim:line.toml";

/// Options that a command gets, if it has this part and not the option: addresses that are free, fewer requests, and the options with which a
/// script agrees where the program would ask on a terminal.
const ADDED: [(&str, &str, &str); 15] = [
    ("demo", "", "--listen 127.0.0.1:0"),
    ("scan", "", "--hsa 10"),
    ("init", "", "--hsa 10"),
    ("field-test", "--port", "--hsa 10"),
    ("field-test", "--port", "--cycles 20"),
    ("field-test", "--allow-writes", "--own"),
    ("user add", "", "--password-stdin"),
    ("user wall", "", "--password-stdin"),
    ("user password", "", "--password-stdin"),
    ("address", "--lock", "--yes"),
    ("write", "--octets", "--yes"),
    ("conform", "", "--own"),
    ("monitor", "", "--own"),
    ("monitor", "--gsd", "--outputs '9=00'"),
    // Its output goes to a file, so no line shows that it runs.
    ("monitor", ">", "--for 1"),
];

/// A station, and a database with a pump-down that began yesterday.
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

/// A device file.
const MY_GAUGE: &str = "format = 1\nname = 'my-gauge'\ntitle = 'MY450-SP'\nlike = 'bcg450'\n";

/// An archive whose servers do not run.
const ARCHIVE: &str = "
[nats]
servers = ['nats://127.0.0.1:1']
[postgres]
connection = 'host=127.0.0.1 port=1 user=profivac dbname=profivac'
[view]
listen = '127.0.0.1:0'
users = 'archive.users'
";

/// A slave with two modules and three octets of user parameters, which no file of a vendor describes.
const PLAIN: &str = "#Profibus_DP
GSD_Revision = 1
Vendor_Name = \"Example\"
Model_Name = \"Plain slave\"
Revision = \"1\"
Ident_Number = 0xF002
Protocol_Ident = 0
Station_Type = 0
Hardware_Release = \"1\"
Software_Release = \"1\"
19.2_supp = 1
MaxTsdr_19.2 = 60
Min_Slave_Intervall = 1
Max_Diag_Data_Len = 6
Modular_Station = 1
Max_Module = 2
Max_Input_Len = 2
Max_Output_Len = 2
Max_Data_Len = 4
User_Prm_Data_Len = 3
User_Prm_Data = 0x00,0x00,0x00
Module = \"2 inputs\" 0x11
EndModule
Module = \"2 outputs\" 0x21
EndModule
";

/// A telegram with its answer, as a text.
const LOG: &str = "TX 68 05 05 68 85 82 6D 3C 3E EE 16\nRX 68 0B 0B 68 82 85 08 3E 3C 02 05 00 FF 08 E6 7D 16\n";

/// The begin of a pcap file with link type 147: byte order and version, zeros, the longest packet, the link type.
const PCAP: [u32; 6] = [0xA1B2_C3D4, 0x0004_0002, 0, 0, 0xFFFF, 147];

/// A folder with the files of the examples, and what else runs meanwhile.
pub struct Workplace {
    folder: Folder,
    programs: Vec<Program>,
}

impl Workplace {
    pub fn new() -> Self {
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
            ("archive.toml", ARCHIVE),
            ("plain.gsd", PLAIN),
            ("valves.toml", "[modules]\n1 = 3\n2 = 7\n3 = 3\n"),
            ("log.txt", LOG),
            ("my-gauge.toml", MY_GAUGE),
            ("password.txt", "correct horse battery staple\n"),
        ] {
            fs::write(folder.path(name), text).unwrap();
        }
        fs::write(folder.path("INFI08E6.GSD"), run(&["gsd", "bcg450"]).stdout).unwrap();
        let only_mine = std::os::unix::fs::PermissionsExt::from_mode(0o600);
        fs::set_permissions(folder.path("plant.toml"), only_mine).unwrap();
        fs::write(folder.path("old.pcap"), old_pcap()).unwrap();
        for name in ["line.tar", "line-19200.tar"] {
            fs::copy(sources().join("crates/cli/tests/field/virtual.tar"), folder.path(name)).unwrap();
        }
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

    /// A line on which another master exchanges data with its slaves.
    fn start_running_line(&mut self) {
        self.start(&["hub --pty line --pty tmp/a --pty tmp/b"]);
        self.start(&["simulate --serial tmp/a", DEVICES]);
        let monitor = "exec profivac monitor --port tmp/b --slot-time 4000 --own --json 5 6 7";
        let master = Program::of(&mut self.shell(monitor));
        until_data(&master);
        self.programs.push(master);
    }

    /// A command in a shell of an ordinary user.
    pub fn shell(&self, command: &str) -> Command {
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
    pub fn prepare(&mut self, line: &str) {
        if line.contains("--listen-only") {
            self.start_running_line();
        } else if line.contains(MEMORY) {
            let devices = devices(line);
            let listed = devices.split(' ').filter(|word| word.contains('@')).map(|word| format!("{word:?}"));
            let text = format!("devices = [{}]\n", listed.collect::<Vec<_>>().join(", "));
            fs::write(self.folder.path("line.toml"), text).unwrap();
        } else if line.contains("PORT") {
            self.start(&["simulate --pty line", &devices(line)]);
            if line.contains("--octets") {
                let slave = self.programs.last_mut().unwrap();
                for record in ["record 9 1 19 01 02", "record 9 1 24 00 00"] {
                    assert_eq!(slave.tell(record), "ok");
                }
            }
        }
        // A result has another name than the recorded one.
        if line.contains("field-test") && line.contains("--out") {
            for name in ["line.tar", "line-19200.tar"] {
                fs::remove_file(self.folder.path(name)).unwrap();
            }
        }
        if line.contains("profivac names") {
            self.make("printf '[prometheus]\n[modbus]\n[epics]\n[opcua]\n[mqtt]\nbroker=\"mqtt://127.0.0.1:1\"\n' >> plant.toml");
        }
        if line.contains("degas on") {
            self.make("profivac write --port line --address 5 --slot-time 4000 execute");
        }
        if line.contains("--out plant.toml") {
            fs::remove_file(self.folder.path("plant.toml")).unwrap();
        }
        if line.contains("doctor target-hall.db") {
            self.make("cp plant.db target-hall.db");
        }
        if line.contains("report backup/plant-monday.db") {
            self.make("cp plant.db backup/plant-monday.db");
        }
        if line.contains(" gauge.toml") && !line.contains("--out gauge.toml") {
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
            fs::write(self.folder.path("pressures.csv"), record_with_dose()).unwrap();
        }
        if line.contains("profivac archive") {
            self.make("profivac user add eve --role viewer archive.toml --password-stdin < password.txt");
        }
        if line.contains("--listen 0.0.0.0") {
            self.make("profivac user add ada --role engineer plant.toml --password-stdin < password.txt");
            self.make("printf '[tls]\ncertificate = \"a.pem\"\nkey = \"a.key\"\n' >> plant.toml");
            let CertifiedKey { cert, signing_key } =
                rcgen::generate_simple_self_signed(["localhost".to_owned()]).unwrap();
            fs::write(self.folder.path("a.pem"), cert.pem()).unwrap();
            fs::write(self.folder.path("a.key"), signing_key.serialize_pem()).unwrap();
            self.make("chmod 600 a.key");
        }
    }
}

/// The first row with data: `monitor` must reach its slaves.
pub fn until_data(monitor: &Program) -> String {
    loop {
        match monitor.line() {
            row if row.contains("DATA") => return row,
            _ => {}
        }
    }
}

/// The gauges on a line, unless the command needs another one.
const DEVICES: &str = "--pressure '5e-6 mbar' bcg450@5 bcg450@6 psg550@7";

/// The stations for a command: gauges, and at address 9 the slave with the modules of the line.
fn devices(line: &str) -> String {
    let gauges = match line {
        // Each slave takes half a minute or more.
        _ if line.contains("field-test") && line.contains("gsd_files") => "",
        _ if line.contains("field-test") => "bcg450@5",
        _ if line.contains("--from 126") => "bcg450@126",
        _ if line.contains("trip-point") => "pcg550@5",
        _ => DEVICES,
    };
    let slave = match line {
        _ if line.contains("valves.toml") => "valves.gsd@9:modules=3+7+3",
        _ if line.contains("--prm") => "plain.gsd@9:modules=1+2",
        _ if line.contains('9') || line.contains("gsd_files") => "valves.gsd@9:modules=3+7",
        _ => "",
    };
    format!("{gauges} {slave}")
}

/// A request for the FDL status, in a capture file of the older format.
fn old_pcap() -> Vec<u8> {
    let telegram = common::octets("10 05 02 49 50 16");
    let length = u32::try_from(telegram.len()).unwrap();
    let words = PCAP.into_iter().chain([0, 0, length, length]);
    words.flat_map(u32::to_le_bytes).chain(telegram).collect()
}

/// A database with the pump-downs of the examples: from the evening before yesterday until the valve was closed at 08:00 for half an hour, and
/// for two hours each yesterday at 14:00 and two hours ago.
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
        let (slave, name, unit) = ("turbo".to_owned(), "speed".to_owned(), Some("Hz".to_owned()));
        let speed = Arc::new(Point { slave, name, unit, kind: PointKind::Number });
        let now = Micros::now();
        for (at, pa) in night(yesterday(now, 0).before(Duration::from_secs(8 * 3_600))) {
            recorder.push(&gauge, Sample::new(at, Some(pa), Quality::Valid));
        }
        for begin in [yesterday(now, 14), now.before(Duration::from_secs(7_000))] {
            for step in 0..230_u32 {
                let t = f64::from(step) * 30.0 - 120.0;
                let pa = 101_325.0 * (-t.max(0.0) / 60.0).exp() + 1e-5 + 0.1 / t.max(1.0);
                let at = begin.after(Duration::from_secs(u64::from(step) * 30));
                recorder.push(&gauge, Sample::new(at, Some(pa), Quality::Valid));
                recorder.push_point(&speed, 0.0, PointSample::new(at, Some(t.clamp(0.0, 1000.0)), Quality::Valid));
            }
        }
        recorder.finish().unwrap();
        (folder, path)
    });
    path
}

/// 1.2 m³, pumped with 100 l/s for 16 hours and then closed for half an hour: two samples a minute, in Pa.
fn night(begin: Micros) -> Vec<(Micros, f64)> {
    let (volume_m3, speed_m3_per_s, mut pa, mut samples) = (1.2, 0.1, 101_325.0, Vec::new());
    for second in 0..59_400_u32 {
        if second % 30 == 0 {
            samples.push((begin.after(Duration::from_secs(second.into())), pa));
        }
        let pumped = if second < 57_600 { speed_m3_per_s * pa } else { 0.0 };
        let (leak, walls) = (1e-7, 5e-6 * 3_600.0 / (f64::from(second) + 5.0));
        pa += (leak + walls - pumped) / volume_m3;
    }
    samples
}

/// A record of yesterday as `monitor --csv` writes it: 50 l, pumped with 20 l/s from 12:25, closed at 14:25, and 0.2 mbar l let in at 14:30.
fn record_with_dose() -> String {
    let (volume_m3, speed_m3_per_s, dose_pa_m3) = (0.05, 0.02, 0.02);
    let begin = yesterday(Micros::now(), 12).after(Duration::from_secs(1_500)).0 / Micros::SECOND;
    let (mut text, mut random) = ("unix_time,address,mbar,quality\n".to_owned(), fastrand::Rng::with_seed(4));
    let mut pa = 100.0;
    for second in 0..8_400_u32 {
        if second == 7_500 {
            pa += dose_pa_m3 / volume_m3;
        }
        let noise: f64 = (0..12).map(|_| random.f64()).sum::<f64>() - 6.0;
        let mbar = pa / 100.0 * (1.0 + 0.01 * noise);
        writeln!(text, "{},5,{mbar:e},valid", begin + i64::from(second)).unwrap();
        for tenth in 0..10 {
            let t = f64::from(second) + f64::from(tenth) / 10.0;
            let pumped = if second < 7_200 { speed_m3_per_s * pa } else { 0.0 };
            pa += (2e-7 + 2e-6 * 3_600.0 / (t + 5.0) - pumped) / volume_m3 / 10.0;
        }
    }
    text
}

/// This hour of yesterday, UTC.
fn yesterday(now: Micros, hour: u64) -> Micros {
    let day = 86_400 * Micros::SECOND;
    Micros(now.0.div_euclid(day) * day - day).after(Duration::from_secs(hour * 3_600))
}

/// The date so many days before yesterday, as in `2026-11-21`.
fn date_before_yesterday(days: u64) -> String {
    let begin = yesterday(Micros::now(), 0).before(Duration::from_secs(days * 86_400));
    let at = jiff::Timestamp::from_microsecond(begin.0).unwrap();
    at.to_zoned(jiff::tz::TimeZone::UTC).date().to_string()
}

/// The line with the names of this workplace: `PORT` for its port.
pub fn adapted(line: &str) -> String {
    let line = line.split(" #").next().unwrap_or_default().split(" || ").next().unwrap_or_default();
    let mut line = line.replace("$baud", "19200");
    for (date, days) in [("2026-11-21", 0), ("2026-11-20", 1)] {
        line = line.replace(date, &date_before_yesterday(days));
    }
    let begins = |command: &str| line.starts_with(&format!("profivac {command} "));
    let serves = begins("simulate") || begins("hub");
    if serves {
        line = line.replace("/dev/ttyUSB0", "LINE");
        // A path of a pty that exists belongs to somebody.
        line = line.replace("--pty /tmp/", "--pty new/").replace("--serial /tmp/", "--serial tmp/");
        line = line.replace("127.0.0.1:4000", "127.0.0.1:0");
    } else {
        for port in PORTS {
            line = line.replace(port, "PORT");
        }
    }
    for (from, to) in [
        ("/tmp/", "tmp/"),
        ("/backup/", "backup/"),
        ("/etc/profivac/", ""),
        ("127.0.0.1:9090", "127.0.0.1:0"),
        ("0.0.0.0:8443", "0.0.0.0:0"),
    ] {
        line = line.replace(from, to);
    }
    for (command, part, option) in ADDED {
        let (name, _) = option.split_once(' ').unwrap_or((option, ""));
        let is_of = format!("{line} ").starts_with(&format!("profivac {command} "));
        if is_of && line.contains(part) && !line.contains(name) {
            line = line.replacen(command, &format!("{command} {option}"), 1);
        }
    }
    // Also on a loaded computer a master must reach its slaves, and a station that listens must hear them.
    let is_patient = line.contains("--listen-only") || line.starts_with("profivac monitor ");
    let time = if is_patient { "20" } else { "1" };
    line = with_number(&with_number(&line, "--for", time), "--cycles", "20");
    if line.contains("--password-stdin") && !line.contains('<') {
        line += " < password.txt";
    }
    if line.starts_with("profivac conform ") {
        return line.replace("PORT", MEMORY);
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
