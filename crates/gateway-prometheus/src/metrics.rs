//! The metrics of a snapshot, and those of the lines, the recorder and the gateways.

use crate::family::{Family, Form, labels, word_label};
use profivac_gateway::{Kind, Point, PointValue, Signal, Snapshot, Value};
use profivac_listen::report::{BusReport, Distribution};
use profivac_station::gateway_status::{ArchiveView, GatewayView};
use profivac_station::view::RecorderView;
use profivac_web_server::exposition::{Exposition, Format, MetricKind, Number, put_label};
use std::collections::BTreeMap;
use std::sync::Arc;

/// The upper bounds of the histograms in microseconds: a bus cycle takes from below a millisecond to seconds.
const BOUNDS_US: [u64; 14] = [
    500, 1_000, 2_500, 5_000, 10_000, 25_000, 50_000, 100_000, 250_000, 500_000, 1_000_000, 2_500_000, 5_000_000,
    10_000_000,
];

/// The description of an info series. The labels of a gauge and the priority of an alarm change when the station reads its file again.
const INFO: &str = "Facts in the labels, the value is always 1; a fact that changes begins a new series";

/// What the metrics show besides the points.
#[derive(Clone, Debug, Default)]
pub struct Others {
    /// The name of the station.
    pub station: String,
    /// The recorder.
    pub recorder: RecorderView,
    /// The lines, by the name of the segment.
    pub buses: BTreeMap<String, Arc<BusReport>>,
    /// The gateways.
    pub gateways: Vec<GatewayView>,
}

/// A sample of a point.
#[derive(Debug)]
struct Entry {
    /// The position of its value.
    index: usize,
    /// Its labels.
    labels: String,
    /// A further label, and the position of its value.
    further: Option<(&'static str, usize)>,
}

/// The labels of an info series.
#[derive(Debug)]
struct Info {
    labels: String,
    /// The further labels, and the positions of their values.
    values: Vec<(&'static str, usize)>,
}

/// The samples of a family.
#[derive(Debug)]
struct Block {
    family: Family,
    sample: String,
    entries: Vec<Entry>,
    infos: Vec<Info>,
}

/// A family whose values are settings.
#[derive(Debug, Default)]
struct Fixed {
    ranges: [Vec<(String, f64)>; 2],
    limits: Vec<(String, f64)>,
}

/// The families of a list of points, with their labels written: they are made again only if the points change.
#[derive(Debug)]
pub struct Layout {
    points: Arc<[Point]>,
    blocks: Vec<Block>,
    fixed: Fixed,
    /// The size of the last text, in octets.
    size: usize,
}

impl Layout {
    /// The families of these points.
    #[must_use]
    pub fn of(points: &Arc<[Point]>) -> Self {
        let mut blocks: BTreeMap<String, Block> = BTreeMap::new();
        for (index, point) in points.iter().enumerate() {
            let family = Family::of(point.signal);
            let sample = family.sample();
            let block = blocks.entry(sample.clone());
            let block = block.or_insert_with(|| Block { family, sample, entries: Vec::new(), infos: Vec::new() });
            block.add(index, point, points);
        }
        let blocks = blocks.into_values().filter(|block| block.family.form != Form::Absent).collect();
        Self { points: Arc::clone(points), blocks, fixed: Fixed::of(points), size: 0 }
    }

    /// Whether it belongs to the points of this snapshot.
    #[must_use]
    pub fn fits(&self, snapshot: &Snapshot) -> bool {
        Arc::ptr_eq(&self.points, &snapshot.points)
    }

    /// The text of a snapshot.
    #[must_use]
    pub fn text(&mut self, snapshot: &Snapshot, others: &Others, format: Format) -> String {
        let mut text = Exposition::new(format, self.size);
        for block in &self.blocks {
            block.put(&mut text, &self.points, &snapshot.values);
        }
        self.fixed.put(&mut text);
        put_others(&mut text, others);
        let text = text.finish();
        self.size = text.len();
        text
    }
}

impl Block {
    fn add(&mut self, index: usize, point: &Point, points: &[Point]) {
        if let Form::Label(name) = self.family.form {
            let name = if let Form::Label(own) = Family::of(point.signal).form { own } else { name };
            let labels = labels(point);
            match self.infos.last_mut().filter(|info| info.labels == labels) {
                Some(info) => info.values.push((name, index)),
                None => self.infos.push(Info { labels, values: vec![(name, index)] }),
            }
        } else {
            let further =
                (point.signal == Signal::AlarmActive).then(|| position_beside(points, index, Signal::Priority));
            let further = further.flatten().map(|index| ("priority", index));
            self.entries.push(Entry { index, labels: labels(point), further });
        }
    }

    fn put(&self, text: &mut Exposition, points: &[Point], values: &[PointValue]) {
        let Family { name, unit, help, .. } = &self.family;
        let help = if self.infos.is_empty() { help } else { INFO };
        text.family(name, self.family.kind(), *unit, help);
        for Entry { index, labels, further } in &self.entries {
            let (Some(point), Some(value)) = (points.get(*index), values.get(*index)) else { continue };
            let labels = match further {
                Some((name, index)) => &with_label(labels, name, &label_of(points, values, *index)),
                None => labels,
            };
            self.put_value(text, labels, point, value);
        }
        for Info { labels, values: further } in &self.infos {
            let mut labels = labels.clone();
            for (name, index) in further {
                put_label(&mut labels, name, &label_of(points, values, *index));
            }
            text.sample(&self.sample, &labels, 1);
        }
    }

    fn put_value(&self, text: &mut Exposition, labels: &str, point: &Point, value: &PointValue) {
        let name = self.sample.as_str();
        match (&value.value, self.family.form) {
            // A pressure that is not measured is absent, so that its series ends. The end of the range is no measured pressure.
            (Value::Float(_), _)
                if point.signal.subject() == SUBJECT_OF_PRESSURES && !value.state.codes().is_measured => {}
            (Value::Float(number), _) if number.is_finite() => text.sample(name, labels, Number(*number)),
            (Value::Integer(number), _) => text.sample(name, labels, number),
            (Value::Boolean(value), _) => text.sample(name, labels, u8::from(*value)),
            (Value::Time(at), _) => text.sample(name, labels, Seconds(at.0)),
            (Value::Choice(number), Form::States(label, words)) => {
                for (position, word) in (0..).zip(words) {
                    let labels = with_label(labels, label, &word_label(word));
                    text.sample(name, &labels, u8::from(position == *number));
                }
            }
            (Value::Text(words), Form::Word(_)) if is_number(words) => {}
            (Value::Text(words), Form::Text(label) | Form::Word(label)) if !words.is_empty() => {
                text.sample(name, &with_label(labels, label, words), 1);
            }
            (Value::Float(_) | Value::None | Value::Choice(_) | Value::Text(_), _) => {}
        }
    }
}

/// Whether a text is a number, with or without a unit. A word such as `inf` or a sentence that begins with a number is none.
fn is_number(text: &str) -> bool {
    let mut words = text.split(' ').filter(|word| *word != "(uncertain)");
    let is_digits = |word: &str| word.trim_start_matches('-').starts_with(|first: char| first.is_ascii_digit());
    words.next().is_some_and(|first| is_digits(first) && first.parse::<f64>().is_ok()) && words.count() <= 1
}

/// Microseconds since 1970 in seconds.
struct Seconds(i64);

impl std::fmt::Display for Seconds {
    fn fmt(&self, formatter: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let micros = self.0.max(0);
        write!(formatter, "{}.{:06}", micros / 1_000_000, micros % 1_000_000)
    }
}

/// What pressures belong to.
const SUBJECT_OF_PRESSURES: profivac_gateway::signal::SubjectKind = Signal::Pressure.subject();

/// The position of another signal of the same subject.
fn position_beside(points: &[Point], index: usize, signal: Signal) -> Option<usize> {
    let subject = &points.get(index)?.subject;
    let after = points.iter().enumerate().skip(index).take_while(|(_, point)| point.subject == *subject);
    after.filter(|(_, point)| point.signal == signal).map(|(position, _)| position).next()
}

fn with_label(labels: &str, name: &str, value: &str) -> String {
    let mut labels = labels.to_owned();
    put_label(&mut labels, name, value);
    labels
}

/// A value as the value of a label.
fn label_of(points: &[Point], values: &[PointValue], index: usize) -> String {
    let (Some(point), Some(value)) = (points.get(index), values.get(index)) else { return String::new() };
    match (&value.value, point.signal.kind()) {
        (Value::Choice(number), Kind::Choice(words)) => {
            words.get(usize::from(*number)).map(|word| word_label(word)).unwrap_or_default()
        }
        (value, _) => value.to_string(),
    }
}

impl Fixed {
    fn of(points: &[Point]) -> Self {
        let mut fixed = Self::default();
        for point in points.iter().filter(|point| point.signal == Signal::Pressure) {
            let labels = labels(point);
            if let Some((low, high)) = point.range {
                let [lows, highs] = &mut fixed.ranges;
                lows.push((labels.clone(), low));
                highs.push((labels.clone(), high));
            }
            let limits = &point.limits;
            let all = [
                ("high_high", limits.high_high),
                ("high", limits.high),
                ("low", limits.low),
                ("low_low", limits.low_low),
            ];
            for (name, limit) in all {
                fixed.limits.extend(limit.map(|limit| (with_label(&labels, "limit", name), limit)));
            }
        }
        fixed
    }

    fn put(&self, text: &mut Exposition) {
        let [lows, highs] = &self.ranges;
        let families = [
            ("profivac_reading_range_low_pascals", "Lower end of the measuring range", lows),
            ("profivac_reading_range_high_pascals", "Upper end of the measuring range", highs),
            (
                "profivac_reading_limit_pascals",
                "Limit of the alarms: high_high and low_low of high priority",
                &self.limits,
            ),
        ];
        for (name, help, samples) in families {
            text.family(name, MetricKind::Gauge, Some("pascals"), help);
            for (labels, pa) in samples {
                text.sample(name, labels, Number(*pa));
            }
        }
    }
}

fn put_others(text: &mut Exposition, others: &Others) {
    let Others { station, recorder, buses, gateways } = others;
    text.family("profivac_target", MetricKind::Info, None, "Name of the station");
    text.sample("profivac_target_info", &with_label("", "station", station), 1);
    put_recorder(text, recorder);
    put_histogram(text, "profivac_segment_cycle_seconds", "Durations of the cycles", buses, |bus| &bus.cycle);
    put_histogram(
        text,
        "profivac_segment_rotation_seconds",
        "Times between two tokens to the same master",
        buses,
        |bus| &bus.rotation,
    );
    put_gateways(text, gateways);
}

fn put_recorder(text: &mut Exposition, recorder: &RecorderView) {
    if let Some(ms) = recorder.last_write_ms {
        let name = "profivac_record_last_write_timestamp_seconds";
        text.family(name, MetricKind::Gauge, Some("timestamp_seconds"), "Time of the last write of the recorder");
        text.sample(name, "", Seconds(ms.saturating_mul(1000)));
    }
    text.family("profivac_record_lost_events", MetricKind::Counter, None, "Events that the recorder has dropped");
    text.sample("profivac_record_lost_events_total", "", recorder.lost_events);
    let name = "profivac_record_last_check_timestamp_seconds";
    text.family(name, MetricKind::Gauge, Some("timestamp_seconds"), "Time of the last check of the database");
    if let Some(ms) = recorder.last_check_ms {
        text.sample(name, "", Seconds(ms.saturating_mul(1000)));
    }
    let name = "profivac_record_damaged";
    text.family(name, MetricKind::Gauge, None, "The last check has found damage in the database");
    // Without a check nothing is known about damage.
    if recorder.last_check_ms.is_some() {
        text.sample(name, "", u64::from(recorder.damage.is_some()));
    }
}

/// A histogram of each segment. The observer counts durations in buckets of a quarter of an octave; each bucket counts as its end.
fn put_histogram(
    text: &mut Exposition,
    name: &str,
    help: &str,
    buses: &BTreeMap<String, Arc<BusReport>>,
    of: fn(&BusReport) -> &Distribution,
) {
    text.family(name, MetricKind::Histogram, Some("seconds"), help);
    for (segment, bus) in buses {
        let distribution = of(bus);
        let labels = with_label("", "segment", segment);
        let bucket = format!("{name}_bucket");
        for bound in BOUNDS_US {
            let below = distribution.buckets.iter().filter(|bucket| bucket.end_us <= bound).map(|bucket| bucket.count);
            let labels = with_label(&labels, "le", &bound_text(bound));
            text.sample(&bucket, &labels, below.fold(0, u64::saturating_add));
        }
        text.sample(&bucket, &with_label(&labels, "le", "+Inf"), distribution.count);
        text.sample(&format!("{name}_count"), &labels, distribution.count);
        text.sample(&format!("{name}_sum"), &labels, Seconds(i64::try_from(distribution.sum_us).unwrap_or(i64::MAX)));
    }
}

/// Microseconds in seconds, in the form that OpenMetrics prescribes for a bound.
fn bound_text(us: u64) -> String {
    let text = format!("{}.{:06}", us / 1_000_000, us % 1_000_000);
    let text = text.trim_end_matches('0');
    if text.ends_with('.') { format!("{text}0") } else { text.to_owned() }
}

/// The batches of a station that sends to an archive.
fn put_archive(text: &mut Exposition, archive: Option<&ArchiveView>) {
    type Count = fn(&ArchiveView) -> u64;
    type Time = fn(&ArchiveView) -> Option<i64>;
    let counts: [(&str, &str, Count); 3] = [
        ("profivac_archive_waiting_batches", "Batches that wait in the database of the station", |it| it.waiting),
        ("profivac_archive_put_aside_batches", "Batches that the archive has put aside", |it| it.put_aside),
        ("profivac_archive_lost_batches", "Batches deleted since the last one was taken, as too many wait", |it| {
            it.lost
        }),
    ];
    for (name, help, of) in counts {
        text.family(name, MetricKind::Gauge, None, help);
        if let Some(archive) = archive {
            text.sample(name, "", of(archive));
        }
    }
    let times: [(&str, &str, Time); 2] = [
        ("profivac_archive_oldest_batch_timestamp_seconds", "When the first waiting batch was made", |it| it.oldest_ms),
        ("profivac_archive_last_answer_timestamp_seconds", "When the archive answered last", |it| it.last_answer_ms),
    ];
    for (name, help, of) in times {
        text.family(name, MetricKind::Gauge, Some("timestamp_seconds"), help);
        if let Some(ms) = archive.and_then(of) {
            text.sample(name, "", Seconds(ms.saturating_mul(1000)));
        }
    }
}

fn put_gateways(text: &mut Exposition, gateways: &[GatewayView]) {
    type Of = fn(&GatewayView) -> u64;
    let families: [(&str, MetricKind, &str, Of); 5] = [
        ("profivac_gateway_up", MetricKind::Gauge, "The gateway serves its clients", |it| u64::from(it.is_running)),
        ("profivac_gateway_clients", MetricKind::Gauge, "Connected clients", |it| it.clients),
        ("profivac_gateway_sent", MetricKind::Counter, "Values and answers sent", |it| it.sent),
        ("profivac_gateway_dropped_updates", MetricKind::Counter, "Updates that a newer value replaced", |it| {
            it.dropped_updates
        }),
        ("profivac_gateway_refused", MetricKind::Counter, "Refused requests and connections", |it| it.refused),
    ];
    for (name, kind, help, of) in families {
        text.family(name, kind, None, help);
        let sample = format!("{name}{}", kind.suffix());
        for gateway in gateways {
            text.sample(&sample, &with_label("", "gateway", &gateway.name), of(gateway));
        }
    }
    put_archive(text, gateways.iter().find_map(|gateway| gateway.archive.as_ref()));
    let name = "profivac_gateway_last_error_timestamp_seconds";
    text.family(name, MetricKind::Gauge, Some("timestamp_seconds"), "Time of the last error of the gateway");
    for gateway in gateways {
        if let Some(ms) = gateway.last_error_ms {
            text.sample(name, &with_label("", "gateway", &gateway.name), Seconds(ms.saturating_mul(1000)));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::is_number;

    #[test]
    fn a_number_has_digits_and_at_most_a_unit() {
        for number in ["12", "-1.5e-3 mbar", "12.5 Hz (uncertain)", "3 (uncertain)"] {
            assert!(is_number(number), "{number}");
        }
        for words in ["", "on", "inf", "nan", "2 of 3 open", "at speed"] {
            assert!(!is_number(words), "{words}");
        }
    }
}
