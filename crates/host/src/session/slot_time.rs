//! The times that a session measured, and the slot time that follows from them.

use super::{BusSession, MAX_SLOT_TBIT};
use crate::clock::duration_of;
use crate::port::{LateAnswerRemedy, Notice};
use std::fmt;
use std::time::Duration;

/// The longest times that a session measured, beside those that it works with.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct SessionTiming {
    /// The answers that were measured.
    pub answers: u64,
    /// From the end of a request to the delivery of the first characters of its answer.
    pub turnaround: Duration,
    /// The slot time.
    pub slot_time: Duration,
    /// Between two deliveries of characters of one answer.
    pub pause: Duration,
    /// The longest pause that is tolerated within a telegram.
    pub tolerated_pause: Duration,
}

impl fmt::Display for SessionTiming {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let ms = |time: Duration| time.as_secs_f64() * 1e3;
        write!(
            f,
            "measured on {} answers: the first characters came up to {:.1} ms after the request (slot time {:.1} ms), with pauses up \
             to {:.1} ms within an answer (up to {:.1} ms are tolerated)",
            self.answers,
            ms(self.turnaround),
            ms(self.slot_time),
            ms(self.pause),
            ms(self.tolerated_pause)
        )
    }
}

impl BusSession {
    /// What the session has measured so far.
    pub fn timing(&mut self) -> SessionTiming {
        let (baud, measured) = (self.baud, self.segment.measured());
        let slot_tbit = self.station().bus().slot_tbit.into();
        SessionTiming {
            answers: measured.answers,
            turnaround: duration_of(baud, measured.turnaround_tbit),
            slot_time: duration_of(baud, slot_tbit),
            pause: duration_of(baud, measured.pause_tbit),
            tolerated_pause: duration_of(baud, self.segment.idle_tbit()),
        }
    }

    /// Raises the slot time if an answer came later, and this master is alone. Beside other masters the notice says what the user
    /// has to do.
    pub(super) fn check_turnaround(&mut self) {
        let turnaround_tbit = self.segment.measured().turnaround_tbit;
        let slot_tbit = self.station().bus().slot_tbit;
        if turnaround_tbit <= u64::from(slot_tbit).max(self.reported_tbit) {
            return;
        }
        let (baud, adapts, name) = (self.baud, self.adapts_slot_time, self.port_name().to_owned());
        self.reported_tbit = turnaround_tbit;
        let station = self.station();
        let is_alone = station.masters().count() < 2 && station.other_master().is_none();
        let wanted_tbit = u32::try_from(turnaround_tbit.saturating_mul(2)).unwrap_or(u32::MAX);
        let needed_tbit = wanted_tbit.min(MAX_SLOT_TBIT);
        let remedy = match adapts && is_alone {
            _ if turnaround_tbit > needed_tbit.into() => LateAnswerRemedy::Impossible,
            true => LateAnswerRemedy::Raised,
            false => LateAnswerRemedy::ToBeSet,
        };
        if remedy == LateAnswerRemedy::Raised {
            station.raise_slot_time(needed_tbit);
        }
        // On a pty or TCP the cause is the load of the computer, which needs no action.
        if remedy == LateAnswerRemedy::Raised && !self.segment.port().is_timed() {
            return;
        }
        let turnaround_ms = u64::try_from(duration_of(baud, turnaround_tbit).as_millis()).unwrap_or(u64::MAX);
        self.late_answer = Some(Notice::LateAnswer { name, turnaround_ms, slot_tbit, needed_tbit, remedy });
    }
}
