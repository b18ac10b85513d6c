//! Functions that only Linux has: transmitters switched by the kernel, the latency of USB adapters, events of ptys.
//!
//! Other systems use `other.rs` instead.

use super::notice::Notice;
use super::{AdapterFacts, Delivery};
use crate::readiness::Readiness;
use rustix::fd::OwnedFd;
use rustix::fs::inotify::{self, CreateFlags, WatchFlags};
use rustix::io::Errno;
use serial2::SerialPort;
use serial2::rs4xx::{Rs485Config, TransceiverMode};
use std::fs;
use std::hash::{DefaultHasher, Hash as _, Hasher as _};
use std::io;
use std::os::linux::net::SocketAddrExt as _;
use std::os::unix::fs::MetadataExt as _;
use std::os::unix::net::{SocketAddr, UnixListener};
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::time::Duration;

/// The folder in which the kernel describes its terminals.
const TERMINALS: &str = "/sys/class/tty";

/// The shortest latency of a USB adapter, in milliseconds. profibus-wire 9.4, point 36.
const LATENCY_MS: u32 = 1;

/// Whether a device is the slave side of a pty.
pub fn is_pty(path: impl AsRef<Path>) -> bool {
    fs::canonicalize(path).is_ok_and(|device| device.starts_with("/dev/pts"))
}

/// The latency of a USB adapter whose driver does not tell it. chosen: the longest that is usual, the default of FTDI
/// chips. profibus-wire 9.4, point 36.
const ASSUMED_LATENCY: Duration = Duration::from_millis(16);

/// The numbers by which the kernel calls UARTs of the 8250 family, PORT_8250 to PORT_MAX_8250. Linux, serial_core.h.
const FAMILY_8250: std::ops::RangeInclusive<u32> = 1..=31;

/// A UART of the 8250 family takes 16 samples of a bit.
const SAMPLES_PER_BIT: u32 = 16;

/// Improves the settings of a serial device as far as possible. Returns a notice for each that cannot be improved.
pub fn set_up(device: &OwnedFd, name: &str) -> Vec<Notice> {
    let Ok(path) = fs::canonicalize(name) else { return Vec::new() };
    let Some(terminal) = terminal_of(&path) else { return Vec::new() };
    // chosen: most USB adapters for RS-485 switch their transmitter themselves, so they get no notice.
    let direction = (!is_usb(&terminal)).then(|| switch_transmitter(device, name)).flatten();
    direction.into_iter().chain(lower_latency(&terminal, &path, name)).collect()
}

/// The programs that have a device open besides this one, as far as this user may see: their names and processes. A lock
/// does not keep out a program that opened the device before, or one of root.
fn other_programs(device: &Path) -> Vec<(String, u32)> {
    let processes = fs::read_dir("/proc").into_iter().flatten().flatten();
    let pids = processes.filter_map(|process| process.file_name().to_str()?.parse::<u32>().ok());
    let has_open = |pid: &u32| {
        let files = fs::read_dir(format!("/proc/{pid}/fd")).into_iter().flatten().flatten();
        files.filter_map(|file| fs::read_link(file.path()).ok()).any(|file| file == device)
    };
    let name = |pid: u32| fs::read_to_string(format!("/proc/{pid}/comm")).unwrap_or_default().trim().to_owned();
    pids.filter(|pid| *pid != std::process::id()).filter(has_open).map(|pid| (name(pid), pid)).collect()
}

/// A notice for each other program that has the device open.
pub fn open_elsewhere(name: &str) -> Vec<Notice> {
    let Ok(device) = fs::canonicalize(name) else { return Vec::new() };
    let notice = |(program, pid)| Notice::OpenElsewhere { name: name.to_owned(), program, pid };
    other_programs(&device).into_iter().map(notice).collect()
}

/// How the driver of a serial device delivers characters, as the kernel describes it.
pub fn delivery(name: &str) -> Delivery {
    terminal(name).map_or(Delivery::Fifo { trigger: None }, |terminal| delivery_of(&terminal))
}

/// The driver of a serial device, and the kind of a USB adapter.
pub fn adapter_facts(name: &str) -> AdapterFacts {
    terminal(name).map(|terminal| adapter_facts_of(&terminal)).unwrap_or_default()
}

fn adapter_facts_of(terminal: &Path) -> AdapterFacts {
    let device = terminal.join("device");
    let driver = fs::canonicalize(device.join("driver")).ok();
    let driver = driver.as_deref().and_then(Path::file_name).map(|name| name.to_string_lossy().into_owned());
    let text = |file: PathBuf| fs::read_to_string(file).ok().map(|text| text.trim().to_owned());
    let usb_id = fs::canonicalize(device).ok().filter(|_| is_usb(terminal)).and_then(|device| {
        let id =
            |folder: &Path| Some(format!("{}:{}", text(folder.join("idVendor"))?, text(folder.join("idProduct"))?));
        device.ancestors().find_map(id)
    });
    AdapterFacts { driver, usb_id }
}

fn delivery_of(terminal: &Path) -> Delivery {
    if !is_usb(terminal) {
        return Delivery::Fifo {
            trigger: number(&terminal.join("rx_trig_bytes")).and_then(|octets| octets.try_into().ok()),
        };
    }
    match number(&terminal.join("device/latency_timer")) {
        // A driver that reports 0 has read nothing from the chip yet.
        Some(ms) => Delivery::Usb { hold: Duration::from_millis(ms.max(LATENCY_MS).into()), is_known: true },
        None => Delivery::Usb { hold: ASSUMED_LATENCY, is_known: false },
    }
}

/// The highest rate of a CH340 or CH341. Linux, ch341.c.
const CH341_MAX_RATE: u32 = 3_000_000;

/// The rate at which a device really runs if its driver was asked for `wanted` bit/s and reports that rate whatever it set.
/// `None` for other drivers.
pub fn real_rate(name: &str, wanted: u32) -> Option<u32> {
    real_rate_of(&terminal(name)?, wanted)
}

fn real_rate_of(terminal: &Path, wanted: u32) -> Option<u32> {
    match adapter_facts_of(terminal).driver.as_deref() {
        Some("ch341-uart" | "ch341") => Some(rate_of_ch341(wanted)),
        _ => rate_of_8250(terminal, wanted),
    }
}

/// A CH340 or CH341 takes its highest rate in place of a higher one. Below, its divisors are closer than the tolerated
/// deviation.
pub fn rate_of_ch341(wanted: u32) -> u32 {
    wanted.min(CH341_MAX_RATE)
}

/// A UART of the 8250 family divides its clock by a whole number.
fn rate_of_8250(terminal: &Path, wanted: u32) -> Option<u32> {
    number(&terminal.join("type")).filter(|kind| FAMILY_8250.contains(kind))?;
    let base = number(&terminal.join("uartclk"))?.checked_div(SAMPLES_PER_BIT)?;
    let divisor = base.saturating_add(wanted.checked_div(2)?).checked_div(wanted)?.max(1);
    base.checked_div(divisor).filter(|rate| *rate > 0)
}

/// The number in a file of the kernel.
fn number(file: &Path) -> Option<u32> {
    fs::read_to_string(file).ok()?.trim().parse().ok()
}

/// The folder of a device below [`TERMINALS`].
fn terminal(name: &str) -> Option<PathBuf> {
    terminal_of(&fs::canonicalize(name).ok()?)
}

/// The same for the path of a device without links.
fn terminal_of(device: &Path) -> Option<PathBuf> {
    Some(Path::new(TERMINALS).join(device.file_name()?))
}

/// The port of the USB adapter with this serial number.
pub fn port_of_serial(serial: &str) -> Option<String> {
    port_of_serial_in(Path::new(TERMINALS), serial)
}

fn port_of_serial_in(terminals: &Path, serial: &str) -> Option<String> {
    let of_adapter = |terminal: &Path| {
        let device = fs::canonicalize(terminal.join("device")).ok()?;
        let text = |folder: &Path| fs::read_to_string(folder.join("serial")).ok();
        device.ancestors().find_map(text).map(|text| text.trim().to_owned())
    };
    let terminals = fs::read_dir(terminals).ok()?.flatten().map(|terminal| terminal.path());
    let is_it = |terminal: &PathBuf| is_usb(terminal) && of_adapter(terminal).as_deref() == Some(serial);
    let mut found: Vec<PathBuf> = terminals.filter(is_it).collect();
    // An adapter with several ports: its first one.
    found.sort();
    Some(format!("/dev/{}", found.first()?.file_name()?.to_string_lossy()))
}

fn is_usb(terminal: &Path) -> bool {
    let device = fs::canonicalize(terminal.join("device"));
    device.is_ok_and(|path| path.components().any(|part| part.as_os_str().to_string_lossy().starts_with("usb")))
}

/// Lets the kernel switch the transmitter on for each telegram. An existing setting with its delays and polarity stays as
/// the administrator made it.
fn switch_transmitter(device: &OwnedFd, name: &str) -> Option<Notice> {
    let is_switched = |port: &SerialPort| matches!(port.get_rs4xx_mode(), Ok(TransceiverMode::Rs485(_)));
    let port = SerialPort::from(device.try_clone().ok()?);
    let done = is_switched(&port) || (port.set_rs4xx_mode(Rs485Config::new()).is_ok() && is_switched(&port));
    (!done).then(|| Notice::TransmitterNotSwitched(name.to_owned()))
}

/// Sets the latency timer of a USB adapter to the minimum: through the file of the driver, which usually requires root, or
/// with the flag ASYNC_LOW_LATENCY, which every user of the port may set. Its system call needs `unsafe`, so the program
/// `setserial` makes it. `device` is the whole path without links, so it is no option of `setserial`, whatever the port is
/// called.
fn lower_latency(terminal: &Path, device: &Path, name: &str) -> Option<Notice> {
    let setting = terminal.join("device/latency_timer");
    let high = || number(&setting).filter(|ms| *ms > LATENCY_MS);
    high()?;
    if fs::write(&setting, LATENCY_MS.to_string()).is_err() || high().is_some() {
        let mut setserial = Command::new("setserial");
        setserial.arg(device).arg("low_latency").stdin(Stdio::null()).stdout(Stdio::null()).stderr(Stdio::null());
        // Whether it was successful is read back.
        setserial.status().ok();
    }
    let ms = high()?;
    Some(Notice::Latency { name: name.to_owned(), ms, setting })
}

/// Reports every opening of the slave side of a pty, and that a program has closed it which could write.
///
/// One instance of inotify watches all ptys of a link, one after another: a user has 128 instances (fs.inotify.max_user_instances).
#[derive(Debug)]
pub struct OpenEvents(OwnedFd);

impl OpenEvents {
    /// Watches nothing yet.
    pub fn new() -> Result<Self, Errno> {
        inotify::init(CreateFlags::NONBLOCK | CreateFlags::CLOEXEC).map(Self)
    }

    /// Watches `side` too, until its pty is closed, which is the last event.
    pub fn watch(&self, side: &Path) -> Result<(), Errno> {
        inotify::add_watch(&self.0, side, WatchFlags::OPEN | WatchFlags::CLOSE_WRITE).map(drop)
    }

    /// Becomes readable when the slave side is opened or closed.
    pub fn readiness(&self) -> Option<Readiness<'_>> {
        Some(Readiness::of(&self.0))
    }

    /// Discards all events so far. Returns whether there were any.
    pub fn drain(&self) -> bool {
        let mut buffer = [0; super::CHUNK];
        let mut found = false;
        while let Ok(1..) = rustix::io::read(&self.0, &mut buffer) {
            found = true;
        }
        found
    }
}

/// Holds the name of the link of a pty among all processes, until it is dropped or its process ends. The name is that of an
/// abstract Unix socket, which leaves no file behind.
#[derive(Debug)]
pub struct LinkClaim {
    _socket: UnixListener,
}

impl LinkClaim {
    /// Claims the link `path`, whatever way leads to its folder.
    ///
    /// # Errors
    /// `EEXIST` when another process holds it; the error of the system when its folder is missing.
    pub fn of(path: &Path) -> io::Result<Self> {
        let address = SocketAddr::from_abstract_name(name_of_claim(path)?)?;
        let socket = UnixListener::bind_addr(&address).map_err(|error| match error.kind() {
            io::ErrorKind::AddrInUse => Errno::EXIST.into(),
            _ => error,
        })?;
        Ok(Self { _socket: socket })
    }

    /// Whether a process holds the link `path`. The kernel's list of sockets says so: a connection would stay in the queue of the holder.
    pub fn is_held(path: &Path) -> bool {
        let Ok(name) = name_of_claim(path) else { return false };
        let sockets = fs::read_to_string("/proc/net/unix").unwrap_or_default();
        sockets.split_ascii_whitespace().any(|word| word.strip_prefix('@') == Some(&name))
    }
}

/// The name of the abstract socket of a link, the same for every way to its folder.
fn name_of_claim(path: &Path) -> io::Result<String> {
    let parent = path.parent().filter(|parent| !parent.as_os_str().is_empty());
    let folder = fs::metadata(parent.unwrap_or(Path::new(".")))?;
    let mut name = DefaultHasher::new();
    (folder.dev(), folder.ino(), path.file_name()).hash(&mut name);
    Ok(format!("profivac-pty-{:016x}", name.finish()))
}

#[cfg(test)]
mod tests {
    use super::*;

    const NAME: &str = "/dev/ttyUSB0";

    fn latency_of(ms: &str) -> (tempfile::TempDir, PathBuf) {
        let terminal = tempfile::tempdir().unwrap();
        fs::create_dir(terminal.path().join("device")).unwrap();
        let setting = terminal.path().join("device/latency_timer");
        fs::write(&setting, ms).unwrap();
        (terminal, setting)
    }

    #[test]
    fn the_latency_of_an_adapter_is_lowered() {
        let (terminal, setting) = latency_of("16\n");
        assert_eq!(lower_latency(terminal.path(), Path::new(NAME), NAME), None);
        assert_eq!(fs::read_to_string(setting).unwrap(), "1");
    }

    #[test]
    fn a_latency_that_cannot_be_lowered_is_a_notice() {
        let terminal = tempfile::tempdir().unwrap();
        fs::create_dir(terminal.path().join("device")).unwrap();
        let setting = terminal.path().join("device/latency_timer");
        // Reads as a number and cannot be written, even by root.
        std::os::unix::fs::symlink("/proc/sys/kernel/cap_last_cap", &setting).unwrap();
        let Some(Notice::Latency { ms, .. }) = lower_latency(terminal.path(), Path::new(NAME), NAME) else {
            panic!("no notice")
        };
        assert!(ms > LATENCY_MS);
    }

    #[test]
    fn an_adapter_without_such_a_setting_is_left_alone() {
        let (terminal, setting) = latency_of("1\n");
        assert_eq!(lower_latency(terminal.path(), Path::new(NAME), NAME), None);
        assert_eq!(fs::read_to_string(&setting).unwrap(), "1\n", "not written without need");
        fs::remove_file(setting).unwrap();
        assert_eq!(lower_latency(terminal.path(), Path::new(NAME), NAME), None);
    }

    /// A folder as the kernel makes it for a UART.
    fn uart(files: &[(&str, &str)]) -> tempfile::TempDir {
        let terminal = tempfile::tempdir().unwrap();
        for (name, text) in files {
            fs::write(terminal.path().join(name), text).unwrap();
        }
        terminal
    }

    /// The clock of a PC's UART, 1.8432 MHz, has 115200 and 38400 bit/s beside 93750 and 45450.
    #[test]
    fn the_rate_of_an_8250_follows_from_its_clock() {
        let terminal = uart(&[("type", "4\n"), ("uartclk", "1843200\n")]);
        for (wanted, real) in [
            (9_600, 9_600),
            (19_200, 19_200),
            (45_450, 38_400),
            (93_750, 115_200),
            (187_500, 115_200),
            (12_000_000, 115_200),
        ] {
            assert_eq!(real_rate_of(terminal.path(), wanted), Some(real), "{wanted}");
        }
        let other = uart(&[("type", "32\n"), ("uartclk", "1843200\n")]);
        assert_eq!(real_rate_of(other.path(), 93_750), None, "a PL011 divides by fractions");
        assert_eq!(real_rate_of(uart(&[]).path(), 93_750), None);
    }

    /// Adapters below `usb1` as the kernel describes them, and a port of the computer without one.
    #[test]
    fn an_adapter_is_found_by_its_serial_number() {
        let root = tempfile::tempdir().unwrap();
        let terminals = root.path().join("tty");
        for (name, port, serial) in
            [("ttyUSB0", "usb1/1-1", "A1"), ("ttyUSB2", "usb1/1-2", "B2"), ("ttyUSB1", "usb1/1-2", "B2")]
        {
            let device = root.path().join(port).join(name);
            fs::create_dir_all(&device).unwrap();
            fs::write(root.path().join(port).join("serial"), format!("{serial}\n")).unwrap();
            fs::create_dir_all(terminals.join(name)).unwrap();
            std::os::unix::fs::symlink(&device, terminals.join(name).join("device")).unwrap();
        }
        fs::create_dir_all(root.path().join("pnp/00:01")).unwrap();
        fs::write(root.path().join("pnp/00:01/serial"), "C3\n").unwrap();
        fs::create_dir_all(terminals.join("ttyS0")).unwrap();
        std::os::unix::fs::symlink(root.path().join("pnp/00:01"), terminals.join("ttyS0/device")).unwrap();
        let found = |serial: &str| port_of_serial_in(&terminals, serial);
        assert_eq!(found("A1").as_deref(), Some("/dev/ttyUSB0"));
        assert_eq!(found("B2").as_deref(), Some("/dev/ttyUSB1"), "the first port of an adapter with two");
        assert_eq!((found("C3"), found("a1"), found("")), (None, None, None));
    }

    #[test]
    fn a_ch341_runs_at_its_highest_rate_in_place_of_a_higher_one() {
        let root = tempfile::tempdir().unwrap();
        let (device, driver) = (root.path().join("usb1/ttyUSB0"), root.path().join("drivers/ch341-uart"));
        fs::create_dir_all(&device).unwrap();
        fs::create_dir_all(&driver).unwrap();
        std::os::unix::fs::symlink(&driver, device.join("driver")).unwrap();
        std::os::unix::fs::symlink(&device, root.path().join("device")).unwrap();
        for (wanted, real) in
            [(19_200, 19_200), (3_000_000, 3_000_000), (6_000_000, 3_000_000), (12_000_000, 3_000_000)]
        {
            assert_eq!(real_rate_of(root.path(), wanted), Some(real), "{wanted}");
        }
    }

    #[test]
    fn the_delivery_of_a_uart_has_the_trigger_of_its_fifo() {
        let terminal = uart(&[("rx_trig_bytes", "8\n")]);
        assert_eq!(delivery_of(terminal.path()), Delivery::Fifo { trigger: Some(8) });
        assert_eq!(delivery_of(uart(&[]).path()), Delivery::Fifo { trigger: None });
    }

    #[test]
    fn the_delivery_of_a_usb_adapter_has_its_latency_or_an_assumption() {
        let root = tempfile::tempdir().unwrap();
        let device = root.path().join("usb1/ttyUSB0");
        fs::create_dir_all(&device).unwrap();
        let terminal = root.path().join("ttyUSB0");
        fs::create_dir(&terminal).unwrap();
        std::os::unix::fs::symlink(&device, terminal.join("device")).unwrap();
        assert_eq!(delivery_of(&terminal), Delivery::Usb { hold: ASSUMED_LATENCY, is_known: false });
        for (reported, ms) in [("2\n", 2), ("16\n", 16), ("0\n", 1)] {
            fs::write(device.join("latency_timer"), reported).unwrap();
            assert_eq!(delivery_of(&terminal), Delivery::Usb { hold: Duration::from_millis(ms), is_known: true });
        }
    }

    #[test]
    fn a_program_that_has_a_device_open_is_named() {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("ttyUSB0");
        fs::write(&file, "").unwrap();
        assert_eq!(other_programs(&file), []);
        let input = fs::File::open(&file).unwrap();
        let mut other = Command::new("tail").args(["-f", "/dev/null"]).stdin(input).spawn().unwrap();
        let found = other_programs(&file);
        other.kill().unwrap();
        other.wait().unwrap();
        // A child has the name of this program until it has replaced itself.
        assert_eq!(found.iter().map(|(_, pid)| *pid).collect::<Vec<_>>(), [other.id()]);
    }

    #[test]
    fn the_facts_of_an_adapter_are_its_driver_and_its_usb_identity() {
        let root = tempfile::tempdir().unwrap();
        let usb = root.path().join("usb1/1-2");
        let device = usb.join("1-2:1.0/ttyUSB0");
        let driver = root.path().join("bus/drivers/ftdi_sio");
        fs::create_dir_all(&device).unwrap();
        fs::create_dir_all(&driver).unwrap();
        std::os::unix::fs::symlink(&driver, device.join("driver")).unwrap();
        for (file, text) in [("idVendor", "0403\n"), ("idProduct", "6001\n"), ("serial", "FT1234\n")] {
            fs::write(usb.join(file), text).unwrap();
        }
        let terminal = root.path().join("ttyUSB0");
        fs::create_dir(&terminal).unwrap();
        std::os::unix::fs::symlink(&device, terminal.join("device")).unwrap();
        let expected = AdapterFacts { driver: Some("ftdi_sio".to_owned()), usb_id: Some("0403:6001".to_owned()) };
        assert_eq!(adapter_facts_of(&terminal), expected);
        assert_eq!(adapter_facts("/dev/null/nothing"), AdapterFacts::default());
    }

    #[test]
    fn a_terminal_without_transmitter_control_is_a_notice() {
        // A pty refuses the setting like a UART without RS-485.
        let ours = rustix::pty::openpt(rustix::pty::OpenptFlags::RDWR | rustix::pty::OpenptFlags::NOCTTY).unwrap();
        assert_eq!(switch_transmitter(&ours, NAME), Some(Notice::TransmitterNotSwitched(NAME.to_owned())));
    }

    #[test]
    fn a_usb_adapter_is_known_by_its_place() {
        let root = tempfile::tempdir().unwrap();
        for (place, usb) in [("devices/pci0000:00/usb1/1-2/ttyUSB0", true), ("devices/platform/serial8250", false)] {
            fs::create_dir_all(root.path().join(place)).unwrap();
            let terminal = root.path().join(if usb { "ttyUSB0" } else { "ttyS0" });
            fs::create_dir(&terminal).unwrap();
            std::os::unix::fs::symlink(root.path().join(place), terminal.join("device")).unwrap();
            assert_eq!(is_usb(&terminal), usb, "{place}");
        }
    }
}
