//! A pty that profivac serves: its path is a link to the slave side, which a master opens as its serial port.
//!
//! A program may open and close the slave side any number of times. While no program has it open nothing is sent, and
//! unread octets are discarded, so no program reads an answer to the request of another. The kernel reports a hang-up while
//! the slave side is closed, and inotify reports its opening.
//!
//! A program may lock the slave side (TIOCEXCL), as most libraries for serial ports do. The kernel keeps the lock when the program ends
//! without unlocking, and then only a privileged process can open the slave side: a new pty takes its place behind the link. A descriptor
//! that keeps the slave side open could unlock it instead, but then the kernel would report no hang-up.
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
use rustix::termios::{OptionalActions, QueueSelector, Termios, ioctl_tiocnxcl, tcflush, tcgetattr, tcsetattr};
use std::ffi::OsString;
use std::fs;
use std::io;
use std::os::unix::ffi::OsStringExt;
use std::os::unix::fs::{MetadataExt as _, chown, symlink};
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
    sides: Sides,
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
        let sides = Sides::open().map_err(opening)?;
        symlink(&sides.slave_path, path).map_err(|error| link_error(&name, error))?;
        Ok(Self {
            name,
            link: path.to_owned(),
            _claim: claim,
            sides,
            is_open: false,
            drops: DropCounter::default(),
            notices: Notices::default(),
        })
    }

    /// Updates whether a program has the slave side open. Prepares the slave side for the next program when the last one has closed it,
    /// also when it was opened and closed since the last call.
    fn update_open(&mut self) -> Result<(), PortError> {
        let using = |errno| PortError::using(&self.name, errno);
        let was_opened = self.sides.open_events.drain();
        let was_open = self.is_open || was_opened;
        self.is_open = self.sides.is_open().map_err(using)?;
        if was_open && !self.is_open {
            self.prepare()?;
            self.is_open = self.sides.is_open().map_err(|errno| PortError::using(&self.name, errno))?;
        }
        Ok(())
    }

    /// Makes the slave side raw, empty and unlocked, or replaces the pty if a program that has ended has locked it.
    fn prepare(&mut self) -> Result<(), PortError> {
        let using = |errno| PortError::using(&self.name, errno);
        match self.sides.reset() {
            // If the slave side is open, the next program has opened and locked it just now.
            Err(Errno::BUSY) if !self.sides.is_open().map_err(using)? => self.replace(),
            Ok(()) | Err(Errno::BUSY) => Ok(()),
            Err(errno) => Err(using(errno)),
        }
    }

    /// Puts a new pty behind the link, with owner and mode of the present one.
    fn replace(&mut self) -> Result<(), PortError> {
        let sides = Sides::open().map_err(|errno| PortError::using(&self.name, errno))?;
        // A server that may not change them keeps those of a new pty.
        copy_access(&self.sides.slave_path, &sides.slave_path).ok();
        if self.owns_link() {
            let relinked = fs::remove_file(&self.link).and_then(|()| symlink(&sides.slave_path, &self.link));
            relinked.map_err(|error| link_error(&self.name, error))?;
        }
        self.sides = sides;
        Ok(())
    }

    /// Whether the link still leads to this pty.
    fn owns_link(&self) -> bool {
        fs::read_link(&self.link).is_ok_and(|side| side == self.sides.slave_path)
    }
}

/// Both sides of a pty.
#[derive(Debug)]
struct Sides {
    master: OwnedFd,
    slave_path: PathBuf,
    /// Reports every opening of the slave side.
    open_events: OpenEvents,
}

impl Sides {
    /// Makes a pty whose slave side is raw.
    fn open() -> Result<Self, Errno> {
        let master = open_master()?;
        rustix::io::ioctl_fionbio(&master, true)?;
        grantpt(&master)?;
        unlockpt(&master)?;
        let slave_path = PathBuf::from(OsString::from_vec(ptsname(&master, Vec::new())?.into_bytes()));
        let open_events = OpenEvents::watch(&slave_path)?;
        let sides = Self { master, slave_path, open_events };
        sides.reset()?;
        Ok(sides)
    }

    /// Whether a program has the slave side open, or has written octets that wait.
    fn is_open(&self) -> Result<bool, Errno> {
        let mut events = [PollFd::new(&self.master, PollFlags::IN)];
        poll(&mut events, Some(&Timespec::default()))?;
        let flags = events.first().map_or(PollFlags::empty(), PollFd::revents);
        // Octets that were written before the slave side was closed must still be read.
        Ok(flags.contains(PollFlags::IN) || !flags.contains(PollFlags::HUP))
    }

    /// Makes the slave side raw, discards its unread octets and unlocks it.
    ///
    /// Settings that are raw already stay untouched: the next program may be changing them at this moment, and the C library
    /// reports an error to a program whose settings did not hold.
    fn reset(&self) -> Result<(), Errno> {
        let flags = OFlags::RDONLY | OFlags::NOCTTY | OFlags::CLOEXEC;
        let slave = rustix::fs::open(&self.slave_path, flags, Mode::empty())?;
        let settings = tcgetattr(&slave)?;
        let mut raw = settings.clone();
        raw.make_raw();
        let modes = |settings: &Termios| (settings.input_modes, settings.output_modes, settings.local_modes);
        if modes(&settings) != modes(&raw) {
            tcsetattr(&slave, OptionalActions::Now, &raw)?;
        }
        tcflush(&slave, QueueSelector::IOFlush)?;
        // Among the events is the opening above. A program that opens the slave side from here on causes another event; a lock that one
        // has set before is removed, which only a privileged server can meet here.
        self.open_events.drain();
        ioctl_tiocnxcl(&slave)
    }
}

impl Port for Pty {
    fn name(&self) -> &str {
        &self.name
    }

    /// The hang-up of a closed slave side stays readable for ever, so the master side counts only while the slave side is
    /// open.
    fn readiness(&self) -> Vec<Readiness<'_>> {
        let master = self.is_open.then(|| Readiness::of(&self.sides.master));
        [self.sides.open_events.readiness(), master].into_iter().flatten().collect()
    }

    fn receive(&mut self, characters: &mut Vec<Character>) -> Result<(), PortError> {
        let mut buffer = [0; CHUNK];
        self.update_open()?;
        match rustix::io::read(&self.sides.master, &mut buffer) {
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
            self.update_open()?;
        }
        if !self.is_open {
            return Ok(());
        }
        let taken = match rustix::io::write(&self.sides.master, octets) {
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
        if self.owns_link() {
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

/// Gives the device `to` the owner and the mode of `from`.
fn copy_access(from: &Path, to: &Path) -> io::Result<()> {
    let access = fs::metadata(from)?;
    fs::set_permissions(to, access.permissions())?;
    chown(to, Some(access.uid()), Some(access.gid()))
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
    use rustix::io::{read, write};
    use rustix::termios::ioctl_tiocexcl;
    use rustix::thread::{CapabilitySet, capabilities, set_capabilities};
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
        assert_eq!(fs::read_link(&path).unwrap(), ours.sides.slave_path);
        assert_ne!(ours.sides.slave_path, side);
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
        old_link(&ours.sides.slave_path, &path);
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
        old_link(&first.sides.slave_path, &path);
        // Another way to the same folder.
        let again = folder.path().join("../").join(folder.path().file_name().unwrap()).join("line");
        assert!(matches!(Pty::create(&again), Err(PortError::AlreadyExists(_))));
        assert_eq!(fs::read_link(&path).unwrap(), first.sides.slave_path);
        drop(first);
        assert!(Pty::create(&path).is_ok());
    }

    /// Takes CAP_SYS_ADMIN from this thread, if it has it: a privileged process can open a locked terminal.
    fn become_an_ordinary_user() {
        let mut sets = capabilities(None).unwrap();
        sets.effective -= CapabilitySet::SYS_ADMIN;
        set_capabilities(None, sets).unwrap();
    }

    fn open_as_a_program(path: &Path) -> Result<OwnedFd, Errno> {
        rustix::fs::open(path, OFlags::RDWR | OFlags::NOCTTY | OFlags::NONBLOCK | OFlags::CLOEXEC, Mode::empty())
    }

    /// A program opens the pty and locks it, as most libraries for serial ports do.
    fn open_and_lock(path: &Path) -> OwnedFd {
        let program = open_as_a_program(path).unwrap();
        ioctl_tiocexcl(&program).unwrap();
        program
    }

    /// A new program opens the pty, and octets pass both ways.
    fn assert_usable(pty: &mut Pty, path: &Path) {
        let program = open_as_a_program(path).unwrap();
        assert_octets_pass(pty, &program);
    }

    fn assert_octets_pass(pty: &mut Pty, program: &OwnedFd) {
        let mut received = Vec::new();
        write(program, b"ask\n").unwrap();
        pty.receive(&mut received).unwrap();
        assert_eq!(received, b"ask\n".map(Character::Octet));
        pty.send(b"answer\n").unwrap();
        let mut buffer = [0; 16];
        let length = read(program, &mut buffer).unwrap();
        assert_eq!(&buffer[..length], b"answer\n");
    }

    fn pty() -> (tempfile::TempDir, PathBuf, Pty) {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("line");
        let pty = Pty::create(&path).unwrap();
        (folder, path, pty)
    }

    #[test]
    fn a_pty_that_an_ended_program_has_locked_is_opened_by_the_next_one() {
        become_an_ordinary_user();
        let (_folder, path, mut ours) = pty();
        for _ in 0..3 {
            let program = open_and_lock(&path);
            assert_octets_pass(&mut ours, &program);
            ours.send(b"for the program that ends").unwrap();
            drop(program);
            assert_eq!(open_as_a_program(&path).unwrap_err(), Errno::BUSY, "the kernel keeps the lock");
            ours.receive(&mut Vec::new()).unwrap();
            assert_usable(&mut ours, &path);
            ours.receive(&mut Vec::new()).unwrap();
        }
    }

    #[test]
    fn a_pty_that_was_locked_and_closed_between_two_looks_is_opened_by_the_next_program() {
        become_an_ordinary_user();
        let (_folder, path, mut ours) = pty();
        drop(open_and_lock(&path));
        ours.receive(&mut Vec::new()).unwrap();
        assert_usable(&mut ours, &path);
    }

    #[test]
    fn a_server_that_sends_notices_a_lock_that_an_ended_program_has_left() {
        become_an_ordinary_user();
        let (_folder, path, mut ours) = pty();
        drop(open_and_lock(&path));
        ours.send(b"nobody hears this").unwrap();
        assert_usable(&mut ours, &path);
    }

    /// Octets that the ended program has written are received before a new pty takes the place.
    #[test]
    fn the_last_octets_of_a_program_that_has_locked_the_pty_are_received() {
        become_an_ordinary_user();
        let (_folder, path, mut ours) = pty();
        let program = open_and_lock(&path);
        write(&program, b"last").unwrap();
        drop(program);
        let mut received = Vec::new();
        ours.receive(&mut received).unwrap();
        ours.receive(&mut received).unwrap();
        assert_eq!(received, b"last".map(Character::Octet));
        assert_usable(&mut ours, &path);
    }

    #[test]
    fn a_privileged_server_removes_the_lock_for_all_users() {
        let (_folder, path, mut ours) = pty();
        drop(open_and_lock(&path));
        ours.receive(&mut Vec::new()).unwrap();
        become_an_ordinary_user();
        assert_usable(&mut ours, &path);
    }

    /// The server finds the pty closed; the next program opens and locks it before the server can open it.
    #[test]
    fn a_pty_that_the_next_program_has_locked_already_is_not_replaced() {
        become_an_ordinary_user();
        let (_folder, path, mut ours) = pty();
        let program = open_and_lock(&path);
        ours.prepare().unwrap();
        assert_eq!(fs::read_link(&path).unwrap(), ours.sides.slave_path);
        assert_octets_pass(&mut ours, &program);
    }

    #[test]
    fn a_pty_without_a_lock_stays_the_same_and_its_own_openings_are_no_events() {
        become_an_ordinary_user();
        let (_folder, path, mut ours) = pty();
        let before = ours.sides.slave_path.clone();
        for _ in 0..3 {
            assert_usable(&mut ours, &path);
            ours.receive(&mut Vec::new()).unwrap();
            assert!(!ours.is_open);
            let sources = ours.readiness();
            let mut events: Vec<_> = sources.iter().map(|source| PollFd::new(source, PollFlags::IN)).collect();
            assert_eq!(poll(&mut events, Some(&Timespec::default())).unwrap(), 0, "nothing to do");
        }
        assert_eq!(fs::read_link(&path).unwrap(), before);
    }

    #[test]
    fn a_new_pty_has_the_mode_of_the_one_it_replaces() {
        become_an_ordinary_user();
        let (_folder, path, mut ours) = pty();
        fs::set_permissions(&path, PermissionsExt::from_mode(0o666)).unwrap();
        drop(open_and_lock(&path));
        ours.receive(&mut Vec::new()).unwrap();
        assert_eq!(fs::metadata(&path).unwrap().permissions().mode() & 0o777, 0o666);
        assert_usable(&mut ours, &path);
    }

    #[test]
    fn a_link_that_another_program_has_made_in_place_of_ours_stays() {
        become_an_ordinary_user();
        let (_folder, path, mut ours) = pty();
        let (_master, side) = stranger();
        drop(open_and_lock(&path));
        fs::remove_file(&path).unwrap();
        symlink(&side, &path).unwrap();
        ours.receive(&mut Vec::new()).unwrap();
        drop(ours);
        assert_eq!(fs::read_link(&path).unwrap(), side);
    }
}
