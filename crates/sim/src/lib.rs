//! A simulated PROFIBUS segment in bit times: stations on a cable, a referee, faults, traces.
//!
//! The state machines are those of a serial port or a microcontroller ([`Station`](profivac_dp::link::Station)). Each
//! character has its own time, and signals take time along the cable. A [referee](Rule) checks every transmission: if a
//! station sends while another does, begins too early or answers too late, the run ends with an error that shows the trace.
//! The simulation uses no clock, and random events come from a seed, so each run can be repeated exactly.
//!
//! ```
//! use profivac_dp::link::{Baud, BitTime};
//! use profivac_sim::stations::{MockStation, Tester};
//! use profivac_sim::Segment;
//!
//! let mut segment = Segment::new(Baud::B1500000);
//! // One station sends a request; the other answers each telegram with SC, one bit time too early.
//! let tester = segment.attach(Tester::new());
//! segment.attach_at(3, MockStation::new(|end, _| Some((end + 10, vec![0xE5]))));
//! segment.station_mut(tester).send(BitTime(100), &[0x10, 8, 2, 0x49, 0x53, 0x16]);
//!
//! let violation = segment.run_until(BitTime(1000)).unwrap_err();
//! let report = violation.to_string();
//! assert!(report.starts_with("bit time 179, station #1: it answered after 10 bit times, min T_SDR is 11"));
//! assert!(report.contains("2 -> 8    FDL_Status ?"));
//! ```
//!
//! | Part | Does |
//! |---|---|
//! | [`Segment`] | stations on a cable; advances time from event to event |
//! | [`Rule`], [`Violation`], [`Limits`] | the rules of the referee, a violation, the limits from the bus parameters |
//! | [`Fault`], [`TelegramFault`], [`Noise`], [`OctetErrors`] | inverted bits, lost and inserted octets, a cut cable, an echo, no power |
//! | [`stations`] | a tester, a mock station for wrong behaviour, a babbling station |
//! | [`dialogue`] | scripted dialogues for tests |
//! | [`Trace`], [`trace::pcapng`] | the telegrams of the line: as text, as a capture file, and back |
//! | [`describe`] | telegrams in English |
//! | [`character`] | characters of eleven bits and their receiver |
//!
//! To add a kind of station, implement `Station`. To add a rule, add a variant to [`Rule`], its check to the referee, and a
//! test in `tests/referee.rs` that violates it. To add a fault, add a variant to [`Fault`].

pub mod character;
pub mod describe;
pub mod dialogue;
mod driver;
mod fault;
mod listeners;
mod noise;
mod random;
mod referee;
mod rule;
mod scheduler;
mod segment;
mod signal;
mod station_id;
pub mod stations;
mod tap;
mod token;
pub mod trace;

pub use fault::{Fault, OctetErrors};
pub use noise::Noise;
pub use random::Random;
pub use referee::Limits;
pub use rule::{Rule, Violation};
pub use segment::Segment;
pub use signal::TelegramFault;
pub use station_id::{StationHandle, StationId};
pub use trace::Trace;

/// The example of the README runs as a test.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
