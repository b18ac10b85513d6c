//! A serial device at 8E1, or a pty that somebody else serves.
//!
//! Ptys keep no parity and send at no rate, and neither is a reason to refuse them. Of a device of copper it is verified that
//! the driver took what the line needs; what would only make it better is a remark.

use super::echo::Echo;
use super::marks::Marks;
use super::notice::{DropCounter, Notice, Notices};
use super::{CHUNK, Character, Port, PortError, system};
use profivac_dp::link::Baud;
use rustix::fd::{AsFd, BorrowedFd, OwnedFd};
use rustix::fs::{FlockOperation, Mode, OFlags, flock};
use rustix::io::Errno;
use rustix::termios::{
    ControlModes, InputModes, OptionalActions, QueueSelector, Termios, ioctl_tiocexcl, tcflush, tcgetattr, tcsetattr,
};

/// The line tolerates a rate that is off by one part in so many: a character of 11 bits is then still read right.
const RATE_TOLERANCE: u32 = 50;

/// An open serial device.
#[derive(Debug)]
pub struct Serial {
    name: String,
    device: OwnedFd,
    /// What a line of copper needs and a pty does not have: errors in characters, and our own octets coming back.
    uart: Option<(Marks, Echo)>,
    drops: DropCounter,
    notices: Notices,
}

impl Serial {
    /// Opens a device for ourselves alone, raw, with eight data bits, even parity and one stop bit.
    ///
    /// # Errors
    /// [`PortError::Missing`], [`InUse`](PortError::InUse), [`Denied`](PortError::Denied),
    /// [`NotSerial`](PortError::NotSerial), [`Character`](PortError::Character) and [`Rate`](PortError::Rate) say what is in
    /// the way.
    pub fn open(name: &str, baud: Baud) -> Result<Self, PortError> {
        let opening = |errno| PortError::opening(name, errno);
        let flags = OFlags::RDWR | OFlags::NOCTTY | OFlags::NONBLOCK | OFlags::CLOEXEC;
        let device = rustix::fs::open(name, flags, Mode::empty()).map_err(opening)?;
        let settings = tcgetattr(&device).map_err(opening)?;
        flock(&device, FlockOperation::NonBlockingLockExclusive).map_err(opening)?;
        let is_pty = system::is_pty(name);
        let mut remarks = Notices::default();
        if is_pty {
            set(&device, to_8e1(settings), baud).map_err(opening)?;
        } else {
            // A lock that programs without flock respect too. On a pty it would outlive us.
            ioctl_tiocexcl(&device).map_err(opening)?;
            remarks.extend(system::set_up(&device, name));
            set(&device, with_error_marks(to_8e1(settings)), baud).map_err(opening)?;
            verify(&tcgetattr(&device).map_err(opening)?, name, baud)?;
        }
        tcflush(&device, QueueSelector::IOFlush).map_err(opening)?;
        let copper = (!is_pty).then(|| (Marks::default(), Echo::default()));
        Ok(Self { name: name.to_owned(), device, uart: copper, drops: DropCounter::default(), notices: remarks })
    }
}

/// Raw, eight data bits, even parity, one stop bit, no handshake.
fn to_8e1(mut settings: Termios) -> Termios {
    settings.make_raw();
    settings.control_modes -= ControlModes::CSIZE | ControlModes::PARODD | ControlModes::CSTOPB | ControlModes::CRTSCTS;
    #[cfg(target_os = "linux")]
    {
        // With it the parity bit would be a constant.
        settings.control_modes -= ControlModes::CMSPAR;
    }
    settings.control_modes |= ControlModes::CS8 | ControlModes::PARENB | ControlModes::CREAD | ControlModes::CLOCAL;
    settings
}

/// Characters with errors are marked. Not on a pty: its settings outlive us, and whoever opens it next may not expect marks.
fn with_error_marks(mut settings: Termios) -> Termios {
    settings.input_modes |= InputModes::INPCK | InputModes::PARMRK;
    settings.input_modes -= InputModes::IGNPAR | InputModes::IGNBRK;
    settings
}

fn set(device: &OwnedFd, mut settings: Termios, baud: Baud) -> Result<(), Errno> {
    settings.set_speed(baud.bits_per_second())?;
    tcsetattr(device, OptionalActions::Now, &settings)
}

/// Drivers leave out what they cannot and take the nearest rate they have, without a word.
fn verify(taken: &Termios, name: &str, baud: Baud) -> Result<(), PortError> {
    let offered = character(taken.control_modes);
    if offered != "8E1" {
        return Err(PortError::UnsupportedCharacter { name: name.to_owned(), offered });
    }
    let wanted = baud.bits_per_second();
    // What is heard and what is sent.
    for offered in [taken.output_speed(), taken.input_speed()] {
        if offered.abs_diff(wanted) > wanted / RATE_TOLERANCE {
            return Err(PortError::UnsupportedRate { name: name.to_owned(), baud, offered });
        }
    }
    Ok(())
}

/// Data bits, parity and stop bits in the usual three characters.
fn character(modes: ControlModes) -> String {
    let bits = match modes & ControlModes::CSIZE {
        size if size == ControlModes::CS8 => 8,
        size if size == ControlModes::CS7 => 7,
        size if size == ControlModes::CS6 => 6,
        _ => 5,
    };
    let parity = match (modes.contains(ControlModes::PARENB), modes.contains(ControlModes::PARODD)) {
        (false, _) => 'N',
        (true, false) => 'E',
        (true, true) => 'O',
    };
    let stop = if modes.contains(ControlModes::CSTOPB) { 2 } else { 1 };
    format!("{bits}{parity}{stop}")
}

impl Port for Serial {
    fn name(&self) -> &str {
        &self.name
    }

    fn is_timed(&self) -> bool {
        self.uart.is_some()
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
                match &mut self.uart {
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
        let taken = match rustix::io::write(&self.device, octets) {
            Ok(taken) => taken,
            Err(Errno::WOULDBLOCK | Errno::INTR) => 0,
            Err(errno) => return Err(PortError::using(&self.name, errno)),
        };
        if let Some((_, echo)) = &mut self.uart {
            echo.sent(octets.get(..taken).unwrap_or_default());
        }
        self.notices.extend(self.drops.sent(&self.name, octets.len(), taken));
        Ok(())
    }

    fn set_baud(&mut self, baud: Baud) -> Result<(), PortError> {
        let Some(copper) = &mut self.uart else { return Err(PortError::NoBaudRate(self.name.clone())) };
        let using = |errno| PortError::using(&self.name, errno);
        let settings = tcgetattr(&self.device).map_err(using)?;
        let offered = settings.output_speed();
        match set(&self.device, settings, baud) {
            Err(Errno::INVAL) => return Err(PortError::UnsupportedRate { name: self.name.clone(), baud, offered }),
            done => done.map_err(using)?,
        }
        verify(&tcgetattr(&self.device).map_err(using)?, &self.name, baud)?;
        // What came at the old rate means nothing at the new one.
        tcflush(&self.device, QueueSelector::IOFlush).map_err(using)?;
        *copper = Default::default();
        Ok(())
    }

    fn next_notice(&mut self) -> Option<Notice> {
        self.notices.next()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const MODES: ControlModes = ControlModes::CS8.union(ControlModes::PARENB);

    /// Settings of a terminal, whichever, as a driver would report them.
    fn settings(modes: ControlModes, speed: u32) -> Termios {
        let terminal = rustix::pty::openpt(rustix::pty::OpenptFlags::RDWR | rustix::pty::OpenptFlags::NOCTTY).unwrap();
        let mut settings = tcgetattr(terminal).unwrap();
        settings.control_modes = modes;
        settings.set_speed(speed).unwrap();
        settings
    }

    #[test]
    fn what_a_driver_took_is_compared_with_8e1() {
        for (modes, offered) in [
            (ControlModes::CS8, "8N1"),
            (MODES | ControlModes::PARODD, "8O1"),
            (MODES | ControlModes::CSTOPB, "8E2"),
            (ControlModes::CS7 | ControlModes::PARENB, "7E1"),
        ] {
            let refused = verify(&settings(modes, 19_200), "port", Baud::B19200).unwrap_err().to_string();
            assert!(refused.ends_with(&format!("(8E1), it offers {offered}")), "{refused}");
        }
        assert!(verify(&settings(MODES, 19_200), "port", Baud::B19200).is_ok());
    }

    #[test]
    fn a_rate_may_be_off_by_two_percent() {
        for (speed, accepted) in [(93_750, true), (95_500, true), (92_000, true), (115_200, false), (57_600, false)] {
            assert_eq!(verify(&settings(MODES, speed), "port", Baud::B93750).is_ok(), accepted, "{speed}");
        }
        let refused = verify(&settings(MODES, 115_200), "port", Baud::B93750).unwrap_err().to_string();
        assert_eq!(refused, "port cannot run at 93.75 kbit/s, it offers 115200 bit/s");
    }

    #[test]
    fn whatever_a_device_was_set_to_is_made_8e1() {
        let wild = ControlModes::CS6 | ControlModes::PARODD | ControlModes::CSTOPB | ControlModes::CRTSCTS;
        let made = to_8e1(settings(wild, 300)).control_modes;
        assert_eq!(character(made), "8E1");
        assert!(made.contains(ControlModes::CLOCAL) && !made.contains(ControlModes::CRTSCTS));
    }

    /// A pty drops the parity: the driver that does not do what it is told.
    #[test]
    fn a_driver_that_leaves_the_parity_out_is_noticed() {
        let terminal = rustix::pty::openpt(rustix::pty::OpenptFlags::RDWR | rustix::pty::OpenptFlags::NOCTTY).unwrap();
        set(&terminal, to_8e1(tcgetattr(&terminal).unwrap()), Baud::B19200).unwrap();
        let refused = verify(&tcgetattr(&terminal).unwrap(), "port", Baud::B19200);
        assert!(matches!(refused, Err(PortError::UnsupportedCharacter { .. })), "{refused:?}");
    }
}
