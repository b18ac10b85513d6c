//! The first moments of a connection to a serial server.
//!
//! A server that has another client takes a new connection and closes it at once, often with a line of words. So does one whose client has
//! just gone, until its own port is closed. A command that began its work on such a connection would lose telegrams, or the whole bus.

use super::{Character, Port, PortError};
use crate::readiness;
use std::time::Duration;

/// The silence after which a connection counts as open. chosen: a refusal comes together with the connection, or with the first answer.
const QUIET: Duration = Duration::from_millis(100);

/// The most octets and the most waits of an opening: a bus that is in operation is never silent. chosen: a greeting fits, and the waits end
/// after two seconds.
const LONGEST_GREETING: usize = 256;
const MOST_WAITS: usize = 20;

/// The connections that are tried, and the pause between them. chosen: a server that closes its port is waited for some five seconds.
const ATTEMPTS: usize = 25;
const PAUSE: Duration = Duration::from_millis(100);

/// Connects until the server keeps the connection. Waits at most `patience` for its first octet. Returns what it has sent meanwhile, too.
///
/// # Errors
/// The error of `connect`, and [`PortError::ServerBusy`] if the server closes each connection.
pub(super) fn open<P: Port>(
    patience: Duration,
    mut connect: impl FnMut() -> Result<P, PortError>,
) -> Result<(P, Vec<u8>), PortError> {
    let mut heard = Vec::new();
    let mut name = String::new();
    for attempt in 0..ATTEMPTS {
        if attempt > 0 {
            std::thread::sleep(PAUSE);
        }
        heard.clear();
        let lost = match connect() {
            Ok(mut port) => match listen(&mut port, patience, &mut heard) {
                Ok(()) => return Ok((port, heard)),
                Err(error) => error,
            },
            Err(error) => error,
        };
        match lost {
            PortError::Lost(port) => name = port,
            error => return Err(error),
        }
    }
    Err(PortError::ServerBusy { name, words: words(&heard).unwrap_or_default() })
}

/// Appends what the server sends until it is silent.
fn listen(port: &mut impl Port, patience: Duration, heard: &mut Vec<u8>) -> Result<(), PortError> {
    let mut timeout = patience;
    for _ in 0..MOST_WAITS {
        let ready =
            readiness::wait(&port.readiness(), timeout).map_err(|error| PortError::system(port.name(), error))?;
        if !ready.contains(&true) || heard.len() >= LONGEST_GREETING {
            break;
        }
        let mut characters = Vec::new();
        port.receive(&mut characters)?;
        let octets = characters.iter().filter_map(|character| match character {
            Character::Octet(octet) => Some(*octet),
            Character::Error => None,
        });
        heard.extend(octets.take(LONGEST_GREETING.saturating_sub(heard.len())));
        timeout = QUIET;
    }
    Ok(())
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
    use crate::port::{self, Notice};
    use profivac_dp::link::Baud;
    use std::io::{Read, Write};
    use std::net::TcpListener;

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
