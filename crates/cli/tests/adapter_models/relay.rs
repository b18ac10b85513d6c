//! The model of an adapter between two ptys, in real time: a program on one of them, a virtual gauge on the other.

use crate::adapter_models::adapter::{Adapter, AdapterModel};
use profivac_dp::link::{Baud, CHARACTER_TBIT};
use profivac_host::clock::duration_of;
use profivac_host::port::{Character, Port, Pty};
use profivac_host::readiness::{WakeSource, Waker, wait, waker};
use std::collections::VecDeque;
use std::path::Path;
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

/// A thread that moves octets between the ptys as an adapter would. It ends when this is dropped.
pub struct Relay {
    stop: Option<Waker>,
    thread: Option<JoinHandle<usize>>,
}

impl Relay {
    /// `computer` becomes the port of a program, `line` that of a virtual gauge.
    pub fn start(adapter: Adapter, baud: Baud, computer: &Path, line: &Path) -> Self {
        let (stop, stopped) = waker().unwrap();
        let ends = Ends {
            model: AdapterModel::new(adapter, baud),
            baud,
            begin: Instant::now(),
            computer: Pty::create(computer).unwrap(),
            line: Pty::create(line).unwrap(),
            on_line: VecDeque::new(),
            deliveries: 0,
        };
        let thread = std::thread::spawn(move || ends.run(&stopped));
        Self { stop: Some(stop), thread: Some(thread) }
    }

    /// Ends the relay. Returns the number of deliveries to the program.
    pub fn end(mut self) -> usize {
        self.stop = None;
        self.thread.take().unwrap().join().unwrap()
    }
}

struct Ends {
    model: AdapterModel,
    baud: Baud,
    begin: Instant,
    computer: Pty,
    line: Pty,
    /// Octets of the gauge and the times at which their last bits reach the adapter.
    on_line: VecDeque<(Duration, u8)>,
    deliveries: usize,
}

impl Ends {
    /// Until the waker is dropped.
    fn run(mut self, stopped: &WakeSource) -> usize {
        loop {
            let due = self.due().map_or(Duration::MAX, |due| due.saturating_sub(self.begin.elapsed()));
            let sources: Vec<_> = [stopped.readiness()]
                .into_iter()
                .chain(self.computer.readiness())
                .chain(self.line.readiness())
                .collect();
            if wait(&sources, due).unwrap()[0] {
                return self.deliveries;
            }
            let now = self.begin.elapsed();
            let (request, answer) = (octets(&mut self.computer), octets(&mut self.line));
            self.model.send(now, &request);
            self.put_on_line(now, &answer);
            self.step(now);
        }
    }

    /// When something happens next.
    fn due(&self) -> Option<Duration> {
        let leaves = self.model.leaves_at().map(|(_, all)| all);
        let arrives = self.on_line.front().map(|(end, _)| *end);
        [leaves, arrives, self.model.delivers_at()].into_iter().flatten().min()
    }

    /// A pty gives an answer at once; on the line its octets come one after the other.
    fn put_on_line(&mut self, now: Duration, answer: &[u8]) {
        let mut end = self.on_line.back().map_or(Duration::ZERO, |(end, _)| *end).max(now);
        for octet in answer {
            end += duration_of(self.baud, CHARACTER_TBIT);
            self.on_line.push_back((end, *octet));
        }
    }

    fn step(&mut self, now: Duration) {
        // The gauge gets a telegram in one piece when its last octet has left: the time between two octets would be that of this thread.
        if self.model.leaves_at().is_some_and(|(_, all)| all <= now) {
            let left: Vec<u8> = std::iter::from_fn(|| self.model.next_left(now)).map(|(_, octet)| octet).collect();
            self.line.send(&left).unwrap();
        }
        // In the order of the times at which they happen, however late this thread is.
        loop {
            let arrives = self.on_line.front().map(|(end, _)| *end).filter(|end| *end <= now);
            let delivers = self.model.delivers_at().filter(|time| *time <= now);
            match (arrives, delivers) {
                (Some(arrives), delivers) if delivers.is_none_or(|delivers| arrives <= delivers) => {
                    let (end, octet) = self.on_line.pop_front().unwrap();
                    self.model.receive(end, octet);
                }
                (_, Some(delivers)) => {
                    let delivered = self.model.deliver(delivers);
                    self.deliveries += 1;
                    self.computer.send(&delivered).unwrap();
                }
                _ => return,
            }
        }
    }
}

impl Drop for Relay {
    fn drop(&mut self) {
        self.stop = None;
        self.thread.take().map(|thread| thread.join().ok());
    }
}

/// What a program has written to its pty.
fn octets(pty: &mut Pty) -> Vec<u8> {
    let mut characters = Vec::new();
    pty.receive(&mut characters).unwrap();
    let octet = |character| match character {
        Character::Octet(octet) => Some(octet),
        Character::Error => None,
    };
    characters.into_iter().filter_map(octet).collect()
}
