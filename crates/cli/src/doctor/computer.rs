//! This computer: its serial devices, programs that disturb them, the delay with which it runs programs, its clock.

use super::Finding;
use profivac_host::port::{AdapterFacts, SCHEDULING_DELAY, adapter_facts};
use std::fs;
use std::path::Path;
use std::thread::sleep;
use std::time::{Duration, Instant, SystemTime};

/// Programs that open a new serial device and send to it or take octets away, and what to do about them.
const DISTURBING: [(&str, &str, &str); 2] = [
    (
        "ModemManager",
        "it sends to each new serial device",
        "run `sudo systemctl disable --now ModemManager` if no modem is used",
    ),
    (
        "brltty",
        "it takes adapters with a CH340 or CP210x",
        "run `sudo apt-get remove brltty` if no Braille display is used",
    ),
];

/// The waits by which the delay of the computer is measured, and their length.
const WAITS: u32 = 200;
const WAIT: Duration = Duration::from_millis(1);

/// A clock before this time was not set: 2024-01-01. chosen.
const EARLIEST: Duration = Duration::from_secs(1_704_067_200);

/// The findings about the computer, without its serial devices.
pub fn check() -> Vec<Finding> {
    let mut findings = vec![punctuality(longest_delay()), clock()];
    let running = programs();
    findings.extend(
        DISTURBING
            .iter()
            .filter(|(name, ..)| running.iter().any(|it| it == name))
            .map(|(name, effect, next)| Finding::note(format!("{name} runs: {effect}"), *next)),
    );
    let devices = serial_devices();
    findings.push(match devices.len() {
        0 => Finding::note(
            "there is no serial device",
            "plug in an adapter; without hardware: `profivac demo`, or `profivac simulate --pty /tmp/line bcg450@5`",
        ),
        count => Finding::good(format!("serial devices: {count}")),
    });
    findings
}

/// The longest time by which this program was run too late.
fn longest_delay() -> Duration {
    let delay = |_| {
        let begun = Instant::now();
        sleep(WAIT);
        begun.elapsed().saturating_sub(WAIT)
    };
    (0..WAITS).map(delay).max().unwrap_or_default()
}

fn punctuality(longest: Duration) -> Finding {
    let measured = format!(
        "the computer runs this program at most {:.1} ms late ({WAITS} waits of {} ms)",
        longest.as_secs_f64() * 1e3,
        WAIT.as_millis()
    );
    match longest <= SCHEDULING_DELAY {
        true => Finding::good(measured),
        false => Finding::note(
            format!("{measured}; {} ms are assumed", SCHEDULING_DELAY.as_millis()),
            "end other programs, or give a bus command a longer --slot-time; --verbose shows the delays of a line",
        ),
    }
}

fn clock() -> Finding {
    let since_1970 = SystemTime::now().duration_since(SystemTime::UNIX_EPOCH).unwrap_or_default();
    match since_1970 >= EARLIEST {
        true => Finding::good("the clock is set"),
        false => Finding::bad_file(
            "the clock shows a year before 2024, and samples would have wrong times",
            "set it, for instance with `sudo timedatectl set-ntp true`",
        ),
    }
}

/// The names of all programs that run.
fn programs() -> Vec<String> {
    let processes = fs::read_dir("/proc").into_iter().flatten().flatten();
    let name = |folder: &Path| fs::read_to_string(folder.join("comm")).ok();
    processes.filter_map(|process| Some(name(&process.path())?.trim().to_owned())).collect()
}

/// The serial ports of Windows.
#[cfg(windows)]
pub fn serial_devices() -> Vec<String> {
    profivac_host::port::list::serial_ports().into_iter().map(|port| port.name).collect()
}

/// The paths of the serial devices that have hardware.
#[cfg(not(windows))]
pub fn serial_devices() -> Vec<String> {
    let terminals = fs::read_dir("/sys/class/tty").into_iter().flatten().flatten();
    let has_hardware = |folder: &Path| {
        // A UART that the kernel only supposes has type 0.
        let kind = fs::read_to_string(folder.join("type")).unwrap_or_default();
        folder.join("device/driver").exists() && kind.trim() != "0"
    };
    let devices = terminals.filter(|terminal| has_hardware(&terminal.path()));
    let mut names: Vec<_> =
        devices.map(|terminal| format!("/dev/{}", terminal.file_name().to_string_lossy())).collect();
    names.retain(|name| Path::new(name).exists());
    names.sort();
    names
}

/// The serial devices, for a user who has named another one.
pub fn present_devices() -> String {
    let described = |name: String| match adapter_facts(&name) {
        AdapterFacts { driver: Some(driver), .. } => format!("{name} ({driver})"),
        AdapterFacts { usb_id: Some(id), .. } => format!("{name} (USB {id})"),
        _ => name,
    };
    let devices: Vec<_> = serial_devices().into_iter().map(described).collect();
    match devices.as_slice() {
        [] => "this computer has no serial device".to_owned(),
        devices => format!("this computer has {}", devices.join(", ")),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::doctor::Verdict;

    #[test]
    fn a_computer_that_is_later_than_assumed_is_noted() {
        assert_eq!(punctuality(SCHEDULING_DELAY).verdict, Verdict::Good);
        let late = punctuality(SCHEDULING_DELAY + Duration::from_micros(100));
        assert_eq!(late.verdict, Verdict::Note);
        assert!(late.found.contains("2.1 ms late") && late.found.contains("2 ms are assumed"), "{}", late.found);
    }
}
