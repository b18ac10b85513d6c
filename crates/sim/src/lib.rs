//! A PROFIBUS segment in bit times: stations on a cable, a referee, faults, traces.
//!
//! The same state machines that run on a serial port or a microcontroller ([`Station`](profivac_dp::link::Station)) run
//! here, and time is as exact as content: every character is timed by itself, signals take time along the cable, and a
//! [referee](Rule) ends the run with the trace around it when a station talks over another, begins too early or answers too
//! late. Nothing depends on a clock or on chance without a seed, so a run can be repeated bit by bit.
//!
//! ```
//! use profivac_dp::link::{Baud, BitTime};
//! use profivac_sim::stations::{Puppet, Tester};
//! use profivac_sim::Bus;
//!
//! let mut bus = Bus::new(Baud::B1500000);
//! // One station asks, the other answers everything with SC, one bit time too early.
//! let tester = bus.attach(Tester::new());
//! bus.attach_at(3, Puppet::new(|end, _| Some((end + 10, vec![0xE5]))));
//! bus.station_mut(tester).send(BitTime(100), &[0x10, 8, 2, 0x49, 0x53, 0x16]);
//!
//! let foul = bus.run_until(BitTime(1000)).unwrap_err();
//! let told = foul.to_string();
//! assert!(told.starts_with("bit time 179, station #1: it answered after 10 bit times, min T_SDR is 11"));
//! assert!(told.contains("2 -> 8    FDL_Status ?"));
//! ```
//!
//! | Part | Does |
//! |---|---|
//! | [`Bus`] | lets time pass from event to event; takes stations and gives them back |
//! | [`Rule`], [`Foul`], [`Limits`] | what the referee looks at, what it found, the bus parameters it judges by |
//! | [`Fault`], [`Tamper`], [`Noise`], [`Mangle`] | flipped bits, lost and added octets, a cut cable, an echo, no power |
//! | [`stations`] | a tester, a puppet for wrong behaviour, a babbler |
//! | [`scenario`] | tests as a dialogue |
//! | [`Trace`], [`trace::pcapng`] | what was on the line: as text, as a capture file, and back |
//! | [`describe`] | telegrams in the words of the field |
//! | [`character`] | the eleven bits of a character and the receiver for them |
//!
//! A new kind of station implements `Station` and is attached; a new rule is a line of [`Rule`] and one in the referee, with
//! a test in `tests/referee.rs` in which it finds something; a new fault is a line of [`Fault`].

pub mod character;
pub mod describe;
mod driver;
mod fault;
mod noise;
mod random;
mod referee;
pub mod scenario;
mod scheduler;
mod segment;
mod signal;
pub mod stations;
mod tap;
mod token;
pub mod trace;

pub use fault::{Fault, OctetErrors};
pub use noise::Noise;
pub use random::Random;
pub use referee::{Limits, Rule, Violation};
pub use segment::{Segment, StationHandle, StationId};
pub use signal::TelegramFault;
pub use trace::Trace;
