//! A pty that profivac serves: its path is a link to the slave side, which a master opens as its serial port.
//!
//! A program may open and close the slave side any number of times. While no program has it open nothing is sent, and the server
//! discards the unread octets when it finds the slave side closed. The kernel reports a hang-up while the slave side is closed, and
//! inotify reports its opening. A program that opens the slave side before the server has looked may still read octets for its
//! predecessor: it discards its input after opening, as libraries for serial ports do. The server cannot do it then: it cannot tell
//! this program from a second one, and through the master side the kernel discards only with new settings for the slave side.
//!
//! A program may lock the slave side (TIOCEXCL), as most libraries for serial ports do. The kernel keeps the lock when the program ends
//! without unlocking, and then only a privileged process can open the slave side: a new pty takes its place behind the link. A descriptor
//! that keeps the slave side open could unlock it instead, but then the kernel would report no hang-up. If the system refuses what the
//! server needs for the next program, the server goes on and tries again at each look.
//!
//! A process that is killed leaves its link. It dangles, or leads to a later pty that got the same number; both are replaced.

use super::notice::{DropCounter, Notice, Notices};
use super::system::{LinkClaim, OpenEvents, is_pty};
use super::{CHUNK, Character, Port, PortError};
use crate::readiness::Readiness;
use profivac_dp::link::Baud;
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

/// socat sets owner and mode of its pty after it has made the link: such a change counts only this long after the link, in s. chosen.
const SETTLING_S: f64 = 10.0;

/// The rate of a pty that no program has set, in bit/s. No bus has it.
const UNSET_RATE: u32 = 38_400;

/// The master side of a pty, and the link to the slave side.
#[derive(Debug)]
pub struct Pty {
    name: String,
    link: PathBuf,
    /// Tells other processes that the link is in use.
    _claim: LinkClaim,
    sides: Sides,
    /// The pty before this one: a program that has just read the link must find it locked, not gone.
    _former: Option<Sides>,
    /// Reports every opening of the slave side.
    open_events: OpenEvents,
    /// A program has the slave side open.
    is_open: bool,
    /// The system has refused what the next program needs.
    is_refused: bool,
    drops: DropCounter,
    notices: Notices,
    /// The rate of the line; `None` if any rate is as good.
    baud: Option<Baud>,
    /// The rate of the program about which a notice was given.
    noticed_rate: u32,
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
        let open_events = OpenEvents::new().map_err(opening)?;
        let sides = Sides::open(&open_events).map_err(opening)?;
        symlink(&sides.slave_path, path).map_err(|error| link_error(&name, error))?;
        Ok(Self {
            name,
            link: path.to_owned(),
            _claim: claim,
            sides,
            _former: None,
            open_events,
            is_open: false,
            is_refused: false,
            drops: DropCounter::default(),
            notices: Notices::default(),
            baud: None,
            noticed_rate: UNSET_RATE,
        })
    }

    /// The line has this rate: a program that sets another one is named.
    #[must_use]
    pub const fn with_rate(mut self, baud: Option<Baud>) -> Self {
        self.baud = baud;
        self
    }

    /// Gives a notice if the program has set another rate. A pty passes octets at any rate, a serial port does not.
    fn check_rate(&mut self) {
        let (Some(baud), Ok(rate)) = (self.baud, self.sides.rate()) else { return };
        if ![UNSET_RATE, baud.bits_per_second(), self.noticed_rate].contains(&rate) {
            self.notices.extend([Notice::PtyRate { name: self.name.clone(), rate, baud }]);
        }
        self.noticed_rate = rate;
    }

    /// Updates whether a program has the slave side open. Prepares the slave side for the next program when the last one has closed it,
    /// also when it was opened and closed since the last call.
    fn update_open(&mut self) -> Result<(), PortError> {
        let was_opened = self.open_events.drain();
        let was_used = self.is_open || was_opened || self.is_refused;
        self.is_open = self.has_program()?;
        if was_used && !self.is_open {
            let prepared = self.prepare();
            self.report(prepared);
            self.is_open = self.has_program()?;
        }
        Ok(())
    }

    fn has_program(&self) -> Result<bool, PortError> {
        self.sides.is_open().map_err(|errno| PortError::using(&self.name, errno))
    }

    /// Makes the slave side raw, empty and unlocked, or replaces the pty if a program that has ended has locked it.
    fn prepare(&mut self) -> io::Result<()> {
        self.sides.reset_rate()?;
        self.noticed_rate = UNSET_RATE;
        match self.sides.reset(&self.open_events) {
            // If the slave side is open, the next program has opened and locked it just now.
            Err(Errno::BUSY) if !self.sides.is_open()? => self.replace(),
            Ok(()) | Err(Errno::BUSY) => Ok(()),
            Err(errno) => Err(errno.into()),
        }
    }

    /// Notes whether the slave side is prepared. The first refusal is a notice.
    fn report(&mut self, prepared: io::Result<()>) {
        let was_refused = self.is_refused;
        self.is_refused = prepared.is_err();
        if let Err(error) = prepared {
            // The end of a new pty that could not be linked is an event too: without this it would cause the next attempt at once.
            self.open_events.drain();
            let notice = Notice::PtyNotReady { name: self.name.clone(), reason: error.to_string() };
            self.notices.extend((!was_refused).then_some(notice));
        }
    }

    /// Puts a new pty behind the link, with owner and mode of the present one. After an error everything is as before.
    fn replace(&mut self) -> io::Result<()> {
        let sides = Sides::open(&self.open_events)?;
        // A server that may not change them keeps those of a new pty.
        copy_access(&self.sides.slave_path, &sides.slave_path).ok();
        if self.owns_link() {
            replace_link(&sides.slave_path, &self.link)?;
        }
        self._former = Some(std::mem::replace(&mut self.sides, sides));
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
}

impl Sides {
    /// Makes a pty whose slave side is raw. Its openings are events from now on, until it is dropped.
    fn open(open_events: &OpenEvents) -> Result<Self, Errno> {
        let master = open_master()?;
        rustix::io::ioctl_fionbio(&master, true)?;
        grantpt(&master)?;
        unlockpt(&master)?;
        let slave_path = PathBuf::from(OsString::from_vec(ptsname(&master, Vec::new())?.into_bytes()));
        let sides = Self { master, slave_path };
        open_events.watch(&sides.slave_path)?;
        sides.reset(open_events)?;
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

    /// The rate that the program has set, in bit/s.
    fn rate(&self) -> Result<u32, Errno> {
        Ok(tcgetattr(&self.master)?.output_speed())
    }

    /// Sets the rate of a new pty for the next program.
    ///
    /// A pty drops the parity bit, and the C library of Debian reports an error to a program whose settings change nothing else: a
    /// program that opens the pty for the second time would fail. With this rate its settings always change something.
    fn reset_rate(&self) -> Result<(), Errno> {
        let mut settings = tcgetattr(&self.master)?;
        if settings.output_speed() != UNSET_RATE && !self.is_open()? {
            settings.set_speed(UNSET_RATE)?;
            tcsetattr(&self.master, OptionalActions::Now, &settings)?;
        }
        Ok(())
    }

    /// Makes the slave side raw, discards its unread octets and unlocks it.
    ///
    /// Settings that are raw already stay untouched: the next program may be changing them at this moment, and the C library
    /// reports an error to a program whose settings did not hold.
    fn reset(&self, open_events: &OpenEvents) -> Result<(), Errno> {
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
        open_events.drain();
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
        [self.open_events.readiness(), master].into_iter().flatten().collect()
    }

    fn receive(&mut self, characters: &mut Vec<Character>) -> Result<(), PortError> {
        let mut buffer = [0; CHUNK];
        self.update_open()?;
        match rustix::io::read(&self.sides.master, &mut buffer) {
            Ok(length) => {
                self.check_rate();
                characters.extend(buffer.iter().take(length).map(|octet| Character::Octet(*octet)));
            }
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

/// Makes `link` lead to `side`. The link exists at every moment: a link with a name of its own takes its place.
fn replace_link(side: &Path, link: &Path) -> io::Result<()> {
    let folder = link.parent().unwrap_or(Path::new(""));
    let new = tempfile::Builder::new().prefix(".profivac-").make_in(folder, |path| symlink(side, path))?;
    new.into_temp_path().persist(link).map_err(|error| error.error)
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
    use rustix::fs::{AtFlags, CWD, Timestamps, inotify, utimensat};
    use rustix::io::{read, write};
    use rustix::termios::ioctl_tiocexcl;
    use rustix::thread::{CapabilitySet, capabilities, set_capabilities};
    use std::mem::MaybeUninit;
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

    /// The settings of a program that opens the slave side at `rate`.
    fn open_at(path: &Path, rate: u32) -> OwnedFd {
        let slave = rustix::fs::open(path, OFlags::RDWR | OFlags::NOCTTY, Mode::empty()).unwrap();
        let mut settings = tcgetattr(&slave).unwrap();
        settings.set_speed(rate).unwrap();
        tcsetattr(&slave, OptionalActions::Now, &settings).unwrap();
        slave
    }

    #[test]
    fn a_pty_has_the_rate_of_a_new_one_for_each_program() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("line");
        let mut ours = Pty::create(&path).unwrap();
        for _ in 0..3 {
            let slave = open_at(&path, 19_200);
            ours.receive(&mut Vec::new()).unwrap();
            assert_eq!(ours.sides.rate(), Ok(19_200), "the rate stays while the program runs");
            drop(slave);
            ours.receive(&mut Vec::new()).unwrap();
            assert_eq!(ours.sides.rate(), Ok(UNSET_RATE));
        }
    }

    #[test]
    fn a_program_at_another_rate_is_named_once() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("line");
        let mut ours = Pty::create(&path).unwrap().with_rate(Some(Baud::B187500));
        for (rate, count) in [(187_500, 0), (UNSET_RATE, 0), (230_400, 1), (9600, 1)] {
            let slave = open_at(&path, rate);
            for octet in [0x10, 0x16] {
                write(&slave, &[octet]).unwrap();
                ours.receive(&mut Vec::new()).unwrap();
            }
            let notices: Vec<String> =
                std::iter::from_fn(|| ours.next_notice()).map(|notice| notice.to_string()).collect();
            assert_eq!(notices.len(), count, "{rate}: {notices:?}");
            assert!(
                notices.iter().all(|text| text.contains(&rate.to_string()) && text.contains("187500")),
                "{notices:?}"
            );
            drop(slave);
            ours.receive(&mut Vec::new()).unwrap();
        }
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
        become_a_user_without(CapabilitySet::SYS_ADMIN);
    }

    fn become_a_user_without(taken: CapabilitySet) {
        let mut sets = capabilities(None).unwrap();
        sets.effective -= taken;
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
    fn a_new_pty_has_the_owner_and_the_group_of_the_one_it_replaces() {
        become_an_ordinary_user();
        let (folder, path, mut ours) = pty();
        let own = fs::metadata(folder.path()).unwrap();
        // Only root may choose another owner. The kernel may have given the pty the group of the terminals.
        let wanted =
            if chown(&path, Some(12_345), Some(12_346)).is_ok() { (12_345, 12_346) } else { (own.uid(), own.gid()) };
        chown(&path, Some(wanted.0), Some(wanted.1)).unwrap();
        drop(open_and_lock(&path));
        ours.receive(&mut Vec::new()).unwrap();
        let access = fs::metadata(&path).unwrap();
        assert_eq!((access.uid(), access.gid()), wanted);
        assert_usable(&mut ours, &path);
    }

    #[test]
    fn the_link_exists_at_every_moment_while_a_new_pty_takes_its_place() {
        become_an_ordinary_user();
        let (folder, path, mut ours) = pty();
        let changes = inotify::init(inotify::CreateFlags::NONBLOCK | inotify::CreateFlags::CLOEXEC).unwrap();
        let kinds = inotify::WatchFlags::DELETE | inotify::WatchFlags::MOVED_FROM | inotify::WatchFlags::MOVED_TO;
        inotify::add_watch(&changes, folder.path(), kinds).unwrap();
        drop(open_and_lock(&path));
        ours.receive(&mut Vec::new()).unwrap();
        let mut buffer = [MaybeUninit::uninit(); 1024];
        let mut reader = inotify::Reader::new(&changes, &mut buffer);
        let mut of_link = Vec::new();
        while let Ok(event) = reader.next() {
            if event.file_name().is_some_and(|name| name.to_bytes() == b"line") {
                of_link.push(event.events());
            }
        }
        assert_eq!(of_link, [inotify::ReadFlags::MOVED_TO]);
        assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 1, "nothing else stays in the folder");
    }

    /// A program reads the link just before it changes.
    #[test]
    fn a_program_that_opens_the_former_pty_finds_it_locked_and_not_gone() {
        become_an_ordinary_user();
        let (_folder, path, mut ours) = pty();
        for _ in 0..3 {
            let former = fs::read_link(&path).unwrap();
            drop(open_and_lock(&path));
            ours.receive(&mut Vec::new()).unwrap();
            assert_ne!(fs::read_link(&path).unwrap(), former);
            assert_eq!(open_as_a_program(&former).unwrap_err(), Errno::BUSY);
        }
    }

    /// What a look of the server leaves to do at once.
    fn is_readable(pty: &Pty) -> bool {
        let sources = pty.readiness();
        let mut events: Vec<_> = sources.iter().map(|source| PollFd::new(source, PollFlags::IN)).collect();
        poll(&mut events, Some(&Timespec::default())).unwrap() > 0
    }

    /// Looks twice while the pty cannot be made ready, and expects one notice in all.
    fn assert_goes_on_with_one_notice(pty: &mut Pty, reason: &str) {
        pty.receive(&mut Vec::new()).unwrap();
        let notice = pty.next_notice().unwrap().to_string();
        assert!(notice.contains("is not ready for the next program") && notice.contains(reason), "{notice}");
        assert!(!is_readable(pty), "the next look comes with the next timer or octet");
        pty.receive(&mut Vec::new()).unwrap();
        pty.send(b"not heard").unwrap();
        assert_eq!(pty.next_notice(), None);
    }

    #[test]
    fn a_server_whose_folder_takes_no_new_link_goes_on_and_tries_again_at_the_next_look() {
        become_a_user_without(CapabilitySet::SYS_ADMIN | CapabilitySet::DAC_OVERRIDE);
        let (folder, path, mut ours) = pty();
        let before = fs::read_link(&path).unwrap();
        drop(open_and_lock(&path));
        fs::set_permissions(folder.path(), PermissionsExt::from_mode(0o500)).unwrap();
        assert_goes_on_with_one_notice(&mut ours, "Permission denied");
        assert_eq!(fs::read_link(&path).unwrap(), before);
        fs::set_permissions(folder.path(), PermissionsExt::from_mode(0o700)).unwrap();
        ours.receive(&mut Vec::new()).unwrap();
        assert_usable(&mut ours, &path);
    }

    #[test]
    fn a_server_that_cannot_open_its_slave_side_goes_on_and_tries_again_at_the_next_look() {
        become_a_user_without(CapabilitySet::SYS_ADMIN | CapabilitySet::DAC_OVERRIDE | CapabilitySet::DAC_READ_SEARCH);
        let (_folder, path, mut ours) = pty();
        let program = open_as_a_program(&path).unwrap();
        assert_octets_pass(&mut ours, &program);
        ours.send(b"for the program that ends").unwrap();
        fs::set_permissions(&path, PermissionsExt::from_mode(0o000)).unwrap();
        drop(program);
        assert_goes_on_with_one_notice(&mut ours, "Permission denied");
        fs::set_permissions(&path, PermissionsExt::from_mode(0o600)).unwrap();
        ours.receive(&mut Vec::new()).unwrap();
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
