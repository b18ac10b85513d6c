//! A pty that profivac serves: its path is a link to the slave side, which a master opens as its serial port.
//!
//! A program may open and close the slave side any number of times. While no program has it open nothing is sent, and
//! unread octets are discarded, so no program reads an answer to the request of another. The kernel reports a hang-up while
//! the slave side is closed, and inotify reports its opening.
//!
//! A process that is killed leaves its link. It dangles, or leads to a later pty that got the same number; both are replaced.

use super::notice::{DropCounter, Notice, Notices};
use super::system::{LinkClaim, OpenEvents, is_pty};
use super::{CHUNK, Character, Port, PortError};
use crate::readiness::Readiness;
use rustix::event::{PollFd, PollFlags, Timespec, poll};
use rustix::fd::OwnedFd;
use rustix::fs::{Mode, OFlags};
use rustix::io::Errno;
use rustix::pty::{OpenptFlags, grantpt, openpt, ptsname, unlockpt};
use rustix::termios::{OptionalActions, QueueSelector, Termios, tcflush, tcgetattr, tcsetattr};
use std::ffi::OsString;
use std::fs;
use std::io;
use std::os::unix::ffi::OsStringExt;
use std::os::unix::fs::{MetadataExt as _, symlink};
use std::path::{Path, PathBuf};

/// socat sets owner and mode of its pty after it has made the link: such a change counts only this long after the link, in s. free choice.
const SETTLING_S: f64 = 10.0;

/// The master side of a pty, and the link to the slave side.
#[derive(Debug)]
pub struct Pty {
    name: String,
    link: PathBuf,
    /// Tells other processes that the link is in use.
    _claim: LinkClaim,
    slave_path: PathBuf,
    master: OwnedFd,
    /// Reports every opening of the slave side.
    open_events: OpenEvents,
    /// A program has the slave side open.
    is_open: bool,
    drops: DropCounter,
    notices: Notices,
}

impl Pty {
    /// Makes a pty and links `path` to its slave side. Replaces a link that a killed process has left.
    ///
    /// # Errors
    /// [`PortError::AlreadyExists`] when `path` is another file or a link in use, [`PortError::NotCreatable`] when no link
    /// can be created there.
    pub fn create(path: &Path) -> Result<Self, PortError> {
        let name = path.display().to_string();
        let opening = |errno| PortError::opening(&name, errno);
        let claim = LinkClaim::of(path).map_err(|error| link_error(&name, error))?;
        // Must come first: the new pty may get the number that a left-over link leads to.
        remove_left_over(path).map_err(|error| link_error(&name, error))?;
        let master = open_master().map_err(opening)?;
        rustix::io::ioctl_fionbio(&master, true).map_err(opening)?;
        grantpt(&master).map_err(opening)?;
        unlockpt(&master).map_err(opening)?;
        let side = PathBuf::from(OsString::from_vec(ptsname(&master, Vec::new()).map_err(opening)?.into_bytes()));
        reset(&side).map_err(opening)?;
        let open_events = OpenEvents::watch(&side).map_err(opening)?;
        symlink(&side, path).map_err(|error| link_error(&name, error))?;
        Ok(Self {
            name,
            link: path.to_owned(),
            _claim: claim,
            slave_path: side,
            master,
            open_events,
            is_open: false,
            drops: DropCounter::default(),
            notices: Notices::default(),
        })
    }

    /// Updates whether the slave side is open, and discards unread octets when it was closed.
    fn update_open(&mut self) -> Result<(), Errno> {
        let mut events = [PollFd::new(&self.master, PollFlags::IN)];
        poll(&mut events, Some(&Timespec::default()))?;
        let flags = events.first().map_or(PollFlags::empty(), PollFd::revents);
        // Octets that were written before the slave side was closed must still be read.
        let is_open = flags.contains(PollFlags::IN) || !flags.contains(PollFlags::HUP);
        if self.is_open && !is_open {
            reset(&self.slave_path)?;
        }
        self.is_open = is_open;
        Ok(())
    }
}

impl Port for Pty {
    fn name(&self) -> &str {
        &self.name
    }

    /// The hang-up of a closed slave side stays readable for ever, so the master side counts only while the slave side is
    /// open.
    fn readiness(&self) -> Vec<Readiness<'_>> {
        let master = self.is_open.then(|| Readiness::of(&self.master));
        [self.open_events.readiness(), master].into_iter().flatten().collect()
    }

    fn receive(&mut self, characters: &mut Vec<Character>) -> Result<(), PortError> {
        let mut buffer = [0; CHUNK];
        self.open_events.drain();
        self.update_open().map_err(|errno| PortError::using(&self.name, errno))?;
        match rustix::io::read(&self.master, &mut buffer) {
            Ok(length) => characters.extend(buffer.iter().take(length).map(|octet| Character::Octet(*octet))),
            // No data, or the slave side is closed.
            Err(Errno::WOULDBLOCK | Errno::INTR | Errno::IO) => {}
            Err(errno) => return Err(PortError::using(&self.name, errno)),
        }
        Ok(())
    }

    fn send(&mut self, octets: &[u8]) -> Result<(), PortError> {
        if !self.is_open {
            // A program may have opened it since the last check.
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
            // A link that cannot be removed stays.
            fs::remove_file(&self.link).ok();
        }
    }
}

/// Opens a new pty that no child process inherits.
fn open_master() -> Result<OwnedFd, Errno> {
    let flags = OpenptFlags::RDWR | OpenptFlags::NOCTTY;
    #[cfg(target_os = "linux")]
    {
        openpt(flags | OpenptFlags::CLOEXEC)
    }
    // Not every system has the flag; without it, it is set afterwards.
    #[cfg(not(target_os = "linux"))]
    {
        let master = openpt(flags)?;
        rustix::io::fcntl_setfd(&master, rustix::io::FdFlags::CLOEXEC)?;
        Ok(master)
    }
}

/// Makes the slave side raw and discards its unread octets.
///
/// Settings that are raw already stay untouched: the next program may be changing them at this moment, and the C library
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

/// Removes a link that a killed process has left.
fn remove_left_over(path: &Path) -> io::Result<()> {
    if is_left_over(path) { fs::remove_file(path) } else { Ok(()) }
}

/// Whether a link dangles, or leads to a pty that is younger than the link: a process makes its pty before the link.
fn is_left_over(path: &Path) -> bool {
    path.is_symlink() && (!path.exists() || seconds_behind(path).is_some_and(|seconds| seconds > 0.0))
}

/// Whether a link leads to a pty that another program has made since the one that made the link was killed.
pub(super) fn leads_to_another_program(path: &Path) -> bool {
    seconds_behind(path).is_some_and(|seconds| seconds > SETTLING_S) && !LinkClaim::is_held(path)
}

/// The time in s from the making of a link to the last change of owner or mode of the pty it leads to, which is its making unless a user
/// changed them later. `None` for anything else, as a link below `/dev/serial` to a serial device.
fn seconds_behind(path: &Path) -> Option<f64> {
    let link = fs::symlink_metadata(path).ok().filter(|_| path.is_symlink() && is_pty(path))?;
    let target = fs::metadata(path).ok()?;
    let seconds = target.ctime().saturating_sub(link.mtime());
    let nanoseconds = target.ctime_nsec().saturating_sub(link.mtime_nsec());
    Some(seconds as f64 + nanoseconds as f64 / 1e9)
}

fn link_error(name: &str, error: io::Error) -> PortError {
    match Errno::from_io_error(&error) {
        Some(Errno::EXIST) => PortError::AlreadyExists(name.to_owned()),
        _ => PortError::NotCreatable { path: name.to_owned(), source: error },
    }
}

#[cfg(test)]
mod tests {
    use super::super::Serial;
    use super::*;
    use profivac_dp::link::Baud;
    use rustix::fs::{AtFlags, CWD, Timestamps, utimensat};
    use std::os::unix::fs::PermissionsExt;

    const AN_HOUR_S: i64 = 3600;

    /// Makes a link to `target` that is an hour older than now.
    fn old_link(target: &Path, path: &Path) {
        symlink(target, path).unwrap();
        let made = fs::symlink_metadata(path).unwrap().mtime();
        let time = Timespec { tv_sec: made - AN_HOUR_S, tv_nsec: 0 };
        let times = Timestamps { last_access: time, last_modification: time };
        utimensat(CWD, path, &times, AtFlags::SYMLINK_NOFOLLOW).unwrap();
    }

    /// A pty of another program.
    fn stranger() -> (OwnedFd, PathBuf) {
        let master = open_master().unwrap();
        unlockpt(&master).unwrap();
        let side = PathBuf::from(OsString::from_vec(ptsname(&master, Vec::new()).unwrap().into_bytes()));
        (master, side)
    }

    #[test]
    fn a_left_over_link_to_a_number_that_another_pty_got_is_replaced() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("line");
        let (_master, side) = stranger();
        old_link(&side, &path);
        let ours = Pty::create(&path).unwrap();
        assert_eq!(fs::read_link(&path).unwrap(), ours.slave_path);
        assert_ne!(ours.slave_path, side);
    }

    #[test]
    fn a_left_over_link_to_the_pty_of_another_program_is_not_opened() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("line");
        let (_master, side) = stranger();
        old_link(&side, &path);
        let opened = Serial::open(path.to_str().unwrap(), Baud::B19200);
        assert!(matches!(opened, Err(PortError::LeftOver(_))), "{opened:?}");
        fs::remove_file(&path).unwrap();
        symlink(&side, &path).unwrap();
        assert!(Serial::open(path.to_str().unwrap(), Baud::B19200).is_ok(), "a link that is younger than its pty");
    }

    /// As socat does with the options `mode` and `user`.
    #[test]
    fn a_link_whose_pty_gets_its_mode_after_it_is_opened() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("line");
        let (_master, side) = stranger();
        symlink(&side, &path).unwrap();
        while seconds_behind(&path).unwrap() <= 0.0 {
            fs::set_permissions(&side, PermissionsExt::from_mode(0o600)).unwrap();
        }
        assert!(Serial::open(path.to_str().unwrap(), Baud::B19200).is_ok());
    }

    #[test]
    fn a_link_in_use_is_opened_also_when_its_pty_got_another_owner_later() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("line");
        let ours = Pty::create(&path).unwrap();
        fs::remove_file(&path).unwrap();
        old_link(&ours.slave_path, &path);
        assert!(Serial::open(path.to_str().unwrap(), Baud::B19200).is_ok());
    }

    #[test]
    fn the_link_of_another_program_to_its_pty_stays() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("line");
        let (_master, side) = stranger();
        symlink(&side, &path).unwrap();
        assert!(matches!(Pty::create(&path), Err(PortError::AlreadyExists(_))));
        assert_eq!(fs::read_link(&path).unwrap(), side);
    }

    #[test]
    fn a_link_in_use_stays_also_when_its_pty_got_another_owner_later() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("line");
        let first = Pty::create(&path).unwrap();
        fs::remove_file(&path).unwrap();
        old_link(&first.slave_path, &path);
        // Another way to the same folder.
        let again = folder.path().join("../").join(folder.path().file_name().unwrap()).join("line");
        assert!(matches!(Pty::create(&again), Err(PortError::AlreadyExists(_))));
        assert_eq!(fs::read_link(&path).unwrap(), first.slave_path);
        drop(first);
        assert!(Pty::create(&path).is_ok());
    }
}
