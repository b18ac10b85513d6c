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

    /// The format for a client with this `Accept` header.
    #[must_use]
    pub fn accepted(accept: &str) -> Self {
        if accept.contains("application/openmetrics-text") { Self::OpenMetrics } else { Self::Prometheus }
    }
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
    }

    #[test]
    fn a_number_is_the_same_after_it_was_read_again() {
        for number in [0.0, 1.0, 5.2e-7, 1234.5, -3.25, 1.7e18, 1e-320] {
            assert_eq!(Number(number).to_string().parse(), Ok(number));
        }
        assert_eq!(Number(5.2e-7).to_string(), "5.2e-7");
    }
}
