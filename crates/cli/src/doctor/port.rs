//! A port and the line behind it. Nothing is sent.

use super::{Finding, slaves, unusable};
use crate::advice::NO_TELEGRAM;
use crate::failure::Failure;
use crate::values::Rate;
use profivac_dp::link::Baud;
use profivac_explain::divider::Divider;
use profivac_explain::frame::TimeSource;
use profivac_explain::gsd::Files;
use profivac_explain::tap::{Tap, TapEvent};
use profivac_host::port::{self, Notice, Port, PortError, adapter_facts, check_access, delivery_of, open_elsewhere};
use profivac_host::rate;
use profivac_listen::Observer;
use profivac_listen::report::BusReport;
use profivac_listen::station::StationState;
use profivac_virtual::open;
use std::time::{Duration, Instant};

/// The share of damaged pieces, in percent, above which a line is called disturbed. chosen: a good line has none.
const DISTURBED_PERCENT: f64 = 0.1;

/// The rate of a port without one, and of a line on which no telegram was received.
const ANY_RATE: Baud = Baud::B19200;

/// The findings about a serial device that is not opened.
pub fn check_unopened(name: &str) -> Vec<Finding> {
    let mut findings = vec![hardware(name)];
    let driver = adapter_facts(name).driver.unwrap_or_default();
    let command_line = std::fs::read_to_string("/proc/cmdline").unwrap_or_default();
    findings.extend(unsuitable(name, &driver, &command_line));
    findings.push(match check_access(name) {
        Ok(()) => Finding::good(format!("you may open it; `profivac doctor {name}` listens to its line")),
        Err(missing @ PortError::NotFound(_)) => return vec![unusable(&missing)],
        Err(refused) => unusable(&refused),
    });
    findings.extend(open_elsewhere(name).iter().map(noted));
    findings
}

/// What a Raspberry Pi, or any computer whose console is a serial port, has at a port that PROFIBUS cannot use.
fn unsuitable(name: &str, driver: &str, command_line: &str) -> Vec<Finding> {
    let mut findings = Vec::new();
    if driver == "bcm2835-aux-uart" {
        findings.push(Finding::note(
            "the mini-UART of a Raspberry Pi, which has no parity bit",
            "use the PL011: write `dtoverlay=disable-bt` into /boot/firmware/config.txt, restart, and open /dev/ttyAMA0; docs/adapters.md has more",
        ));
    }
    let device = name.strip_prefix("/dev/").unwrap_or(name);
    let is_console = |word: &str| {
        word.strip_prefix("console=")
            .and_then(|console| console.split(',').next())
            .is_some_and(|console| console == device)
    };
    if command_line.split_whitespace().any(is_console) {
        findings.push(Finding::note(
            "the kernel writes to this port: it is the serial console",
            format!("remove `console={device}` from the command line of the kernel (Raspberry Pi: raspi-config, Serial Port, no login shell)"),
        ));
    }
    findings
}

/// The driver of a serial device, and how it delivers characters.
fn hardware(name: &str) -> Finding {
    let facts = adapter_facts(name);
    let driver = facts.driver.as_deref().unwrap_or("unknown");
    let usb = facts.usb_id.map_or(String::new(), |id| format!(", USB {id}"));
    Finding::good(format!("driver {driver}{usb}: {}", delivery_of(name)))
}

/// The findings about a port that is opened and listened to.
pub fn check(name: &str, rate: Rate, time: Duration, files: &Files) -> Vec<Finding> {
    let opened = match name.strip_prefix("sim:") {
        Some(_) => open::port(name, rate.initial())
            .map_err(Failure::from)
            .map_err(|failure| Finding::bad_file(failure.to_string(), "correct the file, or see docs/scenarios.md")),
        None => port::open_to_listen(name, rate.initial()).map_err(|error| unusable(&error)),
    };
    match opened {
        Err(finding) => vec![finding],
        Ok(port) => listen(port, rate, time, files),
    }
}

fn listen(mut port: Box<dyn Port>, rate: Rate, time: Duration, files: &Files) -> Vec<Finding> {
    let name = port.name().to_owned();
    let mut findings = Vec::new();
    let is_timed = port.delivery().is_timed();
    if is_timed {
        findings.push(hardware(&name));
    }
    let detected = match rate {
        Rate::Known(baud) => Ok(Some(baud)),
        Rate::Auto if is_timed => detect(&mut *port),
        Rate::Auto => Ok(None),
    };
    let opening: Vec<_> = std::iter::from_fn(|| port.next_notice()).collect();
    findings.extend(opening.iter().map(noted));
    let detected = match detected {
        Ok(detected) => detected,
        Err(error) => {
            findings.push(unusable(&error));
            return findings;
        }
    };
    match observe(port, detected, time, files) {
        Ok(heard) => {
            let is_altered = opening.iter().chain(&heard.notices).any(alters_octets);
            findings.extend(heard.notices.iter().map(noted));
            findings.extend(heard.findings(&name, is_timed, rate, is_altered));
        }
        Err(error) => findings.push(unusable(&error)),
    }
    findings
}

/// The rate at which telegrams are received; none if there are none at any rate.
fn detect(port: &mut dyn Port) -> Result<Option<Baud>, PortError> {
    match rate::detect(port) {
        Ok(baud) => Ok(Some(baud)),
        Err(PortError::NoTelegram { .. }) => port.set_baud(ANY_RATE).map(|()| None),
        Err(error) => Err(error),
    }
}

/// What listening has shown.
struct Heard {
    octets: u64,
    report: BusReport,
    /// What the port has noticed meanwhile.
    notices: Vec<Notice>,
    /// The slaves beside their GSD files.
    slaves: Vec<Finding>,
}

fn observe(port: Box<dyn Port>, detected: Option<Baud>, time: Duration, files: &Files) -> Result<Heard, PortError> {
    let baud = detected.unwrap_or(ANY_RATE);
    let mut tap = Tap::new(port, baud);
    let (mut divider, mut observer) =
        (Divider::new(baud, TimeSource::Platform), Observer::new(baud, TimeSource::Platform).with_gsd(files.clone()));
    let (mut pieces, mut octets) = (Vec::new(), 0_u64);
    let begun = Instant::now();
    while let Some(left) = time.checked_sub(begun.elapsed()) {
        match tap.receive(&[], left)?.0 {
            TapEvent::Octets(chunk) => {
                octets = octets.saturating_add(chunk.octets.len() as u64);
                divider.push(&chunk, &mut pieces);
            }
            TapEvent::Silence => divider.end(&mut pieces),
            TapEvent::Nothing => {}
        }
        pieces.drain(..).for_each(|piece| observer.piece(&piece));
    }
    divider.end(&mut pieces);
    pieces.drain(..).for_each(|piece| observer.piece(&piece));
    let slaves = if files.is_empty() { Vec::new() } else { slaves::findings(&observer, detected) };
    let notices = std::iter::from_fn(|| tap.next_notice()).collect();
    Ok(Heard { octets, report: BusReport::of(&observer), notices, slaves })
}

impl Heard {
    /// The findings about the line. `is_altered`: the server behind the port alters octets, so damage says nothing about the cable.
    fn findings(&self, name: &str, is_timed: bool, rate: Rate, is_altered: bool) -> Vec<Finding> {
        let at_rate = if is_timed { " --baud 19200" } else { "" };
        let tried = if rate == Rate::Auto && is_timed { "at any rate" } else { "among them" };
        match (self.octets, self.report.telegrams) {
            (0, _) => vec![Finding::note(
                "the line is silent: no master sends",
                format!(
                    "ask the gauges with `profivac scan --port {name}{at_rate}`; if a PLC should be there, check that it runs, and the cable"
                ),
            )],
            (_, 0) if is_altered => Vec::new(),
            (octets, 0) => vec![Finding::bad_port(format!("{octets} octets and no telegram {tried}"), NO_TELEGRAM)],
            _ => self.of_telegrams(is_altered),
        }
    }

    fn of_telegrams(&self, is_altered: bool) -> Vec<Finding> {
        let report = &self.report;
        let ring: Vec<_> = report.ring.iter().map(ToString::to_string).collect();
        let masters = if ring.is_empty() { "none".to_owned() } else { ring.join(", ") };
        let mut findings =
            vec![Finding::good(format!("{} telegrams at {} bit/s; masters: {masters}", report.telegrams, report.baud))];
        let pieces = report.telegrams.saturating_add(report.damaged);
        let percent = 100.0 * report.damaged as f64 / pieces as f64;
        let damaged = format!("{} damaged telegrams ({percent:.2} %)", report.damaged);
        findings.push(match percent > DISTURBED_PERCENT {
            true if is_altered => Finding::note(damaged, "the server alters octets: open the port as the finding above says"),
            true => Finding::bad_port(
                damaged,
                "check the termination at both ends, the shield and the distance to drives; `profivac sniff --statistics` shows after whose \
                 requests they come",
            ),
            false => Finding::good(damaged),
        });
        findings.extend(report.stations.iter().filter_map(|station| {
            let address = station.address;
            match station.state {
                StationState::Missing => Some(Finding::bad_port(
                    format!("station {address} is asked and does not answer"),
                    "check its power, its address switch and its connector",
                )),
                StationState::NotConfigured => Some(Finding::note(
                    format!("slave {address} answers and does not exchange data"),
                    format!("compare its GSD file and modules with the PLC; `profivac decode` explains a capture of `profivac sniff --out`, and its diagnosis reports: {}", station.diagnosis.join("; ")),
                )),
                _ => None,
            }
        }));
        findings.extend(self.slaves.iter().cloned());
        findings
    }
}

/// A condition of a port.
fn noted(notice: &Notice) -> Finding {
    let (found, next) = (notice.found(), notice.remedy().unwrap_or_else(|| "see docs/adapters.md".to_owned()));
    if alters_octets(notice) { Finding::bad_port(found, next) } else { Finding::note(found, next) }
}

/// Whether a server does not pass all octets of its line as they are.
const fn alters_octets(notice: &Notice) -> bool {
    matches!(notice, Notice::TelnetServer(_) | Notice::DoubledFf(_))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_mini_uart_and_a_console_are_named() {
        let found = |name, driver, line| -> Vec<String> {
            unsuitable(name, driver, line).into_iter().map(|finding| finding.found).collect()
        };
        let line = "coherent_pool=1M console=ttyAMA0,115200 console=tty1 root=PARTUUID=1";
        assert_eq!(
            found("/dev/ttyAMA0", "uart-pl011", line),
            ["the kernel writes to this port: it is the serial console"]
        );
        assert_eq!(found("/dev/ttyS0", "bcm2835-aux-uart", line).len(), 1);
        assert_eq!(found("/dev/ttyS0", "bcm2835-aux-uart", "console=ttyS0").len(), 2);
        assert_eq!(found("/dev/ttyAMA1", "uart-pl011", line), [""; 0]);
    }
}
