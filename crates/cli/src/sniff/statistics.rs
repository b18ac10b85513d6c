//! `profivac sniff --statistics`: the live list and the statistics of a bus.

use super::{Arguments, MAX_WAIT};
use crate::console::Signals;
use crate::failure::Failure;
use crate::gsd_files::SlaveRow;
use crate::output::{check, json, notices, out, visible};
use profivac_client::pressure::Pressure;
use profivac_dp::link::Baud;
use profivac_explain::divider::Divider;
use profivac_explain::frame::TimeSource;
use profivac_explain::gsd::{Files, Seen};
use profivac_explain::tap::{Tap, TapEvent};
use profivac_listen::Observer;
use profivac_listen::gauge::{Declared, Origin};
use profivac_listen::report::{BusReport, Distribution, StationReport};
use profivac_listen::station::Station;
use profivac_recorder::export::seven_digits;
use profivac_virtual::device_spec::{DeviceSpec, check_addresses};
use serde::Serialize;
use std::time::Instant;

/// A pressure in the JSON output.
#[derive(Debug, Serialize)]
struct GaugeRow {
    address: u8,
    device: &'static str,
    instance: u8,
    /// In Pa; `null` unless the reading is valid.
    pa: Option<f64>,
    quality: String,
    /// The weakest origin of device, configuration and unit.
    origin: Origin,
}

/// The JSON output.
#[derive(Debug, Serialize)]
struct Row<'a> {
    #[serde(flatten)]
    report: &'a BusReport,
    gauges: Vec<GaugeRow>,
    /// The slaves that a file of --gsd describes.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    slaves: Vec<SlaveRow>,
}

/// Listens until a signal or the end of --for, then prints.
pub fn run(arguments: &Arguments, files: Files, signals: &Signals, tap: &mut Tap, baud: Baud) -> Result<(), Failure> {
    let mut observer = observer(baud, TimeSource::Platform, &arguments.gauges)?.with_gsd(files);
    let mut divider = Divider::new(baud, TimeSource::Platform);
    let end = arguments.time.and_then(|time| Instant::now().checked_add(time));
    let mut pieces = Vec::new();
    let ended = loop {
        let left = end.map_or(MAX_WAIT, |end| end.saturating_duration_since(Instant::now()));
        let (event, stop) = match tap.receive(&[signals.readiness()], left) {
            Ok((event, readable)) => (event, readable.first() == Some(&true)),
            Err(error) => break Err(Failure::from(error)),
        };
        notices(|| tap.next_notice());
        match event {
            TapEvent::Octets(chunk) => divider.push(&chunk, &mut pieces),
            TapEvent::Silence => divider.end(&mut pieces),
            TapEvent::Nothing => {}
        }
        pieces.drain(..).for_each(|piece| observer.piece(&piece));
        if stop || end.is_some_and(|end| end <= Instant::now()) {
            break Ok(());
        }
    };
    divider.end(&mut pieces);
    pieces.drain(..).for_each(|piece| observer.piece(&piece));
    print(&observer, arguments.options.json);
    check()?;
    ended
}

/// An observer that knows the devices at some addresses.
pub fn observer(baud: Baud, times: TimeSource, specs: &[DeviceSpec]) -> Result<Observer, Failure> {
    check_addresses(specs)?;
    let mut observer = Observer::new(baud, times);
    for spec in specs {
        let model = spec.model;
        let unit = spec.value("unit").and_then(|unit| model.unit_named(unit));
        observer.declare(spec.address, Declared { model, configuration: None, unit });
    }
    Ok(observer)
}

/// Prints the live list, the statistics and the pressures.
pub fn print(observer: &Observer, is_json: bool) {
    let report = BusReport::of(observer);
    if is_json {
        out(&json(&Row { report: &report, gauges: gauges(observer), slaves: slaves(observer) }));
    } else {
        out(&table(observer, &report));
    }
}

/// The pressures that were heard last.
fn gauges(observer: &Observer) -> Vec<GaugeRow> {
    let mut all = Vec::new();
    for (address, _) in observer.stations() {
        let Some(reading) = observer.reading(address) else { continue };
        all.extend(reading.values.values.iter().map(|value| GaugeRow {
            address,
            device: reading.facts.slave.model.name,
            instance: value.instance,
            pa: value.pa.map(seven_digits),
            quality: value.text(),
            origin: reading.facts.origin(),
        }));
    }
    all
}

/// The slaves that GSD files describe.
fn slaves(observer: &Observer) -> Vec<SlaveRow> {
    // The rate of a pty or a host is not that of the line.
    let bits_per_second = None;
    let row = |(address, station): (u8, &Station)| {
        let (set_prm, diagnosis) = (station.set_prm.as_slice(), station.diagnosis_octets.as_slice());
        let seen = Seen { bits_per_second, set_prm, diagnosis, longest_tsdr: station.longest_tsdr };
        SlaveRow::of(address, &station.described, &seen)
    };
    observer.stations().filter_map(row).collect()
}

/// The report as text.
fn table(observer: &Observer, report: &BusReport) -> String {
    let mut lines = vec![format!(
        "{} telegrams in {:.1} s, {} damaged; cycle {}; token rotation {}",
        report.telegrams,
        report.observed_ms as f64 / 1e3,
        report.damaged,
        times(&report.cycle),
        times(&report.rotation)
    )];
    if !report.ring.is_empty() {
        let ring: Vec<_> = report.ring.iter().map(ToString::to_string).collect();
        lines.push(format!("token ring: {}", ring.join(" -> ")));
    }
    lines.push(String::new());
    let title = ["address", "state", "requests", "lost", "repeated", "longest", "damaged", "refused", "device"];
    lines.push(row(&title.map(str::to_owned)));
    lines.extend(report.stations.iter().map(station));
    let gauges = gauges(observer);
    if !gauges.is_empty() {
        lines.push(String::new());
    }
    for gauge in gauges {
        let pressure = gauge.pa.map_or_else(|| gauge.quality.clone(), |pa| Pressure::from_pa(pa).to_string());
        let GaugeRow { address, device, instance, .. } = gauge;
        lines.push(format!("{address:>7}  {device} instance {instance}: {pressure} ({})", gauge.origin.text()));
    }
    lines.extend(slaves(observer).iter().flat_map(SlaveRow::lines));
    for station in &report.stations {
        let address = station.address;
        lines.extend(station.diagnosis.iter().map(|text| format!("station {address}: diagnosis: {text}")));
        lines.extend(station.unknown.iter().map(|text| format!("station {address}: {text}")));
    }
    for parameter in &report.parameters {
        let (address, requester, name, value) =
            (parameter.address, parameter.requester, &parameter.name, &parameter.value);
        lines.push(format!("station {address}: master {requester}: {name} = {value}"));
    }
    lines.extend(
        report.events.iter().rev().map(|event| format!("{:.1} s ago: {}", event.age_ms as f64 / 1e3, event.text)),
    );
    lines.iter().map(|line| visible(line)).collect::<Vec<_>>().join("\n")
}

fn times(times: &Distribution) -> String {
    match (times.mean_us, times.p99_us, times.max_us) {
        (Some(mean), Some(p99), Some(max)) => {
            let ms = |us: u64| us as f64 / 1e3;
            format!("{:.1} ms (99 % within {:.1} ms, longest {:.1} ms)", ms(mean), ms(p99), ms(max))
        }
        _ => "unknown".to_owned(),
    }
}

fn station(station: &StationReport) -> String {
    let counts = station.total;
    let numbers = [
        counts.requests,
        counts.lost,
        counts.repeated,
        station.longest_sequence.into(),
        counts.damaged,
        counts.refused,
    ];
    let [requests, lost, repeated, longest, damaged, refused] = numbers.map(|number| number.to_string());
    let (address, state) = (station.address.to_string(), station.state.text().to_owned());
    row(&[address, state, requests, lost, repeated, longest, damaged, refused, station.devices.join(", ")])
}

fn row(cells: &[String; 9]) -> String {
    let [address, state, requests, lost, repeated, longest, damaged, refused, device] = cells;
    format!(
        "{address:>7}  {state:<24}{requests:>10}{lost:>8}{repeated:>10}{longest:>9}{damaged:>9}{refused:>9}  {device}"
    )
}
