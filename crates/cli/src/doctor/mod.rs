//! `profivac doctor`: checks this computer, ports, lines and files, and says what to do next.

mod computer;
mod database;
mod file;
mod port;
mod slaves;
mod station;

use crate::device_files::DeviceFileOptions;
use crate::failure::Failure;
use crate::gsd_files;
use crate::gsd_slaves::GsdOptions;
use crate::output::{json, out};
use crate::values::{self, Rate};
use clap::Args;
use profivac_explain::gsd::Files;
use profivac_host::port::PortError;
use profivac_host::port::is_serial_port;
use serde::Serialize;
use std::path::Path;
use std::time::Duration;

/// Find out what is wrong with this computer, an adapter, a line or a file, and what to do next.
///
/// Without WHAT the command checks the computer and its serial devices, and opens none of them. A port (serial device, pty,
/// tcp://HOST:PORT, sim:FILE.toml) is opened and listened to; nothing is sent. A file may be the file of a station with everything it
/// names, a segment or scenario, settings of a gauge, the database of a station, recorded traffic, or a GSD file. With --gsd the traffic of
/// each slave is compared with its GSD file.
#[derive(Args, Debug)]
#[command(after_help = EXAMPLES)]
pub struct Arguments {
    /// Ports and files; none: this computer
    #[arg(value_name = "WHAT")]
    subjects: Vec<String>,
    /// Bits per second of a serial device; with auto, it listens at each rate until it receives a telegram
    #[arg(long, value_name = "RATE|auto", default_value = "auto", value_parser = values::rate)]
    baud: Rate,
    /// Listen to a port for this time
    #[arg(long = "for", value_name = "SECONDS", default_value = "3", value_parser = values::seconds)]
    time: Duration,
    #[command(flatten)]
    gsd: GsdOptions,
    #[command(flatten)]
    device_files: DeviceFileOptions,
    /// Print JSON
    #[arg(long)]
    json: bool,
}

const EXAMPLES: &str = "\
Examples:
  profivac doctor
  profivac doctor /dev/ttyUSB0
  profivac doctor /dev/ttyUSB0 --baud 93750 --for 30
  profivac doctor plant.toml plant.db capture.pcapng
  profivac doctor --gsd gsd/ capture.pcapng      # compares each slave with its GSD file: parameters, modules, diagnosis, rates

Exit codes: 0 no problem, 2 a problem in a file or argument, 3 a problem with a port or line. A note is not a problem.";

/// The weight of a finding.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
enum Verdict {
    /// As it should be.
    Good,
    /// It works, and the user should know.
    Note,
    /// A file or an argument is wrong.
    BadFile,
    /// A port or a line does not work.
    BadPort,
}

/// One sentence about a subject, and the next step.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
struct Finding {
    verdict: Verdict,
    found: String,
    /// What to do; `null` if nothing is to be done.
    next: Option<String>,
}

impl Finding {
    fn good(found: impl Into<String>) -> Self {
        Self { verdict: Verdict::Good, found: found.into(), next: None }
    }

    fn note(found: impl Into<String>, next: impl Into<String>) -> Self {
        Self { verdict: Verdict::Note, found: found.into(), next: Some(next.into()) }
    }

    fn bad_file(found: impl Into<String>, next: impl Into<String>) -> Self {
        Self { verdict: Verdict::BadFile, found: found.into(), next: Some(next.into()) }
    }

    fn bad_port(found: impl Into<String>, next: impl Into<String>) -> Self {
        Self { verdict: Verdict::BadPort, found: found.into(), next: Some(next.into()) }
    }
}

/// The findings about one subject.
#[derive(Debug, Serialize)]
struct Examination {
    /// The port or file; `computer` for this computer.
    subject: String,
    findings: Vec<Finding>,
}

/// Checks and prints.
pub fn run(arguments: &Arguments) -> Result<(), Failure> {
    let files = gsd_files::files(&arguments.gsd, &arguments.device_files)?;
    let mut examinations = Vec::new();
    if arguments.subjects.is_empty() {
        examinations.push(Examination { subject: "computer".to_owned(), findings: computer::check() });
        examinations.extend(computer::serial_devices().into_iter().map(|name| {
            let findings = port::check_unopened(&name);
            Examination { subject: name, findings }
        }));
    }
    for subject in &arguments.subjects {
        let findings = check(subject, arguments, &files);
        examinations.push(Examination { subject: subject.clone(), findings });
    }
    if arguments.json {
        out(&json(&examinations));
    } else {
        out(&text(&examinations));
    }
    outcome(&examinations)
}

/// Whether the name is one of a port; other names are files.
fn is_port(subject: &str) -> bool {
    subject.contains("://")
        || subject.starts_with("sim:")
        || subject.starts_with("usb:")
        || subject.starts_with("/dev/")
        || (cfg!(windows) && is_serial_port(subject))
        || is_device(Path::new(subject))
}

/// Whether a path is a device, or a link to one.
fn is_device(path: &Path) -> bool {
    #[cfg(unix)]
    {
        use std::os::unix::fs::FileTypeExt as _;
        path.metadata().is_ok_and(|metadata| metadata.file_type().is_char_device())
    }
    #[cfg(not(unix))]
    {
        let _ = path;
        false
    }
}

fn check(subject: &str, arguments: &Arguments, files: &Files) -> Vec<Finding> {
    match is_port(subject) {
        true => port::check(subject, arguments.baud, arguments.time, files),
        false => file::check(Path::new(subject), files),
    }
}

fn text(examinations: &[Examination]) -> String {
    let mut lines = Vec::new();
    for Examination { subject, findings } in examinations {
        lines.push(subject.clone());
        for Finding { verdict, found, next } in findings {
            let word = match verdict {
                Verdict::Good => "ok",
                Verdict::Note => "note",
                Verdict::BadFile | Verdict::BadPort => "problem",
            };
            lines.push(format!("  {word:<8} {}", found));
            lines.extend(next.iter().map(|next| format!("  {:<8} next: {next}", "")));
        }
    }
    lines.join("\n")
}

/// The exit code of the first problem. Its sentence stands in the list already.
fn outcome(examinations: &[Examination]) -> Result<(), Failure> {
    let verdicts = examinations.iter().flat_map(|it| &it.findings).map(|finding| finding.verdict);
    match verdicts.into_iter().find(|verdict| matches!(verdict, Verdict::BadFile | Verdict::BadPort)) {
        None | Some(Verdict::Good | Verdict::Note) => Ok(()),
        Some(Verdict::BadFile) => Err(Failure::quiet_usage()),
        Some(Verdict::BadPort) => Err(Failure::quiet()),
    }
}

/// The finding about a port that cannot be used.
fn unusable(error: &PortError) -> Finding {
    let next = match (error, error.remedy()) {
        (PortError::NotFound(_), Some(remedy)) => format!("{remedy}; {}", computer::present_devices()),
        (_, Some(remedy)) => remedy.to_owned(),
        (PortError::Lost(_), None) => "plug it in again, or start the program that serves it".to_owned(),
        (PortError::UnsupportedCharacter { .. }, None) => "use another adapter; see docs/adapters.md".to_owned(),
        (PortError::File(_), None) => "correct the file, or see docs/scenarios.md".to_owned(),
        (PortError::System { .. }, None) => "see docs/adapters.md".to_owned(),
        (_, None) => "correct the name of the port; docs/adapters.md lists what is possible".to_owned(),
    };
    Finding::bad_port(error.found(), next)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn exit_code(findings: Vec<Finding>) -> Option<bool> {
        let examination = Examination { subject: String::new(), findings };
        outcome(&[examination]).err().map(|failure| failure.is_port())
    }

    #[test]
    fn only_problems_end_with_a_failure_and_the_first_one_decides() {
        let (good, note) = (Finding::good("a"), Finding::note("b", "c"));
        assert_eq!(exit_code(vec![good.clone(), note.clone()]), None);
        let (file, port) = (Finding::bad_file("d", "e"), Finding::bad_port("f", "g"));
        assert_eq!(exit_code(vec![note, file.clone(), port.clone()]), Some(false));
        assert_eq!(exit_code(vec![port, file]), Some(true));
    }

    #[test]
    fn a_colon_in_an_error_does_not_divide_it() {
        let finding = unusable(&PortError::InvalidAddress("x".to_owned()));
        assert_eq!(finding.found, "expected HOST:PORT, got \"x\" (an IPv6 address in brackets: [::1]:4000)");
        assert!(finding.next.unwrap().starts_with("correct the name of the port"));
        let source = std::io::Error::other("no route");
        let finding = unusable(&PortError::UnresolvedHost { name: "tcp://x:1".to_owned(), source });
        assert_eq!(finding.found, "tcp://x:1: the name of the host cannot be resolved: no route");
    }

    #[test]
    fn a_next_step_stands_below_its_finding() {
        let findings = vec![Finding::good("it runs"), Finding::note("it is slow", "wait")];
        let text = text(&[Examination { subject: "computer".to_owned(), findings }]);
        assert_eq!(text, "computer\n  ok       it runs\n  note     it is slow\n           next: wait");
    }
}
