//! When the characters that a line carries reach the program: facts of the port and its driver.
//!
//! Between the last bit of a character and the program are a FIFO or a USB adapter, which hold characters back and then
//! deliver several at once. A receiver on such a port tolerates the pauses that this puts between the characters of a
//! telegram, and a master on it waits longer for an answer.

use crate::clock::{duration_of, tbit_of};
use profivac_dp::link::{Baud, CHARACTER_TBIT, T_SYN_TBIT};
use std::fmt;
use std::time::Duration;

/// The time by which the operating system may run a program too late. chosen: longer than the usual delays of a
/// computer that is not overloaded.
pub const SCHEDULING_DELAY: Duration = Duration::from_millis(2);

/// The interval at which a full-speed USB device may transfer data: a frame. USB 2.0, 5.2.3.
const USB_FRAME: Duration = Duration::from_millis(1);

/// The characters after which a UART delivers what its FIFO holds. Datasheet of the 16550D: FIFO timeout interrupt.
const FIFO_TIMEOUT_CHARACTERS: u64 = 4;

/// The highest trigger level of a 16550A, for a driver that does not report it. Datasheet of the 16550D: FIFO control register.
const HIGHEST_TRIGGER: u8 = 14;

/// The reserve of a master for a loaded computer. A longer slot time costs time for absent stations only. chosen.
const LOAD_RESERVE: Duration = Duration::from_millis(10);

/// The delay that is added to the slot time where nothing is known about the port. chosen: a serial server, or another
/// program on a loaded computer.
const UNKNOWN_DELAY: Duration = Duration::from_millis(20);

/// The longest setting of the latency timer of a USB adapter. profibus-wire 9.4, point 36.
const LONGEST_LATENCY: Duration = Duration::from_millis(255);

/// How a port delivers received characters.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[non_exhaustive]
pub enum Delivery {
    /// As soon as they are sent, at no rate: a pty, TCP, a segment in memory. Nothing is known about the delay.
    #[default]
    Unpaced,
    /// By a UART with a FIFO: when it holds `trigger` characters, or four characters after the last one.
    Fifo {
        /// The number of characters, if the driver reports it.
        trigger: Option<u8>,
    },
    /// By a USB adapter, which collects characters for as long as `hold`.
    Usb {
        /// The longest time for which the adapter keeps a character.
        hold: Duration,
        /// Whether `hold` is the setting of the adapter or an assumption.
        is_known: bool,
    },
}

impl Delivery {
    /// Whether the port sends and receives at a baud rate.
    #[must_use]
    pub const fn is_timed(self) -> bool {
        !matches!(self, Self::Unpaced)
    }

    /// The longest time from the last bit of a character to its delivery.
    #[must_use]
    pub fn delay(self, baud: Baud) -> Duration {
        let held = match self {
            Self::Unpaced => Duration::ZERO,
            // A trigger of one or two characters delivers earlier, but not the last characters of a telegram in general.
            Self::Fifo { .. } => duration_of(baud, FIFO_TIMEOUT_CHARACTERS.saturating_mul(CHARACTER_TBIT)),
            Self::Usb { hold, .. } => hold.saturating_add(USB_FRAME),
        };
        held.saturating_add(SCHEDULING_DELAY)
    }

    /// The silence after which the line counts as idle, and the longest tolerated pause within a telegram, in bit times.
    #[must_use]
    pub fn idle_tbit(self, baud: Baud) -> u64 {
        tbit_of(baud, self.delay(baud)).max(T_SYN_TBIT)
    }

    /// The longest pause within a telegram that a master tolerates after it has measured such a pause. Behind a port without a rate may
    /// be a serial server, whose adapter makes pauses; they are tolerated up to what the slot time contains for such a port.
    #[must_use]
    pub const fn max_pause(self) -> Duration {
        match self {
            Self::Unpaced => UNKNOWN_DELAY,
            Self::Fifo { .. } | Self::Usb { .. } => LONGEST_LATENCY,
        }
    }

    /// The time that a master on this port adds to the slot time: its request leaves late, the answer is delivered late, and
    /// the computer may be loaded.
    #[must_use]
    pub fn slot_delay(self, baud: Baud) -> Duration {
        match self {
            Self::Unpaced => UNKNOWN_DELAY,
            Self::Fifo { .. } | Self::Usb { .. } => {
                self.collecting(baud).saturating_add(self.turnaround(baud)).saturating_add(LOAD_RESERVE)
            }
        }
    }

    /// The longest time from the moment at which a telegram should leave to the delivery of one that follows at once.
    fn turnaround(self, baud: Baud) -> Duration {
        let leaves = match self {
            Self::Unpaced | Self::Fifo { .. } => SCHEDULING_DELAY,
            Self::Usb { .. } => SCHEDULING_DELAY.saturating_add(USB_FRAME),
        };
        leaves.saturating_add(self.delay(baud))
    }

    /// The longest time by which the characters behind it delay the first character of an answer: a telegram that does not
    /// reach the trigger of a FIFO is delivered when it is complete. The characters of USB have a time limit, see
    /// [`delay`](Self::delay).
    fn collecting(self, baud: Baud) -> Duration {
        match self {
            Self::Unpaced | Self::Usb { .. } => Duration::ZERO,
            Self::Fifo { trigger } => {
                let behind = u64::from(trigger.unwrap_or(HIGHEST_TRIGGER)).saturating_sub(2);
                duration_of(baud, behind.saturating_mul(CHARACTER_TBIT))
            }
        }
    }

    /// The longest time from the end of a request to the delivery of the first characters of its answer, in bit times, without a
    /// reserve for load. `None` for a port without a rate.
    #[must_use]
    pub fn answer_tbit(self, baud: Baud, max_tsdr_tbit: u64) -> Option<u64> {
        let collecting = whole_tbit(baud, self.collecting(baud));
        self.master_slot_tbit(baud, max_tsdr_tbit).map(|tbit| tbit.saturating_add(collecting))
    }

    /// The slot time that a foreign master needs to hear a slave on this port, in bit times. `None` for a port without a
    /// rate.
    #[must_use]
    pub fn master_slot_tbit(self, baud: Baud, max_tsdr_tbit: u64) -> Option<u64> {
        let delay = self.is_timed().then(|| whole_tbit(baud, self.turnaround(baud)))?;
        // The slot time ends with the first character of the answer.
        Some(max_tsdr_tbit.saturating_add(delay).saturating_add(CHARACTER_TBIT))
    }
}

/// The bit times that contain `time`: the last one counts even if `time` ends within it.
fn whole_tbit(baud: Baud, time: Duration) -> u64 {
    let tbit = tbit_of(baud, time);
    if duration_of(baud, tbit) < time { tbit.saturating_add(1) } else { tbit }
}

impl fmt::Display for Delivery {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Unpaced => f.write_str("no baud rate"),
            Self::Fifo { trigger: Some(1) } => f.write_str("a UART that delivers each character"),
            Self::Fifo { trigger: Some(trigger) } => {
                write!(f, "a UART whose FIFO delivers {trigger} characters at once")
            }
            Self::Fifo { trigger: None } => f.write_str("a UART"),
            Self::Usb { hold, is_known: true } => {
                write!(f, "a USB adapter that collects characters for {} ms", hold.as_millis())
            }
            Self::Usb { hold, is_known: false } => write!(
                f,
                "a USB adapter whose driver does not tell how long it collects characters; {} ms are assumed",
                hold.as_millis()
            ),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::session::MAX_SLOT_TBIT;

    const FTDI: Delivery = Delivery::Usb { hold: Duration::from_millis(16), is_known: true };
    const FIFO: Delivery = Delivery::Fifo { trigger: Some(8) };

    /// A telegram of 17 characters on a 16550A with trigger 8: 8, 8, and one four characters later.
    #[test]
    fn the_last_characters_of_a_telegram_may_wait_for_the_timeout_of_the_fifo() {
        for baud in [Baud::B9600, Baud::B19200, Baud::B45450, Baud::B93750] {
            let pause = FIFO_TIMEOUT_CHARACTERS * CHARACTER_TBIT;
            assert!(FIFO.idle_tbit(baud) >= pause, "{} at {baud}", FIFO.idle_tbit(baud));
        }
    }

    #[test]
    fn packets_of_a_usb_adapter_may_be_its_latency_and_a_frame_apart() {
        for baud in [Baud::B19200, Baud::B187500, Baud::B1500000] {
            assert!(FTDI.idle_tbit(baud) >= tbit_of(baud, Duration::from_millis(17)), "at {baud}");
        }
    }

    #[test]
    fn a_port_without_a_rate_keeps_the_strict_rule_as_far_as_it_can_measure() {
        assert_eq!(Delivery::Unpaced.idle_tbit(Baud::B9600), T_SYN_TBIT);
        assert_eq!(Delivery::Unpaced.idle_tbit(Baud::B93750), tbit_of(Baud::B93750, SCHEDULING_DELAY));
    }

    #[test]
    fn a_fifo_is_described_in_words_for_one_character_and_for_several() {
        let words = |trigger| Delivery::Fifo { trigger: Some(trigger) }.to_string();
        assert_eq!(words(1), "a UART that delivers each character");
        assert_eq!(words(8), "a UART whose FIFO delivers 8 characters at once");
    }

    /// FDL status has six characters, fewer than a trigger of 8 or 14: the first one waits for the other five and the timeout.
    #[test]
    fn a_master_waits_for_a_short_answer_that_stays_in_the_fifo_until_its_end() {
        for (trigger, behind) in [(Some(1), 0), (Some(4), 2), (Some(8), 6), (Some(14), 12), (None, 12)] {
            let fifo = Delivery::Fifo { trigger };
            for baud in [Baud::B9600, Baud::B19200] {
                let held = duration_of(baud, (behind + FIFO_TIMEOUT_CHARACTERS) * CHARACTER_TBIT);
                let needed = held + SCHEDULING_DELAY + SCHEDULING_DELAY + LOAD_RESERVE;
                let (needed, waits) = (tbit_of(baud, needed), tbit_of(baud, fifo.slot_delay(baud)));
                // Each duration is rounded to nanoseconds.
                assert!(waits.abs_diff(needed) <= 1, "{trigger:?} at {baud}: {waits}, {needed}");
            }
        }
        // 60 bit times, one character, 6 + 4 characters, 4 ms of 38.4 bit times.
        assert_eq!(FIFO.answer_tbit(Baud::B9600, 60), Some(60 + 11 + 66 + 44 + 39));
        assert_eq!(Delivery::Unpaced.answer_tbit(Baud::B9600, 60), None);
    }

    #[test]
    fn a_master_waits_for_what_the_port_delays() {
        assert_eq!(FTDI.slot_delay(Baud::B19200), Duration::from_millis(2 + 1 + 16 + 1 + 2 + 10));
        assert_eq!(Delivery::Unpaced.slot_delay(Baud::B19200), UNKNOWN_DELAY);
        assert_eq!(Delivery::Unpaced.master_slot_tbit(Baud::B19200, 60), None);
        // 7 ms are 134.4 bit times.
        let fast = Delivery::Usb { hold: Duration::from_millis(1), is_known: true };
        assert_eq!(fast.master_slot_tbit(Baud::B19200, 60), Some(60 + 135 + 11));
        assert_eq!(fast.master_slot_tbit(Baud::B500000, 60), Some(60 + 3500 + 11));
        assert_eq!(FTDI.master_slot_tbit(Baud::B19200, 60), Some(60 + 423 + 11));
    }

    #[test]
    fn the_table_of_the_page_about_plcs_has_the_slot_time_of_each_port_at_each_rate() {
        let page = include_str!("../../../../docs/plc.md");
        let usb = |ms| Delivery::Usb { hold: Duration::from_millis(ms), is_known: true };
        let ports = [Delivery::Fifo { trigger: None }, usb(1), usb(2), usb(16)];
        let row = |baud: Baud| {
            let cells = ports.map(|port| {
                let tbit = port.master_slot_tbit(baud, baud.max_tsdr_tbit().into()).unwrap();
                let ms = tbit as f64 * 1e3 / f64::from(baud.bits_per_second());
                if tbit > u64::from(MAX_SLOT_TBIT) { "not possible".to_owned() } else { format!("{tbit} ({ms:.1} ms)") }
            });
            format!("| {} | {} |", baud.bits_per_second(), cells.join(" | "))
        };
        let (possible, impossible): (Vec<_>, Vec<_>) =
            Baud::ALL.map(row).into_iter().partition(|row| row.contains("ms"));
        let begin = page.find("| bit/s | UART with a FIFO |").unwrap();
        let rows: Vec<_> = page[begin..].lines().skip(2).take_while(|line| line.starts_with('|')).collect();
        assert_eq!(rows, possible);
        assert_eq!(impossible.len(), 2, "6 and 12 Mbit/s: {impossible:?}");
        assert_eq!(
            Delivery::Usb { hold: Duration::from_millis(16), is_known: false }.slot_delay(Baud::B9600),
            usb(16).slot_delay(Baud::B9600)
        );
    }
}
