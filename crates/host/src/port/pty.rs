//! A pty that profivac serves: its path is a link to what a master opens as its serial port.
//!
//! The other side may be closed and opened again as often as it likes. While nobody has it open nothing is sent, and what
//! the last one left unread is thrown away, so nobody ever reads an answer to somebody else's request. The kernel knows
//! whether anybody is there (the pty reports a hang-up if not) and tells when somebody comes.

use super::notice::{DropCounter, Notice, Notices};
use super::system::OpenEvents;
use super::{CHUNK, Character, Port, PortError};
use rustix::event::{PollFd, PollFlags, Timespec, poll};
use rustix::fd::{AsFd, BorrowedFd, OwnedFd};
use rustix::fs::{Mode, OFlags};
use rustix::io::Errno;
use rustix::pty::{OpenptFlags, grantpt, openpt, ptsname, unlockpt};
use rustix::termios::{OptionalActions, QueueSelector, Termios, tcflush, tcgetattr, tcsetattr};
use std::ffi::OsString;
use std::fs;
use std::io;
use std::os::unix::ffi::OsStringExt;
use std::os::unix::fs::symlink;
use std::path::{Path, PathBuf};

/// Our side of a pty, and the link to the other side.
#[derive(Debug)]
pub struct Pty {
    name: String,
    link: PathBuf,
    slave_path: PathBuf,
    master: OwnedFd,
    /// Reports every opening of the other side.
    open_events: OpenEvents,
    /// Somebody has the other side open.
    is_open: bool,
    drops: DropCounter,
    notices: Notices,
}

impl Pty {
    /// Makes a pty and links `path` to it. A link that leads nowhere is replaced.
    ///
    /// # Errors
    /// [`PortError::Exists`] when there is something else at `path`, [`PortError::Missing`] when its folder does not exist.
    pub fn create(path: &Path) -> Result<Self, PortError> {
        let name = path.display().to_string();
        let opening = |errno| PortError::opening(&name, errno);
        // First of all: the new pty may get the number of the one that a left over link leads to.
        remove_dangling(path).map_err(|error| link_error(&name, error))?;
        let ours = openpt(OpenptFlags::RDWR | OpenptFlags::NOCTTY | OpenptFlags::CLOEXEC).map_err(opening)?;
        rustix::io::ioctl_fionbio(&ours, true).map_err(opening)?;
        grantpt(&ours).map_err(opening)?;
        unlockpt(&ours).map_err(opening)?;
        let side = PathBuf::from(OsString::from_vec(ptsname(&ours, Vec::new()).map_err(opening)?.into_bytes()));
        reset(&side).map_err(opening)?;
        let openings = OpenEvents::watch(&side).map_err(opening)?;
        symlink(&side, path).map_err(|error| link_error(&name, error))?;
        Ok(Self {
            name,
            link: path.to_owned(),
            slave_path: side,
            master: ours,
            open_events: openings,
            is_open: false,
            drops: DropCounter::default(),
            notices: Notices::default(),
        })
    }

    /// Looks whether somebody has the other side open, and clears up after the last one.
    fn update_open(&mut self) -> Result<(), Errno> {
        let mut events = [PollFd::new(&self.master, PollFlags::IN)];
        poll(&mut events, Some(&Timespec::default()))?;
        let seen = events.first().map_or(PollFlags::empty(), PollFd::revents);
        // What was written before the other side was closed is still to be read.
        let present = seen.contains(PollFlags::IN) || !seen.contains(PollFlags::HUP);
        if self.is_open && !present {
            reset(&self.slave_path)?;
        }
        self.is_open = present;
        Ok(())
    }
}

impl Port for Pty {
    fn name(&self) -> &str {
        &self.name
    }

    /// A hang-up is reported without end, so our side is only watched while somebody is there.
    fn watched(&self) -> Vec<BorrowedFd<'_>> {
        let ours = self.is_open.then(|| self.master.as_fd());
        [self.open_events.watched(), ours].into_iter().flatten().collect()
    }

    fn receive(&mut self, heard: &mut Vec<Character>) -> Result<(), PortError> {
        let mut buffer = [0; CHUNK];
        self.open_events.drain();
        self.update_open().map_err(|errno| PortError::using(&self.name, errno))?;
        match rustix::io::read(&self.master, &mut buffer) {
            Ok(length) => heard.extend(buffer.iter().take(length).map(|octet| Character::Octet(*octet))),
            // Nothing there, or nobody.
            Err(Errno::WOULDBLOCK | Errno::INTR | Errno::IO) => {}
            Err(errno) => return Err(PortError::using(&self.name, errno)),
        }
        Ok(())
    }

    fn send(&mut self, octets: &[u8]) -> Result<(), PortError> {
        if !self.is_open {
            // Somebody may have come since we looked last.
            self.update_open().map_err(|errno| PortError::using(&self.name, errno))?;
        }
        if !self.is_open {
            return Ok(());
        }
        let taken = match rustix::io::write(&self.master, octets) {
            Ok(taken) => taken,
            Err(Errno::WOULDBLOCK | Errno::INTR | Errno::IO) => 0,
            Err(errno) => return Err(PortError::using(&self.name, errno)),
        };
        self.notices.extend(self.drops.sent(&self.name, octets.len(), taken));
        Ok(())
    }

    fn next_notice(&mut self) -> Option<Notice> {
        self.notices.next()
    }
}

impl Drop for Pty {
    fn drop(&mut self) {
        if fs::read_link(&self.link).is_ok_and(|side| side == self.slave_path) {
            // Nothing can be done about a link that cannot be removed.
            fs::remove_file(&self.link).ok();
        }
    }
}

/// Makes the other side raw and forgets what was not read there.
///
/// Settings that are raw already are left alone: the next program may be at its own at this very moment, and the C library
/// reports an error to a program whose settings did not hold.
fn reset(side: &Path) -> Result<(), Errno> {
    let other = rustix::fs::open(side, OFlags::RDWR | OFlags::NOCTTY | OFlags::CLOEXEC, Mode::empty())?;
    let settings = tcgetattr(&other)?;
    let mut raw = settings.clone();
    raw.make_raw();
    let modes = |settings: &Termios| (settings.input_modes, settings.output_modes, settings.local_modes);
    if modes(&settings) != modes(&raw) {
        tcsetattr(&other, OptionalActions::Now, &raw)?;
    }
    tcflush(&other, QueueSelector::IOFlush)
}

/// Removes a link that leads nowhere: whoever made it was killed.
fn remove_dangling(path: &Path) -> io::Result<()> {
    if path.is_symlink() && !path.exists() { fs::remove_file(path) } else { Ok(()) }
}

fn link_error(name: &str, error: io::Error) -> PortError {
    match Errno::from_io_error(&error) {
        Some(Errno::EXIST) => PortError::AlreadyExists(name.to_owned()),
        Some(errno) => PortError::opening(name, errno),
        None => PortError::system(name, error),
    }
}
