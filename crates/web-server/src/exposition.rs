//! Metrics as text: the format of OpenMetrics 1.0, and the older one of Prometheus.

use std::fmt::{Display, Write};

/// A format of the text.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Format {
    /// OpenMetrics 1.0.
    OpenMetrics,
    /// The text format of Prometheus, version 0.0.4.
    Prometheus,
}

impl Format {
    /// Its content type.
    #[must_use]
    pub const fn content_type(self) -> &'static str {
        match self {
            Self::OpenMetrics => "application/openmetrics-text; version=1.0.0; charset=utf-8",
            Self::Prometheus => "text/plain; version=0.0.4; charset=utf-8",
        }
    }

    /// The format for a client with this `Accept` header: the one with the greater weight, and OpenMetrics if both have the same. A client
    /// that names neither gets the older one, which is text for every program.
    #[must_use]
    pub fn accepted(accept: &str) -> Self {
        let [open, old] = [("application", "openmetrics-text", "1.0.0"), ("text", "plain", "0.0.4")]
            .map(|media| accept.split(',').filter_map(|range| weight(range, media)).max().unwrap_or_default());
        let is_named = open.specificity == Specificity::Named;
        if open.thousandths > old.thousandths
            || (is_named && open.thousandths > 0 && open.thousandths == old.thousandths)
        {
            Self::OpenMetrics
        } else {
            Self::Prometheus
        }
    }
}

/// How a range of media names one of them. A later one decides over an earlier one (RFC 9110, 12.5.1).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord)]
enum Specificity {
    /// `*/*`, or not at all.
    #[default]
    Any,
    /// `text/*`.
    Kind,
    /// `text/plain`.
    Named,
}

/// What a client gives a format.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord)]
struct Weight {
    specificity: Specificity,
    thousandths: u16,
}

/// What a range of an `Accept` header gives a format; `None` for a range of others, another version, or a text that is no range.
fn weight(range: &str, (kind, name, version): (&str, &str, &str)) -> Option<Weight> {
    let mut parts = range.split(';').map(str::trim);
    let (own_kind, own_name) = parts.next()?.split_once('/')?;
    let is = |own: &str, name: &str| own.eq_ignore_ascii_case(name);
    let specificity = match (own_kind, own_name) {
        ("*", "*") => Specificity::Any,
        (own, "*") if is(own, kind) => Specificity::Kind,
        (own_kind, own_name) if is(own_kind, kind) && is(own_name, name) => Specificity::Named,
        _ => return None,
    };
    let mut thousandths = 1000;
    for (key, value) in parts.filter_map(|part| part.split_once('=')) {
        if is(key, "q") {
            let weight: f32 = value.parse().ok().filter(|weight| (0.0..=1.0).contains(weight))?;
            thousandths = (weight * 1000.0) as u16;
        } else if is(key, "version") && value.trim_matches('"') != version {
            return None;
        }
    }
    Some(Weight { specificity, thousandths })
}

/// The type of a metric.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum MetricKind {
    /// A number that goes up and down.
    Gauge,
    /// A number that only grows.
    Counter,
    /// Labels; the value is 1.
    Info,
    /// Numbers of durations in buckets.
    Histogram,
}

impl MetricKind {
    /// The end of the names of its samples.
    #[must_use]
    pub const fn suffix(self) -> &'static str {
        match self {
            Self::Gauge | Self::Histogram => "",
            Self::Counter => "_total",
            Self::Info => "_info",
        }
    }

    /// Its name in OpenMetrics.
    #[must_use]
    pub const fn word(self) -> &'static str {
        match self {
            Self::Gauge => "gauge",
            Self::Counter => "counter",
            Self::Info => "info",
            Self::Histogram => "histogram",
        }
    }
}

/// A text under construction. Writing to a String cannot fail, so the results are ignored.
#[derive(Debug)]
pub struct Exposition {
    format: Format,
    text: String,
}

impl Exposition {
    /// An empty text; `capacity` is the number of octets that it will probably have.
    #[must_use]
    pub fn new(format: Format, capacity: usize) -> Self {
        Self { format, text: String::with_capacity(capacity) }
    }

    /// The lines before the samples of a family. `name` has its unit, and no suffix of its type.
    pub fn family(&mut self, name: &str, kind: MetricKind, unit: Option<&str>, help: &str) {
        let text = &mut self.text;
        let _written = match (self.format, kind) {
            (Format::OpenMetrics, _) => writeln!(text, "# TYPE {name} {}", kind.word()),
            (Format::Prometheus, MetricKind::Info) => writeln!(text, "# TYPE {name}_info gauge"),
            (Format::Prometheus, _) => writeln!(text, "# TYPE {name}{} {}", kind.suffix(), kind.word()),
        };
        if let (Format::OpenMetrics, Some(unit)) = (self.format, unit.and_then(|unit| unit.rsplit('_').next())) {
            let _written = writeln!(text, "# UNIT {name} {unit}");
        }
        let suffix = if self.format == Format::OpenMetrics { "" } else { kind.suffix() };
        let _written = writeln!(text, "# HELP {name}{suffix} {help}.");
    }

    /// A sample. `name` has the suffix of its type; `labels` were written with [`put_label`].
    pub fn sample(&mut self, name: &str, labels: &str, value: impl Display) {
        let _written = match labels {
            "" => writeln!(self.text, "{name} {value}"),
            labels => writeln!(self.text, "{name}{{{labels}}} {value}"),
        };
    }

    /// The whole text.
    #[must_use]
    pub fn finish(mut self) -> String {
        if self.format == Format::OpenMetrics {
            self.text.push_str("# EOF\n");
        }
        self.text
    }
}

/// A number as both formats write it, in the shortest form.
#[derive(Clone, Copy, Debug)]
pub struct Number(pub f64);

impl Display for Number {
    fn fmt(&self, formatter: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let number = self.0;
        let is_plain = number == 0.0 || (1e-4..1e16).contains(&number.abs());
        if is_plain { number.fmt(formatter) } else { write!(formatter, "{number:e}") }
    }
}

/// Writes a label; `text` holds the labels before it.
pub fn put_label(text: &mut String, name: &str, value: &str) {
    if !text.is_empty() {
        text.push(',');
    }
    text.push_str(name);
    text.push_str("=\"");
    for character in value.chars() {
        match character {
            '\\' => text.push_str("\\\\"),
            '"' => text.push_str("\\\""),
            '\n' => text.push_str("\\n"),
            other => text.push(other),
        }
    }
    text.push('"');
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_value_of_a_label_is_escaped() {
        let mut text = String::new();
        put_label(&mut text, "gauge", "a \"b\" \\ c\nd");
        put_label(&mut text, "channel", "1");
        assert_eq!(text, r#"gauge="a \"b\" \\ c\nd",channel="1""#);
    }

    #[test]
    fn the_two_formats_differ_in_the_names_of_types_and_in_the_end() {
        let text = |format| {
            let mut text = Exposition::new(format, 0);
            text.family("a_bytes", MetricKind::Counter, Some("bytes"), "Octets");
            text.sample("a_bytes_total", "", 1);
            text.family("b", MetricKind::Info, None, "Facts");
            text.sample("b_info", "x=\"1\"", 1);
            text.finish()
        };
        let open = "# TYPE a_bytes counter\n# UNIT a_bytes bytes\n# HELP a_bytes Octets.\na_bytes_total 1\n\
                    # TYPE b info\n# HELP b Facts.\nb_info{x=\"1\"} 1\n# EOF\n";
        let old = "# TYPE a_bytes_total counter\n# HELP a_bytes_total Octets.\na_bytes_total 1\n\
                   # TYPE b_info gauge\n# HELP b_info Facts.\nb_info{x=\"1\"} 1\n";
        assert_eq!((text(Format::OpenMetrics).as_str(), text(Format::Prometheus).as_str()), (open, old));
    }

    #[test]
    fn a_client_that_accepts_openmetrics_gets_it() {
        let prometheus = "application/openmetrics-text;version=1.0.0,text/plain;version=0.0.4;q=0.5,*/*;q=0.1";
        assert_eq!(Format::accepted(prometheus), Format::OpenMetrics);
        assert_eq!(Format::accepted("*/*"), Format::Prometheus);
        for (accept, format) in [
            ("", Format::Prometheus),
            ("application/openmetrics-text", Format::OpenMetrics),
            (
                "Application/OpenMetrics-Text; version=\"1.0.0\"; escaping=allow-utf-8; q=0.6, text/plain; q=0.3",
                Format::OpenMetrics,
            ),
            ("text/plain, application/openmetrics-text", Format::OpenMetrics),
            ("text/plain;q=0.9, application/openmetrics-text;q=0.2", Format::Prometheus),
            ("application/openmetrics-text;q=0", Format::Prometheus),
            ("application/openmetrics-text;q=0, */*", Format::Prometheus),
            ("application/openmetrics-text;version=0.0.1, text/plain;q=0.1", Format::Prometheus),
            ("application/openmetrics-text;q=much", Format::Prometheus),
            ("text/html, application/*;q=0.9", Format::OpenMetrics),
            ("text/*;q=0.9, application/*;q=0.9", Format::Prometheus),
            (";;,,=/q=", Format::Prometheus),
        ] {
            assert_eq!(Format::accepted(accept), format, "{accept}");
        }
    }

    #[test]
    fn a_number_is_the_same_after_it_was_read_again() {
        for number in [0.0, 1.0, 5.2e-7, 1234.5, -3.25, 1.7e18, 1e-320] {
            assert_eq!(Number(number).to_string().parse(), Ok(number));
        }
        assert_eq!(Number(5.2e-7).to_string(), "5.2e-7");
    }
}
