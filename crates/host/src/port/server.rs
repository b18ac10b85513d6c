//! The first moments of a connection to a serial server.
//!
//! A server that has another client takes a new connection and closes it at once, often with a line of words. So does one whose client has
//! just gone, until its own port is closed. A command that began its work on such a connection would lose telegrams, or the whole bus.

use super::PortError;
use crate::readiness::{self, Readiness};
use std::net::TcpStream;
use std::time::Duration;

/// The time in which a server that has another client closes a connection. chosen: it does so at once, and each command waits as long.
const REFUSAL: Duration = Duration::from_millis(100);

/// The connections that are tried, and the pause between them. chosen: a server that closes its port is waited for some five seconds.
const ATTEMPTS: usize = 25;
const PAUSE: Duration = Duration::from_millis(100);

/// A connection to a serial server.
pub(super) trait Connection: Sized {
    /// The longest wait for the first octet of the server.
    const PATIENCE: Duration;

    fn socket(&self) -> &TcpStream;

    /// Appends the octets that the server has sent since the connection, or since the last call.
    ///
    /// # Errors
    /// [`PortError::Lost`] if the server has closed the connection.
    fn hear(&mut self, heard: &mut Vec<u8>) -> Result<(), PortError>;

    /// Gives the notices about a server that keeps the connection and has sent `heard`.
    fn check_server(&mut self, heard: &[u8]);
}

/// Connects until the server keeps the connection. Looks before each further attempt whether the wait `is_cancelled`.
///
/// # Errors
/// The error of `connect`, [`PortError::ServerBusy`] if the server closes each connection, and [`PortError::Interrupted`].
pub(super) fn open<C: Connection>(
    name: &str,
    is_cancelled: &dyn Fn() -> bool,
    mut connect: impl FnMut() -> Result<C, PortError>,
) -> Result<C, PortError> {
    let mut heard = Vec::new();
    for attempt in 0..ATTEMPTS {
        if attempt > 0 {
            std::thread::sleep(PAUSE);
            if is_cancelled() {
                return Err(PortError::Interrupted(name.to_owned()));
            }
        }
        heard.clear();
        match connect().and_then(|connection| kept(name, connection, &mut heard)) {
            Err(PortError::Lost(_)) => {}
            outcome => return outcome,
        }
    }
    Err(PortError::ServerBusy { name: name.to_owned(), words: words(&heard).unwrap_or_default() })
}

/// The connection, if the server keeps it.
fn kept<C: Connection>(name: &str, mut connection: C, heard: &mut Vec<u8>) -> Result<C, PortError> {
    let system = |error| PortError::system(name, error);
    if !C::PATIENCE.is_zero() {
        readiness::wait(&[Readiness::of(connection.socket())], C::PATIENCE).map_err(system)?;
        connection.hear(heard)?;
    }
    let is_closed = readiness::wait_until_closed(Readiness::of(connection.socket()), REFUSAL).map_err(system)?;
    connection.hear(heard)?;
    if is_closed {
        return Err(PortError::Lost(name.to_owned()));
    }
    connection.check_server(heard);
    Ok(connection)
}

/// The words of a server, if `octets` are words and no telegrams.
pub(super) fn words(octets: &[u8]) -> Option<String> {
    let is_text = |octet: &u8| octet.is_ascii_graphic() || matches!(octet, b' ' | b'\r' | b'\n' | b'\t');
    let letters = octets.iter().filter(|octet| octet.is_ascii_alphabetic()).count();
    let is_words = letters >= 4 && octets.len() >= 6 && octets.iter().all(is_text);
    is_words.then(|| String::from_utf8_lossy(octets).split_whitespace().collect::<Vec<_>>().join(" "))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::port::{self, Notice, Port};
    use profivac_dp::link::Baud;
    use std::io::{Read, Write};
    use std::net::TcpListener;
    use std::sync::Arc;
    use std::sync::atomic::{AtomicUsize, Ordering};

    /// A server that runs `serve` with the number of each connection, and the part of its name behind the scheme.
    fn server(mut serve: impl FnMut(usize, std::net::TcpStream) + Send + 'static) -> String {
        let listener = TcpListener::bind("127.0.0.1:0").unwrap();
        let address = listener.local_addr().unwrap().to_string();
        std::thread::spawn(move || {
            for (number, socket) in listener.incoming().enumerate() {
                serve(number, socket.unwrap());
            }
        });
        address
    }

    fn notices(port: &mut dyn Port) -> Vec<Notice> {
        std::iter::from_fn(|| port.next_notice()).collect()
    }

    #[test]
    fn a_server_that_speaks_telnet_on_a_raw_port_is_named_once_at_the_opening() {
        let address = server(|_, mut socket| {
            socket.write_all(&[0xFF, 0xFD, 44, 0xFF, 0xFB, 0]).ok();
            drain(socket);
        });
        let name = format!("tcp://{address}");
        let mut port = port::open(&name, Baud::B19200).unwrap();
        assert_eq!(notices(&mut *port), [Notice::TelnetServer(name)]);
        port.receive(&mut Vec::new()).unwrap();
        assert_eq!(notices(&mut *port), []);
    }

    /// Reads until the other side closes the connection.
    fn drain(mut socket: std::net::TcpStream) {
        socket.read_to_end(&mut Vec::new()).ok();
    }

    #[test]
    fn a_server_whose_client_has_just_gone_is_asked_again() {
        for scheme in ["tcp", "telnet", "rfc2217"] {
            let (done, waiting) = std::sync::mpsc::channel();
            let address = server(move |number, mut socket| {
                if number < 2 {
                    socket.write_all(b"Port already in use\r\n").ok();
                } else {
                    done.send(number).ok();
                    drain(socket);
                }
            });
            let port = port::open(&format!("{scheme}://{address}"), Baud::B19200).map(|port| port.name().to_owned());
            assert_eq!(port.unwrap(), format!("{scheme}://{address}"));
            assert_eq!(waiting.recv().unwrap(), 2);
        }
    }

    #[test]
    fn a_server_that_closes_each_connection_is_an_error_with_its_words() {
        for (said, expected) in [
            (
                &b"Port already in use\r\n"[..],
                "closes each connection at once and says 'Port already in use': another program",
            ),
            (&[0xDC, 2, 1], "closes each connection at once: another program"),
            (&[], "closes each connection at once: another program"),
        ] {
            let address = server(move |_, mut socket| {
                socket.write_all(said).ok();
            });
            let error = port::open(&format!("tcp://{address}"), Baud::B19200).map(|_| ()).unwrap_err().to_string();
            assert!(error.contains(expected) && error.contains(&address), "{error}");
        }
    }

    #[test]
    fn the_wait_for_a_busy_server_ends_when_the_caller_cancels_it() {
        let connections = Arc::new(AtomicUsize::new(0));
        let counted = Arc::clone(&connections);
        let address = server(move |number, _| counted.store(number + 1, Ordering::SeqCst));
        let name = format!("tcp://{address}");
        let is_cancelled = || connections.load(Ordering::SeqCst) >= 2;
        let error = port::open_unless(&name, Baud::B19200, &is_cancelled).map(|_| ()).unwrap_err();
        assert!(matches!(&error, PortError::Interrupted(port) if *port == name), "{error:?}");
    }

    #[test]
    fn a_login_is_named_and_octets_behind_telnet_too() {
        let address = server(|_, mut socket| {
            socket.write_all(b"login: ").ok();
            drain(socket);
        });
        for scheme in ["tcp", "telnet"] {
            let name = format!("{scheme}://{address}");
            let mut port = port::open(&name, Baud::B19200).unwrap();
            let told = notices(&mut *port);
            let banner = Notice::ServerBanner { name: name.clone(), words: "login:".to_owned() };
            assert!(told.contains(&banner), "{told:?}");
            assert_eq!(told.contains(&Notice::NoTelnetServer(name)), scheme == "telnet", "{told:?}");
        }
    }

    #[test]
    fn what_a_line_sends_before_it_is_open_is_received() {
        let telegram = [0xDC, 2, 1];
        let address = server(move |_, mut socket| {
            socket.write_all(&telegram).ok();
            drain(socket);
        });
        let mut port = port::open(&format!("tcp://{address}"), Baud::B19200).unwrap();
        let mut characters = Vec::new();
        while characters.len() < telegram.len() {
            let ready = readiness::wait(&port.readiness(), Duration::from_secs(60)).unwrap();
            assert_eq!(ready, [true], "{characters:?} and no more in a minute");
            port.receive(&mut characters).unwrap();
        }
        assert_eq!(characters, telegram.map(port::Character::Octet));
    }

    #[test]
    fn a_bus_in_operation_is_open_without_a_notice() {
        let address = server(|_, mut socket| while socket.write_all(&[0xDC, 2, 1].repeat(20)).is_ok() {});
        let mut port = port::open(&format!("tcp://{address}"), Baud::B19200).unwrap();
        assert_eq!(notices(&mut *port), []);
    }

    #[test]
    fn telegrams_are_no_words() {
        assert_eq!(words(b"Port already in use\r\n").as_deref(), Some("Port already in use"));
        assert_eq!(words(b"login: ").as_deref(), Some("login:"));
        for octets in [
            &b"hhhhh"[..],
            b"12345678",
            b"login\x01 ",
            &[0x10, 8, 2, 0x49, 0x53, 0x16],
            &[0x68, 5, 5, 0x68, 0x88, 0x82, 0x6D, 0x3C, 0x3E, 0xF1, 0x16],
        ] {
            assert_eq!(words(octets), None, "{octets:02X?}");
        }
    }
}
