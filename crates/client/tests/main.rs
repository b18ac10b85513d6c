//! The tests of this crate in one program: linked once, and what they share is compiled once.

#[path = "support/changing_port.rs"]
mod changing_port;
#[path = "../../../tests/support/every_file.rs"]
mod every_file;
#[path = "../../../tests/support/golden.rs"]
mod golden;
#[allow(clippy::unwrap_used, reason = "a test")]
#[path = "support/late_line.rs"]
mod late_line;
#[path = "../../../tests/support/until.rs"]
mod until;

mod address;
mod cancelled;
mod device_pages;
mod drops;
mod gsd_files;
mod late;
mod lost;
mod malformed;
mod ranges;
mod selector;
mod structured_text;
mod typed;
mod unit;
mod watch;
