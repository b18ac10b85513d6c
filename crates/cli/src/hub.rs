//! `profivac hub`: a virtual RS-485 line between ptys, with disturbances on command.

use crate::console::{Console, Input};
use crate::failure::Failure;
use crate::output::{notice, notices, out};
use crate::values::{self, ValueError};
use clap::Args;
use fastrand::Rng;
use profivac_dp::link::{Baud, BitTime, CHARACTER_TBIT};
use profivac_host::clock::Clock;
use profivac_host::port::{Character, Port, PortError, Pty};
use profivac_host::readiness::{Readiness, wait};
use std::collections::{BTreeSet, VecDeque};
use std::ops::ControlFlow;
use std::path::PathBuf;
use std::time::{Duration, Instant};

/// Connect several ptys as one virtual RS-485 bus.
///
/// The command prints `ready` and the paths when the line works. Then it reads commands from standard input and answers each with
/// one line that begins with `ok` or `error:`. It continues after end of file; `quit`, SIGTERM and SIGINT end it.
#[derive(Args, Debug)]
#[command(after_help = EXAMPLES)]
pub struct Arguments {
    /// Make a pty and link PATH to it; at least two
    #[arg(long = "pty", value_name = "PATH", required = true)]
    ptys: Vec<PathBuf>,
    /// The probability that a bit of an octet is inverted on the line
    #[arg(long, value_name = "P", default_value = "0", value_parser = values::probability, allow_hyphen_values = true)]
    flip: f64,
    /// The probability that an octet is lost on the line
    #[arg(long, value_name = "P", default_value = "0", value_parser = values::probability, allow_hyphen_values = true)]
    drop: f64,
    /// The seed of the disturbances: the same seed gives the same disturbances
    #[arg(long, value_name = "N", default_value_t = 0)]
    seed: u64,
    /// Transmit every octet in the time it takes at this rate
    #[arg(long, value_name = "BAUD", value_parser = values::baud)]
    pace: Option<Baud>,
}

const EXAMPLES: &str = "\
Lines on standard input:
  mute PATH SECONDS             discards the octets that PATH writes for this time
  quit                          ends the hub

Examples:
  profivac hub --pty /tmp/master --pty /tmp/tap
  profivac hub --pty /tmp/master --pty /tmp/a --pty /tmp/b --flip 0.002 --seed 7
On the second line, a master opens /tmp/master, and these commands are the slaves:
  profivac simulate --serial /tmp/a bcg450@5
  profivac simulate --serial /tmp/b bcg450@6";

/// Serves until `quit` or a signal.
pub fn run(arguments: &Arguments) -> Result<(), Failure> {
    check_paths(&arguments.ptys)?;
    let mut hub = Hub::open(arguments)?;
    let mut console = Console::open()?;
    out(&format!("ready {}", hub.names().join(" ")));
    loop {
        let (readable, console_count) = {
            let console = console.descriptors();
            let console_count = console.len();
            let descriptors: Vec<_> = console.into_iter().chain(hub.descriptors()).collect();
            (wait(&descriptors, hub.time_until_due())?, console_count)
        };
        hub.serve()?;
        for input in console.take_input(readable.get(..console_count).unwrap_or_default()) {
            if handle_input(&mut hub, &input).is_break() {
                let Noise { passed, flipped, dropped, .. } = hub.noise;
                notice(&format_args!("{passed} octets, {flipped} with an inverted bit, {dropped} lost"));
                return Ok(());
            }
        }
    }
}

/// Fails unless there are at least two paths, all different.
fn check_paths(ptys: &[PathBuf]) -> Result<(), Failure> {
    if ptys.len() < 2 {
        return Err(Failure::usage("expected at least two --pty, got one"));
    }
    let mut taken = BTreeSet::new();
    match ptys.iter().find(|path| !taken.insert(*path)) {
        Some(path) => Err(Failure::usage(format!("--pty {} is given twice", path.display()))),
        None => Ok(()),
    }
}

fn handle_input(hub: &mut Hub, input: &Input) -> ControlFlow<()> {
    let Some(line) = input.command()? else { return ControlFlow::Continue(()) };
    let words: Vec<&str> = line.split_whitespace().collect();
    match words[..] {
        ["mute", path, seconds] => match hub.mute(path, seconds) {
            Ok(()) => out("ok"),
            Err(error) => out(&format!("error: {error}")),
        },
        ["quit"] => {
            out("ok");
            return ControlFlow::Break(());
        }
        _ => out(&format!("error: expected mute PATH SECONDS or quit, got {line:?}")),
    }
    ControlFlow::Continue(())
}

/// The reason why `mute` failed.
#[derive(Debug, thiserror::Error)]
enum MuteError {
    #[error(transparent)]
    Seconds(#[from] ValueError),
    #[error("expected a shorter time: the clock cannot represent this one")]
    TooLong,
    /// `known` are the paths of the hub.
    #[error("no pty {path}; known: {known}")]
    UnknownPty { path: String, known: String },
}

/// A pty on the line.
struct HubPort {
    pty: Pty,
    muted_until: Option<Instant>,
}

/// The virtual line.
struct Hub {
    ports: Vec<HubPort>,
    noise: Noise,
    pace: Option<Pace>,
    received: Vec<Character>,
}

/// The octets on a line with a rate.
struct Pace {
    clock: Clock,
    /// The time at which the line is free again.
    free: BitTime,
    /// For each octet: the time at which it has passed, the number of its port, the octet.
    queue: VecDeque<(BitTime, usize, u8)>,
}

impl Hub {
    fn open(arguments: &Arguments) -> Result<Self, PortError> {
        let mut ports = Vec::new();
        for path in &arguments.ptys {
            ports.push(HubPort { pty: Pty::create(path)?.with_rate(arguments.pace), muted_until: None });
        }
        let pace = arguments.pace.map(|baud| Pace {
            clock: Clock::starting_at(BitTime(0), baud),
            free: BitTime(0),
            queue: VecDeque::new(),
        });
        let noise = Noise::new(arguments.flip, arguments.drop, arguments.seed);
        Ok(Self { ports, noise, pace, received: Vec::new() })
    }

    fn names(&self) -> Vec<&str> {
        self.ports.iter().map(|port| port.pty.name()).collect()
    }

    fn descriptors(&self) -> impl Iterator<Item = Readiness<'_>> {
        self.ports.iter().flat_map(|port| port.pty.readiness())
    }

    /// The time until the next octet is due.
    fn time_until_due(&self) -> Duration {
        let next = self.pace.as_ref().and_then(|pace| pace.queue.front().map(|(end, ..)| pace.clock.time_until(*end)));
        next.unwrap_or(Duration::MAX)
    }

    fn mute(&mut self, path: &str, seconds: &str) -> Result<(), MuteError> {
        let duration = values::seconds(seconds)?;
        let until = Instant::now().checked_add(duration).ok_or(MuteError::TooLong)?;
        let unknown = MuteError::UnknownPty { path: path.to_owned(), known: self.names().join(", ") };
        let port = self.ports.iter_mut().find(|port| port.pty.name() == path).ok_or(unknown)?;
        port.muted_until = Some(until);
        Ok(())
    }

    fn serve(&mut self) -> Result<(), PortError> {
        for from in 0..self.ports.len() {
            let octets = self.receive(from)?;
            self.forward(from, &octets)?;
        }
        self.deliver_due()
    }

    /// The octets that a port writes, with disturbances.
    fn receive(&mut self, from: usize) -> Result<Vec<u8>, PortError> {
        let Some(port) = self.ports.get_mut(from) else { return Ok(Vec::new()) };
        self.received.clear();
        port.pty.receive(&mut self.received)?;
        if port.muted_until.is_some_and(|until| Instant::now() < until) {
            return Ok(Vec::new());
        }
        let noise = &mut self.noise;
        let octet = |character: &Character| match character {
            Character::Octet(octet) => noise.disturb(*octet),
            Character::Error => None,
        };
        Ok(self.received.iter().filter_map(octet).collect())
    }

    fn forward(&mut self, from: usize, octets: &[u8]) -> Result<(), PortError> {
        let Some(pace) = &mut self.pace else { return self.send(from, octets) };
        for octet in octets {
            pace.free = pace.free.max(pace.clock.now()) + CHARACTER_TBIT;
            pace.queue.push_back((pace.free, from, *octet));
        }
        Ok(())
    }

    /// Delivers the octets that are due.
    fn deliver_due(&mut self) -> Result<(), PortError> {
        while let Some(pace) = &mut self.pace
            && let Some((_, from, octet)) = pace.queue.pop_front_if(|(end, ..)| *end <= pace.clock.now())
        {
            self.send(from, &[octet])?;
        }
        Ok(())
    }

    fn send(&mut self, from: usize, octets: &[u8]) -> Result<(), PortError> {
        for (number, port) in self.ports.iter_mut().enumerate() {
            if number != from && !octets.is_empty() {
                port.pty.send(octets)?;
                notices(|| port.pty.next_notice());
            }
        }
        Ok(())
    }
}

/// Inverts bits and drops octets, reproducibly by seed.
struct Noise {
    rng: Rng,
    flip: f64,
    drop: f64,
    passed: u64,
    flipped: u64,
    dropped: u64,
}

impl Noise {
    fn new(flip: f64, drop: f64, seed: u64) -> Self {
        Self { rng: Rng::with_seed(seed), flip, drop, passed: 0, flipped: 0, dropped: 0 }
    }

    /// Disturbs an octet. It always draws three numbers, so that one probability does not change the octets that the other affects.
    fn disturb(&mut self, octet: u8) -> Option<u8> {
        let (drop, flip, bit) = (self.rng.f64() < self.drop, self.rng.f64() < self.flip, self.rng.u8(..8));
        self.passed += 1;
        if drop {
            self.dropped += 1;
            return None;
        }
        self.flipped += u64::from(flip);
        Some(if flip { octet ^ (1 << bit) } else { octet })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn disturbed(flip: f64, drop: f64, seed: u64) -> Vec<Option<u8>> {
        let mut noise = Noise::new(flip, drop, seed);
        (0..=255).cycle().take(100_000).map(|octet| noise.disturb(octet)).collect()
    }

    #[test]
    fn the_same_seed_disturbs_the_same_octets() {
        assert_eq!(disturbed(0.01, 0.01, 7), disturbed(0.01, 0.01, 7));
        assert_ne!(disturbed(0.01, 0.01, 7), disturbed(0.01, 0.01, 8));
    }

    #[test]
    fn without_disturbances_every_octet_passes() {
        assert!(disturbed(0.0, 0.0, 7).into_iter().eq((0..=255).cycle().take(100_000).map(Some)));
    }

    #[test]
    fn disturbances_have_the_requested_frequency_and_invert_one_bit() {
        let (mut lost, mut flipped) = (0, 0);
        for (sent, received) in (0..=255_u8).cycle().zip(disturbed(0.02, 0.01, 7)) {
            match received {
                None => lost += 1,
                Some(received) if received != sent => {
                    assert_eq!((received ^ sent).count_ones(), 1);
                    flipped += 1;
                }
                Some(_) => {}
            }
        }
        assert!((900..1100).contains(&lost) && (1850..2150).contains(&flipped), "{lost} lost, {flipped} flipped");
    }
}
