//! Replaces `serial.rs` on Windows: a COM port at 8E1.
//!
//! A thread reads the port and passes its octets on through a connection that can be waited for, another one writes. Windows does not say
//! which character had an error. It replaces one with a parity error by [`DAMAGED`], so that changes of two octets do not cancel in the
//! check octet.

use super::echo::Echo;
use super::notice::{DropCounter, Notice, Notices};
use super::{CHUNK, Character, CharacterFormat, Delivery, Parity, Port, PortError, settings, system};
use crate::readiness::{Local, Readiness, pair};
use profivac_dp::link::Baud;
use serial2::{CharSize, FlowControl, SerialPort, Settings, StopBits};
use std::io::{self, ErrorKind, Read as _, Write as _};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{Receiver, SyncSender, sync_channel};
use std::thread::JoinHandle;
use std::time::Duration;

/// How long the thread reads before it looks whether the port is still wanted. It does not delay octets.
const READ_TIMEOUT: Duration = Duration::from_millis(100);

/// The most telegrams that wait for the driver. chosen: a master sends one and waits for its answer.
const MOST_WAITING: usize = 16;

/// Whether a name may be a serial port: `COM5`.
#[must_use]
pub fn is_serial_port(name: &str) -> bool {
    super::error::is_windows_port(name)
}

/// Whether the system lists a serial port: any user may open it.
///
/// # Errors
/// [`PortError::NotFound`].
pub fn check_access(name: &str) -> Result<(), PortError> {
    let is_listed = super::list::serial_ports().iter().any(|port| port.name.eq_ignore_ascii_case(name));
    is_listed.then_some(()).ok_or_else(|| PortError::NotFound(name.to_owned()))
}

/// An open COM port.
#[derive(Debug)]
pub struct Serial {
    name: String,
    port: SerialPort,
    delivery: Delivery,
    received: Local,
    /// What the writing thread takes; `None` for a port that only listens.
    to_send: Option<SyncSender<Vec<u8>>>,
    /// A thread has ended because the port is gone, or shall end because it is closed.
    is_gone: Arc<AtomicBool>,
    /// The threads, which hold the port open.
    threads: Vec<JoinHandle<()>>,
    echo: Echo,
    drops: DropCounter,
    notices: Notices,
}

impl Serial {
    /// Opens a port exclusively: eight data bits, even parity, one stop bit.
    ///
    /// # Errors
    /// [`PortError::NotFound`], [`InUse`](PortError::InUse), [`UnsupportedCharacter`](PortError::UnsupportedCharacter) and
    /// [`UnsupportedRate`](PortError::UnsupportedRate).
    pub fn open(name: &str, baud: Baud) -> Result<Self, PortError> {
        let mut serial = Self::open_to_listen(name, baud)?;
        let (to_send, waiting) = sync_channel(MOST_WAITING);
        let (port, is_gone) = (serial.clone_port()?, Arc::clone(&serial.is_gone));
        serial.threads.push(spawn(name, move || write(&port, &waiting, &is_gone))?);
        serial.to_send = Some(to_send);
        Ok(serial)
    }

    /// Opens a port as [`open`](Self::open) does, without the thread that could send.
    ///
    /// # Errors
    /// As [`open`](Self::open).
    pub fn open_to_listen(name: &str, baud: Baud) -> Result<Self, PortError> {
        let opening = |error| PortError::opening(name, error);
        let configure = |mut settings: Settings| to_8e1(&mut settings, baud).map(|()| settings);
        // The library puts this in front itself.
        let device = name.strip_prefix(r"\\.\").unwrap_or(name);
        let mut port = SerialPort::open(device, configure).map_err(|error| match error.kind() {
            // The driver refuses the rate.
            ErrorKind::InvalidInput => PortError::UnsupportedRate { name: name.to_owned(), baud, offered: None },
            _ => opening(error),
        })?;
        verify(&port.get_configuration().map_err(opening)?, name, baud)?;
        port.set_read_timeout(READ_TIMEOUT).map_err(opening)?;
        port.discard_buffers().map_err(opening)?;
        let (received, passed_on) = pair().map_err(opening)?;
        received.set_nonblocking(true).map_err(opening)?;
        let mut serial = Self {
            name: name.to_owned(),
            port,
            delivery: system::delivery(name),
            received,
            to_send: None,
            is_gone: Arc::default(),
            threads: Vec::new(),
            echo: Echo::default(),
            drops: DropCounter::default(),
            notices: Notices::default(),
        };
        let (port, is_gone) = (serial.clone_port()?, Arc::clone(&serial.is_gone));
        serial.threads.push(spawn(name, move || read(&port, passed_on, &is_gone))?);
        Ok(serial)
    }

    fn clone_port(&self) -> Result<SerialPort, PortError> {
        self.port.try_clone().map_err(|error| PortError::opening(&self.name, error))
    }
}

impl Drop for Serial {
    /// The reading thread ends at its next look, the writing one when it has sent what waits: then the port can be opened again.
    fn drop(&mut self) {
        self.to_send = None;
        self.is_gone.store(true, Ordering::Relaxed);
        for thread in self.threads.drain(..) {
            // A thread that has panicked holds the port no more.
            thread.join().ok();
        }
    }
}

fn spawn(name: &str, run: impl FnOnce() + Send + 'static) -> Result<JoinHandle<()>, PortError> {
    let thread = std::thread::Builder::new().name(format!("port {name}")).spawn(run);
    thread.map_err(|error| PortError::system(name, error))
}

/// Passes received octets on until the port or its owner is gone. The end of the connection tells the owner.
fn read(port: &SerialPort, mut passed_on: Local, is_gone: &AtomicBool) {
    let mut buffer = [0; CHUNK];
    while !is_gone.load(Ordering::Relaxed) {
        match port.read(&mut buffer) {
            Ok(0) => break,
            Ok(length) => {
                if passed_on.write_all(buffer.get(..length).unwrap_or_default()).is_err() {
                    break;
                }
            }
            Err(error) if matches!(error.kind(), ErrorKind::TimedOut | ErrorKind::WouldBlock) => {}
            Err(_) => break,
        }
    }
    is_gone.store(true, Ordering::Relaxed);
}

/// Writes what waits until the port is gone or its owner has closed it.
fn write(port: &SerialPort, waiting: &Receiver<Vec<u8>>, is_gone: &AtomicBool) {
    for octets in waiting {
        if port.write_all(&octets).is_err() {
            is_gone.store(true, Ordering::Relaxed);
            break;
        }
    }
}

/// What Windows puts in place of a character with a parity error. chosen: no telegram begins with it, and few hold it.
const DAMAGED: u8 = 0xFF;

/// Bits of the settings of a port. Microsoft, "DCB structure": parity is checked, a character with an error is replaced, an error stops
/// everything until it is asked for.
const CHECKS_PARITY: u32 = 1 << 1;
const REPLACES: u32 = 1 << 10;
const STOPS: u32 = 1 << 14;

/// Eight data bits, even parity, one stop bit, no handshake; a character with an error does not stop the port.
fn to_8e1(settings: &mut Settings, baud: Baud) -> io::Result<()> {
    settings.set_raw();
    let dcb = settings.as_raw_dbc_mut();
    dcb._bitfield = (dcb._bitfield | CHECKS_PARITY | REPLACES) & !STOPS;
    dcb.ErrorChar = DAMAGED.cast_signed();
    settings.set_char_size(CharSize::Bits8);
    settings.set_parity(serial2::Parity::Even);
    settings.set_stop_bits(StopBits::One);
    settings.set_flow_control(FlowControl::None);
    settings.set_baud_rate(baud.bits_per_second())
}

/// Verifies the settings that the driver has taken.
fn verify(taken: &Settings, name: &str, baud: Baud) -> Result<(), PortError> {
    let opening = |error| PortError::opening(name, error);
    let offered = CharacterFormat {
        data_bits: taken.get_char_size().map_err(opening)?.as_u8(),
        parity: match taken.get_parity().map_err(opening)? {
            serial2::Parity::None => Parity::None,
            serial2::Parity::Even => Parity::Even,
            serial2::Parity::Odd => Parity::Odd,
        },
        stop_bits: if taken.get_stop_bits().map_err(opening)? == StopBits::One { 1 } else { 2 },
    };
    settings::verify(name, baud, offered, [Some(taken.get_baud_rate().map_err(opening)?)])
}

impl Port for Serial {
    fn name(&self) -> &str {
        &self.name
    }

    fn delivery(&self) -> Delivery {
        self.delivery
    }

    fn readiness(&self) -> Vec<Readiness<'_>> {
        vec![Readiness::of(&self.received)]
    }

    fn receive(&mut self, characters: &mut Vec<Character>) -> Result<(), PortError> {
        let mut buffer = [0; CHUNK];
        match self.received.read(&mut buffer) {
            Ok(0) => Err(PortError::Lost(self.name.clone())),
            Ok(length) => {
                for octet in buffer.iter().take(length) {
                    self.echo.filter(Character::Octet(*octet), characters);
                }
                Ok(())
            }
            Err(error) if super::stream::is_temporary(&error) => Ok(()),
            Err(_) => Err(PortError::Lost(self.name.clone())),
        }
    }

    fn send(&mut self, octets: &[u8]) -> Result<(), PortError> {
        if self.is_gone.load(Ordering::Relaxed) {
            return Err(PortError::Lost(self.name.clone()));
        }
        let is_taken = self.to_send.as_ref().is_some_and(|to_send| to_send.try_send(octets.to_vec()).is_ok());
        if is_taken {
            self.echo.sent(octets);
        }
        self.notices.extend(self.drops.sent(&self.name, octets.len(), if is_taken { octets.len() } else { 0 }));
        Ok(())
    }

    fn set_baud(&mut self, baud: Baud) -> Result<(), PortError> {
        let using = |error| PortError::system(&self.name, error);
        let mut settings = self.port.get_configuration().map_err(using)?;
        let set = to_8e1(&mut settings, baud).and_then(|()| self.port.set_configuration(&settings));
        if set.is_err() {
            return Err(PortError::UnsupportedRate { name: self.name.clone(), baud, offered: None });
        }
        verify(&self.port.get_configuration().map_err(using)?, &self.name, baud)?;
        // Octets received at the old rate are meaningless at the new one.
        self.port.discard_buffers().map_err(using)?;
        let mut buffer = [0; CHUNK];
        while let Ok(1..) = self.received.read(&mut buffer) {}
        self.echo = Echo::default();
        Ok(())
    }

    fn next_notice(&mut self) -> Option<Notice> {
        self.notices.next()
    }
}
