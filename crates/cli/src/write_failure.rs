//! A write that failed: whether the slave may have executed it.

use crate::failure::Failure;
use crate::output::{json, out};
use profivac_client::records::WriteEffect;
use serde::Serialize;

/// A write that failed, in the JSON output.
#[derive(Debug, Serialize)]
struct FailedChange<'a> {
    target: &'a str,
    /// `not-sent`, `refused`, `possibly-executed` or `executed`.
    effect: &'static str,
    error: String,
}

/// The failure of a command that has sent no write.
pub fn before_write(failure: Failure) -> Failure {
    if failure.is_interrupted() { Failure::interrupted_with("nothing was written") } else { failure }
}

/// Prints a write that failed as JSON.
pub fn print_failure(target: &str, effect: WriteEffect, failure: &Failure) {
    out(&json(&FailedChange { target, effect: effect.name(), error: failure.to_string() }));
}
