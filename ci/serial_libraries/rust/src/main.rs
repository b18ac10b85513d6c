//! Asks the station at address 5 for its status through the crate `serialport`, as a program of a user does.
//!
//! Usage: ask PORT
//!
//! The port is opened once, with 19200 bit/s and even parity. Prints the answer in hex.

use std::error::Error;
use std::time::Duration;

/// FDL status request of master 2, and the length of its answer (profibus-wire 1.9).
const REQUEST: [u8; 6] = [0x10, 5, 2, 0x49, 0x50, 0x16];
const ANSWER_OCTETS: usize = 6;

/// The longest wait for an answer: a loaded computer is slow.
const TIMEOUT: Duration = Duration::from_secs(60);

fn main() -> Result<(), Box<dyn Error>> {
    let path = std::env::args().nth(1).ok_or("expected the path of a port")?;
    let mut port = serialport::new(path, 19_200).parity(serialport::Parity::Even).timeout(TIMEOUT).open()?;
    port.write_all(&REQUEST)?;
    let mut answer = [0; ANSWER_OCTETS];
    port.read_exact(&mut answer)?;
    println!("{}", answer.map(|octet| format!("{octet:02x}")).join(" "));
    Ok(())
}
