//! Signals and standard input on Windows: a handler and a thread pass them on through connections that can be waited for.

use super::Key;
use profivac_host::readiness::{Local, pair};
use ratatui::crossterm::terminal::{disable_raw_mode, enable_raw_mode};
use std::io::{self, Read as _, Write as _};
use std::os::windows::io::{AsSocket, BorrowedSocket};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, OnceLock, PoisonError};

/// The numbers of the signals. Windows has no first one; Ctrl-C and Ctrl-Break stand for both others. When the window is closed, Windows
/// ends the program at once.
pub const SIGHUP: i32 = 1;
pub const SIGINT: i32 = 2;
pub const SIGTERM: i32 = 15;

/// What the handler tells.
#[derive(Debug, Default)]
struct Told {
    connections: Vec<Local>,
    flags: Vec<Arc<AtomicBool>>,
}

static TOLD: OnceLock<Mutex<Told>> = OnceLock::new();

/// Installs the handler at the first call, and adds to what it tells.
fn add(signal: i32, add: impl FnOnce(&mut Told)) -> io::Result<()> {
    if signal == SIGHUP {
        return Ok(());
    }
    let mut is_first = false;
    let told = TOLD.get_or_init(|| {
        is_first = true;
        Mutex::default()
    });
    add(&mut told.lock().unwrap_or_else(PoisonError::into_inner));
    if is_first { ctrlc::set_handler(tell).map_err(io::Error::other) } else { Ok(()) }
}

fn tell() {
    let Some(told) = TOLD.get() else { return };
    let mut told = told.lock().unwrap_or_else(PoisonError::into_inner);
    for flag in &told.flags {
        flag.store(true, Ordering::Relaxed);
    }
    // A connection that nobody reads any more is closed.
    told.connections.retain_mut(|connection| connection.write_all(&[0]).is_ok());
}

/// The connections for a signal that never comes: a closed one would be readable for ever.
static SILENT: Mutex<Vec<Local>> = Mutex::new(Vec::new());

/// Writes an octet to `to` for each signal from now on.
pub fn pass_on(signal: i32, to: Local) -> io::Result<()> {
    to.set_nonblocking(true)?;
    if signal == SIGHUP {
        SILENT.lock().unwrap_or_else(PoisonError::into_inner).push(to);
        return Ok(());
    }
    add(signal, |told| told.connections.push(to))
}

/// Sets a flag with each signal from now on.
pub fn set_flag(signal: i32, flag: &Arc<AtomicBool>) -> io::Result<()> {
    add(signal, |told| told.flags.push(Arc::clone(flag)))
}

/// Standard input, which can be waited for.
#[derive(Debug)]
pub struct Stdin(Local);

/// What the thread that reads standard input passes on.
static READ: OnceLock<Local> = OnceLock::new();

/// Standard input: from the first call on a thread reads it.
pub fn stdin() -> io::Result<Stdin> {
    if let Some(near) = READ.get() {
        return near.try_clone().map(Stdin);
    }
    let (near, mut far) = pair()?;
    let pass_on = move || {
        let mut buffer = [0; 4096];
        while let Ok(length @ 1..) = io::stdin().lock().read(&mut buffer) {
            if far.write_all(buffer.get(..length).unwrap_or_default()).is_err() {
                break;
            }
        }
    };
    std::thread::Builder::new().name("standard input".to_owned()).spawn(pass_on)?;
    near.set_nonblocking(true)?;
    READ.get_or_init(|| near).try_clone().map(Stdin)
}

impl AsSocket for Stdin {
    fn as_socket(&self) -> BorrowedSocket<'_> {
        self.0.as_socket()
    }
}

/// Reads what standard input has now.
pub fn read(stdin: &Stdin, buffer: &mut [u8]) -> io::Result<usize> {
    (&stdin.0).read(buffer)
}

/// A console that does not show what is typed, until this is dropped.
#[derive(Debug)]
pub struct Silence(());

/// Hides what is typed: the console passes on each key at once.
pub fn silence() -> io::Result<Silence> {
    enable_raw_mode().map(|()| Silence(()))
}

impl Silence {
    /// The meaning of an octet of a line: the console passes on the keys themselves.
    pub const fn key(octet: u8) -> Key {
        match octet {
            b'\r' => Key::End,
            3 => Key::Interrupt,
            8 => Key::Delete,
            octet => Key::Octet(octet),
        }
    }
}

impl Drop for Silence {
    fn drop(&mut self) {
        // An error cannot be reported any more.
        disable_raw_mode().ok();
    }
}
