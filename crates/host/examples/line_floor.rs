//! The processor time of a station's system calls alone: `cargo run --release -p profivac-host --example line_floor`
//!
//! Sixteen threads do for 20 s what the thread of a segment behind a TCP port does for each exchange of data, and nothing else: send a
//! request, wait for the answer, receive it, wait for the idle time of the line, and look for an octet that came meanwhile. The gauges are
//! another process, which answers after the time of the telegrams at 19.2 kbit/s. Linux.

use profivac_host::readiness::{Readiness, wait};
use std::io::{ErrorKind, Read, Write};
use std::net::{TcpListener, TcpStream};
use std::process::{Command, Stdio};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;

const SEGMENTS: usize = 16;
const TIME: Duration = Duration::from_secs(20);
const REQUEST: [u8; 9] = [0x68; 9];
const ANSWER: [u8; 20] = [0x68; 20];
/// The time of request, delay and answer.
const ANSWERED_AFTER: Duration = Duration::from_micros(1_500);
/// The rest of the time of one gauge: a station with 30 gauges on such a line has a cycle of 88 ms.
const IDLE: Duration = Duration::from_micros(1_100);
const LONGEST: Duration = Duration::from_secs(1);
const TICKS_PER_SECOND: f64 = 100.0;

fn main() -> std::io::Result<()> {
    match std::env::args().nth(1) {
        Some(address) => answer(&address),
        None => measure(),
    }
}

/// The gauges of all segments.
fn answer(address: &str) -> std::io::Result<()> {
    let lines = (0..SEGMENTS).map(|_| TcpStream::connect(address)).collect::<Result<Vec<_>, _>>()?;
    std::thread::scope(|threads| {
        for mut line in lines {
            threads.spawn(move || {
                let mut request = [0; 64];
                while line.read(&mut request).is_ok_and(|length| length > 0) {
                    std::thread::sleep(ANSWERED_AFTER);
                    if line.write_all(&ANSWER).is_err() {
                        return;
                    }
                }
            });
        }
    });
    Ok(())
}

fn measure() -> std::io::Result<()> {
    let listener = TcpListener::bind("127.0.0.1:0")?;
    let address = listener.local_addr()?.to_string();
    let mut gauges = Command::new(std::env::current_exe()?).arg(address).stdin(Stdio::null()).spawn()?;
    let ended = Arc::new(AtomicBool::new(false));
    let mut threads = Vec::new();
    for _ in 0..SEGMENTS {
        let (line, _) = listener.accept()?;
        line.set_nonblocking(true)?;
        let ended = Arc::clone(&ended);
        threads.push(std::thread::spawn(move || exchange(line, &ended)));
    }
    std::thread::sleep(TIME);
    ended.store(true, Ordering::Relaxed);
    let mut exchanges = 0;
    for thread in threads {
        exchanges += thread.join().map_err(|_| std::io::Error::other("a thread has panicked"))??;
    }
    gauges.wait()?;
    let [user, system] = shares()?;
    let seconds = TIME.as_secs_f64();
    println!("{:.0} exchanges/s: {user:.1} % of a core user, {system:.1} % system", exchanges as f64 / seconds);
    Ok(())
}

/// Exchanges until `ended`; returns how often.
fn exchange(mut line: TcpStream, ended: &AtomicBool) -> std::io::Result<u64> {
    let (mut octets, mut exchanges) = ([0; 256], 0);
    while !ended.load(Ordering::Relaxed) {
        line.write_all(&REQUEST)?;
        wait(&[Readiness::of(&line)], LONGEST)?;
        received(&mut line, &mut octets)?;
        exchanges += 1;
        wait(&[Readiness::of(&line)], IDLE)?;
        received(&mut line, &mut octets)?;
    }
    Ok(exchanges)
}

fn received(line: &mut TcpStream, octets: &mut [u8]) -> std::io::Result<usize> {
    match line.read(octets) {
        Err(error) if error.kind() == ErrorKind::WouldBlock => Ok(0),
        other => other,
    }
}

/// The processor time of this process in percent of a core, user and system.
fn shares() -> std::io::Result<[f64; 2]> {
    let text = std::fs::read_to_string("/proc/self/stat")?;
    let fields: Vec<&str> = text.rsplit(')').next().unwrap_or_default().split_whitespace().collect();
    let ticks = |index: usize| fields.get(index).and_then(|field| field.parse::<f64>().ok()).unwrap_or_default();
    Ok([11, 12].map(|index| 100.0 * ticks(index) / TICKS_PER_SECOND / TIME.as_secs_f64()))
}
