//! Functions that only Linux has: transmitters switched by the kernel, the latency of USB adapters, events of ptys.
//!
//! Other systems use `other.rs` instead.

use super::notice::Notice;
use crate::readiness::Readiness;
use rustix::fd::OwnedFd;
use rustix::fs::inotify::{self, CreateFlags, WatchFlags};
use rustix::io::Errno;
use serial2::SerialPort;
use serial2::rs4xx::{Rs485Config, TransceiverMode};
use std::fs;
use std::path::{Path, PathBuf};

/// The folder in which the kernel describes its terminals.
const TERMINALS: &str = "/sys/class/tty";

/// The shortest latency of a USB adapter, in milliseconds. profibus-wire 9.4, point 36.
const LATENCY_MS: u32 = 1;

/// Whether a device is the slave side of a pty.
pub fn is_pty(name: &str) -> bool {
    fs::canonicalize(name).is_ok_and(|device| device.starts_with("/dev/pts"))
}

/// Improves the settings of a serial device as far as possible. Returns a notice for each that cannot be improved.
pub fn set_up(device: &OwnedFd, name: &str) -> Vec<Notice> {
    let Some(terminal) = terminal(name) else { return Vec::new() };
    // free choice: most USB adapters for RS-485 switch their transmitter themselves, so they get no notice.
    let direction = (!is_usb(&terminal)).then(|| switch_transmitter(device, name)).flatten();
    direction.into_iter().chain(lower_latency(&terminal, name)).collect()
}

/// The folder of a device below [`TERMINALS`].
fn terminal(name: &str) -> Option<PathBuf> {
    let device = fs::canonicalize(name).ok()?;
    Some(Path::new(TERMINALS).join(device.file_name()?))
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

/// Sets the latency timer of a USB adapter to the minimum.
fn lower_latency(terminal: &Path, name: &str) -> Option<Notice> {
    let setting = terminal.join("device/latency_timer");
    let read = || fs::read_to_string(&setting).ok()?.trim().parse().ok();
    let is_high = |ms: &u32| *ms > LATENCY_MS;
    read().filter(is_high)?;
    // Writing usually requires root, so the value is read back.
    fs::write(&setting, LATENCY_MS.to_string()).ok();
    let ms = read().filter(is_high)?;
    Some(Notice::Latency { name: name.to_owned(), ms, setting })
}

/// Reports every opening of the slave side of a pty.
#[derive(Debug)]
pub struct OpenEvents(OwnedFd);

impl OpenEvents {
    /// Watches `side`.
    pub fn watch(side: &Path) -> Result<Self, Errno> {
        let openings = inotify::init(CreateFlags::NONBLOCK | CreateFlags::CLOEXEC)?;
        inotify::add_watch(&openings, side, WatchFlags::OPEN)?;
        Ok(Self(openings))
    }

    /// Becomes readable when the slave side is opened.
    pub fn readiness(&self) -> Option<Readiness<'_>> {
        Some(Readiness::of(&self.0))
    }

    /// Discards all events so far.
    pub fn drain(&self) {
        let mut buffer = [0; super::CHUNK];
        while let Ok(1..) = rustix::io::read(&self.0, &mut buffer) {}
    }
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
        assert_eq!(lower_latency(terminal.path(), NAME), None);
        assert_eq!(fs::read_to_string(setting).unwrap(), "1");
    }

    #[test]
    fn a_latency_that_cannot_be_lowered_is_a_notice() {
        let terminal = tempfile::tempdir().unwrap();
        fs::create_dir(terminal.path().join("device")).unwrap();
        let setting = terminal.path().join("device/latency_timer");
        // Reads as a number and cannot be written, even by root.
        std::os::unix::fs::symlink("/proc/sys/kernel/cap_last_cap", &setting).unwrap();
        let Some(Notice::Latency { ms, .. }) = lower_latency(terminal.path(), NAME) else { panic!("no notice") };
        assert!(ms > LATENCY_MS);
    }

    #[test]
    fn an_adapter_without_such_a_setting_is_left_alone() {
        let (terminal, setting) = latency_of("1\n");
        assert_eq!(lower_latency(terminal.path(), NAME), None);
        assert_eq!(fs::read_to_string(&setting).unwrap(), "1\n", "not written without need");
        fs::remove_file(setting).unwrap();
        assert_eq!(lower_latency(terminal.path(), NAME), None);
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
