//! The results of a field test: `report.json` and `report.txt`. docs/field-test.md documents the keys.

use super::figures::{Distribution, Figures};
use crate::conform;
use profivac_client::values::hex;
use profivac_conform::dialogue::Stated;
use profivac_dp::link::Baud;
use profivac_gsd_slave::{GsdSlave, PlacedModule};
use profivac_host::port::{Delivery, Notice, Port, adapter_facts};
use serde::{Deserialize, Serialize};
use serde_json::Value;
use std::ops::RangeInclusive;
use std::path::Path;

/// The number of the format of `report.json`. It grows when a key is renamed or removed.
pub const FORMAT: u32 = 1;

/// The whole result of a run.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Report {
    /// [`FORMAT`].
    pub format: u32,
    /// The version of profivac.
    pub version: String,
    /// The release of the kernel.
    pub kernel: Option<String>,
    /// Whether all steps ran.
    pub complete: bool,
    /// How the run ended, as a sentence.
    pub end: String,
    /// The options of the run.
    pub options: Options,
    /// The port; `None` if it was not open yet when the run ended.
    pub port: Option<PortFacts>,
    /// Other masters that were received.
    pub other_masters: Vec<u8>,
    /// The steps in their order.
    pub steps: Vec<Step>,
    /// The stations, as `profivac scan --json` prints them.
    pub stations: Vec<Value>,
    /// The slaves.
    pub slaves: Vec<Slave>,
}

/// The requests of each service that a run may measure. chosen: the last are ten minutes at 19200 bit/s.
pub const CYCLES: RangeInclusive<usize> = 1..=100_000;

/// A number of measured requests that no run has.
#[derive(Clone, Copy, Debug, thiserror::Error)]
#[error("found {0} cycles in place of {least} to {most}", least = CYCLES.start(), most = CYCLES.end())]
pub struct ImpossibleCycles(usize);

/// The options of a run.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Options {
    /// Bits per second.
    pub baud: u32,
    /// The address of this master.
    pub master: u8,
    /// The highest station address that was searched.
    pub hsa: u8,
    /// Measured requests of each service to each slave.
    pub cycles: usize,
    /// Whether rules that set parameters and outputs of the slave may be tested.
    pub allow_writes: bool,
    /// Whether records keep their contents in the capture.
    pub with_serial_numbers: bool,
}

impl Options {
    /// Checks what an archive says about its run: a replay works for as many cycles. The bus parameters are checked like those of a
    /// run.
    ///
    /// # Errors
    /// [`ImpossibleCycles`].
    pub fn check(&self) -> Result<(), ImpossibleCycles> {
        if CYCLES.contains(&self.cycles) { Ok(()) } else { Err(ImpossibleCycles(self.cycles)) }
    }

    /// The rate.
    pub fn rate(&self) -> Option<Baud> {
        Baud::from_bits_per_second(self.baud)
    }
}

/// Facts of the port. They name neither the computer nor a user.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct PortFacts {
    /// The device below `/dev`, or the kind of a port without one: `tcp`, `pty`, `sim`.
    pub name: String,
    /// The driver, as the kernel names it.
    pub driver: Option<String>,
    /// Vendor and product of a USB adapter.
    pub usb_id: Option<String>,
    /// How the driver delivers characters.
    pub delivery: String,
    /// Whether the port has a baud rate.
    pub has_rate: bool,
    /// The longest tolerated pause within a telegram, in bit times.
    pub tolerated_pause_bit_times: u64,
    /// The longest turnaround that profivac expects of this port, in bit times. `None` for a port without a rate.
    #[serde(default)]
    pub expected_turnaround_bit_times: Option<u64>,
    /// The slot time of this master, in bit times.
    pub slot_time_bit_times: u32,
    /// What the port reported when it was opened.
    pub notices: Vec<String>,
}

impl PortFacts {
    /// The facts of an open port.
    pub fn of(port: &dyn Port, baud: Baud, slot_tbit: u32) -> Self {
        let (delivery, facts) = (port.delivery(), adapter_facts(port.name()));
        Self {
            name: public_name(port.name(), delivery),
            driver: facts.driver,
            usb_id: facts.usb_id,
            delivery: delivery.to_string(),
            has_rate: port.is_timed(),
            tolerated_pause_bit_times: delivery.idle_tbit(baud),
            expected_turnaround_bit_times: delivery.answer_tbit(baud, baud.max_tsdr_tbit().into()),
            slot_time_bit_times: slot_tbit,
            notices: Vec::new(),
        }
    }
}

/// The name of a port without a host, a path or a serial number: links in `/dev/serial/by-id` contain one.
fn public_name(name: &str, delivery: Delivery) -> String {
    match scheme_of(name).0 {
        Some(scheme) => scheme.to_owned(),
        None if !delivery.is_timed() => "pty".to_owned(),
        None => {
            let device = std::fs::canonicalize(name).unwrap_or_default();
            let device = device.file_name().map(|file| file.to_string_lossy().into_owned());
            device.map_or_else(|| "serial device".to_owned(), |file| format!("/dev/{file}"))
        }
    }
}

/// The schemes of ports that are no devices.
const SCHEMES: [(&str, &str); 4] = [("tcp", "://"), ("telnet", "://"), ("rfc2217", "://"), ("sim", ":")];

/// The scheme of a port, and the name behind it.
fn scheme_of(port: &str) -> (Option<&'static str>, &str) {
    let behind =
        |(scheme, mark): (&'static str, &str)| Some((Some(scheme), port.strip_prefix(scheme)?.strip_prefix(mark)?));
    SCHEMES.into_iter().find_map(behind).unwrap_or((None, port))
}

/// A notice of a port without paths. `None` for one that does not concern the line.
pub fn public_notice(notice: &Notice) -> Option<String> {
    match notice {
        Notice::Latency { ms, .. } => Some(format!("received octets are delayed by up to {ms} ms")),
        Notice::TransmitterNotSwitched(_) => Some("the kernel does not switch the transmitter".to_owned()),
        Notice::OctetsDropped { octets, .. } => Some(format!("{octets} octets were discarded")),
        _ => None,
    }
}

/// `sentence` with `public` in place of the port as the user wrote it, so that it has no path and no host name.
pub fn public_sentence(sentence: &str, port: &str, public: &str) -> String {
    let (_, bare) = scheme_of(port);
    [port, bare].into_iter().fold(sentence.to_owned(), |text, name| replace_word(&text, name, public))
}

/// Replaces `word` where it is not a part of another word: a port may have a name of one letter.
fn replace_word(text: &str, word: &str, with: &str) -> String {
    let mut replaced = String::new();
    let mut rest = text;
    while let Some((before, behind)) = rest.split_once(word).filter(|_| !word.is_empty()) {
        let is_whole = !before.ends_with(char::is_alphanumeric) && !behind.starts_with(char::is_alphanumeric);
        replaced.push_str(before);
        replaced.push_str(if is_whole { with } else { word });
        rest = behind;
    }
    replaced + rest
}

/// The release of the kernel, where the system has it as a file.
pub fn kernel_release() -> Option<String> {
    let text = std::fs::read_to_string(Path::new("/proc/sys/kernel/osrelease")).ok()?;
    Some(text.trim().to_owned())
}

/// A step of a run.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Step {
    /// What it does.
    pub name: StepName,
    /// The slave that it concerns.
    pub address: Option<u8>,
    /// The number of packets that it has in the capture.
    pub packets: usize,
    /// Its duration in seconds.
    pub seconds: f64,
}

/// What a step does.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum StepName {
    /// Listens for other masters and sends nothing.
    Listen,
    /// Asks every address, and every slave for diagnosis and configuration.
    Scan,
    /// Tests the rules of `conform`.
    Conform,
    /// Sends many FDL status and Slave_Diag requests.
    Measure,
}

/// The results for a slave.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Slave {
    /// Its address.
    pub address: u8,
    /// The answer to Slave_Diag, in hex.
    pub diagnosis: Option<String>,
    /// The answer to Get_Cfg, in hex.
    pub configuration: Option<String>,
    /// The rules, as `profivac conform --json` prints them; `not-recorded` is an outcome beside its own.
    pub rules: Vec<Value>,
    /// Why rules were not tested.
    pub rules_note: Option<String>,
    /// Timing.
    pub figures: Option<Figures>,
    /// Why there are fewer figures than requested.
    pub figures_note: Option<String>,
    /// Times that are longer than profivac expects of the port, each with the remedy.
    #[serde(default)]
    pub timing_notices: Vec<String>,
    /// Its GSD file, if the command line had one.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub gsd: Option<GsdFacts>,
    /// Why fewer rules were tested than the options allow.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub limits_note: Option<String>,
}

/// What the test takes from a GSD file.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct GsdFacts {
    /// Vendor and model.
    pub device: String,
    /// The modules by slot.
    pub modules: Vec<String>,
    /// The user parameters of Set_Prm, in hex.
    pub user_prm: String,
    /// What the rules of the file test.
    pub stated: Stated,
}

impl GsdFacts {
    /// What the file of a slave says.
    pub fn of(slave: &GsdSlave) -> Self {
        let general = &slave.device().general;
        let name = [&general.vendor_name, &general.model_name].map(|name| name.as_deref().unwrap_or("-").trim());
        Self {
            device: name.join(" "),
            modules: slave.layout().modules.iter().map(PlacedModule::label).collect(),
            user_prm: hex(slave.user_prm()),
            stated: conform::stated(slave),
        }
    }
}

impl Slave {
    /// A slave of which only the address is known.
    pub const fn at(address: u8) -> Self {
        Self {
            address,
            diagnosis: None,
            configuration: None,
            rules: Vec::new(),
            rules_note: None,
            figures: None,
            figures_note: None,
            timing_notices: Vec::new(),
            gsd: None,
            limits_note: None,
        }
    }
}

/// The value of a key that is a text.
pub fn text<'a>(value: &'a Value, key: &str) -> &'a str {
    value.get(key).and_then(Value::as_str).unwrap_or_default()
}

/// The report for people.
pub fn as_text(report: &Report) -> String {
    let mut lines = vec![
        format!("profivac {}, Linux kernel {}", report.version, report.kernel.as_deref().unwrap_or("unknown")),
        format!("the run {}: {}", if report.complete { "is complete" } else { "ENDED EARLY" }, report.end),
    ];
    lines.extend(report.port.iter().flat_map(|port| port_lines(port, &report.options)));
    lines.extend(report.other_masters.iter().map(|master| format!("master {master} uses the line")));
    lines.push(format!("stations: {}, slaves: {}", report.stations.len(), report.slaves.len()));
    lines.extend(report.stations.iter().map(station_line));
    lines.extend(report.slaves.iter().flat_map(slave_lines));
    lines.join("\n") + "\n"
}

fn port_lines(port: &PortFacts, options: &Options) -> Vec<String> {
    let PortFacts { name, delivery, tolerated_pause_bit_times: pause, slot_time_bit_times: slot, .. } = port;
    let driver = port.driver.as_deref().unwrap_or("unknown");
    let usb = port.usb_id.as_ref().map(|id| format!(", USB {id}")).unwrap_or_default();
    let mut lines = vec![
        format!("port {name}, driver {driver}{usb}: {delivery}"),
        format!("{} bit/s, tolerated pause {pause} bit times, slot time {slot} bit times", options.baud),
    ];
    lines.extend(port.notices.iter().map(|notice| format!("notice: {notice}")));
    lines
}

fn station_line(station: &Value) -> String {
    let devices = station.get("devices").and_then(Value::as_array);
    let devices: Vec<_> = devices.into_iter().flatten().filter_map(Value::as_str).collect();
    let address = station.get("address").and_then(Value::as_u64).unwrap_or_default();
    format!(
        "  {address:>3}  {} {} {} {}",
        text(station, "kind"),
        text(station, "ident"),
        text(station, "state"),
        devices.join(" or ")
    )
}

fn slave_lines(slave: &Slave) -> Vec<String> {
    let mut lines = vec![String::new(), format!("slave {}", slave.address)];
    let mut add = |name: &str, value: Option<&str>| lines.extend(value.map(|value| format!("  {name}: {value}")));
    add("diagnosis", slave.diagnosis.as_deref());
    add("configuration", slave.configuration.as_deref());
    add("rules", Some(&outcomes(&slave.rules)));
    add("rules", slave.rules_note.as_deref());
    add("rules", slave.limits_note.as_deref());
    for rule in slave.rules.iter().filter(|rule| text(rule, "outcome") == "broken") {
        lines.push(format!("    BROKEN {}: {}", text(rule, "name"), text(rule, "rule")));
    }
    lines.extend(slave.figures.iter().flat_map(figure_lines));
    lines.extend(slave.figures_note.iter().chain(&slave.timing_notices).map(|note| format!("  timing: {note}")));
    lines
}

/// The number of rules with each outcome.
fn outcomes(rules: &[Value]) -> String {
    let mut counts: Vec<(&str, usize)> = Vec::new();
    for rule in rules {
        let outcome = text(rule, "outcome");
        match counts.iter_mut().find(|(name, _)| *name == outcome) {
            Some((_, count)) => *count = count.saturating_add(1),
            None => counts.push((outcome, 1)),
        }
    }
    let counts: Vec<_> = counts.iter().map(|(name, count)| format!("{count} {name}")).collect();
    if counts.is_empty() { "none".to_owned() } else { counts.join(", ") }
}

fn figure_lines(figures: &Figures) -> Vec<String> {
    let Figures { requests, answered, late, damaged, missing, .. } = figures;
    let Figures { lost_characters, extra_characters, character_errors, .. } = figures;
    let mut lines = vec![
        format!("  {requests} requests: {answered} answered ({late} late), {damaged} damaged, {missing} missing"),
        format!(
            "  {lost_characters} characters lost, {extra_characters} too many, {character_errors} with an error; \
             at most {} deliveries for one answer",
            figures.most_pieces
        ),
    ];
    for (name, distribution) in [("turnaround", &figures.turnaround), ("gaps", &figures.gaps)] {
        lines.extend(distribution.iter().flat_map(|distribution| distribution_lines(name, distribution)));
    }
    lines
}

fn distribution_lines(name: &str, distribution: &Distribution) -> Vec<String> {
    let Distribution { count, min, median, p99, max, histogram } = distribution;
    let times = [("minimum", min), ("median", median), ("99 %", p99), ("maximum", max)];
    let times = times.map(|(name, time)| format!("{name} {:.3} ms ({} bit times)", time.ms, time.bit_times));
    let mut lines = vec![format!("  {name}, {count} times: {}", times.join(", "))];
    lines.extend(histogram.iter().map(|range| {
        let part = range.count.saturating_mul(40).div_ceil((*count).max(1));
        let bar = "#".repeat(part);
        let (from, below) = (range.from, range.below);
        format!(
            "    {:>8.3} to {:>8.3} ms ({:>6} to {:>6} bit times) {:>6} {bar}",
            from.ms, below.ms, from.bit_times, below.bit_times, range.count
        )
    }));
    lines
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_name_of_a_port_tells_neither_a_host_nor_a_path() {
        for (name, public) in [
            ("tcp://server.example:4000", "tcp"),
            ("telnet://server.example:4000", "telnet"),
            ("rfc2217://server.example:4000", "rfc2217"),
            ("sim:/home/me/line.toml", "sim"),
            ("/home/me/line", "pty"),
        ] {
            assert_eq!(public_name(name, Delivery::Unpaced), public);
        }
        assert_eq!(public_name("/home/me/gone", Delivery::Fifo { trigger: None }), "serial device");
        assert_eq!(public_name("/dev/null", Delivery::Fifo { trigger: None }), "/dev/null");
        let sentence = public_sentence("lost /home/me/line: it was unplugged", "/home/me/line", "pty");
        assert_eq!(sentence, "lost pty: it was unplugged");
        assert_eq!(public_sentence("no bus on b: b is gone", "b", "pty"), "no bus on pty: pty is gone");
        let sentence = public_sentence("server.example:4000 does not read", "tcp://server.example:4000", "tcp");
        assert_eq!(sentence, "tcp does not read");
        let sentence = public_sentence("server.example:4000 does not read", "rfc2217://server.example:4000", "rfc2217");
        assert_eq!(sentence, "rfc2217 does not read");
    }

    #[test]
    fn a_notice_keeps_its_figures_and_loses_its_path() {
        let latency = Notice::Latency { name: "/dev/x".to_owned(), ms: 16, setting: "/sys/x".into() };
        assert_eq!(public_notice(&latency).as_deref(), Some("received octets are delayed by up to 16 ms"));
        assert_eq!(public_notice(&Notice::Reopened("/dev/x".to_owned())), None);
    }
}
