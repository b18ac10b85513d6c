//! A serial device at 8E1, or a pty that somebody else serves.
//!
//! Ptys keep no parity and send at no rate, and neither is a reason to refuse them.

use super::echo::Echo;
use super::marks::Marks;
use super::{CHUNK, Character, Port, PortError};
use profivac_dp::link::Baud;
use rustix::fd::{AsFd, BorrowedFd, OwnedFd};
use rustix::fs::{FlockOperation, Mode, OFlags, flock};
use rustix::io::Errno;
use rustix::termios::{
    ControlModes, InputModes, OptionalActions, QueueSelector, Termios, ioctl_tiocexcl, tcflush, tcgetattr, tcsetattr,
};
use std::fs;

/// The line tolerates a rate that is off by one part in so many: a character of 11 bits is then still read right.
const RATE_TOLERANCE: u32 = 50;

/// An open serial device.
#[derive(Debug)]
pub struct Serial {
    name: String,
    device: OwnedFd,
    /// What a line of copper needs and a pty does not have: errors in characters, and our own octets coming back.
    copper: Option<(Marks, Echo)>,
}

impl Serial {
    /// Opens a device for ourselves alone, raw, with eight data bits, even parity and one stop bit.
    ///
    /// # Errors
    /// [`PortError::Missing`], [`InUse`](PortError::InUse), [`Denied`](PortError::Denied),
    /// [`NotSerial`](PortError::NotSerial) and [`Rate`](PortError::Rate) say what is in the way.
    pub fn open(name: &str, baud: Baud) -> Result<Self, PortError> {
        let opening = |errno| PortError::opening(name, errno);
        let flags = OFlags::RDWR | OFlags::NOCTTY | OFlags::NONBLOCK | OFlags::CLOEXEC;
        let device = rustix::fs::open(name, flags, Mode::empty()).map_err(opening)?;
        let mut settings = tcgetattr(&device).map_err(opening)?;
        flock(&device, FlockOperation::NonBlockingLockExclusive).map_err(opening)?;
        let is_pty = fs::canonicalize(name).is_ok_and(|device| device.starts_with("/dev/pts"));
        if !is_pty {
            // A lock that programs without flock respect too. On a pty it would outlive us.
            ioctl_tiocexcl(&device).map_err(opening)?;
        }
        make_8e1(&mut settings);
        if !is_pty {
            // The settings of a pty outlive us as well, and whoever opens it next may not expect marks.
            settings.input_modes |= InputModes::INPCK | InputModes::PARMRK;
            settings.input_modes -= InputModes::IGNPAR | InputModes::IGNBRK;
        }
        settings.set_speed(baud.bits_per_second()).map_err(opening)?;
        tcsetattr(&device, OptionalActions::Now, &settings).map_err(opening)?;
        if !is_pty {
            check_rate(&device, name, baud)?;
        }
        tcflush(&device, QueueSelector::IOFlush).map_err(opening)?;
        let copper = (!is_pty).then(|| (Marks::default(), Echo::default()));
        Ok(Self { name: name.to_owned(), device, copper })
    }
}

/// Raw, eight data bits, even parity, one stop bit, no handshake.
fn make_8e1(settings: &mut Termios) {
    settings.make_raw();
    settings.control_modes |= ControlModes::CS8 | ControlModes::PARENB | ControlModes::CREAD | ControlModes::CLOCAL;
    settings.control_modes -= ControlModes::PARODD | ControlModes::CSTOPB | ControlModes::CRTSCTS;
}

/// Drivers take the nearest rate they have without a word.
fn check_rate(device: &OwnedFd, name: &str, baud: Baud) -> Result<(), PortError> {
    let offered = tcgetattr(device).map_err(|errno| PortError::opening(name, errno))?.output_speed();
    let wanted = baud.bits_per_second();
    if offered.abs_diff(wanted) > wanted / RATE_TOLERANCE {
        return Err(PortError::Rate { name: name.to_owned(), baud, offered });
    }
    Ok(())
}

impl Port for Serial {
    fn name(&self) -> &str {
        &self.name
    }

    fn is_timed(&self) -> bool {
        self.copper.is_some()
    }

    fn watched(&self) -> Vec<BorrowedFd<'_>> {
        vec![self.device.as_fd()]
    }

    fn receive(&mut self, heard: &mut Vec<Character>) -> Result<(), PortError> {
        let mut buffer = [0; CHUNK];
        match rustix::io::read(&self.device, &mut buffer) {
            Ok(0) => Err(PortError::Lost(self.name.clone())),
            Ok(length) => {
                let octets = buffer.iter().take(length);
                match &mut self.copper {
                    None => heard.extend(octets.map(|octet| Character::Octet(*octet))),
                    Some((marks, echo)) => octets
                        .filter_map(|octet| marks.take(*octet))
                        .for_each(|character| echo.filter(character, heard)),
                }
                Ok(())
            }
            Err(Errno::WOULDBLOCK | Errno::INTR) => Ok(()),
            Err(errno) => Err(PortError::using(&self.name, errno)),
        }
    }

    fn send(&mut self, octets: &[u8]) -> Result<(), PortError> {
        match rustix::io::write(&self.device, octets) {
            Ok(length) => {
                if let Some((_, echo)) = &mut self.copper {
                    echo.sent(octets.get(..length).unwrap_or_default());
                }
                Ok(())
            }
            Err(Errno::WOULDBLOCK | Errno::INTR) => Ok(()),
            Err(errno) => Err(PortError::using(&self.name, errno)),
        }
    }
}
