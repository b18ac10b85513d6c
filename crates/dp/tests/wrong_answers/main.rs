//! A wrong answer of any kind never becomes a value, and the error says why. profibus-wire 1.3, 1.5, 2.2 and 2.8.
//!
//! For every request of a class 1 master and every raw request, a table of answers with one defect each. All of them carry
//! values that differ from those that the master has. [`Case::takes_the_right_answer`] shows for every kind that
//! the same answer without the defect is taken, so the master refuses the answer because of the defect alone.
//!
//! | Module | Defect |
//! |---|---|
//! | [`case`] | nothing: the requests, their right answers, and the checks after a wrong one |
//! | [`fields`] | addresses, access points, function code, length |
//! | [`damage`] | silence, the former answer, cut and altered octets |
//! | [`untimely`] | answers that come late, and second answers |
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic, reason = "helpers of tests are tests")]

mod case;
mod damage;
mod fields;
mod untimely;
