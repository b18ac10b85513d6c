//! A serial device at 8E1, or the slave side of a pty that another program serves.
//!
//! A pty has neither parity nor baud rate, and needs none. On a real device, [`Serial::open`] verifies that the driver
//! accepted what the line requires; what would merely improve it becomes a notice.

use super::echo::Echo;
use super::marks::Marks;
use super::notice::{DropCounter, Notice, Notices};
use super::{
    CHUNK, Character, CharacterFormat, Delivery, Parity, Port, PortError, ReaderSearch, pty, settings, system,
};
use crate::clock::duration_of;
use crate::readiness::Readiness;
use profivac_dp::link::{Baud, CHARACTER_TBIT};
use rustix::fd::OwnedFd;
use rustix::fs::{FlockOperation, Mode, OFlags, flock};
use rustix::io::Errno;
use rustix::termios::{
    ControlModes, InputModes, OptionalActions, QueueSelector, Termios, ioctl_tiocexcl, tcflush, tcgetattr, tcsetattr,
};
use std::os::fd::AsRawFd;
use std::path::Path;
use std::sync::mpsc::{RecvTimeoutError, channel};
use std::time::{Duration, Instant};

/// The longest time that octets need to leave: a few of the longest telegrams at the lowest rate. chosen.
const MAX_SENDING_TIME: Duration = Duration::from_millis(600);

/// The time that a driver has to close a device before the program goes on without waiting. chosen.
const CLOSING_TIME: Duration = Duration::from_millis(100);

/// The longest time that a thread needs to start on a loaded computer. chosen.
const THREAD_START_TIME: Duration = Duration::from_secs(5);

/// Whether a name may be a serial device: an absolute path.
#[must_use]
pub fn is_serial_port(name: &str) -> bool {
    name.starts_with('/')
}

/// Whether this user may open a serial device, without opening it.
///
/// # Errors
/// [`PortError::NotFound`] and [`PortError::PermissionDenied`].
pub fn check_access(name: &str) -> Result<(), PortError> {
    rustix::fs::access(name, rustix::fs::Access::READ_OK | rustix::fs::Access::WRITE_OK).map_err(|errno| match errno {
        Errno::NOENT => PortError::NotFound(name.to_owned()),
        _ => PortError::PermissionDenied(name.to_owned()),
    })
}

/// An open serial device.
#[derive(Debug)]
pub struct Serial {
    name: String,
    device: OwnedFd,
    baud: Baud,
    delivery: Delivery,
    /// When the octets sent so far have left.
    sending_until: Instant,
    /// On a UART: characters with errors, and the echo of sent octets. `None` on a pty, which has neither.
    uart: Option<(Marks, Echo)>,
    drops: DropCounter,
    notices: Notices,
    /// The other programs that were named when the device was opened.
    named: Vec<Notice>,
}

impl Serial {
    /// Opens a device exclusively: raw, eight data bits, even parity, one stop bit.
    ///
    /// # Errors
    /// [`PortError::NotFound`], [`LeftOver`](PortError::LeftOver), [`InUse`](PortError::InUse),
    /// [`PtyLocked`](PortError::PtyLocked), [`PermissionDenied`](PortError::PermissionDenied), [`NotSerial`](PortError::NotSerial),
    /// [`UnsupportedCharacter`](PortError::UnsupportedCharacter) and [`UnsupportedRate`](PortError::UnsupportedRate).
    pub fn open(name: &str, baud: Baud) -> Result<Self, PortError> {
        Self::open_for(name, baud, OFlags::RDWR)
    }

    /// Opens a device as [`open`](Self::open) does, but for reading alone: the operating system refuses every octet that a program
    /// would send.
    ///
    /// # Errors
    /// As [`open`](Self::open).
    pub fn open_to_listen(name: &str, baud: Baud) -> Result<Self, PortError> {
        Self::open_for(name, baud, OFlags::RDONLY)
    }

    fn open_for(name: &str, baud: Baud, access: OFlags) -> Result<Self, PortError> {
        let opening = |errno| PortError::opening(name, errno);
        // Before anything is set: the terminal of another program would lose its settings and its lock.
        if pty::leads_to_another_program(Path::new(name)) {
            return Err(PortError::LeftOver(name.to_owned()));
        }
        let flags = access | OFlags::NOCTTY | OFlags::NONBLOCK | OFlags::CLOEXEC;
        let device = rustix::fs::open(name, flags, Mode::empty()).map_err(|errno| match errno {
            Errno::BUSY if system::is_pty(name) => PortError::PtyLocked(name.to_owned()),
            _ => opening(errno),
        })?;
        let settings = tcgetattr(&device).map_err(opening)?;
        flock(&device, FlockOperation::NonBlockingLockExclusive).map_err(opening)?;
        let is_pty = system::is_pty(name);
        let (mut notices, mut named) = (Notices::default(), Vec::new());
        if is_pty {
            set(&device, to_8e1(settings), baud).map_err(opening)?;
        } else {
            // Before the lock: it may start a program that opens the device.
            notices.extend(system::set_up(&device, name));
            // A lock that programs without flock respect too. On a pty it would outlive this process.
            ioctl_tiocexcl(&device).map_err(opening)?;
            set(&device, with_error_marks(to_8e1(settings)), baud).map_err(opening)?;
            verify(&tcgetattr(&device).map_err(opening)?, name, baud)?;
            named = system::open_elsewhere(name);
            notices.extend(named.iter().cloned());
        }
        tcflush(&device, QueueSelector::IOFlush).map_err(opening)?;
        let uart = (!is_pty).then(|| (Marks::default(), Echo::default()));
        let delivery = if is_pty { Delivery::Unpaced } else { system::delivery(name) };
        Ok(Self {
            name: name.to_owned(),
            device,
            baud,
            delivery,
            sending_until: Instant::now(),
            uart,
            drops: DropCounter::default(),
            notices,
            named,
        })
    }
}

impl Drop for Serial {
    /// Closes the device without waiting for hardware that takes no data.
    ///
    /// The kernel waits up to 30 s for such octets when a device is closed, also when a process ends. So the sent octets get
    /// the time that they need on the line, the rest is discarded, and a thread closes the device: a process that ends does
    /// not wait for its threads.
    fn drop(&mut self) {
        if self.uart.is_none() {
            return;
        }
        std::thread::sleep(self.sending_until.saturating_duration_since(Instant::now()).min(MAX_SENDING_TIME));
        tcflush(&self.device, QueueSelector::OFlush).ok();
        let Ok(last) = self.device.try_clone() else { return };
        // This descriptor is closed when `self` is; the clone keeps the device open until then.
        if let Ok(null) = rustix::fs::open("/dev/null", OFlags::RDONLY | OFlags::CLOEXEC, Mode::empty()) {
            self.device = null;
            close_in_thread(last);
        }
    }
}

/// Closes a device in a thread, and returns when it is closed or the kernel waits for its hardware.
///
/// A process that ended before the thread has called the kernel would close the device itself, and wait. A descriptor leaves the list of
/// the process when the kernel begins to close it.
fn close_in_thread(last: OwnedFd) {
    let entry = format!("/proc/self/fd/{}", last.as_raw_fd());
    let device = std::fs::read_link(&entry).ok();
    let (closed_here, closed) = channel::<()>();
    let close = move || {
        drop(last);
        drop(closed_here);
    };
    if std::thread::Builder::new().name("close a port".to_owned()).spawn(close).is_err() {
        return;
    }
    let deadline = Instant::now() + THREAD_START_TIME;
    let is_open = || device.is_some() && std::fs::read_link(&entry).ok() == device;
    while is_open() && Instant::now() < deadline {
        if closed.recv_timeout(Duration::from_millis(1)) == Err(RecvTimeoutError::Disconnected) {
            return;
        }
    }
    closed.recv_timeout(CLOSING_TIME).ok();
}

/// Raw, eight data bits, even parity, one stop bit, no handshake.
fn to_8e1(mut settings: Termios) -> Termios {
    settings.make_raw();
    settings.control_modes -= ControlModes::CSIZE | ControlModes::PARODD | ControlModes::CSTOPB | ControlModes::CRTSCTS;
    #[cfg(target_os = "linux")]
    {
        // Mark parity would make the parity bit constant.
        settings.control_modes -= ControlModes::CMSPAR;
    }
    settings.control_modes |= ControlModes::CS8 | ControlModes::PARENB | ControlModes::CREAD | ControlModes::CLOCAL;
    settings
}

/// Marks characters with errors. Not on a pty: its settings outlive this process, and the next program may not expect
/// marks.
fn with_error_marks(mut settings: Termios) -> Termios {
    settings.input_modes |= InputModes::INPCK | InputModes::PARMRK;
    settings.input_modes -= InputModes::IGNPAR | InputModes::IGNBRK;
    settings
}

fn set(device: &OwnedFd, mut settings: Termios, baud: Baud) -> Result<(), Errno> {
    settings.set_speed(baud.bits_per_second())?;
    tcsetattr(device, OptionalActions::Now, &settings)
}

/// Verifies the settings that the driver has taken.
fn verify(taken: &Termios, name: &str, baud: Baud) -> Result<(), PortError> {
    // First the rate that the driver does not report: an impossible one leaves the previous rate set.
    let real = system::real_rate(name, baud.bits_per_second());
    let rates = [real, Some(taken.output_speed()), Some(taken.input_speed())];
    settings::verify(name, baud, character_format(taken.control_modes), rates)
}

/// Data bits, parity and stop bits of a driver.
fn character_format(modes: ControlModes) -> CharacterFormat {
    let data_bits = match modes & ControlModes::CSIZE {
        size if size == ControlModes::CS8 => 8,
        size if size == ControlModes::CS7 => 7,
        size if size == ControlModes::CS6 => 6,
        _ => 5,
    };
    let parity = match (modes.contains(ControlModes::PARENB), modes.contains(ControlModes::PARODD)) {
        (false, _) => Parity::None,
        (true, false) => Parity::Even,
        (true, true) => Parity::Odd,
    };
    let stop_bits = if modes.contains(ControlModes::CSTOPB) { 2 } else { 1 };
    CharacterFormat { data_bits, parity, stop_bits }
}

impl Port for Serial {
    fn name(&self) -> &str {
        &self.name
    }

    fn delivery(&self) -> Delivery {
        self.delivery
    }

    fn readiness(&self) -> Vec<Readiness<'_>> {
        vec![Readiness::of(&self.device)]
    }

    fn receive(&mut self, characters: &mut Vec<Character>) -> Result<(), PortError> {
        let mut buffer = [0; CHUNK];
        match rustix::io::read(&self.device, &mut buffer) {
            Ok(0) => Err(PortError::Lost(self.name.clone())),
            Ok(length) => {
                let octets = buffer.iter().take(length);
                match &mut self.uart {
                    None => characters.extend(octets.map(|octet| Character::Octet(*octet))),
                    Some((marks, echo)) => octets
                        .filter_map(|octet| marks.take(*octet))
                        .for_each(|character| echo.filter(character, characters)),
                }
                Ok(())
            }
            Err(Errno::WOULDBLOCK | Errno::INTR) => Ok(()),
            Err(errno) => Err(PortError::using(&self.name, errno)),
        }
    }

    fn send(&mut self, octets: &[u8]) -> Result<(), PortError> {
        let taken = match rustix::io::write(&self.device, octets) {
            Ok(taken) => taken,
            Err(Errno::WOULDBLOCK | Errno::INTR) => 0,
            Err(errno) => return Err(PortError::using(&self.name, errno)),
        };
        if let Some((_, echo)) = &mut self.uart {
            echo.sent(octets.get(..taken).unwrap_or_default());
            let duration = duration_of(self.baud, CHARACTER_TBIT.saturating_mul(taken as u64));
            self.sending_until = self.sending_until.max(Instant::now()) + duration;
        }
        self.notices.extend(self.drops.sent(&self.name, octets.len(), taken));
        Ok(())
    }

    fn set_baud(&mut self, baud: Baud) -> Result<(), PortError> {
        let Some(uart) = &mut self.uart else { return Err(PortError::NoBaudRate(self.name.clone())) };
        let using = |errno| PortError::using(&self.name, errno);
        let device = &self.device;
        let settings = tcgetattr(device).map_err(using)?;
        match set(device, settings, baud) {
            Err(Errno::INVAL) => {
                return Err(PortError::UnsupportedRate { name: self.name.clone(), baud, offered: None });
            }
            done => done.map_err(using)?,
        }
        verify(&tcgetattr(device).map_err(using)?, &self.name, baud)?;
        // Octets received at the old rate are meaningless at the new one.
        tcflush(device, QueueSelector::IOFlush).map_err(using)?;
        self.baud = baud;
        *uart = Default::default();
        Ok(())
    }

    fn next_notice(&mut self) -> Option<Notice> {
        self.notices.next()
    }

    /// A program that serves a pty may have its slave side open, so only real devices are searched.
    fn reader_search(&self) -> Option<ReaderSearch> {
        let (name, named) = self.uart.as_ref().map(|_| (self.name.clone(), self.named.clone()))?;
        let is_new = move |notice: &Notice| !named.contains(notice);
        Some(Box::new(move || system::open_elsewhere(&name).into_iter().filter(is_new).collect()))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const MODES: ControlModes = ControlModes::CS8.union(ControlModes::PARENB);

    /// The settings of a terminal as a driver would report them.
    fn settings(modes: ControlModes, speed: u32) -> Termios {
        let terminal = rustix::pty::openpt(rustix::pty::OpenptFlags::RDWR | rustix::pty::OpenptFlags::NOCTTY).unwrap();
        let mut settings = tcgetattr(terminal).unwrap();
        settings.control_modes = modes;
        settings.set_speed(speed).unwrap();
        settings
    }

    /// The operating system refuses each octet, so the line gets none.
    #[test]
    fn a_device_that_is_opened_to_listen_receives_and_cannot_send() {
        let folder = tempfile::tempdir().unwrap();
        let name = folder.path().join("line").display().to_string();
        let mut line = crate::port::Pty::create(std::path::Path::new(&name)).unwrap();
        let mut port = Serial::open_to_listen(&name, Baud::B19200).unwrap();
        assert!(rustix::io::write(&port.device, &[0xE5]).is_err_and(|error| error == Errno::BADF));
        port.send(&[0xE5]).ok();
        line.send(&[0x10, 0x16]).unwrap();
        let (mut heard, mut leaked) = (Vec::new(), Vec::new());
        while heard.len() < 2 {
            crate::readiness::wait(&port.readiness(), Duration::from_secs(60)).unwrap();
            port.receive(&mut heard).unwrap();
        }
        line.receive(&mut leaked).unwrap();
        assert_eq!((heard, leaked), (vec![Character::Octet(0x10), Character::Octet(0x16)], vec![]));
    }

    #[test]
    fn settings_other_than_8e1_are_an_error_that_names_them() {
        for (modes, offered) in [
            (ControlModes::CS8, "8N1"),
            (MODES | ControlModes::PARODD, "8O1"),
            (MODES | ControlModes::CSTOPB, "8E2"),
            (ControlModes::CS7 | ControlModes::PARENB, "7E1"),
        ] {
            let refused = verify(&settings(modes, 19_200), "port", Baud::B19200).unwrap_err().to_string();
            assert!(refused.ends_with(&format!("(8E1): the driver set {offered} instead")), "{refused}");
        }
        assert!(verify(&settings(MODES, 19_200), "port", Baud::B19200).is_ok());
    }

    #[test]
    fn a_rate_may_be_off_by_two_percent() {
        for (speed, accepted) in [(93_750, true), (95_500, true), (92_000, true), (115_200, false), (57_600, false)] {
            assert_eq!(verify(&settings(MODES, speed), "port", Baud::B93750).is_ok(), accepted, "{speed}");
        }
        let refused = verify(&settings(MODES, 115_200), "port", Baud::B93750).unwrap_err().to_string();
        assert_eq!(
            refused,
            "port cannot run at 93.75 kbit/s, it would run at 115200 bit/s: use another adapter or another rate"
        );
    }

    #[test]
    fn any_settings_of_a_device_become_8e1() {
        let wild = ControlModes::CS6 | ControlModes::PARODD | ControlModes::CSTOPB | ControlModes::CRTSCTS;
        let made = to_8e1(settings(wild, 300)).control_modes;
        assert_eq!(character_format(made), CharacterFormat::PROFIBUS);
        assert!(made.contains(ControlModes::CLOCAL) && !made.contains(ControlModes::CRTSCTS));
    }

    /// A pty drops the parity, as a driver without parity does.
    #[test]
    fn a_driver_without_parity_is_an_error() {
        let terminal = rustix::pty::openpt(rustix::pty::OpenptFlags::RDWR | rustix::pty::OpenptFlags::NOCTTY).unwrap();
        set(&terminal, to_8e1(tcgetattr(&terminal).unwrap()), Baud::B19200).unwrap();
        let refused = verify(&tcgetattr(&terminal).unwrap(), "port", Baud::B19200);
        assert!(matches!(refused, Err(PortError::UnsupportedCharacter { .. })), "{refused:?}");
    }
}
