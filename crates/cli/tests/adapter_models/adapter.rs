//! A serial adapter as a state machine without port and clock: a character in at a time, characters out at a later time.
//!
//! It has the documented behaviour of an adapter: the packets of its USB endpoint or the trigger of its FIFO, the time for which it
//! holds characters back, the USB frames, and lost characters. [`ModelPort`](crate::adapter_models::simulated::ModelPort) drives it in simulated time,
//! [`Relay`](crate::adapter_models::relay::Relay) in front of a pty.

use profivac_dp::link::{Baud, CHARACTER_TBIT};
use profivac_host::clock::duration_of;
use profivac_host::port::Delivery;
use std::collections::VecDeque;
use std::time::Duration;

/// A full-speed USB device transfers data in frames of this duration. USB 2.0, 5.2.3.
pub const FRAME: Duration = Duration::from_millis(1);

/// When an adapter gives received characters to the computer.
#[derive(Clone, Copy)]
pub enum Holding {
    /// A UART: when `trigger` characters are there, or four characters after the last one.
    Fifo { trigger: usize },
    /// USB: when a packet of this size is full, or `hold` after the first character of it; both in the next frame.
    Packets { size: usize, hold: Duration },
}

/// The received characters that an adapter loses.
#[derive(Clone, Copy)]
pub enum Loss {
    None,
    /// Every character with a number that this divides.
    Every(u64),
    /// One character, the first being 1.
    One(u64),
    /// All characters up to this one.
    UpTo(u64),
}

impl Loss {
    const fn contains(self, number: u64) -> bool {
        match self {
            Self::None => false,
            Self::Every(every) => number.is_multiple_of(every),
            Self::One(one) => number == one,
            Self::UpTo(last) => number <= last,
        }
    }
}

/// An adapter with its driver.
#[derive(Clone, Copy)]
pub struct Adapter {
    pub name: &'static str,
    pub holding: Holding,
    pub loses: Loss,
    /// What profivac knows from the driver.
    pub delivery: Delivery,
}

pub const fn usb(name: &'static str, size: usize, hold_ms: u64, delivery: Delivery) -> Adapter {
    let holding = Holding::Packets { size, hold: Duration::from_millis(hold_ms) };
    Adapter { name, holding, loses: Loss::None, delivery }
}

/// What profivac assumes about a driver without a latency timer.
pub const UNKNOWN: Delivery = Delivery::Usb { hold: Duration::from_millis(16), is_known: false };

/// What profivac knows about a driver with a latency timer.
pub const fn timer(ms: u64) -> Delivery {
    Delivery::Usb { hold: Duration::from_millis(ms), is_known: true }
}

/// The sizes of the packets are those of the bulk endpoints, less the two octets of status that an FT232 adds. The drivers of
/// CP210x, PL2303 and CH341 set no timer, so each has two rows: characters leave in the next frame, or as late as profivac
/// assumes.
pub const ADAPTERS: [Adapter; 11] = [
    Adapter {
        name: "16550A, `8250`, trigger 8",
        holding: Holding::Fifo { trigger: 8 },
        loses: Loss::None,
        delivery: Delivery::Fifo { trigger: Some(8) },
    },
    usb("FT232, `ftdi_sio`, latency 1 ms", 62, 1, timer(1)),
    usb("FT232, `ftdi_sio`, latency 16 ms", 62, 16, timer(16)),
    usb("CP210x, `cp210x`, each frame", 64, 0, UNKNOWN),
    usb("CP210x, `cp210x`, held for 16 ms", 64, 16, UNKNOWN),
    usb("PL2303, `pl2303`, each frame", 64, 0, UNKNOWN),
    usb("PL2303, `pl2303`, held for 16 ms", 64, 16, UNKNOWN),
    usb("CH341, `ch341`, each frame", 32, 0, UNKNOWN),
    usb("CH341, `ch341`, held for 16 ms", 32, 16, UNKNOWN),
    Adapter { loses: Loss::Every(500), ..usb("any USB adapter that loses one character of 500", 64, 1, UNKNOWN) },
    usb("any USB adapter that holds for 40 ms, longer than profivac assumes", 64, 40, UNKNOWN),
];

/// The state of an adapter on a line with a rate. All times are on one clock, which the caller chooses.
pub struct AdapterModel {
    adapter: Adapter,
    baud: Baud,
    /// Octets in the adapter and the times at which it received their last bit.
    held: VecDeque<(Duration, u8)>,
    /// Octets of the computer and the times at which their last bit has left.
    leaving: VecDeque<(Duration, u8)>,
    received: u64,
}

impl AdapterModel {
    pub const fn new(adapter: Adapter, baud: Baud) -> Self {
        Self { adapter, baud, held: VecDeque::new(), leaving: VecDeque::new(), received: 0 }
    }

    pub const fn adapter(&self) -> &Adapter {
        &self.adapter
    }

    /// The last bit of an octet came from the line `at` this time, not earlier than that of the octet before.
    pub fn receive(&mut self, at: Duration, octet: u8) {
        self.received += 1;
        if !self.adapter.loses.contains(self.received) {
            self.held.push_back((at, octet));
        }
    }

    /// When the adapter gives characters to the computer next.
    pub fn delivers_at(&self) -> Option<Duration> {
        let (first, last) = (self.held.front()?.0, self.held.back()?.0);
        let time = match self.adapter.holding {
            Holding::Fifo { trigger } if self.held.len() >= trigger => self.held.get(trigger - 1)?.0,
            Holding::Fifo { .. } => last + duration_of(self.baud, 4 * CHARACTER_TBIT),
            Holding::Packets { size, hold } => {
                let full = self.held.get(size - 1).map_or(Duration::MAX, |(time, _)| *time);
                full.min(first + hold)
            }
        };
        Some(self.next_frame(time))
    }

    /// The octets that the computer gets until `now`, one delivery.
    pub fn deliver(&mut self, now: Duration) -> Vec<u8> {
        let Some(time) = self.delivers_at().filter(|time| *time <= now) else { return Vec::new() };
        let arrived = self.held.iter().take_while(|(at, _)| *at <= time).count();
        let count = match self.adapter.holding {
            Holding::Fifo { .. } => arrived,
            Holding::Packets { size, .. } => arrived.min(size),
        };
        self.held.drain(..count).map(|(_, octet)| octet).collect()
    }

    /// The computer gives octets to the adapter `at` this time. They leave one after the other.
    pub fn send(&mut self, at: Duration, octets: &[u8]) {
        let mut end = self.leaving.back().map_or(Duration::ZERO, |(end, _)| *end).max(self.next_frame(at));
        for octet in octets {
            end += duration_of(self.baud, CHARACTER_TBIT);
            self.leaving.push_back((end, *octet));
        }
    }

    /// When the next octet has left, and when all of them have.
    pub fn leaves_at(&self) -> Option<(Duration, Duration)> {
        Some((self.leaving.front()?.0, self.leaving.back()?.0))
    }

    /// The next octet that has left until `now`, and when its last bit left.
    pub fn next_left(&mut self, now: Duration) -> Option<(Duration, u8)> {
        self.leaving.pop_front_if(|(end, _)| *end <= now)
    }

    /// The begin of the next USB frame; a UART has none.
    fn next_frame(&self, time: Duration) -> Duration {
        match self.adapter.holding {
            Holding::Fifo { .. } => time,
            Holding::Packets { .. } => {
                let frames = time.as_nanos().div_ceil(FRAME.as_nanos());
                Duration::from_nanos(u64::try_from(frames * FRAME.as_nanos()).unwrap())
            }
        }
    }
}

mod tests {
    use super::*;

    /// The times of the deliveries, in microseconds, and the octets of each, when `count` octets come without a pause.
    fn deliveries(adapter: Adapter, baud: Baud, count: u64) -> Vec<(u128, usize)> {
        let mut model = AdapterModel::new(adapter, baud);
        for number in 1..=count {
            model.receive(duration_of(baud, number * CHARACTER_TBIT), 0);
        }
        let next = |model: &mut AdapterModel| {
            let time = model.delivers_at()?;
            Some((time.as_micros(), model.deliver(time).len()))
        };
        std::iter::from_fn(|| next(&mut model)).collect()
    }

    /// At 19200 bit/s a character takes 573 microseconds.
    #[test]
    fn a_fifo_delivers_at_its_trigger_and_four_characters_after_the_last_one() {
        assert_eq!(deliveries(ADAPTERS[0], Baud::B19200, 19), [(4_583, 8), (9_166, 8), (13_177, 3)]);
    }

    /// At 500 kbit/s a character takes 22 microseconds.
    #[test]
    fn usb_delivers_full_packets_in_the_next_frame_and_the_rest_when_its_time_is_over() {
        let fast = |adapter| deliveries(adapter, Baud::B500000, 100);
        assert_eq!(fast(usb("FT232", 62, 16, timer(16))), [(2_000, 62), (18_000, 38)]);
        assert_eq!(
            fast(usb("CH341", 32, 0, UNKNOWN)),
            [(1_000, 32), (1_000, 13), (2_000, 32), (2_000, 13), (3_000, 10)]
        );
    }

    #[test]
    fn a_character_that_the_adapter_loses_is_in_no_delivery() {
        let lossy = Adapter { loses: Loss::Every(10), ..usb("lossy", 64, 0, UNKNOWN) };
        let sizes: usize = deliveries(lossy, Baud::B19200, 100).into_iter().map(|(_, size)| size).sum();
        assert_eq!(sizes, 90);
    }

    #[test]
    fn octets_leave_in_the_next_frame_one_after_the_other() {
        let mut model = AdapterModel::new(usb("FT232", 62, 1, timer(1)), Baud::B500000);
        model.send(Duration::from_micros(100), &[1, 2]);
        model.send(Duration::from_micros(1_010), &[3]);
        let left: Vec<_> = std::iter::from_fn(|| model.next_left(Duration::from_secs(1)))
            .map(|(at, octet)| (at.as_micros(), octet))
            .collect();
        assert_eq!(left, [(1_022, 1), (1_044, 2), (2_022, 3)]);
    }
}
